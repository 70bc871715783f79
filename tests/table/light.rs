//! The light of a scene, against sums over the transport engine's sky and its beam.

#![expect(
    clippy::print_stdout,
    reason = "the measured figures are part of the test's answer"
)]

use core::f64::consts::PI;
use std::sync::LazyLock;

use sky_core::color::{LinearSrgb, xyz_from_linear_srgb};
use sky_core::conditions::Conditions;
use sky_core::direction::{SkyDirection, horizon_zenith};
use sky_core::light::harmonics;
use sky_core::picture::Picture;
use sky_core::quantity::{Angle, EARTH_RADIUS_KM, single};
use sky_core::utm_sky::UtmSky;
use sky_science::cie::ColorWeights;
use sky_science::metrics::Statistics;
use sky_science::sky_model::SkyModel;
use sky_science::spectrum::Spectrum;
use sky_sim::solar::SolarSpectrum;

use crate::cases::Ranges;
use crate::truth::TRUTH;

const DAY: Ranges = Ranges {
    altitude_km: [0.0, 30.0],
    turbidity: [1.0, 8.0],
    sun_zenith_deg: [0.0, 92.0],
};

static WEIGHTS: LazyLock<ColorWeights> = LazyLock::new(|| {
    let sun = SolarSpectrum::g173();
    let sun = Spectrum::new(sun.wavelength_nm, sun.irradiance_w_m2_nm).expect("a spectrum");
    ColorWeights::for_radiance_ratio(&TRUTH.settings().wavelength_nm, &sun).expect("weights")
});

fn luminance(rgb: [f32; 3]) -> f64 {
    let [red, green, blue] = rgb.map(f64::from);
    xyz_from_linear_srgb(LinearSrgb { red, green, blue }).y
}

/// Illuminance of a horizontal plane by a sky \[lx\]: the middles of rings and sectors, closer toward the
/// horizon and the sun's azimuth.
fn sky_illuminance(sky: &dyn SkyModel, conditions: &Conditions) -> f64 {
    const RINGS: u16 = 40;
    const SECTORS: u16 = 24;
    let middle = |i: u16, of: u16| (f64::from(i) + 0.5) / f64::from(of);
    let mut directions = Vec::new();
    let mut weights = Vec::new();
    for ring in 0..RINGS {
        let root = middle(ring, RINGS);
        let cosine = root * root;
        for sector in 0..SECTORS {
            let share = middle(sector, SECTORS);
            directions.push(SkyDirection {
                view_zenith: Angle::from_radians(cosine.acos()),
                relative_azimuth: Angle::from_radians(PI * share * share),
            });
            let area = 2.0 * root / f64::from(RINGS) * 2.0 * PI * 2.0 * share / f64::from(SECTORS);
            weights.push(cosine * area);
        }
    }
    let lights = sky
        .yxy_map(conditions, &directions)
        .expect("inside the domain");
    let weighted = lights
        .iter()
        .zip(&weights)
        .map(|(l, w)| w * l.luminance_cd_m2);
    weighted.sum()
}

/// Illuminance of a plane that faces the sun by the beam through the engine's air \[lx\].
fn sun_illuminance(conditions: &Conditions) -> f64 {
    let optics = TRUTH.optics(conditions.turbidity).expect("optics");
    let radius = EARTH_RADIUS_KM + conditions.observer_altitude.km();
    let cosine = conditions.sun_zenith.radians().cos();
    let count = optics.wavelength_nm.len();
    let mut depth = vec![0.0; count];
    let steps = 4000_u16;
    let top = EARTH_RADIUS_KM + optics.altitude_km[optics.altitude_km.len() - 1];
    let length = (top * top - radius * radius * (1.0 - cosine * cosine)).sqrt() - radius * cosine;
    // steps that grow with the square of the distance
    for i in 0..steps {
        let at = |k: f64| length * (k / f64::from(steps)).powi(2);
        let (from, to) = (at(f64::from(i)), at(f64::from(i) + 1.0));
        let s = 0.5 * (from + to);
        let z = (radius * radius + s * (s + 2.0 * radius * cosine)).sqrt() - EARTH_RADIUS_KM;
        let upper = optics.altitude_km.partition_point(|a| *a <= z);
        let upper = upper.clamp(1, optics.altitude_km.len() - 1);
        let [low, high] = [optics.altitude_km[upper - 1], optics.altitude_km[upper]];
        let f = (z - low) / (high - low);
        for (w, depth) in depth.iter_mut().enumerate() {
            let at = |level: usize| {
                let i = level * count + w;
                optics.rayleigh_scattering_per_km[i]
                    + optics.gas_absorption_per_km[i]
                    + optics.aerosol_scattering_per_km[i]
                    + optics.aerosol_absorption_per_km[i]
            };
            *depth += (to - from) * ((1.0 - f) * at(upper - 1) + f * at(upper));
        }
    }
    let through: Vec<f64> = depth.iter().map(|d| (-d).exp()).collect();
    WEIGHTS.xyz(&through).y
}

