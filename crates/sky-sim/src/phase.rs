//! Phase functions, per steradian: their integral over the sphere is 1.

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
        // At 550 nm, γ = 0.014367: 0.117700 forward, 0.060517 sideways.
        let rho = crate::rayleigh::depolarization(550.0);
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
        let [g, g2, weight] = crate::aerosol::RURAL_PHASE;
        let want =
            core::array::from_fn(|l| two_term_moment(i32::try_from(l).unwrap_or(0), g, g2, weight));
        close(moments(|mu| two_term(mu, g, g2, weight)), want);
        // The rural function's asymmetry parameter, 0.642 +- 0.01.
        assert!((want[1] - 0.65).abs() < 0.01);
    }
}
