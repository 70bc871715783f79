//! What the sky is made of: the profile's nine graphs, the spectra of beam and sky, optical depths.

use anyhow::Result;
use sky_core::direction::{SkyDirection, horizon_zenith};
use sky_core::haze::Haze;
use sky_core::quantity::{Angle, Length};
use sky_sim::optics::{Constituents, OpticalProfile, OpticsSettings};
use sky_sim::profile::{AtmosphereProfile, ProfileRow};
use sky_sim::smarts::{BeamOverrides, DirectBeam};
use sky_sim::solar::SolarSpectrum;

use super::input::ReportInput;
use super::long_table::LongTable;
use crate::cases::conditions;
use crate::profiles::solar_on_grid;
use sky_plot::Scale;
use sky_plot::chart::{Chart, Series, Stroke};
use sky_plot::number::short;
use sky_plot::page::{Section, escape};

/// The profile's graphs: heading, caption of the axis with unit, key of the CSV, quantity, logarithmic.
type Graph = (
    &'static str,
    &'static str,
    &'static str,
    fn(&ProfileRow) -> f64,
    bool,
);

const GRAPHS: [Graph; 9] = [
    (
        "Air temperature",
        "temperature [K]",
        "temperature_k",
        |r| r.temperature_k,
        false,
    ),
    (
        "Pressure",
        "pressure [hPa]",
        "pressure_hpa",
        |r| r.pressure_hpa,
        true,
    ),
    (
        "Effective ozone temperature (Eq. 3.7)",
        "temperature [K]",
        "ozone_effective_temperature_k",
        |r| r.ozone_effective_temperature_k,
        false,
    ),
    (
        "Relative humidity",
        "over liquid water [%]",
        "relative_humidity_percent",
        |r| r.relative_humidity_percent,
        false,
    ),
    (
        "O₂ path",
        "effective path [km]",
        "o2_path_km",
        |r| r.o2_path_km,
        true,
    ),
    (
        "CO₂ path",
        "effective path [km]",
        "co2_path_km",
        |r| r.co2_path_km,
        true,
    ),
    (
        "H₂O above",
        "precipitable water [cm]",
        "water_column_cm",
        |r| r.water_column_cm,
        true,
    ),
    (
        "O₃ above",
        "column [atm-cm]",
        "ozone_column_atm_cm",
        |r| r.ozone_column_atm_cm,
        false,
    ),
    (
        "NO₂ above",
        "column [10⁻⁴ atm-cm]",
        "no2_column_1e-4_atm_cm",
        |r| 1e4 * r.no2_column_atm_cm,
        false,
    ),
];

pub(super) fn profile_graphs(input: &ReportInput<'_>, csv: &mut LongTable) -> Result<Section> {
    let utm2005 = AtmosphereProfile::utm2005();
    let mut profiles = vec![(file_stem(input.profile.name()), input.profile)];
    if input.profile.name() != utm2005.name() {
        profiles.push((file_stem(utm2005.name()), &utm2005));
    }
    let rows: Vec<(&str, Vec<ProfileRow>)> = profiles
        .iter()
        .map(|(name, profile)| {
            let altitudes = (0..=60_u8).map(|i| Length::from_km(0.5 * f64::from(i)));
            (*name, altitudes.map(|z| profile.row(z)).collect())
        })
        .collect();
    let mut body = format!(
        "<p>The atmosphere of this report, {}, against the recipe of 2005 (dashed), from the ground \
         to the highest observer. The path lengths of O₂ and CO₂ are the effective ones of the \
         original report's Eq. 3.11.</p>\n<div class=\"grid\">",
        escape(input.profile.name())
    );
    for (title, caption, key, of, logarithmic) in GRAPHS {
        let mut series = Vec::new();
        for (i, (name, rows)) in rows.iter().enumerate() {
            let points: Vec<[f64; 2]> = rows.iter().map(|r| [of(r), r.altitude_km]).collect();
            let stroke = if i == 0 {
                Stroke::Solid
            } else {
                Stroke::Dashed
            };
            for row in rows.iter().step_by(4) {
                let here = conditions(row.altitude_km, f64::NAN, f64::NAN);
                csv.figure("profile", key, Some(&here), name, of(row));
            }
            series.push(Series::new(*name, i, points).stroked(stroke));
        }
        let all = series.iter().flat_map(|s| s.points.iter().map(|p| p[0]));
        let x = if logarithmic {
            Scale::logarithmic(caption, all, 6.0)
        } else {
            Scale::linear(caption, all)
        };
        body.push_str(
            &Chart {
                title: title.to_owned(),
                x,
                y: Scale::linear_from("altitude [km]", [0.0, 30.0]),
                series,
                notes: Vec::new(),
                size: [340, 250],
            }
            .html()?,
        );
    }
    body.push_str("</div>\n");
    Ok(Section {
        id: "profile",
        title: "The atmosphere",
        body,
    })
}

