//! Aerial perspective: what a finite path of air takes from an object's light, and what it adds.
//!
//! `color = transmittance · object + in-scattered light`, per channel. The path is a straight ray over
//! a sphere. Its optical depth is a sum of closed forms, one for each constituent and section of the
//! path; none divides by a difference of altitudes, so that level paths need no branch.
//!
//! The in-scattered light comes from the table itself. Seen from the lower end of a section the sky
//! is L = (light scattered into the section) + T · (the sky at its upper end), and the table knows
//! both skies. A section that is looked down through has its source from its lower end too, mirrored
//! at the horizontal with the same angle from the sun: sunlight scatters by that angle. Below the
//! horizon the table has no sky, and needs none.
//!
//! Simplifications: no refraction; one sun zenith angle for the whole path. Out of scope: clouds.

use crate::color::linear_srgb;
use crate::conditions::{Conditions, OutsideDomain};
use crate::extended::{self, Coefficients, ScaledRadii, angle, angle_from_sun};
use crate::extinction::{LEVEL_STEP_KM, LEVELS};
use crate::quantity::{Angle, EARTH_RADIUS_KM, Length, single};
use crate::sun::VisibleSun;
use crate::utm_sky::{MAX_LAYERS, UtmSky, haze_coordinate};

/// Sections of a path, shorter near its lower end, where the haze is.
pub const SECTIONS: u8 = 4;

/// Sections of a path to space.
const SPACE_SECTIONS: u8 = 8;

/// Where the air ends \[km\].
const SPACE_KM: f32 = 100.0;

const RADIUS_KM: f32 = single(EARTH_RADIUS_KM);

/// Least distance of two layers \[km\]: f32 tells them apart.
const THINNEST_LAYER_KM: f64 = 0.01;

/// Light that was scattered before and has lost its direction, as a share of that scattered once,
/// in clear air.
pub const SCATTERED_BEFORE: f32 = 0.3;

/// The air between an observer and objects for one haze and sun: the sky of every altitude, and the
/// extinction. No allocation; a shader reads the parts as they lie.
#[derive(Clone, Debug)]
pub struct AerialFrame {
    /// Altitude nodes in use, at least two: a table of one altitude stands at both ends of its domain.
    pub layers: usize,
    /// Their altitudes \[km\].
    pub altitude_km: [f32; MAX_LAYERS],
    /// Their coefficients.
    pub coefficients: [Coefficients; MAX_LAYERS],
    /// Sine and cosine of the sun's zenith angle.
    pub sun: [f32; 2],
    /// Extinction coefficients \[km⁻¹\] of air, gas, haze and stratospheric aerosol at four
    /// wavelengths.
    pub per_km: [[f32; 4]; 4],
    /// Shares of the wavelengths in red, green, blue and luminance.
    pub weights: [[f32; 4]; 4],
    /// Logarithm of the air's relative density, relative densities of gas and stratospheric aerosol,
    /// at levels 2 km apart.
    pub levels: [[f32; 4]; LEVELS],
    /// Sunlight outside the atmosphere in linear sRGB \[lx\].
    pub sun_rgb: [f32; 3],
    /// One over the scale height of the haze \[km⁻¹\].
    pub haze_per_scale_height: f32,
}

/// A finite path's effect on light.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AerialPath {
    /// Transmittance for sunlight: red, green, blue (linear sRGB), luminance.
    pub transmittance: [f32; 4],
    /// In-scattered light in linear sRGB \[cd·m⁻²\].
    pub inscatter: [f32; 3],
}

/// A point of a ray.
#[derive(Clone, Copy)]
struct RayPoint {
    altitude_km: f32,
    /// Cosine of the ray's zenith angle there.
    cosine: f32,
}

