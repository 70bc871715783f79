//! CSV tables of the command line: directions in, maps and spectra out.
//!
//! Angles are kept in degrees as the file had them, so that what comes out equals what went in.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::Args;
use sky_core::color::Yxy;
use sky_core::direction::SkyDirection;
use sky_science::direction::report_directions;
use sky_sim::table::{ColumnSpec, Table, TableError};

use super::files::read_text;

/// Columns of a directions file.
pub const DIRECTION_COLUMNS: [ColumnSpec; 2] = [
    ColumnSpec::required("view_zenith_deg", [0.0, 180.0]),
    ColumnSpec::required("relative_azimuth_deg", [-360.0, 360.0]),
];

/// Directions of view as a file lists them.
#[derive(Clone, Debug, PartialEq)]
pub struct DirectionTable {
    /// View zenith and relative azimuth \[deg\], as written.
    pub degrees: Vec<[f64; 2]>,
    /// The same as directions.
    pub directions: Vec<SkyDirection>,
    /// The file and the line of each; nothing where they were given otherwise.
    source: Option<(String, Vec<u64>)>,
}

/// Directions of view: a file, or one by one.
#[derive(Clone, Debug, Args)]
#[group(skip)]
pub struct DirectionArgs {
    /// Directions: CSV with `view_zenith_deg,relative_azimuth_deg` (0 faces the sun); without any the
    /// zenith and nine rings of 30
    #[arg(long, value_name = "CSV")]
    pub directions: Option<PathBuf>,
    /// A direction by view zenith angle and azimuth (0 faces the sun) [deg]; may be repeated
    #[arg(long, value_name = "ZENITH,AZIMUTH", value_parser = direction,
          conflicts_with = "directions", allow_hyphen_values = true)]
    pub direction: Vec<[f64; 2]>,
}

impl DirectionArgs {
    /// The directions; the report's 271 where none were given.
    ///
    /// # Errors
    /// When the file cannot be read or its table is wrong.
    pub fn table(&self) -> Result<DirectionTable> {
        match &self.directions {
            Some(path) => Ok(DirectionTable::parse(path, &read_text(path)?)?),
            None if self.direction.is_empty() => Ok(DirectionTable::report()),
            None => Ok(DirectionTable::new(self.direction.clone(), None)),
        }
    }
}

fn direction(text: &str) -> Result<[f64; 2], String> {
    numbers(text, &DIRECTION_COLUMNS)
}

/// Numbers with commas between them, within the ranges of as many columns.
pub(crate) fn numbers<const N: usize>(
    text: &str,
    columns: &[ColumnSpec; N],
) -> Result<[f64; N], String> {
    let given: Vec<&str> = text.split(',').map(str::trim).collect();
    let mut out = [0.0; N];
    if given.len() != N {
        let names: Vec<&str> = columns.iter().map(|column| column.name).collect();
        return Err(format!("expected {}, found {text:?}", names.join(",")));
    }
    for ((out, word), column) in out.iter_mut().zip(given).zip(columns) {
        let [low, high] = column.range;
        *out = word
            .parse()
            .ok()
            .filter(|value| (low..=high).contains(value))
            .ok_or_else(|| format!("{}: expected {low} to {high}, found {word:?}", column.name))?;
    }
    Ok(out)
}

impl DirectionTable {
    /// The report's 271 directions.
    #[must_use]
    pub fn report() -> Self {
        let directions = report_directions();
        // Whole degrees that went through radians.
        let degrees = directions
            .iter()
            .map(|d| {
                [
                    d.view_zenith.degrees().round(),
                    d.relative_azimuth.degrees().round(),
                ]
            })
            .collect();
        Self {
            degrees,
            directions,
            source: None,
        }
    }

    fn new(degrees: Vec<[f64; 2]>, source: Option<(String, Vec<u64>)>) -> Self {
        let directions = degrees
            .iter()
            .map(|&[zenith, azimuth]| SkyDirection::from_degrees(zenith, azimuth))
            .collect();
        Self {
            degrees,
            directions,
            source,
        }
    }

    /// Where a direction was given, for errors.
    #[must_use]
    pub fn place(&self, index: usize) -> String {
        let number = index + 1;
        self.source.as_ref().map_or_else(
            || format!("direction {number}"),
            |(file, lines)| format!("{file}:{}: direction {number}", lines[index]),
        )
    }

    /// From CSV text: the two columns in any order, others passed over, lines starting with `#` too.
    ///
    /// # Errors
    /// The first thing that is wrong, with its line and column.
    pub fn parse(path: &Path, text: &str) -> Result<Self, TableError> {
        let table = Table::read_some(&path.display().to_string(), text, &DIRECTION_COLUMNS, 1)?;
        let degrees = table
            .column(0)
            .iter()
            .zip(table.column(1))
            .map(|(zenith, azimuth)| [*zenith, *azimuth])
            .collect();
        Ok(Self::new(degrees, Some((table.file, table.line))))
    }
}

/// Formats a physical value: nine significant digits, always with an exponent.
fn value(text: &mut String, value: f64) {
    // Writing to a string cannot fail.
    let _ = write!(text, "{value:.8e}");
}

