//! Bad input: exit status 2, nothing written, and one message with file, line, column, expected
//! and found.

use std::fs;
use std::path::Path;

use crate::support::{names, refuse};
use tempfile::{TempDir, tempdir};

const GENERAL: &str = include_str!("../../profiles/general.csv");

/// The general profile without comments.
fn general() -> Vec<String> {
    GENERAL
        .lines()
        .filter(|l| !l.starts_with('#'))
        .map(str::to_owned)
        .collect()
}

/// Place of a column in the general profile.
fn place(column: &str) -> usize {
    general()[0]
        .split(',')
        .position(|c| c == column)
        .expect("a column of the general profile")
}

/// The general profile with one cell replaced; line 1 is the header.
fn with_cell(line: usize, column: &str, cell: &str) -> String {
    let mut lines = general();
    let mut cells: Vec<&str> = lines[line - 1].split(',').collect();
    cells[place(column)] = cell;
    let changed = cells.join(",");
    lines[line - 1] = changed;
    lines.join("\n")
}

fn directory_with(name: &str, content: impl AsRef<[u8]>) -> TempDir {
    let dir = tempdir().expect("a temporary directory");
    fs::write(dir.path().join(name), content).expect("the file can be written");
    dir
}

/// Both commands that read a profile first must refuse it.
fn refuse_profile(content: impl AsRef<[u8]>, words: &[&str]) {
    let dir = directory_with("bad.csv", content);
    refuse(dir.path(), "profile --profile bad.csv --out out.csv", words);
    refuse(
        dir.path(),
        "optics --profile bad.csv --turbidity 2 --out out.csv",
        words,
    );
    assert_eq!(names(dir.path()), ["bad.csv"]);
}

#[test]
fn profile_with_a_missing_column() {
    let gone = place("temperature_k");
    let text: Vec<String> = general()
        .iter()
        .map(|l| {
            let cells: Vec<&str> = l.split(',').collect();
            [&cells[..gone], &cells[gone + 1..]].concat().join(",")
        })
        .collect();
    refuse_profile(
        text.join("\n"),
        &["bad.csv:1", "temperature_k", "expected", "found"],
    );
}

#[test]
fn profile_with_a_wrong_unit() {
    refuse_profile(
        with_cell(1, "pressure_hpa", "pressure_pa"),
        &[
            "bad.csv:1",
            "pressure_hpa",
            "pressure_pa",
            "expected",
            "found",
        ],
    );
}

#[test]
fn profile_with_text_for_a_number() {
    refuse_profile(
        with_cell(5, "temperature_k", "warm"),
        &[
            "bad.csv:5",
            "temperature_k",
            "expected a number",
            "\"warm\"",
        ],
    );
}

#[test]
fn profile_with_nan() {
    refuse_profile(
        with_cell(7, "pressure_hpa", "NaN"),
        &["bad.csv:7", "pressure_hpa", "expected", "NaN"],
    );
}

#[test]
fn profile_with_a_negative_pressure() {
    refuse_profile(
        with_cell(4, "pressure_hpa", "-700"),
        &["bad.csv:4", "pressure_hpa", "expected", "-700"],
    );
}

#[test]
fn profile_with_a_negative_density() {
    refuse_profile(
        with_cell(6, "ozone_number_density_per_m3", "-1e17"),
        &[
            "bad.csv:6",
            "ozone_number_density_per_m3",
            "expected",
            "found -1",
        ],
    );
}

#[test]
fn profile_whose_altitudes_do_not_ascend() {
    refuse_profile(
        with_cell(5, "altitude_km", "1.5"),
        &["bad.csv:5", "altitude_km", "expected", "1.5"],
    );
}

#[test]
fn profile_that_does_not_start_at_the_ground() {
    let mut lines = general();
    lines.remove(1);
    refuse_profile(
        lines.join("\n"),
        &["bad.csv:2", "altitude_km", "0 to 30 km", "found"],
    );
}

#[test]
fn profile_that_does_not_reach_30_km() {
    let lines = general()[..20].to_vec();
    refuse_profile(
        lines.join("\n"),
        &["bad.csv:20", "altitude_km", "0 to 30 km", "found"],
    );
}

