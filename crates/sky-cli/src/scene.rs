//! Table, observer, haze and sun from the command line: what every command of the runtime starts with.

use anyhow::{Result, anyhow};
use sky_core::conditions::{Conditions, OutsideDomain};
use sky_core::haze::Haze;
use sky_core::quantity::{Angle, Length};
use sky_core::utm_sky::{SkyFrame, UtmSky};
use sky_science::table_sky::{TableFrame, TableSky};

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
    haze: Option<Haze>,
}

impl Scene {
    /// From arguments.
    ///
    /// # Errors
    /// When the table cannot be read or the haze makes no sense.
    pub fn open(args: &SceneArgs) -> Result<Self> {
        let source = source_name(&args.lut).to_string();
        Ok(Self {
            sky: UtmSky::new(load(&args.lut)?).map_err(|e| anyhow!("{source}: {e}"))?,
            source,
            conditions: args.conditions()?,
            haze: args.haze.haze(args.angstrom_alpha),
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
        let told = self.haze.map_or(outside, |haze| outside.in_words_of(haze));
        anyhow!("{}: {told}", self.source)
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

impl SceneArgs {
    /// Conditions outside a domain, in the words in which they were given.
    fn in_own_words(&self, outside: OutsideDomain) -> OutsideDomain {
        let haze = self.haze.haze(self.angstrom_alpha);
        haze.map_or(outside, |haze| outside.in_words_of(haze))
    }

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
    let altitude = Length::from_km(place.altitude_km);
    let sun_zenith = Angle::from_degrees(place.sun_zenith_deg);
    Ok(Conditions::new(altitude, haze, sun_zenith)?)
}
