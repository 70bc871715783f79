//! The atmosphere's vertical profile, 0–100 km: read, validated, completed, integrated exactly.
//!
//! Between nodes temperature is linear in altitude, the logarithms of pressure and of number densities
//! are linear, and columns are the exact integrals of those pieces. Heights outside 0–100 km are
//! taken at the ends: there is nothing above 100 km.
//!
//! # Profile CSV
//! Columns in any order, units in the names, `#` starts a comment line:
//! - `altitude_km`: ascending from 0 to at least 30, at most 100;
//! - `temperature_k`, `pressure_hpa`, `ozone_number_density_per_m3`: required;
//! - `air_number_density_per_m3`: else p/(k T);
//! - `water_number_density_per_m3` or `relative_humidity_percent` (over liquid water): else the general
//!   atmosphere's share of the air;
//! - `no2_number_density_per_m3`: else the general atmosphere's share of the air.
//!
//! The air must carry itself: from row to row ln p falls by ∫ g/(R T) dz within 20 % and 0.1, and a given
//! number of air molecules is p/(k T) within 10 %. What is further off is a slip of the pen.
//!
//! An empty cell inside a column is interpolated: linearly for temperature and humidity,
//! log-linearly for the rest. A profile that ends below 100 km is continued with the shape of the
//! general atmosphere, and [`AtmosphereProfile::continued_above`] says so.

use crate::gases::{OXYGEN_MOLE_FRACTION, STANDARD_PRESSURE_HPA};
use crate::ozone;
use crate::table::{ColumnSpec, Table, TableError, interpolate};
use sky_core::quantity::{EARTH_RADIUS_KM, Length};
use std::sync::LazyLock;
use thiserror::Error;

/// Top of the atmosphere \[km\]; nothing is above it.
pub const TOP_OF_ATMOSPHERE_KM: f64 = 100.0;

/// Highest altitude of an observer \[km\], to which every profile must reach.
pub const HIGHEST_OBSERVER_KM: f64 = 30.0;

/// Boltzmann's constant \[J·K⁻¹\] (SI 2019).
const BOLTZMANN_J_PER_K: f64 = 1.380_649e-23;

/// Mass of a water molecule \[g\]: 18.01528 g·mol⁻¹ / Avogadro's constant.
const WATER_MOLECULE_G: f64 = 18.015_28 / 6.022_140_76e23;

/// Gas constant of dry air \[J·kg⁻¹·K⁻¹\] (US Standard Atmosphere 1976).
const DRY_AIR_J_PER_KG_K: f64 = 287.053;

/// Standard gravity \[m·s⁻²\].
const STANDARD_GRAVITY_M_S2: f64 = 9.806_65;

/// How far the fall of ln p between two rows may be from that of air at rest: a share of it, and an
/// addend. Humid air, the mixture near 100 km and temperatures far apart take a few percent, pressures
/// printed to two digits 0.05; a digit too few or a decimal point astray takes 2.3.
const MOST_IMBALANCE: [f64; 2] = [0.2, 0.1];

/// How far a given number of molecules may be from p/(k T), relatively.
const MOST_GAS_IMBALANCE: f64 = 0.1;

/// Fewest rows of a profile.
const MIN_ROWS: usize = 4;

const COLUMNS: [ColumnSpec; 8] = [
    ColumnSpec::required("altitude_km", [0.0, TOP_OF_ATMOSPHERE_KM]),
    ColumnSpec::required("temperature_k", [100.0, 400.0]).with_gaps(),
    ColumnSpec::required("pressure_hpa", [1e-9, 2000.0]).with_gaps(),
    ColumnSpec::required("ozone_number_density_per_m3", [0.0, 1e21]).with_gaps(),
    ColumnSpec::optional("air_number_density_per_m3", [1.0, 1e27]).with_gaps(),
    ColumnSpec::optional("no2_number_density_per_m3", [0.0, 1e21]).with_gaps(),
    ColumnSpec::optional("water_number_density_per_m3", [0.0, 1e25]).with_gaps(),
    ColumnSpec::optional("relative_humidity_percent", [0.0, 120.0]).with_gaps(),
];
const TEMPERATURE: usize = 1;
const PRESSURE: usize = 2;
const OZONE: usize = 3;
const AIR: usize = 4;
const NO2: usize = 5;
const WATER: usize = 6;
const HUMIDITY: usize = 7;

