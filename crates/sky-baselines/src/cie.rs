//! The CIE's standard skies of 1955 and 1973: overcast (Moon & Spencer 1942) and clear (Kittler
//! 1967), for an observer on the ground.
//!
//! Both give luminance alone; the chromaticity here is that of D65 everywhere and means nothing. Both
//! give it relative to the zenith. The zenith of the clear sky is Preetham's, at equal aerosol
//! optical depth; that of the overcast sky is 9/(7π) times the illuminance 300 + 21000 sin γs lx
//! (Krochmann & Seidl 1974), whatever the turbidity. The pattern of the clear sky is one for all
//! hazes.

use sky_core::color::Yxy;
use sky_core::conditions::{Conditions, Domain, OutsideDomain};
use sky_core::direction::SkyDirection;
use sky_science::shader_sky::{ShaderFrame, ShaderSky};
use sky_science::sky_model::{SkyError, SkyModel};

use crate::preetham::{self, preetham_turbidity, zenith_luminance_cd_m2};
use crate::texture::single;
use crate::view;

/// Chromaticity of D65 (CIE 15).
const D65: [f64; 2] = [0.3127, 0.3290];

/// Domain of the clear sky: that of the zenith luminance.
pub const CLEAR_DOMAIN: Domain = preetham::DOMAIN;

/// Domain of the overcast sky; the turbidity has no say.
pub const OVERCAST_DOMAIN: Domain = Domain {
    altitude_km: [0.0, 0.1],
    turbidity: [1.0, 10.0],
    sun_zenith_deg: [0.0, 90.0],
    below_horizontal: false,
};

/// Cosines below this are read as this.
const LEAST_COSINE: f32 = 1e-4;

/// Kittler's clear sky.
#[derive(Clone, Copy, Debug, Default)]
pub struct CieClear;

/// Moon and Spencer's overcast sky.
#[derive(Clone, Copy, Debug, Default)]
pub struct CieOvercast;

fn gray(luminance: f32) -> Yxy {
    Yxy {
        luminance_cd_m2: luminance.into(),
        x: D65[0],
        y: D65[1],
    }
}

/// 0.91 + 10 exp(−3γ) + 0.45 cos² γ.
fn clear_indicatrix(gamma: f32, cos_gamma: f32) -> f32 {
    0.91 + 10.0 * (-3.0 * gamma).exp() + 0.45 * cos_gamma * cos_gamma
}

/// 1 − exp(−0.32/cos θ).
fn clear_gradation(cos_view: f32) -> f32 {
    -(-0.32 / cos_view.max(LEAST_COSINE)).exp_m1()
}

impl CieClear {
    /// The sun's sine and cosine, and the zenith's luminance over the pattern's value there.
    fn frame(conditions: &Conditions) -> Result<([f32; 2], f32), OutsideDomain> {
        CLEAR_DOMAIN.check(conditions)?;
        let angle = conditions.sun_zenith.radians();
        let zenith = zenith_luminance_cd_m2(preetham_turbidity(conditions.turbidity), angle);
        let sun = view::sun(conditions);
        let pattern = clear_indicatrix(single(angle), sun[1]) * clear_gradation(1.0);
        Ok((sun, single(zenith) / pattern))
    }
}

impl SkyModel for CieClear {
    fn name(&self) -> &'static str {
        "cie-clear"
    }

    fn domain(&self) -> &Domain {
        &CLEAR_DOMAIN
    }

    fn yxy_map(
        &self,
        conditions: &Conditions,
        directions: &[SkyDirection],
    ) -> Result<Vec<Yxy>, SkyError> {
        let (sun, scale) = Self::frame(conditions)?;
        let light = |d| {
            let v = view::unit_vector(d);
            if v[2] < view::HORIZONTAL {
                return Yxy::default();
            }
            let (gamma, cos_gamma) = view::gamma(sun, v);
            gray(scale * clear_indicatrix(gamma, cos_gamma) * clear_gradation(v[2]))
        };
        Ok(directions.iter().map(light).collect())
    }
}

impl ShaderSky for CieClear {
    fn shader(&self) -> &'static str {
        sky_shaders::baselines::CIE_CLEAR
    }

    fn shader_frame(&self, conditions: &Conditions) -> Result<ShaderFrame, OutsideDomain> {
        let (sun, scale) = Self::frame(conditions)?;
        Ok(ShaderFrame {
            uniforms: vec![[sun[0], 0.0, sun[1], scale]],
            texture: None,
        })
    }

    fn table_bytes(&self) -> usize {
        0
    }
}

