//! Vocabulary, color, the sky formula and the look-up table of the UTM sky model.
//!
//! Purpose: what a flight simulator links, and what every other crate speaks. Pure functions: no
//! files, no threads, no clock. Out of scope: radiative transfer (`sky-sim`), fitting (`sky-fit`),
//! pixels (`sky-gpu`).

pub mod aerial;
pub mod air_mass;
pub mod axis;
pub mod color;
pub mod conditions;
pub mod direction;
pub mod extended;
pub mod extinction;
pub mod haze;
pub mod hdr;
pub mod light;
pub mod lut;
pub mod picture;
pub mod quantity;
pub mod solar_position;
pub mod sun;
pub mod tonemap;
pub mod uniforms;
pub mod utm_sky;
