//! The words that commands share: options, units and ranges, and the values that they stand for.

use std::path::PathBuf;

use anyhow::{Result, anyhow};
use clap::builder::{NonEmptyStringValueParser, TypedValueParser};
use clap::{Args, ValueEnum};
use sky_core::conditions::{Conditions, OutsideDomain};
use sky_core::haze::Haze;
use sky_core::quantity::{Angle, Length};
use sky_core::tonemap::Tone;
use sky_eval::profiles::shipped_names;
use sky_gpu::{Dome, Tier};
use sky_render::Scenery;
use sky_sim::optics::{Constituents, OpticsSettings};

/// Help of `--profile`, with the names of the shipped ones.
pub(crate) fn profile_help() -> String {
    let names: Vec<&str> = shipped_names().collect();
    format!(
        "Profile of the atmosphere: a CSV file or the name of a shipped one ({})",
        names.join(", ")
    )
}

/// A number within bounds, both allowed. NaN and infinities are refused.
pub(crate) fn within(low: f64, high: f64) -> impl TypedValueParser<Value = f64> {
    NonEmptyStringValueParser::new().try_map(move |text| match text.parse::<f64>() {
        Ok(value) if (low..=high).contains(&value) => Ok(value),
        _ if high.is_infinite() => Err(format!("expected a number of at least {low}")),
        _ => Err(format!("expected a number from {low} to {high}")),
    })
}

/// A finite number above 0.
pub(crate) fn positive() -> impl TypedValueParser<Value = f64> {
    NonEmptyStringValueParser::new().try_map(|text| match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value.is_finite() => Ok(value),
        _ => Err("expected a number above 0"),
    })
}

/// A finite number of at least `low`.
pub(crate) fn at_least(low: f64) -> impl TypedValueParser<Value = f64> {
    NonEmptyStringValueParser::new().try_map(move |text| match text.parse::<f64>() {
        Ok(value) if value >= low && value.is_finite() => Ok(value),
        _ => Err(format!("expected a number of at least {low}")),
    })
}

/// One of the wavelength steps \[nm\] that divide 380–780 nm and that the tables serve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum WavelengthStep {
    /// 1 nm, 401 wavelengths.
    #[value(name = "1")]
    Nm1,
    /// 5 nm, 81 wavelengths.
    #[value(name = "5")]
    Nm5,
    /// 10 nm, 41 wavelengths.
    #[value(name = "10")]
    Nm10,
    /// 20 nm, 21 wavelengths.
    #[value(name = "20")]
    Nm20,
}

impl WavelengthStep {
    /// The step \[nm\].
    #[must_use]
    pub fn nm(self) -> u16 {
        match self {
            Self::Nm1 => 1,
            Self::Nm5 => 5,
            Self::Nm10 => 10,
            Self::Nm20 => 20,
        }
    }
}

/// How the sky's radiance is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Engine {
    /// Spherical shells, multiple scattering
    #[default]
    Transport,
    /// Closed-form transmittances, single-scattering pattern
    Smarts,
}

/// The four ways to give the haze.
pub(crate) const HAZE: [&str; 4] = ["turbidity", "aod500", "visual_range_km", "angstrom_beta"];

/// The haze, in one of four ways. Commands decide whether one of them is needed.
#[derive(Clone, Copy, Debug, Args)]
#[group(skip)]
pub struct HazeArgs {
    /// Turbidity T = 1 + (aerosol optical depth at 500 nm) / 0.14344, at least 1 (clean air)
    #[arg(long, value_name = "T", value_parser = at_least(1.0), allow_negative_numbers = true,
          help_heading = "Haze (one of)")]
    pub turbidity: Option<f64>,
    /// Vertical aerosol optical depth at 500 nm
    #[arg(long, value_name = "X", value_parser = at_least(0.0), allow_negative_numbers = true,
          help_heading = "Haze (one of)")]
    pub aod500: Option<f64>,
    /// Visual range at the ground, 2 % contrast at 550 nm (Koschmieder) [km]; 1.306 times a METAR's
    #[arg(long, value_name = "KM", value_parser = positive(), allow_negative_numbers = true,
          help_heading = "Haze (one of)")]
    pub visual_range_km: Option<f64>,
    /// Angstrom's beta, the aerosol optical depth at 1 µm
    #[arg(long, value_name = "BETA", value_parser = at_least(0.0), allow_negative_numbers = true,
          help_heading = "Haze (one of)")]
    pub angstrom_beta: Option<f64>,
}

