//! The renderer: pipelines, uniforms, and the three ways to draw a sky.

use glam::Vec3;
use sky_core::conditions::{Conditions, OutsideDomain};
use sky_core::haze::{Haze, HazeError};
use sky_core::lut::{Lut, LutHeader};
use sky_core::picture::Picture;
use sky_core::quantity::{Angle, Length};
use sky_core::tonemap::{Tone, ev100_from_luminance, exposure_from_ev100, luminance};
use sky_core::utm_sky::{TableError, UtmSky};
use thiserror::Error;

use crate::camera::{Camera, Dome};
use crate::shader;
use crate::uniforms::{AerialUniform, DisplaySettings, SkyUniform, ViewUniform};

/// Cameras that a frame can have.
pub const MOST_VIEWS: u32 = 8;
/// Distance between the uniforms of two cameras: WebGPU's largest alignment.
const VIEW_STRIDE: u64 = 256;
/// Texels of the baked sky, as in `baked.wgsl`.
const BAKED_SIZE: [u32; 2] = [160, 192];
/// Rows of the ground, as in `baked.wgsl`.
const BAKED_GROUND: u32 = 40;
/// Luminance that the baked sky's mean is scaled to: far from both ends of a half float.
const BAKED_MEAN: f32 = 16.0;
/// Steps of altitude \[km\], logarithm of turbidity and sun zenith \[rad\] that a baked sky may lag
/// behind: a tenth of what changes a light by a percent where it changes fastest.
const VISIBLE_STEP: [f64; 3] = [0.002, 0.002, 0.000_2];

/// How the sky is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tier {
    /// A dome colored at its corners: the report's way.
    Vertex(Dome),
    /// The formula at every pixel.
    Fragment,
    /// A small texture, made anew when the sky has changed; one fetch a pixel. The same picture for
    /// half the cost.
    #[default]
    Baked,
}

impl Tier {
    /// The tier that the plan chose from which a table was baked, where it was.
    #[must_use]
    pub fn planned(header: &LutHeader) -> Option<Self> {
        match header.planned("tier")? {
            "vertex" => Some(Self::Vertex(Dome::REPORT)),
            "fragment" => Some(Self::Fragment),
            "baked" => Some(Self::Baked),
            _ => None,
        }
    }
}

/// How light is scaled for the target.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Exposure {
    /// By an exposure value at ISO 100.
    Ev100(f32),
    /// From the mean of the sky.
    #[default]
    Auto,
    /// None: light in cd·m⁻² as it is.
    None,
}

/// What a frame's sky depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkyFrame {
    /// The observer's altitude above mean sea level.
    pub observer_altitude: Length,
    /// The haze, as turbidity, optical depth, visual range or by Ångström's law.
    pub haze: Haze,
    /// The world's direction toward the sun's center; any length.
    pub sun: Vec3,
    /// The world's direction up at the observer; any length.
    pub up: Vec3,
    /// Albedo of the ground.
    pub ground_albedo: f32,
    /// Whether the sun's disc is drawn; the scene's light does not change.
    pub sun_disc: bool,
    /// The exposure.
    pub exposure: Exposure,
    /// The tone curve of an 8-bit target; float targets take linear light.
    pub tone: Option<Tone>,
}

impl Default for SkyFrame {
    fn default() -> Self {
        Self {
            observer_altitude: Length::from_m(2.0),
            haze: Haze::Turbidity(2.5),
            sun: Vec3::new(0.0, 0.707, 0.707),
            up: Vec3::Z,
            ground_albedo: 0.2,
            sun_disc: true,
            exposure: Exposure::Auto,
            tone: Some(Tone::Neutral),
        }
    }
}

/// A frame that has no sky.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum FrameError {
    /// A haze that cannot be.
    #[error("haze: {0}")]
    Haze(#[from] HazeError),
    /// Conditions outside the table's domain.
    #[error(transparent)]
    Sky(#[from] OutsideDomain),
}

impl SkyFrame {
    /// The conditions for the table.
    ///
    /// # Errors
    /// When the haze cannot be: a turbidity below 1, a visual range beyond clean air's.
    pub fn conditions(&self) -> Result<Conditions, HazeError> {
        let (sun, up) = (self.sun.normalize_or_zero(), self.up.normalize_or_zero());
        let zenith = sun.cross(up).length().atan2(sun.dot(up));
        Ok(Conditions {
            observer_altitude: self.observer_altitude,
            turbidity: self.haze.turbidity()?,
            sun_zenith: Angle::from_radians(zenith.into()),
        })
    }

    /// The local frame in the world: toward the sun's azimuth, left of it, up.
    #[must_use]
    pub fn local_axes(&self) -> [Vec3; 3] {
        let up = self.up.normalize_or(Vec3::Z);
        let flat = self.sun - up * self.sun.dot(up);
        let x = flat
            .try_normalize()
            .unwrap_or_else(|| up.any_orthonormal_vector());
        [x, up.cross(x), up]
    }
}

/// Where render-pass timestamps are written.
#[derive(Clone, Copy, Debug)]
pub struct Timing<'a> {
    /// The queries.
    pub queries: &'a wgpu::QuerySet,
    /// Place of the first of two.
    pub first: u32,
}

