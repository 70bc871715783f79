//! Relative optical air mass: the slant optical path through an exponential atmosphere over its
//! vertical one, finite through the horizontal and below it.
//!
//! Simplifications: straight rays, one exponential layer. Out of scope: refraction, and the masses
//! of single constituents at the ground.
//!
//! The `f64` and the `f32` function are one text with one set of constants, so that coefficients
//! fitted with one hold for the other.

use crate::quantity::{EARTH_RADIUS_KM, Length};

/// `erfcx(u) = exp(u²) erfc(u)` for u ≥ 0 as N(u)/D(u): a minimax fit, relative error below 4e-6,
/// exact at 0 and 1/(√π u) at infinity. Numerator, then denominator, constant term first.
const ERFCX_NUMERATOR: [f32; 4] = [1.0, 1.116_127, 0.556_468_2, 0.123_927_8];
const ERFCX_DENOMINATOR: [f32; 5] = [1.0, 2.244_429, 2.089_938, 0.986_262, 0.219_656_3];

/// The erfcx form is low by the factor 1 + q(u)/X, q = 1 − (5/8) / (1 + h₁u + h₂u²), exact at both
/// ends: 3/8 at the horizontal, 1 at the zenith; a fit of the expansion's next term between.
const CURVATURE: [f32; 2] = [0.649_091_9, 0.482_488_6];

/// No slant path above the ground has a larger exponent than 30 km over 1 km; beyond it, under the
/// horizon, the mass saturates so that it stays a finite `f32`.
const LARGEST_EXPONENT: f32 = 60.0;

/// The observer's distance from Earth's center in scale heights, X = (R + h)/H.
#[must_use]
pub fn radius_in_scale_heights(observer_altitude: Length, scale_height: Length) -> f64 {
    (EARTH_RADIUS_KM + observer_altitude.km()) / scale_height.km()
}

/// Relative optical air mass of an exponential atmosphere around a sphere: the slant optical depth
/// from the observer to space over the vertical one from the same observer, 1 at the zenith.
///
/// Domain: view zenith angles from 0 to the geometric horizon, scale heights up to 20 km. Under the
/// geometric horizon, where the ray meets the ground, the value goes on growing and saturates; it is
/// no air mass there, but finite.
///
/// Chapman's function; error below 1e-5 relative above the horizontal, 1e-4 below it.
#[must_use]
pub fn relative_air_mass(
    cos_view_zenith: f64,
    observer_altitude: Length,
    scale_height: Length,
) -> f64 {
    chapman_air_mass(
        cos_view_zenith,
        radius_in_scale_heights(observer_altitude, scale_height),
    )
}

