//! Phase functions, per steradian: their integral over the sphere is 1.

use core::f64::consts::PI;

/// Rayleigh's phase function without depolarization \[sr⁻¹\].
#[must_use]
pub fn rayleigh(cos_gamma: f64) -> f64 {
    3.0 / (16.0 * PI) * (1.0 + cos_gamma * cos_gamma)
}

/// Rayleigh's phase function with depolarization ρ \[sr⁻¹\] (Bucholtz 1995, Eq. 12).
#[must_use]
pub fn rayleigh_depolarized(cos_gamma: f64, depolarization: f64) -> f64 {
    let gamma = depolarization / (2.0 - depolarization);
    3.0 / (16.0 * PI * (1.0 + 2.0 * gamma))
        * ((1.0 + 3.0 * gamma) + (1.0 - gamma) * cos_gamma * cos_gamma)
}

/// Henyey & Greenstein 1941 \[sr⁻¹\]. Hoffman & Preetham's published shader has (1 − g)² for the
/// numerator, which loses all but (1 − g)/(1 + g) of the light; the print of Nielsen 2003 lacks a g
/// in the denominator, which turns negative. This is the normalized form.
#[must_use]
pub fn henyey_greenstein(cos_gamma: f64, g: f64) -> f64 {
    let denominator = (1.0 - g) * (1.0 - g) + 2.0 * g * (1.0 - cos_gamma);
    (1.0 - g * g) / (4.0 * PI * denominator * denominator.sqrt())
}

/// Cornette & Shanks 1992 \[sr⁻¹\]; Nishita et al. 1993, Eq. 5, is this times 4π.
#[must_use]
pub fn cornette_shanks(cos_gamma: f64, g: f64) -> f64 {
    1.5 * (1.0 + cos_gamma * cos_gamma) / (2.0 + g * g) * henyey_greenstein(cos_gamma, g)
}

/// The g of Cornette & Shanks from the mean cosine u (Nishita et al. 1993, below Eq. 5).
#[must_use]
pub fn cornette_shanks_g(u: f64) -> f64 {
    let (u2, u4) = (u * u, u * u * u * u);
    let root = (64.0 / 27.0 - 325.0 / 243.0 * u2 + 1250.0 / 2187.0 * u4).sqrt();
    let x = 5.0 / 9.0 * u + 125.0 / 729.0 * u * u2 + root;
    5.0 / 9.0 * u - (4.0 / 3.0 - 25.0 / 81.0 * u2) / x.cbrt() + x.cbrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Integral over the sphere and mean cosine, Simpson's rule on angles.
    fn moments(phase: impl Fn(f64) -> f64) -> [f64; 2] {
        let n = 20_000_u32;
        let step = PI / f64::from(n);
        let mut out = [0.0; 2];
        for i in 0..=n {
            let angle = step * f64::from(i);
            let weight = if i == 0 || i == n {
                1.0
            } else if i % 2 == 1 {
                4.0
            } else {
                2.0
            };
            let share = weight * step / 3.0 * 2.0 * PI * angle.sin() * phase(angle.cos());
            out[0] += share;
            out[1] += share * angle.cos();
        }
        out
    }

    #[test]
    fn phase_functions_are_normalized() {
        for g in [0.0, 0.3, 0.75, 0.9] {
            let [sum, mean] = moments(|mu| henyey_greenstein(mu, g));
            assert!((sum - 1.0).abs() < 1e-8 && (mean - g).abs() < 1e-8, "{g}");
            assert!((moments(|mu| cornette_shanks(mu, g))[0] - 1.0).abs() < 1e-8);
        }
        assert!((moments(rayleigh)[0] - 1.0).abs() < 1e-9);
        assert!((moments(|mu| rayleigh_depolarized(mu, 0.0283))[0] - 1.0).abs() < 1e-9);
    }

    #[test]
    fn nishitas_u_is_the_mean_cosine() {
        for u in [0.0, 0.5, 0.7, 0.75, 0.85] {
            let g = cornette_shanks_g(u);
            let [_, mean] = moments(|mu| cornette_shanks(mu, g));
            assert!((mean - u).abs() < 1e-7, "{u}: {mean}");
        }
    }

    #[test]
    fn henyey_greenstein_as_misprinted_loses_the_light() {
        // (1 − g)² for 1 − g² keeps 14.3 % at g = 0.75 and 5.3 % at 0.9.
        for (g, kept) in [(0.75, 0.143), (0.9, 0.053)] {
            let printed = |mu: f64| henyey_greenstein(mu, g) * (1.0 - g) / (1.0 + g);
            assert!((moments(printed)[0] - kept).abs() < 5e-4);
        }
    }
}
