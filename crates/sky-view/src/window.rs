//! The window: its events, the frame, and what happens when the device is lost.

use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::{Result, anyhow, bail};
use glam::Mat4;
use sky_core::conditions::{Conditions, Domain};
use sky_core::haze::Haze;
use sky_core::quantity::{Angle, single};
use sky_core::solar_position::SunPosition;
use sky_core::utm_sky::UtmSky;
use sky_gpu::screen::{Screen, ScreenError};
use sky_gpu::{Camera, Exposure, FrameSettings};
use sky_render::terrain::ridges;
use sky_render::{GROUND_ALBEDO, Pixels, world_direction};
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::{ElementState, MouseButton, MouseScrollDelta, StartCause, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop};
use winit::keyboard::{KeyCode, PhysicalKey};
use winit::window::{Window, WindowId};

use crate::flight::{Asked, EYE_KM, Flight, Keys};
use crate::painter::{Layers, Overlay, Painter, View};
use crate::panel::{self, Controls, Status};

/// What a window on X11 loads when it opens, by its names on Debian and Ubuntu.
const LIBRARIES: &str = "libx11-6 libx11-xcb1 libxcursor1 libxi6 libxkbcommon-x11-0";
/// Degrees that the look turns by a pixel of the mouse's way.
const DEGREES_PER_PIXEL: f64 = 0.15;
/// Longest time that a frame stands for \[s\]: after a pause nobody is a kilometer farther.
const LONGEST_STEP_S: f64 = 0.1;
/// Time until the next look at a window that shows nothing.
const IDLE: Duration = Duration::from_millis(50);
/// Devices that may be lost one after the other without a picture between.
const MAX_LOSSES: u32 = 3;
/// What an angle may lose as a direction in f32 \[deg\].
const ROUNDING_DEG: f64 = 1e-4;
/// How much a new time weighs in a mean.
const SMOOTHING: f64 = 0.1;

/// What a window begins with.
#[derive(Debug)]
pub struct Start {
    /// The sky.
    pub sky: UtmSky,
    /// Everything that can be set.
    pub controls: Controls,
    /// Size of the window \[pixels\].
    pub size: [u32; 2],
    /// A part of the GPU's name; `None` for the fastest.
    pub adapter: Option<String>,
    /// Vertical field of view.
    pub fov: Angle,
    /// Ends after so many frames.
    pub frames: Option<u32>,
    /// For tests: destroys the device after so many frames.
    pub lose_device_after: Option<u32>,
    /// Whether the last frame is wanted as a picture.
    pub wants_last_picture: bool,
    /// Where the screenshots go that are asked for in the window; says what came of it.
    pub keep: fn(&Screenshot) -> String,
}

/// A frame as a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Screenshot {
    /// Its pixels.
    pub pixels: Pixels,
    /// Pixels across and down.
    pub size: [u32; 2],
}

/// Opens a window and flies until it is closed; the last frame where it was wanted and there was one.
///
/// # Errors
/// When there is no display or GPU, or a frame cannot be drawn.
pub fn run(start: Start) -> Result<Option<Screenshot>> {
    let events = EventLoop::new().map_err(|e| {
        // what comes before the last colon is a line of the library's source
        let reason = e.to_string();
        let reason = reason.rsplit(": ").next().unwrap_or(&reason);
        let reason = reason.trim_end_matches(['.', ')']);
        anyhow!(
            "display: expected an X11 or Wayland display, found none ({reason}); start a desktop, or \
             Xvfb (on Debian or Ubuntu: xvfb {LIBRARIES}), or draw without a window by utm-sky render"
        )
    })?;
    let mut app = App::new(start);
    events.run_app(&mut app)?;
    app.outcome?;
    Ok(app.last_picture)
}

/// The window and what belongs to it.
struct Stage {
    /// Lost and made anew; the surface must go before the window.
    painter: Option<Painter>,
    input: egui_winit::State,
    window: Arc<Window>,
}

