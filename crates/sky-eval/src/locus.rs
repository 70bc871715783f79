//! The CIE 1931 spectral locus: the chromaticities that light can have.

use core::ops::RangeInclusive;

use sky_science::cie::color_matching_functions;

/// The chromaticities x, y of monochromatic lights at whole wavelengths \[nm\].
pub fn spectral_colors(wavelengths_nm: RangeInclusive<u16>) -> impl Iterator<Item = [f64; 2]> {
    wavelengths_nm.map(|nm| {
        let [x, y, z] = color_matching_functions(f64::from(nm));
        [x / (x + y + z), y / (x + y + z)]
    })
}

/// A half plane `a x + b y <= c`, with (a, b) of length 1.
type HalfPlane = [f64; 3];

/// The convex hull of the spectral colors, closed by the line of purples.
#[derive(Clone, Debug)]
pub struct Locus {
    /// A polygon of few corners within the hull, to answer fast.
    few: Vec<HalfPlane>,
    all: Vec<HalfPlane>,
}

/// Twice the area of a triangle, positive if it turns left.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// The convex hull of points, turning left (monotone chain).
fn hull(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let half = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for p in points {
            while chain.len() > 1 && turn(chain[chain.len() - 2], chain[chain.len() - 1], p) <= 0.0
            {
                chain.pop();
            }
            chain.push(p);
        }
        chain.pop();
        chain
    };
    let mut lower = half(&mut points.iter().copied());
    lower.extend(half(&mut points.iter().rev().copied()));
    lower
}

fn half_planes(corners: &[[f64; 2]]) -> Vec<HalfPlane> {
    corners
        .iter()
        .zip(corners.iter().cycle().skip(1))
        .map(|(p, q)| {
            let [dx, dy] = [q[0] - p[0], q[1] - p[1]];
            let length = dx.hypot(dy);
            let (a, b) = (dy / length, -dx / length);
            [a, b, a * p[0] + b * p[1]]
        })
        .collect()
}

impl Default for Locus {
    fn default() -> Self {
        Self::new()
    }
}

impl Locus {
    /// Of the CIE 1931 2° observer, 380–700 nm.
    #[must_use]
    pub fn new() -> Self {
        let corners = hull(spectral_colors(380..=700).collect());
        let stride = corners.len().div_ceil(12);
        let few: Vec<[f64; 2]> = corners.iter().copied().step_by(stride).collect();
        Self {
            few: half_planes(&few),
            all: half_planes(&corners),
        }
    }

    /// How far a chromaticity lies outside, 0 inside.
    #[must_use]
    pub fn outside(&self, x: f64, y: f64) -> f64 {
        let beyond = |planes: &[HalfPlane]| {
            planes
                .iter()
                .fold(0.0_f64, |most, [a, b, c]| most.max(a * x + b * y - c))
        };
        if beyond(&self.few) > 0.0 {
            beyond(&self.all)
        } else {
            0.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_lies_inside_and_what_no_light_has_outside() {
        let locus = Locus::new();
        for (x, y) in [
            (0.3127, 0.3290),
            (0.25, 0.26),
            (0.64, 0.33),
            (0.15, 0.06),
            (0.2, 0.7),
        ] {
            assert!(locus.outside(x, y) <= 0.0, "{x} {y}");
        }
        for (x, y) in [(0.0, 0.0), (0.7, 0.7), (0.02, 0.3), (0.5, 0.1), (0.3, -0.1)] {
            let outside = locus.outside(x, y);
            assert!(outside > 0.01, "{x} {y}: {outside}");
        }
        // 520 nm itself
        assert!(locus.outside(0.0743, 0.8338) < 1e-3);
        assert!(locus.outside(0.0743, 0.86) > 0.02);
    }
}
