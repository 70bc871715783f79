//! From a look-up table to the light of the sky: the runtime model.
//!
//! What depends on observer, haze and sun is computed once ([`UtmSky::frame`]); what is left for a
//! direction is one formula in `f32` without allocation ([`SkyFrame::yxy`]), the twin of the shader.
//! Out of scope: the sun's disc and the ground.

use crate::air_mass::chapman_air_mass_f32;
use crate::axis::{Axis, Cell, four_from, lagrange_weights};
use crate::color::{
    LinearSrgb, Yxy, linear_srgb, linear_srgb_from_xyz, xyz_from_linear_srgb, xyz_from_yxy,
    yxy_from_xyz,
};
use crate::conditions::{Conditions, OutsideDomain};
use crate::direction::{SkyDirection, horizon_zenith};
use crate::extended::{self, Coefficients, Radii, angle};
use crate::lut::{Form, Interpolation, Lut, LutError};
use crate::quantity::{Angle, single};

/// Bytes of the default table, `luts/default.utmlut`.
pub const EMBEDDED_LUT: &[u8] = include_bytes!("../../../luts/default.utmlut");

/// Distance of the lowest ring that tables of the extended form are fitted to from the geometric
/// horizon \[deg\]. Below it the sky is soon that ring's: the formula is not made to go on.
pub const LOWEST_RING_DEG: f64 = 0.25;
/// Width of the bend from the formula to the lowest ring's sky, in the cosine: 0.08° at the horizon.
pub const LOWEST_RING_BEND: f64 = 1.4e-3;

/// Values of a channel at a node of the Perez forms: zenith, A–E.
pub const PEREZ_TERMS: usize = 6;
/// Corners that a frame blends: four layers, two turbidities, two suns.
pub const MOST_CORNERS: usize = 16;
/// Scale height of the spherical Perez form's air mass \[km\].
pub const PEREZ_SCALE_HEIGHT_KM: f64 = 8.0;

/// The sky of a look-up table.
#[derive(Clone, Debug)]
pub struct UtmSky {
    lut: Lut,
    name: &'static str,
}

/// The sky for one observer, haze and sun.
#[derive(Clone, Debug)]
pub struct SkyFrame {
    formula: Formula,
    radii: Radii,
    sin_sun: f32,
    cos_sun: f32,
    cos_horizon: f32,
    cos_lowest: f32,
}

/// The formula of a frame with its coefficients.
#[expect(
    clippy::large_enum_variant,
    reason = "a frame allocates nothing, so neither variant is boxed"
)]
#[derive(Clone, Debug)]
pub enum Formula {
    /// Linear coefficients blend into one set.
    Extended(Coefficients),
    /// Perez's coefficients are kept for each node, and the lights blended.
    Perez(PerezFrame),
}

/// Perez's formula at the nodes around a frame's place.
#[derive(Clone, Debug)]
pub struct PerezFrame {
    /// Whether the printed 1/cos θ stands for the spherical air mass.
    pub plane_parallel: bool,
    /// How the nodes' lights are blended.
    pub interpolation: Interpolation,
    /// Nodes in use.
    pub corners: usize,
    /// Their weights.
    pub weights: [f32; MOST_CORNERS],
    /// Zenith and A–E of Y, x and y at each node.
    pub coefficients: [[[f32; PEREZ_TERMS]; 3]; MOST_CORNERS],
}

/// A cosine of the view zenith angle as the extended form takes it: below that of the lowest fitted ring
/// it bends, without a kink, to stay.
fn held(cosine: f32, lowest: f32) -> f32 {
    const BEND: f32 = single(LOWEST_RING_BEND);
    let below = ((lowest - cosine) / BEND).clamp(0.0, 1.0);
    cosine.max(lowest) - BEND * (below - 0.5 * below * below)
}

/// Place of a turbidity for interpolation: light grows like the logarithm of the haze.
pub(crate) fn haze_coordinate(turbidity: f64) -> f64 {
    (turbidity - 0.7).ln()
}

impl UtmSky {
    /// The sky of a table.
    #[must_use]
    pub fn new(lut: Lut) -> Self {
        let name = match (lut.header().form, lut.header().interpolation) {
            (Form::Extended, _) => "utm-sky",
            (Form::PerezReport, Interpolation::ReportLagrange) => "utm2005",
            (Form::PerezReport, Interpolation::LogLinear) => "perez-report",
            (Form::PerezSpherical, _) => "perez-spherical",
        };
        Self { lut, name }
    }

    /// The sky of the table that is part of the program.
    ///
    /// # Errors
    /// When the embedded table cannot be read: a fault of the build.
    pub fn embedded() -> Result<Self, LutError> {
        Ok(Self::new(Lut::decode(EMBEDDED_LUT)?))
    }

