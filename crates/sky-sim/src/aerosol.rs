//! Aerosol: rural haze at 50 % relative humidity near the ground, a faint layer in the stratosphere.
//!
//! Spectra are Shettle & Fenn 1979 (AFGL-TR-79-0214) as LOWTRAN7 tabulates them; the stratospheric
//! profile is LOWTRAN7's spring/summer background.

use crate::table::{ColumnSpec, Table, interpolate};
use std::sync::LazyLock;

/// Two-term Henyey–Greenstein fit to the rural phase function of Shettle & Fenn at 550 nm and
/// relative humidity up to 70 %: first g, second g, weight of the first. Used at all wavelengths.
pub const RURAL_PHASE: [f64; 3] = [0.6746, -0.6092, 0.9807];

/// Relative humidity of the reference haze \[%\].
pub const REFERENCE_HUMIDITY_PERCENT: f64 = 50.0;

/// Top of the atmosphere \[km\].
const TOP_KM: f64 = 100.0;

/// What an aerosol does at one wavelength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AerosolSpectrum {
    /// Extinction relative to that at 550 nm.
    pub relative_extinction: f64,
    /// Single-scattering albedo.
    pub single_scattering_albedo: f64,
    /// Asymmetry parameter.
    pub asymmetry_parameter: f64,
}

#[derive(Debug)]
struct Nodes {
    wavelength_um: Vec<f64>,
    log_wavelength: Vec<f64>,
    log_extinction: Vec<f64>,
    single_scattering_albedo: Vec<f64>,
    asymmetry_parameter: Vec<f64>,
}

impl Nodes {
    fn new(rows: impl Iterator<Item = [f64; 4]>) -> Self {
        let mut nodes = Self {
            wavelength_um: Vec::new(),
            log_wavelength: Vec::new(),
            log_extinction: Vec::new(),
            single_scattering_albedo: Vec::new(),
            asymmetry_parameter: Vec::new(),
        };
        for [wavelength_um, extinction, albedo, asymmetry] in rows {
            nodes.wavelength_um.push(wavelength_um);
            nodes.log_wavelength.push(wavelength_um.ln());
            nodes.log_extinction.push(extinction.ln());
            nodes.single_scattering_albedo.push(albedo);
            nodes.asymmetry_parameter.push(asymmetry);
        }
        nodes
    }

    /// Extinction log-linear in log wavelength, the rest linear in wavelength.
    fn at(&self, wavelength_nm: f64) -> AerosolSpectrum {
        let um = 1e-3 * wavelength_nm;
        let linear = |values: &[f64]| interpolate(&self.wavelength_um, values, um);
        AerosolSpectrum {
            relative_extinction: interpolate(&self.log_wavelength, &self.log_extinction, um.ln())
                .exp(),
            single_scattering_albedo: linear(&self.single_scattering_albedo),
            asymmetry_parameter: linear(&self.asymmetry_parameter),
        }
    }
}

#[derive(Debug)]
struct Data {
    rural_dry: Nodes,
    rural_humid: Nodes,
    stratosphere: Nodes,
    profile_altitude_km: Vec<f64>,
    profile_per_km: Vec<f64>,
}

const ANY: [f64; 2] = [0.0, 1e6];

const RURAL_COLUMNS: [ColumnSpec; 5] = [
    ColumnSpec::required("relative_humidity_percent", ANY),
    ColumnSpec::required("wavelength_um", ANY),
    ColumnSpec::required("extinction_relative_to_550nm", ANY),
    ColumnSpec::required("single_scattering_albedo", ANY),
    ColumnSpec::required("asymmetry_parameter", ANY),
];

/// Relative humidity of the humid rural table \[%\]; the other one is dry.
const HUMID_TABLE_PERCENT: f64 = 70.0;

static DATA: LazyLock<Data> = LazyLock::new(|| {
    let rural = Table::read(
        "aerosol_rural.csv",
        include_str!("../data/aerosol_rural.csv"),
        &RURAL_COLUMNS,
        2,
    )
    .expect("the embedded rural table is valid");
    let rural_rows = |humid: bool| {
        let rural = &rural;
        (0..rural.line.len())
            .filter(move |&i| (rural.column(0)[i] > 0.5 * HUMID_TABLE_PERCENT) == humid)
            .map(move |i| core::array::from_fn(|c| rural.column(c + 1)[i]))
    };
    let stratosphere = Table::read(
        "aerosol_stratosphere.csv",
        include_str!("../data/aerosol_stratosphere.csv"),
        &RURAL_COLUMNS[1..],
        2,
    )
    .expect("the embedded stratospheric table is valid");
    let profile = Table::read(
        "aerosol_stratosphere_profile.csv",
        include_str!("../data/aerosol_stratosphere_profile.csv"),
        &[
            ColumnSpec::required("altitude_km", ANY),
            ColumnSpec::required("extinction_550nm_per_km", ANY),
        ],
        2,
    )
    .expect("the embedded stratospheric profile is valid");
    Data {
        rural_dry: Nodes::new(rural_rows(false)),
        rural_humid: Nodes::new(rural_rows(true)),
        stratosphere: Nodes::new(
            (0..stratosphere.line.len())
                .map(|i| core::array::from_fn(|c| stratosphere.column(c)[i])),
        ),
        profile_altitude_km: profile.column(0).to_vec(),
        profile_per_km: profile.column(1).to_vec(),
    }
});

