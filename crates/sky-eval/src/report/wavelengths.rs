//! How coarse the wavelengths may be: color on 20, 10 and 5 nm steps against 1 nm.

use sky_core::conditions::Conditions;
use sky_core::direction::SkyDirection;
use sky_science::sky_model::SkyModel;
use sky_sim::optics::OpticsSettings;
use sky_sim::transport::TransportSettings;

use super::long_table::LongTable;
use super::text::percent;
use crate::cases::conditions;
use crate::score::compare_maps;
use crate::truth::TransportSky;
use sky_plot::number::short;
use sky_plot::page::{Section, table};

/// Color on one wavelength step against 1 nm, over the directions of one map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WavelengthRow {
    /// Step \[nm\].
    pub step_nm: u16,
    /// Where.
    pub conditions: Conditions,
    /// Largest ΔE.
    pub delta_e_max: f64,
    /// Largest relative difference of luminance.
    pub luminance_max: f64,
}

/// Steps that are compared with 1 nm \[nm\].
pub const STEPS_NM: [u16; 3] = [20, 10, 5];

/// Altitudes, turbidity and suns of the table; one turbidity, because each costs a solution at 1 nm.
pub const CONDITIONS: [Conditions; 6] = [
    conditions(0.0, 2.0, 30.0),
    conditions(0.0, 2.0, 80.0),
    conditions(0.0, 2.0, 90.0),
    conditions(12.0, 2.0, 30.0),
    conditions(12.0, 2.0, 90.0),
    conditions(12.0, 2.0, 94.0),
];

fn directions() -> Vec<SkyDirection> {
    let mut out = vec![SkyDirection::from_degrees(0.0, 0.0)];
    for zenith in [45.0, 75.0, 89.0] {
        for azimuth in [0.0, 60.0, 180.0] {
            out.push(SkyDirection::from_degrees(zenith, azimuth));
        }
    }
    out
}

/// Settings of the engine that are enough to tell steps apart: what they cost in accuracy is the same
/// at all steps. They make the 1 nm solution affordable.
fn coarse_transport() -> TransportSettings {
    TransportSettings {
        degree: Some(3),
        zenith_points: [4, 3, 3],
        azimuth_points: 4,
        tolerance: 1e-2,
        shells_km: vec![0.0, 0.6, 1.5, 4.0, 8.0, 14.0, 22.0, 32.0, 46.0, 100.0],
        columns_deg: vec![
            0.0, 30.0, 57.0, 73.0, 82.5, 87.5, 90.5, 93.5, 96.5, 100.0, 106.0,
        ],
        ..TransportSettings::default()
    }
}

/// Solves the truth's atmosphere on coarse and fine wavelengths and compares the colors.
///
/// # Errors
/// When the optics cannot be built or a condition is outside the engine's domain.
pub fn convergence(
    truth: &TransportSky,
    cases: &[Conditions],
) -> anyhow::Result<Vec<WavelengthRow>> {
    let directions = directions();
    let maps = |step_nm: u16| -> anyhow::Result<Vec<_>> {
        let grid = OpticsSettings::with_step_nm(step_nm)?;
        let settings = OpticsSettings {
            wavelength_nm: grid.wavelength_nm,
            gas_band_width_nm: grid.gas_band_width_nm,
            ..truth.settings().clone()
        };
        let sky = TransportSky::new(truth.profile().clone(), settings, truth.ground_albedo())?
            .with_transport_settings(coarse_transport());
        let all = cases.iter().map(|case| sky.yxy_map(case, &directions));
        Ok(all.collect::<Result<_, _>>()?)
    };
    let fine = maps(1)?;
    let mut rows = Vec::new();
    for step_nm in STEPS_NM {
        for ((case, fine), coarse) in cases.iter().zip(&fine).zip(&maps(step_nm)?) {
            let errors = compare_maps(case, &directions, fine, coarse);
            rows.push(WavelengthRow {
                step_nm,
                conditions: *case,
                delta_e_max: errors.delta_e.iter().copied().fold(0.0, f64::max),
                luminance_max: errors.luminance.iter().copied().fold(0.0, f64::max),
            });
        }
    }
    Ok(rows)
}

pub(super) fn section(rows: &[WavelengthRow], csv: &mut LongTable) -> Section {
    let mut places: Vec<Conditions> = Vec::new();
    for row in rows {
        let (here, channel) = (Some(&row.conditions), format!("{} nm", row.step_nm));
        csv.figure(
            "wavelengths",
            "delta_e max",
            here,
            &channel,
            row.delta_e_max,
        );
        csv.figure(
            "wavelengths",
            "luminance difference max",
            here,
            &channel,
            row.luminance_max,
        );
        if !places.contains(&row.conditions) {
            places.push(row.conditions);
        }
    }
    let cells: Vec<Vec<String>> = places
        .iter()
        .map(|place| {
            let mut cells = vec![
                short(place.observer_altitude.km()),
                short(place.turbidity),
                short(place.sun_zenith.degrees()),
            ];
            for step in STEPS_NM {
                let found = rows
                    .iter()
                    .find(|row| row.step_nm == step && row.conditions == *place);
                cells.push(found.map_or_else(String::new, |row| format!("{:.3}", row.delta_e_max)));
                cells.push(found.map_or_else(String::new, |row| percent(row.luminance_max)));
            }
            cells
        })
        .collect();
    let head = [
        "altitude [km]",
        "turbidity",
        "sun zenith [°]",
        "20 nm: ΔE",
        "20 nm: luminance",
        "10 nm: ΔE",
        "10 nm: luminance",
        "5 nm: ΔE",
        "5 nm: luminance",
    ];
    let body = if rows.is_empty() {
        "<p class=\"soft\">Not computed for this report.</p>\n".to_owned()
    } else {
        format!(
            "<p>Largest difference from the color on 1 nm steps over ten directions, the sun's 5° left \
             out: the transport engine solved anew at each step (coarsely, alike at all steps). The radiance ratio is interpolated \
             between the wavelengths; the sun's spectrum and the observer's functions enter at 1 nm \
             always.</p>\n{}",
            table(&head, &cells, 0)
        )
    };
    Section {
        id: "wavelengths",
        title: "Convergence in wavelength",
        body,
    }
}