#[test]
fn profile_that_is_empty() {
    refuse_profile("", &["bad.csv:1", "expected", "found an empty file"]);
    refuse_profile(" \n\n", &["bad.csv:1", "expected", "found an empty file"]);
    refuse_profile(&GENERAL[..0], &["empty"]);
}

#[test]
fn profile_with_a_header_alone() {
    refuse_profile(&general()[0], &["bad.csv:1", "expected", "found 0"]);
}

#[test]
fn profile_that_is_a_directory() {
    let dir = tempdir().unwrap();
    fs::create_dir(dir.path().join("bad.csv")).unwrap();
    refuse(
        dir.path(),
        "profile --profile bad.csv",
        &["bad.csv", "expected a file", "found a directory"],
    );
}

#[test]
fn profile_that_is_missing() {
    let dir = tempdir().unwrap();
    refuse(
        dir.path(),
        "profile --profile none.csv",
        &["none.csv", "expected a file", "found nothing"],
    );
}

#[test]
fn profile_that_is_not_utf8() {
    let mut bytes = general().join("\n").into_bytes();
    let third_line = bytes
        .iter()
        .enumerate()
        .filter(|(_, b)| **b == b'\n')
        .nth(1)
        .map(|(i, _)| i + 1)
        .unwrap();
    bytes[third_line + 4] = 0xe9;
    refuse_profile(bytes, &["bad.csv:3", "column 5", "expected UTF-8", "0xe9"]);
}

/// Arguments that must be refused, and what the message must name.
fn refuse_arguments(line: &str, words: &[&str]) {
    let dir = tempdir().expect("a temporary directory");
    refuse(dir.path(), line, words);
    assert!(names(dir.path()).is_empty(), "{line}");
}

#[test]
fn altitude_outside_minus_half_to_100_km() {
    for value in ["-0.51", "100.1", "nan", "inf", "high"] {
        refuse_arguments(
            &format!("map --altitude-km {value} --turbidity 2 --sun-zenith-deg 60 --out o.csv"),
            &["--altitude-km", "-0.5 to 100", value],
        );
    }
}

#[test]
fn altitude_outside_0_to_30_km() {
    for value in ["-0.1", "30.1", "nan", "inf", "high"] {
        for command in ["beam", "sky"] {
            refuse_arguments(
                &format!(
                    "{command} --altitude-km {value} --turbidity 2 --sun-zenith-deg 60 --out o.csv"
                ),
                &["--altitude-km", "0 to 30", value],
            );
        }
    }
}

#[test]
fn sun_zenith_outside_0_to_108_degrees() {
    for value in ["-1", "108.1", "nan"] {
        refuse_arguments(
            &format!("map --altitude-km 1 --turbidity 2 --sun-zenith-deg {value} --out o.csv"),
            &["--sun-zenith-deg", "0 to 108", value],
        );
    }
}

#[test]
fn what_an_engine_or_a_table_does_not_reach() {
    for (line, words) in [
        (
            "map --engine smarts --altitude-km 31 --turbidity 2 --sun-zenith-deg 60 --out o.csv",
            ["observer altitude", "31"],
        ),
        (
            "map --engine smarts --altitude-km 3 --turbidity 2 --sun-zenith-deg 97 --out o.csv",
            ["sun zenith", "97"],
        ),
        (
            "map --model nishita --altitude-km -0.1 --turbidity 2 --sun-zenith-deg 60 --yxy --out o.csv",
            ["altitude", "-0.1"],
        ),
    ] {
        refuse_arguments(line, &words);
    }
}

#[test]
fn sun_zenith_outside_0_to_96_degrees() {
    for value in ["-1", "96.01", "nan"] {
        for command in ["beam", "sky"] {
            refuse_arguments(
                &format!(
                    "{command} --altitude-km 1 --turbidity 2 --sun-zenith-deg {value} --out o.csv"
                ),
                &["--sun-zenith-deg", "0 to 96", value],
            );
        }
    }
}

