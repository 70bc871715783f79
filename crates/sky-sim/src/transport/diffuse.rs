//! Light scattered more than once: the field on a grid of shells and local sun angles, found by
//! successive orders of scattering.

use super::fan::{FanScratch, FanSweep};
use super::field::{Field, Grid, HIGHEST_DEGREE, Harmonics, Shape, Source, as_f64};
use super::lanes::{Lanes, WIDTH, ZERO, add_scaled, lane};
use super::medium::{LevelFinder, Medium};
use super::path::{Path, Ray, Sampling, Steps, VIEW_SAMPLING, VIEW_SHELLS};
use super::settings::{TransportError, TransportSettings};
use super::sun::SunPlace;
use super::sunlit::Sunlit;
use super::template::{Readings, Template};
use crate::quadrature::gauss_legendre;
use rayon::prelude::*;
use sky_core::quantity::{Angle, EARTH_RADIUS_KM};
use sky_science::phase;

/// Thickest segment of a path that builds the field, as a fraction of (altitude + 4 km).
const FIELD_SHELLS: f64 = 0.5;
/// Rise between two readings of sunlight on a ray that builds the field, per (altitude + 4 km): in
/// twilight the sun lights only what is high, and fades fast below.
const SUNLIT_RISE: f64 = 0.1;
/// Share of a ray's scattered light below which the field is not read at a stop.
const FAINT: f32 = 1e-4;
/// Largest neglected moment of doubly scattered light, relative to its mean.
const HARMONICS_TOLERANCE: f64 = 0.1;
/// Sampling of the rays that build the diffuse field.
const FIELD_SAMPLING: Sampling = Sampling {
    depth: 1.0,
    rise: 0.6,
    turn: 0.02,
    opaque: 12.0,
};

/// What it takes to find the diffuse field, and to read it.
#[derive(Clone, Debug)]
pub(super) struct Diffuse {
    /// At the wavelengths that are solved.
    pub(super) air: Sunlit,
    pub(super) grid: Grid,
    harmonics: Harmonics,
    /// Altitudes at which sunlight is read along the rays that build the field \[km\].
    sunlit_levels: LevelFinder,
    field_shells: Vec<f64>,
    view_shells: Vec<f64>,
}

/// Buffers of one thread.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    pub(super) path: Path,
    pub(super) sun: Vec<SunPlace>,
    pub(super) fan: FanScratch,
    rays: Vec<Ray>,
    /// `[ray * vectors + vector]`
    radiance: Vec<Lanes>,
}

/// Directions of the field's quadrature at one zenith angle of a shell.
#[derive(Debug)]
pub(super) struct Ring {
    template: Template,
    /// Solid angle of each direction \[sr\].
    weight: f64,
    /// Cosines of the azimuths, over half the circle.
    cos_azimuth: Vec<f64>,
}

/// What lights the air, and where its light is scattered next.
#[derive(Clone, Copy, Debug)]
enum Lamp<'a> {
    /// The sun.
    Sun,
    /// A field.
    Field(&'a Source),
}

/// A sum of orders.
#[derive(Clone, Debug)]
pub(super) struct Series {
    pub(super) total: Field,
    /// Orders that were summed; the rest is extrapolated.
    pub(super) orders: usize,
}

/// What is read along a path, and for whom.
#[derive(Clone, Copy, Debug)]
enum View {
    /// Sunlight along the rays that build the field.
    Sunlight,
    /// The field, along the rays that build its next order.
    Field,
    /// The field, along an observer's rays, no farther than this \[km\].
    Observer { reach: f64 },
}

/// A field, and how much of its light the ground at a path's end throws back \[sr⁻¹\].
#[derive(Clone, Copy, Debug)]
pub(super) struct FieldLight<'a> {
    pub(super) source: &'a Source,
    pub(super) reflectance: f64,
}

