//! The one list of skies: ours, the report's and the published ones.

use std::fmt;

use anyhow::{Result, anyhow};
use sky_baselines::Baseline;
use sky_core::conditions::{Conditions, Domain};
use sky_core::direction::SkyDirection;
use sky_core::utm_sky::{EMBEDDED_LUT, UtmSky};
use sky_fit::sweep::Grid;
use sky_science::perez_sky::PerezSky;
use sky_science::shader_sky::ShaderSky;
use sky_science::sky_model::SkyModel;
use sky_sim::optics::OpticsSettings;
use sky_sim::profile::AtmosphereProfile;

use crate::bake::{MAP_STEP_NM, bake};
use crate::perez_table::PerezTable;
use crate::profiles::NamedProfile;
use crate::progress::Progress;
use crate::tiers::{BakedSky, DomeSky};
use crate::truth::{DEFAULT_GROUND_ALBEDO, TransportSky};

/// Where a model comes from.
#[derive(Clone, Copy, Debug)]
pub enum Source {
    /// The default table at every pixel.
    Ours,
    /// The default table through the baked texture.
    Baked,
    /// The default table at the report's 271 corners.
    Dome,
    /// A table of one of the Perez forms, baked when it is asked for.
    Table(fn() -> Result<Grid, sky_core::axis::AxisError>),
    /// A published sky.
    Published(&'static Baseline),
}

/// A row of the list.
#[derive(Clone, Copy, Debug)]
pub struct Model {
    /// The name by which it is asked for.
    pub name: &'static str,
    /// How it is evaluated, where there are several ways.
    pub tier: &'static str,
    /// Where it was published.
    pub citation: &'static str,
    /// Its origin.
    pub source: Source,
}

/// Our own models and the report's; the published ones follow in [`all`].
const OURS: [Model; 5] = [
    Model {
        name: "utm-sky",
        tier: "fragment",
        citation: "this project: 22 products for ln Y, x, y; the default table",
        source: Source::Ours,
    },
    Model {
        name: "utm-sky-baked",
        tier: "baked",
        citation: "this project: the default table in a texture of 160 x 192",
        source: Source::Baked,
    },
    Model {
        name: "utm-sky-vertex",
        tier: "vertex",
        citation: "this project: the default table at the report's 271 endpoints",
        source: Source::Dome,
    },
    Model {
        name: "perez-spherical",
        tier: "fragment",
        citation: "Perez, Seals & Michalsky 1993 with a spherical air mass, fitted by this project",
        source: Source::Table(Grid::perez),
    },
    Model {
        name: "utm2005",
        tier: "fragment",
        citation: "The Development of Local Solar Irradiance for Outdoor Computer Graphics Rendering, UTM 2005: 75 maps, 1/cos, Lagrange",
        source: Source::Table(Grid::report),
    },
];

/// Every model.
#[must_use]
pub fn all() -> Vec<Model> {
    OURS.into_iter()
        .chain(sky_baselines::MODELS.iter().map(|b| Model {
            name: b.name,
            tier: "fragment",
            citation: b.citation,
            source: Source::Published(b),
        }))
        .collect()
}

/// The model of a name.
///
/// # Errors
/// When there is none.
pub fn named(name: &str) -> Result<Model> {
    let known = all();
    known
        .iter()
        .find(|m| m.name == name)
        .copied()
        .ok_or_else(|| {
            anyhow!(
                "model: expected a name of `utm-sky models` ({}), found {name:?}",
                known.iter().map(|m| m.name).collect::<Vec<_>>().join(", ")
            )
        })
}

/// A sky that was made.
pub struct Opened {
    sky: Sky,
    /// Bytes of its tables.
    pub bytes: usize,
}

/// A sky, with a shader or without.
enum Sky {
    Plain(Box<dyn SkyModel + Send>),
    Shaded(Box<dyn ShaderSky + Send>),
}

impl fmt::Debug for Opened {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.sky().name())
    }
}

impl Opened {
    /// The sky.
    #[must_use]
    pub fn sky(&self) -> &dyn SkyModel {
        match &self.sky {
            Sky::Plain(sky) => &**sky,
            Sky::Shaded(sky) => &**sky,
        }
    }

