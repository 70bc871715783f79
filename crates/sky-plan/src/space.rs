//! A scene's ranges as places: where nodes may stand, which skies a table is fitted to, and the
//! skies of all of them.
//!
//! Places are even in coordinates in which the sky changes about evenly: altitude closer near the
//! ground, where the haze is; suns closer near the horizon. Everything follows from the ranges and a
//! seed alone, so that a plan is baked from what it was planned with.

use std::collections::BTreeMap;

use anyhow::{Context as _, Result};
use rayon::prelude::*;
use sky_core::axis::Axis;
use sky_core::conditions::Domain;
use sky_core::lut::Form;
use sky_eval::truth::TransportSky;
use sky_fit::sweep::{MapEquations, SkyMap};

/// An axis of a table: the coordinate in which its places are even, and how close they stand.
struct Spread {
    coordinate: fn(f64) -> f64,
    value: fn(f64) -> f64,
    /// Distance of candidate nodes.
    step: f64,
    /// Values are rounded to so many per unit: short in files.
    per_unit: f64,
}

/// Altitude, turbidity, sun zenith.
const SPREADS: [Spread; 3] = [
    Spread {
        coordinate: |h| (0.6 * h).ln_1p(),
        value: |u| u.exp_m1() / 0.6,
        step: 0.2,
        per_unit: 1e3,
    },
    Spread {
        coordinate: |t| (t - 0.7).ln(),
        value: |u| u.exp() + 0.7,
        step: 0.4,
        per_unit: 1e3,
    },
    // beyond 96 deg there is no sky; the pole at 98.5 keeps steps near the horizon below 2 deg
    Spread {
        coordinate: |s| -(1.0 - s / 98.5).ln(),
        value: |u| 98.5 * (1.0 - (-u).exp()),
        step: 0.2,
        per_unit: 1e2,
    },
];

/// Turbidity at which the stratospheric layer is complete and haze begins: light bends there.
const HAZE_BEGINS: f64 = 1.0577;

impl Spread {
    fn rounded(&self, u: f64) -> f64 {
        ((self.value)(u) * self.per_unit).round() / self.per_unit
    }

    /// Places from one bound to the other, both among them.
    fn places(&self, [low, high]: [f64; 2], step: f64) -> Vec<f64> {
        if high <= low {
            return vec![low];
        }
        let [from, to] = [low, high].map(self.coordinate);
        let count = count((to - from) / step).max(2);
        let mut places = vec![low];
        for i in 1..count {
            let share = f64::from(i) / f64::from(count);
            let place = self.rounded(from + share * (to - from));
            if place > places[places.len() - 1] && place < high {
                places.push(place);
            }
        }
        places.push(high);
        places
    }

    fn middle(&self, [low, high]: [f64; 2]) -> f64 {
        let [from, to] = [low, high].map(self.coordinate);
        self.rounded(0.5 * (from + to)).clamp(low, high)
    }
}

/// A small number rounded up.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "axes are some units long"
)]
fn count(x: f64) -> u16 {
    x.ceil().clamp(0.0, 1000.0) as u16
}

/// Ranges of the three axes.
pub(crate) const fn ranges(domain: &Domain) -> [[f64; 2]; 3] {
    [domain.altitude_km, domain.turbidity, domain.sun_zenith_deg]
}

/// Where nodes may stand on each axis.
pub(crate) fn candidates(domain: &Domain) -> [Vec<f64>; 3] {
    let ranges = ranges(domain);
    let mut all: [Vec<f64>; 3] =
        core::array::from_fn(|axis| SPREADS[axis].places(ranges[axis], SPREADS[axis].step));
    let [low, high] = domain.turbidity;
    if low < HAZE_BEGINS && HAZE_BEGINS < high {
        all[1].retain(|t| (t - HAZE_BEGINS).abs() > 0.03 || *t <= low || *t >= high);
        let at = all[1].partition_point(|t| *t < HAZE_BEGINS);
        all[1].insert(at, HAZE_BEGINS);
    }
    all
}

/// The node of an axis that has but one.
pub(crate) fn middle(axis: usize, range: [f64; 2]) -> f64 {
    SPREADS[axis].middle(range)
}

/// The skies of one turbidity that tables are fitted to.
pub(crate) struct Layer {
    /// For the fit.
    pub(crate) equations: Vec<MapEquations>,
    /// What they were made of.
    pub(crate) maps: Vec<SkyMap>,
}

/// Skies over all altitudes and suns of a scene, by turbidity, computed when they are first needed.
pub(crate) struct Lattice<'a> {
    truth: &'a TransportSky,
    /// Altitude \[km\], sun zenith \[deg\] and weight.
    places: Vec<[f64; 3]>,
    layers: BTreeMap<u64, Layer>,
}

