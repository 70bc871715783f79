//! Light as luminance and chromaticity, as tristimulus values and as linear sRGB.
//!
//! Luminance is absolute \[cd·m⁻²\] up to linear sRGB, which is scene-referred: exposure and tone
//! curve come later ([`crate::tonemap`]). Out of scope: spectra.

use serde::{Deserialize, Serialize};

use crate::quantity::single;

/// Luminance and CIE 1931 2° chromaticity of a light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Yxy {
    /// Luminance Y \[cd·m⁻²\].
    pub luminance_cd_m2: f64,
    /// Chromaticity x.
    pub x: f64,
    /// Chromaticity y.
    pub y: f64,
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

impl LinearSrgb {
    /// Luminance, in the unit of the components.
    #[must_use]
    pub fn luminance(self) -> f64 {
        let [red, green, blue] = XYZ_FROM_LINEAR_SRGB[1];
        red * self.red + green * self.green + blue * self.blue
    }
}

/// Linear sRGB from luminance and chromaticity.
#[must_use]
pub fn linear_srgb([luminance, x, y]: [f32; 3]) -> [f32; 3] {
    let scale = luminance / y;
    let xyz = [x * scale, luminance, (1.0 - x - y) * scale];
    LINEAR_SRGB_FROM_XYZ.map(|row| row.iter().zip(xyz).map(|(m, c)| single(*m) * c).sum())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(found: f64, expected: f64, tolerance: f64) {
        assert!(
            (found - expected).abs() <= tolerance,
            "{found} is not {expected} within {tolerance}"
        );
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
}
