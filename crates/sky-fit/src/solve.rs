//! Levenberg–Marquardt least squares as an argmin `Solver`, with box bounds and a report of why it
//! stopped.
//!
//! Purpose: small dense problems (a handful of parameters, up to some thousands of residuals) with an
//! analytic Jacobian. Simplifications: one local minimum; whoever calls brings the starts. Out of
//! scope: sparse or large problems, robust losses.
//!
//! Sources: damping after Nielsen 1999 (IMM-REP-1999-05); scaling by the largest column norms seen and
//! the stopping tests after Moré 1978 (MINPACK); bounds by an active set with projected steps.

use argmin::core::{
    Error, Executor, IterState, KV, Problem, Solver, State, TerminationReason, TerminationStatus,
};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

/// A least-squares problem: the cost is half the sum of the squared residuals. Weights are inside the
/// residuals.
///
/// A residual that is not finite marks parameters at which the problem is not defined; the solver
/// steps back from them.
pub trait LeastSquares {
    /// How many parameters there are.
    fn parameter_count(&self) -> usize;

    /// How many residuals there are.
    fn residual_count(&self) -> usize;

    /// Writes all residuals at `parameters`.
    fn residuals(&self, parameters: &[f64], residuals: &mut DVector<f64>);

    /// Writes the derivatives of the residuals at `parameters`: one row a residual, one column a
    /// parameter.
    fn jacobian(&self, parameters: &[f64], jacobian: &mut DMatrix<f64>);

    /// Writes both at once, for problems in which they share most of the work. The solver calls this.
    fn residuals_and_jacobian(
        &self,
        parameters: &[f64],
        residuals: &mut DVector<f64>,
        jacobian: &mut DMatrix<f64>,
    ) {
        self.residuals(parameters, residuals);
        self.jacobian(parameters, jacobian);
    }
}

/// Inclusive box bounds, one pair a parameter; infinite where there is none.
#[derive(Clone, Debug, PartialEq)]
pub struct Bounds {
    /// Lower bounds.
    pub lower: Vec<f64>,
    /// Upper bounds.
    pub upper: Vec<f64>,
}

impl Bounds {
    /// No bounds.
    #[must_use]
    pub fn none(parameter_count: usize) -> Self {
        Self {
            lower: vec![f64::NEG_INFINITY; parameter_count],
            upper: vec![f64::INFINITY; parameter_count],
        }
    }
}

/// When to stop.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SolveOptions {
    /// Relative reduction of the cost, actual and predicted, that is not worth another step.
    pub cost_tolerance: f64,
    /// Length of a step, relative to the parameters' own, scaled, that is not worth taking.
    pub step_tolerance: f64,
    /// Cosine between the residuals and the Jacobian's free columns that counts as a right angle.
    pub gradient_tolerance: f64,
    /// Evaluations of the residuals.
    pub max_evaluations: u32,
    /// Damping of the first step, relative to the scaled normal matrix.
    pub initial_damping: f64,
}

impl Default for SolveOptions {
    fn default() -> Self {
        Self {
            cost_tolerance: 1e-10,
            step_tolerance: 1e-9,
            gradient_tolerance: 1e-10,
            max_evaluations: 200,
            initial_damping: 1e-2,
        }
    }
}

/// Why the solver stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum StopReason {
    /// The residuals vanish.
    ExactFit,
    /// The residuals are at right angles to all directions that the bounds leave free.
    SmallGradient,
    /// The last step promised and gave no more than the tolerance.
    SmallReduction,
    /// The next step is shorter than the tolerance.
    SmallStep,
    /// The evaluations are used up.
    MaxEvaluations,
    /// No step, however small, lowers the cost, before any tolerance was met.
    NoProgress,
    /// The residuals or their derivatives at the start are not finite.
    NotFinite,
}

impl StopReason {
    /// Whether a minimum within the tolerances was found.
    #[must_use]
    pub const fn converged(self) -> bool {
        matches!(
            self,
            Self::ExactFit | Self::SmallGradient | Self::SmallReduction | Self::SmallStep
        )
    }
}