    /// The sky with its shader, where it is one that the renderer does not draw itself.
    #[must_use]
    pub fn shader_sky(&self) -> Option<&dyn ShaderSky> {
        match &self.sky {
            Sky::Plain(_) => None,
            Sky::Shaded(sky) => Some(&**sky),
        }
    }

    fn into_sky(self) -> Box<dyn SkyModel + Send> {
        match self.sky {
            Sky::Plain(sky) => sky,
            Sky::Shaded(sky) => sky,
        }
    }
}

/// The sky of a name over the general atmosphere; a table is baked first.
///
/// # Errors
/// When there is no such model, or its table cannot be baked.
pub fn open(name: &str, progress: &dyn Progress) -> Result<Box<dyn SkyModel + Send>> {
    Ok(named(name)?.open(&general_truth()?, progress)?.into_sky())
}

/// The transport engine over the general atmosphere, as the default table is made from it.
///
/// # Errors
/// When the atmosphere cannot be built.
pub fn general_truth() -> Result<TransportSky> {
    TransportSky::new(
        AtmosphereProfile::general(),
        OpticsSettings::with_step_nm(MAP_STEP_NM)?,
        DEFAULT_GROUND_ALBEDO,
    )
}

/// Whether a model answers in a direction: above the geometric horizon, and above the horizontal where
/// its domain ends there.
#[must_use]
pub fn answers(domain: &Domain, conditions: &Conditions, direction: &SkyDirection) -> bool {
    let lowest = domain.lowest_view_zenith_deg(conditions.observer_altitude);
    direction.view_zenith.degrees() <= lowest + 1e-9
}

impl Model {
    /// Makes the sky; a table is baked from the truth first.
    ///
    /// # Errors
    /// When a table cannot be baked.
    pub fn open(&self, truth: &TransportSky, progress: &dyn Progress) -> Result<Opened> {
        let ours = |sky: Box<dyn SkyModel + Send>| Opened {
            sky: Sky::Plain(sky),
            bytes: EMBEDDED_LUT.len(),
        };
        Ok(match self.source {
            Source::Ours => ours(Box::new(UtmSky::embedded()?)),
            Source::Baked => ours(Box::new(BakedSky::new(UtmSky::embedded()?))),
            Source::Dome => ours(Box::new(DomeSky::new(UtmSky::embedded()?))),
            Source::Table(grid) => {
                let (air, profile) = (truth.extinction()?, NamedProfile::general()?);
                let (lut, _) = bake(truth, &grid()?, &profile, air, progress)?;
                let sky = PerezTable::new(PerezSky::new(lut)?);
                Opened {
                    bytes: sky.table_bytes(),
                    sky: Sky::Shaded(Box::new(sky)),
                }
            }
            Source::Published(baseline) => Opened {
                sky: baseline
                    .shader_sky
                    .map_or_else(|| Sky::Plain((baseline.sky)()), |make| Sky::Shaded(make())),
                bytes: baseline.table_bytes(),
            },
        })
    }

    /// Whether its air is its own, matched at equal aerosol optical depth.
    #[must_use]
    pub const fn own_atmosphere(&self) -> bool {
        match self.source {
            Source::Published(baseline) => baseline.own_atmosphere,
            _ => false,
        }
    }

    /// Whether it gives luminance alone.
    #[must_use]
    pub const fn luminance_only(&self) -> bool {
        match self.source {
            Source::Published(baseline) => baseline.luminance_only,
            _ => false,
        }
    }

    /// Where it claims to be valid.
    ///
    /// # Errors
    /// When the embedded table cannot be read.
    pub fn domain(&self) -> Result<Domain> {
        Ok(match self.source {
            Source::Published(baseline) => baseline.domain,
            Source::Table(grid) => {
                let grid = grid()?;
                Domain {
                    altitude_km: grid.altitude_km.bounds(),
                    turbidity: grid.turbidity.bounds(),
                    sun_zenith_deg: grid.sun_zenith_deg.bounds(),
                    below_horizontal: self.name != "utm2005",
                }
            }
            _ => *UtmSky::embedded()?.domain(),
        })
    }
}
