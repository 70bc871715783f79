//! The air that drives every model that can take air from outside: the transport engine's reference
//! atmosphere, reduced to three wavelengths.
//!
//! How the numbers were derived. Wavelengths and matrix: spectra of 912 skies of the transport
//! engine (19 directions; 0.3, 2, 8, 20 km; T 1.2, 2.2, 4.5; sun 20°, 60°, 84°, 91° from the zenith)
//! were reduced to three wavelengths on a 5 nm grid, with the 3×3 matrix of least relative error in
//! X, Y and Z; of all triples 615, 540 and 445 nm leave the least: 0.28 % rms in Y (1.7 % at most),
//! 0.42 % in X, 0.95 % in Z, 0.0012 in x and y (0.0055 at most). So the reduction costs less than
//! any of the methods. Optics at these wavelengths: Rayleigh by Bodhaine et al. 1999; ozone at 226 K
//! and the column and vertical shape of `profiles/general.csv`; rural aerosol of Shettle & Fenn 1979
//! at 50 % relative humidity; the background of the stratosphere after LOWTRAN7. Shapes stand in
//! `data/shapes.csv` on 1 km steps.
//!
//! Simplification: the stratospheric layer scatters with the haze's phase function (mean cosine 0.65
//! for 0.69).

use sky_core::haze::{HAZE_SCALE_HEIGHT_KM, optical_depth_500_from_turbidity};

use crate::texture::singles;
use sky_science::phase;

/// Top of the atmosphere \[km\]; nothing is above.
pub const TOP_KM: f64 = 100.0;

/// Vertical optical depth of the stratospheric background at 500 nm.
pub const STRATOSPHERE_OPTICAL_DEPTH_500: f64 = 0.008_275_36;

/// An atmosphere at three wavelengths (red, green, blue).
#[derive(Clone, Debug, PartialEq)]
pub struct Atmosphere {
    /// Wavelengths \[nm\].
    pub wavelength_nm: [f64; 3],
    /// Scattering by the molecules at sea level \[km⁻¹\].
    pub rayleigh_scattering_per_km: [f64; 3],
    /// Depolarization of the Rayleigh phase function.
    pub rayleigh_depolarization: f64,
    /// Vertical optical depth of ozone.
    pub ozone_optical_depth: [f64; 3],
    /// Extinction of the haze over that at 500 nm.
    pub aerosol_extinction_over_500: [f64; 3],
    /// Single-scattering albedo of the haze.
    pub aerosol_single_scattering_albedo: [f64; 3],
    /// Two Henyey–Greenstein terms: first g, second g, weight of the first.
    pub aerosol_phase: [f64; 3],
    /// Scale height of the haze \[km\].
    pub aerosol_scale_height_km: f64,
    /// Extinction of the stratospheric layer over that at 550 nm; it absorbs nothing.
    pub stratosphere_extinction_over_550: [f64; 3],
    /// The sun's irradiance, mean of 10 nm \[W·m⁻²·nm⁻¹\]; already part of the matrix.
    pub solar_irradiance_w_m2_nm: [f64; 3],
    /// Albedo of the ground (Lambertian).
    pub ground_albedo: f64,
    /// CIE XYZ \[cd·m⁻²\] of radiances over solar irradiance \[sr⁻¹\] at the three wavelengths.
    pub xyz_from_radiance_ratio: [[f64; 3]; 3],
    /// How the constituents lie in the vertical.
    pub shapes: Shapes,
}

/// Vertical shapes on steps of 1 km from the ground to [`TOP_KM`]; logarithmic between the steps.
#[derive(Clone, Debug, PartialEq)]
pub struct Shapes {
    /// Density of the air over that at sea level.
    pub air_relative_density: Vec<f64>,
    /// Share of the ozone column in a kilometre \[km⁻¹\].
    pub ozone_share_per_km: Vec<f64>,
    /// Extinction of the stratospheric layer at 550 nm \[km⁻¹\]; linear between the steps.
    pub stratosphere_extinction_550_per_km: Vec<f64>,
}

impl Shapes {
    /// Those of the transport engine's reference atmosphere.
    #[must_use]
    pub fn reference() -> Self {
        let mut columns: [Vec<f64>; 3] = Default::default();
        for line in include_str!("../data/shapes.csv").lines().skip(1) {
            // The embedded table holds numbers; a test says so.
            for (column, field) in columns.iter_mut().zip(line.split(',').skip(1)) {
                column.push(field.parse().unwrap_or(f64::NAN));
            }
        }
        let [air, ozone, stratosphere] = columns;
        Self {
            air_relative_density: air,
            ozone_share_per_km: ozone,
            stratosphere_extinction_550_per_km: stratosphere,
        }
    }

