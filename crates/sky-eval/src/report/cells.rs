//! How well each node could be fitted.

use anyhow::Result;
use sky_core::conditions::Conditions;
use sky_core::direction::horizon_zenith;

use super::input::{CellReport, ReportInput};
use super::long_table::LongTable;
use super::text::percent;
use sky_plot::heat_map::{HeatMap, color_bar};
use sky_plot::number::short;
use sky_plot::page::{Section, escape, table};

/// Ends of the color scales.
const DELTA_E_FULL_SCALE: f64 = 5.0;
const LUMINANCE_FULL_SCALE_PERCENT: f64 = 20.0;

/// A condition number that says that some parameter is not decided by the samples.
const NEARLY_SINGULAR: f64 = 1e6;

/// How many of the worst cells are told.
const WORST: usize = 10;

fn altitude_km(c: &Conditions) -> f64 {
    c.observer_altitude.km()
}

fn turbidity(c: &Conditions) -> f64 {
    c.turbidity
}

fn sun_deg(c: &Conditions) -> f64 {
    c.sun_zenith.degrees()
}

fn same(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-6
}

/// The different values of a quantity among cells, ascending.
fn values(cells: &[CellReport], of: fn(&Conditions) -> f64) -> Vec<f64> {
    let mut out: Vec<f64> = cells.iter().map(|cell| of(&cell.conditions)).collect();
    out.sort_by(f64::total_cmp);
    out.dedup_by(|b, a| same(*a, *b));
    out
}

pub(super) fn maps(input: &ReportInput<'_>, csv: &mut LongTable) -> Result<Section> {
    for cell in input.cells {
        let here = Some(&cell.conditions);
        csv.figure("cells", "delta_e p95", here, "", cell.delta_e_p95);
        csv.figure("cells", "luminance error p95", here, "", cell.luminance_p95);
        for channel in &cell.channels {
            csv.figure("cells", "residual rms", here, channel.channel, channel.rms);
            let condition = channel.condition_number;
            csv.figure(
                "cells",
                "condition number",
                here,
                channel.channel,
                condition,
            );
            csv.text(
                "cells",
                "why stopped",
                here,
                channel.channel,
                &channel.why_stopped,
            );
            if !channel.note.is_empty() {
                csv.text("cells", "note", here, channel.channel, &channel.note);
            }
        }
    }
    let body = if input.cells.is_empty() {
        "<p class=\"soft\">The table says nothing about the fits at its nodes.</p>\n".to_owned()
    } else {
        let mut body = format!(
            "<p>Errors of the fits <em>at</em> the nodes of {}: what the formula itself costs, without \
             interpolation. 95th percentile over a map.</p>\n",
            escape(&input.fits[0].name)
        );
        body.push_str("<h3>ΔE</h3>\n");
        body.push_str(&color_bar(DELTA_E_FULL_SCALE, "ΔE"));
        body.push_str(&heat_maps(input.cells, DELTA_E_FULL_SCALE, |c| {
            c.delta_e_p95
        })?);
        body.push_str("<h3>Luminance</h3>\n");
        body.push_str(&color_bar(LUMINANCE_FULL_SCALE_PERCENT, "%"));
        let luminance = |c: &CellReport| 100.0 * c.luminance_p95;
        body.push_str(&heat_maps(
            input.cells,
            LUMINANCE_FULL_SCALE_PERCENT,
            luminance,
        )?);
        body
    };
    Ok(Section {
        id: "cells",
        title: "Errors of the fits over the grid",
        body,
    })
}

/// A heat map, altitude against sun, for each turbidity.
fn heat_maps(
    cells: &[CellReport],
    full_scale: f64,
    value: impl Fn(&CellReport) -> f64,
) -> Result<String> {
    let (altitudes, suns) = (values(cells, altitude_km), values(cells, sun_deg));
    let label = |values: &[f64]| values.iter().map(|v| short(*v)).collect::<Vec<_>>();
    let mut out = String::from("<div class=\"grid\">");
    for t in values(cells, turbidity) {
        let mut grid = vec![f64::NAN; altitudes.len() * suns.len()];
        for cell in cells.iter().filter(|c| same(c.conditions.turbidity, t)) {
            let place = |values: &[f64], v: f64| values.iter().position(|node| same(*node, v));
            let row = place(&altitudes, altitude_km(&cell.conditions));
            let column = place(&suns, sun_deg(&cell.conditions));
            if let (Some(row), Some(column)) = (row, column) {
                grid[row * suns.len() + column] = value(cell);
            }
        }
        let rows = u32::try_from(altitudes.len()).unwrap_or(u32::MAX).min(40);
        out.push_str(
            &HeatMap {
                title: format!("Turbidity {}", short(t)),
                x: ("sun zenith [°]".to_owned(), label(&suns)),
                y: ("altitude [km]".to_owned(), label(&altitudes)),
                values: grid,
                full_scale,
                size: [336, (60 + 16 * rows).max(170)],
            }
            .html()?,
        );
    }
    out.push_str("</div>\n");
    Ok(out)
}

