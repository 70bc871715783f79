//! The atmospheres by name, and one with what tells where it comes from.

use anyhow::Result;
use sha2::{Digest as _, Sha256};
use sky_sim::profile::AtmosphereProfile;
use sky_sim::solar::{SolarError, SolarSpectrum};

/// The names of the shipped profiles.
pub fn shipped_names() -> impl Iterator<Item = &'static str> {
    sky_profiles::ALL.iter().map(|shipped| shipped.name)
}

/// A profile, the name by which it was asked for, and its bytes' hash.
#[derive(Clone, Debug)]
pub struct NamedProfile {
    /// The name or path, as the user wrote it.
    pub name: String,
    /// SHA-256 of its text, in hexadecimal digits.
    pub sha256: String,
    /// The atmosphere.
    pub profile: AtmosphereProfile,
}

impl NamedProfile {
    /// The shipped profile of a name; `None` where there is none.
    ///
    /// # Errors
    /// Never: the shipped profiles are checked.
    pub fn shipped(name: &str) -> Result<Option<Self>> {
        let Some(found) = sky_profiles::ALL.iter().find(|known| known.name == name) else {
            return Ok(None);
        };
        Ok(Some(Self {
            name: name.to_owned(),
            sha256: format!("{:x}", Sha256::digest(found.csv)),
            profile: AtmosphereProfile::from_csv_str(found.file, found.csv)?,
        }))
    }

    /// A profile from the text of a file of that name.
    ///
    /// # Errors
    /// When its table is wrong.
    pub fn from_csv(name: &str, text: &str) -> Result<Self> {
        Ok(Self {
            name: name.to_owned(),
            sha256: format!("{:x}", Sha256::digest(text)),
            profile: AtmosphereProfile::from_csv_str(name, text)?,
        })
    }

    /// The general atmosphere, from which the default table is made.
    ///
    /// # Errors
    /// Never: it is shipped.
    pub fn general() -> Result<Self> {
        let shipped = sky_profiles::GENERAL;
        Ok(Self {
            name: shipped.name.to_owned(),
            sha256: format!("{:x}", Sha256::digest(shipped.csv)),
            profile: AtmosphereProfile::from_csv_str(shipped.file, shipped.csv)?,
        })
    }
}

/// The sun at the wavelengths of a grid: the mean over one step, and on the 1 nm grid, where the
/// spectrum itself is tabulated, its own values.
///
/// # Errors
/// When the spectrum does not cover the wavelengths.
pub fn solar_on_grid(wavelength_nm: &[f64], step_nm: u16) -> Result<SolarSpectrum, SolarError> {
    let width_nm = if step_nm > 1 { step_nm.into() } else { 0.0 };
    SolarSpectrum::g173().on_grid(wavelength_nm, width_nm)
}