/// What a profile can get wrong.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ProfileError {
    /// The table itself is wrong.
    #[error(transparent)]
    Table(#[from] TableError),
    /// The altitudes do not cover 0–30 km.
    #[error(
        "{file}:{line}: column altitude_km: expected to cover {} to {} km, found an end at {found}",
        expected[0],
        expected[1]
    )]
    NotCovering {
        /// Name of the file.
        file: String,
        /// Line of the end that falls short.
        line: u64,
        /// The range to cover \[km\].
        expected: [f64; 2],
        /// The first or last altitude \[km\].
        found: f64,
    },
    /// An empty cell with nothing on one side to interpolate from.
    #[error(
        "{file}:{line}: column {column}: expected a number in the first and last row, found an empty cell"
    )]
    GapAtEnd {
        /// Name of the file.
        file: String,
        /// Line of the empty cell.
        line: u64,
        /// Column of the empty cell.
        column: &'static str,
    },
    /// A pressure that the air below it does not carry.
    #[error(
        "{file}:{line}: column pressure_hpa: expected about {expected:.3} as air at rest has it over the row before (at {temperature_k:.0} K), found {found}"
    )]
    NotInBalance {
        /// Name of the file.
        file: String,
        /// Line of the row.
        line: u64,
        /// The pressure of air at rest \[hPa\].
        expected: f64,
        /// The temperature there \[K\].
        temperature_k: f64,
        /// The pressure given \[hPa\].
        found: f64,
    },
    /// A number of molecules that is not that of the pressure and the temperature.
    #[error(
        "{file}:{line}: column air_number_density_per_m3: expected about {expected:.4e}, p/(k T), found {found:e}"
    )]
    NotTheGas {
        /// Name of the file.
        file: String,
        /// Line of the row.
        line: u64,
        /// p/(k T) \[m⁻³\].
        expected: f64,
        /// The number given \[m⁻³\].
        found: f64,
    },
    /// Two columns that say the same thing.
    #[error("{file}:{line}: column {found}: expected either {expected} or {found}, found both")]
    ConflictingColumns {
        /// Name of the file.
        file: String,
        /// Line of the header.
        line: u64,
        /// The first column.
        expected: &'static str,
        /// The column in conflict with it.
        found: &'static str,
    },
}

/// A gas of the profile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gas {
    /// Air molecules.
    Air,
    /// O₃.
    Ozone,
    /// NO₂.
    NitrogenDioxide,
    /// H₂O.
    WaterVapor,
}

/// A positive quantity on nodes whose logarithm is linear between them; linear where an end is 0.
#[derive(Clone, Debug, PartialEq)]
struct LogLinear {
    altitude_km: Vec<f64>,
    value: Vec<f64>,
    /// Integral from each node to the top \[value × m\].
    above: Vec<f64>,
}

/// Integral of a log-linear piece over its length.
fn log_linear_integral(a: f64, b: f64, length: f64) -> f64 {
    if a <= 0.0 || b <= 0.0 {
        return 0.5 * (a + b) * length;
    }
    let ratio = a / b;
    if (ratio - 1.0).abs() < 1e-9 {
        a * length
    } else {
        (a - b) / ratio.ln() * length
    }
}

fn log_linear_value(a: f64, b: f64, t: f64) -> f64 {
    if a <= 0.0 || b <= 0.0 {
        a + t * (b - a)
    } else {
        a * (t * (b / a).ln()).exp()
    }
}

impl LogLinear {
    fn new(altitude_km: &[f64], value: Vec<f64>) -> Self {
        let mut above = vec![0.0; value.len()];
        for i in (0..value.len().saturating_sub(1)).rev() {
            let metres = 1e3 * (altitude_km[i + 1] - altitude_km[i]);
            above[i] = above[i + 1] + log_linear_integral(value[i], value[i + 1], metres);
        }
        Self {
            altitude_km: altitude_km.to_vec(),
            value,
            above,
        }
    }

    /// Index of the piece that holds an altitude, and where in it, 0–1.
    fn locate(&self, altitude_km: f64) -> (usize, f64) {
        let z = &self.altitude_km;
        let last = z.len() - 2;
        let i = z.partition_point(|&node| node <= altitude_km);
        let i = i.saturating_sub(1).min(last);
        let t = (altitude_km - z[i]) / (z[i + 1] - z[i]);
        (i, t.clamp(0.0, 1.0))
    }

