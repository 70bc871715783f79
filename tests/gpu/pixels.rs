//! From the table to the picture, against the transport engine: what the GPU draws in linear light must
//! meet the truth as well as the evaluator does. Needs a Vulkan driver; a software one will do.

#![expect(
    clippy::print_stdout,
    reason = "the measured figures are part of the test's answer"
)]

use sky_core::color::{LinearSrgb, Yxy, xyz_from_linear_srgb, yxy_from_xyz};
use sky_core::conditions::{Conditions, Domain};
use sky_core::direction::{SkyDirection, horizon_zenith};
use sky_core::quantity::Angle;
use sky_core::utm_sky::UtmSky;
use sky_eval::cases::{CaseCounts, LOWEST_RING_ABOVE_HORIZON_DEG, Nodes, held_out_cases};
use sky_eval::score::{Evaluation, MapErrors, compare_maps};
use sky_gpu::{Camera, Projection, Tier};
use sky_render::{Pixels, Shot, facing, looking};
use sky_science::metrics::Statistics;
use sky_science::sky_model::SkyModel;

use crate::gpu::painter;
use crate::truth::TRUTH;

/// Where the figures of accuracy are asked for.
const CLAIMED: Domain = Domain {
    altitude_km: [0.0, 30.0],
    turbidity: [1.0, 8.0],
    sun_zenith_deg: [0.0, 92.0],
    below_horizontal: true,
};
/// How much worse than the evaluator the pixels may be, in CIEDE2000.
const SLACK: f64 = 0.2;
const CASES_OF_A_TURBIDITY: usize = 6;

/// Twelve middles of the table's intervals, at two turbidities: each costs a solution of the air.
fn cases(sky: &UtmSky) -> Vec<Conditions> {
    let header = sky.lut().header();
    let nodes = Nodes {
        altitude_km: header.altitude_km.nodes().to_vec(),
        turbidity: header.turbidity.nodes().to_vec(),
        sun_zenith_deg: header.sun_zenith_deg.nodes().to_vec(),
    };
    let middles = held_out_cases(&nodes, &CLAIMED, CaseCounts::default()).midpoints;
    let mut turbidities: Vec<f64> = middles.iter().map(|c| c.turbidity).collect();
    turbidities.sort_by(f64::total_cmp);
    turbidities.dedup();
    let last = turbidities.len() - 1;
    let chosen = [turbidities[last / 4], turbidities[last * 3 / 4]];
    chosen
        .into_iter()
        .flat_map(|turbidity| {
            let of_it: Vec<_> = middles
                .iter()
                .filter(|c| c.turbidity.to_bits() == turbidity.to_bits())
                .copied()
                .collect();
            // from the first to the last, so that all altitudes are there
            (0..CASES_OF_A_TURBIDITY)
                .map(move |i| of_it[i * (of_it.len() - 1) / (CASES_OF_A_TURBIDITY - 1)])
        })
        .collect()
}

/// The hemisphere, and the band at the horizon that a fisheye does not show from above.
fn shots(conditions: &Conditions) -> [Shot; 2] {
    let shot = |camera, size| Shot {
        conditions: *conditions,
        sun_azimuth: Angle::from_degrees(20.0),
        camera,
        size,
        ev100: None,
        tone: None,
        tier: Tier::Fragment,
        scenery: sky_render::Scenery::None,
        sun_disc: true,
        aerial: true,
    };
    let horizon = 90.0 - horizon_zenith(conditions.observer_altitude).degrees();
    let band = Camera {
        depth_is_distance: true,
        ..Camera::perspective(0.2, 2.0, looking(60.0, horizon + 3.0))
    };
    let fisheye = Camera::panorama(Projection::Fisheye { aspect: 1.0 }, facing(0.0));
    [shot(fisheye, [14, 14]), shot(band, [8, 6])]
}

