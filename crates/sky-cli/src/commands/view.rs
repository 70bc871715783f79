//! `utm-sky view`: starts the window, which is a program of its own.
//!
//! `utm-sky-view` links the window system, and nothing else does, so that no other command waits for it
//! to be built. It stands beside this program where both are installed. Under `cargo run` it is cargo
//! that runs it, and builds it where it must.

use std::env;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use anyhow::{Result, anyhow, bail};
use clap::{ArgGroup, Args, Parser};
use sky_core::quantity::{Angle, Length};
use sky_core::solar_position::{GeoPlace, UtcTime, sun_position};

use crate::args::{
    Ev100, HAZE, HazeArgs, LutSource, SceneKind, TierKind, ToneKind, ev100, look, lut_source, size,
    within,
};
use crate::quiet::sockets;
use crate::tell::tell;

/// The package of the window's program.
const PACKAGE: &str = "utm-sky-view";

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

/// `utm-sky view`.
#[derive(Debug, Args)]
#[command(
    group(ArgGroup::new("haze").args(HAZE)),
    after_help = "Examples:
  utm-sky view
  utm-sky view --scene terrain --altitude-km 3.5 --visual-range-km 60 --sun-zenith-deg 75
  utm-sky view --date 2025-06-21 --utc-h 4.5 --place 47.26,11.34 --tier baked --size 1920x1080
  utm-sky view --scene terrain --frames 30 --screenshot flight.png

With --screenshot, conditions beyond the table's domain are an error; in the window they stop at its
edge, and it says so over the picture.

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
    /// Elevation of the sun, 90 less its zenith angle, in place of that, -6-90 [deg]
    #[arg(long, value_name = "DEG", value_parser = within(-6.0, 90.0), allow_negative_numbers = true,
          conflicts_with = "sun_zenith_deg", help_heading = "Sun")]
    pub sun_elevation_deg: Option<f64>,
    /// Azimuth of the sun, clockwise from north [deg]
    #[arg(long, value_name = "DEG", default_value_t = 180.0, value_parser = within(-360.0, 360.0),
          allow_negative_numbers = true, help_heading = "Sun")]
    pub sun_azimuth_deg: f64,
    /// Date, in place of the sun's angles
    #[arg(long, value_name = "YYYY-MM-DD", value_parser = date, requires = "place",
          conflicts_with_all = ["sun_zenith_deg", "sun_elevation_deg", "sun_azimuth_deg"],
          help_heading = "Sun")]
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
    /// How the sky is drawn; without it as a plan has it, else baked
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

/// The command line of the window's program: that of `utm-sky view` without the first word.
#[derive(Debug, Parser)]
#[command(
    name = "utm-sky view",
    bin_name = "utm-sky view",
    version,
    max_term_width = 100
)]
pub struct ViewCli {
    /// All of it.
    #[command(flatten)]
    pub view: ViewArgs,
}

impl ViewCli {
    /// Reads a command line; the first argument is the program's name.
    ///
    /// # Errors
    /// The exit status where there is nothing to do but to end: what is wrong, or the help, was told.
    pub fn read<I, T>(args: I) -> Result<ViewArgs, ExitCode>
    where
        I: IntoIterator<Item = T>,
        T: Into<OsString> + Clone,
    {
        Self::try_parse_from(args)
            .map(|cli| cli.view)
            .map_err(|message| tell(&message))
    }
}

/// Starts the window with arguments that have been checked: those behind the word `view`.
///
/// # Errors
/// When the window's program is not there or cannot be started.
pub fn run(args: &[OsString]) -> Result<ExitCode> {
    let here = env::current_exe()?;
    let mut command = window(&here, &|name| env::var_os(name))?;
    command.args(args);
    if let Some([name, value]) = sockets() {
        command.env(name, value);
    }
    start(command)
}

/// What starts the window's program: cargo where cargo runs this one, so that it is built and never
/// older than this one; else the neighbor of `here`, by the same name with `-view`.
fn window(here: &Path, environment: &dyn Fn(&str) -> Option<OsString>) -> Result<Command> {
    // cargo tells these to what it runs; to tests, it tells the names of other packages
    let is_run_by_cargo =
        environment("CARGO_PKG_NAME").is_some_and(|name| name == env!("CARGO_PKG_NAME"));
    if let (true, Some(cargo), Some(manifest)) = (
        is_run_by_cargo,
        environment("CARGO"),
        environment("CARGO_MANIFEST_DIR"),
    ) {
        let manifest = Path::new(&manifest).with_file_name(PACKAGE);
        let mut command = Command::new(cargo);
        command
            .args(["run", "--manifest-path"])
            .arg(manifest.join("Cargo.toml"));
        if here
            .parent()
            .is_some_and(|folder| folder.ends_with("release"))
        {
            command.arg("--release");
        }
        command.arg("--");
        return Ok(command);
    }
    let name = here.file_stem().unwrap_or_default().to_string_lossy();
    let program = here.with_file_name(format!("{name}-view{}", env::consts::EXE_SUFFIX));
    if !program.is_file() {
        bail!(
            "{}: expected the window's program, found nothing there; build it by cargo build --release \
             -p {PACKAGE}, or install it by cargo install --path crates/{PACKAGE}; utm-sky render \
             draws without a window",
            program.display()
        );
    }
    Ok(Command::new(program))
}

/// Becomes the other program.
#[cfg(unix)]
fn start(mut command: Command) -> Result<ExitCode> {
    use std::os::unix::process::CommandExt as _;
    let error = command.exec();
    Err(anyhow!(
        "{}: cannot be started: {error}",
        command.get_program().display()
    ))
}

/// Waits for the other program.
#[cfg(not(unix))]
fn start(mut command: Command) -> Result<ExitCode> {
    let status = command.status().map_err(|error| {
        anyhow!(
            "{}: cannot be started: {error}",
            command.get_program().display()
        )
    })?;
    let code = status.code().and_then(|code| u8::try_from(code).ok());
    Ok(code.map_or(ExitCode::FAILURE, ExitCode::from))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_window_stands_beside_this_program() {
        let folder = tempfile::tempdir().unwrap();
        let here = folder.path().join("utm-sky");
        let message = window(&here, &|_| None).unwrap_err().to_string();
        assert!(
            message.contains("utm-sky-view") && message.contains("cargo install"),
            "{message}"
        );
        let program = folder
            .path()
            .join(format!("{PACKAGE}{}", env::consts::EXE_SUFFIX));
        std::fs::write(&program, "").unwrap();
        assert_eq!(window(&here, &|_| None).unwrap().get_program(), program);
    }

    #[test]
    fn cargo_runs_the_window_where_it_runs_this_program() {
        let told = |package: &'static str| {
            move |name: &str| -> Option<OsString> {
                Some(match name {
                    "CARGO" => "cargo".into(),
                    "CARGO_PKG_NAME" => package.into(),
                    _ => "crates/sky-cli".into(),
                })
            }
        };
        let here = Path::new("target/release/utm-sky");
        let command = window(here, &told(env!("CARGO_PKG_NAME"))).unwrap();
        assert_eq!(command.get_program(), "cargo");
        assert!(command.get_args().any(|word| word == "--release"));
        assert!(
            window(here, &told("another")).is_err(),
            "a test of another package"
        );
    }
}