/// The air: profile, constituents, properties of the haze.
#[derive(Clone, Debug, Args)]
#[group(skip)]
pub struct AtmosphereArgs {
    /// Profile of the atmosphere: a CSV file or the name of a shipped one
    #[arg(
        long,
        value_name = "CSV|NAME",
        default_value = "general",
        help = profile_help(),
        help_heading = "Atmosphere"
    )]
    pub profile: PathBuf,
    /// Constituents that take part, separated by commas; without it the reference atmosphere,
    /// rayleigh,ozone,aerosol,stratosphere (beam: all)
    #[arg(
        long,
        value_name = "LIST",
        value_delimiter = ',',
        help_heading = "Atmosphere"
    )]
    pub constituents: Option<Vec<Constituent>>,
    /// Distance of the wavelengths, 380-780 nm [nm]; without it 10 (beam: 1)
    #[arg(long, value_name = "NM", help_heading = "Atmosphere")]
    pub wavelength_step_nm: Option<WavelengthStep>,
    /// Angstrom exponent of the haze; without it the spectrum is that of rural aerosol (with
    /// --angstrom-beta: 1.3)
    #[arg(long, value_name = "ALPHA", value_parser = within(-1.0, 4.0),
          allow_negative_numbers = true, help_heading = "Atmosphere")]
    pub angstrom_alpha: Option<f64>,
    /// Single-scattering albedo of the haze at all wavelengths; without it that of rural aerosol
    #[arg(long, value_name = "W", value_parser = within(0.0, 1.0), allow_negative_numbers = true,
          help_heading = "Atmosphere")]
    pub single_scattering_albedo: Option<f64>,
    /// Asymmetry parameter of the haze (Henyey-Greenstein); without it that of rural aerosol
    #[arg(long, value_name = "G", value_parser = within(-0.99, 0.99),
          allow_negative_numbers = true, help_heading = "Atmosphere")]
    pub asymmetry: Option<f64>,
    /// Scale height of the haze [km]
    #[arg(long, value_name = "KM", value_parser = within(0.1, 20.0), default_value = "1.2",
          allow_negative_numbers = true, help_heading = "Atmosphere")]
    pub scale_height_km: f64,
}

/// What can be switched.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Constituent {
    /// Scattering by the molecules
    Rayleigh,
    /// Ozone
    Ozone,
    /// Nitrogen dioxide
    No2,
    /// Pairs of oxygen molecules
    #[value(name = "o2o2")]
    OxygenPairs,
    /// Oxygen bands
    #[value(name = "o2")]
    Oxygen,
    /// Water vapor bands
    #[value(name = "h2o")]
    Water,
    /// The haze
    Aerosol,
    /// The faint stratospheric layer
    Stratosphere,
    /// All of them
    All,
}

/// Where the observer and the sun are.
#[derive(Clone, Copy, Debug, Args)]
#[group(skip)]
pub struct PlaceArgs {
    /// Altitude of the observer above mean sea level, 0-30 [km]
    #[arg(long, value_name = "KM", value_parser = within(0.0, 30.0), allow_negative_numbers = true)]
    pub altitude_km: f64,
    /// Zenith angle of the sun, 0-96 [deg]
    #[arg(long, value_name = "DEG", value_parser = within(0.0, 96.0), allow_negative_numbers = true,
          required_unless_present = "sun_elevation_deg")]
    pub sun_zenith_deg: Option<f64>,
    /// Elevation of the sun, 90 less its zenith angle, in place of that, -6-90 [deg]
    #[arg(long, value_name = "DEG", value_parser = within(-6.0, 90.0), allow_negative_numbers = true,
          conflicts_with = "sun_zenith_deg")]
    pub sun_elevation_deg: Option<f64>,
}

