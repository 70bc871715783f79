//! An atmosphere over ground of one albedo.

use super::air::Air;
use super::diffuse::{FieldLight, Series};
use super::field::Source;
use super::settings::{TransportError, TransportSettings, check_albedo};
use super::view::{Eye, Sight};
use crate::optics::OpticalProfile;
use sky_core::direction::SkyDirection;
use sky_core::quantity::{Angle, Length};

/// A solved atmosphere over ground of one albedo: answers for any observer, sun and direction.
#[derive(Clone, Debug)]
pub struct Transport {
    air: Air,
    /// Ground albedo over π \[sr⁻¹\].
    reflectance: f64,
    source: Source,
    orders: usize,
    /// The series was cut after single scattering.
    is_single: bool,
}

impl Transport {
    /// Solves for the diffuse field of an atmosphere over ground of a given albedo. The ground lies at
    /// the profile's lowest level.
    ///
    /// # Errors
    /// Refuses malformed tables and albedos outside 0..1; reports a series that does not converge.
    pub fn solve(
        optics: &OpticalProfile,
        ground_albedo: f64,
        settings: &TransportSettings,
    ) -> Result<Self, TransportError> {
        Self::check(ground_albedo)?;
        let air = Air::new(optics, settings)?;
        let reflectance = ground_albedo / core::f64::consts::PI;
        let rings = air.diffuse.rings(settings);
        let Series { total, orders } = air.diffuse.of_sun(&rings, reflectance, settings)?;
        Ok(Self {
            air,
            reflectance,
            source: Source::new(total),
            orders,
            is_single: settings.last_order == Some(1),
        })
    }

    /// Checks an albedo without solving.
    ///
    /// # Errors
    /// Refuses albedos outside 0..1.
    pub fn check(ground_albedo: f64) -> Result<(), TransportError> {
        check_albedo(ground_albedo)
    }

    /// Orders of scattering that were summed; the rest of the series is extrapolated.
    #[must_use]
    pub const fn orders(&self) -> usize {
        self.orders
    }

    /// Radiance per unit solar irradiance \[sr⁻¹\] at each wavelength of the profile, entry
    /// `direction * wavelengths + wavelength`.
    ///
    /// Azimuth is relative to the sun. Directions below the geometric horizon end on the ground. An
    /// observer above the air sees what enters it from there; one below the ground stands on it.
    #[must_use]
    pub fn radiance_ratio(
        &self,
        observer_altitude: Length,
        sun_zenith: Angle,
        directions: &[SkyDirection],
    ) -> Vec<f64> {
        self.collect(observer_altitude, sun_zenith, directions, !self.is_single)
    }

    /// First order of scattering alone (sun → air → eye and sun → ground → eye), same layout.
    #[must_use]
    pub fn single_scattering_ratio(
        &self,
        observer_altitude: Length,
        sun_zenith: Angle,
        directions: &[SkyDirection],
    ) -> Vec<f64> {
        self.collect(observer_altitude, sun_zenith, directions, false)
    }

    fn collect(
        &self,
        observer_altitude: Length,
        sun_zenith: Angle,
        directions: &[SkyDirection],
        diffuse: bool,
    ) -> Vec<f64> {
        let sights: Vec<Sight> = directions.iter().copied().map(Sight::whole).collect();
        let light = FieldLight {
            source: &self.source,
            reflectance: self.reflectance,
        };
        let lights = if diffuse { &[light][..] } else { &[] };
        let eye = Eye {
            altitude: observer_altitude,
            sun_zenith,
        };
        let seen = self.air.look(eye, &sights, self.reflectance, lights);
        let mut radiance = seen.once;
        for diffuse in &seen.diffuse {
            for (sum, light) in radiance.iter_mut().zip(diffuse) {
                *sum += light;
            }
        }
        radiance
    }
}
