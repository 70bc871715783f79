//! `utm-sky report`: one self-contained HTML page on a look-up table, and its figures as CSV.
//!
//! [`build`] makes both from a [`ReportInput`]: the truth, the fits to judge and what the fitting said
//! of each cell. The page loads nothing: style, charts (SVG) and pictures (PNG) are in it. Nothing
//! depends on the clock or on the number of threads.
//!
//! # `report.csv`
//! A long table, `section,key,altitude_km,turbidity,sun_zenith_deg,channel,value`. `section` is that
//! of the page, `key` the quantity with its unit, `channel` the model, constituent or Yxy channel.
//! Conditions that a figure does not have are left empty; `value` is a number but in the sections
//! `cells` (why a fit stopped), `figures` and `provenance`.

pub mod appendix_a;
mod cells;
pub(crate) mod chart;
mod long_table;
pub(crate) mod page;
mod physics;
pub(crate) mod picture;
pub(crate) use picture::png_address;
mod skies;
mod summary;
pub mod wavelengths;

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use sky_core::axis::Axis;
use sky_core::color::Yxy;
use sky_core::conditions::Conditions;
use sky_core::lut::{Lut, LutHeader};
use sky_fit::sweep::{Grid, NodeFit, SkyMap, Sweep};
use sky_science::sky_model::SkyModel;
use sky_science::table_sky::TableSky;
use sky_sim::optics::OpticsSettings;
use sky_sim::profile::AtmosphereProfile;

use crate::args::ReportArgs;
use crate::atmosphere::{load_profile, profile_hash};
use crate::evaluate::{CaseCounts, Nodes, compare_maps};
use crate::files::{OutputFile, create_directory};
use crate::generate::{MAP_STEP_NM, bake, progress, spinner};
use crate::lut_commands::load;
use crate::plan::{self, Seen};
use crate::truth::{DEFAULT_GROUND_ALBEDO, TransportSky};
use chart::{HeatMap, short};
use long_table::LongTable;
use page::Section;
use wavelengths::WavelengthRow;

/// A sky to judge.
#[derive(Clone)]
pub struct NamedModel<'a> {
    /// Name for tables and legends.
    pub name: String,
    /// The sky.
    pub model: &'a dyn SkyModel,
    /// Nodes of its table; empty where it has none.
    pub nodes: Nodes,
}

impl std::fmt::Debug for NamedModel<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("NamedModel")
            .field("name", &self.name)
            .field("nodes", &self.nodes)
            .finish_non_exhaustive()
    }
}

/// How the fit of one channel went at a node.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelReport {
    /// Y, x or y.
    pub channel: &'static str,
    /// Root mean square of the residuals: of the logarithm for Y, of the chromaticity else.
    pub rms: f64,
    /// Why the solver stopped.
    pub why_stopped: String,
    /// Whether it stopped at a minimum.
    pub converged: bool,
    /// Condition number of the Jacobian; NaN if unknown.
    pub condition_number: f64,
    /// What else is to say: parameters at a bound, regularization; may be empty.
    pub note: String,
}

/// How the fits at a node went and how far they are from the truth there.
#[derive(Clone, Debug, PartialEq)]
pub struct CellReport {
    /// The node.
    pub conditions: Conditions,
    /// Its channels.
    pub channels: Vec<ChannelReport>,
    /// 95th percentile of ΔE at the node.
    pub delta_e_p95: f64,
    /// 95th percentile of the relative error of luminance at the node.
    pub luminance_p95: f64,
}

/// A figure that the report only passes on, such as the size of the table.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// What it is, with its unit.
    pub what: String,
    /// The figure.
    pub value: String,
    /// What is asked; empty for nothing.
    pub target: String,
    /// Whether it is met; `None` where nothing is asked.
    pub met: Option<bool>,
}

