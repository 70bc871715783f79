//! The one interface: every sky, ours or published, answers the same question.
//!
//! The sun's disc is never part of the answer.

use sky_core::color::Yxy;
use sky_core::conditions::{Conditions, Domain, OutsideDomain};
use sky_core::direction::SkyDirection;
use sky_core::utm_sky::UtmSky;

/// Why a sky has no answer.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SkyError {
    /// The conditions lie outside its domain.
    #[error(transparent)]
    Outside(#[from] OutsideDomain),
    /// It computes its answer and gave up, though the conditions lie within its domain.
    #[error("{sky} at turbidity {turbidity}: {why}")]
    GaveUp {
        /// Name of the sky.
        sky: &'static str,
        /// The turbidity.
        turbidity: f64,
        /// What it says.
        why: String,
    },
}

/// A sky: its domain, and the light that an observer sees.
pub trait SkyModel: Sync {
    /// Short name for captions and tables.
    fn name(&self) -> &str;

    /// Where the model claims to be valid.
    fn domain(&self) -> &Domain;

    /// The light from several directions under one set of conditions.
    ///
    /// # Errors
    /// When the conditions lie outside the domain, or the sky computes its answer and gives up.
    fn yxy_map(
        &self,
        conditions: &Conditions,
        directions: &[SkyDirection],
    ) -> Result<Vec<Yxy>, SkyError>;
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
    ) -> Result<Vec<Yxy>, SkyError> {
        let frame = self.frame(conditions)?;
        Ok(directions
            .iter()
            .map(|d| frame.yxy(d).unwrap_or_default())
            .collect())
    }
}
