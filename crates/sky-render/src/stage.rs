//! What each way to draw a sky costs on a GPU, beside the floor of a constant color.

use std::time::Instant;

use anyhow::Result;
use glam::Vec3;
use sky_core::haze::Haze;
use sky_core::quantity::{Angle, Length};
use sky_core::utm_sky::UtmSky;
use sky_gpu::headless::Headless;
use sky_gpu::{
    Camera, Dome, Exposure, FrameSettings, Output, SkyRenderer, SkyRendererOptions, Tier, Timing,
    View,
};
use sky_science::metrics::Statistics;

use crate::camera::{looking, pixels, world_direction};
use crate::shot::bind_scene;
use crate::terrain::SceneBuffers;

/// One way to draw.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// Its name in the table.
    pub name: &'static str,
    /// The tier; `None` is the floor.
    pub tier: Option<Tier>,
    /// Whether a scene is laid over it.
    pub composite: bool,
}

const fn case(name: &'static str, tier: Option<Tier>, composite: bool) -> Case {
    Case {
        name,
        tier,
        composite,
    }
}

/// The cases, the floor first.
pub const CASES: [Case; 7] = [
    case("floor", None, false),
    case("vertex", Some(Tier::Vertex(Dome::REPORT)), false),
    case("fragment", Some(Tier::Fragment), false),
    case("baked", Some(Tier::Baked), false),
    case("vertex+composite", Some(Tier::Vertex(Dome::REPORT)), true),
    case("fragment+composite", Some(Tier::Fragment), true),
    case("baked+composite", Some(Tier::Baked), true),
];

/// What a case costs \[ns a pixel\].
#[derive(Clone, Copy, Debug)]
pub struct Cost {
    /// Half of the frames took less.
    pub median_ns: f64,
    /// 95 % of the frames took less.
    pub p95_ns: f64,
}

/// The adapter and its driver, without quotation marks.
#[must_use]
pub fn adapter_name(gpu: &Headless) -> String {
    format!("{} ({})", gpu.info.name, gpu.info.driver_info).replace('"', "'")
}

/// One thing that is drawn and timed.
pub type Draw<'a> = Box<dyn Fn(&mut wgpu::RenderPass<'_>) + 'a>;

/// A target and our own renderer, ready to be timed.
#[derive(Debug)]
pub struct Stage {
    size: [u32; 2],
    target: wgpu::TextureView,
    floor: wgpu::RenderPipeline,
    renderer: SkyRenderer,
    /// Prepared for each tier.
    views: [(Tier, View); 3],
    scene: wgpu::BindGroup,
}

/// The full-screen triangle with a constant color: what the tiers are measured against.
const FLOOR: &str = "
@vertex
fn floor_vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return vec4<f32>(f32((index << 1u) & 2u) * 2.0 - 1.0, f32(index & 2u) * 2.0 - 1.0, 0.0, 1.0);
}
@fragment
fn floor_fragment() -> @location(0) vec4<f32> {
    return vec4<f32>(0.25, 0.5, 0.75, 1.0);
}
";

