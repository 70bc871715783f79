//! The report: one self-contained HTML page on a look-up table, and its figures as CSV.
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
pub mod input;
mod long_table;
pub mod of_table;
mod physics;
mod skies;
mod sources;
mod summary;
mod text;
pub mod wavelengths;

use anyhow::{Result, bail};
use sky_plot::page;

use input::ReportInput;
use long_table::LongTable;

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
        sources::terms(input.ledger, &mut csv)?,
        cells::worst(input, &mut csv),
        sources::appendix(&mut csv),
        sources::provenance(input, &mut csv),
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
