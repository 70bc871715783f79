//! `utm-sky segment`: transmittance and in-scattered light of finite paths.

use std::fmt::Write as _;
use std::path::PathBuf;

use anyhow::{Result, anyhow, bail};
use clap::{ArgGroup, Args, ValueEnum};
use sky_core::aerial::{AerialFrame, AerialPath, path_meets_ground};
use sky_core::color::{LinearSrgb, Yxy, linear_srgb_from_xyz, xyz_from_linear_srgb, yxy_from_xyz};
use sky_core::direction::SkyDirection;
use sky_core::quantity::{Length, single};
use sky_eval::engine::{self, Air, depth_under_ground, transport_paths};
use sky_eval::truth::DEFAULT_GROUND_ALBEDO;
use sky_science::cie::ColorWeights;
use sky_science::spectrum::Spectrum;
use sky_science::utm2005::path_utm2005;
use sky_sim::optics::OpticsSettings;
use sky_sim::profile::AtmosphereProfile;
use sky_sim::solar::SolarSpectrum;
use sky_sim::table::{ColumnSpec, Table};
use sky_sim::transport::Sight;

use crate::args::{AnyPlaceArgs, HAZE, HazeArgs, LutSource, SceneArgs, lut_source, within};
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

/// Who answers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum PathEngine {
    /// A table, as a simulator reads it
    #[default]
    Table,
    /// The transport engine, which the tables are judged by: light integrated along the path, in the
    /// general atmosphere
    Transport,
}

/// `utm-sky segment`.
#[derive(Debug, Args)]
#[command(
    group(ArgGroup::new("haze").required(true).args(HAZE)),
    after_help = "Examples:
  utm-sky segment --altitude-km 3 --turbidity 2 --sun-zenith-deg 60 \\
      --segment 90,0,20 --segment 95,180,10 --out paths.csv
  utm-sky segment --altitude-km 40 --turbidity 2 --sun-zenith-deg 95 --engine transport \\
      --segment 95,0,300 --out truth.csv

A path is a straight ray over a sphere of 6371 km. Transmittances are those of sunlight in linear
sRGB and luminance; in-scattered light is what the air of the path adds."
)]
pub struct SegmentArgs {
    /// Look-up table: a .utmlut file, a plan (.toml), which is baked first, or the built-in one
    #[arg(long, value_name = "FILE|embedded", default_value = "embedded", value_parser = lut_source)]
    pub lut: LutSource,
    /// Observer and sun.
    #[command(flatten)]
    pub place: AnyPlaceArgs,
    /// The haze.
    #[command(flatten)]
    pub haze: HazeArgs,
    /// Angstrom exponent that belongs to --angstrom-beta; without it 1.3
    #[arg(long, value_name = "ALPHA", value_parser = within(-1.0, 4.0), requires = "angstrom_beta",
          allow_negative_numbers = true, help_heading = "Haze (one of)")]
    pub angstrom_alpha: Option<f64>,
    /// Who answers
    #[arg(long, value_enum, default_value_t)]
    pub engine: PathEngine,
    /// Albedo of the ground (Lambertian), which lights the air; without it 0.2. With --engine transport:
    /// a table has its own
    #[arg(long, value_name = "A", value_parser = within(0.0, 1.0), allow_negative_numbers = true)]
    pub albedo: Option<f64>,
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
/// Distance of the transport engine's wavelengths \[nm\].
const STEP_NM: u16 = 10;

/// How far a path may lead under the ground \[km\]: a meter, for the rounding of files.
const SLACK_KM: f64 = 1e-3;

const COLUMNS: [ColumnSpec; 3] = [
    DIRECTION_COLUMNS[0],
    DIRECTION_COLUMNS[1],
    ColumnSpec::required("distance_km", [0.0, 1000.0]),
];

/// Head of the answer.
const HEAD: &str = "view_zenith_deg,relative_azimuth_deg,distance_km,transmittance_r,transmittance_g,\
     transmittance_b,transmittance_y,inscatter_luminance_cd_m2,inscatter_x,inscatter_y\n";

/// The paths that are asked for.
struct Paths {
    /// Their file and the line of each; nothing where they were given one by one.
    source: Option<(String, Vec<u64>)>,
    /// Zenith angle and azimuth \[deg\], length \[km\].
    rows: Vec<[f64; 3]>,
}

impl Paths {
    fn read(args: &SegmentArgs) -> Result<Self> {
        let Some(path) = &args.segments else {
            return Ok(Self {
                source: None,
                rows: args.segment.clone(),
            });
        };
        let name = path.display().to_string();
        let table = Table::read(&name, &read_text(path)?, &COLUMNS, 1)?;
        let rows = (0..table.line.len())
            .map(|row| [0, 1, 2].map(|column| table.column(column)[row]))
            .collect();
        Ok(Self {
            source: Some((name, table.line)),
            rows,
        })
    }

    /// What is said of a path that leads under the ground.
    fn meets_ground(&self, path: usize) -> anyhow::Error {
        let place = self
            .source
            .as_ref()
            .map_or_else(String::new, |(file, lines)| {
                format!("{file}:{}: ", lines[path])
            });
        anyhow!(
            "{place}path {}: distance_km: expected a point above the ground, found {}",
            path + 1,
            self.rows[path][2]
        )
    }
}

