//! The look-up tables between their nodes, against the transport engine; the table that ships.

use std::sync::LazyLock;

use sky_core::axis::Axis;
use sky_core::conditions::{Conditions, Domain};
use sky_core::direction::{SkyDirection, horizon_zenith};
use sky_core::quantity::Length;
use sky_core::utm_sky::{EMBEDDED_LUT, UtmSky};
use sky_eval::bake::{MAP_STEP_NM, bake};
use sky_eval::cases::{CaseCounts, Nodes, conditions, held_out_cases};
use sky_eval::profiles::NamedProfile;
use sky_eval::progress::Silent;
use sky_eval::score::evaluate;
use sky_eval::truth::{DEFAULT_GROUND_ALBEDO, TransportSky};
use sky_fit::sweep::Grid;
use sky_science::metrics::{Statistics, relative_error};
use sky_science::sky_model::SkyModel;
use sky_science::table_sky::TableSky;
use sky_sim::optics::OpticsSettings;
use sky_sim::profile::AtmosphereProfile;

static TRUTH: LazyLock<TransportSky> = LazyLock::new(|| {
    let settings = OpticsSettings::with_step_nm(MAP_STEP_NM).expect("a step");
    TransportSky::new(
        AtmosphereProfile::general(),
        settings,
        DEFAULT_GROUND_ALBEDO,
    )
    .expect("the truth")
});

fn embedded() -> UtmSky {
    UtmSky::embedded().expect("the table of the program")
}

fn nodes(sky: &UtmSky) -> Nodes {
    let header = sky.lut().header();
    let list = |axis: &Axis| axis.nodes().to_vec();
    Nodes {
        altitude_km: list(&header.altitude_km),
        turbidity: list(&header.turbidity),
        sun_zenith_deg: list(&header.sun_zenith_deg),
    }
}

/// Where the figures of accuracy are asked for.
const CLAIMED: Domain = Domain {
    altitude_km: [0.0, 30.0],
    turbidity: [1.0, 8.0],
    sun_zenith_deg: [0.0, 92.0],
    below_horizontal: true,
};

#[test]
fn the_table_that_ships_is_small_and_reproduced_to_the_byte() {
    assert!(
        EMBEDDED_LUT.len() <= 128 * 1024,
        "{} bytes",
        EMBEDDED_LUT.len()
    );
    let grid = Grid::extended().expect("the default grid");
    let (lut, _) = bake(
        &*TRUTH,
        &grid,
        &NamedProfile::general().expect("a shipped profile"),
        TRUTH.extinction().expect("optics"),
        &Silent,
    )
    .expect("a table");
    assert!(
        lut.encode() == EMBEDDED_LUT,
        "luts/default.utmlut is not what generate makes"
    );
}

#[test]
fn between_the_nodes_the_table_meets_the_transport_engine() {
    let sky = embedded();
    let cases = held_out_cases(&nodes(&sky), &CLAIMED, CaseCounts::default()).all();
    let all = evaluate(&*TRUTH, &[&sky], &cases).expect("inside the domain")[0].pooled();
    let (color, luminance) = (
        all.delta_e.expect("directions"),
        all.luminance.expect("directions"),
    );
    assert!(all.maps > 200);
    assert_eq!(all.negatives + all.not_finite, 0);
    assert!(color.median <= 0.5 && color.p95 <= 2.5, "{color:?}");
    assert!(luminance.p95 <= 0.06, "{luminance:?}");
}

/// Relative errors of luminance of the shipped table.
fn luminance_errors(places: &[(Conditions, Vec<SkyDirection>)]) -> Statistics {
    let sky = embedded();
    let mut errors = Vec::new();
    for (conditions, directions) in places {
        let ask = |sky: &dyn SkyModel| sky.yxy_map(conditions, directions).expect("inside");
        let pairs = ask(&sky).into_iter().zip(ask(&*TRUTH));
        errors.extend(pairs.map(|(a, b)| relative_error(a.luminance_cd_m2, b.luminance_cd_m2)));
    }
    Statistics::of(&errors).expect("directions")
}

/// The 5° that every other figure leaves out: the sun's glare hides them, but not its absence.
#[test]
fn close_to_the_sun_the_table_is_no_guess() {
    let mut day = Vec::new();
    for (km, turbidity) in [(0.7, 1.5), (2.5, 3.0), (9.0, 2.5), (16.0, 1.2), (27.0, 5.0)] {
        for sun in [12.0, 38.0, 61.0, 75.0] {
            let near = [-4.0, -2.0, -0.5, 0.5, 2.0, 4.0]
                .into_iter()
                .flat_map(|off| [0.0, 2.0].map(|a| SkyDirection::from_degrees(sun + off, a)));
            day.push((conditions(km, turbidity, sun), near.collect()));
        }
    }
    let errors = luminance_errors(&day);
    assert!(errors.p95 <= 0.05, "{errors:?}");
}

