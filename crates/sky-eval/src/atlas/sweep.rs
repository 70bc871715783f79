//! The sweep: every condition of the domain and beyond it, the directions of each, and what is asked
//! of every light. Nothing here knows a model's weak places; it is dense where formulas break.

use rayon::prelude::*;
use sky_core::aerial::{AerialFrame, path_meets_ground};
use sky_core::color::{XYZ_FROM_LINEAR_SRGB, Yxy};
use sky_core::conditions::{Conditions, Domain};
use sky_core::direction::{SkyDirection, horizon_zenith};
use sky_core::extended::Coefficients;
use sky_core::quantity::{Angle, EARTH_RADIUS_KM, Length, single};
use sky_core::utm_sky::{SkyFrame, UtmSky};
use sky_science::sky_model::SkyError;

use super::kind::{Arithmetic, Kind, Place, Tallies, With};
use super::subject::{Density, Subject};
use crate::cases::conditions;
use crate::locus::Locus;
use crate::twin::{in_f64, rounded_to_f16, with_coefficients};

/// What is swept, whatever a model claims \[km, 1, deg\].
pub const SWEPT: Domain = Domain {
    altitude_km: [-0.5, 36.0],
    turbidity: [0.8, 12.0],
    sun_zenith_deg: [0.0, 108.0],
    below_horizontal: true,
};

/// Step of a direction that must not show \[deg\].
const STEP_DEG: f64 = 0.01;
/// Step of altitude that must not show \[km\].
const STEP_KM: f64 = 0.01;
/// Within this of the geometric horizon a model may answer or not \[deg\].
pub(super) const EDGE_DEG: f64 = 1e-3;
/// Every so many directions are also computed in other numbers.
const TWIN_STRIDE: usize = 4;

/// Between the haze and the top, by day, the zenith darkens with altitude.
const ABOVE_HAZE_KM: f64 = 6.0;
const BY_DAY_DEG: f64 = 85.0;

/// Columns and rows of the maps: sun zenith angle, altitude and view zenith angle in equal steps.
pub const SUN_BINS: usize = 36;
/// See [`SUN_BINS`].
pub const ALTITUDE_BINS: usize = 25;
/// See [`SUN_BINS`].
pub const VIEW_BINS: usize = 60;

/// A bit of a map's cell: some sample lies here.
pub const ASKED: u32 = 1 << 31;
/// A bit of a map's cell: some sample was answered.
pub const ANSWERED: u32 = 1 << 30;

/// What a sweep found.
#[derive(Clone, Debug)]
pub struct Findings {
    /// Counts and worst cases.
    pub tallies: Tallies,
    /// Kinds of failure as bits, `altitude * SUN_BINS + sun`.
    pub altitude_map: Vec<u32>,
    /// Kinds of failure as bits, `sun * VIEW_BINS + view`.
    pub view_map: Vec<u32>,
}

impl Default for Findings {
    fn default() -> Self {
        Self {
            tallies: Tallies::default(),
            altitude_map: vec![0; ALTITUDE_BINS * SUN_BINS],
            view_map: vec![0; SUN_BINS * VIEW_BINS],
        }
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "clamped to the bins"
)]
fn bin(value: f64, [low, high]: [f64; 2], bins: usize) -> usize {
    let share = ((value - low) / (high - low)).clamp(0.0, 1.0);
    let bins_f64 = f64::from(u32::try_from(bins).unwrap_or(u32::MAX));
    ((share * bins_f64) as usize).min(bins - 1)
}

impl Findings {
    fn add(&mut self, other: &Self) {
        self.tallies.add(&other.tallies);
        for (to, from) in [
            (&mut self.altitude_map, &other.altitude_map),
            (&mut self.view_map, &other.view_map),
        ] {
            for (to, from) in to.iter_mut().zip(from) {
                *to |= from;
            }
        }
    }

    fn mark(&mut self, conditions: &Conditions, direction: &SkyDirection, bits: u32) {
        let sun = bin(
            conditions.sun_zenith.degrees(),
            SWEPT.sun_zenith_deg,
            SUN_BINS,
        );
        let altitude = bin(
            conditions.observer_altitude.km(),
            SWEPT.altitude_km,
            ALTITUDE_BINS,
        );
        let view = bin(direction.view_zenith.degrees(), [0.0, 180.0], VIEW_BINS);
        self.altitude_map[altitude * SUN_BINS + sun] |= bits;
        self.view_map[sun * VIEW_BINS + view] |= bits;
    }
}

