//! The command line: every command, option, unit and range, with an example each.

use std::path::PathBuf;

use clap::builder::{NonEmptyStringValueParser, TypedValueParser};
use clap::{ArgGroup, Args, Parser, Subcommand, ValueEnum};
use sky_core::lut::LutHeader;
use sky_core::quantity::{Angle, Length};
use sky_core::solar_position::{GeoPlace, UtcTime, sun_position};

/// Spectral sky radiance, fitted sky formulas and look-up tables for flight simulators.
#[derive(Debug, Parser)]
#[command(
    name = "utm-sky",
    version,
    max_term_width = 100,
    after_help = "Examples:
  utm-sky generate
  utm-sky map --altitude-km 6 --turbidity 2 --sun-zenith-deg 60 --yxy --out sky.csv

Exit status: 0 on success, 2 on bad input or when a file cannot be written."
)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Print the atmosphere: the vertical profile that everything else starts from
    Profile(ProfileArgs),
    /// Write extinction per level and wavelength
    Optics(OpticsArgs),
    /// Write the sky's spectral radiance or Yxy by direction, computed from the atmosphere
    Map(MapArgs),
    /// Write the direct normal spectrum of the sun
    Beam(BeamArgs),
    /// Write the sky's Yxy by direction, as the look-up table gives it
    Sky(SkyArgs),
    /// Write transmittance and in-scattered light of finite paths
    Segment(SegmentArgs),
    /// Draw a picture: sky, sun, ground or terrain
    Render(RenderArgs),
    /// Fly through the sky in a window
    View(ViewArgs),
    /// Draw the figures of the report of 2005 on one contact sheet
    Gallery(GalleryArgs),
    /// Compare every sky: error against cost, on one chart
    Chart(ChartArgs),
    /// List the skies that can be compared, with citation and domain
    #[command(after_help = "Example:\n  utm-sky models")]
    Models,
    /// Print what a scene is lit with: sun, sky, spherical harmonics
    Light(LightArgs),
    /// Time the ways to draw a sky
    BenchGpu(BenchGpuArgs),
    /// Write the shaders in another language, with the table
    ExportShaders(ExportShadersArgs),
    /// Compute maps on a grid, fit them, and write the look-up table and the report
    Generate(GenerateArgs),
    /// Find the cheapest table that a scene needs
    Plan(PlanArgs),
    /// Write the report on a look-up table as one HTML page
    Report(ReportArgs),
    /// Find where the models fail: a sweep over their domains and beyond
    Atlas(AtlasArgs),
    /// Fit damaged maps from random starts, with and without the fit's safeguards
    FitStress(FitStressArgs),
    /// Inspect or export a look-up table
    Lut(LutArgs),
}

/// Help of `--directions`.
const DIRECTIONS_HELP: &str = "Directions: CSV with view_zenith_deg,relative_azimuth_deg \
                               (0 faces the sun); without it the zenith and nine rings of 30";

/// Help of `--segments`.
const SEGMENTS_HELP: &str =
    "Paths: CSV with view_zenith_deg,relative_azimuth_deg (0 faces the sun),distance_km";

/// A number within bounds, both allowed. NaN and infinities are refused.
fn within(low: f64, high: f64) -> impl TypedValueParser<Value = f64> {
    NonEmptyStringValueParser::new().try_map(move |text| match text.parse::<f64>() {
        Ok(value) if (low..=high).contains(&value) => Ok(value),
        _ if high.is_infinite() => Err(format!("expected a number of at least {low}")),
        _ => Err(format!("expected a number from {low} to {high}")),
    })
}

/// A finite number above 0.
fn positive() -> impl TypedValueParser<Value = f64> {
    NonEmptyStringValueParser::new().try_map(|text| match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value.is_finite() => Ok(value),
        _ => Err("expected a number above 0"),
    })
}

/// A finite number of at least `low`.
fn at_least(low: f64) -> impl TypedValueParser<Value = f64> {
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
const HAZE: [&str; 4] = ["turbidity", "aod500", "visual_range_km", "angstrom_beta"];

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
    #[arg(long, value_name = "DEG", value_parser = within(0.0, 96.0), allow_negative_numbers = true)]
    pub sun_zenith_deg: f64,
}

/// `utm-sky profile`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  utm-sky profile
  utm-sky profile --profile utm2005 --out profile.csv")]
pub struct ProfileArgs {
    /// Profile of the atmosphere: a CSV file or the name of a shipped one
    #[arg(long, value_name = "CSV|NAME", default_value = "general")]
    pub profile: PathBuf,
    /// Also write the table as CSV
    #[arg(long, value_name = "CSV")]
    pub out: Option<PathBuf>,
}