/// How much the report computes.
#[derive(Clone, Debug, PartialEq)]
pub struct ReportSettings {
    /// Turbidity of spectra, pictures and chromaticity paths.
    pub scene_turbidity: f64,
    /// Held-out cases.
    pub cases: CaseCounts,
    /// Turbidities of the graphs of error against altitude.
    pub sweep_turbidities: Vec<f64>,
    /// Sun zenith angles of those graphs \[deg\].
    pub sweep_suns_deg: Vec<f64>,
    /// Altitudes of those graphs, 0–30 km.
    pub sweep_altitudes: u8,
    /// Altitudes of the pictures \[km\].
    pub picture_altitudes_km: Vec<f64>,
    /// Sun zenith angles of the pictures \[deg\].
    pub picture_suns_deg: Vec<f64>,
    /// Sun positions of a chromaticity path, 0–96°.
    pub path_suns: u8,
}

impl Default for ReportSettings {
    /// The turbidities are those of the held-out sequence, so that none is solved for a picture alone.
    fn default() -> Self {
        Self {
            scene_turbidity: 2.75,
            cases: CaseCounts::default(),
            sweep_turbidities: vec![1.875, 4.5],
            sweep_suns_deg: vec![30.0, 75.0, 88.5],
            sweep_altitudes: 31,
            picture_altitudes_km: vec![0.0, 3.0, 12.0, 30.0],
            picture_suns_deg: vec![0.0, 60.0, 88.0, 92.0],
            path_suns: 33,
        }
    }
}

/// Everything that a report is made from.
#[derive(Clone, Copy, Debug)]
pub struct ReportInput<'a> {
    /// The atmosphere.
    pub profile: &'a AtmosphereProfile,
    /// What the fits are judged by.
    pub truth: &'a TransportSky,
    /// The skies to judge. The targets are asked of the first; its nodes decide on the held-out cases.
    pub fits: &'a [NamedModel<'a>],
    /// The nodes of the first fit's table.
    pub cells: &'a [CellReport],
    /// Color on coarse wavelengths against 1 nm, from [`wavelengths::convergence`]; may be empty.
    pub wavelengths: &'a [WavelengthRow],
    /// What each constituent of the air is worth, from [`crate::plan::ledger`]; may be empty.
    pub ledger: &'a [Seen],
    /// Figures that the report passes on.
    pub figures: &'a [Figure],
    /// Where everything comes from: hash of the profile, settings, version.
    pub provenance: &'a [(String, String)],
    /// How much to compute.
    pub settings: &'a ReportSettings,
}

/// The finished report.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReportFiles {
    /// `report.html`.
    pub html: String,
    /// `report.csv`.
    pub csv: String,
}

/// Anchors of the page's sections, in order.
pub const SECTIONS: [&str; 12] = [
    "summary",
    "profile",
    "spectra",
    "pictures",
    "cells",
    "altitude",
    "chromaticity",
    "wavelengths",
    "terms",
    "worst",
    "appendix-a",
    "provenance",
];

/// Builds the report.
///
/// # Errors
/// When no fit is given, a case lies outside the truth's domain, or a chart cannot be drawn.
pub fn build(input: &ReportInput<'_>) -> Result<ReportFiles> {
    if input.fits.is_empty() {
        bail!("report: expected at least one sky to judge, found none");
    }
    let mut csv = LongTable::default();
    let sections = [
        summary::summary(input, &mut csv)?,
        physics::profile_graphs(input, &mut csv)?,
        physics::spectra(input, &mut csv)?,
        skies::pictures(input)?,
        cells::maps(input, &mut csv)?,
        summary::against_altitude(input, &mut csv)?,
        skies::chromaticity_paths(input, &mut csv)?,
        wavelengths::section(input.wavelengths, &mut csv),
        terms(input.ledger, &mut csv)?,
        cells::worst(input, &mut csv),
        appendix_section(&mut csv),
        provenance(input, &mut csv),
    ];
    debug_assert!(sections.iter().map(|s| s.id).eq(SECTIONS));
    let lead = format!(
        "How well {} agrees with the transport engine it was fitted to, and what both are made of. \
         Altitudes are above sea level, angles from the zenith; turbidity T = 1 + aerosol optical \
         depth at 500 nm / 0.14344.",
        page::escape(&input.fits[0].name)
    );
    Ok(ReportFiles {
        html: page::page("UTM sky model: report", &lead, &sections),
        csv: csv.finish(),
    })
}

