//! The chart's files: CSV, drawing, page.

use std::fmt::Write as _;

use anyhow::Result;
use sky_plot::Scale;
use sky_plot::chart::{Chart, Note, Series, Stroke};
use sky_plot::page::{Section, page, table};
use sky_plot::sheet::{LEGEND_PX, TITLE_PX};

use super::rows::{DEFAULT_TIER, REGIMES, Row, place};

/// `chart.csv`.
///
/// # Errors
/// Never: a text takes everything.
pub fn csv(rows: &[Row], adapter: &str) -> Result<String> {
    let mut out = String::from(
        "model,tier,regime,valid_share,delta_e_p50,delta_e_p95,luminance_p95,\
         radiance_rmse_mw_m2_sr_nm,cpu_ns_per_direction,gpu_ns_per_pixel_1080p,\
         gpu_ns_per_pixel_2160p,ratio_to_floor,update_us,rebuild_ms,table_bytes,on_front,adapter\n",
    );
    let number = |v: Option<f64>| {
        v.filter(|v| v.is_finite())
            .map_or_else(String::new, |v| format!("{v:.4}"))
    };
    for row in rows {
        for (r, (regime, _)) in REGIMES.iter().enumerate() {
            let e = row.errors[r];
            let c = &row.costs;
            writeln!(
                out,
                "{},{},{regime},{:.4},{},{},{},{},{:.1},{},{},{},{:.2},{:.3},{},{},\"{adapter}\"",
                row.model.name,
                row.model.tier,
                e.map_or(0.0, |e| e.valid_share),
                number(e.map(|e| e.delta_e[0])),
                number(e.map(|e| e.delta_e[1])),
                number(e.map(|e| e.luminance_p95)),
                number(e.map(|e| e.rmse)),
                c.cpu_ns,
                number(c.gpu.ns[0]),
                number(c.gpu.ns[1]),
                number(c.gpu.ratio),
                c.update_us,
                c.rebuild_ms,
                c.bytes,
                row.on_front[r],
            )?;
        }
    }
    Ok(out)
}

/// Regimes on the sheet, each with its title, size and place \[px\]; all of them are on the page.
const SHEET: [(&str, &str, [u32; 2], [u32; 2]); 3] = [
    (
        "all",
        "All cases: error over cost; lower left is better",
        [900, 440],
        [0, LEGEND_PX],
    ),
    (
        "low-sun",
        "Sun 70–90° from the zenith",
        [448, 340],
        [0, LEGEND_PX + TITLE_PX + 450],
    ),
    (
        "aloft",
        "From 9 km and above",
        [448, 340],
        [452, LEGEND_PX + TITLE_PX + 450],
    ),
];

/// Error over GPU cost in a regime, both logarithmic, with the front as a line.
fn chart(rows: &[Row], regime: usize, title: &str, size: [u32; 2]) -> Chart {
    let all: Vec<(&Row, [f64; 2])> = rows
        .iter()
        .filter_map(|row| Some((row, place(row, regime)?)))
        .collect();
    let mut front: Vec<[f64; 2]> = all
        .iter()
        .filter(|(row, _)| row.on_front[regime])
        .map(|(_, p)| *p)
        .collect();
    front.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let dots = |ours: bool| -> Vec<[f64; 2]> {
        all.iter()
            .filter(|(row, _)| row.model.name.starts_with("utm-sky") == ours)
            .map(|(_, p)| *p)
            .collect()
    };
    // the words of ours choose their places first
    let (ours, others): (Vec<_>, Vec<_>) = all
        .iter()
        .partition(|(row, _)| row.model.name.starts_with("utm-sky"));
    let notes = ours
        .iter()
        .chain(&others)
        .map(|(row, at)| Note {
            text: word(row, regime),
            at: *at,
        })
        .collect();
    let wider = |axis: usize, factor: f64| {
        let values: Vec<f64> = all.iter().map(|(_, p)| p[axis]).collect();
        let least = values.iter().copied().fold(f64::INFINITY, f64::min);
        let most = values.iter().copied().fold(0.0, f64::max);
        [least / factor, most * factor]
    };
    Chart {
        title: title.to_owned(),
        x: Scale::logarithmic("GPU [ns a pixel, 1920 x 1080]", wider(0, 1.3), 6.0),
        y: Scale::logarithmic("ΔE2000, 95th percentile", wider(1, 1.1), 4.0),
        series: vec![
            Series::new("front: nothing is both cheaper and closer", 2, front)
                .stroked(Stroke::Dashed),
            Series::new("published", 1, dots(false)).stroked(Stroke::Dots),
            Series::new("ours", 0, dots(true)).stroked(Stroke::Dots),
        ],
        notes,
        size,
    }
}

