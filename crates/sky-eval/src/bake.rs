//! Maps → fits → look-up table.

use std::collections::BTreeMap;

use anyhow::Result;
use sky_core::conditions::Domain;
use sky_core::extinction::Extinction;
use sky_core::lut::{
    CHANNELS, ErrorQuantiles, FitStatistics, Form, Interpolation, Lut, LutHeader, Storage,
};
use sky_fit::sweep::{Grid, SkyMap, Sweep, sweep};
use sky_science::metrics::{Statistics, ciede2000_of_lights, relative_error, white_luminance};
use sky_science::sky_model::SkyModel;
use sky_science::table_sky::TableSky;

use crate::profiles::NamedProfile;
use crate::progress::Progress;
use crate::truth::DEFAULT_GROUND_ALBEDO;

/// Wavelength step of the maps \[nm\]. The report's convergence table: 20 nm shows with the sun at the
/// horizon (ΔE 1.7), 10 nm does not.
pub const MAP_STEP_NM: u16 = 10;

/// Fits a grid and makes the table.
///
/// # Errors
/// When a cell cannot be fitted; the cell is named. What `progress` was told of is then not ended.
pub fn bake(
    truth: &dyn SkyModel,
    grid: &Grid,
    profile: &NamedProfile,
    extinction: Extinction,
    progress: &dyn Progress,
) -> Result<(Lut, Sweep)> {
    progress.begin("sky maps", Some(grid.maps()));
    let sweep = sweep(truth, grid, &|| progress.step())?;
    progress.end();
    let terms = grid.form.terms();
    let (interpolation, storage) = match grid.form {
        Form::PerezReport => (Interpolation::ReportLagrange, Storage::F32),
        Form::PerezSpherical => (Interpolation::LogLinear, Storage::F32),
        Form::Extended => (Interpolation::LogLinear, Storage::Linear16),
    };
    let header = LutHeader {
        form: grid.form,
        storage,
        interpolation,
        altitude_km: grid.altitude_km.clone(),
        turbidity: grid.turbidity.clone(),
        sun_zenith_deg: grid.sun_zenith_deg.clone(),
        channels: CHANNELS.map(str::to_owned).to_vec(),
        terms: terms.iter().map(|t| (*t).to_owned()).collect(),
        profile_name: profile.name.clone(),
        profile_sha256: profile.sha256.clone(),
        generator: concat!("utm-sky ", env!("CARGO_PKG_VERSION")).to_owned(),
        engine: truth.name().to_owned(),
        settings: BTreeMap::from([
            ("ground_albedo".to_owned(), DEFAULT_GROUND_ALBEDO.into()),
            ("wavelength_step_nm".to_owned(), MAP_STEP_NM.into()),
        ]),
        fit: FitStatistics::default(),
        extinction: Some(extinction),
        domain: Domain {
            altitude_km: grid.altitude_km.bounds(),
            turbidity: grid.turbidity.bounds(),
            sun_zenith_deg: grid.sun_zenith_deg.bounds(),
            below_horizontal: grid.form != Form::PerezReport,
        },
    };
    let draft = TableSky::new(Lut::from_f64(header.clone(), &sweep.values)?)?;
    let fit = statistics(&draft, &sweep.maps.iter().collect::<Vec<_>>())?;
    Ok((
        Lut::from_f64(LutHeader { fit, ..header }, &sweep.values)?,
        sweep,
    ))
}

/// Errors of a table over the maps it was fitted to.
///
/// # Errors
/// When a map lies outside the table's domain.
pub fn statistics(sky: &dyn SkyModel, maps: &[&SkyMap]) -> Result<FitStatistics> {
    let (mut colors, mut luminances) = (Vec::new(), Vec::new());
    for map in maps {
        let Some(white) = white_luminance(&map.sky) else {
            continue;
        };
        let found = sky.yxy_map(&map.conditions, &map.directions)?;
        for (found, truth) in found.iter().zip(&map.sky) {
            colors.push(ciede2000_of_lights(*found, *truth, white));
            luminances.push(relative_error(found.luminance_cd_m2, truth.luminance_cd_m2).abs());
        }
    }
    let quantiles = |values: &[f64]| {
        Statistics::of(values).map_or_else(ErrorQuantiles::default, |s| ErrorQuantiles {
            median: s.median,
            p95: s.p95,
            max: s.max,
        })
    };
    Ok(FitStatistics {
        delta_e_2000: quantiles(&colors),
        luminance_relative_error: quantiles(&luminances),
    })
}
