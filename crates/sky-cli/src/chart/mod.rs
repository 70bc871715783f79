//! `utm-sky chart`: speed against accuracy of every sky, measured in one run on one machine.
//!
//! Error is taken against the transport engine on a fixed set of cases that no table was fitted to
//! alone; a model is scored only where it claims to be valid, and the share of cases it covers is
//! told. GPU costs are of a fragment shader over a full picture, beside the floor of a constant color.

use std::fmt::Write as _;
use std::time::Instant;

use anyhow::Result;
use glam::Mat4;
use sky_core::direction::SkyDirection;
use sky_core::metrics::{
    SUN_EXCLUSION_DEG, Statistics, ciede2000_of_lights, is_clear_of_sun, white_luminance,
};
use sky_core::picture::Picture;
use sky_core::quantity::{Angle, LUMINOUS_EFFICACY_LM_PER_W};
use sky_core::shader_sky::{SHADER_HEADER, SHADER_UNIFORMS, ShaderSky};
use sky_core::sky_model::{Conditions, SkyModel, Yxy};
use sky_core::utm_sky::UtmSky;
use sky_gpu::headless::Headless;
use sky_gpu::{Dome, SkyFrame, Tier};

use crate::args::ChartArgs;
use crate::bench_gpu::{CASES, Cost, Draw, STAGE_PLACE, STAGE_SUN_ZENITH_DEG, Stage, adapter_name};
use crate::evaluate::{conditions, evaluation_directions};
use crate::files::{OutputFile, create_directory};
use crate::generate::progress;
use crate::models::{Model, Source, all, answers, general_truth, named};
use crate::report::chart::{Chart, Note, Scale, Series, Stroke};
use crate::report::page::{Section, page, table};
use crate::truth::TransportSky;

const ALTITUDES_KM: [f64; 7] = [0.0, 1.0, 3.0, 9.0, 16.0, 25.0, 30.0];
const TURBIDITIES: [f64; 3] = [1.5, 3.0, 6.0];
const SUNS_DEG: [f64; 5] = [0.0, 40.0, 75.0, 88.0, 92.0];
/// Sizes that GPU costs are taken at.
const SIZES: [[u32; 2]; 2] = [[1920, 1080], [3840, 2160]];
/// Wavelengths under the luminous efficiency function \[nm\]: turns a luminance into a mean spectral
/// radiance.
const EFFICIENCY_WIDTH_NM: f64 = 106.857;