/// Rural aerosol at 50 % relative humidity: dry and 70 % tables, each interpolated in wavelength,
/// then mixed 2 : 5.
#[must_use]
pub fn rural(wavelength_nm: f64) -> AerosolSpectrum {
    let humid_share = REFERENCE_HUMIDITY_PERCENT / HUMID_TABLE_PERCENT;
    let (dry, humid) = (
        DATA.rural_dry.at(wavelength_nm),
        DATA.rural_humid.at(wavelength_nm),
    );
    let mix = |a: f64, b: f64| (1.0 - humid_share) * a + humid_share * b;
    AerosolSpectrum {
        relative_extinction: mix(dry.relative_extinction, humid.relative_extinction),
        single_scattering_albedo: mix(dry.single_scattering_albedo, humid.single_scattering_albedo),
        asymmetry_parameter: mix(dry.asymmetry_parameter, humid.asymmetry_parameter),
    }
}

/// Background aerosol of the stratosphere; it absorbs nothing in the visible.
#[must_use]
pub fn stratosphere(wavelength_nm: f64) -> AerosolSpectrum {
    AerosolSpectrum {
        single_scattering_albedo: 1.0,
        ..DATA.stratosphere.at(wavelength_nm)
    }
}

/// Extinction of the stratospheric background at 550 nm \[km⁻¹\], linear between 1 km nodes.
#[must_use]
pub fn stratosphere_extinction_550_per_km(altitude_km: f64) -> f64 {
    interpolate(
        &DATA.profile_altitude_km,
        &DATA.profile_per_km,
        altitude_km.clamp(0.0, TOP_KM),
    )
}

/// Vertical optical depth of the stratospheric background at 550 nm above an altitude.
#[must_use]
pub fn stratosphere_optical_depth_550(altitude_km: f64) -> f64 {
    let (z, per_km) = (&DATA.profile_altitude_km, &DATA.profile_per_km);
    let mut depth = 0.0;
    for i in 1..z.len() {
        let low = z[i - 1].max(altitude_km);
        if low < z[i] {
            let at_low = interpolate(z, per_km, low);
            depth += 0.5 * (at_low + per_km[i]) * (z[i] - low);
        }
    }
    depth
}

/// Vertical shape of the haze \[km⁻¹\], exp(−z/H) normalized to 1 over 0–100 km.
#[must_use]
pub fn haze_shape_per_km(altitude_km: f64, scale_height_km: f64) -> f64 {
    (-altitude_km / scale_height_km).exp()
        / (scale_height_km * -(-TOP_KM / scale_height_km).exp_m1())
}

/// Share of the haze above an altitude.
#[must_use]
pub fn haze_share_above(altitude_km: f64, scale_height_km: f64) -> f64 {
    let low = altitude_km.min(TOP_KM) / scale_height_km;
    let top = TOP_KM / scale_height_km;
    // e^-low - e^-top, without cancellation.
    -(-low).exp() * (low - top).exp_m1() / -(-top).exp_m1()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reference_spectra() {
        // Rural, 50 %: values of the reference definition.
        for (nm, want) in [
            (400.0, 1.358_35),
            (450.0, 1.212_88),
            (500.0, 1.095_996_4),
            (550.0, 1.0),
            (600.0, 0.899_40),
            (700.0, 0.744_43),
        ] {
            assert!((rural(nm).relative_extinction - want).abs() < 6e-6, "{nm}");
        }
        assert!((rural(400.0).single_scattering_albedo - 0.9488).abs() < 6e-5);
        assert!((rural(700.0).single_scattering_albedo - 0.9350).abs() < 6e-5);
        assert!((rural(400.0).asymmetry_parameter - 0.675).abs() < 6e-4);
        assert!((stratosphere(500.0).relative_extinction - 1.111_941_1).abs() < 1e-7);
    }

    #[test]
    fn the_stratosphere_sums_to_its_published_depth() {
        assert!((stratosphere_optical_depth_550(0.0) - 0.007_442_26).abs() < 1e-8);
        assert!(stratosphere_optical_depth_550(100.0).abs() < 1e-15);
    }

    #[test]
    fn the_haze_integrates_to_one() {
        assert!((haze_share_above(0.0, 1.2) - 1.0).abs() < 1e-15);
        assert!(haze_share_above(100.0, 1.2).abs() < 1e-15);
        let step = 0.01;
        let sum: f64 = (0..10_000_u32)
            .map(|i| step * haze_shape_per_km((f64::from(i) + 0.5) * step, 1.2))
            .sum();
        assert!((sum - 1.0).abs() < 1e-5);
    }
}
