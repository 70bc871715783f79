//! `utm-sky render`: pictures of the sky without a window, by GPU or CPU.

use std::io::Cursor;
use std::path::Path;

use anyhow::{Context as _, Result, anyhow, bail};
use glam::{Mat3, Vec3};
use image::{ExtendedColorType, ImageEncoder as _};
use rayon::prelude::*;
use sky_core::color::{linear_srgb_from_xyz, xyz_from_yxy};
use sky_core::conditions::Conditions;
use sky_core::direction::SkyDirection;
use sky_core::haze::Haze;
use sky_core::lut::LutHeader;
use sky_core::picture::Picture;
use sky_core::quantity::Angle;
use sky_core::quantity::single;
use sky_core::tonemap::{Tone, dither, encoded, exposure_from_ev100, tone_mapped};
use sky_core::utm_sky::UtmSky;
use sky_gpu::headless::{Headless, check_size};
use sky_gpu::{
    Camera, Dome, Exposure, Projection, SkyFrame, SkyRenderer, Tier, auto_ev100, ev100_for_mean,
};
use sky_science::direction::report_directions;
use sky_science::metrics::cosine_weighted_mean;
use sky_science::sky_model::SkyModel;

use crate::args::{Backend, ProjectionKind, RenderArgs, SceneKind, TierKind, ToneKind};
use crate::files::OutputFile;
use crate::models::{self, answers};
use crate::plan::PlannedAerial;
use crate::scene::Scene;
use crate::terrain::{SceneBuffers, terrain};

/// Albedo of the ground of the default table.
pub const GROUND_ALBEDO: f32 = 0.2;

/// Everything that decides a picture.
#[derive(Clone, Debug)]
pub struct Shot {
    /// Observer, haze and sun.
    pub conditions: Conditions,
    /// Azimuth of the sun, clockwise from north.
    pub sun_azimuth: Angle,
    /// The camera.
    pub camera: Camera,
    /// Pixels across and down.
    pub size: [u32; 2],
    /// Exposure value at ISO 100; `None` is automatic.
    pub ev100: Option<f32>,
    /// Tone curve; `None` leaves linear light in cd·m⁻².
    pub tone: Option<Tone>,
    /// How the GPU draws the sky.
    pub tier: Tier,
    /// What stands under the sky.
    pub scenery: SceneKind,
    /// Whether the air between camera and scene is drawn.
    pub aerial: bool,
}

/// A picture: 8-bit sRGB, or linear light.
#[derive(Clone, Debug, PartialEq)]
pub enum Pixels {
    /// Red, green, blue.
    Srgb8(Vec<u8>),
    /// Linear sRGB \[cd·m⁻²\].
    Linear(Vec<f32>),
}

/// Runs the command.
///
/// # Errors
/// When an input is wrong, there is no GPU, or the picture cannot be written.
pub fn run(args: &RenderArgs) -> Result<()> {
    let is_exr = match args.out.extension().and_then(|e| e.to_str()) {
        Some("png") => false,
        Some("exr") => true,
        _ => bail!(
            "--out: expected a name ending in .png or .exr, found {}",
            args.out.display()
        ),
    };
    if let Some(name) = &args.model {
        let shot = shot(args, &args.scene.conditions()?, None, is_exr);
        let out = OutputFile::create(&args.out)?;
        let pixels = draw_model(&*models::open(name)?, &shot)?;
        out.commit(&file_bytes(&pixels, shot.size)?)?;
        return Ok(());
    }
    let scene = Scene::open(&args.scene)?;
    let header = scene.sky.lut().header();
    let shot = shot(args, &scene.conditions, Some(header), is_exr);
    let out = OutputFile::create(&args.out)?;
    let source = scene.source.clone();
    let pixels = match args.backend {
        Backend::Cpu => draw_on_cpu(&scene.sky, &shot),
        Backend::Gpu => Painter::new(scene.sky).and_then(|mut painter| painter.draw(&shot)),
    }
    .with_context(|| source)
    .map_err(|e| anyhow!("{e:#}"))?;
    out.commit(&file_bytes(&pixels, shot.size)?)?;
    Ok(())
}