impl PlaceArgs {
    /// Zenith angle of the sun; clap made sure that it was given one way or the other.
    #[must_use]
    pub fn sun_zenith(&self) -> Angle {
        let zenith_deg = self
            .sun_zenith_deg
            .or(self.sun_elevation_deg.map(|up| 90.0 - up));
        Angle::from_degrees(zenith_deg.unwrap_or_default())
    }
}

/// Where the observer and the sun are, for the engines: anywhere below space, day and night.
#[derive(Clone, Copy, Debug, Args)]
#[group(skip)]
pub struct AnyPlaceArgs {
    /// Altitude of the observer above mean sea level, -0.5 to 100 [km]; the ground lies at 0 km, or at
    /// the observer's feet if they are lower
    #[arg(long, value_name = "KM", value_parser = within(-0.5, 100.0), allow_negative_numbers = true)]
    pub altitude_km: f64,
    /// Zenith angle of the sun, 0-108 [deg]
    #[arg(long, value_name = "DEG", value_parser = within(0.0, 108.0), allow_negative_numbers = true,
          required_unless_present = "sun_elevation_deg")]
    pub sun_zenith_deg: Option<f64>,
    /// Elevation of the sun, 90 less its zenith angle, in place of that, -18-90 [deg]
    #[arg(long, value_name = "DEG", value_parser = within(-18.0, 90.0), allow_negative_numbers = true,
          conflicts_with = "sun_zenith_deg")]
    pub sun_elevation_deg: Option<f64>,
}

impl AnyPlaceArgs {
    /// Zenith angle of the sun.
    #[must_use]
    pub fn sun_zenith(&self) -> Angle {
        PlaceArgs::from(*self).sun_zenith()
    }
}

impl From<AnyPlaceArgs> for PlaceArgs {
    fn from(place: AnyPlaceArgs) -> Self {
        Self {
            altitude_km: place.altitude_km,
            sun_zenith_deg: place.sun_zenith_deg,
            sun_elevation_deg: place.sun_elevation_deg,
        }
    }
}

/// Where a look-up table comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LutSource {
    /// The one that is built into the program.
    Embedded,
    /// A `.utmlut` file.
    File(PathBuf),
    /// A plan (`.toml`), baked when it is asked for.
    Plan(PathBuf),
}

pub(crate) fn lut_source(text: &str) -> Result<LutSource, std::convert::Infallible> {
    Ok(match text {
        "embedded" => LutSource::Embedded,
        path if path.ends_with(".toml") => LutSource::Plan(path.into()),
        path => LutSource::File(path.into()),
    })
}

/// What the runtime needs to know: table, observer, sun and haze.
#[derive(Clone, Debug, Args)]
#[group(skip)]
pub struct SceneArgs {
    /// Look-up table: a .utmlut file, a plan (.toml), which is baked first, or the built-in one
    #[arg(long, value_name = "FILE|embedded", default_value = "embedded", value_parser = lut_source)]
    pub lut: LutSource,
    /// Observer and sun.
    #[command(flatten)]
    pub place: PlaceArgs,
    /// The haze.
    #[command(flatten)]
    pub haze: HazeArgs,
    /// Angstrom exponent that belongs to --angstrom-beta; without it 1.3
    #[arg(long, value_name = "ALPHA", value_parser = within(-1.0, 4.0), requires = "angstrom_beta",
          allow_negative_numbers = true, help_heading = "Haze (one of)")]
    pub angstrom_alpha: Option<f64>,
}

