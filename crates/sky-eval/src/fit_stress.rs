//! Fit stress: thousands of Perez fits from random starts and on damaged maps, beside plain
//! Levenberg–Marquardt without this project's safeguards.
//!
//! The safeguards are: parameters in which every value is a sky, bounds, a pull to a middling sky, and
//! eight starts of which the best end wins. Every random number is a hash of a fixed seed and its
//! place, so that every run is the same. Out of scope: the extended form, whose fit is linear.

use std::fmt::Write as _;

use anyhow::Result;
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::storage::Owned;
use nalgebra::{DVector, Dyn, OMatrix, U6, Vector6};
use rayon::prelude::*;
use sky_core::air_mass::relative_air_mass;
use sky_core::color::Yxy;
use sky_core::conditions::Conditions;
use sky_core::direction::SkyDirection;
use sky_core::lut::Form;
use sky_core::quantity::Length;
use sky_fit::problem::{Channel, FitOptions, PerezFit, Sample, SkySamples, Starts, fit_channel};
use sky_fit::sweep::SkyMap;
use sky_science::perez::PerezCoefficients;
use sky_science::perez_sky::PEREZ_SCALE_HEIGHT_KM;
use sky_sim::optics::OpticsSettings;
use sky_sim::profile::AtmosphereProfile;

use crate::dice::Random;
use crate::progress::Progress;
use crate::truth::{DEFAULT_GROUND_ALBEDO, TransportSky};

/// A fit has succeeded within this of the best residual of its map.
pub const SUCCESS: f64 = 1.01;

/// The air mass from which a sky must be positive: the zenith's, but for rounding.
const LEAST_MASS: f64 = 0.9999;

/// Altitude \[km\], turbidity and sun zenith \[deg\] of the skies that are fitted.
pub const CELLS: [[f64; 3]; 8] = [
    [0.0, 2.0, 0.0],
    [0.0, 2.0, 45.0],
    [0.0, 2.0, 80.0],
    [0.0, 2.0, 90.0],
    [3.0, 2.0, 60.0],
    [12.0, 2.0, 30.0],
    [12.0, 2.0, 88.0],
    [30.0, 2.0, 70.0],
];

/// What is done to a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Damage {
    /// Nothing.
    None,
    /// Every value times 1 + a normal number of this deviation.
    Noise(f64),
    /// No direction within 60° of azimuth around 110°.
    MissingSector,
    /// One direction ten times too bright (a chromaticity 1.5 times too large).
    Outlier,
    /// One direction without light.
    ZeroLuminance,
    /// Only 20 directions.
    TwentyDirections,
}

/// Every damage and its name.
pub const DAMAGES: [(Damage, &str); 8] = [
    (Damage::None, "none"),
    (Damage::Noise(0.001), "noise_0.1_percent"),
    (Damage::Noise(0.01), "noise_1_percent"),
    (Damage::Noise(0.1), "noise_10_percent"),
    (Damage::MissingSector, "missing_sector"),
    (Damage::Outlier, "outlier"),
    (Damage::ZeroLuminance, "zero_luminance"),
    (Damage::TwentyDirections, "twenty_directions"),
];

/// The ways to fit, and their names.
pub const METHODS: [(Method, &str); 4] = [
    (Method::Safeguarded, "safeguarded"),
    (Method::OneStart, "one_start"),
    (Method::PlainEight, "plain_eight"),
    (Method::Plain, "plain"),
];

/// A way to fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// As tables are made, from the eight starts, which are the same for every map: one fit a map.
    Safeguarded,
    /// The same parameters, bounds and pull, from the random start alone.
    OneStart,
    /// As [`Self::Plain`], but from the eight starts of which the best end wins, a sky before what is
    /// none: one fit a map.
    PlainEight,
    /// The printed coefficients, no bounds and no pull, from the random start alone, by the crate
    /// `levenberg-marquardt`.
    Plain,
}

/// How much is fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Effort {
    /// Random starts on each undamaged map.
    pub starts: u32,
    /// Times that each damage is done.
    pub damages: u32,
    /// Random starts on each damaged map.
    pub damaged_starts: u32,
}

