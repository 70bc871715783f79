//! `utm-sky sky`: the look-up table's answer by direction.

use anyhow::{Result, anyhow};

use crate::args::SkyArgs;
use crate::files::OutputFile;
use crate::models;
use crate::scene::table_frame;
use crate::table_io::{DirectionTable, yxy_map_csv};

/// Runs the command.
///
/// # Errors
/// When an input is wrong, conditions or a direction lie outside the table's domain, or the output
/// cannot be written.
pub fn run(args: &SkyArgs) -> Result<()> {
    let directions = DirectionTable::read_or_report(args.directions.as_deref())?;
    if let Some(model) = &args.model {
        let conditions = args.scene.conditions()?;
        let map = models::map(model, &conditions, &directions)?;
        OutputFile::create(&args.out)?.commit(yxy_map_csv(&directions, &map).as_bytes())?;
        return Ok(());
    }
    let frame = table_frame(&args.scene)?;
    let map = directions
        .directions
        .iter()
        .enumerate()
        .map(|(i, direction)| {
            frame.yxy(direction).ok_or_else(|| {
                anyhow!(
                    "direction {}: view_zenith_deg: expected a direction above the geometric horizon, found {:.4}",
                    i + 1,
                    direction.view_zenith.degrees()
                )
            })
        })
        .collect::<Result<Vec<_>>>()?;
    OutputFile::create(&args.out)?.commit(yxy_map_csv(&directions, &map).as_bytes())?;
    Ok(())
}
