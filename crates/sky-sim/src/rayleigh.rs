//! Molecular scattering from first principles: Bodhaine, Wood, Dutton & Slusser 1999
//! (J. Atmos. Oceanic Technol. 16, 1854), with 400 ppmv of CO₂.

use core::f64::consts::PI;

/// CO₂ mole fraction of the reference atmosphere.
pub const CO2_MOLE_FRACTION: f64 = 400e-6;

/// Molecules per volume at 288.15 K and 1013.25 hPa \[cm⁻³\] (Bodhaine et al. 1999, Eq. 2).
const STANDARD_NUMBER_DENSITY_PER_CM3: f64 = 2.546_899e19;

/// Refractivity n − 1 of air at 288.15 K and 1013.25 hPa (Peck & Reeder 1972 for 300 ppmv of CO₂,
/// scaled to 400 ppmv by Edlén's factor). Domain: 230–1700 nm.
#[must_use]
pub fn refractivity(wavelength_nm: f64) -> f64 {
    let inverse_square = wavelength_um(wavelength_nm).powi(-2);
    let for_300_ppmv = 1e-8
        * (8060.51
            + 2_480_990.0 / (132.274 - inverse_square)
            + 17_455.7 / (39.329_57 - inverse_square));
    for_300_ppmv * (1.0 + 0.54 * (CO2_MOLE_FRACTION - 0.0003))
}

/// King factor (6 + 3ρ)/(6 − 7ρ) of air (Bates 1984 for N₂ and O₂; Bodhaine et al. 1999, Eq. 23).
#[must_use]
pub fn king_factor(wavelength_nm: f64) -> f64 {
    let inverse_square = wavelength_um(wavelength_nm).powi(-2);
    let nitrogen = 1.034 + 3.17e-4 * inverse_square;
    let oxygen = 1.096 + 1.385e-3 * inverse_square + 1.448e-4 * inverse_square * inverse_square;
    let co2_percent = 100.0 * CO2_MOLE_FRACTION;
    (78.084 * nitrogen + 20.946 * oxygen + 0.934 + co2_percent * 1.15)
        / (78.084 + 20.946 + 0.934 + co2_percent)
}

/// Depolarization ρ for unpolarized light, from the King factor.
#[must_use]
pub fn depolarization(wavelength_nm: f64) -> f64 {
    depolarization_from_king_factor(king_factor(wavelength_nm))
}

/// ρ = 6 (F − 1)/(3 + 7 F).
#[must_use]
pub fn depolarization_from_king_factor(king_factor: f64) -> f64 {
    6.0 * (king_factor - 1.0) / (3.0 + 7.0 * king_factor)
}

/// F = (6 + 3ρ)/(6 − 7ρ).
#[must_use]
pub fn king_factor_from_depolarization(depolarization: f64) -> f64 {
    (6.0 + 3.0 * depolarization) / (6.0 - 7.0 * depolarization)
}

/// Scattering cross-section per molecule \[m²\] (Bodhaine et al. 1999, Eq. 22–29).
#[must_use]
pub fn cross_section_m2(wavelength_nm: f64) -> f64 {
    let wavelength_cm = 1e-7 * wavelength_nm;
    let square_of_index = (1.0 + refractivity(wavelength_nm)).powi(2);
    let lorentz = (square_of_index - 1.0) / (square_of_index + 2.0);
    let cm2 = 24.0
        * PI.powi(3)
        * (lorentz / (wavelength_cm.powi(2) * STANDARD_NUMBER_DENSITY_PER_CM3)).powi(2)
        * king_factor(wavelength_nm);
    1e-4 * cm2
}

fn wavelength_um(wavelength_nm: f64) -> f64 {
    1e-3 * wavelength_nm
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn king_factor_and_depolarization_are_inverses() {
        for i in 0..257_u16 {
            let rho = 0.1 * f64::from(i) / 256.0;
            let back = depolarization_from_king_factor(king_factor_from_depolarization(rho));
            assert!((back - rho).abs() < 1e-14);
        }
    }

    #[test]
    fn the_print_of_the_report_is_not_ours() {
        // The report prints a depolarization of 0.0035, which would drop 4-5 % of the scattering.
        assert!((king_factor(550.0) - 1.0488).abs() < 1e-4);
        assert!((king_factor_from_depolarization(0.0035) - 1.0059).abs() < 1e-4);
    }
}
