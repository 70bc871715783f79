//! The diffuse field on a grid of shells and local sun positions, as moments of spherical harmonics.
//!
//! One such field serves every observer and every sun: on a sphere under parallel light the field
//! depends on altitude and on the local sun zenith angle alone.

use super::lanes::{Lanes, WIDTH};
use super::medium::{Between, LevelFinder};
use sky_core::axis::{four_from, lagrange_weights};
use sky_core::quantity::Angle;

/// Real spherical harmonics, even in azimuth, orthonormal over the sphere, up to a degree.
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
        for l in 0..=degree {
            for m in 0..=l {
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

    /// Degree of each function, in storage order.
    pub(super) fn degrees(&self) -> impl Iterator<Item = usize> {
        (0..=self.degree).flat_map(|l| core::iter::repeat_n(l, l + 1))
    }

    /// All functions in a direction; `out` has `count()` entries, ordered by degree then order.
    pub(super) fn evaluate(&self, cosine: f64, cos_azimuth: f64, out: &mut [f64]) {
        let sine = ((1.0 - cosine) * (1.0 + cosine)).max(0.0).sqrt();
        let index = |l: usize, m: usize| l * (l + 1) / 2 + m;
        out[0] = 1.0;
        for m in 1..=self.degree {
            out[index(m, m)] = out[index(m - 1, m - 1)] * sine * (2.0 * as_f64(m) - 1.0);
        }
        for m in 0..self.degree {
            out[index(m + 1, m)] = cosine * (2.0 * as_f64(m) + 1.0) * out[index(m, m)];
        }
        for m in 0..=self.degree {
            for l in (m + 2)..=self.degree {
                let [a, b] = self.rise[index(l, m)];
                out[index(l, m)] = a * cosine * out[index(l - 1, m)] - b * out[index(l - 2, m)];
            }
        }
        let (mut previous, mut cos_m) = (cos_azimuth, 1.0); // cos(-φ), cos(0)
        for m in 0..=self.degree {
            for l in m..=self.degree {
                out[index(l, m)] *= cos_m * self.norms[index(l, m)];
            }
            let next = 2.0 * cos_azimuth * cos_m - previous;
            previous = cos_m;
            cos_m = next;
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
    pub(super) columns: LevelFinder,
    /// Harmonics used at each shell: where the air is clean, the first few.
    pub(super) counts: Vec<usize>,
}

/// Four corners of the grid and their weights.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Corners {
    pub(super) node: [usize; 4],
    pub(super) weight: [f64; 4],
    /// Harmonics that the shells at hand use.
    pub(super) count: usize,
}

impl Grid {
    pub(super) fn nodes(&self) -> usize {
        self.shells.levels().len() * self.columns.levels().len()
    }

    pub(super) fn node(&self, shell: usize, column: usize) -> usize {
        column * self.shells.levels().len() + shell
    }

    /// Corners around a place. What is interpolated linearly is the field divided by its size, the
    /// size itself by its logarithm.
    pub(super) fn corners(&self, shell: Between, sun_cosine: f64, field: &Field) -> Corners {
        let sun_zenith_deg = Angle::from_radians(sun_cosine.acos()).degrees();
        let column = self.columns.find(sun_zenith_deg);
        let mut corners = Corners {
            count: self.counts[shell.level].max(self.counts[shell.level + 1]),
            ..Corners::default()
        };
        let sun_weights = self.cubic_weights(column, sun_zenith_deg);
        let mut mean = 0.0;
        for up in 0..2 {
            let share = if up == 0 {
                1.0 - shell.fraction
            } else {
                shell.fraction
            };
            for on in 0..2 {
                let w = share
                    * if on == 0 {
                        1.0 - column.fraction
                    } else {
                        column.fraction
                    };
                let node = self.node(shell.level + up, column.level + on);
                corners.node[2 * on + up] = node;
                corners.weight[2 * on + up] = w * field.inverse_scale[node];
            }
            for (k, w) in sun_weights.1.iter().enumerate() {
                mean += share * w * field.log_scale[self.node(shell.level + up, sun_weights.0 + k)];
            }
        }
        let scale = mean.exp();
        corners.weight = corners.weight.map(|w| w * scale);
        corners
    }

    /// First column and weights of a cubic through four columns around a sun; a straight line at the
    /// ends of the grid and where the field falls off into the dark.
    fn cubic_weights(&self, column: Between, sun_zenith_deg: f64) -> (usize, [f64; 4]) {
        let x = self.columns.levels();
        let first = column.level.saturating_sub(1).min(x.len() - 4);
        if column.level == 0
            || column.level + 2 >= x.len()
            || sun_zenith_deg > LAST_SMOOTH_COLUMN_DEG
        {
            let mut w = [0.0; 4];
            w[column.level - first] = 1.0 - column.fraction;
            w[column.level + 1 - first] = column.fraction;
            return (first, w);
        }
        (
            first,
            lagrange_weights(&four_from(x, first), sun_zenith_deg),
        )
    }
}

/// Beyond this local sun zenith angle single scattering ends within the grid's columns.
const LAST_SMOOTH_COLUMN_DEG: f64 = 95.0;

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

    /// Sets the size of the field at each node: the sum over wavelength of the zeroth moment.
    pub(super) fn measure(&mut self, vectors: usize, count: usize) {
        let sizes = self
            .moments
            .chunks_exact(vectors * count)
            .map(|node| node.iter().step_by(count).flatten().sum::<f64>().max(1e-30));
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
        let mut y = vec![0.0; n];
        // midpoint in azimuth, Gauss-Legendre by brute force in cosine
        let (steps, azimuths) = (4000_u32, 24_u32);
        for i in 0..steps {
            let mu = -1.0 + 2.0 * (f64::from(i) + 0.5) / f64::from(steps);
            for k in 0..azimuths {
                let phi = core::f64::consts::TAU * (f64::from(k) + 0.5) / f64::from(azimuths);
                h.evaluate(mu, phi.cos(), &mut y);
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