/// The brightest part of a twilight seen from altitude: toward the sun, 1 to 5° above the horizon.
#[test]
fn the_glow_of_a_sun_below_the_horizon_is_as_bright_as_it_should() {
    let mut glow = Vec::new();
    for (km, turbidity) in [
        (5.0, 2.0),
        (11.0, 3.0),
        (16.0, 1.5),
        (22.0, 4.0),
        (29.0, 2.0),
    ] {
        let horizon = horizon_zenith(Length::from_km(km)).degrees();
        for sun in [93.0, 94.7, 95.5] {
            let above = [1.0, 1.5, 2.0, 3.0, 5.0]
                .into_iter()
                .flat_map(|up| [0.0, 8.0].map(|a| SkyDirection::from_degrees(horizon - up, a)));
            glow.push((conditions(km, turbidity, sun), above.collect()));
        }
    }
    let errors = luminance_errors(&glow);
    assert!(errors.median <= 0.08 && errors.max <= 0.3, "{errors:?}");
}

#[test]
fn the_report_s_rule_turns_light_negative() {
    let grid = Grid::report().expect("the report's grid");
    let (lut, sweep) = bake(
        &*TRUTH,
        &grid,
        &NamedProfile::general().expect("a shipped profile"),
        TRUTH.extinction().expect("optics"),
        &Silent,
    )
    .expect("a table");
    assert_eq!(lut.header().shape(), [5, 3, 3]);
    assert!(sweep.nodes.iter().all(|n| n.channels.len() == 3));
    let sky = TableSky::new(lut).expect("a sky");
    // the cases of the shipped table, as far as the report's grid reaches
    let cases = held_out_cases(&nodes(&embedded()), &CLAIMED, CaseCounts::default()).all();
    let all = evaluate(&*TRUTH, &[&sky], &cases).expect("inside the domain")[0].pooled();
    assert!(all.negatives > 0, "the known failure is gone: {all:?}");
}

#[test]
fn outside_its_domain_the_table_refuses() {
    let sky = embedded();
    for (km, t, sun) in [
        (-0.1, 2.0, 45.0),
        (30.1, 2.0, 45.0),
        (1.0, 0.9, 45.0),
        (1.0, 8.1, 45.0),
        (1.0, 2.0, 96.1),
        (f64::NAN, 2.0, 45.0),
    ] {
        assert!(
            sky.frame(&conditions(km, t, sun)).is_err(),
            "{km} {t} {sun}"
        );
    }
    for km in [0.0, 3.0, 30.0] {
        let frame = sky.frame(&conditions(km, 2.0, 45.0)).expect("inside");
        let horizon = horizon_zenith(Length::from_km(km)).degrees();
        assert!(
            frame
                .yxy(&SkyDirection::from_degrees(horizon - 0.01, 30.0))
                .is_some()
        );
        assert!(
            frame
                .yxy(&SkyDirection::from_degrees(horizon + 0.05, 30.0))
                .is_none()
        );
    }
}

#[test]
fn nodes_join_without_a_step_and_left_equals_right() {
    let sky = embedded();
    let light = |c: &Conditions, azimuth: f64| {
        sky.yxy_map(c, &[SkyDirection::from_degrees(70.0, azimuth)])
            .expect("inside")[0]
    };
    for (below, above) in [
        (
            conditions(3.499_999, 2.5, 71.0),
            conditions(3.500_001, 2.5, 71.0),
        ),
        (
            conditions(2.2, 1.999_999, 71.0),
            conditions(2.2, 2.000_001, 71.0),
        ),
        (
            conditions(2.2, 2.5, 89.999_999),
            conditions(2.2, 2.5, 90.000_001),
        ),
    ] {
        let (a, b) = (light(&below, 40.0), light(&above, 40.0));
        assert!(
            (a.luminance_cd_m2 / b.luminance_cd_m2 - 1.0).abs() < 1e-4,
            "{a:?} {b:?}"
        );
        let (l, r) = (light(&below, 40.0), light(&below, -40.0));
        assert!((l.luminance_cd_m2 / r.luminance_cd_m2 - 1.0).abs() < 1e-5);
    }
}
