//! From a spectrum to color: the CIE 1931 2° observer, and weights that turn spectral radiance into
//! tristimulus values.
//!
//! Out of scope: other observers, adaptation.

use std::sync::LazyLock;

use sky_core::color::{Xyz, Yxy, yxy_from_xyz};
use sky_core::quantity::LUMINOUS_EFFICACY_LM_PER_W;

use crate::spectrum::{
    Spectrum, SpectrumError, check_wavelengths, cubic_weights, interpolate_linear,
    trapezoid_weights,
};

/// The CIE 1931 2° observer and the illuminant D65, 360–830 nm at 1 nm. Source: `data/README.md`.
struct CieTable {
    wavelength_nm: Vec<f64>,
    color_matching: [Vec<f64>; 3],
    d65: Vec<f64>,
}

static CIE_1931_2DEG: LazyLock<CieTable> = LazyLock::new(|| {
    let mut table = CieTable {
        wavelength_nm: Vec::new(),
        color_matching: [Vec::new(), Vec::new(), Vec::new()],
        d65: Vec::new(),
    };
    let [x_bar, y_bar, z_bar] = &mut table.color_matching;
    let mut columns = [
        &mut table.wavelength_nm,
        x_bar,
        y_bar,
        z_bar,
        &mut table.d65,
    ];
    for line in include_str!("../data/cie_1931_2deg.csv").lines().skip(1) {
        for (column, field) in columns.iter_mut().zip(line.split(',')) {
            column.push(field.parse().expect("the embedded table holds numbers"));
        }
    }
    table
});

/// Color matching functions x̄, ȳ, z̄ of the CIE 1931 2° observer, linear between the 1 nm entries
/// and zero outside 360–830 nm.
#[must_use]
pub fn color_matching_functions(wavelength_nm: f64) -> [f64; 3] {
    let table = &*CIE_1931_2DEG;
    table.color_matching.each_ref().map(|column| {
        interpolate_linear(&table.wavelength_nm, column, wavelength_nm).unwrap_or(0.0)
    })
}

/// Relative power of the standard illuminant D65, 360–830 nm (100 at 560 nm), linear between the
/// 1 nm entries and zero outside.
#[must_use]
pub fn d65_relative_power(wavelength_nm: f64) -> f64 {
    let table = &*CIE_1931_2DEG;
    interpolate_linear(&table.wavelength_nm, &table.d65, wavelength_nm).unwrap_or(0.0)
}

/// Weights that turn a spectrum on a fixed wavelength grid into tristimulus values.
#[derive(Clone, Debug, PartialEq)]
pub struct ColorWeights {
    wavelength_nm: Vec<f64>,
    weights: Vec<[f64; 3]>,
}

/// What wavelengths must cover to have a color \[nm\]: beyond it lies less than 1 % of each color
/// matching function's sum.
pub const VISIBLE_NM: [f64; 2] = [405.0, 695.0];

/// Checks wavelengths, and that they cover the visible; returns their range \[nm\].
fn visible(wavelength_nm: &[f64]) -> Result<[f64; 2], SpectrumError> {
    check_wavelengths(wavelength_nm, 2)?;
    let found_nm = [wavelength_nm[0], wavelength_nm[wavelength_nm.len() - 1]];
    if found_nm[0] > VISIBLE_NM[0] || found_nm[1] < VISIBLE_NM[1] {
        return Err(SpectrumError::NotVisible {
            expected_nm: VISIBLE_NM,
            found_nm,
        });
    }
    Ok(found_nm)
}

impl ColorWeights {
    /// Weights for spectral radiance \[W·m⁻²·sr⁻¹·nm⁻¹\]: trapezoid rule on the given wavelengths
    /// with the color matching functions interpolated linearly there.
    ///
    /// Accurate for smooth spectra on fine grids; the solar spectrum is not smooth, so a sky on
    /// 10 nm steps is better served by [`Self::for_radiance_ratio`].
    ///
    /// # Errors
    /// When the wavelengths are not positive and strictly ascending, or do not cover the visible.
    pub fn for_spectral_radiance(wavelength_nm: &[f64]) -> Result<Self, SpectrumError> {
        visible(wavelength_nm)?;
        let weights = trapezoid_weights(wavelength_nm)
            .iter()
            .zip(wavelength_nm)
            .map(|(step, &nm)| {
                color_matching_functions(nm).map(|bar| LUMINOUS_EFFICACY_LM_PER_W * bar * step)
            })
            .collect();
        Ok(Self {
            wavelength_nm: wavelength_nm.to_vec(),
            weights,
        })
    }