/// How the sky is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum TierKind {
    /// A dome of 271 corners, blended between them
    Vertex,
    /// The formula at every pixel
    Fragment,
    /// A small texture, one fetch a pixel
    #[default]
    Baked,
}

impl From<TierKind> for Tier {
    fn from(kind: TierKind) -> Self {
        match kind {
            TierKind::Vertex => Self::Vertex(Dome::REPORT),
            TierKind::Fragment => Self::Fragment,
            TierKind::Baked => Self::Baked,
        }
    }
}

/// What stands under the sky.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum SceneKind {
    /// The bare ground below the horizon
    #[default]
    None,
    /// Ridges over several hundred kilometers
    Terrain,
}

impl From<SceneKind> for Scenery {
    fn from(kind: SceneKind) -> Self {
        match kind {
            SceneKind::None => Self::None,
            SceneKind::Terrain => Self::Terrain,
        }
    }
}

/// Who draws.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Backend {
    /// wgpu: Vulkan, Metal or Direct3D 12
    #[default]
    Gpu,
    /// The evaluator on the CPU
    Cpu,
}

/// Tone curve by name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum ToneKind {
    /// Linear up to white
    None,
    /// x/(1 + x) on luminance
    Reinhard,
    /// A rational curve like the ACES reference rendering
    Aces,
    /// Khronos PBR Neutral
    #[default]
    Neutral,
}

impl From<ToneKind> for Tone {
    fn from(kind: ToneKind) -> Self {
        match kind {
            ToneKind::None => Self::None,
            ToneKind::Reinhard => Self::Reinhard,
            ToneKind::Aces => Self::Aces,
            ToneKind::Neutral => Self::Neutral,
        }
    }
}

/// Width and height from `WxH`.
pub(crate) fn size(text: &str) -> Result<[u32; 2], String> {
    let expected = || format!("expected WIDTHxHEIGHT, 1 to 8192 pixels a side, found {text:?}");
    let (w, h) = text.split_once('x').ok_or_else(expected)?;
    let side = |t: &str| t.parse().ok().filter(|s| (1..=8192).contains(s));
    match (side(w), side(h)) {
        (Some(w), Some(h)) => Ok([w, h]),
        _ => Err(expected()),
    }
}

/// Azimuth and elevation from `AZ,EL` \[deg\].
pub(crate) fn look(text: &str) -> Result<[f64; 2], String> {
    let expected = || format!("expected AZIMUTH,ELEVATION in degrees, found {text:?}");
    let (az, el) = text.split_once(',').ok_or_else(expected)?;
    match (az.trim().parse(), el.trim().parse()) {
        (Ok(az), Ok(el))
            if (-360.0..=360.0_f64).contains(&az) && (-90.0..=90.0_f64).contains(&el) =>
        {
            Ok([az, el])
        }
        _ => Err(expected()),
    }
}

/// An exposure value, `None` for automatic.
pub(crate) fn ev100(text: &str) -> Result<Ev100, String> {
    match text.parse::<f32>() {
        _ if text == "auto" => Ok(Ev100(None)),
        Ok(value) if (-20.0..=40.0).contains(&value) => Ok(Ev100(Some(value))),
        _ => Err(format!(
            "expected auto or a number from -20 to 40, found {text:?}"
        )),
    }
}

/// An exposure value at ISO 100; `None` is automatic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ev100(pub Option<f32>);

/// Ångström's exponent where only β is given (Ångström 1961: 1.3 for natural haze).
const DEFAULT_ANGSTROM_EXPONENT: f64 = 1.3;