/// `utm-sky optics`.
#[derive(Debug, Args)]
#[command(
    group(ArgGroup::new("haze").required(true)
        .args(HAZE)),
    after_help = "Example:
  utm-sky optics --aod500 0.2 --out optics.csv --solar solar.csv"
)]
pub struct OpticsArgs {
    /// Extinction by level and wavelength
    #[arg(long, value_name = "CSV")]
    pub out: PathBuf,
    /// Extraterrestrial solar spectrum at the same wavelengths, the mean over one step each
    #[arg(long, value_name = "CSV")]
    pub solar: Option<PathBuf>,
    /// The haze.
    #[command(flatten)]
    pub haze: HazeArgs,
    /// The air.
    #[command(flatten)]
    pub atmosphere: AtmosphereArgs,
}

/// `utm-sky map`.
#[derive(Debug, Args)]
#[command(
    group(ArgGroup::new("air").required(true)
        .args(["turbidity", "aod500", "visual_range_km", "angstrom_beta", "optics"])),
    after_help = "Examples:
  utm-sky map --altitude-km 6 --turbidity 2 --sun-zenith-deg 60 --out map.csv
  utm-sky map --altitude-km 0 --aod500 0.1 --sun-zenith-deg 85 --engine smarts --yxy --out sky.csv
  utm-sky map --model nishita --altitude-km 0 --turbidity 2 --sun-zenith-deg 85 --yxy --out map.csv
  utm-sky map --altitude-km 9 --optics optics.csv --solar solar.csv --depolarization 0 \\
      --sun-zenith-deg 92 --albedo 0.1 --out map.csv"
)]
pub struct MapArgs {
    /// Observer and sun.
    #[command(flatten)]
    pub place: PlaceArgs,
    /// Albedo of the ground (Lambertian)
    #[arg(long, value_name = "A", value_parser = within(0.0, 1.0), default_value = "0.2",
          allow_negative_numbers = true)]
    pub albedo: f64,
    /// How the radiance is computed
    #[arg(long, default_value = "transport")]
    pub engine: Engine,
    /// A sky of `utm-sky models` in place of the table's
    #[arg(long, value_name = "NAME", requires = "yxy",
          conflicts_with_all = ["engine", "optics", "albedo"])]
    pub model: Option<String>,
    /// Directions of view, azimuth 0 facing the sun; without it the zenith and nine rings of 30
    #[arg(long, value_name = "CSV", help = DIRECTIONS_HELP)]
    pub directions: Option<PathBuf>,
    /// Write luminance and chromaticity instead of spectral radiance
    #[arg(long)]
    pub yxy: bool,
    /// The map; spectral radiance belongs to the solar spectrum that `utm-sky optics --solar` writes
    #[arg(long, value_name = "CSV")]
    pub out: PathBuf,
    /// Optics made elsewhere, in the format of `utm-sky optics`, instead of a profile and haze
    #[arg(long, value_name = "CSV", requires = "solar", help_heading = "Optics made elsewhere",
          conflicts_with_all = ["profile", "constituents", "wavelength_step_nm", "angstrom_alpha",
                                "single_scattering_albedo", "asymmetry", "scale_height_km"])]
    pub optics: Option<PathBuf>,
    /// Extraterrestrial solar spectrum that covers the wavelengths of --optics
    #[arg(long, value_name = "CSV", help_heading = "Optics made elsewhere")]
    pub solar: Option<PathBuf>,
    /// Depolarization of the Rayleigh phase function; without it that of air, 0.0283
    #[arg(long, value_name = "D", value_parser = within(0.0, 0.5), allow_negative_numbers = true,
          help_heading = "Optics made elsewhere")]
    pub depolarization: Option<f64>,
    /// The haze.
    #[command(flatten)]
    pub haze: HazeArgs,
    /// The air.
    #[command(flatten)]
    pub atmosphere: AtmosphereArgs,
}

/// `utm-sky beam`.
#[derive(Debug, Args)]
#[command(
    group(ArgGroup::new("haze").required(true)
        .args(HAZE)),
    after_help = "Example:
  utm-sky beam --altitude-km 0 --aod500 0.084 --sun-zenith-deg 48.2 --out beam.csv"
)]
pub struct BeamArgs {
    /// Observer and sun.
    #[command(flatten)]
    pub place: PlaceArgs,
    /// The spectrum
    #[arg(long, value_name = "CSV")]
    pub out: PathBuf,
    /// Ozone above the observer instead of the profile's [atm cm]
    #[arg(long, value_name = "ATM_CM", value_parser = within(0.0, 2.0),
          allow_negative_numbers = true, help_heading = "Columns")]
    pub ozone_atm_cm: Option<f64>,
    /// Precipitable water above the observer instead of the profile's [cm]
    #[arg(long, value_name = "CM", value_parser = within(0.0, 20.0),
          allow_negative_numbers = true, help_heading = "Columns")]
    pub water_cm: Option<f64>,
    /// Pressure at the observer instead of the profile's [hPa]
    #[arg(long, value_name = "HPA", value_parser = within(1.0, 1200.0),
          allow_negative_numbers = true, help_heading = "Columns")]
    pub pressure_hpa: Option<f64>,
    /// The haze.
    #[command(flatten)]
    pub haze: HazeArgs,
    /// The air.
    #[command(flatten)]
    pub atmosphere: AtmosphereArgs,
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

