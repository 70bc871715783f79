//! The transport engine against closed forms, radiances computed by a separate program and an
//! independent solver.

#![expect(
    clippy::print_stdout,
    reason = "the measured figures are part of the test's answer"
)]

use sky_core::direction::SkyDirection;
use sky_core::haze::Haze;
use sky_core::quantity::{Angle, Length};
use sky_science::phase;
use sky_sim::optics::{OpticalProfile, OpticsSettings};
use sky_sim::profile::AtmosphereProfile;
use sky_sim::transport::{Transport, TransportError, TransportSettings};

fn optics(aod500: f64, wavelength_nm: &[f64]) -> OpticalProfile {
    let settings = OpticsSettings {
        haze: Haze::OpticalDepth500(aod500),
        wavelength_nm: wavelength_nm.to_vec(),
        ..OpticsSettings::default()
    };
    OpticalProfile::build(&AtmosphereProfile::general(), &settings)
        .expect("the reference atmosphere")
}

fn solve(optics: &OpticalProfile, albedo: f64) -> Transport {
    Transport::solve(optics, albedo, &TransportSettings::default()).expect("a solution")
}

/// An atmosphere of molecules alone, exponential with a scale height of 8 km.
fn molecules(optical_depth: f64) -> OpticalProfile {
    let altitude_km: Vec<f64> = (0..=200).map(|k| f64::from(k) * 0.5).collect();
    let n = altitude_km.len();
    OpticalProfile {
        rayleigh_scattering_per_km: altitude_km
            .iter()
            .map(|z| optical_depth / 8.0 * (-z / 8.0).exp())
            .collect(),
        altitude_km,
        wavelength_nm: vec![550.0],
        gas_absorption_per_km: vec![0.0; n],
        aerosol_scattering_per_km: vec![0.0; n],
        aerosol_absorption_per_km: vec![0.0; n],
        aerosol_g: vec![0.0; n],
        aerosol_g2: vec![0.0; n],
        aerosol_g_weight: vec![1.0; n],
        rayleigh_depolarization: 0.0283,
    }
}

#[test]
fn thin_air_scatters_its_optical_depth_times_the_phase_function() {
    let depth = 1e-4;
    let solved = solve(&molecules(depth), 0.0);
    for sun in [0.0_f64, 40.0, 70.0] {
        let sun = Angle::from_degrees(sun);
        let found =
            solved.radiance_ratio(Length::ZERO, sun, &[SkyDirection::from_degrees(0.0, 0.0)])[0];
        let expected = depth * phase::rayleigh(sun.radians().cos(), 0.0283);
        assert!((found / expected - 1.0).abs() < 2e-3, "{found} {expected}");
    }
}

#[test]
fn a_white_world_without_absorption_keeps_its_light() {
    // Over a ground that reflects everything and under air that absorbs nothing, what comes down must
    // go up again: the two fluxes through a level are equal, but for what the sphere spreads out.
    let solved = solve(&molecules(0.3), 1.0);
    let altitude = Length::from_km(40.0);
    let steps = 400_u32;
    let mut fluxes = [0.0; 2]; // up, down
    for k in 0..steps {
        let mu = -1.0 + 2.0 * (f64::from(k) + 0.5) / f64::from(steps);
        let direction = SkyDirection {
            view_zenith: Angle::from_radians(mu.acos()),
            relative_azimuth: Angle::ZERO,
        };
        let light = solved.radiance_ratio(altitude, Angle::ZERO, &[direction])[0];
        let side = usize::from(mu > 0.0);
        fluxes[side] += core::f64::consts::TAU * mu.abs() * light * 2.0 / f64::from(steps);
    }
    // above 40 km the sun has lost next to nothing
    let beam = (-0.3 * (-40.0_f64 / 8.0).exp()).exp();
    let [up, down] = [fluxes[0], fluxes[1] + beam];
    assert!((up / down - 1.0).abs() < 0.02, "{up} {down}");
}

#[test]
fn the_radiances_of_a_separate_program_are_met() {
    let text = include_str!("../reference/reference_sky_radiance.csv");
    let rows: Vec<Vec<f64>> = text
        .lines()
        .skip(1)
        .map(|line| {
            line.split(',')
                .map(|cell| cell.parse().unwrap_or(f64::NAN))
                .collect()
        })
        .collect();
    assert_eq!(rows.len(), 810);
    let mut deviations = Vec::new();
    for aod in [0.0, 0.5, 1.0] {
        let solved = solve(&optics(aod, &[440.0, 540.0, 640.0]), 0.2);
        for row in rows.iter().filter(|row| (row[0] - aod).abs() < 1e-9) {
            let found = solved.radiance_ratio(
                Length::from_km(row[1]),
                Angle::from_degrees(row[2]),
                &[SkyDirection::from_degrees(row[3], row[4])],
            );
            deviations.extend(
                found
                    .iter()
                    .zip(&row[5..8])
                    .map(|(f, e)| (f / e - 1.0).abs()),
            );
        }
    }
    assert_eq!(deviations.len(), 3 * 810);
    let mean = deviations.iter().sum::<f64>() / 2430.0;
    println!("mean deviation {mean:.4}");
    assert!(mean <= 0.015, "mean deviation {mean}");
}

