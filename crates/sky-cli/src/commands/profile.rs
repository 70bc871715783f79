//! `utm-sky profile`: the atmosphere as a table.

use std::fmt::Write as _;
use std::path::PathBuf;

use anyhow::Result;
use clap::Args;
use sky_core::quantity::Length;
use sky_eval::profiles::shipped_names;
use sky_sim::profile::{AtmosphereProfile, ProfileRow};

use crate::args::profile_help;
use crate::io::files::{OutputFile, is_standard_output, print};
use crate::io::profile::load_profile;

/// `utm-sky profile`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  utm-sky profile
  utm-sky profile --profile utm2005 --out profile.csv
  utm-sky profile --list")]
pub struct ProfileArgs {
    /// Profile of the atmosphere: a CSV file or the name of a shipped one
    #[arg(long, value_name = "CSV|NAME", default_value = "general", help = profile_help())]
    pub profile: PathBuf,
    /// List the names of the shipped profiles
    #[arg(long, conflicts_with_all = ["profile", "out"])]
    pub list: bool,
    /// Also write the table as CSV
    #[arg(long, value_name = "CSV")]
    pub out: Option<PathBuf>,
}

/// Altitudes of the printed table \[km\]: every 2 km for observers, every 10 km above.
fn printed_altitudes_km() -> impl Iterator<Item = u8> {
    (0..=30).step_by(2).chain((40..=100).step_by(10))
}

/// Altitudes of the CSV \[km\].
fn written_altitudes_km() -> impl Iterator<Item = u8> {
    0..=100
}

/// Runs the command.
///
/// # Errors
/// When the profile is wrong or an output cannot be written.
pub fn run(args: &ProfileArgs) -> Result<()> {
    if args.list {
        let names: Vec<&str> = shipped_names().collect();
        return Ok(print(&(names.join("\n") + "\n"))?);
    }
    let profile = load_profile(&args.profile)?.profile;
    let out = args.out.as_deref().map(OutputFile::create).transpose()?;
    if let Some(out) = out {
        out.commit(csv(&profile).as_bytes())?;
    }
    if !args.out.as_deref().is_some_and(is_standard_output) {
        print(&table(&profile))?;
    }
    Ok(())
}

fn row(profile: &AtmosphereProfile, altitude_km: u8) -> ProfileRow {
    let mut row = profile.row(Length::from_km(altitude_km.into()));
    // Kilometres that went through metres.
    row.altitude_km = altitude_km.into();
    row
}

/// Five significant digits.
fn short(value: f64) -> String {
    if value == 0.0 || (1e-3..1e5).contains(&value.abs()) {
        let mut decimals = 4;
        let mut limit = 10.0;
        while value.abs() >= limit && decimals > 0 {
            decimals -= 1;
            limit *= 10.0;
        }
        format!("{value:.decimals$}")
    } else {
        format!("{value:.3e}")
    }
}

/// The printed table: what each column is, then the rows.
fn table(profile: &AtmosphereProfile) -> String {
    // The column names of the CSV, broken at their last underscores so that a row fits a terminal.
    const HEADS: [[&str; 3]; 14] = [
        ["alti-", "tude", "km"],
        ["pres-", "sure", "hPa"],
        ["temper-", "ature", "K"],
        ["ozone", "eff. temp.", "K"],
        ["relative", "humidity", "%"],
        ["", "air", "1/m3"],
        ["", "ozone", "1/m3"],
        ["", "NO2", "1/m3"],
        ["", "water", "1/m3"],
        ["O2", "path", "km"],
        ["CO2", "path", "km"],
        ["H2O", "above", "cm"],
        ["O3", "above", "atm-cm"],
        ["NO2", "above", "atm-cm"],
    ];
    let mut text = format!("Atmosphere profile {}\n", profile.name());
    if let Some(end) = profile.continued_above() {
        let _ = writeln!(
            text,
            "Above {} km it continues with the shape of the general atmosphere.",
            end.km()
        );
    }
    text.push('\n');
    for line in 0..3 {
        for head in HEADS {
            let _ = write!(text, "{:>11}", head[line]);
        }
        text.push('\n');
    }
    for altitude_km in printed_altitudes_km() {
        for (column, value) in row(profile, altitude_km).values().into_iter().enumerate() {
            let cell = if column == 0 {
                altitude_km.to_string()
            } else {
                short(value)
            };
            let _ = write!(text, "{cell:>11}");
        }
        text.push('\n');
    }
    text
}

/// The CSV: all columns, every kilometre.
fn csv(profile: &AtmosphereProfile) -> String {
    let mut text = ProfileRow::COLUMNS.join(",");
    text.push('\n');
    for altitude_km in written_altitudes_km() {
        let cells: Vec<String> = row(profile, altitude_km)
            .values()
            .iter()
            .enumerate()
            .map(|(column, value)| match column {
                0 => altitude_km.to_string(),
                _ => format!("{value:.6e}"),
            })
            .collect();
        let _ = writeln!(text, "{}", cells.join(","));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_five_digits() {
        for (value, text) in [
            (0.0, "0.0000"),
            (1.0, "1.0000"),
            (288.15, "288.15"),
            (1013.25, "1013.2"),
            (0.01234, "0.0123"),
            (2.547e25, "2.547e25"),
            (3e-5, "3.000e-5"),
        ] {
            assert_eq!(short(value), text);
        }
    }

    #[test]
    fn the_table_covers_0_to_100_km_in_columns_of_equal_width() {
        let text = table(&AtmosphereProfile::general());
        let rows: Vec<&str> = text.lines().skip(2).collect();
        assert_eq!(rows.len(), 3 + 16 + 7);
        assert!(rows.iter().all(|r| r.len() == 14 * 11), "{text}");
        assert_eq!(csv(&AtmosphereProfile::general()).lines().count(), 102);
    }
}
