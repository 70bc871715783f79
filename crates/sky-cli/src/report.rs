//! `utm-sky report`.

use anyhow::{Result, bail};

use crate::args::ReportArgs;

/// Runs the command.
///
/// # Errors
/// Always: the look-up table is not there yet.
pub fn run(_args: &ReportArgs) -> Result<()> {
    bail!("report: not built yet")
}
