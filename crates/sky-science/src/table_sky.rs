//! A table of any form as a sky.

use sky_core::color::Yxy;
use sky_core::conditions::{Conditions, Domain, OutsideDomain};
use sky_core::direction::SkyDirection;
use sky_core::lut::{Form, Lut};
use sky_core::utm_sky::{SkyFrame, TableError, UtmSky};

use crate::perez_sky::{PerezFrame, PerezSky};
use crate::sky_model::{SkyError, SkyModel};

/// The sky of a table, whatever its form.
#[derive(Clone, Debug)]
pub enum TableSky {
    /// What the runtime draws.
    Utm(Box<UtmSky>),
    /// A Perez form, for comparison.
    Perez(Box<PerezSky>),
}

/// The sky of a table for one observer, haze and sun.
#[derive(Clone, Debug)]
pub enum TableFrame {
    /// What the runtime draws.
    Utm(Box<SkyFrame>),
    /// A Perez form.
    Perez(Box<PerezFrame>),
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

    /// Gathers what depends on observer, haze and sun.
    ///
    /// # Errors
    /// When the conditions lie outside the table's domain.
    pub fn frame(&self, conditions: &Conditions) -> Result<TableFrame, OutsideDomain> {
        match self {
            Self::Utm(sky) => sky
                .frame(conditions)
                .map(|frame| TableFrame::Utm(Box::new(frame))),
            Self::Perez(sky) => sky
                .frame(conditions)
                .map(|frame| TableFrame::Perez(Box::new(frame))),
        }
    }

    fn model(&self) -> &dyn SkyModel {
        match self {
            Self::Utm(sky) => &**sky,
            Self::Perez(sky) => &**sky,
        }
    }
}

impl TableFrame {
    /// The light from a direction, `None` below the geometric horizon.
    #[must_use]
    pub fn yxy(&self, direction: &SkyDirection) -> Option<Yxy> {
        match self {
            Self::Utm(frame) => frame.yxy(direction),
            Self::Perez(frame) => frame.yxy(direction),
        }
    }
}

impl From<UtmSky> for TableSky {
    fn from(sky: UtmSky) -> Self {
        Self::Utm(Box::new(sky))
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
    ) -> Result<Vec<Yxy>, SkyError> {
        self.model().yxy_map(conditions, directions)
    }
}