impl Diffuse {
    pub(super) fn new(air: Sunlit, settings: &TransportSettings) -> Self {
        let (ground, top) = (air.medium.ground_km(), air.medium.top_km());
        let between = |z: &f64| *z > ground + 1e-6 && *z < top - 1e-6;
        let mut shells = vec![ground];
        shells.extend(settings.shells_km.iter().copied().filter(between));
        shells.push(top);
        let degrees: Vec<usize> = shells
            .iter()
            .map(|z| {
                settings
                    .degree
                    .unwrap_or_else(|| degree_at(&air.medium, *z))
                    .min(HIGHEST_DEGREE)
            })
            .collect();
        let degree = degrees.iter().copied().max().unwrap_or(2);
        let grid = Grid::new(&shells, &settings.columns_deg, degrees);
        let mut field_shells = air.medium.segment_levels(FIELD_SHELLS);
        field_shells.extend(&shells);
        field_shells.sort_by(f64::total_cmp);
        field_shells.dedup_by(|b, a| *b - *a < 1e-3 * (*a + 4.0));
        Self {
            view_shells: air.medium.segment_levels(VIEW_SHELLS),
            sunlit_levels: LevelFinder::new(&sunlit_levels(ground, top)),
            field_shells,
            harmonics: Harmonics::new(degree),
            grid,
            air,
        }
    }

    fn template(&self, radius: f64, cosine: f64, view: View, path: &mut Path) -> Template {
        let (levels, faint) = match view {
            View::Sunlight => (&self.sunlit_levels, 0.0),
            View::Field | View::Observer { .. } => (&self.grid.shells, FAINT),
        };
        let readings = Readings { levels, faint };
        let (shells, sampling, reach) = match view {
            View::Sunlight | View::Field => (&self.field_shells, &FIELD_SAMPLING, f64::INFINITY),
            View::Observer { reach } => (&self.view_shells, &VIEW_SAMPLING, reach),
        };
        let (ray, steps) = (Ray::upright(radius, cosine), Steps { shells, sampling });
        let medium = &self.air.medium;
        pulp::Arch::new().dispatch(|| Template::new(&ray, reach, medium, &readings, steps, path))
    }

    /// The path of an observer's rays of one zenith angle, no longer than `reach` \[km\].
    pub(super) fn observer_template(&self, ray: &Ray, reach: f64, path: &mut Path) -> Template {
        self.template(ray.radius, ray.cosine, View::Observer { reach }, path)
    }

    /// The directions of the quadrature at every shell.
    pub(super) fn rings(&self, settings: &TransportSettings) -> Vec<Vec<Ring>> {
        self.grid
            .shells
            .levels()
            .par_iter()
            .map_init(Scratch::default, |scratch, z| {
                self.rings_at(*z, settings, scratch)
            })
            .collect()
    }

    /// Sunlight, scattered any number of times over ground of a reflectance \[sr⁻¹\].
    pub(super) fn of_sun(
        &self,
        rings: &[Vec<Ring>],
        reflectance: f64,
        settings: &TransportSettings,
    ) -> Result<Series, TransportError> {
        let first = self.gather(rings, Lamp::Sun, reflectance);
        self.series(rings, first, reflectance, settings)
    }

    /// The light of a ground that a sun's field lights, scattered any number of times.
    pub(super) fn of_ground(
        &self,
        rings: &[Vec<Ring>],
        sun: &Field,
        reflectance: f64,
        settings: &TransportSettings,
    ) -> Result<Series, TransportError> {
        let mut lit = sun.clone();
        lit.moments.fill(ZERO);
        let columns = self.grid.columns.levels();
        for (c, column_deg) in columns.iter().enumerate() {
            let beam = self
                .air
                .beam(Angle::from_degrees(*column_deg).radians().cos());
            for (v, beam) in beam.iter().enumerate() {
                add_scaled(&mut lit.ground_irradiance[v * columns.len() + c], 1.0, beam);
            }
        }
        let lamp = Source::of_ground(lit);
        let first = self.gather(rings, Lamp::Field(&lamp), reflectance);
        self.series(rings, first, reflectance, settings)
    }

