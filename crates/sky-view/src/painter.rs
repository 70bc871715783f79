//! Draws a frame: the terrain into color and depth, the sky, the air before the terrain, the panel.

use std::ops::Range;
use std::time::{Duration, Instant};

use anyhow::Result;
use bytemuck::{Pod, Zeroable};
use egui_wgpu::{Renderer, RendererOptions, ScreenDescriptor};
use glam::{Mat4, Vec3};
use sky_core::picture::Picture;
use sky_core::quantity::single;
use sky_core::utm_sky::UtmSky;
use sky_gpu::headless::Headless;
use sky_gpu::screen::Screen;
use sky_gpu::{
    Camera, FrameError, FrameSettings, Output, SkyRenderer, SkyRendererOptions, Tier, auto_ev100,
};
use wgpu::util::DeviceExt as _;

use crate::mesh::{CELLS, CORNERS, Corner, LEVELS, Mesh, triangles};

/// Distance between the uniforms of two squares: WebGPU's largest alignment.
const STRIDE: u64 = 256;
/// Bytes of the corners of a square.
const SQUARE_BYTES: u64 = (size_of::<Corner>() * CORNERS * CORNERS) as u64;
const COLOR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// `SceneUniform` of `ground.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct SceneUniform {
    clip_from_world: Mat4,
    sun: [f32; 4],
    sun_light: [f32; 4],
    sky_light: [f32; 4],
}

/// Where the terrain is drawn to.
#[derive(Debug)]
struct Targets {
    size: [u32; 2],
    color: wgpu::TextureView,
    depth: wgpu::TextureView,
    bound: wgpu::BindGroup,
}

/// The terrain on the GPU.
#[derive(Debug)]
struct Ground {
    mesh: Mesh,
    pipeline: wgpu::RenderPipeline,
    scene: wgpu::Buffer,
    squares: wgpu::Buffer,
    group: wgpu::BindGroup,
    corners: wgpu::Buffer,
    indices: wgpu::Buffer,
    /// Indices without a hole, and with one at each of four places.
    whole: Range<u32>,
    holes: [[Range<u32>; 2]; 2],
    targets: Option<Targets>,
}

/// What a frame of the terrain depends on.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// East and north of the start \[km\].
    pub place_km: [f64; 2],
    /// The camera's altitude and its height above the ground \[km\].
    pub altitude_km: f64,
    /// The same above the ground.
    pub above_ground_km: f64,
    /// From the world in meters, the camera at its origin, to clip space.
    pub clip_from_world: Mat4,
    /// Toward the sun: east, north, up.
    pub sun: Vec3,
}

/// What came of an update.
#[derive(Clone, Copy, Debug)]
pub struct Updated {
    /// The exposure value that the sky asks for.
    pub auto_ev100: f32,
    /// Time for the sky and for the terrain.
    pub times: [Duration; 2],
}

/// What is drawn of it.
#[derive(Clone, Copy, Debug)]
pub struct Layers {
    /// How the sky is drawn.
    pub tier: Tier,
    /// Whether the terrain is.
    pub terrain: bool,
    /// Whether the air before it is.
    pub aerial: bool,
}

/// All that is on a device.
pub struct Painter {
    /// The window's pictures.
    pub screen: Screen,
    /// The sky.
    pub sky: SkyRenderer,
    seen: sky_gpu::View,
    ground: Ground,
    panel: Renderer,
}

impl std::fmt::Debug for Painter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Painter")
            .field("screen", &self.screen)
            .finish_non_exhaustive()
    }
}

/// The panel's triangles and textures.
#[derive(Debug)]
pub struct Overlay {
    /// Triangles.
    pub primitives: Vec<egui::ClippedPrimitive>,
    /// Textures to make and to free.
    pub textures: egui::TexturesDelta,
    /// Pixels of a point.
    pub pixels_per_point: f32,
}

impl Painter {
    /// Makes everything for a window.
    #[must_use]
    pub fn new(screen: Screen, table: &UtmSky) -> Self {
        let device = &screen.gpu.device;
        let options = SkyRendererOptions::new(screen.format(), Output::Display);
        let sky = SkyRenderer::new(device, table, &options);
        Self {
            seen: sky.view(device),
            sky,
            ground: Ground::new(device),
            panel: Renderer::new(device, screen.format(), RendererOptions::default()),
            screen,
        }
    }

