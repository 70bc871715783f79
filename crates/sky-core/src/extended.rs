//! The extended sky formula: a sum of 22 products for each of ln Y, x and y.
//!
//! Perez's formula multiplies one factor of the air mass (gradation) by one factor of the angle from
//! the sun (indicatrix). A low sun, haze below the observer and the aureole break that product, and
//! its coefficients trade against each other, so that they cannot be interpolated. Here
//!
//! `ln Y = Σ c_k p_k(θ) q_k(γ)`, and likewise x and y with coefficients of their own.
//!
//! `p_k` is 1 or m/(n + m) with a relative air mass m of the air (scale height 8 km) or of the haze
//! (1.2 km), both of a spherical atmosphere, finite down to the geometric horizon; `q_k` is 1, cos γ,
//! cos² γ or exp(−n γ). The formula is linear in its coefficients: a fit has one solution, and to
//! interpolate coefficients is to interpolate ln Y, x and y themselves. Luminance cannot turn negative.
//!
//! Source: our own. The products were chosen greedily (orthogonal matching pursuit) from 88 candidates
//! by how much each lowered the residual of transport maps over 0–30 km, T 1–8, sun 0–92°.

use crate::air_mass::{chapman_air_mass_f32, radius_in_scale_heights};
use crate::direction::SkyDirection;
use crate::quantity::Length;
use crate::sky_model::Conditions;

/// Number of products.
pub const TERMS: usize = 22;

/// Names of the products: `a3` is m/(3 + m) of the air, `h5` of the haze; `mu` is cos γ, `e2` is
/// exp(−2γ).
pub const TERM_NAMES: [&str; TERMS] = [
    "1", "a3", "e2", "a50", "a200", "mu2", "a200*mu", "h5*mu", "h5", "h5*e2", "a50*mu", "a3*mu",
    "a1000", "h100*e1", "a1000*mu", "a1*mu2", "a1000*e1", "a1*e8", "a1", "a200*e1", "a10*mu",
    "h20*e1",
];

/// Scale heights of air and haze \[km\] of the two air masses.
pub const SCALE_HEIGHTS_KM: [f64; 2] = [8.0, 1.2];

/// The products in a direction.
///
/// `cosine` is that of the view zenith angle, `radii` the observer's distance from the Earth's center
/// in scale heights of air and haze, `gamma` the angle from the sun \[rad\] and `mu` its cosine.
#[must_use]
pub fn basis(cosine: f32, radii: [f32; 2], gamma: f32, mu: f32) -> [f32; TERMS] {
    let air = chapman_air_mass_f32(cosine, radii[0]);
    let haze = chapman_air_mass_f32(cosine, radii[1]);
    let share = |m: f32, n: f32| m / (n + m);
    let [a1, a3, a10, a50, a200, a1000] =
        [1.0, 3.0, 10.0, 50.0, 200.0, 1000.0].map(|n| share(air, n));
    let [h5, h20, h100] = [5.0, 20.0, 100.0].map(|n| share(haze, n));
    let e1 = (-gamma).exp();
    let e2 = e1 * e1;
    let e4 = e2 * e2;
    let mu2 = mu * mu;
    [
        1.0,
        a3,
        e2,
        a50,
        a200,
        mu2,
        a200 * mu,
        h5 * mu,
        h5,
        h5 * e2,
        a50 * mu,
        a3 * mu,
        a1000,
        h100 * e1,
        a1000 * mu,
        a1 * mu2,
        a1000 * e1,
        a1 * e4 * e4,
        a1,
        a200 * e1,
        a10 * mu,
        h20 * e1,
    ]
}

/// The products for an observer and sun, as a fit needs them.
#[must_use]
pub fn basis_in(direction: &SkyDirection, conditions: &Conditions) -> [f32; TERMS] {
    let radii = SCALE_HEIGHTS_KM.map(|h| {
        single(radius_in_scale_heights(
            conditions.observer_altitude,
            Length::from_km(h),
        ))
    });
    basis(
        single(direction.view_zenith.radians().cos()),
        radii,
        single(direction.scattering_angle(conditions.sun_zenith).radians()),
        single(direction.cos_scattering_angle(conditions.sun_zenith)),
    )
}

#[expect(clippy::cast_possible_truncation, reason = "the runtime works in f32")]
pub(crate) const fn single(x: f64) -> f32 {
    x as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_products_are_finite_from_the_zenith_to_the_horizon() {
        for altitude_km in [0.0_f32, 1.0, 30.0] {
            let radii = [(6371.0 + altitude_km) / 8.0, (6371.0 + altitude_km) / 1.2];
            for i in 0..=200_u8 {
                let cosine = 1.0 - f32::from(i) / 200.0 * 1.1;
                for gamma in [0.0_f32, 1.0, 3.1] {
                    let all = basis(cosine, radii, gamma, gamma.cos());
                    assert!(
                        all.iter().all(|p| p.is_finite() && p.abs() <= 1.0),
                        "{all:?}"
                    );
                }
            }
        }
    }
}
