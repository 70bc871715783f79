//! What the shaders read, as it lies in memory. Twins of the structs in `shaders/`.

use bytemuck::{Pod, Zeroable};
use glam::{Mat4, Vec3};
use sky_core::aerial::{AerialFrame, SECTIONS};
use sky_core::extended::Coefficients;
use sky_core::extended::TERMS;
use sky_core::extinction::LEVELS;
use sky_core::picture::Picture;
use sky_core::utm_sky::MAX_LAYERS;

/// `SkyUniform` of `sky_frame.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct SkyUniform {
    coefficients: Coefficients,
    radii: [f32; 4],
    place: [f32; 4],
    local: [[f32; 4]; 3],
    sun_upper: [f32; 4],
    sun_lower: [f32; 4],
    ground: [f32; 4],
    display: [f32; 4],
    debug: [f32; 4],
}

/// `AerialUniform` of `aerial.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct AerialUniform {
    coefficients: [[[f32; 4]; TERMS]; MAX_LAYERS],
    altitude_km: [f32; MAX_LAYERS],
    per_km: [[f32; 4]; 4],
    weights: [[f32; 4]; 4],
    levels: [[f32; 4]; LEVELS],
    counts: [f32; 4],
    sun: [f32; 4],
}

/// `ViewUniform` of `sky.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct ViewUniform {
    pub(crate) clip_to_world: Mat4,
    pub(crate) world_to_clip: Mat4,
    pub(crate) kind: [f32; 4],
    pub(crate) viewport: [f32; 4],
    pub(crate) dome: [f32; 4],
}

/// How light becomes a pixel of the target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DisplaySettings {
    /// Multiplies light \[m²·cd⁻¹\].
    pub(crate) exposure: f32,
    /// Number of the tone curve.
    pub(crate) tone: f32,
    /// One over the target's levels; 0 for none.
    pub(crate) dither: f32,
    /// Whether the target encodes by itself.
    pub(crate) target_encodes: bool,
}

impl SkyUniform {
    /// From a picture, the frame's axes in the world and the display. `baked_scale` brings light into
    /// the range of half floats.
    #[must_use]
    pub(crate) fn new(
        picture: &Picture,
        [x, y, z]: [Vec3; 3],
        display: DisplaySettings,
        baked_scale: f32,
        outside_domain: bool,
    ) -> Self {
        let coefficients = *picture.sky.coefficients();
        let radii = picture.sky.radii();
        let [sin_sun, cos_sun] = picture.sky.sun();
        let sun = &picture.sun;
        let with = |[r, g, b]: [f32; 3], w: f32| [r, g, b, w];
        let flag = |on: bool| f32::from(u8::from(on));
        Self {
            coefficients,
            radii: [
                radii.scale_heights[0],
                radii.scale_heights[1],
                radii.roots[0],
                radii.roots[1],
            ],
            place: [
                sin_sun,
                cos_sun,
                picture.sky.cos_horizon(),
                picture.altitude_km,
            ],
            local: [x, y, z].map(|axis| axis.extend(0.0).to_array()),
            sun_upper: with(sun.upper, sun.cosines[0]),
            sun_lower: with(sun.lower, sun.cosines[1]),
            ground: with(picture.light.ground, sun.sin_radius),
            display: [
                display.exposure,
                display.tone,
                display.dither,
                flag(display.target_encodes),
            ],
            debug: [
                flag(outside_domain),
                baked_scale,
                baked_scale.recip(),
                picture.sky.cos_lowest(),
            ],
        }
    }
}

impl AerialUniform {
    /// From the frame.
    #[must_use]
    pub(crate) fn new(air: &AerialFrame) -> Self {
        let layers = u16::try_from(air.layers).map_or(0.0, f32::from);
        Self {
            coefficients: air.coefficients,
            altitude_km: air.altitude_km,
            per_km: air.per_km,
            weights: air.weights,
            levels: air.levels,
            counts: [
                layers,
                air.haze_per_scale_height,
                SECTIONS.into(),
                f32::from(SECTIONS) + 3.0,
            ],
            sun: [air.sun[0], air.sun[1], 0.0, 0.0],
        }
    }
}
