//! Where the models fail, found by the atlas's own sweep; the fit under stress; hostile text.

#![expect(clippy::unwrap_used, reason = "tests")]

use std::cell::Cell;
use std::path::Path;

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::test_runner::TestRunner;
use sky_cli::io::table::DirectionTable;
use sky_core::color::Yxy;
use sky_core::conditions::{Conditions, Domain};
use sky_core::direction::SkyDirection;
use sky_core::lut::Lut;
use sky_core::utm_sky::EMBEDDED_LUT;
use sky_eval::atlas::kind::{Arithmetic, Kind, Tally};
use sky_eval::atlas::subject::Density;
use sky_eval::atlas::subject::{Subject, models};
use sky_eval::atlas::sweep::Findings;
use sky_eval::fit_stress::{CELLS, DAMAGES, Effort, METHODS, maps, stress};
use sky_eval::grid::parse_grid;
use sky_eval::progress::Silent;
use sky_science::sky_model::{SkyError, SkyModel};
use sky_science::table_sky::TableSky;
use sky_sim::optics::OpticalProfile;
use sky_sim::profile::AtmosphereProfile;
use sky_sim::table::{ColumnSpec, Table};

const GENERAL: &str = include_str!("../../profiles/general.csv");

/// The kinds that a model may never show inside its domain.
const NEVER: [Kind; 12] = [
    Kind::NotFinite,
    Kind::NegativeLuminance,
    Kind::OutsideLocus,
    Kind::JumpDirection,
    Kind::RefusedInside,
    Kind::JumpAltitude,
    Kind::SteepDirection,
    Kind::SteepAltitude,
    Kind::Asymmetry,
    Kind::Overshoot,
    Kind::RisingZenith,
    Kind::Precision,
];

/// Kinds of a finite path.
const PATHS: [Kind; 5] = [
    Kind::PathNotFinite,
    Kind::PathNegative,
    Kind::PathTransmittance,
    Kind::PathJump,
    Kind::PathAsymmetry,
];

const DENSITY: Density = Density {
    altitudes: 2,
    turbidities: 2,
    suns: 4,
    zeniths: 2,
    azimuths: 1,
    between: 1,
};

fn inside(findings: &Findings, kind: Kind) -> &Tally {
    let arithmetic = if kind == Kind::Precision {
        Arithmetic::CpuF64
    } else {
        Arithmetic::CpuF32
    };
    findings.tallies.get(arithmetic, kind, true)
}

fn no_failures(findings: &Findings, kinds: &[Kind]) {
    for kind in kinds {
        let found = inside(findings, *kind);
        assert!(found.samples > 1000, "{kind:?}: {found:?}");
        assert_eq!(found.failures, 0, "{kind:?}: {found:?}");
    }
}

/// The default table, valid up to a sun zenith angle \[deg\].
fn default_up_to(sun_zenith_deg: f64) -> Subject {
    let lut = Lut::decode(EMBEDDED_LUT).unwrap();
    let mut header = lut.header().clone();
    header.domain.sun_zenith_deg[1] = sun_zenith_deg;
    let narrowed = Lut::new(header, lut.data().to_vec()).unwrap();
    Subject::table_of(TableSky::new(narrowed).expect("a sky"), "embedded")
}

#[test]
fn the_default_model_does_not_fail_in_its_domain_and_refuses_outside() {
    let findings = models()[0].subject(&Silent).unwrap().sweep(DENSITY, &|| {});
    no_failures(&findings, &NEVER);
    no_failures(&findings, &PATHS);
    let outside = findings
        .tallies
        .get(Arithmetic::CpuF32, Kind::SilentOutside, false);
    assert!(outside.samples > 100_000, "{outside:?}");
    assert_eq!(outside.failures, 0, "{outside:?}");
}

#[test]
fn by_day_the_default_model_changes_by_less_than_five_percent_a_hundredth_of_a_degree() {
    let findings = default_up_to(91.5).sweep(DENSITY, &|| {});
    let found = inside(&findings, Kind::SteepDirection);
    assert!(found.samples > 1000 && found.worst < 0.05, "{found:?}");
}

/// A model of the atlas.
fn named(name: &str) -> Subject {
    let entry = models().into_iter().find(|m| m.name == name).unwrap();
    entry.subject(&Silent).unwrap()
}

