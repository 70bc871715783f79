//! L. Hošek, A. Wilkie: An analytic model for full spectral sky-dome radiance, SIGGRAPH 2012.
//!
//! Eq. 8, F = (1 + A exp(B/(cos θ + 0.01))) (C + D exp(E γ) + F cos² γ + G χ(H, γ) + I √cos θ), times
//! the mean radiance; fitted for red, green and blue (sRGB primaries). The coefficients come from the
//! crate `hw-skymodel` 0.1.1 (MIT; its data set is the authors', 3-clause BSD). For an observer on the
//! ground, the sun above the horizon, their turbidity 1–10.
//!
//! Their turbidity is Preetham's: matched at equal aerosol optical depth, their 1–10 is our
//! 1.004–8.12. The data set's unit is that of CIE integrals without 683 lm/W, which is multiplied in
//! here. The paper's numbering of the coefficients differs from the data set's order: there the last
//! one is the g of χ.

use hw_skymodel::rgb::{SkyParams, SkyState};
use sky_core::color::XYZ_FROM_LINEAR_SRGB;
use sky_core::color::Yxy;
use sky_core::conditions::{Conditions, Domain, OutsideDomain, Quantity};
use sky_core::direction::SkyDirection;
use sky_core::quantity::LUMINOUS_EFFICACY_LM_PER_W;
use sky_science::shader_sky::{ShaderFrame, ShaderSky};
use sky_science::sky_model::{SkyError, SkyModel};

use crate::preetham::{preetham_turbidity, turbidity_from_preetham};
use crate::texture::{single, singles};
use crate::view;

/// Their turbidity 1–10, the ground, the sun above the horizon.
pub const DOMAIN: Domain = Domain {
    altitude_km: [0.0, 0.1],
    turbidity: [turbidity_from_preetham(1.0), turbidity_from_preetham(10.0)],
    sun_zenith_deg: [0.0, 90.0],
    below_horizontal: false,
};

/// Two albedos × ten turbidities × six control points × (nine coefficients and one radiance) × three
/// colors.
const TABLE_VALUES: usize = 2 * 10 * 6 * (9 + 1) * 3;

/// Hošek and Wilkie's sky.
#[derive(Clone, Copy, Debug)]
pub struct Hosek {
    ground_albedo: f32,
}

impl Default for Hosek {
    /// Over ground of albedo 0.2.
    fn default() -> Self {
        Self { ground_albedo: 0.2 }
    }
}

/// Their sky for one turbidity and sun.
#[derive(Clone, Copy, Debug)]
pub struct HosekFrame {
    sun: [f32; 2],
    /// The nine coefficients, each for red, green and blue.
    coefficients: [[f32; 3]; 9],
    /// Mean radiance times 683 lm/W.
    radiance: [f32; 3],
    xyz_from_rgb: [[f32; 3]; 3],
}

impl HosekFrame {
    /// CIE XYZ \[cd·m⁻²\] from a unit vector above the horizontal.
    #[must_use]
    #[inline]
    pub fn xyz(&self, v: [f32; 3]) -> [f32; 3] {
        if v[2] < view::HORIZONTAL {
            return [0.0; 3];
        }
        let (gamma, cos_gamma) = view::gamma(self.sun, v);
        let cos_2 = cos_gamma * cos_gamma;
        let [a, b, c, d, e, f, chi_share, root_share, g] = &self.coefficients;
        let cos_view = v[2].max(0.0);
        let (mass, root) = (1.0 / (cos_view + 0.01), cos_view.sqrt());
        let rgb = core::array::from_fn(|k| {
            let base = 1.0 + g[k] * g[k] - 2.0 * g[k] * cos_gamma;
            let chi = (1.0 + cos_2) / (base * base.sqrt());
            self.radiance[k]
                * (1.0 + a[k] * (b[k] * mass).exp())
                * (c[k]
                    + d[k] * (e[k] * gamma).exp()
                    + f[k] * cos_2
                    + chi_share[k] * chi
                    + root_share[k] * root)
        });
        view::multiply(&self.xyz_from_rgb, rgb)
    }
}

