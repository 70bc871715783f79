//! Wavelength grids and spectra: validated tables, interpolation, trapezoid weights.
//!
//! Wavelengths are in nanometres of air or vacuum as the source of a table has them; the difference
//! (0.2 nm) is far below the 1 nm of the tables.

use crate::lagrange::{four_from, lagrange_weights};
use thiserror::Error;

/// A wavelength grid or spectrum that cannot be used: where, what was expected, what was found.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum SpectrumError {
    /// Too few wavelengths.
    #[error("{found} wavelengths, expected at least {expected}")]
    TooFew {
        /// How many are needed.
        expected: usize,
        /// How many there are.
        found: usize,
    },
    /// As many values as wavelengths are needed.
    #[error("{found} values for {expected} wavelengths")]
    LengthMismatch {
        /// Number of wavelengths.
        expected: usize,
        /// Number of values.
        found: usize,
    },
    /// A wavelength is not a finite positive number.
    #[error("wavelength {index} is {found_nm} nm, expected a positive number")]
    NotPositive {
        /// Position in the grid, from 0.
        index: usize,
        /// The wavelength found \[nm\].
        found_nm: f64,
    },
    /// Wavelengths must ascend strictly.
    #[error("wavelength {index} is {found_nm} nm, expected more than {above_nm} nm")]
    NotAscending {
        /// Position in the grid, from 0.
        index: usize,
        /// The wavelength before it \[nm\].
        above_nm: f64,
        /// The wavelength found \[nm\].
        found_nm: f64,
    },
    /// A value is NaN or infinite.
    #[error("the value at {wavelength_nm} nm is {found}, expected a finite number")]
    NotFinite {
        /// Where \[nm\].
        wavelength_nm: f64,
        /// The value found.
        found: f64,
    },
    /// A spectrum does not cover the range that is asked of it.
    #[error(
        "the spectrum covers {}..{} nm, expected it to cover {}..{} nm",
        found_nm[0], found_nm[1], expected_nm[0], expected_nm[1]
    )]
    NotCovered {
        /// The range needed \[nm\].
        expected_nm: [f64; 2],
        /// The range of the spectrum \[nm\].
        found_nm: [f64; 2],
    },
    /// Wavelengths that leave out a part of the visible have no color.
    #[error(
        "the wavelengths cover {}..{} nm, expected them to cover {}..{} nm for a color",
        found_nm[0], found_nm[1], expected_nm[0], expected_nm[1]
    )]
    NotVisible {
        /// The range needed \[nm\].
        expected_nm: [f64; 2],
        /// The range of the wavelengths \[nm\].
        found_nm: [f64; 2],
    },
    /// A uniform grid needs a step that divides its range.
    #[error("a step of {step_nm} nm does not divide {}..{} nm", range_nm[0], range_nm[1])]
    StepDoesNotDivide {
        /// The range \[nm\].
        range_nm: [f64; 2],
        /// The step \[nm\].
        step_nm: f64,
    },
}

/// Checks that wavelengths \[nm\] are positive and strictly ascending, and that there are at least
/// `at_least` of them.
///
/// # Errors
/// Names the first wavelength that is not as expected.
pub fn check_wavelengths(wavelength_nm: &[f64], at_least: usize) -> Result<(), SpectrumError> {
    if wavelength_nm.len() < at_least {
        return Err(SpectrumError::TooFew {
            expected: at_least,
            found: wavelength_nm.len(),
        });
    }
    for (index, &found_nm) in wavelength_nm.iter().enumerate() {
        if !(found_nm.is_finite() && found_nm > 0.0) {
            return Err(SpectrumError::NotPositive { index, found_nm });
        }
    }
    for (index, pair) in wavelength_nm.windows(2).enumerate() {
        if pair[1] <= pair[0] {
            return Err(SpectrumError::NotAscending {
                index: index + 1,
                above_nm: pair[0],
                found_nm: pair[1],
            });
        }
    }
    Ok(())
}

/// Wavelengths from `first_nm` to `last_nm`, both included, every `step_nm` \[nm\].
///
/// # Errors
/// When the step does not divide the range, or the range is not positive and ascending.
pub fn uniform_wavelengths(
    first_nm: f64,
    last_nm: f64,
    step_nm: f64,
) -> Result<Vec<f64>, SpectrumError> {
    let intervals = (last_nm - first_nm) / step_nm;
    if !(step_nm > 0.0 && (1.0..=1e6).contains(&intervals))
        || (intervals - intervals.round()).abs() > 1e-9
    {
        return Err(SpectrumError::StepDoesNotDivide {
            range_nm: [first_nm, last_nm],
            step_nm,
        });
    }
    let mut wavelength_nm = Vec::new();
    let mut k = 0.0;
    while k <= intervals + 0.5 {
        wavelength_nm.push(first_nm + k * step_nm);
        k += 1.0;
    }
    check_wavelengths(&wavelength_nm, 2)?;
    Ok(wavelength_nm)
}