#[test]
fn an_independent_solver_agrees_in_thick_haze() {
    // sasktran2 2026.10.1, successive orders on a two-dimensional grid, on this project's exported
    // optics: aerosol optical depth 1, 550 nm, observer on the ground, sun zenith 75°, albedo 0.2.
    const SOLVER: [[f64; 3]; 7] = [
        [0.0, 0.0, 0.019_932_5],
        [30.0, 90.0, 0.022_164_8],
        [60.0, 180.0, 0.021_750_0],
        [80.0, 90.0, 0.025_415_4],
        [85.0, 90.0, 0.021_610_6],
        [89.0, 90.0, 0.018_755_9],
        [90.0, 90.0, 0.017_561_3],
    ];
    let solved = solve(&optics(1.0, &[550.0]), 0.2);
    for [zenith, azimuth, expected] in SOLVER {
        let found = solved.radiance_ratio(
            Length::ZERO,
            Angle::from_degrees(75.0),
            &[SkyDirection::from_degrees(zenith, azimuth)],
        )[0];
        assert!(
            (found / expected - 1.0).abs() < 0.025,
            "{zenith}: {found} {expected}"
        );
    }
}

#[test]
fn the_sky_is_symmetric_dark_aloft_and_red_at_sunset() {
    let solved = solve(&optics(0.1, &[450.0, 550.0, 650.0]), 0.2);
    let at = |km: f64, sun: f64, zenith: f64, azimuth: f64| {
        solved.radiance_ratio(
            Length::from_km(km),
            Angle::from_degrees(sun),
            &[SkyDirection::from_degrees(zenith, azimuth)],
        )
    };
    let (left, right) = (at(3.0, 70.0, 60.0, 50.0), at(3.0, 70.0, 60.0, -50.0));
    for (l, r) in left.iter().zip(&right) {
        assert!((l / r - 1.0).abs() < 1e-9);
    }
    let zeniths: Vec<f64> = [0.0, 3.0, 10.0, 20.0, 30.0]
        .map(|km| at(km, 40.0, 0.0, 0.0)[1])
        .to_vec();
    assert!(zeniths.windows(2).all(|w| w[1] < w[0]), "{zeniths:?}");
    let sunset = at(0.0, 90.0, 89.0, 0.0);
    let noon = at(0.0, 30.0, 60.0, 90.0);
    assert!(sunset[2] / sunset[0] > 3.0 * noon[2] / noon[0]);
    // the anti-solar horizon is darker
    assert!(at(0.0, 90.0, 85.0, 180.0)[1] < at(0.0, 90.0, 85.0, 0.0)[1]);
}

#[test]
fn every_light_is_finite_and_not_negative() {
    let solved = solve(&optics(0.3, &[450.0, 650.0]), 0.2);
    for km in [0.0, 0.2, 6.0, 30.0] {
        for sun in [0.0, 60.0, 89.9, 90.0, 93.0, 96.0] {
            let directions: Vec<SkyDirection> = (0..=36)
                .flat_map(|z| {
                    [0.0, 90.0, 180.0].map(|a| SkyDirection::from_degrees(f64::from(z) * 5.0, a))
                })
                .collect();
            let all =
                solved.radiance_ratio(Length::from_km(km), Angle::from_degrees(sun), &directions);
            assert!(
                all.iter().all(|l| l.is_finite() && *l >= 0.0),
                "{km} km, sun {sun}"
            );
            assert!(all[0] > 0.0);
        }
    }
}

#[test]
fn bad_input_is_refused() {
    let good = optics(0.1, &[550.0]);
    let settings = TransportSettings::default();
    assert!(matches!(
        Transport::solve(&good, 1.5, &settings),
        Err(TransportError::Albedo(_))
    ));
    let bad = OpticalProfile {
        aerosol_g: vec![0.0; 3],
        ..good.clone()
    };
    assert!(matches!(
        Transport::solve(&bad, 0.2, &settings),
        Err(TransportError::Shape { .. })
    ));
    let few = TransportSettings {
        most_orders: 2,
        ..settings
    };
    assert!(matches!(
        Transport::solve(&good, 0.2, &few),
        Err(TransportError::NotConverged { orders: 2, .. })
    ));
}
