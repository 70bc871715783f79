//! Files and the terminal: everything that is read, written or shown.

pub mod files;
pub mod lut;
pub mod model;
pub mod plan;
pub mod profile;
pub mod progress;
pub mod report;
pub mod scene;
pub mod table;
