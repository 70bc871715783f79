//! Where one looks and where the sun stands: view directions, the scattering angle, the horizon.
//!
//! Directions point from the observer. Zenith angles may exceed 90°: at altitude the sky goes on
//! down to the geometric horizon.

use crate::quantity::{Angle, EARTH_RADIUS_KM, Length, single};

/// A direction of view: zenith angle, and azimuth relative to the sun (0 faces the sun).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkyDirection {
    /// Angle from the zenith, 0–180°.
    pub view_zenith: Angle,
    /// View azimuth minus sun azimuth; the sky is symmetric, so the sign does not matter.
    pub relative_azimuth: Angle,
}

impl SkyDirection {
    /// From degrees.
    #[must_use]
    pub const fn from_degrees(view_zenith_deg: f64, relative_azimuth_deg: f64) -> Self {
        Self {
            view_zenith: Angle::from_degrees(view_zenith_deg),
            relative_azimuth: Angle::from_degrees(relative_azimuth_deg),
        }
    }

    /// From a vector of any length, as [`Self::unit_vector`] has it.
    #[must_use]
    pub fn from_vector([x, y, z]: [f64; 3]) -> Self {
        Self {
            view_zenith: Angle::from_radians(x.hypot(y).atan2(z)),
            relative_azimuth: Angle::from_radians(y.atan2(x)),
        }
    }

    /// As a unit vector: z points up, the sun stands in the plane of x and z, on the side of
    /// positive x.
    #[must_use]
    pub fn unit_vector(&self) -> [f32; 3] {
        let (sin_view, cos_view) = single(self.view_zenith.radians()).sin_cos();
        let (sin_azimuth, cos_azimuth) = single(self.relative_azimuth.radians()).sin_cos();
        [sin_view * cos_azimuth, sin_view * sin_azimuth, cos_view]
    }

    /// Cosine of the scattering angle γ between this direction and the sun.
    #[must_use]
    pub fn cos_scattering_angle(&self, sun_zenith: Angle) -> f64 {
        let (sin_v, cos_v) = self.view_zenith.radians().sin_cos();
        let (sin_s, cos_s) = sun_zenith.radians().sin_cos();
        (cos_v * cos_s + sin_v * sin_s * self.relative_azimuth.radians().cos()).clamp(-1.0, 1.0)
    }

    /// Scattering angle γ between this direction and the sun, exact for small angles too.
    #[must_use]
    pub fn scattering_angle(&self, sun_zenith: Angle) -> Angle {
        let (sin_v, cos_v) = self.view_zenith.radians().sin_cos();
        let (sin_s, cos_s) = sun_zenith.radians().sin_cos();
        let (sin_a, cos_a) = self.relative_azimuth.radians().sin_cos();
        // |view × sun| and view · sun
        let cross_x = sin_v * sin_a * cos_s;
        let cross_y = cos_v * sin_s - sin_v * cos_a * cos_s;
        let cross_z = -sin_v * sin_a * sin_s;
        let cross = (cross_x * cross_x + cross_y * cross_y + cross_z * cross_z).sqrt();
        Angle::from_radians(cross.atan2(cos_v * cos_s + sin_v * sin_s * cos_a))
    }
}

/// Depression of the geometric horizon below the horizontal plane, for an observer above the sphere.
#[must_use]
pub fn horizon_dip(observer_altitude: Length) -> Angle {
    let h = observer_altitude.km().max(0.0);
    // tan(dip) = sqrt((r - R)(r + R)) / R keeps its precision at metres of altitude.
    Angle::from_radians(
        (h * (h + 2.0 * EARTH_RADIUS_KM))
            .sqrt()
            .atan2(EARTH_RADIUS_KM),
    )
}

/// Zenith angle of the geometric horizon.
#[must_use]
pub fn horizon_zenith(observer_altitude: Length) -> Angle {
    Angle::from_radians(core::f64::consts::FRAC_PI_2 + horizon_dip(observer_altitude).radians())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scattering_angle_agrees_with_its_cosine_and_keeps_small_angles() {
        let sun = Angle::from_degrees(60.0);
        for (z, a) in [(0.0, 0.0), (60.0, 10.0), (85.0, 170.0), (95.0, 90.0)] {
            let d = SkyDirection::from_degrees(z, a);
            let gamma = d.scattering_angle(sun).radians();
            assert!((gamma.cos() - d.cos_scattering_angle(sun)).abs() < 1e-14);
        }
        let near = SkyDirection::from_degrees(60.0 + 1e-6, 0.0);
        assert!((near.scattering_angle(sun).degrees() - 1e-6).abs() < 1e-12);
    }

    #[test]
    fn horizon_dip_matches_the_closed_form() {
        for (km, deg) in [(6.0, 2.486), (12.0, 3.514), (30.0, 5.549)] {
            assert!((horizon_dip(Length::from_km(km)).degrees() - deg).abs() < 2e-3);
        }
        assert!(horizon_dip(Length::ZERO).radians().abs() < 1e-15);
    }
}
