//! What a sky gives to a graphics card, so that every sky is drawn and timed by one harness.
//!
//! The portable subset: uniforms of four `f32`, one 2D texture, no storage buffers, no compute. Out
//! of scope: pipelines, adapters, pixels.

use sky_core::conditions::{Conditions, OutsideDomain};

use crate::sky_model::SkyModel;

/// Vectors of four `f32` in the uniform buffer.
pub const SHADER_UNIFORMS: usize = 96;

/// Declarations that a harness puts in front of [`ShaderSky::shader`]. The sampler is linear and
/// clamps. `direction` is a unit vector in the observer's frame: z up, the sun in the x-z plane at
/// azimuth 0, so that x points towards the sun's azimuth.
pub const SHADER_HEADER: &str = "\
@group(0) @binding(0) var<uniform> baseline: array<vec4<f32>, 96>;
@group(0) @binding(1) var baseline_texture: texture_2d<f32>;
@group(0) @binding(2) var baseline_sampler: sampler;
";

/// A sky that can also be drawn on the GPU.
pub trait ShaderSky: SkyModel {
    /// WGSL text that defines `fn baseline_xyz(direction: vec3<f32>) -> vec3<f32>`: CIE XYZ of the
    /// light from a direction, Y in cd·m⁻². It may use what [`SHADER_HEADER`] declares.
    fn shader(&self) -> &'static str;

    /// What the shader needs for one frame.
    ///
    /// # Errors
    /// When the conditions lie outside the domain.
    fn shader_frame(&self, conditions: &Conditions) -> Result<ShaderFrame, OutsideDomain>;

    /// Bytes of the model's tables.
    fn table_bytes(&self) -> usize;

    /// Builds the tables that depend on the haze anew and keeps them for the frames to come; their
    /// bytes, 0 where there are none.
    fn rebuild(&self, _turbidity: f64) -> usize {
        0
    }
}

/// What a shader needs for one frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShaderFrame {
    /// The first vectors of the uniform buffer, at most [`SHADER_UNIFORMS`].
    pub uniforms: Vec<[f32; 4]>,
    /// The texture, where the model has one.
    pub texture: Option<ShaderTexture>,
}

/// A 2D texture. Every texel stays within the range of `f16`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShaderTexture {
    /// Texels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Texels, row by row, the first row at v = 0.
    pub texels: Vec<[f32; 4]>,
}
