//! A table of a Perez form as a sky: the formula at each node around, the lights blended.
//!
//! The default table is of the extended form and needs none of this; here are the report of 2005 and
//! Perez's five coefficients with a spherical air mass, for comparison. In `f32`, as the runtime is.

use sky_core::air_mass::chapman_air_mass_f32;
use sky_core::axis::Axis;
use sky_core::color::{
    LinearSrgb, Yxy, linear_srgb_from_xyz, xyz_from_linear_srgb, xyz_from_yxy, yxy_from_xyz,
};
use sky_core::conditions::{Conditions, Domain, OutsideDomain};
use sky_core::direction::{SkyDirection, horizon_zenith};
use sky_core::extended::{ScaledRadii, angle, angle_from_sun};
use sky_core::lut::{Form, Interpolation, Lut};
use sky_core::quantity::single;
use sky_core::utm_sky::{HORIZON_SLACK, haze_coordinate};

use crate::lagrange::{four_from, lagrange_weights};
use crate::sky_model::{SkyError, SkyModel};

/// Values of a channel at a node: zenith, A–E.
pub const PEREZ_TERMS: usize = 6;
/// Nodes that a frame blends: four altitudes, two turbidities, two suns.
pub const MAX_CORNERS: usize = 16;
/// Scale height of the spherical form's air mass \[km\].
pub const PEREZ_SCALE_HEIGHT_KM: f64 = 8.0;

/// The sky of a table of a Perez form.
#[derive(Clone, Debug)]
pub struct PerezSky {
    lut: Lut,
    name: &'static str,
}

/// A table that is not of a Perez form.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("table: expected a Perez form, found {}", found.name())]
pub struct NotPerez {
    /// The form.
    pub found: Form,
}

/// Perez's formula at the nodes around an observer, haze and sun.
#[derive(Clone, Debug)]
pub struct PerezFrame {
    /// Whether the printed 1/cos θ stands for the spherical air mass.
    pub plane_parallel: bool,
    /// How the nodes' lights are blended.
    pub interpolation: Interpolation,
    /// Nodes in use.
    pub corners: usize,
    /// Their weights.
    pub weights: [f32; MAX_CORNERS],
    /// Zenith and A–E of Y, x and y at each node.
    pub coefficients: [[[f32; PEREZ_TERMS]; 3]; MAX_CORNERS],
    /// What the air masses need of the altitude.
    pub radii: ScaledRadii,
    /// Sine and cosine of the sun's zenith angle.
    pub sun: [f32; 2],
    /// Cosine of the geometric horizon's zenith angle.
    pub cos_horizon: f32,
}

impl PerezSky {
    /// The sky of a table.
    ///
    /// # Errors
    /// When the table is not of a Perez form.
    pub fn new(lut: Lut) -> Result<Self, NotPerez> {
        let name = match (lut.header().form, lut.header().interpolation) {
            (found @ Form::Extended, _) => return Err(NotPerez { found }),
            (Form::PerezReport, Interpolation::ReportLagrange) => "utm2005",
            (Form::PerezReport, Interpolation::LogLinear) => "perez-report",
            (Form::PerezSpherical, _) => "perez-spherical",
        };
        Ok(Self { lut, name })
    }

    /// The table.
    #[must_use]
    pub const fn lut(&self) -> &Lut {
        &self.lut
    }

