//! The files of a report.

use std::path::Path;

use anyhow::Result;
use sky_eval::report::ReportFiles;

use super::files::{OutputFile, create_directory};

/// The report's two output files in a directory, which is made if missing: page, then CSV. Opened
/// before the work starts, so that a bad directory is told at once.
///
/// # Errors
/// When the directory cannot be made or written to.
pub fn create_outputs(directory: &Path) -> Result<[OutputFile; 2]> {
    create_directory(directory)?;
    Ok([
        OutputFile::create(&directory.join("report.html"))?,
        OutputFile::create(&directory.join("report.csv"))?,
    ])
}

/// Writes a report to the files that [`create_outputs`] opened.
///
/// # Errors
/// When writing fails.
pub fn write(report: &ReportFiles, [html, csv]: [OutputFile; 2]) -> Result<()> {
    html.commit(report.html.as_bytes())?;
    csv.commit(report.csv.as_bytes())?;
    Ok(())
}
