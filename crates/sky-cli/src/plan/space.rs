//! A scene's ranges as places: where nodes may stand, which skies a table is fitted to, and the cases
//! that it is judged by.
//!
//! Places are even in coordinates in which the sky changes about evenly: altitude closer near the
//! ground, where the haze is; suns closer near the horizon. Everything follows from the ranges and a
//! seed alone, so that a plan is baked from what it was planned with.

use std::collections::BTreeMap;

use anyhow::{Context as _, Result};
use rayon::prelude::*;
use sky_core::color::Yxy;
use sky_core::conditions::{Conditions, Domain};
use sky_core::direction::SkyDirection;
use sky_core::lut::Form;
use sky_core::quantity::Angle;
use sky_fit::sweep::{MapEquations, SkyMap};
use sky_science::metrics::{
    SUN_EXCLUSION_DEG, Statistics, ciede2000_of_lights, is_clear_of_sun, relative_error,
    white_luminance,
};
use sky_science::sky_model::SkyModel;

use crate::evaluate::{conditions, evaluation_directions};
use crate::truth::TransportSky;

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
pub(super) const fn ranges(domain: &Domain) -> [[f64; 2]; 3] {
    [domain.altitude_km, domain.turbidity, domain.sun_zenith_deg]
}

/// Where nodes may stand on each axis.
pub(super) fn candidates(domain: &Domain) -> [Vec<f64>; 3] {
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
pub(super) fn middle(axis: usize, range: [f64; 2]) -> f64 {
    SPREADS[axis].middle(range)
}

/// The skies of one turbidity that tables are fitted to.
pub(super) struct Layer {
    /// For the fit.
    pub(super) equations: Vec<MapEquations>,
    /// What they were made of.
    pub(super) maps: Vec<SkyMap>,
}

/// Skies over all altitudes and suns of a scene, by turbidity, computed when they are first needed.
pub(super) struct Lattice<'a> {
    truth: &'a TransportSky,
    /// Altitude \[km\], sun zenith \[deg\] and weight.
    places: Vec<[f64; 3]>,
    layers: BTreeMap<u64, Layer>,
}