/// How a fit went.
#[must_use]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FitReport {
    /// Why the solver stopped.
    pub why_stopped: StopReason,
    /// Evaluations of the residuals.
    pub evaluations: u32,
    /// Half the sum of the squared residuals at the start.
    pub initial_cost: f64,
    /// Half the sum of the squared residuals at the end.
    pub final_cost: f64,
    /// Root mean square of the residuals at the end.
    pub rms: f64,
    /// Largest absolute residual at the end.
    pub max_residual: f64,
    /// Ratio of the largest to the smallest singular value of the Jacobian with columns of equal
    /// length; infinite if some combination of parameters has no effect at all.
    pub condition_number: f64,
    /// Largest derivative of the cost along a parameter that the bounds leave free, per unit of the
    /// scaled parameter.
    pub gradient_norm: f64,
    /// For each parameter, whether it ended on one of its bounds.
    pub at_bounds: Vec<bool>,
}

/// A minimum and how it was found.
#[must_use]
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// The best parameters found.
    pub parameters: Vec<f64>,
    /// How the fit went.
    pub report: FitReport,
}

/// A problem that cannot be started on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SolveError {
    /// The start has another length than the problem.
    #[error("start: expected {expected} parameters, found {found}")]
    StartLength {
        /// Parameters of the problem.
        expected: usize,
        /// Parameters of the start.
        found: usize,
    },
    /// The bounds have another length than the problem.
    #[error("bounds: expected {expected} pairs, found {found}")]
    BoundsLength {
        /// Parameters of the problem.
        expected: usize,
        /// The shorter of the two lists of bounds.
        found: usize,
    },
    /// A lower bound is above its upper bound, or not a number.
    #[error("bounds of parameter {index}: expected the lower below the upper")]
    BoundsCrossed {
        /// Which parameter, from 0.
        index: usize,
    },
    /// There is nothing to fit.
    #[error("expected at least one parameter and one residual")]
    Empty,
}

/// The state that argmin keeps: parameters and cost.
pub type LevenbergMarquardtState = IterState<DVector<f64>, (), (), (), (), f64>;

/// The solver. Use [`minimize`], or hand it to an argmin `Executor` for observers and checkpoints; then
/// call [`LevenbergMarquardt::report`] on the solver that comes back.
#[derive(Clone, Debug)]
pub struct LevenbergMarquardt {
    bounds: Bounds,
    options: SolveOptions,
    residuals: DVector<f64>,
    trial_residuals: DVector<f64>,
    trial: DVector<f64>,
    jacobian: DMatrix<f64>,
    /// Triangle of the Jacobian's QR decomposition, and the rotated residuals.
    triangle: DMatrix<f64>,
    rotated: DVector<f64>,
    gradient: DVector<f64>,
    scale: DVector<f64>,
    stacked: DMatrix<f64>,
    stacked_rhs: DVector<f64>,
    step: DVector<f64>,
    fixed: Vec<bool>,
    damping: f64,
    damping_growth: f64,
    evaluations: u32,
    initial_cost: f64,
    gradient_norm: f64,
    stop: Option<StopReason>,
}

impl LevenbergMarquardt {
    /// A solver within `bounds`.
    #[must_use]
    pub fn new(bounds: Bounds, options: SolveOptions) -> Self {
        let empty = DVector::zeros(0);
        Self {
            damping: options.initial_damping,
            bounds,
            options,
            residuals: empty.clone(),
            trial_residuals: empty.clone(),
            trial: empty.clone(),
            jacobian: DMatrix::zeros(0, 0),
            triangle: DMatrix::zeros(0, 0),
            rotated: empty.clone(),
            gradient: empty.clone(),
            scale: empty.clone(),
            stacked: DMatrix::zeros(0, 0),
            stacked_rhs: empty.clone(),
            step: empty,
            fixed: Vec::new(),
            damping_growth: 2.0,
            evaluations: 0,
            initial_cost: f64::NAN,
            gradient_norm: f64::NAN,
            stop: None,
        }
    }

    /// How the last run went, from the solver and the parameters it ended at.
    pub fn report(&self, parameters: &[f64]) -> FitReport {
        let final_cost = 0.5 * self.residuals.norm_squared();
        FitReport {
            why_stopped: self.stop.unwrap_or(StopReason::MaxEvaluations),
            evaluations: self.evaluations,
            initial_cost: self.initial_cost,
            final_cost,
            rms: root_mean_square(&self.residuals),
            max_residual: self.residuals.iter().fold(0.0, |m, r| nan_max(m, r.abs())),
            condition_number: condition_number(&self.triangle),
            gradient_norm: self.gradient_norm,
            at_bounds: parameters
                .iter()
                .zip(self.bounds.lower.iter().zip(&self.bounds.upper))
                .map(|(p, (lower, upper))| p <= lower || p >= upper)
                .collect(),
        }
    }

