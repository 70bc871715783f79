//! An engine that the sky knows nothing of: towers drawn with four samples and reversed depth into a
//! packed float target, for two observers at different altitudes. What is marked (1) to (5) is all that
//! the sky needs.

use sky_gpu::glam::{Mat3, Mat4, Vec3};
use sky_gpu::headless::{Headless, HeadlessError};
use sky_gpu::wgpu::util::DeviceExt as _;
use sky_gpu::{
    Camera, Exposure, FrameError, FrameSettings, Haze, Length, Output, Picture, SkyRenderer,
    SkyRendererOptions, Tier, UtmSky, View, frame_layout, shader, sky_depth, wgpu,
};

/// Light \[cd·m⁻²\] as it is, in 32 bits: half of `Rgba16Float`.
pub(crate) const COLOR: wgpu::TextureFormat = wgpu::TextureFormat::Rg11b10Ufloat;
const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
const SAMPLES: u32 = 4;
/// Toward the sun; x is east, y north, z up.
pub(crate) const SUN: [f32; 3] = [0.25, 0.87, 0.33];

/// A tower: east and north of its middle, half its width, its height \[m\].
pub(crate) type Tower = [f32; 4];
pub(crate) const TOWERS: [Tower; 5] = [
    [-900.0, 2500.0, 150.0, 1300.0],
    [2500.0, 9000.0, 900.0, 3500.0],
    [-9000.0, 24_000.0, 2000.0, 5000.0],
    [5000.0, 45_000.0, 3000.0, 8000.0],
    [-30_000.0, 80_000.0, 6000.0, 9000.0],
];

/// An observer: altitude \[m\], azimuth east of north and elevation \[rad\] of the view.
pub(crate) type Observer = [f32; 3];
pub(crate) const OBSERVERS: [Observer; 2] = [[800.0, 0.0, 0.06], [9000.0, 0.0, -0.12]];

/// The towers' own shader; our functions stand before it.
const TOWER_SHADER: &str = "
struct Eye { clip_from_world: mat4x4<f32>, place: vec4<f32> }
@group(0) @binding(0) var<uniform> eye: Eye;
struct Varying {
    @builtin(position) position: vec4<f32>,
    @location(0) from_eye: vec3<f32>,
    @location(1) light: vec3<f32>,
}
@vertex
fn tower_vertex(@location(0) place: vec3<f32>, @location(1) light: vec3<f32>) -> Varying {
    let from_eye = place - eye.place.xyz;
    return Varying(eye.clip_from_world * vec4<f32>(from_eye, 1.0), from_eye, light);
}
@fragment
fn tower_fragment(in: Varying) -> @location(0) vec4<f32> {
    let air = air_before(in.from_eye, 0.001); // the world is in meters
    return vec4<f32>((air.transmittance.xyz * in.light + air.inscatter) * sky.exposure, 1.0);
}
";

/// What one observer has: a camera, a view of the sky, targets.
#[derive(Debug)]
pub(crate) struct Window {
    altitude_m: f32,
    pub(crate) camera: Camera,
    pub(crate) frame: FrameSettings,
    pub(crate) view: View,
    pub(crate) resolved: wgpu::Texture,
    samples: wgpu::TextureView,
    depth: wgpu::TextureView,
    eye: wgpu::Buffer,
    eye_group: wgpu::BindGroup,
}

/// The engine.
#[derive(Debug)]
pub(crate) struct App {
    pub(crate) gpu: Headless,
    sky: SkyRenderer,
    towers: wgpu::RenderPipeline,
    eye_layout: wgpu::BindGroupLayout,
    corners: wgpu::Buffer,
    corner_count: u32,
}

fn texture(
    device: &wgpu::Device,
    [width, height]: [u32; 2],
    format: wgpu::TextureFormat,
    sample_count: u32,
) -> wgpu::Texture {
    let read = if sample_count == 1 {
        wgpu::TextureUsages::COPY_SRC
    } else {
        wgpu::TextureUsages::empty()
    };
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some("engine"),
        size: wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | read,
        view_formats: &[],
    })
}

