//! E. Bruneton, F. Neyret: Precomputed atmospheric scattering, EGSR 2008 (and Bruneton's
//! implementation of 2017).
//!
//! The light of the whole sky over (r, μ, `μ_s`, ν) in four-dimensional tables: single scattering by
//! air and by aerosol without their phase functions, and the orders 2 to 4 together; each order from
//! the one before through the light that arrives at a point (their ΔJ) and the ground's irradiance
//! (their ΔE). On the CPU only: four dimensions do not fit the portable subset of shaders, and the
//! tables are those of one haze.
//!
//! Smaller than published: 24 × 40 × 28 × 8 for 32 × 128 × 32 × 8. The mappings of r and `μ_s` are
//! those of 2017, and so is that of μ, by the length of the ray, apart for rays that meet the ground.
//! The table of ΔJ holds arriving light weighted by the two phase functions, not yet multiplied by the
//! local scattering, so that the haze need not be resolved by 24 altitudes. Four orders, the default of
//! 2017, leave the zenith of the reference 1 % too dark in clean air and 6–10 % in haze of optical depth
//! 0.5; nine orders would leave 0.3–3.5 %. The air is ours.

use core::f64::consts::PI;
use std::sync::Arc;

use sky_core::color::Yxy;
use sky_core::conditions::{Conditions, Domain};
use sky_core::direction::SkyDirection;
use sky_core::quantity::EARTH_RADIUS_KM;
use sky_science::sky_model::{SkyError, SkyModel};

use crate::atmosphere::{Atmosphere, Optics, TOP_KM};
use crate::cache::Cache;
use crate::hillaire::{Transmittance, attenuated, steps};
use crate::ray::{self, Ray, horizon_km, horizon_to_top_km};
use crate::texture::single;
use crate::view;

/// Ground to 60 km; the table ends at a sun of 102°.
pub const DOMAIN: Domain = Domain {
    altitude_km: [0.0, 60.0],
    turbidity: [1.0, 10.0],
    sun_zenith_deg: [0.0, 102.0],
    below_horizontal: true,
};

const RADII: usize = 24;
/// Rays that reach the top, and as many that meet the ground.
const RAYS: usize = 20;
const SUNS: usize = 28;
const NUS: usize = 8;
/// Cosines of the table of arriving light, uniform.
const ARRIVING: usize = 16;
/// Directions over the sphere: cosines × azimuths of half the circle.
const COSINES: u8 = 24;
const AZIMUTHS: u8 = 12;
const SINGLE_STEPS: u16 = 40;
const ORDER_STEPS: u16 = 20;
/// Highest order of scattering.
const ORDERS: usize = 4;
/// Cosine of the lowest sun, 102°.
const LEAST_COS_SUN: f64 = -0.208;

/// Place of an altitude on the tables' axis.
#[must_use]
pub fn radius_place(altitude_km: f64) -> f64 {
    horizon_km(altitude_km) / horizon_to_top_km()
}

/// The inverse of [`radius_place`] \[km\].
#[must_use]
pub fn altitude_from_place(place: f64) -> f64 {
    let rho = place * horizon_to_top_km();
    rho * rho / (EARTH_RADIUS_KM + EARTH_RADIUS_KM.hypot(rho))
}

/// Place of the sun's cosine on the tables' axis (Bruneton 2017).
#[must_use]
pub fn sun_place(cos_sun: f64) -> f64 {
    let length = Ray::new(0.0, cos_sun).to_top_km();
    let (least, most) = (TOP_KM, horizon_to_top_km());
    let a = (length - least) / (most - least);
    let lowest = (Ray::new(0.0, LEAST_COS_SUN).to_top_km() - least) / (most - least);
    (1.0 - a / lowest).max(0.0) / (1.0 + a)
}

/// The inverse of [`sun_place`].
#[must_use]
pub fn cos_sun_from_place(place: f64) -> f64 {
    let (least, most) = (TOP_KM, horizon_to_top_km());
    let lowest = (Ray::new(0.0, LEAST_COS_SUN).to_top_km() - least) / (most - least);
    let a = (lowest - place * lowest) / (1.0 + place * lowest);
    let length = least + a * (most - least);
    ((most * most - length * length) / (2.0 * EARTH_RADIUS_KM * length)).clamp(-1.0, 1.0)
}

