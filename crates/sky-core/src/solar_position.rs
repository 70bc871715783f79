//! Where the sun stands at a date, a time and a place.
//!
//! The algorithm is that of Reda & Andreas 2004 (SPA, ±0.0003°), from the package
//! `solar-positioning`. Angles are true ones, without refraction, as everywhere in this project.
//! Universal time is taken as UTC, and its distance from the time of the planets as constant. Out of
//! scope: time zones, the equation of clocks, sunrise.

use solar_positioning::time::JulianDate;
use solar_positioning::{Location, SolarPositions};
use thiserror::Error;

use crate::quantity::single;
use crate::quantity::{Angle, Length};

/// Difference of terrestrial and universal time \[s\], 2015–2030 to a second or two. Of the sun's way
/// across the sky a wrong minute here is 0.001°.
const DELTA_T_S: f64 = 69.0;

/// Years for which the constant is near enough.
pub const YEARS: [i32; 2] = [1900, 2100];

/// A moment in universal time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UtcTime {
    /// Year of the Gregorian calendar, [`YEARS`].
    pub year: i32,
    /// Month, 1–12.
    pub month: u32,
    /// Day of the month, from 1.
    pub day: u32,
    /// Hours since midnight UTC; may be negative or exceed 24, for the days before and after.
    pub hours: f64,
}

/// A place on Earth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GeoPlace {
    /// Latitude, north positive, −90…90°.
    pub latitude: Angle,
    /// Longitude, east positive, −180…180°.
    pub longitude: Angle,
    /// Altitude above mean sea level; it moves the sun by its parallax, 0.001° from 300 km.
    pub altitude: Length,
}

/// The sun's direction at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SunPosition {
    /// Zenith angle of the sun's center, without refraction; above 90° at night.
    pub zenith: Angle,
    /// Azimuth, clockwise from north.
    pub azimuth: Angle,
}

/// A moment or place that cannot be.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum SolarPositionError {
    /// A year too far away.
    #[error("year: expected {} to {}, found {found}", YEARS[0], YEARS[1])]
    Year {
        /// The value given.
        found: i32,
    },
    /// No day of the calendar.
    #[error("date: expected a day of the calendar, found {year:04}-{month:02}-{day:02}")]
    Date {
        /// The year given.
        year: i32,
        /// The month given.
        month: u32,
        /// The day given.
        day: u32,
    },
    /// A number outside its bounds.
    #[error("{quantity}: expected a number from {} to {}, found {found}", expected[0], expected[1])]
    Outside {
        /// The quantity, with its unit.
        quantity: &'static str,
        /// The value given.
        found: f64,
        /// The bounds.
        expected: [f64; 2],
    },
}

impl UtcTime {
    /// Midnight of a date in the form `YYYY-MM-DD`; `None` for a text of another form. Whether there
    /// is such a day, [`sun_position`] says.
    #[must_use]
    pub fn from_date(text: &str) -> Option<Self> {
        let mut parts = text.split('-');
        let (year, month, day) = (parts.next()?, parts.next()?, parts.next()?);
        if parts.next().is_some() {
            return None;
        }
        Some(Self {
            year: year.parse().ok()?,
            month: month.parse().ok()?,
            day: day.parse().ok()?,
            hours: 0.0,
        })
    }

    fn julian_date(self) -> Result<JulianDate, SolarPositionError> {
        let Self {
            year, month, day, ..
        } = self;
        if !(YEARS[0]..=YEARS[1]).contains(&year) {
            return Err(SolarPositionError::Year { found: year });
        }
        let no_day = |_| SolarPositionError::Date { year, month, day };
        // a year on either side leaves no bound of the algorithm near
        let hours = within("time [h]", self.hours, [-8784.0, 8784.0])?;
        let midnight =
            JulianDate::from_utc(year, month, day, 0, 0, 0.0, DELTA_T_S).map_err(no_day)?;
        JulianDate::new(midnight.julian_date() + hours / 24.0, DELTA_T_S).map_err(no_day)
    }
}

fn within(
    quantity: &'static str,
    found: f64,
    expected: [f64; 2],
) -> Result<f64, SolarPositionError> {
    // degrees were converted; a value on a bound must stay inside
    let slack = 1e-9 * expected[1];
    if !(found >= expected[0] - slack && found <= expected[1] + slack) {
        return Err(SolarPositionError::Outside {
            quantity,
            found,
            expected,
        });
    }
    Ok(found.clamp(expected[0], expected[1]))
}

/// The sun's true (unrefracted) place in the sky.
///
/// # Errors
/// When the day is none of the calendar, or a number is outside its bounds.
pub fn sun_position(time: UtcTime, place: GeoPlace) -> Result<SunPosition, SolarPositionError> {
    let location = Location {
        latitude: within("latitude [deg]", place.latitude.degrees(), [-90.0, 90.0])?,
        longitude: within(
            "longitude [deg]",
            place.longitude.degrees(),
            [-180.0, 180.0],
        )?,
    };
    let altitude_m = within("altitude [m]", place.altitude.m(), [-1e3, 1e6])?;
    let sun = SolarPositions::new()
        .at_from_julian(time.julian_date()?, location, altitude_m, None)
        // everything that it refuses has been refused above
        .map_err(|_| SolarPositionError::Date {
            year: time.year,
            month: time.month,
            day: time.day,
        })?;
    Ok(SunPosition {
        zenith: Angle::from_degrees(sun.zenith_angle()),
        azimuth: Angle::from_degrees(sun.azimuth()),
    })
}

