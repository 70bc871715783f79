//! The sun's spectrum outside the atmosphere.

use crate::table::{ColumnSpec, Table, TableError, interpolate};
use serde::{Deserialize, Serialize};
use std::sync::LazyLock;
use thiserror::Error;

/// Irradiance of the sun on a plane normal to its rays, at mean distance, by wavelength.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SolarSpectrum {
    /// Wavelengths \[nm\], ascending.
    pub wavelength_nm: Vec<f64>,
    /// Spectral irradiance \[W·m⁻²·nm⁻¹\].
    pub irradiance_w_m2_nm: Vec<f64>,
}

/// What a solar spectrum can get wrong.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum SolarError {
    /// The table itself is wrong.
    #[error(transparent)]
    Table(#[from] TableError),
    /// A wavelength outside the spectrum.
    #[error("solar spectrum: expected a wavelength from {} to {} nm, found {found}", expected[0], expected[1])]
    OutsideSpectrum {
        /// First and last wavelength of the spectrum \[nm\].
        expected: [f64; 2],
        /// The wavelength asked for \[nm\].
        found: f64,
    },
}

const COLUMNS: [ColumnSpec; 2] = [
    ColumnSpec::required("wavelength_nm", [200.0, 4000.0]),
    ColumnSpec::required("irradiance_w_m2_nm", [0.0, 1e3]),
];

static G173: LazyLock<SolarSpectrum> = LazyLock::new(|| {
    SolarSpectrum::from_csv_str(
        "solar_irradiance.csv",
        include_str!("../data/solar_irradiance.csv"),
    )
    .expect("the embedded solar spectrum is valid")
});

impl SolarSpectrum {
    /// The extraterrestrial column of ASTM G173-03 (Gueymard 2004 scaled to 1367 W·m⁻²), 360–830 nm in
    /// 1 nm steps.
    #[must_use]
    pub fn g173() -> Self {
        G173.clone()
    }

    /// Reads a spectrum; `name` is the file's name, for errors.
    ///
    /// # Errors
    /// The first thing that is wrong, with file, line and column.
    pub fn from_csv_str(name: &str, text: &str) -> Result<Self, SolarError> {
        let table = Table::read(name, text, &COLUMNS, 1)?;
        table.check_ascending(0, COLUMNS[0].name)?;
        Ok(Self {
            wavelength_nm: table.column(0).to_vec(),
            irradiance_w_m2_nm: table.column(1).to_vec(),
        })
    }

    /// The spectrum as CSV; [`SolarSpectrum::from_csv_str`] reads it back bit for bit.
    #[must_use]
    pub fn to_csv_string(&self) -> String {
        let mut out = COLUMNS.map(|c| c.name).join(",");
        out.push('\n');
        for (nm, irradiance) in self.wavelength_nm.iter().zip(&self.irradiance_w_m2_nm) {
            out.push_str(&format!("{nm},{irradiance}\n"));
        }
        out
    }

    /// Irradiance at a wavelength, linear between the table's \[W·m⁻²·nm⁻¹\]; the end values continue
    /// outside.
    #[must_use]
    pub fn at(&self, wavelength_nm: f64) -> f64 {
        interpolate(&self.wavelength_nm, &self.irradiance_w_m2_nm, wavelength_nm)
    }

    /// Mean irradiance over `width_nm` around a wavelength \[W·m⁻²·nm⁻¹\]: the exact mean of the linear
    /// pieces. Width 0 is the value at the wavelength.
    #[must_use]
    pub fn band_mean(&self, wavelength_nm: f64, width_nm: f64) -> f64 {
        if width_nm <= 0.0 {
            return self.at(wavelength_nm);
        }
        let (low, high) = (
            wavelength_nm - 0.5 * width_nm,
            wavelength_nm + 0.5 * width_nm,
        );
        let inner = self
            .wavelength_nm
            .iter()
            .copied()
            .filter(|&nm| nm > low && nm < high);
        let mut previous = low;
        let mut sum = 0.0;
        for nm in inner.chain([high]) {
            sum += 0.5 * (self.at(previous) + self.at(nm)) * (nm - previous);
            previous = nm;
        }
        sum / width_nm
    }

    /// Band means on a grid, ±`step_nm`/2 around each wavelength.
    ///
    /// # Errors
    /// A wavelength outside the spectrum.
    pub fn on_grid(&self, wavelength_nm: &[f64], step_nm: f64) -> Result<Self, SolarError> {
        let first = self.wavelength_nm.first().copied().unwrap_or(f64::NAN);
        let last = self.wavelength_nm.last().copied().unwrap_or(f64::NAN);
        for &found in wavelength_nm {
            if !(found >= first && found <= last) {
                return Err(SolarError::OutsideSpectrum {
                    expected: [first, last],
                    found,
                });
            }
        }
        Ok(Self {
            wavelength_nm: wavelength_nm.to_vec(),
            irradiance_w_m2_nm: wavelength_nm
                .iter()
                .map(|&nm| self.band_mean(nm, step_nm))
                .collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integrals_of_the_standard() {
        // 735.839 W/m² over 360-830 nm and 657.040 over 380-780 nm, 1 nm sums.
        let sun = SolarSpectrum::g173();
        let sum = |low: f64, high: f64| -> f64 {
            let pairs = sun.wavelength_nm.iter().zip(&sun.irradiance_w_m2_nm);
            pairs
                .filter(|(nm, _)| **nm >= low && **nm <= high)
                .map(|(_, e)| e)
                .sum()
        };
        assert!((sum(360.0, 830.0) - 735.839).abs() < 1e-3);
        assert!((sum(380.0, 780.0) - 657.040).abs() < 1e-3);
    }

    #[test]
    fn band_means_keep_the_energy() -> Result<(), SolarError> {
        let sun = SolarSpectrum::g173();
        let coarse: Vec<f64> = (0..=40_u16).map(|i| 380.0 + 10.0 * f64::from(i)).collect();
        let bands = sun.on_grid(&coarse, 10.0)?;
        let total: f64 = bands.irradiance_w_m2_nm.iter().map(|e| 10.0 * e).sum();
        let whole = 410.0 * sun.band_mean(580.0, 410.0);
        assert!((total / whole - 1.0).abs() < 1e-12);
        Ok(())
    }

    #[test]
    fn a_linear_spectrum_has_its_middle_as_mean() -> Result<(), SolarError> {
        let sun = SolarSpectrum::from_csv_str(
            "s.csv",
            "wavelength_nm,irradiance_w_m2_nm\n400,1\n500,3\n",
        )?;
        assert!((sun.band_mean(450.0, 33.3) - 2.0).abs() < 1e-12);
        assert!((sun.at(425.0) - 1.5).abs() < 1e-12);
        Ok(())
    }

    #[test]
    fn csv_round_trip_and_domain() -> Result<(), SolarError> {
        let sun = SolarSpectrum::g173();
        assert_eq!(
            SolarSpectrum::from_csv_str("s.csv", &sun.to_csv_string())?,
            sun
        );
        assert!(matches!(
            sun.on_grid(&[900.0], 10.0),
            Err(SolarError::OutsideSpectrum { .. })
        ));
        Ok(())
    }
}
