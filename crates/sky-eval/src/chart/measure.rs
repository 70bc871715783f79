//! Error against the transport engine and cost on the CPU, model by model.

use anyhow::Result;
use sky_core::color::Yxy;
use sky_core::conditions::Conditions;
use sky_core::direction::SkyDirection;
use sky_core::picture::Picture;
use sky_core::quantity::LUMINOUS_EFFICACY_LM_PER_W;
use sky_core::utm_sky::UtmSky;
use sky_science::metrics::{Statistics, ciede2000_of_lights};
use sky_science::sky_model::SkyModel;

use super::rows::{Costs, Errors, GpuCosts, REGIMES, Row, mark_front};
use crate::cases::{conditions, evaluation_directions};
use crate::models::{Model, Opened, Source, all, answers, named};
use crate::progress::Progress;
use crate::score::{Case, cases};
use crate::stopwatch::shortest;
use crate::truth::TransportSky;

const ALTITUDES_KM: [f64; 7] = [0.0, 1.0, 3.0, 9.0, 16.0, 25.0, 30.0];
const TURBIDITIES: [f64; 3] = [1.5, 3.0, 6.0];
const SUNS_DEG: [f64; 5] = [0.0, 40.0, 75.0, 88.0, 92.0];
/// Wavelengths under the luminous efficiency function \[nm\]: turns a luminance into a mean spectral
/// radiance.
const EFFICIENCY_WIDTH_NM: f64 = 106.857;

/// The models of some names, in their order; without names all.
///
/// # Errors
/// When a name is none.
pub fn chosen(names: &[String]) -> Result<Vec<Model>> {
    if names.is_empty() {
        return Ok(all());
    }
    names.iter().map(|name| named(name)).collect()
}

/// The truth of the chart's cases; of a quick one, every fourth.
///
/// # Errors
/// When the truth cannot answer.
pub fn chart_cases(
    truth: &TransportSky,
    quick: bool,
    progress: &dyn Progress,
) -> Result<Vec<Case>> {
    let mut all = Vec::new();
    for turbidity in TURBIDITIES {
        for altitude in ALTITUDES_KM {
            for sun in SUNS_DEG {
                all.push(conditions(altitude, turbidity, sun));
            }
        }
    }
    if quick {
        all = all.into_iter().step_by(4).collect();
    }
    progress.begin("truth", Some(all.len()));
    // every direction, so no seed decides on any
    let out = cases(truth, &all, 1, 0, &|| progress.step())?;
    progress.end();
    Ok(out)
}

/// A row for each model: errors over the cases, costs under the conditions `timed` on the CPU and as
/// they were measured on a GPU.
///
/// # Errors
/// When the embedded table cannot be read.
pub fn rows(
    models: Vec<(Model, &Opened, GpuCosts)>,
    cases: &[Case],
    timed: &Conditions,
    progress: &dyn Progress,
) -> Result<Vec<Row>> {
    progress.begin("models", Some(models.len()));
    let mut rows = Vec::new();
    for (model, sky, gpu) in models {
        let errors = measure_errors(sky.sky(), cases, &model);
        let mut costs = time_on_cpu(&model, sky, timed)?;
        costs.bytes = sky.bytes;
        costs.gpu = gpu;
        rows.push(Row {
            model,
            on_front: vec![false; REGIMES.len()],
            errors,
            costs,
        });
        progress.step();
    }
    progress.end();
    mark_front(&mut rows);
    Ok(rows)
}

/// A light of the truth and what a model has in its place.
struct Light<'a> {
    case: &'a Case,
    direction: SkyDirection,
    truth: Yxy,
    found: Yxy,
}

