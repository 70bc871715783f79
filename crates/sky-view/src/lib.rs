//! A window to fly through the sky in.
//!
//! What is shown is decided without a window (`flight.rs`, `mesh.rs`) and drawn apart from it
//! (`painter.rs`, `panel.rs`); `window.rs` connects them. The only crate that knows a window system.
//! Out of scope: files, the command line, sound, instruments, a flight model.

pub mod flight;
pub mod mesh;
pub mod painter;
pub mod panel;
pub mod window;
