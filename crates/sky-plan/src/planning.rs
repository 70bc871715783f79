//! A scene to a plan: what cannot be seen is left out of the air, then a table is searched for, then the
//! rest follows.

use anyhow::{Result, anyhow, bail};
use sky_core::aerial::AerialFrame;
use sky_core::color::Yxy;
use sky_core::conditions::Domain;
use sky_core::extended::TERMS;
use sky_core::lut::{FitStatistics, Lut, LutHeader, Storage};
use sky_core::quantity::{Angle, single};
use sky_core::utm_sky::UtmSky;
use sky_eval::cases::{pooled_conditions, random_conditions};
use sky_eval::constituents::{SWITCHES, WHOLE_STEP_NM, names, truth, whole_truth};
use sky_eval::profiles::NamedProfile;
use sky_eval::score::{Case, Score, cases, other_skies, score, score_of};
use sky_eval::stopwatch::Stopwatch;
use sky_eval::truth::{DEFAULT_GROUND_ALBEDO, TransportSky};
use sky_fit::sweep::{Grid, MapEquations, SkyMap, fit_turbidity};
use sky_science::sky_model::SkyModel;
use sky_sim::optics::Constituents;
use sky_sim::profile::AtmosphereProfile;

use crate::plan::{Axes, Expected, Plan, PlannedAerial, PlannedTier, header};
use crate::scene::{Scene, Tolerance};
use crate::search::{AXES, Choice, Neighbors, Search, Trial, term_names};
use crate::space::{Lattice, axes, coarsest, ranges};

/// Share of the tolerance that the search aims at.
const AIM: f64 = 0.95;
/// Turbidities of the cases that the search measures on, and cases at each.
const POOL: [usize; 2] = [8, 18];
/// Of the directions of [`sky_eval::cases::evaluation_directions`] every so many.
const POOL_STRIDE: usize = 3;
/// As above, for verification: 24 directions a case.
const VERIFY_STRIDE: usize = 7;
/// Seed of the search's cases; verification never uses it.
const POOL_SEED: u64 = 0x0055_544D_2005;
/// Share of the tolerance that all that is left out of the air may add.
const UNSEEN: f64 = 0.15;
/// Distance of the wavelengths of the truth \[nm\], and the coarser one that is tried.
const STEPS_NM: [u16; 2] = [WHOLE_STEP_NM, 20];

/// A choice, what it saves and what it adds.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// What was chosen.
    pub what: String,
    /// Bytes of the table that it saves.
    pub bytes: Option<usize>,
    /// Time of baking that it saves \[s\].
    pub seconds: Option<f64>,
    /// What it adds to the 95th percentile of ΔE.
    pub delta_e: f64,
    /// What it adds to the 95th percentile of the relative error of luminance.
    pub luminance: f64,
}

/// A removal that breaks the plan.
#[derive(Clone, Debug, PartialEq)]
pub struct Removal {
    /// What is removed.
    pub what: String,
    /// Bytes of the table without it.
    pub bytes: usize,
    /// 95th percentile of ΔE without it.
    pub delta_e: f64,
    /// 95th percentile of the relative error of luminance without it.
    pub luminance: f64,
    /// The larger of both over what the search aims at; above 1.
    pub ratio: f64,
}

/// A plan and how it was found.
#[derive(Clone, Debug)]
pub struct Planned {
    /// The plan.
    pub plan: Plan,
    /// Its table.
    pub lut: Lut,
    /// What the search aimed at.
    pub aim: Tolerance,
    /// Choices.
    pub rows: Vec<Row>,
    /// What would break it, the least first.
    pub removals: Vec<Removal>,
    /// The default table on such cases, in the air that it was made for: bytes and 95th percentiles of
    /// ΔE and luminance.
    pub default: Option<(usize, f64, f64)>,
}

/// A table's errors on random cases of a plan's scene, and the tolerance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Verified {
    /// 95th percentile of ΔE.
    pub delta_e_p95: f64,
    /// 95th percentile of the relative error of luminance.
    pub luminance_p95: f64,
}

/// Measures a plan's table on fresh random cases.
///
/// # Errors
/// When the plan's atmosphere cannot be built.
pub fn verify_plan(
    plan: &Plan,
    profile: &AtmosphereProfile,
    lut: Lut,
    count: u32,
    seed: u64,
) -> Result<Verified> {
    let score = verified(plan, profile, lut, count, seed)?;
    Ok(Verified {
        delta_e_p95: score.delta_e.p95,
        luminance_p95: score.luminance.p95,
    })
}

