//! The table: its file, the one that ships, finite paths, what the report and the atlas say of it.

mod aerial;
mod faults;
mod format;
mod report;
mod stability;
mod utm_sky;

#[path = "../support/lut.rs"]
mod lut_support;
