//! The optical profile: what each constituent scatters and absorbs, per level and wavelength.
//!
//! Levels stand every 0.1 km to 20 km, every 0.25 km to 40 km and every 1 km to 100 km, and
//! coefficients are linear between them. Level values are the local coefficients, corrected at fourth
//! order so that the linear pieces add up to the exact vertical optical depth of the profile.

use crate::profile::{AtmosphereProfile, Gas};
use crate::table::{ColumnSpec, Table, TableError};
use crate::{aerosol, gases, ozone, rayleigh};
use serde::{Deserialize, Serialize};
use sky_core::haze::{Haze, HazeError, KOSCHMIEDER_2_PERCENT};
use sky_core::quantity::Length;
use thiserror::Error;

/// Shortest wavelength of the sky's spectra \[nm\].
pub const SHORTEST_WAVELENGTH_NM: f64 = 380.0;

/// Longest wavelength of the sky's spectra \[nm\].
pub const LONGEST_WAVELENGTH_NM: f64 = 780.0;

/// Steps of the wavelength grid that are offered \[nm\].
pub const WAVELENGTH_STEPS_NM: [u16; 4] = [1, 5, 10, 20];

/// Air mass at which a band form is turned into a volume absorption.
pub const BAND_REFERENCE_AIR_MASS: f64 = 2.0;

/// Lowest ground that optics are continued to \[km\]: the shore of the Dead Sea lies at −0.43 km.
pub const LOWEST_GROUND_KM: f64 = -0.5;

/// Thickness of the layers below 0 km \[km\].
const LOW_LAYER_KM: f64 = 0.1;

/// Variance of a mixture of phase functions below which it is a single Henyey–Greenstein function.
const DEGENERATE_VARIANCE: f64 = 1e-10;

/// Which constituents take part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Constituents {
    /// Molecular scattering.
    pub rayleigh: bool,
    /// Ozone, Chappuis bands.
    pub ozone: bool,
    /// NO₂.
    pub no2: bool,
    /// O₂–O₂ pairs.
    pub o2o2: bool,
    /// O₂ bands (A, B, γ).
    pub o2_band: bool,
    /// Water-vapor bands.
    pub h2o_band: bool,
    /// Aerosol.
    pub aerosol: bool,
    /// The stratospheric share of the aerosol; without it all aerosol is haze near the ground.
    pub stratospheric_aerosol: bool,
}

impl Constituents {
    /// The reference atmosphere: molecules, ozone, aerosol.
    pub const REFERENCE: Self = Self {
        rayleigh: true,
        ozone: true,
        no2: false,
        o2o2: false,
        o2_band: false,
        h2o_band: false,
        aerosol: true,
        stratospheric_aerosol: true,
    };

    /// Everything.
    pub const ALL: Self = Self {
        no2: true,
        o2o2: true,
        o2_band: true,
        h2o_band: true,
        ..Self::REFERENCE
    };
}

/// What to build from a profile.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OpticsSettings {
    /// Wavelengths \[nm\], ascending, 360–830.
    pub wavelength_nm: Vec<f64>,
    /// Width over which NO₂, O₂–O₂ and the band forms are averaged around each wavelength \[nm\];
    /// 0 takes them at the wavelength. The smooth constituents are always taken at the wavelength.
    pub gas_band_width_nm: f64,
    /// Which constituents take part.
    pub constituents: Constituents,
    /// Amount of aerosol.
    pub haze: Haze,
    /// Ångström exponent of all aerosol; `None` is the one of [`Haze::Angstrom`] where that was
    /// given, else the spectra of Shettle & Fenn (rural at 50 % relative humidity; stratosphere).
    pub angstrom_exponent: Option<f64>,
    /// Single-scattering albedo of the haze; `None` is Shettle & Fenn's rural.
    pub single_scattering_albedo: Option<f64>,
    /// Asymmetry parameter of the haze as a single Henyey–Greenstein function; `None` is the
    /// two-term fit to Shettle & Fenn's rural phase function.
    pub asymmetry_parameter: Option<f64>,
    /// Scale height of the haze; 1.2 km.
    pub aerosol_scale_height: Length,
    /// Depolarization of the Rayleigh phase function, one value for all wavelengths; 0.0283 is
    /// Bodhaine's at 550 nm. The scattering coefficient keeps its own King factor.
    pub rayleigh_depolarization: f64,
}

impl Default for OpticsSettings {
    /// The reference atmosphere in 10 nm steps, with the aerosol of a clean day (0.1 at 500 nm).
    fn default() -> Self {
        Self {
            wavelength_nm: grid_nm(10),
            gas_band_width_nm: 0.0,
            constituents: Constituents::REFERENCE,
            haze: Haze::OpticalDepth500(0.1),
            angstrom_exponent: None,
            single_scattering_albedo: None,
            asymmetry_parameter: None,
            aerosol_scale_height: Length::from_km(1.2),
            rayleigh_depolarization: 0.0283,
        }
    }
}

const PER_KM: [f64; 2] = [0.0, 1e3];
/// At |g| = 1 all light goes on in one direction: no phase function, and NaN there.
const G: [f64; 2] = [-0.999, 0.999];
const COLUMNS: [ColumnSpec; 9] = [
    ColumnSpec::required("altitude_km", [0.0, 1000.0]),
    ColumnSpec::required("wavelength_nm", [200.0, 4000.0]),
    ColumnSpec::required("rayleigh_scattering_per_km", PER_KM),
    ColumnSpec::required("gas_absorption_per_km", PER_KM),
    ColumnSpec::required("aerosol_scattering_per_km", PER_KM),
    ColumnSpec::required("aerosol_absorption_per_km", PER_KM),
    ColumnSpec::required("aerosol_g", G),
    ColumnSpec::optional("aerosol_g2", G),
    ColumnSpec::optional("aerosol_g_weight", [0.0, 1.0]),
];
const G2: usize = 7;
const G_WEIGHT: usize = 8;

fn grid_nm(step_nm: u16) -> Vec<f64> {
    (380..=780_u16)
        .step_by(usize::from(step_nm))
        .map(f64::from)
        .collect()
}

