//! A procedural terrain of several hundred kilometers with ridges, so that aerial perspective has
//! something to act on. Drawn by marching rays over the curved Earth; light and distance a pixel. As a
//! mesh, for a window, it is in `sky-view`.

use glam::Vec3;
use rayon::prelude::*;
use sky_core::picture::Picture;
use sky_core::quantity::Length;

/// Earth's radius \[km\].
pub const RADIUS_KM: f32 = 6371.0;
/// Highest ridge \[km\].
pub const HIGHEST_KM: f32 = 3.2;
/// Farthest ground that is looked for \[km\].
const FARTHEST_KM: f32 = 700.0;
/// Octaves of the ridges.
const OCTAVES: u8 = 7;

/// A scene's light and distances, pixel by pixel.
#[derive(Clone, Debug)]
pub struct SceneBuffers {
    width: u32,
    /// Linear sRGB \[cd·m⁻²\] and 1, four numbers a pixel.
    pub light: Vec<f32>,
    /// Distance \[km\], 0 for the sky.
    pub distance_km: Vec<f32>,
}

impl SceneBuffers {
    /// A scene from light and distance a pixel.
    #[must_use]
    pub fn new(width: u32, pixels: impl Iterator<Item = ([f32; 3], f32)>) -> Self {
        let (mut light, mut distance_km) = (Vec::new(), Vec::new());
        for ([r, g, b], distance) in pixels {
            light.extend([r, g, b, 1.0]);
            distance_km.push(distance);
        }
        Self {
            width,
            light,
            distance_km,
        }
    }

    /// Light and distance of a pixel that is not sky.
    #[must_use]
    pub fn at(&self, x: u32, y: u32) -> Option<([f32; 3], f32)> {
        let i = (y * self.width + x) as usize;
        let distance = self.distance_km[i];
        (distance > 0.0).then(|| {
            let l = &self.light[4 * i..];
            ([l[0], l[1], l[2]], distance)
        })
    }
}

/// The terrain as a camera sees it: `direction` is that of a pixel, `None` where there is none.
#[must_use]
pub fn terrain(
    picture: &Picture,
    [width, height]: [u32; 2],
    axes: [Vec3; 3],
    direction: &(dyn Fn(u32, u32) -> Option<Vec3> + Sync),
) -> SceneBuffers {
    let pixels: Vec<_> = (0..height)
        .into_par_iter()
        .flat_map_iter(|y| (0..width).map(move |x| (x, y)))
        .map(|(x, y)| {
            direction(x, y)
                .and_then(|d| march(picture.altitude_km, d))
                .map_or(([0.0; 3], 0.0), |(distance, place)| {
                    (shade(picture, axes, place), distance)
                })
        })
        .collect();
    SceneBuffers::new(width, pixels.into_iter())
}

/// A point of the ground: east and north of the observer, and height \[km\].
#[derive(Clone, Copy)]
struct Ground {
    east: f32,
    north: f32,
    height: f32,
}

/// Altitude of a ray and the ground under it.
fn under(altitude_km: f32, direction: Vec3, distance: f32) -> (f32, f32, f32) {
    let radius = RADIUS_KM + altitude_km;
    let rise = distance * (distance + 2.0 * radius * direction.z);
    let there = (radius * radius + rise).max(1.0).sqrt();
    let altitude = altitude_km + rise / (there + radius);
    // along the ground
    let flat = direction.truncate().length();
    let arc = RADIUS_KM * (distance * flat).atan2(radius + distance * direction.z);
    let scale = if flat > 0.0 { arc / flat } else { 0.0 };
    (altitude, scale * direction.x, scale * direction.y)
}

/// The lowest altitude of an eye at the middle of the terrain: 2 m above the ground.
#[must_use]
pub fn lowest_eye() -> Length {
    Length::from_km(f64::from(ridges(0.0, 0.0)) + 0.002)
}

fn march(altitude_km: f32, direction: Vec3) -> Option<(f32, Ground)> {
    let start = altitude_km;
    let mut distance = 0.0;
    let mut step = 0.0;
    while distance < FARTHEST_KM {
        let (altitude, east, north) = under(start, direction, distance);
        if altitude > HIGHEST_KM && direction.z >= 0.0 {
            return None;
        }
        let ground = if altitude > HIGHEST_KM {
            0.0
        } else {
            ridges(east, north)
        };
        let clearance = altitude - ground;
        if clearance <= 0.0 {
            return Some(refine(start, direction, distance - step, distance));
        }
        step = (0.4 * clearance).max(0.004 + 0.005 * distance);
        distance += step;
    }
    None
}

/// Where the ray enters the ground between two distances.
fn refine(start: f32, direction: Vec3, mut above: f32, mut below: f32) -> (f32, Ground) {
    for _ in 0..12 {
        let middle = 0.5 * (above + below);
        let (altitude, east, north) = under(start, direction, middle);
        if altitude > ridges(east, north) {
            above = middle;
        } else {
            below = middle;
        }
    }
    let (_, east, north) = under(start, direction, below);
    let height = ridges(east, north);
    // no shorter than f32 and the path formula can tell from 0
    (
        below.max(1e-3),
        Ground {
            east,
            north,
            height,
        },
    )
}

