//! `utm-sky fit-stress`: Perez fits from random starts and on damaged maps.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;
use sky_eval::fit_stress::{Effort, csv, stress_all, summary};

use crate::io::files::{OutputFile, create_directory, print};
use crate::io::progress::Bars;

/// `utm-sky fit-stress`.
#[derive(Debug, Args)]
#[command(after_help = "Example:
  utm-sky fit-stress --quick --out fits

fit_stress.csv has a row for each sky, channel, damage and method.
  method              safeguarded: as tables are fitted, from eight starts, the same for every map;
                      one_start: the same from a random start; plain_eight: Levenberg-Marquardt on
                      the printed coefficients from those eight; plain: from a random start
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

/// Runs the command.
///
/// # Errors
/// When the skies cannot be computed or the file cannot be written.
pub fn run(args: &FitStressArgs) -> Result<()> {
    create_directory(&args.out)?;
    let file = OutputFile::create(&args.out.join("fit_stress.csv"))?;
    let effort = if args.quick {
        Effort::QUICK
    } else {
        Effort::FULL
    };
    let rows = stress_all(effort, &Bars::new())?;
    file.commit(csv(&rows).as_bytes())?;
    print(&summary(&rows))?;
    Ok(())
}
