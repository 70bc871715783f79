//! The one interface: every sky, ours or published, answers the same question.
//!
//! The sun's disc is never part of the answer.

use sky_core::color::Yxy;
use sky_core::conditions::{Conditions, Domain, OutsideDomain};
use sky_core::direction::SkyDirection;
use sky_core::utm_sky::UtmSky;

/// A sky: its domain, and the light that an observer sees.
pub trait SkyModel: Sync {
    /// Short name for captions and tables.
    fn name(&self) -> &str;

    /// Where the model claims to be valid.
    fn domain(&self) -> &Domain;

    /// The light from several directions under one set of conditions.
    ///
    /// # Errors
    /// When the conditions lie outside the domain.
    fn yxy_map(
        &self,
        conditions: &Conditions,
        directions: &[SkyDirection],
    ) -> Result<Vec<Yxy>, OutsideDomain>;
}

impl SkyModel for UtmSky {
    fn name(&self) -> &str {
        "utm-sky"
    }

    fn domain(&self) -> &Domain {
        Self::domain(self)
    }

    /// Directions below the geometric horizon come out black.
    fn yxy_map(
        &self,
        conditions: &Conditions,
        directions: &[SkyDirection],
    ) -> Result<Vec<Yxy>, OutsideDomain> {
        let frame = self.frame(conditions)?;
        Ok(directions
            .iter()
            .map(|d| frame.yxy(d).unwrap_or_default())
            .collect())
    }
}
