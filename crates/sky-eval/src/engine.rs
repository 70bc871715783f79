//! Both engines on any air: air, observer and sun in, radiance out.

use anyhow::{Result, bail};
use sky_core::direction::SkyDirection;
use sky_core::quantity::{Angle, EARTH_RADIUS_KM, Length};
use sky_sim::optics::{OpticalProfile, OpticsSettings};
use sky_sim::profile::AtmosphereProfile;
use sky_sim::smarts::SmartsSky;
use sky_sim::solar::SolarSpectrum;
use sky_sim::transport::{AnyGround, Sight, Transport, TransportSettings};

/// The air that an engine works on.
#[derive(Debug)]
pub enum Air {
    /// A profile, and what to build from it.
    Profile {
        /// The profile.
        profile: Box<AtmosphereProfile>,
        /// Constituents, haze, wavelengths.
        settings: OpticsSettings,
    },
    /// Optics made elsewhere.
    Optics(OpticalProfile),
}

impl Air {
    /// The wavelengths of the answer \[nm\].
    #[must_use]
    pub fn wavelength_nm(&self) -> &[f64] {
        match self {
            Self::Profile { settings, .. } => &settings.wavelength_nm,
            Self::Optics(optics) => &optics.wavelength_nm,
        }
    }
}

/// Observer, sun and ground.
#[derive(Clone, Copy, Debug)]
pub struct Scene {
    /// Altitude of the observer above mean sea level.
    pub observer_altitude: Length,
    /// Zenith angle of the sun.
    pub sun_zenith: Angle,
    /// Albedo of the ground.
    pub ground_albedo: f64,
}

/// The parametric engine's radiance per unit of extraterrestrial solar irradiance \[sr⁻¹\], entry
/// `direction * wavelengths + wavelength`.
///
/// # Errors
/// When the air is optics made elsewhere, which it cannot use, or the settings do not suit the profile.
pub fn smarts(air: &Air, scene: Scene, directions: &[SkyDirection]) -> Result<Vec<f64>> {
    let Air::Profile { profile, settings } = air else {
        bail!("--engine: expected transport with --optics, found smarts");
    };
    let unit_sun = SolarSpectrum {
        irradiance_w_m2_nm: vec![1.0; settings.wavelength_nm.len()],
        wavelength_nm: settings.wavelength_nm.clone(),
    };
    let sky = SmartsSky::new(profile, settings, scene.ground_albedo)?.with_sun(&unit_sun)?;
    let map = sky.radiance(scene.observer_altitude, scene.sun_zenith, directions)?;
    Ok(map.spectral_radiance)
}

/// What the air of finite paths takes and adds; tables are `[path * wavelengths + wavelength]`.
#[derive(Clone, Debug, PartialEq)]
pub struct PathLight {
    /// Transmittance.
    pub transmittance: Vec<f64>,
    /// In-scattered radiance per unit of extraterrestrial solar irradiance \[sr⁻¹\].
    pub inscatter: Vec<f64>,
}

/// The air's optics above the ground of an observer: at 0 km, or at the observer's feet if they are
/// lower.
fn optics_over_ground(air: &Air, scene: Scene) -> Result<OpticalProfile> {
    let built;
    let optics = match air {
        Air::Optics(optics) => optics,
        Air::Profile { profile, settings } => {
            built = OpticalProfile::build(profile, settings)?;
            &built
        }
    };
    let ground_km = scene.observer_altitude.km().min(0.0);
    let optics = optics.down_to(Length::from_km(ground_km))?;
    optics.check_observer(scene.observer_altitude)?;
    Ok(optics)
}

/// How far below the ground of a scene a path leads, if it does: the ground lies at 0 km, or at the
/// observer's feet if they are lower.
#[must_use]
pub fn depth_under_ground(scene: Scene, path: &Sight) -> Option<Length> {
    let altitude_km = scene.observer_altitude.km();
    let radius = EARTH_RADIUS_KM + altitude_km;
    let cosine = path.direction.view_zenith.radians().cos();
    let length = path.length.map_or(f64::INFINITY, Length::km);
    let lowest = (-radius * cosine).clamp(0.0, length);
    // (r − R)(r + R) keeps meters at thousands of kilometers
    let square =
        altitude_km * (radius + EARTH_RADIUS_KM) + lowest * (lowest + 2.0 * radius * cosine);
    let there = (radius * radius + lowest * (lowest + 2.0 * radius * cosine)).sqrt();
    let depth_km = altitude_km.min(0.0) - square / (there + EARTH_RADIUS_KM);
    (depth_km > 0.0).then(|| Length::from_km(depth_km))
}

/// The transport engine's light of finite paths.
///
/// # Errors
/// When the optics cannot be built or the engine gives up.
pub fn transport_paths(air: &Air, scene: Scene, paths: &[Sight]) -> Result<PathLight> {
    let optics = optics_over_ground(air, scene)?;
    let solved = AnyGround::solve(&optics, &TransportSettings::default())?;
    let light = solved.light(scene.observer_altitude, scene.sun_zenith, paths)?;
    Ok(PathLight {
        inscatter: light.inscatter(scene.ground_albedo)?,
        transmittance: light.transmittance,
    })
}

/// The transport engine's radiance per unit of extraterrestrial solar irradiance \[sr⁻¹\], entry
/// `direction * wavelengths + wavelength`.
///
/// # Errors
/// When the optics cannot be built or the engine gives up.
pub fn transport(air: &Air, scene: Scene, directions: &[SkyDirection]) -> Result<Vec<f64>> {
    let optics = optics_over_ground(air, scene)?;
    let solved = Transport::solve(&optics, scene.ground_albedo, &TransportSettings::default())?;
    Ok(solved.radiance_ratio(scene.observer_altitude, scene.sun_zenith, directions))
}