/// Light of a place. Twin: `ground_fragment` in `ground.wgsl` of `sky-view`.
fn shade(picture: &Picture, axes: [Vec3; 3], place: Ground) -> [f32; 3] {
    const ACROSS: f32 = 0.05;
    let slope_east = (ridges(place.east + ACROSS, place.north) - place.height) / ACROSS;
    let slope_north = (ridges(place.east, place.north + ACROSS) - place.height) / ACROSS;
    let normal = Vec3::new(-slope_east, -slope_north, 1.0).normalize();
    let [sin_sun, cos_sun] = picture.sky.sun();
    let sun = axes[0] * sin_sun + axes[2] * cos_sun;
    let snow = ((place.height - 2.0) * 2.0).clamp(0.0, 1.0) * normal.z.powi(4);
    let forest = [0.05, 0.09, 0.035];
    let rock = [0.20, 0.18, 0.15];
    let bare = (1.0 - normal.z).clamp(0.0, 0.4) * 2.5;
    let light = &picture.light;
    let open = 0.5 + 0.5 * normal.z;
    core::array::from_fn(|c| {
        let ground = forest[c] + bare * (rock[c] - forest[c]);
        let albedo = ground + snow * (0.75 - ground);
        let lit = light.sun_normal[c] * normal.dot(sun).max(0.0) + light.sky_horizontal[c] * open;
        albedo / core::f32::consts::PI * lit
    })
}

/// Height of the ground \[km\]: ridged noise, gentler where it is low.
pub fn ridges(east: f32, north: f32) -> f32 {
    let (mut x, mut y) = (east / 40.0 + 7.3, north / 40.0 + 2.9);
    let (mut sum, mut amplitude, mut weight) = (0.0, 0.55, 1.0);
    for octave in 0..OCTAVES {
        let ridge = 1.0 - noise(x, y, octave).abs();
        let ridge = ridge * ridge * weight;
        sum += amplitude * ridge;
        weight = (ridge * 1.6).clamp(0.0, 1.0);
        amplitude *= 0.48;
        (x, y) = (1.6 * x + 1.2 * y, 1.6 * y - 1.2 * x);
    }
    let lift = (0.6 + 0.9 * noise(east / 130.0, north / 130.0, 31)).clamp(0.1, 1.0);
    HIGHEST_KM * (1.2 * sum * lift - 0.12).clamp(0.0, 1.0)
}

/// Smooth noise, −1..1.
fn noise(x: f32, y: f32, seed: u8) -> f32 {
    let (cell_x, cell_y) = (x.floor(), y.floor());
    let (u, v) = (x - cell_x, y - cell_y);
    let fade = |t: f32| t * t * t * (t * (6.0 * t - 15.0) + 10.0);
    let corner = |dx: f32, dy: f32| {
        let [gx, gy] = GRADIENTS[hash(cell_x + dx, cell_y + dy, seed)];
        gx * (u - dx) + gy * (v - dy)
    };
    let (a, b, c, d) = (
        corner(0.0, 0.0),
        corner(1.0, 0.0),
        corner(0.0, 1.0),
        corner(1.0, 1.0),
    );
    let (u, v) = (fade(u), fade(v));
    1.5 * (a + u * (b - a) + v * ((c + u * (d - c)) - (a + u * (b - a))))
}

/// Directions of the slopes at the corners of the noise.
const GRADIENTS: [[f32; 2]; 8] = [
    [1.0, 0.0],
    [0.7, 0.7],
    [0.0, 1.0],
    [-0.7, 0.7],
    [-1.0, 0.0],
    [-0.7, -0.7],
    [0.0, -1.0],
    [0.7, -0.7],
];

/// One of eight from a cell.
fn hash(x: f32, y: f32, seed: u8) -> usize {
    let mut h = x
        .to_bits()
        .wrapping_mul(0x9E37_79B1)
        .wrapping_add(y.to_bits().wrapping_mul(0x85EB_CA77))
        .wrapping_add(u32::from(seed).wrapping_mul(0xC2B2_AE3D));
    h = (h ^ (h >> 15)).wrapping_mul(0x2C1B_3C6D);
    h = (h ^ (h >> 12)).wrapping_mul(0x297A_2D39);
    (h >> 29) as usize
}

#[cfg(test)]
mod tests {
    use sky_core::quantity::Angle;
    use sky_core::utm_sky::UtmSky;
    use sky_gpu::{Camera, Tier};

    use super::*;
    use crate::camera::looking;
    use crate::shot::{GROUND_ALBEDO, Scenery, Shot};

    /// Standing in the ground, the observer saw the terrain from above it and the sky from below: what
    /// neither showed was black dashes along the horizon.
    #[test]
    fn a11_what_is_not_terrain_is_sky() {
        let sky = UtmSky::embedded().expect("the table");
        let size = [320, 180];
        let shot = Shot {
            conditions: sky_core::conditions::Conditions {
                observer_altitude: Length::ZERO,
                turbidity: 2.0,
                sun_zenith: Angle::from_degrees(60.0),
            },
            sun_azimuth: Angle::ZERO,
            camera: Camera::perspective(1.0, 16.0 / 9.0, looking(0.0, 8.0)),
            size,
            ev100: None,
            tone: None,
            tier: Tier::Fragment,
            scenery: Scenery::Terrain,
            sun_disc: true,
            aerial: true,
        };
        let picture = Picture::new(&sky, &shot.standing(), GROUND_ALBEDO).expect("in the domain");
        let axes = shot.frame().local_axes();
        let direction = |x, y| shot.direction(x, y);
        let buffers = terrain(&picture, size, axes, &direction);
        let mut seen = [0, 0];
        for (x, y) in (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y))) {
            let world = direction(x, y).expect("a direction");
            let is_terrain = buffers.at(x, y).is_some();
            let is_sky = picture
                .sky
                .light(axes.map(|axis| axis.dot(world)))
                .is_some();
            assert!(is_terrain || is_sky, "{x} {y}: neither");
            seen[usize::from(is_terrain)] += 1;
        }
        assert!(seen.iter().all(|n| *n > 10_000), "{seen:?}");
    }
}