/// Why a cell is among the worst, as far as its fits tell.
fn reason(cell: &CellReport) -> String {
    let mut out = Vec::new();
    for channel in &cell.channels {
        if !channel.converged {
            out.push(format!("{} did not converge", channel.channel));
        }
        if channel.condition_number > NEARLY_SINGULAR {
            out.push(format!("{} nearly singular", channel.channel));
        }
        if !channel.note.is_empty() {
            out.push(format!("{}: {}", channel.channel, channel.note));
        }
    }
    out.extend(circumstances(&cell.conditions));
    if out.is_empty() {
        out.push("the formula's own limit".into());
    }
    out.join("; ")
}

/// What is known to be hard about a place. Circumstances, not proof: the fits do not say which counts.
fn circumstances(c: &Conditions) -> Vec<String> {
    let (sun, altitude, turbidity) = (sun_deg(c), altitude_km(c), turbidity(c));
    let depression = sun - horizon_zenith(c.observer_altitude).degrees();
    let mut out = Vec::new();
    if depression > 0.0 {
        out.push(format!(
            "sun {depression:.1}° below the horizon: the Earth's shadow cuts the sky"
        ));
    } else if sun >= 86.0 {
        out.push(format!(
            "sun {:.1}° above the horizon: the gradation depends on azimuth",
            -depression
        ));
    }
    if altitude >= 10.0 {
        out.push("aloft: the haze is a thin band at the horizon below a nearly black sky".into());
    } else if altitude >= 1.0 && turbidity > 1.2 {
        out.push("within the haze's upper part: half of it above, half below".into());
    } else if turbidity >= 4.0 {
        out.push("thick haze: a wide aureole that one exponential does not follow".into());
    }
    out
}

pub(super) fn worst(input: &ReportInput<'_>, csv: &mut LongTable) -> Section {
    let mut cells: Vec<&CellReport> = input.cells.iter().collect();
    cells.sort_by(|a, b| b.delta_e_p95.total_cmp(&a.delta_e_p95));
    cells.truncate(WORST);
    let rows: Vec<Vec<String>> = cells
        .iter()
        .map(|cell| {
            let c = &cell.conditions;
            let reason = reason(cell);
            csv.figure("worst", "delta_e p95", Some(c), "", cell.delta_e_p95);
            csv.text("worst", "reason", Some(c), "", &reason);
            let each = |text: &dyn Fn(&super::input::ChannelReport) -> String| {
                let lines: Vec<String> = cell.channels.iter().map(text).collect();
                lines.join("<br>")
            };
            vec![
                short(altitude_km(c)),
                short(c.turbidity),
                short(sun_deg(c)),
                format!("{:.2}", cell.delta_e_p95),
                percent(cell.luminance_p95),
                each(&|f| {
                    if f.channel == "Y" {
                        format!("Y {}", percent(f.rms))
                    } else {
                        format!("{} {:.4}", escape(f.channel), f.rms)
                    }
                }),
                each(&|f| {
                    if f.condition_number.is_nan() {
                        "–".into()
                    } else {
                        format!("{:.0e}", f.condition_number)
                    }
                }),
                each(&|f| escape(&f.why_stopped)),
                escape(&reason),
            ]
        })
        .collect();
    let head = [
        "altitude [km]",
        "turbidity",
        "sun zenith [°]",
        "ΔE p95",
        "luminance p95",
        "residual RMS",
        "condition",
        "stopped",
        "what is hard there",
    ];
    let body = if rows.is_empty() {
        "<p class=\"soft\">The table says nothing about the fits at its nodes.</p>\n".to_owned()
    } else {
        table(&head, &rows, head.len())
    };
    Section {
        id: "worst",
        title: "The ten worst cells",
        body,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases::conditions;

    #[test]
    fn d_the_worst_cells_are_told_apart() {
        let words = [
            (0.0, 2.0, 60.0),
            (0.0, 6.0, 60.0),
            (0.0, 2.0, 88.0),
            (0.0, 2.0, 93.0),
            (2.0, 2.0, 88.0),
            (20.0, 2.0, 93.0),
            (20.0, 2.0, 96.0),
        ]
        .map(|(altitude, turbidity, sun)| {
            circumstances(&conditions(altitude, turbidity, sun)).join("; ")
        });
        for (i, word) in words.iter().enumerate() {
            assert!(!words[..i].contains(word), "{i}: {word}");
        }
        assert!(words[0].is_empty(), "nothing is hard by day in clear air");
        assert!(
            words[3].starts_with("sun 3.0° below the horizon"),
            "{}",
            words[3]
        );
    }
}
