//! Perez's coefficients of one channel of a sky, from samples.
//!
//! The formula is fitted in parameters in which every value is a sky: gradation and indicatrix are
//! positive in all directions, B and D negative. Simplifications: one product of two factors; see
//! [`PerezCoefficients`]. Out of scope: the sun's surroundings (the caller leaves out 5°), and where
//! the samples come from.

use crate::solve::{
    Bounds, FitReport, LeastSquares, Solution, SolveError, SolveOptions, jacobian_condition_number,
    minimize,
};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use sky_core::quantity::Angle;
use sky_science::perez::PerezCoefficients;

/// Parameters of a fit: logarithm of the scale, then one each for A–E.
const PARAMETERS: usize = 6;

/// 1/cos θ at the horizontal is infinite; at this mass exp(B m) is 0 for every B within the bounds.
const LARGEST_AIR_MASS: f64 = 1e6;

/// Which of a sky's three numbers is fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Channel {
    /// Luminance Y \[cd·m⁻²\]: residuals are differences of natural logarithms, so relative errors.
    Luminance,
    /// CIE 1931 chromaticity x: residuals are differences.
    ChromaticityX,
    /// CIE 1931 chromaticity y: residuals are differences.
    ChromaticityY,
}

impl Channel {
    /// All channels, in the order Y, x, y.
    pub const ALL: [Self; 3] = [Self::Luminance, Self::ChromaticityX, Self::ChromaticityY];

    /// A sky of middling shape, towards which the fit is drawn where the samples do not decide: for
    /// luminance near a clear sky, for chromaticity near Preetham's at turbidity 3.
    #[must_use]
    pub const fn reference(self) -> PerezCoefficients {
        PerezCoefficients::from_array(match self {
            Self::Luminance => [-0.95, -0.25, 3.0, -2.5, 0.4],
            Self::ChromaticityX => [-0.3, -0.2, 0.2, -1.1, 0.04],
            Self::ChromaticityY => [-0.3, -0.28, 0.19, -1.8, 0.02],
        })
    }

    /// Strength of that pull, in residuals per unit of parameter: a change of B or D by a factor e
    /// costs as much as this root-mean-square error. 3e-4 is 0.03 % of luminance and 3e-5 a tenth of
    /// a just visible step in chromaticity, both far below what the formula itself leaves.
    #[must_use]
    pub const fn regularization(self) -> f64 {
        match self {
            Self::Luminance => 3e-4,
            Self::ChromaticityX | Self::ChromaticityY => 3e-5,
        }
    }

    /// Shapes from which several starts are made: thin and thick, wide and narrow aureole, brighter
    /// and darker toward the horizon. The first is [`Self::reference`].
    #[must_use]
    pub const fn starts(self) -> [[f64; 5]; 8] {
        match self {
            Self::Luminance => [
                Self::Luminance.reference().to_array(),
                [-0.93, -0.64, 5.26, -2.2, 0.17],
                [-0.99, -0.05, 2.0, -1.5, 0.5],
                [-0.5, -1.5, 10.0, -5.0, 0.3],
                [-0.99, -0.1, 0.2, -1.0, 0.9],
                [1.0, -0.5, 1.0, -3.0, 0.3],
                [-0.9, -0.2, 5.0, -0.7, -0.3],
                [-0.9, -0.3, 15.0, -12.0, 0.5],
            ],
            Self::ChromaticityX | Self::ChromaticityY => [
                self.reference().to_array(),
                [-0.3, -1.0, 0.2, -3.0, 0.05],
                [0.3, -0.2, 0.1, -1.0, -0.05],
                [-0.2, -0.05, 0.3, -6.0, 0.1],
                [0.3, -1.0, -0.1, -1.5, 0.1],
                [-0.5, -0.1, -0.1, -4.0, 0.0],
                [-0.1, -3.0, 0.5, -0.5, -0.2],
                [0.1, -0.5, 0.05, -12.0, 0.05],
            ],
        }
    }
}

