//! From the wavelengths that the diffuse light is solved for to all wavelengths of a profile.
//!
//! Diffuse light is smooth in wavelength but for absorption, which is known. So only some wavelengths
//! are solved; in between, the logarithm of the light, freed of the absorption that it shows, is
//! interpolated by a cubic. A profile whose optics are not smooth, or that has few wavelengths, is
//! solved at each.

use super::lanes::{Lanes, WIDTH};
use crate::optics::OpticalProfile;
use sky_science::lagrange::{four_from, lagrange_weights};

/// Widest gap between solved wavelengths \[nm\].
const WIDEST_GAP_NM: f64 = 30.0;
/// Largest relative error of the interpolated vertical scattering depth.
const SCATTERING_TOLERANCE: f64 = 1e-2;
/// Largest error of the interpolated vertical absorption depth.
const ABSORPTION_TOLERANCE: f64 = 1e-2;

/// Which wavelengths are solved, and how the others follow.
#[derive(Clone, Debug)]
pub(super) struct Spread {
    /// Indices of the solved wavelengths.
    solved: Vec<usize>,
    /// For each wavelength of the profile: first of four solved ones, and their weights.
    cubic: Vec<(usize, [f64; 4])>,
    /// Weights of the bend at each solved wavelength but the outer two on either side.
    bends: Vec<[f64; 5]>,
    /// Vertical absorption optical depth at each wavelength.
    absorption: Vec<f64>,
}

/// Cubic Lagrange weights among the four nodes around a place.
fn cubic(nodes: &[f64], x: f64) -> (usize, [f64; 4]) {
    let above = nodes.partition_point(|n| *n <= x);
    let first = above.saturating_sub(2).min(nodes.len() - 4);
    (first, lagrange_weights(&four_from(nodes, first), x))
}

/// Weights of five neighboring nodes: how far the middle one lies from the cubic of the others.
fn bend(nodes: &[f64], middle: usize) -> [f64; 5] {
    let [a, b, d, e] = [middle - 2, middle - 1, middle + 1, middle + 2].map(|i| nodes[i]);
    let [a, b, d, e] = lagrange_weights(&[a, b, d, e], nodes[middle]);
    [-a, -b, 1.0, -d, -e]
}

fn weighted(values: &[f64], (first, weights): &(usize, [f64; 4])) -> f64 {
    weights
        .iter()
        .zip(&values[*first..])
        .map(|(w, v)| w * v)
        .sum()
}

impl Spread {
    pub(super) fn new(optics: &OpticalProfile) -> Self {
        let nm = &optics.wavelength_nm;
        let n = nm.len();
        let column = |tables: [&[f64]; 2], w: usize| -> f64 {
            (1..optics.altitude_km.len())
                .map(|k| {
                    let dz = optics.altitude_km[k] - optics.altitude_km[k - 1];
                    let pair = |t: &[f64]| t[(k - 1) * n + w] + t[k * n + w];
                    0.5 * dz * tables.into_iter().map(pair).sum::<f64>()
                })
                .sum()
        };
        let columns = |tables: [&[f64]; 2]| (0..n).map(|w| column(tables, w)).collect::<Vec<_>>();
        let scattering = columns([
            &optics.rayleigh_scattering_per_km,
            &optics.aerosol_scattering_per_km,
        ]);
        let absorption = columns([
            &optics.gas_absorption_per_km,
            &optics.aerosol_absorption_per_km,
        ]);
        let mut spread = Self {
            solved: (0..n).collect(),
            cubic: Vec::new(),
            bends: Vec::new(),
            absorption,
        };
        // evenly spread, in full vectors, as few as do
        for count in (WIDTH..n).step_by(WIDTH) {
            let solved: Vec<usize> = (0..count)
                .map(|i| (2 * i * (n - 1) + count - 1) / (2 * (count - 1)))
                .collect();
            let nodes: Vec<f64> = solved.iter().map(|i| nm[*i]).collect();
            let cubic: Vec<_> = nm.iter().map(|x| cubic(&nodes, *x)).collect();
            let at = |values: &[f64]| solved.iter().map(|i| values[*i]).collect::<Vec<_>>();
            let (scattered, absorbed) = (at(&scattering), at(&spread.absorption));
            let good = nodes.windows(2).all(|w| w[1] - w[0] <= WIDEST_GAP_NM)
                && (0..n).all(|w| {
                    let scattering_miss = weighted(&scattered, &cubic[w]) - scattering[w];
                    let absorption_miss = weighted(&absorbed, &cubic[w]) - spread.absorption[w];
                    scattering_miss.abs() <= SCATTERING_TOLERANCE * scattering[w]
                        && absorption_miss.abs() <= ABSORPTION_TOLERANCE
                });
            if good {
                spread.bends = (2..count - 2).map(|i| bend(&nodes, i)).collect();
                spread.cubic = cubic;
                spread.solved = solved;
                break;
            }
        }
        spread
    }

