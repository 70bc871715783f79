//! How far two skies differ: relative error, CIEDE2000, chromaticity error, hemispherical means.
//!
//! One convention for all figures of the project: the 5° around the sun are left out, and the white
//! of Lab is D65 at 2.5 times the median luminance of the map that is taken for true.

use palette::color_difference::Ciede2000;
use palette::white_point::D65;

use sky_core::color::{Xyz, Yxy, xyz_from_yxy};
use sky_core::direction::SkyDirection;
use sky_core::quantity::Angle;

/// Angle around the sun that comparisons leave out \[deg\].
pub const SUN_EXCLUSION_DEG: f64 = 5.0;

/// Luminance of Lab's white, in units of the map's median luminance.
pub const WHITE_PER_MEDIAN_LUMINANCE: f64 = 2.5;

/// Tristimulus values of the illuminant D65 for the 2° observer, Y = 1 (ISO/CIE 11664-2).
pub const D65_WHITE: Xyz = Xyz {
    x: 0.950_47,
    y: 1.0,
    z: 1.088_83,
};

/// CIE 1976 L\*a\*b\*.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lab {
    /// Lightness, 100 for white.
    pub lightness: f64,
    /// Green to red.
    pub a: f64,
    /// Blue to yellow.
    pub b: f64,
}

/// L\*a\*b\* of a light, for a D65 white of the given luminance \[cd·m⁻²\] (ISO/CIE 11664-4).
#[must_use]
pub fn lab_from_xyz(xyz: Xyz, white_luminance_cd_m2: f64) -> Lab {
    let f = |value: f64, white: f64| {
        let t = value / (white * white_luminance_cd_m2);
        const DELTA: f64 = 6.0 / 29.0;
        if t > DELTA * DELTA * DELTA {
            t.cbrt()
        } else {
            t / (3.0 * DELTA * DELTA) + 4.0 / 29.0
        }
    };
    let fx = f(xyz.x, D65_WHITE.x);
    let fy = f(xyz.y, D65_WHITE.y);
    let fz = f(xyz.z, D65_WHITE.z);
    Lab {
        lightness: 116.0 * fy - 16.0,
        a: 500.0 * (fx - fy),
        b: 200.0 * (fy - fz),
    }
}

/// CIEDE2000 color difference (ISO/CIE 11664-6), all parametric factors 1.
#[must_use]
pub fn ciede2000(first: Lab, second: Lab) -> f64 {
    let lab = |c: Lab| palette::Lab::<D65, f64>::new(c.lightness, c.a, c.b);
    lab(first).difference(lab(second))
}

/// CIEDE2000 between two lights, for a D65 white of the given luminance \[cd·m⁻²\].
#[must_use]
pub fn ciede2000_of_lights(first: Yxy, second: Yxy, white_luminance_cd_m2: f64) -> f64 {
    ciede2000(
        lab_from_xyz(xyz_from_yxy(first), white_luminance_cd_m2),
        lab_from_xyz(xyz_from_yxy(second), white_luminance_cd_m2),
    )
}

/// The project's white for a map: 2.5 times its median luminance \[cd·m⁻²\]; `None` for an empty map.
#[must_use]
pub fn white_luminance(map: &[Yxy]) -> Option<f64> {
    let luminances: Vec<f64> = map.iter().map(|c| c.luminance_cd_m2).collect();
    percentile(&luminances, 50.0).map(|median| WHITE_PER_MEDIAN_LUMINANCE * median)
}

/// The value below which `percent` of the values lie, interpolated linearly between ranks as numpy
/// does; `None` for no values. A NaN ranks above everything, so it is not lost.
#[must_use]
pub fn percentile(values: &[f64], percent: f64) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    percentile_of_sorted(&sorted, percent)
}