fn appendix_section(csv: &mut LongTable) -> Section {
    let counts = appendix_a::audit();
    let total = appendix_a::rows().len();
    let rows: Vec<Vec<String>> = appendix_a::TESTS
        .iter()
        .zip(counts)
        .map(|(test, count)| {
            csv.figure("appendix-a", test.criterion, None, "rows", count_f64(count));
            vec![page::escape(test.criterion), format!("{count} of {total}")]
        })
        .collect();
    let body = format!(
        "<p>The report that this project continues prints a look-up table of {total} rows, each with \
         one set of coefficients and a zenith color. This is how many of its rows describe a sky that \
         can exist. The table cannot be reproduced and nothing is measured by it.</p>\n{}",
        page::table(&["a row passes if", "rows"], &rows, 1)
    );
    Section {
        id: "appendix-a",
        title: "Audit of the printed look-up table (Appendix A)",
        body,
    }
}

/// What leaving out a term would do to the sky.
fn terms(ledger: &[Seen], csv: &mut LongTable) -> Result<Section> {
    let rows: Vec<Vec<String>> = ledger
        .iter()
        .map(|seen| {
            for (what, value) in [
                ("directions seen", seen.directions_seen),
                ("cases seen", seen.cases_seen),
                ("delta_e p95", seen.delta_e_p95),
                ("luminance p95", seen.luminance_p95),
            ] {
                csv.figure("terms", seen.term, None, what, value);
            }
            let worst = &seen.worst;
            vec![
                page::escape(seen.term),
                format!("{:.1} %", 100.0 * seen.directions_seen),
                format!("{:.1} %", 100.0 * seen.cases_seen),
                format!("{:.2}", seen.delta_e_p95),
                format!("{:.2} %", 100.0 * seen.luminance_p95),
                format!(
                    "{:.1} for {:.1} km, T {:.2}, sun {:.1}°",
                    seen.delta_e_max,
                    worst.observer_altitude.km(),
                    worst.turbidity,
                    worst.sun_zenith.degrees()
                ),
            ]
        })
        .collect();
    let labels = |all: &[f64]| all.iter().map(|v| short(*v)).collect::<Vec<_>>();
    let mut maps = String::new();
    for seen in ledger.iter().filter(|seen| !seen.map.is_empty()) {
        let map = HeatMap {
            title: format!("without {}", seen.term),
            x: ("sun zenith [°]".to_owned(), labels(&plan::SUNS_DEG)),
            y: ("altitude [km]".to_owned(), labels(&plan::ALTITUDES_KM)),
            values: seen.map.iter().map(|share| 100.0 * share).collect(),
            full_scale: 100.0,
            size: [350, 220],
        };
        maps.push_str(&map.html()?);
    }
    let body = format!(
        "<p>The sky without a term, against the whole one, over the default table's domain: altitudes, \
         suns and three turbidities (1.2, 2.6, 5.5), directions from the zenith to the horizon. A term is \
         seen where ΔE2000 is above 1; the maps show where. Constituents, the ground's light and orders of \
         scattering are left out of the transport engine; curvature out of its first order; the \
         others out of the table. <code>utm-sky plan SCENE --explain TERM</code> shows a scene \
         without a constituent.</p>\n{}<div class=\"grid\">{maps}</div>{}",
        page::table(
            &[
                "without",
                "directions seen",
                "cases seen",
                "ΔE p95",
                "luminance p95",
                "largest ΔE"
            ],
            &rows,
            1
        ),
        chart::color_bar(100.0, "% of directions")
    );
    Ok(Section {
        id: "terms",
        title: "What each term is worth",
        body,
    })
}

fn provenance(input: &ReportInput<'_>, csv: &mut LongTable) -> Section {
    let rows: Vec<Vec<String>> = input
        .provenance
        .iter()
        .map(|(key, value)| {
            csv.text("provenance", key, None, "", value);
            vec![
                page::escape(key),
                format!("<code>{}</code>", page::escape(value)),
            ]
        })
        .collect();
    Section {
        id: "provenance",
        title: "Provenance",
        body: page::table(&["what", "value"], &rows, 2),
    }
}

fn count_f64(count: usize) -> f64 {
    f64::from(u32::try_from(count).unwrap_or(u32::MAX))
}

