//! Closed forms: the direct beam with every gas, and the parametric sky.
//!
//! # Beam
//! Each constituent's transmittance is that of its own slant column. Slant columns are integrated
//! numerically along straight rays through the spherical profile (no refraction), at any altitude; they
//! replace the air-mass formulas of SMARTS 2.9, which hold at 0 km only. O₂ and water vapor use their
//! band forms on the whole path.
//!
//! # Sky
//! SMARTS2 and SPCTRL2 give irradiances, never a radiance by direction. Here the closed
//! forms of SPCTRL2 (Bird & Riordan 1986, J. Climate Appl. Meteor. 25, 87) give the Rayleigh, aerosol
//! and ground-reflected parts of the diffuse irradiance at the observer's altitude, from the columns
//! above it. The radiance of a direction is the single-scattering integral through the spherical shells,
//! one pattern for molecules and one for aerosol. Where a formula gives less light than single
//! scattering, its pattern is scaled down to it; where it gives more, the rest was scattered again, and
//! goes with the light from the ground into a third pattern, an isotropic source along the path. The
//! cosine integral of the sum over the upper hemisphere is the irradiance of the formulas. (Scaling
//! the patterns up instead makes a hazy zenith 1.5 times too bright and its horizon 3 times too dark.)
//! Below the geometric horizon the lit ground is seen through the air before it.
//!
//! Simplifications: the formulas know nothing of the sun near the horizon, so beyond a sun zenith angle
//! of 85° the scale factors keep their values for 85°, and twilight fades with the single-scattering
//! integral itself, that is with the Earth's shadow (edge softened by the sun's disc). The O₂ and water bands dim the whole sky by their
//! transmittance along the sun's path.

use crate::optics::{AerosolOptics, OpticsError, OpticsSettings, mean};
use crate::profile::{AtmosphereProfile, Gas, TOP_OF_ATMOSPHERE_KM};
use crate::quadrature::gauss_legendre;
use crate::radiance_map::RadianceMap;
use crate::solar::{SolarError, SolarSpectrum};
use crate::{aerosol, gases, ozone, rayleigh};
use core::f64::consts::PI;
use sky_core::direction::SkyDirection;
use sky_core::quantity::{Angle, EARTH_RADIUS_KM, Length};
use sky_core::sun::{SUN_RADIUS_DEG, segment};
use sky_science::phase;
use std::sync::LazyLock;
use thiserror::Error;

/// Constituents with a column of their own: air, ozone, NO₂, O₂ pairs, water, haze, stratospheric layer.
const SPECIES: usize = 7;
const AIR: usize = 0;
const OZONE: usize = 1;
const NO2: usize = 2;
const PAIRS: usize = 3;
const WATER: usize = 4;
const HAZE: usize = 5;
const LAYER: usize = 6;

/// What messages call the columns that may be given.
const OZONE_ATM_CM: &str = "ozone [atm-cm]";
const WATER_CM: &str = "water [cm]";

/// Sun zenith angle beyond which the scale factors of the sky are held \[deg\].
const HELD_SUN_ZENITH_DEG: f64 = 85.0;

/// Air mass of diffuse light (Bird & Riordan 1986).
const DIFFUSE_AIR_MASS: f64 = 1.8;

/// Columns along a straight path from an altitude to space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlantColumns {
    /// Air molecules \[m⁻²\].
    pub air_per_m2: f64,
    /// Ozone molecules \[m⁻²\].
    pub ozone_per_m2: f64,
    /// NO₂ molecules \[m⁻²\].
    pub no2_per_m2: f64,
    /// Square of the O₂ number density \[m⁻⁵\].
    pub oxygen_pairs_per_m5: f64,
    /// Water molecules \[m⁻²\].
    pub water_per_m2: f64,
    /// Haze, relative to its vertical column from the ground.
    pub haze: f64,
    /// Stratospheric aerosol, relative to its vertical column from the ground.
    pub stratospheric_aerosol: f64,
}

impl SlantColumns {
    const fn from_array(columns: [f64; SPECIES]) -> Self {
        Self {
            air_per_m2: columns[AIR],
            ozone_per_m2: columns[OZONE],
            no2_per_m2: columns[NO2],
            oxygen_pairs_per_m5: columns[PAIRS],
            water_per_m2: columns[WATER],
            haze: columns[HAZE],
            stratospheric_aerosol: columns[LAYER],
        }
    }

    const fn to_array(self) -> [f64; SPECIES] {
        [
            self.air_per_m2,
            self.ozone_per_m2,
            self.no2_per_m2,
            self.oxygen_pairs_per_m5,
            self.water_per_m2,
            self.haze,
            self.stratospheric_aerosol,
        ]
    }
}

/// Densities at an altitude, in the units of [`SlantColumns`] per kilometre.
fn densities_per_km(
    profile: &AtmosphereProfile,
    haze_scale_height_km: f64,
    altitude_km: f64,
) -> [f64; SPECIES] {
    let altitude = Length::from_km(altitude_km);
    let gas = |gas| 1e3 * profile.number_density_per_m3(gas, altitude);
    [
        gas(Gas::Air),
        gas(Gas::Ozone),
        gas(Gas::NitrogenDioxide),
        1e3 * profile.oxygen_pairs_per_m6(altitude),
        gas(Gas::WaterVapor),
        aerosol::haze_shape_per_km(altitude_km, haze_scale_height_km),
        aerosol::stratosphere_extinction_550_per_km(altitude_km)
            / aerosol::stratosphere_optical_depth_550(0.0),
    ]
}

fn vertical_array(
    profile: &AtmosphereProfile,
    haze_scale_height_km: f64,
    altitude_km: f64,
) -> [f64; SPECIES] {
    let altitude = Length::from_km(altitude_km);
    let gas = |gas| profile.column_above_per_m2(gas, altitude);
    [
        gas(Gas::Air),
        gas(Gas::Ozone),
        gas(Gas::NitrogenDioxide),
        profile.oxygen_pairs_above_per_m5(altitude),
        gas(Gas::WaterVapor),
        aerosol::haze_share_above(altitude_km, haze_scale_height_km),
        aerosol::stratosphere_optical_depth_550(altitude_km)
            / aerosol::stratosphere_optical_depth_550(0.0),
    ]
}

/// Columns straight up from an altitude.
#[must_use]
pub fn vertical_columns(
    profile: &AtmosphereProfile,
    haze_scale_height: Length,
    altitude: Length,
) -> SlantColumns {
    SlantColumns::from_array(vertical_array(
        profile,
        haze_scale_height.km(),
        altitude.km(),
    ))
}

/// Points of the Gauss–Legendre rule of one shell.
const GAUSS_POINTS: usize = 12;

/// Nodes and weights on 0–1.
static GAUSS: LazyLock<Vec<(f64, f64)>> = LazyLock::new(|| gauss_legendre(GAUSS_POINTS, 0.0, 1.0));

