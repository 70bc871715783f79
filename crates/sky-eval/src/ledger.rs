//! The term ledger: what the sky would lose without each thing that is modeled, and where.

use anyhow::Result;
use sky_core::color::Yxy;
use sky_core::conditions::{Conditions, Domain};
use sky_core::direction::{SkyDirection, horizon_zenith};
use sky_core::quantity::{Angle, Length};
use sky_core::utm_sky::UtmSky;
use sky_science::sky_model::{SkyError, SkyModel};
use sky_sim::plane_parallel;
use sky_sim::profile::AtmosphereProfile;
use sky_sim::transport::TransportSettings;
use std::fmt::Write as _;

use crate::cases::conditions;
use crate::constituents::{Part, whole_truth, without};
use crate::progress::Progress;
use crate::score::{Case, Score, cases, other_skies, score};
use crate::truth::{DEFAULT_GROUND_ALBEDO, TransportSky};
use crate::twin::{rounded_to_f16, with_coefficients};

/// Seed of the directions.
const SEED: u64 = 0x1ED6E2;
/// Every so many directions are compared.
const STRIDE: usize = 3;

/// Where the ledger looks: altitudes \[km\], turbidities, sun zenith angles \[deg\]. None is a node of
/// the default table but at the ends.
pub const ALTITUDES_KM: [f64; 8] = [0.0, 0.7, 2.7, 4.6, 7.0, 13.4, 21.0, 30.0];
const TURBIDITIES: [f64; 3] = [1.2, 2.6, 5.5];
/// See [`ALTITUDES_KM`].
pub const SUNS_DEG: [f64; 11] = [
    0.0, 20.0, 40.0, 59.0, 73.0, 81.0, 87.0, 89.0, 91.5, 93.0, 95.0,
];

/// What may be left out.
#[derive(Clone, Copy, Debug)]
enum Term {
    /// A constituent of the air, or the ground's light.
    Air(Part),
    /// The orders of scattering after this one.
    OrdersAfter(usize),
    /// The Earth's curvature, in light scattered once: flat layers in its place, which end at the
    /// horizontal and at sunset.
    Curvature,
    /// The table's interpolation between altitudes: the nearest node's sky in its place.
    AltitudeInterpolation,
    /// The table's nodes of suns below the horizon: the sky of sunset in their place.
    TwilightNodes,
    /// The runtime's 32-bit coefficients: 16-bit ones in their place.
    SinglePrecision,
}

/// Every term, by its name.
const TERMS: [(&str, Term); 15] = [
    ("ozone", Term::Air(Part::Ozone)),
    ("no2", Term::Air(Part::No2)),
    ("o2", Term::Air(Part::Oxygen)),
    ("h2o", Term::Air(Part::Water)),
    ("o2o2", Term::Air(Part::OxygenPairs)),
    ("stratosphere", Term::Air(Part::Stratosphere)),
    ("ground", Term::Air(Part::Ground)),
    ("orders after 1", Term::OrdersAfter(1)),
    ("orders after 2", Term::OrdersAfter(2)),
    ("orders after 3", Term::OrdersAfter(3)),
    ("orders after 5", Term::OrdersAfter(5)),
    ("curvature", Term::Curvature),
    ("altitude interpolation", Term::AltitudeInterpolation),
    ("twilight nodes", Term::TwilightNodes),
    ("f32 (f16 in its place)", Term::SinglePrecision),
];

/// How much a term is seen: the errors of leaving it out, over all altitudes, turbidities and suns.
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
    /// Where: the share of directions with ΔE above 1 over the turbidities, sun by sun for each of
    /// [`ALTITUDES_KM`]; may be empty.
    pub map: Vec<f64>,
}

impl Seen {
    /// From a score.
    #[must_use]
    pub const fn new(term: &'static str, score: &Score) -> Self {
        Self {
            term,
            delta_e_median: score.delta_e.median,
            delta_e_p95: score.delta_e.p95,
            delta_e_max: score.delta_e.max,
            luminance_p95: score.luminance.p95,
            directions_seen: score.seen[0],
            cases_seen: score.seen[1],
            worst: score.worst,
            map: Vec::new(),
        }
    }
}

/// The sky whose first order of scattering knows no curvature.
struct Flat(TransportSky);

impl SkyModel for Flat {
    fn name(&self) -> &'static str {
        "flat"
    }

    fn domain(&self) -> &Domain {
        self.0.domain()
    }

    fn yxy_map(
        &self,
        conditions: &Conditions,
        directions: &[SkyDirection],
    ) -> Result<Vec<Yxy>, SkyError> {
        let (here, sun) = (conditions.observer_altitude, conditions.sun_zenith);
        let all = self.0.radiance_ratio(conditions, directions)?;
        let round = self.0.solved(conditions.turbidity)?;
        let round = round.single_scattering_ratio(here, sun, directions);
        let optics = self.0.optics(conditions.turbidity)?;
        let flat = plane_parallel::single_scattering_ratio(&optics, here, sun, directions);
        let without: Vec<f64> = all
            .iter()
            .zip(round.iter().zip(&flat))
            .map(|(all, (round, flat))| all - round + flat)
            .collect();
        Ok(self.0.colors(&without))
    }
}

/// A table without one of its parts.
struct Cut {
    sky: UtmSky,
    term: Term,
}

