//! The shaders of the published skies and of Perez's tables against their Rust twins, by the program
//! that the chart times. Needs a Vulkan driver; a software one will do.

#![expect(
    clippy::print_stdout,
    reason = "the measured figures are part of the test's answer"
)]

use sky_core::color::{LinearSrgb, Yxy, xyz_from_linear_srgb, yxy_from_xyz};
use sky_core::conditions::{Conditions, Domain};
use sky_core::direction::SkyDirection;
use sky_core::quantity::Angle;
use sky_eval::cases::conditions;
use sky_eval::models::{all, answers, general_truth};
use sky_eval::progress::Silent;
use sky_gpu::headless::Headless;
use sky_gpu::{Camera, Tier};
use sky_render::Scenery;
use sky_render::published::{PUBLISHED_SCALE, published};
use sky_render::{Shot, looking};
use sky_science::shader_sky::ShaderSky;

const SIZE: [u32; 2] = [16, 12];
/// Directions this close to where a model's sky ends are left out: a last bit decides on which side
/// they lie.
const EDGE_DEG: f64 = 0.02;
/// Lights below this share of a picture's brightest are measured against it: a texture of `f16` holds
/// shares of the brightest in steps of 6e-8.
const DARK_SHARE: f64 = 1e-3;

/// Shares of the ranges that a model claims: altitude, turbidity, sun zenith angle. Both ends are
/// there; turbidities come in pairs, for tables are made anew for each.
const FRAMES: [[f64; 3]; 8] = [
    [0.0, 0.0, 0.45],
    [0.03, 0.0, 0.93],
    [0.3, 0.15, 0.2],
    [1.0, 0.15, 0.82],
    [0.1, 0.5, 0.6],
    [0.6, 0.5, 0.87],
    [0.003, 1.0, 0.0],
    [0.01, 1.0, 0.85],
];

/// How far a shader may be from its twin: luminance, relative; chromaticity. Those that march differ by
/// 1e-5, those that read a texture of 11 bits by up to 5e-4.
const LIMITS: [f64; 2] = [1e-3, 5e-4];
/// Dobashi's: what passes a segment is read with 11 bits, 2.4e-4, and multiplied segment by segment over
/// rays of up to 200.
const LIMITS_OF_PRODUCTS: [f64; 2] = [4e-3, 1e-3];

fn frames(domain: &Domain) -> Vec<Conditions> {
    let between = |[low, high]: [f64; 2], share: f64| (low + share * (high - low)).min(high);
    FRAMES
        .iter()
        .map(|[altitude, turbidity, sun]| {
            conditions(
                between(domain.altitude_km, *altitude),
                between(domain.turbidity, *turbidity),
                between(domain.sun_zenith_deg, *sun),
            )
        })
        .collect()
}

/// A wide view up, the horizon, and the sun's surroundings.
fn cameras(conditions: &Conditions) -> [Camera; 3] {
    let camera = |field_of_view, azimuth, elevation| {
        Camera::perspective(field_of_view, 4.0 / 3.0, looking(azimuth, elevation))
    };
    let sun = 90.0 - conditions.sun_zenith.degrees();
    [
        camera(1.9, 40.0, 50.0),
        camera(0.3, 70.0, 1.0),
        camera(0.3, 2.0, sun.max(0.0)),
    ]
}

struct Compared {
    direction: SkyDirection,
    gpu: Yxy,
    cpu: Yxy,
}

