//! The transport engine wherever an eye can be below 100 km, and beyond: parts that add up, lines that
//! meet themselves, light that is neither lost nor made.

#![expect(clippy::unwrap_used, reason = "tests")]
#![expect(
    clippy::print_stdout,
    reason = "the measured figures are part of the test's answer"
)]

use sky_core::direction::SkyDirection;
use sky_core::haze::Haze;
use sky_core::quantity::{Angle, EARTH_RADIUS_KM, Length};
use sky_science::metrics;
use sky_sim::optics::{OpticalProfile, OpticsSettings};
use sky_sim::profile::AtmosphereProfile;
use sky_sim::transport::{
    AnyGround, LightParts, Sight, Transport, TransportError, TransportSettings,
};
use std::sync::LazyLock;

fn optics(turbidity: f64) -> OpticalProfile {
    let settings = OpticsSettings {
        haze: Haze::Turbidity(turbidity),
        wavelength_nm: vec![450.0, 550.0, 650.0],
        ..OpticsSettings::default()
    };
    OpticalProfile::build(&AtmosphereProfile::general(), &settings).unwrap()
}

fn solve(optics: &OpticalProfile) -> AnyGround {
    AnyGround::solve(optics, &TransportSettings::default()).unwrap()
}

static CLEAR: LazyLock<AnyGround> = LazyLock::new(|| solve(&optics(1.0)));
static HAZY: LazyLock<AnyGround> = LazyLock::new(|| solve(&optics(4.0)));

/// Numbers in 0..1, the same in every run.
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        f64::from(u32::try_from((z ^ (z >> 31)) >> 32).unwrap()) / 4_294_967_296.0
    }

    fn between(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.roll()
    }
}

/// An eye, a sun and a direction.
#[derive(Clone, Copy, Debug)]
struct Line {
    altitude_km: f64,
    sun_cosine: f64,
    cosine: f64,
    cos_gamma: f64,
}

impl Line {
    fn from_degrees(altitude_km: f64, sun: f64, zenith: f64, azimuth: f64) -> Self {
        let sun = Angle::from_degrees(sun);
        let direction = SkyDirection::from_degrees(zenith, azimuth);
        Self {
            altitude_km,
            sun_cosine: sun.radians().cos(),
            cosine: direction.view_zenith.radians().cos(),
            cos_gamma: direction.cos_scattering_angle(sun),
        }
    }

    /// The same line from a point farther along it.
    fn from_farther(&self, length_km: f64) -> Self {
        let r = EARTH_RADIUS_KM + self.altitude_km;
        let far = (r * r + length_km * (length_km + 2.0 * r * self.cosine)).sqrt();
        Self {
            altitude_km: far - EARTH_RADIUS_KM,
            sun_cosine: (r * self.sun_cosine + length_km * self.cos_gamma) / far,
            cosine: (r * self.cosine + length_km) / far,
            cos_gamma: self.cos_gamma,
        }
    }

    fn light(&self, air: &AnyGround, length_km: Option<f64>) -> LightParts {
        let sines = ((1.0 - self.cosine.powi(2)) * (1.0 - self.sun_cosine.powi(2))).sqrt();
        let cos_azimuth = (self.cos_gamma - self.cosine * self.sun_cosine) / sines.max(1e-12);
        let sight = Sight {
            direction: SkyDirection {
                view_zenith: Angle::from_radians(self.cosine.clamp(-1.0, 1.0).acos()),
                relative_azimuth: Angle::from_radians(cos_azimuth.clamp(-1.0, 1.0).acos()),
            },
            length: length_km.map(Length::from_km),
        };
        let sun = Angle::from_radians(self.sun_cosine.clamp(-1.0, 1.0).acos());
        air.light(Length::from_km(self.altitude_km), sun, &[sight])
            .unwrap()
    }

