//! How hazy the air is, said in one of four ways, and the conversions between them.
//!
//! The project's turbidity is the report's Eq. 2.8, T = (`τ_m` + `τ_a`)/`τ_m`, taken at 500 nm for the
//! whole vertical column. Visual range is Koschmieder's at 2 % contrast, 3.912/β at 550 nm and sea
//! level; the meteorological optical range of a METAR means 5 %, which is shorter by a factor of 1.306.
//! It needs further conventions: rural aerosol at 50 % relative humidity with a scale height of 1.2 km
//! for all aerosol beyond the stratosphere's, over the molecules and the ozone of the general
//! atmosphere. Optics of other air take a visual range at its word (`sky-sim`).

use crate::quantity::Length;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Vertical optical depth of the molecules at 500 nm, sea level, US Standard Atmosphere 1976
/// (Bodhaine et al. 1999, 400 ppmv of CO₂).
pub const RAYLEIGH_OPTICAL_DEPTH_500: f64 = 0.14344;

/// Extinction coefficient of the air without aerosol at 550 nm, at the ground of the general
/// atmosphere \[km⁻¹\]: molecules 0.011489 (Bodhaine et al. 1999), ozone 0.000225.
pub const CLEAN_AIR_EXTINCTION_550_PER_KM: f64 = 0.011_714;

/// Vertical optical depth at 500 nm of the background aerosol of the stratosphere (`LOWTRAN7`), the
/// first share of all aerosol: none of it is at the ground.
pub const STRATOSPHERIC_OPTICAL_DEPTH_500: f64 = 0.008_275_36;

/// Koschmieder's constant for 2 % contrast, −ln 0.02.
pub const KOSCHMIEDER_2_PERCENT: f64 = 3.912;

/// Aerosol extinction at 500 nm over that at 550 nm: rural aerosol at 50 % relative humidity
/// (Shettle & Fenn 1979).
pub const RURAL_EXTINCTION_500_OVER_550: f64 = 1.095_996_4;

/// Scale height of the haze \[km\] (Nishita et al. 1993 after Sekine).
pub const HAZE_SCALE_HEIGHT_KM: f64 = 1.2;

/// The amount of haze, in the words of whoever asks.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Haze {
    /// Turbidity T = 1 + τ/0.14344 at 500 nm, at least 1.
    Turbidity(f64),
    /// Vertical aerosol optical depth at 500 nm, at least 0.
    OpticalDepth500(f64),
    /// Ångström's law τ = β λ^(−α), λ in µm.
    Angstrom {
        /// Ångström turbidity β, the optical depth at 1 µm, at least 0.
        beta: f64,
        /// Ångström exponent α.
        alpha: f64,
    },
    /// Visual range at the ground by Koschmieder's 2 % contrast, 3.912/β, at 550 nm. The 5 % of a
    /// METAR's visibility are 2.996/β: 1.306 times shorter for the same air.
    VisualRange(Length),
}

/// A haze that cannot be.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum HazeError {
    /// NaN or an infinity.
    #[error("{quantity}: expected a finite number, found {found}")]
    NotFinite {
        /// The quantity.
        quantity: &'static str,
        /// The value given.
        found: f64,
    },
    /// Turbidity below that of clean air.
    #[error("turbidity: expected at least 1, found {found}")]
    TurbidityBelowOne {
        /// The value given.
        found: f64,
    },
    /// A negative optical depth or β.
    #[error("{quantity}: expected at least 0, found {found}")]
    Negative {
        /// The quantity.
        quantity: &'static str,
        /// The value given.
        found: f64,
    },
    /// A visual range that is not positive or exceeds that of clean air.
    #[error("visual range [km]: expected more than 0 and at most {clean_air_km:.2}, found {found}")]
    VisualRange {
        /// The value given \[km\].
        found: f64,
        /// Visual range of air without aerosol \[km\].
        clean_air_km: f64,
    },
}