/// A plan's table says how it is drawn, where the arguments do not.
fn shot(
    args: &RenderArgs,
    conditions: &Conditions,
    header: Option<&LutHeader>,
    linear: bool,
) -> Shot {
    let [azimuth, elevation] = args.look.unwrap_or([args.sun_azimuth_deg, 10.0]);
    let [width, height] = args.size;
    let aspect = pixels(width) / pixels(height);
    let camera = match args.projection {
        ProjectionKind::Perspective => Camera {
            depth_is_distance: true,
            ..Camera::perspective(
                single(Angle::from_degrees(args.fov_deg).radians()),
                aspect,
                looking(azimuth, elevation),
            )
        },
        ProjectionKind::Fisheye => {
            Camera::panorama(Projection::Fisheye { aspect }, facing(azimuth))
        }
        ProjectionKind::Equirect => Camera::panorama(Projection::Equirectangular, facing(azimuth)),
    };
    Shot {
        conditions: *conditions,
        sun_azimuth: Angle::from_degrees(args.sun_azimuth_deg),
        camera,
        size: args.size,
        ev100: args.ev100.0,
        tone: (!linear).then_some(tone(args.tone)),
        tier: args
            .tier
            .or_else(|| TierKind::planned(header?))
            .map_or(Tier::Fragment, tier),
        scenery: args.scenery,
        aerial: !args.no_aerial && !header.is_some_and(without_aerial),
    }
}

/// The tone curve of a name.
#[must_use]
pub const fn tone(kind: ToneKind) -> Tone {
    match kind {
        ToneKind::None => Tone::None,
        ToneKind::Reinhard => Tone::Reinhard,
        ToneKind::Aces => Tone::Aces,
        ToneKind::Neutral => Tone::Neutral,
    }
}

/// Whether a table's plan leaves the air between camera and scene out.
#[must_use]
pub fn without_aerial(header: &LutHeader) -> bool {
    header.planned("aerial") == Some(PlannedAerial::None.name())
}

/// The tier of a name.
#[must_use]
pub const fn tier(kind: TierKind) -> Tier {
    match kind {
        TierKind::Vertex => Tier::Vertex(Dome::REPORT),
        TierKind::Fragment => Tier::Fragment,
        TierKind::Baked => Tier::Baked,
    }
}

/// Whole numbers of pixels as a number.
pub(crate) fn pixels(count: u32) -> f32 {
    u16::try_from(count).map_or(65535.0, f32::from)
}

/// The center of a pixel in the picture, −1..1 to the right and up.
#[must_use]
pub fn clip(pixel: [u32; 2], size: [u32; 2]) -> [f32; 2] {
    let [x, y] = pixel.map(|p| pixels(p) + 0.5);
    let [width, height] = size.map(pixels);
    [x / width * 2.0 - 1.0, 1.0 - y / height * 2.0]
}

/// East, north, up: a direction from azimuth (clockwise from north) and elevation.
#[must_use]
pub fn world_direction(azimuth: Angle, elevation: Angle) -> Vec3 {
    let (sin_a, cos_a) = single(azimuth.radians()).sin_cos();
    let (sin_e, cos_e) = single(elevation.radians()).sin_cos();
    Vec3::new(sin_a * cos_e, cos_a * cos_e, sin_e)
}

/// A view that looks in a direction: rows right, up, backward.
#[must_use]
pub fn looking(azimuth_deg: f64, elevation_deg: f64) -> Mat3 {
    let azimuth = Angle::from_degrees(azimuth_deg);
    let forward = world_direction(azimuth, Angle::from_degrees(elevation_deg));
    let right = world_direction(Angle::from_degrees(azimuth_deg + 90.0), Angle::ZERO);
    Mat3::from_cols(right, right.cross(forward), -forward).transpose()
}

/// A panorama's view: rows right, forward, up.
#[must_use]
pub fn facing(azimuth_deg: f64) -> Mat3 {
    let forward = world_direction(Angle::from_degrees(azimuth_deg), Angle::ZERO);
    let right = world_direction(Angle::from_degrees(azimuth_deg + 90.0), Angle::ZERO);
    Mat3::from_cols(right, forward, Vec3::Z).transpose()
}

impl Shot {
    /// The renderer's frame.
    #[must_use]
    pub fn frame(&self) -> SkyFrame {
        let elevation = Angle::from_degrees(90.0 - self.conditions.sun_zenith.degrees());
        SkyFrame {
            observer_altitude: self.conditions.observer_altitude,
            haze: Haze::Turbidity(self.conditions.turbidity),
            sun: world_direction(self.sun_azimuth, elevation),
            up: Vec3::Z,
            ground_albedo: GROUND_ALBEDO,
            sun_disc: true,
            exposure: match (self.tone, self.ev100) {
                (None, _) => Exposure::None,
                (_, Some(ev100)) => Exposure::Ev100(ev100),
                (_, None) => Exposure::Auto,
            },
            tone: self.tone,
        }
    }

    /// The world direction of a pixel; `None` outside a fisheye's disc.
    #[must_use]
    pub fn direction(&self, x: u32, y: u32) -> Option<Vec3> {
        self.camera.direction(clip([x, y], self.size))
    }
}