/// Columns along a straight ray from an altitude to space, or `None` if the ground is in the way.
///
/// Integrated shell by shell (1 km, split at the lowest point), 12 Gauss points each, with the square
/// of the coordinate near the lowest point.
#[must_use]
pub fn slant_columns(
    profile: &AtmosphereProfile,
    haze_scale_height: Length,
    altitude: Length,
    zenith: Angle,
) -> Option<SlantColumns> {
    let start_km = EARTH_RADIUS_KM + altitude.km();
    let (sin, cos) = zenith.radians().sin_cos();
    let lowest_km = start_km * sin;
    let mut columns = [0.0; SPECIES];
    let mut add = |low_km: f64, high_km: f64, times: f64| {
        // Boundaries at whole kilometres of altitude, where the profile has its kinks.
        let mut low = low_km;
        while low < high_km {
            let whole = (low - EARTH_RADIUS_KM + 1e-9).floor() + 1.0 + EARTH_RADIUS_KM;
            let high = whole.min(high_km);
            add_shell(
                profile,
                haze_scale_height.km(),
                lowest_km,
                [low, high],
                times,
                &mut columns,
            );
            low = high;
        }
    };
    let top_km = EARTH_RADIUS_KM + TOP_OF_ATMOSPHERE_KM;
    if cos < 0.0 {
        if lowest_km < EARTH_RADIUS_KM {
            return None;
        }
        add(lowest_km, start_km, 2.0);
    }
    add(start_km, top_km, 1.0);
    Some(SlantColumns::from_array(columns))
}

fn add_shell(
    profile: &AtmosphereProfile,
    haze_scale_height_km: f64,
    lowest_km: f64,
    shell_km: [f64; 2],
    times: f64,
    columns: &mut [f64; SPECIES],
) {
    // Distance from the lowest point of the ray, or of its continuation.
    let distance =
        |radius_km: f64| ((radius_km - lowest_km).max(0.0) * (radius_km + lowest_km)).sqrt();
    let (near, far) = (distance(shell_km[0]), distance(shell_km[1]));
    for &(node, weight) in GAUSS.iter() {
        let s = near + (far - near) * node * node;
        let length = 2.0 * node * weight * (far - near);
        // r - R, without the rounding of two large numbers' roots.
        let altitude_km = lowest_km.hypot(s) - EARTH_RADIUS_KM;
        let densities = densities_per_km(profile, haze_scale_height_km, altitude_km);
        for (column, density) in columns.iter_mut().zip(densities) {
            *column += times * length * density;
        }
    }
}

/// Columns above the observer that are known better than the profile says.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BeamOverrides {
    /// Ozone above the observer \[atm-cm\].
    pub ozone_atm_cm: Option<f64>,
    /// Precipitable water above the observer \[cm\].
    pub water_cm: Option<f64>,
    /// Pressure at the observer \[hPa\]; scales air, O₂ pairs and the bands.
    pub pressure_hpa: Option<f64>,
}

/// What the parametric engine refuses.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum SmartsError {
    /// The optics' settings are wrong.
    #[error(transparent)]
    Optics(#[from] OpticsError),
    /// The sun's spectrum does not cover the wavelengths.
    #[error(transparent)]
    Solar(#[from] SolarError),
    /// A value outside its bounds.
    #[error("{quantity}: expected {} to {}, found {found}", expected[0], expected[1])]
    OutOfRange {
        /// The quantity, with its unit.
        quantity: &'static str,
        /// The bounds.
        expected: [f64; 2],
        /// The value given.
        found: f64,
    },
    /// A column of a gas that the profile has none of above the observer, so that it has no shape.
    #[error(
        "{quantity}: expected 0 for a profile that has none above {altitude_km} km, found {found}"
    )]
    NoShape {
        /// The quantity, with its unit.
        quantity: &'static str,
        /// The observer's altitude \[km\].
        altitude_km: f64,
        /// The value given.
        found: f64,
    },
    /// A solar spectrum on other wavelengths than the optics.
    #[error("solar spectrum: expected {expected} wavelengths as in the optics, found {found}")]
    OtherWavelengths {
        /// Wavelengths of the optics.
        expected: usize,
        /// Wavelengths of the spectrum.
        found: usize,
    },
}

fn within(quantity: &'static str, found: f64, expected: [f64; 2]) -> Result<(), SmartsError> {
    // Degrees and kilometres were converted; a value on a bound must stay inside.
    let slack = 1e-9 * expected[1].abs().max(1.0);
    if found >= expected[0] - slack && found <= expected[1] + slack {
        Ok(())
    } else {
        Err(SmartsError::OutOfRange {
            quantity,
            expected,
            found,
        })
    }
}

/// Cross-sections and aerosol at one wavelength; switched-off constituents are 0.
#[derive(Clone, Debug)]
struct Spectral {
    rayleigh_m2: f64,
    ozone_m2: f64,
    no2_m2: f64,
    pairs_m5: f64,
    aerosol: AerosolOptics,
    /// O₂ and water band forms of the samples in the band.
    bands: Vec<(gases::BandForm, gases::BandForm)>,
}

impl Spectral {
    fn new(settings: &OpticsSettings, optical_depth_500: f64, wavelength_nm: f64) -> Self {
        let on = settings.constituents;
        let samples = settings.gas_samples_nm(wavelength_nm);
        let switch = |on: bool, value: f64| if on { value } else { 0.0 };
        let band = |on: bool, form: gases::BandForm| gases::BandForm {
            strength: switch(on, form.strength),
            ..form
        };
        Self {
            rayleigh_m2: switch(on.rayleigh, rayleigh::cross_section_m2(wavelength_nm)),
            ozone_m2: switch(on.ozone, ozone::cross_section_m2(wavelength_nm)),
            no2_m2: switch(on.no2, mean(samples.clone(), gases::no2_cross_section_m2)),
            pairs_m5: switch(
                on.o2o2,
                mean(samples.clone(), gases::oxygen_pair_coefficient_m5),
            ),
            aerosol: settings.aerosol_at(optical_depth_500, wavelength_nm),
            bands: samples
                .map(|nm| {
                    (
                        band(on.o2_band, gases::o2_band(nm)),
                        band(on.h2o_band, gases::water_band(nm)),
                    )
                })
                .collect(),
        }
    }

    /// Absorption by gases other than the bands.
    fn gas_depth(&self, columns: &[f64; SPECIES]) -> f64 {
        self.ozone_m2 * columns[OZONE] + self.no2_m2 * columns[NO2] + self.pairs_m5 * columns[PAIRS]
    }

    /// Extinction by everything but the bands.
    fn depth(&self, columns: &[f64; SPECIES]) -> f64 {
        self.gas_depth(columns)
            + self.rayleigh_m2 * columns[AIR]
            + self.aerosol.haze_depth * columns[HAZE]
            + self.aerosol.layer_depth * columns[LAYER]
    }

    /// Scattering and absorption by aerosol, and its asymmetry parameter.
    fn aerosol(&self, columns: &[f64; SPECIES]) -> ([f64; 2], f64) {
        let a = &self.aerosol;
        let [haze_g, haze_g2, haze_weight] = a.haze_phase;
        let g_haze = phase::two_term_moment(1, haze_g, haze_g2, haze_weight);
        let (haze, layer) = (a.haze_depth * columns[HAZE], a.layer_depth * columns[LAYER]);
        let (haze_s, layer_s) = (a.haze_albedo * haze, a.layer_albedo * layer);
        let scattering = haze_s + layer_s;
        let g = if scattering > 0.0 {
            (haze_s * g_haze + layer_s * a.layer_g) / scattering
        } else {
            g_haze
        };
        ([scattering, haze + layer - scattering], g)
    }

