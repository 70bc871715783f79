//! Where a ray goes: the points along a straight path through the shells at which the transport
//! integrals are sampled.
//!
//! A path is a chain of segments, each with a point at both ends and one in the middle (Simpson's
//! rule, fourth order). Segments end at shells, at the tangent point, at the edge of the Earth's
//! shadow, and are short enough in altitude and optical depth.

use super::medium::{Between, Medium};
use super::sphere::{half_chord, impact_parameter};
use sky_core::quantity::EARTH_RADIUS_KM;

/// A ray: where it starts and how it leaves, in the frame of the local vertical and the sun.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ray {
    /// Radius of the start \[km\].
    pub(super) radius: f64,
    /// Cosine of the angle between ray and local vertical at the start.
    pub(super) cosine: f64,
    /// Cosine of the local sun zenith angle at the start.
    pub(super) sun_cosine: f64,
    /// Cosine of the angle between ray and sun; constant along the ray.
    pub(super) cos_gamma: f64,
}

/// A point of a path.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Point {
    /// Distance from the start \[km\].
    pub(super) length: f64,
    /// Altitude \[km\].
    pub(super) z: f64,
    /// Cosine of the angle between the ray and the local vertical.
    pub(super) cosine: f64,
    /// Place among the medium's levels.
    pub(super) place: Between,
}

/// How finely paths are sampled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sampling {
    /// Largest optical depth of a segment at the most opaque wavelength.
    pub(super) depth: f64,
    /// Largest change of altitude in a segment, as a fraction of (altitude + 4 km).
    pub(super) rise: f64,
    /// Largest turn of the local vertical in a segment \[rad\].
    pub(super) turn: f64,
    /// Optical depth, at the most transparent wavelength, after which the rest is dark.
    pub(super) opaque: f64,
}

/// Thickest segment of an observer's path, as a fraction of (altitude + 4 km).
pub(super) const VIEW_SHELLS: f64 = 0.2;

/// Sampling of an observer's rays.
pub(super) const VIEW_SAMPLING: Sampling = Sampling {
    depth: 0.8,
    rise: 0.4,
    turn: 0.01,
    opaque: 14.0,
};

/// Where segments end, and how finely they are sampled.
#[derive(Clone, Copy, Debug)]
pub(super) struct Steps<'a> {
    /// Altitudes \[km\] at which a segment ends.
    pub(super) shells: &'a [f64],
    pub(super) sampling: &'a Sampling,
}

/// Points and segments of one path; reused from ray to ray.
#[derive(Clone, Debug, Default)]
pub(super) struct Path {
    /// `2 n + 1` points: ends and middles of n segments.
    pub(super) points: Vec<Point>,
    /// Length of each segment \[km\].
    pub(super) lengths: Vec<f64>,
    /// Whether the path ends on the ground.
    pub(super) ground: bool,
    breaks: Vec<f64>,
}

impl Ray {
    /// A ray whose azimuth does not matter: a sun in the zenith casts no shadow on it.
    pub(super) const fn upright(radius: f64, cosine: f64) -> Self {
        Self {
            radius,
            cosine,
            sun_cosine: 1.0,
            cos_gamma: cosine,
        }
    }

    fn radius_at(&self, length: f64) -> f64 {
        (self.radius * self.radius + length * (length + 2.0 * self.radius * self.cosine)).sqrt()
    }

    fn altitude_at(&self, length: f64) -> f64 {
        let h = self.radius - EARTH_RADIUS_KM;
        // (r - R)(r + R) keeps metres at thousands of kilometres
        let square = h * (self.radius + EARTH_RADIUS_KM)
            + length * (length + 2.0 * self.radius * self.cosine);
        square / (self.radius_at(length) + EARTH_RADIUS_KM)
    }

    /// How far it goes before it enters a sphere: 0 from within, `None` if it misses \[km\].
    pub(super) fn before_sphere(&self, sphere_radius: f64) -> Option<f64> {
        if self.radius <= sphere_radius {
            return Some(0.0);
        }
        let impact = impact_parameter(self.radius, self.cosine);
        (self.cosine < 0.0 && impact < sphere_radius)
            .then(|| -self.radius * self.cosine - half_chord(sphere_radius, impact))
    }

    /// The same ray from a point farther along it.
    pub(super) fn moved(&self, length: f64) -> Self {
        let radius = self.radius_at(length);
        let cosine_at = |start: f64, along: f64| {
            ((self.radius * start + length * along) / radius).clamp(-1.0, 1.0)
        };
        Self {
            radius,
            cosine: cosine_at(self.cosine, 1.0),
            sun_cosine: cosine_at(self.sun_cosine, self.cos_gamma),
            cos_gamma: self.cos_gamma,
        }
    }

