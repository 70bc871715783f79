//! One picture: what decides it, and how the GPU or the CPU draws it.

use anyhow::Result;
use glam::Vec3;
use rayon::prelude::*;
use sky_core::conditions::Conditions;
use sky_core::haze::Haze;
use sky_core::light::SunDisc;
use sky_core::picture::Picture;
use sky_core::quantity::Angle;
use sky_core::tonemap::{Tone, exposure_from_ev100};
use sky_core::utm_sky::UtmSky;
use sky_gpu::headless::{Headless, check_size};
use sky_gpu::{
    Camera, Dome, Exposure, FrameSettings, Output, Projection, SkyRenderer, SkyRendererOptions,
    Tier, View, auto_ev100,
};

use crate::camera::{clip, world_direction};
use crate::pixels::{Pixels, bytes_of, developed, floats_of};
use crate::sun_disc::{Panorama, spread_sun};
use crate::terrain::{SceneBuffers, lowest_eye, terrain};

/// Albedo of the ground of the default table.
pub const GROUND_ALBEDO: f32 = 0.2;

/// Every tier with its name.
pub const TIERS: [(Tier, &str); 3] = [
    (Tier::Vertex(Dome::REPORT), "vertex"),
    (Tier::Fragment, "fragment"),
    (Tier::Baked, "baked"),
];

/// What stands under the sky.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scenery {
    /// The bare ground below the horizon.
    #[default]
    None,
    /// Ridges over several hundred kilometers.
    Terrain,
}

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
    /// Whether the sun's disc is drawn.
    pub sun_disc: bool,
    /// What stands under the sky.
    pub scenery: Scenery,
    /// Whether the air between camera and scene is drawn.
    pub aerial: bool,
}

impl Shot {
    /// Observer, haze and sun; where there is scenery the observer stands on it, not in it. Everything
    /// that is drawn, sky, air and ground, is drawn for this one altitude.
    #[must_use]
    pub fn standing(&self) -> Conditions {
        let asked = self.conditions.observer_altitude;
        let lowest = lowest_eye();
        let is_inside =
            self.scenery == Scenery::Terrain && (0.0..lowest.km()).contains(&asked.km());
        Conditions {
            observer_altitude: if is_inside { lowest } else { asked },
            ..self.conditions
        }
    }

    /// The renderer's frame.
    #[must_use]
    pub fn frame(&self) -> FrameSettings {
        let elevation = Angle::from_degrees(90.0 - self.conditions.sun_zenith.degrees());
        FrameSettings {
            observer_altitude: self.standing().observer_altitude,
            haze: Haze::Turbidity(self.conditions.turbidity),
            sun: world_direction(self.sun_azimuth, elevation),
            up: Vec3::Z,
            ground_albedo: GROUND_ALBEDO,
            sun_disc: self.sun_disc && !self.spreads_sun(),
            exposure: match (self.tone, self.ev100) {
                (None, _) => Exposure::None,
                (_, Some(ev100)) => Exposure::Ev100(ev100),
                (_, None) => Exposure::Auto,
            },
            tone: self.tone,
            ..FrameSettings::default()
        }
    }

    /// Whether the sun's disc is spread over the pixels that it touches after all else is drawn, so
    /// that a picture of light holds all of it: panoramas whose pixels are larger than the disc.
    #[must_use]
    pub fn spreads_sun(&self) -> bool {
        self.sun_disc
            && self.tone.is_none()
            && self.camera.projection == Projection::Equirectangular
    }

    /// The picture that the sun's disc is spread over.
    pub(crate) fn panorama(&self) -> Panorama {
        Panorama {
            size: self.size,
            view_from_world: self.camera.view_from_world,
            axes: self.frame().local_axes(),
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
    let whole = Picture::new(sky, &shot.standing(), GROUND_ALBEDO)?;
    let mut picture = whole.clone();
    if !shot.frame().sun_disc {
        picture.sun = SunDisc::default();
    }
    let axes = shot.frame().local_axes();
    let scene = scene_buffers(&picture, shot, axes);
    let exposure = match (shot.tone, shot.ev100) {
        (None, _) => 1.0,
        (_, ev100) => exposure_from_ev100(ev100.unwrap_or_else(|| auto_ev100(&picture))),
    };
    let mut lights: Vec<[f32; 3]> = (0..height)
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
    if shot.spreads_sun() {
        spread_sun(
            lights.as_flattened_mut(),
            &shot.panorama(),
            &whole,
            scene.as_ref(),
        );
    }
    Ok(developed(lights, shot.size[0], shot.tone, exposure))
}

fn scene_buffers(picture: &Picture, shot: &Shot, axes: [Vec3; 3]) -> Option<SceneBuffers> {
    match shot.scenery {
        Scenery::None => None,
        Scenery::Terrain => Some(terrain(picture, shot.size, axes, &|x, y| {
            shot.direction(x, y)
        })),
    }
}

/// Draws by the GPU; pipelines are made once for a kind of target.
#[derive(Debug)]
pub struct Painter {
    gpu: Headless,
    sky: UtmSky,
    /// For 8-bit sRGB and for linear light.
    renderers: [Option<(SkyRenderer, View)>; 2],
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
        let (place, format, output) = match shot.tone {
            Some(_) => (0, wgpu::TextureFormat::Rgba8Unorm, Output::Display),
            None => (1, wgpu::TextureFormat::Rgba32Float, Output::Linear),
        };
        let target = gpu.target(shot.size, format)?;
        let (renderer, view) = self.renderers[place].get_or_insert_with(|| {
            let options = SkyRendererOptions::new(format, output);
            let renderer = SkyRenderer::new(&gpu.device, &self.sky, &options);
            let view = renderer.view(&gpu.device);
            (renderer, view)
        });
        let frame = shot.frame();
        let picture = renderer.update(&gpu.queue, view, &frame)?;
        let scene = scene_buffers(picture, shot, frame.local_axes());
        renderer.set_camera(&gpu.queue, view, &shot.camera);
        let target_view = target.create_view(&wgpu::TextureViewDescriptor::default());
        let bound = scene
            .as_ref()
            .map(|scene| bind_scene(gpu, renderer, scene, shot.size))
            .transpose()?;
        gpu.draw(renderer, view, &target_view, shot.tier, |view, pass| {
            if let Some(bound) = &bound {
                renderer.composite(pass, view, bound, shot.aerial);
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
            let mut lights: Vec<f32> = floats_of(&bytes)
                .chunks_exact(4)
                .flat_map(|p| [p[0], p[1], p[2]])
                .collect();
            if shot.spreads_sun() {
                let whole = Picture::new(&self.sky, &shot.standing(), GROUND_ALBEDO)?;
                spread_sun(&mut lights, &shot.panorama(), &whole, scene.as_ref());
            }
            Pixels::Linear(lights)
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
    let color = upload(
        wgpu::TextureFormat::Rgba32Float,
        &bytes_of(&scene.light),
        16,
    )?;
    let depth = upload(
        wgpu::TextureFormat::R32Float,
        &bytes_of(&scene.distance_km),
        4,
    )?;
    Ok(renderer.scene(&gpu.device, &color, &depth))
}
