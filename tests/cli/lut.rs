//! `utm-sky lut`: what a table says about itself, its CSV, and files that are no tables.

use std::fs;

use crate::lut_support::{report_grid, smallest};
use crate::support::{names, refuse, succeed};
use tempfile::{TempDir, tempdir};

fn directory_with(bytes: &[u8]) -> TempDir {
    let dir = tempdir().expect("a temporary directory");
    fs::write(dir.path().join("sky.utmlut"), bytes).expect("the file can be written");
    dir
}

/// Every command that reads a table must refuse it, in one line.
fn refuse_table(bytes: &[u8], words: &[&str]) {
    let dir = directory_with(bytes);
    let words: Vec<&str> = words.iter().copied().chain(["sky.utmlut"]).collect();
    for line in ["lut info sky.utmlut", "lut export sky.utmlut --out out.csv"] {
        refuse(dir.path(), line, &words);
        let message = crate::support::run(dir.path(), line).stderr;
        assert_eq!(message.lines().count(), 1, "{message}");
    }
    assert_eq!(names(dir.path()), ["sky.utmlut"]);
}

#[test]
fn info_prints_what_the_table_says() {
    let dir = directory_with(&smallest().encode());
    let printed = succeed(dir.path(), "lut info sky.utmlut").stdout;
    for words in [
        "table             sky.utmlut\n",
        "form              perez-spherical\n",
        "interpolation     log-linear\n",
        "nodes             2 altitudes x 2 turbidities x 2 suns = 8\n",
        "altitude          0 30 km\n",
        "turbidity         1 8\n",
        "sun zenith        0 92 deg\n",
        "terms             zenith A B C D E\n",
        "profile           profiles/general.csv\n",
        "made by           utm-sky 0.1.0\n",
        "luminance: median 1.10 %, 95 % below 3.30 %, largest 11.00 %\n",
        "CIEDE2000: median 0.25, 95 % below 0.75, largest 2.50\n",
        "settings          ground_albedo = 0.2\n",
        "                  wavelength_step_nm = 10\n",
    ] {
        assert!(printed.contains(words), "no {words:?} in\n{printed}");
    }
    assert!(printed.contains(&format!("{} bytes", smallest().encode().len())));
}

#[test]
fn export_writes_the_coefficients() {
    let dir = directory_with(&report_grid().encode());
    let printed = succeed(dir.path(), "lut export sky.utmlut --out out.csv").stdout;
    assert_eq!(printed, "");
    let csv = fs::read_to_string(dir.path().join("out.csv")).unwrap();
    assert_eq!(csv, report_grid().to_csv_string());
    assert_eq!(csv.lines().count(), 76);
}

#[test]
fn a_truncated_table() {
    let bytes = smallest().encode();
    let expected = format!("expected {} bytes", bytes.len());
    refuse_table(
        &bytes[..bytes.len() - 1],
        &[
            "truncated",
            &expected,
            &format!("found {}", bytes.len() - 1),
        ],
    );
    refuse_table(&bytes[..20], &["truncated", "found 20"]);
    refuse_table(b"", &["truncated", "found 0"]);
}

#[test]
fn a_table_with_a_flipped_bit() {
    let mut bytes = smallest().encode();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 0x10;
    refuse_table(&bytes, &["damaged", "expected checksum", "found"]);
}

#[test]
fn a_foreign_file() {
    refuse_table(
        b"altitude_km,pressure_hpa\n0,1013\n",
        &["byte 0", "expected 0x89", "found 0x61", "another kind"],
    );
}

#[test]
fn a_table_of_another_version() {
    let mut bytes = smallest().encode();
    bytes[12] = 2;
    refuse_table(&bytes, &["expected version 1", "found 2"]);
}

#[test]
fn a_table_with_something_behind_its_end() {
    let mut bytes = smallest().encode();
    bytes.extend([0; 3]);
    refuse_table(&bytes, &["expected the end of the file", "3 more bytes"]);
}

#[test]
fn a_table_that_is_not_there() {
    let dir = tempdir().unwrap();
    refuse(
        dir.path(),
        "lut info no.utmlut",
        &["no.utmlut", "expected a file"],
    );
    refuse(dir.path(), "lut info .", &["expected a file", "directory"]);
}

#[test]
fn an_export_that_cannot_be_written() {
    let dir = directory_with(&smallest().encode());
    refuse(
        dir.path(),
        "lut export sky.utmlut --out no/out.csv",
        &["no/out.csv", "expected the directory no"],
    );
    assert_eq!(names(dir.path()), ["sky.utmlut"]);
}

#[test]
fn the_built_in_table_can_be_asked_by_its_name() {
    let dir = tempdir().expect("a temporary directory");
    let printed = succeed(dir.path(), "lut info embedded").stdout;
    assert!(
        printed.contains("form              extended\n"),
        "{printed}"
    );
    succeed(
        dir.path(),
        "sky --lut embedded --altitude-km 6 --turbidity 2 --sun-zenith-deg 60 --out yxy.csv",
    );
    assert_eq!(names(dir.path()), ["yxy.csv"]);
}