fn lut_source(text: &str) -> Result<LutSource, std::convert::Infallible> {
    Ok(match text {
        "embedded" => LutSource::Embedded,
        path if path.ends_with(".toml") => LutSource::Plan(path.into()),
        path => LutSource::File(path.into()),
    })
}

/// `utm-sky sky`.
#[derive(Debug, Args)]
#[command(
    group(ArgGroup::new("haze").required(true)
        .args(HAZE)),
    after_help = "Example:
  utm-sky sky --lut embedded --altitude-km 6 --turbidity 2 --sun-zenith-deg 60 \\
      --directions directions.csv --out yxy.csv
  utm-sky sky --model preetham --altitude-km 0 --aod500 0.1 --sun-zenith-deg 40 --out preetham.csv"
)]
pub struct SkyArgs {
    /// Table, observer, sun and haze.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// A sky of `utm-sky models` in place of the table's
    #[arg(long, value_name = "NAME", conflicts_with = "lut")]
    pub model: Option<String>,
    /// Directions of view, azimuth 0 facing the sun; without it the zenith and nine rings of 30
    #[arg(long, value_name = "CSV", help = DIRECTIONS_HELP)]
    pub directions: Option<PathBuf>,
    /// Luminance and chromaticity by direction
    #[arg(long, value_name = "CSV")]
    pub out: PathBuf,
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

/// Which aerial perspective.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Aerial {
    /// From the table and the extinction of its air
    #[default]
    Default,
    /// As in the report of 2005, with its misprints mended
    Utm2005,
}

/// Arguments of `utm-sky segment`.
#[derive(Debug, Args)]
#[command(
    group(ArgGroup::new("haze").required(true).args(HAZE)),
    after_help = "Example:
  utm-sky segment --altitude-km 3 --turbidity 2 --sun-zenith-deg 60 \\
      --segments segments.csv --out paths.csv

A path is a straight ray over a sphere of 6371 km. Transmittances are those of sunlight in linear
sRGB and luminance; in-scattered light is what the air of the path adds."
)]
pub struct SegmentArgs {
    /// Table, observer, sun and haze.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Paths: CSV with zenith angle, azimuth and length of each
    #[arg(long, value_name = "CSV", help = SEGMENTS_HELP)]
    pub segments: PathBuf,
    /// Which aerial perspective
    #[arg(long, value_enum, default_value_t)]
    pub aerial: Aerial,
    /// The same columns, transmittances and in-scattered light
    #[arg(long, value_name = "CSV")]
    pub out: PathBuf,
}

/// A way to project the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ProjectionKind {
    /// As a camera sees it
    Perspective,
    /// The upper half of the sky as a disc
    Fisheye,
    /// All directions, azimuth across and elevation up
    Equirect,
}

/// How the sky is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum TierKind {
    /// A dome of 271 corners, blended between them
    Vertex,
    /// The formula at every pixel
    #[default]
    Fragment,
    /// A small texture, one fetch a pixel
    Baked,
}

