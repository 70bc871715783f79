//! T. Nishita, T. Sirai, K. Tadamura, E. Nakamae: Display of the Earth taking into account
//! atmospheric scattering, SIGGRAPH 1993; before it K. Kaneda et al. 1991.
//!
//! Single scattering by exponential air (scale height 7994 m) and aerosol (1.2 km) around a sphere,
//! integrated along the ray, at every point with the optical depth towards the sun (Eqs. 6–8). As the
//! paper assumes: no absorption, no light scattered twice, none from the ground (Sections 4.1, 4.3).
//! Here both integrals are marched; `nishita_table.rs` has the paper's table. Good for any observer
//! and sun, twilight included.
//!
//! Ours: Rayleigh scattering and haze of our atmosphere at its three wavelengths; the phase function
//! of Cornette & Shanks with u = 0.7, the end of the paper's 0.7–0.85 that is nearest to our haze
//! (mean cosine 0.65); the sampling. The paper's trapezoids between shells leave a first segment of
//! some 40 km on a level ray; here 48 segments crowd towards the ray's lowest point, each with its
//! own attenuation integrated exactly.

use sky_core::color::Yxy;
use sky_core::conditions::{Conditions, Domain, OutsideDomain};
use sky_core::direction::SkyDirection;
use sky_science::shader_sky::{ShaderFrame, ShaderSky};
use sky_science::sky_model::{SkyError, SkyModel};

use crate::atmosphere::Atmosphere;
use crate::ray::{self, EARTH_RADIUS, point, to_top_km};
use crate::texture::{single, singles};
use crate::view;
use sky_science::phase;

/// Ground to 50 km, day and twilight.
pub const DOMAIN: Domain = Domain {
    altitude_km: [0.0, 50.0],
    turbidity: [1.0, 10.0],
    sun_zenith_deg: [0.0, 108.0],
    below_horizontal: true,
};

/// Scale height of the air (Eq. 2) \[km\].
pub(crate) const AIR_SCALE_KM: f64 = 7.994;
/// Mean cosine of the aerosol's phase function.
pub(crate) const U: f64 = 0.7;

/// Segments of a ray from the observer down to its lowest point, and from there up.
const DOWN: u16 = 20;
const UP: u16 = 48;
/// Samples of a ray to the sun.
const TO_SUN: u16 = 12;

/// Nishita's sky, both integrals marched.
#[derive(Clone, Debug, Default)]
pub struct Nishita {
    air: SingleScattering,
}

/// The air of single scattering: exponential molecules and haze at three wavelengths.
#[derive(Clone, Debug)]
pub(crate) struct SingleScattering {
    pub(crate) atmosphere: Atmosphere,
    pub(crate) g: f64,
}

impl Default for SingleScattering {
    fn default() -> Self {
        Self::new(Atmosphere::default())
    }
}

impl SingleScattering {
    pub(crate) fn new(atmosphere: Atmosphere) -> Self {
        Self {
            atmosphere,
            g: phase::cornette_shanks_g(U),
        }
    }

    /// What depends on observer, haze and sun.
    pub(crate) fn frame(&self, conditions: &Conditions) -> Result<SingleFrame, OutsideDomain> {
        DOMAIN.check(conditions)?;
        let air = &self.atmosphere;
        Ok(SingleFrame {
            sun: view::sun(conditions),
            altitude_km: single(conditions.observer_altitude.km()),
            scale_km: singles([AIR_SCALE_KM, air.aerosol_scale_height_km]),
            rayleigh: singles(air.rayleigh_scattering_per_km),
            haze: singles(air.aerosol_extinction_per_km(conditions.turbidity)),
            g: single(self.g),
            matrix: air.matrix(),
        })
    }
}

/// Single scattering for one observer, haze and sun.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SingleFrame {
    pub(crate) sun: [f32; 2],
    pub(crate) altitude_km: f32,
    /// Scale heights of air and haze.
    pub(crate) scale_km: [f32; 2],
    /// Scattering at sea level \[km⁻¹\].
    pub(crate) rayleigh: [f32; 3],
    pub(crate) haze: [f32; 3],
    pub(crate) g: f32,
    pub(crate) matrix: [[f32; 3]; 3],
}

impl SingleFrame {
    /// Phase functions of air and haze.
    #[inline]
    pub(crate) fn phases(&self, cos_gamma: f32) -> [f32; 2] {
        let square = 1.0 + cos_gamma * cos_gamma;
        let g = self.g;
        let denominator = (1.0 - g) * (1.0 - g) + 2.0 * g * (1.0 - cos_gamma);
        let haze = 0.119_366_21 * (1.0 - g * g) / (2.0 + g * g) * square
            / (denominator * denominator.sqrt());
        [0.059_683_104 * square, haze]
    }

