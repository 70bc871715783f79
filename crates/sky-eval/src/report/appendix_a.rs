//! Audit of the look-up table printed in Appendix A of the report: which of its rows are possible.
//!
//! One set of coefficients a row is printed; it is read as luminance's, with F = (1 + A exp(B/cos θ))
//! (1 + C exp(Dγ) + E cos²γ) relative to the zenith. Out of scope: repairing the table.

use std::sync::LazyLock;

use serde::Deserialize;
use sky_core::direction::SkyDirection;
use sky_core::quantity::Angle;
use sky_science::perez::PerezCoefficients;

use crate::locus::spectral_colors;

/// A row as printed.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Row {
    /// Altitude of the observer \[km\].
    #[serde(rename = "reference_altitude_km")]
    pub altitude_km: f64,
    /// What the report calls turbidity: 0, 0.5 or 1.
    pub turbidity: f64,
    /// Zenith angle of the sun \[deg\].
    pub sun_zenith_deg: f64,
    /// Azimuth of the sun \[deg\].
    pub sun_azimuth_deg: f64,
    /// Coefficient A.
    #[serde(rename = "A")]
    pub a: f64,
    /// Coefficient B.
    #[serde(rename = "B")]
    pub b: f64,
    /// Coefficient C.
    #[serde(rename = "C")]
    pub c: f64,
    /// Coefficient D.
    #[serde(rename = "D")]
    pub d: f64,
    /// Coefficient E.
    #[serde(rename = "E")]
    pub e: f64,
    /// Luminance of the zenith; the report states no unit.
    #[serde(rename = "zenith_Y_unit_not_stated")]
    pub zenith_luminance: f64,
    /// Chromaticity x of the zenith.
    pub zenith_x: f64,
    /// Chromaticity y of the zenith.
    pub zenith_y: f64,
    /// `ok`, or `order_inferred` where the print displaced the numbers.
    pub transcription: String,
}

static ROWS: LazyLock<Vec<Row>> = LazyLock::new(|| {
    csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .from_reader(include_bytes!("../../data/appendix_a.csv").as_slice())
        .deserialize()
        .collect::<Result<_, _>>()
        .expect("the embedded table is complete")
});

/// The spectral locus of the CIE 1931 2° observer, 360–830 nm in 1 nm steps: x, y.
static LOCUS: LazyLock<Vec<[f64; 2]>> = LazyLock::new(|| spectral_colors(360..=830).collect());

/// All 75 rows.
#[must_use]
pub fn rows() -> &'static [Row] {
    &ROWS
}

/// Chromaticities of the monochromatic lights from 360 to 830 nm, 1 nm apart.
#[must_use]
pub fn spectral_locus() -> &'static [[f64; 2]] {
    &LOCUS
}

/// Whether a chromaticity lies inside the spectral locus and the line of purples, so that a light can
/// have it.
#[must_use]
pub fn is_a_color(x: f64, y: f64) -> bool {
    let locus = spectral_locus();
    let mut inside = false;
    let mut last = locus[locus.len() - 1];
    for &here in locus {
        if (here[1] > y) != (last[1] > y)
            && x < (last[0] - here[0]) * (y - here[1]) / (last[1] - here[1]) + here[0]
        {
            inside = !inside;
        }
        last = here;
    }
    inside
}

/// Lowest direction of the dome that is looked at \[deg from the zenith\].
const DOME_END_DEG: f64 = 89.9;

/// Largest ratio of the brightest to the darkest direction that a sky may have.
pub const LARGEST_CONTRAST: f64 = 1e4;

impl Row {
    fn coefficients(&self) -> PerezCoefficients {
        PerezCoefficients::from_array([self.a, self.b, self.c, self.d, self.e])
    }

