//! What a sky depends on besides the direction of view, and where a model is valid.

use core::fmt;

use serde::{Deserialize, Serialize};

use crate::direction::horizon_zenith;
use crate::haze::{
    Haze, HazeError, angstrom_beta_from_optical_depth_500, optical_depth_500_from_turbidity,
    visual_range_from_optical_depth_500,
};
use crate::quantity::{Angle, Length};

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

impl Conditions {
    /// From the observer's altitude, the haze in any word and the sun's zenith angle.
    ///
    /// # Errors
    /// When the haze cannot be.
    pub fn new(
        observer_altitude: Length,
        haze: Haze,
        sun_zenith: Angle,
    ) -> Result<Self, HazeError> {
        Ok(Self {
            observer_altitude,
            turbidity: haze.turbidity()?,
            sun_zenith,
        })
    }
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

/// What may lie outside a model's domain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Quantity {
    /// Altitude of the observer \[km\].
    ObserverAltitude,
    /// Turbidity.
    Turbidity,
    /// Vertical optical depth of the aerosol at 500 nm.
    AerosolOpticalDepth500,
    /// Ångström's turbidity β.
    AngstromBeta,
    /// Visual range \[km\].
    VisualRange,
    /// Zenith angle of the sun \[deg\].
    SunZenith,
}

impl Quantity {
    /// The name, with the unit of its numbers.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::ObserverAltitude => "observer altitude [km]",
            Self::Turbidity => "turbidity",
            Self::AerosolOpticalDepth500 => "aerosol optical depth at 500 nm",
            Self::AngstromBeta => "Angstrom turbidity beta",
            Self::VisualRange => "visual range [km]",
            Self::SunZenith => "sun zenith [deg]",
        }
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A condition outside a model's domain: which, what was given, what is accepted.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{quantity}: {found} is outside {}..{}", expected[0], expected[1])]
pub struct OutsideDomain {
    /// The quantity; it says the unit of the numbers.
    pub quantity: Quantity,
    /// The value given.
    pub found: f64,
    /// The bounds.
    pub expected: [f64; 2],
}

impl OutsideDomain {
    /// The same in the words in which the haze was given: who asked for a visual range reads one. Bounds
    /// that are converted have three digits and lie within the domain.
    #[must_use]
    pub fn in_words_of(self, haze: Haze) -> Self {
        if self.quantity != Quantity::Turbidity {
            return self;
        }
        let bounds = self.expected.map(optical_depth_500_from_turbidity);
        let (quantity, found, bounds) = match haze {
            Haze::Turbidity(_) => return self,
            Haze::OpticalDepth500(found) => (Quantity::AerosolOpticalDepth500, found, bounds),
            Haze::Angstrom { beta, alpha } => (
                Quantity::AngstromBeta,
                beta,
                bounds.map(|depth| angstrom_beta_from_optical_depth_500(depth, alpha)),
            ),
            Haze::VisualRange(found) => {
                let [least, largest] = bounds.map(|d| visual_range_from_optical_depth_500(d).km());
                (Quantity::VisualRange, found.km(), [largest, least])
            }
        };
        Self {
            quantity,
            found,
            expected: [
                three_digits(bounds[0], f64::ceil),
                three_digits(bounds[1], f64::floor),
            ],
        }
    }
}

/// A number with three significant digits.
fn three_digits(value: f64, round: fn(f64) -> f64) -> f64 {
    if value == 0.0 || !value.is_finite() {
        return value;
    }
    // dividing by a power of ten that f64 holds exactly leaves the shortest decimal
    let digits = 2.0 - value.abs().log10().floor();
    if digits >= 0.0 {
        let scale = 10.0_f64.powf(digits);
        round(value * scale) / scale
    } else {
        let scale = 10.0_f64.powf(-digits);
        round(value / scale) * scale
    }
}

/// The valid conditions nearest to those asked for, and what had to be changed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// Conditions inside the domain.
    pub conditions: Conditions,
    changes: [Option<OutsideDomain>; 3],
}

impl Nearest {
    /// What lay outside, each with the value asked for and the bounds; nothing where the conditions are
    /// those asked for.
    pub fn changes(&self) -> impl Iterator<Item = &OutsideDomain> {
        self.changes.iter().flatten()
    }
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

    /// Each condition with what is accepted.
    fn bounds(&self, conditions: &Conditions) -> [OutsideDomain; 3] {
        [
            (
                Quantity::ObserverAltitude,
                conditions.observer_altitude.km(),
                self.altitude_km,
            ),
            (Quantity::Turbidity, conditions.turbidity, self.turbidity),
            (
                Quantity::SunZenith,
                conditions.sun_zenith.degrees(),
                self.sun_zenith_deg,
            ),
        ]
        .map(|(quantity, found, expected)| OutsideDomain {
            quantity,
            found,
            expected,
        })
    }

    /// Checks conditions against the domain.
    ///
    /// # Errors
    /// Names the first quantity that lies outside (NaN lies outside).
    pub fn check(&self, conditions: &Conditions) -> Result<(), OutsideDomain> {
        match self.bounds(conditions).into_iter().find(|b| !b.holds()) {
            Some(outside) => Err(outside),
            None => Ok(()),
        }
    }