    /// Exponential air, ozone as a tent (lowest, peak, highest altitude \[km\]), no stratospheric
    /// layer: the vertical structure that Hillaire 2020 publishes with 8 km and 10–25–40 km.
    #[must_use]
    pub fn exponential(scale_height_km: f64, ozone_tent_km: [f64; 3]) -> Self {
        let [low, peak, high] = ozone_tent_km;
        let steps = (0..=100_u8).map(f64::from);
        let tent = |z: f64| {
            let rising = (z - low) / (peak - low);
            let falling = (high - z) / (high - peak);
            // a tent over `high − low` of height 2/(high − low) has the area 1; a logarithm needs
            // more than nothing
            (2.0 / (high - low) * rising.min(falling)).max(1e-12)
        };
        Self {
            air_relative_density: steps
                .clone()
                .map(|z| (-z / scale_height_km).exp())
                .collect(),
            ozone_share_per_km: steps.map(tent).collect(),
            stratosphere_extinction_550_per_km: vec![0.0; 101],
        }
    }
}

impl Default for Atmosphere {
    fn default() -> Self {
        Self {
            wavelength_nm: [615.0, 540.0, 445.0],
            rayleigh_scattering_per_km: [7.289_139e-3, 1.238_271e-2, 2.740_461e-2],
            rayleigh_depolarization: 0.0283,
            ozone_optical_depth: [4.073_83e-2, 2.660_897e-2, 1.426_495e-3],
            aerosol_extinction_over_500: [0.796_298, 0.928_656, 1.118_598],
            aerosol_single_scattering_albedo: [0.940_74, 0.944_91, 0.947_58],
            aerosol_phase: [0.6746, -0.6092, 0.9807],
            aerosol_scale_height_km: HAZE_SCALE_HEIGHT_KM,
            stratosphere_extinction_over_550: [0.843_716, 1.020_638, 1.265_975],
            solar_irradiance_w_m2_nm: [1.6978, 1.8669, 1.9263],
            ground_albedo: 0.2,
            xyz_from_radiance_ratio: [
                [82_862.002_6, 24_835.705_7, 22_147.864_6],
                [38_570.765_9, 87_936.462_4, 5_583.160_5],
                [-4_732.388_7, 25_237.867_3, 118_620.614_0],
            ],
            shapes: Shapes::reference(),
        }
    }
}

impl Atmosphere {
    /// Vertical optical depth of all aerosol at the three wavelengths, as if all of it were haze.
    #[must_use]
    pub fn aerosol_optical_depth(&self, turbidity: f64) -> [f64; 3] {
        let depth = optical_depth_500_from_turbidity(turbidity);
        self.aerosol_extinction_over_500.map(|e| e * depth)
    }

    /// Extinction of the aerosol at the ground \[km⁻¹\], all of it in one exponential layer.
    #[must_use]
    pub fn aerosol_extinction_per_km(&self, turbidity: f64) -> [f64; 3] {
        self.aerosol_optical_depth(turbidity)
            .map(|depth| depth / self.aerosol_scale_height_km)
    }

    /// Phase function of the molecules \[sr⁻¹\].
    #[must_use]
    pub fn rayleigh_phase(&self, cos_gamma: f64) -> f64 {
        phase::rayleigh(cos_gamma, self.rayleigh_depolarization)
    }

    /// Phase function of the aerosol \[sr⁻¹\].
    #[must_use]
    pub fn aerosol_phase(&self, cos_gamma: f64) -> f64 {
        let [g, g2, weight] = self.aerosol_phase;
        weight * phase::henyey_greenstein(cos_gamma, g)
            + (1.0 - weight) * phase::henyey_greenstein(cos_gamma, g2)
    }

    pub(crate) fn matrix(&self) -> [[f32; 3]; 3] {
        self.xyz_from_radiance_ratio.map(singles)
    }
}

/// Scattering and extinction at one altitude \[km⁻¹\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Local {
    pub(crate) rayleigh: [f64; 3],
    pub(crate) aerosol: [f64; 3],
    pub(crate) extinction: [f64; 3],
}

/// The atmosphere with its haze, by altitude.
#[derive(Clone, Debug)]
pub(crate) struct Optics {
    levels: Vec<Local>,
}

/// Distance of the levels \[km\]: the haze bends by 0.02 % between them.
const LEVEL_KM: f64 = 0.05;

