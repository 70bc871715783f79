//! `utm-sky chart`: speed against accuracy of every sky, measured in one run on one machine.
//!
//! Error is taken against the transport engine on a fixed set of cases that no table was fitted to
//! alone; a model is scored only where it claims to be valid, and the share of cases it covers is
//! told. GPU costs are of a fragment shader over a full picture, beside the floor of a constant color.

mod offline;
mod page;
mod published;

use std::time::Instant;

use anyhow::Result;
use sky_core::color::Yxy;
use sky_core::conditions::Conditions;
use sky_core::direction::SkyDirection;
use sky_core::picture::Picture;
use sky_core::quantity::{Angle, LUMINOUS_EFFICACY_LM_PER_W};
use sky_core::utm_sky::UtmSky;
use sky_gpu::headless::Headless;
use sky_gpu::{Dome, SkyFrame, Tier};
use sky_science::metrics::{
    SUN_EXCLUSION_DEG, Statistics, ciede2000_of_lights, is_clear_of_sun, white_luminance,
};
use sky_science::sky_model::SkyModel;

use crate::args::ChartArgs;
use crate::bench_gpu::{CASES, Cost, Draw, STAGE_PLACE, STAGE_SUN_ZENITH_DEG, Stage, adapter_name};
use crate::evaluate::{conditions, evaluation_directions};
use crate::files::{OutputFile, create_directory, print};
use crate::generate::progress;
use crate::models::{Model, Opened, Source, all, answers, general_truth, named};
use crate::truth::TransportSky;

pub use published::{PUBLISHED_SCALE, published};

const ALTITUDES_KM: [f64; 7] = [0.0, 1.0, 3.0, 9.0, 16.0, 25.0, 30.0];
const TURBIDITIES: [f64; 3] = [1.5, 3.0, 6.0];
const SUNS_DEG: [f64; 5] = [0.0, 40.0, 75.0, 88.0, 92.0];
/// The renderer's default tier.
const DEFAULT_TIER: &str = "utm-sky-baked";
/// Sizes that GPU costs are taken at.
const SIZES: [[u32; 2]; 2] = [[1920, 1080], [3840, 2160]];
/// Wavelengths under the luminous efficiency function \[nm\]: turns a luminance into a mean spectral
/// radiance.
const EFFICIENCY_WIDTH_NM: f64 = 106.857;

