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

/// Bins that a cell of a map may hold at most, across and down: none is empty long before.
const MOST_MERGED: usize = 12;

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

/// Bins taken together, as few as leave no cell without a sample: a hole would say nothing.
#[derive(Clone, Debug, PartialEq)]
struct Merged {
    /// Bins of a cell, across and down.
    by: [usize; 2],
    columns: usize,
    rows: usize,
    cells: Vec<u32>,
}

fn merged(bins: &[u32], [columns, rows]: [usize; 2]) -> Merged {
    let by_size = |by: [usize; 2]| {
        let (across, down) = (columns.div_ceil(by[0]), rows.div_ceil(by[1]));
        let mut cells = vec![0; across * down];
        for (i, bits) in bins.iter().enumerate() {
            cells[(i / columns / by[1]) * across + i % columns / by[0]] |= bits;
        }
        Merged {
            by,
            columns: across,
            rows: down,
            cells,
        }
    };
    let mut sizes: Vec<[usize; 2]> = (1..=MOST_MERGED)
        .flat_map(|x| (1..=MOST_MERGED).map(move |y| [x, y]))
        .collect();
    sizes.sort_by_key(|[x, y]| (x * y, x.abs_diff(*y), *x));
    sizes
        .into_iter()
        .map(by_size)
        .find(|merged| merged.cells.iter().all(|bits| *bits != 0))
        .unwrap_or_else(|| by_size([1, 1]))
}

/// The lower ends of merged bins.
fn ends(axis: (&str, [f64; 2], usize), by: usize) -> Vec<String> {
    labels(axis.1, axis.2).into_iter().step_by(by).collect()
}

fn map(
    title: &str,
    x: (&str, [f64; 2], usize),
    y: (&str, [f64; 2], usize),
    bins: &[u32],
) -> Result<String> {
    let Merged { by, cells, .. } = merged(bins, [x.2, y.2]);
    HeatMap {
        title: title.to_owned(),
        x: (x.0.to_owned(), ends(x, by[0])),
        y: (y.0.to_owned(), ends(y, by[1])),
        values: cells.iter().map(|bits| f64::from(*bits)).collect(),
        full_scale: 1.0,
        size: [524, 390],
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

/// A limit with all its digits, so that what is above it on the page is above it.
fn limit(value: f64) -> String {
    if value == 0.0 {
        "0".to_owned()
    } else {
        format!("{value:e}")
    }
}

fn verdict(row: &Row) -> String {
    let class = if row.failures == 0 {
        "good"
    } else if row.arithmetic == Arithmetic::F16Table {
        // an experiment, see [`HALVES`]
        "soft"
    } else {
        "bad"
    };
    format!("<span class=\"{class}\">{}</span>", row.failures)
}

/// Why a table in halves is in the list.
const HALVES: &str = "<p class=\"soft\">f16_table is no arithmetic of the model but an experiment: the frame's \
    coefficients rounded to half precision, 11 bits of mantissa. It shows why a table stores them in 16 \
    bits between the least and the largest value of each instead; its precision failures are what halves \
    would cost.</p>\n";

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
                limit(entry.limit),
                format!(
                    "<details><summary>show</summary><code>{}</code></details>",
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
        "how to see it",
    ];
    body.push_str(&table(&head, &cells, 3));
    if rows
        .iter()
        .any(|row| row.arithmetic == Arithmetic::F16Table)
    {
        body.push_str(HALVES);
    }
    Ok(Section {
        id: chapter.name,
        title: chapter.name,
        body,
    })
}

/// The models that fail, worst first, and how many were asked, in words that wrap.
fn failing(chapters: &[Chapter], kind: usize, inside: bool) -> String {
    let mut asked = 0;
    let mut found: Vec<(u64, u64, &str)> = Vec::new();
    for chapter in chapters {
        let own = chapter.subject.arithmetic;
        for row in chapter.rows() {
            let twin = KINDS[kind].name == "precision" && row.arithmetic == Arithmetic::CpuF64;
            if row.kind == kind && row.inside_domain == inside && (row.arithmetic == own || twin) {
                asked += 1;
                if row.failures > 0 {
                    found.push((row.failures, row.samples, chapter.name));
                }
            }
        }
    }
    if asked == 0 {
        return "–".to_owned();
    }
    if found.is_empty() {
        return format!("<span class=\"good\">none of {asked}</span>");
    }
    found.sort_by_key(|(failures, _, name)| (core::cmp::Reverse(*failures), *name));
    found
        .iter()
        .map(|(failures, samples, name)| {
            format!(
                "{} <span class=\"bad\">{failures}</span> of {samples}",
                escape(name)
            )
        })
        .collect::<Vec<_>>()
        .join(", ")
}

fn summary(chapters: &[Chapter]) -> Section {
    let rows: Vec<Vec<String>> = KINDS
        .iter()
        .enumerate()
        .map(|(kind, entry)| {
            vec![
                escape(entry.name),
                escape(entry.score),
                limit(entry.limit),
                failing(chapters, kind, true),
                failing(chapters, kind, false),
            ]
        })
        .collect();
    let head = [
        "kind",
        "score",
        "limit",
        "models that fail inside their domain",
        "outside",
    ];
    let body = format!(
        "<p>A sample fails if its score is above the kind's limit. Of each kind, the models with failures, \
         inside and outside of what they claim; the others of those that were asked have none.</p>\n{}{}",
        table(&head, &rows, head.len()),
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn d_a_limit_is_shown_as_it_is_used() {
        for entry in KINDS {
            let shown: f64 = limit(entry.limit).parse().unwrap();
            assert_eq!(shown.to_bits(), entry.limit.to_bits(), "{}", entry.name);
        }
        assert_eq!(limit(0.0125), "1.25e-2");
    }

    #[test]
    fn d_a_map_has_no_holes() {
        // every third column was asked, and every second row
        let [columns, rows] = [36, 25];
        let bins: Vec<u32> = (0..columns * rows)
            .map(|i| {
                if i % columns % 3 == 1 && i / columns % 2 == 0 {
                    ASKED | 1
                } else {
                    0
                }
            })
            .collect();
        let found = merged(&bins, [columns, rows]);
        assert_eq!((found.by, found.columns, found.rows), ([3, 2], 12, 13));
        assert!(found.cells.iter().all(|bits| *bits == ASKED | 1));
        // nothing is merged where nothing is missing
        assert_eq!(merged(&[ASKED; 6], [3, 2]).by, [1, 1]);
    }
}
