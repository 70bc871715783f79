//! Ozone: the Chappuis bands and the report's effective temperature.

use crate::gases;

/// Molecules per area in a column of 1 atm-cm \[m⁻²\] (Loschmidt's constant × 1 cm).
pub const MOLECULES_PER_M2_ATM_CM: f64 = 2.686_781_1e23;

/// Absorption cross-section at 226 K \[m²\], linear between 1 nm means of 360–830 nm.
///
/// Brion et al. 1998 at 295 K × the temperature ratio of Bogumil et al. 2003 (version 4). No
/// dependence on temperature; published sets differ by ±2.5 %.
#[must_use]
pub fn cross_section_m2(wavelength_nm: f64) -> f64 {
    gases::table().o3_m2(wavelength_nm)
}

/// The report's effective ozone temperature \[K\] of an air temperature \[K\] (Eq. 3.7, after
/// Gueymard 1995). Meant for the ground; the report applies it at every level, and so
/// does the profile's printed column. The optics use one cross-section and do not need it.
#[must_use]
pub fn effective_temperature_k(air_temperature_k: f64) -> f64 {
    142.68 + 0.284_98 * air_temperature_k
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chappuis_peak_stands_near_603_nm() {
        // 0.0488 for 343.4 DU, the maximum of the band.
        let depth = |nm: f64| cross_section_m2(nm) * 0.3434 * MOLECULES_PER_M2_ATM_CM;
        assert!((depth(603.0) - 0.0488).abs() < 2e-4);
        assert!(depth(603.0) > depth(580.0) && depth(603.0) > depth(630.0));
    }
}
