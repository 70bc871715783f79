//! The sky formula of Perez, Seals & Michalsky: a gradation from zenith to horizon times an
//! indicatrix around the sun.
//!
//! The air mass comes in as a number, so that the printed 1/cos θ and a spherical mass both work;
//! see [`plane_parallel_air_mass`] and [`sky_core::air_mass`]. Out of scope: the sun's disc, and any clamping of coefficients that do
//! not describe a sky.

use serde::{Deserialize, Serialize};
use sky_core::quantity::Angle;

/// The five coefficients of one channel.
///
/// Source: Perez, Seals & Michalsky 1993, doi:10.1016/0038-092X(93)90017-I; named A–E as in Preetham,
/// Shirley & Smits 1999.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PerezCoefficients {
    /// A: amount of darkening or brightening toward the horizon; −1 in the limit of a thin layer.
    pub a: f64,
    /// B: gradient near the horizon, negative; minus the optical depth in the limit of a thin layer.
    pub b: f64,
    /// C: strength of the circumsolar region.
    pub c: f64,
    /// D: narrowness of the circumsolar region \[rad⁻¹\], negative.
    pub d: f64,
    /// E: strength of the backscattered light.
    pub e: f64,
}

/// Relative optical air mass of a plane-parallel atmosphere, 1/cos θ; infinite at and below the
/// horizontal.
#[must_use]
pub fn plane_parallel_air_mass(cos_view_zenith: f64) -> f64 {
    if cos_view_zenith > 0.0 {
        cos_view_zenith.recip()
    } else if cos_view_zenith.is_nan() {
        f64::NAN
    } else {
        f64::INFINITY
    }
}

/// Coefficients with which the formula is not a sky everywhere.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PerezDomainError {
    /// A coefficient is not a finite number.
    #[error("coefficient {name}: expected a finite number, found {found}")]
    NotFinite {
        /// A–E.
        name: char,
        /// The value.
        found: f64,
    },
    /// B or D is not negative: the formula grows without bound.
    #[error("coefficient {name}: expected a negative number, found {found}")]
    NotNegative {
        /// B or D.
        name: char,
        /// The value.
        found: f64,
    },
    /// The gradation is not positive at the smallest air mass.
    #[error("gradation at air mass {air_mass}: expected a positive number, found {found}")]
    Gradation {
        /// Where.
        air_mass: f64,
        /// The value.
        found: f64,
    },
    /// The indicatrix may not be positive: 1 + C + E or 1 + E or 1 + C has the wrong sign.
    #[error("lower bound of the indicatrix: expected a positive number, found {found}")]
    Indicatrix {
        /// The bound.
        found: f64,
    },
}

impl PerezCoefficients {
    /// From \[A, B, C, D, E\].
    #[must_use]
    pub const fn from_array([a, b, c, d, e]: [f64; 5]) -> Self {
        Self { a, b, c, d, e }
    }

    /// To \[A, B, C, D, E\].
    #[must_use]
    pub const fn to_array(self) -> [f64; 5] {
        [self.a, self.b, self.c, self.d, self.e]
    }

    /// The factor that depends on the view zenith angle, 1 + A exp(B m), by the relative air mass m.
    ///
    /// Domain: B < 0 for an unbounded m; an infinite mass (1/cos θ at the horizontal) gives the
    /// limit, 1.
    #[must_use]
    pub fn gradation(&self, air_mass: f64) -> f64 {
        // 0 · ∞ is not a number, but the limit of B = 0 is.
        let exponent = if self.b == 0.0 {
            0.0
        } else {
            self.b * air_mass
        };
        1.0 + self.a * exponent.exp()
    }

    /// The factor that depends on the angle from the sun, 1 + C exp(D γ) + E cos² γ.
    ///
    /// Domain: any γ from 0 to 180°. E stands outside the exponential.
    #[must_use]
    pub fn indicatrix(&self, scattering_angle: Angle) -> f64 {
        let gamma = scattering_angle.radians();
        let cosine = gamma.cos();
        1.0 + self.c * (self.d * gamma).exp() + self.e * cosine * cosine
    }

    /// F(m, γ): gradation times indicatrix, in no particular unit.
    #[must_use]
    pub fn relative_luminance(&self, air_mass: f64, scattering_angle: Angle) -> f64 {
        self.gradation(air_mass) * self.indicatrix(scattering_angle)
    }