fn measure_errors(sky: &dyn SkyModel, cases: &[Case], model: &Model) -> Vec<Option<Errors>> {
    let mut lights = Vec::new();
    let mut asked = [0_u32; REGIMES.len()];
    for case in cases {
        let map = sky.yxy_map(&case.conditions, &case.directions).ok();
        for (i, (direction, truth)) in case.directions.iter().zip(&case.truth).enumerate() {
            for (asked, (_, inside)) in asked.iter_mut().zip(REGIMES) {
                *asked += u32::from(inside(&case.conditions, direction));
            }
            let answered = answers(sky.domain(), &case.conditions, direction);
            if let Some(map) = map.as_ref().filter(|_| answered) {
                lights.push(Light {
                    case,
                    direction: *direction,
                    truth: *truth,
                    found: map[i],
                });
            }
        }
    }
    // one factor for all lights, the median of their ratios
    let ratios: Vec<f64> = lights
        .iter()
        .map(|light| light.truth.luminance_cd_m2 / light.found.luminance_cd_m2)
        .filter(|r| r.is_finite() && *r > 0.0)
        .collect();
    let factor = Statistics::of(&ratios).map_or(1.0, |s| s.median);
    REGIMES
        .iter()
        .zip(asked)
        .map(|((_, inside), asked)| {
            let here: Vec<&Light<'_>> = lights
                .iter()
                .filter(|light| inside(&light.case.conditions, &light.direction))
                .collect();
            errors(&here, asked, factor, model.luminance_only())
        })
        .collect()
}

/// Errors over some lights, of those that were asked for; `None` without lights.
fn errors(lights: &[&Light<'_>], asked: u32, factor: f64, luminance_only: bool) -> Option<Errors> {
    let (mut delta_e, mut relative, mut scaled) = (Vec::new(), Vec::new(), Vec::new());
    let (mut squares, mut failures, mut count) = (0.0, 0.0, 0.0);
    for Light {
        case, truth, found, ..
    } in lights
    {
        count += 1.0;
        let y = found.luminance_cd_m2;
        if !(y.is_finite() && y >= 0.0 && found.x >= 0.0 && found.y >= 0.0) {
            failures += 1.0;
        }
        let shown = if luminance_only {
            Yxy {
                luminance_cd_m2: y,
                ..*truth
            }
        } else {
            *found
        };
        delta_e.push(ciede2000_of_lights(shown, *truth, case.white));
        relative.push((y / truth.luminance_cd_m2 - 1.0).abs());
        scaled.push((factor * y / truth.luminance_cd_m2 - 1.0).abs());
        let radiance =
            1e3 * (y - truth.luminance_cd_m2) / (LUMINOUS_EFFICACY_LM_PER_W * EFFICIENCY_WIDTH_NM);
        squares += radiance * radiance;
    }
    let p95 = |values: &[f64]| Statistics::of(values).map_or(f64::NAN, |s| s.p95);
    let median = Statistics::of(&delta_e)?.median;
    Some(Errors {
        valid_share: count / f64::from(asked).max(1.0),
        delta_e: [median, p95(&delta_e)],
        luminance_p95: p95(&relative),
        rmse: (squares / f64::max(count, 1.0)).sqrt(),
        scaled_p95: p95(&scaled),
        failures: failures / f64::max(count, 1.0),
    })
}

fn time_on_cpu(model: &Model, opened: &Opened, conditions: &Conditions) -> Result<Costs> {
    let sky = opened.sky();
    let directions = evaluation_directions(conditions.observer_altitude);
    let map = |directions: &[SkyDirection]| {
        shortest(5, || {
            std::hint::black_box(sky.yxy_map(conditions, directions)).ok();
        })
    };
    map(&directions); // tables that are made on first use
    // what belongs to the frame is in both, and cancels
    let many: Vec<SkyDirection> = directions
        .iter()
        .cycle()
        .take(20 * directions.len())
        .copied()
        .collect();
    let cheap = map(&directions) < 2e-3;
    let longer = if cheap { &many } else { &directions };
    let counted = f64::from(u32::try_from(longer.len())?) - 1.0;
    let cpu_ns = (map(longer) - map(&directions[..1])).max(0.0) * 1e9 / counted;
    let mut costs = Costs {
        cpu_ns,
        ..Costs::default()
    };
    if let Some(shader) = opened.shader_sky() {
        costs.update_us = 1e6
            * shortest(3, || {
                drop(std::hint::black_box(shader.shader_frame(conditions)));
            });
        costs.rebuild_ms = 1e3
            * shortest(1, || {
                std::hint::black_box(shader.rebuild(conditions.turbidity));
            });
    } else if let Source::Ours | Source::Baked | Source::Dome = model.source {
        let sky = UtmSky::embedded()?;
        costs.update_us = 1e6
            * shortest(200, || {
                drop(std::hint::black_box(Picture::new(&sky, conditions, 0.2)));
            });
    } else {
        costs.update_us = map(&directions[..1]) * 1e6;
    }
    Ok(costs)
}
