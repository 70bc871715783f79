//! The transport engine at its limits: nothing and a lot of haze, black and white ground, the sun at and
//! below the horizon, an observer exactly on a level; and against itself with stricter settings.

#![expect(clippy::unwrap_used, reason = "tests")]

use sky_core::direction::SkyDirection;
use sky_core::haze::Haze;
use sky_core::quantity::{Angle, Length};
use sky_fit::sweep::between;
use sky_sim::optics::{Constituents, OpticalProfile, OpticsSettings};
use sky_sim::profile::AtmosphereProfile;
use sky_sim::transport::{Transport, TransportSettings};

const WAVELENGTHS_NM: [f64; 2] = [450.0, 650.0];

fn optics(aod500: f64) -> OpticalProfile {
    let settings = OpticsSettings {
        haze: Haze::OpticalDepth500(aod500),
        wavelength_nm: WAVELENGTHS_NM.to_vec(),
        ..OpticsSettings::default()
    };
    OpticalProfile::build(&AtmosphereProfile::general(), &settings).unwrap()
}

fn solve(aod500: f64, albedo: f64) -> Transport {
    Transport::solve(&optics(aod500), albedo, &TransportSettings::default()).unwrap()
}

fn directions() -> Vec<SkyDirection> {
    [
        0.0, 30.0, 60.0, 80.0, 88.0, 89.9, 90.0, 90.1, 95.0, 135.0, 180.0,
    ]
    .into_iter()
    .flat_map(|z| [0.0, 3.0, 90.0, 180.0].map(|a| SkyDirection::from_degrees(z, a)))
    .collect()
}

fn radiance(solved: &Transport, km: f64, sun: f64, directions: &[SkyDirection]) -> Vec<f64> {
    solved.radiance_ratio(Length::from_km(km), Angle::from_degrees(sun), directions)
}

#[test]
fn light_is_finite_and_not_negative_from_no_haze_to_an_optical_depth_of_5() {
    let everywhere = directions();
    for (aod, albedo) in [(0.0, 0.0), (1e-6, 1.0), (0.5, 1.0), (2.0, 0.0), (5.0, 1.0)] {
        let solved = solve(aod, albedo);
        // the ground, levels of the field, the top of the domain
        for km in [0.0, 0.1, 2.9, 30.0] {
            for sun in [0.0, 89.0, 90.0, 93.0, 96.0] {
                let all = radiance(&solved, km, sun, &everywhere);
                assert!(
                    all.iter().all(|l| l.is_finite() && *l >= 0.0),
                    "optical depth {aod}, albedo {albedo}, {km} km, sun {sun}: {all:?}"
                );
            }
        }
    }
}

#[test]
fn a_brighter_ground_brightens_every_sky() {
    let above: Vec<SkyDirection> = directions()
        .into_iter()
        .filter(|d| d.view_zenith.degrees() < 90.0)
        .collect();
    for aod in [0.0, 5.0] {
        let skies = [0.0, 0.5, 1.0].map(|albedo| solve(aod, albedo));
        for km in [0.0, 10.0] {
            for sun in [0.0, 60.0, 89.0] {
                let lights = skies.each_ref().map(|s| radiance(s, km, sun, &above));
                for (i, dark) in lights[0].iter().enumerate() {
                    let rise = [*dark, lights[1][i], lights[2][i]];
                    // what remains of the series when it is stopped may differ by its tolerance
                    assert!(
                        rise[0] <= rise[1] * 1.002 && rise[1] <= rise[2] * 1.002,
                        "optical depth {aod}, {km} km, sun {sun}: {rise:?}"
                    );
                }
            }
        }
    }
}

#[test]
fn the_sky_darkens_steadily_from_sunset_to_the_end_of_twilight() {
    let zenith = [SkyDirection::from_degrees(0.0, 0.0)];
    for aod in [0.0, 0.2, 2.0] {
        let solved = solve(aod, 0.2);
        for km in [0.0, 10.0] {
            let lights: Vec<f64> = (0..=28)
                .map(|i| radiance(&solved, km, 89.0 + 0.25 * f64::from(i), &zenith)[0])
                .collect();
            assert!(
                lights.windows(2).all(|w| w[1] < w[0] && w[1] > 0.0),
                "optical depth {aod}, {km} km: {lights:?}"
            );
        }
    }
}

