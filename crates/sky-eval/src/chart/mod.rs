//! The chart: speed against accuracy of every sky, measured in one run on one machine.
//!
//! Error is taken against the transport engine on a fixed set of cases that no table was fitted to
//! alone; a model is scored only where it claims to be valid, and the share of cases it covers is
//! told. GPU costs are handed in: those of a fragment shader over a full picture, beside the floor of a
//! constant color.

pub mod measure;
pub mod offline;
pub mod page;
pub mod rows;
