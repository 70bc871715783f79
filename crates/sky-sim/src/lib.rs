//! From an atmosphere profile to spectral sky radiance.
//!
//! Profile → optics per level and wavelength → radiance by direction, with two engines: spherical
//! multiple scattering (`transport`) and closed forms (`smarts`). Out of scope: files, refraction,
//! polarization, clouds, the sun's disc.

pub mod aerosol;
pub mod gases;
pub mod optics;
pub mod ozone;
pub mod plane_parallel;
pub mod profile;
mod quadrature;
pub mod radiance_map;
pub mod rayleigh;
pub mod smarts;
pub mod solar;
pub mod table;
pub mod transport;
