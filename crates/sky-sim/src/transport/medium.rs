//! The optical profile, laid out for ray integration.

use super::lanes::{Lanes, WIDTH, ZERO, lane, lerp, pack, vectors};
use super::sphere::horizon_cosine;
use crate::optics::OpticalProfile;
use sky_core::quantity::EARTH_RADIUS_KM;

/// A place between two levels: the lower one and the fraction of the way to the next.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Between {
    pub(super) level: usize,
    pub(super) fraction: f64,
}

/// Finds altitudes among ascending levels in constant time.
#[derive(Clone, Debug)]
pub(super) struct LevelFinder {
    levels: Vec<f64>,
    bins: Vec<usize>,
    per_km: f64,
}

impl LevelFinder {
    pub(super) fn new(levels: &[f64]) -> Self {
        let (first, last) = (levels[0], levels[levels.len() - 1]);
        let n = 4096_u16;
        let per_km = f64::from(n) / (last - first);
        let mut level = 0;
        let bins = (0..n)
            .map(|bin| {
                let z = first + f64::from(bin) / per_km;
                while level + 2 < levels.len() && levels[level + 1] <= z {
                    level += 1;
                }
                level
            })
            .collect();
        Self {
            levels: levels.to_vec(),
            bins,
            per_km,
        }
    }

    pub(super) fn levels(&self) -> &[f64] {
        &self.levels
    }

    /// The pair of levels around `z`; beyond the ends the fraction is 0 or 1.
    #[inline]
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a bin number: clamped to the table's length"
    )]
    pub(super) fn find(&self, z: f64) -> Between {
        let bin = ((z - self.levels[0]) * self.per_km).max(0.0) as usize;
        let mut level = self.bins[bin.min(self.bins.len() - 1)];
        while level + 2 < self.levels.len() && self.levels[level + 1] <= z {
            level += 1;
        }
        let (a, b) = (self.levels[level], self.levels[level + 1]);
        Between {
            level,
            fraction: ((z - a) / (b - a)).clamp(0.0, 1.0),
        }
    }
}

/// Coefficients per kilometre on levels, eight wavelengths to a vector.
#[derive(Clone, Debug)]
pub(super) struct Medium {
    pub(super) finder: LevelFinder,
    /// Vectors that hold one row of wavelengths.
    pub(super) vectors: usize,
    pub(super) wavelengths: usize,
    pub(super) extinction: Vec<Lanes>,
    pub(super) scattering: Vec<Lanes>,
    pub(super) rayleigh: Vec<Lanes>,
    pub(super) aerosol: Vec<Lanes>,
    pub(super) g: Vec<Lanes>,
    pub(super) g2: Vec<Lanes>,
    pub(super) g_weight: Vec<Lanes>,
    /// Whether a level scatters by aerosol at all.
    pub(super) hazy: Vec<bool>,
    /// Largest and smallest extinction over wavelength at each level.
    pub(super) extinction_range: Vec<[f64; 2]>,
    /// Largest |g| that takes part in scattering.
    pub(super) largest_g: f64,
    pub(super) depolarization: f64,
}

impl Medium {
    pub(super) fn new(optics: &OpticalProfile) -> Self {
        let n = optics.wavelength_nm.len();
        let sum = |tables: &[&[f64]]| -> Vec<f64> {
            (0..tables[0].len())
                .map(|i| tables.iter().map(|t| t[i]).sum())
                .collect()
        };
        let scattering = sum(&[
            &optics.rayleigh_scattering_per_km,
            &optics.aerosol_scattering_per_km,
        ]);
        let extinction = sum(&[
            &scattering,
            &optics.gas_absorption_per_km,
            &optics.aerosol_absorption_per_km,
        ]);
        let hazy: Vec<bool> = optics
            .aerosol_scattering_per_km
            .chunks_exact(n)
            .map(|row| row.iter().any(|b| *b > 0.0))
            .collect();
        let mut largest_g = 0.0_f64;
        for i in 0..scattering.len() {
            if optics.aerosol_scattering_per_km[i] > 0.0 {
                let first = if optics.aerosol_g_weight[i] > 0.0 {
                    optics.aerosol_g[i].abs()
                } else {
                    0.0
                };
                largest_g = largest_g.max(first);
                if optics.aerosol_g_weight[i] < 0.9 {
                    largest_g = largest_g.max(optics.aerosol_g2[i].abs());
                }
            }
        }
        let extinction_range = extinction
            .chunks_exact(n)
            .map(|row| {
                row.iter().fold([0.0, f64::INFINITY], |r: [f64; 2], b| {
                    [r[0].max(*b), r[1].min(*b)]
                })
            })
            .collect();
        Self {
            finder: LevelFinder::new(&optics.altitude_km),
            vectors: vectors(n),
            wavelengths: n,
            extinction: pack(&extinction, n),
            scattering: pack(&scattering, n),
            rayleigh: pack(&optics.rayleigh_scattering_per_km, n),
            aerosol: pack(&optics.aerosol_scattering_per_km, n),
            g: pack(&optics.aerosol_g, n),
            g2: pack(&optics.aerosol_g2, n),
            g_weight: pack(&optics.aerosol_g_weight, n),
            hazy,
            extinction_range,
            largest_g,
            depolarization: optics.rayleigh_depolarization,
        }
    }