/// `profiles/general.csv` is `general`.
fn file_stem(name: &str) -> &str {
    let base = name.rsplit(['/', '\\']).next().unwrap_or(name);
    base.strip_suffix(".csv").unwrap_or(base)
}

const SPECTRA_ALTITUDES_KM: [f64; 5] = [0.0, 3.0, 6.0, 12.0, 30.0];
const SPECTRA_SUN_DEG: f64 = 60.0;

pub(super) fn spectra(input: &ReportInput<'_>, csv: &mut LongTable) -> Result<Section> {
    let turbidity = input.settings.scene_turbidity;
    let mut body = format!(
        "<p>Turbidity {}, sun zenith angle {SPECTRA_SUN_DEG}°. The horizon is seen 1° above the \
         geometric one, at right angles to the sun.</p>\n<div class=\"grid\">",
        short(turbidity)
    );
    body.push_str(&beam(input, csv)?.html()?);
    for chart in sky(input, csv)? {
        body.push_str(&chart.html()?);
    }
    body.push_str(&depths(input, csv)?.html()?);
    body.push_str("</div>\n");
    Ok(Section {
        id: "spectra",
        title: "Spectra",
        body,
    })
}

fn wavelength_axis() -> Scale {
    Scale::linear_from("wavelength [nm]", [380.0, 780.0])
}

const SPECTRUM_SIZE: [u32; 2] = [520, 300];

/// Writes every `stride`-th point of a spectrum to the CSV; the wavelength is in the key.
fn log_spectrum(
    csv: &mut LongTable,
    key: &str,
    place: [f64; 3],
    channel: &str,
    points: &[[f64; 2]],
) {
    let here = conditions(place[0], place[1], place[2]);
    for [nm, value] in points.iter().filter(|p| p[0] % 20.0 < 1e-6) {
        csv.figure(
            "spectra",
            &format!("{key} at {nm} nm"),
            Some(&here),
            channel,
            *value,
        );
    }
}

fn beam(input: &ReportInput<'_>, csv: &mut LongTable) -> Result<Chart> {
    let turbidity = input.settings.scene_turbidity;
    let grid = OpticsSettings::with_step_nm(1)?;
    let settings = OpticsSettings {
        wavelength_nm: grid.wavelength_nm,
        gas_band_width_nm: grid.gas_band_width_nm,
        constituents: Constituents::ALL,
        haze: Haze::Turbidity(turbidity),
        ..input.truth.settings().clone()
    };
    let beam = DirectBeam::new(input.profile, &settings, BeamOverrides::default())?;
    let solar = solar_on_grid(&settings.wavelength_nm, 1)?;
    let mut series = Vec::new();
    let pairs = |values: &[f64]| -> Vec<[f64; 2]> {
        settings
            .wavelength_nm
            .iter()
            .zip(values)
            .map(|(&nm, &v)| [nm, v])
            .collect()
    };
    series.push(Series::new(
        "outside the atmosphere",
        7,
        pairs(&solar.irradiance_w_m2_nm),
    ));
    for (i, km) in SPECTRA_ALTITUDES_KM.into_iter().enumerate() {
        let irradiance = beam.normal_irradiance(
            Length::from_km(km),
            Angle::from_degrees(SPECTRA_SUN_DEG),
            &solar,
        )?;
        let points = pairs(&irradiance);
        let place = [km, turbidity, SPECTRA_SUN_DEG];
        log_spectrum(csv, "beam irradiance [W/m2/nm]", place, "beam", &points);
        series.push(Series::new(format!("{km} km"), i, points));
    }
    let all: Vec<f64> = series
        .iter()
        .flat_map(|s| s.points.iter().map(|p| p[1]))
        .collect();
    Ok(Chart {
        title: "Direct normal irradiance, all gases, 1 nm".to_owned(),
        x: wavelength_axis(),
        y: Scale::linear("irradiance [W m⁻² nm⁻¹]", all.into_iter().chain([0.0])),
        series,
        notes: Vec::new(),
        size: SPECTRUM_SIZE,
    })
}