impl SunPosition {
    /// The direction toward the sun as a unit vector: east, north, up.
    #[must_use]
    pub fn east_north_up(&self) -> [f32; 3] {
        let (sin_zenith, cos_zenith) = self.zenith.radians().sin_cos();
        let (sin_azimuth, cos_azimuth) = self.azimuth.radians().sin_cos();
        [
            single(sin_zenith * sin_azimuth),
            single(sin_zenith * cos_azimuth),
            single(cos_zenith),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn place(latitude_deg: f64, longitude_deg: f64, altitude_m: f64) -> GeoPlace {
        GeoPlace {
            latitude: Angle::from_degrees(latitude_deg),
            longitude: Angle::from_degrees(longitude_deg),
            altitude: Length::from_m(altitude_m),
        }
    }

    const fn time(year: i32, month: u32, day: u32, hours: f64) -> UtcTime {
        UtcTime {
            year,
            month,
            day,
            hours,
        }
    }

    /// Source: Reda & Andreas 2004 (NREL/TP-560-34302), appendix A.5: 17 October 2003, 12:30:30 at
    /// UTC − 7 h, ΔT 67 s. Their topocentric zenith angle before refraction is 90° − 39.872046°
    /// (e₀), the azimuth 194.34024°.
    #[test]
    fn the_example_of_the_algorithm_s_authors() {
        let hours = 19.0 + 30.0 / 60.0 + 30.0 / 3600.0;
        let sun = sun_position(
            time(2003, 10, 17, hours),
            place(39.742_476, -105.178_6, 1830.14),
        )
        .expect("a sun");
        assert!((sun.zenith.degrees() - (90.0 - 39.872_046)).abs() < 2e-4);
        assert!((sun.azimuth.degrees() - 194.340_24).abs() < 2e-4);
    }

    #[test]
    fn the_sun_stands_south_at_noon_and_hours_go_on_past_midnight() {
        // Greenwich at the June solstice: 51.48° − 23.44° from the zenith
        let greenwich = place(51.48, 0.0, 0.0);
        let noon = sun_position(time(2025, 6, 21, 12.03), greenwich).expect("a sun");
        assert!((noon.zenith.degrees() - 28.04).abs() < 0.02, "{noon:?}");
        assert!((noon.azimuth.degrees() - 180.0).abs() < 1.0, "{noon:?}");
        let [east, north, up] = noon.east_north_up();
        assert!(east.abs() < 0.01 && (north + 0.470).abs() < 1e-3 && (up - 0.8826).abs() < 1e-3);
        let a = sun_position(time(2025, 6, 21, 26.0), greenwich).expect("a sun");
        let b = sun_position(time(2025, 6, 22, 2.0), greenwich).expect("a sun");
        assert!((a.zenith.degrees() - b.zenith.degrees()).abs() < 1e-6);
        assert!(a.zenith.degrees() > 90.0, "night");
    }

    #[test]
    fn what_cannot_be_is_refused_by_name() {
        let here = place(47.0, 11.0, 0.0);
        for (moment, there, words) in [
            (
                time(2025, 2, 30, 0.0),
                here,
                "date: expected a day of the calendar, found 2025-02-30",
            ),
            (
                time(1700, 1, 1, 0.0),
                here,
                "year: expected 1900 to 2100, found 1700",
            ),
            (
                time(2025, 1, 1, f64::NAN),
                here,
                "time [h]: expected a number from -8784 to 8784, found NaN",
            ),
            (
                time(2025, 1, 1, 0.0),
                place(91.0, 0.0, 0.0),
                "latitude [deg]: expected a number from -90 to 90, found 91",
            ),
            (
                time(2025, 1, 1, 0.0),
                place(0.0, 200.0, 0.0),
                "longitude [deg]: expected a number from -180 to 180, found 200",
            ),
        ] {
            let error = sun_position(moment, there).expect_err(words);
            assert_eq!(error.to_string(), words);
        }
    }

    #[test]
    fn dates_are_read() {
        assert_eq!(
            UtcTime::from_date("2025-06-21"),
            Some(time(2025, 6, 21, 0.0))
        );
        for text in ["", "2025-06", "2025-06-21-1", "2025-June-21", "21.6.2025"] {
            assert_eq!(UtcTime::from_date(text), None, "{text}");
        }
    }

    #[test]
    fn poles_and_date_line_have_a_sun() {
        for latitude in [-90.0, 90.0] {
            for longitude in [-180.0, 180.0] {
                let sun = sun_position(time(2025, 3, 20, 0.0), place(latitude, longitude, 0.0))
                    .expect("a sun");
                assert!((sun.zenith.degrees() - 90.0).abs() < 1.0);
            }
        }
    }
}