    /// Altitudes that cut the profile into segments over which Simpson's rule reproduces the
    /// piecewise linear coefficients, each at most `widest · (altitude + 4 km)` thick.
    ///
    /// A finely tabulated smooth profile merges into thick segments; a coarse table, which means
    /// straight lines between its levels, keeps every level.
    pub(super) fn segment_levels(&self, widest: f64) -> Vec<f64> {
        const TOLERANCE: f64 = 2e-4;
        let levels = self.finder.levels();
        let n = levels.len();
        // running integrals of extinction and scattering at the first and last wavelengths
        let last = (self.wavelengths - 1) % WIDTH;
        let value = |level: usize, which: usize| {
            let table = if which < 2 {
                &self.extinction
            } else {
                &self.scattering
            };
            let row = level * self.vectors;
            f64::from(if which.is_multiple_of(2) {
                table[row][0]
            } else {
                table[row + self.vectors - 1][last]
            })
        };
        let mut integral = vec![[0.0; 4]; n];
        for i in 1..n {
            let dz = levels[i] - levels[i - 1];
            integral[i] = core::array::from_fn(|w| {
                integral[i - 1][w] + 0.5 * dz * (value(i - 1, w) + value(i, w))
            });
        }
        let fits = |from: usize, to: usize| {
            let thickness = levels[to] - levels[from];
            let middle = self.finder.find(0.5 * (levels[from] + levels[to]));
            thickness <= widest * (levels[from] + 4.0)
                && (0..4).all(|w| {
                    let at_middle = value(middle.level, w)
                        + middle.fraction * (value(middle.level + 1, w) - value(middle.level, w));
                    let simpson =
                        thickness / 6.0 * (value(from, w) + 4.0 * at_middle + value(to, w));
                    let exact = integral[to][w] - integral[from][w];
                    (simpson - exact).abs() <= TOLERANCE * exact
                })
        };
        let mut out = vec![levels[0]];
        let mut from = 0;
        while from + 1 < n {
            let mut to = from + 1;
            while to + 1 < n && fits(from, to + 1) {
                to += 1;
            }
            out.push(levels[to]);
            from = to;
        }
        out
    }

    /// Altitude of the ground: the lowest level \[km\].
    pub(super) fn ground_km(&self) -> f64 {
        self.finder.levels()[0]
    }

    pub(super) fn ground_radius(&self) -> f64 {
        EARTH_RADIUS_KM + self.ground_km()
    }

    /// Cosine of the zenith angle of the horizon at an altitude.
    pub(super) fn horizon_cosine(&self, z: f64) -> f64 {
        horizon_cosine(z - self.ground_km(), self.ground_radius())
    }

    pub(super) fn top_km(&self) -> f64 {
        self.finder.levels()[self.finder.levels().len() - 1]
    }

    pub(super) fn top_radius(&self) -> f64 {
        EARTH_RADIUS_KM + self.top_km()
    }

    /// One of the tables at a place.
    #[inline(always)]
    pub(super) fn at(&self, table: &[Lanes], place: Between, vector: usize) -> Lanes {
        let row = place.level * self.vectors + vector;
        lerp(
            &table[row],
            &table[row + self.vectors],
            lane(place.fraction),
        )
    }

    /// Aerosol phase function at a place \[sr⁻¹\].
    #[inline(always)]
    pub(super) fn aerosol_phase(&self, place: Between, vector: usize, cos_gamma: f64) -> Lanes {
        let g = self.at(&self.g, place, vector);
        let g2 = self.at(&self.g2, place, vector);
        let w = self.at(&self.g_weight, place, vector);
        let backward = lane(1.0 - cos_gamma);
        let (first, second) = (
            henyey_greenstein(&g, backward),
            henyey_greenstein(&g2, backward),
        );
        let mut p = ZERO;
        for l in 0..WIDTH {
            p[l] = w[l] * first[l] + (1.0 - w[l]) * second[l];
        }
        p
    }

    /// Largest and smallest extinction over wavelength at an altitude \[km⁻¹\].
    pub(super) fn extinction_bounds(&self, z: f64) -> [f64; 2] {
        let p = self.finder.find(z);
        let (a, b) = (
            self.extinction_range[p.level],
            self.extinction_range[p.level + 1],
        );
        core::array::from_fn(|i| a[i] + p.fraction * (b[i] - a[i]))
    }
}

/// Henyey–Greenstein phase function \[sr⁻¹\] in each lane, as in [`crate::phase`], from one minus the
/// cosine of the scattering angle.
#[inline(always)]
fn henyey_greenstein(g: &Lanes, backward: f32) -> Lanes {
    const PER_SPHERE: f32 = 0.25 * core::f32::consts::FRAC_1_PI;
    let mut out = ZERO;
    for l in 0..WIDTH {
        let d = (1.0 - g[l]) * (1.0 - g[l]) + 2.0 * g[l] * backward;
        out[l] = PER_SPHERE * (1.0 - g[l] * g[l]) / (d * d.sqrt());
    }
    out
}
