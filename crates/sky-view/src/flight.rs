//! Where the observer is, where the sun stands, and how hazy the air is: what a window shows, without
//! the window. Keys and seconds in, the conditions of a sky out.
//!
//! What lies beyond the table's domain stops at its edge, and [`Asked::within`] says so: nothing is
//! clamped in silence. Simplifications: the sun is that of one place, wherever one flies; no inertia.

use glam::Mat3;
use sky_core::conditions::{Conditions, Domain};
use sky_core::haze::{
    Haze, HazeError, optical_depth_500_from_turbidity, turbidity_from_optical_depth_500,
    visual_range_from_optical_depth_500,
};
use sky_core::quantity::{Angle, Length};
use sky_core::solar_position::{GeoPlace, SolarPositionError, SunPosition, UtcTime, sun_position};
use sky_render::{looking, world_direction};

/// Least height of the eye above the ground \[km\].
pub const EYE_KM: f64 = 0.002;
/// Steepest look up or down \[deg\].
const STEEPEST_DEG: f64 = 89.0;
/// How much faster with the shift key.
const FAST: f64 = 8.0;
/// Slowest and fastest flight \[km/s\].
pub const SPEEDS_KM_S: [f64; 2] = [0.005, 20.0];

/// The keys that are held.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Keys {
    /// W or up.
    pub forward: bool,
    /// S or down.
    pub back: bool,
    /// A or left.
    pub left: bool,
    /// D or right.
    pub right: bool,
    /// E or page up.
    pub up: bool,
    /// Q or page down.
    pub down: bool,
    /// Shift.
    pub fast: bool,
}

/// The observer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flight {
    /// East and north of the start \[km\].
    pub place_km: [f64; 2],
    /// Altitude above mean sea level \[km\].
    pub altitude_km: f64,
    /// Where one looks: azimuth clockwise from north, and elevation \[deg\].
    pub look_deg: [f64; 2],
    /// Speed without the shift key \[km/s\].
    pub speed_km_s: f64,
}

impl Flight {
    /// Flies for some seconds, along the look and up or down. The altitude may leave the table's
    /// domain here; who shows it stops it there, visibly.
    pub fn step(&mut self, keys: Keys, seconds: f64) {
        let axis = |plus: bool, minus: bool| f64::from(u8::from(plus)) - f64::from(u8::from(minus));
        let ahead = axis(keys.forward, keys.back);
        let right = axis(keys.right, keys.left);
        let up = axis(keys.up, keys.down);
        let length = (ahead * ahead + right * right + up * up).sqrt();
        if length == 0.0 {
            return;
        }
        let fast = if keys.fast { FAST } else { 1.0 };
        let way = self.speed_km_s * fast * seconds / length;
        let [azimuth, elevation] = self.look_deg.map(Angle::from_degrees);
        let forward = world_direction(azimuth, elevation).as_dvec3();
        let (sine, cosine) = azimuth.radians().sin_cos();
        self.place_km[0] += way * (ahead * forward[0] + right * cosine);
        self.place_km[1] += way * (ahead * forward[1] - right * sine);
        self.altitude_km += way * (ahead * forward[2] + up);
    }

    /// Turns the look to the right and up.
    pub fn turn(&mut self, right_deg: f64, up_deg: f64) {
        let [azimuth, elevation] = &mut self.look_deg;
        *azimuth = (*azimuth + right_deg).rem_euclid(360.0);
        *elevation = (*elevation + up_deg).clamp(-STEEPEST_DEG, STEEPEST_DEG);
    }

    /// Makes the flight faster or slower.
    pub fn change_speed(&mut self, factor: f64) {
        self.speed_km_s = (self.speed_km_s * factor).clamp(SPEEDS_KM_S[0], SPEEDS_KM_S[1]);
    }

    /// The view: rows right, up, backward.
    #[must_use]
    pub fn view_from_world(&self) -> Mat3 {
        looking(self.look_deg[0], self.look_deg[1])
    }
}

/// Where the sun's place comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sun {
    /// It is given.
    Angles(SunPosition),
    /// It follows from a moment and a place, and moves.
    Clock {
        /// The moment.
        time: UtcTime,
        /// The place.
        place: GeoPlace,
        /// Hours a second.
        hours_per_s: f64,
    },
}

impl Sun {
    /// Lets time pass.
    pub fn step(&mut self, seconds: f64) {
        if let Self::Clock {
            time, hours_per_s, ..
        } = self
        {
            // a year at the most, from the date that was given
            time.hours = (time.hours + seconds * *hours_per_s).rem_euclid(24.0 * 365.0);
        }
    }