    /// Where the ray crosses the cylinder of shadow behind the Earth, before `end` \[km\].
    pub(super) fn shadow_edges(
        &self,
        ground_radius: f64,
        end: f64,
    ) -> impl Iterator<Item = f64> + use<> {
        // distance² from the sun's axis: a ℓ² + 2 b ℓ + c = 0 at the cylinder's wall
        let (along, cos_gamma) = (self.radius * self.sun_cosine, self.cos_gamma);
        let a = (1.0 - cos_gamma) * (1.0 + cos_gamma);
        let b = self.radius * self.cosine - along * cos_gamma;
        let c = (self.radius - ground_radius) * (self.radius + ground_radius) - along * along;
        let square = b * b - a * c;
        let crosses = a >= 1e-12 && square > 0.0;
        let root = square.max(0.0).sqrt();
        [(-b - root) / a, (-b + root) / a]
            .into_iter()
            .filter(move |length| {
                let behind = along + length * cos_gamma < 0.0;
                crosses && behind && *length > 1e-6 && *length < end - 1e-6
            })
    }

    fn point(&self, length: f64, medium: &Medium) -> Point {
        let r = self.radius_at(length);
        let z = self
            .altitude_at(length)
            .clamp(medium.ground_km(), medium.top_km());
        let cosine = ((self.radius * self.cosine + length) / r).clamp(-1.0, 1.0);
        Point {
            length,
            z,
            cosine,
            place: medium.finder.find(z),
        }
    }
}

impl Path {
    /// Traces a ray to the top of the atmosphere or to the ground, but no farther than `reach` \[km\].
    pub(super) fn trace(&mut self, ray: &Ray, reach: f64, medium: &Medium, steps: Steps<'_>) {
        self.points.clear();
        self.lengths.clear();
        self.breaks.clear();
        let (r0, mu) = (ray.radius, ray.cosine);
        let impact = impact_parameter(r0, mu);
        let to_tangent = -r0 * mu;
        self.ground = mu < 0.0 && impact < medium.ground_radius();
        let whole = if self.ground {
            (to_tangent - half_chord(medium.ground_radius(), impact)).max(0.0)
        } else {
            to_tangent + half_chord(medium.top_radius(), impact)
        };
        let end = whole.min(reach);
        self.ground &= end >= whole;
        // Shell crossings on both sides of the tangent point, the tangent point itself.
        for z in steps.shells {
            let r = EARTH_RADIUS_KM + z;
            if r > impact {
                let half = half_chord(r, impact);
                for length in [to_tangent - half, to_tangent + half] {
                    if length > 1e-9 && length < end - 1e-9 {
                        self.breaks.push(length);
                    }
                }
            }
        }
        if to_tangent > 1e-9 && to_tangent < end - 1e-9 {
            self.breaks.push(to_tangent);
        }
        self.breaks
            .extend(ray.shadow_edges(medium.ground_radius(), end));
        self.breaks.push(end);
        self.breaks.sort_by(f64::total_cmp);
        self.subdivide(ray, medium, steps.sampling);
    }

    fn subdivide(&mut self, ray: &Ray, medium: &Medium, sampling: &Sampling) {
        let mut start = 0.0;
        let mut thin_depth = 0.0; // at the most transparent wavelength
        self.points.push(ray.point(0.0, medium));
        for k in 0..self.breaks.len() {
            let stop = self.breaks[k];
            while stop - start > 1e-9 {
                let length = stop - start;
                let here = self.points[self.points.len() - 1];
                let far = ray.point(stop, medium);
                let middle = ray.altitude_at(0.5 * (start + stop));
                let dense =
                    medium.extinction_bounds(here.z.min(far.z).min(middle.max(medium.ground_km())));
                let rise = (far.z - here.z).abs() / (here.z.min(far.z) + 4.0);
                let turn = length / ray.radius;
                // later segments may be longer, in proportion to the light they still pass
                let depth = sampling.depth * (1.0 + 0.5 * thin_depth);
                let pieces = (length * dense[0] / depth)
                    .max(rise / sampling.rise)
                    .max(turn / sampling.turn)
                    .ceil()
                    .clamp(1.0, 1e4);
                let step = length / pieces;
                let next = if pieces > 1.0 { start + step } else { stop };
                let middle = ray.point(start + 0.5 * (next - start), medium);
                let last = ray.point(next, medium);
                self.lengths.push(next - start);
                self.points.push(middle);
                self.points.push(last);
                thin_depth += (next - start) * medium.extinction_bounds(middle.z)[1];
                start = next;
                if thin_depth > sampling.opaque {
                    self.ground = false;
                    return;
                }
            }
        }
    }
}
