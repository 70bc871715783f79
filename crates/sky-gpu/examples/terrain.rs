//! Hills under the sky, and the air before them: `cargo run --release -p sky-gpu --example terrain
//! [-- --frames N]`.
//!
//! The scene is drawn first, by code that knows nothing of the sky, into two textures: linear light in
//! cd/m² and reversed depth. Then the sky is drawn over the whole window, and `composite` lays the scene
//! over it, pixel by pixel, behind as much air as its depth says. What is marked (1) to (4) is all that
//! the sky needs; the rest is any renderer's.

use std::{error::Error, sync::Arc};

use sky_core::picture::Picture;
use sky_core::quantity::{Angle, Length};
use sky_core::solar_position::{GeoPlace, UtcTime, sun_position};
use sky_core::utm_sky::UtmSky;
use sky_gpu::glam::{Mat3, Mat4, Vec3};
use sky_gpu::headless::Headless;
use sky_gpu::screen::Screen;
use sky_gpu::{Camera, FrameSettings, Haze, Output, SkyRenderer, SkyRendererOptions, Tier, View};
use winit::application::ApplicationHandler;
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, EventLoop};
use winit::window::{Window, WindowAttributes, WindowId};

/// Of the scene's textures: light needs the range of a half float, depth all of f32's precision.
const COLOR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// The camera's altitude \[m\]; it is also the origin of the scene's coordinates, in meters.
const ALTITUDE_M: f32 = 900.0;

/// A grid that is fine near the camera and coarse 80 km away, made from the vertex number alone.
const HILLS: &str = "
struct Scene {
    clip_from_world: mat4x4<f32>,
    sun: vec4<f32>,       // toward it; w: the camera's altitude [m]
    sun_light: vec4<f32>, // on a plane facing the sun [lx]
    sky_light: vec4<f32>, // of the sky on a horizontal plane [lx]
}
@group(0) @binding(0) var<uniform> scene: Scene;

struct Hill {
    @builtin(position) position: vec4<f32>,
    @location(0) place: vec2<f32>,
}

fn height(p: vec2<f32>) -> f32 {
    let broad = sin(p.x / 2900.0) + sin(p.y / 3700.0 + 1.0) + sin((p.x + p.y) / 5300.0);
    let fine = sin(p.x / 610.0 + sin(p.y / 870.0)) + sin(p.y / 530.0 - p.x / 1300.0);
    let rough = sin(p.x / 170.0 + sin(p.y / 230.0)) * sin(p.y / 190.0 + p.x / 410.0);
    return 150.0 * broad + 70.0 * fine + 16.0 * rough;
}

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Hill {
    let cell = index / 6u;
    let corner = index % 6u;
    let step = vec2<u32>(u32(corner == 1u || corner == 2u || corner == 4u),
                         u32(corner == 2u || corner == 4u || corner == 5u));
    let grid = vec2<f32>(vec2<u32>(cell % 320u, cell / 320u) + step) / 160.0 - 1.0;
    var hill: Hill;
    hill.place = 80000.0 * grid * grid * grid;
    // the Earth falls away below the horizontal plane
    let fall = dot(hill.place, hill.place) / (2.0 * 6371000.0);
    let up = height(hill.place) - fall - scene.sun.w;
    hill.position = scene.clip_from_world * vec4<f32>(hill.place, up, 1.0);
    return hill;
}

@fragment
fn fragment(hill: Hill) -> @location(0) vec4<f32> {
    let h = height(hill.place);
    let slope = vec2<f32>(height(hill.place + vec2<f32>(20.0, 0.0)),
                          height(hill.place + vec2<f32>(0.0, 20.0))) - h;
    let normal = normalize(vec3<f32>(-slope, 20.0));
    let albedo = mix(vec3<f32>(0.05, 0.09, 0.035), vec3<f32>(0.2, 0.18, 0.15),
                     clamp(4.0 * (1.0 - normal.z), 0.0, 1.0));
    let lit = scene.sun_light.xyz * max(dot(normal, scene.sun.xyz), 0.0)
        + scene.sky_light.xyz * (0.5 + 0.5 * normal.z);
    return vec4<f32>(albedo / 3.14159265 * lit, 1.0); // cd/m2
}
";

