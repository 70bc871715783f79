//! `report.csv`: every figure of the page as a row of one long table.

use sky_core::conditions::Conditions;

/// Rows so far.
#[derive(Debug, Default)]
pub(super) struct LongTable {
    rows: String,
}

const HEADER: &str = "section,key,altitude_km,turbidity,sun_zenith_deg,channel,value\n";

/// A cell, quoted where it must be (RFC 4180).
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

/// A number, without the last digits of a conversion of units.
fn rounded(value: f64) -> f64 {
    (value * 1e9).round() / 1e9
}

impl LongTable {
    /// Adds a number.
    pub(super) fn figure(
        &mut self,
        section: &str,
        key: &str,
        conditions: Option<&Conditions>,
        channel: &str,
        value: f64,
    ) {
        let value = if value.abs() >= 1e-3 && value.abs() < 1e7 {
            format!("{:.6}", value)
        } else {
            format!("{value:.6e}")
        };
        self.text(section, key, conditions, channel, &value);
    }

    /// Adds a text.
    pub(super) fn text(
        &mut self,
        section: &str,
        key: &str,
        conditions: Option<&Conditions>,
        channel: &str,
        value: &str,
    ) {
        let [altitude, turbidity, sun] = conditions.map_or_else(
            || [const { String::new() }; 3],
            |c| {
                [
                    c.observer_altitude.km(),
                    c.turbidity,
                    c.sun_zenith.degrees(),
                ]
                .map(|v| {
                    if v.is_nan() {
                        String::new()
                    } else {
                        rounded(v).to_string()
                    }
                })
            },
        );
        self.rows.push_str(&format!(
            "{},{},{altitude},{turbidity},{sun},{},{}\n",
            quoted(section),
            quoted(key),
            quoted(channel),
            quoted(value)
        ));
    }

    /// The table with its header.
    pub(super) fn finish(self) -> String {
        format!("{HEADER}{}", self.rows)
    }
}
