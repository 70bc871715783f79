//! Plan files: a configuration as TOML, and the table that it makes.

use std::collections::BTreeMap;
use std::path::PathBuf;

use anyhow::{Context as _, Result, anyhow, bail};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use sky_core::axis::Axis;
use sky_core::conditions::Domain;
use sky_core::extended::TERM_NAMES;
use sky_core::lut::{
    CHANNELS, ErrorQuantiles, FitStatistics, Form, Interpolation, Lut, LutHeader, Storage,
};
use sky_core::utm_sky::UtmSky;
use sky_fit::sweep::{SkyMap, fit_turbidity};
use sky_science::sky_model::SkyModel;
use sky_sim::optics::WAVELENGTH_STEPS_NM;

use sky_eval::bake::statistics;
use sky_eval::constituents::{named, truth};
use sky_eval::profiles::NamedProfile;
use sky_eval::tiers::{BakedSky, DomeSky};
use sky_eval::truth::{DOMAIN, TransportSky};

use crate::scene::{Tolerance, range_within, within};
use crate::space::{Lattice, axes, by_altitude, ranges};

/// Three numbers or ranges, one an axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Axes<T> {
    /// Observer altitude \[km\].
    pub altitude_km: T,
    /// Turbidity.
    pub turbidity: T,
    /// Sun zenith angle \[deg\].
    pub sun_zenith_deg: T,
}

/// How the sky is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PlannedTier {
    /// A dome of 271 corners, blended between them.
    Vertex,
    /// A small texture, one fetch a pixel.
    Baked,
    /// The formula at every pixel.
    Fragment,
}

impl PlannedTier {
    /// Every tier, the cheapest first.
    pub const ALL: [Self; 3] = [Self::Vertex, Self::Baked, Self::Fragment];

    /// The name in files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Vertex => "vertex",
            Self::Baked => "baked",
            Self::Fragment => "fragment",
        }
    }

    /// A table's sky as this tier draws it.
    pub(crate) fn drawn(self, sky: UtmSky) -> Box<dyn SkyModel> {
        match self {
            Self::Vertex => Box::new(DomeSky::new(sky)),
            Self::Baked => Box::new(BakedSky::new(sky)),
            Self::Fragment => Box::new(sky),
        }
    }
}

/// Which aerial perspective.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PlannedAerial {
    /// The air before the farthest object cannot be seen.
    None,
    /// From the table.
    Default,
}

impl PlannedAerial {
    /// The name in files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Default => "default",
        }
    }
}

/// Whether a table's plan leaves the air between camera and scene out.
#[must_use]
pub fn without_aerial(header: &LutHeader) -> bool {
    header.planned("aerial") == Some(PlannedAerial::None.name())
}

/// Errors that the planner found on cases that the table was not fitted to.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Expected {
    /// Bytes of the table's file.
    pub bytes: usize,
    /// CIEDE2000: median.
    pub delta_e_median: f64,
    /// CIEDE2000: 95 % of directions below.
    pub delta_e_p95: f64,
    /// CIEDE2000: largest.
    pub delta_e_max: f64,
    /// Relative error of luminance: 95 % of directions below \[1\].
    pub luminance_p95: f64,
    /// Relative error of luminance: largest \[1\].
    pub luminance_max: f64,
}

/// A configuration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// Name of the scene.
    pub scene: String,
    /// The atmosphere: name or CSV file.
    pub profile: PathBuf,
    /// Albedo of the ground.
    pub ground_albedo: f64,
    /// Constituents of the air that take part.
    pub constituents: Vec<String>,
    /// Distance of the wavelengths \[nm\].
    pub wavelength_step_nm: u16,
    /// Products of the formula that are kept.
    pub terms: Vec<String>,
    /// How values are stored.
    pub storage: Storage,
    /// How the sky is drawn.
    pub tier: PlannedTier,
    /// Which aerial perspective.
    pub aerial: PlannedAerial,
    /// Where the table is valid: the scene's ranges.
    pub domain: Axes<[f64; 2]>,
    /// Nodes of the table.
    pub grid: Axes<Vec<f64>>,
    /// What was asked for.
    pub tolerance: Tolerance,
    /// What was found.
    pub expected: Expected,
}

