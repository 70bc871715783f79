//! `utm-sky sky`: the look-up table's answer by direction.

use std::path::PathBuf;

use anyhow::{Result, anyhow};
use clap::{ArgGroup, Args};

use crate::args::{HAZE, SceneArgs};
use crate::io::files::OutputFile;
use crate::io::model::map;
use crate::io::scene::table_frame;
use crate::io::table::{DirectionArgs, yxy_map_csv};

/// `utm-sky sky`.
#[derive(Debug, Args)]
#[command(
    group(ArgGroup::new("haze").required(true)
        .args(HAZE)),
    after_help = "Examples:
  utm-sky sky --altitude-km 6 --turbidity 2 --sun-zenith-deg 60 --out yxy.csv
  utm-sky sky --altitude-km 6 --turbidity 2 --sun-elevation-deg 30 --direction 80,0 --out -
  utm-sky sky --model preetham --altitude-km 0 --aod500 0.2 --sun-zenith-deg 40 --out preetham.csv"
)]
pub struct SkyArgs {
    /// Table, observer, sun and haze.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// A sky of `utm-sky models` in place of the table's
    #[arg(long, value_name = "NAME", conflicts_with = "lut")]
    pub model: Option<String>,
    /// Directions of view.
    #[command(flatten)]
    pub directions: DirectionArgs,
    /// Luminance and chromaticity by direction
    #[arg(long, value_name = "CSV")]
    pub out: PathBuf,
}

/// Runs the command.
///
/// # Errors
/// When an input is wrong, conditions or a direction lie outside the table's domain, or the output
/// cannot be written.
pub fn run(args: &SkyArgs) -> Result<()> {
    let directions = args.directions.table()?;
    if let Some(model) = &args.model {
        let conditions = args.scene.conditions()?;
        let map = map(model, &conditions, &directions)?;
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
                    "{}: view_zenith_deg: expected a direction above the geometric horizon, found {:.4}",
                    directions.place(i),
                    direction.view_zenith.degrees()
                )
            })
        })
        .collect::<Result<Vec<_>>>()?;
    OutputFile::create(&args.out)?.commit(yxy_map_csv(&directions, &map).as_bytes())?;
    Ok(())
}
