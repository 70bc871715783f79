//! Faults that were found by using the program, each by the name of what broke. Letters and numbers are
//! those of the list that they were kept in.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::support::{Outcome, names, refuse, run, succeed, utm_sky};
use tempfile::tempdir;

const PLACE: &str = "--altitude-km 1 --turbidity 2 --sun-zenith-deg 60";

/// The examples of a command's help.
fn examples(directory: &Path, command: &str) -> Vec<String> {
    let help = succeed(directory, &format!("{command} --help")).stdout;
    let (_, examples) = help.split_once("Example").expect("examples");
    let joined = examples.replace("\\\n", " ");
    let lines = joined.lines().map(str::trim);
    lines
        .filter_map(|line| line.strip_prefix("utm-sky "))
        .map(str::to_owned)
        .collect()
}

#[test]
fn c_examples_run_as_they_stand() {
    // the others take minutes, a GPU or a window
    for command in [
        "profile",
        "optics",
        "beam",
        "sky",
        "segment",
        "light",
        "models",
        "export-shaders",
        "lut",
        "lut info",
        "lut export",
    ] {
        let dir = tempdir().unwrap();
        let all = examples(dir.path(), command);
        assert!(!all.is_empty(), "{command}");
        for line in all {
            succeed(dir.path(), &line);
        }
    }
}

#[test]
fn c_examples_name_no_file_that_does_not_ship() {
    let dir = tempdir().unwrap();
    for command in [
        "",
        "profile",
        "optics",
        "map",
        "beam",
        "sky",
        "segment",
        "render",
        "view",
        "gallery",
        "chart",
        "models",
        "light",
        "bench-gpu",
        "export-shaders",
        "generate",
        "plan",
        "report",
        "atlas",
        "fit-stress",
        "lut",
        "lut info",
        "lut export",
    ] {
        let mut written = Vec::new();
        for line in examples(dir.path(), command) {
            let words: Vec<&str> = line.split_whitespace().collect();
            for pair in words.windows(2) {
                let is_output = ["--out", "--solar", "--screenshot"].contains(&pair[0]);
                if is_output {
                    written.push(pair[1].to_owned());
                }
                let is_file = [".csv", ".toml", ".utmlut"]
                    .iter()
                    .any(|e| pair[1].ends_with(e));
                assert!(
                    !is_file || written.iter().any(|file| file == pair[1]),
                    "{line}: {} neither ships nor was written",
                    pair[1]
                );
            }
        }
    }
}

#[test]
fn c_an_elevation_of_the_sun_is_not_taken_for_a_zenith_angle() {
    let dir = tempdir().unwrap();
    let zenith = succeed(dir.path(), &format!("light {PLACE}")).stdout;
    let place = PLACE.replace("--sun-zenith-deg 60", "--sun-elevation-deg 30");
    assert_eq!(
        succeed(dir.path(), &format!("light {place}")).stdout,
        zenith
    );
    for command in [
        "beam --out o.csv",
        "map --engine smarts --yxy --out o.csv",
        "sky --out o.csv",
    ] {
        succeed(dir.path(), &format!("{command} {place}"));
    }
    let low = PLACE.replace("--sun-zenith-deg 60", "--sun-elevation-deg -5.5");
    let deep = PLACE.replace("--sun-zenith-deg 60", "--sun-zenith-deg 95.5");
    assert_eq!(
        succeed(dir.path(), &format!("light {low}")).stdout,
        succeed(dir.path(), &format!("light {deep}")).stdout
    );
    refuse(
        dir.path(),
        &format!("light {PLACE} --sun-elevation-deg 30"),
        &["--sun-elevation-deg"],
    );
    refuse(
        dir.path(),
        "light --altitude-km 1 --turbidity 2",
        &["--sun-zenith-deg"],
    );
}

