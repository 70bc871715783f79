//! The diffuse field on a grid of shells and local sun positions, as moments of spherical harmonics.
//!
//! One such field serves every observer and every sun: on a sphere under parallel light the field
//! depends on altitude and on the local sun zenith angle alone.

use super::lanes::{Lanes, WIDTH, lane};
use super::medium::LevelFinder;

/// Real spherical harmonics, even in azimuth, orthonormal over the sphere, up to a degree.
///
/// Stored by order, then degree: the functions of one order share their azimuth.
#[derive(Clone, Debug)]
pub(super) struct Harmonics {
    pub(super) degree: usize,
    norms: Vec<f64>,
    /// Factors of the recurrence in degree, at the place of the function that they lead to.
    rise: Vec<[f64; 2]>,
}

impl Harmonics {
    pub(super) fn new(degree: usize) -> Self {
        let (mut norms, mut rise) = (Vec::new(), Vec::new());
        for m in 0..=degree {
            for l in m..=degree {
                rise.push(if l >= m + 2 {
                    [(2 * l - 1), (l + m - 1)].map(|n| as_f64(n) / as_f64(l - m))
                } else {
                    [0.0; 2]
                });
                // (2l+1)/(4π) (l-m)!/(l+m)!, twice that for m > 0
                let mut ratio = 1.0;
                for i in (l - m + 1)..=(l + m) {
                    ratio /= as_f64(i);
                }
                let two = if m == 0 { 1.0 } else { 2.0 };
                let n = two * (2.0 * as_f64(l) + 1.0) / (4.0 * core::f64::consts::PI) * ratio;
                norms.push(n.sqrt());
            }
        }
        Self {
            degree,
            norms,
            rise,
        }
    }

    /// Number of functions.
    pub(super) fn count(&self) -> usize {
        self.norms.len()
    }

    /// Place of the first function of an order, that of degree `m`.
    pub(super) fn first(&self, m: usize) -> usize {
        m * (2 * self.degree + 3 - m) / 2
    }

    /// Order and degree of each function, in storage order.
    pub(super) fn orders_and_degrees(&self) -> impl Iterator<Item = (usize, usize)> {
        let degree = self.degree;
        (0..=degree).flat_map(move |m| (m..=degree).map(move |l| (m, l)))
    }

    /// All functions without their azimuth, which is `cos mφ`; `out` has `count()` entries.
    pub(super) fn evaluate(&self, cosine: f64, out: &mut [f32]) {
        let sine = ((1.0 - cosine) * (1.0 + cosine)).max(0.0).sqrt();
        let mut diagonal = 1.0;
        for m in 0..=self.degree {
            let first = self.first(m);
            let (mut before, mut last) = (0.0, diagonal);
            for i in first..=first + self.degree - m {
                if i == first + 1 {
                    (before, last) = (last, cosine * (2.0 * as_f64(m) + 1.0) * last);
                } else if i > first {
                    let [a, b] = self.rise[i];
                    (before, last) = (last, a * cosine * last - b * before);
                }
                out[i] = lane(last * self.norms[i]);
            }
            diagonal *= sine * (2.0 * as_f64(m) + 1.0);
        }
    }
}

/// A small count as a float.
pub(super) fn as_f64(n: usize) -> f64 {
    f64::from(u32::try_from(n).unwrap_or(u32::MAX))
}

/// The grid of shells and local sun zenith angles.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    pub(super) shells: LevelFinder,
    /// Local sun zenith angles \[deg\].
    pub(super) columns: LevelFinder,
    /// Highest degree of harmonics used at each shell: where the air is clean, the first few.
    pub(super) degrees: Vec<usize>,
    /// Between each column and the next: how the field's size follows from that of four columns.
    cubics: Vec<Cubic>,
}

/// Interpolation among four neighboring columns, as a polynomial of the way from one to the next.
#[derive(Clone, Copy, Debug)]
struct Cubic {
    /// First of the four columns.
    first: usize,
    /// Factor of each power of the fraction and each column.
    factors: [[f64; 4]; 4],
}

impl Cubic {
    /// A cubic; a straight line at the ends of the grid and where the field falls off into the dark.
    fn new(columns_deg: &[f64], column: usize) -> Self {
        let first = column.saturating_sub(1).min(columns_deg.len() - 4);
        let mut factors = [[0.0; 4]; 4];
        let (from, to) = (columns_deg[column], columns_deg[column + 1]);
        if column == 0 || column + 2 >= columns_deg.len() || to > LAST_SMOOTH_COLUMN_DEG {
            factors[0][column - first] = 1.0;
            factors[1][column - first] = -1.0;
            factors[1][column + 1 - first] = 1.0;
        } else {
            let place: [f64; 4] =
                core::array::from_fn(|k| (columns_deg[first + k] - from) / (to - from));
            for k in 0..4 {
                // the product of (t - t_j)/(t_k - t_j), multiplied out
                let mut product = [1.0, 0.0, 0.0, 0.0];
                for j in (0..4).filter(|j| *j != k) {
                    let slope = 1.0 / (place[k] - place[j]);
                    for power in (0..4).rev() {
                        let lower = if power > 0 { product[power - 1] } else { 0.0 };
                        product[power] = slope * (lower - place[j] * product[power]);
                    }
                }
                for power in 0..4 {
                    factors[power][k] = product[power];
                }
            }
        }
        Self { first, factors }
    }
}