    /// Least and greatest luminance relative to the zenith over the dome, zenith angles up to 89.9°.
    #[must_use]
    pub fn dome_range(&self) -> [f64; 2] {
        let sun = Angle::from_degrees(self.sun_zenith_deg);
        let coefficients = self.coefficients();
        let value = |zenith_deg: f64, azimuth_deg: f64| {
            let direction = SkyDirection::from_degrees(zenith_deg, azimuth_deg);
            let mass = 1.0 / direction.view_zenith.radians().cos();
            coefficients.gradation(mass) * coefficients.indicatrix(direction.scattering_angle(sun))
        };
        let zenith = value(0.0, 0.0);
        let mut range = [f64::INFINITY, f64::NEG_INFINITY];
        for ring in (0..90_u8).map(f64::from).chain([89.5, DOME_END_DEG]) {
            for spoke in 0..=90_u8 {
                let relative = value(ring, 2.0 * f64::from(spoke)) / zenith;
                range[0] = range[0].min(relative);
                range[1] = range[1].max(relative);
            }
        }
        range
    }

    /// Whether the formula stays finite down to the horizon.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.b <= 0.0
    }

    /// Whether luminance is positive over the dome and does not exceed the range of double precision
    /// there (an exponential of more than 709 does).
    #[must_use]
    pub fn is_positive(&self) -> bool {
        let [least, greatest] = self.dome_range();
        least > 0.0 && greatest.is_finite()
    }

    /// Whether brightest and darkest direction differ by less than [`LARGEST_CONTRAST`].
    #[must_use]
    pub fn has_possible_contrast(&self) -> bool {
        let [least, greatest] = self.dome_range();
        greatest / least < LARGEST_CONTRAST
    }

    /// Whether the zenith's chromaticity is that of a light.
    #[must_use]
    pub fn zenith_is_a_color(&self) -> bool {
        is_a_color(self.zenith_x, self.zenith_y)
    }
}

/// A test of the audit.
#[derive(Clone, Copy, Debug)]
pub struct Test {
    /// What is asked of a row.
    pub criterion: &'static str,
    /// The test.
    pub passes: fn(&Row) -> bool,
}

/// The tests, in the order of the report page.
pub const TESTS: [Test; 10] = [
    Test {
        criterion: "zenith x ≤ 1 and y ≤ 1",
        passes: |r| r.zenith_x <= 1.0 && r.zenith_y <= 1.0,
    },
    Test {
        criterion: "zenith x + y ≤ 1",
        passes: |r| r.zenith_x + r.zenith_y <= 1.0,
    },
    Test {
        criterion: "zenith chromaticity inside the spectral locus",
        passes: Row::zenith_is_a_color,
    },
    Test {
        criterion: "zenith x ≤ 0.5 and y ≤ 0.5",
        passes: |r| r.zenith_x <= 0.5 && r.zenith_y <= 0.5,
    },
    Test {
        criterion: "B ≤ 0, so that F is finite at the horizon",
        passes: Row::is_finite,
    },
    Test {
        criterion: "F relative to the zenith positive and computable over the dome (to 89.9°)",
        passes: Row::is_positive,
    },
    Test {
        criterion: "finite and positive",
        passes: |r| r.is_finite() && r.is_positive(),
    },
    Test {
        criterion: "finite, positive, brightest/darkest below 10 000",
        passes: |r| r.is_finite() && r.is_positive() && r.has_possible_contrast(),
    },
    Test {
        criterion: "finite, positive, chromaticity inside the locus",
        passes: |r| r.is_finite() && r.is_positive() && r.zenith_is_a_color(),
    },
    Test {
        criterion: "all of these together",
        passes: |r| {
            r.is_finite() && r.is_positive() && r.zenith_is_a_color() && r.has_possible_contrast()
        },
    },
];

/// How many of the 75 rows pass each test, in the order of [`TESTS`].
#[must_use]
pub fn audit() -> [usize; TESTS.len()] {
    TESTS.map(|test| rows().iter().filter(|row| (test.passes)(row)).count())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_is_a_color_and_an_impossible_red_is_none() {
        assert!(is_a_color(1.0 / 3.0, 1.0 / 3.0));
        assert!(is_a_color(0.3127, 0.3290));
        assert!(!is_a_color(0.8, 0.3));
        assert!(!is_a_color(0.1, 0.1));
    }

    #[test]
    fn few_rows_of_the_printed_table_can_be() {
        assert_eq!(audit(), [29, 23, 19, 14, 17, 33, 13, 10, 6, 5]);
    }
}