impl Effort {
    /// About a minute.
    pub const QUICK: Self = Self {
        starts: 100,
        damages: 4,
        damaged_starts: 5,
    };
    /// Some minutes.
    pub const FULL: Self = Self {
        starts: 1000,
        damages: 20,
        damaged_starts: 10,
    };
}

/// A sky to fit: one channel's samples, those of the sun's surroundings left out.
#[derive(Clone, Debug)]
pub struct Map {
    /// Observer, haze and sun.
    pub conditions: Conditions,
    /// The channel.
    pub channel: Channel,
    /// Its samples.
    pub samples: Vec<Sample>,
    azimuth_deg: Vec<f64>,
}

/// The skies of [`CELLS`] by the transport engine, each channel a map.
///
/// # Errors
/// When the engine cannot be set up.
pub fn maps(cells: &[[f64; 3]]) -> Result<Vec<Map>> {
    let settings = OpticsSettings::with_step_nm(20)?;
    let truth = TransportSky::new(
        AtmosphereProfile::general(),
        settings,
        DEFAULT_GROUND_ALBEDO,
    )?;
    let mut out = Vec::new();
    for &[altitude_km, turbidity, sun_zenith_deg] in cells {
        let SkyMap {
            conditions,
            directions,
            sky,
        } = SkyMap::compute(
            &truth,
            Form::PerezSpherical,
            (altitude_km, turbidity, sun_zenith_deg),
        )?;
        for (k, channel) in Channel::ALL.into_iter().enumerate() {
            let value = |light: &Yxy| [light.luminance_cd_m2, light.x, light.y][k];
            let sample = |(d, light): (&SkyDirection, &Yxy)| Sample {
                air_mass: relative_air_mass(
                    d.view_zenith.radians().cos(),
                    conditions.observer_altitude,
                    Length::from_km(PEREZ_SCALE_HEIGHT_KM),
                ),
                scattering_angle: d.scattering_angle(conditions.sun_zenith),
                value: value(light),
                // as tables are fitted
                weight: d.view_zenith.radians().sin().max(0.1),
            };
            out.push(Map {
                conditions,
                channel,
                samples: directions.iter().zip(&sky).map(sample).collect(),
                azimuth_deg: directions
                    .iter()
                    .map(|d| d.relative_azimuth.degrees())
                    .collect(),
            });
        }
    }
    Ok(out)
}

impl Map {
    /// The samples after a damage.
    fn damaged(&self, damage: Damage, random: Random) -> Vec<Sample> {
        let mut out = self.samples.clone();
        let pick = |k: u64| {
            let share = random.at(k).uniform();
            index(share, self.samples.len())
        };
        match damage {
            Damage::None => {}
            Damage::Noise(deviation) => {
                for (sample, k) in out.iter_mut().zip(0..) {
                    let factor: f64 = 1.0 + deviation * random.at(k).normal();
                    sample.value *= factor.max(0.01);
                }
            }
            Damage::MissingSector => {
                let mut azimuths = self.azimuth_deg.iter();
                out.retain(|_| azimuths.next().is_none_or(|a| !(80.0..140.0).contains(a)));
            }
            Damage::Outlier => {
                out[pick(0)].value *= match self.channel {
                    Channel::Luminance => 10.0,
                    Channel::ChromaticityX | Channel::ChromaticityY => 1.5,
                };
            }
            Damage::ZeroLuminance => out[pick(0)].value = 0.0,
            Damage::TwentyDirections => {
                let mut order: Vec<(u64, usize)> = (0..out.len())
                    .zip(0..)
                    .map(|(i, k)| (random.at(k).0, i))
                    .collect();
                order.sort_unstable();
                out = order.iter().take(20).map(|(_, i)| out[*i]).collect();
            }
        }
        out
    }

