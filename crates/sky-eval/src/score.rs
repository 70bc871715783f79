//! How well a sky agrees with the truth: the project's measure of error.
//!
//! ΔE is CIEDE2000 with Lab's white at 2.5 times the median luminance of the truth's map; the sun's 5°
//! are left out. Pooled figures count every direction of every map once: neither solid angle nor
//! cosine weighs, and the rings stand closer near the horizon, so the horizon counts for more than its
//! area. Out of scope: what the errors mean for a picture on a screen.

use std::collections::BTreeMap;

use anyhow::{Context as _, Result};
use rayon::prelude::*;
use sky_core::color::Yxy;
use sky_core::conditions::Conditions;
use sky_core::direction::SkyDirection;
use sky_core::quantity::Angle;
use sky_science::metrics::{
    SUN_EXCLUSION_DEG, Statistics, ciede2000_of_lights, is_clear_of_sun, relative_error,
    white_luminance,
};
use sky_science::sky_model::{SkyError, SkyModel};

use crate::cases::evaluation_directions;
use crate::dice::Dice;

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
) -> Result<Vec<Evaluation>, SkyError> {
    let answers = by_turbidity(cases.iter().map(|case| case.turbidity), |index| {
        evaluate_case(truth, models, &cases[index])
    })?;
    let mut out = vec![
        Evaluation {
            maps: Vec::new(),
            outside_domain: 0,
        };
        models.len()
    ];
    for errors in answers {
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
) -> Result<Vec<Option<MapErrors>>, SkyError> {
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

/// A sky that was not fitted.
#[derive(Clone, Debug)]
pub struct Case {
    /// Observer, haze and sun.
    pub conditions: Conditions,
    /// Directions clear of the sun.
    pub directions: Vec<SkyDirection>,
    /// Their light.
    pub truth: Vec<Yxy>,
    /// White of the map \[cd·m⁻²\].
    pub white: f64,
}

impl Case {
    /// CIEDE2000 of each direction; infinite where there is no answer.
    #[must_use]
    pub fn delta_e(&self, found: &[Yxy]) -> Vec<f64> {
        self.truth
            .iter()
            .zip(found)
            .map(|(truth, found)| ciede2000_of_lights(*found, *truth, self.white))
            .map(|e| if e.is_nan() { f64::INFINITY } else { e })
            .collect()
    }
}

/// The truth of cases, each in every `stride`th of the directions of [`evaluation_directions`].
///
/// # Errors
/// When a case lies outside the domain.
pub fn cases(
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
            let first = usize::try_from(dice.roll() % stride as u64).unwrap_or(0);
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
    by_turbidity(planned.iter().map(|(case, _)| case.turbidity), |index| {
        let (conditions, directions) = &planned[index];
        let sky = truth.yxy_map(conditions, directions)?;
        done();
        Ok(sky)
    })
}

/// Work on many cases in parallel, in the order of the cases: those of a turbidity together, the first
/// of them alone, so that an engine solves its atmosphere once and not in every thread.
fn by_turbidity<T: Send, E: Send>(
    turbidities: impl Iterator<Item = f64>,
    one: impl Fn(usize) -> Result<T, E> + Sync,
) -> Result<Vec<T>, E> {
    let mut groups: BTreeMap<u64, Vec<usize>> = BTreeMap::new();
    for (index, turbidity) in turbidities.enumerate() {
        groups.entry(turbidity.to_bits()).or_default().push(index);
    }
    let groups: Vec<&Vec<usize>> = groups.values().collect();
    let one = |&index: &usize| one(index).map(|made| (index, made));
    let made: Vec<Vec<(usize, T)>> = groups
        .par_iter()
        .map(|group| {
            let (first, rest) = group.split_at(1);
            let mut out: Vec<_> = first.iter().map(one).collect::<Result<_, E>>()?;
            let rest: Vec<_> = rest.par_iter().map(one).collect::<Result<_, E>>()?;
            out.extend(rest);
            Ok(out)
        })
        .collect::<Result<_, E>>()?;
    let mut ordered: Vec<(usize, T)> = made.into_iter().flatten().collect();
    ordered.sort_by_key(|(index, _)| *index);
    Ok(ordered.into_iter().map(|(_, made)| made).collect())
}

/// Another sky over the directions of cases.
///
/// # Errors
/// When a case lies outside the domain.
pub fn other_skies(truth: &dyn SkyModel, cases: &[Case]) -> Result<Vec<Vec<Yxy>>> {
    let planned: Vec<(Conditions, Vec<SkyDirection>)> = cases
        .iter()
        .map(|case| (case.conditions, case.directions.clone()))
        .collect();
    skies(truth, &planned, &|| ())
}

/// Errors over all directions of all cases.
#[derive(Clone, Copy, Debug)]
pub struct Score {
    /// CIEDE2000.
    pub delta_e: Statistics,
    /// Relative error of luminance.
    pub luminance: Statistics,
    /// The case of the largest ΔE.
    pub worst: Conditions,
    /// Share of directions with ΔE above 1, and of cases with such a direction.
    pub seen: [f64; 2],
}

/// Compares skies with the truth of cases; a sky without an answer counts as infinitely wrong.
///
/// # Errors
/// When there is no direction to compare.
pub fn score(cases: &[Case], found: &[Vec<Yxy>]) -> Result<Score> {
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
///
/// # Errors
/// When a case lies outside the domain, or there is no direction to compare.
pub fn score_of(sky: &dyn SkyModel, cases: &[Case]) -> Result<Score> {
    let found = cases
        .iter()
        .map(|case| Ok(sky.yxy_map(&case.conditions, &case.directions)?))
        .collect::<Result<Vec<_>>>()?;
    score(cases, &found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases::conditions;

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