/// Corners of the grid's triangles.
const VERTICES: u32 = 6 * 320 * 320;

/// A renderer for the hills.
struct Hills {
    pipeline: wgpu::RenderPipeline,
    uniform: wgpu::Buffer,
    group: wgpu::BindGroup,
}

/// The textures that the hills are drawn to, and what `composite` reads them through.
struct Targets {
    color: wgpu::TextureView,
    depth: wgpu::TextureView,
    under_the_sky: wgpu::BindGroup,
}

struct Opened {
    window: Arc<Window>,
    screen: Screen,
    sky: SkyRenderer,
    view: View,
    hills: Hills,
    targets: Option<Targets>,
}

impl Hills {
    fn new(device: &wgpu::Device) -> Self {
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("hills"),
            source: wgpu::ShaderSource::Wgsl(HILLS.into()),
        });
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("hills"),
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("vertex"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: Default::default(),
            // reversed depth: 1 near, 0 infinitely far, where f32 is finest
            depth_stencil: Some(wgpu::DepthStencilState {
                format: DEPTH,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::Greater),
                stencil: Default::default(),
                bias: Default::default(),
            }),
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("fragment"),
                compilation_options: Default::default(),
                targets: &[Some(COLOR.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        let uniform = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("hills"),
            size: 4 * 28,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("hills"),
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: uniform.as_entire_binding(),
            }],
        });
        Self {
            pipeline,
            uniform,
            group,
        }
    }

    /// Lights the hills by the same sun and sky that the window shows.
    fn update(&self, queue: &wgpu::Queue, clip_from_world: Mat4, sun: Vec3, picture: &Picture) {
        let light = &picture.light;
        let with = |[r, g, b]: [f32; 3]| [r, g, b, 0.0];
        let floats = clip_from_world
            .to_cols_array()
            .into_iter()
            .chain(sun.extend(ALTITUDE_M).to_array())
            .chain(with(light.sun_normal))
            .chain(with(light.sky_horizontal));
        let mut bytes = [0; 4 * 28];
        for (place, float) in bytes.chunks_exact_mut(4).zip(floats) {
            place.copy_from_slice(&float.to_ne_bytes());
        }
        queue.write_buffer(&self.uniform, 0, &bytes);
    }

    fn draw(&self, encoder: &mut wgpu::CommandEncoder, targets: &Targets) {
        let clear = |value| wgpu::Operations {
            load: wgpu::LoadOp::Clear(value),
            store: wgpu::StoreOp::Store,
        };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("hills"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &targets.color,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &targets.depth,
                // 0 stays where no hill is: there composite leaves the sky alone
                depth_ops: Some(clear(0.0)),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.group, &[]);
        pass.draw(0..VERTICES, 0..1);
    }
}

impl Targets {
    fn new(device: &wgpu::Device, sky: &SkyRenderer, [width, height]: [u32; 2]) -> Self {
        let texture = |format| {
            let texture = device.create_texture(&wgpu::TextureDescriptor {
                label: Some("scene"),
                size: wgpu::Extent3d {
                    width,
                    height,
                    depth_or_array_layers: 1,
                },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT
                    | wgpu::TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            });
            texture.create_view(&Default::default())
        };
        let (color, depth) = (texture(COLOR), texture(DEPTH));
        // (4a) once for every pair of textures
        let under_the_sky = sky.scene(device, &color, &depth);
        Self {
            color,
            depth,
            under_the_sky,
        }
    }
}

