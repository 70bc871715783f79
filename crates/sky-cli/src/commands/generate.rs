//! `utm-sky generate`: profile → maps → fits → look-up table → report.

use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::Args;
use sky_eval::bake::{MAP_STEP_NM, bake};
use sky_eval::grid::parse_grid;
use sky_eval::progress::Progress as _;
use sky_eval::report::of_table::of_table;
use sky_eval::truth::{DEFAULT_GROUND_ALBEDO, SmartsSkyModel, TransportSky};
use sky_fit::sweep::Grid;
use sky_sim::optics::OpticsSettings;

use crate::args::{Engine, profile_help};
use crate::io::files::{OutputFile, create_directory, print, read_text};
use crate::io::plan::load_plan;
use crate::io::profile::load_profile;
use crate::io::progress::Bars;
use crate::io::report::{create_outputs, write};

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

A plan that utm-sky plan runway_noon --out plan.toml made: utm-sky generate --plan plan.toml --out runway.
Its table comes without a report: utm-sky plan --verify measures it on its own scene.")]
pub struct GenerateArgs {
    /// Profile of the atmosphere: a CSV file or the name of a shipped one
    #[arg(long, value_name = "CSV|NAME", default_value = "general", help = profile_help())]
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
    let air = profile.profile.clone();
    let truth = TransportSky::new(air.clone(), settings.clone(), DEFAULT_GROUND_ALBEDO)?;
    let bars = Bars::new();
    let (lut, sweep) = match args.engine {
        Engine::Transport => {
            let (lut, sweep) = bake(&truth, &grid, &profile, truth.extinction()?, &bars)?;
            (lut, Some(sweep))
        }
        // what this table is judged by is the truth all the same
        Engine::Smarts => {
            let smarts = SmartsSkyModel::new(air, settings, DEFAULT_GROUND_ALBEDO)?;
            (
                bake(&smarts, &grid, &profile, truth.extinction()?, &bars)?.0,
                None,
            )
        }
    };
    let (bytes, csv) = (lut.encode(), lut.to_csv_string());
    write(&of_table(&truth, &profile, lut, sweep, &bars)?, pages)?;
    lut_file.commit(&bytes)?;
    csv_file.commit(csv.as_bytes())?;
    Ok(())
}

/// Bakes a plan: the table and its coefficients. A report belongs to a whole domain, so there is none.
fn bake_plan(path: &Path, directory: &Path) -> Result<()> {
    let (plan, profile) = load_plan(path)?;
    create_directory(directory)?;
    let lut_file = OutputFile::create(&directory.join("sky.utmlut"))?;
    let csv_file = OutputFile::create(&directory.join("coefficients.csv"))?;
    let bars = Bars::new();
    bars.begin("baking", None);
    let lut = plan.bake(&profile)?;
    bars.end();
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