    fn clamp_to_bounds(&self, parameters: &mut DVector<f64>) {
        for (i, p) in parameters.iter_mut().enumerate() {
            // A NaN stays one and is reported as such.
            if *p < self.bounds.lower[i] {
                *p = self.bounds.lower[i];
            } else if *p > self.bounds.upper[i] {
                *p = self.bounds.upper[i];
            }
        }
    }

    /// From residuals and derivatives: the triangle R, the gradient Rᵀ(Qᵀr), and the parameters that
    /// their bounds hold. False if a derivative is not finite; triangle and gradient then stay.
    fn linearize(&mut self, parameters: &DVector<f64>) -> bool {
        self.rotated.copy_from(&self.residuals);
        triangulate(&mut self.jacobian, &mut self.rotated);
        let (rows, n) = self.triangle.shape();
        let upper = |j: usize| 0..(j + 1).min(rows);
        if !(0..n).all(|j| upper(j).all(|i| self.jacobian[(i, j)].is_finite())) {
            return false;
        }
        for j in 0..n {
            let (mut norm_squared, mut slope) = (0.0, 0.0);
            for i in upper(j) {
                let r = self.jacobian[(i, j)];
                self.triangle[(i, j)] = r;
                norm_squared += r * r;
                slope += r * self.rotated[i];
            }
            self.gradient[j] = slope;
            self.scale[j] = self.scale[j].max(norm_squared.sqrt());
            self.fixed[j] = (parameters[j] <= self.bounds.lower[j] && slope >= 0.0)
                || (parameters[j] >= self.bounds.upper[j] && slope <= 0.0);
        }
        self.gradient_norm = (0..n)
            .filter(|&i| !self.fixed[i] && self.scale[i] > 0.0)
            .fold(0.0, |m, i| {
                nan_max(m, (self.gradient[i] / self.scale[i]).abs())
            });
        true
    }

    /// The damped step over the parameters that are free, from the triangle by a second, small QR: the
    /// normal matrix is never formed.
    fn damped_step(&mut self) {
        let n = self.step.len();
        let rows = self.triangle.nrows();
        let root = self.damping.sqrt();
        self.stacked.fill(0.0);
        self.stacked_rhs.fill(0.0);
        for j in 0..n {
            let scale = if self.scale[j] > 0.0 {
                self.scale[j]
            } else {
                1.0
            };
            self.stacked[(rows + j, j)] = root * scale;
            if !self.fixed[j] {
                for i in 0..=j.min(rows - 1) {
                    self.stacked[(i, j)] = self.triangle[(i, j)];
                }
            }
        }
        for i in 0..rows {
            self.stacked_rhs[i] = -self.rotated[i];
        }
        triangulate(&mut self.stacked, &mut self.stacked_rhs);
        for i in (0..n).rev() {
            let mut sum = self.stacked_rhs[i];
            for j in i + 1..n {
                sum -= self.stacked[(i, j)] * self.step[j];
            }
            self.step[i] = sum / self.stacked[(i, i)];
        }
    }

    /// Reduction of the cost that the linear model promises for the step.
    fn predicted_reduction(&self) -> f64 {
        let slope = self.gradient.dot(&self.step);
        let mut curvature = 0.0;
        for i in 0..self.triangle.nrows() {
            let mut row = 0.0;
            for j in i..self.step.len() {
                row += self.triangle[(i, j)] * self.step[j];
            }
            curvature += row * row;
        }
        -slope - 0.5 * curvature
    }

    /// The damped step from a place, cut at the bounds.
    fn bounded_step(&mut self, parameters: &DVector<f64>) {
        self.damped_step();
        self.trial.copy_from(parameters);
        self.trial += &self.step;
        let mut trial = std::mem::replace(&mut self.trial, DVector::zeros(0));
        self.clamp_to_bounds(&mut trial);
        self.trial = trial;
        self.trial.sub_to(parameters, &mut self.step);
    }

