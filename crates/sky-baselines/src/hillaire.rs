//! S. Hillaire: A scalable and production ready sky and atmosphere rendering technique, EGSR 2020.
//!
//! Three tables on the CPU: transmittance 256 × 64 (Section 5.2 and Bruneton's mapping), multiple
//! scattering 32 × 32 (Section 5.5: isotropic, the series of all orders summed as 1/(1 − `f_ms`)), and
//! for a frame the sky view 192 × 108 (Section 5.3), which alone the shader reads, once a pixel.
//! Steps as published: 40, 20 in 64 directions, 30.
//!
//! The air is ours at three wavelengths, so that the comparison is of methods; the first order keeps
//! the full phase functions. Where this differs from the published shader: mappings are inverse pairs
//! (its sub-texel pair is not); all steps grow with the square of their number, which it does in some
//! passes only (40 equal steps of a zenith ray put haze of 1.2 km scale height 16 % wrong); the sky
//! view holds CIE XYZ.

use core::f64::consts::PI;

use sky_core::color::Yxy;
use sky_core::conditions::{Conditions, Domain, OutsideDomain};
use sky_core::direction::{SkyDirection, horizon_dip};
use sky_core::quantity::EARTH_RADIUS_KM;
use sky_science::shader_sky::{ShaderFrame, ShaderSky};
use sky_science::sky_model::{SkyError, SkyModel};

use crate::atmosphere::{Atmosphere, Optics, TOP_KM};
use crate::cache::Cache;
use crate::ray::{self, Ray, horizon_km, horizon_to_top_km};
use crate::texture::{Table, single};
use crate::view;

/// Ground to 60 km, day and twilight.
pub const DOMAIN: Domain = Domain {
    altitude_km: [0.0, 60.0],
    turbidity: [1.0, 10.0],
    sun_zenith_deg: [0.0, 108.0],
    below_horizontal: true,
};

const TRANSMITTANCE: [usize; 2] = [256, 64];
const MULTIPLE: [usize; 2] = [32, 32];
const SKY_VIEW: [usize; 2] = [192, 108];
const TRANSMITTANCE_STEPS: u16 = 40;
const MULTIPLE_STEPS: u16 = 20;
const SKY_VIEW_STEPS: u16 = 30;
/// Directions of the multiple scattering: 8 × 8.
const MULTIPLE_SIDE: u16 = 8;

/// Place in the transmittance table of an altitude and the cosine of a zenith angle above the
/// horizon (Bruneton & Neyret 2008).
#[must_use]
#[inline]
pub fn transmittance_place(altitude_km: f64, cos_zenith: f64) -> [f64; 2] {
    let whole = horizon_to_top_km();
    let rho = horizon_km(altitude_km);
    let length = Ray::new(altitude_km, cos_zenith).to_top_km();
    let (least, most) = (TOP_KM - altitude_km, rho + whole);
    [(length - least) / (most - least), rho / whole]
}

/// Altitude \[km\] and cosine of a place in the transmittance table; the inverse of
/// [`transmittance_place`].
#[must_use]
pub fn transmittance_params([x, y]: [f64; 2]) -> [f64; 2] {
    let whole = horizon_to_top_km();
    let rho = whole * y;
    let radius = EARTH_RADIUS_KM.hypot(rho);
    let altitude_km = rho * rho / (EARTH_RADIUS_KM + radius);
    let (least, most) = (TOP_KM - altitude_km, rho + whole);
    let length = least + x * (most - least);
    let cosine = if length > 0.0 {
        (whole * whole - rho * rho - length * length) / (2.0 * radius * length)
    } else {
        1.0
    };
    [altitude_km, cosine.clamp(-1.0, 1.0)]
}

/// Place in the sky view of a view zenith angle and the cosine of the azimuth from the sun; half of
/// the rows lie above the horizon, most of them close to it.
#[must_use]
pub fn sky_view_place(view_zenith: f64, cos_azimuth: f64, horizon_zenith: f64) -> [f64; 2] {
    let x = (0.5 - 0.5 * cos_azimuth).max(0.0).sqrt();
    let y = if view_zenith <= horizon_zenith {
        0.5 * (1.0 - (1.0 - view_zenith / horizon_zenith).sqrt())
    } else {
        let share = (view_zenith - horizon_zenith) / (PI - horizon_zenith);
        0.5 + 0.5 * share.min(1.0).sqrt()
    };
    [x, y]
}