/// The whole score of a plan's table on fresh random cases.
///
/// # Errors
/// When the plan's atmosphere cannot be built.
pub fn verified(
    plan: &Plan,
    profile: &AtmosphereProfile,
    lut: Lut,
    count: u32,
    seed: u64,
) -> Result<Score> {
    let truth = whole_truth(profile, plan.ground_albedo)?;
    let count = usize::try_from(count)?;
    let conditions = random_conditions(&plan.domain(), count, seed);
    let cases = cases(&truth, &conditions, VERIFY_STRIDE, seed, &|| ())?;
    score_of(plan.tier.drawn(UtmSky::new(lut)?).as_ref(), &cases)
}

/// What a scene needs of the air.
struct Air {
    constituents: Constituents,
    step_nm: u16,
    rows: Vec<Row>,
}

/// Some of the search's cases, of few turbidities: another atmosphere is solved for each.
fn few(pool: &[Case]) -> impl Iterator<Item = &Case> {
    let chosen = |(i, case)| ((i / POOL[1]) % 4 == 1 && i % 3 == 0).then_some(case);
    pool.iter().enumerate().filter_map(chosen)
}

/// A choice of the air and what it adds to the ones before.
fn air_row(what: String, score: &Score, before: Option<&Score>, seconds: Option<f64>) -> Row {
    Row {
        what,
        bytes: Some(0),
        seconds,
        delta_e: score.delta_e.p95 - before.map_or(0.0, |b| b.delta_e.p95),
        luminance: score.luminance.p95 - before.map_or(0.0, |b| b.luminance.p95),
    }
}

/// Leaves out of the air what cannot be seen: constituents, and every other wavelength.
fn needed_air(scene: &Scene, profile: &AtmosphereProfile, pool: &[Case]) -> Result<Air> {
    let cases: Vec<Case> = few(pool).cloned().collect();
    let mut air = Air {
        constituents: Constituents::ALL,
        step_nm: STEPS_NM[0],
        rows: Vec::new(),
    };
    let albedo = scene.ground_albedo;
    let measured = |constituents, step_nm| -> Result<(Score, f64)> {
        let sky = truth(profile, constituents, step_nm, albedo)?;
        let start = Stopwatch::start();
        let skies = other_skies(&sky, &cases)?;
        Ok((score(&cases, &skies)?, start.seconds()))
    };
    let unseen = |score: &Score, share: f64| {
        score.delta_e.p95 <= share * scene.tolerance.delta_e
            && score.luminance.p95 <= share * scene.tolerance.luminance
    };
    let (_, mut time) = measured(air.constituents, air.step_nm)?;
    let mut before: Option<Score> = None;
    // without air or haze there is no sky to ask for
    for switch in SWITCHES
        .iter()
        .filter(|s| !["rayleigh", "aerosol"].contains(&s.name))
    {
        let mut fewer = air.constituents;
        *(switch.of)(&mut fewer) = false;
        let (found, took) = measured(fewer, air.step_nm)?;
        if unseen(&found, UNSEEN) {
            let saved = (time - took).max(0.0);
            let what = format!("without {}", switch.name);
            air.rows
                .push(air_row(what, &found, before.as_ref(), Some(saved)));
            air.constituents = fewer;
            time = took;
            before = Some(found);
        } else {
            let what = format!("with {} (not chosen: without)", switch.name);
            air.rows.push(air_row(what, &found, before.as_ref(), None));
        }
    }
    let (found, took) = measured(air.constituents, STEPS_NM[1])?;
    if unseen(&found, 2.0 * UNSEEN) {
        let saved = (time - took).max(0.0);
        let what = format!("wavelengths every {} nm", STEPS_NM[1]);
        air.rows
            .push(air_row(what, &found, before.as_ref(), Some(saved)));
        air.step_nm = STEPS_NM[1];
    } else {
        let what = format!(
            "wavelengths every {} nm (not chosen: {})",
            STEPS_NM[0], STEPS_NM[1]
        );
        air.rows.push(air_row(what, &found, before.as_ref(), None));
    }
    Ok(air)
}

