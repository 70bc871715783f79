//! Aerial perspective against the transport engine's own difference L(observer) − T · L(object).

#![expect(
    clippy::print_stdout,
    reason = "the measured figures are part of the test's answer"
)]

use sky_core::aerial::{AerialFrame, AerialPath, path_meets_ground};
use sky_core::color::{LinearSrgb, xyz_from_linear_srgb};
use sky_core::conditions::Conditions;
use sky_core::direction::SkyDirection;
use sky_core::haze::Haze;
use sky_core::quantity::{Angle, EARTH_RADIUS_KM, Length, single};
use sky_core::utm_sky::UtmSky;
use sky_eval::truth::{DEFAULT_GROUND_ALBEDO, TransportSky};
use sky_science::cie::ColorWeights;
use sky_science::spectrum::Spectrum;
use sky_science::utm2005::path_utm2005;
use sky_sim::optics::{OpticalProfile, OpticsSettings};
use sky_sim::profile::AtmosphereProfile;
use sky_sim::solar::SolarSpectrum;

/// Fractional part of multiples of irrational numbers: even, repeatable cover of a cube.
fn even(i: u32, dimension: usize) -> f64 {
    const STEPS: [f64; 6] = [
        0.754_877_666,
        0.569_840_290,
        0.438_579_021,
        0.324_717_957,
        0.245_122_333,
        0.819_172_513,
    ];
    (0.5 + f64::from(i) * STEPS[dimension]).fract()
}

struct Case {
    conditions: Conditions,
    direction: SkyDirection,
    distance_km: f64,
}

/// 200 paths: up, level and down, 1–300 km, observers at 0–20 km, T 1–8; objects below 30 km and
/// above the ground.
fn cases() -> Vec<Case> {
    let mut out = Vec::new();
    let mut i = 0;
    while out.len() < 200 {
        i += 1;
        // eight paths share haze and sun, so that an atmosphere is solved once for them
        let sky = u32::try_from(out.len() / 8).expect("a small number");
        let altitude_km = 20.0 * even(i, 0).powi(2);
        let zenith = match out.len() % 3 {
            0 => 20.0 + 68.0 * even(i, 1),
            1 => 88.0 + 4.0 * even(i, 1),
            _ => 92.0 + 58.0 * even(i, 1).powi(2),
        };
        let case = Case {
            conditions: Conditions {
                observer_altitude: Length::from_km(altitude_km),
                turbidity: 8.0_f64.powf(even(sky, 4)),
                sun_zenith: Angle::from_degrees(90.0 * even(sky, 5)),
            },
            direction: SkyDirection::from_degrees(zenith, 180.0 * even(i, 2)),
            distance_km: 300.0_f64.powf(even(i, 3)),
        };
        let (end, _, _) = at_object(&case);
        let meets = path_meets_ground(
            single(altitude_km),
            case.direction.unit_vector(),
            single(case.distance_km),
        );
        if !meets && end.km() > 0.0 && end.km() < 30.0 {
            out.push(case);
        }
    }
    out
}

/// Altitude, sun and direction of the ray where the object is.
fn at_object(case: &Case) -> (Length, Angle, SkyDirection) {
    let radius = EARTH_RADIUS_KM + case.conditions.observer_altitude.km();
    let d = case.direction.unit_vector().map(f64::from);
    let sun = case.conditions.sun_zenith.radians();
    let sun = [sun.sin(), 0.0, sun.cos()];
    let place = [
        case.distance_km * d[0],
        case.distance_km * d[1],
        case.distance_km * d[2] + radius,
    ];
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let there = dot(place, place).sqrt();
    let up = place.map(|c| c / there);
    let level = |v: [f64; 3]| {
        let rise = dot(v, up);
        let flat: [f64; 3] = core::array::from_fn(|i| v[i] - rise * up[i]);
        (rise, flat)
    };
    let ((cos_view, view), (cos_sun, sun)) = (level(d), level(sun));
    let lengths = (dot(view, view) * dot(sun, sun)).sqrt();
    let cos_azimuth = if lengths > 0.0 {
        dot(view, sun) / lengths
    } else {
        1.0
    };
    (
        Length::from_km(there - EARTH_RADIUS_KM),
        Angle::from_radians(cos_sun.clamp(-1.0, 1.0).acos()),
        SkyDirection {
            view_zenith: Angle::from_radians(cos_view.clamp(-1.0, 1.0).acos()),
            relative_azimuth: Angle::from_radians(cos_azimuth.clamp(-1.0, 1.0).acos()),
        },
    )
}

/// Transmittance of a path at the optics' wavelengths, by fine steps along the ray.
fn transmittance(optics: &OpticalProfile, case: &Case) -> Vec<f64> {
    let count = optics.wavelength_nm.len();
    let mut depth = vec![0.0; count];
    const STEPS: u32 = 2000;
    let radius = EARTH_RADIUS_KM + case.conditions.observer_altitude.km();
    let cosine = case.direction.view_zenith.radians().cos();
    let step = case.distance_km / f64::from(STEPS);
    for i in 0..STEPS {
        let s = (f64::from(i) + 0.5) * step;
        let z = (radius * radius + s * (s + 2.0 * radius * cosine)).sqrt() - EARTH_RADIUS_KM;
        let upper = optics
            .altitude_km
            .partition_point(|a| *a <= z)
            .clamp(1, optics.altitude_km.len() - 1);
        let (low, high) = (optics.altitude_km[upper - 1], optics.altitude_km[upper]);
        let f = (z - low) / (high - low);
        for (w, depth) in depth.iter_mut().enumerate() {
            let at = |level: usize| {
                let i = level * count + w;
                optics.rayleigh_scattering_per_km[i]
                    + optics.gas_absorption_per_km[i]
                    + optics.aerosol_scattering_per_km[i]
                    + optics.aerosol_absorption_per_km[i]
            };
            *depth += step * ((1.0 - f) * at(upper - 1) + f * at(upper));
        }
    }
    depth.iter().map(|d| (-d).exp()).collect()
}

