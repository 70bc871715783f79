//! Both engines on any air: air, observer and sun in, radiance out.

use anyhow::{Result, bail};
use sky_core::direction::SkyDirection;
use sky_core::quantity::{Angle, Length};
use sky_sim::optics::{OpticalProfile, OpticsSettings};
use sky_sim::profile::AtmosphereProfile;
use sky_sim::smarts::SmartsSky;
use sky_sim::solar::SolarSpectrum;
use sky_sim::transport::{Transport, TransportSettings};

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

/// The transport engine's radiance per unit of extraterrestrial solar irradiance \[sr⁻¹\], entry
/// `direction * wavelengths + wavelength`.
///
/// # Errors
/// When the optics cannot be built or the engine gives up.
pub fn transport(air: &Air, scene: Scene, directions: &[SkyDirection]) -> Result<Vec<f64>> {
    let built;
    let optics = match air {
        Air::Optics(optics) => optics,
        Air::Profile { profile, settings } => {
            built = OpticalProfile::build(profile, settings)?;
            &built
        }
    };
    optics.check_observer(scene.observer_altitude)?;
    let solved = Transport::solve(optics, scene.ground_albedo, &TransportSettings::default())?;
    Ok(solved.radiance_ratio(scene.observer_altitude, scene.sun_zenith, directions))
}