/// The error of the formula itself: fitted to the very skies that it is compared with.
fn formula_error(truth: &TransportSky, header: &LutHeader, pool: &[Case]) -> Result<Score> {
    let all: Vec<usize> = (0..TERMS).collect();
    let some: Vec<Case> = pool.iter().step_by(4).cloned().collect();
    let skies: Vec<Vec<Yxy>> = some
        .iter()
        .map(|case| {
            let c = &case.conditions;
            let place = [
                c.observer_altitude.km(),
                c.turbidity,
                c.sun_zenith.degrees(),
            ];
            let map = SkyMap::compute(truth, header.form, (place[0], place[1], place[2]))?;
            let [altitude_km, turbidity, sun_zenith_deg] = axes(place.map(|p| vec![p]))?;
            let equations = [MapEquations::of(&map, 1.0)];
            let values = fit_turbidity(&equations, &altitude_km, &sun_zenith_deg, &all)?;
            let header = LutHeader {
                altitude_km,
                turbidity,
                sun_zenith_deg,
                storage: Storage::F32,
                ..header.clone()
            };
            let sky = UtmSky::new(Lut::from_f64(header, &values)?)?;
            Ok(sky.yxy_map(c, &case.directions)?)
        })
        .collect::<Result<_>>()?;
    score(&some, &skies)
}

/// Finds the cheapest configuration of a scene.
///
/// # Errors
/// When the tolerance or the budget cannot be met: names the best that can be reached, and what limits
/// it.
pub fn plan_scene(scene: &Scene, profile: &NamedProfile) -> Result<Planned> {
    let truth = whole_truth(&profile.profile, scene.ground_albedo)?;
    let conditions = pooled_conditions(&scene.domain, POOL[0], POOL[1], POOL_SEED);
    let pool = cases(&truth, &conditions, POOL_STRIDE, POOL_SEED, &|| ())?;
    let aim = Tolerance {
        delta_e: AIM * scene.tolerance.delta_e,
        luminance: AIM * scene.tolerance.luminance,
    };
    let mut plan = draft(scene);
    let sample = placeholder(header(&plan, &truth, profile)?);
    let floor = formula_error(&truth, &sample, &pool)?;
    if floor.delta_e.p95 > aim.delta_e || floor.luminance.p95 > aim.luminance {
        return Err(refused(
            scene,
            &floor,
            "the formula, fitted to each sky by itself",
        ));
    }
    let air = needed_air(scene, &profile.profile, &pool)?;
    plan.constituents = names(air.constituents);
    plan.wavelength_step_nm = air.step_nm;
    let fitted = plan.truth(profile)?;
    let header = placeholder(header(&plan, &fitted, profile)?);
    let lattice = Lattice::new(&fitted, &scene.domain);
    let mut search = Search::new(lattice, &pool, scene.domain, aim, header, &|| ());
    let (best, broken) = search.run()?;
    let Some(broken) = broken else {
        return Err(refused(scene, &best.score, "the distance of the nodes"));
    };
    let mut rows = air.rows;
    rows.extend(table_rows(&mut search, &best)?);
    take(&mut plan, &best.choice)?;
    let lut = plan.bake_on(&search.lattice, &fitted, profile)?;
    let sky = UtmSky::new(lut)?;
    let found = score_of(&sky, &pool)?;
    let bytes = sky.lut().encode().len();
    plan.expected = expected(bytes, &found);
    check_bytes(scene, bytes, &found, &aim)?;
    let (tier, tier_rows) = tier(scene, &aim, &sky, &found, &pool)?;
    rows.extend(tier_rows);
    plan.tier = tier;
    if tier != PlannedTier::Fragment {
        let drawn = score_of(tier.drawn(sky.clone()).as_ref(), &pool)?;
        plan.expected = expected(bytes, &drawn);
    }
    plan.aerial = aerial(scene, &sky)?;
    // once more, for its header tells how it is drawn
    let lut = plan.bake_on(&search.lattice, &fitted, profile)?;
    plan.expected.bytes = lut.encode().len();
    Ok(Planned {
        lut,
        plan,
        aim,
        rows,
        removals: removals(broken),
        default: default_table(scene, &pool)?,
    })
}

/// Puts nodes, products and storage of a choice into a plan.
fn take(plan: &mut Plan, choice: &Choice) -> Result<()> {
    let [altitude_km, turbidity, sun_zenith_deg] = choice.nodes.clone();
    plan.grid = Axes {
        altitude_km,
        turbidity,
        sun_zenith_deg,
    };
    plan.terms = term_names(&choice.terms)?;
    plan.storage = choice.storage;
    Ok(())
}