    /// Extinction per unit of each column.
    fn coefficients(&self) -> [f64; SPECIES] {
        [
            self.rayleigh_m2,
            self.ozone_m2,
            self.no2_m2,
            self.pairs_m5,
            0.0,
            self.aerosol.haze_depth,
            self.aerosol.layer_depth,
        ]
    }

    fn band_transmittance(&self, o2_path: f64, water_path_cm: f64) -> f64 {
        mean(self.bands.iter(), |(o2, water)| {
            o2.transmittance(o2_path) * water.transmittance(water_path_cm)
        })
    }
}

fn spectra(
    profile: &AtmosphereProfile,
    settings: &OpticsSettings,
) -> Result<Vec<Spectral>, OpticsError> {
    let optical_depth_500 = settings.optical_depth_500(profile)?;
    Ok(settings
        .wavelength_nm
        .iter()
        .map(|&nm| Spectral::new(settings, optical_depth_500, nm))
        .collect())
}

/// Paths of the O₂ and water band forms: masses relative to the vertical columns, and the observer's
/// pressure.
fn band_paths(
    slant: &[f64; SPECIES],
    vertical: &[f64; SPECIES],
    water_cm: f64,
    pressure_hpa: f64,
) -> [f64; 2] {
    let pressure = pressure_hpa / gases::STANDARD_PRESSURE_HPA;
    [
        slant[AIR] / vertical[AIR] * pressure.powf(gases::O2_PRESSURE_EXPONENT),
        slant[WATER] / vertical[WATER].max(f64::MIN_POSITIVE)
            * water_cm
            * pressure.powf(gases::WATER_PRESSURE_EXPONENT),
    ]
}

/// The direct beam of the sun at any altitude and sun zenith angle.
#[derive(Clone, Debug)]
pub struct DirectBeam {
    profile: AtmosphereProfile,
    haze_scale_height: Length,
    wavelength_nm: Vec<f64>,
    spectra: Vec<Spectral>,
    overrides: BeamOverrides,
}

impl DirectBeam {
    /// The beam through an atmosphere; switch the optional gases on in the settings
    /// ([`crate::optics::Constituents::ALL`]).
    ///
    /// # Errors
    /// Settings or overrides out of bounds, impossible haze.
    pub fn new(
        profile: &AtmosphereProfile,
        settings: &OpticsSettings,
        overrides: BeamOverrides,
    ) -> Result<Self, SmartsError> {
        for (quantity, found, expected) in [
            (OZONE_ATM_CM, overrides.ozone_atm_cm, [0.0, 2.0]),
            (WATER_CM, overrides.water_cm, [0.0, 20.0]),
            ("pressure [hPa]", overrides.pressure_hpa, [1.0, 1200.0]),
        ] {
            if let Some(found) = found {
                within(quantity, found, expected)?;
            }
        }
        Ok(Self {
            profile: profile.clone(),
            haze_scale_height: settings.aerosol_scale_height,
            wavelength_nm: settings.wavelength_nm.clone(),
            spectra: spectra(profile, settings)?,
            overrides,
        })
    }

    /// Wavelengths \[nm\].
    #[must_use]
    pub fn wavelength_nm(&self) -> &[f64] {
        &self.wavelength_nm
    }

    /// Transmittance from the sun to an altitude, per wavelength; 0 where the ground is in the way.
    /// The angle is the true one: refraction is left out.
    ///
    /// # Errors
    /// A column of ozone or water was given, and the profile has none above the altitude to scale.
    pub fn transmittance(
        &self,
        altitude: Length,
        sun_zenith: Angle,
    ) -> Result<Vec<f64>, SmartsError> {
        let slant = slant_columns(&self.profile, self.haze_scale_height, altitude, sun_zenith);
        let Some(slant) = slant.map(SlantColumns::to_array) else {
            return Ok(vec![0.0; self.spectra.len()]);
        };
        let vertical = vertical_array(&self.profile, self.haze_scale_height.km(), altitude.km());
        for (quantity, given, own) in [
            (OZONE_ATM_CM, self.overrides.ozone_atm_cm, vertical[OZONE]),
            (WATER_CM, self.overrides.water_cm, vertical[WATER]),
        ] {
            if let Some(found) = given.filter(|found| *found > 0.0 && own <= 0.0) {
                return Err(SmartsError::NoShape {
                    quantity,
                    altitude_km: altitude.km(),
                    found,
                });
            }
        }
        let own_pressure_hpa = self.profile.pressure_hpa(altitude);
        let pressure_hpa = self.overrides.pressure_hpa.unwrap_or(own_pressure_hpa);
        let own_water_cm = self.profile.water_column_cm(altitude);
        let water_cm = self.overrides.water_cm.unwrap_or(own_water_cm);
        let [o2_path, water_path] = band_paths(&slant, &vertical, water_cm, pressure_hpa);
        let mut columns = slant;
        let pressure_ratio = pressure_hpa / own_pressure_hpa;
        columns[AIR] *= pressure_ratio;
        columns[PAIRS] *= pressure_ratio * pressure_ratio;
        if let Some(atm_cm) = self.overrides.ozone_atm_cm {
            // of no ozone there is none on the slant path either
            columns[OZONE] *=
                atm_cm * ozone::MOLECULES_PER_M2_ATM_CM / vertical[OZONE].max(f64::MIN_POSITIVE);
        }
        Ok(self
            .spectra
            .iter()
            .map(|s| (-s.depth(&columns)).exp() * s.band_transmittance(o2_path, water_path))
            .collect())
    }

    /// Irradiance on a plane normal to the beam \[W·m⁻²·nm⁻¹\], without the light around the sun.
    ///
    /// # Errors
    /// A solar spectrum that is not on the beam's wavelengths; as [`Self::transmittance`].
    pub fn normal_irradiance(
        &self,
        altitude: Length,
        sun_zenith: Angle,
        sun: &SolarSpectrum,
    ) -> Result<Vec<f64>, SmartsError> {
        check_same_grid(&self.wavelength_nm, sun)?;
        let transmittance = self.transmittance(altitude, sun_zenith)?;
        let pairs = transmittance.iter().zip(&sun.irradiance_w_m2_nm);
        Ok(pairs.map(|(t, e)| t * e).collect())
    }
}

fn check_same_grid(wavelength_nm: &[f64], sun: &SolarSpectrum) -> Result<(), SmartsError> {
    let same = wavelength_nm.len() == sun.wavelength_nm.len()
        && wavelength_nm
            .iter()
            .zip(&sun.wavelength_nm)
            .all(|(a, b)| (a - b).abs() < 1e-6);
    if same {
        Ok(())
    } else {
        Err(SmartsError::OtherWavelengths {
            expected: wavelength_nm.len(),
            found: sun.wavelength_nm.len(),
        })
    }
}

/// Nodes of the sun's slant columns: altitudes × directions.
#[derive(Clone, Debug)]
struct SunTable {
    altitude_km: Vec<f64>,
    /// `altitude * SUN_ANGLES + angle`.
    columns: Vec<[f64; SPECIES]>,
}

