//! The extended sky formula: a sum of 22 products for each of ln Y, x and y.
//!
//! Perez's formula multiplies one factor of the air mass (gradation) by one factor of the angle from
//! the sun (indicatrix). A low sun, haze below the observer and the aureole break that product, and
//! its coefficients trade against each other, so that they cannot be interpolated. Here
//!
//! `ln Y = Σ c_k p_k(θ) q_k(γ)`, and likewise x and y with coefficients of their own.
//!
//! `p_k` is 1 or m/(n + m) with a relative air mass m of the air (scale height 8 km) or of the haze
//! (1.2 km), both of a spherical atmosphere, finite down to the geometric horizon; `q_k` is 1, cos γ,
//! cos² γ or exp(−n γ). The formula is linear in its coefficients: a fit has one solution, and to
//! interpolate coefficients is to interpolate ln Y, x and y themselves. Luminance cannot turn negative.
//!
//! Source: our own. The products were chosen greedily (orthogonal matching pursuit) from 88 candidates
//! by how much each lowered the residual of transport maps over 0–30 km, T 1–8, sun 0–92°.

use crate::air_mass::{radius_in_scale_heights, reciprocal_chapman_f32};
use crate::quantity::{Length, single};

/// Number of products.
pub const TERMS: usize = 22;

/// Names of the products: `a3` is m/(3 + m) of the air, `h5` of the haze; `mu` is cos γ, `e2` is
/// exp(−2γ).
pub const TERM_NAMES: [&str; TERMS] = [
    "1", "a3", "e2", "a50", "a200", "mu2", "a200*mu", "h5*mu", "h5", "h5*e2", "a50*mu", "a3*mu",
    "a1000", "h100*e1", "a1000*mu", "a1*mu2", "a1000*e1", "a1*e8", "a1", "a200*e1", "a10*mu",
    "h20*e1",
];

/// Scale heights of air and haze \[km\] of the two air masses.
pub const SCALE_HEIGHTS_KM: [f64; 2] = [8.0, 1.2];

/// What the two air masses need of the observer's altitude.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ScaledRadii {
    /// The distance from the Earth's center in scale heights of air and of haze, X.
    pub in_scale_heights: [f32; 2],
    /// √(X/2) of each.
    pub half_roots: [f32; 2],
}

impl ScaledRadii {
    /// At an altitude.
    #[must_use]
    pub fn at(observer_altitude: Length) -> Self {
        let scale_heights = SCALE_HEIGHTS_KM.map(|h| {
            single(radius_in_scale_heights(
                observer_altitude,
                Length::from_km(h),
            ))
        });
        Self {
            in_scale_heights: scale_heights,
            half_roots: scale_heights.map(|x| (0.5 * x).sqrt()),
        }
    }

    /// One over the air masses of air and haze.
    fn reciprocal_masses(self, cosine: f32) -> [f32; 2] {
        let [x, x_haze] = self.in_scale_heights;
        let [root, root_haze] = self.half_roots;
        [
            reciprocal_chapman_f32(cosine, x, root),
            reciprocal_chapman_f32(cosine, x_haze, root_haze),
        ]
    }
}

/// Odd polynomial for the arc tangent on 0..1 divided by its argument, in its square: a minimax fit,
/// relative error 7e-7. Our own, so that shader and CPU agree where drivers' `atan2` do not.
const ARC_TANGENT: [f32; 7] = [
    0.999_999_35,
    -0.333_265_15,
    0.198_814_82,
    -0.134_871_9,
    0.083_871_156,
    -0.037_012_97,
    0.007_863_366,
];

/// The angle, 0..π, from its sine (not negative) and cosine times any common factor.
#[must_use]
pub fn angle(sine: f32, cosine: f32) -> f32 {
    let side = cosine.abs();
    let ratio = sine.min(side) / sine.max(side).max(f32::MIN_POSITIVE);
    let square = ratio * ratio;
    // Estrin's order: a shorter chain than Horner's
    let [c0, c1, c2, c3, c4, c5, c6] = ARC_TANGENT;
    let fourth = square * square;
    let low = (c0 + c1 * square) + (c2 + c3 * square) * fourth;
    let high = (c4 + c5 * square) + c6 * fourth;
    let arc = ratio * (low + high * (fourth * fourth));
    let acute = if sine > side {
        core::f32::consts::FRAC_PI_2 - arc
    } else {
        arc
    };
    if cosine < 0.0 {
        core::f32::consts::PI - acute
    } else {
        acute
    }
}

/// The angle between a direction and the sun \[rad\] and its cosine; the sun as sine and cosine of
/// its zenith angle.
#[must_use]
#[expect(
    clippy::imprecise_flops,
    reason = "components of unit vectors; hypot guards against overflow at several times the cost"
)]
pub fn angle_from_sun(direction: [f32; 3], [sin_sun, cos_sun]: [f32; 2]) -> (f32, f32) {
    let [x, y, z] = direction;
    let cos_gamma = x * sin_sun + z * cos_sun;
    // the cross product keeps angles near the sun
    let across = z * sin_sun - x * cos_sun;
    let sine = (y * y + across * across).sqrt();
    (angle(sine, cos_gamma), cos_gamma)
}

