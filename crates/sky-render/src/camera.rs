//! Where a camera looks: directions east, north, up from azimuths clockwise from north.

use glam::{Mat3, Vec3};
use sky_core::quantity::{Angle, single};

/// Whole numbers of pixels as a number.
#[must_use]
pub fn pixels(count: u32) -> f32 {
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