    /// Optical depths of a length of air and one of haze at sea level.
    #[inline]
    pub(crate) fn depth(&self, [air_km, haze_km]: [f32; 2]) -> [f32; 3] {
        core::array::from_fn(|k| self.rayleigh[k] * air_km + self.haze[k] * haze_km)
    }

    #[inline]
    fn densities(&self, altitude_km: f32) -> [f32; 2] {
        self.scale_km.map(|scale| (-altitude_km / scale).exp())
    }

    /// Equivalent lengths at sea level of the air and haze above a point, upwards.
    #[inline]
    fn columns_upward(&self, altitude_km: f32, cos_zenith: f32) -> [f32; 2] {
        let length = to_top_km(altitude_km, cos_zenith);
        let mut sums = [0.0; 2];
        for i in 0..TO_SUN {
            let u = (f32::from(i) + 0.5) / f32::from(TO_SUN);
            let [altitude, _] = point(altitude_km, cos_zenith, length * u * u * u);
            let density = self.densities(altitude);
            sums[0] += u * u * density[0];
            sums[1] += u * u * density[1];
        }
        sums.map(|s| s * 3.0 * length / f32::from(TO_SUN))
    }

    /// Equivalent lengths towards the sun, none in the Earth's shadow.
    #[inline]
    fn columns(&self, altitude_km: f32, cos_sun: f32) -> Option<[f32; 2]> {
        if cos_sun >= 0.0 {
            return Some(self.columns_upward(altitude_km, cos_sun));
        }
        let lowest = ray::lowest_km(altitude_km, cos_sun);
        if lowest < 0.0 {
            return None;
        }
        let [level, behind] = [
            self.columns_upward(lowest, 0.0),
            self.columns_upward(altitude_km, -cos_sun),
        ];
        Some([2.0 * level[0] - behind[0], 2.0 * level[1] - behind[1]])
    }

    /// CIE XYZ \[cd·m⁻²\] from a unit vector; `columns` gives the equivalent lengths of air and haze
    /// from an altitude towards the sun, by the cosine of its local zenith angle.
    #[inline]
    pub(crate) fn march(
        &self,
        v: [f32; 3],
        columns: impl Fn(f32, f32) -> Option<[f32; 2]>,
    ) -> [f32; 3] {
        let (altitude_km, cos_view) = (self.altitude_km, v[2]);
        if ray::meets_ground(altitude_km, cos_view) {
            return [0.0; 3];
        }
        let start = EARTH_RADIUS + altitude_km;
        let cos_gamma = view::cos_gamma(self.sun, v);
        let phases = self.phases(cos_gamma);
        let mut light = [0.0_f32; 3];
        let mut transmittance = [1.0_f32; 3];
        let mut from = 0.0_f32;
        let mut segment = |to: f32| {
            let step = to - from;
            let middle = from + 0.5 * step;
            from = to;
            let [altitude, radius] = point(altitude_km, cos_view, middle);
            let density = self.densities(altitude);
            let depth = self.depth([density[0] * step, density[1] * step]);
            let cos_sun = (start * self.sun[1] + middle * cos_gamma) / radius;
            let sunlit = columns(altitude, cos_sun).map(|c| self.depth(c));
            for k in 0..3 {
                let through = (-depth[k]).exp();
                if let Some(sun_depth) = sunlit {
                    let scattered = self.rayleigh[k] * density[0] * phases[0]
                        + self.haze[k] * density[1] * phases[1];
                    // ∫ exp(−τ) ds over the segment
                    let share = if depth[k] > 0.01 {
                        (1.0 - through) / depth[k]
                    } else {
                        1.0 - depth[k] * (0.5 - depth[k] / 6.0)
                    };
                    light[k] += transmittance[k] * scattered * share * step * (-sun_depth[k]).exp();
                }
                transmittance[k] *= through;
            }
        };
        let lowest = (-start * cos_view).max(0.0);
        if lowest > 0.0 {
            for i in 1..=DOWN {
                let u = 1.0 - f32::from(i) / f32::from(DOWN);
                segment(lowest * (1.0 - u * u));
            }
        }
        let rest = to_top_km(altitude_km, cos_view) - lowest;
        for i in 1..=UP {
            let u = f32::from(i) / f32::from(UP);
            segment(lowest + rest * u * u * u);
        }
        view::multiply(&self.matrix, light)
    }

