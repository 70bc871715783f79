//! From a look-up table to the light of the sky: the runtime model.
//!
//! What depends on observer, haze and sun is computed once ([`UtmSky::frame`]); what is left for a
//! direction is one formula in `f32` without allocation ([`SkyFrame::yxy`]), the twin of the shader.
//! Out of scope: the sun's disc and the ground.

use crate::air_mass::{chapman_air_mass_f32, radius_in_scale_heights};
use crate::axis::{Axis, Cell, four_from, lagrange_weights};
use crate::color::{linear_srgb_from_xyz, xyz_from_linear_srgb, xyz_from_yxy, yxy_from_xyz};
use crate::direction::{SkyDirection, horizon_zenith};
use crate::extended::{self, single};
use crate::lut::{Form, Interpolation, Lut, LutError};
use crate::quantity::Length;
use crate::sky_model::{Conditions, Domain, OutsideDomain, SkyModel, Yxy};

/// Bytes of the default table, `luts/default.utmlut`.
pub const EMBEDDED_LUT: &[u8] = include_bytes!("../../../luts/default.utmlut");

/// Values of a channel at a node: at most those of the extended form.
const MOST_TERMS: usize = extended::TERMS;
/// Corners that a frame blends: four layers, two turbidities, two suns.
const MOST_CORNERS: usize = 16;
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
    form: Form,
    interpolation: Interpolation,
    /// Corners in use: blended into one for the extended form.
    corners: usize,
    weights: [f32; MOST_CORNERS],
    coefficients: [[[f32; MOST_TERMS]; 3]; MOST_CORNERS],
    /// The observer's distance from the Earth's center in scale heights.
    radii: [f32; 2],
    sin_sun: f32,
    cos_sun: f32,
    cos_horizon: f32,
}

/// Place of a turbidity for interpolation: light grows like the logarithm of the haze.
fn haze_coordinate(turbidity: f64) -> f64 {
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
            Interpolation::LogLinear => two(cell(altitude, altitude_km, |h| h)),
            Interpolation::ReportLagrange => lagrange(altitude, altitude_km),
        };
        let hazes = two(match header.interpolation {
            Interpolation::LogLinear => cell(turbidity, conditions.turbidity, haze_coordinate),
            Interpolation::ReportLagrange => cell(turbidity, conditions.turbidity, |t| t),
        });
        let suns = two(cell(sun, conditions.sun_zenith.degrees(), |s| s));
        let mut frame = SkyFrame {
            form: header.form,
            interpolation: header.interpolation,
            corners: 0,
            weights: [0.0; MOST_CORNERS],
            coefficients: [[[0.0; MOST_TERMS]; 3]; MOST_CORNERS],
            radii: extended::SCALE_HEIGHTS_KM.map(|h| {
                single(radius_in_scale_heights(
                    conditions.observer_altitude,
                    Length::from_km(h),
                ))
            }),
            sin_sun: single(conditions.sun_zenith.radians().sin()),
            cos_sun: single(conditions.sun_zenith.radians().cos()),
            cos_horizon: single(horizon_zenith(conditions.observer_altitude).radians().cos()),
        };
        let terms = header.terms_per_channel();
        for (a, wa) in layers {
            for (t, wt) in hazes {
                for (s, ws) in suns {
                    let weight = single(wa * wt * ws);
                    if weight == 0.0 {
                        continue;
                    }
                    let node = self.lut.node(a, t, s);
                    // linear coefficients blend into one set; others are kept for their colors
                    let blended = header.form == Form::Extended;
                    let (k, factor) = if blended {
                        (0, weight)
                    } else {
                        (frame.corners, 1.0)
                    };
                    for (to, from) in frame.coefficients[k]
                        .iter_mut()
                        .zip(node.chunks_exact(terms))
                    {
                        for (to, from) in to.iter_mut().zip(from) {
                            *to += factor * from;
                        }
                    }
                    frame.weights[k] = if blended { 1.0 } else { weight };
                    frame.corners = k + 1;
                }
            }
        }
        Ok(frame)
    }
}

