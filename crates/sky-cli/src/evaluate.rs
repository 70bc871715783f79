//! How well a sky agrees with the truth: the project's measure of error, and the cases it is taken at.
//!
//! ΔE is CIEDE2000 with Lab's white at 2.5 times the median luminance of the truth's map; the sun's 5°
//! are left out. Pooled figures count every direction of every map once: neither solid angle nor
//! cosine weighs, and the rings stand closer near the horizon, so the horizon counts for more than its
//! area. Out of scope: what the errors mean for a picture on a screen.

use std::collections::BTreeMap;

use rayon::prelude::*;
use sky_core::color::Yxy;
use sky_core::conditions::{Conditions, Domain, OutsideDomain};
use sky_core::direction::{SkyDirection, horizon_zenith};
use sky_core::quantity::{Angle, Length};
use sky_science::metrics::{
    SUN_EXCLUSION_DEG, Statistics, ciede2000_of_lights, is_clear_of_sun, relative_error,
    white_luminance,
};
use sky_science::sky_model::SkyModel;

/// Distance of the lowest ring of directions from the geometric horizon \[deg\].
pub const LOWEST_RING_ABOVE_HORIZON_DEG: f64 = 0.25;

/// Conditions from kilometers, turbidity and degrees.
#[must_use]
pub const fn conditions(altitude_km: f64, turbidity: f64, sun_zenith_deg: f64) -> Conditions {
    Conditions {
        observer_altitude: Length::from_km(altitude_km),
        turbidity,
        sun_zenith: Angle::from_degrees(sun_zenith_deg),
    }
}

/// The directions that a map is compared in: the zenith, rings every 10° to 70°, then closer, the
/// last 0.25° above the geometric horizon; on a ring, azimuths closer near the sun. 170 in all.
#[must_use]
pub fn evaluation_directions(observer_altitude: Length) -> Vec<SkyDirection> {
    const RINGS_DEG: [f64; 7] = [10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0];
    /// Shares of the way from 70° to the lowest ring.
    const SHARES: [f64; 6] = [0.3, 0.55, 0.75, 0.88, 0.96, 1.0];
    const AZIMUTHS_DEG: [f64; 13] = [
        0.0, 6.0, 13.0, 22.0, 33.0, 45.0, 60.0, 75.0, 90.0, 110.0, 130.0, 155.0, 180.0,
    ];
    let lowest = horizon_zenith(observer_altitude).degrees() - LOWEST_RING_ABOVE_HORIZON_DEG;
    let low_rings = SHARES.map(|share| 70.0 + share * (lowest - 70.0));
    let mut out = vec![SkyDirection::from_degrees(0.0, 0.0)];
    for ring in RINGS_DEG.into_iter().chain(low_rings) {
        out.extend(AZIMUTHS_DEG.map(|azimuth| SkyDirection::from_degrees(ring, azimuth)));
    }
    out
}

/// Errors of one map, a value for each direction that lies clear of the sun.
#[derive(Clone, Debug, PartialEq)]
pub struct MapErrors {
    /// Where the map was taken.
    pub conditions: Conditions,
    /// Zenith angles of the directions that were compared \[deg\].
    pub view_zenith_deg: Vec<f64>,
    /// CIEDE2000; NaN where the model's answer is not a number.
    pub delta_e: Vec<f64>,
    /// |Y / Y of the truth − 1|.
    pub luminance: Vec<f64>,
    /// Y / Y of the truth − 1.
    pub luminance_signed: Vec<f64>,
    /// Directions, the sun's surroundings included, with a negative luminance or chromaticity.
    pub negatives: usize,
    /// Directions, the sun's surroundings included, with a luminance or chromaticity that is not finite.
    pub not_finite: usize,
}

impl MapErrors {
    /// Statistics of ΔE; `None` without directions.
    #[must_use]
    pub fn delta_e_statistics(&self) -> Option<Statistics> {
        Statistics::of(&self.delta_e)
    }

    /// Statistics of the relative error of luminance; `None` without directions.
    #[must_use]
    pub fn luminance_statistics(&self) -> Option<Statistics> {
        Statistics::of(&self.luminance)
    }
}