    fn at(&self, altitude_km: f64) -> f64 {
        let (i, t) = self.locate(altitude_km);
        log_linear_value(self.value[i], self.value[i + 1], t)
    }

    fn above(&self, altitude_km: f64) -> f64 {
        let (i, t) = self.locate(altitude_km);
        let here = log_linear_value(self.value[i], self.value[i + 1], t);
        let metres = 1e3 * (1.0 - t) * (self.altitude_km[i + 1] - self.altitude_km[i]);
        self.above[i + 1] + log_linear_integral(here, self.value[i + 1], metres)
    }
}

/// A validated atmosphere, 0–100 km.
#[derive(Clone, Debug, PartialEq)]
pub struct AtmosphereProfile {
    name: String,
    altitude_km: Vec<f64>,
    temperature_k: Vec<f64>,
    pressure_hpa: LogLinear,
    air: LogLinear,
    ozone: LogLinear,
    no2: LogLinear,
    water: LogLinear,
    oxygen_pairs: LogLinear,
    continued_above_km: Option<f64>,
}

/// Everything the profile says about one altitude: the report's vertical profiles and effective path
/// lengths, and the number densities.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProfileRow {
    /// Altitude \[km\].
    pub altitude_km: f64,
    /// Pressure \[hPa\].
    pub pressure_hpa: f64,
    /// Air temperature \[K\].
    pub temperature_k: f64,
    /// The report's effective ozone temperature, Eq. 3.7 \[K\].
    pub ozone_effective_temperature_k: f64,
    /// Relative humidity over liquid water \[%\].
    pub relative_humidity_percent: f64,
    /// Air molecules \[m⁻³\].
    pub air_number_density_per_m3: f64,
    /// Ozone molecules \[m⁻³\].
    pub ozone_number_density_per_m3: f64,
    /// NO₂ molecules \[m⁻³\].
    pub no2_number_density_per_m3: f64,
    /// Water molecules \[m⁻³\].
    pub water_number_density_per_m3: f64,
    /// The report's O₂ path, Eq. 3.11 \[km\].
    pub o2_path_km: f64,
    /// The report's CO₂ path, Eq. 3.11 \[km\]; CO₂ has no band in the visible.
    pub co2_path_km: f64,
    /// Precipitable water above \[cm\].
    pub water_column_cm: f64,
    /// Ozone above \[atm-cm\].
    pub ozone_column_atm_cm: f64,
    /// NO₂ above \[atm-cm\].
    pub no2_column_atm_cm: f64,
}

impl ProfileRow {
    /// Column names of [`ProfileRow::values`], units included.
    pub const COLUMNS: [&'static str; 14] = [
        "altitude_km",
        "pressure_hpa",
        "temperature_k",
        "ozone_effective_temperature_k",
        "relative_humidity_percent",
        "air_number_density_per_m3",
        "ozone_number_density_per_m3",
        "no2_number_density_per_m3",
        "water_number_density_per_m3",
        "o2_path_km",
        "co2_path_km",
        "water_column_cm",
        "ozone_column_atm_cm",
        "no2_column_atm_cm",
    ];

    /// The values in the order of [`ProfileRow::COLUMNS`].
    #[must_use]
    pub const fn values(&self) -> [f64; 14] {
        [
            self.altitude_km,
            self.pressure_hpa,
            self.temperature_k,
            self.ozone_effective_temperature_k,
            self.relative_humidity_percent,
            self.air_number_density_per_m3,
            self.ozone_number_density_per_m3,
            self.no2_number_density_per_m3,
            self.water_number_density_per_m3,
            self.o2_path_km,
            self.co2_path_km,
            self.water_column_cm,
            self.ozone_column_atm_cm,
            self.no2_column_atm_cm,
        ]
    }
}

/// Saturation vapor pressure over liquid water \[hPa\] (Magnus form of the report's Eq. 3.9;
/// temperatures in it are degrees Celsius).
#[must_use]
pub fn saturation_vapor_pressure_hpa(temperature_k: f64) -> f64 {
    let celsius = temperature_k - 273.15;
    6.11 * 10.0_f64.powf(7.5 * celsius / (237.7 + celsius))
}

