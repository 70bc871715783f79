//! A model's errors and costs, and the parts of the cases in which they are taken.

use sky_core::conditions::Conditions;
use sky_core::direction::SkyDirection;

use crate::models::Model;

/// The renderer's default tier.
pub const DEFAULT_TIER: &str = "utm-sky-baked";

/// A part of the cases, by its name.
pub type Regime = (&'static str, fn(&Conditions, &SkyDirection) -> bool);

fn from_sun(c: &Conditions, d: &SkyDirection) -> f64 {
    d.scattering_angle(c.sun_zenith).degrees()
}

/// Every part.
pub const REGIMES: [Regime; 7] = [
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
pub struct Errors {
    /// Share of the directions that it answers for.
    pub valid_share: f64,
    /// ΔE: median and 95th percentile.
    pub delta_e: [f64; 2],
    /// Relative error of luminance, 95th percentile.
    pub luminance_p95: f64,
    /// Root mean square of the error of radiance \[mW·m⁻²·sr⁻¹·nm⁻¹\].
    pub rmse: f64,
    /// Luminance p95 after the best single factor for all maps.
    pub scaled_p95: f64,
    /// Share of lights that are negative or no number.
    pub failures: f64,
}

/// Costs of one model on a GPU; nothing where there is none, or no shader.
#[derive(Clone, Copy, Debug, Default)]
pub struct GpuCosts {
    /// Nanoseconds a pixel at 1920 × 1080 and at 3840 × 2160.
    pub ns: [Option<f64>; 2],
    /// The first over that of a constant color.
    pub ratio: Option<f64>,
}

/// Costs of one model.
#[derive(Clone, Copy, Debug, Default)]
pub struct Costs {
    /// A direction on the CPU \[ns\].
    pub cpu_ns: f64,
    /// On the GPU.
    pub gpu: GpuCosts,
    /// What belongs to a frame \[µs\].
    pub update_us: f64,
    /// What belongs to a new haze \[ms\].
    pub rebuild_ms: f64,
    /// Bytes of its tables.
    pub bytes: usize,
}

/// A model's row of the chart.
#[derive(Clone, Debug)]
pub struct Row {
    /// The model.
    pub model: Model,
    /// By part of the cases; `None` where it answers for none.
    pub errors: Vec<Option<Errors>>,
    /// Its costs.
    pub costs: Costs,
    /// By part: whether no model is both cheaper and closer.
    pub on_front: Vec<bool>,
}

/// A model is on the front of a regime where none is both cheaper on the GPU and closer to the truth.
pub fn mark_front(rows: &mut [Row]) {
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
#[must_use]
pub fn place(row: &Row, regime: usize) -> Option<[f64; 2]> {
    let error = row.errors[regime]?.delta_e[1];
    error.is_finite().then_some(())?;
    Some([row.costs.gpu.ns[0]?, error])
}
