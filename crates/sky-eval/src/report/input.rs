//! What a report is made from.

use sky_core::conditions::Conditions;
use sky_science::sky_model::SkyModel;
use sky_sim::profile::AtmosphereProfile;

use super::wavelengths::WavelengthRow;
use crate::cases::{CaseCounts, Nodes};
use crate::ledger::Seen;
use crate::truth::TransportSky;

/// A sky to judge.
#[derive(Clone)]
pub struct NamedModel<'a> {
    /// Name for tables and legends.
    pub name: String,
    /// The sky.
    pub model: &'a dyn SkyModel,
    /// Nodes of its table; empty where it has none.
    pub nodes: Nodes,
}

impl std::fmt::Debug for NamedModel<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("NamedModel")
            .field("name", &self.name)
            .field("nodes", &self.nodes)
            .finish_non_exhaustive()
    }
}

/// How the fit of one channel went at a node.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelReport {
    /// Y, x or y.
    pub channel: &'static str,
    /// Root mean square of the residuals: of the logarithm for Y, of the chromaticity else.
    pub rms: f64,
    /// Why the solver stopped.
    pub why_stopped: String,
    /// Whether it stopped at a minimum.
    pub converged: bool,
    /// Condition number of the Jacobian; NaN if unknown.
    pub condition_number: f64,
    /// What else is to say: parameters at a bound, regularization; may be empty.
    pub note: String,
}

/// How the fits at a node went and how far they are from the truth there.
#[derive(Clone, Debug, PartialEq)]
pub struct CellReport {
    /// The node.
    pub conditions: Conditions,
    /// Its channels.
    pub channels: Vec<ChannelReport>,
    /// 95th percentile of ΔE at the node.
    pub delta_e_p95: f64,
    /// 95th percentile of the relative error of luminance at the node.
    pub luminance_p95: f64,
}

/// A figure that the report only passes on, such as the size of the table.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// What it is, with its unit.
    pub what: String,
    /// The figure.
    pub value: String,
    /// What is asked; empty for nothing.
    pub target: String,
    /// Whether it is met; `None` where nothing is asked.
    pub met: Option<bool>,
}

/// How much the report computes.
#[derive(Clone, Debug, PartialEq)]
pub struct ReportSettings {
    /// Turbidity of spectra, pictures and chromaticity paths.
    pub scene_turbidity: f64,
    /// Held-out cases.
    pub cases: CaseCounts,
    /// Turbidities of the graphs of error against altitude.
    pub sweep_turbidities: Vec<f64>,
    /// Sun zenith angles of those graphs \[deg\].
    pub sweep_suns_deg: Vec<f64>,
    /// Altitudes of those graphs, 0–30 km.
    pub sweep_altitudes: u8,
    /// Altitudes of the pictures \[km\].
    pub picture_altitudes_km: Vec<f64>,
    /// Sun zenith angles of the pictures \[deg\].
    pub picture_suns_deg: Vec<f64>,
    /// Sun positions of a chromaticity path, 0–96°.
    pub path_suns: u8,
}

impl Default for ReportSettings {
    /// The turbidities are those of the held-out sequence, so that none is solved for a picture alone.
    fn default() -> Self {
        Self {
            scene_turbidity: 2.75,
            cases: CaseCounts::default(),
            sweep_turbidities: vec![1.875, 4.5],
            sweep_suns_deg: vec![30.0, 75.0, 88.5],
            sweep_altitudes: 31,
            picture_altitudes_km: vec![0.0, 3.0, 12.0, 30.0],
            picture_suns_deg: vec![0.0, 60.0, 88.0, 92.0],
            path_suns: 33,
        }
    }
}

/// Everything that a report is made from.
#[derive(Clone, Copy, Debug)]
pub struct ReportInput<'a> {
    /// The atmosphere.
    pub profile: &'a AtmosphereProfile,
    /// What the fits are judged by.
    pub truth: &'a TransportSky,
    /// The skies to judge. The targets are asked of the first; its nodes decide on the held-out cases.
    pub fits: &'a [NamedModel<'a>],
    /// The nodes of the first fit's table.
    pub cells: &'a [CellReport],
    /// Color on coarse wavelengths against 1 nm, from [`super::wavelengths::convergence`]; may be empty.
    pub wavelengths: &'a [WavelengthRow],
    /// What each constituent of the air is worth, from [`crate::ledger::ledger`]; may be empty.
    pub ledger: &'a [Seen],
    /// Figures that the report passes on.
    pub figures: &'a [Figure],
    /// Where everything comes from: hash of the profile, settings, version.
    pub provenance: &'a [(String, String)],
    /// How much to compute.
    pub settings: &'a ReportSettings,
}
