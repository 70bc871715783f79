//! The `utm-sky` command.
fn main() {}