/// View zenith angle and cosine of the azimuth of a place in the sky view; the inverse of
/// [`sky_view_place`].
#[must_use]
pub fn sky_view_params([x, y]: [f64; 2], horizon_zenith: f64) -> [f64; 2] {
    let cos_azimuth = 1.0 - 2.0 * x * x;
    let view_zenith = if y <= 0.5 {
        let share = 1.0 - 2.0 * y;
        horizon_zenith * (1.0 - share * share)
    } else {
        let share = 2.0 * y - 1.0;
        horizon_zenith + (PI - horizon_zenith) * share * share
    };
    [view_zenith, cos_azimuth]
}

/// Place in the table of multiple scattering.
fn multiple_place(altitude_km: f64, cos_sun: f64) -> [f64; 2] {
    [0.5 + 0.5 * cos_sun, altitude_km / TOP_KM]
}

fn multiple_params([x, y]: [f64; 2]) -> [f64; 2] {
    [y * TOP_KM, 2.0 * x - 1.0]
}

/// Calls `f` with the middle and the length of each step; steps grow with the square.
#[inline]
pub(crate) fn steps(length_km: f64, count: u16, mut f: impl FnMut(f64, f64)) {
    let n = f64::from(count);
    let mut from = 0.0;
    for i in 1..=count {
        let u = f64::from(i) / n;
        let to = length_km * u * u;
        f(0.5 * (from + to), to - from);
        from = to;
    }
}

/// Transmittance from a point to the top, tabulated; shared with the precomputed scattering.
#[derive(Clone, Debug)]
pub(crate) struct Transmittance {
    table: Table,
}

impl Transmittance {
    pub(crate) fn build(optics: &Optics) -> Self {
        let [width, height] = TRANSMITTANCE;
        let table = Table::build(width, height, |x, y| {
            let [altitude, cosine] = transmittance_params([x, y]);
            let ray = Ray::new(altitude, cosine);
            let mut depth = [0.0; 3];
            steps(ray.to_top_km(), TRANSMITTANCE_STEPS, |middle, step| {
                let extinction = optics.at(ray.at(middle)[0]).extinction;
                for k in 0..3 {
                    depth[k] += extinction[k] * step;
                }
            });
            let [r, g, b] = depth.map(|d| (-d).exp());
            [r, g, b, 0.0]
        });
        Self { table }
    }

    /// From a point to the sun; none in the Earth's shadow.
    #[inline]
    pub(crate) fn to_sun(&self, altitude_km: f64, cos_sun: f64) -> [f64; 3] {
        if Ray::new(altitude_km, cos_sun).meets_ground() {
            return [0.0; 3];
        }
        let [x, y] = transmittance_place(altitude_km.max(0.0), cos_sun);
        let [r, g, b, _] = self.table.at(single(x), single(y));
        [r, g, b].map(f64::from)
    }
}

/// The tables that depend on the haze.
#[derive(Debug)]
struct Tables {
    optics: Optics,
    transmittance: Transmittance,
    multiple: Table,
}

impl Tables {
    fn build(air: &Atmosphere, turbidity: f64) -> Self {
        let optics = Optics::new(air, turbidity);
        let transmittance = Transmittance::build(&optics);
        let [width, height] = MULTIPLE;
        let multiple = Table::build(width, height, |x, y| {
            let [altitude, cos_sun] = multiple_params([x, y]);
            multiple(
                &optics,
                &transmittance,
                air.ground_albedo,
                altitude,
                cos_sun,
            )
        });
        Self {
            optics,
            transmittance,
            multiple,
        }
    }

    fn bytes(&self) -> usize {
        self.transmittance.table.bytes(3) + self.multiple.bytes(3)
    }
}

