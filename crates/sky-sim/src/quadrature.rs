//! Gauss–Legendre quadrature.

/// Nodes and weights on an interval, ascending; exact for polynomials of degree 2n − 1.
#[must_use]
pub(crate) fn gauss_legendre(n: usize, from: f64, to: f64) -> Vec<(f64, f64)> {
    let count = f64::from(u32::try_from(n).unwrap_or(u32::MAX));
    let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
    let mut out = Vec::with_capacity(n);
    for i in 0..n {
        let index = f64::from(u32::try_from(i).unwrap_or(u32::MAX));
        // Newton's method from Tricomi's estimate of the root
        let mut x = -(core::f64::consts::PI * (index + 0.75) / (count + 0.5)).cos();
        let mut derivative = 1.0;
        for _ in 0..100 {
            let (mut p, mut previous) = (1.0, 0.0);
            let mut k = 0.0;
            for _ in 0..n {
                let next = ((2.0 * k + 1.0) * x * p - k * previous) / (k + 1.0);
                previous = p;
                p = next;
                k += 1.0;
            }
            derivative = count * (x * p - previous) / (x * x - 1.0);
            let step = p / derivative;
            x -= step;
            if step.abs() < 1e-15 {
                break;
            }
        }
        let weight = 2.0 / ((1.0 - x * x) * derivative * derivative);
        out.push((middle + half * x, half * weight));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integrates_polynomials_exactly() {
        for n in 1..=16 {
            let degree = 2 * i32::try_from(n).expect("small") - 1;
            let sum: f64 = gauss_legendre(n, 0.5, 2.0)
                .iter()
                .map(|(x, w)| w * x.powi(degree))
                .sum();
            let exact =
                (2.0_f64.powi(degree + 1) - 0.5_f64.powi(degree + 1)) / f64::from(degree + 1);
            assert!((sum / exact - 1.0).abs() < 1e-12, "n = {n}: {sum} {exact}");
        }
    }
}