    /// Brings the sky, and the terrain where there is one, to a new frame.
    ///
    /// # Errors
    /// When the frame lies outside the table's domain.
    pub fn update(
        &mut self,
        frame: &FrameSettings,
        ground: Option<&View>,
    ) -> Result<Updated, FrameError> {
        let queue = &self.screen.gpu.queue;
        let start = Instant::now();
        let picture = self.sky.update(queue, &mut self.seen, frame)?;
        let sky = start.elapsed();
        if let Some(view) = ground {
            self.ground.follow(queue, view, picture);
        }
        Ok(Updated {
            auto_ev100: auto_ev100(picture),
            times: [sky, start.elapsed().saturating_sub(sky)],
        })
    }

    /// Paints stripes in place of the sky until the next update.
    pub fn show_outside_domain(&mut self, frame: &FrameSettings) {
        self.sky
            .show_outside_domain(&self.screen.gpu.queue, &mut self.seen, frame);
    }

    /// Sets the camera; after the update.
    pub fn set_camera(&mut self, camera: &Camera) {
        self.sky
            .set_camera(&self.screen.gpu.queue, &mut self.seen, camera);
    }

    /// Draws sky and terrain to a target of the window's format. The camera has been set.
    pub fn draw(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        target: &wgpu::TextureView,
        size: [u32; 2],
        view: &View,
        layers: Layers,
    ) {
        let queue = &self.screen.gpu.queue;
        self.sky
            .prepare(queue, encoder, &mut self.seen, layers.tier);
        if layers.terrain {
            self.ground
                .draw(&self.screen.gpu, &self.sky, encoder, size, view);
        }
        let mut pass = Headless::pass(encoder, target, None);
        self.sky.draw(&mut pass, &self.seen);
        if let (true, Some(targets)) = (layers.terrain, &self.ground.targets) {
            self.sky
                .composite(&mut pass, &self.seen, &targets.bound, layers.aerial);
        }
    }

    /// Draws the panel over a target.
    pub fn draw_panel(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        target: &wgpu::TextureView,
        overlay: &Overlay,
    ) {
        let Headless { device, queue, .. } = &self.screen.gpu;
        #[expect(
            clippy::iter_over_hash_type,
            reason = "textures do not depend on each other"
        )]
        for (id, changes) in &overlay.textures.set {
            for change in changes {
                self.panel.update_texture(device, queue, *id, change);
            }
        }
        let screen = ScreenDescriptor {
            size_in_pixels: self.screen.size(),
            pixels_per_point: overlay.pixels_per_point,
        };
        let primitives = &overlay.primitives;
        self.panel
            .update_buffers(device, queue, encoder, primitives, &screen);
        let mut pass = encoder
            .begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("panel"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: target,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Load,
                        store: wgpu::StoreOp::Store,
                    },
                })],
                ..wgpu::RenderPassDescriptor::default()
            })
            .forget_lifetime();
        self.panel.render(&mut pass, primitives, &screen);
        drop(pass);
        #[expect(
            clippy::iter_over_hash_type,
            reason = "textures do not depend on each other"
        )]
        for id in &overlay.textures.free {
            self.panel.free_texture(id);
        }
    }
}