/// The pixels by the evaluator.
///
/// # Errors
/// When the conditions lie outside the domain or the size cannot be drawn.
pub fn draw_on_cpu(sky: &UtmSky, shot: &Shot) -> Result<Pixels> {
    check_size(shot.size)?;
    let [width, height] = shot.size;
    let picture = Picture::new(sky, &shot.conditions, GROUND_ALBEDO)?;
    let axes = shot.frame().local_axes();
    let scene = scene_buffers(&picture, shot, axes);
    let exposure = match (shot.tone, shot.ev100) {
        (None, _) => 1.0,
        (_, ev100) => exposure_from_ev100(ev100.unwrap_or_else(|| auto_ev100(&picture))),
    };
    let lights: Vec<[f32; 3]> = (0..height)
        .into_par_iter()
        .flat_map_iter(|y| (0..width).map(move |x| (x, y)))
        .map(|(x, y)| {
            let Some(world) = shot.direction(x, y) else {
                return [0.0; 3];
            };
            let local = axes.map(|axis| axis.dot(world));
            let object = scene.as_ref().and_then(|s| s.at(x, y));
            object.map_or_else(
                || picture.color(local),
                |(light, distance_km)| {
                    if shot.aerial {
                        picture.behind_air(local, distance_km, light)
                    } else {
                        light
                    }
                },
            )
        })
        .collect();
    Ok(developed(lights, shot, exposure))
}

/// Light as a picture for the shot's tone curve.
fn developed(lights: Vec<[f32; 3]>, shot: &Shot, exposure: f32) -> Pixels {
    let width = shot.size[0];
    match shot.tone {
        None => Pixels::Linear(lights.into_iter().flatten().collect()),
        Some(tone) => Pixels::Srgb8(
            lights
                .into_iter()
                .enumerate()
                .flat_map(|(i, light)| {
                    let i = u32::try_from(i).unwrap_or(0);
                    let noise = dither(i % width, i / width) / 255.0;
                    tone_mapped(light.map(|c| c * exposure), tone).map(|c| byte(encoded(c) + noise))
                })
                .collect(),
        ),
    }
}

/// The pixels of any sky: black where it has no answer, and no sun.
///
/// # Errors
/// When the conditions lie outside the domain or the size cannot be drawn.
pub fn draw_model(sky: &dyn SkyModel, shot: &Shot) -> Result<Pixels> {
    check_size(shot.size)?;
    let [width, height] = shot.size;
    let axes = shot.frame().local_axes();
    let (places, directions): (Vec<usize>, Vec<SkyDirection>) = (0..height)
        .flat_map(|y| (0..width).map(move |x| (x, y)))
        .enumerate()
        .filter_map(|(i, (x, y))| {
            let world = shot.direction(x, y)?;
            let direction = SkyDirection::from_vector(axes.map(|axis| f64::from(axis.dot(world))));
            answers(sky.domain(), &shot.conditions, &direction).then_some((i, direction))
        })
        .unzip();
    let ask = |directions: &[SkyDirection]| {
        sky.yxy_map(&shot.conditions, directions)
            .map_err(|e| anyhow!("{}: {e}", sky.name()))
    };
    let mut lights = vec![[0.0; 3]; width as usize * height as usize];
    for (place, yxy) in places.into_iter().zip(ask(&directions)?) {
        let rgb = linear_srgb_from_xyz(xyz_from_yxy(yxy));
        lights[place] = [rgb.red, rgb.green, rgb.blue].map(single);
    }
    let exposure = match (shot.tone, shot.ev100) {
        (None, _) => 1.0,
        (_, Some(ev100)) => exposure_from_ev100(ev100),
        (_, None) => {
            // not the horizontal, where 1/cos has no value
            let mut above = report_directions();
            above.retain(|d| d.view_zenith.degrees() < 89.0);
            let luminances: Vec<f64> = ask(&above)?.iter().map(|l| l.luminance_cd_m2).collect();
            let mean = cosine_weighted_mean(&above, &luminances).unwrap_or(0.0);
            exposure_from_ev100(ev100_for_mean(single(mean)))
        }
    };
    Ok(developed(lights, shot, exposure))
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "clamped to 0..255"
)]
pub(crate) fn byte(value: f32) -> u8 {
    (value * 255.0).round().clamp(0.0, 255.0) as u8
}

fn scene_buffers(picture: &Picture, shot: &Shot, axes: [Vec3; 3]) -> Option<SceneBuffers> {
    match shot.scenery {
        SceneKind::None => None,
        SceneKind::Terrain => Some(terrain(picture, shot, axes)),
    }
}

/// Draws by the GPU; pipelines are made once for a kind of target.
#[derive(Debug)]
pub struct Painter {
    gpu: Headless,
    sky: UtmSky,
    /// For 8-bit sRGB and for linear light.
    renderers: [Option<SkyRenderer>; 2],
}