struct App {
    table: UtmSky,
    size: [u32; 2],
    adapter: Option<String>,
    fov: f32,
    frames: Option<u32>,
    lose_device_after: Option<u32>,
    wants_last_picture: bool,
    controls: Controls,
    status: Status,
    keys: Keys,
    is_dragging: bool,
    /// Last place of the pointer \[pixels\].
    pointer: [f64; 2],
    last_frame: Option<Instant>,
    /// The last sky's conditions inside the domain.
    conditions: Option<Conditions>,
    frames_drawn: u32,
    losses: u32,
    is_idle: bool,
    stage: Option<Stage>,
    last_picture: Option<Screenshot>,
    keep: fn(&Screenshot) -> String,
    outcome: Result<()>,
}

impl App {
    fn new(start: Start) -> Self {
        let domain: Domain = start.sky.lut().header().domain;
        Self {
            table: start.sky.clone(),
            size: start.size,
            adapter: start.adapter,
            fov: single(start.fov.radians()),
            frames: start.frames,
            lose_device_after: start.lose_device_after,
            wants_last_picture: start.wants_last_picture,
            keep: start.keep,
            controls: start.controls,
            status: Status {
                gpu: String::new(),
                domain,
                sun: None,
                edges: [None; 3],
                trouble: None,
                ev100: 0.0,
                times_ms: [0.0; 3],
                screenshot: None,
            },
            keys: Keys::default(),
            is_dragging: false,
            pointer: [0.0; 2],
            last_frame: None,
            conditions: None,
            frames_drawn: 0,
            losses: 0,
            is_idle: false,
            stage: None,
            last_picture: None,
            outcome: Ok(()),
        }
    }

    fn open(&mut self, events: &ActiveEventLoop) -> Result<()> {
        let [width, height] = self.size;
        let attributes = Window::default_attributes()
            .with_title("UTM sky")
            .with_inner_size(PhysicalSize::new(width, height));
        let window = events
            .create_window(attributes)
            .map_err(|e| anyhow!("window: expected one, found none ({e})"))?;
        self.stage = Some(self.stage(Arc::new(window))?);
        Ok(())
    }

    /// All that is on a device, for a window that is there.
    fn stage(&mut self, window: Arc<Window>) -> Result<Stage> {
        let size = window.inner_size().into();
        let screen = Screen::new(Arc::clone(&window), size, self.adapter.as_deref()).map_err(
            |e| match e {
                ScreenError::NoAdapter(_) => {
                    anyhow!("{e}, or draw without one by utm-sky render --backend cpu")
                }
                e => anyhow!("{e}"),
            },
        )?;
        let info = &screen.gpu.info;
        self.status.gpu = format!("{} ({})", info.name, info.backend);
        let context = egui::Context::default();
        let input = egui_winit::State::new(
            context,
            egui::ViewportId::ROOT,
            &window,
            Some(single(window.scale_factor())),
            None,
            usize::try_from(screen.gpu.device.limits().max_texture_dimension_2d).ok(),
        );
        Ok(Stage {
            painter: Some(Painter::new(screen, &self.table)),
            input,
            window,
        })
    }

    /// A frame, or nothing where nothing can be shown; a new device if the old one is lost.
    fn frame(&mut self) -> Result<bool> {
        let is_last = self.wants_last_picture && self.frames == Some(self.frames_drawn + 1);
        match self.draw(is_last) {
            Ok(drawn) => {
                if drawn {
                    self.losses = 0;
                }
                Ok(drawn)
            }
            Err(error) if is_lost(&error) && self.losses < MAX_LOSSES => {
                self.losses += 1;
                let Some(mut stage) = self.stage.take() else {
                    return Ok(false);
                };
                // the old surface first: a window has one
                drop(stage.painter.take());
                let window = Arc::clone(&stage.window);
                drop(stage);
                self.stage = Some(self.stage(window)?);
                self.is_idle = false;
                Ok(false)
            }
            Err(error) => Err(error),
        }
    }