    /// Weights for the radiance per unit of extraterrestrial solar irradiance, L/E₀ \[sr⁻¹\].
    ///
    /// The ratio is smooth in wavelength while the solar spectrum is not. So the ratio is
    /// interpolated between the grid's wavelengths (cubic Lagrange, linear in the first and last
    /// interval), and its product with the solar spectrum and the color matching functions is
    /// integrated on the solar spectrum's own wavelengths, from the first to the last wavelength of
    /// the grid. `solar_irradiance` is normal to the beam \[W·m⁻²·nm⁻¹\].
    ///
    /// # Errors
    /// When there are fewer than two wavelengths, when they are not positive and strictly ascending or
    /// do not cover the visible, or when the solar spectrum does not cover them.
    pub fn for_radiance_ratio(
        wavelength_nm: &[f64],
        solar_irradiance: &Spectrum,
    ) -> Result<Self, SpectrumError> {
        let range = visible(wavelength_nm)?;
        let not_covered = SpectrumError::NotCovered {
            expected_nm: range,
            found_nm: solar_irradiance.range_nm(),
        };
        let mut samples = vec![range[0]];
        samples.extend(
            solar_irradiance
                .wavelength_nm()
                .iter()
                .filter(|&&nm| nm > range[0] && nm < range[1]),
        );
        samples.push(range[1]);
        let mut weights = vec![[0.0; 3]; wavelength_nm.len()];
        for (&nm, step) in samples.iter().zip(trapezoid_weights(&samples)) {
            let irradiance = solar_irradiance.at(nm).ok_or(not_covered)?;
            let local = cubic_weights(wavelength_nm, nm).ok_or(not_covered)?;
            let bars = color_matching_functions(nm);
            for (k, share) in local.weights.iter().enumerate().take(local.count) {
                for (weight, bar) in weights[local.first + k].iter_mut().zip(bars) {
                    *weight += LUMINOUS_EFFICACY_LM_PER_W * bar * irradiance * step * share;
                }
            }
        }
        Ok(Self {
            wavelength_nm: wavelength_nm.to_vec(),
            weights,
        })
    }

    /// The wavelengths \[nm\] that a spectrum must have.
    #[must_use]
    pub fn wavelength_nm(&self) -> &[f64] {
        &self.wavelength_nm
    }

    /// The weights: per wavelength, what one unit adds to X, Y and Z.
    #[must_use]
    pub fn weights(&self) -> &[[f64; 3]] {
        &self.weights
    }

    /// Tristimulus values \[cd·m⁻²\] of a spectrum on these wavelengths.
    ///
    /// # Panics
    /// When the spectrum has another number of values than there are wavelengths.
    #[must_use]
    pub fn xyz(&self, spectrum: &[f64]) -> Xyz {
        assert_eq!(
            spectrum.len(),
            self.weights.len(),
            "one value per wavelength"
        );
        let mut sums = [0.0; 3];
        for (value, weights) in spectrum.iter().zip(&self.weights) {
            for (sum, weight) in sums.iter_mut().zip(weights) {
                *sum += value * weight;
            }
        }
        let [x, y, z] = sums;
        Xyz { x, y, z }
    }