    fn sky<'a>(&self, samples: &'a [Sample]) -> SkySamples<'a> {
        SkySamples {
            samples,
            sun_zenith: self.conditions.sun_zenith,
            zenith_air_mass: 1.0,
        }
    }

    /// How far a sky is from another over all directions of the map, the 95th percentile: share of
    /// luminance, or x or y.
    fn distance(&self, a: &Sky, b: &Sky) -> f64 {
        let mut all: Vec<f64> = self
            .samples
            .iter()
            .map(|s| {
                let [a, b] = [a, b].map(|sky| sky.at(s));
                let difference = (a - b).abs();
                match self.channel {
                    Channel::Luminance => difference / b,
                    Channel::ChromaticityX | Channel::ChromaticityY => difference,
                }
            })
            .map(|d| if d.is_nan() { f64::INFINITY } else { d })
            .collect();
        quantile(&mut all, 0.95)
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::cast_precision_loss,
    reason = "a share of a list's length"
)]
fn index(share: f64, length: usize) -> usize {
    ((share * length as f64) as usize).min(length.saturating_sub(1))
}

/// A value of a list below which a share of them lies; NaN of an empty list.
fn quantile(values: &mut [f64], share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    values
        .get(index(share, values.len()))
        .copied()
        .unwrap_or(f64::NAN)
}

/// Coefficients and scale.
#[derive(Clone, Copy, Debug)]
struct Sky {
    scale: f64,
    coefficients: PerezCoefficients,
}

impl Sky {
    fn at(&self, sample: &Sample) -> f64 {
        self.scale
            * self
                .coefficients
                .relative_luminance(sample.air_mass, sample.scattering_angle)
    }
}

/// How one fit ended.
#[derive(Clone, Copy, Debug)]
struct End {
    sky: Sky,
    rms: f64,
    condition_number: f64,
    evaluations: u32,
}

impl End {
    /// Whether the fit is positive everywhere.
    fn is_sky(&self) -> bool {
        self.sky.scale > 0.0 && self.sky.coefficients.check(LEAST_MASS).is_ok()
    }
}

/// A fit with the project's safeguards.
fn ours(map: &Map, samples: &[Sample], starts: Starts<'_>) -> Option<End> {
    let sky = map.sky(samples);
    let fit = fit_channel(&sky, map.channel, starts, &FitOptions::default()).ok()?;
    let zenith = fit
        .coefficients
        .relative_luminance(1.0, map.conditions.sun_zenith);
    Some(End {
        sky: Sky {
            scale: fit.zenith_value / zenith,
            coefficients: fit.coefficients,
        },
        rms: fit.report.rms,
        condition_number: fit.report.condition_number,
        evaluations: fit.report.evaluations,
    })
}

/// The printed formula as a least-squares problem: scale and A–E, nothing else.
struct PlainPerez<'a> {
    channel: Channel,
    samples: &'a [Sample],
    root_weight: Vec<f64>,
    at: Vector6<f64>,
}

impl PlainPerez<'_> {
    fn sky(&self) -> Sky {
        let [scale, a, b, c, d, e] = self.at.into();
        Sky {
            scale,
            coefficients: PerezCoefficients { a, b, c, d, e },
        }
    }
}

impl LeastSquaresProblem<f64, Dyn, U6> for PlainPerez<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, U6>;
    type ParameterStorage = Owned<f64, U6>;

    fn set_params(&mut self, x: &Vector6<f64>) {
        self.at.copy_from(x);
    }

    fn params(&self) -> Vector6<f64> {
        self.at
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        let sky = self.sky();
        let residuals: Vec<f64> = self
            .samples
            .iter()
            .zip(&self.root_weight)
            .map(|(s, w)| {
                let model = sky.at(s);
                w * match self.channel {
                    Channel::Luminance => model.ln() - s.value.ln(),
                    Channel::ChromaticityX | Channel::ChromaticityY => model - s.value,
                }
            })
            .collect();
        residuals
            .iter()
            .all(|r| r.is_finite())
            .then(|| DVector::from_vec(residuals))
    }

    fn jacobian(&self) -> Option<OMatrix<f64, Dyn, U6>> {
        let sky = self.sky();
        let PerezCoefficients { a, b, c, d, .. } = sky.coefficients;
        let mut out = OMatrix::<f64, Dyn, U6>::zeros(self.samples.len());
        for (i, (s, w)) in self.samples.iter().zip(&self.root_weight).enumerate() {
            let gamma = s.scattering_angle.radians();
            let decay = (b * s.air_mass).exp();
            let glow = (d * gamma).exp();
            let gradation = sky.coefficients.gradation(s.air_mass);
            let indicatrix = sky.coefficients.indicatrix(s.scattering_angle);
            let model = sky.at(s);
            let outer = w * match self.channel {
                Channel::Luminance => model.recip(),
                Channel::ChromaticityX | Channel::ChromaticityY => 1.0,
            };
            let by_gradation = outer * sky.scale * indicatrix;
            let by_indicatrix = outer * sky.scale * gradation;
            let row = [
                outer * gradation * indicatrix,
                by_gradation * decay,
                by_gradation * a * s.air_mass * decay,
                by_indicatrix * glow,
                by_indicatrix * c * gamma * glow,
                by_indicatrix * gamma.cos().powi(2),
            ];
            for (k, value) in row.into_iter().enumerate() {
                out[(i, k)] = value;
            }
        }
        out.iter().all(|v| v.is_finite()).then_some(out)
    }
}

