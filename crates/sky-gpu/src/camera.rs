//! Where a picture is taken to: projection, orientation, viewport.

use glam::{Mat3, Mat4, Vec3, Vec4};
use sky_core::uniforms::{GROUND_RINGS, ViewUniform};

/// How directions become places in the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Any invertible projection matrix, the camera at the origin. Where it is orthographic the rays
    /// are parallel, and the air before a scene is that from the camera's altitude.
    Matrix {
        /// From the view's space to clip space.
        clip_from_view: Mat4,
        /// Depth of what is infinitely far: 0 for reversed depth, 1 otherwise.
        far_depth: f32,
    },
    /// The upper half of the sky as a disc, the zenith in its middle; angles are true from the center.
    /// Panoramas lie at depth 0.
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
    pub(crate) fn vertices(self) -> u32 {
        6 * (u32::from(self.rings) + u32::from(GROUND_RINGS)) * u32::from(self.spokes)
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

    /// The camera of an engine by its matrices, columns first: the projection, the depth of what is
    /// infinitely far, and from the world to the view, of which the translation is left out.
    #[must_use]
    pub fn from_matrices(
        clip_from_view: [[f32; 4]; 4],
        far_depth: f32,
        view_from_world: [[f32; 4]; 4],
    ) -> Self {
        Self {
            projection: Projection::Matrix {
                clip_from_view: Mat4::from_cols_array_2d(&clip_from_view),
                far_depth,
            },
            view_from_world: Mat3::from_mat4(Mat4::from_cols_array_2d(&view_from_world)),
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

    /// Whether all rays are parallel: clip space's w is the same everywhere.
    pub(crate) fn is_orthographic(&self) -> bool {
        match self.projection {
            Projection::Matrix { clip_from_view, .. } => {
                clip_from_view.row(3).truncate().abs().max_element() <= 1e-9
            }
            Projection::Fisheye { .. } | Projection::Equirectangular => false,
        }
    }

    /// World directions of rays, in clip x, clip y and 1. Of a perspective matrix the place of any
    /// depth does, for its direction is linear in clip space; of an orthographic one the direction is
    /// that from near to far.
    fn rays(&self) -> [Vec3; 3] {
        let Projection::Matrix {
            clip_from_view,
            far_depth,
        } = self.projection
        else {
            return [Vec3::ZERO; 3];
        };
        let view_from_clip = clip_from_view.inverse();
        let world_from_view = self.view_from_world.transpose();
        let near_depth = 1.0 - far_depth;
        let from = |column: Vec4| world_from_view * column.truncate();
        if self.is_orthographic() {
            let forward = from(view_from_clip.z_axis) * (far_depth - near_depth);
            return [Vec3::ZERO, Vec3::ZERO, forward.normalize_or_zero()];
        }
        let near = view_from_clip * Vec4::new(0.0, 0.0, near_depth, 1.0);
        let [x, y, center] =
            [view_from_clip.x_axis, view_from_clip.y_axis, near].map(|c| from(c) * near.w.signum());
        // of a length near 1, whatever the units of the matrix
        let scale = center.length_recip();
        [x * scale, y * scale, center * scale]
    }

    /// What the shaders read; the axes are those of the frame's local frame in the world.
    #[must_use]
    pub fn uniform(&self, local: [Vec3; 3], dome: Dome) -> ViewUniform {
        let rotation = Mat4::from_mat3(self.view_from_world);
        let (projection, aspect, far_depth, world_to_clip) = match self.projection {
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
        let [ray_x, ray_y, ray_center] = self.rays().map(|ray| ray.to_array());
        let flag = |on: bool| f32::from(u8::from(on));
        ViewUniform {
            clip_to_world: world_to_clip.inverse().to_cols_array_2d(),
            world_to_clip: world_to_clip.to_cols_array_2d(),
            ray_x,
            projection,
            ray_y,
            aspect,
            ray_center,
            far_depth,
            viewport_origin: self.viewport_origin,
            km_per_unit: self.km_per_unit,
            depth_is_distance: flag(self.depth_is_distance),
            dome_rings: f32::from(dome.rings),
            dome_spokes: f32::from(dome.spokes),
            // azimuths grow to the left, the picture's to the right
            dome_seam_azimuth: if projection > 1.5 { seam } else { 0.0 },
            rays_are_parallel: flag(self.is_orthographic()),
        }
    }

    /// From clip space to the frame of the given axes in the world.
    #[must_use]
    pub fn clip_to_local(&self, axes: [Vec3; 3]) -> Mat4 {
        let local = Mat3::from_cols(axes[0], axes[1], axes[2]).transpose();
        let world = Mat4::from_mat3(self.view_from_world);
        let clip_from_world = match self.projection {
            Projection::Matrix { clip_from_view, .. } => clip_from_view * world,
            Projection::Fisheye { .. } | Projection::Equirectangular => world,
        };
        Mat4::from_mat3(local) * clip_from_world.inverse()
    }

    /// The world direction of a place in the picture, −1..1 to the right and up; `None` outside a
    /// fisheye's disc. The twin of the shader's.
    #[must_use]
    pub fn direction(&self, clip: [f32; 2]) -> Option<Vec3> {
        let world_from_view = self.view_from_world.transpose();
        match self.projection {
            Projection::Matrix { .. } => {
                let [x, y, center] = self.rays();
                Some((x * clip[0] + y * clip[1] + center).normalize())
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Column by column, as an engine has it.
    fn orthographic(half: f32, near: f32, far: f32, reversed: bool) -> Mat4 {
        let (a, b) = if reversed { (far, near) } else { (near, far) };
        Mat4::from_cols(
            Vec4::new(1.0 / half, 0.0, 0.0, 0.0),
            Vec4::new(0.0, 1.0 / half, 0.0, 0.0),
            Vec4::new(0.0, 0.0, 1.0 / (a - b), 0.0),
            Vec4::new(0.0, 0.0, a / (a - b), 1.0),
        )
    }

    #[test]
    fn a18_orthographic_rays_are_parallel() {
        let looking = Mat3::from_cols(Vec3::X, Vec3::Z, -Vec3::Y).transpose();
        for (reversed, far_depth) in [(false, 1.0), (true, 0.0)] {
            let camera = Camera {
                projection: Projection::Matrix {
                    clip_from_view: orthographic(2000.0, 0.1, 5e4, reversed),
                    far_depth,
                },
                ..Camera::perspective(1.0, 1.0, looking)
            };
            for clip in [[0.0, 0.0], [-1.0, 1.0], [0.9, -0.3]] {
                let seen = camera.direction(clip).expect("a direction");
                assert!((seen - Vec3::Y).length() < 1e-6, "{clip:?}: {seen}");
            }
        }
    }

    /// Forward and reversed, near and far planes at hand, centered and not: the ray is the one on which
    /// a place of that direction lies.
    #[test]
    fn rays_are_those_of_the_places_that_the_matrix_puts_there() {
        let looking = Mat3::from_cols(Vec3::X, Vec3::Z, -Vec3::Y).transpose();
        let (f, near, far) = (1.3, 0.5, 2e4);
        for off_axis in [0.0, 0.4] {
            for (a, b, far_depth) in [
                (far / (near - far), near * far / (near - far), 1.0),
                (near / (far - near), near * far / (far - near), 0.0),
                (0.0, near, 0.0),
            ] {
                let clip_from_view = Mat4::from_cols(
                    Vec4::new(f, 0.0, 0.0, 0.0),
                    Vec4::new(0.0, f, 0.0, 0.0),
                    Vec4::new(off_axis, -off_axis, a, -1.0),
                    Vec4::new(0.0, 0.0, b, 0.0),
                );
                let view = Mat4::from_mat3(looking).to_cols_array_2d();
                let camera =
                    Camera::from_matrices(clip_from_view.to_cols_array_2d(), far_depth, view);
                for place in [Vec3::new(0.2, 1.0, -0.3), Vec3::new(-80.0, 200.0, 50.0)] {
                    let clip = clip_from_view * (looking * place).extend(1.0);
                    let seen = camera
                        .direction([clip.x / clip.w, clip.y / clip.w])
                        .expect("a direction");
                    assert!(
                        (seen - place.normalize()).length() < 1e-5,
                        "{place}: {seen}"
                    );
                }
            }
        }
    }
}