    /// Luminance and chromaticity of a spectrum on these wavelengths.
    ///
    /// # Panics
    /// When the spectrum has another number of values than there are wavelengths.
    #[must_use]
    pub fn yxy(&self, spectrum: &[f64]) -> Yxy {
        yxy_from_xyz(self.xyz(spectrum))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::uniform_wavelengths;
    use sky_core::extended::within_locus;
    use sky_core::quantity::single;

    fn close(found: f64, expected: f64, tolerance: f64) {
        assert!(
            (found - expected).abs() <= tolerance,
            "{found} is not {expected} within {tolerance}"
        );
    }

    #[test]
    fn the_embedded_table_has_the_published_sums() {
        let sums = CIE_1931_2DEG
            .color_matching
            .each_ref()
            .map(|c| c.iter().sum::<f64>());
        close(sums[0], 106.865_469, 1e-6);
        close(sums[1], 106.856_917, 1e-6);
        close(sums[2], 106.892_251, 1e-6);
        assert_eq!(CIE_1931_2DEG.wavelength_nm.len(), 471);
        assert_eq!(CIE_1931_2DEG.d65.len(), 471);
    }

    #[test]
    fn equal_energy_and_d65_have_the_published_chromaticities() {
        // A plain sum at 1 nm and the trapezoid rule differ only in the two dark end points.
        let grid = uniform_wavelengths(360.0, 830.0, 1.0).unwrap();
        let weights = ColorWeights::for_spectral_radiance(&grid).unwrap();
        let equal = weights.yxy(&vec![1.0; grid.len()]);
        close(equal.x, 0.333_314, 1e-6);
        close(equal.y, 0.333_288, 1e-6);
        close(equal.luminance_cd_m2, 683.002 * 106.856_917, 2.0);
        let d65 = weights.xyz(
            &grid
                .iter()
                .map(|&nm| d65_relative_power(nm))
                .collect::<Vec<_>>(),
        );
        let yxy = yxy_from_xyz(d65);
        close(yxy.x, 0.312_727, 1e-6);
        close(yxy.y, 0.329_023, 1e-6);
        close(d65.x / d65.y, 0.950_471, 1e-6);
        close(d65.z / d65.y, 1.088_828, 1e-6);
    }

    #[test]
    fn radiance_ratio_weights_equal_the_1_nm_integral_for_a_cubic_ratio() {
        // A jagged "sun" and a ratio that the interpolation reproduces exactly inside the grid.
        let fine = uniform_wavelengths(360.0, 830.0, 1.0).unwrap();
        let jagged: Vec<f64> = (0..fine.len())
            .map(|i| if i % 3 == 0 { 1.0 } else { 2.0 })
            .collect();
        let sun = Spectrum::new(fine.clone(), jagged.clone()).unwrap();
        let ratio = |nm: f64| {
            let t = (nm - 580.0) / 200.0;
            0.3 - 0.2 * t
        };
        let grid = uniform_wavelengths(380.0, 780.0, 10.0).unwrap();
        let coarse = ColorWeights::for_radiance_ratio(&grid, &sun).unwrap();
        let found = coarse.xyz(&grid.iter().map(|&nm| ratio(nm)).collect::<Vec<_>>());
        let inner = uniform_wavelengths(380.0, 780.0, 1.0).unwrap();
        let expected = ColorWeights::for_spectral_radiance(&inner).unwrap().xyz(
            &inner
                .iter()
                .map(|&nm| ratio(nm) * sun.at(nm).unwrap())
                .collect::<Vec<_>>(),
        );
        close(found.x / expected.x, 1.0, 1e-12);
        close(found.y / expected.y, 1.0, 1e-12);
        close(found.z / expected.z, 1.0, 1e-12);
    }

    #[test]
    fn a_rayleigh_ratio_on_10_nm_steps_is_accurate_where_the_plain_rule_is_not() {
        // Lines in the sun, one every 7 nm: the plain 10 nm rule aliases them.
        let fine = uniform_wavelengths(360.0, 830.0, 1.0).unwrap();
        let lines: Vec<f64> = (0..fine.len())
            .map(|i| if i % 7 == 0 { 0.6 } else { 1.8 })
            .collect();
        let sun = Spectrum::new(fine, lines).unwrap();
        let ratio = |nm: f64| (550.0 / nm).powi(4);
        let inner = uniform_wavelengths(380.0, 780.0, 1.0).unwrap();
        let truth = ColorWeights::for_spectral_radiance(&inner).unwrap().yxy(
            &inner
                .iter()
                .map(|&nm| ratio(nm) * sun.at(nm).unwrap())
                .collect::<Vec<_>>(),
        );
        let grid = uniform_wavelengths(380.0, 780.0, 10.0).unwrap();
        let on_grid: Vec<f64> = grid.iter().map(|&nm| ratio(nm)).collect();
        let good = ColorWeights::for_radiance_ratio(&grid, &sun)
            .unwrap()
            .yxy(&on_grid);
        close(good.luminance_cd_m2 / truth.luminance_cd_m2, 1.0, 1e-5);
        close(good.x, truth.x, 1e-5);
        close(good.y, truth.y, 1e-5);
        let radiance: Vec<f64> = grid
            .iter()
            .zip(&on_grid)
            .map(|(&nm, r)| r * sun.at(nm).unwrap())
            .collect();
        let plain = ColorWeights::for_spectral_radiance(&grid)
            .unwrap()
            .yxy(&radiance);
        assert!((plain.luminance_cd_m2 / truth.luminance_cd_m2 - 1.0).abs() > 1e-3);
    }

    #[test]
    fn a_sun_that_does_not_cover_the_grid_is_refused() {
        let sun = Spectrum::new(vec![400.0, 800.0], vec![1.0, 1.0]).unwrap();
        assert!(matches!(
            ColorWeights::for_radiance_ratio(&[380.0, 700.0], &sun),
            Err(SpectrumError::NotCovered { .. })
        ));
    }

    #[test]
    fn a_color_stays_in_the_locus_and_one_within_is_left_alone() {
        for nm in (380..=700_u16).step_by(5) {
            let [x, y, z] = color_matching_functions(nm.into());
            let spectral = [x / (x + y + z), y / (x + y + z)].map(single);
            // what is drawn in is no farther out than the spectral color, and at most a little in
            let [a, b] = within_locus(spectral);
            let share = (a - 1.0 / 3.0).hypot(b - 1.0 / 3.0)
                / (spectral[0] - 1.0 / 3.0).hypot(spectral[1] - 1.0 / 3.0);
            assert!((0.84..1.0).contains(&share), "{nm} nm: {share}");
            // and so is what lies beyond it
            let beyond = spectral.map(|v| 1.0 / 3.0 + 3.0 * (v - 1.0 / 3.0));
            let [c, d] = within_locus(beyond);
            assert!((a - c).abs() < 1e-6 && (b - d).abs() < 1e-6, "{nm} nm");
        }
        for inside in [[0.3127, 0.3290], [0.184, 0.141], [0.6, 0.38], [0.25, 0.25]] {
            let [x, y] = within_locus(inside);
            assert!((x - inside[0]).abs() < 1e-6 && (y - inside[1]).abs() < 1e-6);
        }
    }
}