/// A part of the cases, by its name.
type Regime = (&'static str, fn(&Conditions, &SkyDirection) -> bool);

fn from_sun(c: &Conditions, d: &SkyDirection) -> f64 {
    d.scattering_angle(c.sun_zenith).degrees()
}

const REGIMES: [Regime; 7] = [
    ("all", |_, _| true),
    ("horizon-band", |_, d| d.view_zenith.degrees() >= 80.0),
    ("aureole", |c, d| from_sun(c, d) < 25.0),
    ("high-sun", |c, _| c.sun_zenith.degrees() <= 40.0),
    ("low-sun", |c, _| {
        (70.0..90.0).contains(&c.sun_zenith.degrees())
    }),
    ("twilight", |c, _| c.sun_zenith.degrees() > 90.0),
    ("aloft", |c, _| c.observer_altitude.km() >= 9.0),
];

/// Errors of one model in one regime.
#[derive(Clone, Copy, Debug, Default)]
struct Errors {
    valid_share: f64,
    delta_e: [f64; 2],
    luminance_p95: f64,
    rmse: f64,
    /// Luminance p95 after the best single factor for all maps.
    scaled_p95: f64,
    /// Share of lights that are negative or no number.
    failures: f64,
}

/// Costs of one model.
#[derive(Clone, Copy, Debug, Default)]
struct Costs {
    cpu_ns: f64,
    gpu_ns: [Option<f64>; 2],
    ratio: Option<f64>,
    update_us: f64,
    rebuild_ms: f64,
    bytes: usize,
}

struct Row {
    model: Model,
    errors: Vec<Option<Errors>>,
    costs: Costs,
    on_front: Vec<bool>,
}

/// The truth of a case.
struct Case {
    conditions: Conditions,
    directions: Vec<SkyDirection>,
    truth: Vec<Yxy>,
    white: f64,
}

/// Runs the command.
///
/// # Errors
/// When a model is unknown, a table cannot be baked or an output cannot be written.
pub fn run(args: &ChartArgs) -> Result<()> {
    let models = chosen(&args.models)?;
    create_directory(&args.out)?;
    let [csv_file, svg_file, page_file] = ["chart.csv", "chart.svg", "chart.html"]
        .map(|name| OutputFile::create(&args.out.join(name)));
    let (csv_file, svg_file, page_file) = (csv_file?, svg_file?, page_file?);
    let truth = general_truth()?;
    let cases = cases(&truth, args.quick)?;
    let gpu = Headless::new().ok();
    let adapter = gpu.as_ref().map_or_else(|| "none".to_owned(), adapter_name);
    let gpu_costs = match &gpu {
        Some(gpu) => time_on_gpu(gpu, &models, args.quick)?,
        None => vec![[None; 3]; models.len()],
    };
    let bar = progress("models", models.len());
    let mut rows = Vec::new();
    for (model, gpu) in models.into_iter().zip(gpu_costs) {
        let (sky, bytes) = model.sky(&truth)?;
        let errors = measure_errors(&*sky, &cases, &model)?;
        let mut costs = time_on_cpu(&model, &*sky)?;
        costs.bytes = bytes;
        costs.gpu_ns = [gpu[0], gpu[1]];
        costs.ratio = gpu[2];
        rows.push(Row {
            model,
            on_front: vec![false; REGIMES.len()],
            errors,
            costs,
        });
        bar.inc(1);
    }
    bar.finish_and_clear();
    mark_front(&mut rows);
    csv_file.commit(csv(&rows, &adapter)?.as_bytes())?;
    let panels = panels(&rows)?;
    svg_file.commit(sheet(&panels).as_bytes())?;
    page_file.commit(html(&rows, &panels, &adapter).as_bytes())?;
    Ok(())
}

fn chosen(names: &[String]) -> Result<Vec<Model>> {
    if names.is_empty() {
        return Ok(all());
    }
    names.iter().map(|name| named(name)).collect()
}

fn cases(truth: &TransportSky, quick: bool) -> Result<Vec<Case>> {
    let mut all = Vec::new();
    for turbidity in TURBIDITIES {
        for altitude in ALTITUDES_KM {
            for sun in SUNS_DEG {
                all.push(conditions(altitude, turbidity, sun));
            }
        }
    }
    if quick {
        all = all.into_iter().step_by(4).collect();
    }
    let bar = progress("truth", all.len());
    let mut out = Vec::new();
    for conditions in all {
        let mut directions = evaluation_directions(conditions.observer_altitude);
        let exclusion = Angle::from_degrees(SUN_EXCLUSION_DEG);
        directions.retain(|d| is_clear_of_sun(d, conditions.sun_zenith, exclusion));
        let truth = truth.yxy_map(&conditions, &directions)?;
        out.push(Case {
            white: white_luminance(&truth).unwrap_or(f64::NAN),
            conditions,
            directions,
            truth,
        });
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(out)
}

fn measure_errors(
    sky: &dyn SkyModel,
    cases: &[Case],
    model: &Model,
) -> Result<Vec<Option<Errors>>> {
    // conditions, direction, truth, answer, white of the case
    let mut lights = Vec::new();
    let mut asked = [0_u32; REGIMES.len()];
    for case in cases {
        let map = sky.yxy_map(&case.conditions, &case.directions).ok();
        for (i, (direction, truth)) in case.directions.iter().zip(&case.truth).enumerate() {
            for (asked, (_, inside)) in asked.iter_mut().zip(REGIMES) {
                *asked += u32::from(inside(&case.conditions, direction));
            }
            let answered = answers(sky.domain(), &case.conditions, direction);
            if let Some(map) = map.as_ref().filter(|_| answered) {
                lights.push((case, *direction, *truth, map[i]));
            }
        }
    }
    // one factor for all lights, the median of their ratios
    let ratios: Vec<f64> = lights
        .iter()
        .map(|(_, _, t, f)| t.luminance_cd_m2 / f.luminance_cd_m2)
        .filter(|r| r.is_finite() && *r > 0.0)
        .collect();
    let factor = Statistics::of(&ratios).map_or(1.0, |s| s.median);
    let p95 = |values: &[f64]| Statistics::of(values).map_or(f64::NAN, |s| s.p95);
    Ok(REGIMES
        .iter()
        .zip(asked)
        .map(|((_, inside), asked)| {
            let (mut delta_e, mut relative, mut scaled) = (Vec::new(), Vec::new(), Vec::new());
            let (mut squares, mut failures, mut count) = (0.0, 0.0, 0.0);
            for (case, direction, truth, found) in &lights {
                if !inside(&case.conditions, direction) {
                    continue;
                }
                count += 1.0;
                let y = found.luminance_cd_m2;
                if !(y.is_finite() && y >= 0.0 && found.x >= 0.0 && found.y >= 0.0) {
                    failures += 1.0;
                }
                let shown = if model.luminance_only() {
                    Yxy {
                        luminance_cd_m2: y,
                        ..*truth
                    }
                } else {
                    *found
                };
                delta_e.push(ciede2000_of_lights(shown, *truth, case.white));
                relative.push((y / truth.luminance_cd_m2 - 1.0).abs());
                scaled.push((factor * y / truth.luminance_cd_m2 - 1.0).abs());
                let radiance = 1e3 * (y - truth.luminance_cd_m2)
                    / (LUMINOUS_EFFICACY_LM_PER_W * EFFICIENCY_WIDTH_NM);
                squares += radiance * radiance;
            }
            let median = Statistics::of(&delta_e)?.median;
            Some(Errors {
                valid_share: count / f64::from(asked).max(1.0),
                delta_e: [median, p95(&delta_e)],
                luminance_p95: p95(&relative),
                rmse: (squares / f64::max(count, 1.0)).sqrt(),
                scaled_p95: p95(&scaled),
                failures: failures / f64::max(count, 1.0),
            })
        })
        .collect())
}

/// The conditions of the timed frames.
const fn timed() -> Conditions {
    conditions(STAGE_PLACE[0], STAGE_PLACE[1], STAGE_SUN_ZENITH_DEG)
}

/// The shortest of several runs \[s\].
fn shortest(runs: u32, mut work: impl FnMut()) -> f64 {
    (0..runs)
        .map(|_| {
            let start = Instant::now();
            work();
            start.elapsed().as_secs_f64()
        })
        .fold(f64::INFINITY, f64::min)
}

fn time_on_cpu(model: &Model, sky: &dyn SkyModel) -> Result<Costs> {
    let conditions = timed();
    let directions = evaluation_directions(conditions.observer_altitude);
    let map = |directions: &[SkyDirection]| {
        shortest(5, || {
            std::hint::black_box(sky.yxy_map(&conditions, directions)).ok();
        })
    };
    map(&directions); // tables that are made on first use
    // what belongs to the frame is in both, and cancels
    let many: Vec<SkyDirection> = directions
        .iter()
        .cycle()
        .take(20 * directions.len())
        .copied()
        .collect();
    let cheap = map(&directions) < 2e-3;
    let longer = if cheap { &many } else { &directions };
    let counted = f64::from(u32::try_from(longer.len())?) - 1.0;
    let cpu_ns = (map(longer) - map(&directions[..1])).max(0.0) * 1e9 / counted;
    let mut costs = Costs {
        cpu_ns,
        ..Costs::default()
    };
    if let Some(shader) = model.shader_sky() {
        costs.update_us = 1e6
            * shortest(3, || {
                drop(std::hint::black_box(shader.shader_frame(&conditions)));
            });
        costs.rebuild_ms = 1e3
            * shortest(1, || {
                std::hint::black_box(shader.rebuild(conditions.turbidity));
            });
    } else if let Source::Ours | Source::Baked | Source::Dome = model.source {
        let sky = UtmSky::embedded()?;
        costs.update_us = 1e6
            * shortest(200, || {
                drop(std::hint::black_box(Picture::new(&sky, &conditions, 0.2)));
            });
    } else {
        costs.update_us = map(&directions[..1]) * 1e6;
    }
    Ok(costs)
}

/// Nanoseconds a pixel at both sizes and the ratio to the floor, for each model.
fn time_on_gpu(gpu: &Headless, models: &[Model], quick: bool) -> Result<Vec<[Option<f64>; 3]>> {
    let mut out = vec![[None; 3]; models.len()];
    let sizes = if quick { &SIZES[..1] } else { &SIZES[..] };
    let (frames, seconds) = if quick { (5, 2.0) } else { (15, 4.0) };
    let bar = progress("GPU frames", sizes.len() * (frames as usize + 1));
    for (s, size) in sizes.iter().enumerate() {
        let stage = Stage::new(gpu, *size)?;
        let mut draws: Vec<Draw<'_>> = vec![stage.draw(CASES[0])];
        let mut places = Vec::new();
        for (i, model) in models.iter().enumerate() {
            let tier = match model.source {
                Source::Ours => Some(Tier::Fragment),
                Source::Baked => Some(Tier::Baked),
                Source::Dome => Some(Tier::Vertex(Dome::REPORT)),
                Source::Table(_) | Source::Published(_) => None,
            };
            if let Some(case) = CASES
                .iter()
                .find(|c| tier.is_some() && c.tier == tier && !c.composite)
            {
                draws.push(stage.draw(*case));
                places.push(i);
            } else if let Some(shader) = model.shader_sky() {
                let axes = SkyFrame {
                    sun: crate::render::world_direction(
                        Angle::ZERO,
                        Angle::from_degrees(90.0 - STAGE_SUN_ZENITH_DEG),
                    ),
                    ..SkyFrame::default()
                }
                .local_axes();
                let clip_to_local = Stage::camera(*size).clip_to_local(axes);
                let format = wgpu::TextureFormat::Rgba16Float;
                draws.push(published(gpu, &*shader, &timed(), clip_to_local, format)?);
                places.push(i);
            }
        }
        let costs: Vec<Cost> = stage.interleaved(gpu, &draws, frames, seconds, &|| bar.inc(1))?;
        for (place, cost) in places.iter().zip(&costs[1..]) {
            out[*place][s] = Some(cost.median_ns);
            if s == 0 {
                out[*place][2] = Some(cost.median_ns / costs[0].median_ns);
            }
        }
    }
    bar.finish_and_clear();
    Ok(out)
}

/// Brings the light of a sky by day into the range of 16-bit floats: what [`published`] draws is
/// linear sRGB \[cd·m⁻²\] times this.
pub const PUBLISHED_SCALE: f32 = 5e-5;

/// The same full-screen triangle around a published sky's shader; the factor is [`PUBLISHED_SCALE`].
const AROUND: &str = "
struct Stage { clip_to_local: mat4x4<f32> }
@group(1) @binding(0) var<uniform> stage: Stage;
struct Vertex { @builtin(position) position: vec4<f32>, @location(0) ray: vec3<f32> }
@vertex
fn stage_vertex(@builtin(vertex_index) index: u32) -> Vertex {
    let clip = vec2<f32>(f32((index << 1u) & 2u) * 2.0 - 1.0, f32(index & 2u) * 2.0 - 1.0);
    let ray = stage.clip_to_local * vec4<f32>(clip, 1.0, 1.0);
    return Vertex(vec4<f32>(clip, 0.0, 1.0), ray.xyz / ray.w);
}
@fragment
fn stage_fragment(in: Vertex) -> @location(0) vec4<f32> {
    let xyz = baseline_xyz(normalize(in.ray));
    let rgb = vec3<f32>(
        dot(vec3<f32>(3.24096994, -1.53738318, -0.49861076), xyz),
        dot(vec3<f32>(-0.96924364, 1.87596750, 0.04155506), xyz),
        dot(vec3<f32>(0.05563008, -0.20397696, 1.05697151), xyz),
    );
    return vec4<f32>(rgb * 5e-5, 1.0);
}
";

/// What draws a published sky over a whole target. `clip_to_local` takes clip space to the shader's
/// frame of reference.
///
/// # Errors
/// When the conditions lie outside the model's domain.
pub fn published(
    gpu: &Headless,
    sky: &dyn ShaderSky,
    conditions: &Conditions,
    clip_to_local: Mat4,
    format: wgpu::TextureFormat,
) -> Result<Draw<'static>> {
    let device = &gpu.device;
    let frame = sky.shader_frame(conditions)?;
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(sky.name()),
        source: wgpu::ShaderSource::Wgsl(format!("{SHADER_HEADER}{}{AROUND}", sky.shader()).into()),
    });
    let buffer = |bytes: &[u8]| {
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(sky.name()),
            size: bytes.len() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        gpu.queue.write_buffer(&buffer, 0, bytes);
        buffer
    };
    let floats = |values: &mut dyn Iterator<Item = f32>| -> Vec<u8> {
        values.flat_map(f32::to_le_bytes).collect()
    };
    let mut uniforms = frame.uniforms.clone();
    uniforms.resize(SHADER_UNIFORMS, [0.0; 4]);
    let uniforms = buffer(&floats(&mut uniforms.into_iter().flatten()));
    let matrix = clip_to_local.to_cols_array();
    let matrix = buffer(&floats(&mut matrix.into_iter()));
    let texture = frame
        .texture
        .unwrap_or_else(|| sky_core::shader_sky::ShaderTexture {
            width: 1,
            height: 1,
            texels: vec![[0.0; 4]],
        });
    let target = device.create_texture(&wgpu::TextureDescriptor {
        label: Some(sky.name()),
        size: wgpu::Extent3d {
            width: texture.width,
            height: texture.height,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba16Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let halves: Vec<u8> = texture
        .texels
        .iter()
        .flatten()
        .flat_map(|v| half::f16::from_f32(*v).to_le_bytes())
        .collect();
    gpu.queue.write_texture(
        target.as_image_copy(),
        &halves,
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(8 * texture.width),
            rows_per_image: None,
        },
        target.size(),
    );
    let uniform = |binding| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    };
    let model_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some(sky.name()),
        entries: &[
            uniform(0),
            wgpu::BindGroupLayoutEntry {
                binding: 1,
                visibility: wgpu::ShaderStages::FRAGMENT,
                ty: wgpu::BindingType::Texture {
                    sample_type: wgpu::TextureSampleType::Float { filterable: true },
                    view_dimension: wgpu::TextureViewDimension::D2,
                    multisampled: false,
                },
                count: None,
            },
            wgpu::BindGroupLayoutEntry {
                binding: 2,
                visibility: wgpu::ShaderStages::FRAGMENT,
                ty: wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
                count: None,
            },
        ],
    });
    let stage_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("stage"),
        entries: &[uniform(0)],
    });
    let view = target.create_view(&wgpu::TextureViewDescriptor::default());
    let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        ..wgpu::SamplerDescriptor::default()
    });
    let model_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some(sky.name()),
        layout: &model_layout,
        entries: &[
            wgpu::BindGroupEntry {
                binding: 0,
                resource: uniforms.as_entire_binding(),
            },
            wgpu::BindGroupEntry {
                binding: 1,
                resource: wgpu::BindingResource::TextureView(&view),
            },
            wgpu::BindGroupEntry {
                binding: 2,
                resource: wgpu::BindingResource::Sampler(&sampler),
            },
        ],
    });
    let stage_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("stage"),
        layout: &stage_layout,
        entries: &[wgpu::BindGroupEntry {
            binding: 0,
            resource: matrix.as_entire_binding(),
        }],
    });
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(sky.name()),
        bind_group_layouts: &[Some(&model_layout), Some(&stage_layout)],
        immediate_size: 0,
    });
    let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(sky.name()),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("stage_vertex"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: None,
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("stage_fragment"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(format.into())],
        }),
        multiview_mask: None,
        cache: None,
    });
    Ok(Box::new(move |pass| {
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &model_group, &[]);
        pass.set_bind_group(1, &stage_group, &[]);
        pass.draw(0..3, 0..1);
    }))
}