    /// Draws and shows a frame; keeps it as a picture if it is the last.
    fn draw(&mut self, is_last: bool) -> Result<bool> {
        let Some(Stage {
            painter: Some(painter),
            input,
            window,
        }) = &mut self.stage
        else {
            return Ok(false);
        };
        let Some(target) = painter.screen.next_target()? else {
            self.last_frame = None;
            return Ok(false);
        };
        let passed = passed(&mut self.last_frame, &mut self.status);
        let controls = &mut self.controls;
        if !controls.paused {
            controls.flight.step(self.keys, passed);
            controls.sun.step(passed);
        }
        let frame = sky_frame(controls, &mut self.status, &mut self.conditions)?;
        let camera = Camera::perspective(
            self.fov,
            painter.screen.aspect(),
            controls.flight.view_from_world(),
        );
        let ground_km = ground_km(&controls.flight);
        let view = View {
            place_km: controls.flight.place_km,
            altitude_km: controls.flight.altitude_km,
            above_ground_km: controls.flight.altitude_km - ground_km,
            clip_from_world: camera.clip_from_world().unwrap_or(Mat4::IDENTITY),
            sun: frame.sun,
        };
        let layers = Layers {
            tier: controls.tier,
            terrain: controls.terrain,
            aerial: controls.aerial,
        };
        let updated = painter.update(&frame, controls.terrain.then_some(&view))?;
        self.status.ev100 = updated.auto_ev100;
        for (shown, spent) in self.status.times_ms[1..].iter_mut().zip(updated.times) {
            mean(shown, 1e3 * spent.as_secs_f64());
        }
        if controls.stripes && self.status.edges.iter().any(Option::is_some) {
            painter.show_outside_domain(&frame);
        }
        painter.set_camera(&camera);

        let overlay = overlay(input, window, controls, &self.status);
        let size = [target.texture.width(), target.texture.height()];
        let target_view = target
            .texture
            .create_view(&wgpu::TextureViewDescriptor::default());
        let mut encoder = painter
            .screen
            .gpu
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        painter.draw(&mut encoder, &target_view, size, &view, layers);
        painter.draw_panel(&mut encoder, &target_view, &overlay);
        painter.screen.gpu.queue.submit([encoder.finish()]);
        window.pre_present_notify();
        painter.screen.present(target);
        self.frames_drawn += 1;

        self.keep_picture(size, &view, layers, is_last)?;
        Ok(true)
    }

    /// After a frame: its picture where one was asked for, and the end of the device for tests.
    fn keep_picture(
        &mut self,
        size: [u32; 2],
        view: &View,
        layers: Layers,
        is_last: bool,
    ) -> Result<()> {
        let Some(painter) = self.stage.as_mut().and_then(|s| s.painter.as_mut()) else {
            return Ok(());
        };
        let is_asked = std::mem::take(&mut self.controls.screenshot);
        if is_asked || is_last {
            let pixels = screenshot(painter, size, view, layers)?;
            let picture = Screenshot { pixels, size };
            if is_asked {
                self.status.screenshot = Some((self.keep)(&picture));
            }
            self.last_picture = Some(picture);
        }
        if self.lose_device_after == Some(self.frames_drawn) {
            self.lose_device_after = None;
            painter.screen.gpu.device.destroy();
        }
        Ok(())
    }

    fn key(&mut self, code: KeyCode, is_down: bool) {
        match code {
            KeyCode::KeyW | KeyCode::ArrowUp => self.keys.forward = is_down,
            KeyCode::KeyS | KeyCode::ArrowDown => self.keys.back = is_down,
            KeyCode::KeyA | KeyCode::ArrowLeft => self.keys.left = is_down,
            KeyCode::KeyD | KeyCode::ArrowRight => self.keys.right = is_down,
            KeyCode::KeyE | KeyCode::PageUp => self.keys.up = is_down,
            KeyCode::KeyQ | KeyCode::PageDown => self.keys.down = is_down,
            KeyCode::ShiftLeft | KeyCode::ShiftRight => self.keys.fast = is_down,
            KeyCode::KeyP if is_down => self.controls.paused = !self.controls.paused,
            KeyCode::F12 if is_down => self.controls.screenshot = true,
            KeyCode::Tab if is_down => self.controls.panel = !self.controls.panel,
            _ => {}
        }
    }

    /// The pointer has moved; while it drags, the look turns.
    fn point(&mut self, to: [f64; 2]) {
        if self.is_dragging {
            let [right, down] = [to[0] - self.pointer[0], to[1] - self.pointer[1]];
            let flight = &mut self.controls.flight;
            flight.turn(DEGREES_PER_PIXEL * right, -DEGREES_PER_PIXEL * down);
        }
        self.pointer = to;
    }