/// What optics can get wrong.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum OpticsError {
    /// The table itself is wrong.
    #[error(transparent)]
    Table(#[from] TableError),
    /// The haze cannot be.
    #[error(transparent)]
    Haze(#[from] HazeError),
    /// A visual range without the aerosol that makes it.
    #[error("visual range: expected the constituent aerosol, found it switched off")]
    VisualRangeWithoutAerosol,
    /// A setting outside its bounds.
    #[error("{setting}: expected {} to {}, found {found}", expected[0], expected[1])]
    Setting {
        /// The setting, with its unit.
        setting: &'static str,
        /// The bounds.
        expected: [f64; 2],
        /// The value given.
        found: f64,
    },
    /// A wavelength step that is not offered.
    #[error("wavelength step [nm]: expected one of {WAVELENGTH_STEPS_NM:?}, found {found}")]
    WavelengthStep {
        /// The step given \[nm\].
        found: u16,
    },
    /// Wavelengths that do not ascend, or none.
    #[error("wavelengths [nm]: expected at least one, ascending; found {found:?} at place {place}")]
    Wavelengths {
        /// Place in the list.
        place: usize,
        /// The value there, if any.
        found: Option<f64>,
    },
    /// Two rows for the same altitude and wavelength.
    #[error(
        "{file}:{line}: column wavelength_nm: expected each wavelength once at {altitude_km} km, found {found} again"
    )]
    Duplicate {
        /// Name of the file.
        file: String,
        /// Line of the second row.
        line: u64,
        /// Its altitude \[km\].
        altitude_km: f64,
        /// Its wavelength \[nm\].
        found: f64,
    },
    /// A pair of altitude and wavelength without a row.
    #[error(
        "{file}:{line}: column wavelength_nm: expected a row for every altitude and wavelength, found none at {altitude_km} km, {wavelength_nm} nm"
    )]
    Hole {
        /// Name of the file.
        file: String,
        /// Last line of the file.
        line: u64,
        /// Altitude of the missing row \[km\].
        altitude_km: f64,
        /// Wavelength of the missing row \[nm\].
        wavelength_nm: f64,
    },
    /// The levels do not start at the ground.
    #[error("{file}:{line}: column altitude_km: expected the lowest level at 0, found {found}")]
    NoGround {
        /// Name of the file.
        file: String,
        /// Line of the lowest level.
        line: u64,
        /// Its altitude \[km\].
        found: f64,
    },
    /// An observer above the last level.
    #[error(
        "observer altitude [km]: expected at most {top_km}, where the optics end, found {found}"
    )]
    ObserverAbove {
        /// The last level \[km\].
        top_km: f64,
        /// The observer's altitude \[km\].
        found: f64,
    },
    /// Fewer than two levels.
    #[error("{file}:{line}: column altitude_km: expected at least two levels, found one")]
    OneLevel {
        /// Name of the file.
        file: String,
        /// Last line of the file.
        line: u64,
    },
    /// A second phase-function column without its companion.
    #[error("{file}:{line}: column {column}: expected together with {companion}, found alone")]
    LoneColumn {
        /// Name of the file.
        file: String,
        /// Line of the header.
        line: u64,
        /// The column found.
        column: &'static str,
        /// The column missing.
        companion: &'static str,
    },
}

impl OpticsSettings {
    /// The default on another wavelength step (1, 5, 10 or 20 nm), gases averaged over the step.
    ///
    /// # Errors
    /// A step that is not offered.
    pub fn with_step_nm(step_nm: u16) -> Result<Self, OpticsError> {
        if !WAVELENGTH_STEPS_NM.contains(&step_nm) {
            return Err(OpticsError::WavelengthStep { found: step_nm });
        }
        Ok(Self {
            wavelength_nm: grid_nm(step_nm),
            gas_band_width_nm: f64::from(step_nm),
            ..Self::default()
        })
    }

    /// Ångström exponent in force, if any.
    #[must_use]
    pub fn effective_angstrom_exponent(&self) -> Option<f64> {
        self.angstrom_exponent
            .or_else(|| self.haze.angstrom_exponent())
    }

    /// Checks every setting.
    ///
    /// # Errors
    /// The first setting that is out of bounds.
    pub fn check(&self) -> Result<(), OpticsError> {
        let within = |setting, found: f64, expected: [f64; 2]| {
            if found >= expected[0] && found <= expected[1] {
                Ok(())
            } else {
                Err(OpticsError::Setting {
                    setting,
                    expected,
                    found,
                })
            }
        };
        if self.wavelength_nm.is_empty() {
            return Err(OpticsError::Wavelengths {
                place: 0,
                found: None,
            });
        }
        for (place, pair) in self.wavelength_nm.windows(2).enumerate() {
            // NaN does not ascend either.
            if pair[0].partial_cmp(&pair[1]) != Some(core::cmp::Ordering::Less) {
                return Err(OpticsError::Wavelengths {
                    place: place + 1,
                    found: Some(pair[1]),
                });
            }
        }
        for &nm in &self.wavelength_nm {
            within("wavelength [nm]", nm, [360.0, 830.0])?;
        }
        within("gas band width [nm]", self.gas_band_width_nm, [0.0, 50.0])?;
        let exponent = self.effective_angstrom_exponent().unwrap_or(0.0);
        within("Angstrom exponent", exponent, [-1.0, 4.0])?;
        let albedo = self.single_scattering_albedo.unwrap_or(1.0);
        within("single-scattering albedo", albedo, [0.0, 1.0])?;
        let g = self.asymmetry_parameter.unwrap_or(0.0);
        within("asymmetry parameter", g, [-0.99, 0.99])?;
        let height_km = self.aerosol_scale_height.km();
        within("aerosol scale height [km]", height_km, [0.1, 20.0])?;
        let depolarization = self.rayleigh_depolarization;
        within("Rayleigh depolarization", depolarization, [0.0, 0.5])?;
        Ok(())
    }

