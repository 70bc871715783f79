//! `utm-sky map`: the sky's radiance or color by direction, computed from the atmosphere.

use std::path::{Path, PathBuf};

use anyhow::{Result, anyhow, bail};
use clap::{ArgGroup, Args};
use sky_core::quantity::Length;
use sky_eval::engine::{self, Air, Scene};
use sky_eval::profiles::solar_on_grid;
use sky_science::cie::ColorWeights;
use sky_science::spectrum::Spectrum;
use sky_sim::optics::OpticalProfile;
use sky_sim::solar::SolarSpectrum;

use crate::args::{AnyPlaceArgs, AtmosphereArgs, Defaults, Engine, HazeArgs, conditions, within};
use crate::io::files::{OutputFile, read_text};
use crate::io::model;
use crate::io::profile::load_profile;
use crate::io::table::{DirectionArgs, spectral_map_csv, yxy_map_csv};

/// `utm-sky map`.
#[derive(Debug, Args)]
#[command(
    group(ArgGroup::new("air").required(true)
        .args(["turbidity", "aod500", "visual_range_km", "angstrom_beta", "optics"])),
    after_help = "Examples:
  utm-sky map --altitude-km 6 --turbidity 2 --sun-zenith-deg 60 --out map.csv
  utm-sky map --altitude-km 100 --turbidity 2 --sun-zenith-deg 40 --direction 100,0 --out m.csv
  utm-sky map --altitude-km 0 --aod500 0.1 --sun-zenith-deg 85 --engine smarts --yxy --out sky.csv
  utm-sky map --model nishita --altitude-km 0 --turbidity 2 --sun-zenith-deg 85 --yxy --out map.csv

With what utm-sky optics --turbidity 2 --out optics.csv --solar solar.csv made, or another program in
its format: utm-sky map --altitude-km 9 --optics optics.csv --solar solar.csv --depolarization 0
--sun-zenith-deg 92 --albedo 0.1 --out map.csv"
)]
pub struct MapArgs {
    /// Observer and sun.
    #[command(flatten)]
    pub place: AnyPlaceArgs,
    /// Albedo of the ground (Lambertian), which lights the air and is seen through it
    #[arg(long, value_name = "A", value_parser = within(0.0, 1.0), default_value = "0.2",
          allow_negative_numbers = true)]
    pub albedo: f64,
    /// How the radiance is computed
    #[arg(long, default_value = "transport")]
    pub engine: Engine,
    /// A sky of `utm-sky models` in place of the table's
    #[arg(long, value_name = "NAME", requires = "yxy",
          conflicts_with_all = ["engine", "optics", "albedo", "profile", "constituents",
                                "wavelength_step_nm", "single_scattering_albedo", "asymmetry",
                                "scale_height_km", "depolarization"])]
    pub model: Option<String>,
    /// Directions of view.
    #[command(flatten)]
    pub directions: DirectionArgs,
    /// Write luminance and chromaticity instead of spectral radiance
    #[arg(long)]
    pub yxy: bool,
    /// The map; spectral radiance belongs to the solar spectrum that `utm-sky optics --solar` writes
    #[arg(long, value_name = "CSV")]
    pub out: PathBuf,
    /// Optics made elsewhere, in the format of `utm-sky optics`, instead of a profile and haze
    #[arg(long, value_name = "CSV", requires = "solar", help_heading = "Optics made elsewhere",
          conflicts_with_all = ["profile", "constituents", "wavelength_step_nm", "angstrom_alpha",
                                "single_scattering_albedo", "asymmetry", "scale_height_km"])]
    pub optics: Option<PathBuf>,
    /// Extraterrestrial solar spectrum that covers the wavelengths of --optics
    #[arg(long, value_name = "CSV", help_heading = "Optics made elsewhere")]
    pub solar: Option<PathBuf>,
    /// Depolarization of the Rayleigh phase function; without it that of air, 0.0283
    #[arg(long, value_name = "D", value_parser = within(0.0, 0.5), allow_negative_numbers = true,
          help_heading = "Optics made elsewhere")]
    pub depolarization: Option<f64>,
    /// The haze.
    #[command(flatten)]
    pub haze: HazeArgs,
    /// The air.
    #[command(flatten)]
    pub atmosphere: AtmosphereArgs,
}

