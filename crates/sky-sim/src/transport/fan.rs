//! Diffuse light along a fan: rays that leave one point at one zenith angle, for any sun and azimuth.
//!
//! The rays of a fan pass the same stops at the same angle to the vertical; only the azimuth and the
//! local sun differ. So the source at a stop is summed over the degree of the harmonics once for all
//! of them, which leaves each ray a short sum over their order.

use super::field::{Field, Grid, Harmonics};
use super::lanes::{Lanes, WIDTH, ZERO, acos, add_scaled, exp, lane};
use super::path::Ray;
use super::template::{Stop, Template};
use sky_core::quantity::Angle;

/// Buffers of one thread.
#[derive(Debug, Default)]
pub(super) struct FanScratch {
    readings: Vec<Readings>,
    harmonics: Vec<f32>,
    log_scale: Vec<f64>,
    cubics: Vec<[f32; 4]>,
    folded: Vec<Lanes>,
    irradiance: Vec<Lanes>,
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
    pub(super) field: &'a Field,
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
            self.fold(stop, columns);
            self.add_air(k, columns.0);
            if k == last && !self.template.ground.is_empty() {
                self.add_ground(stop, columns);
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

    /// Finds where each ray reads the field at a stop; returns the first and last columns in use.
    #[inline(always)]
    fn locate(&mut self, stop: &Stop) -> (usize, usize) {
        self.scratch.readings.clear();
        let (mut first, mut last) = (usize::MAX, 0);
        let sine_square = (1.0 - stop.cosine) * (1.0 + stop.cosine);
        for rays in self.rays.chunks(WIDTH) {
            let ray = |i: usize| &rays[i.min(rays.len() - 1)];
            let (mut sun_cosine, mut cos_azimuth) = ([0.0; WIDTH], ZERO);
            for i in 0..WIDTH {
                let Ray {
                    radius,
                    sun_cosine: start,
                    cos_gamma,
                    ..
                } = ray(i);
                let cosine = ((radius * start + stop.length * cos_gamma) / stop.radius)
                    .clamp(-1.0, 1.0);
                let sines = (sine_square * (1.0 - cosine) * (1.0 + cosine)).max(0.0).sqrt();
                let azimuth = (cos_gamma - stop.cosine * cosine) / sines.max(1e-9);
                cos_azimuth[i] = if sines > 1e-9 {
                    lane(azimuth.clamp(-1.0, 1.0))
                } else {
                    1.0
                };
                sun_cosine[i] = cosine;
            }
            let sun_zenith = acos(&sun_cosine);
            let mut readings = Readings {
                column: [0; WIDTH],
                fraction: ZERO,
                cos_azimuth,
            };
            for i in 0..WIDTH {
                let column = self
                    .grid
                    .columns
                    .find(Angle::from_radians(sun_zenith[i]).degrees());
                readings.column[i] = column.level;
                readings.fraction[i] = lane(column.fraction);
                first = first.min(column.level);
                last = last.max(column.level + 1);
            }
            self.scratch.readings.push(readings);
        }
        (first, last)
    }

    /// Sums the source at a stop over the degree of the harmonics, for columns `first..=last`:
    /// `folded[(column * vectors + vector) * orders + order]`.
    #[inline(always)]
    fn fold(&mut self, stop: &Stop, (first, last): (usize, usize)) {
        let vectors = self.vectors();
        let degree = self.degree(stop);
        let (grid, field, harmonics) = (self.grid, self.field, self.harmonics);
        let count = harmonics.count();
        let scratch = &mut *self.scratch;
        scratch.harmonics.resize(count, 0.0);
        harmonics.evaluate(stop.cosine, &mut scratch.harmonics);
        scratch.folded.clear();
        for column in first..=last {
            for v in 0..vectors {
                for m in 0..=degree {
                    let from = harmonics.first(m);
                    let functions = &scratch.harmonics[from..=from + degree - m];
                    let mut sum = ZERO;
                    for (shell, share) in Self::shells(stop) {
                        let node = grid.node(shell, column);
                        let at = (node * vectors + v) * count + from;
                        let moments = &field.moments[at..at + functions.len()];
                        let mut one = ZERO;
                        for (y, moment) in functions.iter().zip(moments) {
                            add_scaled(&mut one, *y, moment);
                        }
                        add_scaled(&mut sum, lane(share * field.inverse_scale[node]), &one);
                    }
                    scratch.folded.push(sum);
                }
            }
        }
        // What is interpolated linearly is the field divided by its size, the size itself by its
        // logarithm.
        scratch.log_scale.clear();
        scratch
            .log_scale
            .extend((0..grid.columns.levels().len()).map(|column| {
                Self::shells(stop)
                    .map(|(shell, share)| share * field.log_scale[grid.node(shell, column)])
                    .sum::<f64>()
            }));
        scratch.cubics.clear();
        scratch
            .cubics
            .extend((first..last).map(|column| {
                grid.log_scale_between(column, &scratch.log_scale).map(lane)
            }));
    }

    /// Weights of the two columns around each of eight rays.
    #[inline(always)]
    fn weights(scratch: &FanScratch, readings: &Readings, first: usize) -> [Lanes; 2] {
        let mut log_scale = ZERO;
        for i in 0..WIDTH {
            let [a, b, c, d] = scratch.cubics[readings.column[i] - first];
            let t = readings.fraction[i];
            log_scale[i] = a + t * (b + t * (c + t * d));
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
    fn add_air(&mut self, k: usize, first: usize) {
        let vectors = self.vectors();
        let orders = self.degree(&self.template.stops[k]) + 1;
        let arriving = &self.template.weights[k * vectors..(k + 1) * vectors];
        let scratch = &*self.scratch;
        for (rays, readings) in self
            .radiance
            .chunks_mut(WIDTH * vectors)
            .zip(&scratch.readings)
        {
            let weights = Self::weights(scratch, readings, first);
            let mut cosines = [ZERO; super::HIGHEST_DEGREE + 1];
            cosines[0] = [1.0; WIDTH];
            cosines[1] = readings.cos_azimuth;
            for m in 2..orders {
                for i in 0..WIDTH {
                    cosines[m][i] =
                        2.0 * readings.cos_azimuth[i] * cosines[m - 1][i] - cosines[m - 2][i];
                }
            }
            for (i, radiance) in rays.chunks_exact_mut(vectors).enumerate() {
                let at = (readings.column[i] - first) * vectors * orders;
                let (low, high) = scratch.folded[at..].split_at(vectors * orders);
                for (v, out) in radiance.iter_mut().enumerate() {
                    let low = &low[v * orders..(v + 1) * orders];
                    let high = &high[v * orders..(v + 1) * orders];
                    let (mut a, mut b) = (ZERO, ZERO);
                    for ((cosines, low), high) in cosines.iter().zip(low).zip(high) {
                        add_scaled(&mut a, cosines[i], low);
                        add_scaled(&mut b, cosines[i], high);
                    }
                    for l in 0..WIDTH {
                        let source = weights[0][i] * a[l] + weights[1][i] * b[l];
                        out[l] += arriving[v][l] * source.max(0.0);
                    }
                }
            }
        }
    }

    /// Adds what the ground at the last stop sends along each ray.
    #[inline(always)]
    fn add_ground(&mut self, stop: &Stop, (first, last): (usize, usize)) {
        let vectors = self.vectors();
        let scratch = &mut *self.scratch;
        scratch.irradiance.clear();
        for column in first..=last {
            let share: f64 = Self::shells(stop)
                .map(|(shell, share)| {
                    share * self.field.inverse_scale[self.grid.node(shell, column)]
                })
                .sum();
            for v in 0..vectors {
                let row = &self.field.ground_irradiance[column * vectors + v];
                scratch.irradiance.push(row.map(|e| lane(share) * e));
            }
        }
        for (rays, readings) in self
            .radiance
            .chunks_mut(WIDTH * vectors)
            .zip(&scratch.readings)
        {
            let weights = Self::weights(scratch, readings, first);
            for (i, radiance) in rays.chunks_exact_mut(vectors).enumerate() {
                let at = (readings.column[i] - first) * vectors;
                let (low, high) = scratch.irradiance[at..].split_at(vectors);
                for (v, out) in radiance.iter_mut().enumerate() {
                    for l in 0..WIDTH {
                        let irradiance = weights[0][i] * low[v][l] + weights[1][i] * high[v][l];
                        out[l] += self.template.ground[v][l] * irradiance * lane(self.reflectance);
                    }
                }
            }
        }
    }
}
