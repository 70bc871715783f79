//! An atmosphere laid out for rays.

use super::diffuse::Diffuse;
use super::medium::Medium;
use super::path::VIEW_SHELLS;
use super::settings::{TransportError, TransportSettings};
use super::spread::Spread;
use super::sunlit::Sunlit;
use crate::optics::OpticalProfile;
use sky_core::quantity::Length;

/// An atmosphere laid out for rays, and what it takes to solve it and to look through it.
#[derive(Clone, Debug)]
pub(super) struct Air {
    /// At every wavelength of the profile.
    pub(super) direct: Sunlit,
    /// At the wavelengths that the diffuse light is solved for.
    pub(super) diffuse: Diffuse,
    pub(super) spread: Spread,
    pub(super) view_shells: Vec<f64>,
}

impl Air {
    pub(super) fn new(
        optics: &OpticalProfile,
        settings: &TransportSettings,
    ) -> Result<Self, TransportError> {
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
        let found = settings.columns_deg.len();
        if found < 4 {
            return Err(TransportError::Columns { found });
        }
        let spread = Spread::new(optics);
        let direct = Sunlit::new(optics);
        let sunlit = spread.coarse(optics).map_or_else(
            || direct.clone(),
            |(coarse, wavelengths)| Sunlit {
                medium: Medium::new(&coarse),
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
    pub(super) fn check_altitude(&self, observer_altitude: Length) -> Result<(), TransportError> {
        let (ground_km, found) = (self.direct.medium.ground_km(), observer_altitude.km());
        if found >= ground_km {
            Ok(())
        } else {
            Err(TransportError::BelowGround { ground_km, found })
        }
    }

    pub(super) fn wavelengths(&self) -> usize {
        self.direct.medium.wavelengths
    }
}