/// A model is on the front of a regime where none is both cheaper on the GPU and closer to the truth.
fn mark_front(rows: &mut [Row]) {
    for r in 0..REGIMES.len() {
        let places: Vec<Option<[f64; 2]>> = rows.iter().map(|row| place(row, r)).collect();
        for (i, row) in rows.iter_mut().enumerate() {
            row.on_front[r] = places[i].is_some_and(|[cost, error]| {
                !places
                    .iter()
                    .flatten()
                    .any(|[c, e]| *c <= cost && *e <= error && (*c < cost || *e < error))
            });
        }
    }
}

/// Cost \[ns a pixel\] and error (ΔE p95) of a row in a regime, where it has both.
fn place(row: &Row, regime: usize) -> Option<[f64; 2]> {
    let error = row.errors[regime]?.delta_e[1];
    error.is_finite().then_some(())?;
    Some([row.costs.gpu_ns[0]?, error])
}

fn csv(rows: &[Row], adapter: &str) -> Result<String> {
    let mut out = String::from(
        "model,tier,regime,valid_share,delta_e_p50,delta_e_p95,luminance_p95,\
         radiance_rmse_mw_m2_sr_nm,cpu_ns_per_direction,gpu_ns_per_pixel_1080p,\
         gpu_ns_per_pixel_2160p,ratio_to_floor,update_us,rebuild_ms,table_bytes,on_front,adapter\n",
    );
    let number = |v: Option<f64>| {
        v.filter(|v| v.is_finite())
            .map_or_else(String::new, |v| format!("{v:.4}"))
    };
    for row in rows {
        for (r, (regime, _)) in REGIMES.iter().enumerate() {
            let e = row.errors[r];
            let c = &row.costs;
            writeln!(
                out,
                "{},{},{regime},{:.4},{},{},{},{},{:.1},{},{},{},{:.2},{:.3},{},{},\"{adapter}\"",
                row.model.name,
                row.model.tier,
                e.map_or(0.0, |e| e.valid_share),
                number(e.map(|e| e.delta_e[0])),
                number(e.map(|e| e.delta_e[1])),
                number(e.map(|e| e.luminance_p95)),
                number(e.map(|e| e.rmse)),
                c.cpu_ns,
                number(c.gpu_ns[0]),
                number(c.gpu_ns[1]),
                number(c.ratio),
                c.update_us,
                c.rebuild_ms,
                c.bytes,
                row.on_front[r],
            )?;
        }
    }
    Ok(out)
}

