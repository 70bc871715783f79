//! From a sky to Perez coefficients and a look-up table.
//!
//! Purpose: fits anything that can be sampled. Simplifications: one channel at a time, one formula.
//! Out of scope: where the sky comes from (`sky-sim`), files, terminals.

pub mod problem;
pub mod solve;

pub mod banded;
pub mod sweep;