    /// Moves to the trial, whose cost is lower; `None` where there are no derivatives.
    fn accept(&mut self, cost: f64, trial_cost: f64, predicted: f64) -> Option<DVector<f64>> {
        let reduction = cost - trial_cost;
        let gain = reduction / predicted;
        std::mem::swap(&mut self.residuals, &mut self.trial_residuals);
        let accepted = self.trial.clone();
        if !self.linearize(&accepted) {
            // Values without derivatives: stay where both are known.
            std::mem::swap(&mut self.residuals, &mut self.trial_residuals);
            self.stop = Some(StopReason::NoProgress);
            return None;
        }
        self.damping *= (1.0 - (2.0 * gain - 1.0).powi(3)).max(1.0 / 3.0);
        self.damping_growth = 2.0;
        let worthwhile = self.options.cost_tolerance * cost;
        if reduction <= worthwhile && predicted <= worthwhile {
            self.stop = Some(StopReason::SmallReduction);
        }
        Some(accepted)
    }

    fn iterate<O: LeastSquares>(
        &mut self,
        problem: &O,
        parameters: DVector<f64>,
        cost: f64,
    ) -> (DVector<f64>, f64) {
        if cost <= f64::MIN_POSITIVE {
            self.stop = Some(StopReason::ExactFit);
            return (parameters, cost);
        }
        if self.gradient_norm <= self.options.gradient_tolerance * (2.0 * cost).sqrt() {
            self.stop = Some(StopReason::SmallGradient);
            return (parameters, cost);
        }
        loop {
            self.bounded_step(&parameters);
            let scaled = |v: &DVector<f64>| v.component_mul(&self.scale).norm();
            if scaled(&self.step)
                <= self.options.step_tolerance * (scaled(&parameters) + self.options.step_tolerance)
            {
                self.stop = Some(StopReason::SmallStep);
                return (parameters, cost);
            }
            let predicted = self.predicted_reduction();
            if predicted > 0.0 {
                if self.evaluations >= self.options.max_evaluations {
                    self.stop = Some(StopReason::MaxEvaluations);
                    return (parameters, cost);
                }
                problem.residuals_and_jacobian(
                    self.trial.as_slice(),
                    &mut self.trial_residuals,
                    &mut self.jacobian,
                );
                self.evaluations += 1;
                let trial_cost = 0.5 * self.trial_residuals.norm_squared();
                // NaN and infinity fail this test as a higher cost does.
                if trial_cost < cost {
                    return match self.accept(cost, trial_cost, predicted) {
                        Some(accepted) => (accepted, trial_cost),
                        None => (parameters, cost),
                    };
                }
                // At the end rounding decides whether a tiny step looks like progress.
                if predicted <= f64::EPSILON * cost {
                    self.stop = Some(StopReason::SmallReduction);
                    return (parameters, cost);
                }
            }
            self.damping *= self.damping_growth;
            self.damping_growth *= 2.0;
            if self.damping.is_nan() || self.damping > 1e30 {
                self.stop = Some(StopReason::NoProgress);
                return (parameters, cost);
            }
        }
    }
}

impl<O: LeastSquares> Solver<O, LevenbergMarquardtState> for LevenbergMarquardt {
    fn name(&self) -> &'static str {
        "Levenberg-Marquardt with box bounds"
    }

    fn init(
        &mut self,
        problem: &mut Problem<O>,
        mut state: LevenbergMarquardtState,
    ) -> Result<(LevenbergMarquardtState, Option<KV>), Error> {
        let mut parameters = state.take_param().unwrap_or_else(|| DVector::zeros(0));
        let cost = problem.problem("residuals", |problem| {
            check(problem, parameters.len(), &self.bounds)?;
            let (m, n) = (problem.residual_count(), problem.parameter_count());
            self.clamp_to_bounds(&mut parameters);
            self.residuals = DVector::zeros(m);
            self.trial_residuals = DVector::zeros(m);
            self.rotated = DVector::zeros(m);
            self.jacobian = DMatrix::zeros(m, n);
            self.triangle = DMatrix::zeros(m.min(n), n);
            self.stacked = DMatrix::zeros(m.min(n) + n, n);
            self.stacked_rhs = DVector::zeros(m.min(n) + n);
            self.trial = DVector::zeros(n);
            self.gradient = DVector::zeros(n);
            self.scale = DVector::zeros(n);
            self.step = DVector::zeros(n);
            self.fixed = vec![false; n];
            self.damping = self.options.initial_damping;
            self.damping_growth = 2.0;
            self.evaluations = 1;
            self.stop = None;
            problem.residuals_and_jacobian(
                parameters.as_slice(),
                &mut self.residuals,
                &mut self.jacobian,
            );
            let cost = 0.5 * self.residuals.norm_squared();
            self.initial_cost = cost;
            if !cost.is_finite() || !self.linearize(&parameters) {
                self.stop = Some(StopReason::NotFinite);
            }
            Ok(cost)
        })?;
        Ok((state.param(parameters).cost(cost), None))
    }

    fn next_iter(
        &mut self,
        problem: &mut Problem<O>,
        mut state: LevenbergMarquardtState,
    ) -> Result<(LevenbergMarquardtState, Option<KV>), Error> {
        let cost = state.get_cost();
        let Some(parameters) = state.take_param() else {
            return Err(SolveError::Empty.into());
        };
        let (parameters, cost) = problem.problem("iterations", |problem| {
            Ok(self.iterate(problem, parameters, cost))
        })?;
        Ok((state.param(parameters).cost(cost), None))
    }

    fn terminate(&mut self, _state: &LevenbergMarquardtState) -> TerminationStatus {
        match self.stop {
            None => TerminationStatus::NotTerminated,
            Some(StopReason::MaxEvaluations) => {
                TerminationStatus::Terminated(TerminationReason::MaxItersReached)
            }
            Some(reason) if reason.converged() => {
                TerminationStatus::Terminated(TerminationReason::SolverConverged)
            }
            Some(reason) => {
                TerminationStatus::Terminated(TerminationReason::SolverExit(format!("{reason:?}")))
            }
        }
    }
}