/// The report's Eq. 3.11 (Gueymard 1995), u = c₀ P^c₁ θ^c₂ with P = p/1013.25 hPa, θ = 288.15 K/T.
/// Fitted for 0–4 km; the report uses it to 30 km, where it runs up to 40 % high.
fn gueymard_path_km(coefficients: [f64; 3], pressure_hpa: f64, temperature_k: f64) -> f64 {
    let [c0, c1, c2] = coefficients;
    c0 * (pressure_hpa / STANDARD_PRESSURE_HPA).powf(c1) * (288.15 / temperature_k).powf(c2)
}

/// Number density of an ideal gas \[m⁻³\].
fn number_density_per_m3(pressure_hpa: f64, temperature_k: f64) -> f64 {
    100.0 * pressure_hpa / (BOLTZMANN_J_PER_K * temperature_k)
}

static GENERAL: LazyLock<AtmosphereProfile> = LazyLock::new(|| {
    AtmosphereProfile::from_csv_str(sky_profiles::GENERAL.file, sky_profiles::GENERAL.csv)
        .expect("the embedded general atmosphere is valid and complete")
});

static UTM2005: LazyLock<AtmosphereProfile> = LazyLock::new(|| {
    AtmosphereProfile::from_csv_str(sky_profiles::UTM2005.file, sky_profiles::UTM2005.csv)
        .expect("the embedded profile of the report is valid and complete")
});

/// How the gaps of a column are closed.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Gaps {
    Linear,
    LogLinear,
}

fn fill_gaps(
    table: &Table,
    column: usize,
    gaps: Gaps,
    altitude_km: &[f64],
) -> Result<Option<Vec<f64>>, ProfileError> {
    let Some(values) = table.optional_column(column) else {
        return Ok(None);
    };
    let known: Vec<usize> = (0..values.len()).filter(|&i| !values[i].is_nan()).collect();
    let end_gap = |row: usize| ProfileError::GapAtEnd {
        file: table.file.clone(),
        line: table.line[row],
        column: COLUMNS[column].name,
    };
    let last = values.len() - 1;
    if known.first() != Some(&0) {
        return Err(end_gap(0));
    }
    if known.last() != Some(&last) {
        return Err(end_gap(last));
    }
    let mut out = values.to_vec();
    for pair in known.windows(2) {
        let (low, high) = (pair[0], pair[1]);
        for i in low + 1..high {
            let t = (altitude_km[i] - altitude_km[low]) / (altitude_km[high] - altitude_km[low]);
            out[i] = match gaps {
                Gaps::Linear => values[low] + t * (values[high] - values[low]),
                Gaps::LogLinear => log_linear_value(values[low], values[high], t),
            };
        }
    }
    Ok(Some(out))
}

/// Checks that the altitudes ascend and cover what an observer may see from.
fn check_altitudes(table: &Table) -> Result<(), ProfileError> {
    table.check_ascending(0, COLUMNS[0].name)?;
    let altitude_km = table.column(0);
    let covering = |row: usize| ProfileError::NotCovering {
        file: table.file.clone(),
        line: table.line[row],
        expected: [0.0, HIGHEST_OBSERVER_KM],
        found: altitude_km[row],
    };
    let last = altitude_km.len() - 1;
    if altitude_km[0] > 0.0 {
        return Err(covering(0));
    }
    if altitude_km[last] < HIGHEST_OBSERVER_KM {
        return Err(covering(last));
    }
    Ok(())
}

/// The columns of a profile with every gap closed.
struct Nodes {
    altitude_km: Vec<f64>,
    temperature: Vec<f64>,
    pressure: Vec<f64>,
    air: Vec<f64>,
    ozone: Vec<f64>,
    no2: Vec<f64>,
    water: Vec<f64>,
}

