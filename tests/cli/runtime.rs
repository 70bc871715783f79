//! The contracts of the runtime's commands: segment, light, render, export-shaders, models, chart.

use std::fs;

use crate::support::{names, refuse, succeed};
use tempfile::tempdir;

#[test]
fn segments_have_their_columns_and_bounds() {
    let dir = tempdir().unwrap();
    let segments = "view_zenith_deg,relative_azimuth_deg,distance_km\n60,30,5\n90,90,40\n95,0,10\n";
    fs::write(dir.path().join("seg.csv"), segments).unwrap();
    for aerial in ["default", "utm2005"] {
        succeed(
            dir.path(),
            &format!(
                "segment --altitude-km 3 --turbidity 2 --sun-zenith-deg 60 --segments seg.csv --out out.csv --aerial {aerial}"
            ),
        );
        let text = fs::read_to_string(dir.path().join("out.csv")).unwrap();
        let mut lines = text.lines();
        assert_eq!(
            lines.next(),
            Some(
                "view_zenith_deg,relative_azimuth_deg,distance_km,transmittance_r,transmittance_g,\
                 transmittance_b,transmittance_y,inscatter_luminance_cd_m2,inscatter_x,inscatter_y"
            )
        );
        for line in lines {
            let v: Vec<f64> = line.split(',').map(|c| c.parse().unwrap()).collect();
            assert_eq!(v.len(), 10, "{line}");
            assert!(v[3..7].iter().all(|t| (0.0..1.0).contains(t)), "{line}");
            assert!(v[7] > 0.0 && v[8] > 0.0 && v[9] > 0.0, "{line}");
        }
    }
    // five kilometers up, a ray straight down meets the ground
    fs::write(
        dir.path().join("down.csv"),
        "view_zenith_deg,relative_azimuth_deg,distance_km\n180,0,9\n",
    )
    .unwrap();
    refuse(
        dir.path(),
        "segment --altitude-km 5 --turbidity 2 --sun-zenith-deg 60 --segments down.csv --out bad.csv",
        &["down.csv", "above the ground", "9"],
    );
    assert_eq!(names(dir.path()), ["down.csv", "out.csv", "seg.csv"]);
}

#[test]
fn the_engine_answers_for_paths_anywhere() {
    let dir = tempdir().unwrap();
    let write = |name: &str, rows: &str| {
        let head = "view_zenith_deg,relative_azimuth_deg,distance_km\n";
        fs::write(dir.path().join(name), format!("{head}{rows}")).unwrap();
    };
    write("seg.csv", "60,30,5\n90.5,90,30\n92,0,60\n93,0,300\n");
    let rows = |words: &str| -> Vec<Vec<f64>> {
        let line = format!("segment --turbidity 2 --segments seg.csv --out out.csv {words}");
        succeed(dir.path(), &line);
        let text = fs::read_to_string(dir.path().join("out.csv")).unwrap();
        text.lines()
            .skip(1)
            .map(|line| line.split(',').map(|c| c.parse().unwrap()).collect())
            .collect()
    };
    // a table and its truth, within what the table is off
    let place = "--altitude-km 9 --sun-zenith-deg 60";
    let (table, truth) = (rows(place), rows(&format!("{place} --engine transport")));
    for (table, truth) in table.iter().zip(&truth) {
        for (i, limit) in [(6, 0.02), (7, 0.15)] {
            assert!(
                (table[i] / truth[i] - 1.0).abs() < limit,
                "{table:?} {truth:?}"
            );
        }
    }
    // snow below lights the air
    let snow = rows(&format!("{place} --engine transport --albedo 0.8"));
    for (gray, white) in truth.iter().zip(&snow) {
        assert!(white[7] > 1.05 * gray[7], "{gray:?} {white:?}");
        assert!((white[6] - gray[6]).abs() < 1e-9, "{gray:?} {white:?}");
    }
    // below the sea, above the table, and into the night
    for (rows_asked, words) in [
        (
            "85,10,4\n90,10,4\n",
            "--altitude-km -0.4 --sun-zenith-deg 20",
        ),
        ("96,10,600\n", "--altitude-km 80 --sun-zenith-deg 100"),
    ] {
        write("seg.csv", rows_asked);
        for row in rows(&format!("{words} --engine transport")) {
            assert!(
                row[7] > 0.0 && row[3..7].iter().all(|t| (0.0..=1.0).contains(t)),
                "{row:?}"
            );
        }
    }
    write("down.csv", "95,0,20\n180,0,9\n");
    for (line, words) in [
        (
            "segment --altitude-km 5 --sun-zenith-deg 60 --engine transport --segments down.csv",
            ["down.csv", "path 2"],
        ),
        (
            "segment --altitude-km 5 --sun-zenith-deg 60 --albedo 0.5 --segments seg.csv",
            ["--albedo", "--engine transport"],
        ),
        (
            "segment --altitude-km 40 --sun-zenith-deg 60 --segments seg.csv",
            ["altitude", "40"],
        ),
        (
            "segment --altitude-km 4 --sun-zenith-deg 60 --engine transport --aerial utm2005 \
             --segments seg.csv",
            ["--aerial", "--engine table"],
        ),
    ] {
        refuse(
            dir.path(),
            &format!("{line} --turbidity 2 --out bad.csv"),
            &words,
        );
    }
    assert_eq!(names(dir.path()), ["down.csv", "out.csv", "seg.csv"]);
}

