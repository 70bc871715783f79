//! What a constituent of the air is worth: the picture without it, and the ledger of all of them.

use std::fmt::Write as _;
use std::path::Path;

use anyhow::Result;
use rayon::prelude::*;
use sky_core::metrics::{ciede2000_of_lights, white_luminance};
use sky_core::sky_model::{Conditions, Domain, SkyModel as _};
use sky_sim::optics::Constituents;

use super::file::{SWITCHES, truth};
use super::scene::Scene;
use super::space::{Case, Score, cases, other_skies, pooled_conditions, score};
use super::{STEPS_NM, whole_truth};
use crate::args::PlanTerm;
use crate::evaluate::{conditions, evaluation_directions};
use crate::report::picture;
use crate::truth::{DEFAULT_GROUND_ALBEDO, TransportSky};

/// Seed of these cases.
const SEED: u64 = 0x1ED6E2;

/// Turbidities, and cases at each.
const CASES: [usize; 2] = [10, 6];

/// How much a term is seen: the errors of leaving it out.
#[derive(Clone, Debug, PartialEq)]
pub struct Seen {
    /// The term.
    pub term: &'static str,
    /// CIEDE2000: median.
    pub delta_e_median: f64,
    /// CIEDE2000: 95 % of directions below.
    pub delta_e_p95: f64,
    /// CIEDE2000: largest.
    pub delta_e_max: f64,
    /// Relative error of luminance: 95 % of directions below \[1\].
    pub luminance_p95: f64,
    /// Share of all directions of all cases with ΔE above 1.
    pub directions_seen: f64,
    /// Share of cases that have such a direction.
    pub cases_seen: f64,
    /// The case of the largest ΔE.
    pub worst: Conditions,
}

impl Seen {
    fn new(term: &'static str, score: &Score) -> Self {
        Self {
            term,
            delta_e_median: score.delta_e.median,
            delta_e_p95: score.delta_e.p95,
            delta_e_max: score.delta_e.max,
            luminance_p95: score.luminance.p95,
            directions_seen: score.seen[0],
            cases_seen: score.seen[1],
            worst: score.worst,
        }
    }
}

/// The sky without a term.
fn without(profile: &Path, ground_albedo: f64, term: PlanTerm) -> Result<TransportSky> {
    let mut constituents = Constituents::ALL;
    let mut albedo = ground_albedo;
    match SWITCHES.iter().find(|s| s.name == term.name()) {
        Some(switch) => *(switch.of)(&mut constituents) = false,
        None => albedo = 0.0,
    }
    truth(profile, constituents, STEPS_NM[0], albedo)
}

fn domain_cases(truth: &TransportSky, domain: &Domain) -> Result<Vec<Case>> {
    let conditions = pooled_conditions(domain, CASES[0], CASES[1], SEED);
    cases(truth, &conditions, 3, SEED, &|| ())
}

/// How much a term is seen over some ranges.
///
/// # Errors
/// When the atmosphere cannot be built.
pub fn visibility(
    profile: &Path,
    ground_albedo: f64,
    domain: &Domain,
    term: PlanTerm,
) -> Result<Seen> {
    let all = domain_cases(&whole_truth(profile, ground_albedo)?, domain)?;
    let sky = without(profile, ground_albedo, term)?;
    let score = score(&all, &other_skies(&sky, &all)?)?;
    Ok(Seen::new(term.name(), &score))
}

/// Every term over the domain of the default table.
///
/// # Errors
/// When the atmosphere cannot be built.
pub fn ledger() -> Result<Vec<Seen>> {
    let (profile, albedo) = (Path::new("general"), DEFAULT_GROUND_ALBEDO);
    let domain = Domain {
        altitude_km: [0.0, 30.0],
        turbidity: [1.0, 8.0],
        sun_zenith_deg: [0.0, 96.0],
        below_horizontal: true,
    };
    let all = domain_cases(&whole_truth(profile, albedo)?, &domain)?;
    PlanTerm::LEDGER
        .par_iter()
        .map(|term| {
            let sky = without(profile, albedo, *term)?;
            Ok(Seen::new(
                term.name(),
                &score(&all, &other_skies(&sky, &all)?)?,
            ))
        })
        .collect()
}

