//! A ray's path without its azimuth: where the diffuse source is read along it, and how much of each
//! reading arrives.
//!
//! Extinction depends on altitude alone, so all rays that leave a point at one zenith angle share
//! the same attenuation. It is integrated finely once; what remains of a ray is a short weighted sum.

use super::lanes::{Lanes, WIDTH, ZERO, lane, simpson_transmittance};
use super::medium::{Between, LevelFinder, Medium};
use super::path::{Path, Point, Ray, Sampling, Steps};

/// A place along the path where the source is read.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stop {
    /// Distance from the start \[km\].
    pub(super) length: f64,
    /// Distance from the Earth's center \[km\].
    pub(super) radius: f64,
    /// Cosine of the angle between the ray and the local vertical.
    pub(super) cosine: f64,
    /// Place among the shells of the field.
    pub(super) shell: Between,
    /// Place among the medium's levels.
    pub(super) place: Between,
    /// Altitude \[km\].
    pub(super) z: f64,
}

impl Stop {
    fn new(point: &Point, shell: Between) -> Self {
        Self {
            length: point.length,
            radius: sky_core::quantity::EARTH_RADIUS_KM + point.z,
            cosine: point.cosine,
            shell,
            place: point.place,
            z: point.z,
        }
    }
}

impl Stop {
    /// Cosine of the local sun zenith angle at the stop of a ray.
    pub(super) fn sun_cosine(&self, ray: &Ray) -> f64 {
        ((ray.radius * ray.sun_cosine + self.length * ray.cos_gamma) / self.radius).clamp(-1.0, 1.0)
    }
}

/// Where a source is read along a path.
#[derive(Clone, Copy, Debug)]
pub(super) struct Readings<'a> {
    /// The altitudes of the readings.
    pub(super) levels: &'a LevelFinder,
    /// Share of a ray's scattered light up to which a reading is left out.
    pub(super) faint: f32,
}

/// The stops of a path and their weights.
#[derive(Clone, Debug)]
pub(super) struct Template {
    pub(super) radius: f64,
    pub(super) cosine: f64,
    pub(super) stops: Vec<Stop>,
    /// Scattering optical depth that arrives from around each stop: molecules, aerosol, and both;
    /// `[stop * vectors + vector]` \[1\].
    pub(super) rayleigh: Vec<Lanes>,
    pub(super) aerosol: Vec<Lanes>,
    pub(super) weights: Vec<Lanes>,
    /// Transmittance of the whole path.
    pub(super) through: Vec<Lanes>,
    /// Whether the last stop lies on the ground.
    pub(super) ends_on_ground: bool,
}

/// Sampling of the source: by shells and the turn of the vertical only.
const STOPS: Sampling = Sampling {
    depth: f64::INFINITY,
    rise: 1.5,
    turn: 0.02,
    opaque: f64::INFINITY,
};

impl Template {
    /// Integrates the attenuation along a ray of any azimuth, no farther than `reach` \[km\].
    #[inline(always)]
    pub(super) fn new(
        ray: &Ray,
        reach: f64,
        medium: &Medium,
        readings: &Readings<'_>,
        steps: Steps<'_>,
        path: &mut Path,
    ) -> Self {
        let coarse = Steps {
            shells: readings.levels.levels(),
            sampling: &STOPS,
        };
        path.trace(ray, reach, medium, coarse);
        let stops: Vec<Stop> = path
            .points
            .iter()
            .step_by(2)
            .map(|p| Stop::new(p, readings.levels.find(p.z)))
            .collect();
        path.trace(ray, reach, medium, steps);
        let vectors = medium.vectors;
        let mut template = Self {
            radius: ray.radius,
            cosine: ray.cosine,
            rayleigh: vec![ZERO; stops.len() * vectors],
            aerosol: vec![ZERO; stops.len() * vectors],
            weights: Vec::new(),
            stops,
            through: Vec::with_capacity(vectors),
            ends_on_ground: path.ground,
        };
        for v in 0..vectors {
            template.share_out(path, medium, v);
        }
        template.weights = template
            .rayleigh
            .iter()
            .zip(&template.aerosol)
            .map(|(r, a)| core::array::from_fn(|l| r[l] + a[l]))
            .collect();
        template.drop_faint_stops(vectors, readings.faint);
        template
    }