#[test]
fn c_what_has_no_effect_is_refused() {
    let dir = tempdir().unwrap();
    let render = format!("render {PLACE} --backend cpu --size 16x8");
    for (line, words) in [
        (
            format!("{render} --projection fisheye --fov-deg 90 --out p.png"),
            ["--fov-deg", "perspective"],
        ),
        (
            format!("{render} --projection equirect --look 10,20 --out p.png"),
            ["--look", "20"],
        ),
        (
            format!("{render} --tier vertex --out p.png"),
            ["--tier", "--backend cpu"],
        ),
        (
            format!("{render} --tier baked --out p.png"),
            ["--tier", "--backend cpu"],
        ),
        (
            format!("{render} --ev100 12 --out p.exr"),
            ["--ev100", "exr"],
        ),
        (
            format!("{render} --tone aces --out p.exr"),
            ["--tone", "exr"],
        ),
        (
            format!("map --model hosek {PLACE} --yxy --scale-height-km 2 --out o.csv"),
            ["--scale-height-km", "--model"],
        ),
    ] {
        refuse(dir.path(), &line, &words);
    }
    assert!(names(dir.path()).is_empty());
    succeed(dir.path(), &format!("{render} --tier fragment --out p.png"));
    succeed(
        dir.path(),
        &format!("{render} --projection equirect --look 10,0 --out e.png"),
    );
}

#[test]
fn c_a_hyphen_is_standard_output() {
    let dir = tempdir().unwrap();
    let csv = format!("sky {PLACE} --out");
    succeed(dir.path(), &format!("{csv} sky.csv"));
    let said = succeed(dir.path(), &format!("{csv} -")).stdout;
    assert_eq!(
        said,
        fs::read_to_string(dir.path().join("sky.csv")).unwrap()
    );
    // nothing else is printed then
    let profile = succeed(dir.path(), "profile --out -").stdout;
    assert!(profile.starts_with("altitude_km,"), "{profile}");
    let picture = utm_sky()
        .args(format!("render {PLACE} --backend cpu --size 16x8 --out -").split_whitespace())
        .output()
        .unwrap();
    assert!(picture.status.success() && picture.stdout.starts_with(b"\x89PNG"));
    refuse(
        dir.path(),
        "export-shaders --target glsl --out -",
        &["directory", "-"],
    );
    assert_eq!(names(dir.path()), ["sky.csv"]);
}

#[test]
fn c_an_extension_may_be_in_capitals() {
    let dir = tempdir().unwrap();
    for name in ["A.PNG", "b.Exr"] {
        succeed(
            dir.path(),
            &format!("render {PLACE} --backend cpu --size 16x8 --out {name}"),
        );
    }
    assert!(
        fs::read(dir.path().join("A.PNG"))
            .unwrap()
            .starts_with(b"\x89PNG")
    );
    refuse(
        dir.path(),
        &format!("render {PLACE} --backend cpu --size 16x8 --out c.jpg"),
        &[".png", "c.jpg"],
    );
}

#[test]
fn c_shipped_names_are_listed() {
    let dir = tempdir().unwrap();
    let listed = succeed(dir.path(), "profile --list").stdout;
    let names: Vec<&str> = listed.lines().collect();
    assert_eq!(
        names,
        ["general", "utm2005", "tropical", "subarctic_winter"]
    );
    for command in ["profile", "optics", "map", "beam", "generate"] {
        let help = succeed(dir.path(), &format!("{command} --help")).stdout;
        for name in &names {
            assert!(help.contains(name), "{command}: {name}");
        }
    }
    for name in names {
        succeed(dir.path(), &format!("profile --profile {name}"));
    }
    // the scenes of the repository are those of the program
    let help = succeed(dir.path(), "plan --help").stdout;
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../profiles/scenes");
    let mut count = 0;
    for entry in fs::read_dir(scenes).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|e| e == "toml") {
            let name = path.file_stem().unwrap().to_string_lossy().into_owned();
            assert!(help.contains(&name), "{name}");
            sky_cli::io::plan::load_scene(Path::new(&name)).unwrap();
            count += 1;
        }
    }
    assert_eq!(count, sky_profiles::SCENES.len());
}

#[test]
fn c_semicolons_are_called_semicolons() {
    let dir = tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(dir.path().join(name), text).unwrap();
    write(
        "d.csv",
        "# a comment\nview_zenith_deg;relative_azimuth_deg\n0;0\n",
    );
    write("p.csv", "altitude_km;pressure_hpa\n0;1013\n");
    for (line, file) in [
        (
            format!("sky {PLACE} --directions d.csv --out o.csv"),
            "d.csv:2",
        ),
        (
            format!("segment {PLACE} --segments d.csv --out o.csv"),
            "d.csv:2",
        ),
        ("profile --profile p.csv".to_owned(), "p.csv:1"),
    ] {
        refuse(dir.path(), &line, &[file, "expected commas", "semicolons"]);
    }
}