    /// Sums the orders of scattering that follow a first.
    fn series(
        &self,
        rings: &[Vec<Ring>],
        first: Field,
        reflectance: f64,
        settings: &TransportSettings,
    ) -> Result<Series, TransportError> {
        let mut orders = 1;
        let mut order = first;
        let mut total = order.clone();
        let mut last_limit = total.column_sums();
        let mut share = f64::INFINITY;
        while share > settings.tolerance {
            // the field of one order is the source of the next
            if settings.last_order.is_some_and(|last| last <= orders + 1) {
                break;
            }
            if orders >= settings.most_orders {
                return Err(TransportError::NotConverged {
                    orders,
                    share,
                    expected: settings.tolerance,
                });
            }
            let fallen = order.column_sums();
            let next = self.gather(rings, Lamp::Field(&Source::new(order)), reflectance);
            orders += 1;
            total.add(&next, None);
            let sums = [fallen, next.column_sums(), total.column_sums()];
            let tail;
            (tail, share) = extrapolate(&sums, &mut last_limit);
            if share <= settings.tolerance {
                total.add(&next, Some(&tail));
            }
            order = next;
        }
        Ok(Series { total, orders })
    }

    /// The field's directions at a shell; zenith intervals meet at the shell's own horizon.
    fn rings_at(&self, z: f64, settings: &TransportSettings, scratch: &mut Scratch) -> Vec<Ring> {
        let horizon = self.air.medium.horizon_cosine(z).acos();
        let shoulder = Angle::from_degrees(78.0).radians();
        let [high, low, ground] = settings.zenith_points;
        let mut zenith = gauss_legendre(high, shoulder.cos(), 1.0);
        zenith.extend(
            gauss_legendre(low, shoulder, horizon)
                .iter()
                .map(|(angle, w)| (angle.cos(), w * angle.sin())),
        );
        zenith.extend(gauss_legendre(ground, -1.0, horizon.cos()));
        // what the harmonics cannot hold needs no directions
        let n = settings.azimuth_points.min(self.harmonics.degree + 3);
        let radius = EARTH_RADIUS_KM + z;
        zenith
            .iter()
            .map(|(cosine, w)| Ring {
                template: self.template(radius, *cosine, View::Field, &mut scratch.path),
                weight: w * core::f64::consts::TAU / as_f64(n),
                cos_azimuth: (0..n)
                    .map(|k| (core::f64::consts::PI * (as_f64(k) + 0.5) / as_f64(n)).cos())
                    .collect(),
            })
            .collect()
    }

    /// One order of scattering: the radiance at every node of the grid, as phase-weighted moments.
    fn gather(&self, rays: &[Vec<Ring>], lamp: Lamp<'_>, reflectance: f64) -> Field {
        let shape = Shape {
            columns: self.grid.columns.levels().len(),
            count: self.harmonics.count(),
            vectors: self.air.medium.vectors,
        };
        let rings: Vec<&Ring> = rays.iter().flatten().collect();
        let waves: Vec<Vec<Lanes>> = rings
            .par_iter()
            .map_init(Scratch::default, |scratch, ring| {
                self.ring_waves(ring, lamp, reflectance, scratch)
            })
            .collect();
        let per_shell = rays[0].len();
        let per_vector = shape.count * shape.columns;
        let mut moments = vec![ZERO; rays.len() * shape.vectors * per_vector];
        moments
            .par_chunks_exact_mut(per_vector)
            .enumerate()
            .for_each(|(i, moments)| {
                let (shell, v) = (i / shape.vectors, i % shape.vectors);
                let waves = &waves[shell * per_shell..(shell + 1) * per_shell];
                self.add_moments(v, &rays[shell], waves, moments);
                self.weight_by_phase(self.grid.shells.levels()[shell], v, moments);
            });
        Field {
            shape,
            moments,
            ground_irradiance: self.irradiance(&rays[0], &waves),
        }
    }