macro_rules! chapman {
    ($real:ty, $chapman:ident, $reciprocal:ident, $above:ident, $doc:literal) => {
        #[doc = $doc]
        ///
        /// `radius_in_scale_heights` is X = (R + h)/H, see [`radius_in_scale_heights`].
        ///
        /// Source: Chapman 1931 in the erfcx form, √(πX/2) erfcx(√(X/2) cos χ), with the next term of
        /// its expansion in 1/X; below the horizontal
        /// Ch(X, χ) = 2 exp(X(1 − sin χ)) Ch(X sin χ, 90°) − Ch(X, 180° − χ).
        #[must_use]
        pub fn $chapman(cos_view_zenith: $real, radius_in_scale_heights: $real) -> $real {
            let x = radius_in_scale_heights;
            $reciprocal(cos_view_zenith, x, (0.5 * x).sqrt()).recip()
        }

        /// One over the air mass; `root` is √(X/2), which does not depend on the direction.
        #[must_use]
        pub fn $reciprocal(cos_view_zenith: $real, x: $real, root: $real) -> $real {
            let cosine = cos_view_zenith;
            let [above, over] = $above(cosine.abs(), x, root);
            if cosine >= 0.0 {
                return over / above;
            }
            // 1 − sin without cancellation; sin never 0, so that no product is 0 · ∞.
            let sine = (1.0 - cosine * cosine).max(1e-6).sqrt();
            let exponent = x * cosine * cosine / (1.0 + sine);
            let [tangent, under] = $above(0.0, x * sine, root * sine.sqrt());
            let growth = exponent.min(<$real>::from(LARGEST_EXPONENT)).exp();
            (2.0 * growth * tangent / under - above / over).recip()
        }

        /// Chapman's function for cosines from 0 to 1, as a numerator and a denominator.
        fn $above(cosine: $real, x: $real, root: $real) -> [$real; 2] {
            // √π
            const ROOT_PI: f32 = 1.772_453_9;
            let horner = |c: &[f32], u: $real| {
                c.iter()
                    .rev()
                    .fold(<$real>::from(0.0_f32), |sum, &c| sum * u + <$real>::from(c))
            };
            // At a small scale height u reaches 100: u⁶ X stays far from the limits of f32.
            let u = root * cosine;
            let curve = 1.0 + u * (<$real>::from(CURVATURE[0]) + u * <$real>::from(CURVATURE[1]));
            [
                <$real>::from(ROOT_PI)
                    * root
                    * horner(&ERFCX_NUMERATOR, u)
                    * (x * curve + (curve - 0.625)),
                horner(&ERFCX_DENOMINATOR, u) * (x * curve),
            ]
        }
    };
}