/// Runs the command.
///
/// # Errors
/// When the table or its profile cannot be read, its truth cannot be computed or the files cannot be
/// written.
pub fn run(args: &ReportArgs) -> Result<()> {
    let lut = load(&args.lut)?;
    let profile = PathBuf::from(&lut.header().profile_name);
    let found = profile_hash(&profile)?;
    if found != lut.header().profile_sha256 {
        bail!(
            "{}: expected the profile that the table was made from, SHA-256 {}, found {found}",
            profile.display(),
            lut.header().profile_sha256
        );
    }
    let outputs = create_outputs(&args.out)?;
    let settings = OpticsSettings::with_step_nm(MAP_STEP_NM)?;
    let truth = TransportSky::new(load_profile(&profile)?, settings, DEFAULT_GROUND_ALBEDO)?;
    write_report(&truth, &profile, lut, None, outputs)
}

/// Makes the report of a table and writes it; `sweep` is what the table was fitted from, if that is at
/// hand.
///
/// # Errors
/// When a comparison cannot be computed or the files cannot be written.
pub fn write_report(
    truth: &TransportSky,
    profile: &Path,
    lut: Lut,
    sweep: Option<Sweep>,
    outputs: [OutputFile; 2],
) -> Result<()> {
    let bytes = lut.encode().len();
    let header = lut.header().clone();
    let sky = TableSky::new(lut)?;
    let (maps, nodes) = match sweep {
        Some(sweep) => (sweep.maps, sweep.nodes),
        None => (node_maps(truth, &header)?, Vec::new()),
    };
    let bar = spinner("report: the report's own table");
    let (seed, _) = bake(truth, &Grid::report()?, profile, truth.extinction()?)?;
    bar.set_message("report: Perez's five coefficients");
    let (perez, _) = bake(truth, &Grid::perez()?, profile, truth.extinction()?)?;
    bar.set_message("report: wavelengths");
    let wavelengths = wavelengths::convergence(truth, &wavelengths::CONDITIONS)?;
    bar.set_message("report: terms");
    let ledger = plan::ledger(&|| ())?;
    bar.set_message("report: held-out cases and pictures");
    let (seed, perez) = (TableSky::new(seed)?, TableSky::new(perez)?);
    let named = |name: &str, model: &'_ TableSky| {
        let h = model.lut().header();
        let nodes = |axis: &Axis| axis.nodes().to_vec();
        (
            format!("{name} ({:.1} KiB)", kib(model.lut().encode().len())),
            Nodes {
                altitude_km: nodes(&h.altitude_km),
                turbidity: nodes(&h.turbidity),
                sun_zenith_deg: nodes(&h.sun_zenith_deg),
            },
        )
    };
    let models = [
        ("this table", &sky),
        ("the report, 2005", &seed),
        ("Perez, spherical air mass", &perez),
    ];
    let fits: Vec<NamedModel<'_>> = models
        .iter()
        .map(|(name, model)| {
            let (name, nodes) = named(name, model);
            NamedModel {
                name,
                model: *model,
                nodes,
            }
        })
        .collect();
    let figures = [Figure {
        what: "size of the table [KiB]".to_owned(),
        value: format!("{:.1}", kib(bytes)),
        target: "at most 128".to_owned(),
        met: Some(bytes <= 128 * 1024),
    }];
    let mut provenance: Vec<(String, String)> = [
        ("made by", header.generator.clone()),
        ("profile", header.profile_name.clone()),
        ("profile SHA-256", header.profile_sha256.clone()),
        ("engine", header.engine.clone()),
        ("form", header.form.name().to_owned()),
        ("interpolation", header.interpolation.name().to_owned()),
    ]
    .map(|(what, value)| (what.to_owned(), value))
    .to_vec();
    provenance.extend(
        header
            .settings
            .iter()
            .map(|(k, v)| (k.clone(), v.to_string())),
    );
    let files = build(&ReportInput {
        profile: truth.profile(),
        truth,
        fits: &fits,
        cells: &cell_reports(&sky, &maps, &nodes)?,
        wavelengths: &wavelengths,
        ledger: &ledger,
        figures: &figures,
        provenance: &provenance,
        settings: &ReportSettings::default(),
    })?;
    bar.finish_and_clear();
    files.write(outputs)
}

