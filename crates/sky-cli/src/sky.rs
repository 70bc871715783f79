//! `utm-sky sky`.

use anyhow::{Result, bail};

use crate::args::SkyArgs;

/// Runs the command.
///
/// # Errors
/// Always: the look-up table is not there yet.
pub fn run(_args: &SkyArgs) -> Result<()> {
    bail!("sky: not built yet")
}