/// Light scattered more than once \[sr⁻¹, per unit of solar irradiance and scattering\] at a point.
fn multiple(
    optics: &Optics,
    transmittance: &Transmittance,
    ground_albedo: f64,
    altitude_km: f64,
    cos_sun: f64,
) -> [f64; 4] {
    let side = f64::from(MULTIPLE_SIDE);
    let sin_sun = (1.0 - cos_sun * cos_sun).max(0.0).sqrt();
    let (mut second, mut again) = ([0.0; 3], [0.0; 3]);
    for i in 0..MULTIPLE_SIDE {
        let azimuth = 2.0 * PI * (f64::from(i) + 0.5) / side;
        for j in 0..MULTIPLE_SIDE {
            let cosine = 1.0 - 2.0 * (f64::from(j) + 0.5) / side;
            let sine = (1.0 - cosine * cosine).sqrt();
            let nu = sine * azimuth.cos() * sin_sun + cosine * cos_sun;
            let ray = Ray::new(altitude_km, cosine);
            let to_ground = ray.meets_ground();
            let length = if to_ground {
                ray.to_ground_km()
            } else {
                ray.to_top_km()
            };
            let mut through = [1.0; 3];
            steps(length, MULTIPLE_STEPS, |middle, step| {
                let [altitude, radius] = ray.at(middle);
                let here = optics.at(altitude);
                let sun =
                    transmittance.to_sun(altitude, ray.cos_light(middle, radius, cos_sun, nu));
                for k in 0..3 {
                    let scattering = here.rayleigh[k] + here.aerosol[k];
                    let passed = (-here.extinction[k] * step).exp();
                    let length = attenuated(here.extinction[k], passed, step);
                    again[k] += through[k] * scattering * length;
                    second[k] += through[k] * scattering * length * sun[k] / (4.0 * PI);
                    through[k] *= passed;
                }
            });
            if to_ground {
                let cos_ground = ray.cos_light(length, EARTH_RADIUS_KM, cos_sun, nu);
                if cos_ground > 0.0 {
                    let sun = transmittance.to_sun(0.0, cos_ground);
                    for k in 0..3 {
                        second[k] += through[k] * sun[k] * cos_ground * ground_albedo / PI;
                    }
                }
            }
        }
    }
    let directions = side * side;
    let [r, g, b] = core::array::from_fn(|k| {
        let share = again[k] / directions;
        second[k] / directions / (1.0 - share)
    });
    [r, g, b, 0.0]
}

/// ∫ exp(−σ s) ds over a step.
#[inline]
pub(crate) fn attenuated(extinction: f64, passed: f64, step: f64) -> f64 {
    if extinction * step > 1e-6 {
        (1.0 - passed) / extinction
    } else {
        step
    }
}

/// Hillaire's sky.
#[derive(Debug, Default)]
pub struct Hillaire {
    air: Atmosphere,
    tables: Cache<Tables>,
}

/// Hillaire's sky for one observer, haze and sun.
#[derive(Clone, Debug)]
pub struct HillaireFrame {
    altitude_km: f32,
    horizon_zenith: f32,
    /// Largest value of the table \[cd·m⁻²\]; the table holds shares of it.
    scale: f32,
    sky_view: Table,
}

impl HillaireFrame {
    /// CIE XYZ \[cd·m⁻²\] from a unit vector above the geometric horizon.
    #[must_use]
    #[inline]
    pub fn xyz(&self, v: [f32; 3]) -> [f32; 3] {
        if ray::meets_ground(self.altitude_km, v[2]) {
            return [0.0; 3];
        }
        let level = v[0].hypot(v[1]);
        let cos_azimuth = if level > 1e-6 { v[0] / level } else { 1.0 };
        let share = (1.0 - level.atan2(v[2]) / self.horizon_zenith).max(0.0);
        let x = (0.5 - 0.5 * cos_azimuth).max(0.0).sqrt();
        let y = 0.5 - 0.5 * share.sqrt();
        let [r, g, b, _] = self.sky_view.at(x, y);
        [r, g, b].map(|c| c * self.scale)
    }
}

impl Hillaire {
    /// In another atmosphere.
    #[must_use]
    pub fn new(air: Atmosphere) -> Self {
        Self {
            air,
            tables: Cache::default(),
        }
    }