impl SkyModel for Cut {
    fn name(&self) -> &'static str {
        "cut"
    }

    fn domain(&self) -> &Domain {
        self.sky.domain()
    }

    fn yxy_map(
        &self,
        conditions: &Conditions,
        directions: &[SkyDirection],
    ) -> Result<Vec<Yxy>, SkyError> {
        match self.term {
            Term::AltitudeInterpolation => {
                let here = conditions.observer_altitude.km();
                let nodes = self.sky.lut().header().altitude_km.nodes();
                let nearest = nodes.iter().copied().fold(f64::INFINITY, |best, node| {
                    if (node - here).abs() < (best - here).abs() {
                        node
                    } else {
                        best
                    }
                });
                let there = Conditions {
                    observer_altitude: Length::from_km(nearest),
                    ..*conditions
                };
                // what the node's horizon hides is its horizon
                let lowest = horizon_zenith(there.observer_altitude);
                let seen: Vec<SkyDirection> = directions
                    .iter()
                    .map(|d| SkyDirection {
                        view_zenith: Angle::from_radians(
                            d.view_zenith.radians().min(lowest.radians()),
                        ),
                        ..*d
                    })
                    .collect();
                self.sky.yxy_map(&there, &seen)
            }
            Term::TwilightNodes => {
                let sunset = Angle::from_degrees(conditions.sun_zenith.degrees().min(90.0));
                let day = Conditions {
                    sun_zenith: sunset,
                    ..*conditions
                };
                self.sky.yxy_map(&day, directions)
            }
            _ => {
                let frame = self.sky.frame(conditions)?;
                let rounded = rounded_to_f16(frame.coefficients());
                Ok(directions
                    .iter()
                    .map(|d| with_coefficients(&rounded, frame.radii(), d, conditions))
                    .collect())
            }
        }
    }
}

fn lights(sky: &dyn SkyModel, cases: &[Case]) -> Result<Vec<Vec<Yxy>>> {
    cases
        .iter()
        .map(|case| Ok(sky.yxy_map(&case.conditions, &case.directions)?))
        .collect()
}

/// A term's row: what is found without it, against what it is with it.
fn row(term: &'static str, cases: &[Case], found: &[Vec<Yxy>]) -> Result<Seen> {
    let score = score(cases, found)?;
    let each: Vec<f64> = cases
        .iter()
        .zip(found)
        .map(|(case, found)| {
            let delta_e = case.delta_e(found);
            delta_e.iter().filter(|e| **e > 1.0).count() as f64 / delta_e.len() as f64
        })
        .collect();
    let places = ALTITUDES_KM.len() * SUNS_DEG.len();
    let map = (0..places)
        .map(|place| {
            let here: Vec<f64> = each.iter().skip(place).step_by(places).copied().collect();
            here.iter().sum::<f64>() / here.len() as f64
        })
        .collect();
    Ok(Seen {
        map,
        ..Seen::new(term, &score)
    })
}

/// Every term over the domain of the default table.
///
/// # Errors
/// When the atmosphere cannot be built.
pub fn ledger(progress: &dyn Progress) -> Result<Vec<Seen>> {
    progress.begin("term ledger", Some(TERMS.len()));
    let (profile, albedo) = (&AtmosphereProfile::general(), DEFAULT_GROUND_ALBEDO);
    let places: Vec<Conditions> = TURBIDITIES
        .into_iter()
        .flat_map(|t| ALTITUDES_KM.map(|h| (t, h)))
        .flat_map(|(t, h)| SUNS_DEG.map(|s| conditions(h, t, s)))
        .collect();
    let of = |sky: &dyn SkyModel| cases(sky, &places, STRIDE, SEED, &|| ());
    let whole = of(&whole_truth(profile, albedo)?)?;
    let table = of(&UtmSky::embedded()?)?;
    let seen = TERMS
        .into_iter()
        .map(|(name, term)| {
            let seen = match term {
                Term::Air(air) => {
                    let sky = without(profile, albedo, air)?;
                    row(name, &whole, &other_skies(&sky, &whole)?)
                }
                Term::OrdersAfter(last) => {
                    let settings = TransportSettings {
                        last_order: Some(last),
                        ..TransportSettings::default()
                    };
                    let sky = whole_truth(profile, albedo)?.with_transport_settings(settings);
                    row(name, &whole, &other_skies(&sky, &whole)?)
                }
                Term::Curvature => {
                    let sky = Flat(whole_truth(profile, albedo)?);
                    row(name, &whole, &other_skies(&sky, &whole)?)
                }
                _ => {
                    let sky = UtmSky::embedded()?;
                    row(name, &table, &lights(&Cut { sky, term }, &table)?)
                }
            };
            progress.step();
            seen
        })
        .collect();
    progress.end();
    seen
}

/// The ledger for people, and as CSV.
///
/// # Errors
/// Never: texts take everything.
pub fn tables(ledger: &[Seen]) -> Result<(String, String)> {
    let mut text = format!(
        "{:<24} {:>10} {:>10} {:>8} {:>8} {:>8} {:>8}   worst at\n",
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
        writeln!(
            text,
            "{:<24} {:>8.1} % {:>8.1} % {:>8.2} {:>8.2} {:>8.2} {:>6.2} %   {h:.1} km, T {t:.2}, sun {s:.1} deg",
            seen.term,
            100.0 * seen.directions_seen,
            100.0 * seen.cases_seen,
            seen.delta_e_median,
            seen.delta_e_p95,
            seen.delta_e_max,
            100.0 * seen.luminance_p95,
        )?;
        writeln!(
            csv,
            "{},{:.4},{:.4},{:.4},{:.4},{:.4},{:.5},{h:.3},{t:.3},{s:.3}",
            seen.term,
            seen.directions_seen,
            seen.cases_seen,
            seen.delta_e_median,
            seen.delta_e_p95,
            seen.delta_e_max,
            seen.luminance_p95,
        )?;
    }
    text.push_str("directions, cases: share with CIEDE2000 above 1 when the term is left out\n");
    Ok((text, csv))
}
