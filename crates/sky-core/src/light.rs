//! What a scene is lit with: the sun's direct light, the sky's illuminance, and the sky as nine
//! spherical-harmonic coefficients for materials.
//!
//! Colors are linear sRGB whose luminance is in the stated unit. Simplifications: the ground below
//! the horizon is uniform, lit by sun and sky, and seen without air. Out of scope: shadows, clouds.

use crate::aerial::AerialFrame;
use crate::quantity::{Angle, single};
use crate::utm_sky::SkyFrame;

/// The sun's angular radius, of the mean distance \[deg\].
pub const SUN_RADIUS_DEG: f64 = 0.2666;

/// Limb darkening in the visible, I(μ) = I₀(1 − u(1 − μ)). Source: Cox (ed.), Allen's Astrophysical
/// Quantities, 4th ed., §14.7, near 550 nm.
pub const LIMB_DARKENING: f32 = 0.6;

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

/// Solid angle of a disc of an angular radius \[sr\]: 4π sin²(r/2), for 1 − cos r cancels in f32.
#[must_use]
pub fn disc_solid_angle(radius: f32) -> f32 {
    let half = (0.5 * radius).sin();
    4.0 * core::f32::consts::PI * half * half
}

/// The part of the sun's disc above a straight horizon, weighted by [`LIMB_DARKENING`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VisibleSun {
    /// Its share of the whole disc's light, 0 to 1.
    pub share: f32,
    /// Cosine of the zenith angle of its center of light: the sun's own while all of it is up.
    pub cosine: f32,
}

impl VisibleSun {
    /// The part above the geometric horizon, from sine and cosine of the sun's zenith angle and the
    /// cosine of the horizon's.
    #[must_use]
    pub fn new([sin_sun, cos_sun]: [f32; 2], cos_horizon: f32) -> Self {
        let [sin_sun, cos_sun, cos_horizon] = [sin_sun, cos_sun, cos_horizon].map(f64::from);
        let sin_horizon = (1.0 - cos_horizon * cos_horizon).max(0.0).sqrt();
        // the difference of the two angles, exact where they are close
        let above = (cos_sun * sin_horizon - sin_sun * cos_horizon)
            .atan2(cos_sun * cos_horizon + sin_sun * sin_horizon);
        let radius = Angle::from_degrees(SUN_RADIUS_DEG).radians();
        let (share, center) = segment(above / radius);
        let (sin_up, cos_up) = (center * radius).sin_cos();
        Self {
            share: single(share),
            cosine: single(cos_sun * cos_up + sin_sun * sin_up),
        }
    }
}

/// Share of the light of a limb-darkened disc above a straight edge, and how far the center of that
/// light lies above the disc's own; in radii, from how far the disc's center stands above the edge.
///
/// With the brightness 1 − u + u √(1 − r²) the light of a chord at height y is
/// 2(1 − u) √(1 − y²) + u (π/2)(1 − y²), which integrates in closed form.
#[must_use]
pub fn segment(above: f64) -> (f64, f64) {
    use core::f64::consts::PI;
    if above >= 1.0 {
        return (1.0, 0.0);
    }
    if above <= -1.0 {
        return (0.0, 1.0);
    }
    let limb = f64::from(LIMB_DARKENING);
    let chord = 1.0 - above * above;
    let flat = PI - above.acos() + above * chord.sqrt();
    let dome = 0.5 * PI * (2.0 / 3.0 + above - above * above * above / 3.0);
    let light = (1.0 - limb) * flat + limb * dome;
    let moment =
        (1.0 - limb) * (2.0 / 3.0) * chord * chord.sqrt() + limb * (PI / 8.0) * chord * chord;
    let share = (light / (PI * (1.0 - limb / 3.0))).clamp(0.0, 1.0);
    // of the last sliver the middle is as good, and it is not a quotient of rounding errors
    let center = if chord < 1e-6 && above < 0.0 {
        0.5 * (1.0 - above)
    } else {
        moment / light
    };
    (share, center)
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
    pub fn light(&self, sine: f32, mu: f32, cosine: f32) -> [f32; 3] {
        if mu < 0.0 || sine >= self.sin_radius {
            return [0.0; 3];
        }
        let from_center = sine / self.sin_radius;
        let limb = 1.0 - LIMB_DARKENING * (1.0 - (1.0 - from_center * from_center).sqrt());
        let [upper, lower] = self.cosines;
        let share = ((cosine - lower) / (upper - lower).max(1e-9)).clamp(0.0, 1.0);
        core::array::from_fn(|c| limb * (self.lower[c] + share * (self.upper[c] - self.lower[c])))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A limb-darkened disc summed point by point: the light above an edge and its center.
    fn summed(above: f64) -> (f64, f64) {
        let (mut whole, mut light, mut moment) = (0.0, 0.0, 0.0);
        let steps = 1000_u16;
        let place = |i: u16| (f64::from(i) + 0.5) / f64::from(steps) * 2.0 - 1.0;
        for y in (0..steps).map(place) {
            for x in (0..steps).map(place) {
                let height = 1.0 - x * x - y * y;
                if height > 0.0 {
                    let here = 1.0 - f64::from(LIMB_DARKENING) * (1.0 - height.sqrt());
                    whole += here;
                    if y > -above {
                        light += here;
                        moment += here * y;
                    }
                }
            }
        }
        (light / whole, moment / light)
    }

    #[test]
    fn a6_the_segment_of_the_disc_is_the_sum_over_its_points() {
        for above in [-0.9, -0.5, 0.0, 0.2, 0.7, 0.99] {
            let (share, center) = segment(above);
            let (want_share, want_center) = summed(above);
            assert!(
                (share - want_share).abs() < 1e-3,
                "{above}: {share} {want_share}"
            );
            assert!(
                (center - want_center).abs() < 2e-3,
                "{above}: {center} {want_center}"
            );
        }
    }

    #[test]
    fn a6_the_share_has_exact_ends_and_never_falls() {
        assert_eq!(segment(1.0), (1.0, 0.0));
        assert_eq!(segment(7.0), (1.0, 0.0));
        assert_eq!(segment(-1.0), (0.0, 1.0));
        assert!((segment(0.0).0 - 0.5).abs() < 1e-15);
        let mut last = (0.0, 1.0);
        for i in -10_000..=10_000_i32 {
            let here = segment(f64::from(i) * 1e-4);
            assert!(
                here.0 >= last.0 && here.0 - last.0 < 1e-4,
                "{i}: {here:?} {last:?}"
            );
            assert!(
                here.1 <= last.1 + 1e-9 && last.1 - here.1 < 2e-4,
                "{i}: {here:?} {last:?}"
            );
            last = here;
        }
    }

    #[test]
    fn a6_a_sun_that_is_up_keeps_its_own_zenith_angle_to_the_last_bit() {
        for zenith in [0.0, 30.0, 89.7_f64] {
            let (sine, cosine) = Angle::from_degrees(zenith).radians().sin_cos();
            let [sine, cosine] = [sine, cosine].map(single);
            let sun = VisibleSun::new([sine, cosine], 0.0);
            assert_eq!(sun, VisibleSun { share: 1.0, cosine });
        }
    }

    #[test]
    fn a16_the_solid_angle_of_the_disc_does_not_cancel() {
        let radius = Angle::from_degrees(SUN_RADIUS_DEG).radians();
        let exact = 2.0 * core::f64::consts::PI * (1.0 - radius.cos());
        let found = f64::from(disc_solid_angle(single(radius)));
        assert!((found / exact - 1.0).abs() < 1e-6, "{found} {exact}");
    }
}
