//! A sky in three lines: the light 30° above the horizon, 90° from the sun's azimuth, seen from 10 km.

use sky_core::conditions::Conditions;
use sky_core::direction::SkyDirection;
use sky_core::quantity::{Angle, Length};
use sky_core::utm_sky::UtmSky;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let conditions = Conditions {
        observer_altitude: Length::from_km(10.0),
        turbidity: 2.0,
        sun_zenith: Angle::from_degrees(45.0),
    };
    let sky = UtmSky::embedded()?;
    let frame = sky.frame(&conditions)?;
    let light = frame
        .yxy(&SkyDirection::from_degrees(60.0, 90.0))
        .ok_or("below the horizon")?;
    assert!(light.luminance_cd_m2 > 100.0 && light.luminance_cd_m2 < 2000.0 && light.x < 0.3);
    Ok(())
}