    /// The nearest conditions that pass [`Self::check`], and which of them had to be changed: to clamp is
    /// the caller's choice, and visible.
    ///
    /// # Errors
    /// What is not a number has no neighbor.
    pub fn nearest(&self, conditions: &Conditions) -> Result<Nearest, OutsideDomain> {
        let bounds = self.bounds(conditions);
        if let Some(outside) = bounds.iter().find(|b| b.found.is_nan()) {
            return Err(*outside);
        }
        let mut nearest = *conditions;
        let changes = bounds.map(|b| (!b.holds()).then_some(b));
        for outside in changes.iter().flatten() {
            let edge = outside
                .found
                .clamp(outside.expected[0], outside.expected[1]);
            match outside.quantity {
                Quantity::ObserverAltitude => nearest.observer_altitude = Length::from_km(edge),
                Quantity::SunZenith => nearest.sun_zenith = Angle::from_degrees(edge),
                _ => nearest.turbidity = edge,
            }
        }
        Ok(Nearest {
            conditions: nearest,
            changes,
        })
    }
}

impl OutsideDomain {
    /// Whether the value lies inside after all.
    fn holds(&self) -> bool {
        // Degrees and kilometers were converted; a value on a bound must stay inside.
        let [low, high] = self.expected;
        let slack = 1e-9 * high.abs().max(1.0);
        self.found >= low - slack && self.found <= high + slack
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DOMAIN: Domain = Domain {
        altitude_km: [0.0, 30.0],
        turbidity: [1.0, 8.0],
        sun_zenith_deg: [0.0, 96.0],
        below_horizontal: true,
    };

    fn conditions(altitude_km: f64, turbidity: f64, sun_zenith_deg: f64) -> Conditions {
        Conditions {
            observer_altitude: Length::from_km(altitude_km),
            turbidity,
            sun_zenith: Angle::from_degrees(sun_zenith_deg),
        }
    }

    #[test]
    fn b1_a_visual_range_outside_is_answered_in_kilometers() {
        let haze = Haze::VisualRange(Length::from_km(3.0));
        let turbidity = haze.turbidity().unwrap();
        let outside = DOMAIN.check(&conditions(0.0, turbidity, 30.0)).unwrap_err();
        let told = outside.in_words_of(haze);
        assert_eq!(told.quantity, Quantity::VisualRange);
        // the bounds that are told are accepted
        for km in told.expected {
            let turbidity = Haze::VisualRange(Length::from_km(km)).turbidity().unwrap();
            assert_eq!(DOMAIN.check(&conditions(0.0, turbidity, 30.0)), Ok(()));
        }
        let message = told.to_string();
        assert!(
            message.starts_with("visual range [km]: 3 is outside 5.") && message.ends_with("..333"),
            "{message}"
        );
    }

    #[test]
    fn the_haze_is_answered_in_its_own_words_and_nothing_else_is() {
        let depth = Haze::OpticalDepth500(1.5);
        let angstrom = Haze::Angstrom {
            beta: 0.9,
            alpha: 1.3,
        };
        for (haze, expected) in [
            (Haze::Turbidity(11.0), "turbidity: 11 is outside 1..8"),
            (
                depth,
                "aerosol optical depth at 500 nm: 1.5 is outside 0..1",
            ),
            (angstrom, "Angstrom turbidity beta: 0.9 is outside 0..0.407"),
        ] {
            let turbidity = haze.turbidity().unwrap();
            let outside = DOMAIN.check(&conditions(0.0, turbidity, 30.0)).unwrap_err();
            assert_eq!(outside.in_words_of(haze).to_string(), expected);
        }
        let high = DOMAIN.check(&conditions(31.0, 2.0, 30.0)).unwrap_err();
        assert_eq!(high.in_words_of(depth), high);
    }

    #[test]
    fn the_nearest_conditions_are_valid_and_say_what_was_changed() {
        let nearest = |c| DOMAIN.nearest(&c).unwrap();
        let inside = conditions(3.0, 2.0, 60.0);
        assert_eq!(nearest(inside).conditions, inside);
        assert_eq!(nearest(inside).changes().count(), 0);
        let moved = nearest(conditions(f64::INFINITY, 0.5, 101.7));
        assert_eq!(DOMAIN.check(&moved.conditions), Ok(()));
        assert!((moved.conditions.sun_zenith.degrees() - 96.0).abs() < 1e-9);
        let told: Vec<_> = moved.changes().map(|c| c.quantity).collect();
        let all = [
            Quantity::ObserverAltitude,
            Quantity::Turbidity,
            Quantity::SunZenith,
        ];
        assert_eq!(told, all);
        let only_sun = nearest(conditions(3.0, 2.0, 101.7));
        assert_eq!(only_sun.changes().count(), 1);
        assert!(DOMAIN.nearest(&conditions(3.0, f64::NAN, 60.0)).is_err());
    }

    #[test]
    fn bounds_are_inside_and_what_is_not_a_number_is_outside() {
        for c in [conditions(30.0, 8.0, 96.0), conditions(0.0, 1.0, 0.0)] {
            assert_eq!(DOMAIN.check(&c), Ok(()));
        }
        for c in [
            conditions(30.001, 8.0, 96.0),
            conditions(30.0, 8.001, 96.0),
            conditions(30.0, 8.0, f64::NAN),
        ] {
            assert!(DOMAIN.check(&c).is_err());
        }
    }
}