/// Place of a ray's cosine, by its length; `ground` for rays that meet the ground.
#[must_use]
pub fn ray_place(altitude_km: f64, cos_view: f64, ground: bool) -> f64 {
    let ray = Ray::new(altitude_km, cos_view);
    let rho = horizon_km(altitude_km);
    let (length, least, most) = if ground {
        (ray.to_ground_km(), altitude_km, rho)
    } else {
        (
            ray.to_top_km(),
            TOP_KM - altitude_km,
            rho + horizon_to_top_km(),
        )
    };
    if most > least {
        ((length - least) / (most - least)).clamp(0.0, 1.0)
    } else {
        0.0
    }
}

/// The inverse of [`ray_place`].
#[must_use]
pub fn cos_view_from_place(altitude_km: f64, place: f64, ground: bool) -> f64 {
    let rho = horizon_km(altitude_km);
    let whole = horizon_to_top_km();
    let radius = EARTH_RADIUS_KM + altitude_km;
    let cosine = if ground {
        let length = altitude_km + place * (rho - altitude_km);
        if length > 0.0 {
            -(rho * rho + length * length) / (2.0 * radius * length)
        } else {
            -1.0
        }
    } else {
        let length = (TOP_KM - altitude_km) + place * (rho + whole - (TOP_KM - altitude_km));
        if length > 0.0 {
            (whole * whole - rho * rho - length * length) / (2.0 * radius * length)
        } else {
            1.0
        }
    };
    cosine.clamp(-1.0, 1.0)
}

/// Two neighbours on an axis.
#[derive(Clone, Copy, Debug)]
struct Cell {
    lower: usize,
    fraction: f64,
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "clamped to the axis first"
)]
fn cell(place: f64, count: usize) -> Cell {
    let at = place.clamp(0.0, 1.0) * (count - 1) as f64;
    let lower = (at as usize).min(count - 2);
    Cell {
        lower,
        fraction: at - lower as f64,
    }
}

fn node(index: usize, count: usize) -> f64 {
    index as f64 / (count - 1) as f64
}

/// Values over radius, sun, ray and ν.
#[derive(Clone, Debug)]
struct Field<const N: usize> {
    rays: usize,
    values: Vec<[f32; N]>,
}

impl<const N: usize> Field<N> {
    fn new(rays: usize) -> Self {
        Self {
            rays,
            values: vec![[0.0; N]; RADII * SUNS * rays * NUS],
        }
    }

    fn index(&self, radius: usize, sun: usize, ray: usize, nu: usize) -> usize {
        ((radius * SUNS + sun) * self.rays + ray) * NUS + nu
    }

    /// Blends the sixteen corners around a place.
    #[inline]
    fn at(&self, radius: Cell, sun: Cell, ray: Cell, nu: Cell) -> [f64; N] {
        let sides = |c: Cell| [(0, 1.0 - c.fraction), (1, c.fraction)];
        let mut sum = [0.0_f64; N];
        for (r, wr) in sides(radius) {
            for (s, ws) in sides(sun) {
                for (m, wm) in sides(ray) {
                    let first =
                        self.index(radius.lower + r, sun.lower + s, ray.lower + m, nu.lower);
                    for (n, wn) in sides(nu) {
                        let weight = wr * ws * wm * wn;
                        for (sum, value) in sum.iter_mut().zip(self.values[first + n]) {
                            *sum += weight * f64::from(value);
                        }
                    }
                }
            }
        }
        sum
    }
}

/// Cell of a ray's axis, which has two halves.
fn ray_cell(altitude_km: f64, cos_view: f64, ground: bool) -> Cell {
    let half = cell(ray_place(altitude_km, cos_view, ground), RAYS);
    Cell {
        lower: half.lower + if ground { RAYS } else { 0 },
        ..half
    }
}