/// A fit without the safeguards.
fn plain(map: &Map, samples: &[Sample], start: &Sky) -> End {
    let total: f64 = samples.iter().map(|s| s.weight).sum();
    let PerezCoefficients { a, b, c, d, e } = start.coefficients;
    let problem = PlainPerez {
        channel: map.channel,
        samples,
        root_weight: samples.iter().map(|s| (s.weight / total).sqrt()).collect(),
        at: Vector6::from([start.scale, a, b, c, d, e]),
    };
    let (problem, report) = LevenbergMarquardt::new().minimize(problem);
    let rms = problem.residuals().map_or(f64::INFINITY, |r| r.norm());
    End {
        sky: problem.sky(),
        rms,
        condition_number: f64::NAN,
        evaluations: u32::try_from(report.number_of_evaluations).unwrap_or(u32::MAX),
    }
}

/// A random shape within the bounds of the safeguarded fit, and the scale that suits the samples.
fn random_start(problem: &PerezFit, random: Random) -> Sky {
    let bounds = problem.bounds();
    let mut p = [0.0; 6];
    for (i, k) in (1..6).zip(1..) {
        let (low, high) = (bounds.lower[i], bounds.upper[i]);
        p[i] = low + (high - low) * random.at(k).uniform();
    }
    scaled(problem, problem.coefficients_from_parameters(&p))
}

/// A shape with the scale that suits the samples.
fn scaled(problem: &PerezFit, coefficients: PerezCoefficients) -> Sky {
    let scale = problem.parameters_from_coefficients(&coefficients)[0].exp();
    Sky {
        scale,
        coefficients,
    }
}

/// Fits of one map, one damage and one method.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Observer, haze and sun.
    pub conditions: Conditions,
    /// The channel.
    pub channel: Channel,
    /// An index of [`DAMAGES`].
    pub damage: usize,
    /// An index of [`METHODS`].
    pub method: usize,
    /// Fits tried.
    pub fits: u32,
    /// Fits that were refused with an error.
    pub refused: u32,
    /// Fits that ended at coefficients that are no sky: not positive everywhere.
    pub no_sky: u32,
    /// Fits that are a sky and within [`SUCCESS`] of the best residual of a sky that any method found
    /// on the same samples.
    pub succeeded: u32,
    /// The best residual, root mean square; of several damaged maps the median.
    pub best_rms: f64,
    /// 95th percentile over the map of the difference from the best fit of the undamaged map: share
    /// of luminance, or x or y; the median of the fits.
    pub radiance_median: f64,
    /// The same of the worst fit.
    pub radiance_worst: f64,
    /// Median of the condition numbers; NaN where none is known.
    pub condition_median: f64,
    /// Median of the evaluations of the start that won.
    pub evaluations_median: f64,
    /// Most evaluations.
    pub evaluations_most: u32,
}