    /// The sky view of an observer, haze and sun. Builds the tables if they are those of another haze.
    ///
    /// # Errors
    /// When the conditions lie outside the domain.
    pub fn frame(&self, conditions: &Conditions) -> Result<HillaireFrame, OutsideDomain> {
        DOMAIN.check(conditions)?;
        let turbidity = conditions.turbidity;
        let tables = self
            .tables
            .get(turbidity, || Tables::build(&self.air, turbidity));
        let altitude_km = conditions.observer_altitude.km();
        let horizon_zenith = 0.5 * PI + horizon_dip(conditions.observer_altitude).radians();
        let (sin_sun, cos_sun) = conditions.sun_zenith.radians().sin_cos();
        let matrix = &self.air.xyz_from_radiance_ratio;
        let [width, height] = SKY_VIEW;
        let mut sky_view = Table::build(width, height, |x, y| {
            let [view_zenith, cos_azimuth] = sky_view_params([x, y], horizon_zenith);
            let (sin_view, cos_view) = view_zenith.sin_cos();
            let nu = (sin_view * cos_azimuth * sin_sun + cos_view * cos_sun).clamp(-1.0, 1.0);
            // The row of the horizon itself is sky.
            let ray = Ray::new(altitude_km, cos_view);
            let length = if y > 0.5 && ray.meets_ground() {
                ray.to_ground_km()
            } else {
                ray.to_top_km()
            };
            let light = self.light(&tables, ray, length, cos_sun, nu);
            let [r, g, b] =
                core::array::from_fn(|row| (0..3).map(|k| matrix[row][k] * light[k]).sum());
            [r, g, b, 0.0]
        });
        let scale = sky_view
            .texels()
            .iter()
            .flatten()
            .fold(1e-12_f32, |most, v| most.max(v.abs()));
        for texel in sky_view.texels_mut() {
            *texel = texel.map(|v| v / scale);
        }
        Ok(HillaireFrame {
            altitude_km: single(altitude_km),
            horizon_zenith: single(horizon_zenith),
            scale,
            sky_view,
        })
    }

    /// Radiance over solar irradiance \[sr⁻¹\] along a ray (Eqs. 1–4 and 11).
    fn light(&self, tables: &Tables, ray: Ray, length: f64, cos_sun: f64, nu: f64) -> [f64; 3] {
        let phases = [self.air.rayleigh_phase(nu), self.air.aerosol_phase(nu)];
        let (mut light, mut through) = ([0.0; 3], [1.0; 3]);
        steps(length, SKY_VIEW_STEPS, |middle, step| {
            let [altitude, radius] = ray.at(middle);
            let here = tables.optics.at(altitude);
            let cos_here = ray.cos_light(middle, radius, cos_sun, nu);
            let sun = tables.transmittance.to_sun(altitude, cos_here);
            let [x, y] = multiple_place(altitude, cos_here);
            let multiple = tables.multiple.at(single(x), single(y));
            for k in 0..3 {
                let (rayleigh, aerosol) = (here.rayleigh[k], here.aerosol[k]);
                let source = sun[k] * (rayleigh * phases[0] + aerosol * phases[1])
                    + f64::from(multiple[k]) * (rayleigh + aerosol);
                let passed = (-here.extinction[k] * step).exp();
                light[k] += through[k] * source * attenuated(here.extinction[k], passed, step);
                through[k] *= passed;
            }
        });
        light
    }
}

impl SkyModel for Hillaire {
    fn name(&self) -> &'static str {
        "hillaire"
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

impl ShaderSky for Hillaire {
    fn shader(&self) -> &'static str {
        sky_shaders::baselines::HILLAIRE
    }

    fn shader_frame(&self, conditions: &Conditions) -> Result<ShaderFrame, OutsideDomain> {
        let frame = self.frame(conditions)?;
        Ok(ShaderFrame {
            uniforms: vec![[frame.altitude_km, frame.horizon_zenith, frame.scale, 0.0]],
            texture: Some(Table::stacked(&[&frame.sky_view])),
        })
    }

    fn table_bytes(&self) -> usize {
        [TRANSMITTANCE, MULTIPLE, SKY_VIEW]
            .iter()
            .map(|[width, height]| width * height * 3 * size_of::<f32>())
            .sum()
    }