#[derive(Debug)]
struct Pipelines {
    fragment: [wgpu::RenderPipeline; 2],
    baked: [wgpu::RenderPipeline; 2],
    dome: wgpu::RenderPipeline,
    /// With and without air.
    composite: [wgpu::RenderPipeline; 2],
    floor: wgpu::RenderPipeline,
    /// Of the ground's rows and of the sky's.
    bake: [wgpu::RenderPipeline; 2],
}

/// Draws the sky of a table.
#[derive(Debug)]
pub struct SkyRenderer {
    sky: UtmSky,
    pipelines: Pipelines,
    target_encodes: bool,
    dither: f32,
    sky_uniform: wgpu::Buffer,
    aerial_uniform: wgpu::Buffer,
    views: wgpu::Buffer,
    frame_group: wgpu::BindGroup,
    view_group: wgpu::BindGroup,
    baked_group: wgpu::BindGroup,
    baked_view: wgpu::TextureView,
    scene_layout: wgpu::BindGroupLayout,
    panoramas: [bool; MOST_VIEWS as usize],
    dome: Dome,
    picture: Option<Picture>,
    baked_for: Option<Baked>,
    /// Whether the ground's rows and the sky's have fallen behind.
    must_bake: [bool; 2],
    local: [Vec3; 3],
}

/// What a baked sky was made for.
#[derive(Clone, Copy, Debug)]
struct Baked {
    place: [f64; 3],
    ground: [f32; 3],
    scale: f32,
    outside: bool,
}

