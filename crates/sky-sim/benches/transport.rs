//! Time of the transport engine on the report's 75 maps: 3 hazes × 5 altitudes × 5 suns, 271
//! directions, 41 wavelengths. The target is 4 s on 2 cores.
//!
//! `cargo bench -p sky-sim --bench transport`

use std::hint::black_box;

use sky_core::haze::Haze;
use sky_core::quantity::{Angle, Length};
use sky_science::direction::report_directions;
use sky_sim::optics::{OpticalProfile, OpticsSettings};
use sky_sim::profile::AtmosphereProfile;
use sky_sim::transport::{Transport, TransportSettings};

#[path = "../../../tests/support/bench.rs"]
mod bench;

const AEROSOL_OPTICAL_DEPTH_500: [f64; 3] = [0.0, 0.5, 1.0];
const ALTITUDE_KM: [f64; 5] = [0.0, 6.0, 12.0, 20.0, 30.0];
const SUN_ZENITH_DEG: [f64; 5] = [90.0, 45.0, 0.0, 45.0, 90.0];
const GROUND_ALBEDO: f64 = 0.2;

fn optics(profile: &AtmosphereProfile, aerosol_optical_depth_500: f64) -> OpticalProfile {
    let mut settings = OpticsSettings::with_step_nm(10).expect("an offered step");
    settings.haze = Haze::OpticalDepth500(aerosol_optical_depth_500);
    assert_eq!(settings.wavelength_nm.len(), 41);
    OpticalProfile::build(profile, &settings).expect("the general atmosphere")
}

fn solve(optics: &OpticalProfile) -> Transport {
    Transport::solve(optics, GROUND_ALBEDO, &TransportSettings::default()).expect("a solution")
}

/// Sum of all radiances of the 25 maps of one haze, so that nothing is left out.
fn maps(transport: &Transport) -> f64 {
    let directions = report_directions();
    assert_eq!(directions.len(), 271);
    let mut sum = 0.0;
    for altitude in ALTITUDE_KM {
        for sun_zenith in SUN_ZENITH_DEG {
            let map = transport.radiance_ratio(
                Length::from_km(altitude),
                Angle::from_degrees(sun_zenith),
                &directions,
            );
            sum += map.iter().sum::<f64>();
        }
    }
    sum
}

fn main() {
    let profile = AtmosphereProfile::general();
    let optics = AEROSOL_OPTICAL_DEPTH_500.map(|depth| optics(&profile, depth));
    bench::time("75 maps x 271 directions x 41 wavelengths", || {
        let all = optics.iter().map(|o| maps(&solve(black_box(o))));
        all.sum::<f64>()
    });
    let hazy = &optics[1];
    bench::time("solution of one atmosphere", || solve(black_box(hazy)));
    let solved = solve(hazy);
    bench::time("25 maps of a solved atmosphere", || {
        maps(black_box(&solved))
    });
}
