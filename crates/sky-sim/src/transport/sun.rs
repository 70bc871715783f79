//! Optical depth from any point of the atmosphere to the sun, along curved-Earth straight rays.
//!
//! Tabulated once as ln τ over altitude and the cosine of the local sun zenith angle. The second
//! axis starts at the point's own geometric horizon, where the ground hides the sun.

use super::lanes::{Lanes, WIDTH, ZERO, add_scaled, exp, lane, vectors};
use super::medium::{Between, LevelFinder, Medium};
use super::sphere::{half_chord, horizon_cosine};
use rayon::prelude::*;
use sky_core::quantity::EARTH_RADIUS_KM;

/// Samples along the sun's axis.
const SAMPLES: usize = 72;
const SAMPLES_F: f64 = 72.0;
/// Width of the fine part of the sun's axis, in cosine.
const FINE: f64 = 0.1;
/// Optical depths below this are zero for us; keeps the logarithm finite.
const TINY: f32 = 1e-14;

/// ln τ on levels × sun positions × wavelengths.
#[derive(Clone, Debug)]
pub(super) struct SunTable {
    finder: LevelFinder,
    vectors: usize,
    log_depth: Vec<Lanes>,
    horizon_cosine: Vec<f64>,
    ground_km: f64,
}

/// Where to read the table: rows and weights; `None` in the Earth's shadow.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SunPlace {
    rows: [usize; 8],
    weights: [f32; 8],
    pub(super) lit: bool,
}

fn coordinate_from_cosine(cosine: f64, horizon: f64) -> f64 {
    let (above, all) = ((cosine - horizon).max(0.0), 1.0 - horizon);
    above * (all + FINE) / (all * (above + FINE))
}

fn cosine_from_coordinate(u: f64, horizon: f64) -> f64 {
    let all = 1.0 - horizon;
    horizon + u * all * FINE / (all * (1.0 - u) + FINE)
}

/// Cubic Lagrange weights on four equidistant samples, `t` counted from the first.
fn cubic_weights(t: f64) -> [f64; 4] {
    let (a, b, c, d) = (t, t - 1.0, t - 2.0, t - 3.0);
    [
        -b * c * d / 6.0,
        a * c * d / 2.0,
        -a * b * d / 2.0,
        a * b * c / 6.0,
    ]
}

impl SunTable {
    pub(super) fn new(medium: &Medium) -> Self {
        // every other level is enough: ln τ is close to linear in altitude
        let all = medium.finder.levels();
        let mut levels: Vec<f64> = Vec::new();
        for (i, z) in all.iter().enumerate() {
            let last = levels.last().copied().unwrap_or(-1.0);
            if i == 0 || i + 1 == all.len() || z - last > 0.19 {
                levels.push(*z);
            }
        }
        let horizon: Vec<f64> = levels.iter().map(|z| medium.horizon_cosine(*z)).collect();
        let vectors = medium.vectors;
        let log_depth = levels
            .par_iter()
            .zip(&horizon)
            .flat_map_iter(|(z, horizon)| {
                let mut rows = vec![ZERO; SAMPLES * vectors];
                for (k, row) in rows.chunks_exact_mut(vectors).enumerate() {
                    let u = f64::from(u32::try_from(k).unwrap_or(0)) / (SAMPLES_F - 1.0);
                    let cosine = cosine_from_coordinate(u, *horizon);
                    pulp::Arch::new().dispatch(DepthToSpace {
                        medium,
                        z: *z,
                        cosine,
                        out: row,
                    });
                    for v in row {
                        *v = v.map(|x| x.max(TINY).ln());
                    }
                }
                rows
            })
            .collect();
        Self {
            finder: LevelFinder::new(&levels),
            vectors,
            log_depth,
            horizon_cosine: horizon,
            ground_km: medium.ground_km(),
        }
    }

    /// The table at some of its wavelengths.
    pub(super) fn pick(&self, wavelengths: &[usize]) -> Self {
        let picked = vectors(wavelengths.len());
        let log_depth = self
            .log_depth
            .chunks_exact(self.vectors)
            .flat_map(|row| {
                (0..picked).map(move |v| {
                    core::array::from_fn(|l| {
                        let i = wavelengths[(v * WIDTH + l).min(wavelengths.len() - 1)];
                        row[i / WIDTH][i % WIDTH]
                    })
                })
            })
            .collect();
        Self {
            finder: self.finder.clone(),
            vectors: picked,
            log_depth,
            horizon_cosine: self.horizon_cosine.clone(),
            ground_km: self.ground_km,
        }
    }