/// The products in a direction.
///
/// `cosine` is that of the view zenith angle, `gamma` the angle from the sun \[rad\] and `mu` its
/// cosine.
#[must_use]
pub fn basis(cosine: f32, radii: ScaledRadii, gamma: f32, cos_gamma: f32) -> [f32; TERMS] {
    let [air, haze] = radii.reciprocal_masses(cosine);
    // m/(n + m) = 1/(1 + n/m)
    let [a1, a3, a10, a50, a200, a1000] =
        [1.0, 3.0, 10.0, 50.0, 200.0, 1000.0].map(|n| 1.0 / (1.0 + n * air));
    let [h5, h20, h100] = [5.0, 20.0, 100.0].map(|n| 1.0 / (1.0 + n * haze));
    let e1 = (-gamma).exp();
    let e2 = e1 * e1;
    let e4 = e2 * e2;
    let mu2 = cos_gamma * cos_gamma;
    [
        1.0,
        a3,
        e2,
        a50,
        a200,
        mu2,
        a200 * cos_gamma,
        h5 * cos_gamma,
        h5,
        h5 * e2,
        a50 * cos_gamma,
        a3 * cos_gamma,
        a1000,
        h100 * e1,
        a1000 * cos_gamma,
        a1 * mu2,
        a1000 * e1,
        a1 * e4 * e4,
        a1,
        a200 * e1,
        a10 * cos_gamma,
        h20 * e1,
    ]
}

/// Coefficients of ln Y, x and y for each product; the fourth entry is not used. A shader reads
/// them as they lie.
pub type Coefficients = [[f32; 4]; TERMS];

/// Places of named products among [`TERM_NAMES`]; `None` unless all are there, in that order.
#[must_use]
pub fn slots(names: &[String]) -> Option<Vec<usize>> {
    let places = names.iter().map(|n| TERM_NAMES.iter().position(|t| t == n));
    let places = places.collect::<Option<Vec<_>>>()?;
    places.is_sorted_by(|a, b| a < b).then_some(places)
}

/// Adds a node of a table, weighted. The node holds the products at `slots` alone, the others are 0.
pub(crate) fn add(sum: &mut Coefficients, weight: f32, node: &[f32], slots: &[usize]) {
    for (channel, values) in node.chunks_exact(slots.len()).enumerate() {
        for (slot, from) in slots.iter().zip(values) {
            sum[*slot][channel] += weight * from;
        }
    }
}

/// Luminance \[cd·m⁻²\], x and y from coefficients and products.
#[must_use]
pub fn light(coefficients: &Coefficients, basis: &[f32; TERMS]) -> [f32; 3] {
    let [ln_luminance, x, y, _] = sums(coefficients, basis);
    let [x, y] = within_locus([x, y]);
    [ln_luminance.exp(), x, y]
}

/// Sides of an octagon within the spectral locus, as how far a step from the equal-energy point in x
/// and in y goes toward each, 1 on the side. Its corners are 400, 462, 477, 489, 505, 530, 572 and
/// 700 nm on the CIE 1931 locus, drawn in by 0.1 %.
const LOCUS_SIDES: [[f32; 8]; 2] = [
    [
        -1.866_77, -2.808_94, -3.319_11, -3.445_84, -1.538_61, 2.763_73, 3.005_51, 1.826_87,
    ],
    [
        -2.137_74, -1.533_3, -1.022_94, -0.417_8, 1.536_81, 3.163_04, 3.017_75, -3.936_53,
    ],
];

/// A chromaticity that light can have: sums that lead out of the spectral locus, as they do where deep
/// twilight leaves next to no light, end on its edge toward the equal-energy point.
#[must_use]
pub fn within_locus([x, y]: [f32; 2]) -> [f32; 2] {
    const WHITE: f32 = 1.0 / 3.0;
    let [dx, dy] = [x - WHITE, y - WHITE];
    let [to_x, to_y] = LOCUS_SIDES;
    let far = to_x
        .iter()
        .zip(to_y)
        .fold(1.0_f32, |far, (a, b)| far.max(a * dx + b * dy));
    [WHITE + dx / far, WHITE + dy / far]
}

/// The sums of all four entries. Not inlined: where the caller drops the fourth, the compiler would
/// split the vectors into single numbers.
#[inline(never)]
fn sums(coefficients: &Coefficients, basis: &[f32; TERMS]) -> [f32; 4] {
    // two sums side by side shorten the chain of additions
    let (mut even, mut odd) = ([0.0_f32; 4], [0.0_f32; 4]);
    for (c, b) in coefficients.chunks_exact(2).zip(basis.chunks_exact(2)) {
        even = core::array::from_fn(|i| even[i] + c[0][i] * b[0]);
        odd = core::array::from_fn(|i| odd[i] + c[1][i] * b[1]);
    }
    core::array::from_fn(|i| even[i] + odd[i])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_products_are_finite_from_the_zenith_to_the_horizon() {
        for altitude_km in [0.0, 1.0, 30.0] {
            let radii = ScaledRadii::at(Length::from_km(altitude_km));
            for i in 0..=200_u8 {
                let cosine = 1.0 - f32::from(i) / 200.0 * 1.1;
                for gamma in [0.0_f32, 1.0, 3.1] {
                    let all = basis(cosine, radii, gamma, gamma.cos());
                    assert!(
                        all.iter().all(|p| p.is_finite() && p.abs() <= 1.0),
                        "{all:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn an_angle_is_that_of_the_library_to_7e_7() {
        for i in 0..=3141_u16 {
            let exact = f64::from(i) / 1000.0;
            let found = f64::from(angle(single(exact.sin().abs()), single(exact.cos())));
            assert!(
                (found - exact).abs() <= 1e-6 * exact.max(0.3),
                "{exact}: {found}"
            );
        }
        assert!(angle(0.0, 1.0).abs() < 1e-9);
        assert!((angle(0.0, -1.0) - core::f32::consts::PI).abs() < 1e-6);
        assert!(angle(0.0, 0.0).is_finite());
    }
}
