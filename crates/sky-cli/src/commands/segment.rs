//! `utm-sky segment`: transmittance and in-scattered light of finite paths.

use std::fmt::Write as _;
use std::path::PathBuf;

use anyhow::{Result, bail};
use clap::{ArgGroup, Args, ValueEnum};
use sky_core::aerial::{AerialFrame, AerialPath, path_meets_ground};
use sky_core::color::{LinearSrgb, xyz_from_linear_srgb, yxy_from_xyz};
use sky_core::direction::SkyDirection;
use sky_core::quantity::single;
use sky_science::utm2005::path_utm2005;
use sky_sim::table::{ColumnSpec, Table};

use crate::args::{HAZE, SceneArgs};
use crate::io::files::{OutputFile, read_text};
use crate::io::scene::Scene;
use crate::io::table::DIRECTION_COLUMNS;
use crate::io::table::numbers;

/// Help of `--segments`.
const SEGMENTS_HELP: &str =
    "Paths: CSV with view_zenith_deg,relative_azimuth_deg (0 faces the sun),distance_km";

/// Which aerial perspective.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Aerial {
    /// From the table and the extinction of its air
    #[default]
    Default,
    /// As in the report of 2005, with its misprints mended
    Utm2005,
}

/// `utm-sky segment`.
#[derive(Debug, Args)]
#[command(
    group(ArgGroup::new("haze").required(true).args(HAZE)),
    after_help = "Example:
  utm-sky segment --altitude-km 3 --turbidity 2 --sun-zenith-deg 60 \\
      --segment 90,0,20 --segment 95,180,10 --out paths.csv

A path is a straight ray over a sphere of 6371 km. Transmittances are those of sunlight in linear
sRGB and luminance; in-scattered light is what the air of the path adds."
)]
pub struct SegmentArgs {
    /// Table, observer, sun and haze.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Paths: CSV with zenith angle, azimuth and length of each
    #[arg(long, value_name = "CSV", help = SEGMENTS_HELP, required_unless_present = "segment")]
    pub segments: Option<PathBuf>,
    /// A path by view zenith angle, azimuth (0 faces the sun) and length [deg, deg, km]; may be repeated
    #[arg(long, value_name = "ZENITH,AZIMUTH,KM", value_parser = segment, conflicts_with = "segments",
          allow_hyphen_values = true)]
    pub segment: Vec<[f64; 3]>,
    /// Which aerial perspective
    #[arg(long, value_enum, default_value_t)]
    pub aerial: Aerial,
    /// The same columns, transmittances and in-scattered light
    #[arg(long, value_name = "CSV")]
    pub out: PathBuf,
}

fn segment(text: &str) -> Result<[f64; 3], String> {
    numbers(text, &COLUMNS)
}

const COLUMNS: [ColumnSpec; 3] = [
    DIRECTION_COLUMNS[0],
    DIRECTION_COLUMNS[1],
    ColumnSpec::required("distance_km", [0.0, 1000.0]),
];

/// Runs the command.
///
/// # Errors
/// When an input is wrong, the table cannot answer, a path ends in the ground, or the output cannot
/// be written.
pub fn run(args: &SegmentArgs) -> Result<()> {
    let paths = paths(args)?;
    let scene = Scene::open(&args.scene)?;
    let conditions = &scene.conditions;
    let frame = scene.frame()?;
    let air = AerialFrame::new(&scene.sky, conditions.turbidity, conditions.sun_zenith)
        .map_err(|e| scene.refusal(e))?;
    let out = OutputFile::create(&args.out)?;
    let mut text = String::from(
        "view_zenith_deg,relative_azimuth_deg,distance_km,transmittance_r,transmittance_g,\
         transmittance_b,transmittance_y,inscatter_luminance_cd_m2,inscatter_x,inscatter_y\n",
    );
    for (place, [zenith, azimuth, distance]) in &paths {
        let direction = SkyDirection::from_degrees(*zenith, *azimuth).unit_vector();
        let altitude_km = single(conditions.observer_altitude.km());
        let distance_km = single(*distance);
        if path_meets_ground(altitude_km, direction, distance_km) {
            bail!("{place}: distance_km: expected a point above the ground, found {distance}");
        }
        let path = match args.aerial {
            Aerial::Default => air.path(altitude_km, direction, distance_km),
            Aerial::Utm2005 => path_utm2005(&air, &frame, altitude_km, direction, distance_km),
        };
        write_row(&mut text, [*zenith, *azimuth, *distance], &path)?;
    }
    out.commit(text.as_bytes())?;
    Ok(())
}

/// Zenith angle, azimuth and length of each path \[deg, deg, km\], and where it was given.
fn paths(args: &SegmentArgs) -> Result<Vec<(String, [f64; 3])>> {
    let Some(path) = &args.segments else {
        let numbered = args.segment.iter().enumerate();
        return Ok(numbered
            .map(|(i, path)| (format!("--segment {}", i + 1), *path))
            .collect());
    };
    let name = path.display().to_string();
    let table = Table::read(&name, &read_text(path)?, &COLUMNS, 1)?;
    let [zeniths, azimuths, lengths] = [0, 1, 2].map(|column| table.column(column));
    Ok((0..table.line.len())
        .map(|i| {
            let place = format!("{name}:{}: path {}", table.line[i], i + 1);
            (place, [zeniths[i], azimuths[i], lengths[i]])
        })
        .collect())
}

fn write_row(text: &mut String, place: [f64; 3], path: &AerialPath) -> Result<()> {
    let [red, green, blue] = path.inscatter.map(f64::from);
    let light = yxy_from_xyz(xyz_from_linear_srgb(LinearSrgb { red, green, blue }));
    let [r, g, b, y] = path.transmittance;
    writeln!(
        text,
        "{},{},{},{r},{g},{b},{y},{},{},{}",
        place[0], place[1], place[2], light.luminance_cd_m2, light.x, light.y
    )?;
    Ok(())
}
