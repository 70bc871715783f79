//! The models of the atlas, and a model under its sweep.

use anyhow::{Result, anyhow};
use sky_core::axis::Axis;
use sky_core::utm_sky::UtmSky;
use sky_science::sky_model::SkyModel;
use sky_science::table_sky::TableSky;

use super::kind::Arithmetic;
use crate::bake::bake;
use crate::cases::Nodes;
use crate::models::{Source, all, general_truth};
use crate::profiles::NamedProfile;
use crate::progress::Progress;

/// How many values are taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Density {
    /// Altitudes, besides nodes and bounds.
    pub altitudes: u16,
    /// Turbidities, besides nodes and bounds.
    pub turbidities: u16,
    /// Suns, besides nodes and bounds.
    pub suns: u16,
    /// View zenith angles, besides those at zenith and horizon.
    pub zeniths: u16,
    /// Azimuths, besides those at the solar plane.
    pub azimuths: u16,
    /// Altitudes between two nodes, and steps of paths.
    pub between: u16,
}

impl Density {
    /// Some seconds a model.
    pub const QUICK: Self = Self {
        altitudes: 8,
        turbidities: 3,
        suns: 8,
        zeniths: 4,
        azimuths: 2,
        between: 2,
    };
    /// More than 10⁸ lights inside the default model's domain.
    pub const FULL: Self = Self {
        altitudes: 24,
        turbidities: 8,
        suns: 24,
        zeniths: 14,
        azimuths: 8,
        between: 8,
    };
}

/// Models whose every condition costs tables of its own: not in the quick sweep, and asked less in the
/// full one.
const SLOW: [&str; 5] = [
    "nishita",
    "nishita-table",
    "dobashi",
    "hillaire",
    "bruneton",
];

/// A model of the atlas.
#[derive(Clone, Copy, Debug)]
pub struct ModelEntry {
    /// Name in `--models` and in the files.
    pub name: &'static str,
    source: Source,
}

/// The models of `utm-sky models`, but for our own tiers: they are the same formula.
#[must_use]
pub fn models() -> Vec<ModelEntry> {
    all()
        .into_iter()
        .filter(|m| !matches!(m.source, Source::Baked | Source::Dome))
        .map(|m| ModelEntry {
            name: m.name,
            source: m.source,
        })
        .collect()
}

impl ModelEntry {
    /// Makes the model.
    ///
    /// # Errors
    /// When its table cannot be read or made.
    pub fn subject(&self, progress: &dyn Progress) -> Result<Subject> {
        match self.source {
            Source::Table(grid) => {
                let truth = general_truth()?;
                let (air, profile) = (truth.extinction()?, NamedProfile::general()?);
                let (table, _) = bake(&truth, &grid()?, &profile, air, progress)?;
                let lut = format!("{}.utmlut", self.name);
                Ok(Subject::table_of(TableSky::new(table)?, &lut))
            }
            Source::Published(baseline) => Ok(Subject::other((baseline.sky)())),
            Source::Ours | Source::Baked | Source::Dome => {
                Ok(Subject::table_of(UtmSky::embedded()?.into(), "embedded"))
            }
        }
    }

    /// How densely it is swept.
    #[must_use]
    pub fn density(&self, quick: bool) -> Density {
        if quick || SLOW.contains(&self.name) {
            Density::QUICK
        } else {
            Density::FULL
        }
    }
}

/// A model under the sweep.
pub struct Subject {
    sky: Sky,
    /// In what numbers it answers.
    pub arithmetic: Arithmetic,
    /// Nodes of its table; empty where it has none.
    pub nodes: Nodes,
    /// What `utm-sky sky --lut` must be given to ask it; without it, it is asked by its name.
    pub lut: Option<String>,
}

enum Sky {
    Table(TableSky),
    Other(Box<dyn SkyModel>),
}

impl std::fmt::Debug for Subject {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Subject")
            .field("name", &self.model().name())
            .field("arithmetic", &self.arithmetic)
            .finish_non_exhaustive()
    }
}

impl Subject {
    /// A table's sky; `lut` names the table on the command line.
    #[must_use]
    pub fn table_of(sky: TableSky, lut: &str) -> Self {
        let header = sky.lut().header();
        let list = |axis: &Axis| axis.nodes().to_vec();
        Self {
            arithmetic: Arithmetic::CpuF32,
            nodes: Nodes {
                altitude_km: list(&header.altitude_km),
                turbidity: list(&header.turbidity),
                sun_zenith_deg: list(&header.sun_zenith_deg),
            },
            lut: Some(lut.to_owned()),
            sky: Sky::Table(sky),
        }
    }

    /// Any other sky, in double precision. Black (Y, x and y 0) below the horizon is taken as no answer.
    #[must_use]
    pub fn other(sky: Box<dyn SkyModel>) -> Self {
        Self {
            arithmetic: Arithmetic::CpuF64,
            nodes: Nodes::default(),
            lut: None,
            sky: Sky::Other(sky),
        }
    }

    /// The sky.
    #[must_use]
    pub fn model(&self) -> &dyn SkyModel {
        match &self.sky {
            Sky::Table(sky) => sky,
            Sky::Other(sky) => &**sky,
        }
    }

    /// The runtime's sky, if it is one.
    #[must_use]
    pub fn table(&self) -> Option<&UtmSky> {
        match &self.sky {
            Sky::Table(sky) => sky.utm(),
            Sky::Other(_) => None,
        }
    }
}

/// The models of a list of names; without one all of them, of a quick sweep those that are quick
/// themselves.
///
/// # Errors
/// Names the models that there are, and the one that is none.
pub fn chosen(names: Option<&[String]>, quick: bool) -> Result<Vec<ModelEntry>> {
    let known = models();
    let Some(names) = names else {
        return Ok(known
            .into_iter()
            .filter(|m| !(quick && SLOW.contains(&m.name)))
            .collect());
    };
    names
        .iter()
        .map(|name| {
            known
                .iter()
                .find(|m| m.name == name)
                .copied()
                .ok_or_else(|| {
                    let known: Vec<&str> = known.iter().map(|m| m.name).collect();
                    anyhow!(
                        "--models: expected some of {}, found {name}",
                        known.join(", ")
                    )
                })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_model_is_named() {
        let names = ["utm-sky".to_owned(), "hosekk".to_owned()];
        let message = chosen(Some(&names), true)
            .map(|_| ())
            .unwrap_err()
            .to_string();
        assert!(
            message.contains("hosekk") && message.contains("utm2005"),
            "{message}"
        );
        assert_eq!(chosen(None, false).unwrap().len(), models().len());
    }
}