    /// How far the line goes to the ground, to its lowest point, or nowhere \[km\].
    fn down_km(&self) -> Option<f64> {
        let r = EARTH_RADIUS_KM + self.altitude_km;
        let impact = r * (1.0 - self.cosine.powi(2)).sqrt();
        let lowest = -r * self.cosine;
        let chord = ((EARTH_RADIUS_KM - impact) * (EARTH_RADIUS_KM + impact)).max(0.0);
        (self.cosine < 0.0).then(|| lowest - chord.sqrt())
    }
}

/// Zenith angle of the horizon.
fn horizon_deg(altitude_km: f64) -> f64 {
    180.0
        - Angle::from_radians((EARTH_RADIUS_KM / (EARTH_RADIUS_KM + altitude_km)).asin()).degrees()
}

fn percentile(values: &[f64], percent: f64) -> f64 {
    metrics::percentile(values, percent).unwrap()
}

fn everywhere() -> Vec<Sight> {
    (0..=18)
        .flat_map(|z| {
            [0.0, 90.0, 180.0].map(|a| SkyDirection::from_degrees(10.0 * f64::from(z), a))
        })
        .map(Sight::whole)
        .collect()
}

#[test]
fn one_solution_answers_for_ground_of_any_albedo() {
    for (turbidity, any) in [(1.0, &*CLEAR), (4.0, &*HAZY)] {
        let optics = optics(turbidity);
        for albedo in [0.0, 0.2, 0.5, 0.8, 1.0] {
            let one = Transport::solve(&optics, albedo, &TransportSettings::default()).unwrap();
            let mut differences = Vec::new();
            for sun in [0.0, 40.0, 70.0, 85.0, 89.0, 91.0, 94.0, 98.0, 102.0] {
                for km in [0.0, 3.0, 20.0, 99.0] {
                    let (km, sun) = (Length::from_km(km), Angle::from_degrees(sun));
                    let sights = everywhere();
                    let directions: Vec<SkyDirection> =
                        sights.iter().map(|s| s.direction).collect();
                    let expected = one.radiance_ratio(km, sun, &directions);
                    let parts = any.light(km, sun, &sights).unwrap();
                    let found = parts.total(albedo, albedo).unwrap();
                    let median = percentile(&expected, 50.0);
                    differences.extend(
                        expected
                            .iter()
                            .zip(&found)
                            .filter(|(e, _)| **e > 0.05 * median)
                            .map(|(e, f)| (f / e - 1.0).abs()),
                    );
                }
            }
            let [most, all] = [95.0, 100.0].map(|percent| percentile(&differences, percent));
            println!("turbidity {turbidity}, albedo {albedo}: 95 % within {most:.4}, all {all:.4}");
            assert!(
                most <= 0.005 && all <= 0.015,
                "{turbidity} {albedo}: {most} {all}"
            );
        }
    }
}

#[test]
fn a_line_sees_what_its_first_part_adds_and_the_rest_through_it() {
    let mut dice = Dice(1);
    let mut gaps = [Vec::new(), Vec::new()];
    for case in 0..400 {
        let air = if case % 2 == 0 { &*CLEAR } else { &*HAZY };
        let altitude_km = 100.0 * dice.roll().powi(3);
        let horizon = horizon_deg(altitude_km);
        let zenith = match case % 3 {
            0 => dice.between(horizon - 1.0, horizon + 0.3),
            1 => dice.between(horizon, 180.0),
            _ => dice.between(0.0, horizon),
        };
        let line = Line::from_degrees(
            altitude_km,
            dice.between(0.0, 96.0),
            zenith,
            dice.between(0.0, 180.0),
        );
        let whole_km = line.down_km().filter(|_| zenith > horizon).unwrap_or(300.0);
        let length_km = whole_km * dice.between(0.02, 0.98);
        let far = line.from_farther(length_km);
        let [whole, near, rest] = [
            line.light(air, None),
            line.light(air, Some(length_km)),
            far.light(air, None),
        ];
        let [total, rest_total] = [&whole, &rest].map(|l| l.total(0.3, 0.3).unwrap());
        let added = near.inscatter(0.3).unwrap();
        for w in 0..3 {
            let through = near.transmittance[w];
            let both = added[w] + through * rest_total[w];
            let once = near.once[w] + through * rest.once[w];
            if total[w] > 1e-6 {
                gaps[0].push((both / total[w] - 1.0).abs());
                gaps[1].push((once - whole.once[w]).abs() / total[w]);
            }
        }
    }
    for (gaps, limits) in gaps.into_iter().zip([[1e-3, 6e-3], [5e-4, 5e-3]]) {
        let [most, all] = [95.0, 100.0].map(|percent| percentile(&gaps, percent));
        println!("gap of a line: 95 % within {most:.1e}, all {all:.1e}");
        assert!(most <= limits[0] && all <= limits[1], "{most} {all}");
    }
}