/// The ledger for people, and as CSV.
pub(super) fn ledger_tables(ledger: &[Seen]) -> (String, String) {
    let mut text = format!(
        "{:<14} {:>10} {:>10} {:>8} {:>8} {:>8} {:>8}   worst at\n",
        "without", "directions", "cases", "dE p50", "dE p95", "dE max", "Y p95"
    );
    let mut csv = "term,directions_seen,cases_seen,delta_e_median,delta_e_p95,delta_e_max,luminance_p95,worst_altitude_km,worst_turbidity,worst_sun_zenith_deg\n".to_owned();
    for seen in ledger {
        let worst = &seen.worst;
        let [h, t, s] = [
            worst.observer_altitude.km(),
            worst.turbidity,
            worst.sun_zenith.degrees(),
        ];
        // a `String` takes everything
        let _ = writeln!(
            text,
            "{:<14} {:>8.1} % {:>8.1} % {:>8.2} {:>8.2} {:>8.2} {:>6.2} %   {h:.1} km, T {t:.2}, sun {s:.1} deg",
            seen.term,
            100.0 * seen.directions_seen,
            100.0 * seen.cases_seen,
            seen.delta_e_median,
            seen.delta_e_p95,
            seen.delta_e_max,
            100.0 * seen.luminance_p95,
        );
        let _ = writeln!(
            csv,
            "{},{:.4},{:.4},{:.4},{:.4},{:.4},{:.5},{h:.3},{t:.3},{s:.3}",
            seen.term,
            seen.directions_seen,
            seen.cases_seen,
            seen.delta_e_median,
            seen.delta_e_p95,
            seen.delta_e_max,
            seen.luminance_p95,
        );
    }
    text.push_str("directions, cases: share with CIEDE2000 above 1 when the term is left out\n");
    (text, csv)
}

/// What a scene loses without a term, in words and as a picture of its worst case: the sky with it,
/// without it, and the difference.
pub(super) fn explain(scene: &Scene, term: PlanTerm) -> Result<(String, Vec<u8>)> {
    let with = whole_truth(&scene.profile, scene.ground_albedo)?;
    let without = without(&scene.profile, scene.ground_albedo, term)?;
    let all = domain_cases(&with, &scene.domain)?;
    let score = score(&all, &other_skies(&without, &all)?)?;
    let worst = score.worst;
    let grid = picture::Grid::new(&worst);
    let directions = grid.directions();
    let png = picture::strip(
        &worst,
        &grid,
        &with.yxy_map(&worst, &directions)?,
        &without.yxy_map(&worst, &directions)?,
    )?;
    let text = format!(
        "{} without {}: CIEDE2000 median {:.2}, p95 {:.2}, worst {:.2}; luminance p95 {:.2} %\n\
         worst at {:.2} km, turbidity {:.2}, sun zenith {:.2} deg\n\
         above 1 in {:.1} % of directions\n",
        scene.name,
        term.name(),
        score.delta_e.median,
        score.delta_e.p95,
        score.delta_e.max,
        100.0 * score.luminance.p95,
        worst.observer_altitude.km(),
        worst.turbidity,
        worst.sun_zenith.degrees(),
        100.0 * score.seen[0],
    );
    Ok((text, png))
}

/// CIEDE2000 at the zenith between the skies with and without ozone, over altitudes and suns of a
/// domain at its least turbidity. The white is that of the whole sky with ozone.
///
/// # Errors
/// When the atmosphere cannot be built.
pub fn zenith_without_ozone(profile: &Path, domain: &Domain) -> Result<Vec<(Conditions, f64)>> {
    const STEPS: u8 = 4;
    let with = whole_truth(profile, DEFAULT_GROUND_ALBEDO)?;
    let without = without(profile, DEFAULT_GROUND_ALBEDO, PlanTerm::Ozone)?;
    let place =
        |[low, high]: [f64; 2], i: u8| low + f64::from(i) / f64::from(STEPS - 1) * (high - low);
    let mut out = Vec::new();
    for a in 0..STEPS {
        for s in 0..STEPS {
            let here = conditions(
                place(domain.altitude_km, a),
                domain.turbidity[0],
                place(domain.sun_zenith_deg, s),
            );
            // the zenith is the first of them
            let directions = evaluation_directions(here.observer_altitude);
            let truth = with.yxy_map(&here, &directions)?;
            let other = without.yxy_map(&here, &directions[..1])?;
            let white = white_luminance(&truth).unwrap_or(f64::NAN);
            out.push((here, ciede2000_of_lights(other[0], truth[0], white)));
        }
    }
    Ok(out)
}