    /// Short name for captions and tables.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        self.name
    }

    /// The table.
    #[must_use]
    pub const fn lut(&self) -> &Lut {
        &self.lut
    }

    /// Gathers what depends on observer, haze and sun. No allocation.
    ///
    /// # Errors
    /// When the conditions lie outside the table's domain.
    pub fn frame(&self, conditions: &Conditions) -> Result<SkyFrame, OutsideDomain> {
        let header = self.lut.header();
        header.domain.check(conditions)?;
        let altitude_km = conditions.observer_altitude.km();
        let (altitude, turbidity, sun) = (
            &header.altitude_km,
            &header.turbidity,
            &header.sun_zenith_deg,
        );
        let layers = match header.interpolation {
            Interpolation::LogLinear => two(altitude, altitude_km, |h| h),
            Interpolation::ReportLagrange => lagrange(altitude, altitude_km),
        };
        let hazes = match header.interpolation {
            Interpolation::LogLinear => two_in(turbidity, conditions.turbidity, haze_coordinate),
            Interpolation::ReportLagrange => two_in(turbidity, conditions.turbidity, |t| t),
        };
        let suns = two_in(sun, conditions.sun_zenith.degrees(), |s| s);
        let mut formula = match header.form {
            Form::Extended => Formula::Extended(Coefficients::default()),
            Form::PerezReport | Form::PerezSpherical => Formula::Perez(PerezFrame {
                plane_parallel: header.form == Form::PerezReport,
                interpolation: header.interpolation,
                corners: 0,
                weights: [0.0; MOST_CORNERS],
                coefficients: [[[0.0; PEREZ_TERMS]; 3]; MOST_CORNERS],
            }),
        };
        for (a, wa) in layers {
            for (t, wt) in hazes {
                for (s, ws) in suns {
                    let weight = single(wa * wt * ws);
                    if weight == 0.0 {
                        continue;
                    }
                    let node = self.lut.node(a, t, s);
                    match &mut formula {
                        Formula::Extended(sum) => {
                            extended::add(sum, weight, node, self.lut.term_slots());
                        }
                        Formula::Perez(perez) => perez.push(weight, node),
                    }
                }
            }
        }
        let (sin_sun, cos_sun) = conditions.sun_zenith.radians().sin_cos();
        let horizon = horizon_zenith(conditions.observer_altitude);
        let lowest_ring = Angle::from_degrees(LOWEST_RING_DEG);
        Ok(SkyFrame {
            formula,
            radii: Radii::at(conditions.observer_altitude),
            sin_sun: single(sin_sun),
            cos_sun: single(cos_sun),
            cos_horizon: single(horizon.radians().cos()),
            cos_lowest: single((horizon.radians() - lowest_ring.radians()).cos()),
        })
    }
}

/// The two nodes of a cell and their weights, in a coordinate of the axis.
fn cell(axis: &Axis, value: f64, coordinate: impl Fn(f64) -> f64) -> Cell {
    let [low, high] = axis.bounds();
    if axis.len() == 1 {
        // the table is the same all over the domain
        return Cell {
            lower: 0,
            fraction: 0.0,
        };
    }
    let value = value.clamp(low, high); // the domain was checked; this undoes rounding alone
    axis.cell_from_value(value).map_or(
        Cell {
            lower: 0,
            fraction: 0.0,
        },
        |c| {
            let (from, to) = (
                coordinate(axis.nodes()[c.lower]),
                coordinate(axis.nodes()[c.lower + 1]),
            );
            Cell {
                fraction: (coordinate(value) - from) / (to - from),
                ..c
            }
        },
    )
}

/// The two nodes around a value and their weights.
pub(crate) fn two_in(
    axis: &Axis,
    value: f64,
    coordinate: impl Fn(f64) -> f64,
) -> [(usize, f64); 2] {
    let c = cell(axis, value, coordinate);
    [(c.lower, 1.0 - c.fraction), (c.lower + 1, c.fraction)]
}

fn two(axis: &Axis, value: f64, coordinate: impl Fn(f64) -> f64) -> [(usize, f64); 4] {
    let [lower, upper] = two_in(axis, value, coordinate);
    [lower, upper, (0, 0.0), (0, 0.0)]
}

/// The report's rule: the four nodes nearest to the cell and Lagrange's weights.
fn lagrange(axis: &Axis, value: f64) -> [(usize, f64); 4] {
    let nodes = axis.nodes();
    let c = cell(axis, value, |h| h);
    if nodes.len() < 4 {
        return two(axis, value, |h| h);
    }
    let first = c.lower.saturating_sub(1).min(nodes.len() - 4);
    let weights = lagrange_weights(&four_from(nodes, first), value);
    core::array::from_fn(|i| (first + i, weights[i]))
}

impl SkyFrame {
    /// The light from a direction, `None` below the geometric horizon.
    #[must_use]
    pub fn yxy(&self, direction: &SkyDirection) -> Option<Yxy> {
        let [luminance, x, y] = self.light(direction.unit_vector())?;
        Some(Yxy {
            luminance_cd_m2: luminance.into(),
            x: x.into(),
            y: y.into(),
        })
    }