/// A tabulated function of wavelength, linear between its entries.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum {
    wavelength_nm: Vec<f64>,
    values: Vec<f64>,
}

impl Spectrum {
    /// From wavelengths \[nm\] and the values there, in whatever unit the caller means.
    ///
    /// # Errors
    /// When the wavelengths are not positive and strictly ascending, when the number of values
    /// differs, or when a value is not finite.
    pub fn new(wavelength_nm: Vec<f64>, values: Vec<f64>) -> Result<Self, SpectrumError> {
        check_wavelengths(&wavelength_nm, 1)?;
        if values.len() != wavelength_nm.len() {
            return Err(SpectrumError::LengthMismatch {
                expected: wavelength_nm.len(),
                found: values.len(),
            });
        }
        for (&wavelength_nm, &found) in wavelength_nm.iter().zip(&values) {
            if !found.is_finite() {
                return Err(SpectrumError::NotFinite {
                    wavelength_nm,
                    found,
                });
            }
        }
        Ok(Self {
            wavelength_nm,
            values,
        })
    }

    /// The wavelengths \[nm\].
    #[must_use]
    pub fn wavelength_nm(&self) -> &[f64] {
        &self.wavelength_nm
    }

    /// The values, one per wavelength.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// First and last wavelength \[nm\].
    #[must_use]
    pub fn range_nm(&self) -> [f64; 2] {
        [
            self.wavelength_nm[0],
            self.wavelength_nm[self.wavelength_nm.len() - 1],
        ]
    }

    /// The value at a wavelength \[nm\], linear between entries; `None` outside the table.
    #[must_use]
    pub fn at(&self, wavelength_nm: f64) -> Option<f64> {
        interpolate_linear(&self.wavelength_nm, &self.values, wavelength_nm)
    }
}

/// Index of the interval of an ascending `grid` that holds `x`; `None` outside the grid.
fn interval(grid: &[f64], x: f64) -> Option<usize> {
    let (&first, &last) = (grid.first()?, grid.last()?);
    if !(x >= first && x <= last) {
        return None;
    }
    let above = grid.partition_point(|&g| g <= x);
    Some(above.clamp(1, grid.len().max(2) - 1) - 1)
}

/// Linear interpolation of `values` on an ascending `grid`; `None` outside it.
#[must_use]
pub fn interpolate_linear(grid: &[f64], values: &[f64], x: f64) -> Option<f64> {
    let i = interval(grid, x)?;
    if grid.len() == 1 {
        return values.first().copied();
    }
    let t = (x - grid[i]) / (grid[i + 1] - grid[i]);
    Some(values[i] * (1.0 - t) + values[i + 1] * t)
}

/// Weights of the trapezoid rule on a grid: Σ w·f is the integral of the piecewise linear f.
/// A single point counts as one unit wide, so that one wavelength can be looked at too.
#[must_use]
pub fn trapezoid_weights(grid: &[f64]) -> Vec<f64> {
    if grid.len() == 1 {
        return vec![1.0];
    }
    let mut weights = vec![0.0; grid.len()];
    for (i, pair) in grid.windows(2).enumerate() {
        let half = 0.5 * (pair[1] - pair[0]);
        weights[i] += half;
        weights[i + 1] += half;
    }
    weights
}

/// Interpolation weights of a point: `weights[k]` belongs to grid entry `first + k`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalWeights {
    /// First grid entry that is used.
    pub first: usize,
    /// How many entries are used, 1 to 4.
    pub count: usize,
    /// The weights; their sum is 1. Only the first `count` are used.
    pub weights: [f64; 4],
}

