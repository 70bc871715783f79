//! The extended formula in other numbers than the runtime's: in double precision, and with its
//! coefficients rounded to half precision.

use sky_core::air_mass::{chapman_air_mass, radius_in_scale_heights};
use sky_core::color::Yxy;
use sky_core::conditions::Conditions;
use sky_core::direction::{SkyDirection, horizon_zenith};
use sky_core::extended::{self, Coefficients, SCALE_HEIGHTS_KM, ScaledRadii, TERMS};
use sky_core::quantity::{Angle, Length, single};
use sky_core::utm_sky::{LOWEST_RING_BEND, LOWEST_RING_DEG};

/// The cosine that the formula takes in place of a direction's, as [`SkyFrame`] has it.
///
/// [`SkyFrame`]: sky_core::utm_sky::SkyFrame
fn held(cosine: f64, altitude: Length) -> f64 {
    let ring = Angle::from_degrees(LOWEST_RING_DEG).radians();
    let lowest = (horizon_zenith(altitude).radians() - ring).cos();
    let below = ((lowest - cosine) / LOWEST_RING_BEND).clamp(0.0, 1.0);
    cosine.max(lowest) - LOWEST_RING_BEND * (below - 0.5 * below * below)
}

/// The products of [`extended::basis`] in double precision.
fn basis(direction: &SkyDirection, altitude: Length, sun_zenith: Angle) -> [f64; TERMS] {
    let cosine = held(direction.view_zenith.radians().cos(), altitude);
    let [air, haze] = SCALE_HEIGHTS_KM.map(|h| {
        chapman_air_mass(
            cosine,
            radius_in_scale_heights(altitude, Length::from_km(h)),
        )
        .recip()
    });
    let a = |n: f64| 1.0 / (1.0 + n * air);
    let h = |n: f64| 1.0 / (1.0 + n * haze);
    let gamma = direction.scattering_angle(sun_zenith).radians();
    let cos_gamma = direction.cos_scattering_angle(sun_zenith);
    let e = |n: f64| (-n * gamma).exp();
    [
        1.0,
        a(3.0),
        e(2.0),
        a(50.0),
        a(200.0),
        cos_gamma * cos_gamma,
        a(200.0) * cos_gamma,
        h(5.0) * cos_gamma,
        h(5.0),
        h(5.0) * e(2.0),
        a(50.0) * cos_gamma,
        a(3.0) * cos_gamma,
        a(1000.0),
        h(100.0) * e(1.0),
        a(1000.0) * cos_gamma,
        a(1.0) * cos_gamma * cos_gamma,
        a(1000.0) * e(1.0),
        a(1.0) * e(8.0),
        a(1.0),
        a(200.0) * e(1.0),
        a(10.0) * cos_gamma,
        h(20.0) * e(1.0),
    ]
}

/// The light of a direction in double precision.
#[must_use]
pub fn in_f64(
    coefficients: &Coefficients,
    direction: &SkyDirection,
    conditions: &Conditions,
) -> Yxy {
    let products = basis(
        direction,
        conditions.observer_altitude,
        conditions.sun_zenith,
    );
    let mut sums = [0.0; 3];
    for (row, product) in coefficients.iter().zip(products) {
        for (sum, c) in sums.iter_mut().zip(row) {
            *sum += f64::from(*c) * product;
        }
    }
    let [x, y] = extended::within_locus([single(sums[1]), single(sums[2])]).map(f64::from);
    Yxy {
        luminance_cd_m2: sums[0].exp(),
        x,
        y,
    }
}

/// The light of a direction with the runtime's arithmetic and other coefficients.
#[must_use]
pub fn with_coefficients(
    coefficients: &Coefficients,
    radii: ScaledRadii,
    direction: &SkyDirection,
    conditions: &Conditions,
) -> Yxy {
    let sun = conditions.sun_zenith;
    let products = extended::basis(
        single(held(
            direction.view_zenith.radians().cos(),
            conditions.observer_altitude,
        )),
        radii,
        single(direction.scattering_angle(sun).radians()),
        single(direction.cos_scattering_angle(sun)),
    );
    let [luminance, x, y] = extended::light(coefficients, &products).map(f64::from);
    Yxy {
        luminance_cd_m2: luminance,
        x,
        y,
    }
}

/// Coefficients rounded to half precision.
#[must_use]
pub fn rounded_to_f16(coefficients: &Coefficients) -> Coefficients {
    coefficients.map(|row| row.map(|c| half::f16::from_f32(c).to_f32()))
}