    /// Vertical optical depth of all aerosol at 500 nm over an atmosphere.
    ///
    /// A visual range V \[km\] is taken at its word: the extinction at 550 nm of everything at the
    /// profile's ground is 3.912/V (Koschmieder, 2 % contrast), whatever the scale height of the haze
    /// and the share of the stratosphere.
    ///
    /// # Errors
    /// Settings out of bounds, impossible haze, a visual range that this air does not allow or that no
    /// aerosol is there for.
    pub fn optical_depth_500(&self, profile: &AtmosphereProfile) -> Result<f64, OpticsError> {
        self.check()?;
        let Haze::VisualRange(range) = self.haze else {
            return Ok(self.haze.optical_depth_500()?);
        };
        let found = range.km();
        if !found.is_finite() {
            return Err(HazeError::NotFinite {
                quantity: "visual range [km]",
                found,
            }
            .into());
        }
        if !self.constituents.aerosol {
            return Err(OpticsError::VisualRangeWithoutAerosol);
        }
        // extinction is linear in the haze, and the first share of all aerosol is no haze
        let least = self.stratospheric_optical_depth_500();
        let clear = self.ground_extinction_550_per_km(profile, least)?;
        let per_depth = self.ground_extinction_550_per_km(profile, least + 1.0)? - clear;
        let clean_air_km = KOSCHMIEDER_2_PERCENT / clear;
        // a range that was read off clean air must not fail by its last digit
        if found <= 0.0 || found > clean_air_km * (1.0 + 1e-9) {
            return Err(HazeError::VisualRange {
                found,
                clean_air_km,
            }
            .into());
        }
        Ok(least + (KOSCHMIEDER_2_PERCENT / found - clear).max(0.0) / per_depth)
    }

    /// Extinction of everything at the ground at 550 nm \[km⁻¹\].
    fn ground_extinction_550_per_km(
        &self,
        profile: &AtmosphereProfile,
        optical_depth_500: f64,
    ) -> Result<f64, OpticsError> {
        let settings = Self {
            wavelength_nm: vec![550.0],
            haze: Haze::OpticalDepth500(optical_depth_500),
            // the exponent of a haze that is no longer there
            angstrom_exponent: self.effective_angstrom_exponent(),
            ..self.clone()
        };
        let optics = OpticalProfile::build(profile, &settings)?;
        Ok(optics.extinction_per_km(0))
    }

    /// Vertical optical depth at 500 nm of the stratospheric aerosol, the first share of all aerosol.
    #[must_use]
    pub fn stratospheric_optical_depth_500(&self) -> f64 {
        if self.constituents.aerosol && self.constituents.stratospheric_aerosol {
            aerosol::stratosphere_optical_depth_550(0.0)
                * aerosol::stratosphere(500.0).relative_extinction
        } else {
            0.0
        }
    }

    /// The aerosol's optical depths and spectra at one wavelength.
    pub(crate) fn aerosol_at(&self, optical_depth_500: f64, wavelength_nm: f64) -> AerosolOptics {
        if !self.constituents.aerosol {
            return AerosolOptics::default();
        }
        let layer_500 = self
            .stratospheric_optical_depth_500()
            .min(optical_depth_500);
        let (rural, layer) = (
            aerosol::rural(wavelength_nm),
            aerosol::stratosphere(wavelength_nm),
        );
        let (haze_law, layer_law) = self.effective_angstrom_exponent().map_or_else(
            || {
                (
                    rural.relative_extinction / aerosol::rural(500.0).relative_extinction,
                    layer.relative_extinction / aerosol::stratosphere(500.0).relative_extinction,
                )
            },
            |alpha| {
                let law = (wavelength_nm / 500.0).powf(-alpha);
                (law, law)
            },
        );
        let [g, g2, weight] = self
            .asymmetry_parameter
            .map_or(aerosol::RURAL_PHASE, |g| [g, aerosol::RURAL_PHASE[1], 1.0]);
        AerosolOptics {
            haze_depth: (optical_depth_500 - layer_500) * haze_law,
            haze_albedo: self
                .single_scattering_albedo
                .unwrap_or(rural.single_scattering_albedo),
            haze_phase: [g, g2, weight],
            layer_depth: layer_500 * layer_law,
            layer_albedo: layer.single_scattering_albedo,
            layer_g: layer.asymmetry_parameter,
        }
    }

    /// The wavelengths over which a gas is averaged.
    pub(crate) fn gas_samples_nm(&self, wavelength_nm: f64) -> impl Iterator<Item = f64> + Clone {
        let width = self.gas_band_width_nm;
        // One sample a nanometre, at the middle of its share.
        let count = (1..=50_u8)
            .take_while(|&n| f64::from(n) <= width.max(1.0) + 1e-9)
            .last()
            .unwrap_or(1);
        (0..count)
            .map(move |i| wavelength_nm + width * ((f64::from(i) + 0.5) / f64::from(count) - 0.5))
    }
}

/// The aerosol at one wavelength, whole columns.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct AerosolOptics {
    /// Vertical optical depth of the haze.
    pub(crate) haze_depth: f64,
    /// Single-scattering albedo of the haze.
    pub(crate) haze_albedo: f64,
    /// First g, second g, weight of the first.
    pub(crate) haze_phase: [f64; 3],
    /// Vertical optical depth of the stratospheric layer.
    pub(crate) layer_depth: f64,
    /// Single-scattering albedo of the layer.
    pub(crate) layer_albedo: f64,
    /// Asymmetry parameter of the layer.
    pub(crate) layer_g: f64,
}

/// Mean of a function over samples.
pub(crate) fn mean<S>(samples: impl Iterator<Item = S>, f: impl Fn(S) -> f64) -> f64 {
    let mut sum = 0.0;
    let mut count = 0.0;
    for sample in samples {
        sum += f(sample);
        count += 1.0;
    }
    sum / count
}