#[test]
fn maps_answer_for_the_whole_sphere_from_below_the_sea_to_the_top_of_the_air() {
    let dir = tempdir().unwrap();
    let everywhere: String = (0..=18)
        .flat_map(|z| [0, 90, 180].map(|a| format!("{},{a}\n", 10 * z)))
        .collect();
    fs::write(
        dir.path().join("where.csv"),
        format!("view_zenith_deg,relative_azimuth_deg\n{everywhere}"),
    )
    .unwrap();
    for (altitude, sun) in [("-0.5", "60"), ("0", "92"), ("50", "30"), ("100", "60")] {
        succeed(
            dir.path(),
            &format!(
                "map --altitude-km {altitude} --turbidity 2 --sun-zenith-deg {sun} --yxy \
                 --directions where.csv --out map.csv"
            ),
        );
        let text = fs::read_to_string(dir.path().join("map.csv")).unwrap();
        let luminance: Vec<f64> = text
            .lines()
            .skip(1)
            .map(|line| line.split(',').nth(2).unwrap().parse().unwrap())
            .collect();
        assert_eq!(luminance.len(), 57);
        // the ground has light of its own; above the top of the air there is none
        assert!(luminance[54..].iter().all(|y| *y > 0.0), "{altitude}");
        let above = if altitude == "100" {
            0.0..=0.0
        } else {
            1e-9..=1e9
        };
        assert!(
            luminance[..27].iter().all(|y| above.contains(y)),
            "{altitude}"
        );
    }
}

#[test]
fn light_is_json_and_the_sun_outshines_the_sky_by_day() {
    let dir = tempdir().unwrap();
    let out = succeed(
        dir.path(),
        "light --altitude-km 3 --turbidity 2 --sun-zenith-deg 40",
    );
    let json: serde_json::Value = serde_json::from_str(&out.stdout).unwrap();
    let sun = json["sun_direct_normal"]["illuminance_lx"]
        .as_f64()
        .unwrap();
    let sky = json["sky_horizontal"]["illuminance_lx"].as_f64().unwrap();
    assert!((80e3..130e3).contains(&sun), "{sun}");
    assert!((4e3..40e3).contains(&sky), "{sky}");
    let harmonics = json["sky_harmonics_cd_m2"]["linear_srgb"]
        .as_array()
        .unwrap();
    assert_eq!(harmonics.len(), 9);
}