impl Opened {
    fn open(events: &ActiveEventLoop) -> Result<Self, Box<dyn Error>> {
        let window = WindowAttributes::default().with_title("Hills under the sky");
        let window = Arc::new(events.create_window(window)?);
        let screen = Screen::new(Arc::clone(&window), window.inner_size().into(), None)?;
        // (1) once for a device and a kind of target: the table and the pipelines; a view for each
        // observer
        let options = SkyRendererOptions::new(screen.format(), Output::Display);
        let sky = SkyRenderer::new(&screen.gpu.device, &UtmSky::embedded()?, &options);
        let view = sky.view(&screen.gpu.device);
        let hills = Hills::new(&screen.gpu.device);
        Ok(Self {
            window,
            screen,
            sky,
            view,
            hills,
            targets: None,
        })
    }

    fn draw(&mut self) -> Result<(), Box<dyn Error>> {
        self.window.request_redraw();
        let Some(shown) = self.screen.next_target()? else {
            std::thread::sleep(std::time::Duration::from_millis(20)); // minimized or hidden
            return Ok(());
        };
        let (device, queue) = (&self.screen.gpu.device, &self.screen.gpu.queue);

        // (2) every frame: observer, sun and haze; the world is east, north, up
        let innsbruck = GeoPlace {
            latitude: Angle::from_degrees(47.26),
            longitude: Angle::from_degrees(11.34),
            altitude: Length::ZERO,
        };
        let evening = UtcTime {
            year: 2025,
            month: 6,
            day: 21,
            hours: 16.5,
        };
        let sun = Vec3::from(sun_position(evening, innsbruck)?.east_north_up());
        let frame = FrameSettings {
            observer_altitude: Length::from_m(ALTITUDE_M.into()),
            haze: Haze::VisualRange(Length::from_km(50.0)),
            sun,
            up: Vec3::Z,
            ..FrameSettings::default()
        };
        let lit = self.sky.update(queue, &mut self.view, &frame)?;

        // (3) the same camera for the scene and the sky: reversed infinite depth, right, up and
        // backward as rows, meters; a projection of your own goes into `Camera::projection`
        let right = Vec3::new(0.5, 0.866, 0.0);
        let looking = Mat3::from_cols(right, Vec3::Z, right.cross(Vec3::Z)).transpose();
        let camera = Camera::perspective(0.9, self.screen.aspect(), looking);
        let clip_from_world = camera.clip_from_world().unwrap_or_default();
        self.hills.update(queue, clip_from_world, sun, lit);
        self.sky.set_camera(queue, &mut self.view, &camera);

        let size = self.screen.size();
        let targets = self
            .targets
            .get_or_insert_with(|| Targets::new(device, &self.sky, size));
        let mut encoder = device.create_command_encoder(&Default::default());
        self.hills.draw(&mut encoder, targets);

        // (4) sky, then the scene behind its air
        self.sky
            .prepare(queue, &mut encoder, &mut self.view, Tier::Fragment);
        let window = shown.texture.create_view(&Default::default());
        let mut pass = Headless::pass(&mut encoder, &window, None);
        self.sky.draw(&mut pass, &self.view);
        self.sky
            .composite(&mut pass, &self.view, &targets.under_the_sky, true);
        drop(pass);
        queue.submit([encoder.finish()]);
        self.screen.present(shown);
        Ok(())
    }
}

/// The window, once it is open, and the pictures until the end.
struct App(Option<Opened>, u32);

impl ApplicationHandler for App {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        self.0 = Some(Opened::open(events).expect("a window and a GPU"));
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(view) = &mut self.0 else { return };
        match event {
            WindowEvent::CloseRequested => events.exit(),
            WindowEvent::Resized(size) => {
                view.screen.resize(size.into());
                view.targets = None;
            }
            WindowEvent::RedrawRequested if self.1 == 0 => events.exit(),
            WindowEvent::RedrawRequested => {
                // a lost device ends the example; how to go on is in the source of utm-sky view
                view.draw().expect("a picture");
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