    /// Locates a point at altitude `z` \[km\] that sees the sun's center at this cosine.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a sample number: clamped to the table"
    )]
    pub(super) fn place(&self, z: f64, cosine: f64) -> SunPlace {
        let mut place = SunPlace {
            lit: cosine >= horizon_cosine(z - self.ground_km, EARTH_RADIUS_KM + self.ground_km),
            ..SunPlace::default()
        };
        if !place.lit {
            return place;
        }
        let Between { level, fraction } = self.finder.find(z);
        for side in 0..2 {
            let u = coordinate_from_cosine(cosine, self.horizon_cosine[level + side])
                * (SAMPLES_F - 1.0);
            let first = (u as usize).saturating_sub(1).min(SAMPLES - 4);
            let first_f = f64::from(u32::try_from(first).unwrap_or(0));
            let w = cubic_weights(u - first_f);
            let share = if side == 0 { 1.0 - fraction } else { fraction };
            for (k, w) in w.iter().enumerate() {
                place.rows[side * 4 + k] = ((level + side) * SAMPLES + first + k) * self.vectors;
                place.weights[side * 4 + k] = lane(w * share);
            }
        }
        place
    }

    /// Transmittance from the sun to the place.
    #[inline(always)]
    pub(super) fn transmittance(&self, place: &SunPlace, vector: usize) -> Lanes {
        if !place.lit {
            return ZERO;
        }
        let mut log_depth = ZERO;
        for k in 0..8 {
            add_scaled(
                &mut log_depth,
                place.weights[k],
                &self.log_depth[place.rows[k] + vector],
            );
        }
        let mut depth = exp(&log_depth);
        for d in &mut depth {
            *d = -*d;
        }
        exp(&depth)
    }
}

/// Inner loop: optical depth from a point to the top of the atmosphere, added to one row of vectors.
///
/// The ray must clear the ground. Extinction is linear between levels and r(ℓ) smooth, so Simpson's
/// rule in each shell is as good as exact.
struct DepthToSpace<'a> {
    medium: &'a Medium,
    z: f64,
    cosine: f64,
    out: &'a mut [Lanes],
}

impl pulp::NullaryFnOnce for DepthToSpace<'_> {
    type Output = ();

    #[inline(always)]
    fn call(mut self) {
        let (z, cosine) = (self.z, self.cosine);
        let r0 = EARTH_RADIUS_KM + z;
        let impact = r0 * ((1.0 - cosine) * (1.0 + cosine)).max(0.0).sqrt();
        let from = if cosine < 0.0 {
            let tangent = (impact - EARTH_RADIUS_KM).max(self.medium.ground_km());
            self.add_shells(tangent, z, impact);
            tangent
        } else {
            z
        };
        self.add_shells(from, self.medium.top_km(), impact);
    }
}

impl DepthToSpace<'_> {
    /// Adds the optical depth of a straight ray of given impact parameter between two altitudes.
    #[inline(always)]
    fn add_shells(&mut self, from: f64, to: f64, impact: f64) {
        let levels = self.medium.finder.levels();
        let impact_square = impact * impact;
        let length = |z: f64| half_chord(EARTH_RADIUS_KM + z, impact);
        let mut k = self.medium.finder.find(from).level;
        let mut a = from;
        let mut length_a = length(a);
        while a < to && k + 1 < levels.len() {
            let b = levels[k + 1].min(to);
            if b > a {
                let length_b = length(b);
                let path = length_b - length_a;
                let middle = 0.5 * (length_a + length_b);
                let z_middle = (impact_square + middle * middle).sqrt() - EARTH_RADIUS_KM;
                let per_km = 1.0 / (levels[k + 1] - levels[k]);
                let f = |z: f64| ((z - levels[k]) * per_km).clamp(0.0, 1.0);
                let upper = (f(a) + 4.0 * f(z_middle) + f(b)) / 6.0;
                let (below, above) = (lane(path * (1.0 - upper)), lane(path * upper));
                let vectors = self.medium.vectors;
                let rows = self.medium.extinction[k * vectors..].split_at(vectors);
                for ((lanes, low), high) in self.out.iter_mut().zip(rows.0).zip(rows.1) {
                    add_scaled(lanes, below, low);
                    add_scaled(lanes, above, high);
                }
                length_a = length_b;
            }
            a = b;
            k += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sun_axis_and_its_inverse_round_trip() {
        for n in [2_u32, 32, 257] {
            for horizon in [0.0, -0.05, -0.17] {
                for i in 0..n {
                    let u = f64::from(i) / f64::from(n - 1);
                    let back = coordinate_from_cosine(cosine_from_coordinate(u, horizon), horizon);
                    assert!((back - u).abs() < 1e-12);
                }
            }
        }
    }

    #[test]
    fn cubic_weights_reproduce_a_cubic() {
        let f = |t: f64| 1.0 - 2.0 * t + 0.5 * t * t - 0.25 * t * t * t;
        for t in [0.0, 0.7, 1.5, 2.2, 3.0] {
            let w = cubic_weights(t);
            let got = w[0] * f(0.0) + w[1] * f(1.0) + w[2] * f(2.0) + w[3] * f(3.0);
            assert!((got - f(t)).abs() < 1e-12);
        }
    }
}