/// A node's geometry: altitude, cosine of the sun, of the view, and between them as close to the
/// node's ν as can be.
fn reachable(cos_view: f64, cos_sun: f64, nu: f64) -> f64 {
    let sines = ((1.0 - cos_view * cos_view) * (1.0 - cos_sun * cos_sun))
        .max(0.0)
        .sqrt();
    nu.clamp(cos_view * cos_sun - sines, cos_view * cos_sun + sines)
}

#[derive(Debug)]
struct Tables {
    /// Single scattering by air and by aerosol, without phase functions.
    single: Field<6>,
    /// The orders above.
    multiple: Field<3>,
}

/// What the orders are computed from.
struct Precomputation<'a> {
    air: &'a Atmosphere,
    optics: Optics,
    transmittance: Transmittance,
}

/// One order: light along rays, and the ground's irradiance over the solar one by the sun's place.
struct Order {
    light: Field<3>,
    irradiance: Vec<[f64; 3]>,
}

impl Precomputation<'_> {
    /// Fills a field of rays from geometry: ray, its length, `μ_s`, ν.
    fn fill<const N: usize>(f: impl Fn(Ray, f64, f64, f64) -> [f64; N]) -> Field<N> {
        let mut field = Field::new(2 * RAYS);
        for r in 0..RADII {
            let altitude = altitude_from_place(node(r, RADII));
            for s in 0..SUNS {
                let cos_sun = cos_sun_from_place(node(s, SUNS));
                for m in 0..2 * RAYS {
                    let ground = m >= RAYS;
                    let cos_view = cos_view_from_place(altitude, node(m % RAYS, RAYS), ground);
                    let ray = Ray::new(altitude, cos_view);
                    let length = if ground {
                        ray.to_ground_km()
                    } else {
                        ray.to_top_km()
                    };
                    for n in 0..NUS {
                        let nu = reachable(cos_view, cos_sun, 2.0 * node(n, NUS) - 1.0);
                        let index = field.index(r, s, m, n);
                        field.values[index] = f(ray, length, cos_sun, nu).map(single);
                    }
                }
            }
        }
        field
    }

    /// Single scattering without its phase function, by air and by aerosol.
    fn single(&self) -> Field<6> {
        Self::fill(|ray, length, cos_sun, nu| {
            let (mut light, mut through) = ([0.0; 6], [1.0; 3]);
            steps(length, SINGLE_STEPS, |middle, step| {
                let [altitude, radius] = ray.at(middle);
                let here = self.optics.at(altitude);
                let sun = self
                    .transmittance
                    .to_sun(altitude, ray.cos_light(middle, radius, cos_sun, nu));
                for k in 0..3 {
                    let passed = (-here.extinction[k] * step).exp();
                    let lit = through[k] * sun[k] * attenuated(here.extinction[k], passed, step);
                    light[k] += lit * here.rayleigh[k];
                    light[k + 3] += lit * here.aerosol[k];
                    through[k] *= passed;
                }
            });
            light
        })
    }

    /// Transmittance of a ray down to the ground.
    fn to_ground(&self, ray: Ray, altitude_km: f64, cos_view: f64, length: f64) -> [f64; 3] {
        let [_, radius] = ray.at(length);
        let cos_ground = -ray.cos_zenith_at(length, radius);
        let whole = self.transmittance.to_sun(0.0, cos_ground.max(0.0));
        let above = self.transmittance.to_sun(altitude_km, -cos_view);
        core::array::from_fn(|k| (whole[k] / above[k].max(1e-30)).min(1.0))
    }

    /// The light that arrives at a point from all directions, weighted by the phase functions of air
    /// and aerosol (their ΔJ over the scattering), for all points, suns and views.
    fn arriving(
        &self,
        light: impl Fn(Cell, Cell, Cell, f64) -> [f64; 3],
        irradiance: &[[f64; 3]],
    ) -> Field<6> {
        let mut field = Field::new(ARRIVING);
        let mut incoming = Vec::new();
        for r in 0..RADII {
            let altitude = altitude_from_place(node(r, RADII));
            let radius_cell = cell(node(r, RADII), RADII);
            for s in 0..SUNS {
                let cos_sun = cos_sun_from_place(node(s, SUNS));
                let sin_sun = (1.0 - cos_sun * cos_sun).max(0.0).sqrt();
                let sun_cell = cell(node(s, SUNS), SUNS);
                incoming.clear();
                for [x, y, z] in directions() {
                    let nu = x * sin_sun + z * cos_sun;
                    let ray = Ray::new(altitude, z);
                    let ground = ray.meets_ground();
                    let mut sum = light(radius_cell, sun_cell, ray_cell(altitude, z, ground), nu);
                    if ground {
                        let length = ray.to_ground_km();
                        let through = self.to_ground(ray, altitude, z, length);
                        let place = sun_place(ray.cos_light(length, EARTH_RADIUS_KM, cos_sun, nu));
                        let below = on_axis(irradiance, place);
                        for k in 0..3 {
                            sum[k] += through[k] * below[k] * self.air.ground_albedo / PI;
                        }
                    }
                    incoming.push(([x, y, z], sum));
                }
                for m in 0..ARRIVING {
                    let cos_view = 2.0 * node(m, ARRIVING) - 1.0;
                    let sin_view = (1.0 - cos_view * cos_view).max(0.0).sqrt();
                    for n in 0..NUS {
                        let nu = reachable(cos_view, cos_sun, 2.0 * node(n, NUS) - 1.0);
                        let sines = sin_view * sin_sun;
                        let cos_azimuth = if sines > 1e-9 {
                            ((nu - cos_view * cos_sun) / sines).clamp(-1.0, 1.0)
                        } else {
                            1.0
                        };
                        let sin_azimuth = (1.0 - cos_azimuth * cos_azimuth).sqrt();
                        let view = [sin_view * cos_azimuth, sin_view * sin_azimuth, cos_view];
                        let index = field.index(r, s, m, n);
                        field.values[index] = self.weighted(&incoming, view).map(single);
                    }
                }
            }
        }
        field
    }

    /// Means of incoming light, weighted by the phase functions, which are made to add up to 1.
    fn weighted(&self, incoming: &[([f64; 3], [f64; 3])], view: [f64; 3]) -> [f64; 6] {
        let (mut sum, mut weights) = ([0.0; 6], [0.0; 2]);
        for ([x, y, z], light) in incoming {
            for side in [1.0, -1.0] {
                let cosine = x * view[0] + side * y * view[1] + z * view[2];
                let phases = [
                    self.air.rayleigh_phase(cosine),
                    self.air.aerosol_phase(cosine),
                ];
                for which in 0..2 {
                    weights[which] += phases[which];
                    for k in 0..3 {
                        sum[3 * which + k] += phases[which] * light[k];
                    }
                }
            }
        }
        core::array::from_fn(|k| sum[k] / weights[k / 3])
    }

    /// The next order along all rays, and what of it falls on the ground.
    fn order(&self, arriving: &Field<6>) -> Order {
        let light = Self::fill(|ray, length, cos_sun, nu| {
            let (mut light, mut through) = ([0.0; 3], [1.0; 3]);
            steps(length, ORDER_STEPS, |middle, step| {
                let [altitude, radius] = ray.at(middle);
                let here = self.optics.at(altitude);
                let cos_here = ray.cos_light(middle, radius, cos_sun, nu);
                let light_here = arriving.at(
                    cell(radius_place(altitude.max(0.0)), RADII),
                    cell(sun_place(cos_here), SUNS),
                    cell(0.5 + 0.5 * ray.cos_zenith_at(middle, radius), ARRIVING),
                    cell(0.5 + 0.5 * nu, NUS),
                );
                for k in 0..3 {
                    let source =
                        here.rayleigh[k] * light_here[k] + here.aerosol[k] * light_here[k + 3];
                    let passed = (-here.extinction[k] * step).exp();
                    light[k] += through[k] * source * attenuated(here.extinction[k], passed, step);
                    through[k] *= passed;
                }
            });
            light
        });
        let irradiance = self.irradiance(|radius, sun, ray, nu| {
            light.at(radius, sun, ray, cell(0.5 + 0.5 * nu, NUS))
        });
        Order { light, irradiance }
    }

    /// The ground's irradiance from the light of the sky, by the sun's place.
    fn irradiance(&self, light: impl Fn(Cell, Cell, Cell, f64) -> [f64; 3]) -> Vec<[f64; 3]> {
        let solid_angle = 4.0 * PI / (f64::from(COSINES) * f64::from(AZIMUTHS));
        (0..SUNS)
            .map(|s| {
                let cos_sun = cos_sun_from_place(node(s, SUNS));
                let sin_sun = (1.0 - cos_sun * cos_sun).max(0.0).sqrt();
                let mut sum = [0.0; 3];
                for [x, _, z] in directions().filter(|d| d[2] > 0.0) {
                    let here = light(
                        cell(0.0, RADII),
                        cell(node(s, SUNS), SUNS),
                        ray_cell(0.0, z, false),
                        x * sin_sun + z * cos_sun,
                    );
                    for k in 0..3 {
                        sum[k] += here[k] * z * solid_angle;
                    }
                }
                sum
            })
            .collect()
    }
}

