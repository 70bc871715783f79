//! What one observer sees with one camera: the numbers that shaders read, and the sky baked for them.

use glam::{Mat3, Vec3};
use sky_core::picture::Picture;
use sky_core::uniforms::{AerialUniform, BAKED_SIZE, SkyUniform, ViewUniform};

use crate::camera::{Camera, Dome};
use crate::layouts::Layouts;
use crate::pipelines::BAKED_FORMAT;
use crate::tier::Tier;

/// Steps of altitude \[km\], logarithm of turbidity and sun zenith \[rad\] that a baked sky may lag
/// behind: a tenth of what changes a light by a percent where it changes fastest.
const VISIBLE_STEP: [f64; 3] = [0.002, 0.002, 0.000_2];

/// One observer with one camera. Made by [`crate::SkyRenderer::view`] and owned by the caller; there is
/// no maximum, and views do not know of each other: observers at different altitudes, under different
/// suns, share one renderer.
#[derive(Debug)]
pub struct View {
    sky: wgpu::Buffer,
    aerial: wgpu::Buffer,
    camera_buffer: wgpu::Buffer,
    frame_group: wgpu::BindGroup,
    baked_group: wgpu::BindGroup,
    baked_texture: wgpu::TextureView,
    picture: Option<Picture>,
    local: [Vec3; 3],
    camera: Camera,
    dome: Dome,
    tier: Tier,
    baked: Baked,
}

/// What the baked sky holds.
#[derive(Debug, Default)]
struct Baked {
    of: Option<BakedFor>,
    /// Whether the ground's rows and the sky's have fallen behind.
    behind: [bool; 2],
}

/// What a baked sky was made for.
#[derive(Clone, Copy, Debug)]
struct BakedFor {
    /// Altitude \[km\], logarithm of turbidity, sun zenith \[rad\].
    conditions: [f64; 3],
    ground: [f32; 3],
    scale: f32,
}

impl Baked {
    /// The scale of the sky for new conditions: as it is while the difference cannot be seen.
    fn follow(&mut self, conditions: [f64; 3], ground: [f32; 3], scale: f32) -> f32 {
        let near = |a: f32, b: f32| (a - b).abs() <= 2e-3 * b.abs();
        let stays = self.of.filter(|old| {
            (0..3).all(|i| near(old.ground[i], ground[i]))
                && (0..3).all(|i| (old.conditions[i] - conditions[i]).abs() <= VISIBLE_STEP[i])
        });
        let of = stays.unwrap_or_else(|| {
            self.behind = [true; 2];
            BakedFor {
                conditions,
                ground,
                scale,
            }
        });
        self.of = Some(of);
        of.scale
    }
}

