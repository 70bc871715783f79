//! Scene files: what a simulator needs to show, and how well.
//!
//! TOML; the fields are documented in `profiles/scenes/README.md`. What is said in words of a pilot (a
//! place and hours, a visual range) becomes ranges of altitude, turbidity and sun zenith here. Out of
//! scope: how the ranges are met.

use std::path::PathBuf;

use anyhow::{Result, anyhow, bail};
use serde::{Deserialize, Serialize};
use sky_core::conditions::Domain;
use sky_core::haze::Haze;
use sky_core::quantity::{Angle, Length};
use sky_core::solar_position::{GeoPlace, SolarPositionError, UtcTime, sun_position};
use sky_eval::truth::{DEFAULT_GROUND_ALBEDO, DOMAIN};

/// Distance of the times at which the sun's place is taken \[min\].
const MINUTES: u32 = 5;

/// Numbers of the CIE's ΔE2000 that an eye can just tell apart.
const JUST_NOTICEABLE_DELTA_E: f64 = 1.0;

/// One value, or the least and the largest.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(untagged)]
enum Span {
    One(f64),
    Range([f64; 2]),
}

impl Span {
    const fn bounds(self) -> [f64; 2] {
        match self {
            Self::One(value) => [value, value],
            Self::Range(bounds) => bounds,
        }
    }
}

/// The file as it is written.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SceneFile {
    altitude_km: Span,
    sun_zenith_deg: Option<Span>,
    place: Option<PlaceFile>,
    haze: HazeFile,
    #[serde(default = "default_albedo")]
    ground_albedo: f64,
    farthest_object_km: f64,
    #[serde(default = "default_profile")]
    profile: PathBuf,
    view: View,
    tolerance: ToleranceFile,
    #[serde(default)]
    budget: Budget,
    #[serde(default)]
    target: Target,
}

const fn default_albedo() -> f64 {
    DEFAULT_GROUND_ALBEDO
}

fn default_profile() -> PathBuf {
    "general".into()
}

/// Where and when instead of a range of sun zenith angles.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct PlaceFile {
    latitude_deg: f64,
    longitude_deg: f64,
    dates: Vec<String>,
    hours_utc: [f64; 2],
}

/// The haze in one of three ways.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct HazeFile {
    turbidity: Option<Span>,
    aod500: Option<Span>,
    visual_range_km: Option<Span>,
}

/// What the camera sees.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct View {
    /// Pixels of a picture.
    pub pixels: f64,
}

/// The error that is tolerated, in numbers or as what an eye can see on a display.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct ToleranceFile {
    delta_e: Option<f64>,
    luminance: Option<f64>,
    just_noticeable_at_cd_m2: Option<f64>,
}

/// The errors that 95 % of directions must stay below.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tolerance {
    /// CIEDE2000.
    pub delta_e: f64,
    /// Relative error of luminance \[1\].
    pub luminance: f64,
}

/// What the scene may cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Budget {
    /// Most bytes of the table's file.
    pub bytes: Option<u32>,
    /// Most GPU time of the sky in a picture \[ns\].
    pub gpu_ns: Option<f64>,
}

/// What the target can do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Target {
    /// Time of the formula at a pixel, as `utm-sky bench-gpu` measures it on the target \[ns\].
    pub fragment_ns_per_pixel: Option<f64>,
}

/// A scene, checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Name of the file without its ending.
    pub name: String,
    /// Ranges of altitude, turbidity and sun zenith.
    pub domain: Domain,
    /// Albedo of the ground.
    pub ground_albedo: f64,
    /// Distance of the farthest object that is seen \[km\].
    pub farthest_object_km: f64,
    /// The atmosphere: name or CSV file.
    pub profile: PathBuf,
    /// The camera.
    pub view: View,
    /// The error that is tolerated.
    pub tolerance: Tolerance,
    /// What it may cost.
    pub budget: Budget,
    /// What the target can do.
    pub target: Target,
}

