//! `utm-sky sky`: the look-up table's answer by direction.

use anyhow::{Result, anyhow};
use sky_core::quantity::{Angle, Length};
use sky_core::sky_model::Conditions;
use sky_core::utm_sky::UtmSky;

use crate::args::SkyArgs;
use crate::files::OutputFile;
use crate::lut_commands::{load, source_name};
use crate::table_io::{DirectionTable, yxy_map_csv};

/// Runs the command.
///
/// # Errors
/// When an input is wrong, conditions or a direction lie outside the table's domain, or the output
/// cannot be written.
pub fn run(args: &SkyArgs) -> Result<()> {
    let directions = DirectionTable::read_or_report(args.directions.as_deref())?;
    let sky = UtmSky::new(load(&args.lut)?);
    let haze = args
        .haze
        .haze(args.angstrom_alpha)
        .ok_or_else(|| anyhow!("haze: expected one of --turbidity, --aod500, --visual-range-km"))?;
    let conditions = Conditions {
        observer_altitude: Length::from_km(args.place.altitude_km),
        turbidity: haze.turbidity()?,
        sun_zenith: Angle::from_degrees(args.place.sun_zenith_deg),
    };
    let frame = sky
        .frame(&conditions)
        .map_err(|e| anyhow!("{}: {e}", source_name(&args.lut)))?;
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
