//! Prints `shaders/uniforms.wgsl`: what the shaders read, for bind group 0 or the one given.

use std::error::Error;
use std::io::{Write as _, stdout};

fn main() -> Result<(), Box<dyn Error>> {
    let group = std::env::args().nth(1).map_or(Ok(0), |n| n.parse())?;
    stdout().write_all(sky_core::uniforms::wgsl(group).as_bytes())?;
    Ok(())
}
