//! The report of a look-up table: what it is compared with, and how its fit went.

use anyhow::Result;
use sky_core::axis::Axis;
use sky_core::color::Yxy;
use sky_core::lut::{Lut, LutHeader};
use sky_fit::problem::ChannelFit;
use sky_fit::sweep::{Grid, NodeFit, SkyMap, Sweep};
use sky_science::sky_model::SkyModel as _;
use sky_science::table_sky::TableSky;

use super::input::{CellReport, ChannelReport, Figure, NamedModel, ReportInput, ReportSettings};
use super::text::count_f64;
use super::{ReportFiles, build, wavelengths};
use crate::bake::bake;
use crate::cases::Nodes;
use crate::ledger::ledger;
use crate::profiles::NamedProfile;
use crate::progress::Progress;
use crate::score::compare_maps;
use crate::truth::TransportSky;

/// Makes the report of a table; `sweep` is what the table was fitted from, if that is at hand.
///
/// # Errors
/// When a comparison cannot be computed.
pub fn of_table(
    truth: &TransportSky,
    profile: &NamedProfile,
    lut: Lut,
    sweep: Option<Sweep>,
    progress: &dyn Progress,
) -> Result<ReportFiles> {
    let bytes = lut.encode().len();
    let header = lut.header().clone();
    let sky = TableSky::new(lut)?;
    let (maps, nodes) = match sweep {
        Some(sweep) => (sweep.maps, sweep.nodes),
        None => (node_maps(truth, &header, progress)?, Vec::new()),
    };
    let beside = |what, grid: Grid| -> Result<TableSky> {
        progress.begin(what, None);
        let (lut, _) = bake(truth, &grid, profile, truth.extinction()?, progress)?;
        progress.end();
        Ok(TableSky::new(lut)?)
    };
    let seed = beside("report: the report's own table", Grid::report()?)?;
    let perez = beside("report: Perez's five coefficients", Grid::perez()?)?;
    progress.begin("report: wavelengths", None);
    let wavelengths = wavelengths::convergence(truth, &wavelengths::CONDITIONS)?;
    progress.end();
    let ledger = ledger(progress)?;
    progress.begin("report: held-out cases and pictures", None);
    let fits = [
        named("this table", &sky),
        named("the report, 2005", &seed),
        named("Perez, spherical air mass", &perez),
    ];
    let figures = [Figure {
        what: "size of the table [KiB]".to_owned(),
        value: format!("{:.1}", kib(bytes)),
        target: "at most 128".to_owned(),
        met: Some(bytes <= 128 * 1024),
    }];
    let files = build(&ReportInput {
        profile: truth.profile(),
        truth,
        fits: &fits,
        cells: &cell_reports(&sky, &maps, &nodes)?,
        wavelengths: &wavelengths,
        ledger: &ledger,
        figures: &figures,
        provenance: &provenance(&header),
        settings: &ReportSettings::default(),
    })?;
    progress.end();
    Ok(files)
}

/// A table's sky with its nodes, its size in the name.
fn named<'a>(name: &str, sky: &'a TableSky) -> NamedModel<'a> {
    let header = sky.lut().header();
    let nodes = |axis: &Axis| axis.nodes().to_vec();
    NamedModel {
        name: format!("{name} ({:.1} KiB)", kib(sky.lut().encode().len())),
        model: sky,
        nodes: Nodes {
            altitude_km: nodes(&header.altitude_km),
            turbidity: nodes(&header.turbidity),
            sun_zenith_deg: nodes(&header.sun_zenith_deg),
        },
    }
}

/// Where a table comes from, as its header has it.
fn provenance(header: &LutHeader) -> Vec<(String, String)> {
    let own = [
        ("made by", header.generator.clone()),
        ("profile", header.profile_name.clone()),
        ("profile SHA-256", header.profile_sha256.clone()),
        ("engine", header.engine.clone()),
        ("form", header.form.name().to_owned()),
        ("interpolation", header.interpolation.name().to_owned()),
    ]
    .map(|(what, value)| (what.to_owned(), value));
    let settings = header
        .settings
        .iter()
        .map(|(k, v)| (k.clone(), v.to_string()));
    own.into_iter().chain(settings).collect()
}

/// The truth at the nodes of a table.
fn node_maps(
    truth: &TransportSky,
    header: &LutHeader,
    progress: &dyn Progress,
) -> Result<Vec<SkyMap>> {
    let grid = Grid {
        altitude_km: header.altitude_km.clone(),
        turbidity: header.turbidity.clone(),
        sun_zenith_deg: header.sun_zenith_deg.clone(),
        form: header.form,
    };
    progress.begin("sky maps", Some(grid.nodes()));
    let maps = sky_fit::sweep::node_maps(truth, &grid, &|| progress.step())?;
    progress.end();
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
        let p95 = |s: Option<sky_science::metrics::Statistics>| s.map_or(f64::NAN, |s| s.p95);
        cells.push(CellReport {
            conditions: *c,
            channels: channel_reports(&found, &map.sky, fits),
            delta_e_p95: p95(errors.delta_e_statistics()),
            luminance_p95: p95(errors.luminance_statistics()),
        });
    }
    Ok(cells)
}

/// A channel's name, and what a light misses of the truth in it.
type Residual = (&'static str, fn(&Yxy, &Yxy) -> f64);

/// How far each channel is from the truth, and how its fit went where a solver made it.
fn channel_reports(found: &[Yxy], truth: &[Yxy], fits: &[ChannelFit]) -> Vec<ChannelReport> {
    let pairs = || {
        found
            .iter()
            .zip(truth)
            .filter(|(_, t)| t.luminance_cd_m2 > 0.0)
    };
    let rms = |residual: fn(&Yxy, &Yxy) -> f64| {
        let squares: f64 = pairs().map(|(f, t)| residual(f, t).powi(2)).sum();
        (squares / count_f64(pairs().count().max(1))).sqrt()
    };
    let residuals: [Residual; 3] = [
        ("Y", |f, t| (f.luminance_cd_m2 / t.luminance_cd_m2).ln()),
        ("x", |f, t| f.x - t.x),
        ("y", |f, t| f.y - t.y),
    ];
    residuals
        .into_iter()
        .enumerate()
        .map(|(k, (channel, residual))| match fits.get(k) {
            None => ChannelReport {
                channel,
                rms: rms(residual),
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
        })
        .collect()
}

fn kib(bytes: usize) -> f64 {
    count_f64(bytes) / 1024.0
}
