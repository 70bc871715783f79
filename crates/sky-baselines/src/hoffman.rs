//! N. Hoffman, A. J. Preetham: Rendering outdoor light scattering in real time, GDC 2002.
//!
//! Air of constant density: `F_ex = exp(−(β_R + β_M) s)`,
//! `L_in = (β_R(γ) + β_M(γ))/(β_R + β_M) E_sun (1 − F_ex)` (their Eqs. 1–3). For an observer on the
//! ground, the sun above the horizon.
//!
//! What the paper leaves open, and how it is read here. `β_R` is their formula (n = 1.0003,
//! N = 2.545e25 m⁻³, p = 0.035) at the wavelengths of our atmosphere; it gives their
//! (6.95, 11.8, 24.4)e-6 m⁻¹ at 650, 570, 475 nm. The sky is the path to the top of a layer of 8.4 km
//! around the Earth, so that `β_R` makes the air's vertical optical depth; the haze's `β_M` is its optical
//! depth over the same height. The sun's color is not given: it is the sun of our atmosphere behind
//! air and haze. Their g is 0.75–0.9; 0.75 is used. The shader's (1 − g)² for the numerator of the
//! phase function is a slip and is not followed. Their c(T) has a power of ten wrong (1e-16 for
//! 1e-18) and is not needed.

use sky_core::air_mass::relative_air_mass;
use sky_core::color::Yxy;
use sky_core::conditions::{Conditions, Domain, OutsideDomain};
use sky_core::direction::SkyDirection;
use sky_core::quantity::{EARTH_RADIUS_KM, Length};
use sky_science::shader_sky::{ShaderFrame, ShaderSky};
use sky_science::sky_model::{SkyError, SkyModel};

use crate::aerial::Aerial;
use crate::atmosphere::Atmosphere;
use crate::texture::{single, singles};
use crate::view;

/// The ground, the sun above the horizon.
pub const DOMAIN: Domain = Domain {
    altitude_km: [0.0, 0.1],
    turbidity: [1.0, 10.0],
    sun_zenith_deg: [0.0, 90.0],
    below_horizontal: false,
};

/// Height of the layer \[km\].
const LAYER_KM: f64 = 8.4;
/// Asymmetry of the haze.
const G: f32 = 0.75;

/// Rayleigh scattering of their formula \[km⁻¹\]:
/// 8π³ (n² − 1)²/(3 N λ⁴) · (6 + 3p)/(6 − 7p).
#[must_use]
pub fn rayleigh_per_km(wavelength_nm: f64) -> f64 {
    let (n, molecules, p) = (1.0003_f64, 2.545e25, 0.035);
    let wavelength_m = wavelength_nm * 1e-9;
    let pi = core::f64::consts::PI;
    let index = n * n - 1.0;
    let per_m = 8.0 * pi * pi * pi * index * index / (3.0 * molecules * wavelength_m.powi(4))
        * (6.0 + 3.0 * p)
        / (6.0 - 7.0 * p);
    1e3 * per_m
}

/// Their sky.
#[derive(Clone, Debug, Default)]
pub struct Hoffman {
    atmosphere: Atmosphere,
}

/// Their sky for one haze and sun.
#[derive(Clone, Copy, Debug)]
pub struct HoffmanFrame {
    sun: [f32; 2],
    rayleigh: [f32; 3],
    haze: [f32; 3],
    sunlight: [f32; 3],
    g: f32,
    matrix: [[f32; 3]; 3],
}

/// 2 R H + H² of the layer \[km²\].
const LAYER_RISE: f64 = LAYER_KM * (2.0 * EARTH_RADIUS_KM + LAYER_KM);

impl HoffmanFrame {
    /// Transmittance and CIE XYZ \[cd·m⁻²\] of the light added to a path from a unit vector.
    #[inline]
    fn path(&self, v: [f32; 3], distance_km: f32) -> ([f32; 3], [f32; 3]) {
        let cos_gamma = view::cos_gamma(self.sun, v);
        let g = self.g;
        let denominator = (1.0 - g) * (1.0 - g) + 2.0 * g * (1.0 - cos_gamma);
        let rayleigh_phase = 0.059_683_104 * (1.0 + cos_gamma * cos_gamma);
        let haze_phase = 0.079_577_47 * (1.0 - g * g) / (denominator * denominator.sqrt());
        let transmittance: [f32; 3] =
            core::array::from_fn(|k| (-(self.rayleigh[k] + self.haze[k]) * distance_km).exp());
        let ratio = core::array::from_fn(|k| {
            (self.rayleigh[k] * rayleigh_phase + self.haze[k] * haze_phase)
                / (self.rayleigh[k] + self.haze[k])
                * self.sunlight[k]
                * (1.0 - transmittance[k])
        });
        (transmittance, view::multiply(&self.matrix, ratio))
    }

    /// CIE XYZ \[cd·m⁻²\] from a unit vector above the horizontal.
    #[must_use]
    #[inline]
    pub fn xyz(&self, v: [f32; 3]) -> [f32; 3] {
        if v[2] < view::HORIZONTAL {
            return [0.0; 3];
        }
        let rise = single(LAYER_RISE);
        let along = single(EARTH_RADIUS_KM) * v[2];
        let distance_km = rise / (along + (along * along + rise).sqrt());
        self.path(v, distance_km).1
    }
}

impl Hoffman {
    /// In another atmosphere.
    #[must_use]
    pub const fn new(atmosphere: Atmosphere) -> Self {
        Self { atmosphere }
    }