/// Both answers in the directions of the pixels' centers that the model answers for.
fn compare(gpu: &Headless, sky: &dyn ShaderSky, conditions: &Conditions) -> Vec<Compared> {
    let mut by_gpu = Vec::new();
    for camera in cameras(conditions) {
        let shot = Shot {
            conditions: *conditions,
            sun_azimuth: Angle::ZERO,
            camera,
            size: SIZE,
            ev100: None,
            tone: None,
            tier: Tier::Fragment,
            scenery: Scenery::None,
            sun_disc: true,
            aerial: false,
        };
        let axes = shot.frame().local_axes();
        let format = wgpu::TextureFormat::Rgba32Float;
        let target = gpu.target(SIZE, format).expect("a target");
        let view = target.create_view(&wgpu::TextureViewDescriptor::default());
        let draw = published(gpu, sky, conditions, camera.clip_to_local(axes), format)
            .expect("inside the domain");
        let mut encoder = gpu
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        draw(&mut Headless::pass(&mut encoder, &view, None));
        gpu.queue.submit([encoder.finish()]);
        let bytes = gpu.read(&target).expect("pixels");
        let number = |b: &[u8]| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
        let mut places = (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (x, y)));
        for pixel in bytes.chunks_exact(16) {
            let (x, y) = places.next().expect("one place a pixel");
            let [red, green, blue] =
                [0, 4, 8].map(|at| number(&pixel[at..]) / f64::from(PUBLISHED_SCALE));
            let found = yxy_from_xyz(xyz_from_linear_srgb(LinearSrgb { red, green, blue }));
            let world = shot.direction(x, y).expect("a direction");
            let direction = SkyDirection::from_vector(axes.map(|axis| f64::from(axis.dot(world))));
            let nearby = [-EDGE_DEG, EDGE_DEG].map(|edge| {
                let moved = SkyDirection {
                    view_zenith: Angle::from_degrees(direction.view_zenith.degrees() + edge),
                    ..direction
                };
                answers(sky.domain(), conditions, &moved)
            });
            match nearby {
                [true, true] => by_gpu.push((direction, found)),
                [false, false] => assert!(
                    [red, green, blue].iter().all(|c| c.abs() <= 0.0),
                    "{} {conditions:?} {direction:?}: {found:?}",
                    sky.name()
                ),
                _ => {}
            }
        }
    }
    let directions: Vec<_> = by_gpu.iter().map(|(d, _)| *d).collect();
    let by_cpu = sky
        .yxy_map(conditions, &directions)
        .expect("inside the domain");
    by_gpu
        .into_iter()
        .zip(by_cpu)
        .map(|((direction, gpu), cpu)| Compared {
            direction,
            gpu,
            cpu,
        })
        .collect()
}

/// The worst of a frame: luminance, chromaticity, and the zenith angles \[deg\] where.
fn worst(compared: &[Compared]) -> [[f64; 2]; 2] {
    let brightest = compared
        .iter()
        .map(|c| c.cpu.luminance_cd_m2)
        .fold(0.0, f64::max);
    let mut worst = [[0.0; 2]; 2];
    for Compared {
        direction,
        gpu,
        cpu,
    } in compared
    {
        let all = [gpu.luminance_cd_m2, gpu.x, gpu.y];
        let difference = (gpu.luminance_cd_m2 - cpu.luminance_cd_m2).abs();
        let is_dark = cpu.luminance_cd_m2 <= DARK_SHARE * brightest;
        let errors = if brightest > 0.0 {
            let of = cpu.luminance_cd_m2.abs().max(DARK_SHARE * brightest);
            let color = (gpu.x - cpu.x).abs().max((gpu.y - cpu.y).abs());
            [difference / of, if is_dark { 0.0 } else { color }]
        } else {
            // black, or a model that has gone negative
            [difference / cpu.luminance_cd_m2.abs().max(1e-12), 0.0]
        };
        assert!(
            is_dark || all.iter().all(|v| v.is_finite()),
            "{direction:?}: {gpu:?}, {cpu:?}"
        );
        for (worst, error) in worst.iter_mut().zip(errors) {
            assert!(error.is_finite(), "{direction:?}: {gpu:?}, {cpu:?}");
            if error > worst[0] {
                *worst = [error, direction.view_zenith.degrees()];
            }
        }
    }
    worst
}

#[test]
fn shaders_agree_with_their_twins() {
    let gpu = Headless::new().unwrap_or_else(|error| panic!("{error}"));
    let truth = general_truth().expect("an atmosphere");
    let mut wrong = Vec::new();
    let mut models = 0;
    for model in all() {
        let opened = model.open(&truth, &Silent).expect("a sky");
        let Some(sky) = opened.shader_sky() else {
            continue;
        };
        models += 1;
        let limits = match model.name {
            "dobashi" => LIMITS_OF_PRODUCTS,
            _ => LIMITS,
        };
        for c in frames(sky.domain()) {
            let compared = compare(&gpu, sky, &c);
            assert!(compared.len() > 300, "{}: {}", model.name, compared.len());
            let [luminance, color] = worst(&compared);
            let text = format!(
                "{} {:.2} km, T {:.2}, sun {:.1}: {} directions, luminance {:.1e} at {:.1}, color {:.1e} at {:.1}",
                model.name,
                c.observer_altitude.km(),
                c.turbidity,
                c.sun_zenith.degrees(),
                compared.len(),
                luminance[0],
                luminance[1],
                color[0],
                color[1],
            );
            println!("{text}");
            if luminance[0] > limits[0] || color[0] > limits[1] {
                wrong.push(text);
            }
        }
    }
    assert_eq!(models, 12, "every model with a shader");
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}