/// The air, and the sun that shines on it.
struct Inputs {
    air: Air,
    /// At the wavelengths of the air \[W·m⁻²·nm⁻¹\].
    irradiance_w_m2_nm: Vec<f64>,
    /// As finely as it is known, for the colors.
    solar: SolarSpectrum,
}

/// Runs the command.
///
/// # Errors
/// When an input is wrong, the engine gives up or the output cannot be written.
pub fn run(args: &MapArgs) -> Result<()> {
    let directions = args.directions.table()?;
    if let Some(model) = &args.model {
        let haze = args.haze.haze(args.atmosphere.angstrom_alpha);
        let map = model::map(model, &conditions(&args.place.into(), haze)?, &directions)?;
        OutputFile::create(&args.out)?.commit(yxy_map_csv(&directions, &map).as_bytes())?;
        return Ok(());
    }
    let inputs = match (&args.optics, &args.solar) {
        (Some(optics), Some(solar)) => made_elsewhere(args, optics, solar)?,
        (None, Some(_)) => bail!("--solar: expected together with --optics, found alone"),
        _ => from_profile(args)?,
    };
    let weights = if args.yxy {
        let solar = Spectrum::new(
            inputs.solar.wavelength_nm.clone(),
            inputs.solar.irradiance_w_m2_nm.clone(),
        )?;
        Some(ColorWeights::for_radiance_ratio(
            inputs.air.wavelength_nm(),
            &solar,
        )?)
    } else {
        None
    };
    let out = OutputFile::create(&args.out)?;
    let scene = Scene {
        observer_altitude: Length::from_km(args.place.altitude_km),
        sun_zenith: args.place.sun_zenith(),
        ground_albedo: args.albedo,
    };
    let ratio = match args.engine {
        Engine::Transport => engine::transport(&inputs.air, scene, &directions.directions)?,
        Engine::Smarts => engine::smarts(&inputs.air, scene, &directions.directions)?,
    };
    let wavelength_nm = inputs.air.wavelength_nm();
    let text = if let Some(weights) = weights {
        let map: Vec<_> = ratio
            .chunks_exact(wavelength_nm.len())
            .map(|spectrum| weights.yxy(spectrum))
            .collect();
        yxy_map_csv(&directions, &map)
    } else {
        let radiance: Vec<f64> = ratio
            .chunks_exact(wavelength_nm.len())
            .flat_map(|spectrum| spectrum.iter().zip(&inputs.irradiance_w_m2_nm))
            .map(|(ratio, irradiance)| ratio * irradiance)
            .collect();
        spectral_map_csv(&directions, wavelength_nm, &radiance)
    };
    out.commit(text.as_bytes())?;
    Ok(())
}

fn from_profile(args: &MapArgs) -> Result<Inputs> {
    let profile = load_profile(&args.atmosphere.profile)?.profile;
    let mut settings = args.atmosphere.settings(&args.haze, Defaults::SKY)?;
    if let Some(depolarization) = args.depolarization {
        settings.rayleigh_depolarization = depolarization;
    }
    let step_nm = args.atmosphere.step_nm(Defaults::SKY);
    Ok(Inputs {
        irradiance_w_m2_nm: solar_on_grid(&settings.wavelength_nm, step_nm)?.irradiance_w_m2_nm,
        solar: SolarSpectrum::g173(),
        air: Air::Profile {
            profile: Box::new(profile),
            settings,
        },
    })
}

fn made_elsewhere(args: &MapArgs, optics_path: &Path, solar_path: &Path) -> Result<Inputs> {
    if args.engine != Engine::Transport {
        bail!("--engine: expected transport with --optics, found smarts");
    }
    let optics_name = optics_path.display().to_string();
    let mut optics = OpticalProfile::from_csv_str(&optics_name, &read_text(optics_path)?)?;
    if let Some(depolarization) = args.depolarization {
        optics.rayleigh_depolarization = depolarization;
    }
    let solar_name = solar_path.display().to_string();
    let solar = SolarSpectrum::from_csv_str(&solar_name, &read_text(solar_path)?)?;
    // Not a band mean: the file says what it means at its wavelengths.
    let irradiance_w_m2_nm = solar
        .on_grid(&optics.wavelength_nm, 0.0)
        .map_err(|error| anyhow!("{solar_name}: {error} in {optics_name}"))?
        .irradiance_w_m2_nm;
    Ok(Inputs {
        air: Air::Optics(optics),
        irradiance_w_m2_nm,
        solar,
    })
}