#[test]
fn an_observer_on_a_level_sees_what_one_beside_it_sees() {
    let solved = solve(0.3, 0.2);
    let directions = directions();
    // levels of the field and of the optics; the engine's own accuracy is 1 %, and in twilight, where
    // rays graze the Earth's shadow, 2 %
    for km in [0.1, 0.6, 2.9, 12.5, 27.0] {
        for sun in [30.0, 85.0, 92.0] {
            let [below, here, above] =
                [km - 1e-6, km, km + 1e-6].map(|h| radiance(&solved, h, sun, &directions));
            let limit = if sun < 90.0 { 1e-2 } else { 2e-2 };
            for ((b, h), a) in below.iter().zip(&here).zip(&above) {
                assert!(
                    (b - h).abs() <= limit * h && (a - h).abs() <= limit * h,
                    "{km} km, sun {sun}: {b} {h} {a}"
                );
            }
        }
    }
}

#[test]
fn air_that_absorbs_nothing_under_a_black_ground_is_brighter_than_air_that_does() {
    let settings = |single_scattering_albedo| OpticsSettings {
        haze: Haze::OpticalDepth500(1.0),
        wavelength_nm: WAVELENGTHS_NM.to_vec(),
        constituents: Constituents {
            ozone: false,
            ..OpticsSettings::default().constituents
        },
        single_scattering_albedo,
        ..OpticsSettings::default()
    };
    let [white, gray] = [Some(1.0), Some(0.8)].map(|w| {
        let optics = OpticalProfile::build(&AtmosphereProfile::general(), &settings(w)).unwrap();
        Transport::solve(&optics, 0.0, &TransportSettings::default()).unwrap()
    });
    let directions = directions();
    for sun in [0.0, 60.0, 88.0] {
        let lights = [&white, &gray].map(|s| radiance(s, 0.0, sun, &directions));
        for (w, g) in lights[0].iter().zip(&lights[1]) {
            assert!(g <= w, "sun {sun}: {g} {w}");
        }
    }
}

/// Largest relative difference between two solutions above the horizon.
fn difference(solved: [&Transport; 2], km: f64, sun: f64) -> f64 {
    let mut sky = directions();
    sky.retain(|d| d.view_zenith.degrees() <= 90.0);
    let [a, b] = solved.map(|s| radiance(s, km, sun, &sky));
    a.iter()
        .zip(&b)
        .map(|(a, b)| (a / b - 1.0).abs())
        .fold(0.0, f64::max)
}

/// With the sun down, only high air is lit: its light must reach the ground whatever the shells.
#[test]
fn light_in_twilight_does_not_depend_on_the_number_of_shells() {
    let optics = optics(0.3);
    let usual = TransportSettings::default();
    let fine = TransportSettings {
        shells_km: between(&between(&usual.shells_km)),
        ..usual.clone()
    };
    let [usual, fine] =
        [usual, fine].map(|settings| Transport::solve(&optics, 0.2, &settings).unwrap());
    for sun in [90.0, 92.0, 93.6, 95.0, 96.0] {
        let worst = difference([&usual, &fine], 0.0, sun);
        assert!(worst <= 0.03, "sun {sun}: {worst}");
    }
}

#[test]
fn stricter_settings_change_little() {
    let optics = optics(0.3);
    let usual = TransportSettings::default();
    let strict = TransportSettings {
        zenith_points: [9, 12, 6],
        azimuth_points: 12,
        tolerance: 2e-4,
        columns_deg: between(&usual.columns_deg),
        shells_km: between(&usual.shells_km),
        ..usual.clone()
    };
    let [usual, strict] =
        [&usual, &strict].map(|settings| Transport::solve(&optics, 0.2, settings).unwrap());
    for (km, sun, tolerance) in [
        (0.0, 30.0, 0.01),
        (0.0, 80.0, 0.015),
        (6.0, 60.0, 0.015),
        (0.0, 90.0, 0.03),
        (12.0, 93.0, 0.05),
        (0.0, 94.0, 0.04),
        (0.0, 96.0, 0.04),
        (20.0, 96.0, 0.05),
        (30.0, 95.0, 0.07),
    ] {
        let worst = difference([&usual, &strict], km, sun);
        assert!(worst <= tolerance, "{km} km, sun {sun}: {worst}");
    }
}