fn percentile_of_sorted(sorted: &[f64], percent: f64) -> Option<f64> {
    let last = sorted.len().checked_sub(1)?;
    #[expect(
        clippy::cast_precision_loss,
        reason = "maps have far fewer than 2^52 values"
    )]
    let rank = last as f64 * (percent / 100.0).clamp(0.0, 1.0);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a rank lies between 0 and the number of values"
    )]
    let below = (rank.floor() as usize).min(last);
    let above = (below + 1).min(last);
    let share = rank - rank.floor();
    if share > 0.0 {
        Some(sorted[below] + share * (sorted[above] - sorted[below]))
    } else {
        Some(sorted[below])
    }
}

/// Median, 95th percentile and maximum of errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Statistics {
    /// How many values.
    pub count: usize,
    /// Median.
    pub median: f64,
    /// 95th percentile.
    pub p95: f64,
    /// Maximum.
    pub max: f64,
}

impl Statistics {
    /// Of the given values; `None` for no values. A NaN among them makes the maximum NaN.
    #[must_use]
    pub fn of(values: &[f64]) -> Option<Self> {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        Some(Self {
            count: sorted.len(),
            median: percentile_of_sorted(&sorted, 50.0)?,
            p95: percentile_of_sorted(&sorted, 95.0)?,
            max: sorted.last().copied()?,
        })
    }
}

/// |found / reference − 1|. Zero against zero is no error; anything else against zero is infinite.
#[must_use]
pub fn relative_error(found: f64, reference: f64) -> f64 {
    let difference = (found - reference).abs();
    if difference == 0.0 {
        0.0
    } else {
        difference / reference.abs()
    }
}

/// Distance in the CIE 1931 x, y plane.
#[must_use]
pub fn chromaticity_error(first: Yxy, second: Yxy) -> f64 {
    (first.x - second.x).hypot(first.y - second.y)
}

/// CIE 1976 u′, v′ of a light; (0, 0) for black.
#[must_use]
pub fn uv_prime(light: Yxy) -> [f64; 2] {
    let denominator = -2.0 * light.x + 12.0 * light.y + 3.0;
    if light.x == 0.0 && light.y == 0.0 {
        return [0.0, 0.0];
    }
    [4.0 * light.x / denominator, 9.0 * light.y / denominator]
}

/// Distance in the CIE 1976 u′, v′ plane.
#[must_use]
pub fn uniform_chromaticity_error(first: Yxy, second: Yxy) -> f64 {
    let [u1, v1] = uv_prime(first);
    let [u2, v2] = uv_prime(second);
    (u1 - u2).hypot(v1 - v2)
}

/// Whether a direction is at least `exclusion` from the sun; comparisons use
/// [`SUN_EXCLUSION_DEG`].
#[must_use]
pub fn is_clear_of_sun(direction: &SkyDirection, sun_zenith: Angle, exclusion: Angle) -> bool {
    direction.scattering_angle(sun_zenith).radians() >= exclusion.radians()
}

