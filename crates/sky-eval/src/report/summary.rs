//! How far the fits are from the truth: figures against targets, and error against altitude.

use anyhow::Result;
use sky_core::conditions::{Conditions, Domain};
use sky_core::direction::horizon_zenith;

use super::input::ReportInput;
use super::long_table::LongTable;
use super::text::{count_f64, percent};
use crate::cases::{conditions, held_out_cases};
use crate::score::{Evaluation, MapErrors, Pooled, evaluate, pool};
use sky_plot::Scale;
use sky_plot::chart::{Chart, Series, Stroke};
use sky_plot::number::short;
use sky_plot::page::{Section, escape, table};

/// Where the targets are asked.
const TARGET_DOMAIN: Domain = Domain {
    altitude_km: [0.0, 30.0],
    turbidity: [1.0, 8.0],
    sun_zenith_deg: [0.0, 92.0],
    below_horizontal: true,
};

/// Targets of the default table between its nodes.
const DELTA_E_MEDIAN: f64 = 0.5;
const DELTA_E_P95: f64 = 2.5;
const LUMINANCE_P95: f64 = 0.06;

fn marked(text: &str, met: Option<bool>) -> String {
    match met {
        Some(true) => format!("<span class=\"good\">{text}</span>"),
        Some(false) => format!("<span class=\"bad\">{text}</span>"),
        None => text.to_owned(),
    }
}

fn delta_e_text(value: f64) -> String {
    format!("{value:.2}")
}

fn row(name: &str, pooled: &Pooled, outside: usize, asked: bool) -> Vec<String> {
    let value = |of: fn(&Pooled) -> Option<f64>| of(pooled).unwrap_or(f64::NAN);
    let median = value(|p| p.delta_e.map(|s| s.median));
    let p95 = value(|p| p.delta_e.map(|s| s.p95));
    let luminance = value(|p| p.luminance.map(|s| s.p95));
    let met = |good: bool| asked.then_some(good);
    vec![
        escape(name),
        pooled.maps.to_string(),
        marked(&delta_e_text(median), met(median <= DELTA_E_MEDIAN)),
        marked(&delta_e_text(p95), met(p95 <= DELTA_E_P95)),
        delta_e_text(value(|p| p.delta_e.map(|s| s.max))),
        percent(value(|p| p.luminance.map(|s| s.median))),
        marked(&percent(luminance), met(luminance <= LUMINANCE_P95)),
        percent(value(|p| p.luminance.map(|s| s.max))),
        marked(&pooled.negatives.to_string(), met(pooled.negatives == 0)),
        marked(&pooled.not_finite.to_string(), met(pooled.not_finite == 0)),
        outside.to_string(),
    ]
}

const HEAD: [&str; 11] = [
    "sky",
    "maps",
    "ΔE median",
    "ΔE p95",
    "ΔE max",
    "luminance median",
    "luminance p95",
    "luminance max",
    "negative",
    "not finite",
    "outside",
];

fn log_pooled(csv: &mut LongTable, key: &str, channel: &str, pooled: &Pooled) {
    let mut add = |what: &str, value: f64| {
        csv.figure("summary", &format!("{key}: {what}"), None, channel, value);
    };
    add("maps", count_f64(pooled.maps));
    if let (Some(e), Some(l)) = (pooled.delta_e, pooled.luminance) {
        add("delta_e median", e.median);
        add("delta_e p95", e.p95);
        add("delta_e max", e.max);
        add("luminance error median", l.median);
        add("luminance error p95", l.p95);
        add("luminance error max", l.max);
    }
    add("negative", count_f64(pooled.negatives));
    add("not finite", count_f64(pooled.not_finite));
}

