//! The transport engine: spectral sky radiance in a spherical atmosphere, every order of scattering.
//!
//! Single scattering is integrated exactly along straight rays through curved shells, with the full
//! phase functions and the Earth's shadow. Higher orders come from a diffuse field on a grid of
//! shells and local sun zenith angles, found by successive orders: each order is the formal solution
//! along rays in a fixed set of directions (no approximation of flat layers), stored as moments of
//! spherical harmonics. The ground is Lambertian; its light counts. Deterministic.
//!
//! Not modeled: refraction, polarization, horizontal variation of the air, the sun's disc.

mod any_ground;
mod diffuse;
mod fan;
mod field;
mod lanes;
mod medium;
mod path;
mod sphere;
mod spread;
mod sun;
mod sunlit;
mod template;
mod view;

pub use any_ground::{AnyGround, LightParts};
pub use view::Sight;

use crate::optics::OpticalProfile;
use diffuse::{Diffuse, FieldLight, Series};
use field::Source;
use path::Sampling;
use sky_core::direction::SkyDirection;
use sky_core::quantity::{Angle, Length};
use spread::Spread;
use sunlit::Sunlit;

/// What the transport engine refuses.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum TransportError {
    /// Fewer than two levels, or tables of the wrong length.
    #[error("optical profile: expected at least 2 levels and full tables, found {levels} levels")]
    Shape {
        /// Number of levels found.
        levels: usize,
    },
    /// The ground reflects a share between 0 and 1.
    #[error("ground albedo: expected 0..1, found {0}")]
    Albedo(f64),
    /// The observer is below the ground.
    #[error("observer altitude [km]: expected at least {ground_km}, found {found}")]
    BelowGround {
        /// Altitude of the ground \[km\].
        ground_km: f64,
        /// Altitude of the observer \[km\].
        found: f64,
    },
    /// The series of orders does not converge in the orders allowed.
    #[error(
        "multiple scattering: order {orders} still adds {share:.1e} of the field, expected below {expected:.1e}"
    )]
    NotConverged {
        /// Orders computed.
        orders: usize,
        /// Share of the field that the last one added.
        share: f64,
        /// Share at which the engine would have stopped.
        expected: f64,
    },
}

/// How finely the transport equation is solved.
#[derive(Clone, Debug, PartialEq)]
pub struct TransportSettings {
    /// Highest degree of spherical harmonics of the diffuse source; `None` chooses by the haze.
    pub degree: Option<usize>,
    /// Gauss points in zenith: from the zenith to 78°, from there to the horizon, below the horizon.
    pub zenith_points: [usize; 3],
    /// Directions in azimuth over half the circle.
    pub azimuth_points: usize,
    /// Most orders of scattering.
    pub most_orders: usize,
    /// The series stops when what remains is below this share of the field everywhere.
    pub tolerance: f64,
    /// Cuts the series after this order, 1 being single scattering: to ask what the others are worth.
    pub last_order: Option<usize>,
    /// Altitudes of the shells of the diffuse field \[km\]; those above the profile's top are dropped.
    pub shells_km: Vec<f64>,
    /// Local sun zenith angles of the diffuse field \[deg\].
    pub columns_deg: Vec<f64>,
}

impl Default for TransportSettings {
    fn default() -> Self {
        Self {
            degree: None,
            zenith_points: [6, 8, 4],
            azimuth_points: 8,
            most_orders: 60,
            tolerance: 2e-3,
            last_order: None,
            shells_km: vec![
                0.0, 0.1, 0.3, 0.6, 1.0, 1.5, 2.1, 2.9, 4.0, 5.5, 7.5, 10.0, 12.5, 15.5, 19.0,
                23.0, 27.0, 32.0, 38.0, 46.0, 56.0, 70.0, 100.0,
            ],
            columns_deg: vec![
                0.0, 15.0, 30.0, 45.0, 57.0, 66.0, 73.0, 78.5, 82.5, 85.5, 87.5, 89.0, 90.5, 92.0,
                93.5, 95.0, 96.5, 98.0, 100.0, 102.5, 106.0,
            ],
        }
    }
}

/// Thickest segment of an observer's path, as a fraction of (altitude + 4 km).
const VIEW_SHELLS: f64 = 0.2;
/// Sampling of an observer's rays.
const VIEW_SAMPLING: Sampling = Sampling {
    depth: 0.8,
    rise: 0.4,
    turn: 0.01,
    opaque: 14.0,
};
/// Harmonics beyond this degree are not used.
const HIGHEST_DEGREE: usize = 12;

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

/// An atmosphere laid out for rays, and what it takes to solve it and to look through it.
#[derive(Clone, Debug)]
struct Air {
    /// At every wavelength of the profile.
    direct: Sunlit,
    /// At the wavelengths that the diffuse light is solved for.
    diffuse: Diffuse,
    spread: Spread,
    view_shells: Vec<f64>,
}

impl Air {
    fn new(optics: &OpticalProfile, settings: &TransportSettings) -> Result<Self, TransportError> {
        let (levels, wavelengths) = (optics.altitude_km.len(), optics.wavelength_nm.len());
        let tables = [
            &optics.rayleigh_scattering_per_km,
            &optics.gas_absorption_per_km,
            &optics.aerosol_scattering_per_km,
            &optics.aerosol_absorption_per_km,
            &optics.aerosol_g,
            &optics.aerosol_g2,
            &optics.aerosol_g_weight,
        ];
        if levels < 2 || wavelengths == 0 || tables.iter().any(|t| t.len() != levels * wavelengths)
        {
            return Err(TransportError::Shape { levels });
        }
        let spread = Spread::new(optics);
        let direct = Sunlit::new(optics);
        let sunlit = spread.coarse(optics).map_or_else(
            || direct.clone(),
            |(coarse, wavelengths)| Sunlit {
                medium: medium::Medium::new(&coarse),
                sun: direct.sun.pick(wavelengths),
            },
        );
        Ok(Self {
            diffuse: Diffuse::new(sunlit, settings),
            view_shells: direct.medium.segment_levels(VIEW_SHELLS),
            direct,
            spread,
        })
    }

    /// Refuses an observer below the ground.
    fn check_altitude(&self, observer_altitude: Length) -> Result<(), TransportError> {
        let (ground_km, found) = (self.direct.medium.ground_km(), observer_altitude.km());
        if found >= ground_km {
            Ok(())
        } else {
            Err(TransportError::BelowGround { ground_km, found })
        }
    }

    fn wavelengths(&self) -> usize {
        self.direct.medium.wavelengths
    }
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
        if (0.0..=1.0).contains(&ground_albedo) {
            Ok(())
        } else {
            Err(TransportError::Albedo(ground_albedo))
        }
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
        let eye = view::Eye {
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
