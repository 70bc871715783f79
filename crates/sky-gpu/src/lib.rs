//! The UTM sky model on the GPU: sky, sun, aerial perspective and scene light with wgpu.
//!
//! A [`SkyRenderer`] is made once for a device and a kind of target; a [`View`] is an observer with a
//! camera, owned by you. Lights are linear sRGB in cd·m⁻².
//!
//! ```no_run
//! # fn frame(device: &wgpu::Device, queue: &wgpu::Queue, encoder: &mut wgpu::CommandEncoder,
//! #     target: &wgpu::TextureView) -> Result<(), Box<dyn std::error::Error>> {
//! use sky_gpu::{Camera, FrameSettings, Output, SkyRenderer, SkyRendererOptions, Tier, UtmSky, wgpu};
//! // once
//! let table = UtmSky::embedded()?;
//! let options = SkyRendererOptions::new(wgpu::TextureFormat::Bgra8Unorm, Output::Display);
//! let sky = SkyRenderer::new(device, &table, &options);
//! let mut view = sky.view(device);
//! // every frame: sun and up in your world, the camera's matrices, then any render pass of that target
//! let frame = FrameSettings { sun: [0.3, 0.8, 0.3].into(), ..FrameSettings::default() };
//! sky.update(queue, &mut view, &frame)?;
//! # let (clip_from_view, view_from_world) = ([[0.0; 4]; 4], [[0.0; 4]; 4]);
//! sky.set_camera(queue, &mut view, &Camera::from_matrices(clip_from_view, 0.0, view_from_world));
//! sky.prepare(queue, encoder, &mut view, Tier::Baked);
//! # let mut pass = sky_gpu::headless::Headless::pass(encoder, target, None);
//! sky.draw(&mut pass, &view);
//! # Ok(()) }
//! ```
//!
//! # What is drawn
//! The sky, the sun's disc and, below the horizon, a uniform ground through the air. Before objects of
//! yours the air is drawn in one of two ways: the object's own shader calls `air_before` (see
//! [`shader`]), exact at every sample; or the scene is finished first, into textures of color and
//! depth, and [`SkyRenderer::composite`] lays the air over it. What an object is lit with is in
//! [`View::picture`]: sun, sky and nine spherical harmonics.
//!
//! # The options
//! [`SkyRendererOptions`] names the target's format and what its numbers mean ([`Output`]: linear light
//! with your pre-exposure, a display, HDR10, scRGB), the depth and stencil state ([`sky_depth`]:
//! reversed or not, before or after the scene), the samples of the target and of a scene's depth. The
//! [`Tier`] says how the sky is drawn. Conditions outside the table's domain (0–30 km, T 1–8, sun
//! 0–96° from the zenith) are an error of [`SkyRenderer::update`], or the nearest that the table has,
//! said so, by [`SkyRenderer::update_nearest`].
//!
//! Nothing asks for more than WebGL 2's limits, but for a scene's multisampled depth. No global state,
//! no allocation in a frame. [`screen`] opens the device and the pictures of a window that you have,
//! [`headless`] those without one. To copy from: `examples/minimal.rs` (a window), `terrain.rs` (a
//! scene under the air), `engine.rs` (MSAA, reversed depth, a packed float target, two observers).
//!
//! # Simplifications, and what is out of scope
//! One sun zenith angle for all objects in view. Out of scope: clouds, shadows, windows and their
//! events.

pub mod camera;
mod frame;
pub mod headless;
mod layouts;
mod options;
mod pipelines;
mod renderer;
pub mod screen;
pub mod shader;
mod tier;
mod view;

pub use camera::{Camera, Dome, Projection};
pub use frame::{Exposure, FrameError, FrameSettings, auto_ev100, ev100_for_mean};
pub use glam;
pub use layouts::{baked_layout, frame_layout};
pub use options::{Output, SkyRendererOptions, sky_depth};
pub use renderer::{SkyRenderer, Timing};
pub use sky_core::conditions::Nearest;
pub use sky_core::haze::Haze;
pub use sky_core::picture::Picture;
pub use sky_core::quantity::{Angle, Length};
pub use sky_core::tonemap::Tone;
pub use sky_core::utm_sky::UtmSky;
pub use tier::Tier;
pub use view::View;
pub use wgpu;