/// Weights of directions in a cosine-weighted mean over the upper hemisphere; their sum is 1 when
/// a direction lies above the horizontal, and directions below it weigh nothing.
///
/// Directions of equal zenith angle form a ring. A ring stands for the zenith angles up to half way
/// to its neighbors, and within it a direction for the azimuths up to half way to its neighbors, so
/// whole and half circles of azimuth both work. `None` when no direction lies above the horizontal.
#[must_use]
pub fn cosine_weights(directions: &[SkyDirection]) -> Option<Vec<f64>> {
    const SAME_RAD: f64 = 1e-9;
    let horizontal = core::f64::consts::FRAC_PI_2;
    let mut order: Vec<usize> = (0..directions.len())
        .filter(|&i| directions[i].view_zenith.radians() <= horizontal + SAME_RAD)
        .collect();
    if order.is_empty() {
        return None;
    }
    let zenith = |i: usize| directions[i].view_zenith.radians();
    // Azimuth folded to 0..π: the sky is symmetric about the sun's vertical plane.
    let azimuth = |i: usize| {
        let turn = directions[i].relative_azimuth.radians();
        turn.cos().clamp(-1.0, 1.0).acos()
    };
    order.sort_by(|&i, &j| zenith(i).total_cmp(&zenith(j)));
    let rings = groups(&order, &zenith);
    let mut weights = vec![0.0; directions.len()];
    for (r, ring) in rings.iter().enumerate() {
        let lower = if r == 0 {
            0.0
        } else {
            0.5 * (zenith(rings[r - 1][0]) + zenith(ring[0]))
        };
        let upper = rings
            .get(r + 1)
            .map_or(horizontal, |next| 0.5 * (zenith(next[0]) + zenith(ring[0])));
        // The integral of 2 cos θ sin θ dθ is sin² θ.
        let ring_weight = upper.sin().powi(2) - lower.sin().powi(2);
        let mut by_azimuth = ring.clone();
        by_azimuth.sort_by(|&i, &j| azimuth(i).total_cmp(&azimuth(j)));
        let spokes = groups(&by_azimuth, &azimuth);
        for (s, spoke) in spokes.iter().enumerate() {
            let from = if s == 0 {
                0.0
            } else {
                0.5 * (azimuth(spokes[s - 1][0]) + azimuth(spoke[0]))
            };
            let to = spokes.get(s + 1).map_or(core::f64::consts::PI, |next| {
                0.5 * (azimuth(next[0]) + azimuth(spoke[0]))
            });
            let share = (to - from) / core::f64::consts::PI;
            for &i in spoke {
                #[expect(
                    clippy::cast_precision_loss,
                    reason = "a ring has far fewer than 2^52 directions"
                )]
                let twins = spoke.len() as f64;
                weights[i] = ring_weight * share / twins;
            }
        }
    }
    Some(weights)
}

/// Splits sorted indices into runs of equal key (within 1e-6 rad of their neighbor).
fn groups(sorted: &[usize], key: &dyn Fn(usize) -> f64) -> Vec<Vec<usize>> {
    const SAME_RAD: f64 = 1e-6;
    sorted
        .chunk_by(|&i, &j| key(j) - key(i) < SAME_RAD)
        .map(<[usize]>::to_vec)
        .collect()
}

