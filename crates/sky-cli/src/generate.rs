//! `utm-sky generate`.

use anyhow::{Result, bail};

use crate::args::GenerateArgs;

/// Runs the command.
///
/// # Errors
/// Always: the look-up table is not there yet.
pub fn run(_args: &GenerateArgs) -> Result<()> {
    bail!("generate: not built yet")
}