    /// Where it stands.
    ///
    /// # Errors
    /// When the date or the place cannot be.
    pub fn position(&self) -> Result<SunPosition, SolarPositionError> {
        match *self {
            Self::Angles(position) => Ok(position),
            Self::Clock { time, place, .. } => sun_position(time, place),
        }
    }
}

/// A word for haze.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HazeWord {
    /// Turbidity.
    Turbidity,
    /// Vertical aerosol optical depth at 500 nm.
    OpticalDepth,
    /// Visual range \[km\].
    VisualRange,
}

impl HazeWord {
    /// Every word with its name and unit.
    pub const ALL: [(Self, &'static str); 3] = [
        (Self::Turbidity, "turbidity"),
        (Self::OpticalDepth, "optical depth, 500 nm"),
        (Self::VisualRange, "visual range [km]"),
    ];

    /// The haze of a number in this word.
    #[must_use]
    pub const fn haze(self, value: f64) -> Haze {
        match self {
            Self::Turbidity => Haze::Turbidity(value),
            Self::OpticalDepth => Haze::OpticalDepth500(value),
            Self::VisualRange => Haze::VisualRange(Length::from_km(value)),
        }
    }

    /// The number in this word for a turbidity. The inverse of [`Self::haze`].
    #[must_use]
    pub fn value(self, turbidity: f64) -> f64 {
        let optical_depth = optical_depth_500_from_turbidity(turbidity);
        match self {
            Self::Turbidity => turbidity_from_optical_depth_500(optical_depth),
            Self::OpticalDepth => optical_depth,
            Self::VisualRange => visual_range_from_optical_depth_500(optical_depth).km(),
        }
    }
}

/// What a sky is asked for, before the table's domain is looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Asked {
    /// The observer's altitude \[km\].
    pub altitude_km: f64,
    /// The haze.
    pub haze: Haze,
    /// The sun.
    pub sun: SunPosition,
}

/// A condition that was stopped at the edge of the table's domain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// The quantity, with its unit.
    pub quantity: &'static str,
    /// What was asked for.
    pub asked: f64,
    /// Where it stopped.
    pub edge: f64,
}

/// Conditions inside the domain, and where they were stopped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shown {
    /// What the sky is shown for.
    pub conditions: Conditions,
    /// Of altitude, turbidity and sun zenith: what was stopped.
    pub edges: [Option<Edge>; 3],
}

