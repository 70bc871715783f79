//! Skies that do not decide all of the coefficients, or none: the fit stays a sky, says how well it is
//! determined, and refuses what is no sky at all.

#![expect(clippy::unwrap_used, reason = "tests")]

use sky_core::air_mass::relative_air_mass;
use sky_core::direction::SkyDirection;
use sky_core::quantity::{Angle, Length};
use sky_fit::problem::{
    Channel, ChannelFit, FitError, FitOptions, Sample, SkySamples, Starts, fit_channel,
};
use sky_science::direction::report_directions;
use sky_science::perez::PerezCoefficients;
use sky_science::perez::plane_parallel_air_mass;

const RAYLEIGH: PerezCoefficients = PerezCoefficients::from_array([-0.995, -0.1, 0.1, -0.8, 0.85]);
const HAZE: PerezCoefficients = PerezCoefficients::from_array([-0.8, -0.5, 6.0, -3.0, 0.3]);

fn weight(direction: &SkyDirection, sun: Angle) -> f64 {
    if direction.scattering_angle(sun).degrees() < 5.0 {
        0.0
    } else {
        // Rings share the hemisphere by the sine of their zenith angle; the zenith has a cap.
        direction.view_zenith.radians().sin().max(0.05)
    }
}

fn samples(
    directions: &[SkyDirection],
    sun: Angle,
    value: impl Fn(f64, Angle) -> f64,
) -> Vec<Sample> {
    directions
        .iter()
        .map(|direction| {
            let air_mass = relative_air_mass(
                direction.view_zenith.radians().cos(),
                Length::ZERO,
                Length::from_km(8.0),
            );
            let scattering_angle = direction.scattering_angle(sun);
            Sample {
                air_mass,
                scattering_angle,
                value: value(air_mass, scattering_angle),
                weight: weight(direction, sun),
            }
        })
        .collect()
}

fn fit(samples: &[Sample], sun: Angle, channel: Channel) -> Result<ChannelFit, FitError> {
    let sky = SkySamples {
        samples,
        sun_zenith: sun,
        zenith_air_mass: 1.0,
    };
    fit_channel(&sky, channel, Starts::Several, &FitOptions::default())
}

/// Fits, and checks that the result is a sky that keeps `rms` and gives the samples back.
fn fits(samples: &[Sample], sun: Angle, channel: Channel, rms: f64) -> ChannelFit {
    let fit = fit(samples, sun, channel).unwrap();
    assert!(fit.report.why_stopped.converged(), "{fit:?}");
    assert!(fit.report.rms <= rms, "{fit:?}");
    assert_eq!(fit.coefficients.check(0.999), Ok(()));
    assert!(fit.zenith_value > 0.0 && fit.zenith_value.is_finite());
    assert!(fit.report.condition_number >= 1.0);
    let worst = samples
        .iter()
        .filter(|s| s.weight > 0.0)
        .map(|s| {
            let model = fit.zenith_value
                * fit
                    .coefficients
                    .relative_to_zenith(s.air_mass, s.scattering_angle, 1.0, sun);
            match channel {
                Channel::Luminance => (model / s.value).ln().abs(),
                Channel::ChromaticityX | Channel::ChromaticityY => (model - s.value).abs(),
            }
        })
        .fold(0.0, f64::max);
    assert!(
        (worst - fit.report.max_residual).abs() < 1e-9 + 1e-6 * worst,
        "{worst} {fit:?}"
    );
    fit
}

#[test]
fn a_uniform_sky() {
    let sun = Angle::from_degrees(40.0);
    for (channel, value) in [
        (Channel::Luminance, 2000.0),
        (Channel::ChromaticityX, 0.31),
        (Channel::ChromaticityY, 0.33),
    ] {
        let flat = samples(&report_directions(), sun, |_, _| value);
        let fit = fits(&flat, sun, channel, 2e-3);
        assert!((fit.zenith_value / value - 1.0).abs() < 5e-3, "{fit:?}");
    }
}

#[test]
fn the_sun_in_the_zenith() {
    let sun = Angle::ZERO;
    for truth in [RAYLEIGH, HAZE] {
        let map = samples(&report_directions(), sun, |m, gamma| {
            truth.relative_luminance(m, gamma)
        });
        let fit = fits(&map, sun, Channel::Luminance, 1e-3);
        // Gradation and indicatrix see the same angle: the report says so.
        assert!(fit.report.condition_number > 30.0, "{fit:?}");
    }
}

#[test]
fn the_sun_below_the_horizon() {
    let sun = Angle::from_degrees(94.0);
    let map = samples(&report_directions(), sun, |m, gamma| {
        // Three decades between the glow and the opposite side.
        0.01 * HAZE.relative_luminance(m, gamma) * (-2.2 * gamma.radians()).exp()
    });
    let _fit = fits(&map, sun, Channel::Luminance, 0.7);
}

#[test]
fn a_single_ring() {
    let sun = Angle::from_degrees(50.0);
    let ring: Vec<SkyDirection> = (0..30)
        .map(|i| SkyDirection::from_degrees(70.0, f64::from(i) * 12.0))
        .collect();
    let map = samples(&ring, sun, |m, gamma| HAZE.relative_luminance(m, gamma));
    let fit = fits(&map, sun, Channel::Luminance, 1e-3);
    // One air mass tells nothing of A and B: the pull to the reference decides.
    assert!(fit.report.condition_number > 1e6, "{fit:?}");
    let reference = Channel::Luminance.reference();
    assert!(
        (fit.coefficients.b / reference.b).ln().abs() < 1.0,
        "{fit:?}"
    );
}