fn pipeline(device: &wgpu::Device, eye: &wgpu::BindGroupLayout) -> wgpu::RenderPipeline {
    // (2) a shader of one's own calls `air_before`: our text before it, our bind group beside its own
    let text = shader::functions(1) + TOWER_SHADER;
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("towers"),
        source: wgpu::ShaderSource::Wgsl(text.into()),
    });
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("towers"),
        bind_group_layouts: &[Some(eye), Some(&frame_layout(device))],
        immediate_size: 0,
    });
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("towers"),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("tower_vertex"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &[Some(wgpu::VertexBufferLayout {
                array_stride: 24,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3],
            })],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Greater),
            ..sky_depth(DEPTH, true)
        }),
        multisample: wgpu::MultisampleState {
            count: SAMPLES,
            ..wgpu::MultisampleState::default()
        },
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("tower_fragment"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(COLOR.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// Light of a wall that looks in a direction \[cd·m⁻²\].
pub(crate) fn wall_light(picture: &Picture, normal: Vec3) -> [f32; 3] {
    let sun = Vec3::from(SUN).normalize().dot(normal).max(0.0);
    let light = &picture.light;
    [0.30, 0.24, 0.18]
        .map(|albedo| albedo / core::f32::consts::PI)
        .into_iter()
        .enumerate()
        .map(|(c, albedo)| {
            albedo * (light.sun_normal[c] * sun + light.sky_horizontal[c] * (0.5 + 0.5 * normal.z))
        })
        .collect::<Vec<_>>()
        .try_into()
        .unwrap_or_default()
}

/// Outward directions of a tower's roof and walls, each with two directions along the face.
const FACES: [[[f32; 3]; 3]; 5] = [
    [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
    [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
];

/// Places and lights of the towers' triangles.
fn corners(picture: &Picture) -> Vec<f32> {
    let mut out = Vec::new();
    for [east, north, half, height] in TOWERS {
        let middle = Vec3::new(east, north, 0.5 * height);
        let size = Vec3::new(half, half, 0.5 * height);
        for [normal, u, v] in FACES.map(|face| face.map(Vec3::from)) {
            let light = wall_light(picture, normal);
            for [a, b] in [[-1, -1], [1, -1], [1, 1], [-1, -1], [1, 1], [-1, 1]] {
                let on_cube = normal + u * a as f32 + v * b as f32;
                out.extend((middle + on_cube * size).to_array());
                out.extend(light);
            }
        }
    }
    out
}

impl App {
    pub(crate) fn new() -> Result<Self, Box<dyn std::error::Error>> {
        let gpu = Headless::with_features(wgpu::Features::RG11B10UFLOAT_RENDERABLE)?;
        let device = &gpu.device;
        // (1) once: the table, and what is drawn to
        let table = UtmSky::embedded()?;
        let options = SkyRendererOptions {
            depth_stencil: Some(sky_depth(DEPTH, true)),
            sample_count: SAMPLES,
            ..SkyRendererOptions::new(COLOR, Output::Linear)
        };
        let sky = SkyRenderer::new(device, &table, &options);
        let eye_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("eye"),
            entries: &[wgpu::BindGroupLayoutEntry {
                binding: 0,
                visibility: wgpu::ShaderStages::VERTEX,
                ty: wgpu::BindingType::Buffer {
                    ty: wgpu::BufferBindingType::Uniform,
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
                count: None,
            }],
        });
        // the towers are lit as at the first observer's place
        let lit = Picture::new(&table, &frame(OBSERVERS[0]).conditions()?, 0.2)?;
        let corners = corners(&lit);
        let bytes: Vec<u8> = corners.iter().flat_map(|f| f.to_ne_bytes()).collect();
        Ok(Self {
            sky,
            towers: pipeline(device, &eye_layout),
            corners: device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("towers"),
                contents: &bytes,
                usage: wgpu::BufferUsages::VERTEX,
            }),
            corner_count: u32::try_from(corners.len() / 6)?,
            eye_layout,
            gpu,
        })
    }

    /// A window for an observer.
    pub(crate) fn open(&self, observer: Observer, size: [u32; 2]) -> Window {
        let device = &self.gpu.device;
        let eye = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("eye"),
            size: 80,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let eye_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("eye"),
            layout: &self.eye_layout,
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: eye.as_entire_binding(),
            }],
        });
        let new_view = |texture: &wgpu::Texture| texture.create_view(&Default::default());
        Window {
            altitude_m: observer[0],
            camera: camera(observer, size),
            frame: frame(observer),
            // (3) a view for each observer, at its own altitude
            view: self.sky.view(device),
            resolved: texture(device, size, COLOR, 1),
            samples: new_view(&texture(device, size, COLOR, SAMPLES)),
            depth: new_view(&texture(device, size, DEPTH, SAMPLES)),
            eye,
            eye_group,
        }
    }

    /// Draws all windows; the sky of every other one before the towers, of the rest after them.
    pub(crate) fn draw(&self, windows: &mut [Window], tier: Tier) -> Result<(), FrameError> {
        let queue = &self.gpu.queue;
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        for (i, window) in windows.iter_mut().enumerate() {
            // (4) every frame: what the view shows, before its pass
            self.sky.update(queue, &mut window.view, &window.frame)?;
            self.sky.set_camera(queue, &mut window.view, &window.camera);
            self.sky
                .prepare(queue, &mut encoder, &mut window.view, tier);
            self.look(window);
            let mut pass = window.pass(&mut encoder);
            // (5) in the pass that the engine has: at the far depth, before the scene or after it
            if i % 2 == 0 {
                self.sky.draw(&mut pass, &window.view);
            }
            pass.set_pipeline(&self.towers);
            pass.set_bind_group(0, &window.eye_group, &[]);
            pass.set_bind_group(1, window.view.frame_group(), &[]);
            pass.set_vertex_buffer(0, self.corners.slice(..));
            pass.draw(0..self.corner_count, 0..1);
            if i % 2 == 1 {
                self.sky.draw(&mut pass, &window.view);
            }
        }
        queue.submit([encoder.finish()]);
        Ok(())
    }

    /// Uploads where a window's camera stands.
    fn look(&self, window: &Window) {
        let clip_from_world = window.camera.clip_from_world().unwrap_or(Mat4::IDENTITY);
        let floats = clip_from_world.to_cols_array().into_iter();
        let bytes: Vec<u8> = floats
            .chain([0.0, 0.0, window.altitude_m, 0.0])
            .flat_map(f32::to_ne_bytes)
            .collect();
        self.gpu.queue.write_buffer(&window.eye, 0, &bytes);
    }

    /// A window's light \[cd·m⁻²\], row by row.
    pub(crate) fn pixels(&self, window: &Window) -> Result<Vec<[f32; 3]>, HeadlessError> {
        let bytes = self.gpu.read(&window.resolved)?;
        Ok(bytes
            .chunks_exact(4)
            .map(|b| unpacked(u32::from_le_bytes([b[0], b[1], b[2], b[3]])))
            .collect())
    }
}

