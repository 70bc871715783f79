//! The finite path of the report of 2005, for comparison.

use sky_core::aerial::{AerialFrame, AerialPath, mean_of_exponential};
use sky_core::color::linear_srgb;
use sky_core::utm_sky::SkyFrame;

/// One over the scale height of the report's transparency \[km⁻¹\]: that of air.
const UTM2005_PER_SCALE_HEIGHT: f32 = 1.0 / 8.0;

/// The path as the report of 2005 has it: Musgrave's mean density, flat Earth, in the corrected
/// form, for one scale height of all constituents; the atmosphere's color is the sky's in the
/// direction of view, on the other side of the dome where the ray would meet the ground.
///
/// Source: the report's Eq. 3.1–3.4. Eq. 3.3 lacks sign, path length, coefficient and scale
/// height; with them no branch at equal altitudes is needed.
#[must_use]
pub fn path_utm2005(
    air: &AerialFrame,
    sky: &SkyFrame,
    altitude_km: f32,
    direction: [f32; 3],
    distance_km: f32,
) -> AerialPath {
    let z1 = altitude_km * UTM2005_PER_SCALE_HEIGHT;
    let z2 = (altitude_km + distance_km * direction[2]) * UTM2005_PER_SCALE_HEIGHT;
    let mean = mean_of_exponential(-z1, -0.5 * (z1 + z2), -z2);
    let depth = core::array::from_fn(|w| {
        let at_ground = air.per_km.iter().map(|c| c[w]).sum::<f32>();
        at_ground * mean * distance_km
    });
    let transmittance = air.transmittance(depth);
    let [x, y, z] = direction;
    let atmosphere = sky
        .light(direction)
        .or_else(|| sky.light([-x, -y, -z]))
        .map_or([0.0; 3], linear_srgb);
    AerialPath {
        transmittance,
        inscatter: core::array::from_fn(|i| (1.0 - transmittance[i]) * atmosphere[i]),
    }
}
