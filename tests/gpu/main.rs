//! What is drawn: shaders against their Rust twins, pictures against those that were looked at. Needs a
//! Vulkan driver; a software one will do.

mod baseline_twins;
mod engine;
mod faults;
mod golden;
mod long_use;
mod pixels;
mod shaders;
mod twins;
