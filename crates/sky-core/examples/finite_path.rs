//! A hill at several distances: what the air before it takes from its light, and what it adds.
#![expect(clippy::print_stdout, reason = "an example shows what it finds")]

use sky_core::{AerialFrame, Angle, SkyDirection, UtmSky};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let sky = UtmSky::embedded()?;
    let (turbidity, sun_zenith) = (3.0, Angle::from_degrees(60.0));
    let air = AerialFrame::new(&sky, turbidity, sun_zenith)?;
    let observer_altitude_km = 2.0;
    let direction = SkyDirection::from_degrees(90.5, 45.0).unit_vector();
    for distance_km in [1.0, 3.0, 10.0, 30.0, 100.0] {
        let path = air.path(observer_altitude_km, direction, distance_km);
        let [red, green, blue, _] = path.transmittance;
        println!(
            "{distance_km:5} km: transmittance {red:.3} {green:.3} {blue:.3}, in-scattered {:?} cd/m2",
            path.inscatter
        );
    }
    Ok(())
}
