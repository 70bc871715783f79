//! `utm-sky models`: the list of skies.

use std::fmt::Write as _;

use anyhow::Result;
use sky_eval::models::all;

use crate::io::files::print;

/// Prints the list.
///
/// # Errors
/// When the terminal cannot be written.
pub fn run() -> Result<()> {
    let mut text = format!(
        "{:<16} {:>14} {:>12} {:>14}  citation\n",
        "name", "altitude [km]", "turbidity", "sun [deg]"
    );
    for model in all() {
        let d = model.domain()?;
        let short = |range: [f64; 2]| {
            let [low, high] = range.map(|v| (v * 100.0).round() / 100.0);
            format!("{low}..{high}")
        };
        writeln!(
            text,
            "{:<16} {:>14} {:>12} {:>14}  {}",
            model.name,
            short(d.altitude_km),
            short(d.turbidity),
            short(d.sun_zenith_deg),
            model.citation
        )?;
    }
    print(&text)?;
    Ok(())
}