/// Optical properties on levels × wavelengths; linear in altitude between levels.
///
/// Tables are stored level-major: entry `level * wavelength_nm.len() + wavelength`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OpticalProfile {
    /// Altitudes of the levels \[km\], ascending; the first is the ground.
    pub altitude_km: Vec<f64>,
    /// Wavelengths \[nm\], ascending.
    pub wavelength_nm: Vec<f64>,
    /// Rayleigh scattering coefficient \[km⁻¹\].
    pub rayleigh_scattering_per_km: Vec<f64>,
    /// Absorption coefficient of all gases \[km⁻¹\].
    pub gas_absorption_per_km: Vec<f64>,
    /// Aerosol scattering coefficient \[km⁻¹\].
    pub aerosol_scattering_per_km: Vec<f64>,
    /// Aerosol absorption coefficient \[km⁻¹\].
    pub aerosol_absorption_per_km: Vec<f64>,
    /// Asymmetry parameter of the first Henyey–Greenstein term.
    pub aerosol_g: Vec<f64>,
    /// Asymmetry parameter of the second Henyey–Greenstein term.
    pub aerosol_g2: Vec<f64>,
    /// Weight of the first term (1: a single Henyey–Greenstein function).
    pub aerosol_g_weight: Vec<f64>,
    /// Depolarization of the Rayleigh phase function, one value for all wavelengths.
    pub rayleigh_depolarization: f64,
}

/// Altitudes of the levels that [`OpticalProfile::build`] makes \[km\].
#[must_use]
pub fn level_altitudes_km() -> Vec<f64> {
    let fine = (0..200_u16).map(|i| f64::from(i) / 10.0);
    let middle = (80..160_u16).map(|i| f64::from(i) / 4.0);
    let coarse = (40..=100_u16).map(f64::from);
    fine.chain(middle).chain(coarse).collect()
}

/// Level values of a coefficient whose linear pieces add up to the exact columns: half of each
/// layer's defect (exact column less trapezoid) goes to either end.
fn column_preserving(
    altitude_km: &[f64],
    at: impl Fn(f64) -> f64,
    column_above: impl Fn(f64) -> f64,
) -> Vec<f64> {
    let value: Vec<f64> = altitude_km.iter().map(|&z| at(z)).collect();
    let above: Vec<f64> = altitude_km.iter().map(|&z| column_above(z)).collect();
    let last = value.len() - 1;
    let thickness = |i: usize| altitude_km[i + 1] - altitude_km[i];
    let defect =
        |i: usize| above[i] - above[i + 1] - 0.5 * thickness(i) * (value[i] + value[i + 1]);
    (0..=last)
        .map(|i| {
            let (mut gap, mut span) = (0.0, 0.0);
            if i > 0 {
                gap += defect(i - 1);
                span += thickness(i - 1);
            }
            if i < last {
                gap += defect(i);
                span += thickness(i);
            }
            (value[i] + gap / span).max(0.0)
        })
        .collect()
}

/// The two-term Henyey–Greenstein function with the first three Legendre moments of a mixture of
/// Henyey–Greenstein functions (Prony's method: the two-point Gauss rule of the mixture's g).
/// Terms are (share, g); returns first g, second g, weight of the first, or `None` without light.
pub(crate) fn two_terms_of_mixture(terms: &[(f64, f64)]) -> Option<[f64; 3]> {
    let mut total = 0.0;
    let mut first = 0.0;
    for &(share, g) in terms {
        total += share;
        first += share * g;
    }
    if total <= 0.0 {
        return None;
    }
    let g_mean = first / total;
    let (mut variance, mut skew) = (0.0, 0.0);
    for &(share, g) in terms {
        variance += share / total * (g - g_mean).powi(2);
        skew += share / total * (g - g_mean).powi(3);
    }
    if variance < DEGENERATE_VARIANCE {
        return Some([g_mean, aerosol::RURAL_PHASE[1], 1.0]);
    }
    // Nodes x about the mean: x² − (skew/variance) x − variance = 0. Their product is −variance,
    // so the smaller one comes from the larger one without cancellation.
    let half = 0.5 * skew / variance;
    let root = half.hypot(variance.sqrt());
    let larger = if half < 0.0 { half - root } else { half + root };
    let other = -variance / larger;
    let (high, low) = (larger.max(other), larger.min(other));
    Some([g_mean + high, g_mean + low, -low / (high - low)])
}

/// Checks that a column of the second phase function does not stand alone.
fn check_companions(table: &Table) -> Result<(), OpticsError> {
    for (column, companion) in [(G2, G_WEIGHT), (G_WEIGHT, G2)] {
        if table.optional_column(column).is_some() && table.optional_column(companion).is_none() {
            return Err(OpticsError::LoneColumn {
                file: table.file.clone(),
                line: table.header_line,
                column: COLUMNS[column].name,
                companion: COLUMNS[companion].name,
            });
        }
    }
    Ok(())
}

/// The row of each altitude and wavelength, in the order of the tables.
fn rows_in_order(
    table: &Table,
    altitude_km: &[f64],
    wavelength_nm: &[f64],
) -> Result<Vec<usize>, OpticsError> {
    let count = wavelength_nm.len();
    let place = |axis: &[f64], v: f64| axis.partition_point(|x| x.total_cmp(&v).is_lt());
    let mut row_at: Vec<Option<usize>> = vec![None; altitude_km.len() * count];
    for (row, (&z, &nm)) in table.column(0).iter().zip(table.column(1)).enumerate() {
        let entry = place(altitude_km, z) * count + place(wavelength_nm, nm);
        if row_at[entry].replace(row).is_some() {
            return Err(OpticsError::Duplicate {
                file: table.file.clone(),
                line: table.line[row],
                altitude_km: z,
                found: nm,
            });
        }
    }
    row_at
        .iter()
        .enumerate()
        .map(|(entry, row)| {
            row.ok_or_else(|| OpticsError::Hole {
                file: table.file.clone(),
                line: table.last_line(),
                altitude_km: altitude_km[entry / count],
                wavelength_nm: wavelength_nm[entry % count],
            })
        })
        .collect()
}

