//! `utm-sky lut info` and `utm-sky lut export`.

use std::fmt::{Arguments, Write as _};
use std::path::PathBuf;

use anyhow::Result;
use clap::{Args, Subcommand};
use sky_core::axis::Axis;
use sky_core::lut::{ErrorQuantiles, FitStatistics, Lut};

use crate::args::{LutSource, lut_source};
use crate::io::files::{OutputFile, print};
use crate::io::lut::{load, source_name};

/// `utm-sky lut`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  utm-sky lut info embedded
  utm-sky lut export embedded --out coefficients.csv")]
pub struct LutArgs {
    /// What to do with the table.
    #[command(subcommand)]
    pub command: LutCommand,
}

/// The commands on a look-up table.
#[derive(Debug, Subcommand)]
pub enum LutCommand {
    /// Print what the table says about itself
    #[command(after_help = "Example:
  utm-sky lut info embedded")]
    Info {
        /// Look-up table: a .utmlut file, a plan (.toml) or the word embedded
        #[arg(value_name = "FILE|embedded", value_parser = lut_source)]
        lut: LutSource,
    },
    /// Write the coefficients in the layout of the report's Appendix A
    #[command(after_help = "Example:
  utm-sky lut export embedded --out coefficients.csv")]
    Export {
        /// Look-up table: a .utmlut file, a plan (.toml) or the word embedded
        #[arg(value_name = "FILE|embedded", value_parser = lut_source)]
        lut: LutSource,
        /// The coefficients
        #[arg(long, value_name = "CSV", alias = "csv")]
        out: PathBuf,
    },
}

/// Runs the command.
///
/// # Errors
/// When the table cannot be read or the output cannot be written.
pub fn run(args: &LutArgs) -> Result<()> {
    match &args.command {
        LutCommand::Info { lut } => {
            print(&info(&source_name(lut), &load(lut)?))?;
        }
        LutCommand::Export { lut, out } => {
            let lut = load(lut)?;
            OutputFile::create(out)?.commit(lut.to_csv_string().as_bytes())?;
        }
    }
    Ok(())
}

/// What a table says about itself, for people.
fn info(name: &str, lut: &Lut) -> String {
    let h = lut.header();
    let mut out = String::new();
    let mut row = |label: &str, value: Arguments<'_>| {
        // A `String` takes everything.
        let _ = writeln!(out, "{label:<18}{value}");
    };
    let [altitudes, turbidities, suns] = h.shape();
    let bytes = lut.encode().len();
    row("table", format_args!("{name}"));
    row("size", format_args!("{bytes} bytes, {:.1} KiB", kib(bytes)));
    row("form", format_args!("{}", h.form.name()));
    row("interpolation", format_args!("{}", h.interpolation.name()));
    row(
        "nodes",
        format_args!(
            "{altitudes} altitudes x {turbidities} turbidities x {suns} suns = {}",
            altitudes * turbidities * suns
        ),
    );
    for (label, axis, domain) in [
        ("altitude", &h.altitude_km, h.domain.altitude_km),
        ("turbidity", &h.turbidity, h.domain.turbidity),
        ("sun zenith", &h.sun_zenith_deg, h.domain.sun_zenith_deg),
    ] {
        let nodes: Vec<String> = axis.nodes().iter().map(f64::to_string).collect();
        row(label, format_args!("{}{}", nodes.join(" "), unit(axis)));
        let whole = (0..2).all(|i| domain[i].total_cmp(&axis.bounds()[i]).is_eq());
        if !whole {
            row(
                "",
                format_args!("valid from {} to {}", domain[0], domain[1]),
            );
        }
    }
    let below = if h.domain.below_horizontal {
        "valid down to the geometric horizon"
    } else {
        "not valid"
    };
    row("below horizontal", format_args!("{below}"));
    row("channels", format_args!("{}", h.channels.join(" ")));
    row("terms", format_args!("{}", h.terms.join(" ")));
    row("profile", format_args!("{}", h.profile_name));
    row("profile SHA-256", format_args!("{}", h.profile_sha256));
    row("engine", format_args!("{}", h.engine));
    row("made by", format_args!("{}", h.generator));
    let [luminance, colors] = fit(&h.fit);
    row("fit to the maps", format_args!("luminance: {luminance}"));
    row("", format_args!("CIEDE2000: {colors}"));
    for (i, (key, value)) in h.settings.iter().enumerate() {
        row(
            if i == 0 { "settings" } else { "" },
            format_args!("{key} = {value}"),
        );
    }
    out
}

/// Errors of luminance and color, in words.
fn fit(fit: &FitStatistics) -> [String; 2] {
    let quantiles = |q: &ErrorQuantiles, scale: f64, unit: &str| {
        format!(
            "median {:.2}{unit}, 95 % below {:.2}{unit}, largest {:.2}{unit}",
            scale * q.median,
            scale * q.p95,
            scale * q.max
        )
    };
    [
        quantiles(&fit.luminance_relative_error, 100.0, " %"),
        quantiles(&fit.delta_e_2000, 1.0, ""),
    ]
}

/// The unit behind a list of nodes; nothing for a pure number.
fn unit(axis: &Axis) -> String {
    match axis.unit() {
        "1" => String::new(),
        unit => format!(" {unit}"),
    }
}

/// Size in KiB.
fn kib(bytes: usize) -> f64 {
    u32::try_from(bytes).map_or(f64::INFINITY, f64::from) / 1024.0
}