impl Grid {
    pub(super) fn new(shells_km: &[f64], columns_deg: &[f64], degrees: Vec<usize>) -> Self {
        Self {
            shells: LevelFinder::new(shells_km),
            columns: LevelFinder::new(columns_deg),
            degrees,
            cubics: (0..columns_deg.len() - 1)
                .map(|column| Cubic::new(columns_deg, column))
                .collect(),
        }
    }

    pub(super) fn nodes(&self) -> usize {
        self.shells.levels().len() * self.columns.levels().len()
    }

    pub(super) fn node(&self, shell: usize, column: usize) -> usize {
        column * self.shells.levels().len() + shell
    }

    /// Logarithm of the field's size between a column and the next, as a polynomial of the fraction
    /// of the way; `log_scale` has an entry for each column.
    pub(super) fn log_scale_between(&self, column: usize, log_scale: &[f64]) -> [f64; 4] {
        let Cubic { first, factors } = &self.cubics[column];
        factors.map(|f| (0..4).map(|k| f[k] * log_scale[first + k]).sum())
    }
}

/// Beyond this local sun zenith angle single scattering ends within the grid's columns.
const LAST_SMOOTH_COLUMN_DEG: f64 = 95.0;

/// Least size of a field: light fainter than this is not told apart from darkness.
const DARK: f64 = 1e-25;

/// Moments of the field at each node of the grid, already weighted by the phase function: the source
/// of a direction, per unit scattering coefficient, is the sum of moments times harmonics.
#[derive(Clone, Debug, Default)]
pub(super) struct Field {
    /// `[(node * vectors + vector) * count + harmonic]`
    pub(super) moments: Vec<Lanes>,
    /// Logarithm of the field's size at each node.
    pub(super) log_scale: Vec<f64>,
    /// One over the field's size at each node.
    pub(super) inverse_scale: Vec<f64>,
    /// Spectral irradiance on the ground, `[column * vectors + vector]`.
    pub(super) ground_irradiance: Vec<Lanes>,
}

impl Field {
    /// Adds an order of scattering, or a multiple of it, `[column * vectors + vector]`.
    pub(super) fn add(
        &mut self,
        order: &Self,
        factor: Option<&[Lanes]>,
        vectors: usize,
        count: usize,
    ) {
        let shells = self.log_scale.len() * vectors / self.ground_irradiance.len();
        let one = [1.0; WIDTH];
        let factor =
            |column: usize, vector: usize| factor.map_or(&one, |f| &f[column * vectors + vector]);
        let add = |a: &mut Lanes, b: &Lanes, w: &Lanes| {
            for l in 0..WIDTH {
                a[l] += w[l] * b[l];
            }
        };
        for (i, (a, b)) in self.moments.iter_mut().zip(&order.moments).enumerate() {
            let (node, vector) = (i / count / vectors, i / count % vectors);
            add(a, b, factor(node / shells, vector));
        }
        for (i, (a, b)) in self
            .ground_irradiance
            .iter_mut()
            .zip(&order.ground_irradiance)
            .enumerate()
        {
            add(a, b, factor(i / vectors, i % vectors));
        }
    }

    /// Sets the size of the field at each node: the sum over wavelength of the zeroth moment, in lanes'
    /// range with its inverse.
    pub(super) fn measure(&mut self, vectors: usize, count: usize) {
        let sizes = self
            .moments
            .chunks_exact(vectors * count)
            .map(|node| {
                let zeroth = node.iter().step_by(count).flatten();
                zeroth.map(|x| f64::from(*x)).sum::<f64>().max(DARK)
            });
        self.inverse_scale = sizes.clone().map(|s| 1.0 / s).collect();
        self.log_scale = sizes.map(f64::ln).collect();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn harmonics_are_orthonormal() {
        let h = Harmonics::new(5);
        let n = h.count();
        let mut gram = vec![0.0; n * n];
        let (mut y, mut functions) = (vec![0.0; n], vec![0.0; n]);
        // midpoint in azimuth, Gauss-Legendre by brute force in cosine
        let (steps, azimuths) = (4000_u32, 24_u32);
        for i in 0..steps {
            let mu = -1.0 + 2.0 * (f64::from(i) + 0.5) / f64::from(steps);
            for k in 0..azimuths {
                let phi = core::f64::consts::TAU * (f64::from(k) + 0.5) / f64::from(azimuths);
                h.evaluate(mu, &mut functions);
                for (((m, _), f), y) in h.orders_and_degrees().zip(&functions).zip(&mut y) {
                    *y = f64::from(*f) * (as_f64(m) * phi).cos();
                }
                let w = 2.0 / f64::from(steps) * core::f64::consts::TAU / f64::from(azimuths);
                for a in 0..n {
                    for b in 0..n {
                        gram[a * n + b] += w * y[a] * y[b];
                    }
                }
            }
        }
        for a in 0..n {
            for b in 0..n {
                let expected = if a == b { 1.0 } else { 0.0 };
                assert!((gram[a * n + b] - expected).abs() < 1e-5, "{a} {b}");
            }
        }
    }
}
