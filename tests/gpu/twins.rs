//! The GPU against the CPU: shaders against their twins, tiers against the evaluator, the horizon.
//! Needs a Vulkan driver; a software one will do.

#![expect(
    clippy::print_stdout,
    reason = "the measured figures are part of the test's answer"
)]

use std::sync::{LazyLock, Mutex};

use sky_core::color::{LinearSrgb, Yxy, xyz_from_linear_srgb, yxy_from_xyz};
use sky_core::haze::Haze;
use sky_core::picture::Picture;
use sky_core::quantity::{Angle, Length};
use sky_core::utm_sky::UtmSky;
use sky_eval::cases::conditions;
use sky_gpu::headless::Headless;
use sky_gpu::{
    Camera, Dome, FrameSettings, Output, Projection, SkyRenderer, SkyRendererOptions, Tier,
};
use sky_render::{Painter, Pixels, Shot, draw_on_cpu, facing, looking};
use sky_science::metrics::{ciede2000_of_lights, white_luminance};

static GPU: LazyLock<Headless> =
    LazyLock::new(|| Headless::new().unwrap_or_else(|error| panic!("{error}")));
static PAINTER: LazyLock<Mutex<Painter>> = LazyLock::new(|| {
    let painter = Painter::new(SKY.clone()).unwrap_or_else(|error| panic!("{error}"));
    Mutex::new(painter)
});
static SKY: LazyLock<UtmSky> = LazyLock::new(|| UtmSky::embedded().expect("the table"));

fn shot(altitude_km: f64, turbidity: f64, sun_deg: f64, camera: Camera) -> Shot {
    Shot {
        conditions: conditions(altitude_km, turbidity, sun_deg),
        sun_azimuth: Angle::from_degrees(20.0),
        camera,
        size: [160, 120],
        ev100: None,
        tone: None,
        tier: Tier::Fragment,
        scenery: sky_render::Scenery::None,
        sun_disc: true,
        aerial: true,
    }
}

fn perspective(azimuth: f64, elevation: f64) -> Camera {
    Camera {
        depth_is_distance: true,
        ..Camera::perspective(1.2, 160.0 / 120.0, looking(azimuth, elevation))
    }
}

