//! `utm-sky generate`: profile → maps → fits → look-up table → report.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Duration;

use anyhow::{Result, anyhow};
use indicatif::{ProgressBar, ProgressStyle};
use serde::Deserialize;
use sky_core::axis::Axis;
use sky_core::conditions::Domain;
use sky_core::extinction::Extinction;
use sky_core::lut::{
    CHANNELS, ErrorQuantiles, FitStatistics, Form, Interpolation, Lut, LutHeader, Storage,
};
use sky_fit::sweep::{Grid, SkyMap, Sweep, sweep};
use sky_science::metrics::{Statistics, ciede2000_of_lights, relative_error, white_luminance};
use sky_science::sky_model::SkyModel;
use sky_science::table_sky::TableSky;
use sky_sim::optics::OpticsSettings;

use crate::args::{Engine, GenerateArgs, GridChoice};
use crate::atmosphere::{load_profile, profile_hash};
use crate::files::{OutputFile, create_directory, print, read_text};
use crate::plan::Plan;
use crate::report::{create_outputs, write_report};
use crate::truth::{DEFAULT_GROUND_ALBEDO, SmartsSkyModel, TransportSky};

/// Wavelength step of the maps \[nm\]. The report's convergence table: 20 nm shows with the sun at the
/// horizon (ΔE 1.7), 10 nm does not.
pub const MAP_STEP_NM: u16 = 10;

/// A grid file: the axes, and optionally the form.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct GridFile {
    altitude_km: Vec<f64>,
    turbidity: Vec<f64>,
    sun_zenith_deg: Vec<f64>,
    #[serde(default = "extended")]
    form: Form,
}

const fn extended() -> Form {
    Form::Extended
}

/// The grid that was asked for.
///
/// # Errors
/// When the grid file cannot be read, or its axes are wrong or outside what the engines answer for.
pub fn load_grid(choice: &GridChoice) -> Result<Grid> {
    let path = match choice {
        GridChoice::Seed => return Ok(Grid::report()?),
        GridChoice::Default => return Ok(Grid::extended()?),
        GridChoice::File(path) => path,
    };
    parse_grid(&path.display().to_string(), &read_text(path)?)
}

/// A grid from the text of a TOML file; `name` goes before messages.
///
/// # Errors
/// When it is no such file, or its axes are wrong or outside what the engines answer for.
pub fn parse_grid(name: &str, text: &str) -> Result<Grid> {
    let file: GridFile = toml::from_str(text).map_err(|e| anyhow!("{name}: {e}"))?;
    let axis = |column: &str, unit: &str, nodes: Vec<f64>, [low, high]: [f64; 2]| -> Result<Axis> {
        let axis = Axis::new(unit, nodes).map_err(|e| anyhow!("{name}: {column}: {e}"))?;
        let found = axis.bounds();
        if found[0] < low || found[1] > high {
            return Err(anyhow!(
                "{name}: {column}: expected nodes within {low} to {high}, found {} to {}",
                found[0],
                found[1]
            ));
        }
        Ok(axis)
    };
    Ok(Grid {
        altitude_km: axis("altitude_km", "km", file.altitude_km, [0.0, 30.0])?,
        turbidity: axis("turbidity", "1", file.turbidity, [1.0, 12.0])?,
        sun_zenith_deg: axis("sun_zenith_deg", "deg", file.sun_zenith_deg, [0.0, 96.0])?,
        form: file.form,
    })
}

/// Runs the command.
///
/// # Errors
/// When an input is wrong, a cell cannot be fitted or a file cannot be written; then none is written.
pub fn run(args: &GenerateArgs) -> Result<()> {
    if let Some(path) = &args.plan {
        return bake_plan(path, &args.out);
    }
    let profile = load_profile(&args.profile)?;
    let grid = load_grid(&args.grid)?;
    // every file is opened before the work starts; none appears under its name before all is done
    let pages = create_outputs(&args.out)?;
    let lut_file = OutputFile::create(&args.out.join("sky.utmlut"))?;
    let csv_file = OutputFile::create(&args.out.join("coefficients.csv"))?;
    let settings = OpticsSettings::with_step_nm(MAP_STEP_NM)?;
    let truth = TransportSky::new(profile.clone(), settings.clone(), DEFAULT_GROUND_ALBEDO)?;
    let (lut, sweep) = match args.engine {
        Engine::Transport => {
            let (lut, sweep) = bake(&truth, &grid, &args.profile, truth.extinction()?)?;
            (lut, Some(sweep))
        }
        // what this table is judged by is the truth all the same
        Engine::Smarts => {
            let smarts = SmartsSkyModel::new(profile, settings, DEFAULT_GROUND_ALBEDO)?;
            (
                bake(&smarts, &grid, &args.profile, truth.extinction()?)?.0,
                None,
            )
        }
    };
    let (bytes, csv) = (lut.encode(), lut.to_csv_string());
    write_report(&truth, &args.profile, lut, sweep, pages)?;
    lut_file.commit(&bytes)?;
    csv_file.commit(csv.as_bytes())?;
    Ok(())
}