/// Compares a map with the truth's map of the same directions.
///
/// # Panics
/// When there is not one color a direction.
#[must_use]
pub fn compare_maps(
    conditions: &Conditions,
    directions: &[SkyDirection],
    truth: &[Yxy],
    found: &[Yxy],
) -> MapErrors {
    assert_eq!(directions.len(), truth.len(), "one color a direction");
    assert_eq!(directions.len(), found.len(), "one color a direction");
    let white = white_luminance(truth).unwrap_or(f64::NAN);
    let exclusion = Angle::from_degrees(SUN_EXCLUSION_DEG);
    let numbers = |c: &Yxy| [c.luminance_cd_m2, c.x, c.y];
    let count = |bad: fn(f64) -> bool| {
        let is_bad = |c: &&Yxy| numbers(c).into_iter().any(bad);
        found.iter().filter(is_bad).count()
    };
    let mut out = MapErrors {
        conditions: *conditions,
        view_zenith_deg: Vec::new(),
        delta_e: Vec::new(),
        luminance: Vec::new(),
        luminance_signed: Vec::new(),
        negatives: count(|v| v < 0.0),
        not_finite: count(|v| !v.is_finite()),
    };
    for ((direction, truth), found) in directions.iter().zip(truth).zip(found) {
        if !is_clear_of_sun(direction, conditions.sun_zenith, exclusion) {
            continue;
        }
        out.view_zenith_deg.push(direction.view_zenith.degrees());
        out.delta_e.push(if truth == found {
            0.0
        } else {
            ciede2000_of_lights(*found, *truth, white)
        });
        out.luminance
            .push(relative_error(found.luminance_cd_m2, truth.luminance_cd_m2));
        out.luminance_signed
            .push(found.luminance_cd_m2 / truth.luminance_cd_m2 - 1.0);
    }
    out
}

/// Figures of many maps together, every direction counting once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pooled {
    /// Maps.
    pub maps: usize,
    /// ΔE; `None` without directions.
    pub delta_e: Option<Statistics>,
    /// Relative error of luminance; `None` without directions.
    pub luminance: Option<Statistics>,
    /// Directions with a negative number.
    pub negatives: usize,
    /// Directions with a number that is not finite.
    pub not_finite: usize,
}

/// Pools the directions of maps that a condition picks; the second argument of `pick` is the
/// direction's zenith angle \[deg\].
#[must_use]
pub fn pool(maps: &[MapErrors], pick: impl Fn(&Conditions, f64) -> bool) -> Pooled {
    let (mut delta_e, mut luminance) = (Vec::new(), Vec::new());
    let (mut used, mut negatives, mut not_finite) = (0, 0, 0);
    for map in maps {
        let before = delta_e.len();
        for (i, &zenith_deg) in map.view_zenith_deg.iter().enumerate() {
            if pick(&map.conditions, zenith_deg) {
                delta_e.push(map.delta_e[i]);
                luminance.push(map.luminance[i]);
            }
        }
        if delta_e.len() > before {
            used += 1;
            negatives += map.negatives;
            not_finite += map.not_finite;
        }
    }
    Pooled {
        maps: used,
        delta_e: Statistics::of(&delta_e),
        luminance: Statistics::of(&luminance),
        negatives,
        not_finite,
    }
}

/// What a comparison over many cases found for one model.
#[derive(Clone, Debug, PartialEq)]
pub struct Evaluation {
    /// One entry a case inside the model's domain, in the order of the cases.
    pub maps: Vec<MapErrors>,
    /// Cases outside the model's domain, which it could not answer.
    pub outside_domain: usize,
}

impl Evaluation {
    /// All directions of all maps together.
    #[must_use]
    pub fn pooled(&self) -> Pooled {
        pool(&self.maps, |_, _| true)
    }
}

/// Compares models with the truth over a list of cases, each on its [`evaluation_directions`].
///
/// The truth is asked once a case, all cases of one turbidity together, turbidities and cases in
/// parallel; the answer does not depend on the number of threads.
///
/// # Errors
/// A case outside the truth's domain.
pub fn evaluate(
    truth: &dyn SkyModel,
    models: &[&dyn SkyModel],
    cases: &[Conditions],
) -> Result<Vec<Evaluation>, OutsideDomain> {
    let mut by_turbidity: BTreeMap<u64, Vec<usize>> = BTreeMap::new();
    for (index, case) in cases.iter().enumerate() {
        let group = by_turbidity.entry(case.turbidity.to_bits()).or_default();
        group.push(index);
    }
    let groups: Vec<&Vec<usize>> = by_turbidity.values().collect();
    let answers: Vec<Vec<(usize, Vec<Option<MapErrors>>)>> = groups
        .par_iter()
        .map(|group| {
            // The first case alone, so that an engine solves its atmosphere once and not in every
            // thread.
            let (first, rest) = group
                .split_first()
                .map_or((None, [].as_slice()), |(f, r)| (Some(f), r));
            let one = |&index: &usize| {
                evaluate_case(truth, models, &cases[index]).map(|errors| (index, errors))
            };
            let mut out: Vec<_> = first.map(one).transpose()?.into_iter().collect();
            let rest: Result<Vec<_>, OutsideDomain> = rest.par_iter().map(one).collect();
            out.extend(rest?);
            Ok(out)
        })
        .collect::<Result<_, OutsideDomain>>()?;
    let mut ordered: Vec<(usize, Vec<Option<MapErrors>>)> = answers.into_iter().flatten().collect();
    ordered.sort_by_key(|(index, _)| *index);
    let mut out = vec![
        Evaluation {
            maps: Vec::new(),
            outside_domain: 0,
        };
        models.len()
    ];
    for (_, errors) in ordered {
        for (evaluation, errors) in out.iter_mut().zip(errors) {
            match errors {
                Some(errors) => evaluation.maps.push(errors),
                None => evaluation.outside_domain += 1,
            }
        }
    }
    Ok(out)
}

