//! Where the offline side's own time goes: error against seconds for every setting of the transport
//! engine and of the table's fit, so that it is seen whether a default sits at a knee.
//!
//! One setting is changed at a time, the others stay at their defaults. The engine is compared with a
//! finer engine; a table with the engine, on skies that it was not fitted to.

use std::fmt::Write as _;

use anyhow::Result;
use rayon::prelude::*;
use sky_core::axis::Axis;
use sky_core::color::Yxy;
use sky_core::conditions::{Conditions, Domain};
use sky_core::direction::{SkyDirection, horizon_zenith};
use sky_core::extended::TERMS;
use sky_core::lut::{Form, Lut, LutHeader};
use sky_core::quantity::{Angle, Length};
use sky_core::utm_sky::UtmSky;
use sky_fit::sweep::{Grid, MapEquations, SkyMap, between, fit_directions, fit_turbidity};
use sky_science::sky_model::SkyModel;
use sky_sim::optics::OpticsSettings;
use sky_sim::profile::AtmosphereProfile;
use sky_sim::transport::TransportSettings;

use sky_plot::Scale;
use sky_plot::chart::{Chart, Note, Series, Stroke};
use sky_plot::number::short;
use sky_plot::page::table;

use crate::bake::{MAP_STEP_NM, bake};
use crate::cases::{LOWEST_RING_ABOVE_HORIZON_DEG, conditions, evaluation_directions};
use crate::models::general_truth;
use crate::profiles::NamedProfile;
use crate::progress::Progress;
use crate::score::{Pooled, compare_maps, evaluate, pool};
use crate::stopwatch::Stopwatch;
use crate::truth::{DEFAULT_GROUND_ALBEDO, TransportSky};

/// Haze of the places where only altitude and sun vary.
const TURBIDITY: f64 = 3.0;
/// Runs of which the shortest counts, until they have taken so long together \[s\].
const RUNS: u32 = 5;
const REPEATED_S: f64 = 6.0;
/// Where the engine is compared: altitudes \[km\] and sun zenith angles \[deg\].
const ENGINE_PLACES: [[f64; 4]; 2] = [[0.0, 3.0, 12.0, 30.0], [30.0, 75.0, 89.0, 94.0]];
/// Where a table of one turbidity is compared; none is a node or half way between two.
const TABLE_PLACES: [[f64; 6]; 2] = [
    [0.13, 0.62, 2.3, 6.1, 13.2, 26.0],
    [19.0, 55.0, 75.0, 85.1, 89.3, 93.3],
];
/// Where turbidity's nodes are compared: altitude, turbidity, sun zenith angle.
const HAZE_PLACES: [[f64; 6]; 3] = [
    [0.0, 0.4, 0.7, 1.0, 1.5, 2.0],
    [1.02, 1.13, 1.6, 2.7, 3.2, 6.1],
    [68.0, 73.0, 78.0, 83.0, 86.0, 90.0],
];
/// The part of the default grid that turbidity's nodes are compared on.
const HAZE_ALTITUDES_KM: [f64; 2] = [0.0, 2.0];
const HAZE_SUNS_DEG: [f64; 2] = [68.0, 90.0];

/// A value of a setting.
#[derive(Clone, Debug)]
pub struct Point {
    setting: &'static str,
    value: String,
    is_default: bool,
    /// Of the shortest run and of the longest.
    seconds: [f64; 2],
    delta_e_p95: f64,
    luminance_p95: f64,
}

/// Measures all settings, or of a quick run the wavelengths alone.
///
/// # Errors
/// When an atmosphere or a table cannot be made.
pub fn measure(quick: bool, progress: &dyn Progress) -> Result<Vec<Point>> {
    let mut points = Vec::new();
    let settings = engine_settings();
    let grids = table_grids()?;
    let steps: &[u16] = if quick { &[20, 10] } else { &[20, 10, 5] };
    let count = if quick {
        steps.len() + 1
    } else {
        steps.len() + settings.len() + grids.len() + DIRECTIONS.len() + 3 + 2
    };
    progress.begin("our own time", Some(count));
    wavelengths(steps, quick, progress, &mut points)?;
    if !quick {
        engine(&settings, progress, &mut points)?;
        grid(&grids, progress, &mut points)?;
        haze(progress, &mut points)?;
    }
    progress.end();
    Ok(points)
}

/// A map of lights for each condition.
type Maps = Vec<Vec<Yxy>>;

fn engine_conditions(quick: bool) -> Vec<Conditions> {
    let [altitudes, suns] = ENGINE_PLACES;
    let all = altitudes
        .into_iter()
        .flat_map(|h| suns.map(|s| conditions(h, TURBIDITY, s)));
    all.step_by(if quick { 5 } else { 1 }).collect()
}

