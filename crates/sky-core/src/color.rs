//! From spectral radiance to color: CIE 1931 2° tristimulus values, Yxy, linear and encoded sRGB.
//!
//! Luminance is absolute \[cd·m⁻²\] up to linear sRGB, which is scene-referred: exposure and tone
//! curve come later, and only encoded sRGB is bounded to 0–1. Out of scope: tone curves, adaptation,
//! other observers.

use std::sync::LazyLock;

use crate::quantity::LUMINOUS_EFFICACY_LM_PER_W;
use crate::sky_model::Yxy;
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

/// CIE 1931 2° tristimulus values \[cd·m⁻²\]; `y` is the luminance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Xyz {
    /// X \[cd·m⁻²\].
    pub x: f64,
    /// Y, the luminance \[cd·m⁻²\].
    pub y: f64,
    /// Z \[cd·m⁻²\].
    pub z: f64,
}

/// Weights that turn a spectrum on a fixed wavelength grid into tristimulus values.
#[derive(Clone, Debug, PartialEq)]
pub struct ColorWeights {
    wavelength_nm: Vec<f64>,
    weights: Vec<[f64; 3]>,
}

impl ColorWeights {
    /// Weights for spectral radiance \[W·m⁻²·sr⁻¹·nm⁻¹\]: trapezoid rule on the given wavelengths
    /// with the color matching functions interpolated linearly there.
    ///
    /// Accurate for smooth spectra on fine grids; the solar spectrum is not smooth, so a sky on
    /// 10 nm steps is better served by [`Self::for_radiance_ratio`].
    ///
    /// # Errors
    /// When the wavelengths are not positive and strictly ascending.
    pub fn for_spectral_radiance(wavelength_nm: &[f64]) -> Result<Self, SpectrumError> {
        check_wavelengths(wavelength_nm, 1)?;
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
    /// When there are fewer than two wavelengths, when they are not positive and strictly ascending,
    /// or when the solar spectrum does not cover them.
    pub fn for_radiance_ratio(
        wavelength_nm: &[f64],
        solar_irradiance: &Spectrum,
    ) -> Result<Self, SpectrumError> {
        check_wavelengths(wavelength_nm, 2)?;
        let range = [wavelength_nm[0], wavelength_nm[wavelength_nm.len() - 1]];
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

/// Luminance and chromaticity. Black has none: its x and y are 0.
#[must_use]
pub fn yxy_from_xyz(xyz: Xyz) -> Yxy {
    let sum = xyz.x + xyz.y + xyz.z;
    let (x, y) = if sum > 0.0 {
        (xyz.x / sum, xyz.y / sum)
    } else {
        (0.0, 0.0)
    };
    Yxy {
        luminance_cd_m2: xyz.y,
        x,
        y,
    }
}

/// Tristimulus values. A chromaticity with y = 0 carries no luminance and gives black.
#[must_use]
pub fn xyz_from_yxy(yxy: Yxy) -> Xyz {
    if yxy.y == 0.0 {
        return Xyz::default();
    }
    let scale = yxy.luminance_cd_m2 / yxy.y;
    Xyz {
        x: yxy.x * scale,
        y: yxy.luminance_cd_m2,
        z: (1.0 - yxy.x - yxy.y) * scale,
    }
}

/// XYZ → linear sRGB, derived at full precision from the primaries (0.64, 0.33), (0.30, 0.60),
/// (0.15, 0.06) and the white (0.3127, 0.3290) of IEC 61966-2-1.
pub const LINEAR_SRGB_FROM_XYZ: [[f64; 3]; 3] = [
    [
        3.240_969_941_904_522_6,
        -1.537_383_177_570_094,
        -0.498_610_760_293_003_4,
    ],
    [
        -0.969_243_636_280_879_6,
        1.875_967_501_507_720_2,
        0.041_555_057_407_175_6,
    ],
    [
        0.055_630_079_696_993_6,
        -0.203_976_958_888_976_5,
        1.056_971_514_242_878_2,
    ],
];

/// Linear sRGB → XYZ, the inverse of [`LINEAR_SRGB_FROM_XYZ`].
pub const XYZ_FROM_LINEAR_SRGB: [[f64; 3]; 3] = [
    [
        0.412_390_799_265_959_3,
        0.357_584_339_383_878,
        0.180_480_788_401_834_3,
    ],
    [
        0.212_639_005_871_510_3,
        0.715_168_678_767_756,
        0.072_192_315_360_733_7,
    ],
    [
        0.019_330_818_715_591_8,
        0.119_194_779_794_626,
        0.950_532_152_249_660_7,
    ],
];

/// Linear (scene-referred) red, green and blue in the sRGB primaries, in the unit of the luminance
/// they came from; components may be negative or exceed 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LinearSrgb {
    /// Red.
    pub red: f64,
    /// Green.
    pub green: f64,
    /// Blue.
    pub blue: f64,
}

/// Display-encoded sRGB, each component 0–1 for a color inside the gamut.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Srgb {
    /// Red.
    pub red: f64,
    /// Green.
    pub green: f64,
    /// Blue.
    pub blue: f64,
}

fn multiply(matrix: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// Linear sRGB of tristimulus values, in the same unit.
#[must_use]
pub fn linear_srgb_from_xyz(xyz: Xyz) -> LinearSrgb {
    let [red, green, blue] = multiply(&LINEAR_SRGB_FROM_XYZ, [xyz.x, xyz.y, xyz.z]);
    LinearSrgb { red, green, blue }
}

/// Tristimulus values of linear sRGB, in the same unit.
#[must_use]
pub fn xyz_from_linear_srgb(rgb: LinearSrgb) -> Xyz {
    let [x, y, z] = multiply(&XYZ_FROM_LINEAR_SRGB, [rgb.red, rgb.green, rgb.blue]);
    Xyz { x, y, z }
}

/// The transfer curve of IEC 61966-2-1, linear → encoded.
#[must_use]
pub fn encoded_from_linear(linear: f64) -> f64 {
    if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    }
}

/// The transfer curve of IEC 61966-2-1, encoded → linear.
#[must_use]
pub fn linear_from_encoded(encoded: f64) -> f64 {
    if encoded <= 0.040_45 {
        encoded / 12.92
    } else {
        ((encoded + 0.055) / 1.055).powf(2.4)
    }
}

/// Encodes linear sRGB; values outside 0–1 are left outside, see [`map_to_gamut`].
#[must_use]
pub fn srgb_from_linear(rgb: LinearSrgb) -> Srgb {
    Srgb {
        red: encoded_from_linear(rgb.red),
        green: encoded_from_linear(rgb.green),
        blue: encoded_from_linear(rgb.blue),
    }
}

/// Decodes sRGB.
#[must_use]
pub fn linear_from_srgb(rgb: Srgb) -> LinearSrgb {
    LinearSrgb {
        red: linear_from_encoded(rgb.red),
        green: linear_from_encoded(rgb.green),
        blue: linear_from_encoded(rgb.blue),
    }
}

/// How a color outside the sRGB gamut is brought inside.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GamutMapping {
    /// Towards the gray of equal luminance, just far enough.
    #[default]
    Desaturate,
    /// Each component on its own; luminance and hue shift.
    Clip,
}

