//! The optical profile: what each constituent scatters and absorbs, per level and wavelength.

use serde::{Deserialize, Serialize};

/// Optical properties on levels × wavelengths; linear in altitude between levels.
///
/// Tables are stored level-major: entry `level * wavelength_nm.len() + wavelength`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OpticalProfile {
    /// Altitudes of the levels \[km\], ascending; the first is the ground.
    pub altitude_km: Vec<f64>,
    /// Wavelengths \[nm\], ascending.
    pub wavelength_nm: Vec<f64>,
    /// Rayleigh scattering coefficient \[km⁻¹\].
    pub rayleigh_scattering_per_km: Vec<f64>,
    /// Absorption coefficient of all gases \[km⁻¹\].
    pub gas_absorption_per_km: Vec<f64>,
    /// Aerosol scattering coefficient \[km⁻¹\].
    pub aerosol_scattering_per_km: Vec<f64>,
    /// Aerosol absorption coefficient \[km⁻¹\].
    pub aerosol_absorption_per_km: Vec<f64>,
    /// Asymmetry parameter of the first Henyey–Greenstein term.
    pub aerosol_g: Vec<f64>,
    /// Asymmetry parameter of the second Henyey–Greenstein term.
    pub aerosol_g2: Vec<f64>,
    /// Weight of the first term (1: a single Henyey–Greenstein function).
    pub aerosol_g_weight: Vec<f64>,
    /// Depolarization of the Rayleigh phase function, one value for all wavelengths.
    pub rayleigh_depolarization: f64,
}
