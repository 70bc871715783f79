//! A sky in three lines: the light 30° above the horizon, 90° from the sun's azimuth, seen from 10 km.
#![expect(clippy::print_stdout, reason = "an example shows what it finds")]

use sky_core::{Angle, Conditions, Haze, Length, SkyDirection, UtmSky};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let altitude = Length::from_km(10.0);
    let here = Conditions::new(altitude, Haze::Turbidity(2.0), Angle::from_degrees(45.0))?;
    let frame = UtmSky::embedded()?.frame(&here)?;
    let light = frame.yxy(&SkyDirection::from_degrees(60.0, 90.0));
    let light = light.ok_or("below the horizon")?;
    println!("{light:?}");
    assert!(light.luminance_cd_m2 > 100.0 && light.luminance_cd_m2 < 2000.0 && light.x < 0.3);
    Ok(())
}
