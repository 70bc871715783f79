//! `utm-sky optics`: extinction per level and wavelength, for this engine or another.

use anyhow::Result;
use sky_sim::optics::OpticalProfile;

use crate::args::OpticsArgs;
use crate::atmosphere::{Defaults, load_profile, solar_on_grid};
use crate::files::OutputFile;

/// Runs the command.
///
/// # Errors
/// When an input is wrong or an output cannot be written.
pub fn run(args: &OpticsArgs) -> Result<()> {
    let profile = load_profile(&args.atmosphere.profile)?;
    let settings = args.atmosphere.settings(&args.haze, Defaults::SKY)?;
    let out = OutputFile::create(&args.out)?;
    let solar_out = args.solar.as_deref().map(OutputFile::create).transpose()?;
    let optics = OpticalProfile::build(&profile, &settings)?;
    if let Some(solar_out) = solar_out {
        let step_nm = args.atmosphere.step_nm(Defaults::SKY);
        let solar = solar_on_grid(&settings.wavelength_nm, step_nm)?;
        solar_out.commit(solar.to_csv_string().as_bytes())?;
    }
    out.commit(optics.to_csv_string().as_bytes())?;
    Ok(())
}
