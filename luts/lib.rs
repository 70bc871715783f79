//! The look-up tables of the UTM sky model as bytes; `sky-core` reads them.
//!
//! How each was made stands in the README beside it.

/// `default.utmlut`: the general atmosphere, 0–30 km, turbidity 1–8, sun zenith 0–96°.
pub const DEFAULT: &[u8] = include_bytes!("default.utmlut");
