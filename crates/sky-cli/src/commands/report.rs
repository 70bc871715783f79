//! `utm-sky report`: the report on a look-up table.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use clap::Args;
use sky_eval::bake::MAP_STEP_NM;
use sky_eval::report::of_table::of_table;
use sky_eval::truth::{DEFAULT_GROUND_ALBEDO, TransportSky};
use sky_sim::optics::OpticsSettings;

use crate::args::{LutSource, lut_source};
use crate::io::lut::load;
use crate::io::profile::load_profile;
use crate::io::progress::Bars;
use crate::io::report::{create_outputs, write};

/// `utm-sky report`.
#[derive(Debug, Args)]
#[command(after_help = "Example:
  utm-sky report --lut embedded --out target/utm-sky")]
pub struct ReportArgs {
    /// Look-up table: a .utmlut file, a plan (.toml), which is baked first, or the built-in one
    #[arg(long, value_name = "FILE|embedded", default_value = "embedded", value_parser = lut_source)]
    pub lut: LutSource,
    /// Directory for report.html and report.csv; made if missing
    #[arg(long, value_name = "DIR", default_value = "target/utm-sky")]
    pub out: PathBuf,
}

/// Runs the command.
///
/// # Errors
/// When the table or its profile cannot be read, its truth cannot be computed or the files cannot be
/// written.
pub fn run(args: &ReportArgs) -> Result<()> {
    let lut = load(&args.lut)?;
    let profile = load_profile(Path::new(&lut.header().profile_name))?;
    if profile.sha256 != lut.header().profile_sha256 {
        bail!(
            "{}: expected the profile that the table was made from, SHA-256 {}, found {}",
            profile.name,
            lut.header().profile_sha256,
            profile.sha256
        );
    }
    let outputs = create_outputs(&args.out)?;
    let settings = OpticsSettings::with_step_nm(MAP_STEP_NM)?;
    let truth = TransportSky::new(profile.profile.clone(), settings, DEFAULT_GROUND_ALBEDO)?;
    write(
        &of_table(&truth, &profile, lut, None, &Bars::new())?,
        outputs,
    )
}