impl Hosek {
    /// What depends on turbidity and sun.
    ///
    /// # Errors
    /// When the conditions lie outside the domain.
    pub fn frame(&self, conditions: &Conditions) -> Result<HosekFrame, OutsideDomain> {
        DOMAIN.check(conditions)?;
        let turbidity = single(preetham_turbidity(conditions.turbidity)).clamp(1.0, 10.0);
        let quarter = core::f32::consts::FRAC_PI_2;
        let elevation = (quarter - single(conditions.sun_zenith.radians())).clamp(0.0, quarter);
        // The clamps undo rounding alone: the domain was checked.
        let state = SkyState::new(&SkyParams {
            elevation,
            turbidity,
            albedo: [self.ground_albedo; 3],
        });
        let (params, radiances) = state.map(|s| s.raw()).map_err(|_| OutsideDomain {
            quantity: Quantity::Turbidity,
            found: conditions.turbidity,
            expected: DOMAIN.turbidity,
        })?;
        let coefficients =
            core::array::from_fn(|k| core::array::from_fn(|color| params[9 * color + k]));
        Ok(HosekFrame {
            sun: view::sun(conditions),
            coefficients,
            radiance: radiances.map(|r| r * single(LUMINOUS_EFFICACY_LM_PER_W)),
            xyz_from_rgb: XYZ_FROM_LINEAR_SRGB.map(singles),
        })
    }
}

impl SkyModel for Hosek {
    fn name(&self) -> &'static str {
        "hosek"
    }

    fn domain(&self) -> &Domain {
        &DOMAIN
    }

    fn yxy_map(
        &self,
        conditions: &Conditions,
        directions: &[SkyDirection],
    ) -> Result<Vec<Yxy>, SkyError> {
        let frame = self.frame(conditions)?;
        Ok(view::each(directions, |v| frame.xyz(v)))
    }
}

impl ShaderSky for Hosek {
    fn shader(&self) -> &'static str {
        sky_shaders::baselines::HOSEK
    }

    fn shader_frame(&self, conditions: &Conditions) -> Result<ShaderFrame, OutsideDomain> {
        let frame = self.frame(conditions)?;
        let mut uniforms = vec![[frame.sun[0], 0.0, frame.sun[1], 0.0]];
        uniforms.extend(frame.coefficients.map(|c| view::uniform(c, 0.0)));
        uniforms.push(view::uniform(frame.radiance, 0.0));
        Ok(ShaderFrame {
            uniforms,
            texture: None,
        })
    }

    fn table_bytes(&self) -> usize {
        TABLE_VALUES * size_of::<f32>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader_check::{self, conditions};
    use hw_skymodel::rgb::Channel;

    #[test]
    fn agrees_with_the_crate() {
        for (turbidity, sun) in [(1.2, 20.0), (3.0, 45.0), (6.5, 85.0), (8.0, 90.0)] {
            let c = conditions(0.0, turbidity, sun);
            let frame = Hosek::default().frame(&c).unwrap();
            let state = SkyState::new(&SkyParams {
                elevation: core::f32::consts::FRAC_PI_2 - single(c.sun_zenith.radians()),
                turbidity: single(preetham_turbidity(turbidity)),
                albedo: [0.2; 3],
            })
            .unwrap_or_else(|e| panic!("{e}"));
            for (zenith, azimuth) in [(0.0, 0.0), (40.0, 30.0), (75.0, 180.0), (89.0, 5.0)] {
                let d = SkyDirection::from_degrees(zenith, azimuth);
                let theta = single(d.view_zenith.radians());
                let gamma = single(d.scattering_angle(c.sun_zenith).radians());
                let rgb = [Channel::R, Channel::G, Channel::B]
                    .map(|channel| 683.002 * state.radiance(theta, gamma, channel));
                let want = view::multiply(&XYZ_FROM_LINEAR_SRGB.map(singles), rgb);
                let found = frame.xyz(view::unit_vector(&d));
                for (f, w) in found.iter().zip(want) {
                    assert!((f / w - 1.0).abs() < 3e-5, "{sun} {zenith}: {f} {w}");
                }
            }
        }
    }

    #[test]
    fn the_crate_holds_the_authors_numbers() {
        // First coefficient of the published red set: albedo 0, turbidity 1, sun at the horizon.
        let state = SkyState::new(&SkyParams {
            elevation: 0.0,
            turbidity: 1.0,
            albedo: [0.0; 3],
        });
        let (params, _) = state.unwrap_or_else(|e| panic!("{e}")).raw();
        assert!((params[0] + 1.099_459).abs() < 1e-6, "{}", params[0]);
    }

    #[test]
    fn its_unit_is_the_candela() {
        // Zenith at T = 3, sun at 60°: the transport engine has 2789 cd·m⁻² (Preetham 5970).
        let c = conditions(0.0, 3.0, 60.0);
        let up = [SkyDirection::from_degrees(0.0, 0.0)];
        let hosek = Hosek::default().yxy_map(&c, &up).unwrap()[0];
        assert!(
            (hosek.luminance_cd_m2 / 2789.0).ln().abs() < 0.25,
            "{hosek:?}"
        );
        assert!((hosek.x - 0.271).abs() < 0.03 && (hosek.y - 0.281).abs() < 0.03);
    }

    #[test]
    fn the_shader_is_valid() {
        shader_check::check(&Hosek::default(), &conditions(0.0, 3.0, 45.0));
    }
}
