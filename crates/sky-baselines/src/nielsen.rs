//! R. S. Nielsen: Real time rendering of atmospheric scattering effects for flight simulators,
//! master's thesis, DTU 2003.
//!
//! **Second-hand.** The thesis could not be obtained. This is one of two readings found in public
//! shaders that cite it: Hoffman and Preetham's light with separate lengths for air and haze,
//! `s_R = lerp(s_h, 8 km·exp(−h/8 km), f)`, `s_M = lerp(s_h, 1.2 km·exp(−h/1.2 km), f)`,
//! f = clamp(cos θ + offset, 0.001, 1)^haziness, horizon length `s_h` = (1 − f)·190 km;
//! `β_R` = (5.8, 13.5, 33.1)e-6 m⁻¹ at 680, 550, 440 nm; Rayleigh's phase with 1 + ½ cos² γ, which
//! integrates to 7/8 (kept, as published). Haziness 0.5 and offset 0 are used, g = 0.75. The print of
//! the Henyey–Greenstein function lacks a g; the normalized function is used.
//!
//! Ours: haze of equal aerosol optical depth with the spectrum of our atmosphere; the sun's color
//! behind air and haze; color by a matrix fitted for these three wavelengths, as described in
//! `atmosphere.rs` (rms 2.3 % in X, 0.7 % in Y, 2.8 % in Z); the lengths of finite paths, which are
//! missing from every source: the mean of an exponential over the path, exactly.

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

/// Ground to 30 km, the sun above the horizon. Below the horizontal the cosine is clamped, and the
/// sky goes on down to the geometric horizon.
pub const DOMAIN: Domain = Domain {
    altitude_km: [0.0, 30.0],
    turbidity: [1.0, 10.0],
    sun_zenith_deg: [0.0, 90.0],
    below_horizontal: true,
};

/// Rayleigh scattering \[km⁻¹\] at 680, 550, 440 nm.
const RAYLEIGH_PER_KM: [f64; 3] = [5.8e-3, 13.5e-3, 33.1e-3];
/// Zenith lengths at the ground, and their scale heights \[km\].
const AIR_KM: f64 = 8.0;
const HAZE_KM: f64 = 1.2;
/// Length towards the horizon \[km\].
const HORIZON_KM: f32 = 190.0;
const HAZINESS: f32 = 0.5;
const G: f32 = 0.75;

/// Rural aerosol at 680, 550, 440 nm: extinction over that at 500 nm.
const HAZE_OVER_500: [f64; 3] = [0.704_540, 0.912_412, 1.130_820];

/// CIE XYZ \[cd·m⁻²\] of radiances over solar irradiance at 680, 550, 440 nm; fitted.
const XYZ_FROM_RADIANCE_RATIO: [[f64; 3]; 3] = [
    [12_440.195_8, 98_175.302_7, 11_278.783_5],
    [6_690.748_4, 118_877.181_8, 4_615.009_5],
    [5_430.372_4, 20_827.588_8, 114_913.845_9],
];

/// Nielsen's sky.
#[derive(Clone, Debug, Default)]
pub struct Nielsen {
    atmosphere: Atmosphere,
}

/// Nielsen's sky for one observer, haze and sun.
#[derive(Clone, Copy, Debug)]
pub struct NielsenFrame {
    sun: [f32; 2],
    altitude_km: f32,
    zenith_km: [f32; 2],
    rayleigh: [f32; 3],
    haze: [f32; 3],
    sunlight: [f32; 3],
    matrix: [[f32; 3]; 3],
}

impl NielsenFrame {
    #[inline]
    fn path(&self, v: [f32; 3], air_km: f32, haze_km: f32) -> ([f32; 3], [f32; 3]) {
        let cos_gamma = view::cos_gamma(self.sun, v);
        let denominator = (1.0 - G) * (1.0 - G) + 2.0 * G * (1.0 - cos_gamma);
        let rayleigh_phase = 0.059_683_104 * (1.0 + 0.5 * cos_gamma * cos_gamma);
        let haze_phase = 0.079_577_47 * (1.0 - G * G) / (denominator * denominator.sqrt());
        let transmittance: [f32; 3] =
            core::array::from_fn(|k| (-(self.rayleigh[k] * air_km + self.haze[k] * haze_km)).exp());
        let ratio = core::array::from_fn(|k| {
            (self.rayleigh[k] * rayleigh_phase + self.haze[k] * haze_phase)
                / (self.rayleigh[k] + self.haze[k])
                * self.sunlight[k]
                * (1.0 - transmittance[k])
        });
        (transmittance, view::multiply(&self.matrix, ratio))
    }

    /// Lengths through air and haze of the whole path \[km\].
    #[inline]
    fn lengths(&self, cos_view: f32) -> [f32; 2] {
        let f = cos_view.clamp(0.001, 1.0).powf(HAZINESS);
        let horizon_km = (1.0 - f) * HORIZON_KM;
        self.zenith_km
            .map(|zenith| horizon_km + f * (zenith - horizon_km))
    }

    /// CIE XYZ \[cd·m⁻²\] from a unit vector above the geometric horizon.
    #[must_use]
    #[inline]
    pub fn xyz(&self, v: [f32; 3]) -> [f32; 3] {
        if crate::ray::meets_ground(self.altitude_km, v[2]) {
            return [0.0; 3];
        }
        let [air_km, haze_km] = self.lengths(v[2]);
        self.path(v, air_km, haze_km).1
    }
}

