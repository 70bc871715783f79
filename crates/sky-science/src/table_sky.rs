//! A table of any form as a sky.

use sky_core::color::Yxy;
use sky_core::conditions::{Conditions, Domain, OutsideDomain};
use sky_core::direction::SkyDirection;
use sky_core::lut::{Form, Lut};
use sky_core::utm_sky::{TableError, UtmSky};

use crate::perez_sky::PerezSky;
use crate::sky_model::SkyModel;

/// The sky of a table, whatever its form.
#[derive(Clone, Debug)]
pub enum TableSky {
    /// What the runtime draws.
    Utm(Box<UtmSky>),
    /// A Perez form, for comparison.
    Perez(Box<PerezSky>),
}

impl TableSky {
    /// The sky of a table.
    ///
    /// # Errors
    /// When a table of the extended form lacks what the runtime needs.
    pub fn new(lut: Lut) -> Result<Self, TableError> {
        match lut.header().form {
            Form::Extended => Ok(Self::Utm(Box::new(UtmSky::new(lut)?))),
            Form::PerezReport | Form::PerezSpherical => PerezSky::new(lut)
                .map(|sky| Self::Perez(Box::new(sky)))
                .map_err(|e| TableError::Form { found: e.found }),
        }
    }

    /// The table.
    #[must_use]
    pub fn lut(&self) -> &Lut {
        match self {
            Self::Utm(sky) => sky.lut(),
            Self::Perez(sky) => sky.lut(),
        }
    }

    /// The runtime's sky, where the table is one.
    #[must_use]
    pub fn utm(&self) -> Option<&UtmSky> {
        match self {
            Self::Utm(sky) => Some(sky),
            Self::Perez(_) => None,
        }
    }

    fn model(&self) -> &dyn SkyModel {
        match self {
            Self::Utm(sky) => &**sky,
            Self::Perez(sky) => &**sky,
        }
    }
}

impl SkyModel for TableSky {
    fn name(&self) -> &str {
        self.model().name()
    }

    fn domain(&self) -> &Domain {
        self.model().domain()
    }

    fn yxy_map(
        &self,
        conditions: &Conditions,
        directions: &[SkyDirection],
    ) -> Result<Vec<Yxy>, OutsideDomain> {
        self.model().yxy_map(conditions, directions)
    }
}
