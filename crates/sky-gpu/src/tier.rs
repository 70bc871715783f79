//! The three ways to draw a sky.

use sky_core::lut::LutHeader;

use crate::camera::Dome;

/// How the sky is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tier {
    /// A dome colored at its corners: the report's way. Orthographic cameras have it drawn as
    /// [`Self::Fragment`].
    Vertex(Dome),
    /// The formula at every pixel.
    Fragment,
    /// A small texture, made anew when the sky has changed; one fetch a pixel. The same picture for
    /// half the cost.
    #[default]
    Baked,
}

impl Tier {
    /// The tier that the plan chose from which a table was baked, where it was.
    #[must_use]
    pub fn planned(header: &LutHeader) -> Option<Self> {
        match header.planned("tier")? {
            "vertex" => Some(Self::Vertex(Dome::REPORT)),
            "fragment" => Some(Self::Fragment),
            "baked" => Some(Self::Baked),
            _ => None,
        }
    }
}
