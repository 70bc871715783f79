//! Quantities that carry their unit, and the only unit conversions of the project.

use serde::{Deserialize, Serialize};

/// Radius of the spherical Earth \[km\]; the reference optics define it.
pub const EARTH_RADIUS_KM: f64 = 6371.0;

/// Luminous efficacy constant K \[lm·W⁻¹\] of the CIE 1931 2° observer's integrals.
pub const LUMINOUS_EFFICACY_LM_PER_W: f64 = 683.002;

/// To the precision of the runtime.
#[must_use]
#[expect(clippy::cast_possible_truncation, reason = "the runtime works in f32")]
pub const fn single(x: f64) -> f32 {
    x as f32
}

/// A plane angle, stored in radians.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd, Serialize, Deserialize)]
pub struct Angle(f64);

impl Angle {
    /// Zero.
    pub const ZERO: Self = Self(0.0);

    /// From radians.
    #[must_use]
    pub const fn from_radians(radians: f64) -> Self {
        Self(radians)
    }

    /// From degrees.
    #[must_use]
    pub const fn from_degrees(degrees: f64) -> Self {
        Self(degrees * (core::f64::consts::PI / 180.0))
    }

    /// In radians.
    #[must_use]
    pub const fn radians(self) -> f64 {
        self.0
    }

    /// In degrees.
    #[must_use]
    pub const fn degrees(self) -> f64 {
        self.0 * (180.0 / core::f64::consts::PI)
    }
}

/// A length, stored in metres.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd, Serialize, Deserialize)]
pub struct Length(f64);

impl Length {
    /// Zero.
    pub const ZERO: Self = Self(0.0);

    /// From metres.
    #[must_use]
    pub const fn from_m(metres: f64) -> Self {
        Self(metres)
    }

    /// From kilometres.
    #[must_use]
    pub const fn from_km(kilometres: f64) -> Self {
        Self(kilometres * 1e3)
    }

    /// In metres.
    #[must_use]
    pub const fn m(self) -> f64 {
        self.0
    }

    /// In kilometres.
    #[must_use]
    pub const fn km(self) -> f64 {
        self.0 * 1e-3
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn degrees_and_kilometres_round_trip() {
        for v in [-30.0, 0.0, 12.5, 96.0] {
            assert!((Angle::from_degrees(v).degrees() - v).abs() < 1e-12);
            assert!((Length::from_km(v).km() - v).abs() < 1e-12);
        }
        assert!((Angle::from_degrees(180.0).radians() - core::f64::consts::PI).abs() < 1e-15);
    }
}