impl TierKind {
    /// The tier that the plan chose from which a table was baked, where it was.
    #[must_use]
    pub fn planned(header: &LutHeader) -> Option<Self> {
        Self::from_str(header.planned("tier")?, false).ok()
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

/// Width and height from `WxH`.
fn size(text: &str) -> Result<[u32; 2], String> {
    let expected = || format!("expected WIDTHxHEIGHT, 1 to 8192 pixels a side, found {text:?}");
    let (w, h) = text.split_once('x').ok_or_else(expected)?;
    let side = |t: &str| t.parse().ok().filter(|s| (1..=8192).contains(s));
    match (side(w), side(h)) {
        (Some(w), Some(h)) => Ok([w, h]),
        _ => Err(expected()),
    }
}

/// Azimuth and elevation from `AZ,EL` \[deg\].
fn look(text: &str) -> Result<[f64; 2], String> {
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
fn ev100(text: &str) -> Result<Ev100, String> {
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

/// Arguments of `utm-sky render`.
#[derive(Debug, Args)]
#[command(
    group(ArgGroup::new("haze").required(true).args(HAZE)),
    after_help = "Examples:
  utm-sky render --altitude-km 0.1 --turbidity 2.5 --sun-zenith-deg 80 --out evening.png
  utm-sky render --altitude-km 12 --visual-range-km 60 --sun-zenith-deg 60 --scene terrain \\
      --look 30,-5 --fov-deg 70 --size 1920x1080 --out flight.png
  utm-sky render --altitude-km 20 --turbidity 1.5 --sun-zenith-deg 92 --projection fisheye \\
      --size 800x800 --backend cpu --out twilight.exr

  utm-sky render --model hillaire --altitude-km 1 --turbidity 3 --sun-zenith-deg 85 --out peer.png

Azimuths are clockwise from north. A PNG is 8-bit sRGB; an EXR holds linear sRGB in cd/m2. With --model
the CPU draws the sky alone: black where the model has no answer, and no sun."
)]
pub struct RenderArgs {
    /// Table, observer, sun and haze.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// A sky of `utm-sky models` in place of the table's
    #[arg(long, value_name = "NAME", conflicts_with_all = ["lut", "scenery", "tier"])]
    pub model: Option<String>,
    /// Azimuth of the sun, clockwise from north [deg]
    #[arg(long, value_name = "DEG", default_value_t = 180.0, value_parser = within(-360.0, 360.0),
          allow_negative_numbers = true)]
    pub sun_azimuth_deg: f64,
    /// Projection
    #[arg(long, value_enum, default_value = "perspective")]
    pub projection: ProjectionKind,
    /// Pixels
    #[arg(long, value_name = "WxH", default_value = "960x540", value_parser = size)]
    pub size: [u32; 2],
    /// Where the camera looks, azimuth from north and elevation [deg]; without it toward the sun's
    /// azimuth, 10 above the horizontal
    #[arg(long, value_name = "AZ,EL", value_parser = look, allow_hyphen_values = true)]
    pub look: Option<[f64; 2]>,
    /// Vertical field of view of a perspective picture [deg]
    #[arg(long, value_name = "DEG", default_value_t = 60.0, value_parser = within(1.0, 170.0))]
    pub fov_deg: f64,
    /// How the sky is drawn (GPU); without it as a plan has it, else fragment
    #[arg(long, value_enum)]
    pub tier: Option<TierKind>,
    /// What stands under the sky
    #[arg(long = "scene", value_enum, default_value_t)]
    pub scenery: SceneKind,
    /// Leave the air between camera and scene out, as some plans do
    #[arg(long)]
    pub no_aerial: bool,
    /// Who draws
    #[arg(long, value_enum, default_value_t)]
    pub backend: Backend,
    /// Exposure value at ISO 100, or auto
    #[arg(long, value_name = "E|auto", default_value = "auto", value_parser = ev100,
          allow_hyphen_values = true)]
    pub ev100: Ev100,
    /// Tone curve of a PNG
    #[arg(long, value_enum, default_value_t)]
    pub tone: ToneKind,
    /// Picture: .png or .exr
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
}

/// Latitude and longitude from `LAT,LON` \[deg\].
fn geo_place(text: &str) -> Result<[f64; 2], String> {
    let expected = || {
        format!("expected LATITUDE,LONGITUDE in degrees, -90 to 90 and -180 to 180, found {text:?}")
    };
    let (latitude, longitude) = text.split_once(',').ok_or_else(expected)?;
    match (latitude.trim().parse(), longitude.trim().parse()) {
        (Ok(latitude), Ok(longitude))
            if (-90.0..=90.0_f64).contains(&latitude)
                && (-180.0..=180.0_f64).contains(&longitude) =>
        {
            Ok([latitude, longitude])
        }
        _ => Err(expected()),
    }
}

/// A date from `YYYY-MM-DD`, at midnight.
fn date(text: &str) -> Result<UtcTime, String> {
    let greenwich = GeoPlace {
        latitude: Angle::ZERO,
        longitude: Angle::ZERO,
        altitude: Length::ZERO,
    };
    let time =
        UtcTime::from_date(text).ok_or_else(|| format!("expected YYYY-MM-DD, found {text:?}"))?;
    sun_position(time, greenwich)
        .map(|_| time)
        .map_err(|e| e.to_string())
}

/// Arguments of `utm-sky view`.
#[derive(Debug, Args)]
#[command(
    group(ArgGroup::new("haze").args(HAZE)),
    after_help = "Examples:
  utm-sky view
  utm-sky view --scene terrain --altitude-km 3.5 --visual-range-km 60 --sun-zenith-deg 75
  utm-sky view --date 2025-06-21 --utc-h 4.5 --place 47.26,11.34 --tier baked --size 1920x1080
  utm-sky view --scene terrain --frames 30 --screenshot flight.png
  utm-sky view --lut plan.toml

