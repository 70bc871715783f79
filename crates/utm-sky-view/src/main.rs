//! The window of the `utm-sky` command, which `utm-sky view` starts: arguments to a flight, pictures to
//! files.

use std::io::{Write as _, stderr};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Result, anyhow, bail};
use sky_cli::args::{SceneKind, TierKind};
use sky_cli::commands::view::{ViewArgs, ViewCli};
use sky_cli::io::files::{EXIT_FAILURE, OutputFile, clean_up_on_interrupt, has_extension};
use sky_cli::io::lut::{load, source_name};
use sky_core::conditions::{Conditions, Domain};
use sky_core::haze::Haze;
use sky_core::lut::LutHeader;
use sky_core::quantity::{Angle, Length};
use sky_core::solar_position::{GeoPlace, SunPosition, UtcTime};
use sky_core::utm_sky::UtmSky;
use sky_gpu::Tier;
use sky_plan::plan::without_aerial;
use sky_render::file_bytes;
use sky_view::flight::{Flight, HazeWord, Sun};
use sky_view::panel::Controls;
use sky_view::window::{Screenshot, Start, run};

fn main() -> ExitCode {
    let args = match ViewCli::read(std::env::args_os()) {
        Ok(args) => args,
        Err(status) => return status,
    };
    clean_up_on_interrupt();
    match fly(&args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            drop(writeln!(stderr(), "error: {error}"));
            ExitCode::from(EXIT_FAILURE)
        }
    }
}

/// Opens the window, and writes the last frame where that was asked for.
fn fly(args: &ViewArgs) -> Result<()> {
    if let Some(path) = &args.screenshot
        && !has_extension(path, "png")
    {
        bail!(
            "--screenshot: expected a name ending in .png, found {}",
            path.display()
        );
    }
    let source = source_name(&args.lut);
    let sky = UtmSky::new(load(&args.lut)?).map_err(|e| anyhow!("{source}: {e}"))?;
    let screenshot = args
        .screenshot
        .as_deref()
        .map(OutputFile::create)
        .transpose()?;
    let controls = controls(args, sky.lut().header())?;
    if args.screenshot.is_some() {
        // the picture is without what the window says over it
        check(args, &controls, sky.domain()).map_err(|e| anyhow!("{source}: {e}"))?;
    }
    let picture = run(Start {
        controls,
        sky,
        size: args.size,
        adapter: args.adapter.clone(),
        fov: Angle::from_degrees(args.fov_deg),
        frames: args.frames,
        lose_device_after: args.lose_device_after,
        wants_last_picture: args.screenshot.is_some(),
        keep,
    })?;
    if let Some(file) = screenshot {
        let Some(picture) = picture else {
            bail!("--screenshot: expected a picture, found the window closed before the first");
        };
        file.commit(&file_bytes(&picture.pixels, picture.size)?)?;
    }
    Ok(())
}

/// Writes a picture under the first free name here, and says which.
fn keep(picture: &Screenshot) -> String {
    let name = (1_u32..)
        .map(|n| PathBuf::from(format!("utm-sky-{n:03}.png")))
        .find(|path| !path.exists());
    let path = name.unwrap_or_default();
    match write(&path, picture) {
        Ok(()) => format!("wrote {}", path.display()),
        Err(error) => format!("{error}"),
    }
}

fn write(path: &Path, picture: &Screenshot) -> Result<()> {
    OutputFile::create(path)?.commit(&file_bytes(&picture.pixels, picture.size)?)?;
    Ok(())
}

/// Whether the flight starts inside the table's domain.
fn check(args: &ViewArgs, controls: &Controls, domain: &Domain) -> Result<()> {
    let (word, value) = controls.haze;
    let conditions = Conditions::new(
        Length::from_km(controls.flight.altitude_km),
        word.haze(value),
        controls.sun.position()?.zenith,
    )?;
    domain.check(&conditions).map_err(|outside| {
        let haze = args.haze.haze(args.angstrom_alpha);
        haze.map_or(outside, |haze| outside.in_words_of(haze))
            .into()
    })
}

/// Where the flight starts. What the arguments leave open lies inside the table's domain.
fn controls(args: &ViewArgs, header: &LutHeader) -> Result<Controls> {
    let domain = &header.domain;
    let inside = |value: f64, [low, high]: [f64; 2]| value.clamp(low, high);
    let haze = args
        .haze
        .haze(args.angstrom_alpha)
        .unwrap_or_else(|| Haze::Turbidity(inside(2.5, domain.turbidity)));
    let depth = haze.optical_depth_500().map_err(|e| anyhow!("haze: {e}"))?;
    let haze = match haze {
        Haze::Turbidity(value) => (HazeWord::Turbidity, value),
        Haze::VisualRange(range) => (HazeWord::VisualRange, range.km()),
        Haze::OpticalDepth500(_) | Haze::Angstrom { .. } => (HazeWord::OpticalDepth, depth),
    };
    let sun = sun(args, inside(60.0, domain.sun_zenith_deg));
    let toward_sun = sun.position()?.azimuth.degrees();
    Ok(Controls {
        flight: Flight {
            place_km: [0.0; 2],
            altitude_km: args
                .altitude_km
                .unwrap_or_else(|| inside(1.0, domain.altitude_km)),
            look_deg: args.look.unwrap_or([toward_sun, 5.0]),
            speed_km_s: 0.25,
        },
        sun,
        haze,
        tier: args
            .tier
            .map(Tier::from)
            .or_else(|| Tier::planned(header))
            .unwrap_or_else(|| TierKind::default().into()),
        tone: args.tone.into(),
        ev100: args.ev100.0,
        terrain: args.scenery == SceneKind::Terrain,
        aerial: !args.no_aerial && !without_aerial(header),
        sun_disc: true,
        stripes: false,
        paused: false,
        panel: true,
        screenshot: false,
    })
}

/// The sun of the arguments; where they leave it open, `zenith_deg` from the zenith.
fn sun(args: &ViewArgs, zenith_deg: f64) -> Sun {
    let up = args.sun_elevation_deg;
    let asked = args.sun_zenith_deg.or(up.map(|up| 90.0 - up));
    match (args.date, args.place) {
        (Some(date), Some([latitude, longitude])) => Sun::Clock {
            time: UtcTime {
                hours: args.utc_h,
                ..date
            },
            place: GeoPlace {
                latitude: Angle::from_degrees(latitude),
                longitude: Angle::from_degrees(longitude),
                altitude: Length::ZERO,
            },
            hours_per_s: 0.0,
        },
        _ => Sun::Angles(SunPosition {
            zenith: Angle::from_degrees(asked.unwrap_or(zenith_deg)),
            azimuth: Angle::from_degrees(args.sun_azimuth_deg.rem_euclid(360.0)),
        }),
    }
}
