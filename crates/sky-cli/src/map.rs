//! `utm-sky map`: the sky's radiance or color by direction, computed from the atmosphere.

use std::path::Path;

use anyhow::{Result, anyhow, bail};
use sky_core::quantity::{Angle, Length};
use sky_science::cie::ColorWeights;
use sky_science::spectrum::Spectrum;
use sky_sim::optics::OpticalProfile;
use sky_sim::solar::SolarSpectrum;

use crate::args::{Engine, MapArgs};
use crate::atmosphere::{Defaults, load_profile, solar_on_grid};
use crate::engine::{Air, Scene, radiance_ratio};
use crate::files::{OutputFile, read_text};
use crate::models;
use crate::scene::conditions;
use crate::table_io::{DirectionTable, spectral_map_csv, yxy_map_csv};

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
    let directions = DirectionTable::read_or_report(args.directions.as_deref())?;
    if let Some(model) = &args.model {
        let haze = args.haze.haze(args.atmosphere.angstrom_alpha);
        let map = models::map(model, &conditions(&args.place, haze)?, &directions)?;
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
        sun_zenith: Angle::from_degrees(args.place.sun_zenith_deg),
        ground_albedo: args.albedo,
    };
    let ratio = radiance_ratio(args.engine, &inputs.air, scene, &directions.directions)?;
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
    let profile = load_profile(&args.atmosphere.profile)?;
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
