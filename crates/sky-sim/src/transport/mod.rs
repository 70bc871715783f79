//! The transport engine: spectral sky radiance in a spherical atmosphere, every order of scattering.
//!
//! Single scattering is integrated exactly along straight rays through curved shells, with the full
//! phase functions and the Earth's shadow. Higher orders come from a diffuse field on a grid of
//! shells and local sun zenith angles, found by successive orders: each order is the formal solution
//! along rays in a fixed set of directions (no approximation of flat layers), stored as moments of
//! spherical harmonics. The ground is Lambertian; its light counts. Deterministic.
//!
//! Not modeled: refraction, polarization, horizontal variation of the air, the sun's disc.

mod fan;
mod field;
mod lanes;
mod medium;
mod path;
mod spread;
mod sun;
mod template;

use crate::optics::OpticalProfile;
use crate::quadrature::gauss_legendre;
use fan::{FanScratch, FanSweep};
use field::{Field, Grid, Harmonics, Shape, Source, as_f64};
use lanes::{Lanes, WIDTH, ZERO, add_product, add_scaled, lane};
use medium::{LevelFinder, Medium};
use path::{Path, Ray, Sampling};
use rayon::prelude::*;
use sky_core::direction::SkyDirection;
use sky_core::quantity::{Angle, EARTH_RADIUS_KM, Length};
use sky_science::phase;
use spread::Spread;
use sun::{SunPlace, SunTable, horizon_cosine};
use template::{Readings, Stop, Template};

/// What the transport engine refuses.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum TransportError {
    /// Fewer than two levels, or tables of the wrong length.
    #[error("optical profile: expected at least 2 levels and full tables, found {levels} levels")]
    Shape {
        /// Number of levels found.
        levels: usize,
    },
    /// Fewer local sun zenith angles than the field is interpolated among.
    #[error("columns of the diffuse field: expected at least 4, found {found}")]
    Columns {
        /// Number of columns found.
        found: usize,
    },
    /// The ground reflects a share between 0 and 1.
    #[error("ground albedo: expected 0..1, found {0}")]
    Albedo(f64),
    /// The series of orders does not converge in the orders allowed.
    #[error(
        "multiple scattering: order {orders} still adds {share:.1e} of the field, expected below {expected:.1e}"
    )]
    NotConverged {
        /// Orders computed.
        orders: usize,
        /// Share of the field that the last one added.
        share: f64,
        /// Share at which the engine would have stopped.
        expected: f64,
    },
}

/// How finely the transport equation is solved.
#[derive(Clone, Debug, PartialEq)]
pub struct TransportSettings {
    /// Highest degree of spherical harmonics of the diffuse source; `None` chooses by the haze.
    pub degree: Option<usize>,
    /// Gauss points in zenith: from the zenith to 78°, from there to the horizon, below the horizon.
    pub zenith_points: [usize; 3],
    /// Directions in azimuth over half the circle.
    pub azimuth_points: usize,
    /// Most orders of scattering.
    pub most_orders: usize,
    /// The series stops when what remains is below this share of the field everywhere.
    pub tolerance: f64,
    /// Cuts the series after this order, 1 being single scattering: to ask what the others are worth.
    pub last_order: Option<usize>,
    /// Altitudes of the shells of the diffuse field \[km\]; those above the profile's top are dropped.
    pub shells_km: Vec<f64>,
    /// Local sun zenith angles of the diffuse field \[deg\].
    pub columns_deg: Vec<f64>,
}

impl Default for TransportSettings {
    fn default() -> Self {
        Self {
            degree: None,
            zenith_points: [6, 8, 4],
            azimuth_points: 8,
            most_orders: 60,
            tolerance: 2e-3,
            last_order: None,
            shells_km: vec![
                0.0, 0.1, 0.3, 0.6, 1.0, 1.5, 2.1, 2.9, 4.0, 5.5, 7.5, 10.0, 12.5, 15.5, 19.0,
                23.0, 27.0, 32.0, 38.0, 46.0, 56.0, 70.0, 100.0,
            ],
            columns_deg: vec![
                0.0, 15.0, 30.0, 45.0, 57.0, 66.0, 73.0, 78.5, 82.5, 85.5, 87.5, 89.0, 90.5, 92.0,
                93.5, 95.0, 96.5, 98.0, 100.0, 102.5, 106.0,
            ],
        }
    }
}

