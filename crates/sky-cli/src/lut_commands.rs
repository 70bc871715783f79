//! `utm-sky lut info` and `utm-sky lut export`.

use anyhow::{Result, bail};

use crate::args::{LutArgs, LutCommand};

/// Runs the command.
///
/// # Errors
/// Always: the look-up table is not there yet.
pub fn run(args: &LutArgs) -> Result<()> {
    match &args.command {
        LutCommand::Info { .. } => bail!("lut info: not built yet"),
        LutCommand::Export { .. } => bail!("lut export: not built yet"),
    }
}