impl Scene {
    /// From the text of a scene file.
    ///
    /// # Errors
    /// Names the field, what was expected and what was found.
    pub fn from_toml(name: &str, text: &str) -> Result<Self> {
        let file: SceneFile = toml::from_str(text)?;
        let altitude_km = checked("altitude_km", file.altitude_km, DOMAIN.altitude_km)?;
        let sun_zenith_deg = match (file.sun_zenith_deg, &file.place) {
            (Some(span), None) => checked("sun_zenith_deg", span, DOMAIN.sun_zenith_deg)?,
            (None, Some(place)) => place.sun_zenith_deg()?,
            (found, _) => bail!(
                "sun_zenith_deg, place: expected one of them, found {}",
                if found.is_some() { "both" } else { "neither" }
            ),
        };
        within("ground_albedo", file.ground_albedo, [0.0, 1.0])?;
        within("farthest_object_km", file.farthest_object_km, [0.0, 1000.0])?;
        within("view.pixels", file.view.pixels, [1.0, 1e9])?;
        for (field, value) in [
            ("budget.gpu_ns", file.budget.gpu_ns),
            (
                "target.fragment_ns_per_pixel",
                file.target.fragment_ns_per_pixel,
            ),
        ] {
            if let Some(value) = value {
                within(field, value, [1e-6, 1e12])?;
            }
        }
        Ok(Self {
            name: name.to_owned(),
            domain: Domain {
                altitude_km,
                turbidity: file.haze.turbidity()?,
                sun_zenith_deg,
                below_horizontal: true,
            },
            ground_albedo: file.ground_albedo,
            farthest_object_km: file.farthest_object_km,
            profile: file.profile,
            view: file.view,
            tolerance: file.tolerance.checked()?,
            budget: file.budget,
            target: file.target,
        })
    }
}

/// A number within bounds.
pub(crate) fn within(field: &str, found: f64, [low, high]: [f64; 2]) -> Result<f64> {
    if !(low..=high).contains(&found) {
        bail!("{field}: expected a number from {low} to {high}, found {found}");
    }
    Ok(found)
}

/// A range within bounds.
pub(crate) fn range_within(
    field: &str,
    [from, to]: [f64; 2],
    bounds: [f64; 2],
) -> Result<[f64; 2]> {
    within(field, from, bounds)?;
    within(field, to, bounds)?;
    if from > to {
        bail!("{field}: expected the least and the largest value, found {from} before {to}");
    }
    Ok([from, to])
}

fn checked(field: &str, span: Span, bounds: [f64; 2]) -> Result<[f64; 2]> {
    range_within(field, span.bounds(), bounds)
}

impl HazeFile {
    fn turbidity(&self) -> Result<[f64; 2]> {
        type Way = (&'static str, fn(f64) -> Haze);
        let ways: [(Way, Option<Span>); 3] = [
            (("haze.turbidity", Haze::Turbidity), self.turbidity),
            (("haze.aod500", Haze::OpticalDepth500), self.aod500),
            (
                ("haze.visual_range_km", |km| {
                    Haze::VisualRange(Length::from_km(km))
                }),
                self.visual_range_km,
            ),
        ];
        let mut given = ways
            .into_iter()
            .filter_map(|(way, span)| Some((way, span?)));
        let (Some(((field, haze), span)), None) = (given.next(), given.next()) else {
            bail!(
                "haze: expected one of turbidity, aod500, visual_range_km, found none or several"
            );
        };
        let [a, b] = span.bounds();
        if a > b {
            bail!("{field}: expected the least and the largest value, found {a} before {b}");
        }
        let turbidity = |value| {
            let turbidity = haze(value)
                .turbidity()
                .map_err(|e| anyhow!("{field}: {e}"))?;
            within(field, turbidity, DOMAIN.turbidity)
                .map_err(|e| anyhow!("{e} (as turbidity, of {value})"))
        };
        let (a, b) = (turbidity(a)?, turbidity(b)?);
        Ok([a.min(b), a.max(b)])
    }
}

impl ToleranceFile {
    fn checked(&self) -> Result<Tolerance> {
        match (self.delta_e, self.luminance, self.just_noticeable_at_cd_m2) {
            (Some(delta_e), Some(luminance), None) => Ok(Tolerance {
                delta_e: within("tolerance.delta_e", delta_e, [1e-3, 100.0])?,
                luminance: within("tolerance.luminance", luminance, [1e-4, 10.0])?,
            }),
            (None, None, Some(display)) => {
                within(
                    "tolerance.just_noticeable_at_cd_m2",
                    display,
                    [0.05, 3990.0],
                )?;
                Ok(Tolerance {
                    delta_e: JUST_NOTICEABLE_DELTA_E,
                    luminance: just_noticeable_contrast(display),
                })
            }
            _ => bail!(
                "tolerance: expected delta_e and luminance, or just_noticeable_at_cd_m2, found another choice"
            ),
        }
    }
}

/// Luminance of a step of the grayscale standard display function \[cd·m⁻²\].
///
/// Source: DICOM PS3.14, Eq. 7.1 (after Barten 1992); 1 to 1023.
fn grayscale_luminance(step: f64) -> f64 {
    let j = step.ln();
    let above = -1.301_187_7
        + j * (8.024_263_6e-2 + j * (1.364_669_9e-1 + j * (-2.546_840_4e-2 + j * 1.363_533_4e-3)));
    let below = 1.0
        + j * (-2.584_019_1e-2
            + j * (-1.032_022_9e-1
                + j * (2.874_562_0e-2 + j * (-3.197_897_7e-3 + j * 1.299_263_4e-4))));
    10.0_f64.powf(above / below)
}

/// The contrast that an eye can just see at a luminance of the display, 0.05 to 3990 cd·m⁻².
fn just_noticeable_contrast(display_cd_m2: f64) -> f64 {
    let (mut low, mut high) = (1.0, 1022.0);
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if grayscale_luminance(middle) < display_cd_m2 {
            low = middle;
        } else {
            high = middle;
        }
    }
    grayscale_luminance(low + 1.0) / grayscale_luminance(low) - 1.0
}