/// Weights of the cubic Lagrange interpolation through the four grid entries round `x`; linear in
/// the first and the last interval, where no entry lies on one side. `None` outside the grid.
///
/// Exact for cubics inside, for straight lines at the ends.
#[must_use]
pub fn cubic_weights(grid: &[f64], x: f64) -> Option<LocalWeights> {
    let i = interval(grid, x)?;
    if grid.len() == 1 {
        return Some(LocalWeights {
            first: 0,
            count: 1,
            weights: [1.0, 0.0, 0.0, 0.0],
        });
    }
    if i == 0 || i + 2 >= grid.len() {
        let t = (x - grid[i]) / (grid[i + 1] - grid[i]);
        return Some(LocalWeights {
            first: i,
            count: 2,
            weights: [1.0 - t, t, 0.0, 0.0],
        });
    }
    Some(LocalWeights {
        first: i - 1,
        count: 4,
        weights: lagrange_weights(&four_from(grid, i - 1), x),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uniform_grids_include_both_ends() {
        let grid = uniform_wavelengths(380.0, 780.0, 10.0).unwrap();
        assert_eq!(grid.len(), 41);
        assert!((grid[40] - 780.0).abs() < 1e-12);
        assert!(uniform_wavelengths(380.0, 780.0, 7.0).is_err());
        assert!(uniform_wavelengths(380.0, 780.0, 0.0).is_err());
        assert!(uniform_wavelengths(380.0, 780.0, -10.0).is_err());
        assert!(uniform_wavelengths(380.0, 780.0, f64::NAN).is_err());
        assert!(uniform_wavelengths(0.0, 780.0, 10.0).is_err());
    }

    #[test]
    fn bad_grids_are_named() {
        assert!(matches!(
            check_wavelengths(&[400.0, 390.0], 1),
            Err(SpectrumError::NotAscending { index: 1, .. })
        ));
        assert!(matches!(
            check_wavelengths(&[400.0, 400.0], 1),
            Err(SpectrumError::NotAscending { index: 1, .. })
        ));
        assert!(matches!(
            check_wavelengths(&[f64::NAN], 1),
            Err(SpectrumError::NotPositive { index: 0, .. })
        ));
        assert!(matches!(
            check_wavelengths(&[], 1),
            Err(SpectrumError::TooFew { .. })
        ));
        assert!(matches!(
            Spectrum::new(vec![400.0, 500.0], vec![1.0]),
            Err(SpectrumError::LengthMismatch { .. })
        ));
        assert!(matches!(
            Spectrum::new(vec![400.0], vec![f64::INFINITY]),
            Err(SpectrumError::NotFinite { .. })
        ));
    }

    #[test]
    fn linear_interpolation_keeps_nodes_and_refuses_outside() {
        let s = Spectrum::new(vec![400.0, 410.0, 430.0], vec![1.0, 2.0, 6.0]).unwrap();
        for (x, v) in [
            (400.0, 1.0),
            (405.0, 1.5),
            (410.0, 2.0),
            (420.0, 4.0),
            (430.0, 6.0),
        ] {
            assert!((s.at(x).unwrap() - v).abs() < 1e-12);
        }
        assert!(s.at(399.999).is_none());
        assert!(s.at(430.001).is_none());
        assert!(s.at(f64::NAN).is_none());
        let one = Spectrum::new(vec![500.0], vec![3.0]).unwrap();
        assert!((one.at(500.0).unwrap() - 3.0).abs() < 1e-12);
    }

    #[test]
    fn trapezoid_integrates_a_straight_line_exactly() {
        let grid = [380.0, 390.0, 430.0, 431.0];
        let integral: f64 = trapezoid_weights(&grid)
            .iter()
            .zip(grid)
            .map(|(w, x)| w * (2.0 * x - 5.0))
            .sum();
        let exact = (431.0_f64.powi(2) - 380.0_f64.powi(2)) - 5.0 * 51.0;
        assert!((integral - exact).abs() < 1e-8);
    }

    #[test]
    fn cubic_weights_reproduce_a_cubic_inside_and_a_line_at_the_ends() {
        let grid = [1.0, 2.0, 4.0, 5.0, 7.0, 8.0];
        let apply = |x: f64, f: &dyn Fn(f64) -> f64| {
            let l = cubic_weights(&grid, x).unwrap();
            (0..l.count)
                .map(|k| l.weights[k] * f(grid[l.first + k]))
                .sum::<f64>()
        };
        let cubic = |x: f64| x * x * x - 4.0 * x * x + x - 7.0;
        for x in [2.0, 2.5, 4.0, 4.7, 6.1, 7.0] {
            assert!((apply(x, &cubic) - cubic(x)).abs() < 1e-10, "{x}");
        }
        let line = |x: f64| 3.0 * x - 1.0;
        for x in [1.0, 1.3, 2.0, 3.0, 7.5, 8.0] {
            assert!((apply(x, &line) - line(x)).abs() < 1e-12, "{x}");
        }
        assert!(cubic_weights(&grid, 0.9).is_none());
    }
}