/// Fits a map in every way.
#[must_use]
pub fn stress(map: &Map, effort: Effort, seed: u64) -> Vec<Row> {
    let random = Random(seed);
    let Some(truth) = ours(map, &map.samples, Starts::Several) else {
        return Vec::new();
    };
    DAMAGES
        .iter()
        .enumerate()
        .flat_map(|(damage, (kind, _))| {
            let undamaged = *kind == Damage::None;
            let (repeats, starts) = if undamaged {
                (1, effort.starts)
            } else {
                (effort.damages, effort.damaged_starts)
            };
            let mut rounds = Vec::new();
            for repeat in 0..repeats {
                let here = random.at(damage as u64).at(repeat.into());
                rounds.push(round(map, *kind, starts, here));
            }
            rows(map, damage, &truth.sky, &rounds)
        })
        .collect()
}

/// The fits of one damaged map, by method; `None` for what was refused.
type Round = [Vec<Option<End>>; METHODS.len()];

fn round(map: &Map, damage: Damage, starts: u32, random: Random) -> Round {
    let samples = map.damaged(damage, random.at(0));
    let own = PerezFit::new(&map.sky(&samples), map.channel, &FitOptions::default()).ok();
    // what ours refuses is begun at a shape for the undamaged map
    let problem = own.clone().or_else(|| {
        PerezFit::new(&map.sky(&map.samples), map.channel, &FitOptions::default()).ok()
    });
    let [one_start, plain_ends] = match &problem {
        None => Default::default(),
        Some(problem) => {
            let ends: Vec<(Option<End>, End)> = (0..starts)
                .into_par_iter()
                .map(|start| {
                    let start = random_start(problem, random.at(1).at(start.into()));
                    let near = own
                        .as_ref()
                        .and_then(|_| ours(map, &samples, Starts::Near(&start.coefficients)));
                    (near, plain(map, &samples, &start))
                })
                .collect();
            let (near, plain): (Vec<_>, Vec<_>) = ends.into_iter().unzip();
            [near, plain.into_iter().map(Some).collect()]
        }
    };
    [
        // the eight starts do not depend on a random one
        vec![ours(map, &samples, Starts::Several)],
        one_start,
        vec![problem.and_then(|problem| plain_eight(map, &samples, &problem))],
        plain_ends,
    ]
}

/// The best end of a fit without the safeguards from the eight starts; a sky before what is none.
fn plain_eight(map: &Map, samples: &[Sample], problem: &PerezFit) -> Option<End> {
    let order = |a: &End, b: &End| {
        let of = |end: &End| (!end.is_sky(), end.rms);
        let ((no_sky_a, rms_a), (no_sky_b, rms_b)) = (of(a), of(b));
        no_sky_a.cmp(&no_sky_b).then(rms_a.total_cmp(&rms_b))
    };
    map.channel
        .starts()
        .map(PerezCoefficients::from_array)
        .map(|shape| plain(map, samples, &scaled(problem, shape)))
        .into_iter()
        .min_by(order)
}

fn rows(map: &Map, damage: usize, truth: &Sky, rounds: &[Round]) -> Vec<Row> {
    let count = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
    let best = |round: &Round| {
        round
            .iter()
            .flatten()
            .flatten()
            .filter(|end| end.is_sky())
            .map(|end| end.rms)
            .fold(f64::INFINITY, f64::min)
    };
    let mut bests: Vec<f64> = rounds.iter().map(best).collect();
    let best_rms = quantile(&mut bests, 0.5);
    (0..METHODS.len())
        .map(|method| {
            let mut row = Row {
                conditions: map.conditions,
                channel: map.channel,
                damage,
                method,
                fits: 0,
                refused: 0,
                no_sky: 0,
                succeeded: 0,
                best_rms,
                radiance_median: f64::NAN,
                radiance_worst: f64::NAN,
                condition_median: f64::NAN,
                evaluations_median: f64::NAN,
                evaluations_most: 0,
            };
            let (mut distances, mut conditions, mut evaluations) = (vec![], vec![], vec![]);
            for round in rounds {
                let limit = best(round) * SUCCESS + 1e-12;
                row.fits += count(round[method].len());
                for end in &round[method] {
                    let Some(end) = end else {
                        row.refused += 1;
                        continue;
                    };
                    row.no_sky += u32::from(!end.is_sky());
                    row.succeeded += u32::from(end.rms <= limit && end.is_sky());
                    distances.push(map.distance(&end.sky, truth));
                    if !end.condition_number.is_nan() {
                        conditions.push(end.condition_number);
                    }
                    evaluations.push(f64::from(end.evaluations));
                    row.evaluations_most = row.evaluations_most.max(end.evaluations);
                }
            }
            row.radiance_median = quantile(&mut distances, 0.5);
            row.radiance_worst = quantile(&mut distances, 1.0);
            row.condition_median = quantile(&mut conditions, 0.5);
            row.evaluations_median = quantile(&mut evaluations, 0.5);
            row
        })
        .collect()
}