/// The truth at the nodes of a table.
fn node_maps(truth: &TransportSky, header: &LutHeader) -> Result<Vec<SkyMap>> {
    let grid = Grid {
        altitude_km: header.altitude_km.clone(),
        turbidity: header.turbidity.clone(),
        sun_zenith_deg: header.sun_zenith_deg.clone(),
        form: header.form,
    };
    let bar = progress("sky maps", grid.nodes());
    let maps = sky_fit::sweep::node_maps(truth, &grid, &|| bar.inc(1))?;
    bar.finish_and_clear();
    Ok(maps)
}

/// How far a table is from the maps at its nodes, and how the fits went there where a solver made them.
fn cell_reports(sky: &TableSky, maps: &[SkyMap], nodes: &[NodeFit]) -> Result<Vec<CellReport>> {
    let header = sky.lut().header();
    let on_node = |axis: &Axis, value: f64| axis.nodes().iter().any(|n| (n - value).abs() < 1e-9);
    let mut cells = Vec::new();
    for (i, map) in maps.iter().enumerate() {
        let c = &map.conditions;
        // a solver's maps are the nodes, one by one
        let fits = if nodes.len() == maps.len() {
            nodes[i].channels.as_slice()
        } else {
            &[]
        };
        if !(on_node(&header.altitude_km, c.observer_altitude.km())
            && on_node(&header.sun_zenith_deg, c.sun_zenith.degrees()))
        {
            continue;
        }
        let found = sky.yxy_map(c, &map.directions)?;
        let errors = compare_maps(c, &map.directions, &map.sky, &found);
        let pairs = || {
            found
                .iter()
                .zip(&map.sky)
                .filter(|(_, t)| t.luminance_cd_m2 > 0.0)
        };
        let rms = |residual: &dyn Fn(&Yxy, &Yxy) -> f64| {
            let squares: f64 = pairs().map(|(f, t)| residual(f, t).powi(2)).sum();
            (squares / count_f64(pairs().count().max(1))).sqrt()
        };
        let channel = |k: usize, channel, rms| match fits.get(k) {
            None => ChannelReport {
                channel,
                rms,
                why_stopped: "linear least squares".to_owned(),
                converged: true,
                condition_number: f64::NAN,
                note: String::new(),
            },
            Some(fit) => ChannelReport {
                channel,
                rms: fit.report.rms,
                why_stopped: format!("{:?}", fit.report.why_stopped),
                converged: fit.report.why_stopped.converged(),
                condition_number: fit.report.condition_number,
                note: if fit.report.at_bounds.contains(&true) {
                    "a parameter at its bound".to_owned()
                } else {
                    String::new()
                },
            },
        };
        let p95 = |s: Option<sky_science::metrics::Statistics>| s.map_or(f64::NAN, |s| s.p95);
        cells.push(CellReport {
            conditions: *c,
            channels: vec![
                channel(
                    0,
                    "Y",
                    rms(&|f, t| (f.luminance_cd_m2 / t.luminance_cd_m2).ln()),
                ),
                channel(1, "x", rms(&|f, t| f.x - t.x)),
                channel(2, "y", rms(&|f, t| f.y - t.y)),
            ],
            delta_e_p95: p95(errors.delta_e_statistics()),
            luminance_p95: p95(errors.luminance_statistics()),
        });
    }
    Ok(cells)
}

fn kib(bytes: usize) -> f64 {
    count_f64(bytes) / 1024.0
}

/// The report's two output files in a directory, which is made if missing: page, then CSV. Opened
/// before the work starts, so that a bad directory is told at once.
///
/// # Errors
/// When the directory cannot be made or written to.
pub fn create_outputs(directory: &Path) -> Result<[OutputFile; 2]> {
    create_directory(directory)?;
    Ok([
        OutputFile::create(&directory.join("report.html"))?,
        OutputFile::create(&directory.join("report.csv"))?,
    ])
}

impl ReportFiles {
    /// Writes the report to the files that [`create_outputs`] opened.
    ///
    /// # Errors
    /// When writing fails.
    pub fn write(&self, [html, csv]: [OutputFile; 2]) -> Result<()> {
        html.commit(self.html.as_bytes())?;
        csv.commit(self.csv.as_bytes())?;
        Ok(())
    }
}