impl SkyRenderer {
    /// A renderer for a table and the format of the targets.
    ///
    /// # Errors
    /// When the table lacks what the runtime needs.
    pub fn new(
        device: &wgpu::Device,
        lut: &Lut,
        target_format: wgpu::TextureFormat,
    ) -> Result<Self, TableError> {
        let sky = UtmSky::new(lut.clone())?;
        let layouts = Layouts::new(device);
        let pipelines = Pipelines::new(device, &layouts, target_format);
        let buffer = |label, size| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        let sky_uniform = buffer("sky", size_of::<SkyUniform>() as u64);
        let aerial_uniform = buffer("aerial", size_of::<AerialUniform>() as u64);
        let views = buffer("sky views", VIEW_STRIDE * u64::from(MOST_VIEWS));
        let frame_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("sky frame"),
            layout: &layouts.frame,
            entries: &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: sky_uniform.as_entire_binding(),
                },
                wgpu::BindGroupEntry {
                    binding: 1,
                    resource: aerial_uniform.as_entire_binding(),
                },
            ],
        });
        let view_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("sky view"),
            layout: &layouts.view,
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                    buffer: &views,
                    offset: 0,
                    size: wgpu::BufferSize::new(size_of::<ViewUniform>() as u64),
                }),
            }],
        });
        let (baked_view, baked_group) = baked_texture(device, &layouts.baked);
        Ok(Self {
            sky,
            pipelines,
            target_encodes: target_format.is_srgb(),
            dither: if is_float(target_format) {
                0.0
            } else {
                1.0 / 255.0
            },
            sky_uniform,
            aerial_uniform,
            views,
            frame_group,
            view_group,
            baked_group,
            baked_view,
            scene_layout: layouts.scene,
            panoramas: [false; MOST_VIEWS as usize],
            dome: Dome::REPORT,
            picture: None,
            baked_for: None,
            must_bake: [false; 2],
            local: [Vec3::X, Vec3::Y, Vec3::Z],
        })
    }

    /// Computes the frame and uploads it: some microseconds, no allocation of ours.
    ///
    /// # Errors
    /// When the haze cannot be or the conditions lie outside the table's domain. The sky of the last frame stays; with
    /// [`Self::show_outside_domain`] it can be painted as such.
    pub fn update(
        &mut self,
        queue: &wgpu::Queue,
        frame: &SkyFrame,
    ) -> Result<&Picture, FrameError> {
        let conditions = frame.conditions()?;
        let mut picture = Picture::new(&self.sky, &conditions, frame.ground_albedo)?;
        if !frame.sun_disc {
            (picture.sun.upper, picture.sun.lower) = ([0.0; 3], [0.0; 3]);
        }
        self.local = frame.local_axes();
        let display = self.display(frame, &picture);
        let place = [
            conditions.observer_altitude.km(),
            conditions.turbidity.ln(),
            conditions.sun_zenith.radians(),
        ];
        let stays = self.baked_for.filter(|baked| {
            !baked.outside
                && near(baked.ground, picture.light.ground)
                && (0..3).all(|i| (baked.place[i] - place[i]).abs() <= VISIBLE_STEP[i])
        });
        let scale = stays.map_or_else(
            || BAKED_MEAN / luminance(mean(&picture)).max(1e-6),
            |baked| baked.scale,
        );
        if stays.is_none() {
            self.must_bake = [true; 2];
            self.baked_for = Some(Baked {
                place,
                ground: picture.light.ground,
                scale,
                outside: false,
            });
        }
        let uniform = SkyUniform::new(&picture, self.local, display, scale, false);
        queue.write_buffer(&self.sky_uniform, 0, bytemuck::bytes_of(&uniform));
        let aerial = AerialUniform::new(&picture.air);
        queue.write_buffer(&self.aerial_uniform, 0, bytemuck::bytes_of(&aerial));
        Ok(self.picture.insert(picture))
    }

    /// Paints stripes in place of the sky until the next [`Self::update`] that succeeds: what lies
    /// outside the domain is never a silent wrong sky. Nothing before the first update.
    pub fn show_outside_domain(&mut self, queue: &wgpu::Queue, frame: &SkyFrame) {
        if let Some(picture) = &self.picture {
            let display = self.display(frame, picture);
            let uniform = SkyUniform::new(picture, self.local, display, 1.0, true);
            queue.write_buffer(&self.sky_uniform, 0, bytemuck::bytes_of(&uniform));
            self.must_bake = [true; 2];
            if let Some(baked) = &mut self.baked_for {
                baked.outside = true;
            }
        }
    }

    fn display(&self, frame: &SkyFrame, picture: &Picture) -> DisplaySettings {
        DisplaySettings {
            exposure: match frame.exposure {
                Exposure::None => 1.0,
                Exposure::Ev100(ev100) => exposure_from_ev100(ev100),
                Exposure::Auto => exposure_from_ev100(auto_ev100(picture)),
            },
            tone: frame.tone.unwrap_or_default().index(),
            dither: self.dither,
            target_encodes: self.target_encodes,
        }
    }

    /// Sets one of up to eight cameras.
    ///
    /// # Panics
    /// When the place is not below [`MOST_VIEWS`].
    pub fn set_camera(&mut self, queue: &wgpu::Queue, view: u32, camera: &Camera) {
        assert!(
            view < MOST_VIEWS,
            "view {view}: expected one below {MOST_VIEWS}"
        );
        let uniform = camera.uniform(self.local, self.dome);
        let offset = u64::from(view) * VIEW_STRIDE;
        queue.write_buffer(&self.views, offset, bytemuck::bytes_of(&uniform));
        self.panoramas[view as usize] = camera.is_panorama();
    }

    /// The mesh of the tier `vertex`; call before [`Self::set_camera`].
    pub const fn set_dome(&mut self, dome: Dome) {
        self.dome = dome;
    }

    /// Bakes what the tier takes from the texture, where it has fallen behind: the ground, and for
    /// the tier `baked` the sky. Once a frame, before the pass.
    pub fn prepare(&mut self, encoder: &mut wgpu::CommandEncoder, tier: Tier) {
        let wanted = match tier {
            Tier::Vertex(_) => [false, false],
            Tier::Fragment => [true, false],
            Tier::Baked => [true, true],
        };
        let rows = [
            [0, BAKED_GROUND],
            [BAKED_GROUND, BAKED_SIZE[1] - BAKED_GROUND],
        ];
        if !(0..2).any(|part| wanted[part] && self.must_bake[part]) {
            return;
        }
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("bake the sky"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.baked_view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Load,
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: None,
            timestamp_writes: None,
            occlusion_query_set: None,
            multiview_mask: None,
        });
        for part in 0..2 {
            if wanted[part] && self.must_bake[part] {
                self.must_bake[part] = false;
                pass.set_pipeline(&self.pipelines.bake[part]);
                self.bind(&mut pass, 0);
                pass.set_scissor_rect(0, rows[part][0], BAKED_SIZE[0], rows[part][1]);
                pass.draw(0..3, 0..1);
            }
        }
    }

    fn bind(&self, pass: &mut wgpu::RenderPass<'_>, view: u32) {
        pass.set_bind_group(0, &self.frame_group, &[]);
        let offset = u64::from(view) * VIEW_STRIDE;
        pass.set_bind_group(1, &self.view_group, &[u32::try_from(offset).unwrap_or(0)]);
    }

    /// Draws the sky over the whole viewport, before or after the scene (depth is not tested).
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, view: u32, tier: Tier) {
        let kind = usize::from(self.panoramas[view as usize]);
        let (pipeline, vertices) = match tier {
            Tier::Vertex(dome) => (&self.pipelines.dome, dome.vertices()),
            Tier::Fragment => (&self.pipelines.fragment[kind], 3),
            Tier::Baked => (&self.pipelines.baked[kind], 3),
        };
        pass.set_pipeline(pipeline);
        self.bind(pass, view);
        if !matches!(tier, Tier::Vertex(_)) {
            pass.set_bind_group(2, &self.baked_group, &[]);
        }
        pass.draw(0..vertices, 0..1);
    }

    /// The same triangle with a constant color: the floor that the tiers are measured against.
    pub fn draw_floor(&self, pass: &mut wgpu::RenderPass<'_>, view: u32) {
        pass.set_pipeline(&self.pipelines.floor);
        self.bind(pass, view);
        pass.draw(0..3, 0..1);
    }

    /// Binds a scene's color (linear light in cd·m⁻²) and depth for [`Self::composite`]. The depth may
    /// be the depth texture that the scene was drawn with, or a float texture.
    #[must_use]
    pub fn scene(
        &self,
        device: &wgpu::Device,
        color: &wgpu::TextureView,
        depth: &wgpu::TextureView,
    ) -> wgpu::BindGroup {
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("scene under the sky"),
            layout: &self.scene_layout,
            entries: &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: wgpu::BindingResource::TextureView(color),
                },
                wgpu::BindGroupEntry {
                    binding: 1,
                    resource: wgpu::BindingResource::TextureView(depth),
                },
            ],
        })
    }

    /// Lays the air over a scene, pixel by pixel, and displays it; the sky's pixels are left alone.
    /// Without `air` the scene is displayed as it is.
    pub fn composite(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        view: u32,
        scene: &wgpu::BindGroup,
        air: bool,
    ) {
        pass.set_pipeline(&self.pipelines.composite[usize::from(!air)]);
        self.bind(pass, view);
        pass.set_bind_group(2, scene, &[]);
        pass.draw(0..3, 0..1);
    }

    /// Bytes of our buffers and textures on the GPU.
    #[must_use]
    pub const fn gpu_bytes() -> u64 {
        size_of::<SkyUniform>() as u64
            + size_of::<AerialUniform>() as u64
            + VIEW_STRIDE * MOST_VIEWS as u64
            + 8 * BAKED_SIZE[0] as u64 * BAKED_SIZE[1] as u64
    }
}

