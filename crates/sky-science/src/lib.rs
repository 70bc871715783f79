//! What the offline crates of the UTM sky model share: spectra and the CIE's observer, how far two
//! skies differ, the one interface of every sky, and Perez's formula.
//!
//! Purpose: the vocabulary of simulation, fit, published models and their comparison. A flight
//! simulator needs none of it and links `sky-core` alone. Pure functions: no files, no threads.
//! Out of scope: radiative transfer (`sky-sim`), fitting (`sky-fit`).

pub mod cie;
pub mod direction;
pub mod lagrange;
pub mod metrics;
pub mod perez;
pub mod perez_sky;
pub mod phase;
pub mod shader_sky;
pub mod sky_model;
pub mod spectrum;
pub mod table_sky;
pub mod utm2005;