    fn handle(&mut self, events: &ActiveEventLoop, event: &WindowEvent) -> Result<()> {
        let Some(stage) = &mut self.stage else {
            return Ok(());
        };
        // egui would take the tab key for itself
        let is_tab = matches!(event, WindowEvent::KeyboardInput { event, .. }
            if event.physical_key == PhysicalKey::Code(KeyCode::Tab));
        let is_taken = !is_tab && stage.input.on_window_event(&stage.window, event).consumed;
        match event {
            WindowEvent::CloseRequested => {
                events.exit();
                if self.wants_last_picture {
                    self.draw(true)?;
                }
            }
            WindowEvent::Resized(size) => {
                if let Some(painter) = &mut stage.painter {
                    painter.screen.resize((*size).into());
                }
                self.is_idle = false;
                stage.window.request_redraw();
            }
            WindowEvent::RedrawRequested => {
                self.is_idle = !self.frame()?;
                if self.frames.is_some_and(|n| self.frames_drawn >= n) {
                    events.exit();
                }
            }
            WindowEvent::Focused(false) => {
                self.keys = Keys::default();
                self.is_dragging = false;
            }
            WindowEvent::KeyboardInput { event, .. } => {
                let is_down = event.state == ElementState::Pressed;
                if let PhysicalKey::Code(code) = event.physical_key
                    && (!is_taken || !is_down)
                    && (!event.repeat || is_movement(code))
                {
                    self.key(code, is_down);
                }
            }
            WindowEvent::MouseInput { state, button, .. } => {
                if matches!(button, MouseButton::Left | MouseButton::Right) {
                    self.is_dragging = *state == ElementState::Pressed && !is_taken;
                }
            }
            WindowEvent::CursorMoved { position, .. } => {
                self.point([position.x, position.y]);
            }
            WindowEvent::MouseWheel { delta, .. } if !is_taken => {
                let notches = match delta {
                    MouseScrollDelta::LineDelta(_, y) => f64::from(*y),
                    MouseScrollDelta::PixelDelta(way) => way.y / 40.0,
                };
                self.controls.flight.change_speed(1.25_f64.powf(notches));
            }
            _ => {}
        }
        Ok(())
    }
}

/// The panel's triangles, after what is set there was taken.
fn overlay(
    input: &mut egui_winit::State,
    window: &Window,
    controls: &mut Controls,
    status: &Status,
) -> Overlay {
    let context = input.egui_ctx().clone();
    let output = context.run_ui(input.take_egui_input(window), |ui| {
        panel::show(ui.ctx(), controls, status);
    });
    input.handle_platform_output(window, output.platform_output);
    Overlay {
        primitives: context.tessellate(output.shapes, output.pixels_per_point),
        textures: output.textures_delta,
        pixels_per_point: output.pixels_per_point,
    }
}

const fn is_movement(code: KeyCode) -> bool {
    !matches!(code, KeyCode::KeyP | KeyCode::F12 | KeyCode::Tab)
}

fn is_lost(error: &anyhow::Error) -> bool {
    matches!(error.downcast_ref(), Some(ScreenError::Lost))
}

/// Seconds since the last frame, which go into its mean.
fn passed(last_frame: &mut Option<Instant>, status: &mut Status) -> f64 {
    let now = Instant::now();
    last_frame.replace(now).map_or(0.0, |last| {
        let seconds = (now - last).as_secs_f64();
        mean(&mut status.times_ms[0], 1e3 * seconds);
        seconds.min(LONGEST_STEP_S)
    })
}

/// A running mean.
fn mean(mean: &mut f64, new: f64) {
    *mean = if *mean > 0.0 {
        *mean + SMOOTHING * (new - *mean)
    } else {
        new
    };
}

/// Height of the ground under the observer \[km\].
fn ground_km(flight: &Flight) -> f64 {
    let [east, north] = flight.place_km.map(single);
    ridges(east, north).into()
}

