//! `utm-sky beam`: the direct normal spectrum of the sun.

use std::path::PathBuf;

use anyhow::Result;
use clap::{ArgGroup, Args};
use sky_core::quantity::Length;
use sky_eval::profiles::solar_on_grid;
use sky_sim::smarts::{BeamOverrides, DirectBeam};

use crate::args::{AtmosphereArgs, Defaults, HAZE, HazeArgs, PlaceArgs, within};
use crate::io::files::OutputFile;
use crate::io::profile::load_profile;
use crate::io::table::irradiance_csv;

/// `utm-sky beam`.
#[derive(Debug, Args)]
#[command(
    group(ArgGroup::new("haze").required(true)
        .args(HAZE)),
    after_help = "Example:
  utm-sky beam --altitude-km 0 --aod500 0.084 --sun-zenith-deg 48.2 --out beam.csv"
)]
pub struct BeamArgs {
    /// Observer and sun.
    #[command(flatten)]
    pub place: PlaceArgs,
    /// The spectrum
    #[arg(long, value_name = "CSV")]
    pub out: PathBuf,
    /// Ozone above the observer instead of the profile's [atm cm]
    #[arg(long, value_name = "ATM_CM", value_parser = within(0.0, 2.0),
          allow_negative_numbers = true, help_heading = "Columns")]
    pub ozone_atm_cm: Option<f64>,
    /// Precipitable water above the observer instead of the profile's [cm]
    #[arg(long, value_name = "CM", value_parser = within(0.0, 20.0),
          allow_negative_numbers = true, help_heading = "Columns")]
    pub water_cm: Option<f64>,
    /// Pressure at the observer instead of the profile's [hPa]
    #[arg(long, value_name = "HPA", value_parser = within(1.0, 1200.0),
          allow_negative_numbers = true, help_heading = "Columns")]
    pub pressure_hpa: Option<f64>,
    /// The haze.
    #[command(flatten)]
    pub haze: HazeArgs,
    /// The air.
    #[command(flatten)]
    pub atmosphere: AtmosphereArgs,
}

/// Runs the command.
///
/// # Errors
/// When an input is wrong or the output cannot be written.
pub fn run(args: &BeamArgs) -> Result<()> {
    let profile = load_profile(&args.atmosphere.profile)?.profile;
    let settings = args.atmosphere.settings(&args.haze, Defaults::BEAM)?;
    let overrides = BeamOverrides {
        ozone_atm_cm: args.ozone_atm_cm,
        water_cm: args.water_cm,
        pressure_hpa: args.pressure_hpa,
    };
    let beam = DirectBeam::new(&profile, &settings, overrides)?;
    let step_nm = args.atmosphere.step_nm(Defaults::BEAM);
    let solar = solar_on_grid(&settings.wavelength_nm, step_nm)?;
    let out = OutputFile::create(&args.out)?;
    let irradiance = beam.normal_irradiance(
        Length::from_km(args.place.altitude_km),
        args.place.sun_zenith(),
        &solar,
    )?;
    out.commit(irradiance_csv(&settings.wavelength_nm, &irradiance).as_bytes())?;
    Ok(())
}