impl OpticalProfile {
    /// Optics of an atmosphere.
    ///
    /// The O₂ and water band forms are not multiplicative. Switched on here they enter as an effective
    /// volume absorption: the derivative, along the vertical, of τ(z) = (k m u(z))^a / m at the reference
    /// air mass m = 2, u the path above z. A path of air mass 2 is then right from every altitude to
    /// space; shorter paths absorb too little, longer ones too much.
    ///
    /// # Errors
    /// Settings out of bounds, impossible haze.
    pub fn build(
        profile: &AtmosphereProfile,
        settings: &OpticsSettings,
    ) -> Result<Self, OpticsError> {
        let optical_depth_500 = settings.optical_depth_500(profile)?;
        let altitude_km = level_altitudes_km();
        let on_levels = Shapes::new(profile, settings, &altitude_km);
        let size = altitude_km.len() * settings.wavelength_nm.len();
        let mut out = Self {
            wavelength_nm: settings.wavelength_nm.clone(),
            rayleigh_scattering_per_km: vec![0.0; size],
            gas_absorption_per_km: vec![0.0; size],
            aerosol_scattering_per_km: vec![0.0; size],
            aerosol_absorption_per_km: vec![0.0; size],
            aerosol_g: vec![0.0; size],
            aerosol_g2: vec![0.0; size],
            aerosol_g_weight: vec![1.0; size],
            rayleigh_depolarization: settings.rayleigh_depolarization,
            altitude_km,
        };
        for w in 0..settings.wavelength_nm.len() {
            out.fill_wavelength(w, profile, settings, &on_levels, optical_depth_500);
        }
        Ok(out)
    }

    fn fill_wavelength(
        &mut self,
        w: usize,
        profile: &AtmosphereProfile,
        settings: &OpticsSettings,
        shapes: &Shapes,
        optical_depth_500: f64,
    ) {
        let nm = self.wavelength_nm[w];
        let on = settings.constituents;
        // m² × m⁻³ is m⁻¹: 10³ of them a kilometre.
        let switch = |on: bool, per_m: f64| if on { 1e3 * per_m } else { 0.0 };
        let samples = settings.gas_samples_nm(nm);
        let rayleigh = switch(on.rayleigh, rayleigh::cross_section_m2(nm));
        let ozone = switch(on.ozone, ozone::cross_section_m2(nm));
        let no2 = switch(on.no2, mean(samples.clone(), gases::no2_cross_section_m2));
        let pairs = switch(
            on.o2o2,
            mean(samples.clone(), gases::oxygen_pair_coefficient_m5),
        );
        let aerosol = settings.aerosol_at(optical_depth_500, nm);
        let bands = BandAbsorption::new(profile, settings, nm).map(|bands| {
            column_preserving(&self.altitude_km, |z| bands.per_km(z), |z| bands.depth(z))
        });
        for level in 0..self.altitude_km.len() {
            let entry = level * self.wavelength_nm.len() + w;
            self.rayleigh_scattering_per_km[entry] = rayleigh * shapes.air[level];
            self.gas_absorption_per_km[entry] = ozone * shapes.ozone[level]
                + no2 * shapes.no2[level]
                + pairs * shapes.pairs[level]
                + bands.as_ref().map_or(0.0, |b| b[level]);
            let haze = aerosol.haze_depth * shapes.haze[level];
            let layer = aerosol.layer_depth * shapes.layer[level];
            let haze_scattering = aerosol.haze_albedo * haze;
            let layer_scattering = aerosol.layer_albedo * layer;
            self.aerosol_scattering_per_km[entry] = haze_scattering + layer_scattering;
            self.aerosol_absorption_per_km[entry] =
                (haze - haze_scattering) + (layer - layer_scattering);
            let [g, g2, weight] = aerosol.haze_phase;
            let mixture = two_terms_of_mixture(&[
                (haze_scattering * weight, g),
                (haze_scattering * (1.0 - weight), g2),
                (layer_scattering, aerosol.layer_g),
            ]);
            let phase = mixture.unwrap_or(aerosol.haze_phase);
            self.aerosol_g[entry] = phase[0];
            self.aerosol_g2[entry] = phase[1];
            self.aerosol_g_weight[entry] = phase[2];
        }
    }

    /// Reads optics made elsewhere; `name` is the file's name, for errors. Rows may come in any
    /// order, but every altitude needs every wavelength. Without `aerosol_g2` and
    /// `aerosol_g_weight` the aerosol phase function is a single Henyey–Greenstein function.
    /// The Rayleigh depolarization is not in the file; it is set to 0.0283.
    ///
    /// # Errors
    /// The first thing that is wrong, with file, line and column.
    pub fn from_csv_str(name: &str, text: &str) -> Result<Self, OpticsError> {
        let table = Table::read(name, text, &COLUMNS, 1)?;
        check_companions(&table)?;
        let axis = |column: usize| {
            let mut values = table.column(column).to_vec();
            values.sort_by(f64::total_cmp);
            values.dedup_by(|a, b| a.total_cmp(b).is_eq());
            values
        };
        let (altitude_km, wavelength_nm) = (axis(0), axis(1));
        let row_of = |z: f64| table.column(0).iter().position(|v| v.total_cmp(&z).is_eq());
        if altitude_km[0] > 0.0 {
            return Err(OpticsError::NoGround {
                file: name.to_owned(),
                line: row_of(altitude_km[0]).map_or(table.last_line(), |row| table.line[row]),
                found: altitude_km[0],
            });
        }
        if altitude_km.len() < 2 {
            return Err(OpticsError::OneLevel {
                file: name.to_owned(),
                line: table.last_line(),
            });
        }
        let rows = rows_in_order(&table, &altitude_km, &wavelength_nm)?;
        let sorted = |column: usize, default: f64| -> Vec<f64> {
            table.optional_column(column).map_or_else(
                || vec![default; rows.len()],
                |values| rows.iter().map(|&row| values[row]).collect(),
            )
        };
        Ok(Self {
            rayleigh_scattering_per_km: sorted(2, 0.0),
            gas_absorption_per_km: sorted(3, 0.0),
            aerosol_scattering_per_km: sorted(4, 0.0),
            aerosol_absorption_per_km: sorted(5, 0.0),
            aerosol_g: sorted(6, 0.0),
            aerosol_g2: sorted(G2, 0.0),
            aerosol_g_weight: sorted(G_WEIGHT, 1.0),
            rayleigh_depolarization: OpticsSettings::default().rayleigh_depolarization,
            altitude_km,
            wavelength_nm,
        })
    }