#[test]
fn c_a_direction_is_told_with_its_line() {
    let dir = tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(dir.path().join(name), text).unwrap();
    write(
        "d.csv",
        "# two\nview_zenith_deg,relative_azimuth_deg\n0,0\n99,0\n",
    );
    write(
        "s.csv",
        "view_zenith_deg,relative_azimuth_deg,distance_km\n90,0,5\n180,0,5\n",
    );
    refuse(
        dir.path(),
        &format!("sky {PLACE} --directions d.csv --out o.csv"),
        &["d.csv:4: direction 2", "99"],
    );
    refuse(
        dir.path(),
        "sky --model hosek --altitude-km 0 --turbidity 2 --sun-zenith-deg 60 --directions d.csv --out o.csv",
        &["d.csv:4: direction 2", "hosek"],
    );
    refuse(
        dir.path(),
        &format!("segment {PLACE} --segments s.csv --out o.csv"),
        &["s.csv:3: path 2", "above the ground"],
    );
    // one by one
    refuse(
        dir.path(),
        &format!("sky {PLACE} --direction 0,0 --direction 99,0 --out o.csv"),
        &["direction 2", "99"],
    );
    refuse(
        dir.path(),
        &format!("sky {PLACE} --direction 0 --out o.csv"),
        &["view_zenith_deg"],
    );
    let one = succeed(
        dir.path(),
        &format!("sky {PLACE} --direction 45,90 --out -"),
    )
    .stdout;
    assert!(one.lines().nth(1).unwrap().starts_with("45,90,"), "{one}");
}

#[test]
fn c_a_scene_given_as_a_plan_is_called_one() {
    let dir = tempdir().unwrap();
    let scene = "altitude_km = 0.1\nsun_zenith_deg = [30.0, 40.0]\nfarthest_object_km = 10.0\n\
                 [haze]\nturbidity = 2.0\n[view]\npixels = 1000\n\
                 [tolerance]\ndelta_e = 1.0\nluminance = 0.05\n";
    fs::write(dir.path().join("scene.toml"), scene).unwrap();
    for line in [
        "plan --verify scene.toml".to_owned(),
        "generate --plan scene.toml --out out".to_owned(),
        format!("sky {PLACE} --lut scene.toml --out o.csv"),
    ] {
        refuse(
            dir.path(),
            &line,
            &["scene.toml: expected a plan, found a scene", "utm-sky plan"],
        );
    }
    assert_eq!(
        names(dir.path()),
        ["scene.toml"],
        "no empty directory either"
    );
}

#[test]
fn c_lut_export_says_out_as_the_rest_does() {
    let dir = tempdir().unwrap();
    succeed(dir.path(), "lut export embedded --out new.csv");
    succeed(dir.path(), "lut export embedded --csv old.csv");
    let [new, old] = ["new.csv", "old.csv"].map(|name| fs::read(dir.path().join(name)).unwrap());
    assert_eq!(new, old);
    let help = succeed(dir.path(), "lut export --help").stdout;
    assert!(help.contains("--out") && !help.contains("--csv"), "{help}");
}

/// Needs a Vulkan driver.
#[test]
fn c_a_driver_s_complaint_is_not_passed_on() {
    let dir = tempdir().unwrap();
    let outcome: Outcome = utm_sky()
        .current_dir(dir.path())
        .env_remove("XDG_RUNTIME_DIR")
        .args(format!("render {PLACE} --size 16x8 --out p.png").split_whitespace())
        .output()
        .unwrap()
        .into();
    assert_eq!((outcome.code, outcome.stderr.as_str()), (Some(0), ""));
    assert_eq!(names(dir.path()), ["p.png"]);
}

#[cfg(unix)]
#[test]
fn c_an_interrupted_run_leaves_no_empty_directory() {
    let dir = tempdir().unwrap();
    let out = dir.path().join("a/b");
    let child = utm_sky()
        .current_dir(dir.path())
        .args("generate --grid seed --out a/b".split(' '))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let start = Instant::now();
    while !out.is_dir() || names(&out).is_empty() {
        assert!(
            start.elapsed() < Duration::from_secs(60),
            "no directory came"
        );
        sleep(Duration::from_millis(5));
    }
    let sent = Command::new("sh")
        .arg("-c")
        .arg(format!("kill -INT {}", child.id()))
        .status()
        .unwrap();
    assert!(sent.success());
    let outcome: Outcome = child.wait_with_output().unwrap().into();
    assert_eq!(outcome.code, Some(2), "{outcome:?}");
    assert!(names(dir.path()).is_empty(), "{:?}", names(dir.path()));
    // nor one that fails; what was there stays
    fs::create_dir(dir.path().join("kept")).unwrap();
    fs::write(dir.path().join("bad.toml"), "altitude_km = 1\n").unwrap();
    for line in [
        "export-shaders --target glsl --lut bad.toml --out new",
        "fit-stress --out bad.toml/x",
    ] {
        assert_eq!(run(dir.path(), line).code, Some(2), "{line}");
    }
    assert_eq!(names(dir.path()), ["bad.toml", "kept"]);
}