fn p95(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() * 95 / 100]
}

fn luminance(path: &AerialPath) -> f64 {
    let [red, green, blue] = path.inscatter.map(f64::from);
    xyz_from_linear_srgb(LinearSrgb { red, green, blue }).y
}

#[test]
fn finite_paths_meet_the_transport_engine() {
    let profile = AtmosphereProfile::general();
    let settings = OpticsSettings::with_step_nm(20).expect("a step");
    let truth = TransportSky::new(profile.clone(), settings.clone(), DEFAULT_GROUND_ALBEDO)
        .expect("an engine");
    let sun = SolarSpectrum::g173();
    let sun = Spectrum::new(sun.wavelength_nm, sun.irradiance_w_m2_nm).expect("a spectrum");
    let weights = ColorWeights::for_radiance_ratio(&settings.wavelength_nm, &sun).expect("weights");
    let sky = UtmSky::embedded().expect("a table");
    let white = weights.xyz(&vec![1.0; settings.wavelength_nm.len()]).y;
    let mut errors = [const { Vec::new() }; 4];
    for (i, case) in cases().iter().enumerate() {
        let c = &case.conditions;
        let optics = OpticalProfile::build(
            &profile,
            &OpticsSettings {
                haze: Haze::Turbidity(c.turbidity),
                ..settings.clone()
            },
        )
        .expect("optics");
        let through = transmittance(&optics, case);
        let through_y = weights.xyz(&through).y / white;
        let (altitude, sun_zenith, direction) = at_object(case);
        let solved = truth.solved(c.turbidity).expect("thin air");
        let near = solved.radiance_ratio(c.observer_altitude, c.sun_zenith, &[case.direction]);
        let far = solved.radiance_ratio(altitude, sun_zenith, &[direction]);
        let scattered: Vec<f64> = (0..near.len())
            .map(|w| near[w] - through[w] * far[w])
            .collect();
        let scattered_y = weights.xyz(&scattered).y;
        let horizon = SkyDirection {
            view_zenith: Angle::from_degrees(89.5),
            ..case.direction
        };
        let horizon = solved.radiance_ratio(c.observer_altitude, c.sun_zenith, &[horizon]);
        let scale = scattered_y.max(0.05 * weights.xyz(&horizon).y);

        let frame = sky.frame(c).expect("inside the domain");
        let air = AerialFrame::new(&sky, c.turbidity, c.sun_zenith).expect("a table with air");
        let (h, d, s) = (
            single(c.observer_altitude.km()),
            case.direction.unit_vector(),
            single(case.distance_km),
        );
        let found = [air.path(h, d, s), path_utm2005(&air, &frame, h, d, s)];
        let mut row = [0.0; 4];
        for (k, path) in found.iter().enumerate() {
            let t = f64::from(path.transmittance[3]);
            // relative where the object can be seen at all (2 %), absolute beyond
            row[k] = (t - through_y).abs() / through_y.max(0.02);
            row[2 + k] = (luminance(path) - scattered_y).abs() / scale;
        }
        for (errors, value) in errors.iter_mut().zip(row) {
            errors.push(value);
        }
        println!(
            "{i:3} h {h:5.2} T {:4.2} sun {:4.1} view {:5.1} az {:5.1} s {s:6.1} end {:5.2}: T {through_y:.4} err {:.4} in {scattered_y:8.1} err {:.4} ({:.4})",
            c.turbidity,
            c.sun_zenith.degrees(),
            case.direction.view_zenith.degrees(),
            case.direction.relative_azimuth.degrees(),
            altitude.km(),
            row[0],
            row[2],
            row[3],
        );
    }
    let [t, t2005, inscatter, inscatter2005] = errors.map(p95);
    println!("transmittance p95: default {t:.4}, utm2005 {t2005:.4}");
    println!("in-scattered light p95: default {inscatter:.4}, utm2005 {inscatter2005:.4}");
    assert!(t <= 0.03, "transmittance: {t}");
    assert!(inscatter <= 0.08, "in-scattered light: {inscatter}");
}

#[test]
fn a_path_beyond_the_air_takes_no_more_light() {
    // Found by the atlas: the sections of a long path stepped over the ozone and the haze, and 1000 km
    // upward let 4 % more through than 400 km.
    let sky = UtmSky::embedded().expect("a table");
    for (turbidity, sun) in [(1.06, 13.5), (4.0, 80.0)] {
        let sun = Angle::from_degrees(sun);
        let air = AerialFrame::new(&sky, turbidity, sun).expect("the table's domain");
        for zenith in [0.0, 13.5, 60.0, 85.0] {
            let direction = SkyDirection::from_degrees(zenith, 0.0).unit_vector();
            let through = |km: f32| air.path(0.0, direction, km).transmittance;
            let space = through(1000.0);
            for km in [100.0, 200.0, 400.0, 700.0] {
                for (near, far) in through(km).iter().zip(space) {
                    assert!(
                        (near - far).abs() < 0.01 || near > &far,
                        "{zenith} {km}: {near} {far}"
                    );
                }
            }
            let at_top = through(400.0);
            let same = at_top.iter().zip(space).all(|(a, b)| (a - b).abs() < 1e-6);
            assert!(zenith > 60.0 || same, "{zenith}");
        }
    }
}