impl AerialFrame {
    /// Gathers what depends on haze and sun.
    ///
    /// # Errors
    /// When haze or sun lie outside the table's domain.
    pub fn new(sky: &UtmSky, turbidity: f64, sun_zenith: Angle) -> Result<Self, OutsideDomain> {
        let (header, extinction) = (sky.lut().header(), sky.extinction());
        let nodes = header.altitude_km.nodes();
        header.domain.check(&Conditions {
            observer_altitude: Length::from_km(header.domain.altitude_km[0]),
            turbidity,
            sun_zenith,
        })?;
        let mut coefficients = [Coefficients::default(); MAX_LAYERS];
        let mut altitude_km = [0.0; MAX_LAYERS];
        let hazes = header.turbidity.blend(turbidity, haze_coordinate);
        let suns = header.sun_zenith_deg.blend(sun_zenith.degrees(), |s| s);
        for (a, node) in nodes.iter().enumerate() {
            altitude_km[a] = single(*node);
            for (t, wt) in hazes {
                for (s, ws) in suns {
                    let weight = single(wt * ws);
                    if weight > 0.0 {
                        let node = sky.lut().node(a, t, s);
                        extended::add(&mut coefficients[a], weight, node, sky.lut().term_slots());
                    }
                }
            }
        }
        let mut layers = nodes.len();
        if layers == 1 {
            // one sky for the whole domain: what blends layers needs two of them
            let [low, high] = header.domain.altitude_km;
            altitude_km[0] = single(low);
            altitude_km[1] = single(high.max(low + THINNEST_LAYER_KM));
            coefficients[1] = coefficients[0];
            layers = 2;
        }
        let mut levels = [[0.0; 4]; LEVELS];
        for (level, [air, gas, layer]) in levels.iter_mut().zip(&extinction.relative_density) {
            *level = [air.ln(), *gas, *layer, 0.0].map(single);
        }
        let (sin_sun, cos_sun) = sun_zenith.radians().sin_cos();
        Ok(Self {
            layers,
            altitude_km,
            coefficients,
            sun: [single(sin_sun), single(cos_sun)],
            per_km: extinction
                .coefficients_per_km(turbidity)
                .map(|c| c.map(single)),
            weights: extinction.weights.map(|w| w.map(single)),
            levels,
            sun_rgb: extinction.sun_rgb_lx.map(single),
            haze_per_scale_height: single(extinction.haze_scale_height_km.recip()),
        })
    }

    /// Transmittance and in-scattered light between the observer and a point at a distance.
    ///
    /// The direction is that of [`crate::utm_sky::SkyFrame::light`]. The path must not pass through
    /// the Earth; the object may be anywhere above the ground.
    #[must_use]
    pub fn path(&self, altitude_km: f32, direction: [f32; 3], distance_km: f32) -> AerialPath {
        let start = RayPoint {
            altitude_km,
            cosine: direction[2],
        };
        let (gamma, cos_gamma) = angle_from_sun(direction, self.sun);
        let sun_angle = [gamma, cos_gamma];
        // the ray descends to its lowest point, then rises
        let lowest = (-(RADIUS_KM + altitude_km) * start.cosine).clamp(0.0, distance_km);
        let bottom = along(start, lowest);
        let (mut depth, mut light) = ([0.0; 4], [0.0; 3]);
        if lowest > 0.0 {
            // from the observer down: the sections in the order of the ray, shorter downward
            let mut upper = start;
            let mut upper_sky = self.mirrored_sky(upper, cos_gamma);
            for i in (0..SECTIONS).rev() {
                let lower = along(start, lowest * (1.0 - section_end(i, SECTIONS)));
                let length = lowest * (section_end(i + 1, SECTIONS) - section_end(i, SECTIONS));
                let section = self.optical_depth(upper, lower, length);
                let lower_sky = self.mirrored_sky(lower, cos_gamma);
                self.add(&mut light, depth, section, lower_sky, upper_sky);
                depth = add(depth, section);
                (upper, upper_sky) = (lower, lower_sky);
            }
        }
        // beyond the air a section would only lose its places in the air
        let rise = (distance_km - lowest).min(distance_to_top(bottom));
        if rise > 0.0 {
            let section = self.rising_depth(bottom, rise, SECTIONS);
            let end = along(bottom, rise);
            self.add(
                &mut light,
                depth,
                section,
                self.sky(bottom, sun_angle),
                self.sky(end, sun_angle),
            );
            depth = add(depth, section);
        }
        AerialPath {
            transmittance: self.transmittance(depth),
            inscatter: light,
        }
    }

    /// Transmittance of red, green, blue and luminance from an altitude to space in a direction above
    /// the geometric horizon.
    #[must_use]
    pub fn transmittance_to_space(&self, altitude_km: f32, cosine: f32) -> [f32; 4] {
        let start = RayPoint {
            altitude_km,
            cosine,
        };
        let lowest = (-(RADIUS_KM + altitude_km) * cosine).max(0.0);
        let bottom = along(start, lowest);
        // from the lowest point to the top: h (h + 2 r) of a right triangle, without cancellation
        let radius = RADIUS_KM + bottom.altitude_km;
        let rise = (SPACE_KM - bottom.altitude_km).max(0.0);
        let half = radius * bottom.cosine.max(0.0);
        let up = rise * (rise + 2.0 * radius)
            / (half + (half * half + rise * (rise + 2.0 * radius)).sqrt());
        let mut depth = self.rising_depth(bottom, up, SPACE_SECTIONS);
        if lowest > 0.0 {
            let back = RayPoint {
                cosine: 0.0,
                ..bottom
            };
            depth = add(depth, self.rising_depth(back, lowest, SECTIONS));
        }
        self.transmittance(depth)
    }