impl LinearSrgb {
    /// Luminance, in the unit of the components.
    #[must_use]
    pub fn luminance(self) -> f64 {
        let [red, green, blue] = XYZ_FROM_LINEAR_SRGB[1];
        red * self.red + green * self.green + blue * self.blue
    }

    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        Self {
            red: f(self.red),
            green: f(self.green),
            blue: f(self.blue),
        }
    }

    /// Mixes with the gray of equal luminance until every component lies in 0–`upper`.
    fn desaturate(self, upper: f64) -> Self {
        let gray = self.luminance();
        if gray <= 0.0 {
            return self.map(|_| 0.0);
        }
        if gray >= upper {
            return self.map(|_| upper);
        }
        // Largest saturation s with 0 <= gray + s (c - gray) <= upper for each component c.
        let mut saturation = 1.0_f64;
        for component in [self.red, self.green, self.blue] {
            if component < 0.0 {
                saturation = saturation.min(gray / (gray - component));
            } else if component > upper {
                saturation = saturation.min((upper - gray) / (component - gray));
            }
        }
        // The last rounding must not leave the gamut.
        self.map(|c| (gray + saturation * (c - gray)).clamp(0.0, upper))
    }

    /// Brings a scene-referred color into the sRGB triangle: no component negative, none limited
    /// above, so that exposure can still be applied.
    #[must_use]
    pub fn without_negatives(self, mapping: GamutMapping) -> Self {
        match mapping {
            GamutMapping::Desaturate => self.desaturate(f64::INFINITY),
            GamutMapping::Clip => self.map(|c| c.max(0.0)),
        }
    }
}