/// One direction of a sky.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Relative optical air mass; infinite is the limit of 1/cos θ at the horizontal.
    pub air_mass: f64,
    /// Angle γ from the sun.
    pub scattering_angle: Angle,
    /// Luminance \[cd·m⁻²\] or chromaticity.
    pub value: f64,
    /// How much the direction counts, in any unit: its solid angle. Zero leaves it out.
    pub weight: f64,
}

/// A sky's samples and where its zenith lies in the formula's terms.
#[derive(Clone, Copy, Debug)]
pub struct SkySamples<'a> {
    /// The directions, the sun's surroundings left out.
    pub samples: &'a [Sample],
    /// Zenith angle of the sun, which is the zenith's scattering angle.
    pub sun_zenith: Angle,
    /// Relative optical air mass of the zenith, 1 for 1/cos θ.
    pub zenith_air_mass: f64,
}

/// Where the fit begins.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Starts<'a> {
    /// At eight shapes; the best end wins.
    #[default]
    Several,
    /// At one shape, such as a neighboring grid cell's: fast, but a local minimum is not noticed.
    Near(&'a PerezCoefficients),
    /// At one shape and at the eight.
    NearAndSeveral(&'a PerezCoefficients),
}

/// How to fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitOptions {
    /// When the solver stops.
    pub solve: SolveOptions,
    /// Shape towards which the fit is drawn; by default [`Channel::reference`].
    pub reference: Option<PerezCoefficients>,
    /// Strength of the pull; by default [`Channel::regularization`]. Zero switches it off.
    pub regularization: Option<f64>,
}

impl Default for FitOptions {
    /// The channel's own reference and regularization, and a solver that stops when a step lowers the
    /// root-mean-square residual by less than a part in 10⁸.
    fn default() -> Self {
        Self {
            solve: SolveOptions {
                cost_tolerance: 2e-8,
                step_tolerance: 1e-8,
                ..SolveOptions::default()
            },
            reference: None,
            regularization: None,
        }
    }
}

/// One channel of one sky in the formula.
#[must_use]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ChannelFit {
    /// What was fitted.
    pub channel: Channel,
    /// A–E; they pass [`PerezCoefficients::check`] at the zenith's air mass.
    pub coefficients: PerezCoefficients,
    /// Value of the formula at the zenith \[cd·m⁻² or 1\]. A direction's value is this times
    /// [`PerezCoefficients::relative_to_zenith`].
    pub zenith_value: f64,
    /// How the best start went. `rms` is weighted, `max_residual` is not, both over the samples alone:
    /// differences of natural logarithms for luminance, differences for chromaticity.
    /// `condition_number` too is that of the samples alone, without the pull to the reference.
    /// `at_bounds` is in the order scale, A, B, C, D, E.
    pub report: FitReport,
    /// How many starts were tried.
    pub starts: usize,
    /// How many of them ended within 0.01 % of the best root-mean-square residual.
    pub agreeing_starts: usize,
}

/// Samples that cannot be fitted.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum FitError {
    /// Too few samples with a weight.
    #[error("samples with a weight: expected at least {expected}, found {found}")]
    TooFew {
        /// The least number.
        expected: usize,
        /// How many there are.
        found: usize,
    },
    /// No sample has any light.
    #[error("samples: expected light, found a black map")]
    Black,
    /// A value is not a positive, finite number.
    #[error("sample {index}: expected a positive value, found {found}")]
    Value {
        /// Which sample, from 0.
        index: usize,
        /// The value.
        found: f64,
    },
    /// A weight is negative or not a finite number.
    #[error("sample {index}: expected a weight of at least 0, found {found}")]
    Weight {
        /// Which sample, from 0.
        index: usize,
        /// The weight.
        found: f64,
    },
    /// An air mass is not a positive number.
    #[error("sample {index}: expected a positive air mass, found {found}")]
    AirMass {
        /// Which sample, from 0; one more than the last for the zenith.
        index: usize,
        /// The air mass.
        found: f64,
    },
    /// A scattering angle is outside 0–180°.
    #[error("sample {index}: expected a scattering angle of 0 to 180 degrees, found {found}")]
    ScatteringAngle {
        /// Which sample, from 0; one more than the last for the zenith.
        index: usize,
        /// The angle \[deg\].
        found: f64,
    },
    /// The regularization is negative or not a finite number.
    #[error("regularization: expected a number of at least 0, found {found}")]
    Regularization {
        /// The strength.
        found: f64,
    },
    /// The solver refused the problem.
    #[error(transparent)]
    Solve(#[from] SolveError),
}