    /// Luminance \[cd·m⁻²\], x and y from a direction, `None` below the geometric horizon.
    ///
    /// The direction is a unit vector: z points up, and the sun stands in the plane of x and z on
    /// the side of positive x. The twin of the shader's function.
    #[must_use]
    pub fn light(&self, direction: [f32; 3]) -> Option<[f32; 3]> {
        let cosine = direction[2];
        // a hair below the horizon is the horizon: f32 resolves 1e-7 in the cosine
        if cosine < self.cos_horizon - 2e-7 {
            return None;
        }
        let (gamma, mu) = angle_from_sun(direction, [self.sin_sun, self.cos_sun]);
        Some(match &self.formula {
            Formula::Extended(coefficients) => extended::light(
                coefficients,
                &extended::basis(held(cosine, self.cos_lowest), self.radii, gamma, mu),
            ),
            Formula::Perez(perez) => {
                let air_mass = if perez.plane_parallel {
                    1.0 / cosine.max(0.0)
                } else {
                    chapman_air_mass_f32(cosine, self.radii.scale_heights[0])
                };
                perez.light(air_mass, gamma, angle(self.sin_sun, self.cos_sun))
            }
        })
    }

    /// Linear sRGB \[cd·m⁻²\] from a direction, `None` below the geometric horizon.
    #[must_use]
    pub fn linear_srgb(&self, direction: [f32; 3]) -> Option<[f32; 3]> {
        self.light(direction).map(linear_srgb)
    }

    /// The formula and its coefficients.
    #[must_use]
    pub const fn formula(&self) -> &Formula {
        &self.formula
    }

    /// What the air masses need of the altitude.
    #[must_use]
    pub const fn radii(&self) -> Radii {
        self.radii
    }

    /// Sine and cosine of the sun's zenith angle.
    #[must_use]
    pub const fn sun(&self) -> [f32; 2] {
        [self.sin_sun, self.cos_sun]
    }

    /// Cosine of the zenith angle of the lowest ring that the table was fitted to.
    #[must_use]
    pub const fn cos_lowest(&self) -> f32 {
        self.cos_lowest
    }

    /// Cosine of the geometric horizon's zenith angle.
    #[must_use]
    pub const fn cos_horizon(&self) -> f32 {
        self.cos_horizon
    }
}

/// The angle between a direction and the sun \[rad\] and its cosine; the sun as sine and cosine of
/// its zenith angle.
#[must_use]
#[expect(
    clippy::imprecise_flops,
    reason = "components of unit vectors; hypot guards against overflow at several times the cost"
)]
pub(crate) fn angle_from_sun(direction: [f32; 3], [sin_sun, cos_sun]: [f32; 2]) -> (f32, f32) {
    let [x, y, z] = direction;
    let mu = x * sin_sun + z * cos_sun;
    // the cross product keeps angles near the sun
    let across = z * sin_sun - x * cos_sun;
    let sine = (y * y + across * across).sqrt();
    (angle(sine, mu), mu)
}

impl PerezFrame {
    fn push(&mut self, weight: f32, node: &[f32]) {
        let to = &mut self.coefficients[self.corners];
        for (to, from) in to.iter_mut().zip(node.chunks_exact(PEREZ_TERMS)) {
            to.copy_from_slice(from);
        }
        self.weights[self.corners] = weight;
        self.corners += 1;
    }

    /// Perez's formula at each node, blended by the table's rule.
    fn light(&self, air_mass: f32, gamma: f32, sun_zenith: f32) -> [f32; 3] {
        let mut sum = [0.0_f64; 3];
        for (weight, channels) in self
            .weights
            .iter()
            .zip(&self.coefficients)
            .take(self.corners)
        {
            let [luminance, x, y] =
                channels.map(|c| perez(&c, air_mass, gamma) * c[0] / perez(&c, 1.0, sun_zenith));
            let weight = f64::from(*weight);
            let parts = match self.interpolation {
                Interpolation::LogLinear => [luminance.ln().into(), x.into(), y.into()],
                Interpolation::ReportLagrange => {
                    let light = Yxy {
                        luminance_cd_m2: luminance.into(),
                        x: x.into(),
                        y: y.into(),
                    };
                    let rgb = linear_srgb_from_xyz(xyz_from_yxy(light));
                    [rgb.red, rgb.green, rgb.blue]
                }
            };
            for (sum, part) in sum.iter_mut().zip(parts) {
                *sum += weight * part;
            }
        }
        match self.interpolation {
            Interpolation::LogLinear => [sum[0].exp(), sum[1], sum[2]].map(single),
            Interpolation::ReportLagrange => {
                let [red, green, blue] = sum;
                let light = yxy_from_xyz(xyz_from_linear_srgb(LinearSrgb { red, green, blue }));
                [light.luminance_cd_m2, light.x, light.y].map(single)
            }
        }
    }
}

/// Perez's F from the values of a channel (zenith, A–E), the twin of
/// `sky_science::perez::PerezCoefficients::relative_luminance` in `f32`.
#[must_use]
pub fn perez(c: &[f32; PEREZ_TERMS], air_mass: f32, gamma: f32) -> f32 {
    let [_, a, b, c, d, e] = *c;
    let exponent = if b == 0.0 { 0.0 } else { b * air_mass };
    let cos_gamma = gamma.cos();
    (1.0 + a * exponent.exp()) * (1.0 + c * (d * gamma).exp() + e * cos_gamma * cos_gamma)
}
