//! Long and shared use: a flight of many frames, several renderers and devices, many threads. A binary
//! of its own, so that its memory is its own.

use std::thread;

use glam::Vec3;
use sky_core::quantity::{Angle, Length, single};
use sky_core::tonemap::luminance;
use sky_core::utm_sky::UtmSky;
use sky_eval::cases::conditions;
use sky_gpu::headless::Headless;
use sky_gpu::{
    Camera, Dome, Exposure, FrameSettings, Haze, Output, SkyRenderer, SkyRendererOptions, Tier,
    View,
};
use sky_render::looking;

const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

/// A climb from 0 to 30 km from day to dusk, the haze going up and down; `t` from 0 to 1.
fn flight(t: f64) -> FrameSettings {
    let sun = Angle::from_degrees(90.0 - 96.0 * t).radians();
    FrameSettings {
        observer_altitude: Length::from_km(30.0 * t),
        haze: Haze::Turbidity(1.0 + 7.0 * (0.5 - 0.5 * (40.0 * t).cos())),
        sun: Vec3::new(0.0, single(sun.cos()), single(sun.sin())),
        exposure: Exposure::Auto,
        tone: None,
        ..FrameSettings::default()
    }
}

/// A renderer and a view of it.
type Sky = (SkyRenderer, View);

fn renderer(gpu: &Headless, sky: &UtmSky) -> Sky {
    let options = SkyRendererOptions::new(FORMAT, Output::Linear);
    let renderer = SkyRenderer::new(&gpu.device, sky, &options);
    let view = renderer.view(&gpu.device);
    (renderer, view)
}

fn draw(gpu: &Headless, (renderer, view): &mut Sky, target: &wgpu::Texture, t: f64, tier: Tier) {
    let target = target.create_view(&wgpu::TextureViewDescriptor::default());
    renderer
        .update(&gpu.queue, view, &flight(t))
        .expect("inside the domain");
    let camera = Camera::perspective(1.2, 1.0, looking(0.0, 0.0));
    renderer.set_camera(&gpu.queue, view, &camera);
    gpu.draw(renderer, view, &target, tier, |_, _| ());
}

/// A half-precision number.
fn half(bytes: [u8; 2]) -> f32 {
    let bits = u16::from_le_bytes(bytes);
    let sign = if bits & 0x8000 == 0 { 1.0 } else { -1.0 };
    let fraction = f32::from(bits & 0x3FF) / 1024.0;
    sign * match (bits >> 10) & 0x1F {
        0 => fraction * 2.0_f32.powi(-14),
        31 => f32::NAN,
        exponent => (1.0 + fraction) * 2.0_f32.powi(i32::from(exponent) - 15),
    }
}

/// Memory that the process holds \[bytes\], where the system tells it.
fn resident_bytes() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/statm").ok()?;
    let pages: u64 = text.split_whitespace().nth(1)?.parse().ok()?;
    Some(pages * 4096)
}

/// wgpu panics at a validation error, so that there is none either.
#[test]
fn twenty_thousand_frames_show_no_bad_pixel_and_keep_their_memory() {
    const FRAMES: u32 = 20_000;
    let gpu = Headless::new().unwrap_or_else(|error| panic!("{error}"));
    let target = gpu.target([16, 16], FORMAT).expect("a target");
    let mut renderer = renderer(&gpu, &UtmSky::embedded().expect("a table"));
    let mut early = None;
    for i in 0..FRAMES {
        // the tiers that bake take their turns
        let tier = match i % 40 {
            0 => Tier::Fragment,
            20 => Tier::Baked,
            _ => Tier::Vertex(Dome::REPORT),
        };
        draw(
            &gpu,
            &mut renderer,
            &target,
            f64::from(i) / f64::from(FRAMES),
            tier,
        );
        if i % 10 == 0 {
            let bytes = gpu.read(&target).expect("pixels");
            for pixel in bytes.chunks_exact(8) {
                let light = [0, 2, 4].map(|c| half([pixel[c], pixel[c + 1]]));
                assert!(light.iter().all(|c| c.is_finite()), "frame {i}: {light:?}");
                // a saturated color has a negative component, its luminance is none
                assert!(luminance(light) >= 0.0, "frame {i}: {light:?}");
            }
        }
        if i == FRAMES / 10 {
            early = resident_bytes();
        }
    }
    if let (Some(early), Some(late)) = (early, resident_bytes()) {
        let grown = late.saturating_sub(early);
        assert!(grown < 8 << 20, "{grown} bytes more after {FRAMES} frames");
    }
}

#[test]
fn several_renderers_and_devices_draw_the_same() {
    let sky = UtmSky::embedded().expect("a table");
    let mut pictures = Vec::new();
    for _ in 0..2 {
        let gpu = Headless::new().unwrap_or_else(|error| panic!("{error}"));
        let mut renderers = [(), ()].map(|()| renderer(&gpu, &sky));
        let target = gpu.target([32, 32], FORMAT).expect("a target");
        // the other one's sky in between changes nothing
        for (first, second) in [(0, 1), (1, 0)] {
            draw(&gpu, &mut renderers[second], &target, 0.7, Tier::Baked);
            draw(&gpu, &mut renderers[first], &target, 0.3, Tier::Fragment);
            pictures.push(gpu.read(&target).expect("pixels"));
        }
    }
    assert!(pictures[0].iter().any(|byte| *byte != 0));
    assert!(pictures.iter().all(|picture| *picture == pictures[0]));
}

#[test]
fn threads_that_ask_at_once_get_the_same_answers() {
    let sky = UtmSky::embedded().expect("a table");
    let ask = || {
        let mut sum = Vec::new();
        for i in 0..2000_u32 {
            let t = f64::from(i) / 2000.0;
            let frame = sky
                .frame(&conditions(30.0 * t, 1.0 + 7.0 * t, 96.0 * (1.0 - t)))
                .expect("inside the domain");
            let light = frame.light([0.6, 0.0, 0.8]).expect("above the horizon");
            sum.extend(light.map(f32::to_bits));
        }
        sum
    };
    let alone = ask();
    let together: Vec<_> = thread::scope(|scope| {
        let all: Vec<_> = (0..8).map(|_| scope.spawn(ask)).collect();
        all.into_iter()
            .map(|one| one.join().expect("no panic"))
            .collect()
    });
    assert!(together.iter().all(|answers| *answers == alone));
}

/// The device is the program's own: when it is lost, reading back says so, and a renderer made anew on
/// another device goes on with the same picture.
#[test]
fn after_a_lost_device_a_new_renderer_draws_the_same() {
    let sky = UtmSky::embedded().expect("a table");
    let open = || {
        let gpu = Headless::new().unwrap_or_else(|error| panic!("{error}"));
        let renderer = renderer(&gpu, &sky);
        let target = gpu.target([32, 32], FORMAT).expect("a target");
        (gpu, renderer, target)
    };
    let picture = |(gpu, renderer, target): &mut (Headless, Sky, wgpu::Texture)| {
        draw(gpu, renderer, target, 0.4, Tier::Baked);
        gpu.read(target)
    };
    let mut first = open();
    let before = picture(&mut first).expect("pixels");
    assert!(before.iter().any(|byte| *byte != 0));
    for _ in 0..3 {
        first
            .0
            .device
            .on_uncaptured_error(std::sync::Arc::new(|_| ()));
        first.0.device.destroy();
        assert!(picture(&mut first).is_err(), "pixels from a lost device");
        first = open();
        assert_eq!(picture(&mut first).expect("pixels"), before);
    }
}