#[test]
fn light_on_a_path_grows_with_its_length() {
    let mut dice = Dice(2);
    for case in 0..60 {
        let air = if case % 2 == 0 { &*CLEAR } else { &*HAZY };
        let altitude_km = 40.0 * dice.roll().powi(2);
        let horizon = horizon_deg(altitude_km);
        let zenith = dice.between(horizon - 2.0, horizon + 4.0);
        let line = Line::from_degrees(
            altitude_km,
            dice.between(0.0, 100.0),
            zenith,
            dice.between(0.0, 180.0),
        );
        let whole_km = line.down_km().filter(|_| zenith > horizon).unwrap_or(500.0);
        let mut before = vec![0.0; 3];
        for step in 1..=10 {
            let length_km = whole_km * f64::from(step) / 10.0;
            let now = line.light(air, Some(length_km)).inscatter(0.2).unwrap();
            for (now, before) in now.iter().zip(&before) {
                assert!(
                    *now >= before * (1.0 - 3e-3),
                    "{line:?} {length_km} km: {now} after {before}"
                );
            }
            before = now;
        }
    }
}

#[test]
fn the_air_before_the_horizon_is_the_same_from_both_sides() {
    for air in [&*CLEAR, &*HAZY] {
        for km in [0.001, 0.1, 1.0, 10.0, 50.0, 99.9] {
            for sun in [20.0, 80.0, 90.0, 94.0] {
                // the path to the ground is shorter by the root of this share of the dip
                let off = 1e-6 * (horizon_deg(km) - 90.0);
                let [above, below] = [-off, off]
                    .map(|side| Line::from_degrees(km, sun, horizon_deg(km) + side, 60.0));
                let lowest = -(EARTH_RADIUS_KM + km) * above.cosine;
                let above = above.light(air, Some(lowest)).inscatter(0.2).unwrap();
                let below = below.light(air, None).inscatter(0.2).unwrap();
                for (a, b) in above.iter().zip(&below) {
                    assert!((a / b - 1.0).abs() <= 5e-3, "{km} km, sun {sun}: {a} {b}");
                }
            }
        }
    }
}

#[test]
fn from_above_the_air_a_line_is_what_it_is_where_it_enters() {
    let enters = Line::from_degrees(100.0, 60.0, 97.0, 30.0);
    // back along the line
    let space = enters.from_farther(-2000.0);
    assert!(space.altitude_km > 150.0);
    let [near, far] = [enters, space].map(|line| line.light(&CLEAR, None).total(0.2, 0.2).unwrap());
    for (n, f) in near.iter().zip(&far) {
        assert!((f / n - 1.0).abs() < 1e-5, "{n} {f}");
    }
    // and one that misses it is dark, one that ends before it too
    let miss = Line::from_degrees(1000.0, 60.0, 90.0, 30.0);
    let short = space.light(&CLEAR, Some(1000.0));
    for light in [miss.light(&CLEAR, None), short] {
        assert!(
            light
                .total(0.2, 0.2)
                .unwrap()
                .iter()
                .all(|l| l.abs() < 1e-30)
        );
        assert!(light.transmittance.iter().all(|t| (t - 1.0).abs() < 1e-12));
    }
}

