//! The UTM sky model on the GPU: sky, sun, aerial perspective and scene light with wgpu.
//!
//! A [`SkyRenderer`] is made once for a device and a target format, updated once a frame, and draws
//! into any render pass; [`SkyRenderer::composite`] lays the air over a finished scene. What depends
//! on the frame alone is computed on the CPU (some microseconds) and lies in two uniforms. No global
//! state, no allocation in a frame. Lights are linear sRGB in cd/m². [`screen`] opens the device and the
//! pictures of a window that the caller has, [`headless`] those without one. What users copy is in
//! `examples/`: `minimal.rs` and `terrain.rs`.
//!
//! Simplifications: one sun zenith angle for all objects in view. Out of scope: clouds, shadows,
//! windows and their events.

pub mod camera;
pub mod headless;
mod renderer;
pub mod screen;
pub mod shader;
mod uniforms;

pub use camera::{Camera, Dome, Projection};
pub use glam;
pub use renderer::{
    Exposure, FrameError, MOST_VIEWS, SkyFrame, SkyRenderer, Tier, Timing, auto_ev100,
    ev100_for_mean,
};
pub use sky_core::haze::Haze;
pub use sky_core::tonemap::Tone;