impl Asked {
    /// Stops at the domain's edge what lies beyond it.
    ///
    /// # Errors
    /// When the haze cannot be.
    pub fn within(&self, domain: &Domain) -> Result<Shown, HazeError> {
        let stop = |quantity, asked: f64, [low, high]: [f64; 2]| {
            let edge = asked.clamp(low, high);
            // degrees and kilometers were converted
            let is_beyond = (asked - edge).abs() > 1e-9 * high.abs().max(1.0);
            let stopped = is_beyond.then_some(Edge {
                quantity,
                asked,
                edge,
            });
            (edge, stopped)
        };
        let (altitude, a) = stop("altitude [km]", self.altitude_km, domain.altitude_km);
        let (turbidity, t) = stop("turbidity", self.haze.turbidity()?, domain.turbidity);
        let zenith = self.sun.zenith.degrees();
        let (sun, s) = stop("sun zenith [deg]", zenith, domain.sun_zenith_deg);
        Ok(Shown {
            conditions: Conditions {
                observer_altitude: Length::from_km(altitude),
                turbidity,
                sun_zenith: Angle::from_degrees(sun),
            },
            edges: [a, t, s],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sky_core::haze::STRATOSPHERIC_OPTICAL_DEPTH_500;

    const DOMAIN: Domain = Domain {
        altitude_km: [0.0, 30.0],
        turbidity: [1.0, 8.0],
        sun_zenith_deg: [0.0, 96.0],
        below_horizontal: true,
    };

    const fn flight(azimuth: f64, elevation: f64) -> Flight {
        Flight {
            place_km: [0.0; 2],
            altitude_km: 1.0,
            look_deg: [azimuth, elevation],
            speed_km_s: 0.25,
        }
    }

    const fn sun(zenith: f64) -> SunPosition {
        SunPosition {
            zenith: Angle::from_degrees(zenith),
            azimuth: Angle::from_degrees(180.0),
        }
    }

    #[test]
    fn keys_move_along_the_look() {
        let forward = Keys {
            forward: true,
            ..Keys::default()
        };
        let mut east = flight(90.0, 0.0);
        east.step(forward, 4.0);
        assert!((east.place_km[0] - 1.0).abs() < 1e-6 && east.place_km[1].abs() < 1e-6);
        assert!((east.altitude_km - 1.0).abs() < 1e-6);
        let right = Keys {
            right: true,
            ..Keys::default()
        };
        let mut south = flight(90.0, 30.0);
        south.step(right, 4.0);
        assert!((south.place_km[1] + 1.0).abs() < 1e-6, "{south:?}");
        let mut climb = flight(0.0, 30.0);
        climb.step(
            Keys {
                fast: true,
                ..forward
            },
            1.0,
        );
        assert!((climb.altitude_km - 1.0 - 0.25 * FAST * 0.5).abs() < 1e-6);
        // two keys are no faster than one, opposite ones stand still
        let mut both = flight(0.0, 0.0);
        both.step(
            Keys {
                right: true,
                ..forward
            },
            4.0,
        );
        assert!((both.place_km[0].hypot(both.place_km[1]) - 1.0).abs() < 1e-6);
        let mut still = flight(10.0, 5.0);
        still.step(
            Keys {
                back: true,
                ..forward
            },
            4.0,
        );
        assert_eq!(still, flight(10.0, 5.0));
    }

    #[test]
    fn the_look_turns_all_round_and_stops_at_the_zenith() {
        let mut look = flight(350.0, 0.0);
        look.turn(20.0, 200.0);
        assert!((look.look_deg[0] - 10.0).abs() < 1e-9);
        assert!((look.look_deg[1] - STEEPEST_DEG).abs() < 1e-9);
    }

    #[test]
    fn a_clock_moves_the_sun() {
        let mut sun = Sun::Clock {
            time: UtcTime {
                year: 2025,
                month: 6,
                day: 21,
                hours: 6.0,
            },
            place: GeoPlace {
                latitude: Angle::from_degrees(47.26),
                longitude: Angle::from_degrees(11.34),
                altitude: Length::ZERO,
            },
            hours_per_s: 0.5,
        };
        let morning = sun.position().expect("a sun").zenith;
        sun.step(10.0);
        let noon = sun.position().expect("a sun").zenith;
        assert!(morning.degrees() - noon.degrees() > 30.0);
        assert!((noon.degrees() - 23.9).abs() < 0.5, "{noon:?}");
    }

    #[test]
    fn what_lies_beyond_the_table_stops_at_its_edge_and_says_so() {
        let asked = Asked {
            altitude_km: 31.0,
            haze: Haze::Turbidity(20.0),
            sun: sun(110.0),
        };
        let shown = asked.within(&DOMAIN).expect("a haze");
        assert!(DOMAIN.check(&shown.conditions).is_ok());
        for (edge, (found, stopped)) in
            shown
                .edges
                .iter()
                .zip([(31.0, 30.0), (20.0, 8.0), (110.0, 96.0)])
        {
            let edge = edge.expect("an edge");
            assert!((edge.asked - found).abs() < 1e-6 && (edge.edge - stopped).abs() < 1e-6);
        }
        let inside = Asked {
            altitude_km: 30.0,
            haze: Haze::Turbidity(1.0),
            sun: sun(96.0),
        };
        let shown = inside.within(&DOMAIN).expect("a haze");
        assert_eq!(shown.edges, [None; 3]);
        let wrong = Asked {
            haze: Haze::Turbidity(0.5),
            ..inside
        };
        assert!(wrong.within(&DOMAIN).is_err());
    }

    #[test]
    fn words_for_haze_are_inverse_to_their_numbers() {
        for n in [2_u32, 32, 257] {
            for i in 0..n {
                let turbidity = 1.0 + 7.0 * f64::from(i) / f64::from(n - 1);
                for (word, name) in HazeWord::ALL {
                    let back = word.haze(word.value(turbidity)).turbidity().expect(name);
                    // the aerosol of the stratosphere shortens no visual range at the ground
                    let least = match word {
                        HazeWord::VisualRange => {
                            turbidity_from_optical_depth_500(STRATOSPHERIC_OPTICAL_DEPTH_500)
                        }
                        _ => 1.0,
                    };
                    assert!((back - turbidity.max(least)).abs() < 1e-9, "{name}: {back}");
                }
            }
        }
    }
}
