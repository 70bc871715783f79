//! The diffuse field on a grid of shells and local sun positions, as moments of spherical harmonics.
//!
//! One such field serves every observer and every sun: on a sphere under parallel light the field
//! depends on altitude and on the local sun zenith angle alone.

use super::lanes::{Lanes, WIDTH, add_scaled, lane, lerp};
use super::medium::LevelFinder;
use sky_core::quantity::Angle;

/// Real spherical harmonics, even in azimuth, orthonormal over the sphere, up to a degree.
///
/// Stored by order, then degree: the functions of one order share their azimuth.
#[derive(Clone, Debug)]
pub(super) struct Harmonics {
    pub(super) degree: usize,
    norms: Vec<f64>,
    /// Factors of the recurrence in degree, at the place of the function that they lead on from.
    rise: Vec<[f64; 2]>,
}

impl Harmonics {
    pub(super) fn new(degree: usize) -> Self {
        let (mut norms, mut rise) = (Vec::new(), Vec::new());
        for m in 0..=degree {
            for l in m..=degree {
                rise.push([2 * l + 1, l + m].map(|n| as_f64(n) / as_f64(l + 1 - m)));
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
            let functions = first..=first + self.degree - m;
            let factors = self.norms[functions.clone()]
                .iter()
                .zip(&self.rise[functions.clone()]);
            for (out, (norm, [a, b])) in out[functions].iter_mut().zip(factors) {
                *out = lane(last * norm);
                (before, last) = (last, a * cosine * last - b * before);
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

    /// Logarithm of the field's size between a column and the next, as a polynomial of the fraction
    /// of the way; `log_scale` has an entry for each column.
    pub(super) fn log_scale_between(&self, column: usize, log_scale: &[f64]) -> [f64; 4] {
        let Cubic { first, factors } = &self.cubics[column];
        factors.map(|f| (0..4).map(|k| f[k] * log_scale[first + k]).sum())
    }
}

/// Harmonics beyond this degree are not used.
pub(super) const HIGHEST_DEGREE: usize = 12;

/// Beyond this local sun zenith angle single scattering ends within the grid's columns.
const LAST_SMOOTH_COLUMN_DEG: f64 = 95.0;

/// Least size of a field: light fainter than this is not told apart from darkness.
const DARK: f64 = 1e-25;

/// Lengths of a field's tables.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Shape {
    pub(super) columns: usize,
    /// Spherical harmonics.
    pub(super) count: usize,
    pub(super) vectors: usize,
}

/// Light at each node of the grid as moments of spherical harmonics, already weighted by the phase
/// function: the source of a direction, per unit scattering coefficient, is the sum of moments times
/// harmonics.
#[derive(Clone, Debug, Default)]
pub(super) struct Field {
    pub(super) shape: Shape,
    /// `[((shell * vectors + vector) * count + harmonic) * columns + column]`
    pub(super) moments: Vec<Lanes>,
    /// Spectral irradiance on the ground, `[vector * columns + column]`.
    pub(super) ground_irradiance: Vec<Lanes>,
}

impl Field {
    /// Adds an order of scattering, or a multiple of it, `[vector * columns + column]`.
    pub(super) fn add(&mut self, order: &Self, factor: Option<&[Lanes]>) {
        let Shape {
            columns,
            count,
            vectors,
        } = self.shape;
        let ones = vec![[1.0; WIDTH]; columns];
        let factors = |vector: usize| {
            factor.map_or(ones.as_slice(), |f| {
                &f[vector * columns..(vector + 1) * columns]
            })
        };
        let add = |sum: &mut [Lanes], order: &[Lanes], factors: &[Lanes]| {
            for ((a, b), w) in sum.iter_mut().zip(order).zip(factors) {
                for l in 0..WIDTH {
                    a[l] += w[l] * b[l];
                }
            }
        };
        let rows = self.moments.chunks_exact_mut(columns);
        for (i, (a, b)) in rows.zip(order.moments.chunks_exact(columns)).enumerate() {
            add(a, b, factors(i / count % vectors));
        }
        let rows = self.ground_irradiance.chunks_exact_mut(columns);
        let order = order.ground_irradiance.chunks_exact(columns);
        for (vector, (a, b)) in rows.zip(order).enumerate() {
            add(a, b, factors(vector));
        }
    }

    /// Zeroth moments at each shell, `[vector * columns + column]`.
    fn zeroth(&self) -> impl Iterator<Item = impl Iterator<Item = &Lanes>> {
        let Shape {
            columns,
            count,
            vectors,
        } = self.shape;
        self.moments
            .chunks_exact(columns * count * vectors)
            .map(move |shell| {
                shell
                    .chunks_exact(columns * count)
                    .flat_map(move |vector| &vector[..columns])
            })
    }

    /// Zeroth moments summed over the shells, `[vector * columns + column]`.
    pub(super) fn column_sums(&self) -> Vec<Lanes> {
        let mut sums = vec![[0.0; WIDTH]; self.shape.vectors * self.shape.columns];
        for shell in self.zeroth() {
            for (sum, moment) in sums.iter_mut().zip(shell) {
                add_scaled(sum, 1.0, moment);
            }
        }
        sums
    }
}

/// A field made ready to be read between the nodes of its grid: divided by its size at each node,
/// which is the sum over wavelength of the zeroth moment. The divided field is interpolated linearly,
/// the size by its logarithm.
#[derive(Clone, Debug, Default)]
pub(super) struct Source {
    /// The field, divided by its size.
    pub(super) field: Field,
    /// Logarithm of the size, `[shell * columns + column]`.
    pub(super) log_scale: Vec<f64>,
}

impl Source {
    pub(super) fn new(field: Field) -> Self {
        let columns = field.shape.columns;
        let sizes = field.zeroth().map(|shell| sizes(shell, columns)).collect();
        Self::of_sizes(field, sizes)
    }

    /// The light of the ground alone: of a field without moments, sized by the ground's irradiance.
    pub(super) fn of_ground(field: Field) -> Self {
        let columns = field.shape.columns;
        let shells = field.zeroth().count();
        let sizes = vec![sizes(field.ground_irradiance.iter(), columns); shells];
        Self::of_sizes(field, sizes)
    }

    /// The irradiance of the ground where it has the sun at an angle, at the solved wavelengths.
    pub(super) fn ground_irradiance(&self, grid: &Grid, sun_cosine: f64) -> Vec<Lanes> {
        let columns = self.field.shape.columns;
        let place = grid
            .columns
            .find(Angle::from_radians(sun_cosine.acos()).degrees());
        let [a, b, c, d] = grid.log_scale_between(place.level, &self.log_scale[..columns]);
        let t = place.fraction;
        let scale = lane((a + t * (b + t * (c + t * d))).exp());
        self.field
            .ground_irradiance
            .chunks_exact(columns)
            .map(|row| {
                lerp(&row[place.level], &row[place.level + 1], lane(t))
                    .map(|x| (x * scale).max(0.0))
            })
            .collect()
    }

    /// Divides a field by its sizes, `[shell][column]`.
    fn of_sizes(mut field: Field, sizes: Vec<Vec<f64>>) -> Self {
        let columns = field.shape.columns;
        let mut log_scale = Vec::new();
        let mut inverse = Vec::new();
        for sizes in sizes {
            let sizes = sizes.into_iter().map(|s| s.max(DARK));
            inverse.push(sizes.clone().map(|s| lane(1.0 / s)).collect::<Vec<_>>());
            log_scale.extend(sizes.map(f64::ln));
        }
        let divide = |rows: &mut [Lanes], inverse: &[f32]| {
            for row in rows.chunks_exact_mut(columns) {
                for (lanes, inverse) in row.iter_mut().zip(inverse) {
                    *lanes = lanes.map(|x| x * inverse);
                }
            }
        };
        let per_shell = columns * field.shape.count * field.shape.vectors;
        for (shell, inverse) in field.moments.chunks_exact_mut(per_shell).zip(&inverse) {
            divide(shell, inverse);
        }
        divide(&mut field.ground_irradiance, &inverse[0]);
        Self { field, log_scale }
    }
}

/// Sums over wavelength, by column, of lanes `[vector * columns + column]`.
fn sizes<'a>(lanes: impl Iterator<Item = &'a Lanes>, columns: usize) -> Vec<f64> {
    let mut sizes = vec![0.0; columns];
    for (i, lanes) in lanes.enumerate() {
        sizes[i % columns] += lanes.iter().map(|x| f64::from(*x)).sum::<f64>();
    }
    sizes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_between_columns_follow_a_cubic() {
        let columns = [0.0, 20.0, 30.0, 55.0, 70.0, 94.0];
        let grid = Grid::new(&[0.0, 1.0], &columns, vec![2, 2]);
        let curve = |x: f64| 1.0 - 0.3 * x + 2e-3 * x * x - 1e-5 * x * x * x;
        let sizes: Vec<f64> = columns.iter().map(|x| curve(*x)).collect();
        for column in 1..4 {
            let [a, b, c, d] = grid.log_scale_between(column, &sizes);
            for t in [0.0, 0.25, 0.5, 1.0] {
                let x = columns[column] + t * (columns[column + 1] - columns[column]);
                let found = a + t * (b + t * (c + t * d));
                assert!((found - curve(x)).abs() < 1e-12, "{column} {t}");
            }
        }
        // straight at the ends
        let [a, b, c, d] = grid.log_scale_between(0, &sizes);
        assert!((a - sizes[0]).abs() < 1e-15 && (a + b - sizes[1]).abs() < 1e-12);
        assert!([c, d].iter().all(|x| x.abs() < 1e-15));
    }

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