impl HazeArgs {
    /// The haze that was given; clap made sure that there is at most one.
    #[must_use]
    pub fn haze(&self, angstrom_alpha: Option<f64>) -> Option<Haze> {
        let angstrom = |beta| Haze::Angstrom {
            beta,
            alpha: angstrom_alpha.unwrap_or(DEFAULT_ANGSTROM_EXPONENT),
        };
        self.turbidity
            .map(Haze::Turbidity)
            .or(self.aod500.map(Haze::OpticalDepth500))
            .or(self
                .visual_range_km
                .map(|km| Haze::VisualRange(Length::from_km(km))))
            .or(self.angstrom_beta.map(angstrom))
    }
}

/// What a command takes where the user says nothing.
#[derive(Clone, Copy, Debug)]
pub struct Defaults {
    /// Constituents that take part.
    pub constituents: Constituents,
    /// Distance of the wavelengths.
    pub wavelength_step: WavelengthStep,
}

impl Defaults {
    /// For the sky: the reference atmosphere every 10 nm.
    pub const SKY: Self = Self {
        constituents: Constituents::REFERENCE,
        wavelength_step: WavelengthStep::Nm10,
    };

    /// For the sun's beam: every constituent every 1 nm, to stand beside a measured spectrum.
    pub const BEAM: Self = Self {
        constituents: Constituents::ALL,
        wavelength_step: WavelengthStep::Nm1,
    };
}

fn constituents(list: &[Constituent]) -> Constituents {
    let on = |c| list.contains(&c) || list.contains(&Constituent::All);
    Constituents {
        rayleigh: on(Constituent::Rayleigh),
        ozone: on(Constituent::Ozone),
        no2: on(Constituent::No2),
        o2o2: on(Constituent::OxygenPairs),
        o2_band: on(Constituent::Oxygen),
        h2o_band: on(Constituent::Water),
        aerosol: on(Constituent::Aerosol),
        stratospheric_aerosol: on(Constituent::Stratosphere),
    }
}

impl AtmosphereArgs {
    /// The step of the wavelengths \[nm\].
    #[must_use]
    pub fn step_nm(&self, defaults: Defaults) -> u16 {
        self.wavelength_step_nm
            .unwrap_or(defaults.wavelength_step)
            .nm()
    }

    /// The settings of the optics.
    ///
    /// # Errors
    /// When no such step is offered, or the haze cannot be.
    pub fn settings(&self, haze: &HazeArgs, defaults: Defaults) -> Result<OpticsSettings> {
        let mut settings = OpticsSettings::with_step_nm(self.step_nm(defaults))?;
        settings.constituents = self
            .constituents
            .as_deref()
            .map_or(defaults.constituents, constituents);
        if let Some(haze) = haze.haze(self.angstrom_alpha) {
            settings.haze = haze;
        }
        settings.angstrom_exponent = self.angstrom_alpha;
        settings.single_scattering_albedo = self.single_scattering_albedo;
        settings.asymmetry_parameter = self.asymmetry;
        settings.aerosol_scale_height = Length::from_km(self.scale_height_km);
        settings.check()?;
        Ok(settings)
    }
}

impl SceneArgs {
    /// Conditions outside a domain, in the words in which they were given.
    #[must_use]
    pub fn in_own_words(&self, outside: OutsideDomain) -> OutsideDomain {
        let haze = self.haze.haze(self.angstrom_alpha);
        haze.map_or(outside, |haze| outside.in_words_of(haze))
    }

    /// Observer, haze and sun.
    ///
    /// # Errors
    /// When the haze makes no sense.
    pub fn conditions(&self) -> Result<Conditions> {
        conditions(&self.place, self.haze.haze(self.angstrom_alpha))
    }
}

/// Observer, haze and sun.
///
/// # Errors
/// When the haze makes no sense.
pub fn conditions(place: &PlaceArgs, haze: Option<Haze>) -> Result<Conditions> {
    let haze = haze
        .ok_or_else(|| anyhow!("haze: expected one of --turbidity, --aod500, --visual-range-km"))?;
    let altitude = Length::from_km(place.altitude_km);
    Ok(Conditions::new(altitude, haze, place.sun_zenith())?)
}