/// Fits A–E and the zenith value of one channel to a sky.
///
/// Deterministic. Unconverged fits are returned, not refused: see `report.why_stopped`.
///
/// # Errors
/// When the samples are too few, black, negative or not numbers.
pub fn fit_channel(
    sky: &SkySamples<'_>,
    channel: Channel,
    starts: Starts<'_>,
    options: &FitOptions,
) -> Result<ChannelFit, FitError> {
    let problem = PerezFit::new(sky, channel, options)?;
    let mut shapes = Vec::with_capacity(9);
    if let Starts::Near(near) | Starts::NearAndSeveral(near) = starts {
        shapes.push(*near);
    }
    if !matches!(starts, Starts::Near(_)) {
        shapes.extend(channel.starts().map(PerezCoefficients::from_array));
    }
    let mut costs = Vec::with_capacity(shapes.len());
    let mut best: Option<Solution> = None;
    for shape in &shapes {
        let start = problem.parameters_from_coefficients(shape);
        let found = minimize(&problem, &start, &problem.bounds, &options.solve)?;
        costs.push(found.report.final_cost);
        // NaN loses; of equals the first wins.
        let better = best.as_ref().is_none_or(|b| {
            found.report.final_cost < b.report.final_cost || b.report.final_cost.is_nan()
        });
        if better {
            best = Some(found);
        }
    }
    let Some(best) = best else {
        return Err(SolveError::Empty.into());
    };
    let lowest = best.report.final_cost;
    // Costs go with the square; the floor covers fits that are exact to rounding.
    let agreeing_starts = costs
        .iter()
        .filter(|&&c| c <= lowest * 1.0002 + 1e-16)
        .count();
    Ok(problem.finish(&best, shapes.len(), agreeing_starts))
}

/// The formula of one channel against samples, as a least-squares problem.
///
/// Parameters, in order: k, the logarithm of the scale, value = exp(k) φ f; u = ln φ at the smallest
/// air mass m₀; b = ln(−B); κ with C = exp(κ) − 1/(1 + exp(−ε)); d = ln(−D); ε = ln(1 + E).
/// A = (exp(u) − 1) exp(−B m₀). Then φ = 1 + (exp(u) − 1) exp(B (m − m₀)) > 0 for every m ≥ m₀, and
/// f = sin²γ + exp(ε) cos²γ + C exp(D γ) > 0 for every γ, because the logistic function of ε is below
/// both 1 and exp(ε).
#[derive(Clone, Debug)]
pub struct PerezFit {
    channel: Channel,
    air_mass: Vec<f64>,
    /// Whether a sample has the air mass of the one before, as those of a ring do.
    same_air_mass: Vec<bool>,
    gamma: Vec<f64>,
    cos2_gamma: Vec<f64>,
    /// Logarithm of the luminance, or the chromaticity itself.
    target: Vec<f64>,
    /// Square root of the weight, of which the squares add up to 1.
    root_weight: Vec<f64>,
    smallest_air_mass: f64,
    zenith_air_mass: f64,
    sun_zenith: Angle,
    regularization: f64,
    reference: [f64; PARAMETERS],
    bounds: Bounds,
}

/// The numbers of a parameter vector that every sample needs.
struct Shape {
    scale: f64,
    exp_u: f64,
    b: f64,
    exp_kappa: f64,
    c: f64,
    d: f64,
    exp_epsilon: f64,
    logistic: f64,
}

/// The formula at a sample.
struct Factors {
    gradation: f64,
    indicatrix: f64,
    /// exp(B (m − m₀))
    decay: f64,
    /// exp(D γ)
    glow: f64,
}

