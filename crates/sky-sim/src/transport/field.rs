//! The diffuse field on a grid of shells and local sun positions, as moments of spherical harmonics.
//!
//! One such field serves every observer and every sun: on a sphere under parallel light the field
//! depends on altitude and on the local sun zenith angle alone.

use super::lanes::{Lanes, WIDTH};
use super::medium::{Between, LevelFinder};
use sky_core::quantity::Angle;

/// Real spherical harmonics, even in azimuth, orthonormal over the sphere, up to a degree.
#[derive(Clone, Debug)]
pub(super) struct Harmonics {
    pub(super) degree: usize,
    norms: Vec<f64>,
}

impl Harmonics {
    pub(super) fn new(degree: usize) -> Self {
        let mut norms = Vec::new();
        for l in 0..=degree {
            for m in 0..=l {
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
        Self { degree, norms }
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
                out[index(l, m)] = ((2.0 * as_f64(l) - 1.0) * cosine * out[index(l - 1, m)]
                    - as_f64(l + m - 1) * out[index(l - 2, m)])
                    / as_f64(l - m);
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
}

/// Four corners of the grid and their weights.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Corners {
    pub(super) node: [usize; 4],
    pub(super) weight: [f64; 4],
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
        let mut corners = Corners::default();
        let mut mean = 0.0;
        for k in 0..4 {
            let (up, on) = (k & 1, k >> 1);
            let w = if up == 0 { 1.0 - shell.fraction } else { shell.fraction }
                * if on == 0 { 1.0 - column.fraction } else { column.fraction };
            let node = self.node(shell.level + up, column.level + on);
            corners.node[k] = node;
            corners.weight[k] = w * field.inverse_scale[node];
            mean += w * field.log_scale[node];
        }
        let scale = mean.exp();
        corners.weight = corners.weight.map(|w| w * scale);
        corners
    }
}

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
    /// Adds an order of scattering, or a multiple of it for each wavelength.
    pub(super) fn add(&mut self, order: &Self, factor: Option<&[Lanes]>, vectors: usize, count: usize) {
        let one = [1.0; WIDTH];
        let add = |to: &mut [Lanes], from: &[Lanes], stride: usize| {
            for (k, (a, b)) in to.iter_mut().zip(from).enumerate() {
                let w = factor.map_or(&one, |f| &f[(k / stride) % vectors]);
                for l in 0..WIDTH {
                    a[l] += w[l] * b[l];
                }
            }
        };
        add(&mut self.moments, &order.moments, count);
        add(&mut self.ground_irradiance, &order.ground_irradiance, 1);
    }

    /// Sets the size of the field at each node: the sum over wavelength of the zeroth moment.
    pub(super) fn measure(&mut self, vectors: usize, count: usize) {
        let sizes = self.moments.chunks_exact(vectors * count).map(|node| {
            node.iter().step_by(count).flatten().sum::<f64>().max(1e-30)
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