impl Ground {
    fn new(device: &wgpu::Device) -> Self {
        let buffer = |label, size, usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage: usage | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        let uniform = wgpu::BufferUsages::UNIFORM;
        let scene = buffer("ground", size_of::<SceneUniform>() as u64, uniform);
        let squares = buffer("ground squares", STRIDE * LEVELS as u64, uniform);
        let corners = buffer(
            "ground corners",
            SQUARE_BYTES * LEVELS as u64,
            wgpu::BufferUsages::VERTEX,
        );
        let mut list: Vec<u16> = Vec::new();
        let mut add = |hole| {
            let first = list.len();
            list.extend(triangles(hole));
            let place = |index: usize| u32::try_from(index).unwrap_or(0);
            place(first)..place(list.len())
        };
        let whole = add(None);
        let quarter = CELLS / 4;
        let holes =
            [0, 1].map(|east| [0, 1].map(|north| add(Some([quarter + east, quarter + north]))));
        let indices = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("ground triangles"),
            contents: bytemuck::cast_slice(&list),
            usage: wgpu::BufferUsages::INDEX,
        });
        let (layout, group) = bound(device, &scene, &squares);
        Self {
            mesh: Mesh::default(),
            pipeline: pipeline(device, &layout),
            scene,
            squares,
            group,
            corners,
            indices,
            whole,
            holes,
            targets: None,
        }
    }

    fn follow(&mut self, queue: &wgpu::Queue, view: &View, picture: &Picture) {
        let Self { mesh, corners, .. } = self;
        mesh.follow(view.place_km, view.above_ground_km, |level, new| {
            let offset = SQUARE_BYTES * level as u64;
            queue.write_buffer(corners, offset, bytemuck::cast_slice(new));
        });
        for square in mesh.squares(view.place_km) {
            let [east, north] = square.middle_km;
            let place = [east, north, square.cell_km, 0.0];
            let offset = STRIDE * square.level as u64;
            queue.write_buffer(&self.squares, offset, bytemuck::cast_slice(&place));
        }
        let with = |[r, g, b]: [f32; 3]| [r, g, b, 0.0];
        let scene = SceneUniform {
            clip_from_world: view.clip_from_world,
            sun: view.sun.extend(single(view.altitude_km)).to_array(),
            sun_light: with(picture.light.sun_normal),
            sky_light: with(picture.light.sky_horizontal),
        };
        queue.write_buffer(&self.scene, 0, bytemuck::bytes_of(&scene));
    }

    fn draw(
        &mut self,
        gpu: &Headless,
        sky: &SkyRenderer,
        encoder: &mut wgpu::CommandEncoder,
        size: [u32; 2],
        view: &View,
    ) {
        if self.targets.as_ref().is_none_or(|t| t.size != size) {
            self.targets = Some(Targets::new(&gpu.device, sky, size));
        }
        let Some(targets) = &self.targets else { return };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("ground"),
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
                depth_ops: Some(wgpu::Operations {
                    // reversed depth: 0 is infinitely far, the sky
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: None,
            }),
            ..wgpu::RenderPassDescriptor::default()
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint16);
        for square in self.mesh.squares(view.place_km) {
            let offset = STRIDE * square.level as u64;
            pass.set_bind_group(0, &self.group, &[u32::try_from(offset).unwrap_or(0)]);
            let first = SQUARE_BYTES * square.level as u64;
            pass.set_vertex_buffer(0, self.corners.slice(first..first + SQUARE_BYTES));
            let indices = square.hole.map_or(&self.whole, |hole| {
                let [east, north] = hole.map(|h| usize::from(h - CELLS / 4));
                &self.holes[east][north]
            });
            pass.draw_indexed(indices.clone(), 0, 0..1);
        }
    }
}

impl Targets {
    fn new(device: &wgpu::Device, sky: &SkyRenderer, size: [u32; 2]) -> Self {
        let texture = |label, format| {
            let [width, height] = size;
            device
                .create_texture(&wgpu::TextureDescriptor {
                    label: Some(label),
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
                })
                .create_view(&wgpu::TextureViewDescriptor::default())
        };
        let color = texture("ground light", COLOR);
        let depth = texture("ground depth", DEPTH);
        Self {
            size,
            bound: sky.scene(device, &color, &depth),
            color,
            depth,
        }
    }
}

/// The terrain's uniforms: one for all, and one a square.
fn bound(
    device: &wgpu::Device,
    scene: &wgpu::Buffer,
    squares: &wgpu::Buffer,
) -> (wgpu::BindGroupLayout, wgpu::BindGroup) {
    let entry = |binding, has_dynamic_offset| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset,
            min_binding_size: None,
        },
        count: None,
    };
    let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("ground"),
        entries: &[entry(0, false), entry(1, true)],
    });
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("ground"),
        layout: &layout,
        entries: &[
            wgpu::BindGroupEntry {
                binding: 0,
                resource: scene.as_entire_binding(),
            },
            wgpu::BindGroupEntry {
                binding: 1,
                resource: wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                    buffer: squares,
                    offset: 0,
                    size: wgpu::BufferSize::new(16),
                }),
            },
        ],
    });
    (layout, group)
}

fn pipeline(device: &wgpu::Device, layout: &wgpu::BindGroupLayout) -> wgpu::RenderPipeline {
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("ground"),
        source: wgpu::ShaderSource::Wgsl(include_str!("ground.wgsl").into()),
    });
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("ground"),
        bind_group_layouts: &[Some(layout)],
        immediate_size: 0,
    });
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("ground"),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("ground_vertex"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &[Some(wgpu::VertexBufferLayout {
                array_stride: size_of::<Corner>() as u64,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &wgpu::vertex_attr_array![0 => Float32x3],
            })],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Greater),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("ground_fragment"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(COLOR.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}
