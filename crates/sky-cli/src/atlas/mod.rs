//! `utm-sky atlas`: where every model fails, found by a sweep over its domain and beyond.
//!
//! [`models`] is the list of models, the published ones included, and [`kind::KINDS`] that of failures; [`sweep`] asks every model the
//! same questions. Nothing depends on the clock or on the number of threads. Out of scope: whether an
//! answer is right (`report`, `chart`).

mod gpu;
pub mod kind;
mod locus;
mod page;
pub mod sweep;
pub(crate) mod twin;

use std::fmt::Write as _;
use std::path::Path;

use anyhow::{Context, Result, anyhow, bail};
use sky_core::axis::Axis;
use sky_core::utm_sky::UtmSky;
use sky_gpu::headless::Headless;
use sky_science::sky_model::SkyModel;
use sky_science::table_sky::TableSky;

use crate::args::AtlasArgs;
use crate::evaluate::Nodes;
use crate::files::{OutputFile, print};
use crate::generate::{bake, progress, spinner};
use crate::models::{Source, all, general_truth};
use kind::{Arithmetic, KINDS, Place, With};
use sweep::{Density, Findings};

/// Models whose every condition costs tables of its own: not in the quick sweep, and asked less in the
/// full one.
const SLOW: [&str; 5] = [
    "nishita",
    "nishita-table",
    "dobashi",
    "hillaire",
    "bruneton",
];

/// A model of the atlas.
#[derive(Clone, Copy, Debug)]
pub struct ModelEntry {
    /// Name in `--models` and in the files.
    pub name: &'static str,
    source: Source,
}

/// The models of `utm-sky models`, but for our own tiers: they are the same formula.
#[must_use]
pub fn models() -> Vec<ModelEntry> {
    all()
        .into_iter()
        .filter(|m| !matches!(m.source, Source::Baked | Source::Dome))
        .map(|m| ModelEntry {
            name: m.name,
            source: m.source,
        })
        .collect()
}

impl ModelEntry {
    /// Makes the model.
    ///
    /// # Errors
    /// When its table cannot be read or made.
    pub fn subject(&self) -> Result<Subject> {
        match self.source {
            Source::Table(grid) => {
                let truth = general_truth()?;
                let (table, _) = bake(&truth, &grid()?, Path::new("general"), truth.extinction()?)?;
                let lut = format!("{}.utmlut", self.name);
                Ok(Subject::table_of(TableSky::new(table)?, &lut))
            }
            Source::Published(baseline) => Ok(Subject::other((baseline.sky)())),
            Source::Ours | Source::Baked | Source::Dome => {
                Ok(Subject::table_of(UtmSky::embedded()?.into(), "embedded"))
            }
        }
    }

    /// How densely it is swept.
    fn density(&self, quick: bool) -> Density {
        if quick || SLOW.contains(&self.name) {
            Density::QUICK
        } else {
            Density::FULL
        }
    }
}

/// A model under the sweep.
pub struct Subject {
    sky: Sky,
    /// In what numbers it answers.
    pub arithmetic: Arithmetic,
    /// Nodes of its table; empty where it has none.
    pub nodes: Nodes,
    /// What `utm-sky sky --lut` must be given to ask it; without it, it is asked by its name.
    pub lut: Option<String>,
}

enum Sky {
    Table(TableSky),
    Other(Box<dyn SkyModel>),
}

impl std::fmt::Debug for Subject {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Subject")
            .field("name", &self.model().name())
            .field("arithmetic", &self.arithmetic)
            .finish_non_exhaustive()
    }
}

impl Subject {
    /// A table's sky; `lut` names the table on the command line.
    #[must_use]
    pub fn table_of(sky: TableSky, lut: &str) -> Self {
        let header = sky.lut().header();
        let list = |axis: &Axis| axis.nodes().to_vec();
        Self {
            arithmetic: Arithmetic::CpuF32,
            nodes: Nodes {
                altitude_km: list(&header.altitude_km),
                turbidity: list(&header.turbidity),
                sun_zenith_deg: list(&header.sun_zenith_deg),
            },
            lut: Some(lut.to_owned()),
            sky: Sky::Table(sky),
        }
    }