#[test]
fn twenty_directions() {
    let sun = Angle::from_degrees(55.0);
    let few: Vec<SkyDirection> = (0..20)
        .map(|i| SkyDirection::from_degrees(f64::from(i) * 4.6, f64::from(i) * 77.0))
        .collect();
    for truth in [RAYLEIGH, HAZE] {
        let map = samples(&few, sun, |m, gamma| truth.relative_luminance(m, gamma));
        let _fit = fits(&map, sun, Channel::Luminance, 1e-3);
    }
}

#[test]
fn a_black_map_and_what_is_no_number_are_refused() {
    let sun = Angle::from_degrees(55.0);
    let good = samples(&report_directions(), sun, |m, gamma| {
        HAZE.relative_luminance(m, gamma)
    });
    let with = |change: &dyn Fn(&mut Vec<Sample>)| {
        let mut bad = good.clone();
        change(&mut bad);
        fit(&bad, sun, Channel::Luminance).map(|_| ()).unwrap_err()
    };
    let black = with(&|s| s.iter_mut().for_each(|s| s.value = 0.0));
    assert_eq!(black, FitError::Black);
    assert!(matches!(
        with(&|s| s[7].value = 0.0),
        FitError::Value { index: 7, .. }
    ));
    assert!(matches!(
        with(&|s| s[8].value = f64::NAN),
        FitError::Value { index: 8, .. }
    ));
    assert!(matches!(
        with(&|s| s[9].weight = -1.0),
        FitError::Weight { index: 9, .. }
    ));
    assert!(matches!(
        with(&|s| s[3].air_mass = f64::NAN),
        FitError::AirMass { index: 3, .. }
    ));
    assert!(matches!(
        with(&|s| s[4].scattering_angle = Angle::from_degrees(-3.0)),
        FitError::ScatteringAngle { index: 4, .. }
    ));
    assert!(matches!(
        with(&|s| s.truncate(5)),
        FitError::TooFew {
            expected: 6,
            found: 5
        }
    ));
    assert!(matches!(
        with(&Vec::clear),
        FitError::TooFew { found: 0, .. }
    ));
}

#[test]
fn one_over_cosine_fits_through_an_infinite_mass() {
    let sun = Angle::from_degrees(55.0);
    let map: Vec<Sample> = report_directions()
        .iter()
        .map(|d| {
            // Exactly horizontal: the cosine in floating point is not 0.
            let cosine = d.view_zenith.radians().cos();
            let air_mass = plane_parallel_air_mass(if cosine < 1e-9 { 0.0 } else { cosine });
            let scattering_angle = d.scattering_angle(sun);
            Sample {
                air_mass,
                scattering_angle,
                value: HAZE.relative_luminance(air_mass, scattering_angle),
                weight: weight(d, sun),
            }
        })
        .collect();
    assert!(map.iter().any(|s| s.air_mass.is_infinite()));
    let fit = fits(&map, sun, Channel::Luminance, 1e-3);
    for (x, y) in fit.coefficients.to_array().iter().zip(HAZE.to_array()) {
        assert!((x / y - 1.0).abs() < 0.05, "{fit:?}");
    }
}

#[test]
fn chromaticity_with_an_inverted_gradation() {
    // Redder toward the horizon, and a chromaticity that falls around the sun: C and E negative.
    let sun = Angle::from_degrees(70.0);
    let truth = PerezCoefficients::from_array([0.4, -0.3, -0.15, -2.0, -0.05]);
    let map = samples(&report_directions(), sun, |m, gamma| {
        0.3 * truth.relative_luminance(m, gamma)
    });
    for channel in [Channel::ChromaticityX, Channel::ChromaticityY] {
        let _fit = fits(&map, sun, channel, 2e-4);
    }
}

#[test]
fn the_pull_costs_next_to_nothing_and_a_fit_repeats_to_the_bit() {
    let sun = Angle::from_degrees(55.0);
    let map = samples(&report_directions(), sun, |m, gamma| {
        // A second, narrow aureole that the formula cannot carry.
        HAZE.relative_luminance(m, gamma) + 4.0 * (-14.0 * gamma.radians()).exp()
    });
    let sky = SkySamples {
        samples: &map,
        sun_zenith: sun,
        zenith_air_mass: 1.0,
    };
    let free = FitOptions {
        regularization: Some(0.0),
        ..FitOptions::default()
    };
    let without = fit_channel(&sky, Channel::Luminance, Starts::Several, &free).unwrap();
    let with = fits(&map, sun, Channel::Luminance, 0.1);
    assert!(
        with.report.rms < without.report.rms * 1.001,
        "{with:?} {without:?}"
    );
    assert_eq!(with, fits(&map, sun, Channel::Luminance, 0.1));
    // A neighbor's coefficients lead to the same place in fewer steps.
    let near = fit_channel(
        &sky,
        Channel::Luminance,
        Starts::Near(&HAZE),
        &FitOptions::default(),
    )
    .unwrap();
    assert!((near.report.final_cost / with.report.final_cost - 1.0).abs() < 1e-4);
}
