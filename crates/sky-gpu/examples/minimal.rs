//! A window and the sky in it: `cargo run --release -p sky-gpu --example minimal [-- --frames N]`.

use std::{error::Error, sync::Arc};

use sky_core::utm_sky::UtmSky;
use sky_gpu::glam::{Mat3, Vec3};
use sky_gpu::{Camera, FrameSettings, Haze, Output, SkyRenderer, SkyRendererOptions, Tier, View};
use sky_gpu::{headless::Headless, screen::Screen};
use winit::event_loop::{ActiveEventLoop, EventLoop};
use winit::window::{Window, WindowAttributes, WindowId};
use winit::{application::ApplicationHandler, event::WindowEvent};

/// The window, its device, what draws skies and what is seen; frames until the end.
type Opened = (Arc<Window>, Screen, SkyRenderer, View);
struct App(Option<Opened>, u32);

fn open(events: &ActiveEventLoop) -> Result<Opened, Box<dyn Error>> {
    let window = Arc::new(events.create_window(WindowAttributes::default())?);
    let screen = Screen::new(Arc::clone(&window), window.inner_size().into(), None)?;
    // once for a device and a kind of target: the table and the pipelines; then a view for each observer
    let device = &screen.gpu.device;
    let options = SkyRendererOptions::new(screen.format(), Output::Display);
    let sky = SkyRenderer::new(device, &UtmSky::embedded()?, &options);
    let view = sky.view(device);
    Ok((window, screen, sky, view))
}

fn draw((window, screen, sky, view): &mut Opened) -> Result<(), Box<dyn Error>> {
    window.request_redraw();
    let Some(shown) = screen.next_target()? else {
        std::thread::sleep(std::time::Duration::from_millis(20)); // minimized or hidden
        return Ok(());
    };
    // every frame: where the sun is, in a world of your choice, and how hazy the air is
    let frame = FrameSettings {
        sun: Vec3::new(0.3, 0.8, 0.3),
        up: Vec3::Z,
        haze: Haze::Turbidity(2.5),
        ..FrameSettings::default()
    };
    let (device, queue) = (&screen.gpu.device, &screen.gpu.queue);
    sky.update(queue, view, &frame)?;
    // the view's right, up and backward in the world
    let looking = Mat3::from_cols(Vec3::X, Vec3::Z, -Vec3::Y).transpose();
    let camera = Camera::perspective(1.0, screen.aspect(), looking);
    sky.set_camera(queue, view, &camera);
    let mut encoder = device.create_command_encoder(&Default::default());
    sky.prepare(queue, &mut encoder, view, Tier::Fragment);
    let target = shown.texture.create_view(&Default::default());
    let mut pass = Headless::pass(&mut encoder, &target, None); // a pass like any other
    sky.draw(&mut pass, view);
    drop(pass);
    queue.submit([encoder.finish()]);
    screen.present(shown);
    Ok(())
}

impl ApplicationHandler for App {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        self.0 = Some(open(events).expect("a window and a GPU"));
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(view) = &mut self.0 else { return };
        match event {
            WindowEvent::CloseRequested => events.exit(),
            WindowEvent::Resized(size) => view.1.resize(size.into()),
            WindowEvent::RedrawRequested if self.1 == 0 => events.exit(),
            WindowEvent::RedrawRequested => {
                draw(view).expect("a picture");
                self.1 -= 1;
            }
            _ => {}
        }
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let frames = std::env::args().nth(2);
    let frames = frames.map_or(Ok(u32::MAX), |n| n.parse())?;
    Ok(EventLoop::new()?.run_app(&mut App(None, frames))?)
}