/// Mean of exp(−z/H) over a path that climbs by `rise`, times the path \[km\].
fn optical_length(distance: f32, rise: f32, altitude: f32, scale: f32) -> f32 {
    let delta = rise / scale;
    let mean = if delta.abs() > 1e-3 {
        -(-delta).exp_m1() / delta
    } else {
        1.0 - 0.5 * delta
    };
    distance * (-altitude / scale).exp() * mean
}

impl Nielsen {
    /// With the haze of another atmosphere.
    #[must_use]
    pub const fn new(atmosphere: Atmosphere) -> Self {
        Self { atmosphere }
    }

    /// What depends on observer, haze and sun.
    ///
    /// # Errors
    /// When the conditions lie outside the domain.
    pub fn frame(&self, conditions: &Conditions) -> Result<NielsenFrame, OutsideDomain> {
        DOMAIN.check(conditions)?;
        let depth_500 = sky_core::haze::optical_depth_500_from_turbidity(conditions.turbidity);
        let scale_km = self.atmosphere.aerosol_scale_height_km;
        let haze = HAZE_OVER_500.map(|e| e * depth_500 / scale_km);
        let altitude = conditions.observer_altitude;
        let zenith_km = [AIR_KM, HAZE_KM].map(|km| km * (-altitude.km() / km).exp());
        let cos_sun = conditions.sun_zenith.radians().cos();
        let mass = |km| relative_air_mass(cos_sun, altitude, Length::from_km(km));
        let (air_km, haze_km) = (zenith_km[0] * mass(AIR_KM), zenith_km[1] * mass(HAZE_KM));
        let sunlight =
            core::array::from_fn(|k| (-(RAYLEIGH_PER_KM[k] * air_km + haze[k] * haze_km)).exp());
        Ok(NielsenFrame {
            sun: view::sun(conditions),
            altitude_km: single(altitude.km()),
            zenith_km: singles(zenith_km),
            rayleigh: singles(RAYLEIGH_PER_KM),
            haze: singles(haze),
            sunlight: singles(sunlight),
            matrix: XYZ_FROM_RADIANCE_RATIO.map(singles),
        })
    }

    /// Aerial perspective of a finite path.
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
        let v = view::unit_vector(direction);
        let km = single(distance.km());
        let length = |scale| optical_length(km, km * v[2], frame.altitude_km, single(scale));
        let (transmittance, xyz) = frame.path(v, length(AIR_KM), length(HAZE_KM));
        Ok(Aerial::new(transmittance, xyz))
    }
}

impl SkyModel for Nielsen {
    fn name(&self) -> &'static str {
        "nielsen"
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

impl ShaderSky for Nielsen {
    fn shader(&self) -> &'static str {
        sky_shaders::baselines::NIELSEN
    }

    fn shader_frame(&self, conditions: &Conditions) -> Result<ShaderFrame, OutsideDomain> {
        let frame = self.frame(conditions)?;
        let mut uniforms = vec![
            [frame.sun[0], 0.0, frame.sun[1], frame.altitude_km],
            view::uniform(frame.rayleigh, frame.zenith_km[0]),
            view::uniform(frame.haze, frame.zenith_km[1]),
            view::uniform(frame.sunlight, G),
        ];
        uniforms.extend(frame.matrix.map(|row| view::uniform(row, HAZINESS)));
        debug_assert!(
            (EARTH_RADIUS_KM - 6371.0).abs() < 1e-9,
            "the shader's radius"
        );
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

    #[test]
    fn published_lengths_at_the_horizon() {
        // Haziness 0.5 at 89°: 144 km of air and 143 km of haze, where 199 and 50 would be right.
        let frame = Nielsen::default()
            .frame(&conditions(0.0, 2.0, 45.0))
            .unwrap();
        let cos = single(SkyDirection::from_degrees(89.0, 0.0).view_zenith.radians()).cos();
        let [air, haze] = frame.lengths(cos);
        assert!(
            (air - 144.0).abs() < 1.0 && (haze - 143.0).abs() < 1.0,
            "{air} {haze}"
        );
        let [air, haze] = frame.lengths(1.0);
        assert!((air - 8.0).abs() < 1e-5 && (haze - 1.2).abs() < 1e-5);
    }

    #[test]
    fn optical_lengths_of_finite_paths() {
        // β₀, H, z₁, z₂, s, τ.
        for (beta, scale, from, to, s, depth) in [
            (0.011_489, 8.45, 0.0, 5.0, 10.0, 0.086_718_174_6),
            (0.011_489, 8.45, 5.0, 0.0, 10.0, 0.086_718_174_6),
            (0.011_489, 8.45, 1.0, 1.0, 20.0, 0.204_134_508_9),
            (0.011_489, 8.45, 30.0, 0.0, 40.0, 0.125_725_637_4),
            (0.4167, 1.2, 0.0, 3.0, 20.0, 3.059_961_449),
        ] {
            let found = beta * f64::from(optical_length(s, to - from, from, scale));
            assert!((found / depth - 1.0).abs() < 3e-6, "{found} {depth}");
        }
    }

    #[test]
    fn the_shader_is_valid() {
        shader_check::check(&Nielsen::default(), &conditions(12.0, 3.0, 45.0));
    }
}