    /// Sunlight on a plane facing the sun in linear sRGB \[lx\], of the part of the disc that is
    /// above the horizon, through the air at that part's center; black without any.
    #[must_use]
    pub fn sunlight(&self, altitude_km: f32, sun: &VisibleSun) -> [f32; 3] {
        if sun.share <= 0.0 {
            return [0.0; 3];
        }
        let through = self.transmittance_to_space(altitude_km, sun.cosine);
        core::array::from_fn(|c| sun.share * self.sun_rgb[c] * through[c])
    }

    /// Optical depths of a ray that rises from its lowest point.
    fn rising_depth(&self, bottom: RayPoint, length_km: f32, sections: u8) -> [f32; 4] {
        let mut depth = [0.0; 4];
        let mut lower = bottom;
        for i in 0..sections {
            let (start, end) = (section_end(i, sections), section_end(i + 1, sections));
            let upper = along(bottom, length_km * end);
            depth = add(
                depth,
                self.optical_depth(lower, upper, length_km * (end - start)),
            );
            lower = upper;
        }
        depth
    }

    /// Adds a section's light: what its lower end sees of it, seen through what lies before.
    fn add(
        &self,
        light: &mut [f32; 3],
        before: [f32; 4],
        section: [f32; 4],
        lower_sky: [f32; 3],
        upper_sky: [f32; 3],
    ) {
        let [through, before] = [section, before].map(|depth| self.transmittance(depth));
        for i in 0..3 {
            let scattered = (lower_sky[i] - through[i] * upper_sky[i]).max(0.0);
            light[i] += before[i] * scattered;
        }
    }

    /// Transmittance of red, green, blue and luminance for optical depths at the four wavelengths.
    #[must_use]
    pub fn transmittance(&self, depth: [f32; 4]) -> [f32; 4] {
        let through = depth.map(|d| (-d).exp());
        self.weights.map(|w| dot(w, through).clamp(0.0, 1.0))
    }

    /// Optical depths at the four wavelengths between two points of a ray.
    fn optical_depth(&self, from: RayPoint, to: RayPoint, length_km: f32) -> [f32; 4] {
        // the altitude of the middle carries the curvature of the path and of the profile
        let middle = along(from, 0.5 * length_km);
        let [a, m, b] = [from, middle, to].map(|place| self.level(place.altitude_km));
        let haze = [from, middle, to].map(|p| -p.altitude_km * self.haze_per_scale_height);
        let columns = [
            length_km * mean_of_exponential(a[0], m[0], b[0]),
            length_km * (a[1] + 4.0 * m[1] + b[1]) / 6.0,
            length_km * mean_of_exponential(haze[0], haze[1], haze[2]),
            length_km * (a[2] + 4.0 * m[2] + b[2]) / 6.0,
        ];
        let mut depth = [0.0; 4];
        for (column, per_km) in columns.iter().zip(&self.per_km) {
            for (depth, per_km) in depth.iter_mut().zip(per_km) {
                *depth += column * per_km;
            }
        }
        depth
    }

    /// Logarithm of the air's density and the densities of gas and stratospheric aerosol.
    fn level(&self, altitude_km: f32) -> [f32; 4] {
        let place = (altitude_km / single(LEVEL_STEP_KM)).max(0.0);
        let mut lower = 0;
        let mut fraction = place;
        while fraction > 1.0 && lower + 2 < LEVELS {
            lower += 1;
            fraction -= 1.0;
        }
        let (low, high) = (self.levels[lower], self.levels[lower + 1]);
        // above the last level the air goes on thinning, and the others are gone
        let share = fraction.min(1.0);
        [
            low[0] + fraction * (high[0] - low[0]),
            low[1] + share * (high[1] - low[1]),
            low[2] + share * (high[2] - low[2]),
            0.0,
        ]
    }

    /// The sky at a place in the ray's direction, in linear sRGB \[cd·m⁻²\].
    fn sky(&self, place: RayPoint, [gamma, cos_gamma]: [f32; 2]) -> [f32; 3] {
        let top = self.altitude_km[self.layers - 1];
        let altitude_km = place.altitude_km.clamp(self.altitude_km[0], top);
        let mut upper = 1;
        while upper + 1 < self.layers && self.altitude_km[upper] < altitude_km {
            upper += 1;
        }
        let (low, high) = (self.altitude_km[upper - 1], self.altitude_km[upper]);
        let fraction = (altitude_km - low) / (high - low);
        let (below, above) = (&self.coefficients[upper - 1], &self.coefficients[upper]);
        let blended = core::array::from_fn(|k| {
            core::array::from_fn(|c| below[k][c] + fraction * (above[k][c] - below[k][c]))
        });
        let radii = ScaledRadii::at(Length::from_km(altitude_km.into()));
        let basis = extended::basis(place.cosine, radii, gamma, cos_gamma);
        let rgb = linear_srgb(extended::light(&blended, &basis));
        // above the table's top the sky fades with the air that is left
        let left = (self.level(place.altitude_km)[0] - self.level(altitude_km)[0]).exp();
        rgb.map(|c| c * left)
    }