impl Optics {
    pub(crate) fn new(air: &Atmosphere, turbidity: f64) -> Self {
        let depth_500 = optical_depth_500_from_turbidity(turbidity);
        let has_layer = air
            .shapes
            .stratosphere_extinction_550_per_km
            .iter()
            .any(|e| *e > 0.0);
        let layer_500 = if has_layer {
            STRATOSPHERE_OPTICAL_DEPTH_500.min(depth_500)
        } else {
            0.0
        };
        let layer = layer_500 / STRATOSPHERE_OPTICAL_DEPTH_500;
        let height = air.aerosol_scale_height_km;
        let ground = (depth_500 - layer_500) / (height * -(-TOP_KM / height).exp_m1());
        let levels = (0..=2000_u16)
            .map(|i| {
                let z = f64::from(i) * LEVEL_KM;
                let density = at(&air.shapes.air_relative_density, z, true);
                let ozone = at(&air.shapes.ozone_share_per_km, z, true);
                let background = at(&air.shapes.stratosphere_extinction_550_per_km, z, false);
                let haze = ground * (-z / height).exp();
                let mut local = Local::default();
                for k in 0..3 {
                    let rayleigh = air.rayleigh_scattering_per_km[k] * density;
                    let haze = haze * air.aerosol_extinction_over_500[k];
                    let layer = layer * background * air.stratosphere_extinction_over_550[k];
                    local.rayleigh[k] = rayleigh;
                    local.aerosol[k] = haze * air.aerosol_single_scattering_albedo[k] + layer;
                    local.extinction[k] =
                        rayleigh + haze + layer + ozone * air.ozone_optical_depth[k];
                }
                local
            })
            .collect();
        Self { levels }
    }

    #[inline]
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped to the levels first"
    )]
    pub(crate) fn at(&self, altitude_km: f64) -> Local {
        let last = self.levels.len() - 1;
        let place = (altitude_km / LEVEL_KM).clamp(0.0, last as f64);
        let lower = (place as usize).min(last - 1);
        let f = place - lower as f64;
        let (a, b) = (&self.levels[lower], &self.levels[lower + 1]);
        let mix = |a: &[f64; 3], b: &[f64; 3]| core::array::from_fn(|k| a[k] + f * (b[k] - a[k]));
        Local {
            rayleigh: mix(&a.rayleigh, &b.rayleigh),
            aerosol: mix(&a.aerosol, &b.aerosol),
            extinction: mix(&a.extinction, &b.extinction),
        }
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "altitudes lie between 0 and 100 km"
)]
fn at(steps: &[f64], altitude_km: f64, logarithmic: bool) -> f64 {
    let lower = (altitude_km as usize).min(steps.len() - 2);
    let f = altitude_km - lower as f64;
    let (a, b) = (steps[lower], steps[lower + 1]);
    if logarithmic {
        a * (b / a).powf(f)
    } else {
        a + f * (b - a)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn column(f: impl Fn(f64) -> f64) -> f64 {
        (0..20_000_u32)
            .map(|i| 0.005 * f((f64::from(i) + 0.5) * 0.005))
            .sum()
    }

    #[test]
    fn the_air_is_that_of_the_reference_optics() {
        let air = Atmosphere::default();
        for shape in [
            &air.shapes.air_relative_density,
            &air.shapes.ozone_share_per_km,
            &air.shapes.stratosphere_extinction_550_per_km,
        ] {
            assert_eq!(shape.len(), 101);
            assert!(shape.iter().all(|v| v.is_finite() && *v >= 0.0));
        }
        // Optical depths of the reference at 540 nm: Rayleigh 0.104665, ozone 0.026609.
        let clean = Optics::new(&air, 1.0);
        let tau = column(|z| clean.at(z).extinction[1]);
        assert!((tau / (0.104_665 + 0.026_609) - 1.0).abs() < 1e-3, "{tau}");
        // Aerosol of T = 3: 0.28688 at 500 nm, of which 0.00828 far above.
        let hazy = Optics::new(&air, 3.0);
        let tau = column(|z| hazy.at(z).extinction[1] - clean.at(z).extinction[1]);
        let want = (0.286_88 - 0.008_275) * 0.928_656 + 0.007_442_26 * 1.020_638;
        assert!((tau / want - 1.0).abs() < 1e-3, "{tau} {want}");
        let above = column(|z| if z > 12.0 { hazy.at(z).aerosol[1] } else { 0.0 });
        assert!((above - 0.006_32 * 1.020_638).abs() < 1e-4, "{above}");
    }

    #[test]
    fn hillaires_tent_and_exponential() {
        let air = Atmosphere {
            shapes: Shapes::exponential(8.0, [10.0, 25.0, 40.0]),
            ..Atmosphere::default()
        };
        let clean = Optics::new(&air, 1.0);
        let rayleigh = column(|z| clean.at(z).rayleigh[2]);
        assert!((rayleigh / (8.0 * 2.740_461e-2) - 1.0).abs() < 1e-4);
        let ozone = column(|z| clean.at(z).extinction[0] - clean.at(z).rayleigh[0]);
        assert!((ozone / 4.073_83e-2 - 1.0).abs() < 0.01, "{ozone}");
    }
}