chapman!(
    f64,
    chapman_air_mass,
    reciprocal_chapman,
    chapman_above,
    "Chapman's function: the air mass from the cosine of the view zenith angle."
);
chapman!(
    f32,
    chapman_air_mass_f32,
    reciprocal_chapman_f32,
    chapman_above_f32,
    "Chapman's function in `f32`, the twin of [`chapman_air_mass`]."
);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::direction::{horizon_dip, horizon_zenith};
    use crate::quantity::Angle;

    fn cos_deg(degrees: f64) -> f64 {
        Angle::from_degrees(degrees).radians().cos()
    }

    /// Ch(X, χ) by Simpson's rule along the path.
    fn quadrature(x: f64, cosine: f64) -> f64 {
        // Path length from the observer in radii; exponent X(√(1 + 2 s c + s²) − 1).
        let far = (60.0 / x) + (120.0 / x).sqrt() + 2.0 * (-cosine).max(0.0);
        let n = 400_000_u32;
        let step = far / f64::from(n);
        let mut sum = 0.0;
        for i in 0..=n {
            let s = f64::from(i) * step;
            let rise = s * (2.0 * cosine + s);
            let height = rise / (1.0 + (1.0 + rise).sqrt());
            let weight = if i == 0 || i == n {
                1.0
            } else if i % 2 == 1 {
                4.0
            } else {
                2.0
            };
            sum += weight * (-x * height).exp();
        }
        sum * step / 3.0 * x
    }

    #[test]
    fn erfcx_is_within_4e_6_of_published_values() {
        // for an infinite radius the numerator over the denominator is √π root · erfcx(root cos χ)
        let erfcx = |u: f64| {
            let [above, over] = chapman_above(u, 1e12, 1.0);
            above / over / core::f64::consts::PI.sqrt()
        };
        // Abramowitz & Stegun, table 7.1, and the asymptotic series at 10.
        for (u, value) in [
            (0.0, 1.0),
            (0.5, 0.615_690_344_2),
            (1.0, 0.427_583_576_2),
            (2.0, 0.255_395_676_3),
            (10.0, 0.056_140_992_7),
        ] {
            assert!((erfcx(u) / value - 1.0).abs() < 4e-6, "{u}: {}", erfcx(u));
        }
        assert!((erfcx(1e5) * 1e5 * core::f64::consts::PI.sqrt() - 1.0).abs() < 4e-6);
    }

    #[test]
    fn exact_values_by_quadrature() {
        // Exponential atmospheres of 8.45 and 1.2 km on a sphere of 6371 km, observer at 0 km.
        let table = [
            (0.0, 1.0, 1.0),
            (45.0, 1.412_353, 1.413_947),
            (60.0, 1.992_166, 1.998_872),
            (75.0, 3.796_202, 3.853_652),
            (80.0, 5.540_018, 5.724_518),
            (85.0, 10.084_992, 11.210_146),
            (88.0, 18.421_081, 25.464_157),
            (90.0, 34.431_128, 91.327_967),
            (91.0, 52.831_613, 368.273_829),
            (92.0, 90.551_755, 4_610.041_141),
        ];
        for (deg, thick, thin) in table {
            for (scale, exact) in [(8.45, thick), (1.2, thin)] {
                let m = relative_air_mass(cos_deg(deg), Length::ZERO, Length::from_km(scale));
                assert!(
                    (m / exact - 1.0).abs() < 1e-5,
                    "{deg}° {scale} km: {m} {exact}"
                );
            }
        }
    }

    #[test]
    fn agrees_with_quadrature_from_altitude_down_to_the_horizon() {
        for h in [0.5, 6.0, 12.0, 30.0] {
            let horizon = horizon_zenith(Length::from_km(h));
            for scale in [8.0, 6.0, 1.2] {
                let x = radius_in_scale_heights(Length::from_km(h), Length::from_km(scale));
                for share in [0.3, 0.9, 0.98, 1.0] {
                    let cosine = (horizon.radians() * share).cos();
                    let exact = quadrature(x, cosine);
                    let m = chapman_air_mass(cosine, x);
                    assert!(
                        (m / exact - 1.0).abs() < 1e-4,
                        "{h} km, scale {scale}, {share}: {m} {exact}"
                    );
                }
            }
        }
    }

    #[test]
    fn smooth_and_rising_through_the_horizontal() {
        for (h, scale) in [(0.0, 8.0), (12.0, 8.0), (30.0, 8.0), (3.0, 1.2)] {
            let x = radius_in_scale_heights(Length::from_km(h), Length::from_km(scale));
            let dip = horizon_dip(Length::from_km(h)).radians();
            let m = |depression: f64| chapman_air_mass(-depression.sin(), x);
            let mut last = 0.0;
            for i in 0..=2000 {
                let value = m(-1.5 + (1.5 + dip) * f64::from(i) / 2000.0);
                assert!(value > last);
                last = value;
            }
            // Equal slopes and nearly equal curvatures on both sides.
            let s = 1e-4;
            let left = (m(0.0) - m(-s)) / s;
            let right = (m(s) - m(0.0)) / s;
            assert!(
                (right / left - 1.0).abs() < 5.0 * s * (x / 2.0).sqrt(),
                "{left} {right}"
            );
        }
    }

    #[test]
    fn single_precision_twin_agrees() {
        let x = radius_in_scale_heights(Length::from_km(12.0), Length::from_km(8.0));
        #[expect(clippy::cast_possible_truncation, reason = "the twin takes f32")]
        for i in 0..=1000 {
            let cosine = f64::from(1.0 - 1.061_f32 * (i as f32) / 1000.0);
            let twin = f64::from(chapman_air_mass_f32(cosine as f32, x as f32));
            let m = chapman_air_mass(cosine, x);
            assert!((twin / m - 1.0).abs() < 1e-5, "{cosine}: {twin} {m}");
        }
    }

    #[test]
    fn finite_everywhere() {
        for i in 0..=180 {
            let cosine = cos_deg(f64::from(i));
            for x in [300.0, 800.0, 6400.0] {
                assert!(chapman_air_mass(cosine, x).is_finite());
                #[expect(clippy::cast_possible_truncation, reason = "the twin takes f32")]
                let twin = chapman_air_mass_f32(cosine as f32, x as f32);
                assert!(twin.is_finite() && twin > 0.9);
            }
        }
    }
}
