//! The render pipelines, made once for a device, a target and an output.

use crate::layouts::Layouts;
use crate::options::{Output, SkyRendererOptions};
use crate::shader;

/// Format of a baked sky.
pub(crate) const BAKED_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

/// The pipelines of a renderer. Of two, the first is for cameras with a matrix, the second for
/// panoramas.
#[derive(Debug)]
pub(crate) struct Pipelines {
    pub(crate) fragment: [wgpu::RenderPipeline; 2],
    pub(crate) baked: [wgpu::RenderPipeline; 2],
    pub(crate) dome: wgpu::RenderPipeline,
    /// With and without air.
    pub(crate) composite: [wgpu::RenderPipeline; 2],
    /// Of the ground's rows and of the sky's.
    pub(crate) bake: [wgpu::RenderPipeline; 2],
}

/// What is drawn to.
struct Target {
    format: wgpu::TextureFormat,
    depth_stencil: Option<wgpu::DepthStencilState>,
    sample_count: u32,
}

/// Makes pipelines of one shader.
struct Maker<'a> {
    device: &'a wgpu::Device,
    module: wgpu::ShaderModule,
    layout: wgpu::PipelineLayout,
    target: &'a Target,
}

fn layout(
    device: &wgpu::Device,
    label: &str,
    groups: &[Option<&wgpu::BindGroupLayout>],
) -> wgpu::PipelineLayout {
    device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(label),
        bind_group_layouts: groups,
        immediate_size: 0,
    })
}

impl<'a> Maker<'a> {
    fn new(
        device: &'a wgpu::Device,
        program: shader::Program,
        output: Output,
        groups: &[Option<&wgpu::BindGroupLayout>],
        target: &'a Target,
    ) -> Self {
        Self {
            module: device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(program.name),
                source: wgpu::ShaderSource::Wgsl(shader::text(program, output).into()),
            }),
            layout: layout(device, program.name, groups),
            device,
            target,
        }
    }

    fn pipeline(&self, vertex: &str, fragment: &str) -> wgpu::RenderPipeline {
        self.device
            .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(fragment),
                layout: Some(&self.layout),
                vertex: wgpu::VertexState {
                    module: &self.module,
                    entry_point: Some(vertex),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    buffers: &[],
                },
                primitive: wgpu::PrimitiveState::default(),
                depth_stencil: self.target.depth_stencil.clone(),
                multisample: wgpu::MultisampleState {
                    count: self.target.sample_count,
                    ..wgpu::MultisampleState::default()
                },
                fragment: Some(wgpu::FragmentState {
                    module: &self.module,
                    entry_point: Some(fragment),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    targets: &[Some(self.target.format.into())],
                }),
                multiview_mask: None,
                cache: None,
            })
    }

    /// The same shader with other groups, for another target.
    fn with(&self, groups: &[Option<&wgpu::BindGroupLayout>], target: &'a Target) -> Self {
        Self {
            device: self.device,
            module: self.module.clone(),
            layout: layout(self.device, "bake the sky", groups),
            target,
        }
    }

    /// Over the whole viewport.
    fn screen(&self, fragment: &str) -> wgpu::RenderPipeline {
        self.pipeline("screen_vertex", fragment)
    }
}

impl Pipelines {
    pub(crate) fn new(
        device: &wgpu::Device,
        layouts: &Layouts,
        options: &SkyRendererOptions,
    ) -> Self {
        let target = |depth_stencil| Target {
            format: options.target_format,
            depth_stencil,
            sample_count: options.sample_count,
        };
        // a scene's own depth decides what is laid over what
        let over = target(
            options
                .depth_stencil
                .clone()
                .map(|state| wgpu::DepthStencilState {
                    depth_write_enabled: Some(false),
                    depth_compare: Some(wgpu::CompareFunction::Always),
                    ..state
                }),
        );
        let target = target(options.depth_stencil.clone());
        let half = Target {
            format: BAKED_FORMAT,
            depth_stencil: None,
            sample_count: 1,
        };
        let frame = Some(&layouts.frame);
        let (with_baked, with_scene) =
            ([frame, Some(&layouts.baked)], [frame, Some(&layouts.scene)]);
        let output = options.output;
        let make =
            |program, groups: &[_], target| Maker::new(device, program, output, groups, target);
        let sky = make(shader::SKY_PROGRAM, &with_baked, &target);
        let bake = sky.with(&[frame], &half);
        let dome = make(shader::DOME_PROGRAM, &[frame], &target);
        let program = if options.scene_depth_multisampled {
            shader::MULTISAMPLED_PROGRAM
        } else {
            shader::COMPOSITE_PROGRAM
        };
        let composite = make(program, &with_scene, &over);
        Self {
            fragment: ["sky_fragment", "sky_panorama"].map(|f| sky.screen(f)),
            baked: ["baked_fragment", "baked_panorama"].map(|f| sky.screen(f)),
            dome: dome.pipeline("dome_vertex", "dome_fragment"),
            composite: ["composite_fragment", "scene_fragment"].map(|f| composite.screen(f)),
            bake: ["bake_ground", "bake_sky"].map(|f| bake.screen(f)),
        }
    }
}
