//! The GPU against the CPU: shaders against their twins, tiers against the evaluator, the horizon.
//! Needs a Vulkan driver; a software one will do.

#![expect(
    clippy::print_stdout,
    reason = "the measured figures are part of the test's answer"
)]

use std::sync::LazyLock;

use sky_core::color::{LinearSrgb, Yxy, xyz_from_linear_srgb, yxy_from_xyz};
use sky_core::haze::Haze;
use sky_core::picture::Picture;
use sky_core::quantity::{Angle, Length};
use sky_eval::cases::conditions;
use sky_gpu::headless::Headless;
use sky_gpu::{
    Camera, Dome, FrameSettings, Output, Projection, SkyRenderer, SkyRendererOptions, Tier,
};
use sky_render::{Pixels, Shot, draw_on_cpu, facing, looking};
use sky_science::metrics::{ciede2000_of_lights, white_luminance};

use crate::cases::{Ranges, random};
use crate::gpu::{SKY, painter};

static GPU: LazyLock<Headless> =
    LazyLock::new(|| Headless::new().unwrap_or_else(|error| panic!("{error}")));

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
    painter().draw(shot).expect("a picture")
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

/// Median, 95th and 99th percentile; not a number where one is none.
fn percentiles(values: &[f64]) -> [f64; 3] {
    if values.iter().any(|v| v.is_nan()) {
        return [f64::NAN; 3];
    }
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    [50, 95, 99].map(|percent| sorted[sorted.len() * percent / 100])
}

fn light(rgb: [f32; 3]) -> Yxy {
    let [red, green, blue] = rgb.map(f64::from);
    yxy_from_xyz(xyz_from_linear_srgb(LinearSrgb { red, green, blue }))
}

/// How far the shader's light is from its twin's: luminance, relative; x; y. The sun's disc and what
/// lies below the horizon are left out.
fn differences_from_the_twin(shot: &Shot, found: &[[f32; 3]]) -> Vec<[f64; 3]> {
    let picture = Picture::new(&SKY, &shot.conditions, 0.2).expect("inside the domain");
    let axes = shot.frame().local_axes();
    let [width, height] = shot.size;
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let mut out = Vec::new();
    for ((x, y), rgb) in places.zip(found) {
        let world = shot.direction(x, y).expect("all directions");
        let direction = axes.map(|a| a.dot(world));
        let Some(expected) = picture.sky.linear_srgb(direction) else {
            continue;
        };
        if (picture.color(direction)[0] - expected[0]).abs() > 0.0 {
            continue; // the sun's disc
        }
        let (found, expected) = (light(*rgb), light(expected));
        assert!(
            found.luminance_cd_m2 >= 0.0,
            "{shot:?} {direction:?}: {found:?}"
        );
        out.push([
            (found.luminance_cd_m2 / expected.luminance_cd_m2 - 1.0).abs(),
            (found.x - expected.x).abs(),
            (found.y - expected.y).abs(),
        ]);
    }
    out
}

/// The three tiers at their finest and coarsest, and how far each may be from the evaluator's picture
/// in CIEDE2000 over the whole domain and the whole sphere: median, 95th and 99th percentile. These are
/// the figures of ARCHITECTURE.md.
const TIERS: [(&str, Tier, [f64; 3]); 4] = [
    ("fragment", Tier::Fragment, [0.001, 0.09, 0.33]),
    ("baked", Tier::Baked, [0.015, 0.18, 0.62]),
    ("fine dome", Tier::Vertex(Dome::FINE), [0.04, 1.1, 3.3]),
    (
        "the report's dome",
        Tier::Vertex(Dome::REPORT),
        [0.2, 3.0, 23.0],
    ),
];