/// Whether two lights differ by less than can be seen.
fn near(a: [f32; 3], b: [f32; 3]) -> bool {
    (0..3).all(|c| (a[c] - b[c]).abs() <= 2e-3 * b[c].abs())
}

/// Mean light of the upper half of the sky, by cosine \[cd·m⁻²\].
fn mean(picture: &Picture) -> [f32; 3] {
    picture
        .light
        .sky_horizontal
        .map(|c| c / core::f32::consts::PI)
}

/// The exposure value that brings the mean of a picture's sky to middle gray, 0.18.
#[must_use]
pub fn auto_ev100(picture: &Picture) -> f32 {
    ev100_for_mean(luminance(mean(picture)))
}

/// The exposure value that brings a luminance \[cd·m⁻²\] to middle gray, 0.18.
#[must_use]
pub fn ev100_for_mean(mean: f32) -> f32 {
    // a meter's answer brings it to 0.104
    ev100_from_luminance(mean) - 0.79
}

struct Layouts {
    frame: wgpu::BindGroupLayout,
    view: wgpu::BindGroupLayout,
    baked: wgpu::BindGroupLayout,
    scene: wgpu::BindGroupLayout,
}

impl Layouts {
    fn new(device: &wgpu::Device) -> Self {
        let layout = |label, entries: &[wgpu::BindGroupLayoutEntry]| {
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some(label),
                entries,
            })
        };
        let uniform = |binding, has_dynamic_offset| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Uniform,
                has_dynamic_offset,
                min_binding_size: None,
            },
            count: None,
        };
        let texture = |binding, filterable| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty: wgpu::BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Float { filterable },
                view_dimension: wgpu::TextureViewDimension::D2,
                multisampled: false,
            },
            count: None,
        };
        let sampler = wgpu::BindGroupLayoutEntry {
            binding: 1,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty: wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
            count: None,
        };
        Self {
            frame: layout("sky frame", &[uniform(0, false), uniform(1, false)]),
            view: layout("sky view", &[uniform(0, true)]),
            baked: layout("baked sky", &[texture(0, true), sampler]),
            scene: layout("scene", &[texture(0, false), texture(1, false)]),
        }
    }
}

