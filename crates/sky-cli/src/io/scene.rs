//! Table, observer, haze and sun from the command line: what every command of the runtime starts with.

use anyhow::{Result, anyhow};
use sky_core::conditions::{Conditions, OutsideDomain};
use sky_core::utm_sky::{SkyFrame, UtmSky};
use sky_science::table_sky::{TableFrame, TableSky};

use super::lut::{load, source_name};
use crate::args::SceneArgs;

/// A table's sky and the conditions under which it is asked.
#[derive(Debug)]
pub struct Scene {
    /// The sky.
    pub sky: UtmSky,
    /// Name of the table.
    pub source: String,
    /// Observer, haze and sun.
    pub conditions: Conditions,
    args: SceneArgs,
}

impl Scene {
    /// From arguments.
    ///
    /// # Errors
    /// When the table cannot be read or the haze makes no sense.
    pub fn open(args: &SceneArgs) -> Result<Self> {
        let source = source_name(&args.lut);
        Ok(Self {
            sky: UtmSky::new(load(&args.lut)?).map_err(|e| anyhow!("{source}: {e}"))?,
            source,
            conditions: args.conditions()?,
            args: args.clone(),
        })
    }

    /// The sky under the conditions.
    ///
    /// # Errors
    /// When they lie outside the table's domain; the table is named.
    pub fn frame(&self) -> Result<SkyFrame> {
        self.sky
            .frame(&self.conditions)
            .map_err(|e| self.refusal(e))
    }

    /// Conditions outside the table's domain, in the words in which they were given.
    #[must_use]
    pub fn refusal(&self, outside: OutsideDomain) -> anyhow::Error {
        anyhow!("{}: {}", self.source, self.args.in_own_words(outside))
    }
}

/// A table of any form under the conditions of the arguments.
///
/// # Errors
/// When the table cannot be read, the haze makes no sense, or the conditions lie outside its domain.
pub fn table_frame(args: &SceneArgs) -> Result<TableFrame> {
    let source = source_name(&args.lut);
    let sky = TableSky::new(load(&args.lut)?).map_err(|e| anyhow!("{source}: {e}"))?;
    let conditions = args.conditions()?;
    sky.frame(&conditions)
        .map_err(|e| anyhow!("{source}: {}", args.in_own_words(e)))
}