/// Directions of the sun per altitude, from the local horizon up to the zenith.
const SUN_ANGLES: u16 = 64;

/// Altitudes of the shells \[km\]: 0.25 km to 6, 0.5 km to 20, 2 km to 100.
fn shell_altitudes_km() -> Vec<f64> {
    let fine = (0..24_u16).map(|i| f64::from(i) / 4.0);
    let middle = (12..40_u16).map(|i| f64::from(i) / 2.0);
    let coarse = (10..=50_u16).map(|i| 2.0 * f64::from(i));
    fine.chain(middle).chain(coarse).collect()
}

/// Cosine of the zenith angle of the geometric horizon.
fn horizon_cosine(radius_km: f64) -> f64 {
    -((radius_km - EARTH_RADIUS_KM).max(0.0) * (radius_km + EARTH_RADIUS_KM)).sqrt() / radius_km
}

impl SunTable {
    fn new(profile: &AtmosphereProfile, haze_scale_height_km: f64) -> Self {
        let altitude_km = shell_altitudes_km();
        let above: Vec<[f64; SPECIES]> = altitude_km
            .iter()
            .map(|&z| vertical_array(profile, haze_scale_height_km, z))
            .collect();
        let mut columns = Vec::with_capacity(altitude_km.len() * usize::from(SUN_ANGLES));
        for (k, &z) in altitude_km.iter().enumerate() {
            let radius_km = EARTH_RADIUS_KM + z;
            let lowest_cosine = horizon_cosine(radius_km);
            for j in 0..SUN_ANGLES {
                let x = f64::from(j) / f64::from(SUN_ANGLES - 1);
                let cosine = lowest_cosine + (1.0 - lowest_cosine) * x * x;
                let lowest_km = radius_km * (1.0 - cosine * cosine).max(0.0).sqrt();
                let mut sum = [0.0; SPECIES];
                for i in 0..altitude_km.len() - 1 {
                    let times = match (i >= k, cosine < 0.0) {
                        (true, _) => 1.0,
                        (false, true) => 2.0,
                        (false, false) => 0.0,
                    };
                    let bottom_km = EARTH_RADIUS_KM + altitude_km[i];
                    let top_km = EARTH_RADIUS_KM + altitude_km[i + 1];
                    if times <= 0.0 || top_km <= lowest_km {
                        continue;
                    }
                    // Distance from the lowest point of the ray.
                    let distance = |r: f64| ((r - lowest_km).max(0.0) * (r + lowest_km)).sqrt();
                    let stretch = (distance(top_km) - distance(bottom_km)) / (top_km - bottom_km);
                    for c in 0..SPECIES {
                        sum[c] += times * stretch * (above[i][c] - above[i + 1][c]);
                    }
                }
                columns.push(sum);
            }
        }
        Self {
            altitude_km,
            columns,
        }
    }

    /// Columns from an altitude towards the sun; the sun at or below the horizon counts as on it.
    fn at(&self, altitude_km: f64, sun_cosine: f64) -> [f64; SPECIES] {
        let z = &self.altitude_km;
        let k = z.partition_point(|&node| node <= altitude_km);
        let k = k.saturating_sub(1).min(z.len() - 2);
        let t = ((altitude_km - z[k]) / (z[k + 1] - z[k])).clamp(0.0, 1.0);
        let lowest_cosine = horizon_cosine(EARTH_RADIUS_KM + altitude_km.max(0.0));
        let square = ((sun_cosine - lowest_cosine) / (1.0 - lowest_cosine)).clamp(0.0, 1.0);
        let place = square.sqrt() * f64::from(SUN_ANGLES - 1);
        let (mut j, mut low) = (0_usize, 0.0);
        // Truncation without a cast: the table is short.
        while low + 1.0 <= place && j + 2 < usize::from(SUN_ANGLES) {
            j += 1;
            low += 1.0;
        }
        let u = place - low;
        let node = |k: usize, j: usize| &self.columns[k * usize::from(SUN_ANGLES) + j];
        let (a, b, c, d) = (
            node(k, j),
            node(k, j + 1),
            node(k + 1, j),
            node(k + 1, j + 1),
        );
        core::array::from_fn(|s| {
            (1.0 - t) * ((1.0 - u) * a[s] + u * b[s]) + t * ((1.0 - u) * c[s] + u * d[s])
        })
    }
}

/// Cells along a path of view, one way.
const CELLS: u16 = 20;

/// Directions of the hemisphere that the patterns are normalized over: zenith angles × azimuths.
const HEMISPHERE_ZENITHS: usize = 10;
const HEMISPHERE_AZIMUTHS: u16 = 12;

static HEMISPHERE_GAUSS: LazyLock<Vec<(f64, f64)>> =
    LazyLock::new(|| gauss_legendre(HEMISPHERE_ZENITHS, 0.0, 1.0));

/// The parametric sky over one atmosphere and ground.
#[derive(Clone, Debug)]
pub struct SmartsSky {
    profile: AtmosphereProfile,
    haze_scale_height_km: f64,
    rayleigh_depolarization: f64,
    ground_albedo: f64,
    wavelength_nm: Vec<f64>,
    sun: Vec<f64>,
    spectra: Vec<Spectral>,
    coefficients: Vec<[f64; SPECIES]>,
    /// Densities \[per km\] every 0.1 km.
    densities: Vec<[f64; SPECIES]>,
    sun_table: SunTable,
}

/// Step of the table of densities \[km⁻¹\].
const DENSITY_STEPS_PER_KM: f64 = 10.0;

/// Single scattering of a direction per unit of solar irradiance, by wavelength \[sr⁻¹\].
#[derive(Clone, Debug)]
struct Pattern {
    molecules: Vec<f64>,
    aerosol: Vec<f64>,
    /// Share of the isotropic source that the path scatters in, 0–1.
    isotropic: Vec<f64>,
    /// What is left of the light behind the path.
    transmittance: Vec<f64>,
    /// Where the path ends at the ground: cosine of the sun's zenith angle there.
    ground: Option<f64>,
}

/// Diffuse irradiance on the horizontal plane, per unit of solar irradiance.
#[derive(Clone, Copy, Debug, Default)]
struct Diffuse {
    molecules: f64,
    aerosol: f64,
    ground: f64,
}

/// Factors from pattern to radiance, by wavelength.
#[derive(Clone, Debug)]
struct Scales {
    molecules: Vec<f64>,
    aerosol: Vec<f64>,
    /// Radiance of the isotropic source.
    isotropic: Vec<f64>,
    /// Diffuse irradiance of the ground.
    ground_diffuse: Vec<f64>,
}

/// Diffuse reflectance and transmittance of a layer for diffuse light (SPCTRL2's sky reflectivity,
/// Bird & Riordan 1986, Eq. 3-11), from its scattering and absorption depths.
fn diffuse_layer(depth_rayleigh: f64, depth_aerosol: [f64; 2], gas: f64, g: f64) -> [f64; 2] {
    let m = DIFFUSE_AIR_MASS;
    let [scattering, absorption] = depth_aerosol;
    let rayleigh = (-m * depth_rayleigh).exp();
    let aerosol = (-m * scattering).exp();
    let absorbed = (-m * (gas + absorption)).exp();
    let forward = forward_share(1.0 / m, g);
    let reflectance = absorbed
        * (0.5 * (1.0 - rayleigh.powf(0.95)) + (1.0 - forward) * rayleigh * (1.0 - aerosol));
    [reflectance, (absorbed - reflectance).max(0.0)]
}

