//! What a camera sees without a scene: sky, sun and the ground below the horizon.
//!
//! Twin of the entry points in `shaders/`: the picture where there is no GPU.

use crate::aerial::AerialFrame;
use crate::aerial::distance_to_ground;
use crate::conditions::{Conditions, OutsideDomain};
use crate::light::{SceneLight, SunDisc};
use crate::quantity::single;
use crate::utm_sky::{SkyFrame, UtmSky};

/// Everything that a picture needs, for one observer, haze and sun.
#[derive(Clone, Debug)]
pub struct Picture {
    /// The sky.
    pub sky: SkyFrame,
    /// The air between observer and objects.
    pub air: AerialFrame,
    /// The observer's altitude \[km\].
    pub altitude_km: f32,
    /// The light on the scene.
    pub light: SceneLight,
    /// The sun's disc.
    pub sun: SunDisc,
}

impl Picture {
    /// Gathers it. No allocation.
    ///
    /// # Errors
    /// When the conditions lie outside the table's domain.
    pub fn new(
        sky: &UtmSky,
        conditions: &Conditions,
        ground_albedo: f32,
    ) -> Result<Self, OutsideDomain> {
        let frame = sky.frame(conditions)?;
        let air = AerialFrame::new(sky, conditions.turbidity, conditions.sun_zenith)?;
        let altitude_km = single(conditions.observer_altitude.km());
        Ok(Self {
            light: SceneLight::new(&frame, &air, altitude_km, ground_albedo),
            sun: SunDisc::new(&frame, &air, altitude_km),
            sky: frame,
            air,
            altitude_km,
        })
    }

    /// Light from a direction in linear sRGB \[cd·m⁻²\].
    #[must_use]
    pub fn color(&self, direction: [f32; 3]) -> [f32; 3] {
        let [x, y, z] = direction;
        match self.sky.linear_srgb(direction) {
            Some(sky) => {
                let [sin_sun, cos_sun] = self.sky.sun();
                let across = z * sin_sun - x * cos_sun;
                let cos_gamma = x * sin_sun + z * cos_sun;
                let disc = self.sun.light(y.hypot(across), cos_gamma, z);
                core::array::from_fn(|c| sky[c] + disc[c])
            }
            None => self.behind_air(
                direction,
                distance_to_ground(self.altitude_km, z),
                self.light.ground,
            ),
        }
    }

    /// An object's light at a distance, through the air before it.
    #[must_use]
    pub fn behind_air(&self, direction: [f32; 3], distance_km: f32, object: [f32; 3]) -> [f32; 3] {
        let path = self.air.path(self.altitude_km, direction, distance_km);
        core::array::from_fn(|c| path.transmittance[c] * object[c] + path.inscatter[c])
    }
}