#[test]
fn bounds_themselves_are_allowed() {
    let dir = tempdir().unwrap();
    for (altitude, sun) in [("0", "0"), ("30", "96")] {
        crate::support::succeed(
            dir.path(),
            &format!(
                "map --altitude-km {altitude} --turbidity 1 --sun-zenith-deg {sun} \
                 --engine smarts --yxy --out o.csv"
            ),
        );
    }
}

#[test]
fn turbidity_below_one() {
    for command in [
        "map --altitude-km 1 --sun-zenith-deg 60",
        "sky --altitude-km 1 --sun-zenith-deg 60",
        "beam --altitude-km 1 --sun-zenith-deg 60",
        "optics",
    ] {
        refuse_arguments(
            &format!("{command} --turbidity 0.99 --out o.csv"),
            &["--turbidity", "at least 1", "0.99"],
        );
    }
}

#[test]
fn haze_that_cannot_be() {
    for (haze, words) in [
        ("--aod500 -0.1", ["--aod500", "at least 0", "-0.1"]),
        ("--visual-range-km 0", ["--visual-range-km", "above 0", "0"]),
        (
            "--visual-range-km 500",
            ["visual range", "at most 333.97", "500"],
        ),
        (
            "--angstrom-beta nan",
            ["--angstrom-beta", "at least 0", "nan"],
        ),
    ] {
        refuse_arguments(&format!("optics {haze} --out o.csv"), &words);
    }
}

#[test]
fn conflicting_or_missing_turbidity() {
    for command in [
        "map --altitude-km 1 --sun-zenith-deg 60",
        "sky --altitude-km 1 --sun-zenith-deg 60",
        "beam --altitude-km 1 --sun-zenith-deg 60",
        "optics",
    ] {
        refuse_arguments(
            &format!("{command} --turbidity 2 --aod500 0.1 --out o.csv"),
            &["--turbidity", "cannot be used with", "--aod500"],
        );
        refuse_arguments(
            &format!("{command} --visual-range-km 20 --angstrom-beta 0.1 --out o.csv"),
            &[
                "--visual-range-km",
                "cannot be used with",
                "--angstrom-beta",
            ],
        );
        refuse_arguments(
            &format!("{command} --out o.csv"),
            &["--turbidity", "--aod500", "--visual-range-km", "required"],
        );
    }
}

#[test]
fn optics_made_elsewhere_with_a_profile_or_haze() {
    let common = "map --altitude-km 1 --sun-zenith-deg 60 --out o.csv --optics a.csv";
    refuse_arguments(common, &["--solar", "required"]);
    for option in [
        "--turbidity 2",
        "--profile general",
        "--constituents ozone",
        "--asymmetry 0.7",
        "--wavelength-step-nm 5",
    ] {
        refuse_arguments(
            &format!("{common} --solar b.csv {option}"),
            &["cannot be used with", "--optics"],
        );
    }
    refuse_arguments(
        "map --altitude-km 1 --sun-zenith-deg 60 --out o.csv --turbidity 2 --solar b.csv",
        &["--optics"],
    );
}

#[test]
fn optics_or_sun_that_cannot_be_read() {
    let dir = directory_with(
        "solar.csv",
        "wavelength_nm,irradiance_w_m2_nm\n400,1\n500,1\n",
    );
    let line = "map --altitude-km 1 --sun-zenith-deg 60 --out o.csv --solar solar.csv --optics";
    refuse(
        dir.path(),
        &format!("{line} none.csv"),
        &["none.csv", "found nothing"],
    );
    let header = "altitude_km,wavelength_nm,rayleigh_scattering_per_km,gas_absorption_per_km,\
                  aerosol_scattering_per_km,aerosol_absorption_per_km,aerosol_g\n";
    let write = |name: &str, rows: &str| {
        fs::write(dir.path().join(name), format!("{header}{rows}")).unwrap();
    };
    write("text.csv", "0,400,0.1,0,0,x,0\n1,400,0.1,0,0,0,0\n");
    refuse(
        dir.path(),
        &format!("{line} text.csv"),
        &[
            "text.csv:2",
            "aerosol_absorption_per_km",
            "expected a number",
            "\"x\"",
        ],
    );
    write(
        "hole.csv",
        "0,400,0.1,0,0,0,0\n0,500,0.1,0,0,0,0\n1,400,0.1,0,0,0,0\n",
    );
    refuse(
        dir.path(),
        &format!("{line} hole.csv"),
        &["hole.csv", "500"],
    );
    write("wide.csv", "0,600,0.1,0,0,0,0\n1,600,0.1,0,0,0,0\n");
    refuse(
        dir.path(),
        &format!("{line} wide.csv"),
        &["solar.csv", "400 to 500", "600", "wide.csv"],
    );
    refuse(
        dir.path(),
        &format!("{line} wide.csv --engine smarts"),
        &["--engine", "expected transport", "found smarts"],
    );
}