impl<P: LeastSquares> LeastSquares for &P {
    fn parameter_count(&self) -> usize {
        (**self).parameter_count()
    }

    fn residual_count(&self) -> usize {
        (**self).residual_count()
    }

    fn residuals(&self, parameters: &[f64], residuals: &mut DVector<f64>) {
        (**self).residuals(parameters, residuals);
    }

    fn jacobian(&self, parameters: &[f64], jacobian: &mut DMatrix<f64>) {
        (**self).jacobian(parameters, jacobian);
    }

    fn residuals_and_jacobian(
        &self,
        parameters: &[f64],
        residuals: &mut DVector<f64>,
        jacobian: &mut DMatrix<f64>,
    ) {
        (**self).residuals_and_jacobian(parameters, residuals, jacobian);
    }
}

/// The local minimum reached from `start`, which is moved into the bounds first.
///
/// Deterministic; does not panic on residuals that are not finite, see [`StopReason::NotFinite`].
///
/// # Errors
/// When start, bounds and problem do not fit together.
pub fn minimize<P: LeastSquares>(
    problem: &P,
    start: &[f64],
    bounds: &Bounds,
    options: &SolveOptions,
) -> Result<Solution, SolveError> {
    check(&problem, start.len(), bounds)?;
    let solver = LevenbergMarquardt::new(bounds.clone(), *options);
    let outcome = Executor::new(problem, solver)
        .configure(|state| state.param(DVector::from_column_slice(start)))
        .run()
        // The arguments were checked above; the solver has no other error.
        .map_err(|_| SolveError::Empty)?;
    let parameters = outcome
        .state
        .get_param()
        .map_or_else(|| start.to_vec(), |p| p.as_slice().to_vec());
    let report = outcome.solver.report(&parameters);
    Ok(Solution { parameters, report })
}

fn check<P: LeastSquares>(problem: &P, start: usize, bounds: &Bounds) -> Result<(), SolveError> {
    let expected = problem.parameter_count();
    if expected == 0 || problem.residual_count() == 0 {
        return Err(SolveError::Empty);
    }
    if start != expected {
        return Err(SolveError::StartLength {
            expected,
            found: start,
        });
    }
    let found = bounds.lower.len().min(bounds.upper.len());
    if found != expected || bounds.lower.len() != bounds.upper.len() {
        return Err(SolveError::BoundsLength { expected, found });
    }
    for (index, (lower, upper)) in bounds.lower.iter().zip(&bounds.upper).enumerate() {
        if lower.is_nan() || upper.is_nan() || lower > upper {
            return Err(SolveError::BoundsCrossed { index });
        }
    }
    Ok(())
}

