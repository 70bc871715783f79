//! The contracts of the command line: columns, rows, exit status.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crate::support::{names, refuse, run, succeed};
use tempfile::tempdir;

/// Header and rows of a CSV of numbers.
fn read(path: &Path) -> (String, Vec<Vec<f64>>) {
    let text = fs::read_to_string(path).expect("the output can be read");
    let mut lines = text.lines();
    let header = lines.next().expect("a header").to_owned();
    let rows = lines
        .map(|l| {
            l.split(',')
                .map(|cell| cell.parse().expect("a number"))
                .collect()
        })
        .collect();
    (header, rows)
}

fn close(found: f64, expected: f64, tolerance: f64) {
    assert!(
        (found - expected).abs() <= tolerance,
        "{found} is not {expected} within {tolerance}"
    );
}

#[test]
fn every_command_has_help_with_an_example() {
    let dir = tempdir().unwrap();
    for command in [
        "",
        "profile",
        "optics",
        "map",
        "beam",
        "sky",
        "generate",
        "report",
        "lut",
        "lut info",
        "lut export",
    ] {
        let help = succeed(dir.path(), &format!("{command} --help"));
        assert!(help.stdout.contains("Example"), "{command}");
        assert!(help.stdout.contains("  utm-sky "), "{command}");
    }
    assert_eq!(run(dir.path(), "").code, Some(2));
    refuse(dir.path(), "paint", &["paint"]);
    let version = succeed(dir.path(), "--version");
    assert!(version.stdout.starts_with("utm-sky "));
}

#[test]
fn the_profile_is_printed_and_written() {
    let dir = tempdir().unwrap();
    let printed = succeed(dir.path(), "profile --out profile.csv").stdout;
    assert!(printed.contains("1013.2"), "{printed}");
    let (header, rows) = read(&dir.path().join("profile.csv"));
    for column in [
        "altitude_km",
        "pressure_hpa",
        "temperature_k",
        "ozone_effective_temperature_k",
        "relative_humidity_percent",
        "air_number_density_per_m3",
        "ozone_number_density_per_m3",
        "no2_number_density_per_m3",
        "water_number_density_per_m3",
        "o2_path_km",
        "co2_path_km",
    ] {
        assert!(header.split(',').any(|c| c == column), "{column}");
    }
    assert_eq!(rows.len(), 101);
    close(rows[0][0], 0.0, 0.0);
    close(rows[100][0], 100.0, 0.0);
    close(rows[0][1], 1013.25, 0.01);
    // T_eo = 142.68 + 0.28498 T at 288.15 K.
    close(rows[0][3], 224.797, 0.01);
    assert_eq!(succeed(dir.path(), "profile").stdout, printed);
}

#[test]
fn a_profile_of_one_s_own_is_taken_in_any_column_order() {
    let dir = tempdir().unwrap();
    let mut text = String::from(
        "# my atmosphere\npressure_hpa,ozone_number_density_per_m3,altitude_km,temperature_k\n",
    );
    for km in (0..=40_u8).step_by(2) {
        let z = f64::from(km);
        text += &format!("{},{},{z},250\n", 1000.0 * (-z / 8.0).exp(), 1e18);
    }
    fs::write(dir.path().join("own.csv"), text).unwrap();
    let printed = succeed(dir.path(), "profile --profile own.csv").stdout;
    assert!(printed.contains("own.csv"), "{printed}");
    assert!(printed.contains("1000.0"), "{printed}");
}

#[test]
fn every_shipped_profile_can_be_named() {
    let dir = tempdir().unwrap();
    for name in ["general", "utm2005", "tropical", "subarctic_winter"] {
        let printed = succeed(dir.path(), &format!("profile --profile {name}")).stdout;
        assert!(
            printed.contains(&format!("profiles/{name}.csv")),
            "{printed}"
        );
    }
}

#[test]
fn optics_written_and_read_back_give_the_same_sky() {
    let dir = tempdir().unwrap();
    fs::write(
        dir.path().join("dirs.csv"),
        "view_zenith_deg,relative_azimuth_deg\n0,0\n75,30\n89,180\n120,90\n",
    )
    .unwrap();
    let scene = "map --altitude-km 3 --sun-zenith-deg 60 --albedo 0.3 --directions dirs.csv";
    let air = "--turbidity 2 --wavelength-step-nm 20";
    succeed(
        dir.path(),
        &format!("optics {air} --out o.csv --solar s.csv"),
    );
    succeed(dir.path(), &format!("{scene} {air} --out direct.csv"));
    succeed(
        dir.path(),
        &format!("{scene} --optics o.csv --solar s.csv --out again.csv"),
    );
    let direct = read(&dir.path().join("direct.csv")).1;
    let again = read(&dir.path().join("again.csv")).1;
    assert_eq!(direct.len(), 4 * 21);
    assert_eq!(again.len(), direct.len());
    for (a, b) in again.iter().zip(&direct) {
        assert_eq!(format!("{:?}", &a[..3]), format!("{:?}", &b[..3]));
        // Eight digits of the solar spectrum and the radiance.
        close(a[3] / b[3], 1.0, 1e-6);
    }
}