/// A tolerance that cannot be met, and the best that can be reached.
fn refused(scene: &Scene, found: &Score, limit: &str) -> anyhow::Error {
    anyhow!(
        "tolerance: expected at least CIEDE2000 {:.2} and luminance {:.4}, the best that can be reached here, found {} and {}; what limits it: {limit}",
        (found.delta_e.p95 / AIM * 100.0).ceil() / 100.0,
        (found.luminance.p95 / AIM * 1e4).ceil() / 1e4,
        scene.tolerance.delta_e,
        scene.tolerance.luminance,
    )
}

/// What would break a plan, the least first.
fn removals(broken: Neighbors) -> Vec<Removal> {
    let mut removals: Vec<Removal> = broken
        .into_iter()
        .map(|(edit, trial)| Removal {
            what: edit.words(),
            bytes: trial.bytes,
            delta_e: trial.score.delta_e.p95,
            luminance: trial.score.luminance.p95,
            ratio: trial.ratio,
        })
        .collect();
    removals.sort_by(|a, b| a.ratio.total_cmp(&b.ratio));
    removals
}

/// A budget of bytes that cannot be met.
fn check_bytes(scene: &Scene, bytes: usize, found: &Score, aim: &Tolerance) -> Result<()> {
    if let Some(budget) = scene.budget.bytes
        && bytes > usize::try_from(budget)?
    {
        bail!(
            "budget.bytes: expected at least {bytes} for CIEDE2000 {} and luminance {}, found {budget}; what limits it: {}",
            scene.tolerance.delta_e,
            scene.tolerance.luminance,
            limit(found, aim),
        );
    }
    Ok(())
}

/// Which of two errors is nearer to what is aimed at.
fn limit(found: &Score, aim: &Tolerance) -> &'static str {
    if found.delta_e.p95 / aim.delta_e > found.luminance.p95 / aim.luminance {
        "the color difference"
    } else {
        "the luminance"
    }
}

/// Room for the statistics that a baked table's header has.
fn placeholder(header: LutHeader) -> LutHeader {
    let fit = FitStatistics::default();
    LutHeader { fit, ..header }
}

/// A plan before anything was found.
fn draft(scene: &Scene) -> Plan {
    let [altitude_km, turbidity, sun_zenith_deg] = coarsest(&scene.domain);
    let Domain {
        altitude_km: a,
        turbidity: t,
        sun_zenith_deg: s,
        ..
    } = scene.domain;
    Plan {
        scene: scene.name.clone(),
        profile: scene.profile.clone(),
        ground_albedo: scene.ground_albedo,
        constituents: names(Constituents::ALL),
        wavelength_step_nm: STEPS_NM[0],
        terms: sky_core::extended::TERM_NAMES.map(str::to_owned).to_vec(),
        storage: Storage::Linear16,
        tier: PlannedTier::Fragment,
        aerial: PlannedAerial::Default,
        domain: Axes {
            altitude_km: a,
            turbidity: t,
            sun_zenith_deg: s,
        },
        grid: Axes {
            altitude_km,
            turbidity,
            sun_zenith_deg,
        },
        tolerance: scene.tolerance,
        expected: Expected {
            bytes: 0,
            delta_e_median: 0.0,
            delta_e_p95: 0.0,
            delta_e_max: 0.0,
            luminance_p95: 0.0,
            luminance_max: 0.0,
        },
    }
}

fn expected(bytes: usize, found: &Score) -> Expected {
    let short = |x: f64| format!("{x:.3e}").parse().unwrap_or(x);
    Expected {
        bytes,
        delta_e_median: short(found.delta_e.median),
        delta_e_p95: short(found.delta_e.p95),
        delta_e_max: short(found.delta_e.max),
        luminance_p95: short(found.luminance.p95),
        luminance_max: short(found.luminance.max),
    }
}