/// A part of the cases, by its name.
type Regime = (&'static str, fn(&Conditions, &SkyDirection) -> bool);

fn from_sun(c: &Conditions, d: &SkyDirection) -> f64 {
    d.scattering_angle(c.sun_zenith).degrees()
}

const REGIMES: [Regime; 7] = [
    ("all", |_, _| true),
    ("horizon-band", |_, d| d.view_zenith.degrees() >= 80.0),
    ("aureole", |c, d| from_sun(c, d) < 25.0),
    ("high-sun", |c, _| c.sun_zenith.degrees() <= 40.0),
    ("low-sun", |c, _| {
        (70.0..90.0).contains(&c.sun_zenith.degrees())
    }),
    ("twilight", |c, _| c.sun_zenith.degrees() > 90.0),
    ("aloft", |c, _| c.observer_altitude.km() >= 9.0),
];

/// Errors of one model in one regime.
#[derive(Clone, Copy, Debug, Default)]
struct Errors {
    valid_share: f64,
    delta_e: [f64; 2],
    luminance_p95: f64,
    rmse: f64,
    /// Luminance p95 after the best single factor for all maps.
    scaled_p95: f64,
    /// Share of lights that are negative or no number.
    failures: f64,
}

/// Costs of one model.
#[derive(Clone, Copy, Debug, Default)]
struct Costs {
    cpu_ns: f64,
    gpu_ns: [Option<f64>; 2],
    ratio: Option<f64>,
    update_us: f64,
    rebuild_ms: f64,
    bytes: usize,
}

struct Row {
    model: Model,
    errors: Vec<Option<Errors>>,
    costs: Costs,
    on_front: Vec<bool>,
}

/// The truth of a case.
struct Case {
    conditions: Conditions,
    directions: Vec<SkyDirection>,
    truth: Vec<Yxy>,
    white: f64,
}

/// Runs the command.
///
/// # Errors
/// When a model is unknown, a table cannot be baked or an output cannot be written.
pub fn run(args: &ChartArgs) -> Result<()> {
    let models = chosen(&args.models)?;
    create_directory(&args.out)?;
    let file = |name: &str| OutputFile::create(&args.out.join(name));
    let (csv_file, svg_file, page_file) =
        (file("chart.csv")?, file("chart.svg")?, file("chart.html")?);
    // our own settings belong to the whole chart; a quick one has a sample of them
    let offline = if args.quick || args.models.is_empty() {
        Some((file("offline.csv")?, offline::measure(args.quick)?))
    } else {
        None
    };
    let truth = general_truth()?;
    let cases = cases(&truth, args.quick)?;
    let skies: Vec<Opened> = models
        .iter()
        .map(|model| model.open(&truth))
        .collect::<Result<_>>()?;
    let gpu = Headless::new().ok();
    let adapter = gpu.as_ref().map_or_else(|| "none".to_owned(), adapter_name);
    let gpu_costs = match &gpu {
        Some(gpu) => time_on_gpu(gpu, &models, &skies, args.quick)?,
        None => vec![[None; 3]; models.len()],
    };
    let bar = progress("models", models.len());
    let mut rows = Vec::new();
    for ((model, sky), gpu) in models.into_iter().zip(&skies).zip(gpu_costs) {
        let errors = measure_errors(sky.sky(), &cases, &model)?;
        let mut costs = time_on_cpu(&model, sky)?;
        costs.bytes = sky.bytes;
        costs.gpu_ns = [gpu[0], gpu[1]];
        costs.ratio = gpu[2];
        rows.push(Row {
            model,
            on_front: vec![false; REGIMES.len()],
            errors,
            costs,
        });
        bar.inc(1);
    }
    bar.finish_and_clear();
    mark_front(&mut rows);
    csv_file.commit(page::csv(&rows, &adapter)?.as_bytes())?;
    let panels = page::panels(&rows)?;
    svg_file.commit(page::sheet(&panels).as_bytes())?;
    let offline = match offline {
        Some((file, points)) => {
            file.commit(offline::csv(&points)?.as_bytes())?;
            offline::html(&points)?
        }
        None => "<p class=\"soft\">Measured where all models are.</p>".to_owned(),
    };
    page_file.commit(page::html(&rows, &panels, &offline, &adapter).as_bytes())?;
    print(&page::beside_text(&rows, &page::beside(&rows))?)?;
    Ok(())
}

fn chosen(names: &[String]) -> Result<Vec<Model>> {
    if names.is_empty() {
        return Ok(all());
    }
    names.iter().map(|name| named(name)).collect()
}

fn cases(truth: &TransportSky, quick: bool) -> Result<Vec<Case>> {
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
    let bar = progress("truth", all.len());
    let mut out = Vec::new();
    for conditions in all {
        let mut directions = evaluation_directions(conditions.observer_altitude);
        let exclusion = Angle::from_degrees(SUN_EXCLUSION_DEG);
        directions.retain(|d| is_clear_of_sun(d, conditions.sun_zenith, exclusion));
        let truth = truth.yxy_map(&conditions, &directions)?;
        out.push(Case {
            white: white_luminance(&truth).unwrap_or(f64::NAN),
            conditions,
            directions,
            truth,
        });
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(out)
}

fn measure_errors(
    sky: &dyn SkyModel,
    cases: &[Case],
    model: &Model,
) -> Result<Vec<Option<Errors>>> {
    // conditions, direction, truth, answer, white of the case
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
                lights.push((case, *direction, *truth, map[i]));
            }
        }
    }
    // one factor for all lights, the median of their ratios
    let ratios: Vec<f64> = lights
        .iter()
        .map(|(_, _, t, f)| t.luminance_cd_m2 / f.luminance_cd_m2)
        .filter(|r| r.is_finite() && *r > 0.0)
        .collect();
    let factor = Statistics::of(&ratios).map_or(1.0, |s| s.median);
    let p95 = |values: &[f64]| Statistics::of(values).map_or(f64::NAN, |s| s.p95);
    Ok(REGIMES
        .iter()
        .zip(asked)
        .map(|((_, inside), asked)| {
            let (mut delta_e, mut relative, mut scaled) = (Vec::new(), Vec::new(), Vec::new());
            let (mut squares, mut failures, mut count) = (0.0, 0.0, 0.0);
            for (case, direction, truth, found) in &lights {
                if !inside(&case.conditions, direction) {
                    continue;
                }
                count += 1.0;
                let y = found.luminance_cd_m2;
                if !(y.is_finite() && y >= 0.0 && found.x >= 0.0 && found.y >= 0.0) {
                    failures += 1.0;
                }
                let shown = if model.luminance_only() {
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
                let radiance = 1e3 * (y - truth.luminance_cd_m2)
                    / (LUMINOUS_EFFICACY_LM_PER_W * EFFICIENCY_WIDTH_NM);
                squares += radiance * radiance;
            }
            let median = Statistics::of(&delta_e)?.median;
            Some(Errors {
                valid_share: count / f64::from(asked).max(1.0),
                delta_e: [median, p95(&delta_e)],
                luminance_p95: p95(&relative),
                rmse: (squares / f64::max(count, 1.0)).sqrt(),
                scaled_p95: p95(&scaled),
                failures: failures / f64::max(count, 1.0),
            })
        })
        .collect())
}