/// Bakes a plan: the table and its coefficients. A report belongs to a whole domain, so there is none.
fn bake_plan(path: &Path, directory: &Path) -> Result<()> {
    let plan = Plan::load(path)?;
    create_directory(directory)?;
    let lut_file = OutputFile::create(&directory.join("sky.utmlut"))?;
    let csv_file = OutputFile::create(&directory.join("coefficients.csv"))?;
    let bar = spinner("baking");
    let lut = plan.bake()?;
    bar.finish_and_clear();
    let bytes = lut.encode();
    lut_file.commit(&bytes)?;
    csv_file.commit(lut.to_csv_string().as_bytes())?;
    print(&format!(
        "sky.utmlut: {} bytes for {}; without a report: measure it with utm-sky plan --verify\n",
        bytes.len(),
        plan.scene
    ))?;
    Ok(())
}

/// Fits a grid and makes the table.
///
/// # Errors
/// When a cell cannot be fitted; the cell is named.
pub fn bake(
    truth: &dyn SkyModel,
    grid: &Grid,
    profile: &Path,
    extinction: Extinction,
) -> Result<(Lut, Sweep)> {
    let bar = progress("sky maps", grid.maps());
    let sweep = sweep(truth, grid, &|| bar.inc(1))?;
    bar.finish_and_clear();
    let terms = grid.form.terms();
    let (interpolation, storage) = match grid.form {
        Form::PerezReport => (Interpolation::ReportLagrange, Storage::F32),
        Form::PerezSpherical => (Interpolation::LogLinear, Storage::F32),
        Form::Extended => (Interpolation::LogLinear, Storage::Linear16),
    };
    let header = LutHeader {
        form: grid.form,
        storage,
        interpolation,
        altitude_km: grid.altitude_km.clone(),
        turbidity: grid.turbidity.clone(),
        sun_zenith_deg: grid.sun_zenith_deg.clone(),
        channels: CHANNELS.map(str::to_owned).to_vec(),
        terms: terms.iter().map(|t| (*t).to_owned()).collect(),
        profile_name: profile.display().to_string(),
        profile_sha256: profile_hash(profile)?,
        generator: concat!("utm-sky ", env!("CARGO_PKG_VERSION")).to_owned(),
        engine: truth.name().to_owned(),
        settings: BTreeMap::from([
            ("ground_albedo".to_owned(), DEFAULT_GROUND_ALBEDO.into()),
            ("wavelength_step_nm".to_owned(), MAP_STEP_NM.into()),
        ]),
        fit: FitStatistics::default(),
        extinction: Some(extinction),
        domain: Domain {
            altitude_km: grid.altitude_km.bounds(),
            turbidity: grid.turbidity.bounds(),
            sun_zenith_deg: grid.sun_zenith_deg.bounds(),
            below_horizontal: grid.form != Form::PerezReport,
        },
    };
    let draft = TableSky::new(Lut::from_f64(header.clone(), &sweep.values)?)?;
    let fit = statistics(&draft, &sweep.maps.iter().collect::<Vec<_>>())?;
    Ok((
        Lut::from_f64(LutHeader { fit, ..header }, &sweep.values)?,
        sweep,
    ))
}

/// Errors of a table over the maps it was fitted to.
pub(crate) fn statistics(sky: &dyn SkyModel, maps: &[&SkyMap]) -> Result<FitStatistics> {
    let (mut colors, mut luminances) = (Vec::new(), Vec::new());
    for map in maps {
        let Some(white) = white_luminance(&map.sky) else {
            continue;
        };
        let found = sky.yxy_map(&map.conditions, &map.directions)?;
        for (found, truth) in found.iter().zip(&map.sky) {
            colors.push(ciede2000_of_lights(*found, *truth, white));
            luminances.push(relative_error(found.luminance_cd_m2, truth.luminance_cd_m2).abs());
        }
    }
    let quantiles = |values: &[f64]| {
        Statistics::of(values).map_or_else(ErrorQuantiles::default, |s| ErrorQuantiles {
            median: s.median,
            p95: s.p95,
            max: s.max,
        })
    };
    Ok(FitStatistics {
        delta_e_2000: quantiles(&colors),
        luminance_relative_error: quantiles(&luminances),
    })
}

/// A progress bar with the time that is left; silent where there is no terminal.
///
/// # Panics
/// Never: the template is a constant.
#[must_use]
pub fn progress(what: &'static str, count: usize) -> ProgressBar {
    let bar = ProgressBar::new(count as u64);
    let style = ProgressStyle::with_template("{msg:>12} [{bar:40}] {pos}/{len}  {eta} left")
        .expect("a constant template");
    bar.set_style(style.progress_chars("=> "));
    bar.set_message(what);
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}

/// A sign of life for work of unknown length.
///
/// # Panics
/// Never: the template is a constant.
#[must_use]
pub fn spinner(what: &'static str) -> ProgressBar {
    let bar = ProgressBar::new_spinner();
    let style =
        ProgressStyle::with_template("{spinner} {msg}  {elapsed}").expect("a constant template");
    bar.set_style(style);
    bar.set_message(what);
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}