impl PlaceFile {
    /// The least and the largest zenith angle of the sun, without refraction.
    fn sun_zenith_deg(&self) -> Result<[f64; 2]> {
        within("place.latitude_deg", self.latitude_deg, [-90.0, 90.0])?;
        within("place.longitude_deg", self.longitude_deg, [-180.0, 180.0])?;
        let [from, to] = range_within("place.hours_utc", self.hours_utc, [0.0, 24.0])?;
        if self.dates.is_empty() {
            bail!("place.dates: expected at least one date, found none");
        }
        let place = GeoPlace {
            latitude: Angle::from_degrees(self.latitude_deg),
            longitude: Angle::from_degrees(self.longitude_deg),
            altitude: Length::ZERO,
        };
        let mut bounds = [f64::INFINITY, f64::NEG_INFINITY];
        for date in &self.dates {
            let no_date = || anyhow!("place.dates: expected YYYY-MM-DD, found {date:?}");
            let midnight = UtcTime::from_date(date).ok_or_else(no_date)?;
            let steps = (0..=24 * 60 / MINUTES).map(|i| f64::from(i * MINUTES) / 60.0);
            for hours in steps.filter(|h| *h > from && *h < to).chain([from, to]) {
                let time = UtcTime { hours, ..midnight };
                let sun = sun_position(time, place).map_err(|e| match e {
                    SolarPositionError::Date { .. } => no_date(),
                    e => anyhow!("place: {date} {hours:.2} h: {e}"),
                })?;
                let zenith = sun.zenith.degrees();
                if !(..=DOMAIN.sun_zenith_deg[1]).contains(&zenith) {
                    bail!(
                        "place.hours_utc: expected the sun within {} deg of the zenith, found {zenith:.1} deg on {date} at {hours:.2} h UTC",
                        DOMAIN.sun_zenith_deg[1]
                    );
                }
                bounds = [bounds[0].min(zenith), bounds[1].max(zenith)];
            }
        }
        // hundredths, outward: short in files, and nothing of the range is lost
        Ok([
            (bounds[0] * 100.0).floor() / 100.0,
            ((bounds[1] * 100.0).ceil() / 100.0).min(DOMAIN.sun_zenith_deg[1]),
        ])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_grayscale_function_is_that_of_the_standard() {
        // the ends of the standard's range, and the check value of colour-science
        // (`eotf_DICOMGSDF(512)`)
        for (step, luminance) in [(1.0, 0.05), (512.0, 130.0653), (1023.0, 3993.4)] {
            let found = grayscale_luminance(step);
            assert!((found / luminance - 1.0).abs() < 2e-3, "{step}: {found}");
        }
        let contrast = just_noticeable_contrast(100.0);
        assert!((0.006..0.010).contains(&contrast), "{contrast}");
    }

    #[test]
    fn a_place_becomes_a_range_of_suns() {
        // Innsbruck at the June solstice: the noon sun stands 90 - 47.26 + 23.44 deg high
        let place = PlaceFile {
            latitude_deg: 47.26,
            longitude_deg: 11.34,
            dates: vec!["2025-06-21".into()],
            hours_utc: [9.0, 13.0],
        };
        let [least, largest] = place.sun_zenith_deg().unwrap();
        assert!((least - 23.82).abs() < 0.05, "{least}");
        assert!((30.0..50.0).contains(&largest), "{largest}");
    }
}