    /// The sky upward from a place that the ray passes on its way down: the sky at the mirrored zenith
    /// angle and the ray's own angle from the sun.
    ///
    /// Where no direction of that sky has this angle, the formula is extended beyond its sky: in haze
    /// as it is, in clear air from the nearest angle by the phase function of molecules.
    fn mirrored_sky(&self, place: RayPoint, cos_gamma: f32) -> [f32; 3] {
        let up = RayPoint {
            cosine: -place.cosine,
            ..place
        };
        let [sin_sun, cos_sun] = self.sun;
        let across = (1.0 - up.cosine * up.cosine).max(0.0).sqrt() * sin_sun;
        let along = up.cosine * cos_sun;
        let nearest = cos_gamma.clamp(along - across, along + across);
        let air = self.per_km[0][2] * self.level(place.altitude_km)[0].exp();
        let haze = self.per_km[2][2] * (-place.altitude_km * self.haze_per_scale_height).exp();
        let there = (cos_gamma + (nearest - cos_gamma) * air / (air + haze)).clamp(-1.0, 1.0);
        let sky = self.sky(up, [angle((1.0 - there * there).sqrt(), there), there]);
        let ratio = molecular_scattering(cos_gamma) / molecular_scattering(there);
        sky.map(|c| c * ratio)
    }
}

/// How much clear air scatters by an angle of cosine `mu`, up to a factor: once, and before.
fn molecular_scattering(cos_gamma: f32) -> f32 {
    0.75 * (1.0 + cos_gamma * cos_gamma) + SCATTERED_BEFORE
}

/// Distance to the ground in a direction below the geometric horizon \[km\].
#[must_use]
pub fn distance_to_ground(altitude_km: f32, cosine: f32) -> f32 {
    let down = -(RADIUS_KM + altitude_km) * cosine;
    let tangent = altitude_km * (altitude_km + 2.0 * RADIUS_KM);
    tangent / (down + (down * down - tangent).max(0.0).sqrt()).max(1e-6)
}

/// Whether a ray from an altitude meets the ground before a distance.
#[must_use]
pub fn path_meets_ground(altitude_km: f32, direction: [f32; 3], distance_km: f32) -> bool {
    let start = RayPoint {
        altitude_km,
        cosine: direction[2],
    };
    let lowest = (-(RADIUS_KM + altitude_km) * start.cosine).clamp(0.0, distance_km);
    // a meter of slack: f32 and the rounding of files
    along(start, lowest).altitude_km < -1e-3
}

/// End of a section as a share of the path from its lower end.
fn section_end(section: u8, sections: u8) -> f32 {
    let share = f32::from(section) / f32::from(sections);
    share * share
}

/// The point of a ray at a distance.
fn along(start: RayPoint, distance_km: f32) -> RayPoint {
    let radius = RADIUS_KM + start.altitude_km;
    let rise = distance_km * (distance_km + 2.0 * radius * start.cosine);
    let there = (radius * radius + rise).max(1.0).sqrt();
    RayPoint {
        // r' − r without cancellation
        altitude_km: start.altitude_km + rise / (there + radius),
        cosine: ((distance_km + radius * start.cosine) / there).clamp(-1.0, 1.0),
    }
}

/// Distance at which a rising ray passes the highest level; not positive above it.
fn distance_to_top(bottom: RayPoint) -> f32 {
    let radius = RADIUS_KM + bottom.altitude_km;
    let up = single(LEVEL_STEP_KM) * (LEVELS - 1) as f32 - bottom.altitude_km;
    // the root of d² + 2 d r cos θ = up (up + 2 r), without cancellation
    let half = radius * bottom.cosine.max(0.0);
    let product = up * (up + 2.0 * radius);
    product / (half + (half * half + product).max(0.0).sqrt()).max(1e-6)
}

/// Mean along a section of a density whose logarithm has given values at start, middle and end.
///
/// Exact for a straight line of logarithms: (1 − e^(−x))/x of the larger end, x their difference.
/// A bend at the middle is weighted by how much the mean looks there, 2/3 where x is 0.
#[must_use]
pub fn mean_of_exponential(start: f32, middle: f32, end: f32) -> f32 {
    let x = (start - end).abs();
    let mean = if x < 0.01 {
        1.0 - x * (0.5 - x / 6.0)
    } else {
        (1.0 - (-x).exp()) / x
    };
    let bend = middle - 0.5 * (start + end);
    mean * (start.max(end) + bend * 4.0 / (36.0 + x * x).sqrt()).exp()
}

fn dot(a: [f32; 4], b: [f32; 4]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]
}

fn add(a: [f32; 4], b: [f32; 4]) -> [f32; 4] {
    core::array::from_fn(|i| a[i] + b[i])
}
