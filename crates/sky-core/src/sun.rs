//! The sun's disc: how large and how dark at its rim it is, and what the horizon leaves of it.
//!
//! Simplifications: the horizon is straight across the disc; no refraction.

use crate::quantity::{Angle, single};

/// The sun's angular radius, of the mean distance \[deg\].
pub const SUN_RADIUS_DEG: f64 = 0.2666;

/// Limb darkening in the visible, I(μ) = I₀(1 − u(1 − μ)). Source: Cox (ed.), Allen's Astrophysical
/// Quantities, 4th ed., §14.7, near 550 nm.
pub const LIMB_DARKENING: f32 = 0.6;

/// Solid angle of a disc of an angular radius \[sr\]: 4π sin²(r/2), for 1 − cos r cancels in f32.
#[must_use]
pub fn disc_solid_angle(radius: f32) -> f32 {
    let half = (0.5 * radius).sin();
    4.0 * core::f32::consts::PI * half * half
}

/// The part of the sun's disc above a straight horizon, weighted by [`LIMB_DARKENING`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VisibleSun {
    /// Its share of the whole disc's light, 0 to 1.
    pub share: f32,
    /// Cosine of the zenith angle of its center of light: the sun's own while all of it is up.
    pub cosine: f32,
}

impl VisibleSun {
    /// The part above the geometric horizon, from sine and cosine of the sun's zenith angle and the
    /// cosine of the horizon's.
    #[must_use]
    pub fn new([sin_sun, cos_sun]: [f32; 2], cos_horizon: f32) -> Self {
        let [sin_sun, cos_sun, cos_horizon] = [sin_sun, cos_sun, cos_horizon].map(f64::from);
        let sin_horizon = (1.0 - cos_horizon * cos_horizon).max(0.0).sqrt();
        // the difference of the two angles, exact where they are close
        let above = (cos_sun * sin_horizon - sin_sun * cos_horizon)
            .atan2(cos_sun * cos_horizon + sin_sun * sin_horizon);
        let radius = Angle::from_degrees(SUN_RADIUS_DEG).radians();
        let (share, center) = segment(above / radius);
        let (sin_up, cos_up) = (center * radius).sin_cos();
        Self {
            share: single(share),
            cosine: single(cos_sun * cos_up + sin_sun * sin_up),
        }
    }
}

/// Share of the light of a limb-darkened disc above a straight edge, and how far the center of that
/// light lies above the disc's own; in radii, from how far the disc's center stands above the edge.
///
/// With the brightness 1 − u + u √(1 − r²) the light of a chord at height y is
/// 2(1 − u) √(1 − y²) + u (π/2)(1 − y²), which integrates in closed form.
#[must_use]
pub fn segment(above: f64) -> (f64, f64) {
    use core::f64::consts::PI;
    if above >= 1.0 {
        return (1.0, 0.0);
    }
    if above <= -1.0 {
        return (0.0, 1.0);
    }
    let limb = f64::from(LIMB_DARKENING);
    let chord = 1.0 - above * above;
    let flat = PI - above.acos() + above * chord.sqrt();
    let dome = 0.5 * PI * (2.0 / 3.0 + above - above * above * above / 3.0);
    let light = (1.0 - limb) * flat + limb * dome;
    let moment =
        (1.0 - limb) * (2.0 / 3.0) * chord * chord.sqrt() + limb * (PI / 8.0) * chord * chord;
    let share = (light / (PI * (1.0 - limb / 3.0))).clamp(0.0, 1.0);
    // of the last sliver the middle is as good, and it is not a quotient of rounding errors
    let center = if chord < 1e-6 && above < 0.0 {
        0.5 * (1.0 - above)
    } else {
        moment / light
    };
    (share, center)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A limb-darkened disc summed point by point: the light above an edge and its center.
    fn summed(above: f64) -> (f64, f64) {
        let (mut whole, mut light, mut moment) = (0.0, 0.0, 0.0);
        let steps = 1000_u16;
        let place = |i: u16| (f64::from(i) + 0.5) / f64::from(steps) * 2.0 - 1.0;
        for y in (0..steps).map(place) {
            for x in (0..steps).map(place) {
                let height = 1.0 - x * x - y * y;
                if height > 0.0 {
                    let here = 1.0 - f64::from(LIMB_DARKENING) * (1.0 - height.sqrt());
                    whole += here;
                    if y > -above {
                        light += here;
                        moment += here * y;
                    }
                }
            }
        }
        (light / whole, moment / light)
    }

    #[test]
    fn a6_the_segment_of_the_disc_is_the_sum_over_its_points() {
        for above in [-0.9, -0.5, 0.0, 0.2, 0.7, 0.99] {
            let (share, center) = segment(above);
            let (want_share, want_center) = summed(above);
            assert!(
                (share - want_share).abs() < 1e-3,
                "{above}: {share} {want_share}"
            );
            assert!(
                (center - want_center).abs() < 2e-3,
                "{above}: {center} {want_center}"
            );
        }
    }

    #[test]
    fn a6_the_share_has_exact_ends_and_never_falls() {
        assert_eq!(segment(1.0), (1.0, 0.0));
        assert_eq!(segment(7.0), (1.0, 0.0));
        assert_eq!(segment(-1.0), (0.0, 1.0));
        assert!((segment(0.0).0 - 0.5).abs() < 1e-15);
        let mut last = (0.0, 1.0);
        for i in -10_000..=10_000_i32 {
            let here = segment(f64::from(i) * 1e-4);
            assert!(
                here.0 >= last.0 && here.0 - last.0 < 1e-4,
                "{i}: {here:?} {last:?}"
            );
            assert!(
                here.1 <= last.1 + 1e-9 && last.1 - here.1 < 2e-4,
                "{i}: {here:?} {last:?}"
            );
            last = here;
        }
    }

    #[test]
    fn a6_a_sun_that_is_up_keeps_its_own_zenith_angle_to_the_last_bit() {
        for zenith in [0.0, 30.0, 89.7_f64] {
            let (sine, cosine) = Angle::from_degrees(zenith).radians().sin_cos();
            let [sine, cosine] = [sine, cosine].map(single);
            let sun = VisibleSun::new([sine, cosine], 0.0);
            assert_eq!(sun, VisibleSun { share: 1.0, cosine });
        }
    }

    #[test]
    fn a16_the_solid_angle_of_the_disc_does_not_cancel() {
        let radius = Angle::from_degrees(SUN_RADIUS_DEG).radians();
        let exact = 2.0 * core::f64::consts::PI * (1.0 - radius.cos());
        let found = f64::from(disc_solid_angle(single(radius)));
        assert!((found / exact - 1.0).abs() < 1e-6, "{found} {exact}");
    }
}