pub(super) fn summary(input: &ReportInput<'_>, csv: &mut LongTable) -> Result<Section> {
    let held_out = held_out_cases(&input.fits[0].nodes, &TARGET_DOMAIN, input.settings.cases);
    let models: Vec<_> = input.fits.iter().map(|fit| fit.model).collect();
    let midpoints = evaluate(input.truth, &models, &held_out.midpoints)?;
    let sequence = evaluate(input.truth, &models, &held_out.sequence)?;
    let together: Vec<Evaluation> = midpoints
        .iter()
        .zip(&sequence)
        .map(|(a, b)| Evaluation {
            maps: a.maps.iter().chain(&b.maps).cloned().collect(),
            outside_domain: a.outside_domain + b.outside_domain,
        })
        .collect();

    let mut rows = Vec::new();
    for (i, (fit, evaluation)) in input.fits.iter().zip(&together).enumerate() {
        let pooled = evaluation.pooled();
        log_pooled(csv, "all held-out cases", &fit.name, &pooled);
        rows.push(row(&fit.name, &pooled, evaluation.outside_domain, i == 0));
    }
    rows.push(
        [
            "<span class=\"soft\">target</span>",
            "",
            "≤ 0.5",
            "≤ 2.5",
            "",
            "",
            "≤ 6 %",
            "",
            "0",
            "0",
            "",
        ]
        .map(str::to_owned)
        .to_vec(),
    );
    let mut body = format!(
        "<p>Measured at altitudes, turbidities and suns <em>between</em> the nodes of the table: {} \
         cases in the middle of its intervals and {} spread evenly over 0–30 km, T 1–8 and sun zenith \
         angles 0–92°. Each map has {} directions down to 0.25° above the geometric horizon; the sun's \
         5° are left out, and every direction counts once. The targets are asked of the first row. ΔE is CIEDE2000 with white at 2.5 times the \
         median luminance of the true map.</p>\n",
        held_out.midpoints.len(),
        held_out.sequence.len(),
        crate::cases::evaluation_directions(sky_core::quantity::Length::ZERO).len(),
    );
    body.push_str(&table(&HEAD, &rows, 1));
    if !input.figures.is_empty() {
        let figures: Vec<Vec<String>> = input
            .figures
            .iter()
            .map(|figure| {
                csv.text("figures", &figure.what, None, "", &figure.value);
                vec![
                    escape(&figure.what),
                    marked(&escape(&figure.value), figure.met),
                    escape(&figure.target),
                ]
            })
            .collect();
        body.push_str(&table(&["figure", "value", "target"], &figures, 1));
    }
    body.push_str(&breakdown(
        input,
        csv,
        &together[0],
        [&midpoints[0], &sequence[0]],
    ));
    Ok(Section {
        id: "summary",
        title: "Figures against targets",
        body,
    })
}

/// The first fit's figures by altitude, turbidity, sun and view.
fn breakdown(
    input: &ReportInput<'_>,
    csv: &mut LongTable,
    all: &Evaluation,
    [midpoints, sequence]: [&Evaluation; 2],
) -> String {
    type Pick = Box<dyn Fn(&Conditions, f64) -> bool>;
    let mut groups: Vec<(String, &[MapErrors], Pick)> = vec![
        (
            "middle of the intervals".into(),
            &midpoints.maps,
            Box::new(|_, _| true),
        ),
        (
            "spread evenly".into(),
            &sequence.maps,
            Box::new(|_, _| true),
        ),
    ];
    for [low, high] in [[0.0, 1.0], [1.0, 3.0], [3.0, 10.0], [10.0, 30.0]] {
        groups.push((
            format!("altitude {low}–{high} km"),
            &all.maps,
            Box::new(move |c, _| (low..high).contains(&c.observer_altitude.km())),
        ));
    }
    for [low, high] in [[1.0, 2.0], [2.0, 4.0], [4.0, 8.0]] {
        groups.push((
            format!("turbidity {low}–{high}"),
            &all.maps,
            Box::new(move |c, _| (low..high).contains(&c.turbidity)),
        ));
    }
    for [low, high] in [[0.0, 60.0], [60.0, 80.0], [80.0, 88.0], [88.0, 92.1]] {
        groups.push((
            format!("sun zenith {low}–{}°", f64::floor(high)),
            &all.maps,
            Box::new(move |c, _| (low..high).contains(&c.sun_zenith.degrees())),
        ));
    }
    groups.push((
        "view zenith below 70°".into(),
        &all.maps,
        Box::new(|_, view| view < 70.0),
    ));
    groups.push((
        "within 10° of the geometric horizon".into(),
        &all.maps,
        Box::new(|c, view| view > horizon_zenith(c.observer_altitude).degrees() - 10.0),
    ));
    let rows: Vec<Vec<String>> = groups
        .iter()
        .filter_map(|(name, maps, pick)| {
            let pooled = pool(maps, pick);
            if pooled.maps == 0 {
                return None;
            }
            log_pooled(csv, name, &input.fits[0].name, &pooled);
            let mut cells = row(name, &pooled, 0, false);
            cells.truncate(8);
            Some(cells)
        })
        .collect();
    let mut head = HEAD;
    head[0] = "cases";
    format!(
        "<h3>{}, by case</h3>\n{}",
        escape(&input.fits[0].name),
        table(&head[..8], &rows, 1)
    )
}