fn evaluate_case(
    truth: &dyn SkyModel,
    models: &[&dyn SkyModel],
    case: &Conditions,
) -> Result<Vec<Option<MapErrors>>, OutsideDomain> {
    let directions = evaluation_directions(case.observer_altitude);
    let expected = truth.yxy_map(case, &directions)?;
    Ok(models
        .iter()
        .map(|model| {
            let found = model.yxy_map(case, &directions).ok()?;
            Some(compare_maps(case, &directions, &expected, &found))
        })
        .collect())
}

/// The nodes of a table's axes, ascending.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Nodes {
    /// Observer altitudes \[km\].
    pub altitude_km: Vec<f64>,
    /// Turbidities.
    pub turbidity: Vec<f64>,
    /// Sun zenith angles \[deg\].
    pub sun_zenith_deg: Vec<f64>,
}

/// How many held-out cases to take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CaseCounts {
    /// Most cases between the nodes. When there are more intervals, some are taken, spread over all.
    pub midpoints: usize,
    /// Turbidities of the sequence; each costs a solution of the truth's atmosphere.
    pub sequence_turbidities: u32,
    /// Cases of the sequence at each of them.
    pub cases_per_turbidity: u32,
}

impl Default for CaseCounts {
    fn default() -> Self {
        Self {
            midpoints: 240,
            sequence_turbidities: 4,
            cases_per_turbidity: 40,
        }
    }
}

/// Cases that lie between the nodes of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldOut {
    /// The middle of intervals on all three axes: as far from the nodes as can be. Every pair of
    /// altitude and sun intervals, the turbidity interval changing from pair to pair.
    pub midpoints: Vec<Conditions>,
    /// Spread evenly over the domain in altitude, turbidity and sun zenith angle (Halton's sequence in
    /// bases 2, 3 and 5): what a user meets who picks at random.
    pub sequence: Vec<Conditions>,
}

impl HeldOut {
    /// Both lists, midpoints first.
    #[must_use]
    pub fn all(&self) -> Vec<Conditions> {
        self.midpoints
            .iter()
            .chain(&self.sequence)
            .copied()
            .collect()
    }
}

/// The digits of `index` in a base, mirrored at the point: van der Corput's sequence, 0–1.
fn mirrored_digits(mut index: u32, base: u32) -> f64 {
    let (mut value, mut unit) = (0.0, 1.0);
    while index > 0 {
        unit /= f64::from(base);
        value += unit * f64::from(index % base);
        index /= base;
    }
    value
}

/// A stride near the golden section of a list's length and without a common divisor with it: steps of
/// it visit every place once, and the first few lie far apart.
fn spreading_stride(length: usize) -> usize {
    let divisor = |mut a: usize, mut b: usize| {
        while b > 0 {
            (a, b) = (b, a % b);
        }
        a
    };
    let golden = length * 618 / 1000;
    (golden.max(1)..length)
        .find(|&s| divisor(s, length) == 1)
        .unwrap_or(1)
}

/// Middles of the intervals of an axis that lie inside bounds; a single node stands for itself.
fn middles(nodes: &[f64], bounds: [f64; 2]) -> Vec<f64> {
    if nodes.len() < 2 {
        return nodes.to_vec();
    }
    let pairs = nodes.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
    pairs
        .filter(|middle| (bounds[0]..=bounds[1]).contains(middle))
        .collect()
}

