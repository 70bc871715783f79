//! Color with the real sun: published check values, and how much a coarse wavelength grid costs.

use sky_core::color::{Yxy, linear_srgb_from_xyz};
use sky_science::cie::ColorWeights;
use sky_science::spectrum::{Spectrum, uniform_wavelengths};
use sky_sim::solar::SolarSpectrum;

fn close(found: f64, expected: f64, tolerance: f64) {
    assert!(
        (found - expected).abs() <= tolerance,
        "{found} is not {expected} within {tolerance}"
    );
}

fn sun() -> Spectrum {
    let g173 = SolarSpectrum::g173();
    Spectrum::new(g173.wavelength_nm, g173.irradiance_w_m2_nm).expect("the sun's spectrum is valid")
}

#[test]
fn the_extraterrestrial_sun_has_the_published_illuminance_and_chromaticity() {
    // ASTM G173 with 683.002 lm/W, 360-830 nm: 133.10 klx, x = 0.323379, y = 0.332660.
    let sun = sun();
    let weights = ColorWeights::for_spectral_radiance(sun.wavelength_nm()).unwrap();
    let xyz = weights.xyz(sun.values());
    close(xyz.x, 129_387.6, 0.5);
    close(xyz.y, 133_100.8, 0.5);
    close(xyz.z, 137_622.7, 0.5);
    let yxy = weights.yxy(sun.values());
    close(yxy.x, 0.323_379, 1e-6);
    close(yxy.y, 0.332_660, 1e-6);
    let rgb = linear_srgb_from_xyz(xyz);
    close(rgb.red / xyz.y, 1.097_62, 2e-5);
    close(rgb.green / xyz.y, 0.976_73, 2e-5);
    close(rgb.blue / xyz.y, 0.942_98, 2e-5);
}

#[test]
fn the_plain_rule_is_the_trapezoid_on_the_given_wavelengths() {
    // Made with a separate script from the CIE table: uneven grid, L = 0.1 (550/λ)^4.
    let grid = [
        400.5, 410.0, 433.3, 450.0, 480.0, 500.0, 520.25, 550.0, 570.0, 600.0, 640.0, 700.0,
    ];
    let radiance = grid.map(|nm| 0.1 * (550.0_f64 / nm).powi(4));
    let xyz = ColorWeights::for_spectral_radiance(&grid)
        .unwrap()
        .xyz(&radiance);
    close(xyz.x, 7_423.908_193_904_7, 1e-8);
    close(xyz.y, 7_270.101_721_501_5, 1e-8);
    close(xyz.z, 15_779.017_702_661_9, 1e-8);
}

#[test]
fn a_sun_known_only_on_the_grid_gives_the_plain_rule() {
    let grid = uniform_wavelengths(380.0, 780.0, 10.0).unwrap();
    let ratio: Vec<f64> = grid.iter().map(|nm| (550.0 / nm).powi(4)).collect();
    let full = sun();
    let values: Vec<f64> = grid.iter().map(|&nm| full.at(nm).unwrap()).collect();
    let coarse_sun = Spectrum::new(grid.clone(), values.clone()).unwrap();
    let by_ratio = ColorWeights::for_radiance_ratio(&grid, &coarse_sun)
        .unwrap()
        .yxy(&ratio);
    let radiance: Vec<f64> = ratio.iter().zip(&values).map(|(r, e)| r * e).collect();
    let plain = ColorWeights::for_spectral_radiance(&grid)
        .unwrap()
        .yxy(&radiance);
    close(by_ratio.luminance_cd_m2 / plain.luminance_cd_m2, 1.0, 1e-12);
    close(by_ratio.x, plain.x, 1e-12);
    close(by_ratio.y, plain.y, 1e-12);
}

/// A clear sky's ratio L/E0 in miniature: Rayleigh light through a haze and ozone-like band.
fn sky_ratio(nm: f64) -> f64 {
    let rayleigh = 0.1 * (550.0 / nm).powi(4);
    let ozone = 0.04 * (-((nm - 600.0) / 50.0).powi(2)).exp();
    let haze = 0.1 * (550.0 / nm).powf(1.3);
    (rayleigh + 0.3 * haze) * (-3.0 * (rayleigh + ozone)).exp()
}

#[test]
fn ten_nm_steps_are_enough_with_the_sun_in_the_weights_and_not_without() {
    let sun = sun();
    let color = |step: f64| -> (Yxy, Yxy) {
        let grid = uniform_wavelengths(380.0, 780.0, step).unwrap();
        let ratio: Vec<f64> = grid.iter().map(|&nm| sky_ratio(nm)).collect();
        let radiance: Vec<f64> = grid
            .iter()
            .map(|&nm| sky_ratio(nm) * sun.at(nm).unwrap())
            .collect();
        (
            ColorWeights::for_radiance_ratio(&grid, &sun)
                .unwrap()
                .yxy(&ratio),
            ColorWeights::for_spectral_radiance(&grid)
                .unwrap()
                .yxy(&radiance),
        )
    };
    let (truth, plain_truth) = color(1.0);
    close(
        truth.luminance_cd_m2 / plain_truth.luminance_cd_m2,
        1.0,
        1e-12,
    );
    // Relative luminance, x and y: what a step of 5, 10 and 20 nm costs.
    for (step, limit) in [(5.0, 1e-5), (10.0, 1e-4), (20.0, 1e-3)] {
        let (weighted, _) = color(step);
        close(weighted.luminance_cd_m2 / truth.luminance_cd_m2, 1.0, limit);
        close(weighted.x, truth.x, limit);
        close(weighted.y, truth.y, limit);
    }
    let (_, plain) = color(10.0);
    let plain_error = (plain.x - truth.x).hypot(plain.y - truth.y);
    assert!(plain_error > 1e-3, "{plain_error}");
}