    /// F(m, γ) divided by F at the zenith, where γ is the sun's zenith angle: 1 at the zenith. The light of a direction is the zenith's
    /// times this.
    ///
    /// Domain: coefficients that pass [`Self::check`]; otherwise the divisor may vanish.
    #[must_use]
    pub fn relative_to_zenith(
        &self,
        air_mass: f64,
        scattering_angle: Angle,
        zenith_air_mass: f64,
        sun_zenith: Angle,
    ) -> f64 {
        self.relative_luminance(air_mass, scattering_angle)
            / self.relative_luminance(zenith_air_mass, sun_zenith)
    }

    /// Whether the formula is finite and positive for every air mass from `smallest_air_mass` up and
    /// every angle from the sun.
    ///
    /// The test of the indicatrix is sufficient, not necessary: with e⁻ = 1 + min(E, 0), the bound
    /// e⁻ + min(C, 0) must be positive.
    ///
    /// # Errors
    /// The first condition that does not hold.
    pub fn check(&self, smallest_air_mass: f64) -> Result<(), PerezDomainError> {
        for (name, found) in ['A', 'B', 'C', 'D', 'E'].into_iter().zip(self.to_array()) {
            if !found.is_finite() {
                return Err(PerezDomainError::NotFinite { name, found });
            }
        }
        for (name, found) in [('B', self.b), ('D', self.d)] {
            if found >= 0.0 {
                return Err(PerezDomainError::NotNegative { name, found });
            }
        }
        let found = self.gradation(smallest_air_mass);
        if found <= 0.0 {
            return Err(PerezDomainError::Gradation {
                air_mass: smallest_air_mass,
                found,
            });
        }
        let found = 1.0 + self.e.min(0.0) + self.c.min(0.0);
        if found <= 0.0 {
            return Err(PerezDomainError::Indicatrix { found });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sky_core::direction::SkyDirection;

    // Preetham 1999, appendix A.2, at turbidity 3: slope · T + offset.
    const LUMINANCE: PerezCoefficients =
        PerezCoefficients::from_array([-0.9269, -0.6387, 5.2570, -2.2153, 0.1693]);
    const X: PerezCoefficients =
        PerezCoefficients::from_array([-0.3171, -0.1987, 0.2113, -1.0912, 0.0353]);
    const Y: PerezCoefficients =
        PerezCoefficients::from_array([-0.3109, -0.2758, 0.1865, -1.7860, 0.0202]);

    /// Sun zenith, view zenith, azimuth [deg]; γ [rad]; F of luminance there and at the zenith; Y [kcd/m²], x, y.
    const PREETHAM: [[f64; 9]; 5] = [
        [
            45.0,
            0.0,
            0.0,
            core::f64::consts::FRAC_PI_4,
            1.025_042_88,
            1.025_042_88,
            7.320_358,
            0.245_678,
            0.251_476,
        ],
        [
            45.0,
            45.0,
            0.0,
            0.0,
            4.012_430_29,
            1.025_042_88,
            28.654_828,
            0.284_253,
            0.296_955,
        ],
        [
            45.0,
            60.0,
            180.0,
            1.832_596,
            0.817_292_15,
            1.025_042_88,
            5.836_703,
            0.243_216,
            0.258_031,
        ],
        [
            60.0,
            80.0,
            90.0,
            1.483_863,
            1.169_615_63,
            0.796_063_57,
            7.550_700,
            0.288_115,
            0.303_455,
        ],
        [
            30.0,
            30.0,
            0.0,
            0.0,
            3.577_259_94,
            1.417_007_72,
            26.288_014,
            0.278_659,
            0.291_757,
        ],
    ];

    /// Zenith values at T = 3 [kcd/m²], Preetham 1999, appendix A.2.
    fn zenith(sun_zenith: f64) -> [f64; 3] {
        let t = 3.0;
        let s = sun_zenith;
        let chi = (4.0 / 9.0 - t / 120.0) * (core::f64::consts::PI - 2.0 * s);
        let luminance = (4.0453 * t - 4.9710) * chi.tan() - 0.2155 * t + 2.4192;
        let chromaticity = |m: [[f64; 4]; 3]| {
            let row = |r: [f64; 4]| ((r[0] * s + r[1]) * s + r[2]) * s + r[3];
            (row(m[0]) * t + row(m[1])) * t + row(m[2])
        };
        [
            luminance,
            chromaticity([
                [0.00166, -0.00375, 0.00209, 0.0],
                [-0.02903, 0.06377, -0.03202, 0.00394],
                [0.11693, -0.21196, 0.06052, 0.25886],
            ]),
            chromaticity([
                [0.00275, -0.00610, 0.00317, 0.0],
                [-0.04214, 0.08970, -0.04153, 0.00516],
                [0.15346, -0.26756, 0.06670, 0.26688],
            ]),
        ]
    }

    #[test]
    fn preethams_sky_at_turbidity_3() {
        for [sun, view, azimuth, gamma, f, f_zenith, lum, x, y] in PREETHAM {
            let sun = Angle::from_degrees(sun);
            let direction = SkyDirection::from_degrees(view, azimuth);
            let angle = direction.scattering_angle(sun);
            assert!((angle.radians() - gamma).abs() < 1e-6);
            let m = plane_parallel_air_mass(direction.view_zenith.radians().cos());
            assert!((LUMINANCE.relative_luminance(m, angle) - f).abs() < 1e-8);
            assert!((LUMINANCE.relative_luminance(1.0, sun) - f_zenith).abs() < 1e-8);
            let at_zenith = zenith(sun.radians());
            for ((c, z), expected) in [LUMINANCE, X, Y].iter().zip(at_zenith).zip([lum, x, y]) {
                let value = z * c.relative_to_zenith(m, angle, 1.0, sun);
                assert!((value - expected).abs() < 2e-6, "{value} {expected}");
            }
        }
    }

    #[test]
    fn the_cie_clear_sky_is_a_perez_sky() {
        // CIE 1973: A = −1, B = −0.32, C = 10/0.91, D = −3, E = 0.45/0.91.
        let clear = PerezCoefficients::from_array([-1.0, -0.32, 10.0 / 0.91, -3.0, 0.45 / 0.91]);
        for (sun, view, gamma, expected) in [
            (45.0, 0.0, 45.0, 1.0),
            (45.0, 60.0, 15.0, 4.880_780_579_7),
            (45.0, 60.0, 105.0, 0.813_101_288_9),
            (60.0, 80.0, 90.0, 2.112_408_388_8),
        ] {
            let m = plane_parallel_air_mass(Angle::from_degrees(view).radians().cos());
            let value = clear.relative_to_zenith(
                m,
                Angle::from_degrees(gamma),
                1.0,
                Angle::from_degrees(sun),
            );
            assert!((value - expected).abs() < 1e-9);
        }
    }

    #[test]
    fn the_horizon_is_a_limit() {
        let m = plane_parallel_air_mass(0.0);
        assert!((LUMINANCE.gradation(m) - 1.0).abs() < 1e-15);
        let flat = PerezCoefficients { b: 0.0, ..X };
        assert!((flat.gradation(m) - (1.0 + X.a)).abs() < 1e-15);
    }

    #[test]
    fn the_check_names_what_is_wrong() {
        for c in [LUMINANCE, X, Y] {
            assert_eq!(c.check(1.0), Ok(()));
        }
        let b = PerezCoefficients {
            b: 0.1,
            ..LUMINANCE
        };
        assert!(matches!(
            b.check(1.0),
            Err(PerezDomainError::NotNegative { name: 'B', .. })
        ));
        // Preetham's slope and offset at T = 1.5: the gradation is negative near the zenith.
        let hazeless = PerezCoefficients {
            a: 0.1787 * 1.5 - 1.4630,
            b: -0.3554 * 1.5 + 0.4275,
            ..LUMINANCE
        };
        assert!(matches!(
            hazeless.check(1.0),
            Err(PerezDomainError::Gradation { .. })
        ));
        let dark = PerezCoefficients {
            c: -0.6,
            e: -0.5,
            ..X
        };
        assert!(matches!(
            dark.check(1.0),
            Err(PerezDomainError::Indicatrix { .. })
        ));
        let nan = PerezCoefficients { e: f64::NAN, ..X };
        assert!(matches!(
            nan.check(1.0),
            Err(PerezDomainError::NotFinite { name: 'E', .. })
        ));
    }

    #[test]
    fn plane_parallel_mass_ends_at_the_horizontal() {
        assert!((plane_parallel_air_mass(0.5) - 2.0).abs() < 1e-15);
        assert!(plane_parallel_air_mass(0.0).is_infinite());
        assert!(plane_parallel_air_mass(-0.1).is_infinite());
        assert!(plane_parallel_air_mass(f64::NAN).is_nan());
    }
}
