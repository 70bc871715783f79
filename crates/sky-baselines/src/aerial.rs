//! Aerial perspective: what the air takes from and adds to a finite path.

use sky_core::color::Xyz;

/// A path through air.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aerial {
    /// Transmittance at the model's three wavelengths.
    pub transmittance: [f64; 3],
    /// Light added to the path \[cd·m⁻²\].
    pub in_scattered: Xyz,
}

impl Aerial {
    pub(crate) fn new(transmittance: [f32; 3], xyz: [f32; 3]) -> Self {
        let [x, y, z] = xyz.map(f64::from);
        Self {
            transmittance: transmittance.map(f64::from),
            in_scattered: Xyz { x, y, z },
        }
    }
}