    fn rebuild(&self, turbidity: f64) -> usize {
        let tables = Tables::build(&self.air, turbidity);
        let bytes = tables.bytes();
        self.tables.put(turbidity, tables);
        bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::atmosphere::Shapes;
    use crate::shader_check::{self, conditions};
    use sky_core::air_mass::relative_air_mass;
    use sky_core::quantity::{Angle, Length};

    #[test]
    fn mappings_are_inverse_pairs() {
        for n in [2_u16, 32, 257] {
            for i in 0..n {
                for j in 0..n.min(33) {
                    let x = f64::from(i) / f64::from(n - 1);
                    let y = f64::from(j) / f64::from(n.min(33) - 1);
                    // The row of the top has no length to tell cosines by at its zenith.
                    if y < 1.0 {
                        let [altitude, cosine] = transmittance_params([x, y]);
                        let back = transmittance_place(altitude, cosine);
                        assert!(
                            (back[0] - x).abs() < 1e-6 && (back[1] - y).abs() < 1e-9,
                            "{x} {y} {back:?}"
                        );
                    }
                    let horizon = 1.62;
                    let [zenith, cos_azimuth] = sky_view_params([y, x], horizon);
                    let back = sky_view_place(zenith, cos_azimuth, horizon);
                    assert!((back[0] - y).abs() < 1e-7 && (back[1] - x).abs() < 1e-7);
                    let [altitude, cos_sun] = multiple_params([x, y]);
                    let back = multiple_place(altitude, cos_sun);
                    assert!((back[0] - x).abs() < 1e-14 && (back[1] - y).abs() < 1e-14);
                }
            }
        }
    }

    #[test]
    fn transmittance_agrees_with_the_closed_form() {
        // Exponential air of 8 km and haze of 1.2 km: Chapman's function; no ozone.
        let air = Atmosphere {
            shapes: Shapes::exponential(8.0, [10.0, 25.0, 40.0]),
            ozone_optical_depth: [0.0; 3],
            ..Atmosphere::default()
        };
        for turbidity in [1.0, 2.0, 4.0] {
            let table = Transmittance::build(&Optics::new(&air, turbidity));
            let haze = air.aerosol_extinction_per_km(turbidity);
            for altitude in [0.0, 0.5, 2.0, 6.0, 12.0, 30.0] {
                for degrees in [0.0, 30.0, 60.0, 75.0, 85.0, 89.0, 90.0, 91.5, 93.0_f64] {
                    let cos = Angle::from_degrees(degrees).radians().cos();
                    if Ray::new(altitude, cos).meets_ground() {
                        continue;
                    }
                    let depth = |per_km: f64, scale: f64| {
                        let mass = relative_air_mass(
                            cos,
                            Length::from_km(altitude),
                            Length::from_km(scale),
                        );
                        per_km * scale * (-altitude / scale).exp() * mass
                    };
                    let found = table.to_sun(altitude, cos);
                    for k in 0..3 {
                        let want = (-depth(air.rayleigh_scattering_per_km[k], 8.0)
                            - depth(haze[k], 1.2))
                        .exp();
                        assert!(
                            (found[k] - want).abs() < 0.005,
                            "T {turbidity}, {altitude} km, {degrees}: {} {want}",
                            found[k]
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn zenith_of_the_reference() {
        // `reference_sky_radiance.csv`: optical depth at 500 nm, sun, luminance, x, y.
        let hillaire = Hillaire::default();
        for (depth, sun, luminance, x, y) in [
            (0.0, 45.0, 1361.9, 0.2315, 0.2319),
            (0.0, 75.0, 789.5, 0.2323, 0.2361),
            (0.5, 45.0, 6467.0, 0.2888, 0.3014),
            (0.5, 75.0, 2043.0, 0.2791, 0.2916),
        ] {
            let c = conditions(0.0, 1.0 + depth / 0.143_44, sun);
            let up = [SkyDirection::from_degrees(0.0, 0.0)];
            let found = hillaire.yxy_map(&c, &up).unwrap()[0];
            // Found: −1.5 %, −2.9 %, −5.9 %, −12.4 %.
            assert!(
                (found.luminance_cd_m2 / luminance - 1.0).abs() < 0.15,
                "{found:?}"
            );
            assert!(
                (found.x - x).abs() < 0.012 && (found.y - y).abs() < 0.012,
                "{found:?}"
            );
        }
    }

    #[test]
    fn the_shader_is_valid() {
        shader_check::check(&Hillaire::default(), &conditions(12.0, 3.0, 91.0));
        assert_eq!(
            Hillaire::default().rebuild(2.0) + 192 * 108 * 12,
            Hillaire::default().table_bytes()
        );
    }
}