/// Directions of the pixels' centers, clear of the horizon, and their places in the picture.
fn directions(shot: &Shot) -> Vec<(usize, SkyDirection)> {
    let lowest =
        horizon_zenith(shot.conditions.observer_altitude).degrees() - LOWEST_RING_ABOVE_HORIZON_DEG;
    let axes = shot.frame().local_axes();
    let [width, height] = shot.size;
    (0..height)
        .flat_map(|y| (0..width).map(move |x| (x, y)))
        .enumerate()
        .filter_map(|(i, (x, y))| {
            let world = shot.direction(x, y)?;
            let direction = SkyDirection::from_vector(axes.map(|axis| f64::from(axis.dot(world))));
            (direction.view_zenith.degrees() <= lowest).then_some((i, direction))
        })
        .collect()
}

fn drawn(shot: &Shot) -> Vec<Yxy> {
    match painter().draw(shot).expect("a picture") {
        Pixels::Linear(values) => values
            .chunks_exact(3)
            .map(|p| {
                let [red, green, blue] = [p[0], p[1], p[2]].map(f64::from);
                yxy_from_xyz(xyz_from_linear_srgb(LinearSrgb { red, green, blue }))
            })
            .collect(),
        Pixels::Srgb8(_) => panic!("a linear picture was asked for"),
    }
}

fn pooled(maps: Vec<MapErrors>) -> Statistics {
    let all = Evaluation {
        maps,
        outside_domain: 0,
    }
    .pooled();
    assert_eq!(all.not_finite, 0);
    all.delta_e.expect("directions")
}

#[test]
fn pixels_meet_the_transport_engine_as_the_evaluator_does() {
    let sky = UtmSky::embedded().expect("the table");
    let cases = cases(&sky);
    assert_eq!(cases.len(), 2 * CASES_OF_A_TURBIDITY);
    let tiers = [("fragment", Tier::Fragment), ("baked", Tier::Baked)];
    let (mut by_cpu, mut by_gpu) = (Vec::new(), [Vec::new(), Vec::new()]);
    for case in &cases {
        let shots = shots(case);
        let places = shots.each_ref().map(directions);
        let directions: Vec<_> = places.iter().flatten().map(|(_, d)| *d).collect();
        assert!(directions.len() > 150);
        let expected = TRUTH.yxy_map(case, &directions).expect("inside the domain");
        let evaluated = sky.yxy_map(case, &directions).expect("inside the domain");
        by_cpu.push(compare_maps(case, &directions, &expected, &evaluated));
        let mut told = String::new();
        for ((name, tier), maps) in tiers.iter().zip(&mut by_gpu) {
            let found: Vec<Yxy> = shots
                .iter()
                .zip(&places)
                .flat_map(|(shot, places)| {
                    let shot = Shot {
                        tier: *tier,
                        ..shot.clone()
                    };
                    let picture = drawn(&shot);
                    places
                        .iter()
                        .map(move |(i, _)| picture[*i])
                        .collect::<Vec<_>>()
                })
                .collect();
            let errors = compare_maps(case, &directions, &expected, &found);
            let p95 = errors.delta_e_statistics().expect("directions").p95;
            told.push_str(&format!(", {name} {p95:.2}"));
            maps.push(errors);
        }
        let p95 = by_cpu
            .last()
            .and_then(MapErrors::delta_e_statistics)
            .expect("directions")
            .p95;
        println!(
            "{:.2} km, T {:.2}, sun {:.2}: dE p95 evaluator {p95:.2}{told}",
            case.observer_altitude.km(),
            case.turbidity,
            case.sun_zenith.degrees()
        );
    }
    let evaluator = pooled(by_cpu);
    println!(
        "all: dE median and p95: evaluator {:.3} {:.3}",
        evaluator.median, evaluator.p95
    );
    for ((name, _), maps) in tiers.iter().zip(by_gpu) {
        let pixels = pooled(maps);
        println!("{name} {:.3} {:.3}", pixels.median, pixels.p95);
        assert!(
            pixels.median <= evaluator.median + SLACK && pixels.p95 <= evaluator.p95 + SLACK,
            "{name}: {pixels:?}, evaluator {evaluator:?}"
        );
    }
}