    /// Shares what is scattered along a path out to the stops on either side, for one vector.
    #[inline(always)]
    fn share_out(&mut self, path: &Path, medium: &Medium, v: usize) {
        let (vectors, stops) = (medium.vectors, &self.stops);
        let mut through = [1.0; WIDTH];
        let mut extinction = medium.at(&medium.extinction, path.points[0].place, v);
        let mut stop = 0;
        for (k, length) in path.lengths.iter().enumerate() {
            let [e_m, e_b] =
                [1, 2].map(|i| medium.at(&medium.extinction, path.points[2 * k + i].place, v));
            let (middle, end) = simpson_transmittance(lane(*length), &extinction, &e_m, &e_b);
            for (i, simpson) in [(0, 1.0), (1, 4.0), (2, 1.0)] {
                let point = &path.points[2 * k + i];
                while stop + 2 < stops.len() && stops[stop + 1].length < point.length {
                    stop += 1;
                }
                let span = (stops[stop + 1].length - stops[stop].length).max(1e-12);
                let f = ((point.length - stops[stop].length) / span).clamp(0.0, 1.0);
                let share = length * simpson / 6.0;
                let shares = [lane((1.0 - f) * share), lane(f * share)];
                for (table, weights) in [
                    (&medium.rayleigh, &mut self.rayleigh),
                    (&medium.aerosol, &mut self.aerosol),
                ] {
                    let scattering = medium.at(table, point.place, v);
                    for l in 0..WIDTH {
                        let attenuation = match i {
                            0 => through[l],
                            1 => through[l] * middle[l],
                            _ => through[l] * end[l],
                        };
                        let w = attenuation * scattering[l];
                        weights[stop * vectors + v][l] += shares[0] * w;
                        weights[(stop + 1) * vectors + v][l] += shares[1] * w;
                    }
                }
            }
            for l in 0..WIDTH {
                through[l] *= end[l];
            }
            extinction = e_b;
        }
        self.through.push(through);
    }

    /// A stop at every point of a path; for sunlight, which is not smooth enough for fewer.
    #[inline(always)]
    pub(super) fn of_path(ray: &Ray, path: &Path, medium: &Medium) -> Self {
        let stops: Vec<Stop> = path
            .points
            .iter()
            .map(|p| Stop::new(p, Between::default()))
            .collect();
        let vectors = medium.vectors;
        let mut weights = vec![ZERO; stops.len() * vectors];
        let mut all_through = Vec::with_capacity(vectors);
        for v in 0..vectors {
            let extinction = |i: usize| medium.at(&medium.extinction, path.points[i].place, v);
            let mut through = [1.0; WIDTH];
            let mut start = extinction(0);
            for (k, length) in path.lengths.iter().enumerate() {
                let stop = extinction(2 * k + 2);
                let (middle, end) =
                    simpson_transmittance(lane(*length), &start, &extinction(2 * k + 1), &stop);
                let sixth = lane(length / 6.0);
                for l in 0..WIDTH {
                    weights[2 * k * vectors + v][l] += sixth * through[l];
                    weights[(2 * k + 1) * vectors + v][l] = 4.0 * sixth * through[l] * middle[l];
                    through[l] *= end[l];
                    weights[(2 * k + 2) * vectors + v][l] = sixth * through[l];
                }
                start = stop;
            }
            all_through.push(through);
        }
        let arriving = |table: &[Lanes]| -> Vec<Lanes> {
            weights
                .iter()
                .enumerate()
                .map(|(i, w)| {
                    let scattering = medium.at(table, stops[i / vectors].place, i % vectors);
                    core::array::from_fn(|l| w[l] * scattering[l])
                })
                .collect()
        };
        Self {
            radius: ray.radius,
            cosine: ray.cosine,
            rayleigh: arriving(&medium.rayleigh),
            aerosol: arriving(&medium.aerosol),
            weights: Vec::new(),
            stops,
            through: all_through,
            ends_on_ground: path.ground,
        }
    }

    /// Cosine of the local sun zenith angle where a ray meets the ground, if it does.
    pub(super) fn ground_sun_cosine(&self, ray: &Ray) -> Option<f64> {
        self.stops
            .last()
            .filter(|_| self.ends_on_ground)
            .map(|stop| stop.sun_cosine(ray))
    }

    /// Drops stops from which at most a faint share arrives at any wavelength; the last stays, it may
    /// be the ground.
    fn drop_faint_stops(&mut self, vectors: usize, faint: f32) {
        let count = self.stops.len();
        let mut all = vec![ZERO; vectors];
        for (k, w) in self.weights.iter().enumerate() {
            for l in 0..WIDTH {
                all[k % vectors][l] += w[l];
            }
        }
        let keep: Vec<bool> = (0..count)
            .map(|k| {
                k + 1 == count
                    || (0..vectors).any(|v| {
                        let w = &self.weights[k * vectors + v];
                        (0..WIDTH).any(|l| w[l] > faint * all[v][l])
                    })
            })
            .collect();
        let mut place = 0..;
        self.stops
            .retain(|_| place.next().is_none_or(|k: usize| keep[k]));
        for table in [&mut self.rayleigh, &mut self.aerosol, &mut self.weights] {
            let mut place = 0..;
            table.retain(|_| place.next().is_none_or(|k: usize| keep[k / vectors]));
        }
    }
}
