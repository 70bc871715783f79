//! From the command line's words to the atmosphere that the engines need.

use std::path::Path;

use anyhow::Result;
use sha2::{Digest as _, Sha256};
use sky_core::haze::Haze;
use sky_core::quantity::Length;
use sky_sim::optics::{Constituents, OpticsSettings};
use sky_sim::profile::AtmosphereProfile;
use sky_sim::solar::{SolarError, SolarSpectrum};

use crate::args::{AtmosphereArgs, Constituent, HazeArgs, WavelengthStep};
use crate::files::read_text;

/// The profiles that can be named instead of a file: name, file and content.
const SHIPPED_PROFILES: [[&str; 3]; 4] = [
    [
        "general",
        "profiles/general.csv",
        include_str!("../../../profiles/general.csv"),
    ],
    [
        "utm2005",
        "profiles/utm2005.csv",
        include_str!("../../../profiles/utm2005.csv"),
    ],
    [
        "tropical",
        "profiles/tropical.csv",
        include_str!("../../../profiles/tropical.csv"),
    ],
    [
        "subarctic_winter",
        "profiles/subarctic_winter.csv",
        include_str!("../../../profiles/subarctic_winter.csv"),
    ],
];

/// Ångström's exponent where only β is given (Ångström 1961: 1.3 for natural haze).
const DEFAULT_ANGSTROM_EXPONENT: f64 = 1.3;

/// The profile of that name, or the one in that file (`./general` is a file).
///
/// # Errors
/// When the file cannot be read or its table is wrong.
pub fn load_profile(path_or_name: &Path) -> Result<AtmosphereProfile> {
    for [name, file, text] in SHIPPED_PROFILES {
        if path_or_name.as_os_str() == name {
            return Ok(AtmosphereProfile::from_csv_str(file, text)?);
        }
    }
    let text = read_text(path_or_name)?;
    Ok(AtmosphereProfile::from_csv_str(
        &path_or_name.display().to_string(),
        &text,
    )?)
}

/// SHA-256 of a profile's bytes, in hexadecimal digits.
///
/// # Errors
/// When the file cannot be read.
pub fn profile_hash(path_or_name: &Path) -> Result<String> {
    let shipped = SHIPPED_PROFILES
        .iter()
        .find(|[name, ..]| path_or_name.as_os_str() == *name);
    let digest = match shipped {
        Some([_, _, text]) => Sha256::digest(text),
        None => Sha256::digest(read_text(path_or_name)?),
    };
    Ok(format!("{digest:x}"))
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

impl HazeArgs {
    /// The haze that was given; clap made sure that there is at most one.
    #[must_use]
    pub fn haze(&self, angstrom_alpha: Option<f64>) -> Option<Haze> {
        let angstrom = |beta| Haze::Angstrom {
            beta,
            alpha: angstrom_alpha.unwrap_or(DEFAULT_ANGSTROM_EXPONENT),
        };
        self.turbidity
            .map(Haze::Turbidity)
            .or(self.aod500.map(Haze::OpticalDepth500))
            .or(self
                .visual_range_km
                .map(|km| Haze::VisualRange(Length::from_km(km))))
            .or(self.angstrom_beta.map(angstrom))
    }
}

/// What a command takes where the user says nothing.
#[derive(Clone, Copy, Debug)]
pub struct Defaults {
    /// Constituents that take part.
    pub constituents: Constituents,
    /// Distance of the wavelengths.
    pub wavelength_step: WavelengthStep,
}

impl Defaults {
    /// For the sky: the reference atmosphere every 10 nm.
    pub const SKY: Self = Self {
        constituents: Constituents::REFERENCE,
        wavelength_step: WavelengthStep::Nm10,
    };

    /// For the sun's beam: every constituent every 1 nm, to stand beside a measured spectrum.
    pub const BEAM: Self = Self {
        constituents: Constituents::ALL,
        wavelength_step: WavelengthStep::Nm1,
    };
}

fn constituents(list: &[Constituent]) -> Constituents {
    let on = |c| list.contains(&c) || list.contains(&Constituent::All);
    Constituents {
        rayleigh: on(Constituent::Rayleigh),
        ozone: on(Constituent::Ozone),
        no2: on(Constituent::No2),
        o2o2: on(Constituent::OxygenPairs),
        o2_band: on(Constituent::Oxygen),
        h2o_band: on(Constituent::Water),
        aerosol: on(Constituent::Aerosol),
        stratospheric_aerosol: on(Constituent::Stratosphere),
    }
}

impl AtmosphereArgs {
    /// The step of the wavelengths \[nm\].
    #[must_use]
    pub fn step_nm(&self, defaults: Defaults) -> u16 {
        self.wavelength_step_nm
            .unwrap_or(defaults.wavelength_step)
            .nm()
    }

    /// The settings of the optics.
    ///
    /// # Errors
    /// When no such step is offered, or the haze cannot be.
    pub fn settings(&self, haze: &HazeArgs, defaults: Defaults) -> Result<OpticsSettings> {
        let mut settings = OpticsSettings::with_step_nm(self.step_nm(defaults))?;
        settings.constituents = self
            .constituents
            .as_deref()
            .map_or(defaults.constituents, constituents);
        if let Some(haze) = haze.haze(self.angstrom_alpha) {
            settings.haze = haze;
        }
        settings.angstrom_exponent = self.angstrom_alpha;
        settings.single_scattering_albedo = self.single_scattering_albedo;
        settings.asymmetry_parameter = self.asymmetry;
        settings.aerosol_scale_height = Length::from_km(self.scale_height_km);
        settings.check()?;
        Ok(settings)
    }
}
