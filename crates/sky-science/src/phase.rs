//! Phase functions, per steradian: their integral over the sphere is 1.
//!
//! Molecules with and without depolarization, Henyey & Greenstein's function with one and two terms,
//! Cornette & Shanks'. Out of scope: Mie theory.

use core::f64::consts::PI;

/// Rayleigh phase function with depolarization ρ \[sr⁻¹\] (Chandrasekhar; Bucholtz 1995, Eq. 12):
/// γ = ρ/(2 − ρ), P = 3/(16π (1 + 2γ)) · ((1 + 3γ) + (1 − γ) μ²).
#[must_use]
#[inline]
pub fn rayleigh(cos_scattering_angle: f64, depolarization: f64) -> f64 {
    let gamma = gamma_from_depolarization(depolarization);
    let mu = cos_scattering_angle;
    3.0 / (16.0 * PI * (1.0 + 2.0 * gamma)) * ((1.0 + 3.0 * gamma) + (1.0 - gamma) * mu * mu)
}

/// Second Legendre moment χ₂ of the Rayleigh phase function, `4πP = Σ (2l + 1) χ_l P_l`; χ₀ = 1, the
/// others are 0.
#[must_use]
pub fn rayleigh_second_moment(depolarization: f64) -> f64 {
    let gamma = gamma_from_depolarization(depolarization);
    (1.0 - gamma) / (10.0 * (1.0 + 2.0 * gamma))
}

fn gamma_from_depolarization(depolarization: f64) -> f64 {
    depolarization / (2.0 - depolarization)
}

/// Henyey–Greenstein phase function \[sr⁻¹\] (Henyey & Greenstein 1941), −1 < g < 1.
///
/// Hoffman & Preetham's published shader has (1 − g)² for the numerator, which loses all but
/// (1 − g)/(1 + g) of the light; the print of Nielsen 2003 lacks a g in the denominator, which turns
/// negative. This is the normalized form.
#[must_use]
#[inline]
pub fn henyey_greenstein(cos_scattering_angle: f64, g: f64) -> f64 {
    // 1 + g² − 2gμ = (1 − g)² + 2g (1 − μ), without cancellation near the sun.
    let denominator = (1.0 - g) * (1.0 - g) + 2.0 * g * (1.0 - cos_scattering_angle);
    (1.0 - g * g) / (4.0 * PI * denominator * denominator.sqrt())
}

/// Two Henyey–Greenstein terms, `weight` on the first \[sr⁻¹\].
#[must_use]
pub fn two_term(cos_scattering_angle: f64, g: f64, g2: f64, weight: f64) -> f64 {
    weight * henyey_greenstein(cos_scattering_angle, g)
        + (1.0 - weight) * henyey_greenstein(cos_scattering_angle, g2)
}

/// Legendre moment `χ_l` of the two-term function, `4πP = Σ (2l + 1) χ_l P_l`.
#[must_use]
pub fn two_term_moment(order: i32, g: f64, g2: f64, weight: f64) -> f64 {
    weight * g.powi(order) + (1.0 - weight) * g2.powi(order)
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

    /// `∫ P(μ) P_l(μ) dΩ` by Simpson's rule on angles, for l = 0–3.
    fn moments(phase: impl Fn(f64) -> f64) -> [f64; 4] {
        let n = 20_000_u32;
        let step = PI / f64::from(n);
        let mut out = [0.0; 4];
        for i in 0..=n {
            let angle = step * f64::from(i);
            let mu = angle.cos();
            let weight = if i == 0 || i == n {
                1.0
            } else if i % 2 == 1 {
                4.0
            } else {
                2.0
            };
            let share = weight * step / 3.0 * 2.0 * PI * angle.sin() * phase(mu);
            let legendre = [1.0, mu, 1.5 * mu * mu - 0.5, 2.5 * mu * mu * mu - 1.5 * mu];
            for (sum, polynomial) in out.iter_mut().zip(legendre) {
                *sum += share * polynomial;
            }
        }
        out
    }

    fn close(found: [f64; 4], want: [f64; 4]) {
        for (f, w) in found.iter().zip(want) {
            assert!((f - w).abs() < 1e-9, "{found:?} {want:?}");
        }
    }

    #[test]
    fn rayleigh_is_normalized_and_has_its_moments() {
        for rho in [0.0, 0.0283, 0.1] {
            let want = [1.0, 0.0, rayleigh_second_moment(rho), 0.0];
            close(moments(|mu| rayleigh(mu, rho)), want);
        }
    }

    #[test]
    fn rayleigh_check_values() {
        // Depolarization 0.028328 (Bodhaine et al. 1999, 550 nm), γ = 0.014367: 0.117700 forward,
        // 0.060517 sideways.
        let rho = 2.0 * 0.014_367 / (1.0 + 0.014_367);
        assert!((rayleigh(1.0, rho) - 0.117_700).abs() < 1e-6);
        assert!((rayleigh(0.0, rho) - 0.060_517).abs() < 1e-6);
        assert!((rayleigh(1.0, 0.0) - 0.119_366).abs() < 1e-6);
    }

    #[test]
    fn henyey_greenstein_is_normalized_and_has_its_moments() {
        for g in [-0.6092_f64, 0.0, 0.3, 0.6746, 0.9] {
            let want = [1.0, g, g * g, g.powi(3)];
            close(moments(|mu| henyey_greenstein(mu, g)), want);
        }
    }

    #[test]
    fn two_terms_have_the_moments_of_their_mixture() {
        let [g, g2, weight] = [0.6746, -0.6092, 0.9807];
        let want =
            core::array::from_fn(|l| two_term_moment(i32::try_from(l).unwrap_or(0), g, g2, weight));
        close(moments(|mu| two_term(mu, g, g2, weight)), want);
    }

    #[test]
    fn cornette_and_shanks_is_normalized_and_nishitas_u_is_its_mean_cosine() {
        for g in [0.0, 0.3, 0.75, 0.9] {
            assert!(
                (moments(|mu| cornette_shanks(mu, g))[0] - 1.0).abs() < 1e-8,
                "{g}"
            );
        }
        for u in [0.0, 0.5, 0.7, 0.75, 0.85] {
            let g = cornette_shanks_g(u);
            let mean = moments(|mu| cornette_shanks(mu, g))[1];
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
