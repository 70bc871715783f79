//! Look-up tables: built in, from files, or baked from plans.

use std::path::Path;

use anyhow::{Result, anyhow};
use sky_core::lut::Lut;
use sky_core::utm_sky::EMBEDDED_LUT;
use sky_eval::progress::Progress as _;

use super::files::read_bytes;
use super::plan::load_plan;
use super::progress::Bars;
use crate::args::LutSource;

/// The look-up table that an option names.
///
/// # Errors
/// When the file cannot be read or is no look-up table; the message begins with its name.
pub fn load(source: &LutSource) -> Result<Lut> {
    match source {
        LutSource::Embedded => {
            Lut::decode(EMBEDDED_LUT).map_err(|error| anyhow!("embedded: {error}"))
        }
        LutSource::File(path) => load_file(path),
        LutSource::Plan(path) => {
            let (plan, profile) = load_plan(path)?;
            let bars = Bars::new();
            bars.begin("baking", None);
            let lut = plan.bake(&profile);
            bars.end();
            lut.map_err(|error| anyhow!("{}: {error}", path.display()))
        }
    }
}

fn load_file(path: &Path) -> Result<Lut> {
    let bytes = read_bytes(path)?;
    Lut::decode(&bytes).map_err(|error| anyhow!("{}: {error}", path.display()))
}

/// What messages and tables call the source.
#[must_use]
pub fn source_name(source: &LutSource) -> String {
    match source {
        LutSource::Embedded => "embedded".to_owned(),
        LutSource::File(path) | LutSource::Plan(path) => path.display().to_string(),
    }
}
