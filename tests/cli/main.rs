//! The command line: contracts, bad input, interruption, windows; and the walls of ARCHITECTURE.md.

mod bad_input;
mod chart;
mod commands;
mod faults;
mod interruption;
mod lut;
mod plan;
mod runtime;
mod support;
mod view;
mod walls;

#[path = "../support/lut.rs"]
mod lut_support;

#[path = "../support/source.rs"]
mod source;
