//! The clear sky from the ground to 30 km as a simulator runs it: luminance \[cd·m⁻²\] and color of any
//! direction, the air before objects, and the light on a scene, for any haze and sun.
//!
//! Pure functions in `f32`: no files, no threads, no clock, and no allocation once the table is read.
//! Pixels come from `sky-gpu`; any other engine can take the same numbers.
//!
//! # Simplifications
//! Straight rays; a horizontally uniform atmosphere; one sun zenith angle for a whole path; particles of
//! one kind, whose amount is the turbidity; a ground of one albedo.
//!
//! # Out of scope
//! Clouds, weather, night, polarization, terrain shadows; spectra (`sky-science`), radiative transfer
//! (`sky-sim`), fitting (`sky-fit`).
//!
//! # Words
//! Angles and lengths are types. Zenith angles are measured from straight up and exceed 90° below the
//! horizontal; azimuth 0 faces the sun. As a vector, z is up and the sun stands over positive x.
//! Outside the table's domain everything is an error; [`Domain::nearest`] is for who wants to clamp.
//!
//! # Examples
//! Each is also a program in `examples/`.
//!
//! A sky in three lines:
//! ```
//! use sky_core::{Angle, Conditions, Haze, Length, SkyDirection, UtmSky};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let here = Conditions::new(Length::from_km(10.0), Haze::Turbidity(2.0), Angle::from_degrees(45.0))?;
//! let frame = UtmSky::embedded()?.frame(&here)?;
//! let light = frame.yxy(&SkyDirection::from_degrees(60.0, 90.0)).expect("above the horizon");
//! assert!(light.luminance_cd_m2 > 100.0 && light.luminance_cd_m2 < 2000.0);
//! # Ok(())
//! # }
//! ```
//!
//! The sun from date, time and place:
//! ```
//! use sky_core::{Angle, GeoPlace, Length, UtcTime, sun_position};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let innsbruck = GeoPlace {
//!     latitude: Angle::from_degrees(47.26),
//!     longitude: Angle::from_degrees(11.39),
//!     altitude: Length::from_m(580.0),
//! };
//! let noon = UtcTime { year: 2025, month: 6, day: 21, hours: 11.27 };
//! let sun = sun_position(noon, innsbruck)?;
//! assert!((sun.zenith.degrees() - (47.26 - 23.44)).abs() < 0.1);
//! # Ok(())
//! # }
//! ```
//!
//! Haze in any word, and an answer in the same word:
//! ```
//! use sky_core::{Angle, Conditions, Haze, Length, UtmSky};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let sky = UtmSky::embedded()?;
//! let haze = Haze::VisualRange(Length::from_km(2.0));
//! let fog = Conditions::new(Length::ZERO, haze, Angle::from_degrees(30.0))?;
//! let refusal = sky.frame(&fog).expect_err("thicker than the table knows").in_words_of(haze);
//! assert!(refusal.to_string().starts_with("visual range [km]: 2 is outside"));
//! let nearest = sky.domain().nearest(&fog)?; // to clamp is the caller's choice
//! assert!(nearest.changes().count() == 1 && sky.frame(&nearest.conditions).is_ok());
//! # Ok(())
//! # }
//! ```
//!
//! What a scene is lit with:
//! ```
//! use sky_core::{Angle, Conditions, Haze, Length, Picture, UtmSky, tonemap};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let haze = Haze::OpticalDepth500(0.2);
//! let here = Conditions::new(Length::ZERO, haze, Angle::from_degrees(60.0))?;
//! let light = Picture::new(&UtmSky::embedded()?, &here, 0.2)?.light;
//! let [sun, sky] = [light.sun_normal, light.sky_horizontal].map(tonemap::luminance);
//! assert!(sun > 40_000.0 && sky > 5_000.0 && sky < 20_000.0); // lx
//! # Ok(())
//! # }
//! ```
//!
//! What a finite path of air takes and adds:
//! ```
//! use sky_core::{Angle, Conditions, Haze, Length, Picture, SkyDirection, UtmSky};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let here = Conditions::new(Length::from_km(1.0), Haze::Turbidity(3.0), Angle::from_degrees(40.0))?;
//! let frame = Picture::new(&UtmSky::embedded()?, &here, 0.2)?;
//! let forest = [30.0, 60.0, 20.0]; // linear sRGB [cd/m2]
//! let direction = SkyDirection::from_degrees(91.0, 120.0).unit_vector();
//! let [near, far] = [1.0, 30.0].map(|km| frame.behind_air(direction, km, forest));
//! assert!(far[2] > near[2]); // distance is blue and bright
//! # Ok(())
//! # }
//! ```
//!
//! # Features
//! Both are on by default. `default-table`: the table of [`UtmSky::embedded`], 124 KiB in the program;
//! without it, give [`UtmSky::decode`] the bytes of a `.utmlut` file. `solar-position`: the sun from
//! date, time and place.

pub mod aerial;
pub mod air_mass;
pub mod axis;
pub mod color;
pub mod conditions;
pub mod direction;
pub mod extended;
pub mod extinction;
pub mod haze;
pub mod hdr;
pub mod light;
pub mod lut;
pub mod picture;
pub mod quantity;
#[cfg(feature = "solar-position")]
pub mod solar_position;
pub mod sun;
pub mod tonemap;
pub mod uniforms;
pub mod utm_sky;

pub use aerial::{AerialFrame, AerialPath};
pub use color::{LinearSrgb, Xyz, Yxy};
pub use conditions::{Conditions, Domain, Nearest, OutsideDomain, Quantity};
pub use direction::{SkyDirection, horizon_zenith};
pub use haze::{Haze, HazeError};
pub use light::{SceneLight, SunDisc};
pub use lut::{Lut, LutError, LutHeader};
pub use picture::Picture;
pub use quantity::{Angle, Length};
#[cfg(feature = "solar-position")]
pub use solar_position::{GeoPlace, SunPosition, UtcTime, sun_position};
pub use tonemap::Tone;
pub use utm_sky::{SkyFrame, TableError, UtmSky};
