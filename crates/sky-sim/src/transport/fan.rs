//! Diffuse light along a fan: rays that leave one point at one zenith angle, for any sun and azimuth.
//!
//! The rays of a fan pass the same stops at the same angle to the vertical; only the azimuth and the
//! local sun differ. So the source at a stop is summed over the degree of the harmonics once for all
//! of them, which leaves each ray a short sum over their order.

use super::field::{Grid, HIGHEST_DEGREE, Harmonics, Shape, Source};
use super::lanes::{Lanes, WIDTH, ZERO, acos, add_positive, add_scaled, exp, lane};
use super::path::Ray;
use super::template::{Stop, Template};
use core::ops::Range;
use sky_core::quantity::Angle;

/// Buffers of one thread.
#[derive(Debug, Default)]
pub(super) struct FanScratch {
    readings: Vec<Readings>,
    harmonics: Vec<f32>,
    log_scale: Vec<f64>,
    cubics: Vec<[f32; 4]>,
    folded: Vec<Lanes>,
}

/// Where eight rays read the field at a stop.
#[derive(Clone, Copy, Debug)]
struct Readings {
    /// Column of the grid below the local sun zenith angle.
    column: [usize; WIDTH],
    /// Fraction of the way to the next column.
    fraction: Lanes,
    /// Cosine of the azimuth between ray and sun.
    cos_azimuth: Lanes,
}

/// Inner loop: the diffuse light along the rays of a fan, all wavelengths.
pub(super) struct FanSweep<'a> {
    pub(super) grid: &'a Grid,
    pub(super) harmonics: &'a Harmonics,
    pub(super) source: &'a Source,
    pub(super) template: &'a Template,
    pub(super) rays: &'a [Ray],
    /// Ground albedo over π \[sr⁻¹\].
    pub(super) reflectance: f64,
    pub(super) scratch: &'a mut FanScratch,
    /// Light is added here, `[ray * vectors + vector]`.
    pub(super) radiance: &'a mut [Lanes],
}

impl pulp::NullaryFnOnce for FanSweep<'_> {
    type Output = ();

    #[inline(always)]
    fn call(mut self) {
        let last = self.template.stops.len() - 1;
        for (k, stop) in self.template.stops.iter().enumerate() {
            let columns = self.locate(stop);
            self.fold(stop, &columns);
            self.add_air(k, &columns);
            if k == last && self.template.ends_on_ground {
                self.add_ground(&columns);
            }
        }
    }
}