    pub(crate) fn uniforms(&self) -> Vec<[f32; 4]> {
        let mut uniforms = vec![
            [self.sun[0], 0.0, self.sun[1], self.altitude_km],
            view::uniform(self.rayleigh, self.scale_km[0]),
            view::uniform(self.haze, self.scale_km[1]),
        ];
        uniforms.extend(self.matrix.map(|row| view::uniform(row, self.g)));
        uniforms
    }
}

impl Nishita {
    /// In another atmosphere.
    #[must_use]
    pub fn new(atmosphere: Atmosphere) -> Self {
        Self {
            air: SingleScattering::new(atmosphere),
        }
    }
}

impl SkyModel for Nishita {
    fn name(&self) -> &'static str {
        "nishita"
    }

    fn domain(&self) -> &Domain {
        &DOMAIN
    }

    fn yxy_map(
        &self,
        conditions: &Conditions,
        directions: &[SkyDirection],
    ) -> Result<Vec<Yxy>, SkyError> {
        let frame = self.air.frame(conditions)?;
        Ok(view::each(directions, |v| {
            frame.march(v, |altitude, cos_sun| frame.columns(altitude, cos_sun))
        }))
    }
}

impl ShaderSky for Nishita {
    fn shader(&self) -> &'static str {
        sky_shaders::baselines::NISHITA
    }

    fn shader_frame(&self, conditions: &Conditions) -> Result<ShaderFrame, OutsideDomain> {
        Ok(ShaderFrame {
            uniforms: self.air.frame(conditions)?.uniforms(),
            texture: None,
        })
    }

    fn table_bytes(&self) -> usize {
        0
    }
}

/// For tests: the same integrals in `f64`, with thousands of samples.
#[cfg(test)]
pub(crate) mod direct {
    use super::{AIR_SCALE_KM, SingleScattering};
    use crate::ray::Ray;
    use sky_core::conditions::Conditions;
    use sky_core::direction::SkyDirection;
    use sky_science::phase;
    use sky_science::sky_model::SkyModel;

    /// Samples of a substitution s = L u³ from the ray's lowest point.
    fn integrate(length: f64, samples: u32, mut f: impl FnMut(f64, f64)) {
        for i in 0..samples {
            let n = f64::from(samples);
            let (a, b) = (f64::from(i) / n, f64::from(i + 1) / n);
            let (a, b) = (length * a.powi(3), length * b.powi(3));
            f(0.5 * (a + b), b - a);
        }
    }

    pub(crate) fn columns(altitude_km: f64, cos_zenith: f64, haze_km: f64) -> Option<[f64; 2]> {
        let up = |ray: Ray| {
            let mut sums = [0.0; 2];
            integrate(ray.to_top_km(), 800, |s, step| {
                let [altitude, _] = ray.at(s);
                sums[0] += step * (-altitude / AIR_SCALE_KM).exp();
                sums[1] += step * (-altitude / haze_km).exp();
            });
            sums
        };
        let ray = Ray::new(altitude_km, cos_zenith);
        if cos_zenith >= 0.0 {
            return Some(up(ray));
        }
        if ray.meets_ground() {
            return None;
        }
        let [altitude, _] = ray.at(-(6371.0 + altitude_km) * cos_zenith);
        let (level, behind) = (
            up(Ray::new(altitude, 0.0)),
            up(Ray::new(altitude_km, -cos_zenith)),
        );
        Some([2.0 * level[0] - behind[0], 2.0 * level[1] - behind[1]])
    }

    /// Luminance \[cd·m⁻²\].
    pub(crate) fn luminance(
        air: &SingleScattering,
        conditions: &Conditions,
        direction: &SkyDirection,
    ) -> f64 {
        let atmosphere = &air.atmosphere;
        let haze_km = atmosphere.aerosol_scale_height_km;
        let haze = atmosphere.aerosol_extinction_per_km(conditions.turbidity);
        let rayleigh = atmosphere.rayleigh_scattering_per_km;
        let cos_view = direction.view_zenith.radians().cos();
        let cos_sun = conditions.sun_zenith.radians().cos();
        let nu = direction.cos_scattering_angle(conditions.sun_zenith);
        let phases = [phase::rayleigh(nu, 0.0), phase::cornette_shanks(nu, air.g)];
        let altitude_km = conditions.observer_altitude.km();
        let ray = Ray::new(altitude_km, cos_view);
        let lowest = (-(6371.0 + altitude_km) * cos_view).max(0.0);
        let mut places = Vec::new();
        integrate(lowest, if lowest > 0.0 { 800 } else { 0 }, |s, step| {
            places.push((lowest - s, step));
        });
        places.reverse();
        integrate(ray.to_top_km() - lowest, 800, |s, step| {
            places.push((lowest + s, step));
        });
        let mut depth = [0.0; 3];
        let mut light = [0.0; 3];
        for (s, step) in places {
            let [altitude, radius] = ray.at(s);
            let density = [
                (-altitude / AIR_SCALE_KM).exp(),
                (-altitude / haze_km).exp(),
            ];
            let sun = columns(altitude, ray.cos_light(s, radius, cos_sun, nu), haze_km);
            for k in 0..3 {
                let [r, m] = [rayleigh[k] * density[0], haze[k] * density[1]];
                let here = (r + m) * step;
                if let Some([a, b]) = sun {
                    let to_sun = rayleigh[k] * a + haze[k] * b;
                    light[k] += (r * phases[0] + m * phases[1])
                        * step
                        * (-(depth[k] + 0.5 * here) - to_sun).exp();
                }
                depth[k] += here;
            }
        }
        let row = atmosphere.xyz_from_radiance_ratio[1];
        row[0] * light[0] + row[1] * light[1] + row[2] * light[2]
    }

