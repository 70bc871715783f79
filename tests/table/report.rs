//! The report: its audit of the printed table, its measure of error, its page; and a truth to test it
//! with that is cheap.

use std::sync::Arc;

use sky_core::color::Yxy;
use sky_core::conditions::{Conditions, Domain};
use sky_core::direction::SkyDirection;
use sky_core::quantity::{Angle, Length};
use sky_eval::cases::{CaseCounts, Nodes, conditions, evaluation_directions, held_out_cases};
use sky_eval::ledger::{ALTITUDES_KM, SUNS_DEG, Seen};
use sky_eval::report::input::{
    CellReport, ChannelReport, Figure, NamedModel, ReportInput, ReportSettings,
};
use sky_eval::report::{ReportFiles, SECTIONS, appendix_a, build, wavelengths};
use sky_eval::score::{evaluate, pool};
use sky_eval::truth::{SmartsSkyModel, TransportSky};
use sky_science::sky_model::{SkyError, SkyModel};
use sky_sim::optics::OpticsSettings;
use sky_sim::profile::AtmosphereProfile;
use sky_sim::transport::TransportSettings;

#[test]
fn the_printed_table_has_few_rows_that_can_be() {
    let rows = appendix_a::rows();
    assert_eq!(rows.len(), 75);
    let counts = appendix_a::audit();
    for (criterion, expected) in [
        ("zenith x ≤ 1 and y ≤ 1", 29),
        ("zenith x + y ≤ 1", 23),
        ("zenith chromaticity inside the spectral locus", 19),
        ("zenith x ≤ 0.5 and y ≤ 0.5", 14),
        ("B ≤ 0, so that F is finite at the horizon", 17),
        (
            "F relative to the zenith positive and computable over the dome (to 89.9°)",
            33,
        ),
        ("finite and positive", 13),
        ("finite, positive, brightest/darkest below 10 000", 10),
        ("finite, positive, chromaticity inside the locus", 6),
        ("all of these together", 5),
    ] {
        let place = appendix_a::TESTS
            .iter()
            .position(|t| t.criterion == criterion);
        let place = place.unwrap_or_else(|| panic!("no test {criterion}"));
        assert_eq!(counts[place], expected, "{criterion}");
    }
}

#[test]
fn the_six_rows_that_can_be_are_named() {
    let found: Vec<[f64; 4]> = appendix_a::rows()
        .iter()
        .filter(|r| r.is_finite() && r.is_positive() && r.zenith_is_a_color())
        .map(|r| {
            [
                r.altitude_km,
                r.turbidity,
                r.sun_zenith_deg,
                r.sun_azimuth_deg,
            ]
        })
        .collect();
    let expected = [
        [0.0, 0.0, 0.0, 0.0],
        [0.0, 0.5, 90.0, 270.0],
        [6.0, 0.0, 90.0, 90.0],
        [6.0, 1.0, 45.0, 270.0],
        [12.0, 0.0, 90.0, 90.0],
        [30.0, 1.0, 45.0, 90.0],
    ];
    assert_eq!(found, expected);
}

const ENGINE_DOMAIN: Domain = Domain {
    altitude_km: [0.0, 30.0],
    turbidity: [1.0, 8.0],
    sun_zenith_deg: [0.0, 96.0],
    below_horizontal: true,
};

/// A smooth sky in closed form, so that the tests of the measure need no engine.
struct Plain {
    brighter: f64,
    domain: Domain,
}

const PLAIN: Plain = Plain {
    brighter: 1.0,
    domain: ENGINE_DOMAIN,
};

impl SkyModel for Plain {
    fn name(&self) -> &str {
        "plain"
    }

    fn domain(&self) -> &Domain {
        &self.domain
    }

    fn yxy_map(
        &self,
        conditions: &Conditions,
        directions: &[SkyDirection],
    ) -> Result<Vec<Yxy>, SkyError> {
        self.domain.check(conditions)?;
        Ok(directions
            .iter()
            .map(|d| {
                let gamma = d.scattering_angle(conditions.sun_zenith).radians();
                Yxy {
                    luminance_cd_m2: self.brighter * 1000.0 * (1.5 + gamma.cos()),
                    x: 0.28 + 0.02 * gamma,
                    y: 0.30,
                }
            })
            .collect())
    }
}

fn few_cases() -> Vec<Conditions> {
    let nodes = Nodes {
        altitude_km: vec![0.0, 10.0, 30.0],
        turbidity: vec![1.0, 4.0],
        sun_zenith_deg: vec![0.0, 60.0, 90.0],
    };
    let counts = CaseCounts {
        midpoints: 4,
        sequence_turbidities: 2,
        cases_per_turbidity: 3,
    };
    held_out_cases(&nodes, &ENGINE_DOMAIN, counts).all()
}

#[test]
fn a_sky_compared_with_itself_has_no_error() {
    let found = evaluate(&PLAIN, &[&PLAIN], &few_cases()).unwrap();
    let pooled = found[0].pooled();
    assert_eq!(pooled.maps, 10);
    let (delta_e, luminance) = (pooled.delta_e.unwrap(), pooled.luminance.unwrap());
    assert!(delta_e.count > 1000);
    assert!(delta_e.max.abs() < 1e-12 && luminance.max.abs() < 1e-12);
    assert_eq!((pooled.negatives, pooled.not_finite), (0, 0));
}

