//! Absorbing gases besides ozone: NO₂, O₂–O₂ pairs, and the band forms of O₂ and water vapor.
//!
//! NO₂ and O₂–O₂ are ordinary volume absorbers. The O₂ and H₂O functions are means over 1 nm of
//! many lines, exp(−(k u)^a) with a < 1: they are *not* multiplicative along a path, so they belong to
//! a whole path. `optics` says how they enter a transport solver.

use crate::table::{ColumnSpec, Table, interpolate};
use std::sync::LazyLock;

/// Share of O₂ in air that the pair coefficients were defined with.
pub const OXYGEN_MOLE_FRACTION: f64 = 0.2095;

/// Pressure exponent of the O₂ path above a level: u = (p/p₀)^1.85.
pub const O2_PRESSURE_EXPONENT: f64 = 1.85;

/// Pressure exponent of the water path above a level: u = w (p/p₀)^0.65.
pub const WATER_PRESSURE_EXPONENT: f64 = 0.65;

/// Standard pressure p₀ \[hPa\].
pub const STANDARD_PRESSURE_HPA: f64 = 1013.25;

/// A band form exp(−(k u)^a) at one wavelength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BandForm {
    /// Strength k, per unit of the path u.
    pub strength: f64,
    /// Exponent a; 1 is Beer's law.
    pub exponent: f64,
}

impl BandForm {
    /// The exponent (k u)^a of the transmittance along a path.
    #[must_use]
    pub fn path_exponent(self, path: f64) -> f64 {
        if self.strength > 0.0 && path > 0.0 {
            (self.strength * path).powf(self.exponent)
        } else {
            0.0
        }
    }

    /// Transmittance of a whole path.
    #[must_use]
    pub fn transmittance(self, path: f64) -> f64 {
        (-self.path_exponent(path)).exp()
    }
}

/// The 1 nm table of all gases, 360–830 nm.
#[derive(Debug)]
pub(crate) struct GasTable {
    wavelength_nm: Vec<f64>,
    columns: [Vec<f64>; 7],
}

impl GasTable {
    pub(crate) fn o3_m2(&self, wavelength_nm: f64) -> f64 {
        1e-4 * interpolate(&self.wavelength_nm, &self.columns[0], wavelength_nm)
    }

    fn value(&self, column: usize, wavelength_nm: f64) -> f64 {
        interpolate(&self.wavelength_nm, &self.columns[column], wavelength_nm)
    }
}

const ANY: [f64; 2] = [0.0, 1e6];

const COLUMNS: [ColumnSpec; 8] = [
    ColumnSpec::required("wavelength_nm", ANY),
    ColumnSpec::required("o3_cross_section_cm2", ANY),
    ColumnSpec::required("no2_cross_section_cm2", ANY),
    ColumnSpec::required("o2o2_cross_section_cm5", ANY),
    ColumnSpec::required("o2_band_k", ANY),
    ColumnSpec::required("o2_band_exponent", ANY),
    ColumnSpec::required("h2o_band_k_per_cm", ANY),
    ColumnSpec::required("h2o_band_exponent", ANY),
];

static TABLE: LazyLock<GasTable> = LazyLock::new(|| {
    let table = Table::read(
        "gas_absorption.csv",
        include_str!("../data/gas_absorption.csv"),
        &COLUMNS,
        2,
    )
    .expect("the embedded gas table is valid");
    GasTable {
        wavelength_nm: table.column(0).to_vec(),
        columns: core::array::from_fn(|i| table.column(i + 1).to_vec()),
    }
});

pub(crate) fn table() -> &'static GasTable {
    &TABLE
}

/// NO₂ absorption cross-section \[m²\]: Vandaele et al. 1998 at 226 K; Burrows et al. 1998 beyond
/// 655 nm.
#[must_use]
pub fn no2_cross_section_m2(wavelength_nm: f64) -> f64 {
    1e-4 * table().value(1, wavelength_nm)
}

/// O₂–O₂ collision-pair coefficient \[m⁵\], to be multiplied by the square of the O₂ number density
/// \[m⁻³\]: Fally et al. 2000 / Hermans; zero beyond 666 nm.
#[must_use]
pub fn oxygen_pair_coefficient_m5(wavelength_nm: f64) -> f64 {
    1e-10 * table().value(2, wavelength_nm)
}

/// O₂ band form (A, B and γ bands): 1 nm means of a HITRAN line calculation fitted over air masses
/// 0.05–38. Path u = m (p/p₀)^1.85, m the air mass and p the observer's pressure.
#[must_use]
pub fn o2_band(wavelength_nm: f64) -> BandForm {
    BandForm {
        strength: table().value(3, wavelength_nm),
        exponent: table().value(4, wavelength_nm),
    }
}

/// Water-vapor band form: LOWTRAN7 band shapes (Pierluissi & Maragoudakis), strengths scaled to the
/// equivalent widths of ASTM G173. Path u = w m (p/p₀)^0.65, w the precipitable water \[cm\].
#[must_use]
pub fn water_band(wavelength_nm: f64) -> BandForm {
    BandForm {
        strength: table().value(5, wavelength_nm),
        exponent: table().value(6, wavelength_nm),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_are_where_they_belong() {
        assert!(o2_band(760.0).transmittance(1.5) < 0.5);
        assert!((o2_band(740.0).transmittance(1.5) - 1.0).abs() < 1e-12);
        assert!(water_band(720.0).transmittance(2.1) < 0.9);
        assert!((water_band(500.0).transmittance(2.1) - 1.0).abs() < 1e-12);
        assert!(oxygen_pair_coefficient_m5(577.0) > 10.0 * oxygen_pair_coefficient_m5(560.0));
        assert!(no2_cross_section_m2(440.0) > no2_cross_section_m2(600.0));
    }

    #[test]
    fn an_empty_path_transmits_all() {
        assert!((o2_band(760.0).transmittance(0.0) - 1.0).abs() < 1e-15);
    }
}