impl<'a> Lattice<'a> {
    pub(crate) fn new(truth: &'a TransportSky, domain: &Domain) -> Self {
        let weighted = |axis: usize, range| {
            let spread = &SPREADS[axis];
            let all = spread.places(range, 0.5 * spread.step);
            let last = all.len() - 1;
            let lengths = (0..all.len()).map(|i| all[(i + 1).min(last)] - all[i.saturating_sub(1)]);
            // between a place's share of the range and one for each place: both ends count
            let roots: Vec<f64> = lengths.map(|l| l.max(1e-9).sqrt()).collect();
            let mean = roots.iter().sum::<f64>() / roots.len() as f64;
            let weights = roots.into_iter().map(move |r| r / mean);
            all.into_iter().zip(weights).collect::<Vec<_>>()
        };
        let altitudes = weighted(0, domain.altitude_km);
        let suns = weighted(2, domain.sun_zenith_deg);
        Self {
            truth,
            places: altitudes
                .iter()
                .flat_map(|(h, wh)| suns.iter().map(move |(s, ws)| [*h, *s, wh * ws]))
                .collect(),
            layers: BTreeMap::new(),
        }
    }

    /// Computes what is missing for some turbidities.
    pub(crate) fn prepare(&mut self, turbidities: &[f64]) -> Result<()> {
        for turbidity in turbidities {
            if self.layers.contains_key(&turbidity.to_bits()) {
                continue;
            }
            // alone, for it does its own parallel work
            self.truth.solved(*turbidity)?;
            let made: Vec<(MapEquations, SkyMap)> = self
                .places
                .par_iter()
                .map(|[altitude_km, sun, weight]| {
                    let place = (*altitude_km, *turbidity, *sun);
                    let map = SkyMap::compute(self.truth, Form::Extended, place)?;
                    Ok((MapEquations::of(&map, *weight), map))
                })
                .collect::<Result<_>>()?;
            let (equations, maps) = made.into_iter().unzip();
            self.layers
                .insert(turbidity.to_bits(), Layer { equations, maps });
        }
        Ok(())
    }

    /// A turbidity that was prepared.
    pub(crate) fn layer(&self, turbidity: f64) -> Result<&Layer> {
        self.layers
            .get(&turbidity.to_bits())
            .context("a turbidity that was prepared")
    }
}

/// Axes of nodes.
pub(crate) fn axes([altitude, turbidity, sun]: [Vec<f64>; 3]) -> Result<[Axis; 3]> {
    Ok([
        Axis::new("km", altitude)?,
        Axis::new("1", turbidity)?,
        Axis::new("deg", sun)?,
    ])
}

/// Values of a table, altitude by altitude, from those of each turbidity.
pub(crate) fn by_altitude(fits: &[&[f64]], altitudes: usize) -> Vec<f64> {
    (0..altitudes)
        .flat_map(|a| {
            fits.iter().flat_map(move |fit| {
                let row = fit.len() / altitudes;
                &fit[a * row..(a + 1) * row]
            })
        })
        .copied()
        .collect()
}

/// The coarsest nodes: one an axis.
pub(crate) fn coarsest(domain: &Domain) -> [Vec<f64>; 3] {
    let ranges = ranges(domain);
    core::array::from_fn(|axis| vec![middle(axis, ranges[axis])])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turbidities_stand_side_by_side_at_each_altitude() {
        let found = by_altitude(&[&[1.0, 2.0, 3.0, 4.0], &[5.0, 6.0, 7.0, 8.0]], 2);
        assert_eq!(
            format!("{found:?}"),
            "[1.0, 2.0, 5.0, 6.0, 3.0, 4.0, 7.0, 8.0]"
        );
    }

    #[test]
    fn places_ascend_from_bound_to_bound() {
        let domain = Domain {
            altitude_km: [0.0, 30.0],
            turbidity: [1.0, 8.0],
            sun_zenith_deg: [0.0, 96.0],
            below_horizontal: true,
        };
        for (places, range) in candidates(&domain).iter().zip(ranges(&domain)) {
            let ends = [places[0], places[places.len() - 1]];
            assert_eq!(ends.map(f64::to_bits), range.map(f64::to_bits));
            assert!(places.is_sorted_by(|a, b| a < b), "{places:?}");
        }
        for (axis, range) in ranges(&domain).into_iter().enumerate() {
            let middle = middle(axis, range);
            assert!(middle > range[0] && middle < range[1]);
        }
    }
}
