//! The commands: one file each, with its arguments, its `run` and its tests.

pub mod atlas;
pub mod beam;
pub mod bench_gpu;
pub mod chart;
pub mod export_shaders;
pub mod fit_stress;
pub mod gallery;
pub mod generate;
pub mod light;
pub mod lut;
pub mod map;
pub mod models;
pub mod optics;
pub mod plan;
pub mod profile;
pub mod render;
pub mod report;
pub mod segment;
pub mod sky;
pub mod view;