/// Householder QR in place: the triangle replaces the upper part of `a`, what lies below it is
/// scratch, and `b` is rotated along.
fn triangulate(a: &mut DMatrix<f64>, b: &mut DVector<f64>) {
    let (m, n) = a.shape();
    for k in 0..n.min(m) {
        let norm = a.view((k, k), (m - k, 1)).norm();
        if norm <= 0.0 {
            continue;
        }
        let head = a[(k, k)];
        let alpha = if head > 0.0 { -norm } else { norm };
        // v = x − α e₁, H = I − v vᵀ / (α(α − x₁))
        let inverse = 1.0 / (alpha * (alpha - head));
        a[(k, k)] = head - alpha;
        let (left, mut right) = a.columns_range_pair_mut(k..=k, k + 1..n);
        let v = left.rows_range(k..m);
        let v = v.column(0);
        for mut column in right.column_iter_mut() {
            let mut tail = column.rows_range_mut(k..m);
            let factor = -v.dot(&tail) * inverse;
            tail.axpy(factor, &v, 1.0);
        }
        let mut tail = b.rows_range_mut(k..m);
        let factor = -v.dot(&tail) * inverse;
        tail.axpy(factor, &v, 1.0);
        a[(k, k)] = alpha;
    }
}

/// Ratio of the extreme singular values of a triangle after its columns are scaled to unit length.
fn condition_number(triangle: &DMatrix<f64>) -> f64 {
    if triangle.nrows() < triangle.ncols() {
        return f64::INFINITY;
    }
    let mut scaled = triangle.clone();
    for mut column in scaled.column_iter_mut() {
        let norm = column.norm();
        if !(norm > 0.0 && norm.is_finite()) {
            return f64::INFINITY;
        }
        column /= norm;
    }
    let values = scaled.singular_values();
    if values.min() > 0.0 {
        values.max() / values.min()
    } else {
        f64::INFINITY
    }
}

/// Condition number of a Jacobian with columns scaled to unit length; see [`FitReport`].
pub(crate) fn jacobian_condition_number(mut jacobian: DMatrix<f64>) -> f64 {
    let mut scratch = DVector::zeros(jacobian.nrows());
    triangulate(&mut jacobian, &mut scratch);
    condition_number(&jacobian.upper_triangle())
}

#[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
fn root_mean_square(residuals: &DVector<f64>) -> f64 {
    (residuals.norm_squared() / residuals.len() as f64).sqrt()
}

