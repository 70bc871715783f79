//! Table, observer, haze and sun from the command line: what every command of the runtime starts with.

use anyhow::{Result, anyhow};
use sky_core::conditions::Conditions;
use sky_core::utm_sky::{SkyFrame, UtmSky};

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
}

impl Scene {
    /// From arguments.
    ///
    /// # Errors
    /// When the table cannot be read or the haze makes no sense.
    pub fn open(args: &SceneArgs) -> Result<Self> {
        let sky = UtmSky::new(load(&args.lut)?);
        Ok(Self {
            sky,
            source: source_name(&args.lut).to_string(),
            conditions: args.conditions()?,
        })
    }

    /// The sky under the conditions.
    ///
    /// # Errors
    /// When they lie outside the table's domain; the table is named.
    pub fn frame(&self) -> Result<SkyFrame> {
        self.sky
            .frame(&self.conditions)
            .map_err(|e| anyhow!("{}: {e}", self.source))
    }
}