/// Thickest segment of a path, as a fraction of (altitude + 4 km): for the field and an observer.
const FIELD_SHELLS: f64 = 0.5;
const VIEW_SHELLS: f64 = 0.2;
/// Rise between two readings of sunlight on a ray that builds the field, per (altitude + 4 km): in
/// twilight the sun lights only what is high, and fades fast below.
const SUNLIT_RISE: f64 = 0.1;
/// Share of a ray's scattered light below which the field is not read at a stop.
const FAINT: f32 = 1e-4;
/// Sampling of the rays that build the diffuse field.
const FIELD_SAMPLING: Sampling = Sampling {
    depth: 1.0,
    rise: 0.6,
    turn: 0.02,
    opaque: 12.0,
};
/// Sampling of an observer's rays.
const VIEW_SAMPLING: Sampling = Sampling {
    depth: 0.8,
    rise: 0.4,
    turn: 0.01,
    opaque: 14.0,
};

/// A solved atmosphere: answers for any observer, sun and direction.
#[derive(Clone, Debug)]
pub struct Transport {
    /// At every wavelength of the profile.
    direct: Sunlit,
    /// At the wavelengths that the diffuse light is solved for.
    diffuse: Diffuse,
    spread: Spread,
    view_shells: Vec<f64>,
    /// The series was cut after single scattering.
    is_single: bool,
}

/// Air and ground in sunlight: single scattering.
#[derive(Clone, Debug)]
struct Sunlit {
    medium: Medium,
    sun: SunTable,
    /// Ground albedo over π \[sr⁻¹\].
    reflectance: f64,
}

/// The diffuse field, and what it takes to read it.
#[derive(Clone, Debug)]
struct Diffuse {
    air: Sunlit,
    grid: Grid,
    harmonics: Harmonics,
    source: Source,
    orders: usize,
    /// Altitudes at which sunlight is read along the rays that build the field \[km\].
    sunlit_levels: LevelFinder,
    field_shells: Vec<f64>,
    view_shells: Vec<f64>,
}

/// Buffers of one thread.
#[derive(Debug, Default)]
struct Scratch {
    path: Path,
    sun: Vec<SunPlace>,
    fan: FanScratch,
    rays: Vec<Ray>,
    /// `[ray * vectors + vector]`
    radiance: Vec<Lanes>,
}

/// Directions of the field's quadrature at one zenith angle of a shell.
#[derive(Debug)]
struct Ring {
    template: Template,
    /// Solid angle of each direction \[sr\].
    weight: f64,
    /// Cosines of the azimuths, over half the circle.
    cos_azimuth: Vec<f64>,
}

impl Transport {
    /// Solves for the diffuse field of an atmosphere over ground of a given albedo.
    ///
    /// # Errors
    /// Refuses malformed tables and albedos outside 0..1; reports a series that does not converge.
    pub fn solve(
        optics: &OpticalProfile,
        ground_albedo: f64,
        settings: &TransportSettings,
    ) -> Result<Self, TransportError> {
        let (levels, wavelengths) = (optics.altitude_km.len(), optics.wavelength_nm.len());
        let tables = [
            &optics.rayleigh_scattering_per_km,
            &optics.gas_absorption_per_km,
            &optics.aerosol_scattering_per_km,
            &optics.aerosol_absorption_per_km,
            &optics.aerosol_g,
            &optics.aerosol_g2,
            &optics.aerosol_g_weight,
        ];
        if levels < 2 || wavelengths == 0 || tables.iter().any(|t| t.len() != levels * wavelengths)
        {
            return Err(TransportError::Shape { levels });
        }
        Self::check(ground_albedo)?;
        let found = settings.columns_deg.len();
        if found < 4 {
            return Err(TransportError::Columns { found });
        }
        let spread = Spread::new(optics);
        let direct = Sunlit::new(optics, ground_albedo);
        let air = spread.coarse(optics).map_or_else(
            || direct.clone(),
            |(coarse, wavelengths)| Sunlit {
                medium: Medium::new(&coarse),
                sun: direct.sun.pick(wavelengths),
                ..direct
            },
        );
        let mut diffuse = Diffuse::new(air, settings);
        diffuse.successive_orders(settings)?;
        let view_shells = direct.medium.segment_levels(VIEW_SHELLS);
        Ok(Self {
            direct,
            diffuse,
            spread,
            view_shells,
            is_single: settings.last_order == Some(1),
        })
    }