    /// Any other sky, in double precision. Black (Y, x and y 0) below the horizon is taken as no answer.
    #[must_use]
    pub fn other(sky: Box<dyn SkyModel>) -> Self {
        Self {
            arithmetic: Arithmetic::CpuF64,
            nodes: Nodes::default(),
            lut: None,
            sky: Sky::Other(sky),
        }
    }

    /// The sky.
    #[must_use]
    pub fn model(&self) -> &dyn SkyModel {
        match &self.sky {
            Sky::Table(sky) => sky,
            Sky::Other(sky) => &**sky,
        }
    }

    /// The runtime's sky, if it is one.
    #[must_use]
    pub fn table(&self) -> Option<&UtmSky> {
        match &self.sky {
            Sky::Table(sky) => sky.utm(),
            Sky::Other(_) => None,
        }
    }

    /// Sweeps the model. `done` is told of each of [`Self::columns`].
    pub fn sweep(&self, density: Density, done: &(dyn Fn() + Sync)) -> Findings {
        sweep::sweep(self, density, done)
    }

    /// Steps that a sweep tells of.
    #[must_use]
    pub fn columns(&self, density: Density) -> usize {
        sweep::columns(self, density)
    }
}

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

/// The models of a list of names, all of them without one.
fn chosen(names: Option<&[String]>, quick: bool) -> Result<Vec<ModelEntry>> {
    let known = models();
    let Some(names) = names else {
        return Ok(known
            .into_iter()
            .filter(|m| !(quick && SLOW.contains(&m.name)))
            .collect());
    };
    names
        .iter()
        .map(|name| {
            known
                .iter()
                .find(|m| m.name == name)
                .copied()
                .ok_or_else(|| {
                    let known: Vec<&str> = known.iter().map(|m| m.name).collect();
                    anyhow!(
                        "--models: expected some of {}, found {name}",
                        known.join(", ")
                    )
                })
        })
        .collect()
}

/// Runs the command.
///
/// # Errors
/// When a model is unknown or cannot be made, or the files cannot be written.
pub fn run(args: &AtlasArgs) -> Result<()> {
    let models = chosen(args.models.as_deref(), args.quick)?;
    if models.is_empty() {
        bail!("--models: expected at least one model, found none");
    }
    std::fs::create_dir_all(&args.out).with_context(|| {
        format!(
            "{}: expected a directory or a place to make one",
            args.out.display()
        )
    })?;
    let csv_file = OutputFile::create(&args.out.join("atlas.csv"))?;
    let html_file = OutputFile::create(&args.out.join("atlas.html"))?;
    let mut chapters = Vec::new();
    for entry in models {
        let sign = spinner(entry.name);
        let subject = entry.subject()?;
        let density = entry.density(args.quick);
        sign.finish_and_clear();
        if let (Some(table), Some(name)) = (subject.table(), &subject.lut)
            && name != "embedded"
        {
            // what the commands of the atlas ask
            OutputFile::create(&args.out.join(name))?.commit(&table.lut().encode())?;
        }
        let bar = progress(entry.name, subject.columns(density));
        let mut findings = subject.sweep(density, &|| bar.inc(1));
        bar.finish_and_clear();
        if let Some(table) = subject.table()
            && subject.lut.as_deref() == Some("embedded")
        {
            match Headless::new() {
                Ok(device) => {
                    let bar = progress("panoramas", density.panoramas() as usize);
                    gpu::sweep(&device, table, density, &mut findings, &|| bar.inc(1))?;
                    bar.finish_and_clear();
                }
                Err(error) => print(&format!("gpu_f32 is left out: {error}\n"))?,
            }
        }
        chapters.push(Chapter {
            name: entry.name,
            subject,
            findings,
        });
    }
    csv_file.commit(&csv(&chapters)?)?;
    html_file.commit(page::html(&chapters)?.as_bytes())?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::conditions;
    use sky_core::direction::SkyDirection;

    #[test]
    fn an_unknown_model_is_named() {
        let names = ["utm-sky".to_owned(), "hosekk".to_owned()];
        let message = chosen(Some(&names), true)
            .map(|_| ())
            .unwrap_err()
            .to_string();
        assert!(
            message.contains("hosekk") && message.contains("utm2005"),
            "{message}"
        );
        assert_eq!(chosen(None, false).unwrap().len(), models().len());
    }

    #[test]
    fn a_worst_case_is_a_command() {
        let subject = models()[0].subject().unwrap();
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
