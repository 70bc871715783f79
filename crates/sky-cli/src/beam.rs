//! `utm-sky beam`: the direct normal spectrum of the sun.

use anyhow::Result;
use sky_core::quantity::{Angle, Length};
use sky_sim::smarts::{BeamOverrides, DirectBeam};

use crate::args::BeamArgs;
use crate::atmosphere::{Defaults, load_profile, solar_on_grid};
use crate::files::OutputFile;
use crate::table_io::irradiance_csv;

/// Runs the command.
///
/// # Errors
/// When an input is wrong or the output cannot be written.
pub fn run(args: &BeamArgs) -> Result<()> {
    let profile = load_profile(&args.atmosphere.profile)?;
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
        Angle::from_degrees(args.place.sun_zenith_deg),
        &solar,
    )?;
    out.commit(irradiance_csv(&settings.wavelength_nm, &irradiance).as_bytes())?;
    Ok(())
}
