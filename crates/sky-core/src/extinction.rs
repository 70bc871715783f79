//! What the air takes from light on its way: extinction by constituent and altitude, small enough to
//! travel in a table's header.
//!
//! Four wavelengths stand for the spectrum. The transmittance of a channel for sunlight (linear sRGB
//! red, green, blue, or luminance) is a weighted sum of the transmittances at the four; the weights
//! are fitted where the table is baked. Out of scope: band absorption of water vapor.

use serde::{Deserialize, Serialize};

use crate::haze::optical_depth_500_from_turbidity;

/// Wavelengths that stand for the spectrum \[nm\]: of the sets of four on a 10 nm grid the one with
/// the least error, found by exchange.
pub const WAVELENGTHS_NM: [f64; 4] = [440.0, 490.0, 560.0, 620.0];

/// Distance of the levels \[km\].
pub const LEVEL_STEP_KM: f64 = 2.0;

/// Number of levels, from the ground to 60 km.
pub const LEVELS: usize = 31;

/// Altitudes of the levels \[km\].
pub fn level_altitudes_km() -> impl Iterator<Item = f64> {
    (0..LEVELS).scan(0.0, |next, _| {
        let here = *next;
        *next += LEVEL_STEP_KM;
        Some(here)
    })
}

/// Extinction of the atmosphere that a table was baked for.
///
/// Coefficients hold for a wavelength each and are multiplied by a constituent's relative density.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Extinction {
    /// Sunlight outside the atmosphere, in linear sRGB \[lx\].
    pub sun_rgb_lx: [f64; 3],
    /// Share of each wavelength in red, green, blue and luminance; a row sums to 1.
    pub weights: [[f64; 4]; 4],
    /// Rayleigh scattering coefficient at the ground \[km⁻¹\].
    pub rayleigh_per_km: [f64; 4],
    /// Absorption coefficient of the gases where they are densest \[km⁻¹\].
    pub gas_per_km: [f64; 4],
    /// Extinction coefficient of the haze at the ground for an optical depth of 1 at 500 nm \[km⁻¹\].
    pub haze_per_km: [f64; 4],
    /// Extinction coefficient of the stratospheric aerosol where it is densest \[km⁻¹\].
    pub layer_per_km: [f64; 4],
    /// Optical depth of the stratospheric aerosol at 500 nm: the first share of all aerosol.
    pub layer_optical_depth_500: f64,
    /// Scale height of the haze \[km\].
    pub haze_scale_height_km: f64,
    /// Density of air, gas and stratospheric aerosol at levels [`LEVEL_STEP_KM`] apart, relative to
    /// where the coefficient holds.
    pub relative_density: Vec<[f64; 3]>,
}

impl Extinction {
    /// Whether every number can be one of an atmosphere, and every list has its length.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        let not_negative = |x: &f64| x.is_finite() && *x >= 0.0;
        self.relative_density.len() == LEVELS
            && self.relative_density.iter().flatten().all(not_negative)
            && [
                &self.rayleigh_per_km,
                &self.gas_per_km,
                &self.haze_per_km,
                &self.layer_per_km,
            ]
            .into_iter()
            .flatten()
            .all(not_negative)
            && self.sun_rgb_lx.iter().all(not_negative)
            && self.weights.iter().flatten().all(|w| w.is_finite())
            && not_negative(&self.layer_optical_depth_500)
            && self.haze_scale_height_km > 0.0
            && self.haze_scale_height_km.is_finite()
    }

    /// Coefficients \[km⁻¹\] of air, gas, haze and stratospheric aerosol at the four wavelengths for
    /// a turbidity.
    #[must_use]
    pub fn coefficients_per_km(&self, turbidity: f64) -> [[f64; 4]; 4] {
        let depth = optical_depth_500_from_turbidity(turbidity).max(0.0);
        let layer = depth.min(self.layer_optical_depth_500);
        let layer_share = if self.layer_optical_depth_500 > 0.0 {
            layer / self.layer_optical_depth_500
        } else {
            0.0
        };
        [
            self.rayleigh_per_km,
            self.gas_per_km,
            self.haze_per_km.map(|c| c * (depth - layer)),
            self.layer_per_km.map(|c| c * layer_share),
        ]
    }
}