fn floor(device: &wgpu::Device, format: wgpu::TextureFormat) -> wgpu::RenderPipeline {
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("floor"),
        source: wgpu::ShaderSource::Wgsl(FLOOR.into()),
    });
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("floor"),
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("floor_vertex"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: None,
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("floor_fragment"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(format.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// What a stage shows.
fn stage_frame() -> FrameSettings {
    FrameSettings {
        observer_altitude: Length::from_km(STAGE_PLACE[0]),
        haze: Haze::Turbidity(STAGE_PLACE[1]),
        sun: world_direction(
            Angle::ZERO,
            Angle::from_degrees(90.0 - STAGE_SUN_ZENITH_DEG),
        ),
        up: Vec3::Z,
        exposure: Exposure::Ev100(14.0),
        tone: None,
        ..FrameSettings::default()
    }
}

/// The sun of a stage is 60° from the zenith, due north.
pub const STAGE_SUN_ZENITH_DEG: f64 = 60.0;
/// Altitude \[km\] and turbidity of a stage.
pub const STAGE_PLACE: [f64; 2] = [0.05, 2.5];

impl Stage {
    /// A stage of a size; its lower edge looks 5° up, so that the picture is all sky.
    ///
    /// # Errors
    /// When the size cannot be drawn.
    pub fn new(gpu: &Headless, size: [u32; 2]) -> Result<Self> {
        let format = wgpu::TextureFormat::Rgba16Float;
        let target = gpu.target(size, format)?;
        let sky = UtmSky::embedded()?;
        let options = SkyRendererOptions::new(format, Output::Linear);
        let renderer = SkyRenderer::new(&gpu.device, &sky, &options);
        let mut encoder = gpu
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut views = [Tier::Vertex(Dome::REPORT), Tier::Fragment, Tier::Baked]
            .map(|tier| (tier, renderer.view(&gpu.device)));
        for (tier, view) in &mut views {
            renderer.update(&gpu.queue, view, &stage_frame())?;
            renderer.set_camera(&gpu.queue, view, &Self::camera(size));
            renderer.prepare(&gpu.queue, &mut encoder, view, *tier);
        }
        gpu.queue.submit([encoder.finish()]);
        let [width, height] = size;
        let scene = SceneBuffers::new(
            width,
            (0..height).flat_map(|y| {
                let distance = if 2 * y >= height { 50.0 } else { 0.0 };
                (0..width).map(move |_| ([500.0; 3], distance))
            }),
        );
        let scene = bind_scene(gpu, &renderer, &scene, size)?;
        Ok(Self {
            size,
            target: target.create_view(&wgpu::TextureViewDescriptor::default()),
            floor: floor(&gpu.device, format),
            renderer,
            views,
            scene,
        })
    }

    /// The camera of a stage.
    #[must_use]
    pub fn camera(size: [u32; 2]) -> Camera {
        let aspect = pixels(size[0]) / pixels(size[1]);
        let fov = sky_core::quantity::single(Angle::from_degrees(60.0).radians());
        Camera {
            depth_is_distance: true,
            ..Camera::perspective(fov, aspect, looking(20.0, 35.0))
        }
    }

    /// What draws a case.
    #[must_use]
    pub fn draw(&self, case: Case) -> Draw<'_> {
        let view = self.views.iter().find(|(tier, _)| case.tier == Some(*tier));
        Box::new(move |pass| {
            let Some((_, view)) = view else {
                pass.set_pipeline(&self.floor);
                pass.draw(0..3, 0..1);
                return;
            };
            self.renderer.draw(pass, view);
            if case.composite {
                self.renderer.composite(pass, view, &self.scene, true);
            }
        })
    }

    /// Times several things in turn, frame by frame, each up to a number of frames or seconds.
    ///
    /// # Errors
    /// When the device is lost.
    pub fn interleaved(
        &self,
        gpu: &Headless,
        draws: &[Draw<'_>],
        frames: u32,
        most_seconds: f64,
        tick: &dyn Fn(),
    ) -> Result<Vec<Cost>> {
        let clock = Clock::new(gpu);
        let count = f64::from(self.size[0]) * f64::from(self.size[1]);
        let mut times = vec![Vec::new(); draws.len()];
        for i in 0..=frames {
            for (draw, times) in draws.iter().zip(&mut times) {
                if times.iter().sum::<f64>() * count > most_seconds * 1e9 {
                    continue;
                }
                let ns = clock.time(gpu, |encoder, timing| {
                    draw(&mut Headless::pass(encoder, &self.target, timing));
                })?;
                // the first frame compiles; it counts only where it has used up the time
                if i > 0 || ns > 0.5e9 * most_seconds {
                    times.push(ns / count);
                }
            }
            tick();
        }
        Ok(times
            .iter()
            .filter_map(|t| Statistics::of(t))
            .map(|s| Cost {
                median_ns: s.median,
                p95_ns: s.p95,
            })
            .collect())
    }
}

/// The GPU's clock, or the wall's where it has none.
#[derive(Debug)]
pub struct Clock {
    gpu: Option<GpuClock>,
}

#[derive(Debug)]
struct GpuClock {
    queries: wgpu::QuerySet,
    resolve: wgpu::Buffer,
    read: wgpu::Buffer,
    tick_ns: f64,
}

impl Clock {
    /// The best that a device has.
    #[must_use]
    pub fn new(gpu: &Headless) -> Self {
        let buffer = |usage| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("timestamps"),
                size: 16,
                usage,
                mapped_at_creation: false,
            })
        };
        Self {
            gpu: gpu.timestamp_ns.map(|tick_ns| GpuClock {
                queries: gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                    label: Some("timestamps"),
                    ty: wgpu::QueryType::Timestamp,
                    count: 2,
                }),
                resolve: buffer(wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC),
                read: buffer(wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ),
                tick_ns: tick_ns.into(),
            }),
        }
    }

    /// Runs one pass and tells its time \[ns\].
    ///
    /// # Errors
    /// When the device is lost.
    pub fn time(
        &self,
        gpu: &Headless,
        record: impl FnOnce(&mut wgpu::CommandEncoder, Option<Timing<'_>>),
    ) -> Result<f64> {
        let mut encoder = gpu
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let Some(clock) = &self.gpu else {
            record(&mut encoder, None);
            let start = Instant::now();
            gpu.queue.submit([encoder.finish()]);
            gpu.device.poll(wgpu::PollType::wait_indefinitely())?;
            return Ok(start.elapsed().as_secs_f64() * 1e9);
        };
        record(
            &mut encoder,
            Some(Timing {
                queries: &clock.queries,
                first: 0,
            }),
        );
        encoder.resolve_query_set(&clock.queries, 0..2, &clock.resolve, 0);
        encoder.copy_buffer_to_buffer(&clock.resolve, 0, &clock.read, 0, 16);
        gpu.queue.submit([encoder.finish()]);
        let bytes = gpu.mapped(&clock.read)?;
        clock.read.unmap();
        let tick = |b: &[u8]| u64::from_le_bytes(b.try_into().unwrap_or([0; 8]));
        let ticks = tick(&bytes[8..16]).saturating_sub(tick(&bytes[..8]));
        #[expect(
            clippy::cast_precision_loss,
            reason = "a pass takes far fewer than 2^52 ticks"
        )]
        let ticks = ticks as f64;
        Ok(ticks * clock.tick_ns)
    }
}
