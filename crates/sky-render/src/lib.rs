//! Pictures of skies without a window, by GPU or CPU, and what they cost.
//!
//! A [`Shot`](shot::Shot) is all that decides a picture; a stage times the ways to draw one. The
//! commands that write pictures and the window draw with it. Simplifications: one terrain, one
//! camera a picture. Out of scope: files, windows, and how good a sky is.

pub mod camera;
pub mod pixels;
pub mod published;
pub mod shot;
pub mod stage;
mod sun_disc;
pub mod terrain;

pub use camera::{clip, facing, looking, world_direction};
pub use pixels::{Pixels, file_bytes, file_bytes_with_comment};
pub use shot::{GROUND_ALBEDO, Painter, Scenery, Shot, draw_on_cpu};
