//! What a sky depends on besides the direction of view, and where a model is valid.

use crate::direction::horizon_zenith;
use crate::quantity::{Angle, Length};
use serde::{Deserialize, Serialize};

/// What the sky depends on besides the direction of view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conditions {
    /// Altitude of the observer above mean sea level.
    pub observer_altitude: Length,
    /// Turbidity T = 1 + `aerosol_optical_depth_500` / 0.14344 (the report's Eq. 2.8), at least 1.
    pub turbidity: f64,
    /// Zenith angle of the sun; exceeds 90° in twilight.
    pub sun_zenith: Angle,
}

/// Where a model claims to be valid. Bounds are inclusive.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Domain {
    /// Lowest and highest observer altitude \[km\].
    pub altitude_km: [f64; 2],
    /// Lowest and highest turbidity.
    pub turbidity: [f64; 2],
    /// Lowest and highest sun zenith angle \[deg\].
    pub sun_zenith_deg: [f64; 2],
    /// Whether directions below the horizontal, down to the geometric horizon, are covered.
    pub below_horizontal: bool,
}

/// A condition outside a model's domain: which, what was given, what is accepted.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{quantity}: {found} is outside {}..{}", expected[0], expected[1])]
pub struct OutsideDomain {
    /// The quantity, with its unit.
    pub quantity: &'static str,
    /// The value given.
    pub found: f64,
    /// The bounds.
    pub expected: [f64; 2],
}

impl Domain {
    /// View zenith angle of the lowest directions that are covered \[deg\]: the geometric horizon's, or
    /// the horizontal's.
    #[must_use]
    pub fn lowest_view_zenith_deg(&self, observer_altitude: Length) -> f64 {
        if self.below_horizontal {
            horizon_zenith(observer_altitude).degrees()
        } else {
            90.0
        }
    }

    /// Checks conditions against the domain.
    ///
    /// # Errors
    /// Names the first quantity that lies outside (NaN lies outside).
    pub fn check(&self, conditions: &Conditions) -> Result<(), OutsideDomain> {
        let table = [
            (
                "observer altitude [km]",
                conditions.observer_altitude.km(),
                self.altitude_km,
            ),
            ("turbidity", conditions.turbidity, self.turbidity),
            (
                "sun zenith [deg]",
                conditions.sun_zenith.degrees(),
                self.sun_zenith_deg,
            ),
        ];
        for (quantity, found, expected) in table {
            // Degrees and kilometres were converted; a value on a bound must stay inside.
            let slack = 1e-9 * expected[1].abs().max(1.0);
            if !(found >= expected[0] - slack && found <= expected[1] + slack) {
                return Err(OutsideDomain {
                    quantity,
                    found,
                    expected,
                });
            }
        }
        Ok(())
    }
}