#[test]
fn pictures_without_a_gpu() {
    let dir = tempdir().unwrap();
    for (projection, name) in [
        ("perspective", "p.png"),
        ("fisheye", "f.png"),
        ("equirect", "e.exr"),
    ] {
        succeed(
            dir.path(),
            &format!(
                "render --altitude-km 1 --turbidity 2 --sun-zenith-deg 60 --backend cpu --size 48x32 --projection {projection} --out {name}"
            ),
        );
    }
    let png = fs::read(dir.path().join("p.png")).unwrap();
    assert_eq!(&png[1..4], b"PNG");
    let exr = fs::read(dir.path().join("e.exr")).unwrap();
    assert_eq!(exr[..4], [0x76, 0x2f, 0x31, 0x01]);
    let wrong = "render --altitude-km 1 --turbidity 2 --sun-zenith-deg 60 --backend cpu";
    refuse(
        dir.path(),
        &format!("{wrong} --size 0x10 --out x.png"),
        &["WIDTHxHEIGHT", "0x10"],
    );
    refuse(
        dir.path(),
        &format!("{wrong} --out x.jpg"),
        &[".png", ".exr", "x.jpg"],
    );
    refuse(
        dir.path(),
        &format!("{wrong} --lut none.utmlut --out x.png"),
        &["none.utmlut"],
    );
    refuse(
        dir.path(),
        &format!("{wrong} --out nowhere/x.png"),
        &["nowhere"],
    );
}

#[test]
fn shaders_are_exported_with_the_table() {
    let dir = tempdir().unwrap();
    for target in ["glsl", "glsl-es", "hlsl", "msl", "spirv"] {
        succeed(
            dir.path(),
            &format!("export-shaders --target {target} --out {target}"),
        );
        let files = names(&dir.path().join(target));
        assert!(
            files.iter().any(|f| f == "sky.bin") && files.iter().any(|f| f == "sky.h"),
            "{files:?}"
        );
        assert!(files.len() >= 8, "{files:?}");
    }
    let header = fs::read_to_string(dir.path().join("glsl/sky.h")).unwrap();
    assert!(header.contains("UTM_SKY_ALTITUDE_KM"));
}

#[test]
fn the_embedded_table_answers() {
    let dir = tempdir().unwrap();
    succeed(
        dir.path(),
        "sky --lut embedded --altitude-km 6 --turbidity 2 --sun-zenith-deg 60 --out yxy.csv",
    );
    succeed(dir.path(), "lut info embedded");
    let models = succeed(dir.path(), "models").stdout;
    for name in [
        "utm-sky", "utm2005", "preetham", "hosek", "hillaire", "bruneton",
    ] {
        assert!(models.contains(name), "{name}");
    }
}

#[test]
fn every_model_answers_by_name() {
    let dir = tempdir().unwrap();
    let directions = "view_zenith_deg,relative_azimuth_deg\n0,0\n60,90\n89,180\n";
    fs::write(dir.path().join("directions.csv"), directions).unwrap();
    let place = "--altitude-km 0 --turbidity 2.5 --sun-zenith-deg 60";
    let mut zeniths = Vec::new();
    for name in ["utm-sky", "preetham", "hosek", "nishita-table"] {
        let [sky, map] = ["sky", "map --yxy"].map(|command| {
            succeed(
                dir.path(),
                &format!(
                    "{command} --model {name} {place} --directions directions.csv --out sky.csv"
                ),
            );
            fs::read_to_string(dir.path().join("sky.csv")).unwrap()
        });
        assert_eq!(sky.lines().count(), 4, "{sky}");
        assert_eq!(sky, map, "{name}");
        zeniths.push(sky);
    }
    zeniths.dedup();
    assert_eq!(zeniths.len(), 4, "models that differ");
    succeed(
        dir.path(),
        &format!("render --model cie-clear {place} --size 64x36 --out sky.png"),
    );
    assert!(fs::metadata(dir.path().join("sky.png")).unwrap().len() > 200);
    // beyond its domain, unknown, without --yxy
    refuse(
        dir.path(),
        "sky --model preetham --altitude-km 5 --turbidity 2.5 --sun-zenith-deg 60 --out no.csv",
        &["altitude"],
    );
    refuse(
        dir.path(),
        &format!("sky --model blue {place} --out no.csv"),
        &["\"blue\""],
    );
    refuse(
        dir.path(),
        &format!("map --model hosek {place} --out no.csv"),
        &["--yxy"],
    );
}
