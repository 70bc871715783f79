//! What each term of the sky is worth, the audit of the printed table, and where everything comes from.

use anyhow::Result;
use sky_plot::heat_map::{HeatMap, color_bar};
use sky_plot::number::short;
use sky_plot::page::{self, Section};

use super::appendix_a;
use super::input::ReportInput;
use super::long_table::LongTable;
use super::text::count_f64;
use crate::ledger::{ALTITUDES_KM, SUNS_DEG, Seen};

pub(super) fn appendix(csv: &mut LongTable) -> Section {
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
pub(super) fn terms(ledger: &[Seen], csv: &mut LongTable) -> Result<Section> {
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
            x: ("sun zenith [°]".to_owned(), labels(&SUNS_DEG)),
            y: ("altitude [km]".to_owned(), labels(&ALTITUDES_KM)),
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
        color_bar(100.0, "% of directions")
    );
    Ok(Section {
        id: "terms",
        title: "What each term is worth",
        body,
    })
}

pub(super) fn provenance(input: &ReportInput<'_>, csv: &mut LongTable) -> Section {
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
