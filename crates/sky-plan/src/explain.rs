//! What a constituent of the air is worth to a scene: figures, and the picture without it.

use anyhow::Result;
use sky_core::conditions::{Conditions, Domain};
use sky_eval::cases::{conditions, evaluation_directions, pooled_conditions};
use sky_eval::constituents::{Part, whole_truth, without};
use sky_eval::ledger::Seen;
use sky_eval::picture;
use sky_eval::score::{Case, cases, other_skies, score};
use sky_eval::truth::{DEFAULT_GROUND_ALBEDO, TransportSky};
use sky_science::metrics::{ciede2000_of_lights, white_luminance};
use sky_science::sky_model::SkyModel as _;
use sky_sim::profile::AtmosphereProfile;

use crate::scene::Scene;

/// Seed of these cases.
const SEED: u64 = 0x1ED6E2;

/// Turbidities, and cases at each.
const CASES: [usize; 2] = [10, 6];

fn domain_cases(truth: &TransportSky, domain: &Domain) -> Result<Vec<Case>> {
    let conditions = pooled_conditions(domain, CASES[0], CASES[1], SEED);
    cases(truth, &conditions, 3, SEED, &|| ())
}

/// How much a term is seen over some ranges.
///
/// # Errors
/// When the atmosphere cannot be built.
pub fn visibility(
    profile: &AtmosphereProfile,
    ground_albedo: f64,
    domain: &Domain,
    term: Part,
) -> Result<Seen> {
    let all = domain_cases(&whole_truth(profile, ground_albedo)?, domain)?;
    let sky = without(profile, ground_albedo, term)?;
    let score = score(&all, &other_skies(&sky, &all)?)?;
    Ok(Seen::new(term.name(), &score))
}

/// What a scene loses without a term, in words and as a picture of its worst case: the sky with it,
/// without it, and the difference.
///
/// # Errors
/// When the atmosphere cannot be built.
pub fn explain(
    scene: &Scene,
    profile: &AtmosphereProfile,
    term: Part,
) -> Result<(String, Vec<u8>)> {
    let with = whole_truth(profile, scene.ground_albedo)?;
    let without = without(profile, scene.ground_albedo, term)?;
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
pub fn zenith_without_ozone(
    profile: &AtmosphereProfile,
    domain: &Domain,
) -> Result<Vec<(Conditions, f64)>> {
    const STEPS: u8 = 4;
    let with = whole_truth(profile, DEFAULT_GROUND_ALBEDO)?;
    let without = without(profile, DEFAULT_GROUND_ALBEDO, Part::Ozone)?;
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