const fn channel_name(channel: Channel) -> &'static str {
    match channel {
        Channel::Luminance => "Y",
        Channel::ChromaticityX => "x",
        Channel::ChromaticityY => "y",
    }
}

/// `fit_stress.csv`.
#[must_use]
pub fn csv(rows: &[Row]) -> String {
    let mut out = String::from(
        "altitude_km,turbidity,sun_zenith_deg,channel,damage,method,fits,refused,no_sky,succeeded,\
         success_rate,best_rms,radiance_median,radiance_worst,condition_median,\
         evaluations_median,evaluations_most\n",
    );
    for row in rows {
        let c = &row.conditions;
        // Writing to a string cannot fail.
        let _ = writeln!(
            out,
            "{:.1},{},{:.1},{},{},{},{},{},{},{},{:.5},{:.6e},{:.6e},{:.6e},{:.3e},{},{}",
            c.observer_altitude.km(),
            c.turbidity,
            c.sun_zenith.degrees(),
            channel_name(row.channel),
            DAMAGES[row.damage].1,
            METHODS[row.method].1,
            row.fits,
            row.refused,
            row.no_sky,
            row.succeeded,
            f64::from(row.succeeded) / f64::from(row.fits),
            row.best_rms,
            row.radiance_median,
            row.radiance_worst,
            row.condition_median,
            row.evaluations_median,
            row.evaluations_most
        );
    }
    out
}

/// A table for people: success and recovered light by damage and method.
#[must_use]
pub fn summary(rows: &[Row]) -> String {
    let mut out = format!(
        "{:<20}{:<13}{:>8}{:>9}{:>8}{:>10}{:>17}{:>15}\n",
        "damage",
        "method",
        "fits",
        "refused",
        "no sky",
        "success",
        "worst luminance",
        "evaluations"
    );
    for (damage, (_, damage_name)) in DAMAGES.iter().enumerate() {
        for (method, (_, method_name)) in METHODS.iter().enumerate() {
            let picked: Vec<&Row> = rows
                .iter()
                .filter(|r| r.damage == damage && r.method == method)
                .collect();
            let sum = |of: fn(&Row) -> u32| picked.iter().map(|r| of(r)).sum::<u32>();
            let worst = picked
                .iter()
                .filter(|r| r.channel == Channel::Luminance)
                .map(|r| r.radiance_worst)
                .fold(f64::NAN, f64::max);
            let fits = sum(|r| r.fits).max(1);
            let success = 100.0 * f64::from(sum(|r| r.succeeded)) / f64::from(fits);
            let _ = writeln!(
                out,
                "{damage_name:<20}{method_name:<13}{fits:>8}{:>9}{:>8}{success:>8.2} %{:>15.2} %{:>15}",
                sum(|r| r.refused),
                sum(|r| r.no_sky),
                100.0 * worst,
                picked.iter().map(|r| r.evaluations_most).max().unwrap_or(0)
            );
        }
    }
    out
}

/// Fits the skies of [`CELLS`] in every way.
///
/// # Errors
/// When the engine cannot be set up.
pub fn stress_all(effort: Effort, progress: &dyn Progress) -> Result<Vec<Row>> {
    progress.begin("skies", None);
    let maps = maps(&CELLS)?;
    progress.end();
    progress.begin("fits", Some(maps.len()));
    let found: Vec<Vec<Row>> = maps
        .par_iter()
        .enumerate()
        .map(|(i, map)| {
            let rows = stress(map, effort, i as u64);
            progress.step();
            rows
        })
        .collect();
    progress.end();
    Ok(found.into_iter().flatten().collect())
}
