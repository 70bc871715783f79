//! `utm-sky plan`: the cheapest configuration that a scene needs.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use anyhow::{Result, anyhow};
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{ArgGroup, Args};
use sky_eval::constituents::Part;
use sky_eval::ledger::{ledger, tables};
use sky_eval::progress::Progress as _;
use sky_plan::explain::explain;
use sky_plan::{plan_scene, verified};

use crate::args::{LutSource, lut_source};
use crate::io::files::{EXIT_NOT_MET, OutputFile, is_standard_output, print};
use crate::io::lut::load;
use crate::io::plan::{load_plan, load_scene};
use crate::io::profile::load_profile;
use crate::io::progress::Bars;

/// A part of the sky by its name.
fn part() -> impl TypedValueParser<Value = Part> {
    let named =
        |(_, name, what): (Part, &'static str, &'static str)| PossibleValue::new(name).help(what);
    PossibleValuesParser::new(Part::ALL.map(named)).try_map(|name| {
        let found = Part::ALL.into_iter().find(|(_, known, _)| *known == name);
        found
            .map(|(part, ..)| part)
            .ok_or("expected a part of the sky")
    })
}

/// Help of the scene, with the names of the shipped ones.
fn scene_help() -> String {
    let names: Vec<&str> = sky_profiles::SCENES
        .iter()
        .map(|scene| scene.name)
        .collect();
    format!(
        "The scene, ranges, tolerance and budget: a TOML file (see profiles/scenes/README.md) or the name \
         of a shipped one ({})",
        names.join(", ")
    )
}

/// `utm-sky plan`.
#[derive(Debug, Args)]
#[command(
    group(ArgGroup::new("task").required(true).args(["scene", "verify", "ledger"])),
    after_help = "Examples:
  utm-sky plan runway_noon --out plan.toml
  utm-sky plan airliner_dusk --explain ozone
  utm-sky plan --verify plan.toml --cases 500 --seed 1
  utm-sky plan --ledger --out ledger.csv

Errors are 95th percentiles over the directions of cases that were not fitted, against the transport
engine with every constituent; the sun's 5 degrees are left out. Exit status of --verify: 0 where the
tolerance is met, 1 where it is not."
)]
pub struct PlanArgs {
    /// The scene, ranges, tolerance and budget: a TOML file (see profiles/scenes/README.md) or the name
    /// of a shipped one
    #[arg(value_name = "SCENE.toml|NAME", help = scene_help())]
    pub scene: Option<PathBuf>,
    /// The plan; without it plan.toml. With --ledger the ledger as CSV
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Instead of planning: what the scene loses without a term, with a picture beside the plan
    #[arg(long, value_name = "TERM", value_parser = part(), requires = "scene")]
    pub explain: Option<Part>,
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

/// Runs the command.
///
/// # Errors
/// When an input is wrong, the tolerance cannot be met or a file cannot be written.
pub fn run(args: &PlanArgs) -> Result<ExitCode> {
    let bars = Bars::new();
    if let Some(path) = &args.verify {
        return verify(args, path, &bars);
    }
    let Some(path) = &args.scene else {
        let out = args.out.as_deref().map(OutputFile::create).transpose()?;
        let (text, csv) = tables(&ledger(&bars)?)?;
        if let Some(out) = out {
            out.commit(csv.as_bytes())?;
        }
        if !args.out.as_deref().is_some_and(is_standard_output) {
            print(&text)?;
        }
        return Ok(ExitCode::SUCCESS);
    };
    plan(args, path, &bars)?;
    Ok(ExitCode::SUCCESS)
}

/// Plans a scene, or explains what it loses without a term.
fn plan(args: &PlanArgs, path: &Path, bars: &Bars) -> Result<()> {
    let scene = load_scene(path)?;
    let profile = load_profile(&scene.profile)?;
    let out = args.out.as_deref().unwrap_or(Path::new("plan.toml"));
    if let Some(term) = args.explain {
        let picture = out.with_file_name(format!("without_{}.png", term.name()));
        let file = OutputFile::create(&picture)?;
        bars.begin("explaining", None);
        let (text, png) = explain(&scene, &profile.profile, term)?;
        bars.end();
        file.commit(&png)?;
        return Ok(print(&format!("{text}picture: {}\n", picture.display()))?);
    }
    let file = OutputFile::create(out)?;
    let start = Instant::now();
    bars.begin("planning", None);
    let planned = plan_scene(&scene, &profile).map_err(|e| anyhow!("{}: {e}", path.display()))?;
    bars.end();
    file.commit(planned.plan.to_toml()?.as_bytes())?;
    if is_standard_output(out) {
        return Ok(());
    }
    let mut report = planned.report()?;
    writeln!(
        report,
        "\nplanned in {:.0} s; written to {}",
        start.elapsed().as_secs_f64(),
        out.display()
    )?;
    Ok(print(&report)?)
}

/// Measures a plan's table; the status says whether the tolerance is met.
fn verify(args: &PlanArgs, path: &Path, bars: &Bars) -> Result<ExitCode> {
    let (plan, profile) = load_plan(path)?;
    bars.begin("verifying", None);
    let lut = match &args.lut {
        Some(source) => load(source)?,
        None => plan.bake(&profile)?,
    };
    let score = verified(&plan, &profile.profile, lut, args.cases, args.seed)?;
    bars.end();
    let worst = &score.worst;
    let met = score.delta_e.p95 <= plan.tolerance.delta_e
        && score.luminance.p95 <= plan.tolerance.luminance;
    print(&format!(
        "{} random cases, {} directions\n\
         \x20                 p50      p95    worst   tolerance (p95)\n\
         CIEDE2000    {:8.2} {:8.2} {:8.2}   {:.2}\n\
         luminance    {:6.2} % {:6.2} % {:6.2} %   {:.2} %\n\
         worst color at {:.2} km, turbidity {:.2}, sun zenith {:.2} deg\n\
         the tolerance is {}\n",
        args.cases,
        score.delta_e.count,
        score.delta_e.median,
        score.delta_e.p95,
        score.delta_e.max,
        plan.tolerance.delta_e,
        100.0 * score.luminance.median,
        100.0 * score.luminance.p95,
        100.0 * score.luminance.max,
        100.0 * plan.tolerance.luminance,
        worst.observer_altitude.km(),
        worst.turbidity,
        worst.sun_zenith.degrees(),
        if met { "met" } else { "not met" },
    ))?;
    Ok(if met {
        ExitCode::SUCCESS
    } else {
        ExitCode::from(EXIT_NOT_MET)
    })
}