fn cameras() -> [(&'static str, Camera); 3] {
    let fisheye = Projection::Fisheye {
        aspect: 160.0 / 120.0,
    };
    [
        ("perspective", perspective(10.0, 5.0)),
        ("fisheye", Camera::panorama(fisheye, facing(0.0))),
        (
            "equirect",
            Camera::panorama(Projection::Equirectangular, facing(0.0)),
        ),
    ]
}

fn on_gpu(shot: &Shot) -> Pixels {
    let mut painter = PAINTER.lock().expect("no test has panicked while drawing");
    painter.draw(shot).expect("a picture")
}

fn linear(pixels: &Pixels) -> Vec<[f32; 3]> {
    match pixels {
        Pixels::Linear(values) => values.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect(),
        Pixels::Srgb8(_) => panic!("a linear picture was asked for"),
    }
}

/// Colors of a linear picture as lights.
fn lights(pixels: &Pixels) -> Vec<Yxy> {
    linear(pixels)
        .into_iter()
        .map(|rgb| {
            let [red, green, blue] = rgb.map(f64::from);
            yxy_from_xyz(xyz_from_linear_srgb(LinearSrgb { red, green, blue }))
        })
        .collect()
}

/// Median and 99th percentile.
fn quantiles(mut values: Vec<f64>) -> [f64; 2] {
    values.sort_by(f64::total_cmp);
    [50, 99].map(|percent| values[values.len() * percent / 100])
}

fn counter(i: u32, dimension: u32) -> f64 {
    const STEPS: [f64; 4] = [0.819_172_513, 0.671_043_606, 0.549_700_477, 0.450_295_262];
    (0.5 + f64::from(i) * STEPS[dimension as usize]).fract()
}

/// 108 frames of 1024 pixels cover the domain: above 1e5 inputs.
#[test]
fn the_shader_agrees_with_its_twin() {
    let mut worst = [0.0_f64; 3];
    let mut inputs = 0;
    for i in 0..108 {
        let camera = Camera::panorama(Projection::Equirectangular, facing(360.0 * counter(i, 3)));
        let mut shot = shot(
            30.0 * counter(i, 0).powi(2),
            8.0_f64.powf(counter(i, 1)),
            96.0 * counter(i, 2),
            camera,
        );
        shot.size = [64, 32];
        let found = linear(&on_gpu(&shot));
        let picture = Picture::new(&SKY, &shot.conditions, 0.2).expect("inside the domain");
        let axes = shot.frame().local_axes();
        for y in 0..32 {
            for x in 0..64 {
                let world = shot.direction(x, y).expect("all directions");
                let direction = axes.map(|a| a.dot(world));
                let Some(expected) = picture.sky.linear_srgb(direction) else {
                    continue;
                };
                if (picture.color(direction)[0] - expected[0]).abs() > 0.0 {
                    continue; // the sun's disc
                }
                inputs += 1;
                let yxy = |[red, green, blue]: [f32; 3]| {
                    yxy_from_xyz(xyz_from_linear_srgb(LinearSrgb {
                        red: red.into(),
                        green: green.into(),
                        blue: blue.into(),
                    }))
                };
                let (found, expected) = (yxy(found[(y * 64 + x) as usize]), yxy(expected));
                assert!(
                    found.luminance_cd_m2 >= 0.0,
                    "{shot:?} {direction:?}: {found:?}"
                );
                let errors = [
                    (found.luminance_cd_m2 / expected.luminance_cd_m2 - 1.0).abs(),
                    (found.x - expected.x).abs(),
                    (found.y - expected.y).abs(),
                ];
                for (worst, error) in worst.iter_mut().zip(errors) {
                    assert!(error.is_finite(), "{shot:?} {direction:?}: {found:?}");
                    *worst = worst.max(error);
                }
            }
        }
    }
    println!(
        "{inputs} inputs; worst: luminance {:.2e}, x {:.2e}, y {:.2e}",
        worst[0], worst[1], worst[2]
    );
    assert!(inputs >= 100_000);
    assert!(
        worst[0] <= 1e-3 && worst[1] <= 2e-4 && worst[2] <= 2e-4,
        "{worst:?}"
    );
}

/// In linear light: of an 8-bit picture one code more or less in the shadows is a ΔE of 1 by itself.
#[test]
fn every_tier_draws_the_evaluator_s_picture() {
    let tiers = [
        ("fragment", Tier::Fragment, 0.5),
        ("baked", Tier::Baked, 1.0),
        ("vertex", Tier::Vertex(Dome::REPORT), f64::INFINITY),
        ("fine vertex", Tier::Vertex(Dome::FINE), 10.0),
    ];
    for (camera_name, camera) in cameras() {
        for (altitude, turbidity, sun) in [
            (0.0, 2.5, 60.0),
            (1.0, 5.0, 85.0),
            (12.0, 1.5, 92.0),
            (30.0, 2.0, 40.0),
        ] {
            let mut shot = shot(altitude, turbidity, sun, camera);
            let expected = lights(&draw_on_cpu(&SKY, &shot).expect("a picture"));
            let white = white_luminance(&expected).expect("a picture with light");
            for (name, tier, limit) in tiers {
                shot.tier = tier;
                let found = lights(&on_gpu(&shot));
                let errors: Vec<f64> = found
                    .iter()
                    .zip(&expected)
                    .map(|(f, e)| ciede2000_of_lights(*f, *e, white))
                    .collect();
                let [median, error] = quantiles(errors);
                println!(
                    "{camera_name} {altitude} km T {turbidity} sun {sun}: {name} dE median {median:.3} p99 {error:.3}"
                );
                assert!(median <= 3.0, "{camera_name} {name}: median {median}");
                assert!(error <= limit, "{camera_name} {name}: {error}");
            }
        }
    }
}

/// Walks down a column of pixels across the horizon.
#[test]
fn the_horizon_has_no_seam_stripe_or_hole() {
    for altitude in [0.0, 1.0, 12.0, 30.0] {
        for tier in [Tier::Fragment, Tier::Baked] {
            let dip = sky_core::direction::horizon_dip(Length::from_km(altitude)).degrees();
            let mut shot = shot(
                altitude,
                2.0,
                60.0,
                Camera {
                    depth_is_distance: true,
                    ..Camera::perspective(0.07, 1.0, looking(90.0, -dip))
                },
            );
            shot.size = [3, 400];
            shot.tier = tier;
            let pixels = linear(&on_gpu(&shot));
            let column: Vec<f64> = (0..400)
                .map(|y| f64::from(sky_core::tonemap::luminance(pixels[3 * y + 1])))
                .collect();
            let (low, high) = column
                .iter()
                .fold((f64::INFINITY, 0.0_f64), |(l, h), c| (l.min(*c), h.max(*c)));
            assert!(
                low > 0.0 && high.is_finite(),
                "{altitude} km {tier:?}: {low} to {high}"
            );
            // one step at most, where sky and ground meet; none elsewhere, and no stripe between them
            let steps: Vec<f64> = column
                .windows(2)
                .map(|p| (p[1] / p[0]).ln().abs())
                .collect();
            let mut sorted = steps.clone();
            sorted.sort_by(|a, b| b.total_cmp(a));
            println!(
                "{altitude} km {tier:?}: largest steps {:.3} {:.3} {:.3}",
                sorted[0], sorted[1], sorted[2]
            );
            // at the ground the horizon is an edge: the ground at one's feet against the sky
            let edge = if altitude < 0.5 { 2.0 } else { 0.15 };
            assert!(
                sorted[0] <= edge,
                "{altitude} km {tier:?}: step {}",
                sorted[0]
            );
            assert!(
                sorted[2] <= 0.05,
                "{altitude} km {tier:?}: second step {}",
                sorted[2]
            );
        }
    }
}

#[test]
fn outside_the_domain_is_an_error_and_can_be_seen() {
    let format = wgpu::TextureFormat::Rgba16Float;
    let options = SkyRendererOptions::new(format, Output::Linear);
    let renderer = SkyRenderer::new(&GPU.device, &SKY, &options);
    let mut seen = renderer.view(&GPU.device);
    let inside = FrameSettings {
        tone: None,
        ..FrameSettings::default()
    };
    renderer
        .update(&GPU.queue, &mut seen, &inside)
        .expect("inside the domain");
    let outside = FrameSettings {
        haze: Haze::Turbidity(20.0),
        ..inside
    };
    assert!(renderer.update(&GPU.queue, &mut seen, &outside).is_err());
    renderer.show_outside_domain(&GPU.queue, &mut seen, &outside);
    renderer.set_camera(&GPU.queue, &mut seen, &perspective(0.0, 20.0));
    let target = GPU.target([32, 32], format).expect("a target");
    let view = target.create_view(&wgpu::TextureViewDescriptor::default());
    for tier in [Tier::Fragment, Tier::Baked] {
        GPU.draw(&renderer, &mut seen, &view, tier, |_, _| ());
        let bytes = GPU.read(&target).expect("pixels");
        let green = bytes
            .chunks_exact(8)
            .all(|p| u16::from_le_bytes([p[2], p[3]]) & 0x7FFF == 0);
        assert!(green, "{tier:?}: stripes have no green");
    }
}

#[test]
fn absurd_sizes_are_refused() {
    for size in [[0, 10], [10, 0], [100_000, 4]] {
        let error = GPU
            .target(size, wgpu::TextureFormat::Rgba8Unorm)
            .expect_err("no such size");
        assert!(
            error.to_string().starts_with("size: expected 1 to 8192"),
            "{error}"
        );
    }
}
