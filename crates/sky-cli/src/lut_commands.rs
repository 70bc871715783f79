//! `utm-sky lut info` and `utm-sky lut export`.

use std::fmt::{Arguments, Write as _};
use std::path::Path;

use anyhow::{Result, anyhow};
use sky_core::axis::Axis;
use sky_core::lut::{ErrorQuantiles, Lut};
use sky_core::utm_sky::EMBEDDED_LUT;

use crate::args::{LutArgs, LutCommand, LutSource};
use crate::files::{OutputFile, print, read_bytes};
use crate::generate::spinner;
use crate::plan::Plan;

/// Runs the command.
///
/// # Errors
/// When the table cannot be read or the output cannot be written.
pub fn run(args: &LutArgs) -> Result<()> {
    match &args.command {
        LutCommand::Info { lut } => {
            print(&info(&source_name(lut), &load(lut)?))?;
        }
        LutCommand::Export { lut, csv } => {
            let lut = load(lut)?;
            OutputFile::create(csv)?.commit(lut.to_csv_string().as_bytes())?;
        }
    }
    Ok(())
}

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
            let plan = Plan::load(path)?;
            let bar = spinner("baking");
            let lut = plan.bake();
            bar.finish_and_clear();
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
    row(
        "below horizontal",
        format_args!(
            "{}",
            if h.domain.below_horizontal {
                "valid down to the geometric horizon"
            } else {
                "not valid"
            }
        ),
    );
    row("channels", format_args!("{}", h.channels.join(" ")));
    row("terms", format_args!("{}", h.terms.join(" ")));
    row("profile", format_args!("{}", h.profile_name));
    row("profile SHA-256", format_args!("{}", h.profile_sha256));
    row("engine", format_args!("{}", h.engine));
    row("made by", format_args!("{}", h.generator));
    let quantiles = |q: &ErrorQuantiles, scale: f64, unit: &str| {
        format!(
            "median {:.2}{unit}, 95 % below {:.2}{unit}, largest {:.2}{unit}",
            scale * q.median,
            scale * q.p95,
            scale * q.max
        )
    };
    row(
        "fit to the maps",
        format_args!(
            "luminance: {}",
            quantiles(&h.fit.luminance_relative_error, 100.0, " %")
        ),
    );
    row(
        "",
        format_args!("CIEDE2000: {}", quantiles(&h.fit.delta_e_2000, 1.0, "")),
    );
    for (i, (key, value)) in h.settings.iter().enumerate() {
        row(
            if i == 0 { "settings" } else { "" },
            format_args!("{key} = {value}"),
        );
    }
    out
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