/// What is the same for all conditions.
struct Sweeper<'a> {
    subject: &'a Subject,
    locus: Locus,
    density: Density,
}

/// Evenly spread values, nodes and what lies a hair beside them, sorted.
fn values(span: [f64; 2], count: u16, nodes: &[f64], bounds: [f64; 2], hair: f64) -> Vec<f64> {
    let mut out: Vec<f64> = (0..=count)
        .map(|i| span[0] + (span[1] - span[0]) * f64::from(i) / f64::from(count))
        .collect();
    out.extend(nodes.iter().flat_map(|n| [n - hair, *n, n + 0.37 * hair]));
    out.extend(bounds.iter().flat_map(|b| [b - 1e-6, *b, b + 1e-6]));
    out.retain(|v| (span[0]..=span[1]).contains(v));
    out.sort_by(f64::total_cmp);
    out.dedup_by(|b, a| (*a - *b).abs() < 1e-12);
    out
}

/// Conditions that no model can answer for.
fn senseless() -> Vec<Conditions> {
    let mut out = Vec::new();
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1e300, 1e300] {
        out.push(conditions(bad, 2.0, 45.0));
        out.push(conditions(1.0, bad, 45.0));
        out.push(conditions(1.0, 2.0, bad));
    }
    out
}

/// Whether a direction shows sky.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Cover {
    Sky,
    Edge,
    Below,
}

fn cover(zenith_deg: f64, horizon_deg: f64) -> Cover {
    if zenith_deg < horizon_deg - EDGE_DEG {
        Cover::Sky
    } else if zenith_deg > horizon_deg + EDGE_DEG {
        Cover::Below
    } else {
        Cover::Edge
    }
}

/// View zenith and relative azimuth \[deg\] for an observer and sun; `turn` shifts the evenly spread
/// ones, so that frames do not share them.
fn places(horizon: f64, sun: f64, density: Density, turn: f64) -> Vec<[f64; 2]> {
    let n = f64::from(density.zeniths);
    let mut zeniths: Vec<f64> = (0..density.zeniths)
        .map(|i| horizon * (f64::from(i) + turn) / n)
        .collect();
    zeniths.extend([0.0, 0.002, 89.99, 89.9999, 90.0, 90.0001, 90.01]);
    zeniths.extend([0.0, 0.002, 0.02, 0.4].map(|above| horizon - above));
    zeniths.extend([0.002, 0.3, 5.0, 40.0].map(|below| horizon + below));
    zeniths.push(180.0);
    let n = f64::from(density.azimuths);
    let mut azimuths: Vec<f64> = (0..density.azimuths)
        .map(|i| 180.0 * (f64::from(i) + turn) / n)
        .collect();
    azimuths.extend([0.0, 0.003, 2.0, 178.0, 179.997, 180.0]);
    let mut out: Vec<[f64; 2]> = zeniths
        .iter()
        .flat_map(|z| azimuths.iter().map(|a| [*z, *a]))
        .collect();
    // the sun and the point opposite
    for (zenith, azimuth) in [(sun, 0.0), (180.0 - sun, 180.0)] {
        for d in [0.0, 1e-5, 1e-3, 0.03, 0.3, 2.0] {
            out.extend([
                [zenith + d, azimuth],
                [zenith - d, azimuth],
                [zenith, (azimuth - d).abs()],
            ]);
        }
    }
    out.retain(|[z, _]| (0.0..=180.0).contains(z));
    out
}

/// Directions asked at a place: itself, down, up, right, left, and its mirror image.
const FAN: usize = 6;

fn fan([zenith, azimuth]: [f64; 2]) -> [SkyDirection; FAN] {
    let at = SkyDirection::from_degrees;
    let across = STEP_DEG / Angle::from_degrees(zenith).radians().sin().max(1e-3);
    let up = if zenith >= STEP_DEG {
        at(zenith - STEP_DEG, azimuth)
    } else {
        // over the zenith
        at(STEP_DEG - zenith, azimuth + 180.0)
    };
    [
        at(zenith, azimuth),
        at((zenith + STEP_DEG).min(180.0), azimuth),
        up,
        at(zenith, azimuth + across),
        at(zenith, azimuth - across),
        at(zenith, -azimuth),
    ]
}

