//! `utm-sky bench-gpu`: what each way to draw a sky costs, beside the floor of a constant color.

use std::fmt::Write as _;
use std::time::Instant;

use anyhow::Result;
use glam::Vec3;
use sky_core::metrics::Statistics;
use sky_core::quantity::{Angle, Length};
use sky_core::utm_sky::UtmSky;
use sky_gpu::headless::Headless;
use sky_gpu::{Camera, Dome, Exposure, SkyFrame, SkyRenderer, Tier, Timing};

use crate::args::BenchGpuArgs;
use crate::files::OutputFile;
use crate::generate::progress;
use crate::render::{bind_scene, looking, pixels, world_direction};
use crate::terrain::SceneBuffers;

/// Frames that are drawn before any is counted.
const WARM_UP: u32 = 3;

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

/// Runs the command.
///
/// # Errors
/// When there is no GPU or the output cannot be written.
pub fn run(args: &BenchGpuArgs) -> Result<()> {
    let out = OutputFile::create(&args.out)?;
    let gpu = Headless::new()?;
    let costs = measure(&gpu, args.size, args.frames)?;
    let mut text =
        String::from("name,median_ns_per_pixel,p95_ns_per_pixel,ratio_to_floor,adapter\n");
    for (case, cost) in CASES.iter().zip(&costs) {
        writeln!(
            text,
            "{},{:.4},{:.4},{:.3},\"{}\"",
            case.name,
            cost.median_ns,
            cost.p95_ns,
            cost.median_ns / costs[0].median_ns,
            adapter_name(&gpu)
        )?;
    }
    out.commit(text.as_bytes())?;
    Ok(())
}

/// The adapter and its driver, without quotation marks.
#[must_use]
pub fn adapter_name(gpu: &Headless) -> String {
    format!("{} ({})", gpu.info.name, gpu.info.driver_info).replace('"', "'")
}

/// Times every case, in turn, frame by frame.
///
/// # Errors
/// When the device is lost.
pub fn measure(gpu: &Headless, size: [u32; 2], frames: u32) -> Result<Vec<Cost>> {
    let format = wgpu::TextureFormat::Rgba16Float;
    let target = gpu.target(size, format)?;
    let view = target.create_view(&wgpu::TextureViewDescriptor::default());
    let sky = UtmSky::embedded()?;
    let mut renderer = SkyRenderer::new(&gpu.device, sky.lut(), format)?;
    let frame = SkyFrame {
        observer_altitude: Length::from_km(3.0),
        turbidity: 2.5,
        sun: world_direction(Angle::ZERO, Angle::from_degrees(30.0)),
        up: Vec3::Z,
        ground_albedo: 0.2,
        exposure: Exposure::Ev100(14.0),
        tone: None,
    };
    renderer.update(&gpu.queue, &frame)?;
    // the lower edge of the picture looks 5 degrees up: sky alone
    let aspect = pixels(size[0]) / pixels(size[1]);
    let fov = Angle::from_degrees(60.0);
    let camera = Camera {
        depth_is_distance: true,
        ..Camera::perspective(
            sky_core::extended::single(fov.radians()),
            aspect,
            looking(20.0, 35.0),
        )
    };
    renderer.set_camera(&gpu.queue, 0, &camera);
    let [width, height] = size;
    let scene = SceneBuffers::new(
        width,
        (0..height).flat_map(|y| {
            let distance = if 2 * y >= height { 50.0 } else { 0.0 };
            (0..width).map(move |_| ([500.0; 3], distance))
        }),
    );
    let scene = bind_scene(gpu, &renderer, &scene, size)?;
    let clock = Clock::new(gpu);
    let bar = progress("frames", frames as usize);
    let mut times = vec![Vec::new(); CASES.len()];
    for i in 0..WARM_UP + frames {
        for (case, times) in CASES.iter().zip(&mut times) {
            let ns = clock.time(gpu, |encoder, timing| {
                if let Some(tier) = case.tier {
                    renderer.prepare(encoder, tier);
                }
                let mut pass = Headless::pass(encoder, &view, timing);
                match case.tier {
                    None => renderer.draw_floor(&mut pass, 0),
                    Some(tier) => renderer.draw(&mut pass, 0, tier),
                }
                if case.composite {
                    renderer.composite(&mut pass, 0, &scene);
                }
            })?;
            if i >= WARM_UP {
                times.push(ns / (f64::from(width) * f64::from(height)));
            }
        }
        bar.inc(u64::from(i >= WARM_UP));
    }
    bar.finish_and_clear();
    Ok(times
        .iter()
        .filter_map(|t| Statistics::of(t))
        .map(|s| Cost {
            median_ns: s.median,
            p95_ns: s.p95,
        })
        .collect())
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
