//! What was wrong once, by the number that it had on the list, and is right.

use sky_core::aerial::AerialFrame;
use sky_core::direction::horizon_zenith;

use sky_core::conditions::Conditions;
use sky_core::picture::Picture;
use sky_core::quantity::{Angle, Length, single};
use sky_core::sun::{LIMB_DARKENING, SUN_RADIUS_DEG};
use sky_core::utm_sky::UtmSky;

type Fallible<T> = Result<T, Box<dyn core::error::Error>>;

/// Red sunlight on a plane facing the sun \[lx\], the sun's center some degrees above the horizon.
fn sunlight(sky: &UtmSky, altitude_km: f64, turbidity: f64, above_deg: f64) -> Fallible<f64> {
    let altitude = Length::from_km(altitude_km);
    let conditions = Conditions {
        observer_altitude: altitude,
        turbidity,
        sun_zenith: Angle::from_degrees(horizon_zenith(altitude).degrees() - above_deg),
    };
    Ok(Picture::new(sky, &conditions, 0.1)?.light.sun_normal[0].into())
}

/// The same summed over chords of the disc, each through its own air.
fn summed(sky: &UtmSky, altitude_km: f64, turbidity: f64, above_deg: f64) -> Fallible<f64> {
    let horizon = horizon_zenith(Length::from_km(altitude_km)).degrees();
    let air = AerialFrame::new(sky, turbidity, Angle::from_degrees(90.0))?;
    let limb = f64::from(LIMB_DARKENING);
    let (mut light, mut whole) = (0.0, 0.0);
    let chords = 400_u16;
    for i in 0..chords {
        let y = (f64::from(i) + 0.5) / f64::from(chords) * 2.0 - 1.0;
        let chord = 1.0 - y * y;
        let weight = 2.0 * (1.0 - limb) * chord.sqrt() + limb * 0.5 * core::f64::consts::PI * chord;
        whole += weight;
        let zenith = horizon - above_deg - y * SUN_RADIUS_DEG;
        if zenith < horizon {
            let cosine = single(Angle::from_degrees(zenith).radians().cos());
            let through = air.transmittance_to_space(single(altitude_km), cosine);
            light += weight * f64::from(air.sun_rgb[0] * through[0]);
        }
    }
    Ok(light / whole)
}

#[test]
fn a6_the_disc_sets_over_half_a_degree() -> Fallible<()> {
    let sky = UtmSky::embedded()?;
    let mut compared = 0;
    for [altitude_km, turbidity] in [[0.0, 1.2], [1.0, 1.2], [10.0, 1.2], [30.0, 1.0]] {
        let at = |above_deg| sunlight(&sky, altitude_km, turbidity, above_deg);
        let up = at(0.3)?;
        let air = format!("{altitude_km} km, T {turbidity}");
        assert!(up > 1.0, "{air}: there is light to lose, {up}");
        assert!(
            at(-SUN_RADIUS_DEG - 1e-3)? == 0.0,
            "{air}: the whole disc is below"
        );
        assert!(
            at(-SUN_RADIUS_DEG + 0.02)? > 0.0,
            "{air}: its upper limb is not"
        );
        let mut last = up;
        for step in 1..=60 {
            let above_deg = 0.3 - 0.01 * f64::from(step);
            let here = at(above_deg)?;
            let step = (last - here) / up;
            assert!(
                (0.0..0.1).contains(&step),
                "{air}, {above_deg}: {here} after {last}"
            );
            // half the variance of the logarithm over the disc is what one path for all of it misses
            let want = summed(&sky, altitude_km, turbidity, above_deg)?;
            if want > 0.01 * up && altitude_km < 2.0 {
                let ratio = here / want;
                assert!(
                    (ratio - 1.0).abs() < 0.07,
                    "{air}, {above_deg}: {here} {want}"
                );
                compared += 1;
            }
            last = here;
        }
    }
    assert!(compared > 90, "{compared}");
    Ok(())
}
