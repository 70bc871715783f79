//! The extinction that travels with a table: an atmosphere reduced to four wavelengths and 31 levels.

use anyhow::{Result, bail};
use nalgebra::{DMatrix, DVector};
use sky_core::color::linear_srgb_from_xyz;
use sky_core::extinction::{Extinction, WAVELENGTHS_NM, level_altitudes_km};
use sky_core::haze::Haze;
use sky_science::cie::ColorWeights;
use sky_science::spectrum::Spectrum;
use sky_sim::aerosol::{stratosphere, stratosphere_optical_depth_550};
use sky_sim::optics::{Constituents, OpticalProfile, OpticsSettings};
use sky_sim::profile::AtmosphereProfile;
use sky_sim::solar::SolarSpectrum;

/// Columns of air, haze and gas in vertical columns that the weights are fitted over.
const AIR: [f64; 7] = [0.0, 0.1, 0.5, 2.0, 6.0, 15.0, 38.0];
const HAZE: [f64; 6] = [0.0, 0.03, 0.1, 0.4, 1.2, 4.0];
const GAS: [f64; 4] = [0.0, 1.0, 5.0, 20.0];
/// Errors are relative down to this transmittance, absolute below.
const FAINT: f64 = 0.02;
/// Weight of the condition that no air takes no light.
const CLEAR: f64 = 1e3;

/// Reduces an atmosphere.
///
/// # Errors
/// When the settings do not suit the profile.
pub fn reduce(profile: &AtmosphereProfile, settings: &OpticsSettings) -> Result<Extinction> {
    let with = |wavelength_nm: &[f64], optical_depth| {
        OpticalProfile::build(
            profile,
            &OpticsSettings {
                wavelength_nm: wavelength_nm.to_vec(),
                haze: Haze::OpticalDepth500(optical_depth),
                ..settings.clone()
            },
        )
    };
    // the first share of all aerosol is the stratosphere's; what is beyond it is haze
    let layer_depth = layer_optical_depth_500(settings.constituents);
    let thin = with(&WAVELENGTHS_NM, layer_depth)?;
    let thick = with(&WAVELENGTHS_NM, layer_depth + 1.0)?;
    let levels: Vec<usize> = level_altitudes_km()
        .map(|z| level_at(&thin, z))
        .collect::<Result<_>>()?;
    let at = |table: &[f64], level: usize| -> [f64; 4] {
        core::array::from_fn(|w| table[level * WAVELENGTHS_NM.len() + w])
    };
    let aerosol = |optics: &OpticalProfile, level: usize| -> [f64; 4] {
        let scattering = at(&optics.aerosol_scattering_per_km, level);
        let absorption = at(&optics.aerosol_absorption_per_km, level);
        core::array::from_fn(|w| scattering[w] + absorption[w])
    };
    let densest = |table: &dyn Fn(usize) -> [f64; 4]| -> [f64; 4] {
        levels.iter().map(|&l| table(l)).fold(
            [0.0; 4],
            |best, here| {
                if here[2] > best[2] { here } else { best }
            },
        )
    };
    let rayleigh = |l: usize| at(&thin.rayleigh_scattering_per_km, l);
    let gas = |l: usize| at(&thin.gas_absorption_per_km, l);
    let layer = |l: usize| aerosol(&thin, l);
    let (ground_air, most_gas, most_layer) = (rayleigh(levels[0]), densest(&gas), densest(&layer));
    let (thick_ground, thin_ground) = (aerosol(&thick, levels[0]), aerosol(&thin, levels[0]));
    let (weights, sun) = channel_weights(profile, settings)?;
    Ok(Extinction {
        sun_rgb_lx: sun.map(rounded),
        weights,
        rayleigh_per_km: ground_air.map(rounded),
        gas_per_km: most_gas.map(rounded),
        haze_per_km: core::array::from_fn(|w| rounded(thick_ground[w] - thin_ground[w])),
        layer_per_km: most_layer.map(rounded),
        layer_optical_depth_500: layer_depth,
        haze_scale_height_km: settings.aerosol_scale_height.km(),
        relative_density: levels
            .iter()
            .map(|&l| {
                [
                    relative(rayleigh(l), ground_air),
                    relative(gas(l), most_gas),
                    relative(layer(l), most_layer),
                ]
            })
            .collect(),
    })
}

/// A share of a reference over all four wavelengths.
fn relative(here: [f64; 4], reference: [f64; 4]) -> f64 {
    let (sum, whole) = (here.iter().sum::<f64>(), reference.iter().sum::<f64>());
    if whole > 0.0 {
        rounded(sum / whole)
    } else {
        0.0
    }
}

/// Five digits are more than the formula is good for, and short in a header.
fn rounded(value: f64) -> f64 {
    format!("{value:.4e}").parse().unwrap_or(value)
}

fn level_at(optics: &OpticalProfile, altitude_km: f64) -> Result<usize> {
    let found = optics
        .altitude_km
        .iter()
        .position(|z| (z - altitude_km).abs() < 1e-6);
    match found {
        Some(level) => Ok(level),
        None => bail!("optics: expected a level at {altitude_km} km, found none"),
    }
}

