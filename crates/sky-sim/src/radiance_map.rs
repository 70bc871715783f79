//! Spectral radiance over a set of directions.

use sky_core::direction::SkyDirection;

/// Spectral radiance by direction and wavelength.
#[derive(Clone, Debug, PartialEq)]
pub struct RadianceMap {
    /// Directions of view.
    pub directions: Vec<SkyDirection>,
    /// Wavelengths \[nm\].
    pub wavelength_nm: Vec<f64>,
    /// Spectral radiance \[W·m⁻²·sr⁻¹·nm⁻¹\], entry `direction * wavelength_nm.len() + wavelength`.
    pub spectral_radiance: Vec<f64>,
}