/// Runs the command.
///
/// # Errors
/// When an input is wrong, the table cannot answer, a path ends in the ground, or the output cannot
/// be written.
pub fn run(args: &SegmentArgs) -> Result<()> {
    let paths = Paths::read(args)?;
    let text = match args.engine {
        PathEngine::Table => of_table(args, &paths)?,
        PathEngine::Transport => of_transport(args, &paths)?,
    };
    OutputFile::create(&args.out)?.commit(text.as_bytes())?;
    Ok(())
}

fn of_table(args: &SegmentArgs, paths: &Paths) -> Result<String> {
    if let Some(albedo) = args.albedo {
        bail!("--albedo: expected with --engine transport, found {albedo}: a table has its own");
    }
    let scene = Scene::open(&SceneArgs {
        lut: args.lut.clone(),
        place: args.place.into(),
        haze: args.haze,
        angstrom_alpha: args.angstrom_alpha,
    })?;
    let conditions = &scene.conditions;
    let frame = scene.frame()?;
    let air = AerialFrame::new(&scene.sky, conditions.turbidity, conditions.sun_zenith)
        .map_err(|e| scene.refusal(e))?;
    let mut text = String::from(HEAD);
    for (i, row) in paths.rows.iter().enumerate() {
        let [zenith, azimuth, distance] = *row;
        let direction = SkyDirection::from_degrees(zenith, azimuth).unit_vector();
        let altitude_km = single(conditions.observer_altitude.km());
        let distance_km = single(distance);
        if path_meets_ground(altitude_km, direction, distance_km) {
            return Err(paths.meets_ground(i));
        }
        let path = match args.aerial {
            Aerial::Default => air.path(altitude_km, direction, distance_km),
            Aerial::Utm2005 => path_utm2005(&air, &frame, altitude_km, direction, distance_km),
        };
        let AerialPath {
            transmittance,
            inscatter: [red, green, blue],
        } = path;
        let [red, green, blue] = [red, green, blue].map(f64::from);
        let light = yxy_from_xyz(xyz_from_linear_srgb(LinearSrgb { red, green, blue }));
        write_row(&mut text, row, transmittance, light)?;
    }
    Ok(text)
}

fn of_transport(args: &SegmentArgs, paths: &Paths) -> Result<String> {
    if args.lut != LutSource::Embedded {
        bail!("--lut: expected with --engine table");
    }
    if args.aerial != Aerial::Default {
        bail!("--aerial: expected with --engine table");
    }
    let settings = OpticsSettings {
        haze: args
            .haze
            .haze(args.angstrom_alpha)
            .ok_or_else(|| anyhow!("haze: expected one of {HAZE:?}"))?,
        ..OpticsSettings::with_step_nm(STEP_NM)?
    };
    let sun = SolarSpectrum::g173();
    let sun = Spectrum::new(sun.wavelength_nm, sun.irradiance_w_m2_nm)?;
    let weights = ColorWeights::for_radiance_ratio(&settings.wavelength_nm, &sun)?;
    let wavelengths = settings.wavelength_nm.len();
    let scene = engine::Scene {
        observer_altitude: Length::from_km(args.place.altitude_km),
        sun_zenith: args.place.sun_zenith(),
        ground_albedo: args.albedo.unwrap_or(DEFAULT_GROUND_ALBEDO),
    };
    let sights: Vec<Sight> = paths
        .rows
        .iter()
        .map(|[zenith, azimuth, distance]| Sight {
            direction: SkyDirection::from_degrees(*zenith, *azimuth),
            length: Some(Length::from_km(*distance)),
        })
        .collect();
    let under = |sight| depth_under_ground(scene, sight).is_some_and(|d| d.km() > SLACK_KM);
    if let Some(path) = sights.iter().position(under) {
        return Err(paths.meets_ground(path));
    }
    let air = Air::Profile {
        profile: Box::new(AtmosphereProfile::general()),
        settings,
    };
    let light = transport_paths(&air, scene, &sights)?;
    let srgb = |spectrum: &[f64]| {
        let LinearSrgb { red, green, blue } = linear_srgb_from_xyz(weights.xyz(spectrum));
        [red, green, blue]
    };
    let sunlight = vec![1.0; wavelengths];
    let (whole_rgb, whole) = (srgb(&sunlight), weights.yxy(&sunlight));
    let mut text = String::from(HEAD);
    let spectra = light
        .transmittance
        .chunks_exact(wavelengths)
        .zip(light.inscatter.chunks_exact(wavelengths));
    for (row, (transmittance, inscatter)) in paths.rows.iter().zip(spectra) {
        let rgb = srgb(transmittance);
        let luminance = weights.yxy(transmittance).luminance_cd_m2 / whole.luminance_cd_m2;
        let [r, g, b] = [0, 1, 2].map(|i| rgb[i] / whole_rgb[i]);
        let transmittance = [r, g, b, luminance].map(single);
        write_row(&mut text, row, transmittance, weights.yxy(inscatter))?;
    }
    Ok(text)
}

fn write_row(
    text: &mut String,
    [zenith, azimuth, distance]: &[f64; 3],
    [r, g, b, y]: [f32; 4],
    light: Yxy,
) -> Result<()> {
    writeln!(
        text,
        "{zenith},{azimuth},{distance},{r},{g},{b},{y},{},{},{}",
        light.luminance_cd_m2, light.x, light.y
    )?;
    Ok(())
}