/// One chart a regime: error over GPU cost, both logarithmic, with the front as a line.
fn panels(rows: &[Row]) -> Result<Vec<String>> {
    REGIMES
        .iter()
        .enumerate()
        .map(|(r, (regime, _))| {
            let all: Vec<(&Row, [f64; 2])> = rows
                .iter()
                .filter_map(|row| Some((row, place(row, r)?)))
                .collect();
            let mut front: Vec<[f64; 2]> = all
                .iter()
                .filter(|(row, _)| row.on_front[r])
                .map(|(_, p)| *p)
                .collect();
            front.sort_by(|a, b| a[0].total_cmp(&b[0]));
            let dots = |ours: bool| -> Vec<[f64; 2]> {
                all.iter()
                    .filter(|(row, _)| row.model.name.starts_with("utm-sky") == ours)
                    .map(|(_, p)| *p)
                    .collect()
            };
            let notes = all
                .iter()
                .map(|(row, at)| {
                    let e = row.errors[r].unwrap_or_default();
                    let mut text = format!(" {}", row.model.name);
                    if e.valid_share < 0.995 {
                        write!(text, " ({:.0} % covered)", 100.0 * e.valid_share).ok();
                    }
                    if e.failures > 0.0 {
                        write!(text, " fails {:.1} %", 100.0 * e.failures).ok();
                    }
                    Note { text, at: *at }
                })
                .collect();
            Chart {
                title: format!("{regime}: error over cost"),
                x: Scale::logarithmic(
                    "GPU [ns a pixel, 1920 x 1080]",
                    all.iter().map(|(_, p)| p[0]),
                    6.0,
                ),
                y: Scale::logarithmic(
                    "ΔE2000, 95th percentile",
                    all.iter().map(|(_, p)| p[1]),
                    4.0,
                ),
                series: vec![
                    Series::new("front", 2, front).stroked(Stroke::Dashed),
                    Series::new("published", 1, dots(false)).stroked(Stroke::Dots),
                    Series::new("ours", 0, dots(true)).stroked(Stroke::Dots),
                ],
                notes,
                size: [560, 360],
            }
            .html()
        })
        .collect()
}

