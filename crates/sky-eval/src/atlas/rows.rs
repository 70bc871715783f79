//! What the atlas found, as rows: counts, and a command that shows each worst case.

use std::fmt::Write as _;

use anyhow::{Result, anyhow};

use super::kind::{Arithmetic, KINDS, Place, With};
use super::subject::Subject;
use super::sweep::Findings;

/// A model and what its sweep found.
#[derive(Debug)]
pub struct Chapter {
    /// The model's name.
    pub name: &'static str,
    /// The model.
    pub subject: Subject,
    /// What was found.
    pub findings: Findings,
}

/// A row of `atlas.csv`.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The model's name.
    pub model: &'static str,
    /// In what numbers.
    pub arithmetic: Arithmetic,
    /// Kind of failure, an index of [`KINDS`].
    pub kind: usize,
    /// Whether the samples lie inside the model's domain.
    pub inside_domain: bool,
    /// Samples taken.
    pub samples: u64,
    /// Samples that failed.
    pub failures: u64,
    /// Largest score.
    pub worst_value: f64,
    /// A command that shows the worst case.
    pub reproduce: String,
}

impl Chapter {
    /// One row for each arithmetic, kind and side of the domain that has samples.
    #[must_use]
    pub fn rows(&self) -> Vec<Row> {
        let mut rows = Vec::new();
        for arithmetic in Arithmetic::ALL {
            for (kind, entry) in KINDS.iter().enumerate() {
                for inside_domain in [true, false] {
                    let tally = self
                        .findings
                        .tallies
                        .get(arithmetic, entry.kind, inside_domain);
                    if tally.samples > 0 {
                        rows.push(Row {
                            model: self.name,
                            arithmetic,
                            kind,
                            inside_domain,
                            samples: tally.samples,
                            failures: tally.failures,
                            worst_value: tally.worst,
                            reproduce: tally
                                .place
                                .map_or_else(String::new, |p| reproduce(&self.subject, &p)),
                        });
                    }
                }
            }
        }
        rows
    }
}

/// The shell command that shows a place; run in the directory of `atlas.csv`.
fn reproduce(subject: &Subject, place: &Place) -> String {
    let scene = |altitude_km: f64| {
        format!(
            "--altitude-km {} --turbidity {} --sun-zenith-deg {}",
            round(altitude_km),
            place.conditions.turbidity,
            round(place.conditions.sun_zenith.degrees())
        )
    };
    let degrees = |d: &sky_core::direction::SkyDirection| {
        [d.view_zenith.degrees(), d.relative_azimuth.degrees()].map(round)
    };
    let here = place.conditions.observer_altitude.km();
    let [zenith, azimuth] = degrees(&place.direction);
    let ask = subject.lut.as_ref().map_or_else(
        || format!("--model {}", subject.model().name()),
        |lut| format!("--lut {lut}"),
    );
    if let With::Path(distance) = place.with {
        return format!(
            "printf 'view_zenith_deg,relative_azimuth_deg,distance_km\\n{zenith},{azimuth},{}\\n' \
             > path.csv; utm-sky segment {ask} {} --segments path.csv --out out.csv",
            round(distance),
            scene(here)
        );
    }
    let mut out = format!("printf 'view_zenith_deg,relative_azimuth_deg\\n{zenith},{azimuth}\\n");
    if let With::Direction(other) = &place.with {
        let [zenith, azimuth] = degrees(other);
        let _ = write!(out, "{zenith},{azimuth}\\n");
    }
    out.push_str("' > view.csv");
    let altitudes = match place.with {
        With::Altitude(there) => vec![here, there],
        With::Nodes([low, high]) => vec![low, here, high],
        With::Nothing | With::Direction(_) | With::Path(_) => vec![here],
    };
    for (i, altitude) in altitudes.iter().enumerate() {
        let _ = write!(
            out,
            "; utm-sky sky {ask} {} --directions view.csv --out out{}.csv",
            scene(*altitude),
            i + 1
        );
    }
    out
}

/// Freed of the noise of the way through radians and meters.
fn round(value: f64) -> f64 {
    if value.abs() < 1e6 {
        (value * 1e10).round() / 1e10
    } else {
        value
    }
}

/// `atlas.csv`.
///
/// # Errors
/// Never: it is written to memory.
pub fn csv(chapters: &[Chapter]) -> Result<Vec<u8>> {
    let mut out = csv::Writer::from_writer(Vec::new());
    out.write_record([
        "model",
        "arithmetic",
        "kind",
        "inside_domain",
        "samples",
        "failures",
        "worst_value",
        "reproduce",
    ])?;
    for row in chapters.iter().flat_map(Chapter::rows) {
        out.write_record([
            row.model,
            row.arithmetic.name(),
            KINDS[row.kind].name,
            &row.inside_domain.to_string(),
            &row.samples.to_string(),
            &row.failures.to_string(),
            &format!("{:.6e}", row.worst_value),
            &row.reproduce,
        ])?;
    }
    out.into_inner().map_err(|e| anyhow!("atlas.csv: {e}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::atlas::subject::models;
    use crate::cases::conditions;
    use crate::progress::Silent;
    use sky_core::direction::SkyDirection;

    #[test]
    fn a_worst_case_is_a_command() {
        let subject = models()[0].subject(&Silent).unwrap();
        let place = Place {
            conditions: conditions(6.0, 2.0, 88.0),
            direction: SkyDirection::from_degrees(91.0, 30.0),
            with: With::Altitude(6.01),
        };
        assert_eq!(
            reproduce(&subject, &place),
            "printf 'view_zenith_deg,relative_azimuth_deg\\n91,30\\n' > view.csv\
             ; utm-sky sky --lut embedded --altitude-km 6 --turbidity 2 --sun-zenith-deg 88 \
             --directions view.csv --out out1.csv\
             ; utm-sky sky --lut embedded --altitude-km 6.01 --turbidity 2 --sun-zenith-deg 88 \
             --directions view.csv --out out2.csv"
        );
    }
}