/// Share of the aerosol's scattered light that goes down (Bird & Riordan 1986, Eq. 3-7 to 3-10).
fn forward_share(cos_zenith: f64, g: f64) -> f64 {
    let log = (-g.min(0.99)).ln_1p();
    let a = log * (1.459 + log * (0.1595 + log * 0.4129));
    let b = log * (0.0783 + log * (-0.3824 - log * 0.5874));
    1.0 - 0.5 * ((a + b * cos_zenith) * cos_zenith).exp()
}

/// SPCTRL2's correction of the diffuse light at short wavelengths (Bird & Riordan 1986, Eq. 3-17).
fn short_wave_correction(wavelength_nm: f64) -> f64 {
    let um = 1e-3 * wavelength_nm;
    if um <= 0.45 {
        (um + 0.55).powf(1.8)
    } else {
        1.0
    }
}

/// Spacing of a grid, taken at its start; 1 nm for a single wavelength.
fn spacing_nm(wavelength_nm: &[f64]) -> f64 {
    match wavelength_nm {
        [first, second, ..] => (second - first).min(20.0),
        _ => 1.0,
    }
}

impl SmartsSky {
    /// The sky of an atmosphere over a Lambertian ground, lit by the sun of ASTM G173 averaged over
    /// the wavelengths' spacing.
    ///
    /// # Errors
    /// Settings out of bounds, impossible haze, a ground albedo outside 0–1, wavelengths whose bands
    /// the sun's spectrum (360–830 nm) does not reach.
    pub fn new(
        profile: &AtmosphereProfile,
        settings: &OpticsSettings,
        ground_albedo: f64,
    ) -> Result<Self, SmartsError> {
        within("ground albedo", ground_albedo, [0.0, 1.0])?;
        let spectra = spectra(profile, settings)?;
        let haze_scale_height_km = settings.aerosol_scale_height.km();
        let sun = SolarSpectrum::g173()
            .on_grid(&settings.wavelength_nm, spacing_nm(&settings.wavelength_nm))?;
        let steps = (0..=1000_u16).map(|i| f64::from(i) / DENSITY_STEPS_PER_KM);
        Ok(Self {
            haze_scale_height_km,
            rayleigh_depolarization: settings.rayleigh_depolarization,
            ground_albedo,
            wavelength_nm: settings.wavelength_nm.clone(),
            sun: sun.irradiance_w_m2_nm,
            coefficients: spectra.iter().map(Spectral::coefficients).collect(),
            spectra,
            densities: steps
                .map(|z| densities_per_km(profile, haze_scale_height_km, z))
                .collect(),
            sun_table: SunTable::new(profile, haze_scale_height_km),
            profile: profile.clone(),
        })
    }

    /// The same sky under another sun.
    ///
    /// # Errors
    /// A spectrum on other wavelengths than the optics.
    pub fn with_sun(mut self, sun: &SolarSpectrum) -> Result<Self, SmartsError> {
        check_same_grid(&self.wavelength_nm, sun)?;
        self.sun.clone_from(&sun.irradiance_w_m2_nm);
        Ok(self)
    }

    /// Diffuse irradiance on the horizontal plane at an altitude by the closed forms, for a sun at most
    /// 85° from the zenith \[W·m⁻²·nm⁻¹\]: what the radiances of the upper hemisphere add up to.
    ///
    /// # Errors
    /// An altitude outside 0–30 km, a sun zenith angle outside 0–85°.
    pub fn diffuse_irradiance(
        &self,
        altitude: Length,
        sun_zenith: Angle,
    ) -> Result<Vec<f64>, SmartsError> {
        within("observer altitude [km]", altitude.km(), [0.0, 30.0])?;
        let zenith_deg = sun_zenith.degrees();
        within("sun zenith [deg]", zenith_deg, [0.0, HELD_SUN_ZENITH_DEG])?;
        let diffuse = self.diffuse(altitude.km(), sun_zenith);
        let pairs = diffuse.iter().zip(&self.sun);
        Ok(pairs
            .map(|(d, e)| e * (d.molecules + d.aerosol + d.ground))
            .collect())
    }

    /// Spectral radiance \[W·m⁻²·sr⁻¹·nm⁻¹\] of the sky, and below the geometric horizon of the ground.
    ///
    /// # Errors
    /// An altitude outside 0–30 km, a sun zenith angle outside 0–96°.
    pub fn radiance(
        &self,
        observer_altitude: Length,
        sun_zenith: Angle,
        directions: &[SkyDirection],
    ) -> Result<RadianceMap, SmartsError> {
        let altitude_km = observer_altitude.km();
        within("observer altitude [km]", altitude_km, [0.0, 30.0])?;
        within("sun zenith [deg]", sun_zenith.degrees(), [0.0, 96.0])?;
        let scales = self.scales(altitude_km, sun_zenith);
        let count = self.wavelength_nm.len();
        let mut spectral_radiance = Vec::with_capacity(directions.len() * count);
        for &direction in directions {
            let pattern = self.pattern(altitude_km, sun_zenith, direction);
            let ground = self.ground_radiance(&pattern, &scales);
            for (w, ground) in ground.iter().enumerate() {
                let sky = scales.molecules[w] * pattern.molecules[w]
                    + scales.aerosol[w] * pattern.aerosol[w]
                    + scales.isotropic[w] * pattern.isotropic[w];
                spectral_radiance.push(self.sun[w] * (sky + ground * pattern.transmittance[w]));
            }
        }
        Ok(RadianceMap {
            directions: directions.to_vec(),
            wavelength_nm: self.wavelength_nm.clone(),
            spectral_radiance,
        })
    }

    /// Radiance of the lit ground at the end of a path, per unit of solar irradiance.
    fn ground_radiance(&self, pattern: &Pattern, scales: &Scales) -> Vec<f64> {
        let Some(sun_cosine) = pattern.ground else {
            return vec![0.0; self.wavelength_nm.len()];
        };
        let columns = self.sun_table.at(0.0, sun_cosine);
        self.spectra
            .iter()
            .zip(&scales.ground_diffuse)
            .map(|(spectral, diffuse)| {
                let direct = sun_cosine.max(0.0) * (-spectral.depth(&columns)).exp();
                self.ground_albedo / PI * (direct + diffuse)
            })
            .collect()
    }