    /// The table as CSV, altitude by altitude; [`OpticalProfile::from_csv_str`] reads it back bit
    /// for bit (but for the depolarization, which has no column).
    #[must_use]
    pub fn to_csv_string(&self) -> String {
        let mut out = String::with_capacity(160 * self.rayleigh_scattering_per_km.len());
        out.push_str(&COLUMNS.map(|c| c.name).join(","));
        out.push('\n');
        let count = self.wavelength_nm.len();
        for (level, z) in self.altitude_km.iter().enumerate() {
            for (w, nm) in self.wavelength_nm.iter().enumerate() {
                let entry = level * count + w;
                out.push_str(&format!("{z},{nm}"));
                for column in [
                    &self.rayleigh_scattering_per_km,
                    &self.gas_absorption_per_km,
                    &self.aerosol_scattering_per_km,
                    &self.aerosol_absorption_per_km,
                    &self.aerosol_g,
                    &self.aerosol_g2,
                    &self.aerosol_g_weight,
                ] {
                    out.push_str(&format!(",{:e}", column[entry]));
                }
                out.push('\n');
            }
        }
        out
    }

    /// The same air down to a ground below its lowest level, which is 0 km: each coefficient goes on
    /// below with the scale height that it has, at its wavelength, between the lowest two levels, and
    /// phase functions stay what they are at the lowest. Amounts of haze still count from 0 km up.
    ///
    /// US 1976 air continued so is 0.07 % too dense at −0.5 km.
    ///
    /// # Errors
    /// A ground outside −0.5 to 0 km.
    pub fn down_to(&self, ground: Length) -> Result<Self, OpticsError> {
        let ground_km = ground.km();
        if !(LOWEST_GROUND_KM..=0.0).contains(&ground_km) {
            return Err(OpticsError::Setting {
                setting: "ground altitude [km]",
                expected: [LOWEST_GROUND_KM, 0.0],
                found: ground_km,
            });
        }
        let (lowest, n) = (self.altitude_km[0], self.wavelength_nm.len());
        let first_layer = self.altitude_km[1] - lowest;
        let mut below: Vec<f64> = (1..=99_u8)
            .map(|i| lowest - LOW_LAYER_KM * f64::from(i))
            .take_while(|z| *z > ground_km + 0.1 * LOW_LAYER_KM)
            .collect();
        if ground_km < lowest {
            below.push(ground_km);
        }
        below.reverse();
        let continued = |table: &[f64], depth_share: f64| -> Vec<f64> {
            let row = |w: usize| {
                let (here, above) = (table[w], table[n + w]);
                if here > 0.0 && above > 0.0 {
                    here * (here / above).powf(depth_share)
                } else {
                    here
                }
            };
            (0..n).map(row).collect()
        };
        let extend = |table: &[f64], falls: bool| -> Vec<f64> {
            let rows = below.iter().flat_map(|z| {
                let share = if falls {
                    (lowest - z) / first_layer
                } else {
                    0.0
                };
                continued(table, share)
            });
            rows.chain(table.iter().copied()).collect()
        };
        Ok(Self {
            altitude_km: below.iter().chain(&self.altitude_km).copied().collect(),
            wavelength_nm: self.wavelength_nm.clone(),
            rayleigh_scattering_per_km: extend(&self.rayleigh_scattering_per_km, true),
            gas_absorption_per_km: extend(&self.gas_absorption_per_km, true),
            aerosol_scattering_per_km: extend(&self.aerosol_scattering_per_km, true),
            aerosol_absorption_per_km: extend(&self.aerosol_absorption_per_km, true),
            aerosol_g: extend(&self.aerosol_g, false),
            aerosol_g2: extend(&self.aerosol_g2, false),
            aerosol_g_weight: extend(&self.aerosol_g_weight, false),
            rayleigh_depolarization: self.rayleigh_depolarization,
        })
    }

    /// Checks that an observer stands below the last level: above it there would be nothing to see.
    ///
    /// # Errors
    /// An altitude above the last level, or none.
    pub fn check_observer(&self, altitude: Length) -> Result<(), OpticsError> {
        let top_km = self.altitude_km.last().copied().unwrap_or(0.0);
        let found = altitude.km();
        // kilometers were converted; an altitude on the last level must stay inside
        if found < top_km + 1e-9 {
            Ok(())
        } else {
            Err(OpticsError::ObserverAbove { top_km, found })
        }
    }

    /// Extinction coefficient of everything \[km⁻¹\] at an entry of the tables.
    fn extinction_per_km(&self, entry: usize) -> f64 {
        self.rayleigh_scattering_per_km[entry]
            + self.gas_absorption_per_km[entry]
            + self.aerosol_scattering_per_km[entry]
            + self.aerosol_absorption_per_km[entry]
    }

    /// Vertical optical depth above an altitude, per wavelength; 0 above the last level.
    #[must_use]
    pub fn vertical_optical_depth(&self, altitude: Length) -> Vec<f64> {
        let (z, count) = (&self.altitude_km, self.wavelength_nm.len());
        let extinction = |level: usize, w: usize| self.extinction_per_km(level * count + w);
        let mut depth = vec![0.0; count];
        for level in 1..z.len() {
            let low = z[level - 1].max(altitude.km());
            if low >= z[level] {
                continue;
            }
            let t = (low - z[level - 1]) / (z[level] - z[level - 1]);
            for (w, depth) in depth.iter_mut().enumerate() {
                let (below, top) = (extinction(level - 1, w), extinction(level, w));
                let at_low = below + t * (top - below);
                *depth += 0.5 * (at_low + top) * (z[level] - low);
            }
        }
        depth
    }
}

/// Vertical shapes of the volume constituents on the levels.
struct Shapes {
    /// Air \[m⁻³\].
    air: Vec<f64>,
    /// Ozone \[m⁻³\].
    ozone: Vec<f64>,
    /// NO₂ \[m⁻³\].
    no2: Vec<f64>,
    /// Square of O₂ \[m⁻⁶\].
    pairs: Vec<f64>,
    /// Haze \[km⁻¹\], integrates to 1.
    haze: Vec<f64>,
    /// Stratospheric layer \[km⁻¹\], integrates to 1.
    layer: Vec<f64>,
}