    /// What depends on haze and sun.
    ///
    /// # Errors
    /// When the conditions lie outside the domain.
    pub fn frame(&self, conditions: &Conditions) -> Result<HoffmanFrame, OutsideDomain> {
        DOMAIN.check(conditions)?;
        let air = &self.atmosphere;
        let rayleigh = air.wavelength_nm.map(rayleigh_per_km);
        let haze = air
            .aerosol_optical_depth(conditions.turbidity)
            .map(|depth| depth / LAYER_KM);
        let cos_sun = conditions.sun_zenith.radians().cos();
        let mass = |km| relative_air_mass(cos_sun, Length::ZERO, Length::from_km(km));
        let (air_mass, haze_mass) = (mass(LAYER_KM), mass(air.aerosol_scale_height_km));
        let sunlight = core::array::from_fn(|k| {
            (-(rayleigh[k] * air_mass + haze[k] * haze_mass) * LAYER_KM).exp()
        });
        Ok(HoffmanFrame {
            sun: view::sun(conditions),
            rayleigh: singles(rayleigh),
            haze: singles(haze),
            sunlight: singles(sunlight),
            g: G,
            matrix: air.matrix(),
        })
    }

    /// Aerial perspective of a path along the ground.
    ///
    /// # Errors
    /// When the conditions lie outside the domain.
    pub fn aerial(
        &self,
        conditions: &Conditions,
        direction: &SkyDirection,
        distance: Length,
    ) -> Result<Aerial, OutsideDomain> {
        let frame = self.frame(conditions)?;
        let (transmittance, xyz) = frame.path(view::unit_vector(direction), single(distance.km()));
        Ok(Aerial::new(transmittance, xyz))
    }
}

impl SkyModel for Hoffman {
    fn name(&self) -> &'static str {
        "hoffman"
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

impl ShaderSky for Hoffman {
    fn shader(&self) -> &'static str {
        sky_shaders::baselines::HOFFMAN
    }

    fn shader_frame(&self, conditions: &Conditions) -> Result<ShaderFrame, OutsideDomain> {
        let frame = self.frame(conditions)?;
        let mut uniforms = vec![
            [frame.sun[0], 0.0, frame.sun[1], 0.0],
            view::uniform(frame.rayleigh, single(LAYER_RISE)),
            view::uniform(frame.haze, single(EARTH_RADIUS_KM)),
            view::uniform(frame.sunlight, frame.g),
        ];
        uniforms.extend(frame.matrix.map(|row| view::uniform(row, 0.0)));
        Ok(ShaderFrame {
            uniforms,
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
    use sky_science::phase;

    #[test]
    fn published_coefficients() {
        for (nm, per_m) in [(650.0, 6.95e-6), (570.0, 1.18e-5), (475.0, 2.44e-5)] {
            assert!((rayleigh_per_km(nm) / 1e3 / per_m - 1.0).abs() < 4e-3);
        }
    }

    #[test]
    fn published_check_values() {
        // g = 0.75, β_M = 2e-6 m⁻¹, E_sun = 1: path \[km\], angle \[deg\], F_ex, L_in.
        let identity = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let frame = HoffmanFrame {
            sun: [0.0, 1.0],
            rayleigh: [6.95e-3, 1.18e-2, 2.44e-2],
            haze: [2e-3; 3],
            sunlight: [1.0; 3],
            g: 0.75,
            matrix: identity,
        };
        for (km, angle, transmittance, light) in [
            (
                10.0,
                0.0,
                [0.914_388, 0.871_099, 0.767_974],
                [0.050_562_9, 0.054_781_8, 0.064_764_2],
            ),
            (
                10.0,
                90.0,
                [0.914_388, 0.871_099, 0.767_974],
                [0.004_308_79, 0.006_911_27, 0.013_112_3],
            ),
            (
                50.0,
                45.0,
                [0.639_224, 0.501_576, 0.267_135],
                [0.032_976_1, 0.045_228_5, 0.066_076_2],
            ),
        ] {
            let v = view::unit_vector(&SkyDirection::from_degrees(angle, 0.0));
            let (found_t, found_l) = frame.path(v, km);
            for k in 0..3 {
                assert!((f64::from(found_t[k]) - transmittance[k]).abs() < 2e-6);
                assert!((f64::from(found_l[k]) / light[k] - 1.0).abs() < 1e-5);
            }
        }
    }

    #[test]
    fn the_phase_functions_are_the_normalized_ones() {
        let mu = 0.3_f64;
        assert!((0.059_683_104 * (1.0 + mu * mu) - phase::rayleigh(mu, 0.0)).abs() < 1e-8);
        assert!((0.079_577_47 - phase::henyey_greenstein(mu, 0.0)).abs() < 1e-8);
    }

    #[test]
    fn the_sky_is_a_path_through_the_layer() {
        let hoffman = Hoffman::default();
        let c = conditions(0.0, 2.0, 50.0);
        for (zenith, km) in [(0.0, 8.4), (90.0, 327.268)] {
            let d = SkyDirection::from_degrees(zenith, 60.0);
            let sky = hoffman.yxy_map(&c, &[d]).unwrap()[0];
            let path = hoffman.aerial(&c, &d, Length::from_km(km)).unwrap();
            assert!((path.in_scattered.y / sky.luminance_cd_m2 - 1.0).abs() < 1e-4);
        }
    }

    #[test]
    fn the_shader_is_valid() {
        shader_check::check(&Hoffman::default(), &conditions(0.0, 3.0, 45.0));
    }
}
