//! The chart's files: CSV, drawing, page.

use std::fmt::Write as _;

use anyhow::Result;
use sky_plot::Scale;
use sky_plot::chart::{Chart, Note, Series, Stroke};
use sky_plot::page::{Section, page, table};

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

/// One chart a regime: error over GPU cost, both logarithmic, with the front as a line.
///
/// # Errors
/// When a chart cannot be drawn.
pub fn panels(rows: &[Row]) -> Result<Vec<String>> {
    REGIMES
        .iter()
        .enumerate()
        .map(|(r, (regime, _))| {
            let all: Vec<(&Row, [f64; 2])> = rows
                .iter()
                .filter_map(|row| Some((row, place(row, r)?)))
                .collect();
            let mut front: Vec<[f64; 2]> = all
                .iter()
                .filter(|(row, _)| row.on_front[r])
                .map(|(_, p)| *p)
                .collect();
            front.sort_by(|a, b| a[0].total_cmp(&b[0]));
            let dots = |ours: bool| -> Vec<[f64; 2]> {
                all.iter()
                    .filter(|(row, _)| row.model.name.starts_with("utm-sky") == ours)
                    .map(|(_, p)| *p)
                    .collect()
            };
            let notes = all
                .iter()
                .map(|(row, at)| {
                    let e = row.errors[r].unwrap_or_default();
                    let mut text = format!(" {}", row.model.name);
                    if row.model.own_atmosphere() {
                        text.push('*');
                    }
                    if row.model.luminance_only() {
                        text.push('°');
                    }
                    if e.valid_share < 0.995 {
                        write!(text, " ({:.0} % covered)", 100.0 * e.valid_share).ok();
                    }
                    if e.failures > 0.0 {
                        write!(text, " fails {:.1} %", 100.0 * e.failures).ok();
                    }
                    Note { text, at: *at }
                })
                .collect();
            Chart {
                title: format!("{regime}: error over cost"),
                x: Scale::logarithmic(
                    "GPU [ns a pixel, 1920 x 1080]",
                    all.iter().map(|(_, p)| p[0]),
                    6.0,
                ),
                y: Scale::logarithmic(
                    "ΔE2000, 95th percentile",
                    all.iter().map(|(_, p)| p[1]),
                    4.0,
                ),
                series: vec![
                    Series::new("front", 2, front).stroked(Stroke::Dashed),
                    Series::new("published", 1, dots(false)).stroked(Stroke::Dots),
                    Series::new("ours", 0, dots(true)).stroked(Stroke::Dots),
                ],
                notes,
                size: [560, 360],
            }
            .html()
            .map_err(Into::into)
        })
        .collect()
}

/// The panels' drawings as one SVG file.
pub fn sheet(panels: &[String]) -> String {
    let mut out = String::new();
    let (mut column, mut row) = (0, 0);
    for (panel, (regime, _)) in panels.iter().zip(REGIMES) {
        let drawing = panel
            .find("<svg")
            .and_then(|start| Some(&panel[start..panel.find("</svg>")? + 6]))
            .unwrap_or_default();
        let placed = drawing.replacen(
            "<svg",
            &format!(
                "<svg x=\"{}\" y=\"{}\" width=\"560\" height=\"360\"",
                column * 570,
                row * 370
            ),
            1,
        );
        out.push_str(&placed);
        out.push_str(&format!(
            "<text x=\"{}\" y=\"{}\" font-family=\"sans-serif\" font-size=\"15\">{regime}</text>",
            column * 570 + 300,
            row * 370 + 18
        ));
        column += 1;
        if column == 2 {
            (column, row) = (0, row + 1);
        }
    }
    let height = (row + column) * 370 + 30;
    out.push_str(&format!(
        "<text x=\"20\" y=\"{}\" font-family=\"sans-serif\" font-size=\"13\">* air of its own, matched at \
         equal aerosol optical depth   ° luminance alone, scored with the truth's chromaticity</text>",
        height - 10
    ));
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"1140\" height=\"{height}\" \
         viewBox=\"0 0 1140 {height}\" color=\"#222\"><rect width=\"100%\" height=\"100%\" fill=\"white\"/>{out}</svg>\n"
    )
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
        "RMSE [mW/m²/sr/nm]",
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
    let mut body = String::new();
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
