//! From an atmosphere profile to spectral sky radiance.
//!
//! Profile → optics per level and wavelength → radiance by direction, with two engines: spherical
//! multiple scattering (`transport`) and closed forms (`smarts`). Out of scope: files, refraction,
//! polarization, clouds, the sun's disc.

pub mod optics;
pub mod radiance_map;
