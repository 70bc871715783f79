//! A published sky on the GPU: its shader on a full-screen triangle.

use anyhow::Result;
use glam::Mat4;
use sky_core::conditions::Conditions;
use sky_gpu::headless::Headless;
use sky_science::shader_sky::{
    SHADER_HEADER, SHADER_UNIFORMS, ShaderFrame, ShaderSky, ShaderTexture,
};

use crate::pixels::bytes_of;
use crate::stage::Draw;

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
    let ShaderFrame {
        mut uniforms,
        texture,
    } = sky.shader_frame(conditions)?;
    uniforms.resize(SHADER_UNIFORMS, [0.0; 4]);
    let uniforms = uniform_buffer(gpu, uniforms.as_flattened());
    let matrix = uniform_buffer(gpu, &clip_to_local.to_cols_array());
    let texture = upload(
        gpu,
        texture.unwrap_or_else(|| ShaderTexture {
            width: 1,
            height: 1,
            texels: vec![[0.0; 4]],
        }),
    );
    let layouts = layouts(device);
    let model_group = model_group(device, &layouts[0], &uniforms, &texture);
    let stage_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("stage"),
        layout: &layouts[1],
        entries: &[wgpu::BindGroupEntry {
            binding: 0,
            resource: matrix.as_entire_binding(),
        }],
    });
    let pipeline = pipeline(device, sky, &layouts, format);
    Ok(Box::new(move |pass| {
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &model_group, &[]);
        pass.set_bind_group(1, &stage_group, &[]);
        pass.draw(0..3, 0..1);
    }))
}

fn uniform_buffer(gpu: &Headless, numbers: &[f32]) -> wgpu::Buffer {
    let bytes = bytes_of(numbers);
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("published sky"),
        size: bytes.len() as u64,
        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    gpu.queue.write_buffer(&buffer, 0, &bytes);
    buffer
}

/// The model's texture in half precision, as every GPU filters it.
fn upload(gpu: &Headless, texture: ShaderTexture) -> wgpu::Texture {
    let target = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("published sky"),
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
    target
}

/// Groups 0 and 1: the model's, as the shaders' header has it, and the stage's.
fn layouts(device: &wgpu::Device) -> [wgpu::BindGroupLayout; 2] {
    let entry = |binding, visibility, ty| wgpu::BindGroupLayoutEntry {
        binding,
        visibility,
        ty,
        count: None,
    };
    let uniform = entry(
        0,
        wgpu::ShaderStages::VERTEX_FRAGMENT,
        wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: None,
        },
    );
    let texture = entry(
        1,
        wgpu::ShaderStages::FRAGMENT,
        wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: true },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        },
    );
    let sampler = entry(
        2,
        wgpu::ShaderStages::FRAGMENT,
        wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
    );
    let layout = |label, entries: &[wgpu::BindGroupLayoutEntry]| {
        device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some(label),
            entries,
        })
    };
    [
        layout("published sky", &[uniform, texture, sampler]),
        layout("stage", &[uniform]),
    ]
}

fn model_group(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    uniforms: &wgpu::Buffer,
    texture: &wgpu::Texture,
) -> wgpu::BindGroup {
    let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
    let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        ..wgpu::SamplerDescriptor::default()
    });
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("published sky"),
        layout,
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
    })
}

fn pipeline(
    device: &wgpu::Device,
    sky: &dyn ShaderSky,
    layouts: &[wgpu::BindGroupLayout; 2],
    format: wgpu::TextureFormat,
) -> wgpu::RenderPipeline {
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(sky.name()),
        source: wgpu::ShaderSource::Wgsl(format!("{SHADER_HEADER}{}{AROUND}", sky.shader()).into()),
    });
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(sky.name()),
        bind_group_layouts: &layouts.each_ref().map(Some),
        immediate_size: 0,
    });
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
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
    })
}