impl Plan {
    /// From the text of a plan file; `name` goes before messages.
    ///
    /// # Errors
    /// Names file, field, what was expected and what was found.
    pub fn from_toml(name: &str, text: &str) -> Result<Self> {
        let plan: Self = toml::from_str(text).map_err(|e| anyhow!("{name}: {e}"))?;
        plan.check().map_err(|e| anyhow!("{name}: {e}"))?;
        Ok(plan)
    }

    /// As the text of a plan file.
    ///
    /// # Errors
    /// Never: a plan can be written.
    pub fn to_toml(&self) -> Result<String> {
        Ok(format!(
            "# Written by utm-sky plan; baked by utm-sky generate --plan.\n{}",
            toml::to_string(self)?
        ))
    }

    fn check(&self) -> Result<()> {
        let fields = ["altitude_km", "turbidity", "sun_zenith_deg"];
        let (domain, nodes) = (self.domain(), self.nodes());
        for (axis, field) in fields.into_iter().enumerate() {
            let bounds = ranges(&DOMAIN)[axis];
            let range = ranges(&domain)[axis];
            range_within(&format!("domain.{field}"), range, bounds)?;
            let found =
                Axis::new("1", nodes[axis].clone()).map_err(|e| anyhow!("grid.{field}: {e}"))?;
            let [first, last] = found.bounds();
            let holds = if found.len() == 1 {
                range[0] <= first && last <= range[1]
            } else {
                first <= range[0] && range[1] <= last
            };
            if !holds {
                bail!(
                    "grid.{field}: expected nodes that cover {} to {}, found {first} to {last}",
                    range[0],
                    range[1]
                );
            }
        }
        within("ground_albedo", self.ground_albedo, [0.0, 1.0])?;
        if !WAVELENGTH_STEPS_NM.contains(&self.wavelength_step_nm) {
            bail!(
                "wavelength_step_nm: expected 1, 5, 10 or 20, found {}",
                self.wavelength_step_nm
            );
        }
        self.term_places()?;
        named(&self.constituents).map(|_| ())
    }

    fn term_places(&self) -> Result<Vec<usize>> {
        let places = sky_core::extended::slots(&self.terms).filter(|p| !p.is_empty());
        places.with_context(|| {
            format!(
                "terms: expected some of {} in that order, found {}",
                TERM_NAMES.join(" "),
                self.terms.join(" ")
            )
        })
    }

    /// The scene's ranges.
    #[must_use]
    pub const fn domain(&self) -> Domain {
        Domain {
            altitude_km: self.domain.altitude_km,
            turbidity: self.domain.turbidity,
            sun_zenith_deg: self.domain.sun_zenith_deg,
            below_horizontal: true,
        }
    }

    /// Nodes of altitude, turbidity and sun zenith.
    fn nodes(&self) -> [Vec<f64>; 3] {
        let grid = &self.grid;
        [&grid.altitude_km, &grid.turbidity, &grid.sun_zenith_deg].map(Clone::clone)
    }

    /// The sky that the table is fitted to; `profile` is the plan's own.
    ///
    /// # Errors
    /// When the settings do not suit the profile.
    pub fn truth(&self, profile: &NamedProfile) -> Result<TransportSky> {
        truth(
            &profile.profile,
            named(&self.constituents)?,
            self.wavelength_step_nm,
            self.ground_albedo,
        )
    }