/// What the slope of the logarithm does not explain of a change: large at a step or a bend, small
/// where a value changes smoothly, however fast. Infinite where the sign changes.
fn bend(before: f64, here: f64, after: f64) -> f64 {
    if before * here > 0.0 && here * after > 0.0 {
        (before / here * (after / here)).ln().abs()
    } else if before.abs() + here.abs() + after.abs() > 0.0 {
        f64::INFINITY
    } else {
        0.0
    }
}

fn luminance_of(rgb: [f32; 3]) -> f64 {
    let row = XYZ_FROM_LINEAR_SRGB[1];
    rgb.iter().zip(row).map(|(c, w)| f64::from(*c) * w).sum()
}

pub(super) fn is_finite(light: &Yxy) -> bool {
    light.luminance_cd_m2.is_finite() && light.x.is_finite() && light.y.is_finite()
}

/// Difference as a share of the larger.
fn relative(a: f64, b: f64) -> f64 {
    let larger = a.abs().max(b.abs());
    if larger > 0.0 {
        (a - b).abs() / larger
    } else {
        0.0
    }
}

/// Difference of two lights: share of luminance, or of x or y.
pub(super) fn difference(a: &Yxy, b: &Yxy) -> f64 {
    relative(a.luminance_cd_m2, b.luminance_cd_m2)
        .max((a.x - b.x).abs())
        .max((a.y - b.y).abs())
}

impl Subject {
    /// Sweeps the model. `done` is told of each of [`Self::columns`].
    pub fn sweep(&self, density: Density, done: &(dyn Fn() + Sync)) -> Findings {
        sweep(self, density, done)
    }

    /// Steps that a sweep tells of.
    #[must_use]
    pub fn columns(&self, density: Density) -> usize {
        columns(self, density)
    }
}

/// Lengths of paths in a direction \[km\], as far as they and their neighbors meet no ground.
fn path_distances(zenith_deg: f64, altitude_km: f64, rays: [[f32; 3]; 3]) -> Vec<f64> {
    let mut distances = vec![0.0, 1e-3, 0.03, 0.5, 3.0, 20.0, 100.0, 400.0, 1000.0];
    if zenith_deg > 90.0 {
        // where the path is back at the observer's altitude
        let cosine = Angle::from_degrees(zenith_deg).radians().cos();
        distances.push(-2.0 * (EARTH_RADIUS_KM + altitude_km) * cosine);
    }
    distances.retain(|d| *d <= 1000.0);
    distances.sort_by(f64::total_cmp);
    distances.retain(|distance| {
        rays.iter()
            .all(|ray| !path_meets_ground(single(altitude_km), *ray, single(*distance)))
    });
    distances
}

/// How far transmittances are from what they can be: a share, not more than nearer, and all of it
/// without a path.
fn transmittance_error(found: [f32; 4], nearer: [f32; 4], distance_km: f64) -> f32 {
    found
        .iter()
        .zip(nearer)
        .map(|(t, nearer)| {
            let full = if distance_km > 0.0 { 0.0 } else { 1.0 - t };
            (t - nearer).max(-t).max(full)
        })
        .fold(0.0, f32::max)
}

/// Sweeps a model. `done` is told of each of [`columns`].
fn sweep(subject: &Subject, density: Density, done: &(dyn Fn() + Sync)) -> Findings {
    let sweeper = Sweeper {
        subject,
        locus: Locus::new(),
        density,
    };
    let (altitudes, turbidities, suns) = sweeper.axes();
    let columns: Vec<(f64, f64)> = altitudes
        .iter()
        .flat_map(|a| turbidities.iter().map(|t| (*a, *t)))
        .collect();
    let mut found: Vec<Findings> = columns
        .par_iter()
        .enumerate()
        .map(|(i, (altitude, turbidity))| {
            let mut findings = Findings::default();
            for (k, sun) in suns.iter().enumerate() {
                let turn = golden(i * suns.len() + k);
                sweeper.conditions(
                    &mut findings,
                    &conditions(*altitude, *turbidity, *sun),
                    turn,
                );
            }
            done();
            findings
        })
        .collect();
    found.push(sweeper.senseless());
    found.extend(sweeper.between_nodes(&turbidities, &suns));
    found.extend(sweeper.rising(&turbidities, &suns));
    found.extend(sweeper.paths(&turbidities, &suns));
    let mut all = Findings::default();
    for findings in &found {
        all.add(findings);
    }
    all
}

