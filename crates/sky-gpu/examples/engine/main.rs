//! The sky in an engine with four samples, reversed depth and a packed float target, seen by two
//! observers at once: `cargo run --release -p sky-gpu --example engine [-- DIRECTORY]`. Needs no window;
//! what the observers see is written as `observer_1.png` and `observer_2.png`.

mod app;

use std::error::Error;

use app::{App, OBSERVERS};
use sky_core::tonemap::{Tone, encoded, tone_mapped};
use sky_gpu::Tier;

const SIZE: [u32; 2] = [960, 540];

/// A component of a picture, 0–1, in 8 bits.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "clamped to 0..255"
)]
fn byte(component: f32) -> u8 {
    (component * 255.0).round().clamp(0.0, 255.0) as u8
}

fn main() -> Result<(), Box<dyn Error>> {
    let directory = std::env::args().nth(1).unwrap_or_else(|| ".".into());
    let app = App::new()?;
    let mut windows = OBSERVERS.map(|observer| app.open(observer, SIZE));
    app.draw(&mut windows, Tier::Baked)?;
    for (window, name) in windows.iter().zip(["observer_1.png", "observer_2.png"]) {
        // the engine's own display: the target has light, this is its camera
        let shown: Vec<u8> = app
            .pixels(window)?
            .into_iter()
            .flat_map(|light| tone_mapped(light.map(|c| c * 1.2e-4), Tone::Neutral))
            .map(|c| byte(encoded(c)))
            .collect();
        let path = std::path::Path::new(&directory).join(name);
        image::save_buffer(path, &shown, SIZE[0], SIZE[1], image::ColorType::Rgb8)?;
    }
    Ok(())
}