    /// The profile at the solved wavelengths, and their indices; `None` if these are all.
    pub(super) fn coarse(&self, optics: &OpticalProfile) -> Option<(OpticalProfile, &[usize])> {
        if self.cubic.is_empty() {
            return None;
        }
        let n = optics.wavelength_nm.len();
        let pick = |table: &[f64]| -> Vec<f64> {
            table
                .chunks_exact(n)
                .flat_map(|row| self.solved.iter().map(|i| row[*i]))
                .collect()
        };
        let coarse = OpticalProfile {
            altitude_km: optics.altitude_km.clone(),
            wavelength_nm: self
                .solved
                .iter()
                .map(|i| optics.wavelength_nm[*i])
                .collect(),
            rayleigh_scattering_per_km: pick(&optics.rayleigh_scattering_per_km),
            gas_absorption_per_km: pick(&optics.gas_absorption_per_km),
            aerosol_scattering_per_km: pick(&optics.aerosol_scattering_per_km),
            aerosol_absorption_per_km: pick(&optics.aerosol_absorption_per_km),
            aerosol_g: pick(&optics.aerosol_g),
            aerosol_g2: pick(&optics.aerosol_g2),
            aerosol_g_weight: pick(&optics.aerosol_g_weight),
            rayleigh_depolarization: optics.rayleigh_depolarization,
        };
        Some((coarse, &self.solved))
    }

    /// Adds diffuse radiance at the solved wavelengths to a spectrum at all.
    pub(super) fn add(&self, diffuse: &[Lanes], spectrum: &mut [f64]) {
        let light = |i: usize| f64::from(diffuse[i / WIDTH][i % WIDTH]);
        let count = self.solved.len();
        if self.cubic.is_empty() {
            for (i, out) in spectrum.iter_mut().enumerate() {
                *out += light(i);
            }
            return;
        }
        if (0..count).any(|i| light(i) <= 0.0) {
            // dark somewhere: no logarithm
            let values: Vec<f64> = (0..count).map(light).collect();
            for (out, cubic) in spectrum.iter_mut().zip(&self.cubic) {
                *out += weighted(&values, cubic).max(0.0);
            }
            return;
        }
        let mut logarithm: Vec<f64> = (0..count).map(|i| light(i).ln()).collect();
        let depth: Vec<f64> = self.solved.iter().map(|i| self.absorption[*i]).collect();
        // the absorber paths that the light shows: where absorption bends, so does the light
        let (mut both, mut square) = (0.0, 1e-12);
        for (i, weights) in self.bends.iter().enumerate() {
            let bend = |v: &[f64]| -> f64 { weights.iter().zip(&v[i..]).map(|(w, x)| w * x).sum() };
            let (l, d) = (bend(&logarithm), bend(&depth));
            both += l * d;
            square += d * d;
        }
        let paths = (-both / square).clamp(0.0, 60.0);
        for (l, d) in logarithm.iter_mut().zip(&depth) {
            *l += paths * d;
        }
        for ((out, cubic), depth) in spectrum.iter_mut().zip(&self.cubic).zip(&self.absorption) {
            *out += (weighted(&logarithm, cubic) - paths * depth).exp();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spectrum_with_an_absorption_band_is_recovered() {
        let nm: Vec<f64> = (0..41_u32).map(|i| 380.0 + 10.0 * f64::from(i)).collect();
        let band =
            |x: f64| 0.04 * (-((x - 600.0) / 40.0).powi(2)).exp() * (1.0 + 0.1 * (x / 8.0).sin());
        let n = nm.len();
        let two =
            |f: &dyn Fn(f64) -> f64| -> Vec<f64> { nm.iter().chain(&nm).map(|x| f(*x)).collect() };
        let optics = OpticalProfile {
            altitude_km: vec![0.0, 1.0],
            wavelength_nm: nm.clone(),
            rayleigh_scattering_per_km: two(&|x| 0.1 * (550.0 / x).powi(4)),
            gas_absorption_per_km: two(&band),
            aerosol_scattering_per_km: vec![0.0; 2 * n],
            aerosol_absorption_per_km: vec![0.0; 2 * n],
            aerosol_g: vec![0.0; 2 * n],
            aerosol_g2: vec![0.0; 2 * n],
            aerosol_g_weight: vec![1.0; 2 * n],
            rayleigh_depolarization: 0.0,
        };
        let spread = Spread::new(&optics);
        assert!(spread.solved.len() < n);
        let truth: Vec<f64> = nm
            .iter()
            .map(|x| (550.0 / x).powi(3) * (-8.0 * band(*x)).exp())
            .collect();
        let solved: Vec<f64> = spread.solved.iter().map(|i| truth[*i]).collect();
        let packed = super::super::lanes::pack(&solved, solved.len());
        let mut found = vec![0.0; n];
        spread.add(&packed, &mut found);
        for (f, t) in found.iter().zip(&truth) {
            assert!((f / t - 1.0).abs() < 2e-3, "{f} {t}");
        }
    }

    /// Why maps every 20 nm cost no less than maps every 10 nm, as `utm-sky chart` finds.
    #[test]
    fn d_every_20_nm_is_no_cheaper_than_every_10_nm() {
        let solved = |step_nm: u16| {
            let settings = crate::optics::OpticsSettings::with_step_nm(step_nm).unwrap();
            let profile = crate::profile::AtmosphereProfile::general();
            let optics = OpticalProfile::build(&profile, &settings).unwrap();
            Spread::new(&optics).solved.len()
        };
        assert_eq!([solved(20), solved(10)], [21, 16]);
    }
}