#[test]
fn directions_that_cannot_be_used() {
    let line = "map --altitude-km 1 --turbidity 2 --sun-zenith-deg 60 --engine smarts \
                --directions dirs.csv --out o.csv";
    for (content, words) in [
        ("", vec!["dirs.csv:1", "empty file"]),
        (
            "view_zenith_deg,azimuth\n1,2\n",
            vec!["dirs.csv:1", "relative_azimuth_deg", "expected", "found"],
        ),
        (
            "view_zenith_deg,relative_azimuth_deg\n1,2\n200,2\n",
            vec!["dirs.csv:3", "view_zenith_deg", "0 to 180", "found 200"],
        ),
        (
            "view_zenith_deg,relative_azimuth_deg\n1,left\n",
            vec![
                "dirs.csv:2",
                "relative_azimuth_deg",
                "expected a number",
                "\"left\"",
            ],
        ),
    ] {
        let dir = directory_with("dirs.csv", content);
        refuse(dir.path(), line, &words);
        assert_eq!(names(dir.path()), ["dirs.csv"]);
    }
}

#[test]
fn unknown_grid_engine_or_constituent() {
    refuse_arguments(
        "generate --grid fine --out out",
        &[
            "--grid",
            "expected seed, default or the path of a .toml file",
            "fine",
        ],
    );
    refuse_arguments(
        "map --altitude-km 1 --turbidity 2 --sun-zenith-deg 60 --engine magic --out o.csv",
        &["--engine", "magic", "transport", "smarts"],
    );
    refuse_arguments(
        "optics --turbidity 2 --constituents ozone,argon --out o.csv",
        &["--constituents", "argon"],
    );
    refuse_arguments(
        "optics --turbidity 2 --wavelength-step-nm 7 --out o.csv",
        &["--wavelength-step-nm", "7", "5, 10, 20"],
    );
}

#[test]
fn outputs_that_cannot_be_written() {
    let dir = directory_with("file", "old");
    let line = "optics --turbidity 2 --wavelength-step-nm 20 --out";
    refuse(
        dir.path(),
        &format!("{line} no/such/o.csv"),
        &["no/such/o.csv", "cannot be written", "no/such"],
    );
    refuse(
        dir.path(),
        &format!("{line} ."),
        &["expected a file", "found a directory"],
    );
    refuse(
        dir.path(),
        &format!("{line} file/o.csv"),
        &["file/o.csv", "cannot be written"],
    );
    assert_eq!(names(dir.path()), ["file"]);
}

#[cfg(unix)]
#[test]
fn output_directory_without_permission() {
    use std::os::unix::fs::PermissionsExt;
    let dir = tempdir().unwrap();
    let locked = dir.path().join("locked");
    fs::create_dir(&locked).unwrap();
    fs::set_permissions(&locked, fs::Permissions::from_mode(0o555)).unwrap();
    // The superuser may write everywhere but into the kernel's own directory.
    let privileged = fs::write(locked.join("probe"), "x").is_ok();
    let target = if privileged {
        Path::new("/proc")
    } else {
        locked.as_path()
    };
    let target = target.join("o.csv");
    refuse(
        dir.path(),
        &format!("optics --turbidity 2 --out {}", target.display()),
        &["o.csv", "cannot be written"],
    );
    assert!(!target.exists());
}
