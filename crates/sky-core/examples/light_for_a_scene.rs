//! What an engine lights a scene with: sun, sky, ground, and the sky as spherical harmonics.
#![expect(clippy::print_stdout, reason = "an example shows what it finds")]

use sky_core::tonemap::{ev100_from_luminance, luminance};
use sky_core::{Angle, Conditions, Haze, Length, Picture, UtmSky};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let haze = Haze::OpticalDepth500(0.2);
    let here = Conditions::new(Length::ZERO, haze, Angle::from_degrees(60.0))?;
    let ground_albedo = 0.2;
    let light = Picture::new(&UtmSky::embedded()?, &here, ground_albedo)?.light;
    println!("sun, on a plane facing it: {:?} lx", light.sun_normal);
    println!("sky, on a horizontal plane: {:?} lx", light.sky_horizontal);
    println!("ground: {:?} cd/m2", light.ground);
    for (coefficient, name) in light.harmonics.iter().zip(["1", "y", "z", "x"]) {
        println!("harmonic {name}: {coefficient:?} cd/m2");
    }
    println!(
        "a camera's EV100: {:.1}",
        ev100_from_luminance(luminance(light.ground))
    );
    Ok(())
}
