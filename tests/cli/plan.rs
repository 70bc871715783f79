//! `utm-sky plan`: scenes become the smallest tables that meet their tolerance.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use crate::support::{names, refuse, run, succeed};
use sky_cli::io::plan::load_scene;
use sky_core::conditions::Domain;
use sky_core::lut::Lut;
use sky_core::utm_sky::UtmSky;
use sky_eval::constituents::Part;
use sky_eval::profiles::NamedProfile;
use sky_gpu::Tier;
use sky_plan::scene::Scene;
use sky_plan::{Plan, Planned, PlannedTier, plan_scene, verify_plan, visibility};
use tempfile::tempdir;

fn scenes() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../profiles/scenes")
}

/// The atmosphere of the shipped scenes.
fn general() -> NamedProfile {
    NamedProfile::general().expect("a shipped profile")
}

fn shipped(name: &str) -> Scene {
    load_scene(&scenes().join(format!("{name}.toml"))).expect("a shipped scene")
}

/// The plan of the runway; several tests look at it.
fn runway() -> &'static Planned {
    static PLANNED: OnceLock<Planned> = OnceLock::new();
    PLANNED.get_or_init(|| plan_scene(&shipped("runway_noon"), &general()).expect("a plan"))
}

/// A small scene with two values that tests change.
fn small_scene(altitude: &str, tolerance: &str) -> String {
    format!(
        "{altitude}\nsun_zenith_deg = [30.0, 40.0]\nfarthest_object_km = 10.0\n\
         [haze]\nturbidity = 2.0\n[view]\npixels = 1000\n\
         [tolerance]\n{tolerance}\n"
    )
}

#[test]
fn the_shipped_scenes_are_good() {
    let mut found = 0;
    for entry in fs::read_dir(scenes()).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|e| e == "toml") {
            load_scene(&path).unwrap();
            found += 1;
        }
    }
    assert_eq!(found, 7);
}

#[test]
fn a_runway_at_noon_takes_four_kibibytes() {
    let planned = runway();
    let bytes = planned.lut.encode();
    assert!(bytes.len() <= 4096, "{}", bytes.len());
    assert_eq!(bytes.len(), planned.plan.expected.bytes);
    // on cases that the search has not seen
    let found = verify_plan(
        &planned.plan,
        &general().profile,
        planned.lut.clone(),
        200,
        77,
    )
    .unwrap();
    assert!(
        found.delta_e_p95 <= planned.plan.tolerance.delta_e,
        "{found:?}"
    );
    assert!(
        found.luminance_p95 <= planned.plan.tolerance.luminance,
        "{found:?}"
    );
    // the file is the whole of it: the same table is baked from it
    let text = toml::to_string(&planned.plan).unwrap();
    let read: Plan = toml::from_str(&text).unwrap();
    assert_eq!(read, planned.plan);
    assert_eq!(read.bake(&general()).unwrap().encode(), bytes);
}

/// Nothing can be taken away: every node and every product is needed.
fn is_minimal(planned: &Planned) {
    assert!(planned.plan.expected.delta_e_p95 <= planned.aim.delta_e);
    assert!(planned.plan.expected.luminance_p95 <= planned.aim.luminance);
    assert!(planned.removals.len() >= planned.plan.terms.len());
    for removal in &planned.removals {
        let breaks =
            removal.delta_e > planned.aim.delta_e || removal.luminance > planned.aim.luminance;
        assert!(breaks && removal.ratio > 1.0, "{removal:?}");
    }
}

#[test]
fn a_plan_has_nothing_to_spare() {
    is_minimal(runway());
    // an airliner on a day of one haze
    let text = fs::read_to_string(scenes().join("airliner_day.toml")).unwrap();
    let text = text.replace("turbidity = [1.5, 4.0]", "turbidity = 2.0");
    is_minimal(&plan_scene(&Scene::from_toml("one_haze", &text).unwrap(), &general()).unwrap());
}