impl Shapes {
    fn new(profile: &AtmosphereProfile, settings: &OpticsSettings, levels_km: &[f64]) -> Self {
        // Columns per metre of height become columns per kilometre: 10⁻³.
        let gas = |gas| {
            column_preserving(
                levels_km,
                |z| profile.number_density_per_m3(gas, Length::from_km(z)),
                |z| 1e-3 * profile.column_above_per_m2(gas, Length::from_km(z)),
            )
        };
        let height_km = settings.aerosol_scale_height.km();
        let layer_depth = aerosol::stratosphere_optical_depth_550(0.0);
        Self {
            air: gas(Gas::Air),
            ozone: gas(Gas::Ozone),
            no2: gas(Gas::NitrogenDioxide),
            pairs: column_preserving(
                levels_km,
                |z| profile.oxygen_pairs_per_m6(Length::from_km(z)),
                |z| 1e-3 * profile.oxygen_pairs_above_per_m5(Length::from_km(z)),
            ),
            haze: column_preserving(
                levels_km,
                |z| aerosol::haze_shape_per_km(z, height_km),
                |z| aerosol::haze_share_above(z, height_km),
            ),
            layer: column_preserving(
                levels_km,
                |z| aerosol::stratosphere_extinction_550_per_km(z) / layer_depth,
                |z| aerosol::stratosphere_optical_depth_550(z) / layer_depth,
            ),
        }
    }
}

/// The O₂ and water bands at one wavelength as an effective vertical absorption.
struct BandAbsorption<'a> {
    profile: &'a AtmosphereProfile,
    /// Band forms of the samples in the band; strength 0 where switched off.
    forms: Vec<(gases::BandForm, gases::BandForm)>,
}

impl<'a> BandAbsorption<'a> {
    fn new(
        profile: &'a AtmosphereProfile,
        settings: &OpticsSettings,
        wavelength_nm: f64,
    ) -> Option<Self> {
        let on = settings.constituents;
        let switch = |on: bool, form: gases::BandForm| gases::BandForm {
            strength: if on { form.strength } else { 0.0 },
            ..form
        };
        let forms: Vec<_> = settings
            .gas_samples_nm(wavelength_nm)
            .map(|nm| {
                (
                    switch(on.o2_band, gases::o2_band(nm)),
                    switch(on.h2o_band, gases::water_band(nm)),
                )
            })
            .collect();
        let active = |(o2, water): &(gases::BandForm, gases::BandForm)| {
            o2.strength > 0.0 || water.strength > 0.0
        };
        forms.iter().any(active).then_some(Self { profile, forms })
    }

    /// Effective vertical optical depth above an altitude at the reference air mass.
    fn depth(&self, altitude_km: f64) -> f64 {
        let altitude = Length::from_km(altitude_km);
        let pressure = self.profile.pressure_hpa(altitude) / gases::STANDARD_PRESSURE_HPA;
        let o2_path = BAND_REFERENCE_AIR_MASS * pressure.powf(gases::O2_PRESSURE_EXPONENT);
        let water_path = BAND_REFERENCE_AIR_MASS
            * self.profile.water_column_cm(altitude)
            * pressure.powf(gases::WATER_PRESSURE_EXPONENT);
        let transmittance = mean(0..self.forms.len(), |i: usize| {
            let (o2, water) = self.forms[i];
            o2.transmittance(o2_path) * water.transmittance(water_path)
        });
        -transmittance.ln() / BAND_REFERENCE_AIR_MASS
    }