/// 54 frames of 4096 pixels cover the domain, its corners among them: above 1e5 inputs. In linear
/// light: of an 8-bit picture one code more or less in the shadows is a ΔE of 1 by itself.
#[test]
fn shaders_agree_with_their_twin_and_tiers_with_the_evaluator() {
    let domain = SKY.lut().header().domain;
    let ranges = Ranges {
        altitude_km: domain.altitude_km,
        turbidity: domain.turbidity,
        sun_zenith_deg: domain.sun_zenith_deg,
    };
    let mut worst = [0.0_f64; 3];
    let mut inputs = 0;
    let mut errors = TIERS.map(|_| Vec::new());
    for (i, conditions) in ranges.conditions("twins", 54, 54).into_iter().enumerate() {
        let i = u32::try_from(i).expect("few");
        let heading = facing(360.0 * random("heading", [i, 0]));
        let mut shot = Shot {
            conditions,
            size: [64, 64],
            ..shot(
                0.0,
                1.0,
                0.0,
                Camera::panorama(Projection::Equirectangular, heading),
            )
        };
        let expected = lights(&draw_on_cpu(&SKY, &shot).expect("a picture"));
        let white = white_luminance(&expected).expect("a picture with light");
        for ((name, tier, _), errors) in TIERS.iter().zip(&mut errors) {
            shot.tier = *tier;
            let found = on_gpu(&shot);
            if *tier == Tier::Fragment {
                // a panorama spreads the sun's disc over pixels larger than itself: not the twin's
                let bare = Shot {
                    sun_disc: false,
                    ..shot.clone()
                };
                for one in differences_from_the_twin(&bare, &linear(&on_gpu(&bare))) {
                    inputs += 1;
                    for (worst, error) in worst.iter_mut().zip(one) {
                        assert!(error.is_finite(), "{shot:?}");
                        *worst = worst.max(error);
                    }
                }
            }
            let of_frame: Vec<f64> = lights(&found)
                .into_iter()
                .zip(&expected)
                .map(|(f, e)| ciede2000_of_lights(f, *e, white))
                .collect();
            println!("{i} {name} {conditions:?} {:?}", percentiles(&of_frame));
            errors.extend(of_frame);
        }
    }
    println!("{inputs} inputs; worst: {worst:?}");
    assert!(inputs >= 100_000);
    for ((name, _, _), errors) in TIERS.iter().zip(&errors) {
        println!("{name}: {:.3?}", percentiles(errors));
    }
    assert!(
        worst[0] <= 1e-3 && worst[1] <= 2e-4 && worst[2] <= 2e-4,
        "{worst:?}"
    );
    for ((name, _, limits), errors) in TIERS.iter().zip(&errors) {
        let found = percentiles(errors);
        let within = found.iter().zip(limits).all(|(f, l)| f <= l);
        assert!(within, "{name}: {found:?}, at most {limits:?}");
    }
}

/// Through other cameras the tiers draw what they draw of the whole sphere.
#[test]
fn every_tier_draws_the_evaluator_s_picture_through_every_camera() {
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
            for (name, tier, _) in TIERS {
                shot.tier = tier;
                let found = lights(&on_gpu(&shot));
                let errors: Vec<f64> = found
                    .iter()
                    .zip(&expected)
                    .map(|(f, e)| ciede2000_of_lights(*f, *e, white))
                    .collect();
                let [median, p95, p99] = percentiles(&errors);
                println!(
                    "{camera_name} {altitude} km T {turbidity} sun {sun}: {name} dE median {median:.3} p95 {p95:.3} p99 {p99:.3}"
                );
                let limits = match tier {
                    Tier::Fragment => [0.1, 0.5],
                    Tier::Baked => [0.1, 1.0],
                    Tier::Vertex(Dome::FINE) => [0.5, 10.0],
                    // one of its triangles spans the whole glow of a low sun
                    Tier::Vertex(_) => [3.0, 60.0],
                };
                let within = median <= limits[0] && p99 <= limits[1];
                assert!(within, "{camera_name} {name}: {median} {p95} {p99}");
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