/// The conditions of the timed frames.
const fn timed() -> Conditions {
    conditions(STAGE_PLACE[0], STAGE_PLACE[1], STAGE_SUN_ZENITH_DEG)
}

/// The shortest of several runs \[s\].
fn shortest(runs: u32, mut work: impl FnMut()) -> f64 {
    (0..runs)
        .map(|_| {
            let start = Instant::now();
            work();
            start.elapsed().as_secs_f64()
        })
        .fold(f64::INFINITY, f64::min)
}

fn time_on_cpu(model: &Model, opened: &Opened) -> Result<Costs> {
    let sky = opened.sky();
    let conditions = timed();
    let directions = evaluation_directions(conditions.observer_altitude);
    let map = |directions: &[SkyDirection]| {
        shortest(5, || {
            std::hint::black_box(sky.yxy_map(&conditions, directions)).ok();
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
                drop(std::hint::black_box(shader.shader_frame(&conditions)));
            });
        costs.rebuild_ms = 1e3
            * shortest(1, || {
                std::hint::black_box(shader.rebuild(conditions.turbidity));
            });
    } else if let Source::Ours | Source::Baked | Source::Dome = model.source {
        let sky = UtmSky::embedded()?;
        costs.update_us = 1e6
            * shortest(200, || {
                drop(std::hint::black_box(Picture::new(&sky, &conditions, 0.2)));
            });
    } else {
        costs.update_us = map(&directions[..1]) * 1e6;
    }
    Ok(costs)
}

/// Nanoseconds a pixel at both sizes and the ratio to the floor, for each model.
fn time_on_gpu(
    gpu: &Headless,
    models: &[Model],
    skies: &[Opened],
    quick: bool,
) -> Result<Vec<[Option<f64>; 3]>> {
    let mut out = vec![[None; 3]; models.len()];
    let sizes = if quick { &SIZES[..1] } else { &SIZES[..] };
    let (frames, seconds) = if quick { (5, 2.0) } else { (15, 4.0) };
    let bar = progress("GPU frames", sizes.len() * (frames as usize + 1));
    for (s, size) in sizes.iter().enumerate() {
        let stage = Stage::new(gpu, *size)?;
        let mut draws: Vec<Draw<'_>> = vec![stage.draw(CASES[0])];
        let mut places = Vec::new();
        for (i, (model, sky)) in models.iter().zip(skies).enumerate() {
            let tier = match model.source {
                Source::Ours => Some(Tier::Fragment),
                Source::Baked => Some(Tier::Baked),
                Source::Dome => Some(Tier::Vertex(Dome::REPORT)),
                Source::Table(_) | Source::Published(_) => None,
            };
            if let Some(case) = CASES
                .iter()
                .find(|c| tier.is_some() && c.tier == tier && !c.composite)
            {
                draws.push(stage.draw(*case));
                places.push(i);
            } else if let Some(shader) = sky.shader_sky() {
                let axes = SkyFrame {
                    sun: crate::render::world_direction(
                        Angle::ZERO,
                        Angle::from_degrees(90.0 - STAGE_SUN_ZENITH_DEG),
                    ),
                    ..SkyFrame::default()
                }
                .local_axes();
                let clip_to_local = Stage::camera(*size).clip_to_local(axes);
                let format = wgpu::TextureFormat::Rgba16Float;
                draws.push(published(gpu, shader, &timed(), clip_to_local, format)?);
                places.push(i);
            }
        }
        let costs: Vec<Cost> = stage.interleaved(gpu, &draws, frames, seconds, &|| bar.inc(1))?;
        for (place, cost) in places.iter().zip(&costs[1..]) {
            out[*place][s] = Some(cost.median_ns);
            if s == 0 {
                out[*place][2] = Some(cost.median_ns / costs[0].median_ns);
            }
        }
    }
    bar.finish_and_clear();
    Ok(out)
}

/// A model is on the front of a regime where none is both cheaper on the GPU and closer to the truth.
fn mark_front(rows: &mut [Row]) {
    for r in 0..REGIMES.len() {
        let places: Vec<Option<[f64; 2]>> = rows.iter().map(|row| place(row, r)).collect();
        for (i, row) in rows.iter_mut().enumerate() {
            row.on_front[r] = places[i].is_some_and(|[cost, error]| {
                !places
                    .iter()
                    .flatten()
                    .any(|[c, e]| *c <= cost && *e <= error && (*c < cost || *e < error))
            });
        }
    }
}

/// Cost \[ns a pixel\] and error (ΔE p95) of a row in a regime, where it has both.
fn place(row: &Row, regime: usize) -> Option<[f64; 2]> {
    let error = row.errors[regime]?.delta_e[1];
    error.is_finite().then_some(())?;
    Some([row.costs.gpu_ns[0]?, error])
}