    /// Radiance around a ring, times each `cos mφ` and the solid angle, for the sun of every column:
    /// `[(vector * orders + order) * columns + column]`.
    fn ring_waves(
        &self,
        ring: &Ring,
        lamp: Lamp<'_>,
        reflectance: f64,
        scratch: &mut Scratch,
    ) -> Vec<Lanes> {
        let Ring {
            template,
            weight,
            cos_azimuth,
        } = ring;
        let (vectors, orders) = (self.air.medium.vectors, self.harmonics.degree + 1);
        let columns = self.grid.columns.levels();
        let mu = template.cosine;
        scratch.rays.clear();
        for column_deg in columns {
            let sun_cosine = Angle::from_degrees(*column_deg).radians().cos();
            let sines = ((1.0 - mu * mu) * (1.0 - sun_cosine * sun_cosine))
                .max(0.0)
                .sqrt();
            scratch
                .rays
                .extend(cos_azimuth.iter().map(|cos_azimuth| Ray {
                    radius: template.radius,
                    cosine: mu,
                    sun_cosine,
                    cos_gamma: (mu * sun_cosine + sines * cos_azimuth).clamp(-1.0, 1.0),
                }));
        }
        let Scratch {
            path,
            sun,
            fan,
            rays,
            radiance,
        } = scratch;
        radiance.clear();
        radiance.resize(rays.len() * vectors, ZERO);
        match lamp {
            Lamp::Sun => {
                let template = self.template(template.radius, mu, View::Sunlight, path);
                for (ray, radiance) in rays.iter().zip(radiance.chunks_exact_mut(vectors)) {
                    self.air
                        .add_sunlight(ray, &template, reflectance, sun, radiance);
                }
            }
            Lamp::Field(source) => {
                let light = FieldLight {
                    source,
                    reflectance,
                };
                self.add_diffuse(rays, template, light, fan, radiance);
            }
        }
        let mut waves = vec![ZERO; columns.len() * vectors * orders];
        let around = cos_azimuth.len();
        for (i, light) in radiance.iter().enumerate() {
            let (ray, v) = (i / vectors, i % vectors);
            let (column, azimuth) = (ray / around, ray % around);
            let cos_azimuth = cos_azimuth[azimuth];
            let (mut before, mut cos_m) = (cos_azimuth, 1.0); // cos(-φ), cos(0)
            for m in 0..orders {
                let wave = &mut waves[(v * orders + m) * columns.len() + column];
                add_scaled(wave, lane(weight * cos_m), light);
                (before, cos_m) = (cos_m, 2.0 * cos_azimuth * cos_m - before);
            }
        }
        waves
    }

    /// Adds the moments of the rings of a shell, `[harmonic * columns + column]`, for one vector.
    fn add_moments(&self, v: usize, rings: &[Ring], waves: &[Vec<Lanes>], moments: &mut [Lanes]) {
        let columns = self.grid.columns.levels().len();
        let orders = self.harmonics.degree + 1;
        let mut functions = vec![0.0; self.harmonics.count()];
        for (ring, waves) in rings.iter().zip(waves) {
            self.harmonics
                .evaluate(ring.template.cosine, &mut functions);
            let harmonics = self.harmonics.orders_and_degrees().zip(&functions);
            for (moments, ((m, _), y)) in moments.chunks_exact_mut(columns).zip(harmonics) {
                let wave = &waves[(v * orders + m) * columns..][..columns];
                for (moment, wave) in moments.iter_mut().zip(wave) {
                    add_scaled(moment, *y, wave);
                }
            }
        }
    }

    /// Irradiance on a horizontal plane at a shell, `[vector * columns + column]`.
    fn irradiance(&self, rings: &[Ring], waves: &[Vec<Lanes>]) -> Vec<Lanes> {
        let columns = self.grid.columns.levels().len();
        let orders = self.harmonics.degree + 1;
        let mut irradiance = vec![ZERO; columns * self.air.medium.vectors];
        for (ring, waves) in rings.iter().zip(waves) {
            let mu = ring.template.cosine;
            if mu > 0.0 {
                for (sums, waves) in irradiance
                    .chunks_exact_mut(columns)
                    .zip(waves.chunks_exact(orders * columns))
                {
                    for (sum, wave) in sums.iter_mut().zip(waves) {
                        add_scaled(sum, lane(mu), wave);
                    }
                }
            }
        }
        irradiance
    }

