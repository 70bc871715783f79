//! What the shaders bind, group by group.

use crate::options::SkyRendererOptions;

/// The bind group layouts of a renderer.
#[derive(Debug)]
pub(crate) struct Layouts {
    /// The three uniforms.
    pub(crate) frame: wgpu::BindGroupLayout,
    /// The baked sky and its sampler.
    pub(crate) baked: wgpu::BindGroupLayout,
    /// Color and depth of a scene.
    pub(crate) scene: wgpu::BindGroupLayout,
}

const fn uniform(binding: u32) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    }
}

const fn texture(binding: u32, filterable: bool, multisampled: bool) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty: wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled,
        },
        count: None,
    }
}

/// The layout of [`crate::View::frame_group`]: bindings 0 to 2 are uniforms, for vertex and fragment
/// stages. For pipelines of yours that use [`crate::shader::functions`].
#[must_use]
pub fn frame_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("sky frame"),
        entries: &[uniform(0), uniform(1), uniform(2)],
    })
}

/// The layout of [`crate::View::baked_group`]: the baked sky's texture and a linear sampler.
#[must_use]
pub fn baked_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let sampler = wgpu::BindGroupLayoutEntry {
        binding: 1,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty: wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
        count: None,
    };
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("baked sky"),
        entries: &[texture(0, true, false), sampler],
    })
}

impl Layouts {
    pub(crate) fn new(device: &wgpu::Device, options: &SkyRendererOptions) -> Self {
        let depth = texture(1, false, options.scene_depth_multisampled);
        Self {
            frame: frame_layout(device),
            baked: baked_layout(device),
            scene: device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some("scene"),
                entries: &[texture(0, false, false), depth],
            }),
        }
    }
}