/// The two nodes of a cell and their weights, in a coordinate of the axis.
fn cell(axis: &Axis, value: f64, coordinate: impl Fn(f64) -> f64) -> Cell {
    let [low, high] = axis.bounds();
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

fn two(c: Cell) -> [(usize, f64); 4] {
    [
        (c.lower, 1.0 - c.fraction),
        (c.lower + 1, c.fraction),
        (0, 0.0),
        (0, 0.0),
    ]
}

/// The report's rule: the four nodes nearest to the cell and Lagrange's weights.
fn lagrange(axis: &Axis, value: f64) -> [(usize, f64); 4] {
    let nodes = axis.nodes();
    let c = cell(axis, value, |h| h);
    if nodes.len() < 4 {
        return two(c);
    }
    let first = c.lower.saturating_sub(1).min(nodes.len() - 4);
    let weights = lagrange_weights(&four_from(nodes, first), value);
    core::array::from_fn(|i| (first + i, weights[i]))
}

impl SkyFrame {
    /// The light from a direction, `None` below the geometric horizon.
    #[must_use]
    pub fn yxy(&self, direction: &SkyDirection) -> Option<Yxy> {
        let (sin_view, cos_view) = single(direction.view_zenith.radians()).sin_cos();
        let (sin_azimuth, cos_azimuth) = single(direction.relative_azimuth.radians()).sin_cos();
        // a hair below the horizon is the horizon: f32 resolves 1e-7 in the cosine
        if cos_view < self.cos_horizon - 2e-7 {
            return None;
        }
        let mu = cos_view * self.cos_sun + sin_view * self.sin_sun * cos_azimuth;
        // atan2 of cross and dot keeps angles near the sun
        let cross = [
            sin_view * sin_azimuth * self.cos_sun,
            cos_view * self.sin_sun - sin_view * cos_azimuth * self.cos_sun,
            sin_view * sin_azimuth * self.sin_sun,
        ];
        let gamma = (cross[0] * cross[0] + cross[1] * cross[1] + cross[2] * cross[2])
            .sqrt()
            .atan2(mu);
        let [luminance, x, y] = match self.form {
            Form::Extended => {
                let basis = extended::basis(cos_view, self.radii, gamma, mu.clamp(-1.0, 1.0));
                let [ln_luminance, x, y] = self.coefficients[0]
                    .map(|c| c.iter().zip(&basis).map(|(c, b)| c * b).sum::<f32>());
                [ln_luminance.exp(), x, y]
            }
            Form::PerezReport => self.blend(1.0 / cos_view.max(0.0), gamma),
            Form::PerezSpherical => {
                self.blend(chapman_air_mass_f32(cos_view, self.radii[0]), gamma)
            }
        };
        Some(Yxy {
            luminance_cd_m2: luminance.into(),
            x: x.into(),
            y: y.into(),
        })
    }

    /// Perez's formula at each corner, blended by the table's rule.
    fn blend(&self, air_mass: f32, gamma: f32) -> [f32; 3] {
        let sun_zenith = self.sin_sun.atan2(self.cos_sun);
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
                let light = yxy_from_xyz(xyz_from_linear_srgb(crate::color::LinearSrgb {
                    red,
                    green,
                    blue,
                }));
                [light.luminance_cd_m2, light.x, light.y].map(single)
            }
        }
    }
}

/// Perez's F from the values of a channel (zenith, A–E), the twin of
/// [`crate::perez::PerezCoefficients::relative_luminance`] in `f32`.
fn perez(c: &[f32; MOST_TERMS], air_mass: f32, gamma: f32) -> f32 {
    let [_, a, b, c, d, e, ..] = *c;
    let exponent = if b == 0.0 { 0.0 } else { b * air_mass };
    let cos_gamma = gamma.cos();
    (1.0 + a * exponent.exp()) * (1.0 + c * (d * gamma).exp() + e * cos_gamma * cos_gamma)
}

impl SkyModel for UtmSky {
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
    ) -> Result<Vec<Yxy>, OutsideDomain> {
        let frame = self.frame(conditions)?;
        Ok(directions
            .iter()
            .map(|d| frame.yxy(d).unwrap_or_default())
            .collect())
    }
}
