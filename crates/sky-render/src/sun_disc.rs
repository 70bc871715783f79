//! The sun's disc in a panorama of light: spread over pixels that may be larger than itself.
//!
//! A disc of half a degree between the centers of pixels is lost, and one on a center fills the whole
//! pixel. Here every point of the disc gives its light to the four pixels around it, in shares that keep
//! its sum and its illuminance on a horizontal plane at every size. Simplification: points are nearer to
//! each other than pixels of pictures up to 8192 across.

use core::f64::consts::{PI, TAU};

use glam::{Mat3, Vec2, Vec3};
use sky_core::picture::Picture;
use sky_core::quantity::single;

use crate::terrain::SceneBuffers;

/// Points across the disc.
const ACROSS: u16 = 128;

/// Which picture it is: pixels, from the world to right, forward and up, and the sun's axes in the world.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Panorama {
    pub(crate) size: [u32; 2],
    pub(crate) view_from_world: Mat3,
    pub(crate) axes: [Vec3; 3],
}

/// Adds the disc to an equirectangular picture in linear sRGB \[cd·m⁻²\].
pub(crate) fn spread_sun(
    lights: &mut [f32],
    panorama: &Panorama,
    picture: &Picture,
    scene: Option<&SceneBuffers>,
) {
    let points = points(picture);
    let whole = points.iter().fold([0.0; 3], |sum, (_, light)| {
        core::array::from_fn(|c| sum[c] + f64::from(light[c]))
    });
    let grid = Grid::new(panorama.size);
    for (local, light) in &points {
        let world = (0..3).fold(Vec3::ZERO, |sum, i| sum + panorama.axes[i] * local[i]);
        let place = grid.place(panorama.view_from_world * world);
        if scene.is_some_and(|scene| grid.is_hidden(place, scene)) {
            continue;
        }
        // of the sunlight on a plane facing the sun [lx], what comes from this point
        let point = core::array::from_fn(|c| {
            f64::from(picture.light.sun_normal[c]) * f64::from(light[c]) / whole[c].max(1e-300)
        });
        grid.add(lights, place, f64::from(local[2]), point);
    }
}

/// Directions over the disc, each for an equal solid angle, in the local frame, with their light.
fn points(picture: &Picture) -> Vec<([f32; 3], [f32; 3])> {
    let [sin_sun, cos_sun] = picture.sky.sun();
    let radius = picture.sun.sin_radius;
    let toward = Vec3::new(sin_sun, 0.0, cos_sun);
    let down = Vec3::new(cos_sun, 0.0, -sin_sun);
    let place = |i: u16| (2.0 * f32::from(i) + 1.0) / f32::from(ACROSS) - 1.0;
    (0..ACROSS)
        .flat_map(|i| (0..ACROSS).map(move |j| Vec2::new(place(i), place(j)) * radius))
        .filter_map(|at| {
            let sine = at.length();
            let cosine = (1.0 - sine * sine).max(0.0).sqrt();
            let direction = toward * cosine + Vec3::Y * at.x + down * at.y;
            let light = picture.sun.light(sine, cosine, direction.z);
            let is_up = direction.z >= picture.sky.cos_horizon();
            (is_up && light[1] > 0.0).then_some((direction.to_array(), light))
        })
        .collect()
}

/// Pixels of an equirectangular picture.
struct Grid {
    size: [usize; 2],
    /// Width and height.
    sides: [f64; 2],
}

impl Grid {
    fn new(size: [u32; 2]) -> Self {
        Self {
            size: size.map(|side| side as usize),
            sides: size.map(f64::from),
        }
    }

    /// Columns and rows from the center of the first pixel, by a direction right, forward and up.
    fn place(&self, view: Vec3) -> [f64; 2] {
        let [right, forward, up] = view.as_dvec3().to_array();
        let [width, height] = self.sides;
        [
            (right.atan2(forward) / TAU + 0.5) * width - 0.5,
            up.clamp(-1.0, 1.0).acos() / PI * height - 0.5,
        ]
    }