impl Nodes {
    /// Closes the gaps, and completes the columns that the table lacks.
    fn complete(table: &Table) -> Result<Self, ProfileError> {
        let altitude_km = table.column(0).to_vec();
        let fill = |column, gaps| fill_gaps(table, column, gaps, &altitude_km);
        // The required columns exist: the table was read with them.
        let temperature = fill(TEMPERATURE, Gaps::Linear)?.unwrap_or_default();
        let pressure = fill(PRESSURE, Gaps::LogLinear)?.unwrap_or_default();
        let ozone = fill(OZONE, Gaps::LogLinear)?.unwrap_or_default();
        let air = fill(AIR, Gaps::LogLinear)?.unwrap_or_else(|| {
            let pairs = pressure.iter().zip(&temperature);
            pairs.map(|(&p, &t)| number_density_per_m3(p, t)).collect()
        });
        let share_of_air = |of: fn(&AtmosphereProfile) -> &LogLinear| -> Vec<f64> {
            let general = &*GENERAL;
            let share = |z: f64| of(general).at(z) / general.air.at(z);
            let pairs = altitude_km.iter().zip(&air);
            pairs.map(|(&z, &n)| n * share(z)).collect()
        };
        let no2 =
            fill(NO2, Gaps::LogLinear)?.unwrap_or_else(|| share_of_air(|general| &general.no2));
        let humidity = fill(HUMIDITY, Gaps::Linear)?;
        let water = match (fill(WATER, Gaps::LogLinear)?, humidity) {
            (Some(water), _) => water,
            (None, Some(humidity)) => {
                let pairs = humidity.iter().zip(&temperature);
                pairs
                    .map(|(&rh, &t)| {
                        number_density_per_m3(0.01 * rh * saturation_vapor_pressure_hpa(t), t)
                    })
                    .collect()
            }
            (None, None) => share_of_air(|general| &general.water),
        };
        Ok(Self {
            temperature,
            pressure,
            air,
            ozone,
            no2,
            water,
            altitude_km,
        })
    }

    /// Checks that the air carries itself: from each pressure that was given to the next, ln p falls by
    /// the integral of g/(R T), and that the air, where it was given, is that of pressure and
    /// temperature. The bounds are [`MOST_IMBALANCE`] and [`MOST_GAS_IMBALANCE`].
    fn check_balance(&self, table: &Table) -> Result<(), ProfileError> {
        let given = |column: usize, row: usize| {
            table
                .optional_column(column)
                .is_some_and(|values| !values[row].is_nan())
        };
        let (mut below, mut fall) = (0, 0.0);
        for row in 1..self.altitude_km.len() {
            let thickness_m = 1e3 * (self.altitude_km[row] - self.altitude_km[row - 1]);
            let middle_km = 0.5 * (self.altitude_km[row] + self.altitude_km[row - 1]);
            let gravity =
                STANDARD_GRAVITY_M_S2 * (EARTH_RADIUS_KM / (EARTH_RADIUS_KM + middle_km)).powi(2);
            let coldness =
                0.5 * (self.temperature[row].recip() + self.temperature[row - 1].recip());
            fall += thickness_m * gravity * coldness / DRY_AIR_J_PER_KG_K;
            if !given(PRESSURE, row) {
                continue;
            }
            let found = (self.pressure[below] / self.pressure[row]).ln();
            if (found - fall).abs() > MOST_IMBALANCE[0] * fall + MOST_IMBALANCE[1] {
                return Err(ProfileError::NotInBalance {
                    file: table.file.clone(),
                    line: table.line[row],
                    expected: self.pressure[below] * (-fall).exp(),
                    temperature_k: self.temperature[row],
                    found: self.pressure[row],
                });
            }
            (below, fall) = (row, 0.0);
        }
        for row in (0..self.altitude_km.len()).filter(|&row| given(AIR, row)) {
            let expected = number_density_per_m3(self.pressure[row], self.temperature[row]);
            let found = self.air[row];
            if (found / expected - 1.0).abs() > MOST_GAS_IMBALANCE {
                return Err(ProfileError::NotTheGas {
                    file: table.file.clone(),
                    line: table.line[row],
                    expected,
                    found,
                });
            }
        }
        Ok(())
    }

    /// Goes on to the top with the shape of the general atmosphere. Returns where that begins \[km\].
    fn continue_to_top(&mut self) -> Option<f64> {
        let last = self.altitude_km.len() - 1;
        let end_km = self.altitude_km[last];
        if end_km >= TOP_OF_ATMOSPHERE_KM {
            return None;
        }
        let general = &*GENERAL;
        let warmth = self.temperature[last]
            / interpolate(&general.altitude_km, &general.temperature_k, end_km);
        let shapes = [
            (&mut self.pressure, &general.pressure_hpa),
            (&mut self.air, &general.air),
            (&mut self.ozone, &general.ozone),
            (&mut self.no2, &general.no2),
            (&mut self.water, &general.water),
        ];
        let above = || (0..general.altitude_km.len()).filter(|&i| general.altitude_km[i] > end_km);
        for (own, shape) in shapes {
            let scale = own[last] / shape.at(end_km);
            own.extend(above().map(|i| scale * shape.value[i]));
        }
        self.temperature
            .extend(above().map(|i| warmth * general.temperature_k[i]));
        self.altitude_km
            .extend(above().map(|i| general.altitude_km[i]));
        Some(end_km)
    }
}