    /// Conditions and directions at which models of single scattering are compared.
    pub(crate) const CASES: [(f64, f64, f64); 8] = [
        (0.0, 1.0, 30.0),
        (0.0, 1.5, 60.0),
        (0.0, 3.0, 75.0),
        (0.0, 6.0, 88.0),
        (1.0, 3.0, 92.0),
        (3.0, 3.0, 40.0),
        (9.0, 3.0, 88.0),
        (25.0, 3.0, 92.0),
    ];

    /// Holds a model of single scattering against fine integration.
    pub(crate) fn compare(model: &dyn SkyModel, limit: impl Fn(f64) -> f64) {
        let air = SingleScattering::default();
        for (altitude, turbidity, sun) in CASES {
            let c = crate::shader_check::conditions(altitude, turbidity, sun);
            for zenith in view_zeniths(altitude) {
                for azimuth in [0.0, 120.0] {
                    let d = SkyDirection::from_degrees(zenith, azimuth);
                    let want = luminance(&air, &c, &d);
                    let found = model.yxy_map(&c, &[d]).unwrap()[0].luminance_cd_m2;
                    // below a thousandth of a candela the night is brighter
                    assert!(
                        (found - want).abs() < limit(turbidity) * want + 1e-3,
                        "{altitude} km, T {turbidity}, sun {sun}: {zenith}, {azimuth}: {found} {want}"
                    );
                }
            }
        }
    }

    /// View zeniths from the zenith to just above the geometric horizon.
    pub(crate) fn view_zeniths(altitude_km: f64) -> [f64; 6] {
        let dip =
            sky_core::direction::horizon_dip(sky_core::quantity::Length::from_km(altitude_km));
        [0.0, 40.0, 75.0, 87.0, 90.0, 89.9 + dip.degrees()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader_check::{self, conditions};

    #[test]
    fn agrees_with_fine_integration() {
        let nishita = Nishita::default();
        // 1 % everywhere but where haze hides the sun: 5 % at T = 6 with the sun at 88°.
        direct::compare(
            &nishita,
            |turbidity| if turbidity > 5.0 { 0.05 } else { 0.02 },
        );
    }

    #[test]
    fn single_scattering_of_the_reference() {
        // Reference: no aerosol, black ground, sun at 45°, zenith: 0.01506, 0.00738, 0.00401 sr⁻¹ at
        // 450, 550, 650 nm. Ours has 7994 m for 8453 m and no ozone: 5 % less air.
        let c = conditions(0.0, 1.0, 45.0);
        let mut frame = SingleScattering::default().frame(&c).unwrap();
        frame.rayleigh = [0.026_169_5, 0.011_488_8, 0.005_821_7];
        frame.matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let found = frame.march([0.0, 0.0, 1.0], |h, mu| frame.columns(h, mu));
        for (f, want) in found.iter().zip([0.015_06, 0.007_38, 0.004_01]) {
            assert!((f / want - 0.97).abs() < 0.03, "{f} {want}");
        }
    }

    #[test]
    fn the_earths_shadow_is_dark() {
        let frame = SingleScattering::default()
            .frame(&conditions(0.0, 2.0, 95.0))
            .unwrap();
        // Overhead the shadow reaches 24.3 km with the sun 5° below the horizon.
        assert!(frame.columns(23.5, frame.sun[1]).is_none());
        assert!(frame.columns(24.7, frame.sun[1]).is_some());
    }

    #[test]
    fn the_shader_is_valid() {
        shader_check::check(&Nishita::default(), &conditions(12.0, 3.0, 91.0));
    }
}