impl Painter {
    /// Opens a GPU.
    ///
    /// # Errors
    /// When there is none.
    pub fn new(sky: UtmSky) -> Result<Self> {
        Ok(Self {
            gpu: Headless::new()?,
            sky,
            renderers: [None, None],
        })
    }

    /// The pixels of a picture.
    ///
    /// # Errors
    /// When the conditions lie outside the domain, the size cannot be drawn or the device is lost.
    pub fn draw(&mut self, shot: &Shot) -> Result<Pixels> {
        let gpu = &self.gpu;
        let (place, format) = match shot.tone {
            Some(_) => (0, wgpu::TextureFormat::Rgba8Unorm),
            None => (1, wgpu::TextureFormat::Rgba32Float),
        };
        let target = gpu.target(shot.size, format)?;
        let renderer = match &mut self.renderers[place] {
            Some(renderer) => renderer,
            empty => empty.insert(SkyRenderer::new(&gpu.device, self.sky.lut(), format)?),
        };
        let frame = shot.frame();
        let picture = renderer.update(&gpu.queue, &frame)?;
        let scene = scene_buffers(picture, shot, frame.local_axes());
        if let Tier::Vertex(dome) = shot.tier {
            renderer.set_dome(dome);
        }
        renderer.set_camera(&gpu.queue, 0, &shot.camera);
        let view = target.create_view(&wgpu::TextureViewDescriptor::default());
        let bound = scene
            .as_ref()
            .map(|scene| bind_scene(gpu, renderer, scene, shot.size))
            .transpose()?;
        gpu.draw(renderer, &view, shot.tier, |renderer, pass| {
            if let Some(bound) = &bound {
                renderer.composite(pass, 0, bound, shot.aerial);
            }
        });
        let bytes = gpu.read(&target)?;
        Ok(if shot.tone.is_some() {
            Pixels::Srgb8(
                bytes
                    .chunks_exact(4)
                    .flat_map(|p| [p[0], p[1], p[2]])
                    .collect(),
            )
        } else {
            let number = |b: &[u8]| f32::from_le_bytes([b[0], b[1], b[2], b[3]]);
            Pixels::Linear(
                bytes
                    .chunks_exact(16)
                    .flat_map(|p| [number(&p[..4]), number(&p[4..8]), number(&p[8..12])])
                    .collect(),
            )
        })
    }
}

/// Uploads a scene's light and distances.
///
/// # Errors
/// When the size cannot be drawn.
pub fn bind_scene(
    gpu: &Headless,
    renderer: &SkyRenderer,
    scene: &SceneBuffers,
    size: [u32; 2],
) -> Result<wgpu::BindGroup> {
    let upload = |format, bytes: &[u8], row: u32| -> Result<wgpu::TextureView> {
        let texture = gpu.target(size, format)?;
        gpu.queue.write_texture(
            texture.as_image_copy(),
            bytes,
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(row * size[0]),
                rows_per_image: None,
            },
            texture.size(),
        );
        Ok(texture.create_view(&wgpu::TextureViewDescriptor::default()))
    };
    let bytes = |values: &[f32]| {
        values
            .iter()
            .flat_map(|v| v.to_le_bytes())
            .collect::<Vec<_>>()
    };
    let color = upload(wgpu::TextureFormat::Rgba32Float, &bytes(&scene.light), 16)?;
    let depth = upload(wgpu::TextureFormat::R32Float, &bytes(&scene.distance_km), 4)?;
    Ok(renderer.scene(&gpu.device, &color, &depth))
}

/// The bytes of a PNG or EXR file.
///
/// # Errors
/// When the picture cannot be encoded.
pub fn file_bytes(pixels: &Pixels, [width, height]: [u32; 2]) -> Result<Vec<u8>> {
    let mut out = Cursor::new(Vec::new());
    match pixels {
        Pixels::Srgb8(bytes) => image::codecs::png::PngEncoder::new(&mut out).write_image(
            bytes,
            width,
            height,
            ExtendedColorType::Rgb8,
        )?,
        Pixels::Linear(values) => {
            let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_ne_bytes()).collect();
            image::codecs::openexr::OpenExrEncoder::new(&mut out).write_image(
                &bytes,
                width,
                height,
                ExtendedColorType::Rgb32F,
            )?;
        }
    }
    Ok(out.into_inner())
}

/// Writes a picture at once or not at all.
///
/// # Errors
/// When it cannot be encoded or written.
pub fn write(path: &Path, pixels: &Pixels, size: [u32; 2]) -> Result<()> {
    OutputFile::create(path)?.commit(&file_bytes(pixels, size)?)?;
    Ok(())
}
