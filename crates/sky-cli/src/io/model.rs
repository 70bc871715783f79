//! The skies of `utm-sky models`, asked in the directions of a table.

use anyhow::{Result, anyhow, bail};
use sky_core::color::Yxy;
use sky_core::conditions::Conditions;
use sky_eval::models::{answers, open};

use super::progress::Bars;
use super::table::DirectionTable;

/// A model's light in the directions of a table.
///
/// # Errors
/// When there is no such model, or conditions or a direction lie outside its domain.
pub fn map(name: &str, conditions: &Conditions, table: &DirectionTable) -> Result<Vec<Yxy>> {
    let sky = open(name, &Bars::new())?;
    if let Some(i) = table
        .directions
        .iter()
        .position(|d| !answers(sky.domain(), conditions, d))
    {
        bail!(
            "{}: view_zenith_deg: expected one in the domain of {name}, found {:.4}",
            table.place(i),
            table.directions[i].view_zenith.degrees()
        );
    }
    sky.yxy_map(conditions, &table.directions)
        .map_err(|e| anyhow!("{name}: {e}"))
}
