//! Where a picture is taken to: projection, orientation, viewport.

use glam::{Mat3, Mat4, Vec3, Vec4};

use crate::uniforms::ViewUniform;

/// How directions become places in the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Any invertible projection matrix. The camera stands at the origin.
    Matrix {
        /// From the view's space to clip space.
        clip_from_view: Mat4,
        /// Depth of what is infinitely far: 0 for reversed depth, 1 otherwise.
        far_depth: f32,
    },
    /// The upper half of the sky as a disc, the zenith in its middle; angles are true from the center.
    Fisheye {
        /// Width over height.
        aspect: f32,
    },
    /// All directions: azimuth across, elevation up.
    Equirectangular,
}

/// A camera: its projection, and where it looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// The projection.
    pub projection: Projection,
    /// From the world to the view's space, without translation: the floating origin is the camera.
    /// For fisheye and equirectangular pictures the view's axes are right, forward and up.
    pub view_from_world: Mat3,
    /// Kilometers of a unit of the world.
    pub km_per_unit: f32,
    /// First pixel of the viewport.
    pub viewport_origin: [f32; 2],
    /// Whether the depth that [`crate::SkyRenderer::composite`] reads is a distance \[km\], 0 for the
    /// sky, in place of a depth in clip space.
    pub depth_is_distance: bool,
}

/// Rings and spokes of the dome; the report's has 9 and 30.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dome {
    /// Rings from the zenith to the horizon.
    pub rings: u16,
    /// Corners of a ring.
    pub spokes: u16,
}

impl Dome {
    /// The report's 271 endpoints.
    pub const REPORT: Self = Self {
        rings: 9,
        spokes: 30,
    };
    /// Fine enough that the mesh is hard to see.
    pub const FINE: Self = Self {
        rings: 45,
        spokes: 120,
    };
    /// Rings below the horizon, as in `dome.wgsl`.
    const GROUND_RINGS: u32 = 6;

    pub(crate) fn vertices(self) -> u32 {
        6 * (u32::from(self.rings) + Self::GROUND_RINGS) * u32::from(self.spokes)
    }
}

impl Camera {
    /// A perspective camera with reversed, infinite depth, looking along the view's −z.
    #[must_use]
    pub fn perspective(vertical_fov_rad: f32, aspect: f32, view_from_world: Mat3) -> Self {
        let f = 1.0 / (0.5 * vertical_fov_rad).tan();
        // depth is near/distance: 1 at the near plane, 0 infinitely far
        let near = 0.1;
        let clip_from_view = Mat4::from_cols(
            Vec4::new(f / aspect, 0.0, 0.0, 0.0),
            Vec4::new(0.0, f, 0.0, 0.0),
            Vec4::new(0.0, 0.0, 0.0, -1.0),
            Vec4::new(0.0, 0.0, near, 0.0),
        );
        Self {
            projection: Projection::Matrix {
                clip_from_view,
                far_depth: 0.0,
            },
            view_from_world,
            km_per_unit: 1e-3,
            viewport_origin: [0.0; 2],
            depth_is_distance: false,
        }
    }

    /// A fisheye or equirectangular camera; `view_from_world` has the rows right, forward and up.
    #[must_use]
    pub const fn panorama(projection: Projection, view_from_world: Mat3) -> Self {
        Self {
            projection,
            view_from_world,
            km_per_unit: 1e-3,
            viewport_origin: [0.0; 2],
            depth_is_distance: true,
        }
    }

    /// From the world, the camera at its origin, to clip space: what a scene is drawn with. `None`
    /// for pictures that no matrix makes.
    #[must_use]
    pub fn clip_from_world(&self) -> Option<Mat4> {
        match self.projection {
            Projection::Matrix { clip_from_view, .. } => {
                Some(clip_from_view * Mat4::from_mat3(self.view_from_world))
            }
            Projection::Fisheye { .. } | Projection::Equirectangular => None,
        }
    }

    pub(crate) const fn is_panorama(&self) -> bool {
        !matches!(self.projection, Projection::Matrix { .. })
    }

    /// What the shaders read. `seam_azimuth` is the azimuth from the sun of the picture's left edge,
    /// where the dome of an equirectangular picture is cut.
    pub(crate) fn uniform(&self, local: [Vec3; 3], dome: Dome) -> ViewUniform {
        let rotation = Mat4::from_mat3(self.view_from_world);
        let (kind, aspect, far_depth, world_to_clip) = match self.projection {
            Projection::Matrix {
                clip_from_view,
                far_depth,
            } => (0.0, 1.0, far_depth, clip_from_view * rotation),
            Projection::Fisheye { aspect } => (1.0, aspect, 0.0, rotation),
            Projection::Equirectangular => (2.0, 1.0, 0.0, rotation),
        };
        // the picture's left edge looks backward
        let backward = -(self.view_from_world.transpose() * Vec3::Y);
        let seam = backward.dot(local[1]).atan2(backward.dot(local[0]));
        // azimuths grow to the left, the picture's to the right
        let turned = if kind > 1.5 { seam } else { 0.0 };
        ViewUniform {
            clip_to_world: world_to_clip.inverse(),
            world_to_clip,
            kind: [
                kind,
                1.0 - far_depth,
                aspect,
                f32::from(u8::from(self.depth_is_distance)),
            ],
            viewport: [
                self.viewport_origin[0],
                self.viewport_origin[1],
                self.km_per_unit,
                0.0,
            ],
            dome: [
                f32::from(dome.rings),
                f32::from(dome.spokes),
                turned,
                far_depth,
            ],
        }
    }

    /// From clip space to the frame of the given axes in the world.
    #[must_use]
    pub fn clip_to_local(&self, axes: [Vec3; 3]) -> Mat4 {
        let local = Mat3::from_cols(axes[0], axes[1], axes[2]).transpose();
        Mat4::from_mat3(local) * self.uniform(axes, Dome::REPORT).clip_to_world
    }

    /// The world direction of a place in the picture, −1..1 to the right and up; `None` outside a
    /// fisheye's disc. The twin of the shader's.
    #[must_use]
    pub fn direction(&self, clip: [f32; 2]) -> Option<Vec3> {
        let world_from_view = self.view_from_world.transpose();
        match self.projection {
            Projection::Matrix {
                clip_from_view,
                far_depth,
            } => {
                let seen =
                    clip_from_view.inverse() * Vec4::new(clip[0], clip[1], 1.0 - far_depth, 1.0);
                Some((world_from_view * (seen.truncate() / seen.w)).normalize())
            }
            Projection::Fisheye { aspect } => {
                let disc = [clip[0] * aspect.max(1.0), clip[1] / aspect.min(1.0)];
                let radius = disc[0].hypot(disc[1]);
                if radius > 1.0 {
                    return None;
                }
                let (sine, cosine) = (radius * core::f32::consts::FRAC_PI_2).sin_cos();
                let s = sine / radius.max(1e-6);
                Some(world_from_view * Vec3::new(disc[0] * s, disc[1] * s, cosine))
            }
            Projection::Equirectangular => {
                let (sin_azimuth, cos_azimuth) = (clip[0] * core::f32::consts::PI).sin_cos();
                let (sin_up, cos_up) = (clip[1] * core::f32::consts::FRAC_PI_2).sin_cos();
                Some(
                    world_from_view * Vec3::new(sin_azimuth * cos_up, cos_azimuth * cos_up, sin_up),
                )
            }
        }
    }
}