/// A spectral map: one row per direction and wavelength.
/// `spectral_radiance` is direction-major \[W·m⁻²·sr⁻¹·nm⁻¹\].
#[must_use]
pub fn spectral_map_csv(
    directions: &DirectionTable,
    wavelength_nm: &[f64],
    spectral_radiance: &[f64],
) -> String {
    let mut text =
        String::from("view_zenith_deg,relative_azimuth_deg,wavelength_nm,radiance_w_m2_sr_nm\n");
    let rows = spectral_radiance.chunks_exact(wavelength_nm.len().max(1));
    for ([zenith, azimuth], spectrum) in directions.degrees.iter().zip(rows) {
        for (nm, &radiance) in wavelength_nm.iter().zip(spectrum) {
            let _ = write!(text, "{zenith},{azimuth},{nm},");
            value(&mut text, radiance);
            text.push('\n');
        }
    }
    text
}

/// A map of luminance and chromaticity: one row per direction.
#[must_use]
pub fn yxy_map_csv(directions: &DirectionTable, map: &[Yxy]) -> String {
    let mut text = String::from("view_zenith_deg,relative_azimuth_deg,luminance_cd_m2,x,y\n");
    for ([zenith, azimuth], yxy) in directions.degrees.iter().zip(map) {
        let _ = write!(text, "{zenith},{azimuth},");
        value(&mut text, yxy.luminance_cd_m2);
        let _ = writeln!(text, ",{:.8},{:.8}", yxy.x, yxy.y);
    }
    text
}

/// A spectrum: `wavelength_nm,irradiance_w_m2_nm`.
#[must_use]
pub fn irradiance_csv(wavelength_nm: &[f64], irradiance: &[f64]) -> String {
    let mut text = String::from("wavelength_nm,irradiance_w_m2_nm\n");
    for (nm, &irradiance) in wavelength_nm.iter().zip(irradiance) {
        let _ = write!(text, "{nm},");
        value(&mut text, irradiance);
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<DirectionTable, TableError> {
        DirectionTable::parse(Path::new("dirs.csv"), text)
    }

    #[test]
    fn columns_come_in_any_order_and_others_are_ignored() {
        let text =
            "\u{feff}# comment\nname,relative_azimuth_deg,view_zenith_deg\na,12,10.5\nb,-30,180\n";
        let table = parse(text).unwrap();
        assert_eq!(
            format!("{:?}", table.degrees),
            "[[10.5, 12.0], [180.0, -30.0]]"
        );
        assert!((table.directions[0].view_zenith.degrees() - 10.5).abs() < 1e-12);
    }

    #[test]
    fn bad_directions_are_told_with_line_and_column() {
        for (text, message) in [
            (
                "view_zenith_deg,azimuth_deg\n1,2\n",
                "dirs.csv:1: column relative_azimuth_deg: expected in the header, found only \
                 view_zenith_deg, azimuth_deg",
            ),
            (
                "view_zenith_deg,relative_azimuth_deg\n1,2\n1,x\n",
                "dirs.csv:3: column relative_azimuth_deg: expected a number, found \"x\"",
            ),
            (
                "view_zenith_deg,relative_azimuth_deg\n181,2\n",
                "dirs.csv:2: column view_zenith_deg: expected 0 to 180, found 181",
            ),
            (
                "view_zenith_deg,relative_azimuth_deg\nNaN,2\n",
                "dirs.csv:2: column view_zenith_deg: expected a finite number, found NaN",
            ),
            (
                "view_zenith_deg,relative_azimuth_deg\n1\n",
                "dirs.csv:2: expected 2 cells as in the header, found 1",
            ),
            (
                "view_zenith_deg,relative_azimuth_deg\n",
                "dirs.csv:1: expected at least 1 rows, found 0",
            ),
            (
                "view_zenith_deg,relative_azimuth_deg,view_zenith_deg\n1,2,3\n",
                "dirs.csv:1: column view_zenith_deg: expected once, found twice",
            ),
        ] {
            assert_eq!(parse(text).unwrap_err().to_string(), message);
        }
    }

    #[test]
    fn c_a_direction_is_named_with_its_line() {
        let table = parse("# comment\nview_zenith_deg,relative_azimuth_deg\n0,0\n95,12\n").unwrap();
        assert_eq!(table.place(1), "dirs.csv:4: direction 2");
        assert_eq!(DirectionTable::report().place(0), "direction 1");
    }

    #[test]
    fn the_default_is_the_report_s_271_in_whole_degrees() {
        let table = DirectionTable::report();
        assert_eq!(table.degrees.len(), 271);
        assert_eq!(format!("{:?}", table.degrees[1]), "[10.0, 0.0]");
        assert_eq!(format!("{:?}", table.degrees[270]), "[90.0, 348.0]");
    }

    #[test]
    fn rows_are_written_direction_by_direction() {
        let table = parse("view_zenith_deg,relative_azimuth_deg\n0,0\n10,12\n").unwrap();
        let csv = spectral_map_csv(&table, &[400.0, 500.5], &[1.0, 2.0, 3.0, 0.04]);
        assert_eq!(
            csv,
            "view_zenith_deg,relative_azimuth_deg,wavelength_nm,radiance_w_m2_sr_nm\n\
             0,0,400,1.00000000e0\n0,0,500.5,2.00000000e0\n\
             10,12,400,3.00000000e0\n10,12,500.5,4.00000000e-2\n"
        );
        let yxy = Yxy {
            luminance_cd_m2: 5000.0,
            x: 0.25,
            y: 0.26,
        };
        assert_eq!(
            yxy_map_csv(&table, &[yxy, yxy]).lines().nth(2),
            Some("10,12,5.00000000e3,0.25000000,0.26000000")
        );
        assert_eq!(
            irradiance_csv(&[500.0], &[1.9]),
            "wavelength_nm,irradiance_w_m2_nm\n500,1.90000000e0\n"
        );
    }
}