fn finite(quantity: &'static str, found: f64) -> Result<f64, HazeError> {
    if found.is_finite() {
        Ok(found)
    } else {
        Err(HazeError::NotFinite { quantity, found })
    }
}

fn not_negative(quantity: &'static str, found: f64) -> Result<f64, HazeError> {
    let found = finite(quantity, found)?;
    if found < 0.0 {
        return Err(HazeError::Negative { quantity, found });
    }
    Ok(found)
}

/// Turbidity of a vertical aerosol optical depth at 500 nm.
#[must_use]
pub fn turbidity_from_optical_depth_500(optical_depth_500: f64) -> f64 {
    1.0 + optical_depth_500 / RAYLEIGH_OPTICAL_DEPTH_500
}

/// Vertical aerosol optical depth at 500 nm of a turbidity.
#[must_use]
pub fn optical_depth_500_from_turbidity(turbidity: f64) -> f64 {
    (turbidity - 1.0) * RAYLEIGH_OPTICAL_DEPTH_500
}

/// Visual range (Koschmieder, 2 %) of a vertical aerosol optical depth at 500 nm, at most that of
/// clean air.
#[must_use]
pub fn visual_range_from_optical_depth_500(optical_depth_500: f64) -> Length {
    let haze = (optical_depth_500 - STRATOSPHERIC_OPTICAL_DEPTH_500).max(0.0);
    let haze_per_km = haze / RURAL_EXTINCTION_500_OVER_550 / HAZE_SCALE_HEIGHT_KM;
    Length::from_km(KOSCHMIEDER_2_PERCENT / (CLEAN_AIR_EXTINCTION_550_PER_KM + haze_per_km))
}

/// Vertical aerosol optical depth at 500 nm of a visual range (Koschmieder, 2 %). That of clean air is
/// the stratosphere's alone: less than that leaves the range as it is.
#[must_use]
pub fn optical_depth_500_from_visual_range(visual_range: Length) -> f64 {
    let haze_per_km = KOSCHMIEDER_2_PERCENT / visual_range.km() - CLEAN_AIR_EXTINCTION_550_PER_KM;
    STRATOSPHERIC_OPTICAL_DEPTH_500
        + haze_per_km * HAZE_SCALE_HEIGHT_KM * RURAL_EXTINCTION_500_OVER_550
}

/// Ångström's β of a vertical aerosol optical depth at 500 nm, for an exponent α.
#[must_use]
pub fn angstrom_beta_from_optical_depth_500(optical_depth_500: f64, alpha: f64) -> f64 {
    optical_depth_500 * 0.5_f64.powf(alpha)
}

/// Vertical aerosol optical depth at 500 nm of Ångström's β and α.
#[must_use]
pub fn optical_depth_500_from_angstrom(beta: f64, alpha: f64) -> f64 {
    beta * 0.5_f64.powf(-alpha)
}

impl Haze {
    /// Vertical aerosol optical depth of the whole atmosphere at 500 nm.
    ///
    /// # Errors
    /// Turbidity below 1, negative or non-finite values, a visual range longer than clean air's.
    pub fn optical_depth_500(self) -> Result<f64, HazeError> {
        match self {
            Self::Turbidity(found) => {
                let turbidity = finite("turbidity", found)?;
                if turbidity < 1.0 {
                    return Err(HazeError::TurbidityBelowOne { found });
                }
                Ok(optical_depth_500_from_turbidity(turbidity))
            }
            Self::OpticalDepth500(found) => not_negative("aerosol optical depth at 500 nm", found),
            Self::Angstrom { beta, alpha } => {
                let beta = not_negative("Angstrom turbidity beta", beta)?;
                let alpha = finite("Angstrom exponent alpha", alpha)?;
                finite(
                    "aerosol optical depth at 500 nm",
                    optical_depth_500_from_angstrom(beta, alpha),
                )
            }
            Self::VisualRange(range) => {
                let found = finite("visual range [km]", range.km())?;
                let clean_air_km = visual_range_from_optical_depth_500(0.0).km();
                if found <= 0.0 || found > clean_air_km {
                    return Err(HazeError::VisualRange {
                        found,
                        clean_air_km,
                    });
                }
                finite(
                    "aerosol optical depth at 500 nm",
                    optical_depth_500_from_visual_range(range),
                )
            }
        }
    }

