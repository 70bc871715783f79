//! A stranger's engine: four samples, reversed depth, a packed float target, a scene that calls our
//! functions in its own shader, two observers at different altitudes from one renderer. Its pixels are
//! those of the evaluator.

use glam::Vec3;
use sky_core::picture::Picture;
use sky_core::utm_sky::UtmSky;
use sky_gpu::Tier;

#[path = "../../crates/sky-gpu/examples/engine/app.rs"]
mod app;

use app::{App, OBSERVERS, SUN, TOWERS, Window, wall_light};

const SIZE: [u32; 2] = [160, 90];

/// How far a component may be from the evaluator's, as a share of the pixel's brightest: red and green
/// have 6 bits behind the point, blue 5, and a mean of four samples is rounded twice.
const OFF: f32 = 0.035;

/// What a ray from a place meets first: distance \[m\], the wall's direction outward, which tower.
fn hit(eye: Vec3, seen: Vec3) -> Option<(f32, Vec3, usize)> {
    let mut first: Option<(f32, Vec3, usize)> = None;
    for (tower, [east, north, half, height]) in TOWERS.into_iter().enumerate() {
        let low = Vec3::new(east - half, north - half, 0.0) - eye;
        let high = Vec3::new(east + half, north + half, height) - eye;
        let (a, b) = (low / seen, high / seen);
        let (enter, leave) = (a.min(b), a.max(b));
        let distance = enter.max_element();
        if distance > 0.0 && distance <= leave.min_element() {
            let axis = [Vec3::X, Vec3::Y, Vec3::Z][enter.max_position()];
            if first.is_none_or(|(least, ..)| distance < least) {
                first = Some((distance, -axis * seen.dot(axis).signum(), tower));
            }
        }
    }
    first
}

/// The evaluator's light of a pixel's center, and whether the pixels around it see the same thing.
struct Expected {
    light: [f32; 3],
    is_plain: bool,
    is_tower: bool,
}

fn expected(sky: &UtmSky, window: &Window, lit: &Picture, x: u32, y: u32) -> Expected {
    let frame = &window.frame;
    let conditions = frame.conditions().expect("a haze");
    let picture = Picture::new(sky, &conditions, frame.ground_albedo).expect("inside the domain");
    let eye = Vec3::new(0.0, 0.0, picture.altitude_km * 1000.0);
    let axes = frame.local_axes();
    let ray = |x: f32, y: f32| {
        let clip = [
            2.0 * x / SIZE[0] as f32 - 1.0,
            1.0 - 2.0 * y / SIZE[1] as f32,
        ];
        let seen = window.camera.direction(clip).expect("a direction");
        (seen, axes.map(|axis| axis.dot(seen)))
    };
    let (px, py) = (x as f32, y as f32);
    let (seen, local) = ray(px + 0.5, py + 0.5);
    let here = hit(eye, seen);
    let sun = Vec3::from(SUN).normalize();
    let kind = |(seen, local): (Vec3, [f32; 3])| {
        (
            hit(eye, seen).map(|(_, normal, tower)| (normal.to_array().map(f32::to_bits), tower)),
            local[2] >= picture.sky.cos_horizon(),
            seen.dot(sun) > 0.999_98,
        )
    };
    let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
    let plain = kind((seen, local));
    Expected {
        light: here.map_or_else(
            || picture.color(local),
            |(distance, normal, _)| {
                picture.behind_air(local, distance / 1000.0, wall_light(lit, normal))
            },
        ),
        is_plain: !plain.2
            && corners
                .iter()
                .all(|[a, b]| kind(ray(px + a, py + b)) == plain),
        is_tower: here.is_some(),
    }
}

#[test]
fn a_stranger_s_engine_shows_the_evaluator_s_light() {
    let app = App::new().unwrap_or_else(|error| panic!("{error}"));
    let sky = UtmSky::embedded().expect("the table");
    let mut windows = OBSERVERS.map(|observer| app.open(observer, SIZE));
    // twice, so that what one window leaves behind would show in the other
    for _ in 0..2 {
        app.draw(&mut windows, Tier::Fragment)
            .expect("inside the domain");
    }
    let lit = Picture::new(
        &sky,
        &windows[0].frame.conditions().expect("a haze"),
        windows[0].frame.ground_albedo,
    )
    .expect("inside the domain");
    for window in &windows {
        let pixels = app.pixels(window).expect("pixels");
        let mut seen = [0, 0];
        for (i, found) in (0_u32..).zip(&pixels) {
            let [x, y] = [i % SIZE[0], i / SIZE[0]];
            let want = expected(&sky, window, &lit, x, y);
            if !want.is_plain {
                continue;
            }
            seen[usize::from(want.is_tower)] += 1;
            let brightest = want.light.iter().fold(0.0_f32, |a, b| a.max(*b));
            for c in 0..3 {
                // the format has no sign
                let off = (found[c] - want.light[c].max(0.0)).abs() / brightest;
                assert!(
                    off <= OFF,
                    "{} km, pixel {x} {y}: {found:?}, evaluator {:?}",
                    window.frame.observer_altitude.km(),
                    want.light
                );
            }
        }
        assert!(seen[0] > 5000 && seen[1] > 500, "{seen:?}");
    }
}

/// The sun's disc, 1e9 cd/m², in a format that holds 65 024.
#[test]
fn a17_no_pixel_of_a_float_target_is_infinite() {
    let app = App::new().unwrap_or_else(|error| panic!("{error}"));
    let [east, north, up] = SUN;
    let toward = [2000.0, east.atan2(north), (up / east.hypot(north)).atan()];
    for tier in [Tier::Fragment, Tier::Baked] {
        let mut windows = [app.open(toward, [64, 64])];
        windows[0].camera = sky_gpu::Camera {
            projection: sky_gpu::Camera::perspective(0.02, 1.0, glam::Mat3::IDENTITY).projection,
            ..windows[0].camera
        };
        app.draw(&mut windows, tier).expect("inside the domain");
        let pixels = app.pixels(&windows[0]).expect("pixels");
        assert!(pixels.iter().flatten().all(|c| c.is_finite()), "{tier:?}");
        let [red, green, blue] = pixels[32 * 64 + 32];
        // as bright as the format allows, and still of the sun's color: red above blue
        assert!(red > 60_000.0, "{tier:?}: {red}");
        assert!(
            blue < green && green < red,
            "{tier:?}: {red} {green} {blue}"
        );
    }
}