/// Cosine-weighted mean over the upper hemisphere: for luminances it is the illuminance of the
/// horizontal plane divided by π. `None` when no direction lies above the horizontal.
///
/// # Panics
/// When there is not one value per direction.
#[must_use]
pub fn cosine_weighted_mean(directions: &[SkyDirection], values: &[f64]) -> Option<f64> {
    assert_eq!(directions.len(), values.len(), "one value per direction");
    let weights = cosine_weights(directions)?;
    Some(weights.iter().zip(values).map(|(w, v)| w * v).sum())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::direction::report_directions;

    fn close(found: f64, expected: f64, tolerance: f64) {
        assert!(
            (found - expected).abs() <= tolerance,
            "{found} is not {expected} within {tolerance}"
        );
    }

    /// Sharma, Wu & Dalal 2005 (Color Research & Application 30, 21–30), table 1: pairs that tell
    /// wrong implementations apart (hue wrap, the rotation term, near-neutral colors).
    #[test]
    fn ciede2000_matches_the_published_test_pairs() {
        type Pair = ([f64; 3], [f64; 3], f64);
        const PAIRS: [Pair; 20] = [
            ([50.0, 2.6772, -79.7751], [50.0, 0.0, -82.7485], 2.0425),
            ([50.0, 3.1571, -77.2803], [50.0, 0.0, -82.7485], 2.8615),
            ([50.0, 2.8361, -74.0200], [50.0, 0.0, -82.7485], 3.4412),
            ([50.0, -1.3802, -84.2814], [50.0, 0.0, -82.7485], 1.0),
            ([50.0, -1.1848, -84.8006], [50.0, 0.0, -82.7485], 1.0),
            ([50.0, -0.9009, -85.5211], [50.0, 0.0, -82.7485], 1.0),
            ([50.0, 0.0, 0.0], [50.0, -1.0, 2.0], 2.3669),
            ([50.0, -1.0, 2.0], [50.0, 0.0, 0.0], 2.3669),
            ([50.0, 2.4900, -0.0010], [50.0, -2.4900, 0.0009], 7.1792),
            ([50.0, 2.4900, -0.0010], [50.0, -2.4900, 0.0010], 7.1792),
            ([50.0, 2.4900, -0.0010], [50.0, -2.4900, 0.0011], 7.2195),
            ([50.0, 2.4900, -0.0010], [50.0, -2.4900, 0.0012], 7.2195),
            ([50.0, 2.5, 0.0], [73.0, 25.0, -18.0], 27.1492),
            ([50.0, 2.5, 0.0], [61.0, -5.0, 29.0], 22.8977),
            ([50.0, 2.5, 0.0], [56.0, -27.0, -3.0], 31.9030),
            ([50.0, 2.5, 0.0], [58.0, 24.0, 15.0], 19.4535),
            (
                [60.2574, -34.0099, 36.2677],
                [60.4626, -34.1751, 39.4387],
                1.2644,
            ),
            (
                [63.0109, -31.0961, -5.8663],
                [62.8187, -29.7946, -4.0864],
                1.2630,
            ),
            (
                [6.7747, -0.2908, -2.4247],
                [5.8714, -0.0985, -2.2286],
                0.6377,
            ),
            (
                [2.0776, 0.0795, -1.1350],
                [0.9033, -0.0636, -0.5514],
                0.9082,
            ),
        ];
        let lab = |[lightness, a, b]: [f64; 3]| Lab { lightness, a, b };
        for (first, second, expected) in PAIRS {
            close(ciede2000(lab(first), lab(second)), expected, 5e-5);
        }
    }

    #[test]
    fn lab_of_white_and_of_middle_gray() {
        let white = lab_from_xyz(
            Xyz {
                x: 950.47,
                y: 1000.0,
                z: 1088.83,
            },
            1000.0,
        );
        close(white.lightness, 100.0, 1e-12);
        close(white.a, 0.0, 1e-12);
        close(white.b, 0.0, 1e-12);
        // L* = 50 lies at Y/Yn = ((50 + 16)/116)³.
        let gray = (66.0_f64 / 116.0).powi(3);
        close(
            lab_from_xyz(
                Xyz {
                    x: 0.0,
                    y: gray,
                    z: 0.0,
                },
                1.0,
            )
            .lightness,
            50.0,
            1e-12,
        );
        // The straight part: L* = 903.296 Y/Yn.
        close(
            lab_from_xyz(
                Xyz {
                    x: 0.0,
                    y: 0.001,
                    z: 0.0,
                },
                1.0,
            )
            .lightness,
            0.903_296_3,
            1e-6,
        );
    }

    #[test]
    fn a_light_differs_from_itself_by_nothing_and_from_a_brighter_one_by_its_lightness() {
        let light = |luminance_cd_m2| Yxy {
            luminance_cd_m2,
            x: 0.312_72,
            y: 0.329_03,
        };
        close(
            ciede2000_of_lights(light(4000.0), light(4000.0), 10_000.0),
            0.0,
            1e-12,
        );
        let de = ciede2000_of_lights(light(4000.0), light(4040.0), 10_000.0);
        // dL* = 116 · 0.4^(1/3) · (1.01^(1/3) − 1) = 0.2840, divided by S_L = 1.2867 at L* = 69.61.
        close(de, 0.2207, 1e-4);
    }

    #[test]
    fn percentiles_are_those_of_numpy() {
        // numpy.percentile([1, 2, 3, 4, 10], [0, 50, 95, 100]) = 1, 3, 8.8, 10
        let v = [10.0, 3.0, 1.0, 4.0, 2.0];
        for (p, expected) in [(0.0, 1.0), (50.0, 3.0), (95.0, 8.8), (100.0, 10.0)] {
            close(percentile(&v, p).unwrap(), expected, 1e-12);
        }
        // numpy.percentile([1, 2], 25) = 1.25
        close(percentile(&[2.0, 1.0], 25.0).unwrap(), 1.25, 1e-12);
        assert!(percentile(&[], 50.0).is_none());
        let s = Statistics::of(&v).unwrap();
        assert_eq!(s.count, 5);
        close(s.median, 3.0, 1e-12);
        close(s.p95, 8.8, 1e-12);
        close(s.max, 10.0, 1e-12);
        assert!(Statistics::of(&[1.0, f64::NAN]).unwrap().max.is_nan());
        assert!(Statistics::of(&[]).is_none());
    }

    #[test]
    fn relative_errors_of_zero_are_visible() {
        close(relative_error(1.1, 1.0), 0.1, 1e-12);
        close(relative_error(0.9, 1.0), 0.1, 1e-12);
        close(relative_error(0.0, 0.0), 0.0, 0.0);
        assert!(relative_error(1.0, 0.0).is_infinite());
        assert!(relative_error(f64::NAN, 1.0).is_nan());
    }

    #[test]
    fn chromaticity_distances() {
        let a = Yxy {
            luminance_cd_m2: 1.0,
            x: 0.3127,
            y: 0.3290,
        };
        let b = Yxy {
            x: 0.3157,
            y: 0.3330,
            ..a
        };
        close(chromaticity_error(a, b), 0.005, 1e-12);
        // u', v' of D65: 0.1978, 0.4683.
        let [u, v] = uv_prime(a);
        close(u, 0.1978, 5e-5);
        close(v, 0.4683, 5e-5);
        close(uniform_chromaticity_error(a, a), 0.0, 0.0);
    }

    #[test]
    fn five_degrees_round_the_sun_are_left_out() {
        let sun = Angle::from_degrees(60.0);
        let limit = Angle::from_degrees(SUN_EXCLUSION_DEG);
        for (zenith, azimuth, clear) in [
            (60.0, 0.0, false),
            (64.9, 0.0, false),
            (65.1, 0.0, true),
            (60.0, 5.5, false),
            (60.0, 6.0, true),
            (60.0, 180.0, true),
        ] {
            let d = SkyDirection::from_degrees(zenith, azimuth);
            assert_eq!(is_clear_of_sun(&d, sun, limit), clear, "{zenith} {azimuth}");
        }
    }

    #[test]
    fn a_uniform_sky_has_its_own_mean_on_any_set_of_directions() {
        let whole = report_directions();
        let mut half = vec![SkyDirection::from_degrees(0.0, 0.0)];
        for z in [15.0, 30.0, 50.0, 80.0, 95.0] {
            for a in [0.0, 30.0, 90.0, 180.0] {
                half.push(SkyDirection::from_degrees(z, a));
            }
        }
        for set in [whole, half] {
            let mean = cosine_weighted_mean(&set, &vec![7.0; set.len()]).unwrap();
            close(mean, 7.0, 1e-12);
        }
        assert!(cosine_weights(&[SkyDirection::from_degrees(100.0, 0.0)]).is_none());
    }

    #[test]
    fn a_sky_that_goes_with_the_cosine_has_two_thirds_of_its_zenith_value() {
        // ∫ cos θ · 2 cos θ sin θ dθ = 2/3; the rings every 10° are midpoint sums of that.
        let set = report_directions();
        let values: Vec<f64> = set.iter().map(|d| d.view_zenith.radians().cos()).collect();
        close(
            cosine_weighted_mean(&set, &values).unwrap(),
            2.0 / 3.0,
            4e-3,
        );
        // One side bright, one side dark: the mean is the half.
        let sided: Vec<f64> = set
            .iter()
            .map(|d| 1.0 + d.relative_azimuth.radians().cos())
            .collect();
        close(cosine_weighted_mean(&set, &sided).unwrap(), 1.0, 2e-2);
    }

    #[test]
    fn the_white_is_two_and_a_half_medians() {
        let map: Vec<Yxy> = [100.0, 300.0, 200.0]
            .into_iter()
            .map(|luminance_cd_m2| Yxy {
                luminance_cd_m2,
                x: 0.3,
                y: 0.3,
            })
            .collect();
        close(white_luminance(&map).unwrap(), 500.0, 1e-12);
        assert!(white_luminance(&[]).is_none());
    }
}