/// Solves an atmosphere and computes maps; the seconds that both took, of the shortest of several runs
/// and of the longest.
fn solved(
    step_nm: u16,
    settings: &TransportSettings,
    cases: &[Conditions],
) -> Result<([f64; 2], usize, Maps)> {
    let sky = || -> Result<TransportSky> {
        let sky = TransportSky::new(
            AtmosphereProfile::general(),
            OpticsSettings::with_step_nm(step_nm)?,
            DEFAULT_GROUND_ALBEDO,
        )?;
        Ok(sky.with_transport_settings(settings.clone()))
    };
    let (mut seconds, mut together) = ([f64::INFINITY, 0.0], 0.0);
    let (mut orders, mut maps) = (0, Maps::new());
    for _ in 0..RUNS {
        let sky = sky()?;
        let start = Stopwatch::start();
        orders = sky.solved(TURBIDITY)?.orders();
        maps = cases
            .par_iter()
            .map(|c| sky.yxy_map(c, &evaluation_directions(c.observer_altitude)))
            .collect::<Result<_, _>>()?;
        let run = start.seconds();
        seconds = [run.min(seconds[0]), run.max(seconds[1])];
        together += run;
        if together > REPEATED_S {
            break;
        }
    }
    Ok((seconds, orders, maps))
}

/// ΔE and relative luminance, 95th percentiles over all maps.
fn errors(cases: &[Conditions], truth: &Maps, found: &Maps) -> [f64; 2] {
    let maps: Vec<_> = cases
        .iter()
        .zip(truth.iter().zip(found))
        .map(|(c, (truth, found))| {
            compare_maps(c, &evaluation_directions(c.observer_altitude), truth, found)
        })
        .collect();
    percentiles(&pool(&maps, |_, _| true))
}

/// ΔE and relative luminance, 95th percentiles.
fn percentiles(pooled: &Pooled) -> [f64; 2] {
    [pooled.delta_e, pooled.luminance].map(|s| s.map_or(f64::NAN, |s| s.p95))
}

fn wavelengths(
    steps: &[u16],
    quick: bool,
    progress: &dyn Progress,
    points: &mut Vec<Point>,
) -> Result<()> {
    let cases = engine_conditions(quick);
    let default = TransportSettings::default();
    let (_, _, truth) = solved(if quick { 5 } else { 1 }, &default, &cases)?;
    progress.step();
    for step_nm in steps {
        let (seconds, _, maps) = solved(*step_nm, &default, &cases)?;
        let [delta_e_p95, luminance_p95] = errors(&cases, &truth, &maps);
        points.push(Point {
            setting: "wavelength step",
            value: format!("{step_nm} nm"),
            is_default: *step_nm == MAP_STEP_NM,
            seconds,
            delta_e_p95,
            luminance_p95,
        });
        progress.step();
    }
    Ok(())
}

/// Every so many of a list, both ends among them.
fn thinned(all: &[f64], stride: usize) -> Vec<f64> {
    let mut out: Vec<f64> = all.iter().step_by(stride).copied().collect();
    if !(all.len() - 1).is_multiple_of(stride) {
        out.extend(all.last());
    }
    out
}

/// Gauss points in zenith that are more than the default's in every part of the sky.
const FINE_ZENITH_POINTS: [usize; 3] = [9, 12, 6];

/// The engine's settings, one changed at a time; each series holds the default.
fn engine_settings() -> Vec<(&'static str, String, TransportSettings)> {
    let base = TransportSettings::default;
    let mut all = Vec::new();
    for tolerance in [0.3, 0.05, 1e-2, 2e-3, 2e-4] {
        let settings = TransportSettings {
            tolerance,
            ..base()
        };
        all.push(("orders of scattering", String::new(), settings));
    }
    for degree in [Some(1), Some(2), Some(3), None, Some(8)] {
        let value = degree.map_or_else(|| "by haze".to_owned(), |d| d.to_string());
        all.push(("degree", value, TransportSettings { degree, ..base() }));
    }
    let zenith_points = base().zenith_points;
    for zenith_points in [[3, 3, 2], [4, 4, 3], zenith_points, FINE_ZENITH_POINTS] {
        let value = zenith_points.iter().sum::<usize>().to_string();
        let settings = TransportSettings {
            zenith_points,
            ..base()
        };
        all.push(("zenith points", value, settings));
    }
    for azimuth_points in [4, 6, 8, 12] {
        let settings = TransportSettings {
            azimuth_points,
            ..base()
        };
        all.push(("azimuth points", azimuth_points.to_string(), settings));
    }
    let (shells, columns) = (base().shells_km, base().columns_deg);
    for shells_km in [
        thinned(&shells, 3),
        thinned(&shells, 2),
        shells.clone(),
        between(&shells),
    ] {
        let value = shells_km.len().to_string();
        all.push((
            "shells",
            value,
            TransportSettings {
                shells_km,
                ..base()
            },
        ));
    }
    for columns_deg in [
        thinned(&columns, 3),
        thinned(&columns, 2),
        columns.clone(),
        between(&columns),
    ] {
        let value = columns_deg.len().to_string();
        let settings = TransportSettings {
            columns_deg,
            ..base()
        };
        all.push(("sun columns", value, settings));
    }
    all
}