    /// Irradiances by the closed forms, per unit of solar irradiance, for a sun at most 85° from the
    /// zenith.
    fn diffuse(&self, altitude_km: f64, sun_zenith: Angle) -> Vec<Diffuse> {
        let cosine = sun_zenith.radians().cos();
        let slant = self.sun_table.at(altitude_km, cosine);
        let height = self.haze_scale_height_km;
        let above = vertical_array(&self.profile, height, altitude_km);
        let total = vertical_array(&self.profile, height, 0.0);
        let altitude = Length::from_km(altitude_km);
        let [o2_path, water_path] = band_paths(
            &slant,
            &above,
            self.profile.water_column_cm(altitude),
            self.profile.pressure_hpa(altitude),
        );
        let below: [f64; SPECIES] = core::array::from_fn(|c| total[c] - above[c]);
        let air_share = above[AIR] / total[AIR];
        self.spectra
            .iter()
            .zip(&self.wavelength_nm)
            .map(|(s, &nm)| {
                let ([scattering, absorption], g) = s.aerosol(&slant);
                let rayleigh = (-s.rayleigh_m2 * slant[AIR]).exp();
                let absorbed = (-s.gas_depth(&slant) - absorption).exp()
                    * s.band_transmittance(o2_path, water_path);
                let scattered = (-scattering).exp();
                let short = short_wave_correction(nm).powf(air_share);
                let light = cosine * absorbed * short;
                // Eq. 3-7 times C_s, on the direct part too: Eq. 3-1 as NREL's program has it
                let direct = light * rayleigh * scattered;
                let molecules = 0.5 * light * (1.0 - rayleigh.powf(0.95));
                let aerosol_light =
                    light * rayleigh.powf(1.5) * (1.0 - scattered) * forward_share(cosine, g);
                let layer = |columns: &[f64; SPECIES]| {
                    let (depth, g) = s.aerosol(columns);
                    diffuse_layer(s.rayleigh_m2 * columns[AIR], depth, s.gas_depth(columns), g)
                };
                // Ground and the air below the observer as one reflector under the air above.
                let [sky, _] = layer(&above);
                let [air_below, through_below] = layer(&below);
                let albedo = self.ground_albedo;
                let reflector =
                    air_below + through_below * through_below * albedo / (1.0 - albedo * air_below);
                let global = direct + molecules + aerosol_light;
                Diffuse {
                    molecules,
                    aerosol: aerosol_light,
                    ground: global * sky * reflector / (1.0 - sky * reflector),
                }
            })
            .collect()
    }

    /// Scale factors, held beyond 85°.
    fn scales(&self, altitude_km: f64, sun_zenith: Angle) -> Scales {
        let held = Angle::from_degrees(sun_zenith.degrees().min(HELD_SUN_ZENITH_DEG));
        let diffuse = self.diffuse(altitude_km, held);
        let at_ground = self.diffuse(0.0, held);
        let reference = self.hemisphere(altitude_km, held);
        let fade = if sun_zenith.radians() > held.radians() {
            let now = self.hemisphere(altitude_km, sun_zenith);
            reference
                .iter()
                .zip(&now)
                .map(|(then, now)| (now[0] + now[1]) / (then[0] + then[1]).max(f64::MIN_POSITIVE))
                .collect()
        } else {
            vec![1.0; self.wavelength_nm.len()]
        };
        let ratio = |a: f64, b: f64| if b > 0.0 { a / b } else { 0.0 };
        // What the formulas have beyond single scattering was scattered again.
        let excess = |w: usize| {
            (diffuse[w].molecules - reference[w][0]).max(0.0)
                + (diffuse[w].aerosol - reference[w][1]).max(0.0)
        };
        let each = |f: &dyn Fn(usize) -> f64| (0..self.wavelength_nm.len()).map(f).collect();
        Scales {
            molecules: each(&|w| ratio(diffuse[w].molecules, reference[w][0]).min(1.0)),
            aerosol: each(&|w| ratio(diffuse[w].aerosol, reference[w][1]).min(1.0)),
            isotropic: each(&|w| fade[w] * ratio(diffuse[w].ground + excess(w), reference[w][2])),
            ground_diffuse: each(&|w| {
                let d = &at_ground[w];
                fade[w] * (d.molecules + d.aerosol + d.ground)
            }),
        }
    }

    /// Cosine integrals of the patterns over the upper hemisphere: molecules, aerosol, isotropic.
    fn hemisphere(&self, altitude_km: f64, sun_zenith: Angle) -> Vec<[f64; 3]> {
        let mut sums = vec![[0.0; 3]; self.wavelength_nm.len()];
        let azimuth_step = PI / f64::from(HEMISPHERE_AZIMUTHS);
        for &(node, weight) in HEMISPHERE_GAUSS.iter() {
            // ∫ cos θ sin θ dθ = ∫ ½ d(sin² θ).
            let view_zenith = Angle::from_radians(node.sqrt().asin());
            for spoke in 0..HEMISPHERE_AZIMUTHS {
                let direction = SkyDirection {
                    view_zenith,
                    relative_azimuth: Angle::from_radians(azimuth_step * (f64::from(spoke) + 0.5)),
                };
                let pattern = self.pattern(altitude_km, sun_zenith, direction);
                let share = 0.5 * weight * 2.0 * azimuth_step;
                for (w, sum) in sums.iter_mut().enumerate() {
                    sum[0] += share * pattern.molecules[w];
                    sum[1] += share * pattern.aerosol[w];
                    sum[2] += share * pattern.isotropic[w];
                }
            }
        }
        sums
    }

    fn densities_at(&self, altitude_km: f64) -> [f64; SPECIES] {
        let last = self.densities.len() - 2;
        let mut index = 0;
        // Truncation without a cast: binary search for the node below.
        let place = (altitude_km * DENSITY_STEPS_PER_KM).max(0.0);
        let mut bit = 512;
        let mut low = 0.0;
        let mut width = 512.0;
        while bit > 0 {
            if low + width <= place && index + bit <= last {
                index += bit;
                low += width;
            }
            bit /= 2;
            width *= 0.5;
        }
        let t = (place - low).min(1.0);
        let (a, b) = (&self.densities[index], &self.densities[index + 1]);
        core::array::from_fn(|c| a[c] + t * (b[c] - a[c]))
    }

    /// Single scattering along a path of view.
    fn pattern(&self, altitude_km: f64, sun_zenith: Angle, direction: SkyDirection) -> Pattern {
        let count = self.wavelength_nm.len();
        let start_km = EARTH_RADIUS_KM + altitude_km;
        let view_cosine = direction.view_zenith.radians().cos();
        let view_sine = direction.view_zenith.radians().sin();
        let sun_cosine = sun_zenith.radians().cos();
        let scattering_cosine = direction.scattering_angle(sun_zenith).radians().cos();
        let lowest_km = start_km * view_sine;
        // Distances along the ray; the lowest point of the ray may lie behind the observer.
        let distance = |r: f64| ((r - lowest_km).max(0.0) * (r + lowest_km)).sqrt();
        let to_lowest = -start_km * view_cosine;
        let to_top = to_lowest + distance(EARTH_RADIUS_KM + TOP_OF_ATMOSPHERE_KM);
        let hits_ground = view_cosine < horizon_cosine(start_km) - 1e-12;
        let mut path = Path {
            start_km,
            view_cosine,
            sun_cosine,
            scattering_cosine,
            at_km: 0.0,
            molecules_phase: phase::rayleigh(scattering_cosine, self.rayleigh_depolarization),
            aerosol_phase: self.aerosol_phase(scattering_cosine),
            pattern: Pattern {
                molecules: vec![0.0; count],
                aerosol: vec![0.0; count],
                isotropic: vec![0.0; count],
                transmittance: vec![1.0; count],
                ground: None,
            },
        };
        // Cells crowd where the air is dense: at the observer, the lowest point or the ground.
        if hits_ground {
            let to_ground = to_lowest - distance(EARTH_RADIUS_KM);
            self.march(&mut path, to_ground, |x| 1.0 - (1.0 - x).powi(2));
            let radius = EARTH_RADIUS_KM;
            path.pattern.ground =
                Some((start_km * sun_cosine + to_ground * scattering_cosine) / radius);
        } else {
            if view_cosine < 0.0 {
                self.march(&mut path, to_lowest, |x| 1.0 - (1.0 - x).powi(2));
            }
            self.march(&mut path, to_top, |x| x.powi(3));
        }
        path.pattern
    }