/// Unit vectors of equal solid angle over half the sphere, y > 0.
fn directions() -> impl Iterator<Item = [f64; 3]> {
    (0..COSINES).flat_map(|i| {
        let z = 1.0 - 2.0 * (f64::from(i) + 0.5) / f64::from(COSINES);
        let sine = (1.0 - z * z).sqrt();
        (0..AZIMUTHS).map(move |j| {
            let (sin, cos) = (PI * (f64::from(j) + 0.5) / f64::from(AZIMUTHS)).sin_cos();
            [sine * cos, sine * sin, z]
        })
    })
}

fn on_axis(values: &[[f64; 3]], place: f64) -> [f64; 3] {
    let c = cell(place, values.len());
    core::array::from_fn(|k| {
        let (a, b) = (values[c.lower][k], values[c.lower + 1][k]);
        a + c.fraction * (b - a)
    })
}

impl Tables {
    fn build(air: &Atmosphere, turbidity: f64) -> Self {
        let optics = Optics::new(air, turbidity);
        let transmittance = Transmittance::build(&optics);
        let work = Precomputation {
            air,
            optics,
            transmittance,
        };
        let first = work.single();
        let single_light = |radius, sun, ray, nu: f64| {
            let place = cell(0.5 + 0.5 * nu, NUS);
            let light = first.at(radius, sun, ray, place);
            let (pa, pm) = (air.rayleigh_phase(nu), air.aerosol_phase(nu));
            core::array::from_fn(|k| pa * light[k] + pm * light[k + 3])
        };
        // The sun's own light on the ground counts for the second order.
        let sunlight: Vec<[f64; 3]> = (0..SUNS)
            .map(|s| {
                let cos_sun = cos_sun_from_place(node(s, SUNS)).max(0.0);
                work.transmittance.to_sun(0.0, cos_sun).map(|t| t * cos_sun)
            })
            .collect();
        let mut arriving = work.arriving(single_light, &sunlight);
        // The light of the first order falls on the ground as well; its reflection is of the third.
        let mut below = work.irradiance(single_light);
        let mut multiple = Field::new(2 * RAYS);
        for order in 2..=ORDERS {
            let next = work.order(&arriving);
            for (sum, value) in multiple.values.iter_mut().zip(&next.light.values) {
                for k in 0..3 {
                    sum[k] += value[k];
                }
            }
            if order < ORDERS {
                arriving = work.arriving(
                    |radius, sun, ray, nu| {
                        next.light.at(radius, sun, ray, cell(0.5 + 0.5 * nu, NUS))
                    },
                    &below,
                );
                below = next.irradiance;
            }
        }
        Self {
            single: first,
            multiple,
        }
    }