    /// Gathers what depends on observer, haze and sun.
    ///
    /// # Errors
    /// When the conditions lie outside the table's domain.
    pub fn frame(&self, conditions: &Conditions) -> Result<PerezFrame, OutsideDomain> {
        let header = self.lut.header();
        header.domain.check(conditions)?;
        let altitude_km = conditions.observer_altitude.km();
        let lagrange_rule = header.interpolation == Interpolation::ReportLagrange;
        let altitudes = if lagrange_rule {
            four_altitudes(&header.altitude_km, altitude_km)
        } else {
            two_altitudes(&header.altitude_km, altitude_km)
        };
        let hazes = header.turbidity.blend(conditions.turbidity, |t| {
            if lagrange_rule { t } else { haze_coordinate(t) }
        });
        let suns = (header.sun_zenith_deg).blend(conditions.sun_zenith.degrees(), |s| s);
        let (sin_sun, cos_sun) = conditions.sun_zenith.radians().sin_cos();
        let horizon = horizon_zenith(conditions.observer_altitude);
        let mut frame = PerezFrame {
            plane_parallel: header.form == Form::PerezReport,
            interpolation: header.interpolation,
            corners: 0,
            weights: [0.0; MAX_CORNERS],
            coefficients: [[[0.0; PEREZ_TERMS]; 3]; MAX_CORNERS],
            radii: ScaledRadii::at(conditions.observer_altitude),
            sun: [single(sin_sun), single(cos_sun)],
            cos_horizon: single(horizon.radians().cos()),
        };
        for (a, wa) in altitudes {
            for (t, wt) in hazes {
                for (s, ws) in suns {
                    let weight = single(wa * wt * ws);
                    if weight != 0.0 {
                        frame.push(weight, self.lut.node(a, t, s));
                    }
                }
            }
        }
        Ok(frame)
    }
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

    /// The light from a direction, `None` below the geometric horizon.
    #[must_use]
    pub fn yxy(&self, direction: &SkyDirection) -> Option<Yxy> {
        let direction = direction.unit_vector();
        let cosine = direction[2];
        if cosine < self.cos_horizon - HORIZON_SLACK {
            return None;
        }
        let (gamma, _) = angle_from_sun(direction, self.sun);
        let air_mass = if self.plane_parallel {
            1.0 / cosine.max(0.0)
        } else {
            chapman_air_mass_f32(cosine, self.radii.in_scale_heights[0])
        };
        let [sin_sun, cos_sun] = self.sun;
        let [luminance, x, y] = self.light(air_mass, gamma, angle(sin_sun, cos_sun));
        Some(Yxy {
            luminance_cd_m2: luminance.into(),
            x: x.into(),
            y: y.into(),
        })
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
/// [`crate::perez::PerezCoefficients::relative_luminance`] in `f32`.
#[must_use]
pub fn perez(c: &[f32; PEREZ_TERMS], air_mass: f32, gamma: f32) -> f32 {
    let [_, a, b, c, d, e] = *c;
    let exponent = if b == 0.0 { 0.0 } else { b * air_mass };
    let cos_gamma = gamma.cos();
    (1.0 + a * exponent.exp()) * (1.0 + c * (d * gamma).exp() + e * cos_gamma * cos_gamma)
}

/// The two altitudes around a value and their weights.
fn two_altitudes(axis: &Axis, altitude_km: f64) -> [(usize, f64); 4] {
    let [lower, upper] = axis.blend(altitude_km, |h| h);
    [lower, upper, (0, 0.0), (0, 0.0)]
}

/// The report's rule: the four altitudes nearest to a value and Lagrange's weights.
fn four_altitudes(axis: &Axis, altitude_km: f64) -> [(usize, f64); 4] {
    let nodes = axis.nodes();
    if nodes.len() < 4 {
        return two_altitudes(axis, altitude_km);
    }
    let [(lower, _), _] = axis.blend(altitude_km, |h| h);
    let first = lower.saturating_sub(1).min(nodes.len() - 4);
    let [low, high] = axis.bounds();
    let weights = lagrange_weights(&four_from(nodes, first), altitude_km.clamp(low, high));
    core::array::from_fn(|i| (first + i, weights[i]))
}

impl SkyModel for PerezSky {
    fn name(&self) -> &str {
        self.name
    }

    fn domain(&self) -> &Domain {
        &self.lut.header().domain
    }

    /// Directions below the geometric horizon come out black.
    fn yxy_map(
        &self,
        conditions: &Conditions,
        directions: &[SkyDirection],
    ) -> Result<Vec<Yxy>, SkyError> {
        let frame = self.frame(conditions)?;
        Ok(directions
            .iter()
            .map(|d| frame.yxy(d).unwrap_or_default())
            .collect())
    }
}
