//! `utm-sky optics`: extinction per level and wavelength, for this engine or another.

use std::path::PathBuf;

use anyhow::Result;
use clap::{ArgGroup, Args};
use sky_eval::profiles::solar_on_grid;
use sky_sim::optics::OpticalProfile;

use crate::args::{AtmosphereArgs, Defaults, HAZE, HazeArgs};
use crate::io::files::OutputFile;
use crate::io::profile::load_profile;

/// `utm-sky optics`.
#[derive(Debug, Args)]
#[command(
    group(ArgGroup::new("haze").required(true)
        .args(HAZE)),
    after_help = "Example:
  utm-sky optics --aod500 0.2 --out optics.csv --solar solar.csv"
)]
pub struct OpticsArgs {
    /// Extinction by level and wavelength
    #[arg(long, value_name = "CSV")]
    pub out: PathBuf,
    /// Extraterrestrial solar spectrum at the same wavelengths, the mean over one step each
    #[arg(long, value_name = "CSV")]
    pub solar: Option<PathBuf>,
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
/// When an input is wrong or an output cannot be written.
pub fn run(args: &OpticsArgs) -> Result<()> {
    let profile = load_profile(&args.atmosphere.profile)?.profile;
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