Drag: look. W A S D and arrows: fly; E and Q, page up and down: up and down; Shift: faster; wheel:
speed. P: pause. F12: screenshot. Tab: panel. Azimuths are clockwise from north. Where there is no
display, utm-sky render draws the same."
)]
pub struct ViewArgs {
    /// Look-up table: a .utmlut file, a plan (.toml), which is baked first, or the built-in one
    #[arg(long, value_name = "FILE|embedded", default_value = "embedded", value_parser = lut_source)]
    pub lut: LutSource,
    /// Altitude of the observer above mean sea level, 0-30; without it 1 [km]
    #[arg(long, value_name = "KM", value_parser = within(0.0, 30.0),
          allow_negative_numbers = true)]
    pub altitude_km: Option<f64>,
    /// The haze; without it a turbidity of 2.5.
    #[command(flatten)]
    pub haze: HazeArgs,
    /// Angstrom exponent that belongs to --angstrom-beta; without it 1.3
    #[arg(long, value_name = "ALPHA", value_parser = within(-1.0, 4.0), requires = "angstrom_beta",
          allow_negative_numbers = true, help_heading = "Haze (one of)")]
    pub angstrom_alpha: Option<f64>,
    /// Zenith angle of the sun, 0-96; without it 60 [deg]
    #[arg(long, value_name = "DEG", value_parser = within(0.0, 96.0),
          allow_negative_numbers = true, help_heading = "Sun")]
    pub sun_zenith_deg: Option<f64>,
    /// Azimuth of the sun, clockwise from north [deg]
    #[arg(long, value_name = "DEG", default_value_t = 180.0, value_parser = within(-360.0, 360.0),
          allow_negative_numbers = true, help_heading = "Sun")]
    pub sun_azimuth_deg: f64,
    /// Date, in place of the sun's angles
    #[arg(long, value_name = "YYYY-MM-DD", value_parser = date, requires = "place",
          conflicts_with_all = ["sun_zenith_deg", "sun_azimuth_deg"], help_heading = "Sun")]
    pub date: Option<UtcTime>,
    /// Time on that date [h UTC]
    #[arg(long, value_name = "H", value_parser = within(0.0, 24.0), default_value_t = 12.0,
          requires = "date", help_heading = "Sun")]
    pub utc_h: f64,
    /// Latitude (north) and longitude (east) of the place on that date [deg]
    #[arg(long, value_name = "LAT,LON", value_parser = geo_place, requires = "date",
          allow_hyphen_values = true, help_heading = "Sun")]
    pub place: Option<[f64; 2]>,
    /// Where the camera looks, azimuth from north and elevation [deg]; without it toward the sun's
    /// azimuth, 5 above the horizontal
    #[arg(long, value_name = "AZ,EL", value_parser = look, allow_hyphen_values = true)]
    pub look: Option<[f64; 2]>,
    /// Vertical field of view [deg]
    #[arg(long, value_name = "DEG", default_value_t = 60.0, value_parser = within(1.0, 170.0))]
    pub fov_deg: f64,
    /// Size of the window [pixels]
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = size)]
    pub size: [u32; 2],
    /// GPU, by a part of its name; without it the fastest
    #[arg(long, value_name = "NAME")]
    pub adapter: Option<String>,
    /// How the sky is drawn; without it as a plan has it, else fragment
    #[arg(long, value_enum)]
    pub tier: Option<TierKind>,
    /// What stands under the sky
    #[arg(long = "scene", value_enum, default_value_t)]
    pub scenery: SceneKind,
    /// Leave the air between camera and scene out
    #[arg(long)]
    pub no_aerial: bool,
    /// Exposure value at ISO 100, or auto
    #[arg(long, value_name = "E|auto", default_value = "auto", value_parser = ev100,
          allow_hyphen_values = true)]
    pub ev100: Ev100,
    /// Tone curve
    #[arg(long, value_enum, default_value_t)]
    pub tone: ToneKind,
    /// Draw so many frames, then exit
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub frames: Option<u32>,
    /// The last frame as a picture, without the panel
    #[arg(long, value_name = "PNG")]
    pub screenshot: Option<PathBuf>,
    /// For tests: destroy the device after so many frames
    #[arg(long, value_name = "N", hide = true)]
    pub lose_device_after: Option<u32>,
}

/// Arguments of `utm-sky gallery`.
#[derive(Debug, Args)]
#[command(after_help = "Example:
  utm-sky gallery --out gallery