#[test]
fn light_is_finite_and_not_negative_from_below_the_sea_to_space() {
    let mut dice = Dice(3);
    let low = solve(&optics(3.0).down_to(Length::from_km(-0.5)).unwrap());
    for (air, lowest_km) in [(&*CLEAR, 0.0), (&*HAZY, 0.0), (&low, -0.5)] {
        for _ in 0..300 {
            let line = Line::from_degrees(
                lowest_km + dice.roll().powi(3) * 120.0,
                dice.between(0.0, 108.0),
                dice.between(0.0, 180.0),
                dice.between(0.0, 180.0),
            );
            let light = line.light(air, None);
            for part in [
                &light.once,
                &light.more,
                &light.inscatter(1.0).unwrap(),
                &light.total(0.0, 1.0).unwrap(),
            ] {
                assert!(
                    part.iter().all(|l| l.is_finite() && *l >= 0.0),
                    "{line:?}: {light:?}"
                );
            }
            assert!(light.transmittance.iter().all(|t| (0.0..=1.0).contains(t)));
        }
    }
}

#[test]
fn the_ground_may_lie_below_the_sea() {
    let sea = optics(3.0);
    let all_sky: Vec<Sight> = everywhere()
        .into_iter()
        .filter(|s| s.direction.view_zenith.degrees() <= 90.0)
        .collect();
    let look = |ground_km: f64| {
        let air = solve(&sea.down_to(Length::from_km(ground_km)).unwrap());
        let eye = Length::from_km(ground_km);
        let lights = [30.0, 80.0, 92.0].map(|sun| {
            let light = air.light(eye, Angle::from_degrees(sun), &all_sky).unwrap();
            light.total(0.2, 0.2).unwrap()
        });
        lights.concat()
    };
    let [sea_level, nearly, low] = [0.0, -0.002, -0.43].map(look);
    // level lines are longest, and most sensitive to the amount of air
    for ((s, n), l) in sea_level.iter().zip(&nearly).zip(&low) {
        assert!((n / s - 1.0).abs() < 0.01, "{s} {n}");
        assert!((l / s - 1.0).abs() < 0.5, "{s} {l}");
    }
    // half a kilometer more of air and haze above the eye
    let [here, there] = [0.0, -0.5].map(|km| {
        let optics = sea.down_to(Length::from_km(km)).unwrap();
        optics.vertical_optical_depth(Length::from_km(km))
    });
    assert!(here.iter().zip(&there).all(|(h, t)| t > h && *t < 1.4 * h));
    assert!(matches!(
        CLEAR.light(Length::from_km(-0.1), Angle::ZERO, &all_sky),
        Err(TransportError::BelowGround { .. })
    ));
    for km in [-0.6, 0.1] {
        assert!(sea.down_to(Length::from_km(km)).is_err());
    }
}