impl Shape {
    fn new(p: &[f64]) -> Self {
        let exp_epsilon = p[5].exp();
        let logistic = exp_epsilon / (1.0 + exp_epsilon);
        let exp_kappa = p[3].exp();
        Self {
            scale: p[0].exp(),
            exp_u: p[1].exp(),
            b: -p[2].exp(),
            exp_kappa,
            c: exp_kappa - logistic,
            d: -p[4].exp(),
            exp_epsilon,
            logistic,
        }
    }
}

impl PerezFit {
    /// Checks the samples and sets the problem up.
    ///
    /// # Errors
    /// When the samples are too few, black, negative or not numbers.
    pub fn new(
        sky: &SkySamples<'_>,
        channel: Channel,
        options: &FitOptions,
    ) -> Result<Self, FitError> {
        let regularization = options
            .regularization
            .unwrap_or_else(|| channel.regularization());
        if !(regularization >= 0.0 && regularization.is_finite()) {
            return Err(FitError::Regularization {
                found: regularization,
            });
        }
        let used = checked(sky)?;
        let total: f64 = used.iter().map(|s| s.weight).sum();
        let masses = || used.iter().map(|s| s.air_mass.min(LARGEST_AIR_MASS));
        let values = || used.iter().map(|s| s.value);
        let smallest = values().fold(f64::INFINITY, f64::min);
        let largest = values().fold(0.0, f64::max);
        let air_mass: Vec<f64> = masses().collect();
        let same_air_mass = (0..air_mass.len())
            .map(|i| i > 0 && air_mass[i].to_bits() == air_mass[i - 1].to_bits())
            .collect();
        let least_b = match channel {
            Channel::Luminance => -6.9,
            Channel::ChromaticityX | Channel::ChromaticityY => -11.5,
        };
        let mut problem = Self {
            channel,
            air_mass,
            same_air_mass,
            gamma: used.iter().map(|s| s.scattering_angle.radians()).collect(),
            cos2_gamma: used
                .iter()
                .map(|s| s.scattering_angle.radians().cos().powi(2))
                .collect(),
            target: match channel {
                Channel::Luminance => values().map(f64::ln).collect(),
                Channel::ChromaticityX | Channel::ChromaticityY => values().collect(),
            },
            root_weight: used.iter().map(|s| (s.weight / total).sqrt()).collect(),
            smallest_air_mass: masses().fold(sky.zenith_air_mass, f64::min),
            zenith_air_mass: sky.zenith_air_mass,
            sun_zenith: sky.sun_zenith,
            regularization,
            reference: [0.0; PARAMETERS],
            // |B| from a thousandth, of color from 1e-5 (at 30 km it is even in the air mass), to 12,
            // |D| from a tenth to 40, C up to 100, 1 + E from 1/20 to 20.
            bounds: Bounds {
                lower: vec![smallest.ln() - 20.0, -10.0, least_b, -9.0, -2.3, -3.0],
                upper: vec![largest.ln() + 20.0, 6.0, 2.5, 4.6, 3.7, 3.0],
            },
        };
        let reference = options.reference.unwrap_or_else(|| channel.reference());
        problem.reference = problem.parameters_from_coefficients(&reference);
        Ok(problem)
    }