Writes gallery.png, one contact sheet, and gallery.html, the same with captions.")]
pub struct GalleryArgs {
    /// Look-up table: a .utmlut file, a plan (.toml), which is baked first, or the built-in one
    #[arg(long, value_name = "FILE|embedded", default_value = "embedded", value_parser = lut_source)]
    pub lut: LutSource,
    /// Who draws
    #[arg(long, value_enum, default_value_t)]
    pub backend: Backend,
    /// Directory
    #[arg(long, value_name = "DIR", default_value = "target/utm-sky/gallery")]
    pub out: PathBuf,
}

/// Arguments of `utm-sky chart`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  utm-sky chart
  utm-sky chart --models utm-sky,hillaire,preetham --quick --out chart

Measures error against the transport engine and cost of every model in one run, and writes chart.csv,
chart.svg and chart.html. --quick takes fewer cases and one picture size.")]
pub struct ChartArgs {
    /// Models to compare, by name; without it all (see utm-sky models)
    #[arg(long, value_name = "A,B", value_delimiter = ',')]
    pub models: Vec<String>,
    /// Fewer cases and frames
    #[arg(long)]
    pub quick: bool,
    /// Directory
    #[arg(long, value_name = "DIR", default_value = "target/utm-sky/chart")]
    pub out: PathBuf,
}

/// Arguments of `utm-sky light`.
#[derive(Debug, Args)]
#[command(
    group(ArgGroup::new("haze").required(true).args(HAZE)),
    after_help = "Example:
  utm-sky light --altitude-km 3 --turbidity 2 --sun-zenith-deg 60

Prints JSON: sunlight on a plane facing the sun, skylight on a horizontal plane, light of the ground,
and sky and ground as nine spherical harmonics (x toward the sun's azimuth, z up)."
)]
pub struct LightArgs {
    /// Table, observer, sun and haze.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Albedo of the ground
    #[arg(long, value_name = "A", default_value_t = 0.2, value_parser = within(0.0, 1.0))]
    pub albedo: f64,
}

/// Arguments of `utm-sky bench-gpu`.
#[derive(Debug, Args)]
#[command(after_help = "Example:
  utm-sky bench-gpu --size 1920x1080 --out bench.csv

Times are of render passes on a 16-bit float target, by the GPU's own clock where it has one. The sky
fills the picture. With composite, a scene 50 km away covers its lower half.")]
pub struct BenchGpuArgs {
    /// Pixels
    #[arg(long, value_name = "WxH", default_value = "1920x1080", value_parser = size)]
    pub size: [u32; 2],
    /// Frames a case, taken in turn
    #[arg(long, value_name = "N", default_value_t = 30, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub frames: u32,
    /// Times
    #[arg(long, value_name = "CSV")]
    pub out: PathBuf,
}

/// A language that shaders are translated to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ShaderTarget {
    /// GLSL 4.50
    Glsl,
    /// GLSL ES 3.00 (WebGL2)
    GlslEs,
    /// HLSL, shader model 5.1
    Hlsl,
    /// Metal 2.0
    Msl,
    /// SPIR-V 1.3
    Spirv,
}

/// Arguments of `utm-sky export-shaders`.
#[derive(Debug, Args)]
#[command(after_help = "Example:
  utm-sky export-shaders --target glsl-es --out shaders-es

Writes every entry point, the table as plain floats (sky.bin) and a header that documents it (sky.h).")]
pub struct ExportShadersArgs {
    /// Language
    #[arg(long, value_enum)]
    pub target: ShaderTarget,
    /// Look-up table: a .utmlut file, a plan (.toml), which is baked first, or the built-in one
    #[arg(long, value_name = "FILE|embedded", default_value = "embedded", value_parser = lut_source)]
    pub lut: LutSource,
    /// Directory
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

/// Which altitudes, turbidities and suns a table has.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum GridChoice {
    /// The report's 75 maps.
    Seed,
    /// The grid that meets the project's accuracy.
    Default,
    /// Axes from a TOML file.
    File(PathBuf),
}

fn grid_choice(text: &str) -> Result<GridChoice, &'static str> {
    match text {
        "seed" => Ok(GridChoice::Seed),
        "default" => Ok(GridChoice::Default),
        path if path.ends_with(".toml") => Ok(GridChoice::File(path.into())),
        _ => Err("expected seed, default or the path of a .toml file"),
    }
}

/// `utm-sky generate`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  utm-sky generate
  utm-sky generate --grid seed --engine smarts --out my-sky
  utm-sky generate --plan plan.toml --out runway

