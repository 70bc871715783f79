//! Straight rays over the sphere: where they leave the air or meet the ground, and how high they run.
//!
//! In `f64` for what is computed ahead, in `f32` for what runs for every direction, whose shader twins
//! do the same. None divides by what vanishes at the horizontal, none subtracts two radii.

use sky_core::quantity::EARTH_RADIUS_KM;

use crate::atmosphere::TOP_KM;
use crate::texture::single;

/// Length of the ray that touches the ground, from there to the top \[km\].
pub(crate) fn horizon_to_top_km() -> f64 {
    horizon_km(TOP_KM)
}

/// Length of the ray that touches the ground, from there to an altitude \[km\].
pub(crate) fn horizon_km(altitude_km: f64) -> f64 {
    (altitude_km * (2.0 * EARTH_RADIUS_KM + altitude_km)).sqrt()
}

/// Radius of the Earth \[km\].
pub(crate) const EARTH_RADIUS: f32 = single(EARTH_RADIUS_KM);

/// A ray from an altitude: where it leaves the atmosphere or meets the ground, and the altitude and
/// local vertical along it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ray {
    altitude_km: f64,
    radius_km: f64,
    cos_zenith: f64,
}

impl Ray {
    pub(crate) fn new(altitude_km: f64, cos_zenith: f64) -> Self {
        Self {
            altitude_km,
            radius_km: EARTH_RADIUS_KM + altitude_km,
            cos_zenith,
        }
    }

    /// Altitude of the lowest point of the whole line \[km\]; negative where it meets the ground.
    fn lowest_km(&self) -> f64 {
        let mu = self.cos_zenith;
        let sin = (1.0 - mu * mu).max(0.0).sqrt();
        self.altitude_km - self.radius_km * mu * mu / (1.0 + sin)
    }

    pub(crate) fn meets_ground(&self) -> bool {
        self.cos_zenith < 0.0 && self.lowest_km() < 0.0
    }

    /// Length up to the top of the atmosphere \[km\].
    pub(crate) fn to_top_km(self) -> f64 {
        self.to_sphere_km(TOP_KM, 1.0)
    }

    /// Length down to the ground \[km\].
    pub(crate) fn to_ground_km(self) -> f64 {
        self.to_sphere_km(0.0, -1.0)
    }

    fn to_sphere_km(self, altitude_km: f64, side: f64) -> f64 {
        let along = self.radius_km * self.cos_zenith;
        let rise = (altitude_km - self.altitude_km)
            * (2.0 * EARTH_RADIUS_KM + altitude_km + self.altitude_km);
        (-along + side * (along * along + rise).max(0.0).sqrt()).max(0.0)
    }

    /// Altitude \[km\] and radius \[km\] at a distance.
    #[inline]
    pub(crate) fn at(&self, distance_km: f64) -> [f64; 2] {
        let rise = distance_km * (2.0 * self.radius_km * self.cos_zenith + distance_km);
        let radius = (self.radius_km * self.radius_km + rise).sqrt();
        [self.altitude_km + rise / (self.radius_km + radius), radius]
    }

    /// Cosine of a far light's local zenith angle at a distance, from its cosine at the start and
    /// the cosine between ray and light.
    #[inline]
    pub(crate) fn cos_light(&self, distance_km: f64, radius_km: f64, start: f64, nu: f64) -> f64 {
        ((self.radius_km * start + distance_km * nu) / radius_km).clamp(-1.0, 1.0)
    }

    /// Cosine of the ray's own local zenith angle at a distance.
    #[inline]
    pub(crate) fn cos_zenith_at(&self, distance_km: f64, radius_km: f64) -> f64 {
        ((self.radius_km * self.cos_zenith + distance_km) / radius_km).clamp(-1.0, 1.0)
    }
}

/// Lowest altitude of the line through an observer \[km\].
#[inline]
pub(crate) fn lowest_km(altitude_km: f32, cos_view: f32) -> f32 {
    let radius = EARTH_RADIUS + altitude_km;
    let sine = (1.0 - cos_view * cos_view).max(0.0).sqrt();
    altitude_km - radius * cos_view * cos_view / (1.0 + sine)
}

/// Whether a direction lies below the geometric horizon; a metre is left to rounding.
#[inline]
pub(crate) fn meets_ground(altitude_km: f32, cos_view: f32) -> bool {
    cos_view < 0.0 && lowest_km(altitude_km, cos_view) < -1e-3
}

/// Length of a ray up to the top of the atmosphere \[km\].
#[inline]
pub(crate) fn to_top_km(altitude_km: f32, cos_zenith: f32) -> f32 {
    let top = single(TOP_KM);
    let along = (EARTH_RADIUS + altitude_km) * cos_zenith;
    let rise = (top - altitude_km) * (2.0 * EARTH_RADIUS + top + altitude_km);
    (along * along + rise.max(0.0)).sqrt() - along
}

/// Altitude and radius \[km\] at a distance along a ray.
#[inline]
pub(crate) fn point(altitude_km: f32, cos_zenith: f32, distance_km: f32) -> [f32; 2] {
    let start = EARTH_RADIUS + altitude_km;
    let rise = distance_km * (2.0 * start * cos_zenith + distance_km);
    let radius = (start * start + rise).sqrt();
    [altitude_km + rise / (start + radius), radius]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_know_ground_and_top() {
        let up = Ray::new(0.0, 1.0);
        assert!((up.to_top_km() - 100.0).abs() < 1e-9);
        let down = Ray::new(10.0, -1.0);
        assert!(down.meets_ground() && (down.to_ground_km() - 10.0).abs() < 1e-9);
        let level = Ray::new(0.0, 0.0);
        assert!(!level.meets_ground());
        let [altitude, radius] = level.at(100.0);
        assert!((altitude - (6371.0_f64.hypot(100.0) - 6371.0)).abs() < 1e-9);
        assert!((radius - 6371.0 - altitude).abs() < 1e-9);
    }
}