#[test]
fn the_sweep_itself_finds_what_is_wrong_with_the_report_of_2005() {
    let findings = named("utm2005").sweep(Density::QUICK, &|| {});
    let failures = |kind| inside(&findings, kind).failures;
    // FINDINGS: four-point Lagrange on linear colors turns negative between the layers, and leaves
    // the range of its nodes
    assert!(failures(Kind::NegativeLuminance) > 0);
    assert!(failures(Kind::Overshoot) > 0);
    let worst = inside(&findings, Kind::NegativeLuminance);
    let place = worst.place.unwrap().conditions;
    assert!(
        place.turbidity > 1.5 && place.observer_altitude.km() > 0.0,
        "{worst:?}"
    );
    // outside its domain it is refused like any table
    let outside = findings
        .tallies
        .get(Arithmetic::CpuF32, Kind::SilentOutside, false);
    assert!(outside.samples > outside.failures, "{outside:?}");
}

/// A sky with a fault of every kind.
#[derive(Debug)]
struct Broken(Domain);

impl SkyModel for Broken {
    fn name(&self) -> &'static str {
        "broken"
    }
    fn domain(&self) -> &Domain {
        &self.0
    }
    /// Answers everywhere; fails in a known way in each region.
    fn yxy_map(
        &self,
        conditions: &Conditions,
        directions: &[SkyDirection],
    ) -> Result<Vec<Yxy>, SkyError> {
        let km = conditions.observer_altitude.km();
        Ok(directions
            .iter()
            .map(|d| {
                let zenith = d.view_zenith.degrees();
                let mut light = Yxy {
                    luminance_cd_m2: 1000.0 * (1.0 + 0.02 * km),
                    x: 0.3,
                    y: 0.3,
                };
                if conditions.turbidity < 1.05 {
                    light.luminance_cd_m2 = -2.35;
                }
                if zenith > 90.000_05 {
                    light.luminance_cd_m2 *= 1.05;
                }
                if d.relative_azimuth.degrees() < 0.0 {
                    light.luminance_cd_m2 *= 1.001;
                }
                if km > 15.0 {
                    light.luminance_cd_m2 *= 0.9;
                }
                if (80.0..=82.0).contains(&conditions.sun_zenith.degrees()) {
                    light.x = 0.9;
                }
                if zenith < 0.001 {
                    light.y = f64::NAN;
                }
                light
            })
            .collect())
    }
}

#[test]
fn the_sweep_finds_each_fault_that_was_put_in() {
    let domain = Domain {
        altitude_km: [0.0, 30.0],
        turbidity: [1.0, 8.0],
        sun_zenith_deg: [0.0, 96.0],
        below_horizontal: true,
    };
    let findings = Subject::other(Box::new(Broken(domain))).sweep(DENSITY, &|| {});
    let tally = |kind, inside| findings.tallies.get(Arithmetic::CpuF64, kind, inside);
    for kind in [
        Kind::NotFinite,
        Kind::NegativeLuminance,
        Kind::OutsideLocus,
        Kind::JumpDirection,
        Kind::Asymmetry,
        Kind::RisingZenith,
    ] {
        let found = tally(kind, true);
        assert!(found.failures > 0, "{kind:?}: {found:?}");
        assert!(found.failures < found.samples, "{kind:?}: {found:?}");
        assert!(found.place.is_some());
    }
    let outside = tally(Kind::SilentOutside, false);
    assert_eq!(outside.failures, outside.samples, "it refuses nothing");
    assert!((tally(Kind::NegativeLuminance, true).worst - 2.35 * 1.05 * 1.001).abs() < 1.0);
}