#[test]
fn a_sky_five_percent_brighter_has_five_percent_of_error() {
    let brighter = Plain {
        brighter: 1.05,
        ..PLAIN
    };
    let found = evaluate(&PLAIN, &[&brighter], &few_cases()).unwrap();
    let pooled = found[0].pooled();
    let luminance = pooled.luminance.unwrap();
    for value in [luminance.median, luminance.p95, luminance.max] {
        assert!((value - 0.05).abs() < 1e-9);
    }
    // Near the median (L* 70) 5 % of luminance is 1.4 units of L*, about 1.1 of ΔE.
    let delta_e = pooled.delta_e.unwrap();
    assert!((0.5..2.0).contains(&delta_e.median), "{}", delta_e.median);
    let signed = &found[0].maps[0].luminance_signed;
    assert!(signed.iter().all(|v| (v - 0.05).abs() < 1e-9));
}

#[test]
fn the_suns_surroundings_are_left_out_and_what_a_model_does_not_cover_is_counted() {
    let small = Plain {
        brighter: 1.0,
        domain: Domain {
            altitude_km: [0.0, 12.0],
            ..ENGINE_DOMAIN
        },
    };
    let cases = [conditions(0.0, 2.0, 40.0), conditions(20.0, 2.0, 40.0)];
    let found = evaluate(&PLAIN, &[&PLAIN, &small], &cases).unwrap();
    assert_eq!((found[0].outside_domain, found[1].outside_domain), (0, 1));
    assert_eq!(found[1].maps.len(), 1);
    let all = evaluation_directions(Length::ZERO);
    let sun = Angle::from_degrees(40.0);
    let near = all
        .iter()
        .filter(|d| d.scattering_angle(sun).degrees() < 5.0)
        .count();
    assert!(near >= 2, "the sun stands on a ring");
    assert_eq!(found[0].maps[0].delta_e.len(), all.len() - near);
    let low = pool(&found[0].maps, |c, view| {
        c.observer_altitude.km() < 1.0 && view > 85.0
    });
    assert_eq!(low.maps, 1);
    assert!(low.delta_e.unwrap().count < 60);
}

#[test]
fn cases_outside_the_truth_are_an_error() {
    let outside = [conditions(31.0, 2.0, 40.0)];
    assert!(evaluate(&PLAIN, &[&PLAIN], &outside).is_err());
}

fn coarse_truth(profile: &AtmosphereProfile) -> TransportSky {
    let settings = OpticsSettings::with_step_nm(20).expect("20 nm are offered");
    let coarse = TransportSettings {
        degree: Some(3),
        zenith_points: [4, 3, 3],
        azimuth_points: 4,
        tolerance: 1e-2,
        ..TransportSettings::default()
    };
    TransportSky::new(profile.clone(), settings, 0.2)
        .expect("the settings are valid")
        .with_transport_settings(coarse)
}

#[test]
fn the_transport_sky_answers_in_its_domain_and_keeps_what_it_solved() {
    let profile = AtmosphereProfile::general();
    let truth = coarse_truth(&profile);
    let zenith = [SkyDirection::from_degrees(0.0, 0.0)];
    assert!(truth.yxy_map(&conditions(0.0, 0.9, 30.0), &zenith).is_err());
    assert!(
        truth
            .yxy_map(&conditions(0.0, 2.0, 109.0), &zenith)
            .is_err()
    );
    let day = truth.yxy_map(&conditions(0.0, 2.0, 60.0), &zenith).unwrap()[0];
    let aloft = truth
        .yxy_map(&conditions(12.0, 2.0, 60.0), &zenith)
        .unwrap()[0];
    let [first, second] = [truth.solved(2.0), truth.solved(2.0)].map(Result::unwrap);
    assert!(Arc::ptr_eq(&first, &second));
    // A blue zenith of some thousand cd/m², darker and bluer aloft.
    assert!((1000.0..6000.0).contains(&day.luminance_cd_m2), "{day:?}");
    assert!((0.23..0.30).contains(&day.x), "{day:?}");
    assert!(aloft.luminance_cd_m2 < 0.5 * day.luminance_cd_m2 && aloft.x < day.x);
    let smarts = SmartsSkyModel::new(profile.clone(), truth.settings().clone(), 0.2).unwrap();
    let closed = smarts
        .yxy_map(&conditions(0.0, 2.0, 60.0), &zenith)
        .unwrap()[0];
    assert!((closed.luminance_cd_m2 / day.luminance_cd_m2 - 1.0).abs() < 0.3);
    smarts
        .yxy_map(&conditions(30.0, 2.0, 96.0), &zenith)
        .unwrap();
}