    /// The box within which the parameters are sought.
    #[must_use]
    pub const fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    /// The parameters of a shape, moved into the bounds, with the scale that fits the samples best.
    #[must_use]
    pub fn parameters_from_coefficients(
        &self,
        coefficients: &PerezCoefficients,
    ) -> [f64; PARAMETERS] {
        let PerezCoefficients { a, b, c, d, e } = *coefficients;
        let tiny = 1e-9_f64;
        let epsilon = (1.0 + e).max(tiny).ln();
        let exp_epsilon = epsilon.exp();
        let mut p = [
            0.0,
            (1.0 + a * (b * self.smallest_air_mass).exp())
                .max(tiny)
                .ln(),
            (-b).max(tiny).ln(),
            (c + exp_epsilon / (1.0 + exp_epsilon)).max(tiny).ln(),
            (-d).max(tiny).ln(),
            epsilon,
        ];
        for (i, p) in p.iter_mut().enumerate().skip(1) {
            *p = p.clamp(self.bounds.lower[i], self.bounds.upper[i]);
        }
        let shape = Shape::new(&p);
        let (mut top, mut bottom) = (0.0, 0.0);
        self.each_sample(&shape, |i, factors| {
            let weight = self.root_weight[i] * self.root_weight[i];
            let f = factors.gradation * factors.indicatrix;
            match self.channel {
                Channel::Luminance => {
                    top += weight * (self.target[i] - f.ln());
                    bottom += weight;
                }
                Channel::ChromaticityX | Channel::ChromaticityY => {
                    top += weight * self.target[i] * f;
                    bottom += weight * f * f;
                }
            }
        });
        p[0] = match self.channel {
            Channel::Luminance => top / bottom,
            Channel::ChromaticityX | Channel::ChromaticityY => (top / bottom).ln(),
        };
        p
    }

    /// A–E from parameters, the inverse of [`Self::parameters_from_coefficients`] within the bounds.
    #[must_use]
    pub fn coefficients_from_parameters(&self, p: &[f64; PARAMETERS]) -> PerezCoefficients {
        let shape = Shape::new(p);
        PerezCoefficients {
            a: p[1].exp_m1() * (-shape.b * self.smallest_air_mass).exp(),
            b: shape.b,
            c: shape.c,
            d: shape.d,
            e: p[5].exp_m1(),
        }
    }

    /// Calls `with` for each sample in turn.
    fn each_sample(&self, shape: &Shape, mut with: impl FnMut(usize, Factors)) {
        let mut decay = 1.0;
        for i in 0..self.target.len() {
            if !self.same_air_mass[i] {
                decay = (shape.b * (self.air_mass[i] - self.smallest_air_mass)).exp();
            }
            let glow = (shape.d * self.gamma[i]).exp();
            let cos2 = self.cos2_gamma[i];
            with(
                i,
                Factors {
                    // 1 − decay and sin² + exp(ε) cos² keep the sign of what is positive.
                    gradation: (1.0 - decay) + shape.exp_u * decay,
                    indicatrix: (1.0 - cos2) + shape.exp_epsilon * cos2 + shape.c * glow,
                    decay,
                    glow,
                },
            );
        }
    }

    fn residual(&self, parameters: &[f64], shape: &Shape, i: usize, factors: &Factors) -> f64 {
        let f = factors.gradation * factors.indicatrix;
        let model = match self.channel {
            Channel::Luminance => parameters[0] + f.ln(),
            Channel::ChromaticityX | Channel::ChromaticityY => shape.scale * f,
        };
        self.root_weight[i] * (model - self.target[i])
    }

    /// The derivatives of a sample's residual by the parameters.
    fn derivatives(&self, shape: &Shape, i: usize, factors: &Factors) -> [f64; PARAMETERS] {
        let Factors {
            gradation,
            indicatrix,
            decay,
            glow,
        } = *factors;
        let weight = self.root_weight[i];
        // By φ and by f: of the logarithm, or of the value.
        let (of_scale, of_gradation, of_indicatrix) = match self.channel {
            Channel::Luminance => (weight, weight / gradation, weight / indicatrix),
            Channel::ChromaticityX | Channel::ChromaticityY => {
                let scaled = weight * shape.scale;
                (
                    scaled * gradation * indicatrix,
                    scaled * indicatrix,
                    scaled * gradation,
                )
            }
        };
        let rise = self.air_mass[i] - self.smallest_air_mass;
        let slope = shape.logistic * (1.0 - shape.logistic);
        [
            of_scale,
            of_gradation * shape.exp_u * decay,
            of_gradation * (shape.exp_u - 1.0) * shape.b * rise * decay,
            of_indicatrix * shape.exp_kappa * glow,
            of_indicatrix * shape.c * shape.d * self.gamma[i] * glow,
            of_indicatrix * (shape.exp_epsilon * self.cos2_gamma[i] - slope * glow),
        ]
    }

