//! Symmetric positive definite banded linear systems with three right-hand sides.

/// A matrix that is not positive definite.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("linear system: expected a positive pivot in row {row}, found {found}")]
pub struct NotPositive {
    /// The row.
    pub row: usize,
    /// The pivot.
    pub found: f64,
}

/// The lower band of a symmetric matrix, and the right-hand sides.
#[derive(Clone, Debug)]
pub(crate) struct BandedSystem {
    size: usize,
    /// Entries kept left of the diagonal.
    width: usize,
    /// Row by row; the diagonal is the last entry of a row.
    band: Vec<f64>,
    right: Vec<[f64; 3]>,
}

impl BandedSystem {
    pub(crate) fn new(size: usize, width: usize) -> Self {
        let width = width.min(size);
        Self {
            size,
            width,
            band: vec![0.0; size * (width + 1)],
            right: vec![[0.0; 3]; size],
        }
    }

    /// Adds `factor` times a square block whose first entry is at a row and column; the part above the
    /// diagonal is dropped, its mirror image is expected to be added too.
    pub(crate) fn add_block(
        &mut self,
        row: usize,
        column: usize,
        size: usize,
        block: &[f64],
        factor: f64,
    ) {
        for i in 0..size {
            for j in 0..size {
                let (r, c) = (row + i, column + j);
                if c <= r {
                    self.band[r * (self.width + 1) + self.width - (r - c)] +=
                        factor * block[i * size + j];
                }
            }
        }
    }

    pub(crate) fn add_right(&mut self, row: usize, values: &[f64; 3]) {
        for (to, from) in self.right[row].iter_mut().zip(values) {
            *to += from;
        }
    }

    pub(crate) fn add_diagonal(&mut self, value: f64) {
        for row in 0..self.size {
            self.band[row * (self.width + 1) + self.width] += value;
        }
    }

    /// Cholesky's factorization in place, then both substitutions.
    pub(crate) fn solve(mut self) -> Result<Vec<[f64; 3]>, NotPositive> {
        let (n, w) = (self.size, self.width);
        let row_start = |r: usize| r.saturating_sub(w);
        for r in 0..n {
            let (done, rest) = self.band.split_at_mut(r * (w + 1));
            let this = &mut rest[..=w];
            for c in row_start(r)..r {
                let other = &done[c * (w + 1)..(c + 1) * (w + 1)];
                let from = row_start(r).max(row_start(c));
                let length = c - from;
                let (a, b) = (&this[w - (r - from)..][..length], &other[w - length..w]);
                let sum: f64 = a.iter().zip(b).map(|(x, y)| x * y).sum();
                this[w - (r - c)] = (this[w - (r - c)] - sum) / other[w];
            }
            let squares: f64 = this[w - (r - row_start(r))..w].iter().map(|x| x * x).sum();
            let pivot = this[w] - squares;
            if pivot.is_nan() || pivot <= 0.0 {
                return Err(NotPositive {
                    row: r,
                    found: pivot,
                });
            }
            this[w] = pivot.sqrt();
        }
        for r in 0..n {
            let row = &self.band[r * (w + 1)..(r + 1) * (w + 1)];
            for k in 0..3 {
                let sum: f64 = (row_start(r)..r)
                    .map(|c| row[w - (r - c)] * self.right[c][k])
                    .sum();
                self.right[r][k] = (self.right[r][k] - sum) / row[w];
            }
        }
        for r in (0..n).rev() {
            let row = &self.band[r * (w + 1)..(r + 1) * (w + 1)];
            for k in 0..3 {
                self.right[r][k] /= row[w];
                let x = self.right[r][k];
                for c in row_start(r)..r {
                    self.right[c][k] -= row[w - (r - c)] * x;
                }
            }
        }
        Ok(self.right)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_a_banded_system() {
        let n = 40;
        let mut system = BandedSystem::new(n, 6);
        let block = [4.0, 1.0, 1.0, 3.0];
        for i in 0..n / 2 {
            system.add_block(2 * i, 2 * i, 2, &block, 2.0);
            if i > 0 {
                system.add_block(2 * i, 2 * i - 2, 2, &[0.5, -0.25, 0.1, 0.3], 1.0);
            }
        }
        let dense = system.clone();
        let at = |r: usize, c: usize| {
            let (r, c) = (r.max(c), r.min(c));
            if r - c > 6 {
                0.0
            } else {
                dense.band[r * 7 + 6 - (r - c)]
            }
        };
        for i in 0..n {
            let x = f64::from(u32::try_from(i).expect("small")).sin();
            system.add_right(i, &[x, 1.0, -x]);
        }
        let right = system.right.clone();
        let x = system.solve().expect("positive definite");
        for (r, right) in right.iter().enumerate() {
            for (k, right) in right.iter().enumerate() {
                let product: f64 = (0..n).map(|c| at(r, c) * x[c][k]).sum();
                assert!((product - right).abs() < 1e-12);
            }
        }
        assert!(BandedSystem::new(3, 1).solve().is_err());
    }
}