    /// Computes the skies of the scene and fits the table; `profile` is the plan's own.
    ///
    /// # Errors
    /// When the settings do not suit the profile or the skies do not determine the table.
    pub fn bake(&self, profile: &NamedProfile) -> Result<Lut> {
        let truth = self.truth(profile)?;
        let mut lattice = Lattice::new(&truth, &self.domain());
        lattice.prepare(&self.grid.turbidity)?;
        self.bake_on(&lattice, &truth, profile)
    }

    /// Fits the table to skies that were computed before.
    pub(crate) fn bake_on(
        &self,
        lattice: &Lattice<'_>,
        truth: &TransportSky,
        profile: &NamedProfile,
    ) -> Result<Lut> {
        let header = header(self, truth, profile)?;
        let fitted = values(lattice, &self.nodes(), &self.term_places()?)?;
        let draft = UtmSky::new(Lut::from_f64(header.clone(), &fitted)?)?;
        let mut maps: Vec<&SkyMap> = Vec::new();
        for turbidity in &self.grid.turbidity {
            maps.extend(&lattice.layer(*turbidity)?.maps);
        }
        let fit = rounded(statistics(&draft, &maps)?);
        Ok(Lut::from_f64(LutHeader { fit, ..header }, &fitted)?)
    }
}

/// Four digits: more would be as long as a node in the header of a small table.
fn rounded(fit: FitStatistics) -> FitStatistics {
    let short = |x: f64| format!("{x:.3e}").parse().unwrap_or(x);
    let quantiles = |q: ErrorQuantiles| ErrorQuantiles {
        median: short(q.median),
        p95: short(q.p95),
        max: short(q.max),
    };
    FitStatistics {
        delta_e_2000: quantiles(fit.delta_e_2000),
        luminance_relative_error: quantiles(fit.luminance_relative_error),
    }
}

/// The header of a plan's table.
pub(crate) fn header(
    plan: &Plan,
    truth: &TransportSky,
    profile: &NamedProfile,
) -> Result<LutHeader> {
    let [altitude_km, turbidity, sun_zenith_deg] = axes(plan.nodes())?;
    Ok(LutHeader {
        form: Form::Extended,
        storage: plan.storage,
        interpolation: Interpolation::LogLinear,
        altitude_km,
        turbidity,
        sun_zenith_deg,
        channels: CHANNELS.map(str::to_owned).to_vec(),
        terms: plan.terms.clone(),
        profile_name: plan.profile.display().to_string(),
        profile_sha256: profile.sha256.clone(),
        generator: concat!("utm-sky ", env!("CARGO_PKG_VERSION")).to_owned(),
        engine: truth.name().to_owned(),
        settings: BTreeMap::from([
            ("ground_albedo".to_owned(), plan.ground_albedo.into()),
            (
                "wavelength_step_nm".to_owned(),
                plan.wavelength_step_nm.into(),
            ),
            (
                "constituents".to_owned(),
                plan.constituents.join(",").into(),
            ),
            ("scene".to_owned(), plan.scene.clone().into()),
            ("tier".to_owned(), plan.tier.name().into()),
            ("aerial".to_owned(), plan.aerial.name().into()),
        ]),
        fit: FitStatistics::default(),
        extinction: Some(truth.extinction()?),
        domain: plan.domain(),
    })
}

/// The values of a table, fitted to prepared skies.
pub(crate) fn values(
    lattice: &Lattice<'_>,
    nodes: &[Vec<f64>; 3],
    terms: &[usize],
) -> Result<Vec<f64>> {
    let [altitude, turbidity, sun] = axes(nodes.clone())?;
    let fits: Vec<Vec<f64>> = turbidity
        .nodes()
        .par_iter()
        .map(|t| {
            Ok(fit_turbidity(
                &lattice.layer(*t)?.equations,
                &altitude,
                &sun,
                terms,
            )?)
        })
        .collect::<Result<_>>()?;
    let fits: Vec<&[f64]> = fits.iter().map(Vec::as_slice).collect();
    Ok(by_altitude(&fits, altitude.len()))
}