/// The panels' drawings as one SVG file.
fn sheet(panels: &[String]) -> String {
    let mut out = String::new();
    let (mut column, mut row) = (0, 0);
    for (panel, (regime, _)) in panels.iter().zip(REGIMES) {
        let drawing = panel
            .find("<svg")
            .and_then(|start| Some(&panel[start..panel.find("</svg>")? + 6]))
            .unwrap_or_default();
        let placed = drawing.replacen(
            "<svg",
            &format!(
                "<svg x=\"{}\" y=\"{}\" width=\"560\" height=\"360\"",
                column * 570,
                row * 370
            ),
            1,
        );
        out.push_str(&placed);
        out.push_str(&format!(
            "<text x=\"{}\" y=\"{}\" font-family=\"sans-serif\" font-size=\"15\">{regime}</text>",
            column * 570 + 300,
            row * 370 + 18
        ));
        column += 1;
        if column == 2 {
            (column, row) = (0, row + 1);
        }
    }
    let height = (row + column) * 370;
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"1140\" height=\"{height}\" \
         viewBox=\"0 0 1140 {height}\" color=\"#222\"><rect width=\"100%\" height=\"100%\" fill=\"white\"/>{out}</svg>\n"
    )
}

fn html(rows: &[Row], panels: &[String], adapter: &str) -> String {
    let head = [
        "model",
        "covers",
        "ΔE p50",
        "ΔE p95",
        "luminance p95",
        "after one factor",
        "RMSE [mW/m²/sr/nm]",
        "CPU [ns]",
        "GPU 1080p [ns/px]",
        "GPU 2160p",
        "x floor",
        "update [µs]",
        "rebuild [ms]",
        "tables [B]",
        "fails",
        "front",
    ];
    let number = |v: Option<f64>, digits: usize| {
        v.map_or_else(|| "–".to_owned(), |v| format!("{v:.digits$}"))
    };
    let mut body = String::new();
    for (r, (regime, _)) in REGIMES.iter().enumerate() {
        let cells: Vec<Vec<String>> = rows
            .iter()
            .map(|row| {
                let e = row.errors[r];
                let c = &row.costs;
                vec![
                    row.model.name.to_owned(),
                    format!("{:.0} %", 100.0 * e.map_or(0.0, |e| e.valid_share)),
                    number(e.map(|e| e.delta_e[0]), 2),
                    number(e.map(|e| e.delta_e[1]), 2),
                    number(e.map(|e| 100.0 * e.luminance_p95), 1) + " %",
                    number(e.map(|e| 100.0 * e.scaled_p95), 1) + " %",
                    number(e.map(|e| e.rmse), 1),
                    number(Some(c.cpu_ns), 0),
                    number(c.gpu_ns[0], 2),
                    number(c.gpu_ns[1], 2),
                    number(c.ratio, 2),
                    number(Some(c.update_us), 1),
                    number(Some(c.rebuild_ms), 1),
                    c.bytes.to_string(),
                    format!("{:.2} %", 100.0 * e.map_or(0.0, |e| e.failures)),
                    if row.on_front[r] { "yes" } else { "" }.to_owned(),
                ]
            })
            .collect();
        body.push_str(&format!(
            "<h3>{regime}</h3>{}{}",
            panels[r],
            table(&head, &cells, 1)
        ));
    }
    let notes: String = rows
        .iter()
        .map(|row| {
            let own = if row.model.own_atmosphere() {
                " Own atmosphere, matched at equal aerosol optical depth."
            } else {
                ""
            };
            let luminance = if row.model.luminance_only() {
                " Luminance alone: scored with the truth's chromaticity."
            } else {
                ""
            };
            format!(
                "<p><b>{}</b>: {}.{own}{luminance}</p>",
                row.model.name, row.model.citation
            )
        })
        .collect();
    page(
        "Speed against accuracy",
        &format!(
            "Error against the transport engine at 0–30 km, T 1.5–6, sun 0–92°, all directions above the \
             geometric horizon but the sun's 5°; cost of a full picture on {adapter}. A model is scored where \
             it claims to be valid."
        ),
        &[
            Section {
                id: "regimes",
                title: "Regimes",
                body,
            },
            Section {
                id: "models",
                title: "Models",
                body: notes,
            },
        ],
    )
}