impl View {
    pub(crate) fn new(device: &wgpu::Device, layouts: &Layouts) -> Self {
        let buffer = |label, bytes: usize| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: bytes as u64,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        let sky = buffer("sky", SkyUniform::BYTES);
        let aerial = buffer("aerial", AerialUniform::BYTES);
        let camera_buffer = buffer("sky view", ViewUniform::BYTES);
        let frame_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("sky frame"),
            layout: &layouts.frame,
            entries: &[(0, &sky), (1, &aerial), (2, &camera_buffer)].map(|(binding, buffer)| {
                wgpu::BindGroupEntry {
                    binding,
                    resource: buffer.as_entire_binding(),
                }
            }),
        });
        let (baked_texture, baked_group) = baked_texture(device, &layouts.baked);
        Self {
            sky,
            aerial,
            camera_buffer,
            frame_group,
            baked_group,
            baked_texture,
            picture: None,
            local: [Vec3::X, Vec3::Y, Vec3::Z],
            camera: Camera::perspective(1.0, 1.0, Mat3::IDENTITY),
            dome: Dome::REPORT,
            tier: Tier::default(),
            baked: Baked::default(),
        }
    }

    /// The frame of the last update; `None` before the first.
    #[must_use]
    pub const fn picture(&self) -> Option<&Picture> {
        self.picture.as_ref()
    }

    /// The sky's uniforms for pipelines of yours, by [`crate::frame_layout`]; text for their shaders is
    /// [`crate::shader::functions`].
    #[must_use]
    pub const fn frame_group(&self) -> &wgpu::BindGroup {
        &self.frame_group
    }

    /// The baked sky and its sampler, by [`crate::baked_layout`]. Light times
    /// [`SkyUniform::baked_scale`], at the texels of `baked_from_direction` in `baked.wgsl`.
    #[must_use]
    pub const fn baked_group(&self) -> &wgpu::BindGroup {
        &self.baked_group
    }

    /// The buffers behind [`Self::frame_group`], for bind groups of yours: [`SkyUniform`],
    /// [`AerialUniform`] and [`ViewUniform`].
    #[must_use]
    pub const fn buffers(&self) -> [&wgpu::Buffer; 3] {
        [&self.sky, &self.aerial, &self.camera_buffer]
    }

    /// Takes a frame. `conditions` are altitude \[km\], logarithm of turbidity and sun zenith \[rad\];
    /// `uniform` fills the sky's numbers for a scale of the baked sky.
    pub(crate) fn take(
        &mut self,
        queue: &wgpu::Queue,
        picture: Picture,
        local: [Vec3; 3],
        conditions: [f64; 3],
        scale: f32,
        uniform: impl FnOnce(&Picture, f32) -> SkyUniform,
    ) -> &Picture {
        let scale = self.baked.follow(conditions, picture.light.ground, scale);
        queue.write_buffer(&self.sky, 0, &uniform(&picture, scale).as_bytes());
        let aerial = AerialUniform::new(&picture.air);
        queue.write_buffer(&self.aerial, 0, &aerial.as_bytes());
        self.local = local;
        self.upload_camera(queue);
        self.picture.insert(picture)
    }

    /// Shows stripes until the next frame.
    pub(crate) fn take_outside(&mut self, queue: &wgpu::Queue, uniform: &SkyUniform) {
        queue.write_buffer(&self.sky, 0, &uniform.as_bytes());
        self.baked = Baked {
            of: None,
            behind: [true; 2],
        };
    }

    pub(crate) fn take_camera(&mut self, queue: &wgpu::Queue, camera: &Camera) {
        self.camera = *camera;
        self.upload_camera(queue);
    }

    /// Takes the tier; returns what of the baked sky, ground and sky, must be made for it.
    pub(crate) fn take_tier(&mut self, queue: &wgpu::Queue, tier: Tier) -> [bool; 2] {
        // a dome has no parallel rays
        self.tier = match tier {
            Tier::Vertex(_) if self.camera.is_orthographic() => Tier::Fragment,
            tier => tier,
        };
        if let Tier::Vertex(dome) = self.tier
            && dome != self.dome
        {
            self.dome = dome;
            self.upload_camera(queue);
        }
        let read = match self.tier {
            Tier::Vertex(_) => [false, false],
            Tier::Fragment => [true, false],
            Tier::Baked => [true, true],
        };
        core::array::from_fn(|part| {
            let must = read[part] && self.baked.behind[part];
            self.baked.behind[part] &= !must;
            must
        })
    }

    fn upload_camera(&self, queue: &wgpu::Queue) {
        let uniform = self.camera.uniform(self.local, self.dome);
        queue.write_buffer(&self.camera_buffer, 0, &uniform.as_bytes());
    }

    pub(crate) const fn local(&self) -> [Vec3; 3] {
        self.local
    }

    /// The tier that it was prepared for.
    pub(crate) const fn tier(&self) -> Tier {
        self.tier
    }

    pub(crate) const fn is_panorama(&self) -> bool {
        self.camera.is_panorama()
    }

    pub(crate) const fn baked_texture(&self) -> &wgpu::TextureView {
        &self.baked_texture
    }
}

fn baked_texture(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
) -> (wgpu::TextureView, wgpu::BindGroup) {
    let [width, height] = BAKED_SIZE;
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("baked sky"),
        size: wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: BAKED_FORMAT,
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