    /// Checks an albedo without solving.
    ///
    /// # Errors
    /// Refuses albedos outside 0..1.
    pub fn check(ground_albedo: f64) -> Result<(), TransportError> {
        if (0.0..=1.0).contains(&ground_albedo) {
            Ok(())
        } else {
            Err(TransportError::Albedo(ground_albedo))
        }
    }

    /// Orders of scattering that were summed; the rest of the series is extrapolated.
    #[must_use]
    pub const fn orders(&self) -> usize {
        self.diffuse.orders
    }

    /// Radiance per unit solar irradiance \[sr⁻¹\] at each wavelength of the profile, entry
    /// `direction * wavelengths + wavelength`.
    ///
    /// Azimuth is relative to the sun. Directions below the geometric horizon end on the ground.
    #[must_use]
    pub fn radiance_ratio(
        &self,
        observer_altitude: Length,
        sun_zenith: Angle,
        directions: &[SkyDirection],
    ) -> Vec<f64> {
        self.collect(observer_altitude, sun_zenith, directions, !self.is_single)
    }

    /// First order of scattering alone (sun → air → eye and sun → ground → eye), same layout.
    #[must_use]
    pub fn single_scattering_ratio(
        &self,
        observer_altitude: Length,
        sun_zenith: Angle,
        directions: &[SkyDirection],
    ) -> Vec<f64> {
        self.collect(observer_altitude, sun_zenith, directions, false)
    }

    fn collect(
        &self,
        observer_altitude: Length,
        sun_zenith: Angle,
        directions: &[SkyDirection],
        diffuse: bool,
    ) -> Vec<f64> {
        let n = self.direct.medium.wavelengths;
        let top_km = self.direct.medium.top_km();
        let radius = EARTH_RADIUS_KM + observer_altitude.km().clamp(0.0, top_km);
        // directions of equal zenith angle share a path
        let same = |a: &SkyDirection, b: &SkyDirection| {
            a.view_zenith.radians().to_bits() == b.view_zenith.radians().to_bits()
        };
        let rings: Vec<&[SkyDirection]> = directions
            .chunk_by(same)
            .flat_map(|ring| ring.chunks(32))
            .collect();
        let sun_cosine = sun_zenith.radians().cos();
        rings
            .par_iter()
            .map_init(Scratch::default, |scratch, ring| {
                let cosine = ring[0].view_zenith.radians().cos();
                let rays: Vec<Ray> = ring
                    .iter()
                    .map(|direction| Ray {
                        radius,
                        cosine,
                        sun_cosine,
                        cos_gamma: direction.cos_scattering_angle(sun_zenith),
                    })
                    .collect();
                let mut out = Vec::with_capacity(ring.len() * n);
                let mut radiance = vec![ZERO; self.direct.medium.vectors];
                // what the Earth's shadow does not cut is the same for the whole ring
                let mut uncut = None;
                for ray in &rays {
                    let cut = ray.shadow_edges(f64::INFINITY).next().is_some();
                    let cut_path;
                    let template = if cut {
                        cut_path = self.single_template(ray, &mut scratch.path);
                        &cut_path
                    } else {
                        uncut.get_or_insert_with(|| self.single_template(ray, &mut scratch.path))
                    };
                    radiance.fill(ZERO);
                    self.direct
                        .add_sunlight(ray, template, &mut scratch.sun, &mut radiance);
                    out.extend(radiance.iter().flatten().take(n).map(|x| f64::from(*x)));
                }
                if diffuse {
                    let template =
                        self.diffuse
                            .template(radius, cosine, View::Observer, &mut scratch.path);
                    let vectors = self.diffuse.air.medium.vectors;
                    let mut radiance = vec![ZERO; rays.len() * vectors];
                    let source = &self.diffuse.source;
                    self.diffuse.add_diffuse(
                        &rays,
                        &template,
                        source,
                        &mut scratch.fan,
                        &mut radiance,
                    );
                    for (light, out) in radiance.chunks_exact(vectors).zip(out.chunks_exact_mut(n))
                    {
                        self.spread.add(light, out);
                    }
                }
                out
            })
            .flatten_iter()
            .collect()
    }