    /// The residuals of the pull to the reference.
    fn pull(&self, parameters: &[f64], residuals: &mut DVector<f64>) {
        let n = self.target.len();
        for j in 1..PARAMETERS {
            residuals[n + j - 1] = self.regularization * (parameters[j] - self.reference[j]);
        }
    }

    fn pull_derivatives(&self, jacobian: &mut DMatrix<f64>) {
        let n = self.target.len();
        for j in 1..PARAMETERS {
            for k in 0..PARAMETERS {
                jacobian[(n + j - 1, k)] = if j == k { self.regularization } else { 0.0 };
            }
        }
    }

    fn finish(&self, best: &Solution, starts: usize, agreeing_starts: usize) -> ChannelFit {
        let mut p = [0.0; PARAMETERS];
        p.copy_from_slice(&best.parameters);
        let coefficients = self.coefficients_from_parameters(&p);
        let zenith_value =
            p[0].exp() * coefficients.relative_luminance(self.zenith_air_mass, self.sun_zenith);
        let samples = self.target.len();
        let mut residuals = DVector::zeros(self.residual_count());
        self.residuals(&p, &mut residuals);
        let mut jacobian = DMatrix::zeros(self.residual_count(), PARAMETERS);
        self.jacobian(&p, &mut jacobian);
        let mut report = best.report.clone();
        report.rms = residuals.rows(0, samples).norm();
        report.max_residual = (0..samples)
            .map(|i| (residuals[i] / self.root_weight[i]).abs())
            .fold(0.0, f64::max);
        report.condition_number = jacobian_condition_number(jacobian.rows(0, samples).into_owned());
        ChannelFit {
            channel: self.channel,
            coefficients,
            zenith_value,
            report,
            starts,
            agreeing_starts,
        }
    }
}

impl LeastSquares for PerezFit {
    fn parameter_count(&self) -> usize {
        PARAMETERS
    }

    fn residual_count(&self) -> usize {
        self.target.len() + PARAMETERS - 1
    }

    fn residuals(&self, parameters: &[f64], residuals: &mut DVector<f64>) {
        let shape = Shape::new(parameters);
        self.each_sample(&shape, |i, factors| {
            residuals[i] = self.residual(parameters, &shape, i, &factors);
        });
        self.pull(parameters, residuals);
    }

    fn jacobian(&self, parameters: &[f64], jacobian: &mut DMatrix<f64>) {
        let shape = Shape::new(parameters);
        self.each_sample(&shape, |i, factors| {
            for (j, d) in self
                .derivatives(&shape, i, &factors)
                .into_iter()
                .enumerate()
            {
                jacobian[(i, j)] = d;
            }
        });
        self.pull_derivatives(jacobian);
    }

    fn residuals_and_jacobian(
        &self,
        parameters: &[f64],
        residuals: &mut DVector<f64>,
        jacobian: &mut DMatrix<f64>,
    ) {
        let shape = Shape::new(parameters);
        self.each_sample(&shape, |i, factors| {
            residuals[i] = self.residual(parameters, &shape, i, &factors);
            for (j, d) in self
                .derivatives(&shape, i, &factors)
                .into_iter()
                .enumerate()
            {
                jacobian[(i, j)] = d;
            }
        });
        self.pull(parameters, residuals);
        self.pull_derivatives(jacobian);
    }
}