impl Pipelines {
    fn new(device: &wgpu::Device, layouts: &Layouts, target: wgpu::TextureFormat) -> Self {
        let module = |program: shader::Program| {
            device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(program.0),
                source: wgpu::ShaderSource::Wgsl(shader::text(program, is_float(target)).into()),
            })
        };
        let sky = module(shader::SKY_PROGRAM);
        let dome = module(shader::DOME_PROGRAM);
        let composite = module(shader::COMPOSITE_PROGRAM);
        let pipeline = |module: &wgpu::ShaderModule,
                        third: Option<&wgpu::BindGroupLayout>,
                        [vertex, fragment]: [&str; 2],
                        format: wgpu::TextureFormat| {
            let groups = [Some(&layouts.frame), Some(&layouts.view), third];
            let groups = if third.is_some() {
                &groups[..]
            } else {
                &groups[..2]
            };
            let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some(fragment),
                bind_group_layouts: groups,
                immediate_size: 0,
            });
            device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(fragment),
                layout: Some(&layout),
                vertex: wgpu::VertexState {
                    module,
                    entry_point: Some(vertex),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    buffers: &[],
                },
                primitive: wgpu::PrimitiveState::default(),
                depth_stencil: None,
                multisample: wgpu::MultisampleState::default(),
                fragment: Some(wgpu::FragmentState {
                    module,
                    entry_point: Some(fragment),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    targets: &[Some(format.into())],
                }),
                multiview_mask: None,
                cache: None,
            })
        };
        let screen = |fragment| ["screen_vertex", fragment];
        let half = wgpu::TextureFormat::Rgba16Float;
        let (tex, scene) = (Some(&layouts.baked), Some(&layouts.scene));
        let is_cpu = device.adapter_info().device_type == wgpu::DeviceType::Cpu;
        let flat = is_cpu.then(|| module(shader::FLAT_PROGRAM));
        let perspective = |flat_entries, fragment| {
            flat.as_ref().map_or_else(
                || pipeline(&sky, tex, screen(fragment), target),
                |flat| pipeline(flat, tex, flat_entries, target),
            )
        };
        Self {
            fragment: [
                perspective(["flat_vertex", "flat_fragment"], "sky_fragment"),
                pipeline(&sky, tex, screen("sky_panorama"), target),
            ],
            baked: [
                perspective(
                    ["flat_baked_vertex", "flat_baked_fragment"],
                    "baked_fragment",
                ),
                pipeline(&sky, tex, screen("baked_panorama"), target),
            ],
            dome: pipeline(&dome, None, ["dome_vertex", "dome_fragment"], target),
            composite: ["composite_fragment", "scene_fragment"]
                .map(|f| pipeline(&composite, scene, screen(f), target)),
            floor: pipeline(&sky, None, screen("floor_fragment"), target),
            bake: ["bake_ground", "bake_sky"].map(|f| pipeline(&sky, None, screen(f), half)),
        }
    }
}

/// Whether a target takes light in place of a picture.
const fn is_float(target: wgpu::TextureFormat) -> bool {
    matches!(
        target,
        wgpu::TextureFormat::Rgba16Float | wgpu::TextureFormat::Rgba32Float
    )
}

fn baked_texture(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
) -> (wgpu::TextureView, wgpu::BindGroup) {
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("baked sky"),
        size: wgpu::Extent3d {
            width: BAKED_SIZE[0],
            height: BAKED_SIZE[1],
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba16Float,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    });
    let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
    let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("baked sky"),
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        ..wgpu::SamplerDescriptor::default()
    });
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("baked sky"),
        layout,
        entries: &[
            wgpu::BindGroupEntry {
                binding: 0,
                resource: wgpu::BindingResource::TextureView(&view),
            },
            wgpu::BindGroupEntry {
                binding: 1,
                resource: wgpu::BindingResource::Sampler(&sampler),
            },
        ],
    });
    (view, group)
}
