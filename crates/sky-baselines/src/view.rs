//! From conditions and directions to vectors, and from colors back to Yxy.

use sky_core::color::Yxy;
use sky_core::color::{Xyz, yxy_from_xyz};
use sky_core::conditions::Conditions;
use sky_core::direction::SkyDirection;

use crate::texture::single;

/// Unit vector of a direction: z up, x towards the sun's azimuth.
#[inline]
pub(crate) fn unit_vector(direction: &SkyDirection) -> [f32; 3] {
    let (sin_view, cos_view) = single(direction.view_zenith.radians()).sin_cos();
    let (sin_azimuth, cos_azimuth) = single(direction.relative_azimuth.radians()).sin_cos();
    [sin_view * cos_azimuth, sin_view * sin_azimuth, cos_view]
}

/// Sine and cosine of the sun's zenith angle.
pub(crate) fn sun(conditions: &Conditions) -> [f32; 2] {
    let (sin, cos) = conditions.sun_zenith.radians().sin_cos();
    [single(sin), single(cos)]
}

/// Cosine of the angle between a direction and the sun.
#[inline]
pub(crate) fn cos_gamma([sin_sun, cos_sun]: [f32; 2], v: [f32; 3]) -> f32 {
    (v[0] * sin_sun + v[2] * cos_sun).clamp(-1.0, 1.0)
}

/// The angle itself and its cosine; from cross and dot, so that it holds close to the sun.
#[inline]
pub(crate) fn gamma([sin_sun, cos_sun]: [f32; 2], v: [f32; 3]) -> (f32, f32) {
    let dot = v[0] * sin_sun + v[2] * cos_sun;
    let cross = [
        v[1] * cos_sun,
        v[2] * sin_sun - v[0] * cos_sun,
        v[1] * sin_sun,
    ];
    let length = (cross[0] * cross[0] + cross[1] * cross[1] + cross[2] * cross[2]).sqrt();
    (length.atan2(dot), dot.clamp(-1.0, 1.0))
}

/// Product of a matrix and a vector.
#[inline]
pub(crate) fn multiply(matrix: &[[f32; 3]; 3], v: [f32; 3]) -> [f32; 3] {
    matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

pub(crate) fn yxy([x, y, z]: [f32; 3]) -> Yxy {
    yxy_from_xyz(Xyz {
        x: x.into(),
        y: y.into(),
        z: z.into(),
    })
}

/// The light from each direction, given as a unit vector.
pub(crate) fn each(directions: &[SkyDirection], light: impl Fn([f32; 3]) -> [f32; 3]) -> Vec<Yxy> {
    directions
        .iter()
        .map(|d| yxy(light(unit_vector(d))))
        .collect()
}

/// Three values and a fourth, as a uniform.
pub(crate) const fn uniform(v: [f32; 3], last: f32) -> [f32; 4] {
    [v[0], v[1], v[2], last]
}

/// Cosines of view zenith angles below this are under the horizontal: 90° in `f32` is not quite 0.
pub(crate) const HORIZONTAL: f32 = -1e-6;