/// Altitudes from 0 to 30 km, close together near the ground.
fn sweep_altitudes(count: u8) -> Vec<f64> {
    let last = f64::from(count.max(2) - 1);
    (0..count.max(2))
        .map(|i| {
            let s = f64::from(i) / last;
            30.0 * s * s
        })
        .collect()
}

pub(super) fn against_altitude(input: &ReportInput<'_>, csv: &mut LongTable) -> Result<Section> {
    let settings = input.settings;
    let altitudes = sweep_altitudes(settings.sweep_altitudes);
    let models: Vec<_> = input.fits.iter().map(|fit| fit.model).collect();
    let mut body = String::from(
        "<p>95th percentile over the directions of a map, at altitudes between and at the nodes, on \
         logarithmic scales. The altitude axis is stretched near the ground (square root); dots on \
         the lower edge are the altitude nodes of the first table. Gaps are conditions outside a \
         sky's domain.</p>\n",
    );
    for &turbidity in &settings.sweep_turbidities {
        let cases: Vec<Conditions> = settings
            .sweep_suns_deg
            .iter()
            .flat_map(|&sun| {
                altitudes
                    .iter()
                    .map(move |&km| conditions(km, turbidity, sun))
            })
            .collect();
        let evaluations = evaluate(input.truth, &models, &cases)?;
        body.push_str(&format!(
            "<h3>Turbidity {turbidity}</h3>\n<div class=\"grid\">"
        ));
        for &sun in &settings.sweep_suns_deg {
            for (title, key, factor, values) in [
                ("ΔE p95", "delta_e p95", 1.0, 0),
                ("luminance p95 [%]", "luminance error p95", 100.0, 1),
            ] {
                let mut series = Vec::new();
                for (i, (fit, evaluation)) in input.fits.iter().zip(&evaluations).enumerate() {
                    let mut points = Vec::new();
                    for &km in &altitudes {
                        let here = conditions(km, turbidity, sun);
                        let map = evaluation.maps.iter().find(|m| m.conditions == here);
                        let statistics = map.and_then(|m| {
                            if values == 0 {
                                m.delta_e_statistics()
                            } else {
                                m.luminance_statistics()
                            }
                        });
                        let value = statistics.map_or(f64::NAN, |s| s.p95);
                        if value.is_finite() {
                            csv.figure("altitude", key, Some(&here), &fit.name, value);
                        }
                        points.push([km.sqrt(), factor * value]);
                    }
                    series.push(Series::new(fit.name.clone(), i, points));
                }
                let all = series.iter().flat_map(|s| s.points.iter().map(|p| p[1]));
                let y = Scale::logarithmic(title, all, 3.5);
                let floor = y.low();
                let nodes = input.fits[0].nodes.altitude_km.iter();
                let marks = nodes.map(|km| [km.sqrt(), floor]).collect();
                series.push(Series::new("", 0, marks).in_ink().stroked(Stroke::Dots));
                body.push_str(
                    &Chart {
                        title: format!("{title}, sun zenith {}°", short(sun)),
                        x: Scale::labeled(
                            "altitude [km]",
                            &[0.0, 0.25, 1.0, 2.0, 4.0, 7.0, 12.0, 20.0, 30.0]
                                .map(|km: f64| (km.sqrt(), short(km))),
                        ),
                        y,
                        series,
                        notes: Vec::new(),
                        size: [500, 250],
                    }
                    .html()?,
                );
            }
        }
        body.push_str("</div>\n");
    }
    Ok(Section {
        id: "altitude",
        title: "Error against altitude, between the nodes",
        body,
    })
}