#[test]
fn optics_come_in_long_format_with_their_sun() {
    let dir = tempdir().unwrap();
    succeed(
        dir.path(),
        "optics --aod500 0.5 --wavelength-step-nm 20 --out optics.csv --solar solar.csv",
    );
    let (header, rows) = read(&dir.path().join("optics.csv"));
    assert_eq!(
        header,
        "altitude_km,wavelength_nm,rayleigh_scattering_per_km,gas_absorption_per_km,\
         aerosol_scattering_per_km,aerosol_absorption_per_km,aerosol_g,aerosol_g2,aerosol_g_weight"
    );
    let mut optical_depth_500 = 0.0;
    let at_500: Vec<&Vec<f64>> = rows
        .iter()
        .filter(|r| (r[1] - 500.0).abs() < 1e-9)
        .collect();
    for pair in at_500.windows(2) {
        let mean = 0.5 * (pair[0][4] + pair[0][5] + pair[1][4] + pair[1][5]);
        optical_depth_500 += mean * (pair[1][0] - pair[0][0]);
    }
    close(optical_depth_500, 0.5, 5e-4);
    close(at_500[0][0], 0.0, 0.0);
    close(at_500[at_500.len() - 1][0], 100.0, 0.0);
    let (header, sun) = read(&dir.path().join("solar.csv"));
    assert_eq!(header, "wavelength_nm,irradiance_w_m2_nm");
    assert_eq!(sun.len(), 21);
    // Extraterrestrial irradiance between 380 and 780 nm, ASTM G173: 657 W/m2.
    let total: f64 = sun.iter().map(|r| 20.0 * r[1]).sum();
    close(total / 657.0, 1.0, 0.05);
}

#[test]
fn the_same_haze_in_four_ways_gives_the_same_optics() {
    let dir = tempdir().unwrap();
    for (name, haze) in [("a.csv", "--turbidity 2"), ("b.csv", "--aod500 0.14344")] {
        succeed(
            dir.path(),
            &format!("optics {haze} --wavelength-step-nm 20 --out {name}"),
        );
    }
    for (a, b) in read(&dir.path().join("a.csv"))
        .1
        .iter()
        .flatten()
        .zip(read(&dir.path().join("b.csv")).1.iter().flatten())
    {
        close(*a, *b, 1e-12 * b.abs().max(1e-9));
    }
    // Angstrom with alpha 1.3: tau(500) = beta 0.5^-1.3, tau(400)/tau(500) = (4/5)^-1.3.
    succeed(
        dir.path(),
        "optics --angstrom-beta 0.1 --angstrom-alpha 1.3 --wavelength-step-nm 20 --out c.csv",
    );
    let depth = |nm: f64| {
        let rows = read(&dir.path().join("c.csv")).1;
        let at: Vec<Vec<f64>> = rows
            .into_iter()
            .filter(|r| (r[1] - nm).abs() < 1e-9)
            .collect();
        at.windows(2)
            .map(|p| 0.5 * (p[0][4] + p[0][5] + p[1][4] + p[1][5]) * (p[1][0] - p[0][0]))
            .sum::<f64>()
    };
    close(depth(500.0), 0.1 * 0.5_f64.powf(-1.3), 3e-4);
    close(depth(400.0) / depth(500.0), 0.8_f64.powf(-1.3), 1e-3);
}

#[test]
fn constituents_are_switched_one_by_one() {
    let dir = tempdir().unwrap();
    let sums = |list: &str| -> [f64; 3] {
        succeed(
            dir.path(),
            &format!(
                "optics --aod500 0.2 --constituents {list} --wavelength-step-nm 20 --out o.csv"
            ),
        );
        let rows = read(&dir.path().join("o.csv")).1;
        [2, 3, 4].map(|column| rows.iter().map(|r| r[column]).sum())
    };
    let [rayleigh, gas, aerosol] = sums("rayleigh");
    assert!(rayleigh > 0.0 && gas == 0.0 && aerosol == 0.0);
    let mut last = 0.0;
    for list in [
        "ozone",
        "ozone,no2",
        "ozone,no2,o2o2",
        "ozone,no2,o2o2,o2",
        "ozone,no2,o2o2,o2,h2o",
    ] {
        let [rayleigh, gas, aerosol] = sums(list);
        assert!(rayleigh == 0.0 && aerosol == 0.0, "{list}");
        assert!(gas > last, "{list}");
        last = gas;
    }
    let [rayleigh, gas, aerosol] = sums("aerosol,stratosphere");
    assert!(rayleigh == 0.0 && gas == 0.0 && aerosol > 0.0);
}