/// A model on the chart: its name, what is told of it by a sign, and the share that it covers.
fn word(row: &Row, regime: usize) -> String {
    let errors = row.errors[regime].unwrap_or_default();
    let mut text = row.model.name.to_owned();
    if row.model.own_atmosphere() {
        text.push('*');
    }
    if row.model.luminance_only() {
        text.push('°');
    }
    if errors.valid_share < 0.995 {
        text.push_str(&format!(" {:.0} %", 100.0 * errors.valid_share));
    }
    if errors.failures > 0.0 {
        text.push_str(&format!(", fails {:.1} %", 100.0 * errors.failures));
    }
    text
}

/// What the signs on the charts mean.
const FOOTNOTES: [&str; 2] = [
    "* air of its own, matched at equal aerosol optical depth   ° luminance alone, scored with the truth's \
     chromaticity",
    "8 %: share of the cases that it answers for, where that is not all; its error is taken over those \
     alone",
];

/// One chart a regime, as HTML.
///
/// # Errors
/// When a chart cannot be drawn.
pub fn panels(rows: &[Row]) -> Result<Vec<String>> {
    REGIMES
        .iter()
        .enumerate()
        .map(|(r, (regime, _))| {
            let title = format!("{regime}: error over cost");
            Ok(chart(rows, r, &title, [720, 400]).html()?)
        })
        .collect()
}

/// The most telling regimes as one SVG file.
///
/// # Errors
/// When a chart cannot be drawn.
pub fn sheet(rows: &[Row]) -> Result<String> {
    let charts: Vec<(Chart, [u32; 2])> = SHEET
        .iter()
        .filter_map(|(name, title, size, place)| {
            let regime = REGIMES.iter().position(|(known, _)| known == name)?;
            Some((chart(rows, regime, title, *size), *place))
        })
        .collect();
    let panels: Vec<_> = charts
        .iter()
        .map(|(chart, place)| (chart, *place))
        .collect();
    Ok(sky_plot::sheet::sheet(&panels, &FOOTNOTES)?)
}

/// A model beside the default tier, over all cases that it answers for.
#[derive(Clone, Copy, Debug)]
pub struct Beside {
    model: &'static str,
    covers: f64,
    delta_e_p95: f64,
    gpu_ns: Option<f64>,
    /// Its error over the default tier's.
    times_error: f64,
    /// Its cost over the default tier's.
    times_cost: Option<f64>,
}

/// Every other model beside the default tier; none where that was not measured.
pub fn beside(rows: &[Row]) -> Vec<Beside> {
    let of = |row: &Row| Some((row.errors[0]?, row.costs.gpu.ns[0]));
    let Some((ours, our_cost)) = rows
        .iter()
        .find(|row| row.model.name == DEFAULT_TIER)
        .and_then(of)
    else {
        return Vec::new();
    };
    rows.iter()
        .filter(|row| row.model.name != DEFAULT_TIER)
        .filter_map(|row| {
            let (errors, cost) = of(row)?;
            Some(Beside {
                model: row.model.name,
                covers: errors.valid_share,
                delta_e_p95: errors.delta_e[1],
                gpu_ns: cost,
                times_error: errors.delta_e[1] / ours.delta_e[1],
                times_cost: cost.zip(our_cost).map(|(theirs, ours)| theirs / ours),
            })
        })
        .collect()
}