impl FanSweep<'_> {
    fn vectors(&self) -> usize {
        self.radiance.len() / self.rays.len()
    }

    /// Highest degree of harmonics that the shells around a stop use.
    fn degree(&self, stop: &Stop) -> usize {
        let degrees = &self.grid.degrees;
        degrees[stop.shell.level].max(degrees[stop.shell.level + 1])
    }

    /// The shells around a stop and their shares; one shell where the stop lies on it.
    fn shells(stop: &Stop) -> impl Iterator<Item = (usize, f64)> {
        let (level, fraction) = (stop.shell.level, stop.shell.fraction);
        [(level, 1.0 - fraction), (level + 1, fraction)]
            .into_iter()
            .filter(|(_, share)| *share > 0.0)
    }

    /// Finds where each ray reads the field at a stop; returns the columns in use.
    #[inline(always)]
    fn locate(&mut self, stop: &Stop) -> Range<usize> {
        self.scratch.readings.clear();
        let (mut first, mut end) = (usize::MAX, 0);
        let sine_square = (1.0 - stop.cosine) * (1.0 + stop.cosine);
        for rays in self.rays.chunks(WIDTH) {
            let ray = |i: usize| &rays[i.min(rays.len() - 1)];
            let cos_gamma: [f64; WIDTH] = core::array::from_fn(|i| ray(i).cos_gamma);
            let start: [f64; WIDTH] = core::array::from_fn(|i| ray(i).radius * ray(i).sun_cosine);
            let mut sun_cosine = [0.0; WIDTH];
            for i in 0..WIDTH {
                let cosine = (start[i] + stop.length * cos_gamma[i]) / stop.radius;
                sun_cosine[i] = cosine.clamp(-1.0, 1.0);
            }
            let mut azimuth = [0.0; WIDTH];
            for i in 0..WIDTH {
                let sun_sine_square = (1.0 - sun_cosine[i]) * (1.0 + sun_cosine[i]);
                // where the sun or the ray is vertical, any azimuth is right
                let sines = (sine_square * sun_sine_square).max(1e-18).sqrt();
                let cosine = (cos_gamma[i] - stop.cosine * sun_cosine[i]) / sines;
                azimuth[i] = cosine.clamp(-1.0, 1.0);
            }
            let sun_zenith = acos(&sun_cosine);
            let mut readings = Readings {
                column: [0; WIDTH],
                fraction: ZERO,
                cos_azimuth: azimuth.map(lane),
            };
            for (i, angle) in sun_zenith.iter().enumerate() {
                let column = self
                    .grid
                    .columns
                    .find(Angle::from_radians(*angle).degrees());
                readings.column[i] = column.level;
                readings.fraction[i] = lane(column.fraction);
                first = first.min(column.level);
                end = end.max(column.level + 2);
            }
            self.scratch.readings.push(readings);
        }
        first..end
    }

    /// Sums the source at a stop over the degree of the harmonics:
    /// `folded[(vector * orders + order) * columns + column]`.
    #[inline(always)]
    fn fold(&mut self, stop: &Stop, columns: &Range<usize>) {
        let Shape {
            columns: all,
            count,
            vectors,
        } = self.source.field.shape;
        let degree = self.degree(stop);
        let scratch = &mut *self.scratch;
        scratch.harmonics.resize(count, 0.0);
        self.harmonics.evaluate(stop.cosine, &mut scratch.harmonics);
        scratch.folded.clear();
        scratch
            .folded
            .resize(vectors * (degree + 1) * columns.len(), ZERO);
        let mut sums = scratch.folded.chunks_exact_mut(columns.len());
        for v in 0..vectors {
            for m in 0..=degree {
                let Some(sums) = sums.next() else { return };
                let first = self.harmonics.first(m);
                for (shell, share) in Self::shells(stop) {
                    let row = ((shell * vectors + v) * count + first) * all;
                    let moments = self.source.field.moments[row..].chunks_exact(all);
                    let functions = &scratch.harmonics[first..=first + degree - m];
                    for (y, moments) in functions.iter().zip(moments) {
                        let factor = lane(share) * y;
                        for (sum, moment) in sums.iter_mut().zip(&moments[columns.clone()]) {
                            add_scaled(sum, factor, moment);
                        }
                    }
                }
            }
        }
        scratch.log_scale.clear();
        scratch.log_scale.resize(all, 0.0);
        for (shell, share) in Self::shells(stop) {
            let row = &self.source.log_scale[shell * all..(shell + 1) * all];
            for (sum, log_scale) in scratch.log_scale.iter_mut().zip(row) {
                *sum += share * log_scale;
            }
        }
        scratch.cubics.clear();
        scratch
            .cubics
            .extend((columns.start..columns.end - 1).map(|column| {
                self.grid
                    .log_scale_between(column, &scratch.log_scale)
                    .map(lane)
            }));
    }

    /// Weights of the two columns around each of eight rays.
    #[inline(always)]
    fn weights(scratch: &FanScratch, readings: &Readings, first: usize) -> [Lanes; 2] {
        let mut log_scale = ZERO;
        for (i, log_scale) in log_scale.iter_mut().enumerate() {
            let [a, b, c, d] = scratch.cubics[readings.column[i] - first];
            let t = readings.fraction[i];
            *log_scale = a + t * (b + t * (c + t * d));
        }
        let scale = exp(&log_scale);
        let mut weights = [ZERO; 2];
        for i in 0..WIDTH {
            weights[0][i] = (1.0 - readings.fraction[i]) * scale[i];
            weights[1][i] = readings.fraction[i] * scale[i];
        }
        weights
    }

    /// Adds what the air around a stop sends along each ray.
    #[inline(always)]
    fn add_air(&mut self, k: usize, columns: &Range<usize>) {
        let vectors = self.vectors();
        let orders = self.degree(&self.template.stops[k]) + 1;
        let arriving = &self.template.weights[k * vectors..(k + 1) * vectors];
        let scratch = &*self.scratch;
        for (rays, readings) in self
            .radiance
            .chunks_mut(WIDTH * vectors)
            .zip(&scratch.readings)
        {
            let weights = Self::weights(scratch, readings, columns.start);
            let mut cosines = [ZERO; HIGHEST_DEGREE + 1];
            cosines[0] = [1.0; WIDTH];
            cosines[1] = readings.cos_azimuth;
            for m in 2..orders {
                let (last, before) = (cosines[m - 1], cosines[m - 2]);
                for (i, cosine) in cosines[m].iter_mut().enumerate() {
                    *cosine = 2.0 * readings.cos_azimuth[i] * last[i] - before[i];
                }
            }
            for (i, radiance) in rays.chunks_exact_mut(vectors).enumerate() {
                let column = readings.column[i] - columns.start;
                let folded = scratch.folded.chunks_exact(columns.len() * orders);
                for ((out, arriving), folded) in radiance.iter_mut().zip(arriving).zip(folded) {
                    let (mut low, mut high) = (ZERO, ZERO);
                    let orders = folded.chunks_exact(columns.len());
                    for (cosines, columns) in cosines.iter().zip(orders) {
                        add_scaled(&mut low, cosines[i], &columns[column]);
                        add_scaled(&mut high, cosines[i], &columns[column + 1]);
                    }
                    let mut source = ZERO;
                    add_scaled(&mut source, weights[0][i], &low);
                    add_scaled(&mut source, weights[1][i], &high);
                    add_positive(out, arriving, &source);
                }
            }
        }
    }

    /// Adds what the ground at the last stop sends along each ray.
    #[inline(always)]
    fn add_ground(&mut self, columns: &Range<usize>) {
        let vectors = self.vectors();
        let scratch = &*self.scratch;
        let all = self.source.field.shape.columns;
        for (rays, readings) in self
            .radiance
            .chunks_mut(WIDTH * vectors)
            .zip(&scratch.readings)
        {
            let weights = Self::weights(scratch, readings, columns.start);
            for (i, radiance) in rays.chunks_exact_mut(vectors).enumerate() {
                let rows = self.source.field.ground_irradiance.chunks_exact(all);
                for ((out, through), row) in
                    radiance.iter_mut().zip(&self.template.through).zip(rows)
                {
                    let mut irradiance = ZERO;
                    for side in 0..2 {
                        let weight = weights[side][i] * lane(self.reflectance);
                        add_scaled(&mut irradiance, weight, &row[readings.column[i] + side]);
                    }
                    add_positive(out, through, &irradiance);
                }
            }
        }
    }
}