impl AtmosphereProfile {
    /// The general atmosphere: US Standard Atmosphere 1976 with the AFGL 1986 gases, 1 km steps.
    #[must_use]
    pub fn general() -> Self {
        GENERAL.clone()
    }

    /// The report's own recipe (2005): US 1976 air in 2 km steps, ozone and NO₂ columns that fall
    /// linearly with altitude, C = 1 − 0.00898 z. Kept to reproduce its Table 3.1, not to be used.
    #[must_use]
    pub fn utm2005() -> Self {
        UTM2005.clone()
    }

    /// Reads a profile; `name` is the file's name, for errors.
    ///
    /// # Errors
    /// The first thing that is wrong, with file, line and column.
    pub fn from_csv_str(name: &str, text: &str) -> Result<Self, ProfileError> {
        let table = Table::read(name, text, &COLUMNS, MIN_ROWS)?;
        check_altitudes(&table)?;
        if table.optional_column(WATER).is_some() && table.optional_column(HUMIDITY).is_some() {
            return Err(ProfileError::ConflictingColumns {
                file: name.to_owned(),
                line: table.header_line,
                expected: COLUMNS[WATER].name,
                found: COLUMNS[HUMIDITY].name,
            });
        }
        let mut nodes = Nodes::complete(&table)?;
        nodes.check_balance(&table)?;
        let continued_above_km = nodes.continue_to_top();
        let pairs = nodes
            .air
            .iter()
            .map(|n| (OXYGEN_MOLE_FRACTION * n).powi(2))
            .collect();
        let on_nodes = |value: Vec<f64>| LogLinear::new(&nodes.altitude_km, value);
        Ok(Self {
            name: name.to_owned(),
            pressure_hpa: on_nodes(nodes.pressure),
            air: on_nodes(nodes.air),
            ozone: on_nodes(nodes.ozone),
            no2: on_nodes(nodes.no2),
            water: on_nodes(nodes.water),
            oxygen_pairs: on_nodes(pairs),
            temperature_k: nodes.temperature,
            continued_above_km,
            altitude_km: nodes.altitude_km,
        })
    }

    /// The name it was read under.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Altitudes of the nodes \[km\].
    #[must_use]
    pub fn altitude_km(&self) -> &[f64] {
        &self.altitude_km
    }

    /// Where the given profile ends and the general atmosphere's shape continues it.
    #[must_use]
    pub fn continued_above(&self) -> Option<Length> {
        self.continued_above_km.map(Length::from_km)
    }

    /// Air temperature \[K\].
    #[must_use]
    pub fn temperature_k(&self, altitude: Length) -> f64 {
        interpolate(&self.altitude_km, &self.temperature_k, altitude.km())
    }

    /// Air pressure \[hPa\].
    #[must_use]
    pub fn pressure_hpa(&self, altitude: Length) -> f64 {
        self.pressure_hpa.at(altitude.km())
    }

    /// Molecules per volume \[m⁻³\].
    #[must_use]
    pub fn number_density_per_m3(&self, gas: Gas, altitude: Length) -> f64 {
        self.gas(gas).at(altitude.km())
    }

    /// Molecules above an altitude \[m⁻²\].
    #[must_use]
    pub fn column_above_per_m2(&self, gas: Gas, altitude: Length) -> f64 {
        self.gas(gas).above(altitude.km())
    }

    /// Square of the O₂ number density \[m⁻⁶\].
    #[must_use]
    pub fn oxygen_pairs_per_m6(&self, altitude: Length) -> f64 {
        self.oxygen_pairs.at(altitude.km())
    }

    /// Integral of the square of the O₂ number density above an altitude \[m⁻⁵\].
    #[must_use]
    pub fn oxygen_pairs_above_per_m5(&self, altitude: Length) -> f64 {
        self.oxygen_pairs.above(altitude.km())
    }

    /// Precipitable water above an altitude \[cm\].
    #[must_use]
    pub fn water_column_cm(&self, altitude: Length) -> f64 {
        // 1 g per cm² of liquid water is 1 cm deep.
        1e-4 * self.column_above_per_m2(Gas::WaterVapor, altitude) * WATER_MOLECULE_G
    }