/// The renderer's frame. What lies outside the domain stops at its edge, and the status says so; a haze
/// or date that cannot be leaves the last sky, and the status says so too.
fn sky_frame(
    controls: &mut Controls,
    status: &mut Status,
    last: &mut Option<Conditions>,
) -> Result<FrameSettings> {
    status.trouble = None;
    status.edges = [None; 3];
    if controls.terrain {
        let floor = ground_km(&controls.flight) + EYE_KM;
        controls.flight.altitude_km = controls.flight.altitude_km.max(floor);
    } else if status.domain.altitude_km[0] <= 0.0 {
        controls.flight.altitude_km = controls.flight.altitude_km.max(0.0);
    }
    match controls.sun.position() {
        Ok(sun) => status.sun = Some(sun),
        Err(error) => status.trouble = Some(format!("sun: {error}")),
    }
    let sun = status.sun.unwrap_or(SunPosition {
        zenith: Angle::from_degrees(60.0),
        azimuth: Angle::from_degrees(180.0),
    });
    let asked = Asked {
        altitude_km: controls.flight.altitude_km,
        haze: controls.haze.0.haze(controls.haze.1),
        sun,
    };
    match asked.within(&status.domain) {
        Ok(shown) => {
            status.edges = shown.edges;
            *last = Some(shown.conditions);
        }
        Err(error) => status.trouble = Some(format!("haze: {error}")),
    }
    let Some(conditions) = *last else {
        bail!("haze: expected one for the first frame, found none");
    };
    // the flight stops where the table does
    controls.flight.altitude_km = conditions.observer_altitude.km();
    // a direction in f32 that comes from the edge must not end beyond it
    let [highest, lowest] = status.domain.sun_zenith_deg;
    let zenith = conditions.sun_zenith.degrees();
    let zenith = zenith.clamp(highest, (lowest - ROUNDING_DEG).max(highest));
    let elevation = Angle::from_degrees(90.0 - zenith);
    Ok(FrameSettings {
        observer_altitude: conditions.observer_altitude,
        haze: Haze::Turbidity(conditions.turbidity),
        sun: world_direction(sun.azimuth, elevation),
        ground_albedo: GROUND_ALBEDO,
        sun_disc: controls.sun_disc,
        exposure: controls.ev100.map_or(Exposure::Auto, Exposure::Ev100),
        tone: Some(controls.tone),
        ..FrameSettings::default()
    })
}

/// The frame once more, without the panel.
fn screenshot(
    painter: &mut Painter,
    size: [u32; 2],
    view: &View,
    layers: Layers,
) -> Result<Pixels> {
    let format = painter.screen.format();
    let texture = painter.screen.gpu.target(size, format)?;
    let target = texture.create_view(&wgpu::TextureViewDescriptor::default());
    let mut encoder = painter
        .screen
        .gpu
        .device
        .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    painter.draw(&mut encoder, &target, size, view, layers);
    painter.screen.gpu.queue.submit([encoder.finish()]);
    let order = match format.remove_srgb_suffix() {
        wgpu::TextureFormat::Bgra8Unorm => [2, 1, 0],
        wgpu::TextureFormat::Rgba8Unorm => [0, 1, 2],
        other => bail!("screenshot: expected a window of 8 bits a color, found {other:?}"),
    };
    let bytes = painter.screen.gpu.read(&texture)?;
    Ok(Pixels::Srgb8(
        bytes
            .chunks_exact(4)
            .flat_map(|pixel| order.map(|i| pixel[i]))
            .collect(),
    ))
}

impl ApplicationHandler for App {
    fn new_events(&mut self, _: &ActiveEventLoop, cause: StartCause) {
        if let (StartCause::ResumeTimeReached { .. }, Some(stage)) = (cause, &self.stage) {
            stage.window.request_redraw();
        }
    }

    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.stage.is_none()
            && let Err(error) = self.open(events)
        {
            self.outcome = Err(error);
            events.exit();
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        if self.outcome.is_err() || events.exiting() {
            return;
        }
        if let Err(error) = self.handle(events, &event) {
            self.outcome = Err(error);
            events.exit();
        }
    }

    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        if self.is_idle {
            events.set_control_flow(ControlFlow::WaitUntil(Instant::now() + IDLE));
        } else if let Some(stage) = &self.stage {
            // the surface waits for the display, so this is no busy loop
            events.set_control_flow(ControlFlow::Wait);
            stage.window.request_redraw();
        }
    }

    fn exiting(&mut self, _: &ActiveEventLoop) {
        // surface and device go while the window is still there
        self.stage = None;
    }
}