    /// Turbidity T at 500 nm.
    ///
    /// # Errors
    /// As [`Haze::optical_depth_500`].
    pub fn turbidity(self) -> Result<f64, HazeError> {
        self.optical_depth_500()
            .map(turbidity_from_optical_depth_500)
    }

    /// Visual range at the ground (Koschmieder, 2 %).
    ///
    /// # Errors
    /// As [`Haze::optical_depth_500`].
    pub fn visual_range(self) -> Result<Length, HazeError> {
        self.optical_depth_500()
            .map(visual_range_from_optical_depth_500)
    }

    /// The Ångström exponent, where the haze was given with one.
    #[must_use]
    pub fn angstrom_exponent(self) -> Option<f64> {
        match self {
            Self::Angstrom { alpha, .. } => Some(alpha),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_mapping_stands_beside_its_inverse() -> Result<(), HazeError> {
        for n in [2_u32, 32, 257] {
            for i in 0..n {
                let tau = 2.0 * f64::from(i) / f64::from(n - 1);
                let turbidity = turbidity_from_optical_depth_500(tau);
                assert!((Haze::Turbidity(turbidity).optical_depth_500()? - tau).abs() < 1e-12);
                let range = visual_range_from_optical_depth_500(tau);
                let least = tau.max(STRATOSPHERIC_OPTICAL_DEPTH_500);
                assert!((Haze::VisualRange(range).optical_depth_500()? - least).abs() < 1e-12);
                let beta = angstrom_beta_from_optical_depth_500(tau, 1.3);
                let haze = Haze::Angstrom { beta, alpha: 1.3 };
                assert!((haze.optical_depth_500()? - tau).abs() < 1e-12);
                assert!((Haze::OpticalDepth500(tau).turbidity()? - turbidity).abs() < 1e-12);
            }
        }
        Ok(())
    }

    #[test]
    fn b1_the_visual_ranges_of_a_table_are_those_of_the_optics() {
        // 3.912 over the extinction at 550 nm of the general atmosphere's ground, turbidity 8 and 1
        for (turbidity, km) in [(8.0, 5.09), (1.0, 333.97)] {
            let depth = optical_depth_500_from_turbidity(turbidity);
            let found = visual_range_from_optical_depth_500(depth).km();
            assert!((found / km - 1.0).abs() < 1e-3, "{found}");
        }
    }

    #[test]
    fn impossible_hazes_are_refused() {
        assert!(matches!(
            Haze::Turbidity(0.99).turbidity(),
            Err(HazeError::TurbidityBelowOne { .. })
        ));
        assert!(matches!(
            Haze::Turbidity(f64::NAN).turbidity(),
            Err(HazeError::NotFinite { .. })
        ));
        assert!(matches!(
            Haze::OpticalDepth500(-0.1).turbidity(),
            Err(HazeError::Negative { .. })
        ));
        assert!(matches!(
            Haze::OpticalDepth500(f64::INFINITY).turbidity(),
            Err(HazeError::NotFinite { .. })
        ));
        for km in [0.0, -5.0, 335.0] {
            assert!(matches!(
                Haze::VisualRange(Length::from_km(km)).turbidity(),
                Err(HazeError::VisualRange { .. })
            ));
        }
        let bad = Haze::Angstrom {
            beta: 0.1,
            alpha: f64::NAN,
        };
        assert!(matches!(bad.turbidity(), Err(HazeError::NotFinite { .. })));
    }
}