impl Window {
    fn pass<'a>(&self, encoder: &'a mut wgpu::CommandEncoder) -> wgpu::RenderPass<'a> {
        let resolved = self.resolved.create_view(&Default::default());
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("engine"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.samples,
                depth_slice: None,
                resolve_target: Some(&resolved),
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                    store: wgpu::StoreOp::Discard,
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Discard,
                }),
                stencil_ops: None,
            }),
            ..Default::default()
        })
    }
}

/// What an observer's sky depends on.
pub(crate) fn frame([altitude_m, ..]: Observer) -> FrameSettings {
    FrameSettings {
        observer_altitude: Length::from_m(altitude_m.into()),
        haze: Haze::VisualRange(Length::from_km(60.0)),
        sun: SUN.into(),
        exposure: Exposure::None,
        ..FrameSettings::default()
    }
}

/// An observer's camera: reversed infinite depth; rows right, up, backward.
pub(crate) fn camera([_, azimuth, elevation]: Observer, [width, height]: [u32; 2]) -> Camera {
    let (sin_azimuth, cos_azimuth) = azimuth.sin_cos();
    let (sin_elevation, cos_elevation) = elevation.sin_cos();
    let forward = Vec3::new(
        sin_azimuth * cos_elevation,
        cos_azimuth * cos_elevation,
        sin_elevation,
    );
    let right = Vec3::new(cos_azimuth, -sin_azimuth, 0.0);
    let looking = Mat3::from_cols(right, right.cross(forward), -forward).transpose();
    Camera::perspective(0.9, width as f32 / height as f32, looking)
}

/// The three unsigned floats of a texel of `Rg11b10Ufloat`.
fn unpacked(texel: u32) -> [f32; 3] {
    let float = |bits: u32, fraction_bits: u32| {
        let fraction = (bits & ((1 << fraction_bits) - 1)) as f32 / (1 << fraction_bits) as f32;
        match bits >> fraction_bits {
            0 => fraction * 2.0_f32.powi(-14),
            31 => f32::INFINITY,
            exponent => (1.0 + fraction) * (exponent as f32 - 15.0).exp2(),
        }
    };
    [
        float(texel & 0x7FF, 6),
        float(texel >> 11 & 0x7FF, 6),
        float(texel >> 22, 5),
    ]
}