fn sky(input: &ReportInput<'_>, csv: &mut LongTable) -> Result<[Chart; 2]> {
    let turbidity = input.settings.scene_turbidity;
    let wavelength_nm = &input.truth.settings().wavelength_nm;
    let step = match wavelength_nm.as_slice() {
        [first, second, ..] => second - first,
        _ => 1.0,
    };
    let solar = SolarSpectrum::g173().on_grid(wavelength_nm, step)?;
    let (mut zenith, mut horizon) = (Vec::new(), Vec::new());
    for (i, km) in SPECTRA_ALTITUDES_KM.into_iter().enumerate() {
        let here = conditions(km, turbidity, SPECTRA_SUN_DEG);
        let low = horizon_zenith(here.observer_altitude).degrees() - 1.0;
        let directions = [
            SkyDirection::from_degrees(0.0, 0.0),
            SkyDirection::from_degrees(low, 90.0),
        ];
        let ratio = input.truth.radiance_ratio(&here, &directions)?;
        let place = [km, turbidity, SPECTRA_SUN_DEG];
        for (spectrum, (name, series)) in ratio
            .chunks_exact(wavelength_nm.len())
            .zip([("zenith", &mut zenith), ("horizon", &mut horizon)])
        {
            let points: Vec<[f64; 2]> = wavelength_nm
                .iter()
                .zip(spectrum.iter().zip(&solar.irradiance_w_m2_nm))
                .map(|(&nm, (ratio, sun))| [nm, 1e3 * ratio * sun])
                .collect();
            log_spectrum(csv, "radiance [mW/m2/sr/nm]", place, name, &points);
            series.push(Series::new(format!("{km} km"), i, points));
        }
    }
    Ok(
        [("Zenith", zenith), ("Horizon", horizon)].map(|(name, series)| {
            let all: Vec<f64> = series
                .iter()
                .flat_map(|s| s.points.iter().map(|p| p[1]))
                .collect();
            Chart {
                title: format!("{name}: spectral radiance, {step} nm"),
                x: wavelength_axis(),
                y: Scale::logarithmic("radiance [mW m⁻² sr⁻¹ nm⁻¹]", all, 5.0),
                series,
                notes: Vec::new(),
                size: SPECTRUM_SIZE,
            }
        }),
    )
}

fn depths(input: &ReportInput<'_>, csv: &mut LongTable) -> Result<Chart> {
    const NONE: Constituents = Constituents {
        rayleigh: false,
        ozone: false,
        no2: false,
        o2o2: false,
        o2_band: false,
        h2o_band: false,
        aerosol: false,
        stratospheric_aerosol: false,
    };
    let list = [
        (
            "Rayleigh",
            Constituents {
                rayleigh: true,
                ..NONE
            },
        ),
        (
            "haze",
            Constituents {
                aerosol: true,
                ..NONE
            },
        ),
        (
            "ozone",
            Constituents {
                ozone: true,
                ..NONE
            },
        ),
        ("NO₂", Constituents { no2: true, ..NONE }),
        ("O₂–O₂", Constituents { o2o2: true, ..NONE }),
        (
            "O₂ bands",
            Constituents {
                o2_band: true,
                ..NONE
            },
        ),
        (
            "H₂O bands",
            Constituents {
                h2o_band: true,
                ..NONE
            },
        ),
        (
            "stratospheric layer",
            Constituents {
                stratospheric_aerosol: true,
                ..NONE
            },
        ),
    ];
    let turbidity = input.settings.scene_turbidity;
    let grid = OpticsSettings::with_step_nm(5)?;
    let mut series = Vec::new();
    for (i, (name, constituents)) in list.into_iter().enumerate() {
        let settings = OpticsSettings {
            wavelength_nm: grid.wavelength_nm.clone(),
            gas_band_width_nm: grid.gas_band_width_nm,
            constituents,
            haze: Haze::Turbidity(turbidity),
            ..input.truth.settings().clone()
        };
        let optics = OpticalProfile::build(input.profile, &settings)?;
        let depth = optics.vertical_optical_depth(Length::ZERO);
        let points: Vec<[f64; 2]> = settings
            .wavelength_nm
            .iter()
            .zip(depth)
            .map(|(&nm, d)| [nm, d])
            .collect();
        log_spectrum(
            csv,
            "vertical optical depth",
            [0.0, turbidity, f64::NAN],
            name,
            &points,
        );
        // Nothing to draw where a gas does not absorb.
        let points = points
            .iter()
            .map(|&[nm, d]| [nm, if d > 0.0 { d } else { f64::NAN }]);
        let stroke = if i < 4 { Stroke::Solid } else { Stroke::Dashed };
        series.push(Series::new(name, i, points.collect()).stroked(stroke));
    }
    let all: Vec<f64> = series
        .iter()
        .flat_map(|s| s.points.iter().map(|p| p[1]))
        .collect();
    Ok(Chart {
        title: "Vertical optical depth from the ground by constituent, 5 nm".to_owned(),
        x: wavelength_axis(),
        y: Scale::logarithmic("optical depth", all, 4.5),
        series,
        notes: Vec::new(),
        size: SPECTRUM_SIZE,
    })
}