#[test]
fn a_map_has_one_row_per_direction_and_wavelength_in_the_file_s_order() {
    let dir = tempdir().unwrap();
    fs::write(
        dir.path().join("dirs.csv"),
        "name,relative_azimuth_deg,view_zenith_deg\nb,180,60.5\na,0,10\n",
    )
    .unwrap();
    let common = "map --altitude-km 3 --aod500 0.1 --sun-zenith-deg 60 --engine smarts";
    succeed(
        dir.path(),
        &format!("{common} --directions dirs.csv --out map.csv"),
    );
    let (header, rows) = read(&dir.path().join("map.csv"));
    assert_eq!(
        header,
        "view_zenith_deg,relative_azimuth_deg,wavelength_nm,radiance_w_m2_sr_nm"
    );
    assert_eq!(rows.len(), 2 * 41);
    assert_eq!(format!("{:?}", &rows[0][..3]), "[60.5, 180.0, 380.0]");
    assert_eq!(format!("{:?}", &rows[81][..3]), "[10.0, 0.0, 780.0]");
    assert!(rows.iter().all(|r| r[3] > 0.0 && r[3] < 1.0));

    succeed(dir.path(), &format!("{common} --yxy --out yxy.csv"));
    let (header, rows) = read(&dir.path().join("yxy.csv"));
    assert_eq!(
        header,
        "view_zenith_deg,relative_azimuth_deg,luminance_cd_m2,x,y"
    );
    assert_eq!(rows.len(), 271);
    // A clear sky: hundreds to ten thousands of cd/m2, bluish to white, bright towards the sun.
    assert!(rows.iter().all(|r| r[2] > 100.0 && r[2] < 3e5));
    assert!(
        rows.iter()
            .all(|r| r[3] > 0.2 && r[3] < 0.45 && r[4] > 0.2 && r[4] < 0.45)
    );
    let at: BTreeMap<String, f64> = rows
        .iter()
        .map(|r| (format!("{} {}", r[0], r[1]), r[2]))
        .collect();
    assert!(at["60 0"] > 2.0 * at["60 180"]);
}

#[test]
fn the_colors_of_a_map_are_those_of_its_spectra() {
    let dir = tempdir().unwrap();
    let common = "map --altitude-km 0 --aod500 0.1 --sun-zenith-deg 45 --engine smarts \
                  --wavelength-step-nm 5";
    succeed(dir.path(), &format!("{common} --out map.csv"));
    succeed(dir.path(), &format!("{common} --yxy --out yxy.csv"));
    let spectra = read(&dir.path().join("map.csv")).1;
    let colors = read(&dir.path().join("yxy.csv")).1;
    let wavelength_nm: Vec<f64> = spectra[..81].iter().map(|r| r[2]).collect();
    let weights = sky_science::cie::ColorWeights::for_spectral_radiance(&wavelength_nm).unwrap();
    for (spectrum, color) in spectra.chunks_exact(81).zip(&colors) {
        let radiance: Vec<f64> = spectrum.iter().map(|r| r[3]).collect();
        let yxy = weights.yxy(&radiance);
        // Band means on 5 nm against the product with the 1 nm sun: they differ little.
        close(color[2] / yxy.luminance_cd_m2, 1.0, 1e-3);
        close(color[3], yxy.x, 5e-4);
        close(color[4], yxy.y, 5e-4);
    }
}

#[test]
fn the_beam_is_brighter_aloft_and_gone_behind_the_earth() {
    let dir = tempdir().unwrap();
    let beam = |options: &str| {
        succeed(
            dir.path(),
            &format!("beam --aod500 0.1 {options} --out b.csv"),
        );
        let (header, rows) = read(&dir.path().join("b.csv"));
        assert_eq!(header, "wavelength_nm,irradiance_w_m2_nm");
        assert_eq!(rows.len(), 401);
        rows.iter().map(|r| r[1]).sum::<f64>()
    };
    let ground = beam("--altitude-km 0 --sun-zenith-deg 60");
    let aloft = beam("--altitude-km 12 --sun-zenith-deg 60");
    assert!(aloft > 1.1 * ground && aloft < 657.1);
    assert!(beam("--altitude-km 0 --sun-zenith-deg 60 --water-cm 5") < ground);
    assert!(beam("--altitude-km 0 --sun-zenith-deg 60 --ozone-atm-cm 0.6") < ground);
    assert!(beam("--altitude-km 0 --sun-zenith-deg 60 --pressure-hpa 800") > ground);
    close(beam("--altitude-km 0 --sun-zenith-deg 95"), 0.0, 0.0);
}

#[test]
fn the_same_command_writes_the_same_bytes() {
    let dir = tempdir().unwrap();
    for name in ["a.csv", "b.csv"] {
        succeed(
            dir.path(),
            &format!(
                "map --altitude-km 6 --turbidity 3 --sun-zenith-deg 80 --engine smarts --out {name}"
            ),
        );
    }
    let bytes = |name| fs::read(dir.path().join(name)).unwrap();
    assert!(bytes("a.csv") == bytes("b.csv"));
    assert_eq!(names(dir.path()), ["a.csv", "b.csv"]);
}
