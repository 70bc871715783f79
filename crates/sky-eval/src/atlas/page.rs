//! `atlas.html`: for each model, maps of the first failure in two planes, and its worst cases.

use anyhow::Result;
use sky_plot::heat_map::HeatMap;
use sky_plot::number::short;
use sky_plot::page::{Section, escape, page, table};

use super::kind::{Arithmetic, KINDS};
use super::rows::{Chapter, Row};
use super::sweep::{ALTITUDE_BINS, ANSWERED, ASKED, SUN_BINS, SWEPT, VIEW_BINS};

const SOUND: [u8; 3] = [150, 205, 165];
const REFUSED: [u8; 3] = [170, 175, 182];

/// The color of a cell's bits; `None` where nothing was asked.
fn color(bits: u32) -> Option<[u8; 3]> {
    let failed = KINDS.iter().find(|k| bits >> (k.kind as u32) & 1 == 1);
    match failed {
        Some(kind) => Some(kind.color),
        None if bits & ANSWERED != 0 => Some(SOUND),
        None if bits & ASKED != 0 => Some(REFUSED),
        None => None,
    }
}

/// Lower ends of equal bins, as labels.
fn labels([low, high]: [f64; 2], bins: usize) -> Vec<String> {
    let count = f64::from(u32::try_from(bins).unwrap_or(1));
    (0..bins)
        .map(|i| {
            let place = f64::from(u32::try_from(i).unwrap_or(0));
            let value = low + (high - low) * place / count;
            short((value * 100.0).round() / 100.0)
        })
        .collect()
}

fn map(
    title: &str,
    x: (&str, [f64; 2], usize),
    y: (&str, [f64; 2], usize),
    cells: &[u32],
) -> Result<String> {
    HeatMap {
        title: title.to_owned(),
        x: (x.0.to_owned(), labels(x.1, x.2)),
        y: (y.0.to_owned(), labels(y.1, y.2)),
        values: cells.iter().map(|bits| f64::from(*bits)).collect(),
        full_scale: 1.0,
        size: [540, 400],
    }
    .html_colored(|i| color(cells[i]))
    .map_err(Into::into)
}

fn key(color: [u8; 3], name: &str) -> String {
    let [r, g, b] = color;
    format!(
        "<span><i class=\"key dots\" style=\"border-color:rgb({r},{g},{b})\"></i>{}</span>\n",
        escape(name)
    )
}

fn legend() -> String {
    let mut out = String::from("<div class=\"legend\" style=\"max-width:none\">");
    out.push_str(&key(SOUND, "answered, no failure"));
    out.push_str(&key(REFUSED, "refused"));
    for kind in KINDS {
        out.push_str(&key(kind.color, kind.name));
    }
    out.push_str("</div>\n");
    out
}

fn verdict(row: &Row) -> String {
    let class = if row.failures == 0 { "good" } else { "bad" };
    format!("<span class=\"{class}\">{}</span>", row.failures)
}

fn side(inside: bool) -> String {
    if inside { "inside" } else { "outside" }.to_owned()
}

fn chapter(chapter: &Chapter) -> Result<Section> {
    let rows = chapter.rows();
    let domain = chapter.subject.model().domain();
    let [h, t, s] = [domain.altitude_km, domain.turbidity, domain.sun_zenith_deg]
        .map(|[low, high]| format!("{}–{}", short(low), short(high)));
    let mut body = format!(
        "<p>Domain: altitude {h} km, turbidity {t}, sun zenith {s}°, directions down to the {}.</p>\n",
        if domain.below_horizontal {
            "geometric horizon"
        } else {
            "horizontal"
        }
    );
    body.push_str("<div class=\"grid\">\n");
    let sun = ("sun zenith [°]", SWEPT.sun_zenith_deg, SUN_BINS);
    body.push_str(&map(
        "First failure, all turbidities and directions",
        sun,
        ("altitude [km]", SWEPT.altitude_km, ALTITUDE_BINS),
        &chapter.findings.altitude_map,
    )?);
    body.push_str(&map(
        "First failure, all altitudes, turbidities and azimuths",
        ("view zenith [°]", [0.0, 180.0], VIEW_BINS),
        sun,
        &chapter.findings.view_map,
    )?);
    body.push_str("</div>\n");
    let cells: Vec<Vec<String>> = rows
        .iter()
        .map(|row| {
            let entry = &KINDS[row.kind];
            vec![
                escape(entry.name),
                row.arithmetic.name().to_owned(),
                side(row.inside_domain),
                row.samples.to_string(),
                verdict(row),
                format!("{:.3e}", row.worst_value),
                format!("{:.0e}", entry.limit),
                format!(
                    "<details><summary>{}</summary><code>{}</code></details>",
                    escape(entry.score),
                    escape(&row.reproduce)
                ),
            ]
        })
        .collect();
    let head = [
        "kind",
        "arithmetic",
        "domain",
        "samples",
        "failures",
        "worst",
        "limit",
        "what the worst is; how to see it",
    ];
    body.push_str(&table(&head, &cells, 3));
    Ok(Section {
        id: chapter.name,
        title: chapter.name,
        body,
    })
}

fn summary(chapters: &[Chapter]) -> Section {
    let rows: Vec<Vec<String>> = KINDS
        .iter()
        .enumerate()
        .map(|(kind, entry)| {
            let mut row = vec![escape(entry.name), escape(entry.score)];
            for chapter in chapters {
                let own = chapter.subject.arithmetic;
                let cell = |inside: bool| {
                    chapter
                        .rows()
                        .iter()
                        .find(|r| {
                            let twin =
                                entry.name == "precision" && r.arithmetic == Arithmetic::CpuF64;
                            r.kind == kind
                                && r.inside_domain == inside
                                && (r.arithmetic == own || twin)
                        })
                        .map_or_else(
                            || "–".to_owned(),
                            |r| format!("{} of {}", verdict(r), r.samples),
                        )
                };
                row.extend([cell(true), cell(false)]);
            }
            row
        })
        .collect();
    let heads: Vec<String> = chapters
        .iter()
        .flat_map(|c| {
            [
                format!("{}, inside", c.name),
                format!("{}, outside", c.name),
            ]
        })
        .collect();
    let head: Vec<&str> = ["kind", "score"]
        .into_iter()
        .chain(heads.iter().map(String::as_str))
        .collect();
    let body = format!(
        "<p>Failures of samples, inside and outside of what the model claims. A sample fails if its \
         score is above the kind's limit.</p>\n{}{}",
        table(&head, &rows, 2),
        legend()
    );
    Section {
        id: "summary",
        title: "Failures",
        body,
    }
}

/// The page.
///
/// # Errors
/// When a map cannot be drawn.
pub fn html(chapters: &[Chapter]) -> Result<String> {
    let mut sections = vec![summary(chapters)];
    for found in chapters {
        sections.push(chapter(found)?);
    }
    let lead = format!(
        "Where each model fails: swept over altitude {} to {} km, turbidity {} to {}, sun zenith {} to \
         {}° and every direction, dense where formulas are known to break. A cell's color is the \
         first of its failures in the order of the list.",
        SWEPT.altitude_km[0],
        SWEPT.altitude_km[1],
        SWEPT.turbidity[0],
        SWEPT.turbidity[1],
        SWEPT.sun_zenith_deg[0],
        SWEPT.sun_zenith_deg[1]
    );
    Ok(page("UTM sky model: atlas of failures", &lead, &sections))
}