fn picture(sky: &UtmSky, conditions: &Conditions) -> Picture {
    Picture::new(sky, conditions, 0.2).expect("inside the domain")
}

/// From the zenith to 92°: the light of a sky, and of a sun that is up.
#[test]
fn a_scene_is_lit_as_the_transport_engine_has_it() {
    let sky = UtmSky::embedded().expect("the table");
    let (mut by_sky, mut by_sun, mut own) = (Vec::new(), Vec::new(), Vec::new());
    for c in DAY.conditions("scene light", 6, 48) {
        let light = picture(&sky, &c).light;
        let error = |found: [f32; 3], expected: f64| (luminance(found) / expected - 1.0).abs();
        let of_sky = error(light.sky_horizontal, sky_illuminance(&*TRUTH, &c));
        own.push(error(light.sky_horizontal, sky_illuminance(&sky, &c)));
        let mut told = format!("{c:?}: sky {of_sky:.4} own {:.4}", own[own.len() - 1]);
        by_sky.push(of_sky);
        // the disc sets over half a degree
        if c.sun_zenith.degrees() < horizon_zenith(c.observer_altitude).degrees() - 0.3 {
            let of_sun = error(light.sun_normal, sun_illuminance(&c));
            told += &format!(", sun {of_sun:.4}");
            by_sun.push(of_sun);
        }
        println!("{told}");
    }
    for (what, errors, [p95, max]) in [
        ("summed", own, [0.009, 0.0125]),
        ("sky", by_sky, [0.04, 0.05]),
        ("sun", by_sun, [0.007, 0.013]),
    ] {
        let found = Statistics::of(&errors).expect("cases");
        println!("{what}: {found:?}");
        assert!(found.count > 40, "{what}: {found:?}");
        assert!(found.p95 < p95 && found.max < max, "{what}: {found:?}");
    }
}

/// Nine harmonics against sums over the sky and the ground that they stand for.
#[test]
fn the_harmonics_are_those_of_sky_and_ground() {
    let sky = UtmSky::embedded().expect("the table");
    let mut errors = Vec::new();
    for c in DAY.conditions("harmonics", 48, 24) {
        let picture = picture(&sky, &c);
        let cos_horizon = horizon_zenith(c.observer_altitude).radians().cos();
        let mut sums = [0.0; 9];
        let (rings, sectors) = (600_u16, 96_u16);
        for ring in 0..rings {
            let z = 2.0 * (f64::from(ring) + 0.5) / f64::from(rings) - 1.0;
            for sector in 0..sectors {
                let turn = core::f64::consts::TAU * (f64::from(sector) + 0.5) / f64::from(sectors);
                let level = (1.0 - z * z).sqrt();
                let direction = [level * turn.cos(), level * turn.sin(), z].map(single);
                let rgb = if z > cos_horizon {
                    picture
                        .sky
                        .linear_srgb(direction)
                        .unwrap_or(picture.light.ground)
                } else {
                    picture.light.ground
                };
                let solid_angle = 4.0 * PI / f64::from(rings) / f64::from(sectors);
                for (sum, factor) in sums.iter_mut().zip(harmonics(direction)) {
                    *sum += solid_angle * f64::from(factor) * luminance(rgb);
                }
            }
        }
        // as shares of the mean
        let all = picture.light.harmonics.iter().zip(sums);
        let of_all = all.map(|(found, expected)| (luminance(*found) - expected).abs() / sums[0]);
        let worst = of_all.fold(0.0, f64::max);
        println!("{c:?}: {worst:.4}");
        errors.push(worst);
    }
    let found = Statistics::of(&errors).expect("cases");
    println!("{found:?}");
    assert!(found.p95 < 0.035 && found.max < 0.13, "{found:?}");
}