    /// Multiplies moments of one vector by those of the local phase function.
    fn weight_by_phase(&self, z: f64, v: usize, moments: &mut [Lanes]) {
        let medium = &self.air.medium;
        let place = medium.finder.find(z);
        let rayleigh_2 = phase::rayleigh_second_moment(medium.depolarization);
        let [rayleigh, aerosol, g, g2, w] = [
            &medium.rayleigh,
            &medium.aerosol,
            &medium.g,
            &medium.g2,
            &medium.g_weight,
        ]
        .map(|table| medium.at(table, place, v));
        let rows = moments.chunks_exact_mut(self.grid.columns.levels().len());
        for ((_, degree), moments) in self.harmonics.orders_and_degrees().zip(rows) {
            let power = i32::try_from(degree).unwrap_or(0);
            let ray = match degree {
                0 => 1.0,
                2 => lane(rayleigh_2),
                _ => 0.0,
            };
            let factor: Lanes = core::array::from_fn(|l| {
                let aer = w[l] * g[l].powi(power) + (1.0 - w[l]) * g2[l].powi(power);
                let all = rayleigh[l] + aerosol[l];
                if all > 0.0 {
                    (rayleigh[l] * ray + aerosol[l] * aer) / all
                } else {
                    ray
                }
            });
            for moment in moments {
                for l in 0..WIDTH {
                    moment[l] *= factor[l];
                }
            }
        }
    }

    /// Adds the diffuse light that a field sends along the rays that share a template.
    pub(super) fn add_diffuse(
        &self,
        rays: &[Ray],
        template: &Template,
        light: FieldLight<'_>,
        scratch: &mut FanScratch,
        radiance: &mut [Lanes],
    ) {
        pulp::Arch::new().dispatch(FanSweep {
            grid: &self.grid,
            harmonics: &self.harmonics,
            source: light.source,
            template,
            rays,
            reflectance: light.reflectance,
            scratch,
            radiance,
        });
    }
}

/// What remains of a series if each column's light goes on falling by the same ratio: factors of the
/// last order, and the largest change of the limit since the order before. `sums` are those of the
/// order before, of the last order and of all.
fn extrapolate(sums: &[Vec<Lanes>; 3], last_limit: &mut [Lanes]) -> (Vec<Lanes>, f64) {
    let [fallen, fresh, sum] = sums;
    let mut tail = vec![ZERO; sum.len()];
    let mut share = 0.0_f64;
    for (i, tail) in tail.iter_mut().enumerate() {
        for l in 0..WIDTH {
            // no comparison sees NaN, and `max` drops it: the series must not end on it
            if (sum[i][l] + fallen[i][l] + fresh[i][l]).is_nan() {
                share = f64::INFINITY;
            }
            if sum[i][l] > 0.0 && fallen[i][l] > 0.0 {
                let q = (fresh[i][l] / fallen[i][l]).min(0.99);
                tail[l] = q / (1.0 - q);
                let limit = sum[i][l] + tail[l] * fresh[i][l];
                share = share.max(f64::from((limit / last_limit[i][l] - 1.0).abs()));
                last_limit[i][l] = limit;
            }
        }
    }
    (tail, share)
}

/// Altitudes from the ground to the top of the atmosphere, a constant share of (altitude + 4 km) apart
/// \[km\].
fn sunlit_levels(ground_km: f64, top_km: f64) -> Vec<f64> {
    let mut levels: Vec<f64> =
        core::iter::successors(Some(ground_km), |z| Some(z + SUNLIT_RISE * (z + 4.0)))
            .take_while(|z| *z < top_km - 1e-6)
            .collect();
    levels.push(top_km);
    levels
}

/// Highest degree of harmonics that the phase function at an altitude asks for: the source of the
/// diffuse light is a convolution, and light that has been scattered twice has the product of two
/// moments.
fn degree_at(medium: &Medium, z: f64) -> usize {
    let place = medium.finder.find(z);
    let all = medium.at(&medium.scattering, place, medium.vectors - 1);
    let aerosol = medium.at(&medium.aerosol, place, medium.vectors - 1);
    let share = (0..WIDTH).fold(0.0_f64, |s, l| {
        if all[l] > 0.0 {
            s.max(f64::from(aerosol[l] / all[l]))
        } else {
            s
        }
    });
    let g = medium.largest_g;
    (2..=HIGHEST_DEGREE)
        .find(|l| {
            share * (2.0 * as_f64(*l) + 3.0) * g.powi(2).powf(as_f64(*l) + 1.0)
                < HARMONICS_TOLERANCE
        })
        .unwrap_or(HIGHEST_DEGREE)
}