    fn march(&self, path: &mut Path, to_km: f64, spacing: impl Fn(f64) -> f64) {
        let from_km = path.at_km;
        for cell in 1..=CELLS {
            let near_km = path.at_km;
            path.at_km = from_km + (to_km - from_km) * spacing(f64::from(cell) / f64::from(CELLS));
            let (middle_km, length_km) = (0.5 * (near_km + path.at_km), path.at_km - near_km);
            let square = path.start_km * path.start_km
                + middle_km * (middle_km + 2.0 * path.start_km * path.view_cosine);
            let radius_km = square.max(EARTH_RADIUS_KM * EARTH_RADIUS_KM).sqrt();
            let altitude_km = radius_km - EARTH_RADIUS_KM;
            let densities = self.densities_at(altitude_km);
            let here: [f64; SPECIES] = core::array::from_fn(|c| length_km * densities[c]);
            let sun_cosine =
                (path.start_km * path.sun_cosine + middle_km * path.scattering_cosine) / radius_km;
            self.scatter(path, altitude_km, sun_cosine, &here);
        }
    }

    /// Phase functions of haze and layer, albedo and depth per unit column included.
    fn aerosol_phase(&self, scattering_cosine: f64) -> Vec<[f64; 2]> {
        self.spectra
            .iter()
            .map(|s| {
                let a = &s.aerosol;
                if a.haze_depth + a.layer_depth <= 0.0 {
                    return [0.0; 2];
                }
                let [g, g2, weight] = a.haze_phase;
                [
                    a.haze_albedo
                        * a.haze_depth
                        * phase::two_term(scattering_cosine, g, g2, weight),
                    a.layer_albedo
                        * a.layer_depth
                        * phase::henyey_greenstein(scattering_cosine, a.layer_g),
                ]
            })
            .collect()
    }

    fn scatter(&self, path: &mut Path, altitude_km: f64, sun_cosine: f64, here: &[f64; SPECIES]) {
        let lit = sun_visible(EARTH_RADIUS_KM + altitude_km, sun_cosine);
        let sun_columns = if lit > 0.0 {
            self.sun_table.at(altitude_km, sun_cosine)
        } else {
            [0.0; SPECIES]
        };
        for (w, (spectral, coefficients)) in self.spectra.iter().zip(&self.coefficients).enumerate()
        {
            let dot = |columns: &[f64; SPECIES]| -> f64 {
                let mut sum = 0.0;
                for c in 0..SPECIES {
                    sum += coefficients[c] * columns[c];
                }
                sum
            };
            let a = &spectral.aerosol;
            let depth = dot(here);
            let near = path.pattern.transmittance[w];
            let far = near * (-depth).exp();
            path.pattern.transmittance[w] = far;
            // Mean transmittance over the cell times its depth is near − far.
            let mean = if depth > 1e-9 {
                (near - far) / depth
            } else {
                near
            };
            let molecules = spectral.rayleigh_m2 * here[AIR];
            let haze = a.haze_albedo * a.haze_depth * here[HAZE];
            let layer = a.layer_albedo * a.layer_depth * here[LAYER];
            path.pattern.isotropic[w] += mean * (molecules + haze + layer);
            if lit > 0.0 {
                let sunlight = lit * mean * (-dot(&sun_columns)).exp();
                let [haze_phase, layer_phase] = path.aerosol_phase[w];
                path.pattern.molecules[w] += sunlight * molecules * path.molecules_phase;
                path.pattern.aerosol[w] +=
                    sunlight * (haze_phase * here[HAZE] + layer_phase * here[LAYER]);
            }
        }
    }
}

/// A path of view while it is walked.
#[derive(Debug)]
struct Path {
    start_km: f64,
    view_cosine: f64,
    sun_cosine: f64,
    scattering_cosine: f64,
    at_km: f64,
    /// Scattering towards the observer \[sr⁻¹\]: molecules; haze and layer by wavelength.
    molecules_phase: f64,
    aerosol_phase: Vec<[f64; 2]>,
    pattern: Pattern,
}