/// What each choice of the table saves against the fuller one.
fn table_rows(search: &mut Search<'_>, best: &Trial) -> Result<Vec<Row>> {
    let row = |what: String, other: &Trial| Row {
        what,
        bytes: Some(other.bytes.saturating_sub(best.bytes)),
        seconds: None,
        delta_e: best.score.delta_e.p95 - other.score.delta_e.p95,
        luminance: best.score.luminance.p95 - other.score.luminance.p95,
    };
    let full = search.trial(Choice {
        terms: (0..TERMS).collect(),
        ..best.choice.clone()
    })?;
    let exact = search.trial(Choice {
        storage: Storage::F32,
        ..best.choice.clone()
    })?;
    let count = best.choice.terms.len();
    let mut rows = vec![
        row(format!("{count} of {TERMS} products"), &full),
        row("16 bits a value".to_owned(), &exact),
    ];
    for (axis, nodes) in best.choice.nodes.iter().enumerate() {
        let [low, high] = ranges(&search.domain)[axis];
        if nodes.len() == 1 && high > low {
            let mut both = best.choice.clone();
            both.nodes[axis] = vec![low, high];
            let both = search.trial(both)?;
            rows.push(row(format!("no interpolation in {}", AXES[axis].0), &both));
        }
    }
    let default = Grid::extended()?;
    let nodes: Vec<String> = best
        .choice
        .nodes
        .iter()
        .map(|n| n.len().to_string())
        .collect();
    rows.push(Row {
        what: format!(
            "{} nodes instead of the default's {}",
            nodes.join(" x "),
            default.nodes()
        ),
        bytes: Some(
            UtmSky::embedded()?
                .lut()
                .encode()
                .len()
                .saturating_sub(full.bytes),
        ),
        seconds: None,
        delta_e: full.score.delta_e.p95,
        luminance: full.score.luminance.p95,
    });
    Ok(rows)
}

/// The cheapest way to draw the table that still meets what is aimed at, and what each adds.
fn tier(
    scene: &Scene,
    aim: &Tolerance,
    sky: &UtmSky,
    formula: &Score,
    pool: &[Case],
) -> Result<(PlannedTier, Vec<Row>)> {
    let mut rows = Vec::new();
    let mut chosen = PlannedTier::Fragment;
    for tier in PlannedTier::ALL {
        if tier == PlannedTier::Fragment || chosen != PlannedTier::Fragment {
            continue;
        }
        let found = score_of(tier.drawn(sky.clone()).as_ref(), pool)?;
        let met = found.delta_e.p95 <= aim.delta_e && found.luminance.p95 <= aim.luminance;
        if met {
            chosen = tier;
        }
        rows.push(Row {
            what: if met {
                format!("tier {}", tier.name())
            } else {
                format!("tier not {}", tier.name())
            },
            bytes: None,
            seconds: None,
            delta_e: found.delta_e.p95 - formula.delta_e.p95,
            luminance: found.luminance.p95 - formula.luminance.p95,
        });
    }
    let target = (scene.budget.gpu_ns, scene.target.fragment_ns_per_pixel);
    if let (PlannedTier::Fragment, (Some(budget), Some(each))) = (chosen, target)
        && each * scene.view.pixels > budget
    {
        bail!(
            "budget.gpu_ns: expected at least {:.0} for the formula at every pixel, found {budget}; what limits it: the cheaper tiers miss the tolerance",
            each * scene.view.pixels
        );
    }
    Ok((chosen, rows))
}

/// Whether the air before the farthest object can be seen: more of its light is lost than is tolerated.
fn aerial(scene: &Scene, sky: &UtmSky) -> Result<PlannedAerial> {
    let d = &scene.domain;
    let air = AerialFrame::new(
        sky,
        d.turbidity[1],
        Angle::from_degrees(d.sun_zenith_deg[0]),
    )?;
    let distance = single(scene.farthest_object_km);
    let level = air.path(single(d.altitude_km[0]), [1.0, 0.0, 0.0], distance);
    let lost = 1.0 - f64::from(level.transmittance[3]);
    Ok(if lost < scene.tolerance.luminance {
        PlannedAerial::None
    } else {
        PlannedAerial::Default
    })
}

/// The default table on cases, where it answers for all of them; judged by the air that it was made
/// for, so that what counts is the table.
fn default_table(scene: &Scene, pool: &[Case]) -> Result<Option<(usize, f64, f64)>> {
    let default = UtmSky::embedded()?;
    if scene.domain.turbidity[1] > default.domain().turbidity[1] {
        return Ok(None);
    }
    let (air, albedo) = (Constituents::REFERENCE, DEFAULT_GROUND_ALBEDO);
    let truth = truth(&AtmosphereProfile::general(), air, STEPS_NM[0], albedo)?;
    let conditions: Vec<_> = few(pool).map(|c| c.conditions).collect();
    let cases = cases(&truth, &conditions, POOL_STRIDE, POOL_SEED, &|| ())?;
    let score = score_of(&default, &cases)?;
    let bytes = default.lut().encode().len();
    Ok(Some((bytes, score.delta_e.p95, score.luminance.p95)))
}