/// The same for the terminal, and where the default tier is beaten.
///
/// # Errors
/// Never: a text takes everything.
pub fn beside_text(rows: &[Row], beside: &[Beside]) -> Result<String> {
    let Some(ours) = rows.iter().find(|row| row.model.name == DEFAULT_TIER) else {
        return Ok(String::new());
    };
    let number = |v: Option<f64>, digits: usize| {
        v.map_or_else(|| "-".to_owned(), |v| format!("{v:.digits$}"))
    };
    let mut out = format!(
        "{:<16} {:>7} {:>8} {:>7} {:>8} {:>7}\n",
        "model", "covers", "dE p95", "x ours", "ns/px", "x ours"
    );
    for b in beside {
        writeln!(
            out,
            "{:<16} {:>6.0}% {:>8.2} {:>7.2} {:>8} {:>7}",
            b.model,
            100.0 * b.covers,
            b.delta_e_p95,
            b.times_error,
            number(b.gpu_ns, 2),
            number(b.times_cost, 2)
        )?;
    }
    let off: Vec<&str> = REGIMES
        .iter()
        .zip(&ours.on_front)
        .filter(|(_, on)| !**on)
        .map(|((regime, _), _)| *regime)
        .collect();
    writeln!(
        out,
        "{DEFAULT_TIER}: {:.2} dE p95, {} ns/px; {}",
        ours.errors[0].map_or(f64::NAN, |e| e.delta_e[1]),
        number(ours.costs.gpu.ns[0], 2),
        if off.is_empty() {
            "on the front in every regime".to_owned()
        } else {
            format!("not on the front in {}", off.join(", "))
        }
    )?;
    Ok(out)
}

fn beside_table(beside: &[Beside]) -> String {
    let number = |v: Option<f64>| v.map_or_else(|| "–".to_owned(), |v| format!("{v:.2}"));
    let cells: Vec<Vec<String>> = beside
        .iter()
        .map(|b| {
            vec![
                b.model.to_owned(),
                format!("{:.0} %", 100.0 * b.covers),
                number(Some(b.delta_e_p95)),
                number(Some(b.times_error)),
                number(b.gpu_ns),
                number(b.times_cost),
            ]
        })
        .collect();
    let head = [
        "model",
        "covers",
        "ΔE p95",
        "times ours",
        "GPU 1080p [ns/px]",
        "times ours",
    ];
    format!(
        "<p>Ours is {DEFAULT_TIER}, the renderer's default tier. Each model is taken over all cases that \
         it answers for; ours over all cases.</p>{}",
        table(&head, &cells, 1)
    )
}

