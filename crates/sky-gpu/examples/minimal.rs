//! A window and the sky in it: `cargo run --release -p sky-gpu --example minimal [-- --frames N]`.

use std::{error::Error, sync::Arc};

use sky_core::utm_sky::UtmSky;
use sky_gpu::glam::{Mat3, Vec3};
use sky_gpu::{Camera, Haze, SkyFrame, SkyRenderer, Tier, headless::Headless, screen::Screen};
use winit::event_loop::{ActiveEventLoop, EventLoop};
use winit::window::{Window, WindowAttributes, WindowId};
use winit::{application::ApplicationHandler, event::WindowEvent};

/// The window, its device, and the one object that draws skies; pictures until the end.
type View = (Arc<Window>, Screen, SkyRenderer);
struct App(Option<View>, u32);

fn open(events: &ActiveEventLoop) -> Result<View, Box<dyn Error>> {
    let window = Arc::new(events.create_window(WindowAttributes::default())?);
    let screen = Screen::new(Arc::clone(&window), window.inner_size().into(), None)?;
    // once for a device and a format: the table and the pipelines
    let table = UtmSky::embedded()?;
    let sky = SkyRenderer::new(&screen.gpu.device, table.lut(), screen.format())?;
    Ok((window, screen, sky))
}

fn draw((window, screen, sky): &mut View) -> Result<(), Box<dyn Error>> {
    window.request_redraw();
    let Some(picture) = screen.next_picture()? else {
        std::thread::sleep(std::time::Duration::from_millis(20)); // minimized or hidden
        return Ok(());
    };
    // every frame: where the sun is, in a world of your choice, and how hazy the air is
    let frame = SkyFrame {
        sun: Vec3::new(0.3, 0.8, 0.3),
        up: Vec3::Z,
        haze: Haze::Turbidity(2.5),
        ..SkyFrame::default()
    };
    let (device, queue) = (&screen.gpu.device, &screen.gpu.queue);
    sky.update(queue, &frame)?;
    // the view's right, up and backward in the world
    let looking = Mat3::from_cols(Vec3::X, Vec3::Z, -Vec3::Y).transpose();
    let camera = Camera::perspective(1.0, screen.aspect(), looking);
    sky.set_camera(queue, 0, &camera);
    let mut encoder = device.create_command_encoder(&Default::default());
    sky.prepare(&mut encoder, Tier::Fragment);
    let target = picture.texture.create_view(&Default::default());
    let mut pass = Headless::pass(&mut encoder, &target, None); // a pass like any other
    sky.draw(&mut pass, 0, Tier::Fragment);
    drop(pass);
    queue.submit([encoder.finish()]);
    screen.present(picture);
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