/// Molecules alone, exponential with a scale height of 8 km.
fn molecules(optical_depth: f64) -> OpticalProfile {
    let altitude_km: Vec<f64> = (0..=200).map(|k| f64::from(k) * 0.5).collect();
    let n = altitude_km.len();
    OpticalProfile {
        rayleigh_scattering_per_km: altitude_km
            .iter()
            .map(|z| optical_depth / 8.0 * (-z / 8.0).exp())
            .collect(),
        altitude_km,
        wavelength_nm: vec![450.0],
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
fn what_falls_on_a_white_world_leaves_it() {
    // Over ground that throws everything back and under air that absorbs nothing, as much light leaves
    // the top of the air, summed over the whole sphere, as ground and air take out of the sun's beam.
    const TOP_KM: f64 = 100.0;
    const SUNS: u32 = 54;
    const VIEWS: u32 = 12;
    const AZIMUTHS: u32 = 12;
    let middle = |i: u32, n: u32| (f64::from(i) + 0.5) / f64::from(n);
    let air = solve(&molecules(0.25));
    let (ground, top) = (EARTH_RADIUS_KM, EARTH_RADIUS_KM + TOP_KM);
    // squares of the cosine: below this a line passes over the ground
    let limb = 1.0 - (ground / top).powi(2);
    let mut leaving = 0.0;
    for s in 0..SUNS {
        let sun = Angle::from_degrees(108.0 * middle(s, SUNS));
        let belt = sun.radians().sin() * Angle::from_degrees(108.0 / f64::from(SUNS)).radians();
        for (from, to) in [(0.0, limb), (limb, 1.0)] {
            let sights: Vec<Sight> = (0..VIEWS)
                .flat_map(|v| {
                    let cosine = -(from + (to - from) * middle(v, VIEWS)).sqrt();
                    (0..AZIMUTHS).map(move |a| {
                        Sight::whole(SkyDirection {
                            view_zenith: Angle::from_radians(cosine.acos()),
                            relative_azimuth: Angle::from_degrees(180.0 * middle(a, AZIMUTHS)),
                        })
                    })
                })
                .collect();
            let light = air.light(Length::from_km(TOP_KM), sun, &sights).unwrap();
            let mean =
                light.total(1.0, 1.0).unwrap().iter().sum::<f64>() / f64::from(VIEWS * AZIMUTHS);
            leaving += core::f64::consts::PI * (to - from) * mean * belt;
        }
    }
    leaving *= 2.0 * core::f64::consts::PI * top.powi(2);
    // the disc of the ground, and of the beams that pass over it what they lose
    let rings = 200_u32;
    let lost: f64 = (0..rings)
        .map(|i| {
            let tangent_km = TOP_KM * middle(i, rings);
            let line = Line {
                altitude_km: TOP_KM,
                sun_cosine: 0.0,
                cosine: -(1.0 - ((ground + tangent_km) / top).powi(2)).sqrt(),
                cos_gamma: 0.0,
            };
            let through = line.light(&air, None).transmittance[0];
            2.0 * (ground + tangent_km) * TOP_KM / f64::from(rings) * (1.0 - through)
        })
        .sum();
    let falling = core::f64::consts::PI * (ground.powi(2) + lost);
    let share = leaving / falling;
    println!("leaves over falls: {share:.4}");
    assert!((share - 1.0).abs() < 0.005, "{share}");
}

#[test]
fn a_line_to_the_ground_is_its_air_and_the_ground_through_it() {
    let line = Line::from_degrees(2.0, 50.0, 130.0, 40.0);
    let light = line.light(&HAZY, None);
    let (all, air) = (
        light.total(0.3, 0.7).unwrap(),
        light.inscatter(0.3).unwrap(),
    );
    let ground = light.white_ground(0.3).unwrap();
    for w in 0..light.wavelengths() {
        let both = air[w] + 0.7 * light.transmittance[w] * ground[w];
        assert!((all[w] / both - 1.0).abs() < 1e-12);
        // under a sun 50 degrees from the zenith, less than that of space, more than half of it
        let most = Angle::from_degrees(50.0).radians().cos() / core::f64::consts::PI;
        assert!((0.5 * most..most).contains(&ground[w]), "{}", ground[w]);
    }
    let sky = Line::from_degrees(2.0, 50.0, 60.0, 40.0).light(&HAZY, None);
    assert!(
        sky.white_ground(0.3)
            .unwrap()
            .iter()
            .all(|l| l.abs() < 1e-30)
    );
}

#[test]
fn albedos_outside_0_to_1_are_refused() {
    let light = Line::from_degrees(1.0, 30.0, 40.0, 0.0).light(&CLEAR, None);
    for albedo in [-0.1, 1.1, f64::NAN] {
        assert!(matches!(
            light.total(albedo, 0.2),
            Err(TransportError::Albedo(_))
        ));
        assert!(matches!(
            light.total(0.2, albedo),
            Err(TransportError::Albedo(_))
        ));
    }
}
