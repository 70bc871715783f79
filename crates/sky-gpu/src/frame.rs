//! What a frame's sky depends on: observer, haze, sun, exposure.

use glam::Vec3;
use sky_core::conditions::{Conditions, OutsideDomain};
use sky_core::haze::{Haze, HazeError};
use sky_core::picture::Picture;
use sky_core::quantity::{Angle, Length};
use sky_core::tonemap::{Tone, ev100_from_luminance, exposure_from_ev100, luminance};
use thiserror::Error;

/// How light is scaled for the target.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Exposure {
    /// By an exposure value at ISO 100.
    Ev100(f32),
    /// From the mean of the sky.
    #[default]
    Auto,
    /// By a factor of the caller's \[m²·cd⁻¹\]: the pre-exposure of an engine.
    Scale(f32),
    /// None: light in cd·m⁻² as it is.
    None,
}

/// What a frame's sky depends on. Directions are in a world of the caller's choice; arrays become
/// vectors by `into`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameSettings {
    /// The observer's altitude above mean sea level.
    pub observer_altitude: Length,
    /// The haze, as turbidity, optical depth, visual range or by Ångström's law.
    pub haze: Haze,
    /// The world's direction toward the sun's center; any length.
    pub sun: Vec3,
    /// The world's direction up at the observer; any length.
    pub up: Vec3,
    /// Albedo of the ground.
    pub ground_albedo: f32,
    /// Whether the sun's disc is drawn; the scene's light does not change.
    pub sun_disc: bool,
    /// The exposure.
    pub exposure: Exposure,
    /// The tone curve of [`crate::Output::Display`]; other outputs have none.
    pub tone: Option<Tone>,
    /// What the colors that [`crate::SkyRenderer::composite`] reads were multiplied with \[m²·cd⁻¹\]:
    /// 1 where they are light.
    pub scene_exposure: f32,
}

impl Default for FrameSettings {
    fn default() -> Self {
        Self {
            observer_altitude: Length::from_m(2.0),
            haze: Haze::Turbidity(2.5),
            sun: Vec3::new(0.0, 0.707, 0.707),
            up: Vec3::Z,
            ground_albedo: 0.2,
            sun_disc: true,
            exposure: Exposure::Auto,
            tone: Some(Tone::Neutral),
            scene_exposure: 1.0,
        }
    }
}

/// A frame that has no sky.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum FrameError {
    /// A haze that cannot be.
    #[error("haze: {0}")]
    Haze(#[from] HazeError),
    /// Conditions outside the table's domain.
    #[error(transparent)]
    Domain(#[from] OutsideDomain),
}

impl FrameSettings {
    /// The conditions for the table.
    ///
    /// # Errors
    /// When the haze cannot be: a turbidity below 1, a visual range beyond clean air's.
    pub fn conditions(&self) -> Result<Conditions, HazeError> {
        let (sun, up) = (self.sun.normalize_or_zero(), self.up.normalize_or_zero());
        let zenith = sun.cross(up).length().atan2(sun.dot(up));
        Ok(Conditions {
            observer_altitude: self.observer_altitude,
            turbidity: self.haze.turbidity()?,
            sun_zenith: Angle::from_radians(zenith.into()),
        })
    }

    /// The local frame in the world: toward the sun's azimuth, left of it, up.
    #[must_use]
    pub fn local_axes(&self) -> [Vec3; 3] {
        let up = self.up.normalize_or(Vec3::Z);
        let flat = self.sun - up * self.sun.dot(up);
        let x = flat
            .try_normalize()
            .unwrap_or_else(|| up.any_orthonormal_vector());
        [x, up.cross(x), up]
    }

    /// What light is multiplied with \[m²·cd⁻¹\].
    pub(crate) fn exposure(&self, picture: &Picture) -> f32 {
        match self.exposure {
            Exposure::None => 1.0,
            Exposure::Scale(scale) => scale,
            Exposure::Ev100(ev100) => exposure_from_ev100(ev100),
            Exposure::Auto => exposure_from_ev100(auto_ev100(picture)),
        }
    }
}

/// Mean light of the upper half of the sky, by cosine \[cd·m⁻²\].
pub(crate) fn mean(picture: &Picture) -> [f32; 3] {
    picture
        .light
        .sky_horizontal
        .map(|c| c / core::f32::consts::PI)
}

/// The exposure value that brings the mean of a picture's sky to middle gray, 0.18.
#[must_use]
pub fn auto_ev100(picture: &Picture) -> f32 {
    ev100_for_mean(luminance(mean(picture)))
}

/// The exposure value that brings a luminance \[cd·m⁻²\] to middle gray, 0.18.
#[must_use]
pub fn ev100_for_mean(mean: f32) -> f32 {
    // a meter's answer brings it to 0.104
    ev100_from_luminance(mean) - 0.79
}