/// The samples that count, if all of them are in order.
fn checked(sky: &SkySamples<'_>) -> Result<Vec<Sample>, FitError> {
    let zenith = Sample {
        air_mass: sky.zenith_air_mass,
        scattering_angle: sky.sun_zenith,
        value: 1.0,
        weight: 0.0,
    };
    if !sky.samples.is_empty() && sky.samples.iter().all(|s| s.value == 0.0) {
        return Err(FitError::Black);
    }
    for (index, sample) in sky.samples.iter().chain([&zenith]).enumerate() {
        let Sample {
            air_mass,
            scattering_angle,
            value,
            weight,
        } = *sample;
        if !(weight >= 0.0 && weight.is_finite()) {
            return Err(FitError::Weight {
                index,
                found: weight,
            });
        }
        if air_mass.is_nan() || air_mass <= 0.0 {
            return Err(FitError::AirMass {
                index,
                found: air_mass,
            });
        }
        let found = scattering_angle.degrees();
        if !(0.0..=180.0 + 1e-9).contains(&found) {
            return Err(FitError::ScatteringAngle { index, found });
        }
        if !(value > 0.0 && value.is_finite()) {
            return Err(FitError::Value {
                index,
                found: value,
            });
        }
    }
    if !zenith.air_mass.is_finite() {
        return Err(FitError::AirMass {
            index: sky.samples.len(),
            found: zenith.air_mass,
        });
    }
    let used: Vec<Sample> = sky
        .samples
        .iter()
        .filter(|s| s.weight > 0.0)
        .copied()
        .collect();
    if used.len() < PARAMETERS {
        return Err(FitError::TooFew {
            expected: PARAMETERS,
            found: used.len(),
        });
    }
    Ok(used)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(truth: &PerezCoefficients) -> Vec<Sample> {
        (0..60)
            .map(|i| {
                let air_mass = 1.0 + f64::from(i % 10).powi(2) * 0.3;
                let scattering_angle = Angle::from_degrees(6.0 + f64::from(i) * 2.8);
                Sample {
                    air_mass,
                    scattering_angle,
                    value: 0.3 * truth.relative_luminance(air_mass, scattering_angle),
                    weight: 1.0 + f64::from(i % 3),
                }
            })
            .collect()
    }

    fn problem(channel: Channel) -> PerezFit {
        let samples = samples(&channel.reference());
        let sky = SkySamples {
            samples: &samples,
            sun_zenith: Angle::from_degrees(50.0),
            zenith_air_mass: 1.0,
        };
        PerezFit::new(&sky, channel, &FitOptions::default()).unwrap()
    }

    #[test]
    fn the_jacobian_agrees_with_finite_differences() {
        for channel in Channel::ALL {
            let problem = problem(channel);
            let (m, n) = (problem.residual_count(), PARAMETERS);
            for shape in channel.starts() {
                let p = problem.parameters_from_coefficients(&PerezCoefficients::from_array(shape));
                let mut jacobian = DMatrix::zeros(m, n);
                problem.jacobian(&p, &mut jacobian);
                for j in 0..n {
                    let h = 1e-5;
                    let (mut up, mut down) = (DVector::zeros(m), DVector::zeros(m));
                    let mut q = p;
                    q[j] = p[j] + h;
                    problem.residuals(&q, &mut up);
                    q[j] = p[j] - h;
                    problem.residuals(&q, &mut down);
                    let numeric = (up - down) / (2.0 * h);
                    let error = (numeric - jacobian.column(j)).amax();
                    assert!(error < 1e-8, "{channel:?} {j}: {error}");
                }
            }
        }
    }

    #[test]
    fn coefficients_and_parameters_are_inverses() {
        for channel in Channel::ALL {
            let problem = problem(channel);
            for shape in channel.starts() {
                let shape = PerezCoefficients::from_array(shape);
                let p = problem.parameters_from_coefficients(&shape);
                let back = problem.coefficients_from_parameters(&p);
                for (x, y) in shape.to_array().iter().zip(back.to_array()) {
                    assert!((x - y).abs() < 1e-12, "{shape:?} {back:?}");
                }
            }
        }
    }

    #[test]
    fn every_corner_of_the_bounds_is_a_sky() {
        let problem = problem(Channel::Luminance);
        let bounds = problem.bounds();
        for corner in 0..64_u32 {
            let mut p = [0.0; PARAMETERS];
            for (j, p) in p.iter_mut().enumerate() {
                let side = if corner >> j & 1 == 0 {
                    &bounds.lower
                } else {
                    &bounds.upper
                };
                *p = side[j];
            }
            let coefficients = problem.coefficients_from_parameters(&p);
            assert_eq!(coefficients.check(1.0), Ok(()), "{coefficients:?}");
        }
    }
}