/// The page.
pub fn html(rows: &[Row], panels: &[String], offline: &str, adapter: &str) -> String {
    let head = [
        "model",
        "covers",
        "ΔE p50",
        "ΔE p95",
        "luminance p95",
        "after one factor",
        "RMSE [mW m⁻² sr⁻¹ nm⁻¹]",
        "CPU [ns]",
        "GPU 1080p [ns/px]",
        "GPU 2160p",
        "x floor",
        "update [µs]",
        "rebuild [ms]",
        "tables [B]",
        "fails",
        "front",
    ];
    let number = |v: Option<f64>, digits: usize| {
        v.map_or_else(|| "–".to_owned(), |v| format!("{v:.digits$}"))
    };
    let mut body = format!("<p class=\"soft\">{}</p>\n", FOOTNOTES.join("<br>"));
    for (r, (regime, _)) in REGIMES.iter().enumerate() {
        let cells: Vec<Vec<String>> = rows
            .iter()
            .map(|row| {
                let e = row.errors[r];
                let c = &row.costs;
                vec![
                    row.model.name.to_owned(),
                    format!("{:.0} %", 100.0 * e.map_or(0.0, |e| e.valid_share)),
                    number(e.map(|e| e.delta_e[0]), 2),
                    number(e.map(|e| e.delta_e[1]), 2),
                    number(e.map(|e| 100.0 * e.luminance_p95), 1) + " %",
                    number(e.map(|e| 100.0 * e.scaled_p95), 1) + " %",
                    number(e.map(|e| e.rmse), 1),
                    number(Some(c.cpu_ns), 0),
                    number(c.gpu.ns[0], 2),
                    number(c.gpu.ns[1], 2),
                    number(c.gpu.ratio, 2),
                    number(Some(c.update_us), 1),
                    number(Some(c.rebuild_ms), 1),
                    c.bytes.to_string(),
                    format!("{:.2} %", 100.0 * e.map_or(0.0, |e| e.failures)),
                    if row.on_front[r] { "yes" } else { "" }.to_owned(),
                ]
            })
            .collect();
        body.push_str(&format!(
            "<h3>{regime}</h3>{}{}",
            panels[r],
            table(&head, &cells, 1)
        ));
    }
    let notes: String = rows
        .iter()
        .map(|row| {
            let own = if row.model.own_atmosphere() {
                " Own atmosphere, matched at equal aerosol optical depth."
            } else {
                ""
            };
            let luminance = if row.model.luminance_only() {
                " Luminance alone: scored with the truth's chromaticity."
            } else {
                ""
            };
            format!(
                "<p><b>{}</b>: {}.{own}{luminance}</p>",
                row.model.name, row.model.citation
            )
        })
        .collect();
    page(
        "Speed against accuracy",
        &format!(
            "Error against the transport engine at 0–30 km, T 1.5–6, sun 0–92°, all directions above the \
             geometric horizon but the sun's 5°; cost of a full picture on {adapter}. A model is scored where \
             it claims to be valid."
        ),
        &[
            Section {
                id: "regimes",
                title: "Regimes",
                body,
            },
            Section {
                id: "factors",
                title: "Beside the default tier",
                body: beside_table(&beside(rows)),
            },
            Section {
                id: "offline",
                title: "Where our own time goes",
                body: offline.to_owned(),
            },
            Section {
                id: "models",
                title: "Models",
                body: notes,
            },
        ],
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chart::rows::{Costs, Errors, GpuCosts, mark_front};
    use crate::models::all;

    /// Rows of every model with costs and errors as they are measured, within a factor.
    fn rows() -> Vec<Row> {
        let figures = [
            (30.9, 2.62, 1.0),
            (14.3, 2.63, 1.0),
            (13.2, 26.5, 1.0),
            (104.0, 12.9, 1.0),
            (190.0, 21.0, 0.67),
            (6.78, 56.8, 0.11),
            (10.7, 62.6, 0.08),
            (19.3, 46.7, 0.08),
            (24.2, 40.0, 0.11),
            (15.9, 64.9, 0.11),
            (20.2, 94.5, 0.8),
            (2469.0, 41.4, 1.0),
            (1131.0, 41.4, 1.0),
            (558.0, 42.2, 1.0),
            (16.3, 8.81, 1.0),
        ];
        let mut rows: Vec<Row> = all()
            .into_iter()
            .zip(figures)
            .map(|(model, (ns, error, share))| Row {
                model,
                errors: vec![
                    Some(Errors {
                        valid_share: share,
                        delta_e: [0.3 * error, error],
                        ..Errors::default()
                    });
                    REGIMES.len()
                ],
                costs: Costs {
                    gpu: GpuCosts {
                        ns: [Some(ns), None],
                        ratio: None,
                    },
                    ..Costs::default()
                },
                on_front: vec![false; REGIMES.len()],
            })
            .collect();
        mark_front(&mut rows);
        rows
    }

    #[test]
    fn d_the_sheet_has_few_panels_and_one_legend() {
        let rows = rows();
        let svg = sheet(&rows).unwrap();
        // as wide as a page shows it, so that its words are as large as they are drawn
        assert!(svg.starts_with("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"900\""));
        for (_, title, ..) in SHEET {
            assert_eq!(
                svg.matches(title).count(),
                2,
                "{title}: as title and as label"
            );
        }
        assert_eq!(svg.matches(">published</text>").count(), 1);
        for row in &rows {
            assert!(
                svg.matches(&word(row, 0)).count() >= SHEET.len(),
                "{}",
                row.model.name
            );
        }
    }
}
