//! The sun from date, time and place, and the sky at the zenith hour by hour.
#![expect(clippy::print_stdout, reason = "an example shows what it finds")]

use sky_core::{
    Angle, Conditions, GeoPlace, Haze, Length, SkyDirection, UtcTime, UtmSky, sun_position,
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let sky = UtmSky::embedded()?;
    let innsbruck = GeoPlace {
        latitude: Angle::from_degrees(47.26),
        longitude: Angle::from_degrees(11.39),
        altitude: Length::from_m(580.0),
    };
    let haze = Haze::VisualRange(Length::from_km(60.0));
    for hours in [2.0, 3.5, 5.0, 8.0, 11.25, 18.0, 19.5] {
        let time = UtcTime {
            hours,
            ..UtcTime::from_date("2025-06-21").ok_or("a date")?
        };
        let sun = sun_position(time, innsbruck)?;
        let here = Conditions::new(innsbruck.altitude, haze, sun.zenith)?;
        print!(
            "{hours:5.2} h: sun {:6.2}° from the zenith: ",
            sun.zenith.degrees()
        );
        match sky.frame(&here) {
            Ok(frame) => {
                let zenith = frame.yxy(&SkyDirection::from_degrees(0.0, 0.0));
                println!("zenith {:8.2} cd/m2", zenith.ok_or("up")?.luminance_cd_m2);
            }
            Err(night) => println!("{night}"),
        }
    }
    Ok(())
}
