//! The transport engine: spectral sky radiance in a spherical atmosphere, every order of scattering.
//!
//! Single scattering is integrated exactly along straight rays through curved shells, with the full
//! phase functions and the Earth's shadow. Higher orders come from a diffuse field on a grid of
//! shells and local sun zenith angles, found by successive orders: each order is the formal solution
//! along rays in a fixed set of directions (no approximation of flat layers), stored as moments of
//! spherical harmonics. The ground is Lambertian; its light counts. Deterministic.
//!
//! Not modeled: refraction, polarization, horizontal variation of the air, the sun's disc.

mod air;
mod any_ground;
mod diffuse;
mod fan;
mod field;
mod lanes;
mod medium;
mod one_ground;
mod path;
mod settings;
mod sphere;
mod spread;
mod sun;
mod sunlit;
mod template;
mod view;

pub use any_ground::{AnyGround, LightParts};
pub use one_ground::Transport;
pub use settings::{TransportError, TransportSettings};
pub use view::Sight;