#[test]
fn bad_scenes_are_told_by_field() {
    let directory = tempdir().unwrap();
    let good = "altitude_km = [0.0, 0.1]";
    let tolerance = "delta_e = 2.0\nluminance = 0.1";
    for (altitude, tolerance, words) in [
        (
            "altitude_km = [0.0, 31.0]",
            tolerance,
            ["altitude_km", "0 to 30, found 31"],
        ),
        (
            "altitude_km = [2.0, 1.0]",
            tolerance,
            ["altitude_km", "found 2 before 1"],
        ),
        (
            "altitude_km = 1.0\nheight = 2",
            tolerance,
            ["unknown field", "height"],
        ),
        (
            "ground_albedo = 0.1",
            tolerance,
            ["missing field", "altitude_km"],
        ),
        (
            "altitude_km = 1.0\nground_albedo = 1.5",
            tolerance,
            ["ground_albedo", "found 1.5"],
        ),
        (
            good,
            "delta_e = 2.0",
            ["tolerance", "expected delta_e and luminance"],
        ),
        (
            good,
            "delta_e = -1.0\nluminance = 0.1",
            ["tolerance.delta_e", "found -1"],
        ),
    ] {
        fs::write(
            directory.path().join("bad.toml"),
            small_scene(altitude, tolerance),
        )
        .unwrap();
        refuse(
            directory.path(),
            "plan bad.toml",
            &["bad.toml", words[0], words[1]],
        );
    }
    let night = small_scene(good, tolerance).replace(
        "sun_zenith_deg = [30.0, 40.0]",
        "place = { latitude_deg = 47.0, longitude_deg = 11.0, dates = [\"2025-12-21\"], hours_utc = [8.0, 20.0] }",
    );
    fs::write(directory.path().join("bad.toml"), night).unwrap();
    refuse(
        directory.path(),
        "plan bad.toml",
        &["bad.toml", "place.hours_utc", "2025-12-21"],
    );
    let twice =
        small_scene(good, tolerance).replace("turbidity = 2.0", "turbidity = 2.0\naod500 = 0.1");
    fs::write(directory.path().join("bad.toml"), twice).unwrap();
    refuse(
        directory.path(),
        "plan bad.toml",
        &["bad.toml", "haze", "one of turbidity"],
    );
    refuse(
        directory.path(),
        "plan none.toml",
        &["none.toml", "expected a file"],
    );
    assert_eq!(names(directory.path()), ["bad.toml"]);
}

#[test]
fn an_impossible_tolerance_is_refused_with_what_limits_it() {
    let directory = tempdir().unwrap();
    let scene = small_scene("altitude_km = 0.1", "delta_e = 0.01\nluminance = 0.001");
    fs::write(directory.path().join("scene.toml"), scene).unwrap();
    refuse(
        directory.path(),
        "plan scene.toml --out plan.toml",
        &[
            "scene.toml",
            "best that can be reached",
            "what limits it: the formula",
        ],
    );
    assert!(!directory.path().join("plan.toml").exists());
    let scene = small_scene(
        "altitude_km = 0.1",
        "delta_e = 4.0\nluminance = 0.3\n[budget]\nbytes = 100",
    );
    fs::write(directory.path().join("scene.toml"), scene).unwrap();
    refuse(
        directory.path(),
        "plan scene.toml --out plan.toml",
        &["scene.toml", "budget.bytes", "found 100", "what limits it"],
    );
}

#[test]
fn a_plan_is_baked_and_refuses_what_lies_outside() {
    let directory = tempdir().unwrap();
    let text = toml::to_string(&runway().plan).unwrap();
    fs::write(directory.path().join("plan.toml"), &text).unwrap();
    succeed(directory.path(), "generate --plan plan.toml --out baked");
    let bytes = fs::read(directory.path().join("baked/sky.utmlut")).unwrap();
    assert!(directory.path().join("baked/coefficients.csv").is_file());
    let lut = Lut::decode(&bytes).unwrap();
    assert_eq!(lut, runway().lut);
    assert_eq!(lut.header().domain, runway().plan.domain());
    assert_eq!(lut.header().terms, runway().plan.terms);
    let ask = "sky --lut baked/sky.utmlut --visual-range-km 40 --out sky.csv";
    succeed(
        directory.path(),
        &format!("{ask} --altitude-km 0.2 --sun-zenith-deg 30"),
    );
    for (outside, word) in [
        ("--altitude-km 0.4 --sun-zenith-deg 30", "altitude"),
        ("--altitude-km 0.2 --sun-zenith-deg 60", "sun zenith"),
    ] {
        refuse(
            directory.path(),
            &format!("{ask} {outside}"),
            &["baked/sky.utmlut", word, "outside"],
        );
    }
    let hazy = ask.replace("visual-range-km 40", "visual-range-km 20");
    refuse(
        directory.path(),
        &format!("{hazy} --altitude-km 0.2 --sun-zenith-deg 30"),
        &["visual range [km]: 20 is outside"],
    );
    // what draws pictures takes the table, or the plan itself, and draws it as planned
    assert_eq!(
        lut.header().planned("tier"),
        Some(runway().plan.tier.name())
    );
    let planned = Tier::planned(lut.header()).expect("a tier");
    assert_eq!(
        matches!(planned, Tier::Vertex(_)),
        runway().plan.tier == PlannedTier::Vertex
    );
    let pictures = [
        "baked/sky.utmlut",
        "plan.toml",
        &format!("plan.toml --tier {}", runway().plan.tier.name()),
    ]
    .map(|lut| {
        let place = "--visual-range-km 40 --altitude-km 0.2 --sun-zenith-deg 30";
        succeed(
            directory.path(),
            &format!("render --lut {lut} {place} --size 64x36 --out sky.png"),
        );
        fs::read(directory.path().join("sky.png")).unwrap()
    });
    assert_eq!(pictures[0], pictures[1]);
    assert_eq!(pictures[0], pictures[2]);
    refuse(
        directory.path(),
        "render --lut plan.toml --turbidity 6 --altitude-km 0.2 --sun-zenith-deg 30 --out out.png",
        &["plan.toml", "turbidity", "outside"],
    );
    let verified = succeed(
        directory.path(),
        "plan --verify plan.toml --lut baked/sky.utmlut --cases 20 --seed 5",
    );
    assert!(
        verified.stdout.contains("20 random cases"),
        "{}",
        verified.stdout
    );
    refuse(
        directory.path(),
        "generate --plan plan.toml --grid seed",
        &["--grid"],
    );
    fs::write(
        directory.path().join("plan.toml"),
        text.replace("\"a3\"", "\"a4\""),
    )
    .unwrap();
    refuse(
        directory.path(),
        "generate --plan plan.toml",
        &["plan.toml", "terms", "a4"],
    );
}