fn cell(altitude_km: f64, turbidity: f64, sun_deg: f64) -> CellReport {
    let size = 1.0 + turbidity * (-altitude_km / 3.0).exp() * (sun_deg / 45.0);
    CellReport {
        conditions: conditions(altitude_km, turbidity, sun_deg),
        channels: ["Y", "x", "y"]
            .map(|channel| ChannelReport {
                channel,
                rms: 0.01 * size,
                why_stopped: "small reduction".to_owned(),
                converged: true,
                condition_number: 1e3 * size,
                note: String::new(),
            })
            .to_vec(),
        delta_e_p95: 0.5 * size,
        luminance_p95: 0.02 * size,
    }
}

fn small_report() -> ReportFiles {
    let profile = AtmosphereProfile::general();
    let truth = coarse_truth(&profile);
    let smarts = SmartsSkyModel::new(profile.clone(), truth.settings().clone(), 0.2)
        .expect("the settings are valid");
    let nodes = Nodes {
        altitude_km: vec![0.0, 6.0, 30.0],
        turbidity: vec![1.0, 3.0],
        sun_zenith_deg: vec![0.0, 60.0, 90.0],
    };
    let mut cells = Vec::new();
    for &km in &nodes.altitude_km {
        for &turbidity in &nodes.turbidity {
            for &sun in &nodes.sun_zenith_deg {
                cells.push(cell(km, turbidity, sun));
            }
        }
    }
    let settings = ReportSettings {
        scene_turbidity: 2.0,
        cases: CaseCounts {
            midpoints: 4,
            sequence_turbidities: 0,
            cases_per_turbidity: 0,
        },
        sweep_turbidities: vec![2.0],
        sweep_suns_deg: vec![60.0],
        sweep_altitudes: 4,
        picture_altitudes_km: vec![3.0],
        picture_suns_deg: vec![60.0],
        path_suns: 5,
    };
    let ledger = [Seen {
        term: "ozone",
        delta_e_median: 3.0,
        delta_e_p95: 20.0,
        delta_e_max: 40.0,
        luminance_p95: 0.1,
        directions_seen: 0.8,
        cases_seen: 1.0,
        worst: conditions(12.0, 2.0, 92.0),
        map: vec![0.25; ALTITUDES_KM.len() * SUNS_DEG.len()],
    }];
    let rows = [wavelengths::WavelengthRow {
        step_nm: 10,
        conditions: conditions(0.0, 2.0, 30.0),
        delta_e_max: 0.01,
        luminance_max: 0.001,
    }];
    build(&ReportInput {
        profile: &profile,
        truth: &truth,
        fits: &[NamedModel {
            name: "smarts <&> more".to_owned(),
            model: &smarts,
            nodes,
        }],
        cells: &cells,
        wavelengths: &rows,
        ledger: &ledger,
        figures: &[Figure {
            what: "size of the table [KiB]".to_owned(),
            value: "100".to_owned(),
            target: "≤ 128".to_owned(),
            met: Some(true),
        }],
        provenance: &[("profile, hash".to_owned(), "abc \"quoted\"".to_owned())],
        settings: &settings,
    })
    .expect("the report can be made")
}

#[test]
fn the_page_is_whole_and_stands_alone() {
    let report = small_report();
    let html = &report.html;
    for section in SECTIONS {
        assert!(
            html.contains(&format!("<section id=\"{section}\">")),
            "{section}"
        );
        assert!(html.contains(&format!("href=\"#{section}\"")), "{section}");
    }
    for forbidden in [
        "http://", "https://", "src=\"/", "url(", "@import", "<script", "<link",
    ] {
        assert!(!html.contains(forbidden), "{forbidden}");
    }
    for source in html.split("src=\"").skip(1) {
        assert!(source.starts_with("data:image/png;base64,"));
    }
    for target in html.split("href=\"").skip(1) {
        assert!(target.starts_with('#'));
    }
    assert_eq!(html.matches("<svg").count(), html.matches("</svg>").count());
    assert!(html.matches("<svg").count() >= 9 + 4 + 2 + 2);
    assert!(html.contains("smarts &lt;&amp;&gt; more"));
    // a picture's letters may spell anything
    let words = html.split("base64,").enumerate().map(|(i, part)| match i {
        0 => part,
        _ => part.split_once('"').map_or("", |(_, after)| after),
    });
    assert!(
        !words.collect::<String>().contains("NaN"),
        "no figure is missing"
    );
    assert!(html.contains("6 of 75"));
}

#[test]
fn the_long_table_is_regular_and_covers_the_page() {
    let report = small_report();
    let mut reader = csv::Reader::from_reader(report.csv.as_bytes());
    let header = reader.headers().unwrap().clone();
    let expected = "section,key,altitude_km,turbidity,sun_zenith_deg,channel,value";
    assert_eq!(header.iter().collect::<Vec<_>>().join(","), expected);
    let mut sections = std::collections::BTreeSet::new();
    for row in reader.records() {
        let row = row.unwrap();
        sections.insert(row[0].to_owned());
        for column in 2..5 {
            assert!(row[column].is_empty() || row[column].parse::<f64>().unwrap().is_finite());
        }
        assert!(!row[6].is_empty());
    }
    for section in SECTIONS.iter().filter(|s| **s != "pictures") {
        assert!(sections.contains(*section), "{section}");
    }
    assert_eq!(report, small_report(), "the same on every run");
}