#[test]
fn b5_maps_are_counted_and_every_method_has_as_many_starts() {
    let effort = Effort {
        starts: 1000,
        damages: 3,
        damaged_starts: 4,
    };
    for map in maps(&[CELLS[1]]).unwrap() {
        let rows = stress(&map, effort, 5);
        let row = |damage: &str, method: &str| {
            rows.iter()
                .find(|r| DAMAGES[r.damage].1 == damage && METHODS[r.method].1 == method)
                .unwrap()
        };
        // the eight starts are the same for every fit of a map, so that a map is one fit
        let undamaged = row("none", "safeguarded");
        assert_eq!(
            [undamaged.fits, undamaged.succeeded],
            [1, 1],
            "{undamaged:?}"
        );
        assert_eq!(row("none", "plain_eight").fits, 1);
        // the safeguards are worth something, start by start
        let (one, plain) = (row("none", "one_start"), row("none", "plain"));
        assert_eq!([one.fits, plain.fits], [1000, 1000]);
        assert!(plain.succeeded < one.succeeded, "{plain:?} {one:?}");
        let noisy = row("noise_1_percent", "safeguarded");
        assert_eq!([noisy.fits, noisy.refused], [3, 0]);
        assert!(noisy.radiance_worst <= 0.01, "{noisy:?}");
        let black = row("zero_luminance", "safeguarded");
        assert_eq!(black.refused, black.fits, "{black:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(200) })]

    #[test]
    fn any_text_is_a_profile_or_refused(text in "\\PC{0,300}") {
        let _ = AtmosphereProfile::from_csv_str("any.csv", &text);
        let _ = OpticalProfile::from_csv_str("any.csv", &text);
        let _ = DirectionTable::parse(Path::new("any.csv"), &text);
        let _ = parse_grid("any.toml", &text);
    }

    #[test]
    fn a_profile_with_a_changed_cell_is_a_profile_or_refused(
        line in 0_usize..60,
        cell in 0_usize..12,
        text in "[-+0-9eE.,a-zµ\"\\\\ \n]{0,12}|nan|inf|-0|1e308|1e-320|999999999999999999999",
    ) {
        let mut lines: Vec<String> = GENERAL.lines().map(str::to_owned).collect();
        let line = line % lines.len();
        let mut cells: Vec<&str> = lines[line].split(',').collect();
        let cell = cell % cells.len();
        cells[cell] = &text;
        lines[line] = cells.join(",");
        let _ = AtmosphereProfile::from_csv_str("general.csv", &lines.join("\n"));
    }

    #[test]
    fn a_directions_file_of_any_cells_is_read_or_refused(
        rows in vec(vec("[-+0-9eE.]{0,8}|nan|inf", 0..4), 0..8),
    ) {
        let mut text = String::from("view_zenith_deg,relative_azimuth_deg\n");
        for row in rows {
            text.push_str(&row.join(","));
            text.push('\n');
        }
        if let Ok(table) = DirectionTable::parse(Path::new("d.csv"), &text) {
            for [zenith, azimuth] in table.degrees {
                prop_assert!((0.0..=180.0).contains(&zenith) && azimuth.abs() <= 360.0);
            }
        }
        let columns = [
            ColumnSpec::required("view_zenith_deg", [0.0, 180.0]),
            ColumnSpec::required("relative_azimuth_deg", [-360.0, 360.0]),
        ];
        if let Ok(table) = Table::read("s.csv", &text, &columns, 1) {
            prop_assert!(table.column(0).iter().all(|z| (0.0..=180.0).contains(z)));
        }
    }
}

/// Nodes of an axis: mostly ascending ones within bounds, else any numbers.
fn axis([low, high]: [f64; 2]) -> impl Strategy<Value = Vec<f64>> {
    let ascending = vec(low..=high, 1..6).prop_map(|mut nodes| {
        nodes.sort_by(f64::total_cmp);
        nodes.dedup();
        nodes
    });
    prop_oneof![9 => ascending, 1 => vec(prop::num::f64::ANY, 0..6)]
}

#[test]
fn b6_a_grid_is_read_if_it_is_one_and_most_that_are_drawn_are() {
    const BOUNDS: [[f64; 2]; 3] = [[0.0, 30.0], [1.0, 12.0], [0.0, 96.0]];
    let form = prop_oneof![
        9 => "extended|perez-report|perez-spherical",
        1 => Just("other".to_owned()),
    ];
    let drawn = (axis(BOUNDS[0]), axis(BOUNDS[1]), axis(BOUNDS[2]), form);
    let (read, refused) = (Cell::new(0), Cell::new(0));
    let config = ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::with_cases(400)
    };
    TestRunner::new(config)
        .run(&drawn, |(altitude, turbidity, sun, form)| {
            let axes = [altitude, turbidity, sun];
            let list = |nodes: &[f64]| {
                let items: Vec<String> = nodes.iter().map(|n| format!("{n:e}")).collect();
                items.join(",")
            };
            let text = format!(
                "altitude_km=[{}]\nturbidity=[{}]\nsun_zenith_deg=[{}]\nform=\"{form}\"\n",
                list(&axes[0]),
                list(&axes[1]),
                list(&axes[2])
            );
            let is_grid = form != "other"
                && axes.iter().zip(BOUNDS).all(|(nodes, [low, high])| {
                    !nodes.is_empty()
                        && nodes.iter().all(|n| (low..=high).contains(n))
                        && nodes.windows(2).all(|pair| pair[0] < pair[1])
                });
            match parse_grid("any.toml", &text) {
                Ok(grid) => {
                    prop_assert!(is_grid, "{text}");
                    let found = [&grid.altitude_km, &grid.turbidity, &grid.sun_zenith_deg];
                    prop_assert_eq!(found.map(|axis| axis.nodes().to_vec()), axes);
                    read.set(read.get() + 1);
                }
                Err(error) => {
                    prop_assert!(!is_grid, "{text}: {error}");
                    refused.set(refused.get() + 1);
                }
            }
            Ok(())
        })
        .unwrap();
    let [read, refused] = [read.get(), refused.get()];
    assert!(
        read > 200 && refused > 40,
        "{read} were read, {refused} refused"
    );
}