#[test]
fn b4_a_tolerance_that_is_not_met_ends_with_1() {
    let directory = tempdir().unwrap();
    let mut plan = runway().plan.clone();
    fs::write(directory.path().join("met.toml"), plan.to_toml().unwrap()).unwrap();
    plan.tolerance.delta_e = 1e-4;
    fs::write(directory.path().join("not.toml"), plan.to_toml().unwrap()).unwrap();
    fs::write(directory.path().join("sky.utmlut"), runway().lut.encode()).unwrap();
    for (name, verdict, status) in [("met", "is met", 0), ("not", "is not met", 1)] {
        let outcome = run(
            directory.path(),
            &format!("plan --verify {name}.toml --lut sky.utmlut --cases 20 --seed 5"),
        );
        assert_eq!(outcome.code, Some(status), "{outcome:?}");
        assert!(outcome.stdout.contains(verdict), "{outcome:?}");
    }
}

#[test]
fn a_table_may_lack_products_and_altitudes() {
    let lut = &runway().lut;
    assert!(lut.term_slots().len() < 22);
    let sky = UtmSky::new(lut.clone()).expect("a table for the runtime");
    let air = sky_core::aerial::AerialFrame::new(
        &sky,
        runway().plan.domain().turbidity[0],
        sky_core::quantity::Angle::from_degrees(30.0),
    )
    .unwrap();
    assert!(air.layers >= 2);
    let path = air.path(0.1, [1.0, 0.0, 0.0], 5.0);
    let all = path.inscatter.iter().chain(&path.transmittance);
    assert!(
        all.into_iter().all(|v| v.is_finite() && *v >= 0.0),
        "{path:?}"
    );
}

#[test]
fn a_term_is_explained_with_a_picture() {
    let directory = tempdir().unwrap();
    let scene = small_scene("altitude_km = 0.1", "delta_e = 2.0\nluminance = 0.1");
    fs::write(directory.path().join("scene.toml"), scene).unwrap();
    let said = succeed(
        directory.path(),
        "plan scene.toml --out plan.toml --explain ground",
    );
    assert!(
        said.stdout.contains("without ground: CIEDE2000"),
        "{}",
        said.stdout
    );
    let png = fs::read(directory.path().join("without_ground.png")).unwrap();
    assert!(png.starts_with(b"\x89PNG"));
    assert!(!directory.path().join("plan.toml").exists());
}

/// The report of 2005, 5.4.1.1, has it that absorption is futile for the blue zenith at sunset. It is
/// ozone that keeps the zenith blue: Hulburt 1953.
#[test]
fn ozone_is_not_futile_for_the_zenith_at_sunset() {
    let domain = Domain {
        altitude_km: [0.0, 30.0],
        turbidity: [2.0, 2.0],
        sun_zenith_deg: [85.0, 94.0],
        below_horizontal: true,
    };
    let zenith = sky_plan::zenith_without_ozone(&general().profile, &domain).unwrap();
    // ΔE by altitude and sun; the least at the top, above most of the ozone
    let least = zenith.iter().map(|(_, e)| *e).fold(f64::INFINITY, f64::min);
    let most = zenith.iter().map(|(_, e)| *e).fold(0.0, f64::max);
    assert!(most > 10.0, "{zenith:?}");
    assert!(least < most / 3.0, "{zenith:?}");
    let over_all = visibility(&general().profile, 0.2, &domain, Part::Ozone).unwrap();
    assert!(over_all.directions_seen > 0.9, "{over_all:?}");
}