    /// The path of an observer's ray for sunlight scattered once.
    fn single_template(&self, ray: &Ray, path: &mut Path) -> Template {
        let medium = &self.direct.medium;
        path.trace(ray, medium, &self.view_shells, &VIEW_SAMPLING);
        pulp::Arch::new().dispatch(|| Template::of_path(ray, path, medium))
    }
}

/// What is read along a path, and for whom.
#[derive(Clone, Copy, Debug)]
enum View {
    /// Sunlight along the rays that build the field.
    Sunlight,
    /// The field, along the rays that build its next order.
    Field,
    /// The field, along an observer's rays.
    Observer,
}

impl Diffuse {
    fn new(air: Sunlit, settings: &TransportSettings) -> Self {
        let top = air.medium.top_km();
        let mut shells: Vec<f64> = settings
            .shells_km
            .iter()
            .copied()
            .filter(|z| *z < top - 1e-6)
            .collect();
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
            sunlit_levels: LevelFinder::new(&sunlit_levels(top)),
            field_shells,
            harmonics: Harmonics::new(degree),
            source: Source::default(),
            orders: 1,
            grid,
            air,
        }
    }

    fn template(&self, radius: f64, cosine: f64, view: View, path: &mut Path) -> Template {
        let field = Readings {
            levels: &self.grid.shells,
            faint: FAINT,
        };
        let sunlight = Readings {
            levels: &self.sunlit_levels,
            faint: 0.0,
        };
        let (readings, shells, sampling) = match view {
            View::Sunlight => (sunlight, &self.field_shells, &FIELD_SAMPLING),
            View::Field => (field, &self.field_shells, &FIELD_SAMPLING),
            View::Observer => (field, &self.view_shells, &VIEW_SAMPLING),
        };
        let medium = &self.air.medium;
        pulp::Arch::new()
            .dispatch(|| Template::new(radius, cosine, medium, &readings, shells, sampling, path))
    }

    /// Sums the orders of scattering into `self.source`.
    fn successive_orders(&mut self, settings: &TransportSettings) -> Result<(), TransportError> {
        let shells = self.grid.shells.levels();
        let rays: Vec<Vec<Ring>> = shells
            .par_iter()
            .map_init(Scratch::default, |scratch, z| {
                self.rings_at(*z, settings, scratch)
            })
            .collect();
        let mut order = self.gather(&rays, None);
        let mut total = order.clone();
        let mut last_limit = total.column_sums();
        let mut share = f64::INFINITY;
        while share > settings.tolerance {
            // the field of one order is the source of the next
            if settings
                .last_order
                .is_some_and(|last| last <= self.orders + 1)
            {
                break;
            }
            if self.orders >= settings.most_orders {
                return Err(TransportError::NotConverged {
                    orders: self.orders,
                    share,
                    expected: settings.tolerance,
                });
            }
            let fallen = order.column_sums();
            let next = self.gather(&rays, Some(&Source::new(order)));
            self.orders += 1;
            total.add(&next, None);
            // the rest of the series, if each column's light goes on falling by the same ratio
            let (fresh, sum) = (next.column_sums(), total.column_sums());
            let mut tail = vec![ZERO; sum.len()];
            share = 0.0;
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
            if share <= settings.tolerance {
                total.add(&next, Some(&tail));
            }
            order = next;
        }
        self.source = Source::new(total);
        Ok(())
    }

    /// The field's directions at a shell; zenith intervals meet at the shell's own horizon.
    fn rings_at(&self, z: f64, settings: &TransportSettings, scratch: &mut Scratch) -> Vec<Ring> {
        let horizon = horizon_cosine(z).acos();
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
    /// Without a source field, the first order.
    fn gather(&self, rays: &[Vec<Ring>], source: Option<&Source>) -> Field {
        let shape = Shape {
            columns: self.grid.columns.levels().len(),
            count: self.harmonics.count(),
            vectors: self.air.medium.vectors,
        };
        let rings: Vec<&Ring> = rays.iter().flatten().collect();
        let waves: Vec<Vec<Lanes>> = rings
            .par_iter()
            .map_init(Scratch::default, |scratch, ring| {
                self.ring_waves(ring, source, scratch)
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
        source: Option<&Source>,
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
        match source {
            None => {
                let template = self.template(template.radius, mu, View::Sunlight, path);
                for (ray, radiance) in rays.iter().zip(radiance.chunks_exact_mut(vectors)) {
                    self.air.add_sunlight(ray, &template, sun, radiance);
                }
            }
            Some(source) => self.add_diffuse(rays, template, source, fan, radiance),
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
    fn add_diffuse(
        &self,
        rays: &[Ray],
        template: &Template,
        source: &Source,
        scratch: &mut FanScratch,
        radiance: &mut [Lanes],
    ) {
        pulp::Arch::new().dispatch(FanSweep {
            grid: &self.grid,
            harmonics: &self.harmonics,
            source,
            template,
            rays,
            reflectance: self.air.reflectance,
            scratch,
            radiance,
        });
    }
}

impl Sunlit {
    fn new(optics: &OpticalProfile, ground_albedo: f64) -> Self {
        let medium = Medium::new(optics);
        Self {
            sun: SunTable::new(&medium),
            reflectance: ground_albedo / core::f64::consts::PI,
            medium,
        }
    }

    /// Adds sunlight scattered once, by air or ground, along a ray to `radiance`.
    fn add_sunlight(
        &self,
        ray: &Ray,
        template: &Template,
        sun: &mut Vec<SunPlace>,
        radiance: &mut [Lanes],
    ) {
        sun.clear();
        sun.extend(
            template
                .stops
                .iter()
                .map(|stop| self.sun.place(stop.z, sun_cosine_at(ray, stop))),
        );
        if sun.iter().any(|s| s.lit) {
            pulp::Arch::new().dispatch(SunlitStops {
                medium: &self.medium,
                table: &self.sun,
                ray,
                template,
                sun,
                reflectance: self.reflectance,
                radiance,
            });
        }
    }
}

/// Inner loop: sunlight scattered once at the stops of a ray, all wavelengths.
struct SunlitStops<'a> {
    medium: &'a Medium,
    table: &'a SunTable,
    ray: &'a Ray,
    template: &'a Template,
    sun: &'a [SunPlace],
    reflectance: f64,
    radiance: &'a mut [Lanes],
}

impl pulp::NullaryFnOnce for SunlitStops<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self {
            medium: m,
            table,
            ray,
            template,
            sun,
            reflectance,
            radiance,
        } = self;
        let rayleigh_phase = lane(phase::rayleigh(ray.cos_gamma, m.depolarization));
        let vectors = radiance.len();
        for (k, stop) in template.stops.iter().enumerate() {
            if !sun[k].lit {
                continue;
            }
            let hazy = m.hazy[stop.place.level] || m.hazy[stop.place.level + 1];
            for (v, out) in radiance.iter_mut().enumerate() {
                let mut scattered = ZERO;
                let at = k * vectors + v;
                add_scaled(&mut scattered, rayleigh_phase, &template.rayleigh[at]);
                if hazy {
                    let phase = m.aerosol_phase(stop.place, v, ray.cos_gamma);
                    add_product(&mut scattered, &template.aerosol[at], &phase);
                }
                add_product(out, &table.transmittance(&sun[k], v), &scattered);
            }
        }
        let last = template.stops.len() - 1;
        let cosine = sun_cosine_at(ray, &template.stops[last]);
        if cosine > 0.0 && sun[last].lit {
            for (v, through) in template.ground.iter().enumerate() {
                let mut reflected = ZERO;
                add_scaled(&mut reflected, lane(cosine * reflectance), through);
                add_product(
                    &mut radiance[v],
                    &table.transmittance(&sun[last], v),
                    &reflected,
                );
            }
        }
    }
}

fn sun_cosine_at(ray: &Ray, stop: &Stop) -> f64 {
    ((ray.radius * ray.sun_cosine + stop.length * ray.cos_gamma) / stop.radius).clamp(-1.0, 1.0)
}

/// Altitudes from the ground to the top of the atmosphere, a constant share of (altitude + 4 km) apart
/// \[km\].
fn sunlit_levels(top_km: f64) -> Vec<f64> {
    let mut levels: Vec<f64> =
        core::iter::successors(Some(0.0), |z| Some(z + SUNLIT_RISE * (z + 4.0)))
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

/// Harmonics beyond this degree are not used.
const HIGHEST_DEGREE: usize = 12;
/// Largest neglected moment of doubly scattered light, relative to its mean.
const HARMONICS_TOLERANCE: f64 = 0.1;