    /// Cosine of the zenith angle of a row, counted from the edge of the first.
    fn cosine(&self, row: f64) -> f64 {
        (row / self.sides[1] * PI).cos()
    }

    fn is_hidden(&self, [column, row]: [f64; 2], scene: &SceneBuffers) -> bool {
        let [x, y] = [column, row].map(|at| at.round().max(0.0));
        let x = x % self.sides[0];
        let y = y.min(self.sides[1] - 1.0);
        scene.at(whole(x), whole(y)).is_some()
    }

    /// Gives a point's light \[lx\] to the four pixels around it.
    ///
    /// Two rows share it so that its zenith angle's cosine is kept. Where one of them looks below the
    /// horizontal, only the other is seen by a plane that faces up, and takes what it needs for that.
    fn add(&self, lights: &mut [f32], [column, row]: [f64; 2], cosine: f64, point: [f64; 3]) {
        let [width, height] = self.sides;
        let upper = row.floor().clamp(0.0, height - 1.0);
        let lower = (row.floor() + 1.0).clamp(0.0, height - 1.0);
        let [above, below] = [upper, lower].map(|row| self.cosine(row + 0.5));
        let to_upper = if lower <= upper {
            1.0
        } else if above > 0.0 && below < 0.0 {
            cosine.max(0.0) / above
        } else {
            (cosine - below) / (above - below)
        };
        let to_upper = to_upper.clamp(0.0, 1.0);
        let left = column.floor();
        let to_right = column - left;
        for (row, row_share) in [(upper, to_upper), (lower, 1.0 - to_upper)] {
            let solid_angle = TAU / width * (self.cosine(row) - self.cosine(row + 1.0));
            for (column, share) in [(left, 1.0 - to_right), (left + 1.0, to_right)] {
                let column = whole(column.rem_euclid(width)) as usize;
                let first = 3 * (whole(row) as usize * self.size[0] + column);
                for (sum, c) in lights[first..first + 3].iter_mut().zip(point) {
                    *sum += single(c * row_share * share / solid_angle);
                }
            }
        }
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a row or column of a picture"
)]
fn whole(place: f64) -> u32 {
    place as u32
}

#[cfg(test)]
mod tests {
    use sky_core::conditions::Conditions;
    use sky_core::quantity::{Angle, Length};
    use sky_core::utm_sky::UtmSky;
    use sky_gpu::{Camera, Projection, Tier};

    use super::*;
    use crate::camera::facing;
    use crate::shot::{GROUND_ALBEDO, Scenery, Shot};

    fn shot(size: [u32; 2], altitude_km: f64, sun_zenith_deg: f64, azimuth_deg: f64) -> Shot {
        Shot {
            conditions: Conditions {
                observer_altitude: Length::from_km(altitude_km),
                turbidity: 2.0,
                sun_zenith: Angle::from_degrees(sun_zenith_deg),
            },
            sun_azimuth: Angle::from_degrees(azimuth_deg),
            camera: Camera::panorama(Projection::Equirectangular, facing(100.0)),
            size,
            ev100: None,
            tone: None,
            tier: Tier::Fragment,
            sun_disc: true,
            scenery: Scenery::None,
            aerial: true,
        }
    }

    /// Light on a horizontal plane facing up, and on one facing each pixel \[lx\], green.
    fn illuminance(lights: &[f32], size: [u32; 2]) -> [f64; 2] {
        let grid = Grid::new(size);
        let rows = lights.chunks_exact(3 * grid.size[0]).enumerate();
        rows.fold([0.0; 2], |[horizontal, normal], (row, pixels)| {
            let row = f64::from(u32::try_from(row).unwrap());
            let solid_angle = TAU / grid.sides[0] * (grid.cosine(row) - grid.cosine(row + 1.0));
            let sum: f64 = pixels.chunks_exact(3).map(|p| f64::from(p[1])).sum();
            let light = sum * solid_angle;
            [
                horizontal + light * grid.cosine(row + 0.5).max(0.0),
                normal + light,
            ]
        })
    }