/// Vertical optical depth at 500 nm of the stratospheric aerosol.
fn layer_optical_depth_500(constituents: Constituents) -> f64 {
    if constituents.aerosol && constituents.stratospheric_aerosol {
        rounded(stratosphere_optical_depth_550(0.0) * stratosphere(500.0).relative_extinction)
    } else {
        0.0
    }
}

/// Vertical optical depths of air, haze of depth 1 and gas, by wavelength.
fn vertical_depths(
    profile: &AtmosphereProfile,
    settings: &OpticsSettings,
    wavelength_nm: &[f64],
) -> Result<[Vec<f64>; 3]> {
    let optics = OpticalProfile::build(
        profile,
        &OpticsSettings {
            wavelength_nm: wavelength_nm.to_vec(),
            haze: Haze::OpticalDepth500(1.0),
            ..settings.clone()
        },
    )?;
    let column = |parts: &[&[f64]]| -> Vec<f64> {
        let count = wavelength_nm.len();
        let mut sum = vec![0.0; count];
        for l in 1..optics.altitude_km.len() {
            let step = optics.altitude_km[l] - optics.altitude_km[l - 1];
            for part in parts {
                for (w, sum) in sum.iter_mut().enumerate() {
                    *sum += 0.5 * step * (part[(l - 1) * count + w] + part[l * count + w]);
                }
            }
        }
        sum
    };
    Ok([
        column(&[&optics.rayleigh_scattering_per_km]),
        column(&[
            &optics.aerosol_scattering_per_km,
            &optics.aerosol_absorption_per_km,
        ]),
        column(&[&optics.gas_absorption_per_km]),
    ])
}

/// A path's transmittances at the four wavelengths and what they are in the four channels.
type PathRow = ([f64; 4], [f64; 4]);

/// Shares of the four wavelengths in the transmittances of red, green, blue and luminance of
/// sunlight, by least squares over paths of all lengths; and the sunlight itself in linear sRGB \[lx\].
fn channel_weights(
    profile: &AtmosphereProfile,
    settings: &OpticsSettings,
) -> Result<([[f64; 4]; 4], [f64; 3])> {
    let sun = SolarSpectrum::g173();
    let sun = Spectrum::new(sun.wavelength_nm, sun.irradiance_w_m2_nm)?;
    let fine = OpticsSettings::with_step_nm(10)?.wavelength_nm;
    let colors = ColorWeights::for_radiance_ratio(&fine, &sun)?;
    let all = vertical_depths(profile, settings, &fine)?;
    let four = vertical_depths(profile, settings, &WAVELENGTHS_NM)?;
    let through = |depths: &[Vec<f64>; 3], amounts: [f64; 3]| -> Vec<f64> {
        (0..depths[0].len())
            .map(|w| (-(0..3).map(|k| amounts[k] * depths[k][w]).sum::<f64>()).exp())
            .collect()
    };
    let channels = |spectrum: &[f64]| {
        let xyz = colors.xyz(spectrum);
        let rgb = linear_srgb_from_xyz(xyz);
        [rgb.red, rgb.green, rgb.blue, xyz.y]
    };
    let whole = channels(&vec![1.0; fine.len()]);
    // no air takes no light
    let mut rows: Vec<PathRow> = vec![([1.0; 4], [1.0; 4])];
    for air in AIR {
        for haze in HAZE {
            for gas in GAS {
                let amounts = [air, haze, gas];
                let exact = channels(&through(&all, amounts));
                let at_four = through(&four, amounts);
                rows.push((
                    core::array::from_fn(|w| at_four[w]),
                    core::array::from_fn(|c| exact[c] / whole[c]),
                ));
            }
        }
    }
    let mut weights = [[0.0; 4]; 4];
    for (channel, weights) in weights.iter_mut().enumerate() {
        *weights = fitted(&rows, channel)?;
    }
    Ok((weights, [whole[0], whole[1], whole[2]]))
}

/// The shares of a channel; the first row is the clear path.
fn fitted(rows: &[PathRow], channel: usize) -> Result<[f64; 4]> {
    let mut normal = DMatrix::<f64>::zeros(4, 4);
    let mut right = DVector::<f64>::zeros(4);
    for (i, (at_four, exact)) in rows.iter().enumerate() {
        let target = exact[channel];
        let scale = if i == 0 {
            CLEAR
        } else {
            1.0 / target.max(FAINT)
        };
        for a in 0..4 {
            right[a] += scale * scale * at_four[a] * target;
            for b in 0..4 {
                normal[(a, b)] += scale * scale * at_four[a] * at_four[b];
            }
        }
    }
    let Some(solution) = normal.lu().solve(&right) else {
        bail!("extinction: expected four independent wavelengths, found a singular fit");
    };
    Ok(core::array::from_fn(|w| rounded(solution[w])))
}