/// Brings an exposed color into the display's cube 0–1. Desaturating keeps the luminance up to
/// white; what is brighter than white becomes white.
#[must_use]
pub fn map_to_gamut(rgb: LinearSrgb, mapping: GamutMapping) -> LinearSrgb {
    match mapping {
        GamutMapping::Desaturate => rgb.desaturate(1.0),
        GamutMapping::Clip => rgb.map(|c| c.clamp(0.0, 1.0)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::uniform_wavelengths;

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
    fn yxy_and_xyz_round_trip() {
        for (luminance_cd_m2, x, y) in [(5000.0, 0.25, 0.26), (1e-3, 0.7, 0.29), (1.0, 0.31, 0.33)]
        {
            let yxy = Yxy {
                luminance_cd_m2,
                x,
                y,
            };
            let back = yxy_from_xyz(xyz_from_yxy(yxy));
            close(
                back.luminance_cd_m2,
                luminance_cd_m2,
                1e-12 * luminance_cd_m2,
            );
            close(back.x, x, 1e-14);
            close(back.y, y, 1e-14);
        }
        let black = yxy_from_xyz(Xyz::default());
        assert_eq!(black, Yxy::default());
        assert_eq!(xyz_from_yxy(black), Xyz::default());
    }

    #[test]
    fn the_matrices_are_inverses_and_white_is_white() {
        for (i, unit) in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
            .into_iter()
            .enumerate()
        {
            let back = multiply(&LINEAR_SRGB_FROM_XYZ, multiply(&XYZ_FROM_LINEAR_SRGB, unit));
            for (j, found) in back.into_iter().enumerate() {
                close(found, if i == j { 1.0 } else { 0.0 }, 4e-16);
            }
        }
        let white = linear_srgb_from_xyz(Xyz {
            x: 0.950_455_927_051_671_6,
            y: 1.0,
            z: 1.089_057_750_759_878_4,
        });
        for c in [white.red, white.green, white.blue] {
            close(c, 1.0, 1e-15);
        }
    }

    #[test]
    fn a_sky_blue_has_the_expected_linear_srgb() {
        let rgb = linear_srgb_from_xyz(xyz_from_yxy(Yxy {
            luminance_cd_m2: 1.0,
            x: 0.25,
            y: 0.26,
        }));
        close(rgb.red, 0.639_245, 1e-6);
        close(rgb.green, 1.022_318, 1e-6);
        close(rgb.blue, 1.841_498, 1e-6);
        let back = xyz_from_linear_srgb(rgb);
        close(back.y, 1.0, 1e-15);
    }

    #[test]
    fn the_transfer_curve_has_the_published_values_and_its_inverse() {
        for (linear, encoded) in [
            (0.001, 0.012_92),
            (0.003_130_8, 0.040_449_936_0),
            (0.18, 0.461_356_129_5),
            (0.5, 0.735_356_983_1),
            (1.0, 1.0),
        ] {
            close(encoded_from_linear(linear), encoded, 5e-11);
        }
        for (encoded, linear) in [
            (0.001, 0.000_077_399_4),
            (0.040_45, 0.003_130_805_0),
            (0.18, 0.027_211_781_0),
            (0.5, 0.214_041_140_5),
            (1.0, 1.0),
        ] {
            close(linear_from_encoded(encoded), linear, 5e-11);
        }
        for i in 0..257_u16 {
            let v = f64::from(i) / 256.0;
            close(encoded_from_linear(linear_from_encoded(v)), v, 1e-7);
        }
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
    fn desaturation_keeps_luminance_and_ends_on_the_boundary() {
        let out = LinearSrgb {
            red: -0.2,
            green: 0.5,
            blue: 1.3,
        };
        let inside = map_to_gamut(out, GamutMapping::Desaturate);
        close(inside.luminance(), out.luminance(), 1e-15);
        let components = [inside.red, inside.green, inside.blue];
        assert!(components.iter().all(|c| (0.0..=1.0).contains(c)));
        assert!(components.iter().any(|c| *c < 1e-15 || *c > 1.0 - 1e-15));
        let scene = LinearSrgb {
            red: -20.0,
            green: 500.0,
            blue: 1300.0,
        };
        let kept = scene.without_negatives(GamutMapping::Desaturate);
        close(kept.luminance(), scene.luminance(), 1e-10);
        close(kept.red, 0.0, 1e-12);
        let fine = LinearSrgb {
            red: 0.1,
            green: 0.2,
            blue: 0.9,
        };
        let same = map_to_gamut(fine, GamutMapping::Desaturate);
        close(same.blue, 0.9, 1e-15);
        let glare = map_to_gamut(
            LinearSrgb {
                red: 5.0,
                green: 4.0,
                blue: 3.0,
            },
            GamutMapping::Desaturate,
        );
        close(glare.blue, 1.0, 0.0);
        let clipped = map_to_gamut(out, GamutMapping::Clip);
        close(clipped.red, 0.0, 0.0);
        close(clipped.blue, 1.0, 0.0);
    }
}