    #[test]
    fn a7_a_panorama_of_light_holds_the_whole_sun_at_every_size() {
        let sky = UtmSky::embedded().unwrap();
        for size in [[32, 16], [64, 32], [128, 65], [512, 256], [1024, 512]] {
            for (altitude_km, sun) in [
                (0.0, 0.0),
                (0.0, 0.3),
                (0.0, 23.456),
                (2.0, 60.0),
                (0.0, 85.1),
                (10.0, 89.0),
            ] {
                for azimuth in [0.0, 133.7, 280.0] {
                    let shot = shot(size, altitude_km, sun, azimuth);
                    let picture = Picture::new(&sky, &shot.conditions, GROUND_ALBEDO).unwrap();
                    let mut lights = vec![0.0; 3 * (size[0] * size[1]) as usize];
                    spread_sun(&mut lights, &shot.panorama(), &picture, None);
                    let [horizontal, normal] = illuminance(&lights, size);
                    let sun_normal = f64::from(picture.light.sun_normal[1]);
                    let expected = sun_normal * Angle::from_degrees(sun).radians().cos();
                    let case = format!("{size:?}, {altitude_km} km, sun {sun}, {azimuth}");
                    assert!(
                        (horizontal / expected - 1.0).abs() < 0.01,
                        "{case}: horizontal {horizontal}, {expected}"
                    );
                    assert!(
                        (normal / sun_normal - 1.0).abs() < 1e-4,
                        "{case}: normal {normal}, {sun_normal}"
                    );
                }
            }
        }
    }

    #[test]
    fn a7_the_disc_lies_where_the_sun_is() {
        let sky = UtmSky::embedded().unwrap();
        let size = [256, 128];
        let shot = shot(size, 0.0, 60.0, 145.0);
        let picture = Picture::new(&sky, &shot.conditions, GROUND_ALBEDO).unwrap();
        let mut lights = vec![0.0; 3 * (size[0] * size[1]) as usize];
        spread_sun(&mut lights, &shot.panorama(), &picture, None);
        let brightest = (0..lights.len() / 3)
            .max_by(|a, b| lights[3 * a].total_cmp(&lights[3 * b]))
            .unwrap();
        // 45° right of the middle, 60° below the upper edge
        let (x, y) = (brightest % 256, brightest / 256);
        assert!(
            (159..=160).contains(&x) && (42..=43).contains(&y),
            "{x} {y}"
        );
        assert!(lights.iter().filter(|l| **l > 0.0).count() <= 3 * 9);
    }

    #[test]
    fn a7_the_picture_by_the_cpu_agrees_with_the_light() {
        let sky = UtmSky::embedded().unwrap();
        for (size, sun) in [([64, 32], 30.0), ([100, 50], 57.3), ([180, 90], 80.0)] {
            let shot = shot(size, 0.0, sun, 200.0);
            let picture = Picture::new(&sky, &shot.conditions, GROUND_ALBEDO).unwrap();
            let crate::Pixels::Linear(lights) = crate::draw_on_cpu(&sky, &shot).unwrap() else {
                panic!("expected linear light");
            };
            let [horizontal, _] = illuminance(&lights, size);
            let sunlight =
                f64::from(picture.light.sun_normal[1]) * Angle::from_degrees(sun).radians().cos();
            let expected = f64::from(picture.light.sky_horizontal[1]) + sunlight;
            // the rest is the sky between the centers of pixels
            assert!(
                (horizontal / expected - 1.0).abs() < 0.01,
                "{size:?}, sun {sun}: {horizontal}, {expected}"
            );
        }
    }
}