/// Share of the light of the sun's disc above the geometric horizon of a point.
fn sun_visible(radius_km: f64, sun_cosine: f64) -> f64 {
    let horizon = Angle::from_radians(horizon_cosine(radius_km).acos());
    let sun = Angle::from_radians(sun_cosine.clamp(-1.0, 1.0).acos());
    let above_deg = horizon.degrees() - sun.degrees();
    let (share, _) = segment(above_deg / SUN_RADIUS_DEG);
    share
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::{Constituents, OpticalProfile};
    use sky_core::direction::horizon_zenith;
    use sky_core::haze::Haze;

    type Outcome = Result<(), Box<dyn core::error::Error>>;

    fn settings(optical_depth_500: f64) -> OpticsSettings {
        OpticsSettings {
            wavelength_nm: vec![450.0, 550.0, 650.0],
            haze: Haze::OpticalDepth500(optical_depth_500),
            ..OpticsSettings::default()
        }
    }

    #[test]
    fn the_gauss_rule_integrates_polynomials() {
        let rule = gauss_legendre(12, 0.0, 1.0);
        for power in 0..24_i32 {
            let sum: f64 = rule.iter().map(|(x, w)| w * x.powi(power)).sum();
            assert!(
                (sum * f64::from(power + 1) - 1.0).abs() < 1e-13,
                "x^{power}"
            );
        }
    }

    #[test]
    fn a_beam_from_the_zenith_obeys_beers_law() -> Outcome {
        let profile = AtmosphereProfile::general();
        let settings = settings(0.3);
        let beam = DirectBeam::new(&profile, &settings, BeamOverrides::default())?;
        let optics = OpticalProfile::build(&profile, &settings)?;
        for km in [0.0, 0.7, 6.0, 12.0, 30.0] {
            let altitude = Length::from_km(km);
            let depth = optics.vertical_optical_depth(altitude);
            let found = beam.transmittance(altitude, Angle::ZERO)?;
            for (t, depth) in found.iter().zip(depth) {
                assert!((t / (-depth).exp() - 1.0).abs() < 1e-5, "{km} km");
            }
        }
        Ok(())
    }

    #[test]
    fn overrides_scale_the_columns_and_bad_ones_are_refused() -> Outcome {
        let profile = AtmosphereProfile::general();
        let mut settings = settings(0.0);
        settings.constituents = Constituents::ALL;
        let beam = |overrides| DirectBeam::new(&profile, &settings, overrides);
        let at = |overrides| -> Result<Vec<f64>, SmartsError> {
            beam(overrides)?.transmittance(Length::ZERO, Angle::ZERO)
        };
        let with_ozone = |atm_cm| {
            at(BeamOverrides {
                ozone_atm_cm: Some(atm_cm),
                ..BeamOverrides::default()
            })
        };
        let depth = (with_ozone(0.1)?[1] / with_ozone(0.4)?[1]).ln();
        let want = 0.3 * ozone::MOLECULES_PER_M2_ATM_CM * ozone::cross_section_m2(550.0);
        assert!((depth / want - 1.0).abs() < 1e-9);
        let own = at(BeamOverrides::default())?;
        let same = at(BeamOverrides {
            ozone_atm_cm: Some(profile.row(Length::ZERO).ozone_column_atm_cm),
            water_cm: Some(profile.water_column_cm(Length::ZERO)),
            pressure_hpa: Some(1013.25),
        })?;
        for (a, b) in own.iter().zip(same) {
            assert!((a / b - 1.0).abs() < 1e-12);
        }
        let bad = BeamOverrides {
            water_cm: Some(-1.0),
            ..BeamOverrides::default()
        };
        assert!(matches!(beam(bad), Err(SmartsError::OutOfRange { .. })));
        Ok(())
    }

    #[test]
    fn the_ground_stops_the_beam_and_altitude_sees_past_the_horizontal() -> Outcome {
        let beam = DirectBeam::new(
            &AtmosphereProfile::general(),
            &settings(0.1),
            BeamOverrides::default(),
        )?;
        let below = Angle::from_degrees(92.0);
        assert!(
            beam.transmittance(Length::ZERO, below)?
                .iter()
                .all(|t| t.abs() < 1e-300)
        );
        assert!(beam.transmittance(Length::from_km(12.0), below)?[2] > 0.01);
        Ok(())
    }

    #[test]
    fn single_scattering_matches_an_independent_solution() -> Outcome {
        // No aerosol, black ground, sun 45°, zenith: 0.01506, 0.00738, 0.00401 per sr at 450, 550,
        // 650 nm, from a separate spherical successive-orders solver.
        let sky = SmartsSky::new(&AtmosphereProfile::general(), &settings(0.0), 0.0)?;
        let zenith = SkyDirection::from_degrees(0.0, 0.0);
        let pattern = sky.pattern(0.0, Angle::from_degrees(45.0), zenith);
        for (found, want) in pattern.molecules.iter().zip([0.01506, 0.00738, 0.00401]) {
            assert!((found / want - 1.0).abs() < 0.01, "{found} {want}");
        }
        Ok(())
    }

    #[test]
    fn radiances_add_up_to_the_irradiance_of_the_formulas() -> Outcome {
        for (haze, km, sun_deg) in [
            (0.0, 0.0, 30.0),
            (0.3, 0.0, 60.0),
            (1.0, 0.0, 80.0),
            (0.3, 3.0, 0.0),
            (0.5, 12.0, 75.0),
        ] {
            let sky = SmartsSky::new(&AtmosphereProfile::general(), &settings(haze), 0.2)?;
            let (altitude, sun) = (Length::from_km(km), Angle::from_degrees(sun_deg));
            let want = sky.diffuse_irradiance(altitude, sun)?;
            // A rule of its own: midpoints in both angles, 1° × 3°.
            let cells = (0..90_u8).flat_map(|ring| (0..60_u8).map(move |spoke| (ring, spoke)));
            let directions: Vec<SkyDirection> = cells
                .map(|(ring, spoke)| (f64::from(ring) + 0.5, 3.0 * f64::from(spoke) + 1.5))
                .map(|(zenith_deg, azimuth_deg)| {
                    SkyDirection::from_degrees(zenith_deg, azimuth_deg)
                })
                .collect();
            let map = sky.radiance(altitude, sun, &directions)?;
            let cell =
                2.0 * Angle::from_degrees(3.0).radians() * Angle::from_degrees(1.0).radians();
            let mut sums = vec![0.0; want.len()];
            let radiances = map.spectral_radiance.chunks(want.len());
            for (direction, radiances) in directions.iter().zip(radiances) {
                let (sin, cos) = direction.view_zenith.radians().sin_cos();
                for (sum, l) in sums.iter_mut().zip(radiances) {
                    *sum += cell * sin * cos * l;
                }
            }
            for (sum, want) in sums.iter().zip(want) {
                assert!(
                    (sum / want - 1.0).abs() < 0.015,
                    "{haze} {km} {sun_deg}: {sum} {want}"
                );
            }
        }
        Ok(())
    }

    #[test]
    fn radiance_is_finite_and_never_negative_and_twilight_fades() -> Outcome {
        for haze in [0.0, 0.3, 1.0] {
            let sky = SmartsSky::new(&AtmosphereProfile::general(), &settings(haze), 0.2)?;
            for km in [0.0, 0.1, 6.0, 12.0, 30.0] {
                let altitude = Length::from_km(km);
                let horizon_deg = horizon_zenith(altitude).degrees();
                let mut directions = Vec::new();
                for azimuth_deg in [0.0, 45.0, 180.0] {
                    for zenith_deg in [0.0, 45.0, 85.0, 89.9, 90.0, 120.0, 180.0] {
                        directions.push(SkyDirection::from_degrees(zenith_deg, azimuth_deg));
                    }
                    directions.push(SkyDirection::from_degrees(horizon_deg, azimuth_deg));
                    directions.push(SkyDirection::from_degrees(horizon_deg - 0.05, azimuth_deg));
                }
                let mut before = f64::INFINITY;
                for sun_deg in [0.0, 45.0, 84.9, 85.1, 90.0, 92.0, 94.0, 96.0] {
                    let sun = Angle::from_degrees(sun_deg);
                    let map = sky.radiance(altitude, sun, &directions)?;
                    let fine = |l: &f64| l.is_finite() && *l >= 0.0;
                    assert!(
                        map.spectral_radiance.iter().all(fine),
                        "{haze} {km} {sun_deg}"
                    );
                    let zenith = map.spectral_radiance[1];
                    if sun_deg > 80.0 {
                        assert!(zenith < before, "{haze} {km} {sun_deg}");
                        before = zenith;
                    }
                    assert!(zenith > 0.0);
                }
            }
        }
        Ok(())
    }

    #[test]
    fn the_engine_knows_its_domain() -> Outcome {
        let profile = AtmosphereProfile::general();
        let sky = SmartsSky::new(&profile, &settings(0.1), 0.2)?;
        let refused = |km, deg| {
            let found = sky.radiance(Length::from_km(km), Angle::from_degrees(deg), &[]);
            matches!(found, Err(SmartsError::OutOfRange { .. }))
        };
        assert!(refused(-0.1, 45.0) && refused(30.1, 45.0) && refused(0.0, 96.1));
        assert!(refused(f64::NAN, 45.0));
        assert!(SmartsSky::new(&profile, &settings(0.1), 1.2).is_err());
        let other = SolarSpectrum::g173();
        assert!(matches!(
            sky.with_sun(&other),
            Err(SmartsError::OtherWavelengths { .. })
        ));
        Ok(())
    }
}
