//! Table, observer, haze and sun from the command line: what every command of the runtime starts with.

use anyhow::{Result, anyhow};
use sky_core::conditions::Conditions;
use sky_core::haze::Haze;
use sky_core::quantity::{Angle, Length};
use sky_core::utm_sky::{SkyFrame, UtmSky};

use crate::args::{PlaceArgs, SceneArgs};
use crate::lut_commands::{load, source_name};

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

impl SceneArgs {
    /// Observer, haze and sun.
    ///
    /// # Errors
    /// When the haze makes no sense.
    pub fn conditions(&self) -> Result<Conditions> {
        conditions(&self.place, self.haze.haze(self.angstrom_alpha))
    }
}

/// Observer, haze and sun.
///
/// # Errors
/// When the haze makes no sense.
pub fn conditions(place: &PlaceArgs, haze: Option<Haze>) -> Result<Conditions> {
    let haze = haze
        .ok_or_else(|| anyhow!("haze: expected one of --turbidity, --aod500, --visual-range-km"))?;
    Ok(Conditions {
        observer_altitude: Length::from_km(place.altitude_km),
        turbidity: haze.turbidity()?,
        sun_zenith: Angle::from_degrees(place.sun_zenith_deg),
    })
}