    /// Relative humidity over liquid water \[%\].
    #[must_use]
    pub fn relative_humidity_percent(&self, altitude: Length) -> f64 {
        let temperature_k = self.temperature_k(altitude);
        let density = self.number_density_per_m3(Gas::WaterVapor, altitude);
        let vapor_hpa = 0.01 * density * BOLTZMANN_J_PER_K * temperature_k;
        100.0 * vapor_hpa / saturation_vapor_pressure_hpa(temperature_k)
    }

    /// All quantities at one altitude.
    #[must_use]
    pub fn row(&self, altitude: Length) -> ProfileRow {
        let temperature_k = self.temperature_k(altitude);
        let pressure_hpa = self.pressure_hpa(altitude);
        let density = |gas| self.number_density_per_m3(gas, altitude);
        let atm_cm = |gas| self.column_above_per_m2(gas, altitude) / ozone::MOLECULES_PER_M2_ATM_CM;
        ProfileRow {
            altitude_km: altitude.km(),
            pressure_hpa,
            temperature_k,
            ozone_effective_temperature_k: ozone::effective_temperature_k(temperature_k),
            relative_humidity_percent: self.relative_humidity_percent(altitude),
            air_number_density_per_m3: density(Gas::Air),
            ozone_number_density_per_m3: density(Gas::Ozone),
            no2_number_density_per_m3: density(Gas::NitrogenDioxide),
            water_number_density_per_m3: density(Gas::WaterVapor),
            o2_path_km: gueymard_path_km([4.9293, 1.8849, 0.1815], pressure_hpa, temperature_k),
            co2_path_km: gueymard_path_km([4.8649, 1.9908, -0.697], pressure_hpa, temperature_k),
            water_column_cm: self.water_column_cm(altitude),
            ozone_column_atm_cm: atm_cm(Gas::Ozone),
            no2_column_atm_cm: atm_cm(Gas::NitrogenDioxide),
        }
    }

    const fn gas(&self, gas: Gas) -> &LogLinear {
        match gas {
            Gas::Air => &self.air,
            Gas::Ozone => &self.ozone,
            Gas::NitrogenDioxide => &self.no2,
            Gas::WaterVapor => &self.water,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_exponential_integrates_exactly() {
        let z: Vec<f64> = (0..=100).map(f64::from).collect();
        let n: Vec<f64> = z.iter().map(|z| 3.0 * (-z / 7.0).exp()).collect();
        let column = LogLinear::new(&z, n);
        for at in [0.0, 0.37, 12.5, 99.9_f64] {
            let want = 3.0 * 7e3 * ((-at / 7.0).exp() - (-100.0_f64 / 7.0).exp());
            assert!((column.above(at) / want - 1.0).abs() < 1e-10);
            assert!((column.at(at) / (3.0 * (-at / 7.0).exp()) - 1.0).abs() < 1e-12);
        }
        assert!(column.above(100.0).abs() < 1e-12);
    }

    #[test]
    fn reference_columns() {
        let general = AtmosphereProfile::general();
        let air = general.column_above_per_m2(Gas::Air, Length::ZERO);
        assert!((air / 2.152_827e29 - 1.0).abs() < 1e-6);
        let ozone = general.column_above_per_m2(Gas::Ozone, Length::ZERO);
        assert!((ozone / 9.226_41e22 - 1.0).abs() < 1e-5);
        let pairs = general.oxygen_pairs_above_per_m5(Length::ZERO);
        // 1.3203e43 cm^-5 on the pack's own, finer grid.
        assert!((pairs / 1.3203e53 - 1.0).abs() < 2e-3);
        assert!((general.water_column_cm(Length::ZERO) / 1.4164 - 1.0).abs() < 2e-3);
        assert_eq!(general.continued_above(), None);
    }

    #[test]
    fn humidity_of_the_standard_atmosphere() {
        // US 1976 with the AFGL water, over liquid: 46, 50, 13, 0.8 % at 0, 6, 12, 20 km; the report
        // prints others.
        let general = AtmosphereProfile::general();
        for (km, percent, slack) in [
            (0.0, 46.0, 0.5),
            (6.0, 50.0, 0.6),
            (12.0, 13.0, 0.5),
            (20.0, 0.8, 0.05),
        ] {
            let found = general.relative_humidity_percent(Length::from_km(km));
            assert!((found - percent).abs() <= slack, "{km} km: {found}");
        }
    }
}