/// The larger of two numbers, NaN if one of them is.
fn nan_max(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() {
        f64::NAN
    } else {
        a.max(b)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rosenbrock's valley as residuals; undefined right of `wall`.
    struct Rosenbrock {
        wall: f64,
    }

    impl LeastSquares for Rosenbrock {
        fn parameter_count(&self) -> usize {
            2
        }
        fn residual_count(&self) -> usize {
            2
        }
        fn residuals(&self, p: &[f64], r: &mut DVector<f64>) {
            r[0] = 10.0 * (p[1] - p[0] * p[0]);
            r[1] = if p[0] > self.wall {
                f64::NAN
            } else {
                1.0 - p[0]
            };
        }
        fn jacobian(&self, p: &[f64], j: &mut DMatrix<f64>) {
            j[(0, 0)] = -20.0 * p[0];
            j[(0, 1)] = 10.0;
            j[(1, 0)] = -1.0;
            j[(1, 1)] = 0.0;
        }
    }

    const FREE: Rosenbrock = Rosenbrock {
        wall: f64::INFINITY,
    };

    fn solve(problem: &Rosenbrock, start: [f64; 2], bounds: &Bounds) -> Solution {
        minimize(problem, &start, bounds, &SolveOptions::default()).unwrap()
    }

    #[test]
    fn finds_the_bottom_of_rosenbrocks_valley() {
        let found = solve(&FREE, [-1.2, 1.0], &Bounds::none(2));
        assert!(found.report.why_stopped.converged(), "{found:?}");
        assert!(
            (found.parameters[0] - 1.0).abs() < 1e-9 && (found.parameters[1] - 1.0).abs() < 1e-9
        );
        assert!(found.report.initial_cost > 10.0 && found.report.final_cost < 1e-18);
    }

    #[test]
    fn stops_at_the_minimum_on_a_bound() {
        let bounds = Bounds {
            lower: vec![-2.0, -2.0],
            upper: vec![0.5, 2.0],
        };
        let found = solve(&FREE, [-1.2, 1.0], &bounds);
        assert!(found.report.why_stopped.converged(), "{found:?}");
        assert_eq!(found.report.at_bounds, [true, false]);
        assert!((found.parameters[0] - 0.5).abs() < 1e-15);
        assert!((found.parameters[1] - 0.25).abs() < 1e-8);
    }

    #[test]
    fn a_start_outside_the_bounds_is_moved_inside() {
        let bounds = Bounds {
            lower: vec![-2.0, -2.0],
            upper: vec![2.0, 2.0],
        };
        let found = solve(&FREE, [50.0, -70.0], &bounds);
        assert!((found.parameters[0] - 1.0).abs() < 1e-8, "{found:?}");
    }

    #[test]
    fn steps_back_from_where_the_problem_is_undefined() {
        let found = solve(&Rosenbrock { wall: 0.7 }, [-1.2, 1.0], &Bounds::none(2));
        assert!(
            found.parameters[0] <= 0.7 && found.parameters[0] > 0.69,
            "{found:?}"
        );
        assert!(found.report.final_cost.is_finite());
    }

    #[test]
    fn a_start_without_a_cost_is_reported() {
        for start in [[f64::NAN, 1.0], [2.0, 1.0], [f64::INFINITY, 0.0]] {
            let found = solve(&Rosenbrock { wall: 1.5 }, start, &Bounds::none(2));
            assert_eq!(found.report.why_stopped, StopReason::NotFinite);
        }
    }

    #[test]
    fn the_evaluations_are_limited() {
        let options = SolveOptions {
            max_evaluations: 5,
            ..SolveOptions::default()
        };
        let found = minimize(&FREE, &[-1.2, 1.0], &Bounds::none(2), &options).unwrap();
        assert_eq!(found.report.why_stopped, StopReason::MaxEvaluations);
        assert_eq!(found.report.evaluations, 5);
    }

    #[test]
    fn what_does_not_fit_together_is_refused() {
        let options = SolveOptions::default();
        assert_eq!(
            minimize(&FREE, &[1.0], &Bounds::none(2), &options),
            Err(SolveError::StartLength {
                expected: 2,
                found: 1
            })
        );
        assert_eq!(
            minimize(&FREE, &[1.0, 1.0], &Bounds::none(3), &options),
            Err(SolveError::BoundsLength {
                expected: 2,
                found: 3
            })
        );
        let crossed = Bounds {
            lower: vec![0.0, 2.0],
            upper: vec![1.0, 1.0],
        };
        assert_eq!(
            minimize(&FREE, &[1.0, 1.0], &crossed, &options),
            Err(SolveError::BoundsCrossed { index: 1 })
        );
    }

    #[test]
    fn a_parameter_without_effect_is_seen_in_the_condition_number() {
        struct Idle;
        impl LeastSquares for Idle {
            fn parameter_count(&self) -> usize {
                2
            }
            fn residual_count(&self) -> usize {
                3
            }
            fn residuals(&self, p: &[f64], r: &mut DVector<f64>) {
                for (i, x) in [1.0, 2.0, 4.0].into_iter().enumerate() {
                    r[i] = p[0] * x - 3.0;
                }
            }
            fn jacobian(&self, _: &[f64], j: &mut DMatrix<f64>) {
                for (i, x) in [1.0, 2.0, 4.0].into_iter().enumerate() {
                    j[(i, 0)] = x;
                    j[(i, 1)] = 0.0;
                }
            }
        }
        let found = minimize(
            &Idle,
            &[0.0, 5.0],
            &Bounds::none(2),
            &SolveOptions::default(),
        )
        .unwrap();
        assert!((found.parameters[0] - 1.0).abs() < 1e-9, "{found:?}");
        assert!((found.parameters[1] - 5.0).abs() < 1e-15);
        assert!(found.report.condition_number.is_infinite());
    }

    #[test]
    fn the_triangle_has_the_same_normal_matrix() {
        let a = DMatrix::from_fn(9, 4, |i, j| ((i * 7 + j * 3 + i * j) % 11) as f64 - 4.0);
        let b = DVector::from_fn(9, |i, _| i as f64 - 3.0);
        let (mut r, mut c) = (a.clone(), b.clone());
        triangulate(&mut r, &mut c);
        let r = r.upper_triangle();
        assert!((r.tr_mul(&r) - a.tr_mul(&a)).norm() < 1e-10);
        let head = c.rows(0, 4);
        let square = r.rows(0, 4).into_owned();
        assert!((square.tr_mul(&head) - a.tr_mul(&b)).norm() < 1e-10);
    }
}
