//! What a scene is lit with: the sun's direct light, the sky's illuminance, and the sky as nine
//! spherical-harmonic coefficients for materials.
//!
//! Colors are linear sRGB whose luminance is in the stated unit. Simplifications: the ground below
//! the horizon is uniform, lit by sun and sky, and seen without air. Out of scope: shadows, clouds.

use crate::aerial::AerialFrame;
use crate::quantity::{Angle, single};
use crate::sun::{LIMB_DARKENING, SUN_RADIUS_DEG, VisibleSun, disc_solid_angle};
use crate::utm_sky::SkyFrame;

/// Nodes and weights of Gauss–Legendre's rule on 0..1, eight points.
const GAUSS: [[f32; 2]; 8] = [
    [0.019_855_07, 0.050_614_27],
    [0.101_666_76, 0.111_190_52],
    [0.237_233_8, 0.156_853_33],
    [0.408_282_68, 0.181_341_89],
    [0.591_717_3, 0.181_341_89],
    [0.762_766_2, 0.156_853_33],
    [0.898_333_25, 0.111_190_52],
    [0.980_144_9, 0.050_614_27],
];

/// Azimuths on the half circle; the other half is its mirror image.
const AZIMUTHS: u8 = 8;

/// The light of sky and sun on a scene, in the local frame of [`SkyFrame::light`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SceneLight {
    /// Sunlight on a plane facing the sun \[lx\], of the part of the disc above the horizon.
    pub sun_normal: [f32; 3],
    /// Light of the sky alone on a horizontal plane facing up \[lx\].
    pub sky_horizontal: [f32; 3],
    /// Light of the ground \[cd·m⁻²\]: albedo/π times sun and sky on the horizontal plane.
    pub ground: [f32; 3],
    /// Radiance of sky and ground \[cd·m⁻²\] as real spherical harmonics, in the order
    /// 1, y, z, x, xy, yz, 3z² − 1, xz, x² − y², each normalized.
    pub harmonics: [[f32; 3]; 9],
}

impl SceneLight {
    /// Integrates the sky.
    #[must_use]
    pub fn new(sky: &SkyFrame, air: &AerialFrame, altitude_km: f32, ground_albedo: f32) -> Self {
        let sun = VisibleSun::new(sky.sun(), sky.cos_horizon());
        let mut out = Self {
            sun_normal: air.sunlight(altitude_km, &sun),
            ..Self::default()
        };
        let pi = core::f32::consts::PI;
        let lowest = sky.cos_horizon();
        for [node, weight] in GAUSS {
            let cosine = lowest + (1.0 - lowest) * node;
            let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
            let solid_angle = weight * (1.0 - lowest) * pi / f32::from(AZIMUTHS);
            for i in 0..AZIMUTHS {
                let (y, x) = (pi * (f32::from(i) + 0.5) / f32::from(AZIMUTHS)).sin_cos();
                let direction = [sine * x, sine * y, cosine];
                let Some(rgb) = sky.linear_srgb(direction) else {
                    continue;
                };
                let mirrored = [direction[0], -direction[1], direction[2]];
                for direction in [direction, mirrored] {
                    add(&mut out.harmonics, direction, solid_angle, rgb);
                }
                for (sum, c) in out.sky_horizontal.iter_mut().zip(rgb) {
                    *sum += 2.0 * solid_angle * cosine.max(0.0) * c;
                }
            }
        }
        let sun_height = sun.cosine.max(0.0);
        for c in 0..3 {
            let light = out.sky_horizontal[c] + sun_height * out.sun_normal[c];
            out.ground[c] = ground_albedo / pi * light;
        }
        // the ground's part has no azimuth: three points in the cosine are exact for its square
        for [share, weight] in [
            [0.112_701_67, 5.0 / 18.0],
            [0.5, 8.0 / 18.0],
            [0.887_298_35, 5.0 / 18.0],
        ] {
            let cosine = -1.0 + (lowest + 1.0) * share;
            let solid_angle = weight * (lowest + 1.0) * 2.0 * pi;
            for (k, factor) in zonal(cosine) {
                for (sum, c) in out.harmonics[k].iter_mut().zip(out.ground) {
                    *sum += solid_angle * factor * c;
                }
            }
        }
        out
    }
}