    /// Its derivative \[km⁻¹\].
    fn per_km(&self, altitude_km: f64) -> f64 {
        let step = 0.05;
        let (low, high) = (
            (altitude_km - step).max(0.0),
            (altitude_km + step).min(100.0),
        );
        ((self.depth(low) - self.depth(high)) / (high - low)).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sky_science::phase;

    #[test]
    fn there_are_fewer_than_400_levels_and_they_ascend() {
        let z = level_altitudes_km();
        assert!(z.len() < 400);
        assert!(z.windows(2).all(|p| p[1] > p[0]));
        assert!(z[0].abs() < 1e-15 && (z[z.len() - 1] - 100.0).abs() < 1e-12);
    }

    #[test]
    fn a_mixture_keeps_its_first_three_moments() {
        let terms: [(f64, f64); 3] = [(0.3, 0.6746), (0.01, -0.6092), (0.5, 0.685)];
        let total: f64 = terms.iter().map(|t| t.0).sum();
        let moment = |l: i32| -> f64 { terms.iter().map(|t| t.0 / total * t.1.powi(l)).sum() };
        let found = two_terms_of_mixture(&terms);
        assert!(found.is_some());
        let [g, g2, weight] = found.unwrap_or_default();
        for l in 1..=3 {
            let got = phase::two_term_moment(l, g, g2, weight);
            assert!((got - moment(l)).abs() < 1e-14, "moment {l}");
        }
        assert!((0.0..=1.0).contains(&weight) && g < 1.0 && g2 > -1.0);
    }

    #[test]
    fn one_term_is_a_degenerate_mixture() {
        let single = two_terms_of_mixture(&[(0.0, 0.6746), (0.0, -0.6092), (0.2, 0.685)]);
        let [g, _, weight] = single.unwrap_or_default();
        assert!((g - 0.685).abs() < 1e-15 && (weight - 1.0).abs() < 1e-15);
        assert_eq!(two_terms_of_mixture(&[(0.0, 0.5)]), None);
    }

    #[test]
    fn level_values_preserve_columns() {
        let levels = level_altitudes_km();
        let value = column_preserving(&levels, |z| (-z / 1.2).exp(), |z| 1.2 * (-z / 1.2).exp());
        let sum: f64 = (1..levels.len())
            .map(|i| 0.5 * (levels[i] - levels[i - 1]) * (value[i] + value[i - 1]))
            .sum();
        assert!((sum / 1.2 - 1.0).abs() < 1e-12);
    }

    #[test]
    fn the_csv_reads_back_bit_for_bit() -> Result<(), OpticsError> {
        let settings = OpticsSettings {
            wavelength_nm: vec![450.0, 550.0, 650.0],
            constituents: Constituents::ALL,
            ..OpticsSettings::default()
        };
        let optics = OpticalProfile::build(&AtmosphereProfile::general(), &settings)?;
        let back = OpticalProfile::from_csv_str("optics.csv", &optics.to_csv_string())?;
        assert_eq!(back, optics);
        Ok(())
    }

    #[test]
    fn a_band_form_gives_its_transmittance_at_the_reference_air_mass() -> Result<(), OpticsError> {
        let mut settings = OpticsSettings {
            wavelength_nm: vec![720.0, 760.0],
            haze: Haze::Turbidity(1.0),
            ..OpticsSettings::default()
        };
        let profile = AtmosphereProfile::general();
        let depth = |settings: &OpticsSettings| -> Result<Vec<f64>, OpticsError> {
            Ok(OpticalProfile::build(&profile, settings)?.vertical_optical_depth(Length::ZERO))
        };
        let without = depth(&settings)?;
        settings.constituents = Constituents::ALL;
        settings.constituents.no2 = false;
        let with = depth(&settings)?;
        let water_cm = profile.water_column_cm(Length::ZERO);
        for (i, nm) in [720.0, 760.0].into_iter().enumerate() {
            let band = gases::o2_band(nm).path_exponent(2.0)
                + gases::water_band(nm).path_exponent(2.0 * water_cm);
            assert!(
                (2.0 * (with[i] - without[i]) / band - 1.0).abs() < 1e-3,
                "{nm}"
            );
        }
        Ok(())
    }

    #[test]
    fn bad_optics_tables_are_refused() {
        let header = "altitude_km,wavelength_nm,rayleigh_scattering_per_km,gas_absorption_per_km,aerosol_scattering_per_km,aerosol_absorption_per_km,aerosol_g";
        let read = |rows: &str| OpticalProfile::from_csv_str("o.csv", &format!("{header}\n{rows}"));
        let row = |z: f64, nm: f64| format!("{z},{nm},0.01,0,0,0,0\n");
        assert!(read(&(row(0.0, 500.0) + &row(1.0, 500.0))).is_ok());
        let hole = row(0.0, 500.0) + &row(0.0, 600.0) + &row(1.0, 500.0);
        assert!(matches!(read(&hole), Err(OpticsError::Hole { .. })));
        let twice = row(0.0, 500.0) + &row(0.0, 500.0) + &row(1.0, 500.0);
        assert!(matches!(
            read(&twice),
            Err(OpticsError::Duplicate { line: 3, .. })
        ));
        let aloft = row(0.5, 500.0) + &row(1.0, 500.0);
        assert!(matches!(
            read(&aloft),
            Err(OpticsError::NoGround { line: 2, .. })
        ));
        assert!(matches!(
            read(&row(0.0, 500.0)),
            Err(OpticsError::OneLevel { .. })
        ));
        let lone = format!("{header},aerosol_g2\n0,500,0.01,0,0,0,0,0\n");
        assert!(matches!(
            OpticalProfile::from_csv_str("o.csv", &lone),
            Err(OpticsError::LoneColumn { .. })
        ));
        assert!(matches!(
            read("0,500,-0.01,0,0,0,0\n"),
            Err(OpticsError::Table(TableError::OutOfRange { line: 2, .. }))
        ));
    }

    #[test]
    fn b2_what_optics_cannot_be_asked_is_refused() -> Result<(), OpticsError> {
        let header = "altitude_km,wavelength_nm,rayleigh_scattering_per_km,gas_absorption_per_km,aerosol_scattering_per_km,aerosol_absorption_per_km,aerosol_g";
        let read = |rows: &str| OpticalProfile::from_csv_str("o.csv", &format!("{header}\n{rows}"));
        // a negative zero is the same level
        assert!(matches!(
            read("-0,500,0.01,0,0,0,0\n0,500,0.01,0,0,0,0\n1,500,0.01,0,0,0,0\n"),
            Err(OpticsError::Duplicate { line: 3, .. })
        ));
        // a phase function of one direction is none
        for g in ["1", "-1", "0.9995"] {
            assert!(matches!(
                read(&format!("0,500,0.01,0,0.1,0,{g}\n1,500,0.01,0,0.1,0,{g}\n")),
                Err(OpticsError::Table(TableError::OutOfRange {
                    column: "aerosol_g",
                    ..
                }))
            ));
        }
        let low = read("0,500,0.01,0,0,0,0\n10,500,0.01,0,0,0,0\n")?;
        assert_eq!(low.check_observer(Length::from_km(10.0)), Ok(()));
        for km in [10.1, 20.0, f64::NAN] {
            assert!(matches!(
                low.check_observer(Length::from_km(km)),
                Err(OpticsError::ObserverAbove { .. })
            ));
        }
        Ok(())
    }

    #[test]
    fn bad_settings_are_refused() {
        let profile = AtmosphereProfile::general();
        let with = |change: fn(&mut OpticsSettings)| {
            let mut settings = OpticsSettings::default();
            change(&mut settings);
            OpticalProfile::build(&profile, &settings)
        };
        assert!(matches!(
            with(|s| s.haze = Haze::Turbidity(0.5)),
            Err(OpticsError::Haze(_))
        ));
        assert!(matches!(
            with(|s| s.wavelength_nm = vec![500.0, 400.0]),
            Err(OpticsError::Wavelengths { place: 1, .. })
        ));
        assert!(matches!(
            with(|s| s.wavelength_nm.clear()),
            Err(OpticsError::Wavelengths { .. })
        ));
        assert!(matches!(
            with(|s| s.single_scattering_albedo = Some(1.1)),
            Err(OpticsError::Setting { .. })
        ));
        assert!(matches!(
            with(|s| s.asymmetry_parameter = Some(f64::NAN)),
            Err(OpticsError::Setting { .. })
        ));
        assert!(matches!(
            OpticsSettings::with_step_nm(7),
            Err(OpticsError::WavelengthStep { found: 7 })
        ));
    }
}