impl CieOvercast {
    fn zenith(conditions: &Conditions) -> Result<f32, OutsideDomain> {
        OVERCAST_DOMAIN.check(conditions)?;
        let sine_of_elevation = conditions.sun_zenith.radians().cos().max(0.0);
        let illuminance_lx = 300.0 + 21_000.0 * sine_of_elevation;
        Ok(single(9.0 / (7.0 * core::f64::consts::PI) * illuminance_lx))
    }
}

impl SkyModel for CieOvercast {
    fn name(&self) -> &'static str {
        "cie-overcast"
    }

    fn domain(&self) -> &Domain {
        &OVERCAST_DOMAIN
    }

    fn yxy_map(
        &self,
        conditions: &Conditions,
        directions: &[SkyDirection],
    ) -> Result<Vec<Yxy>, SkyError> {
        let zenith = Self::zenith(conditions)?;
        let light = |d: &SkyDirection| {
            let cos_view = single(d.view_zenith.radians()).cos();
            if cos_view < view::HORIZONTAL {
                return Yxy::default();
            }
            gray(zenith * (1.0 + 2.0 * cos_view) / 3.0)
        };
        Ok(directions.iter().map(light).collect())
    }
}

impl ShaderSky for CieOvercast {
    fn shader(&self) -> &'static str {
        sky_shaders::baselines::CIE_OVERCAST
    }

    fn shader_frame(&self, conditions: &Conditions) -> Result<ShaderFrame, OutsideDomain> {
        Ok(ShaderFrame {
            uniforms: vec![[0.0, 0.0, 0.0, Self::zenith(conditions)?]],
            texture: None,
        })
    }

    fn table_bytes(&self) -> usize {
        0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader_check::{self, conditions};
    use sky_core::quantity::Angle;

    #[test]
    fn clear_check_values() {
        // Sun, view zenith, angle between them \[deg\]: luminance over that of the zenith.
        for (sun, zenith, gamma, want) in [
            (45.0, 0.0, 45.0, 1.0),
            (45.0, 60.0, 15.0, 4.880_780_579_7),
            (45.0, 60.0, 105.0, 0.813_101_288_9),
            (60.0, 80.0, 90.0, 2.112_408_388_9),
        ] {
            let sun_angle = Angle::from_degrees(sun);
            let cos = |degrees: f64| Angle::from_degrees(degrees).radians().cos();
            let at = |gamma: f64, zenith: f64| {
                clear_indicatrix(
                    single(Angle::from_degrees(gamma).radians()),
                    single(cos(gamma)),
                ) * clear_gradation(single(cos(zenith)))
            };
            let found = f64::from(at(gamma, zenith) / at(sun_angle.degrees(), 0.0));
            assert!((found / want - 1.0).abs() < 2e-6, "{found} {want}");
        }
    }

    #[test]
    fn clear_zenith_is_preethams() {
        let c = conditions(0.0, 3.0, 45.0);
        let up = [SkyDirection::from_degrees(0.0, 0.0)];
        let clear = CieClear.yxy_map(&c, &up).unwrap()[0];
        let preetham = preetham::Preetham.yxy_map(&c, &up).unwrap()[0];
        assert!((clear.luminance_cd_m2 / preetham.luminance_cd_m2 - 1.0).abs() < 1e-6);
        assert!((clear.x - 0.3127).abs() < 1e-9);
    }

    #[test]
    fn overcast_check_values() {
        let c = conditions(0.0, 3.0, 30.0);
        let directions = [0.0, 60.0, 85.0, 90.0].map(|z| SkyDirection::from_degrees(z, 70.0));
        let sky = CieOvercast.yxy_map(&c, &directions).unwrap();
        let zenith = sky[0].luminance_cd_m2;
        for (found, want) in sky
            .iter()
            .zip([1.0, 0.666_666_666_7, 0.391_437_161_8, 1.0 / 3.0])
        {
            assert!((found.luminance_cd_m2 / zenith - want).abs() < 1e-6);
        }
        // Horizontal illuminance of (1 + 2 cos θ)/3 is 7π/9 of the zenith's luminance.
        let steps = 20_000_u32;
        let step = core::f64::consts::FRAC_PI_2 / f64::from(steps);
        let sum: f64 = (0..steps)
            .map(|i| {
                let (sin, cos) = ((f64::from(i) + 0.5) * step).sin_cos();
                2.0 * core::f64::consts::PI * step * sin * cos * (1.0 + 2.0 * cos) / 3.0
            })
            .sum();
        let illuminance = 300.0 + 21_000.0 * Angle::from_degrees(30.0).radians().cos();
        assert!((zenith * sum / illuminance - 1.0).abs() < 1e-5);
    }

    #[test]
    fn the_shaders_are_valid() {
        shader_check::check(&CieClear, &conditions(0.0, 3.0, 45.0));
        shader_check::check(&CieOvercast, &conditions(0.0, 3.0, 45.0));
    }
}