    fn bytes(&self) -> usize {
        size_of_val(&self.single.values[..]) + size_of_val(&self.multiple.values[..])
    }
}

/// Bruneton's sky.
#[derive(Debug, Default)]
pub struct Bruneton {
    air: Atmosphere,
    tables: Cache<Tables>,
}

impl Bruneton {
    /// In another atmosphere.
    #[must_use]
    pub fn new(air: Atmosphere) -> Self {
        Self {
            air,
            tables: Cache::default(),
        }
    }

    /// Bytes of the tables.
    #[must_use]
    pub const fn table_bytes(&self) -> usize {
        3 * RADII * SUNS * 2 * RAYS * NUS * size_of::<[f32; 3]>()
    }

    /// Builds the tables of a turbidity anew and keeps them; their bytes.
    pub fn rebuild(&self, turbidity: f64) -> usize {
        let tables = Tables::build(&self.air, turbidity);
        let bytes = tables.bytes();
        self.tables.put(turbidity, tables);
        bytes
    }

    fn tables(&self, turbidity: f64) -> Arc<Tables> {
        self.tables
            .get(turbidity, || Tables::build(&self.air, turbidity))
    }
}

impl SkyModel for Bruneton {
    fn name(&self) -> &'static str {
        "bruneton"
    }

    fn domain(&self) -> &Domain {
        &DOMAIN
    }

    fn yxy_map(
        &self,
        conditions: &Conditions,
        directions: &[SkyDirection],
    ) -> Result<Vec<Yxy>, SkyError> {
        DOMAIN.check(conditions)?;
        let tables = self.tables(conditions.turbidity);
        let altitude_km = conditions.observer_altitude.km();
        let sun = view::sun(conditions);
        let radius_cell = cell(radius_place(altitude_km), RADII);
        let sun_cell = cell(sun_place(conditions.sun_zenith.radians().cos()), SUNS);
        let matrix = self.air.matrix();
        Ok(view::each(directions, |v| {
            if ray::meets_ground(single(altitude_km), v[2]) {
                return [0.0; 3];
            }
            let nu = f64::from(view::cos_gamma(sun, v));
            let ray = ray_cell(altitude_km, v[2].into(), false);
            let nu_cell = cell(0.5 + 0.5 * nu, NUS);
            let first = tables.single.at(radius_cell, sun_cell, ray, nu_cell);
            let more = tables.multiple.at(radius_cell, sun_cell, ray, nu_cell);
            let (pa, pm) = (self.air.rayleigh_phase(nu), self.air.aerosol_phase(nu));
            let ratio =
                core::array::from_fn(|k| single(pa * first[k] + pm * first[k + 3] + more[k]));
            view::multiply(&matrix, ratio)
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader_check::conditions;

    #[test]
    fn mappings_are_inverse_pairs() {
        for n in [2_usize, 32, 257] {
            for i in 0..n {
                let x = node(i, n);
                assert!((radius_place(altitude_from_place(x)) - x).abs() < 1e-9);
                assert!((sun_place(cos_sun_from_place(x)) - x).abs() < 1e-7, "{x}");
                for altitude in [0.5, 12.0, 60.0] {
                    for ground in [false, true] {
                        let cosine = cos_view_from_place(altitude, x, ground);
                        let back = ray_place(altitude, cosine, ground);
                        // at the horizon the length to the ground is a root of nothing
                        assert!((back - x).abs() < 1e-5, "{altitude} {ground} {x} {back}");
                    }
                }
            }
        }
    }

    #[test]
    fn zenith_of_the_reference() {
        // `reference_sky_radiance.csv`: optical depth at 500 nm, sun, luminance, x, y at the zenith.
        let bruneton = Bruneton::default();
        assert_eq!(bruneton.rebuild(1.0), bruneton.table_bytes());
        for (depth, sun, luminance, x, y) in [
            (0.0, 45.0, 1361.9, 0.2315, 0.2319),
            (0.0, 75.0, 789.5, 0.2323, 0.2361),
            (0.5, 45.0, 6467.0, 0.2888, 0.3014),
            (0.5, 75.0, 2043.0, 0.2791, 0.2916),
        ] {
            let c = conditions(0.0, 1.0 + depth / 0.143_44, sun);
            let up = [SkyDirection::from_degrees(0.0, 0.0)];
            let found = bruneton.yxy_map(&c, &up).unwrap()[0];
            // Found: −0.7 %, −0.9 %, −5.5 %, −9.5 %.
            assert!(
                (found.luminance_cd_m2 / luminance - 1.0).abs() < 0.12,
                "{found:?}"
            );
            assert!(
                (found.x - x).abs() < 0.012 && (found.y - y).abs() < 0.012,
                "{found:?}"
            );
        }
    }
}