/// Columns of a sweep, for the progress bar.
fn columns(subject: &Subject, density: Density) -> usize {
    let sweeper = Sweeper {
        subject,
        locus: Locus::new(),
        density,
    };
    let (altitudes, turbidities, _) = sweeper.axes();
    altitudes.len() * turbidities.len()
}

/// The fraction of multiples of the golden section: evenly spread, never the same.
fn golden(index: usize) -> f64 {
    let index = f64::from(u32::try_from(index).unwrap_or(u32::MAX));
    (index * 0.618_033_988_749_895).fract()
}

impl Sweeper<'_> {
    fn axes(&self) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
        let domain = self.subject.model().domain();
        let nodes = &self.subject.nodes;
        let d = self.density;
        (
            values(
                SWEPT.altitude_km,
                d.altitudes,
                &nodes.altitude_km,
                domain.altitude_km,
                0.005,
            ),
            values(
                SWEPT.turbidity,
                d.turbidities,
                &nodes.turbidity,
                domain.turbidity,
                1e-6,
            ),
            values(
                SWEPT.sun_zenith_deg,
                d.suns,
                &nodes.sun_zenith_deg,
                domain.sun_zenith_deg,
                1e-4,
            ),
        )
    }

    fn ask(
        &self,
        conditions: &Conditions,
        directions: &[SkyDirection],
    ) -> Result<Vec<Yxy>, SkyError> {
        self.subject.model().yxy_map(conditions, directions)
    }

    fn frame(&self, conditions: &Conditions) -> Option<(SkyFrame, Coefficients)> {
        let frame = self.subject.table()?.frame(conditions).ok()?;
        let coefficients = *frame.coefficients();
        Some((frame, coefficients))
    }

    fn senseless(&self) -> Findings {
        let mut findings = Findings::default();
        let direction = SkyDirection::from_degrees(40.0, 60.0);
        for conditions in senseless() {
            let answered = self.ask(&conditions, &[direction]).is_ok();
            let place = || Place {
                conditions,
                direction,
                with: With::Nothing,
            };
            findings.tallies.record(
                self.subject.arithmetic,
                Kind::SilentOutside,
                false,
                f64::from(u8::from(answered)),
                place,
            );
        }
        findings
    }

    /// All that is asked under one set of conditions.
    fn conditions(&self, findings: &mut Findings, conditions: &Conditions, turn: f64) {
        let domain = self.subject.model().domain();
        let inside = domain.check(conditions).is_ok();
        let horizon = horizon_zenith(conditions.observer_altitude).degrees();
        let sun = conditions.sun_zenith.degrees();
        let places = places(horizon, sun, self.density, turn);
        let lowest = domain.lowest_view_zenith_deg(conditions.observer_altitude);
        let mut directions = Vec::with_capacity(FAN * places.len());
        for place in &places {
            directions.extend(fan(*place));
        }
        let Ok(lights) = self.ask(conditions, &directions) else {
            let kind = if inside {
                Kind::RefusedInside
            } else {
                Kind::SilentOutside
            };
            for direction in directions.iter().step_by(FAN) {
                let place = || Place {
                    conditions: *conditions,
                    direction: *direction,
                    with: With::Nothing,
                };
                let score = f64::from(u8::from(inside));
                let failed =
                    findings
                        .tallies
                        .record(self.subject.arithmetic, kind, inside, score, place);
                let bits = if failed { 1 << kind as u32 } else { 0 };
                findings.mark(conditions, direction, ASKED | bits);
            }
            return;
        };
        for (fan, lights) in directions.chunks_exact(FAN).zip(lights.chunks_exact(FAN)) {
            self.place(findings, conditions, fan, lights, [horizon, lowest], inside);
        }
        self.altitude_step(findings, conditions, &directions, &lights, inside);
        self.twins(findings, conditions, &directions, &lights, lowest);
    }

    /// One place: is its light a light, and does it agree with its neighbors'?
    fn place(
        &self,
        findings: &mut Findings,
        conditions: &Conditions,
        directions: &[SkyDirection],
        lights: &[Yxy],
        [horizon, lowest]: [f64; 2],
        conditions_inside: bool,
    ) {
        let arithmetic = self.subject.arithmetic;
        let direction = directions[0];
        let zenith = direction.view_zenith.degrees();
        let seen = cover(zenith, horizon);
        let inside = conditions_inside && zenith <= lowest + EDGE_DEG;
        let mut bits = ASKED;
        let mut record =
            |tallies: &mut Tallies, kind: Kind, inside: bool, score, at: [usize; 2]| {
                let place = || Place {
                    conditions: *conditions,
                    direction: directions[at[0]],
                    with: if at[1] > 0 {
                        With::Direction(directions[at[1]])
                    } else {
                        With::Nothing
                    },
                };
                if tallies.record(arithmetic, kind, inside, score, place) {
                    bits |= 1 << kind as u32;
                }
            };
        let t = &mut findings.tallies;
        let dark = |light: &Yxy| *light == Yxy::default();
        let answered = !dark(&lights[0]);
        let score = f64::from(u8::from(answered));
        if !inside {
            record(t, Kind::SilentOutside, false, score, [0, 0]);
        } else if zenith < lowest - EDGE_DEG {
            record(t, Kind::RefusedInside, true, 1.0 - score, [0, 0]);
        }
        for (k, light) in lights.iter().enumerate().filter(|(_, l)| !dark(l)) {
            let inside =
                conditions_inside && directions[k].view_zenith.degrees() <= lowest + EDGE_DEG;
            let finite = is_finite(light);
            let score = f64::from(u8::from(!finite));
            record(t, Kind::NotFinite, inside, score, [k, 0]);
            if finite {
                let below_zero = -light.luminance_cd_m2;
                record(t, Kind::NegativeLuminance, inside, below_zero, [k, 0]);
                let beyond = self.locus.outside(light.x, light.y);
                record(t, Kind::OutsideLocus, inside, beyond, [k, 0]);
            }
        }
        if answered {
            let light = &lights[0];
            if is_finite(light) {
                let luminance = light.luminance_cd_m2;
                // up and down, right and left
                for pair in [1, 3] {
                    let sides = [&lights[pair], &lights[pair + 1]];
                    let same = directions[pair..pair + 2].iter().all(|d| {
                        let other = d.view_zenith.degrees();
                        cover(other, horizon) == seen && (other <= lowest) == (zenith <= lowest)
                    });
                    if same && sides.iter().all(|l| !dark(l) && is_finite(l)) {
                        let values = sides.map(|l| l.luminance_cd_m2);
                        let score = bend(values[0], luminance, values[1]);
                        record(t, Kind::JumpDirection, inside, score, [0, pair]);
                        let steep = values.map(|v| relative(luminance, v));
                        let score = steep[0].max(steep[1]);
                        record(t, Kind::SteepDirection, inside, score, [0, pair]);
                    }
                }
                if is_finite(&lights[5]) {
                    let score = difference(light, &lights[5]);
                    record(t, Kind::Asymmetry, inside, score, [0, 5]);
                }
            }
            bits |= ANSWERED;
        }
        findings.mark(conditions, &direction, bits);
    }

    /// The same directions 10 m higher and lower.
    fn altitude_step(
        &self,
        findings: &mut Findings,
        conditions: &Conditions,
        directions: &[SkyDirection],
        lights: &[Yxy],
        inside: bool,
    ) {
        let domain = self.subject.model().domain();
        let here = conditions.observer_altitude.km();
        let lower = Length::from_km(here - STEP_KM);
        let lowest = if domain.below_horizontal {
            horizon_zenith(lower).degrees() - EDGE_DEG
        } else {
            90.0
        };
        let (bases, middle): (Vec<SkyDirection>, Vec<&Yxy>) = directions
            .iter()
            .zip(lights)
            .step_by(FAN)
            .filter(|(d, light)| d.view_zenith.degrees() < lowest && is_finite(light))
            .unzip();
        let at = |km: f64| {
            let observer_altitude = Length::from_km(km);
            let stepped = Conditions {
                observer_altitude,
                ..*conditions
            };
            self.ask(&stepped, &bases)
        };
        let (Ok(below), Ok(above)) = (at(here - STEP_KM), at(here + STEP_KM)) else {
            return;
        };
        for (k, direction) in bases.iter().enumerate() {
            let [low, middle, high] = [&below[k], middle[k], &above[k]];
            if !(is_finite(low) && is_finite(high)) {
                continue;
            }
            let [low, middle, high] = [low, middle, high].map(|l| l.luminance_cd_m2);
            let place = || Place {
                conditions: *conditions,
                direction: *direction,
                with: With::Nodes([here - STEP_KM, here + STEP_KM]),
            };
            let steep = relative(low, middle).max(relative(middle, high));
            for (kind, score) in [
                (Kind::JumpAltitude, bend(low, middle, high)),
                (Kind::SteepAltitude, steep),
            ] {
                if findings
                    .tallies
                    .record(self.subject.arithmetic, kind, inside, score, place)
                {
                    findings.mark(conditions, direction, 1 << kind as u32);
                }
            }
        }
    }

    /// The same formula in double precision, and with coefficients in half precision.
    fn twins(
        &self,
        findings: &mut Findings,
        conditions: &Conditions,
        directions: &[SkyDirection],
        lights: &[Yxy],
        lowest: f64,
    ) {
        let Some((frame, coefficients)) = self.frame(conditions) else {
            return;
        };
        let rounded = rounded_to_f16(&coefficients);
        for (direction, light) in directions
            .iter()
            .zip(lights)
            .step_by(FAN)
            .step_by(TWIN_STRIDE)
            .filter(|(d, _)| d.view_zenith.degrees() < lowest - EDGE_DEG)
        {
            let place = || Place {
                conditions: *conditions,
                direction: *direction,
                with: With::Nothing,
            };
            let double = in_f64(&coefficients, direction, conditions);
            let half = with_coefficients(&rounded, frame.radii(), direction, conditions);
            for (arithmetic, twin) in [(Arithmetic::CpuF64, double), (Arithmetic::F16Table, half)] {
                let t = &mut findings.tallies;
                let finite = is_finite(&twin);
                let score = f64::from(u8::from(!finite));
                t.record(arithmetic, Kind::NotFinite, true, score, place);
                if finite {
                    let beyond = self.locus.outside(twin.x, twin.y);
                    t.record(arithmetic, Kind::OutsideLocus, true, beyond, place);
                    let score = difference(light, &twin);
                    if t.record(arithmetic, Kind::Precision, true, score, place)
                        && arithmetic == Arithmetic::CpuF64
                    {
                        findings.mark(conditions, direction, 1 << Kind::Precision as u32);
                    }
                }
            }
        }
    }

    /// Between two altitude nodes, against the skies of both.
    fn between_nodes(&self, turbidities: &[f64], suns: &[f64]) -> Vec<Findings> {
        let domain = self.subject.model().domain();
        let nodes = &self.subject.nodes.altitude_km;
        let pairs: Vec<([f64; 2], f64)> = nodes
            .windows(2)
            .flat_map(|w| turbidities.iter().map(|t| ([w[0], w[1]], *t)))
            .collect();
        let directions: Vec<SkyDirection> = [0.0, 30.0, 55.0, 75.0, 85.0, 89.0, 89.9]
            .iter()
            .flat_map(|z| {
                [0.0, 15.0, 60.0, 110.0, 180.0].map(|a| SkyDirection::from_degrees(*z, a))
            })
            .collect();
        pairs
            .par_iter()
            .map(|([low, high], turbidity)| {
                let mut findings = Findings::default();
                for sun in suns {
                    let at = |km: f64| self.ask(&conditions(km, *turbidity, *sun), &directions);
                    let (Ok(lower), Ok(upper)) = (at(*low), at(*high)) else {
                        continue;
                    };
                    for i in 1..=self.density.between {
                        let share = f64::from(i) / f64::from(self.density.between + 1);
                        let altitude = low + share * (high - low);
                        let here = conditions(altitude, *turbidity, *sun);
                        let Ok(middle) = self.ask(&here, &directions) else {
                            continue;
                        };
                        for (k, light) in middle.iter().enumerate() {
                            let ends = [lower[k], upper[k]].map(|l| l.luminance_cd_m2);
                            let (least, most) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
                            if !(least > 0.0 && most.is_finite() && is_finite(light)) {
                                continue;
                            }
                            let found = light.luminance_cd_m2;
                            let score = (found / most - 1.0).max(1.0 - found / least).max(0.0);
                            let place = || Place {
                                conditions: here,
                                direction: directions[k],
                                with: With::Nodes([*low, *high]),
                            };
                            let inside = domain.check(&here).is_ok();
                            let kind = Kind::Overshoot;
                            if findings.tallies.record(
                                self.subject.arithmetic,
                                kind,
                                inside,
                                score,
                                place,
                            ) {
                                findings.mark(&here, &directions[k], 1 << kind as u32);
                            }
                        }
                    }
                }
                findings
            })
            .collect()
    }

    /// The zenith by day, from above the haze to the top.
    fn rising(&self, turbidities: &[f64], suns: &[f64]) -> Vec<Findings> {
        const STEPS: u16 = 300;
        let zenith = SkyDirection::from_degrees(0.0, 0.0);
        turbidities
            .par_iter()
            .map(|turbidity| {
                let mut findings = Findings::default();
                for sun in suns.iter().filter(|s| **s <= BY_DAY_DEG) {
                    let mut below: Option<(f64, f64)> = None;
                    for i in 0..=STEPS {
                        let altitude = ABOVE_HAZE_KM + 0.1 * f64::from(i);
                        let here = conditions(altitude, *turbidity, *sun);
                        let Ok(light) = self.ask(&here, &[zenith]) else {
                            break;
                        };
                        let found = light[0].luminance_cd_m2;
                        if let Some((km, before)) = below
                            && before > 0.0
                        {
                            let place = || Place {
                                conditions: here,
                                direction: zenith,
                                with: With::Altitude(km),
                            };
                            let inside = self.subject.model().domain().check(&here).is_ok();
                            let kind = Kind::RisingZenith;
                            let score = found / before - 1.0;
                            if findings.tallies.record(
                                self.subject.arithmetic,
                                kind,
                                inside,
                                score,
                                place,
                            ) {
                                findings.mark(&here, &zenith, 1 << kind as u32);
                            }
                        }
                        below = Some((altitude, found));
                    }
                }
                findings
            })
            .collect()
    }

    /// Finite paths, for tables that know the air's extinction.
    fn paths(&self, turbidities: &[f64], suns: &[f64]) -> Vec<Findings> {
        let Some(sky) = self.subject.table() else {
            return Vec::new();
        };
        turbidities
            .par_iter()
            .map(|turbidity| {
                let mut findings = Findings::default();
                for sun in suns {
                    self.paths_under(&mut findings, sky, *turbidity, *sun);
                }
                findings
            })
            .collect()
    }

    fn paths_under(&self, findings: &mut Findings, sky: &UtmSky, turbidity: f64, sun: f64) {
        let domain = self.subject.model().domain();
        let ground = conditions(domain.altitude_km[0], turbidity, sun);
        let inside = domain.check(&ground).is_ok();
        let air = AerialFrame::new(sky, turbidity, ground.sun_zenith);
        let (true, Ok(air)) = (inside, &air) else {
            let kind = if inside {
                Kind::RefusedInside
            } else {
                Kind::SilentOutside
            };
            let place = || Place {
                conditions: ground,
                direction: SkyDirection::from_degrees(90.0, 0.0),
                with: With::Path(1.0),
            };
            // wrong is no answer inside, and an answer outside
            let score = f64::from(u8::from(inside || air.is_ok()));
            findings
                .tallies
                .record(self.subject.arithmetic, kind, inside, score, place);
            return;
        };
        let n = f64::from(self.density.between);
        let mut altitudes = vec![0.0, 0.002, 0.3, 1.0, 5.5, 12.0, 30.0];
        altitudes.extend((0..self.density.between).map(|i| 30.0 * (f64::from(i) + 0.5) / n));
        altitudes.retain(|h| (domain.altitude_km[0]..=domain.altitude_km[1]).contains(h));
        for altitude in altitudes {
            let horizon = horizon_zenith(Length::from_km(altitude)).degrees();
            let mut zeniths = vec![
                0.0,
                45.0,
                85.0,
                89.99,
                90.0,
                90.0001,
                horizon - 0.01,
                horizon + 1.0,
                130.0,
                180.0,
            ];
            zeniths.push(sun);
            for zenith in zeniths {
                for azimuth in [0.0, 70.0, 180.0] {
                    let here = conditions(altitude, turbidity, sun);
                    self.paths_along(findings, air, &here, [zenith, azimuth]);
                }
            }
        }
    }

    /// Paths of growing length in one direction.
    fn paths_along(
        &self,
        findings: &mut Findings,
        air: &AerialFrame,
        here: &Conditions,
        [zenith, azimuth]: [f64; 2],
    ) {
        let altitude = here.observer_altitude.km();
        let direction = SkyDirection::from_degrees(zenith, azimuth);
        let toward = direction.unit_vector();
        let mirrored = SkyDirection::from_degrees(zenith, -azimuth).unit_vector();
        let sides = [STEP_DEG, -STEP_DEG]
            .map(|step| SkyDirection::from_degrees(zenith + step, azimuth).unit_vector());
        let height = single(altitude);
        let distances = path_distances(zenith, altitude, [toward, sides[0], sides[1]]);
        let light_at = |direction, distance: f64| {
            luminance_of(air.path(height, direction, single(distance)).inscatter)
        };
        // the light of a meter of air is all rounding: a share of the sky's is the least that counts
        let skyward = SkyDirection::from_degrees(zenith.min(180.0 - zenith), azimuth);
        let longest = distances
            .last()
            .map_or(0.0, |d| light_at(toward, *d))
            .max(0.01 * light_at(skyward.unit_vector(), 100.0));
        let share = |difference: f64, light: f64| {
            let whole = light.max(longest);
            if whole > 0.0 {
                difference.abs() / whole
            } else {
                0.0
            }
        };
        let mut last = [1.0_f32; 4];
        for distance in distances {
            let reach = single(distance);
            let place = || Place {
                conditions: *here,
                direction,
                with: With::Path(distance),
            };
            let path = air.path(height, toward, reach);
            let finite = path.transmittance.iter().all(|t| t.is_finite())
                && path.inscatter.iter().all(|c| c.is_finite());
            let t = &mut findings.tallies;
            let mut record = |kind: Kind, score: f64| {
                if t.record(self.subject.arithmetic, kind, true, score, place) {
                    1 << kind as u32
                } else {
                    0
                }
            };
            let mut bits = record(Kind::PathNotFinite, f64::from(u8::from(!finite)));
            if finite {
                let least = path.inscatter.iter().copied().fold(f32::INFINITY, f32::min);
                bits |= record(Kind::PathNegative, f64::from(-least));
                let wrong = transmittance_error(path.transmittance, last, distance);
                let light = luminance_of(path.inscatter);
                let unlit = if distance > 0.0 { 0.0 } else { light };
                bits |= record(Kind::PathTransmittance, f64::from(wrong).max(unlit));
                last = path.transmittance;
                let [down, up] = sides.map(|d| light_at(d, distance));
                let bent = bend(down, light, up).min(1.0) * light;
                bits |= record(Kind::PathJump, share(bent, light));
                let mirror = light_at(mirrored, distance);
                bits |= record(Kind::PathAsymmetry, share(light - mirror, light));
            }
            if bits != 0 {
                findings.mark(here, &direction, bits);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_hold_nodes_bounds_and_what_lies_beside_them() {
        let axis = values([0.0, 108.0], 9, &[0.0, 90.0, 96.0], [0.0, 96.0], 1e-4);
        for value in [0.0, 36.0, 90.0, 90.0 - 1e-4, 96.0, 96.0 + 1e-6, 108.0] {
            assert!(axis.iter().any(|v| (v - value).abs() < 1e-9), "{value}");
        }
        assert!(axis.windows(2).all(|w| w[0] < w[1]));
    }

    #[test]
    fn bins_cover_the_sweep() {
        assert_eq!(bin(0.0, [0.0, 108.0], SUN_BINS), 0);
        assert_eq!(bin(108.0, [0.0, 108.0], SUN_BINS), SUN_BINS - 1);
        assert_eq!(bin(54.1, [0.0, 108.0], SUN_BINS), 18);
    }

    #[test]
    fn directions_hold_the_sun_the_horizontal_and_the_horizon() {
        let horizon = horizon_zenith(Length::from_km(6.0)).degrees();
        let all = places(horizon, 40.0, Density::QUICK, 0.3);
        for place in [
            [0.0, 0.0],
            [90.0, 180.0],
            [40.0, 0.0],
            [horizon, 0.0],
            [180.0, 0.0],
        ] {
            assert!(all.contains(&place), "{place:?}");
        }
    }
}