A plan's table comes without a report: utm-sky plan --verify measures it on its own scene.")]
pub struct GenerateArgs {
    /// Profile of the atmosphere: a CSV file or the name of a shipped one
    #[arg(long, value_name = "CSV|NAME", default_value = "general")]
    pub profile: PathBuf,
    /// Plan of `utm-sky plan`, instead of a grid
    #[arg(long, value_name = "TOML", conflicts_with_all = ["grid", "engine", "profile"])]
    pub plan: Option<PathBuf>,
    /// Altitudes, turbidities and suns: seed, default or a TOML file
    #[arg(long, value_name = "seed|default|TOML", default_value = "default",
          value_parser = grid_choice)]
    pub grid: GridChoice,
    /// How the radiance is computed
    #[arg(long, default_value = "transport")]
    pub engine: Engine,
    /// Directory for sky.utmlut, coefficients.csv, report.html and report.csv; made if missing
    #[arg(long, value_name = "DIR", default_value = "target/utm-sky")]
    pub out: PathBuf,
}

/// What `utm-sky plan --explain` leaves out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PlanTerm {
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
    /// The faint stratospheric layer
    Stratosphere,
    /// The light that the ground reflects
    Ground,
}

impl PlanTerm {
    /// The name on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ozone => "ozone",
            Self::No2 => "no2",
            Self::OxygenPairs => "o2o2",
            Self::Oxygen => "o2",
            Self::Water => "h2o",
            Self::Stratosphere => "stratosphere",
            Self::Ground => "ground",
        }
    }
}

/// `utm-sky plan`.
#[derive(Debug, Args)]
#[command(
    group(ArgGroup::new("task").required(true).args(["scene", "verify", "ledger"])),
    after_help = "Examples:
  utm-sky plan profiles/scenes/runway_noon.toml --out plan.toml
  utm-sky plan profiles/scenes/airliner_dusk.toml --explain ozone
  utm-sky plan --verify plan.toml --cases 500 --seed 1
  utm-sky plan --ledger --out ledger.csv

Errors are 95th percentiles over the directions of cases that were not fitted, against the transport
engine with every constituent; the sun's 5 degrees are left out."
)]
pub struct PlanArgs {
    /// The scene: ranges, tolerance and budget (see profiles/scenes/README.md)
    #[arg(value_name = "SCENE.toml")]
    pub scene: Option<PathBuf>,
    /// The plan; without it plan.toml. With --ledger the ledger as CSV
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Instead of planning: what the scene loses without a term, with a picture beside the plan
    #[arg(long, value_enum, value_name = "TERM", requires = "scene")]
    pub explain: Option<PlanTerm>,
    /// Measure a plan's table on fresh random cases of its scene
    #[arg(long, value_name = "PLAN.toml")]
    pub verify: Option<PathBuf>,
    /// Cases to verify on
    #[arg(long, value_name = "N", default_value_t = 500, requires = "verify",
          value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub cases: u32,
    /// Seed of those cases
    #[arg(long, value_name = "S", default_value_t = 1, requires = "verify")]
    pub seed: u64,
    /// The table to verify; without it the plan is baked
    #[arg(long, value_name = "FILE|embedded", value_parser = lut_source, requires = "verify")]
    pub lut: Option<LutSource>,
    /// Print what each constituent of the air is worth over the whole domain
    #[arg(long)]
    pub ledger: bool,
}

/// `utm-sky report`.
#[derive(Debug, Args)]
#[command(after_help = "Example:
  utm-sky report --lut target/utm-sky/sky.utmlut --out target/utm-sky")]
pub struct ReportArgs {
    /// Look-up table: a .utmlut file, a plan (.toml), which is baked first, or the built-in one
    #[arg(long, value_name = "FILE|embedded", default_value = "embedded", value_parser = lut_source)]
    pub lut: LutSource,
    /// Directory for report.html and report.csv; made if missing
    #[arg(long, value_name = "DIR", default_value = "target/utm-sky")]
    pub out: PathBuf,
}

/// `utm-sky atlas`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  utm-sky atlas --quick
  utm-sky atlas --models utm-sky,utm2005 --out atlas

atlas.csv has a row for each model, arithmetic, kind of failure and side of the model's domain:
samples, failures, the largest score and a command that shows it. What the score of a kind is,
and above which limit it is a failure, stands in atlas.html. The tables that were made for the sweep
are written beside it.")]
pub struct AtlasArgs {
    /// Fewer samples, for a first look, and only the models that are quick themselves
    #[arg(long)]
    pub quick: bool,
    /// Models, separated by commas; without it all of `utm-sky models` but our own tiers
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    pub models: Option<Vec<String>>,
    /// Directory for atlas.csv and atlas.html; made if missing
    #[arg(long, value_name = "DIR", default_value = "target/utm-sky/atlas")]
    pub out: PathBuf,
}

/// `utm-sky fit-stress`.
#[derive(Debug, Args)]
#[command(after_help = "Example:
  utm-sky fit-stress --quick --out fits

