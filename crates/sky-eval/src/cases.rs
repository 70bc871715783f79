//! The cases that skies are compared at: conditions between the nodes of a table, spread over a domain
//! or random, and the directions of each. The same arguments give the same cases.

use sky_core::conditions::{Conditions, Domain};
use sky_core::direction::{SkyDirection, horizon_zenith};
use sky_core::quantity::{Angle, Length};

use crate::dice::Dice;

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

/// Turbidities that random cases share at most: each costs a solution of the truth.
const MAX_TURBIDITIES: usize = 64;

/// Cases anywhere in a domain: altitude and sun of their own, turbidities in turn from at most 64.
#[must_use]
pub fn random_conditions(domain: &Domain, count: usize, seed: u64) -> Vec<Conditions> {
    let mut dice = Dice::new(seed);
    let turbidities: Vec<f64> = (0..count.min(MAX_TURBIDITIES))
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
#[must_use]
pub fn pooled_conditions(
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
    fn random_cases_lie_in_the_domain_and_repeat() {
        let domain = Domain {
            altitude_km: [0.0, 30.0],
            turbidity: [1.0, 8.0],
            sun_zenith_deg: [0.0, 96.0],
            below_horizontal: true,
        };
        let case = random_conditions(&domain, 3, 7);
        assert_eq!(case, random_conditions(&domain, 3, 7));
        for case in case.iter().chain(&pooled_conditions(&domain, 4, 9, 1)) {
            domain.check(case).unwrap();
        }
    }
}