impl<'a> Lattice<'a> {
    pub(super) fn new(truth: &'a TransportSky, domain: &Domain) -> Self {
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
    pub(super) fn prepare(&mut self, turbidities: &[f64]) -> Result<()> {
        for turbidity in turbidities {
            if self.layers.contains_key(&turbidity.to_bits()) {
                continue;
            }
            // alone, for it does its own parallel work
            drop(self.truth.solved(*turbidity));
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
    pub(super) fn layer(&self, turbidity: f64) -> Result<&Layer> {
        self.layers
            .get(&turbidity.to_bits())
            .context("a turbidity that was prepared")
    }
}

/// Numbers that look random and are the same for the same seed (splitmix64, Steele, Lea & Flood 2014).
#[derive(Clone, Debug)]
pub(super) struct Dice(u64);

impl Dice {
    pub(super) const fn new(seed: u64) -> Self {
        Self(seed)
    }

    const fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Evenly from 0 to 1.
    const fn share(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    const fn between(&mut self, [low, high]: [f64; 2]) -> f64 {
        low + self.share() * (high - low)
    }
}

/// Turbidities that random cases share at most: each costs a solution of the truth.
const MOST_TURBIDITIES: usize = 64;

/// Cases anywhere in a domain: altitude and sun of their own, turbidities in turn from at most 64.
pub(super) fn random_conditions(domain: &Domain, count: usize, seed: u64) -> Vec<Conditions> {
    let mut dice = Dice::new(seed);
    let turbidities: Vec<f64> = (0..count.min(MOST_TURBIDITIES))
        .map(|_| dice.between(domain.turbidity))
        .collect();
    let turns = turbidities.into_iter().cycle().take(count);
    turns
        .map(|turbidity| {
            let altitude_km = dice.between(domain.altitude_km);
            conditions(altitude_km, turbidity, dice.between(domain.sun_zenith_deg))
        })
        .collect()
}

/// Cases anywhere in a domain that share turbidities, for each costs a solution of the truth:
/// `turbidities` of them, one in each share of the range, and `each` cases at each.
pub(super) fn pooled_conditions(
    domain: &Domain,
    turbidities: usize,
    each: usize,
    seed: u64,
) -> Vec<Conditions> {
    let mut dice = Dice::new(seed);
    let [low, high] = domain.turbidity;
    let count = if high > low { turbidities } else { 1 };
    let width = (high - low) / count as f64;
    let each = each * turbidities / count;
    let mut out = Vec::new();
    for t in 0..count {
        let from = low + t as f64 * width;
        let turbidity = dice.between([from, from + width]);
        for i in 0..each {
            let stratum = |[low, high]: [f64; 2], place: usize, dice: &mut Dice| {
                low + (place as f64 + dice.share()) / each as f64 * (high - low)
            };
            // altitudes in order, suns spread against them
            let s = (i * 5 + t) % each;
            let altitude_km = stratum(domain.altitude_km, i, &mut dice);
            let sun = stratum(domain.sun_zenith_deg, s, &mut dice);
            out.push(conditions(altitude_km, turbidity, sun));
        }
    }
    out
}

/// A sky that was not fitted.
#[derive(Clone, Debug)]
pub(super) struct Case {
    /// Observer, haze and sun.
    pub(super) conditions: Conditions,
    /// Directions clear of the sun.
    pub(super) directions: Vec<SkyDirection>,
    /// Their light.
    pub(super) truth: Vec<Yxy>,
    /// White of the map \[cd·m⁻²\].
    white: f64,
}

impl Case {
    /// CIEDE2000 of each direction; infinite where there is no answer.
    pub(super) fn delta_e(&self, found: &[Yxy]) -> Vec<f64> {
        self.truth
            .iter()
            .zip(found)
            .map(|(truth, found)| ciede2000_of_lights(*found, *truth, self.white))
            .map(|e| if e.is_nan() { f64::INFINITY } else { e })
            .collect()
    }
}

/// The truth of cases, each in every `stride`th of the directions of [`evaluation_directions`].
pub(super) fn cases(
    truth: &dyn SkyModel,
    all: &[Conditions],
    stride: usize,
    seed: u64,
    done: &(dyn Fn() + Sync),
) -> Result<Vec<Case>> {
    let exclusion = Angle::from_degrees(SUN_EXCLUSION_DEG);
    let mut dice = Dice::new(seed ^ 0x5EED);
    let planned: Vec<(Conditions, Vec<SkyDirection>)> = all
        .iter()
        .map(|case| {
            let first = usize::try_from(dice.next() % stride as u64).unwrap_or(0);
            let directions = evaluation_directions(case.observer_altitude)
                .into_iter()
                .skip(first)
                .step_by(stride)
                .filter(|d| is_clear_of_sun(d, case.sun_zenith, exclusion))
                .collect();
            (*case, directions)
        })
        .collect();
    let skies = skies(truth, &planned, done)?;
    Ok(planned
        .into_iter()
        .zip(skies)
        .map(|((conditions, directions), truth)| Case {
            white: white_luminance(&truth).unwrap_or(f64::NAN),
            conditions,
            directions,
            truth,
        })
        .collect())
}

/// The light of many skies; all of a turbidity together, turbidities side by side.
fn skies(
    truth: &dyn SkyModel,
    planned: &[(Conditions, Vec<SkyDirection>)],
    done: &(dyn Fn() + Sync),
) -> Result<Vec<Vec<Yxy>>> {
    let mut by_turbidity: BTreeMap<u64, Vec<usize>> = BTreeMap::new();
    for (index, (case, _)) in planned.iter().enumerate() {
        by_turbidity
            .entry(case.turbidity.to_bits())
            .or_default()
            .push(index);
    }
    let one = |index: &usize| -> Result<(usize, Vec<Yxy>)> {
        let (conditions, directions) = &planned[*index];
        let sky = truth.yxy_map(conditions, directions)?;
        done();
        Ok((*index, sky))
    };
    let groups: Vec<&Vec<usize>> = by_turbidity.values().collect();
    let found: Vec<Vec<(usize, Vec<Yxy>)>> = groups
        .par_iter()
        .map(|group| {
            // the first alone solves the atmosphere for all
            let (first, rest) = group.split_at(1);
            let mut out: Vec<_> = first.iter().map(one).collect::<Result<_>>()?;
            let rest: Vec<_> = rest.par_iter().map(one).collect::<Result<_>>()?;
            out.extend(rest);
            Ok(out)
        })
        .collect::<Result<_>>()?;
    let mut ordered: Vec<(usize, Vec<Yxy>)> = found.into_iter().flatten().collect();
    ordered.sort_by_key(|(index, _)| *index);
    Ok(ordered.into_iter().map(|(_, sky)| sky).collect())
}

/// Another sky over the directions of cases.
pub(super) fn other_skies(truth: &dyn SkyModel, cases: &[Case]) -> Result<Vec<Vec<Yxy>>> {
    let planned: Vec<(Conditions, Vec<SkyDirection>)> = cases
        .iter()
        .map(|case| (case.conditions, case.directions.clone()))
        .collect();
    skies(truth, &planned, &|| ())
}

/// Errors over all directions of all cases.
#[derive(Clone, Copy, Debug)]
pub(super) struct Score {
    /// CIEDE2000.
    pub(super) delta_e: Statistics,
    /// Relative error of luminance.
    pub(super) luminance: Statistics,
    /// The case of the largest ΔE.
    pub(super) worst: Conditions,
    /// Share of directions with ΔE above 1, and of cases with such a direction.
    pub(super) seen: [f64; 2],
}

/// Compares skies with the truth of cases; a sky without an answer counts as infinitely wrong.
pub(super) fn score(cases: &[Case], found: &[Vec<Yxy>]) -> Result<Score> {
    let (mut delta_e, mut luminance) = (Vec::new(), Vec::new());
    let mut worst: Option<(f64, Conditions)> = None;
    let mut seen_cases = 0.0;
    for (case, found) in cases.iter().zip(found) {
        let colors = case.delta_e(found);
        let most = colors.iter().copied().fold(0.0, f64::max);
        delta_e.extend(colors);
        for (truth, found) in case.truth.iter().zip(found) {
            luminance.push(relative_error(found.luminance_cd_m2, truth.luminance_cd_m2));
        }
        if most > 1.0 {
            seen_cases += 1.0;
        }
        if worst.is_none_or(|(so_far, _)| most > so_far) {
            worst = Some((most, case.conditions));
        }
    }
    let seen = delta_e.iter().filter(|e| **e > 1.0).count() as f64;
    let none = "a scene with at least one direction clear of the sun";
    Ok(Score {
        seen: [seen / delta_e.len() as f64, seen_cases / cases.len() as f64],
        delta_e: Statistics::of(&delta_e).context(none)?,
        luminance: Statistics::of(&luminance).context(none)?,
        worst: worst.context(none)?.1,
    })
}

/// The score of a sky model.
pub(super) fn score_of(sky: &dyn SkyModel, cases: &[Case]) -> Result<Score> {
    let found = cases
        .iter()
        .map(|case| Ok(sky.yxy_map(&case.conditions, &case.directions)?))
        .collect::<Result<Vec<_>>>()?;
    score(cases, &found)
}

#[cfg(test)]
mod tests {
    use super::*;

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
        let case = random_conditions(&domain, 3, 7);
        assert_eq!(case, random_conditions(&domain, 3, 7));
        for case in case.iter().chain(&pooled_conditions(&domain, 4, 9, 1)) {
            domain.check(case).unwrap();
        }
    }
}