fit_stress.csv has a row for each sky, channel, damage and method.
  method              safeguarded: as tables are fitted, a random start added; one_start: the random
                      start alone; plain: Levenberg-Marquardt on the printed coefficients
  refused             fits that ended in an error that names what is wrong with the map
  no_sky              fits that ended at coefficients that are not positive everywhere
  succeeded           skies within 1 % of the best residual of a sky on the same map
  best_rms            that residual (median over the damaged maps): of ln Y, or of x or y
  radiance_median     how far the fitted sky is from the undamaged one's, 95th percentile over the
  radiance_worst      directions: share of luminance, or x or y
  condition_median    condition number of the samples' Jacobian
  evaluations_median  evaluations of the formula over all samples
  evaluations_most")]
pub struct FitStressArgs {
    /// Fewer fits, for a first look
    #[arg(long)]
    pub quick: bool,
    /// Directory for the CSV file; made if missing
    #[arg(long, value_name = "DIR", default_value = "target/utm-sky/fit-stress")]
    pub out: PathBuf,
}

/// `utm-sky lut`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  utm-sky lut info target/utm-sky/sky.utmlut
  utm-sky lut export target/utm-sky/sky.utmlut --csv coefficients.csv")]
pub struct LutArgs {
    /// What to do with the table.
    #[command(subcommand)]
    pub command: LutCommand,
}

/// The commands on a look-up table.
#[derive(Debug, Subcommand)]
pub enum LutCommand {
    /// Print what the table says about itself
    #[command(after_help = "Example:
  utm-sky lut info target/utm-sky/sky.utmlut")]
    Info {
        /// Look-up table: a .utmlut file, a plan (.toml) or the word embedded
        #[arg(value_name = "FILE|embedded", value_parser = lut_source)]
        lut: LutSource,
    },
    /// Write the coefficients in the layout of the report's Appendix A
    #[command(after_help = "Example:
  utm-sky lut export target/utm-sky/sky.utmlut --csv coefficients.csv")]
    Export {
        /// Look-up table: a .utmlut file, a plan (.toml) or the word embedded
        #[arg(value_name = "FILE|embedded", value_parser = lut_source)]
        lut: LutSource,
        /// The coefficients
        #[arg(long, value_name = "CSV")]
        csv: PathBuf,
    },
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_definitions_are_consistent() {
        Cli::command().debug_assert();
    }

    /// Every command, with its path.
    fn all_commands(command: &clap::Command, path: &str) -> Vec<(String, clap::Command)> {
        let mut found = Vec::new();
        for sub in command.get_subcommands() {
            let path = format!("{path} {}", sub.get_name());
            found.extend(all_commands(sub, &path));
            found.push((path, sub.clone()));
        }
        found
    }

    #[test]
    fn every_command_has_an_example_that_parses() {
        for (path, mut command) in all_commands(&Cli::command(), "utm-sky") {
            let help = command.render_long_help().to_string();
            let (_, examples) = help
                .split_once("Example")
                .unwrap_or_else(|| panic!("{path} has no example"));
            let joined = examples.replace("\\\n", " ");
            let lines: Vec<&str> = joined
                .lines()
                .map(str::trim)
                .filter(|l| l.starts_with("utm-sky "))
                .collect();
            assert!(!lines.is_empty(), "{path} has no example");
            for line in lines {
                assert!(line.starts_with(&path), "{line} is no example of {path}");
                if let Err(error) = Cli::try_parse_from(line.split_whitespace()) {
                    panic!("{line}: {error}");
                }
            }
        }
    }

    fn refused(line: &str) -> String {
        Cli::try_parse_from(line.split_whitespace())
            .expect_err(line)
            .to_string()
    }

    #[test]
    fn values_outside_their_range_name_the_option_and_the_range() {
        let rest = "--aod500 0.1 --out o.csv";
        for (options, option, expected) in [
            (
                "--altitude-km 31 --sun-zenith-deg 60",
                "--altitude-km",
                "0 to 30",
            ),
            (
                "--altitude-km -1 --sun-zenith-deg 60",
                "--altitude-km",
                "0 to 30",
            ),
            (
                "--altitude-km nan --sun-zenith-deg 60",
                "--altitude-km",
                "0 to 30",
            ),
            (
                "--altitude-km 1 --sun-zenith-deg 96.1",
                "--sun-zenith-deg",
                "0 to 96",
            ),
            (
                "--altitude-km 1 --sun-zenith-deg x",
                "--sun-zenith-deg",
                "0 to 96",
            ),
            (
                "--altitude-km 1 --sun-zenith-deg 60 --albedo 2",
                "--albedo",
                "0 to 1",
            ),
        ] {
            let message = refused(&format!("utm-sky map {options} {rest}"));
            assert!(message.contains(option), "{message}");
            assert!(message.contains(expected), "{message}");
        }
    }
}