/// Cases between the nodes, always the same ones for the same nodes.
#[must_use]
pub fn held_out_cases(nodes: &Nodes, domain: &Domain, counts: CaseCounts) -> HeldOut {
    let altitudes = middles(&nodes.altitude_km, domain.altitude_km);
    let turbidities = middles(&nodes.turbidity, domain.turbidity);
    let suns = middles(&nodes.sun_zenith_deg, domain.sun_zenith_deg);
    let mut midpoints = Vec::new();
    if !turbidities.is_empty() {
        for (i, &altitude) in altitudes.iter().enumerate() {
            for (k, &sun) in suns.iter().enumerate() {
                let turbidity = turbidities[(i + k) % turbidities.len()];
                midpoints.push(conditions(altitude, turbidity, sun));
            }
        }
    }
    if midpoints.len() > counts.midpoints && counts.midpoints > 0 {
        let total = midpoints.len();
        let stride = spreading_stride(total);
        let mut kept: Vec<usize> = (0..counts.midpoints).map(|n| n * stride % total).collect();
        kept.sort_unstable();
        midpoints = kept.into_iter().map(|n| midpoints[n]).collect();
    }
    let between = |bounds: [f64; 2], share: f64| bounds[0] + share * (bounds[1] - bounds[0]);
    let mut sequence = Vec::new();
    for t in 0..counts.sequence_turbidities {
        let turbidity = between(domain.turbidity, mirrored_digits(t + 1, 2));
        for n in 0..counts.cases_per_turbidity {
            let index = t * counts.cases_per_turbidity + n + 1;
            sequence.push(conditions(
                between(domain.altitude_km, mirrored_digits(index, 3)),
                turbidity,
                between(domain.sun_zenith_deg, mirrored_digits(index, 5)),
            ));
        }
    }
    HeldOut {
        midpoints,
        sequence,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_end_a_quarter_of_a_degree_above_the_horizon() {
        for km in [0.0, 3.0, 30.0] {
            let altitude = Length::from_km(km);
            let lowest = evaluation_directions(altitude)
                .iter()
                .map(|d| d.view_zenith.degrees())
                .fold(0.0, f64::max);
            let horizon = horizon_zenith(altitude).degrees();
            assert!((horizon - lowest - LOWEST_RING_ABOVE_HORIZON_DEG).abs() < 1e-9);
        }
        assert_eq!(evaluation_directions(Length::ZERO).len(), 170);
    }

    #[test]
    fn held_out_cases_avoid_the_nodes_and_repeat() {
        let nodes = Nodes {
            altitude_km: vec![0.0, 1.0, 5.0, 30.0],
            turbidity: vec![1.0, 3.0, 8.0],
            sun_zenith_deg: vec![0.0, 60.0, 90.0, 96.0],
        };
        let domain = Domain {
            altitude_km: [0.0, 30.0],
            turbidity: [1.0, 8.0],
            sun_zenith_deg: [0.0, 92.0],
            below_horizontal: true,
        };
        let held_out = held_out_cases(&nodes, &domain, CaseCounts::default());
        // 93° lies outside the domain.
        assert_eq!(held_out.midpoints.len(), 3 * 2);
        assert_eq!(held_out.sequence.len(), 160);
        for case in held_out.all() {
            domain.check(&case).unwrap();
            for (value, nodes) in [
                (case.observer_altitude.km(), &nodes.altitude_km),
                (case.sun_zenith.degrees(), &nodes.sun_zenith_deg),
            ] {
                assert!(nodes.iter().all(|node| (node - value).abs() > 1e-6));
            }
        }
        assert_eq!(
            held_out,
            held_out_cases(&nodes, &domain, CaseCounts::default())
        );
        let few = CaseCounts {
            midpoints: 4,
            ..CaseCounts::default()
        };
        assert_eq!(held_out_cases(&nodes, &domain, few).midpoints.len(), 4);
        for length in 1..200 {
            let stride = spreading_stride(length);
            let mut places: Vec<usize> = (0..length).map(|n| n * stride % length).collect();
            places.sort_unstable();
            assert!(places.iter().enumerate().all(|(i, &place)| i == place));
        }
    }

    #[test]
    fn bad_numbers_are_counted() {
        let directions = [
            SkyDirection::from_degrees(0.0, 0.0),
            SkyDirection::from_degrees(50.0, 180.0),
        ];
        let good = Yxy {
            luminance_cd_m2: 100.0,
            x: 0.3,
            y: 0.3,
        };
        let negative = Yxy {
            luminance_cd_m2: -1.0,
            ..good
        };
        let nan = Yxy {
            x: f64::NAN,
            ..good
        };
        let errors = compare_maps(
            &conditions(0.0, 2.0, 40.0),
            &directions,
            &[good; 2],
            &[negative, nan],
        );
        assert_eq!((errors.negatives, errors.not_finite), (1, 1));
        assert!(errors.delta_e[1].is_nan());
    }
}