/// Attributes of an EXR and text of a PNG stand in the file as they are.
fn says(path: &Path, words: &str) -> bool {
    let bytes = fs::read(path).expect("a file");
    bytes
        .windows(words.len())
        .any(|part| part == words.as_bytes())
}

#[test]
fn a7_a_file_without_the_sun_says_so() {
    let dir = tempdir().unwrap();
    let render = format!("render {PLACE} --backend cpu --size 64x32 --projection equirect");
    for name in ["without.exr", "without.png"] {
        succeed(dir.path(), &format!("{render} --no-sun --out {name}"));
        assert!(
            says(&dir.path().join(name), "The sun's disc is left out."),
            "{name}"
        );
    }
    succeed(dir.path(), &format!("{render} --out with.exr"));
    assert!(says(&dir.path().join("with.exr"), "spread over the pixels"));
    // the brightest pixel is the sun, and is gone without it
    let [with, without] = ["with.exr", "without.exr"].map(|name| {
        let picture = image::open(dir.path().join(name)).unwrap().to_rgb32f();
        picture.pixels().map(|p| p.0[1]).fold(0.0_f32, f32::max)
    });
    assert!(with > 10.0 * without, "{with} {without}");
}

#[test]
fn a7_the_gpu_s_panorama_holds_the_sun_too() {
    let dir = tempdir().unwrap();
    let mut light: BTreeMap<&str, f64> = BTreeMap::new();
    for backend in ["cpu", "gpu"] {
        let name = format!("{backend}.exr");
        succeed(
            dir.path(),
            &format!(
                "render {PLACE} --backend {backend} --size 96x48 --projection equirect --out {name}"
            ),
        );
        let picture = image::open(dir.path().join(&name)).unwrap().to_rgb32f();
        let sum = picture.enumerate_pixels().map(|(_, y, p)| {
            let zenith = (f64::from(y) + 0.5) / 48.0 * core::f64::consts::PI;
            f64::from(p.0[1]) * zenith.sin() * zenith.cos().max(0.0)
        });
        light.insert(backend, sum.sum());
    }
    let ratio = light["gpu"] / light["cpu"];
    assert!((ratio - 1.0).abs() < 0.01, "{ratio}");
}

#[test]
fn b4_the_exit_status_tells_what_happened() {
    let dir = tempdir().unwrap();
    let help = succeed(dir.path(), "--help").stdout;
    for words in [
        "0 on success",
        "1 where a verdict is \"not met\"",
        "2 on bad",
    ] {
        assert!(help.contains(words), "{words}: {help}");
    }
    assert_eq!(run(dir.path(), "plan --verify none.toml").code, Some(2));
}

/// The window stays closed: what it would draw is refused before it opens.
#[test]
fn a10_a_sun_beyond_the_domain_is_refused_where_nobody_watches() {
    let dir = tempdir().unwrap();
    let view = |line: &str| -> Outcome {
        Command::new(env!("CARGO_BIN_EXE_utm-sky-under-test-view"))
            .current_dir(dir.path())
            .env_remove("DISPLAY")
            .env_remove("WAYLAND_DISPLAY")
            .args(line.split_whitespace())
            .output()
            .unwrap()
            .into()
    };
    let svalbard = view("--date 2025-12-21 --utc-h 11 --place 78.22,15.65 --screenshot p.png");
    assert_eq!(svalbard.code, Some(2), "{svalbard:?}");
    assert!(
        svalbard.stderr.contains("sun zenith [deg]: 101.6"),
        "{svalbard:?}"
    );
    assert!(svalbard.stderr.contains("outside 0..96"), "{svalbard:?}");
    let haze = view("--visual-range-km 1 --screenshot p.png");
    assert_eq!(haze.code, Some(2));
    assert!(
        haze.stderr.contains("visual range [km]: 1 is outside"),
        "{haze:?}"
    );
    assert!(names(dir.path()).is_empty());
}