fn engine(
    settings: &[(&'static str, String, TransportSettings)],
    progress: &dyn Progress,
    points: &mut Vec<Point>,
) -> Result<()> {
    let cases = engine_conditions(false);
    let default = TransportSettings::default();
    let fine = TransportSettings {
        degree: Some(8),
        zenith_points: FINE_ZENITH_POINTS,
        azimuth_points: 12,
        tolerance: 2e-4,
        shells_km: between(&default.shells_km),
        columns_deg: between(&default.columns_deg),
        ..default.clone()
    };
    let (_, _, truth) = solved(MAP_STEP_NM, &fine, &cases)?;
    progress.step();
    for (setting, value, settings) in settings {
        let (seconds, orders, maps) = solved(MAP_STEP_NM, settings, &cases)?;
        let [delta_e_p95, luminance_p95] = errors(&cases, &truth, &maps);
        points.push(Point {
            setting,
            value: if value.is_empty() {
                orders.to_string()
            } else {
                value.clone()
            },
            is_default: *settings == default,
            seconds,
            delta_e_p95,
            luminance_p95,
        });
        progress.step();
    }
    Ok(())
}

/// Directions that a map is fitted in: a stride over the default ones; 0 for twice as many.
const DIRECTIONS: [usize; 4] = [8, 3, 1, 0];

fn directions(stride: usize, altitude: Length) -> Vec<SkyDirection> {
    let mut all = fit_directions(altitude);
    if stride == 0 {
        let lowest = horizon_zenith(altitude).degrees() - LOWEST_RING_ABOVE_HORIZON_DEG;
        let others: Vec<SkyDirection> = all
            .iter()
            .map(|d| {
                let [zenith, azimuth] = [d.view_zenith, d.relative_azimuth].map(Angle::degrees);
                SkyDirection::from_degrees((zenith + 0.7).min(lowest), (azimuth + 5.0).min(180.0))
            })
            .collect();
        all.extend(others);
    }
    all.into_iter().step_by(stride.max(1)).collect()
}

/// Axes of altitude and sun, by the setting that they belong to.
type AxesOf = (&'static str, [Vec<f64>; 2], bool);

fn table_grids() -> Result<Vec<AxesOf>> {
    let grid = Grid::extended()?;
    let [altitudes, suns] = [&grid.altitude_km, &grid.sun_zenith_deg].map(|a| a.nodes().to_vec());
    let mut all = Vec::new();
    for nodes in [thinned(&altitudes, 4), thinned(&altitudes, 2)] {
        all.push(("altitude nodes", [nodes, suns.clone()], false));
    }
    all.push(("altitude nodes", [altitudes.clone(), suns.clone()], true));
    all.push(("altitude nodes", [between(&altitudes), suns.clone()], false));
    for nodes in [thinned(&suns, 4), thinned(&suns, 2)] {
        all.push(("sun nodes", [altitudes.clone(), nodes], false));
    }
    all.push(("sun nodes", [altitudes.clone(), suns.clone()], true));
    all.push(("sun nodes", [altitudes, between(&suns)], false));
    Ok(all)
}

/// A table of one turbidity, and the seconds that its maps and their fit took.
fn one_turbidity(
    truth: &TransportSky,
    nodes: &[Vec<f64>; 2],
    stride: usize,
) -> Result<(f64, UtmSky)> {
    let [altitudes, suns] = nodes;
    let start = Stopwatch::start();
    let places: Vec<Conditions> = between(altitudes)
        .into_iter()
        .flat_map(|h| {
            between(suns)
                .into_iter()
                .map(move |s| conditions(h, TURBIDITY, s))
        })
        .collect();
    let equations: Vec<MapEquations> = places
        .par_iter()
        .map(|conditions| {
            let directions = directions(stride, conditions.observer_altitude);
            let sky = truth.yxy_map(conditions, &directions)?;
            let map = SkyMap {
                conditions: *conditions,
                directions,
                sky,
            };
            Ok(MapEquations::of(&map, 1.0))
        })
        .collect::<Result<_>>()?;
    let altitude_km = Axis::new("km", altitudes.clone())?;
    let sun_zenith_deg = Axis::new("deg", suns.clone())?;
    let terms: Vec<usize> = (0..TERMS).collect();
    let values = fit_turbidity(&equations, &altitude_km, &sun_zenith_deg, &terms)?;
    let embedded = UtmSky::embedded()?;
    let header = LutHeader {
        altitude_km,
        turbidity: Axis::new("1", vec![TURBIDITY])?,
        sun_zenith_deg,
        domain: Domain {
            turbidity: [TURBIDITY; 2],
            ..*embedded.domain()
        },
        ..embedded.lut().header().clone()
    };
    let sky = UtmSky::new(Lut::from_f64(header, &values)?)?;
    Ok((start.seconds(), sky))
}

fn grid(grids: &[AxesOf], progress: &dyn Progress, points: &mut Vec<Point>) -> Result<()> {
    let truth = general_truth()?;
    let [altitudes, suns] = TABLE_PLACES;
    let cases: Vec<Conditions> = altitudes
        .into_iter()
        .flat_map(|h| suns.map(|s| conditions(h, TURBIDITY, s)))
        .collect();
    let mut add = |setting, value: String, is_default, nodes: &_, stride| -> Result<()> {
        let (seconds, sky) = one_turbidity(&truth, nodes, stride)?;
        points.push(judged(
            &truth,
            &sky,
            &cases,
            (setting, value, is_default),
            seconds,
        )?);
        progress.step();
        Ok(())
    };
    truth.solved(TURBIDITY)?; // the solution is the engine's, not the table's
    for (setting, nodes, is_default) in grids {
        let count = if *setting == "altitude nodes" {
            nodes[0].len()
        } else {
            nodes[1].len()
        };
        add(*setting, count.to_string(), *is_default, nodes, 1)?;
    }
    let default = grids.iter().find(|(_, _, is_default)| *is_default);
    for stride in DIRECTIONS {
        let Some((_, nodes, _)) = default else { break };
        let count = directions(stride, Length::ZERO).len();
        add("directions", count.to_string(), stride == 1, nodes, stride)?;
    }
    Ok(())
}

/// A point from a table and what it is compared with.
fn judged(
    truth: &dyn SkyModel,
    sky: &UtmSky,
    cases: &[Conditions],
    (setting, value, is_default): (&'static str, String, bool),
    seconds: f64,
) -> Result<Point> {
    let pooled = evaluate(truth, &[sky], cases)?[0].pooled();
    let [delta_e_p95, luminance_p95] = percentiles(&pooled);
    Ok(Point {
        setting,
        value,
        is_default,
        seconds: [seconds; 2],
        delta_e_p95,
        luminance_p95,
    })
}

/// Turbidity's nodes, on the part of the grid where haze counts most.
fn haze(progress: &dyn Progress, points: &mut Vec<Point>) -> Result<()> {
    let grid = Grid::extended()?;
    let within = |axis: &Axis, [low, high]: [f64; 2]| {
        let nodes = axis.nodes().iter().copied();
        nodes.filter(|n| (low..=high).contains(n)).collect()
    };
    let turbidities = grid.turbidity.nodes().to_vec();
    let [altitudes, hazes, suns] = HAZE_PLACES;
    // altitudes and suns in turn: a square of them for each turbidity is more than it takes
    let cases: Vec<Conditions> = hazes
        .into_iter()
        .flat_map(|t| (0..altitudes.len()).map(move |i| (t, i)))
        .map(|(t, i)| conditions(altitudes[i], t, suns[(2 * i + 1) % suns.len()]))
        .collect();
    let judge = general_truth()?;
    for nodes in [
        thinned(&turbidities, 2),
        turbidities.clone(),
        between(&turbidities),
    ] {
        let start = Stopwatch::start();
        let truth = general_truth()?;
        let part = Grid {
            altitude_km: Axis::new("km", within(&grid.altitude_km, HAZE_ALTITUDES_KM))?,
            turbidity: Axis::new("1", nodes.clone())?,
            sun_zenith_deg: Axis::new("deg", within(&grid.sun_zenith_deg, HAZE_SUNS_DEG))?,
            form: Form::Extended,
        };
        let (air, profile) = (truth.extinction()?, NamedProfile::general()?);
        let (lut, _) = bake(&truth, &part, &profile, air, progress)?;
        let seconds = start.seconds();
        let label = (
            "turbidity nodes",
            nodes.len().to_string(),
            nodes == turbidities,
        );
        points.push(judged(&judge, &UtmSky::new(lut)?, &cases, label, seconds)?);
        progress.step();
    }
    Ok(())
}

/// The points as CSV.
///
/// # Errors
/// Never: a text takes everything.
pub fn csv(points: &[Point]) -> Result<String> {
    let mut out =
        String::from("setting,value,default,seconds,seconds_longest,delta_e_p95,luminance_p95\n");
    for p in points {
        writeln!(
            out,
            "{},{},{},{:.3},{:.3},{:.4},{:.5}",
            p.setting,
            p.value,
            p.is_default,
            p.seconds[0],
            p.seconds[1],
            p.delta_e_p95,
            p.luminance_p95
        )?;
    }
    Ok(out)
}

/// A chart for each setting, and the figures.
///
/// # Errors
/// When a chart cannot be drawn.
pub fn html(points: &[Point]) -> Result<String> {
    let mut charts = String::new();
    for group in points.chunk_by(|a, b| a.setting == b.setting) {
        let at = |p: &Point| [p.seconds[0], p.delta_e_p95.max(1e-4)];
        let of = |is_default: bool| -> Vec<[f64; 2]> {
            let all = group.iter().filter(|p| p.is_default == is_default);
            all.map(at).collect()
        };
        let chart = Chart {
            title: group[0].setting.to_owned(),
            x: Scale::logarithmic("seconds", group.iter().map(|p| p.seconds[0]), 4.0),
            y: Scale::logarithmic("ΔE2000 p95", group.iter().map(|p| at(p)[1]), 4.0),
            series: vec![
                Series::new("", 1, group.iter().map(at).collect()).stroked(Stroke::Dashed),
                Series::new("other values", 1, of(false)).stroked(Stroke::Dots),
                Series::new("default", 0, of(true)).stroked(Stroke::Dots),
            ],
            notes: group
                .iter()
                .map(|p| Note {
                    text: format!(
                        "  {}{}",
                        p.value,
                        if p.is_default { ", default" } else { "" }
                    ),
                    at: at(p),
                })
                .collect(),
            size: [360, 260],
        };
        charts.push_str(&chart.html()?);
    }
    let head = [
        "setting",
        "value",
        "seconds",
        "longest run",
        "ΔE p95",
        "luminance p95",
        "default",
    ];
    let cells: Vec<Vec<String>> = points
        .iter()
        .map(|p| {
            vec![
                p.setting.to_owned(),
                p.value.clone(),
                format!("{:.2}", p.seconds[0]),
                format!("{:.2}", p.seconds[1]),
                short(p.delta_e_p95),
                format!("{:.2} %", 100.0 * p.luminance_p95),
                if p.is_default { "yes" } else { "" }.to_owned(),
            ]
        })
        .collect();
    Ok(format!(
        "<p>One setting at a time is changed, at turbidity {TURBIDITY} but for its own nodes. Of the engine: \
         seconds to solve the atmosphere and compute {} maps, error against a finer engine. Of the table: \
         seconds to compute and fit the maps (of one turbidity, the solution left out; of turbidity's nodes, \
         all of {}–{} km and sun {}–{}°), error against the engine between the nodes, which the \
         formula's own bounds from below. Seconds are those of the shortest of up to {RUNS} runs; how \
         far the longest is from it is the noise of the machine, and settings that differ by less are \
         alike. 20 nm is no faster than 10 nm: of 41 wavelengths the engine solves 16 and interpolates the \
         others, of 21 it solves each.</p>\n<div class=\"grid\">{charts}</div>\n{}",
        ENGINE_PLACES[0].len() * ENGINE_PLACES[1].len(),
        HAZE_ALTITUDES_KM[0],
        HAZE_ALTITUDES_KM[1],
        HAZE_SUNS_DEG[0],
        HAZE_SUNS_DEG[1],
        table(&head, &cells, 2)
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn b6_every_series_marks_one_default_and_it_is_the_engine_s() {
        let default = TransportSettings::default();
        let all = engine_settings();
        let mut names: Vec<&str> = all.iter().map(|(name, ..)| *name).collect();
        names.dedup();
        assert_eq!(names.len(), 6, "{names:?}");
        for name in names {
            let series = all.iter().filter(|(of, ..)| *of == name);
            let marked = series.filter(|(_, _, settings)| *settings == default);
            assert_eq!(marked.count(), 1, "{name}");
        }
        let finer = FINE_ZENITH_POINTS.iter().zip(default.zenith_points);
        assert!(finer.into_iter().all(|(fine, own)| *fine > own));
    }
}
