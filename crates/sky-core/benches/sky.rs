//! What the sky of the default table costs: a direction, and a frame.

use std::hint::black_box;

use sky_core::conditions::Conditions;
use sky_core::direction::SkyDirection;
use sky_core::picture::Picture;
use sky_core::quantity::{Angle, Length};
use sky_core::utm_sky::UtmSky;

#[path = "../../../tests/support/bench.rs"]
mod bench;

fn main() {
    let sky = UtmSky::embedded().expect("the table of the program");
    let conditions = Conditions {
        observer_altitude: Length::from_km(3.7),
        turbidity: 2.6,
        sun_zenith: Angle::from_degrees(71.0),
    };
    let frame = sky.frame(&conditions).expect("inside the domain");
    // all but the horizontal ring: the observer's horizon lies below it, so all are lit
    let rings = (1..=9_u8).flat_map(|ring| {
        let zenith_deg = 10.0 * f64::from(ring);
        (0..30_u8).map(move |k| SkyDirection::from_degrees(zenith_deg, 12.0 * f64::from(k)))
    });
    let directions: Vec<_> = [SkyDirection::from_degrees(0.0, 0.0)]
        .into_iter()
        .chain(rings)
        .collect();
    bench::time("271 directions", || {
        directions
            .iter()
            .map(|d| {
                let light = frame.yxy(black_box(d));
                light.map_or(0.0, |light| light.luminance_cd_m2)
            })
            .sum::<f64>()
    });
    bench::time("frame", || sky.frame(black_box(&conditions)));
    // all that a renderer uploads: sky, air, scene light, sun
    bench::time("picture", || {
        Picture::new(&sky, black_box(&conditions), 0.2)
    });
}