/// The real spherical harmonics in a direction.
#[must_use]
pub fn harmonics([x, y, z]: [f32; 3]) -> [f32; 9] {
    [
        0.282_094_8,
        0.488_602_5 * y,
        0.488_602_5 * z,
        0.488_602_5 * x,
        1.092_548_4 * x * y,
        1.092_548_4 * y * z,
        0.315_391_57 * (3.0 * z * z - 1.0),
        1.092_548_4 * x * z,
        0.546_274_2 * (x * x - y * y),
    ]
}

/// Those without azimuth, by place.
fn zonal(z: f32) -> [(usize, f32); 3] {
    let all = harmonics([0.0, 0.0, z]);
    [(0, all[0]), (2, all[2]), (6, all[6])]
}

fn add(sums: &mut [[f32; 3]; 9], direction: [f32; 3], solid_angle: f32, rgb: [f32; 3]) {
    for (sum, factor) in sums.iter_mut().zip(harmonics(direction)) {
        for (sum, c) in sum.iter_mut().zip(rgb) {
            *sum += solid_angle * factor * c;
        }
    }
}

/// The sun's disc for one observer, drawn apart from the sky.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SunDisc {
    /// Light of the disc's center \[cd·m⁻²\] through the air at its upper limb, linear sRGB.
    pub upper: [f32; 3],
    /// The same at its lower limb, or at the horizon.
    pub lower: [f32; 3],
    /// Cosines of the view zenith angles that the two belong to.
    pub cosines: [f32; 2],
    /// Sine of the disc's angular radius.
    pub sin_radius: f32,
}

impl SunDisc {
    /// The disc that an observer sees.
    #[must_use]
    pub fn new(sky: &SkyFrame, air: &AerialFrame, altitude_km: f32) -> Self {
        let radius = single(Angle::from_degrees(SUN_RADIUS_DEG).radians());
        let (sin_radius, cos_radius) = radius.sin_cos();
        let [sin_sun, cos_sun] = sky.sun();
        let upper = cos_sun * cos_radius + sin_sun * sin_radius;
        let lower = (cos_sun * cos_radius - sin_sun * sin_radius).max(sky.cos_horizon());
        let solid_angle = disc_solid_angle(radius);
        // the disc's mean is its center times 1 − u/3
        let center = 1.0 / (solid_angle * (1.0 - LIMB_DARKENING / 3.0));
        let light = |cosine: f32| {
            let through = air.transmittance_to_space(altitude_km, cosine);
            core::array::from_fn(|c| air.sun_rgb[c] * through[c] * center)
        };
        if upper < sky.cos_horizon() {
            return Self {
                sin_radius,
                ..Self::default()
            };
        }
        Self {
            upper: light(upper.max(sky.cos_horizon())),
            lower: light(lower),
            cosines: [upper, lower],
            sin_radius,
        }
    }

    /// Light of the disc in a direction above the horizon \[cd·m⁻²\]; black outside it.
    ///
    /// `sine` is that of the angle from the sun's center, `cosine` that of the view zenith angle.
    #[must_use]
    pub fn light(&self, sine: f32, cos_gamma: f32, cosine: f32) -> [f32; 3] {
        if cos_gamma < 0.0 || sine >= self.sin_radius {
            return [0.0; 3];
        }
        let from_center = sine / self.sin_radius;
        let limb = 1.0 - LIMB_DARKENING * (1.0 - (1.0 - from_center * from_center).sqrt());
        let [upper, lower] = self.cosines;
        let share = ((cosine - lower) / (upper - lower).max(1e-9)).clamp(0.0, 1.0);
        core::array::from_fn(|c| limb * (self.lower[c] + share * (self.upper[c] - self.lower[c])))
    }
}
