//! The look-up table: sky coefficients over altitude, turbidity and sun zenith, and its file format.
//!
//! A table knows where it comes from and where it is valid, and can be read without this project. Out
//! of scope: what lies between nodes (`UtmSky`), and files as such: everything here is bytes and text.
//!
//! # The format `.utmlut`, version 1
//! All integers and floats are little-endian.
//!
//! | offset | bytes | content |
//! |---|---|---|
//! | 0 | 12 | magic: `89 55 54 4d 4c 55 54 0d 0a 1a 0a 00` (`\x89UTMLUT\r\n\x1a\n\0`) |
//! | 12 | 4 | version, u32 |
//! | 16 | 4 | length H of the header in bytes, u32 |
//! | 20 | 4 | length D of the data in bytes, u32 |
//! | 24 | H | header: a JSON object in UTF-8, filled up with spaces so that the data begin at a multiple of 8 |
//! | 24 + H | D | data, as the header's `storage` says |
//! | 24 + H + D | 8 | checksum, u64: CRC-64/XZ of everything before it |
//!
//! With storage `f32` the data are the values, f32. With storage `linear16` they begin with two f32 for
//! each value of a node, the least and the largest that it takes in the table; then follow the
//! values as u16: 0 is the least, 65535 the largest, linear between.
//!
//! The file ends there; a shorter or longer one is refused. The first byte and the line ends of the
//! magic show a file that was sent as text. A CRC finds every single flipped bit, its own included,
//! and every burst of up to 64 bits.
//!
//! An axis may have a single node: then the sky is the same all along it, and the domain says how far
//! it may be used. A table of the extended form may leave terms out: they are 0.
//!
//! The header is a [`LutHeader`], field by field. Values run over \[altitude\]\[turbidity\]\[sun
//! zenith\]\[channel\]\[term\], the last fastest; the header names the channels and the terms. The
//! same table is always encoded to the same bytes.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde::{Deserialize, Serialize};

use crate::axis::Axis;
use crate::conditions::Domain;
use crate::extended;
use crate::extinction::{Extinction, LEVELS};

/// First bytes of every file.
pub const MAGIC: [u8; 12] = *b"\x89UTMLUT\r\n\x1a\n\0";

/// The version that is written, and the only one that is read.
pub const VERSION: u32 = 1;

/// The channels, in the order of the values: luminance \[cd·m⁻²\] and CIE 1931 chromaticity.
pub const CHANNELS: [&str; 3] = ["Y", "x", "y"];

/// Bytes before the header.
const PRELUDE_BYTES: usize = 24;
/// Bytes of the checksum.
const CHECKSUM_BYTES: usize = 8;
/// The values begin at a multiple of this.
const ALIGNMENT: usize = 8;

/// The sky formula that a table's values belong to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Form {
    /// Perez's formula with the printed 1/cos θ.
    PerezReport,
    /// Perez's formula with a spherical relative air mass.
    PerezSpherical,
    /// Products of a factor of the air mass and a factor of the angle from the sun, summed: see
    /// [`crate::extended`].
    Extended,
}

/// Zenith value and Perez's coefficients.
const PEREZ_TERMS: &[&str] = &["zenith", "A", "B", "C", "D", "E"];

impl Form {
    /// Every form.
    pub const ALL: [Self; 3] = [Self::PerezReport, Self::PerezSpherical, Self::Extended];

    /// Names of the values of one channel, in their order; `zenith` is the value at the zenith.
    #[must_use]
    pub const fn terms(self) -> &'static [&'static str] {
        match self {
            Self::PerezReport | Self::PerezSpherical => PEREZ_TERMS,
            Self::Extended => &extended::TERM_NAMES,
        }
    }

    /// The name in files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::PerezReport => "perez-report",
            Self::PerezSpherical => "perez-spherical",
            Self::Extended => "extended",
        }
    }
}

/// How a sky between the nodes is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Interpolation {
    /// The report's rule: four-point Lagrange in altitude on the colors of the layers.
    ReportLagrange,
    /// Linear on logarithms of luminance and on chromaticities, in altitude, in ln(T − 0.7) and in the
    /// sun's zenith angle: cannot overshoot or turn negative.
    LogLinear,
}

impl Interpolation {
    /// Every rule.
    pub const ALL: [Self; 2] = [Self::ReportLagrange, Self::LogLinear];

    /// The name in files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::ReportLagrange => "report-lagrange",
            Self::LogLinear => "log-linear",
        }
    }
}

/// How a file holds the values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Storage {
    /// Four bytes a value.
    #[default]
    F32,
    /// Two bytes a value, between the least and the largest that it takes in the table.
    Linear16,
}

/// Median, 95th percentile and largest of an error.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ErrorQuantiles {
    /// Half of the errors lie below.
    pub median: f64,
    /// 95 % of the errors lie below.
    pub p95: f64,
    /// The largest.
    pub max: f64,
}

/// How well the table meets the skies that it was fitted to: those at the nodes, and for the extended
/// form also half way between altitudes and suns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FitStatistics {
    /// CIEDE2000 color difference over all their directions.
    pub delta_e_2000: ErrorQuantiles,
    /// Relative error of luminance over all their directions \[1\].
    pub luminance_relative_error: ErrorQuantiles,
}

/// What a table says about itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LutHeader {
    /// The sky formula.
    pub form: Form,
    /// How the values are stored.
    pub storage: Storage,
    /// The rule between nodes.
    pub interpolation: Interpolation,
    /// Observer altitudes; the unit is `km`.
    pub altitude_km: Axis,
    /// Turbidities; the unit is `1`.
    pub turbidity: Axis,
    /// Sun zenith angles; the unit is `deg`.
    pub sun_zenith_deg: Axis,
    /// Names of the channels: [`CHANNELS`].
    pub channels: Vec<String>,
    /// Names of the values of a channel: those of the form, in its order; the extended form may lack some.
    pub terms: Vec<String>,
    /// Name of the atmosphere's profile.
    pub profile_name: String,
    /// SHA-256 of the profile's bytes, in hexadecimal digits.
    pub profile_sha256: String,
    /// Program and version that made the table.
    pub generator: String,
    /// The engine that computed the skies.
    pub engine: String,
    /// Settings of the engine and the fit, by name; [`Self::planned`] reads those of a plan.
    pub settings: BTreeMap<String, serde_json::Value>,
    /// Errors of the fit.
    pub fit: FitStatistics,
    /// Extinction of the atmosphere, for aerial perspective and the sun's light.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub extinction: Option<Extinction>,
    /// Where the table is valid; lies within the axes, or holds the node of an axis that has but one.
    pub domain: Domain,
}

impl LutHeader {
    /// What a plan chose for the renderer under a name (`tier`, `aerial`), where the table was baked
    /// from one.
    #[must_use]
    pub fn planned(&self, name: &str) -> Option<&str> {
        self.settings.get(name)?.as_str()
    }

    /// Number of values of one channel at one node.
    #[must_use]
    pub fn terms_per_channel(&self) -> usize {
        self.terms.len()
    }

    /// Number of values at one node.
    #[must_use]
    pub fn values_per_node(&self) -> usize {
        self.channels.len() * self.terms.len()
    }

    /// Number of nodes along altitude, turbidity and sun zenith.
    #[must_use]
    pub fn shape(&self) -> [usize; 3] {
        [
            self.altitude_km.len(),
            self.turbidity.len(),
            self.sun_zenith_deg.len(),
        ]
    }

    /// The axes with the units that they must have and the bounds of the domain.
    fn axes(&self) -> [(&'static str, &'static str, &Axis, [f64; 2]); 3] {
        let d = &self.domain;
        [
            ("altitude_km", "km", &self.altitude_km, d.altitude_km),
            ("turbidity", "1", &self.turbidity, d.turbidity),
            (
                "sun_zenith_deg",
                "deg",
                &self.sun_zenith_deg,
                d.sun_zenith_deg,
            ),
        ]
    }

    /// Whether the parts fit together, and how many values the table has.
    fn check(&self) -> Result<usize, LutError> {
        for (axis, expected, found, domain) in self.axes() {
            if found.unit() != expected {
                return Err(LutError::Unit { axis, expected });
            }
            let [low, high] = found.bounds();
            let fits = if found.len() == 1 {
                domain[0] <= low && high <= domain[1]
            } else {
                domain[0] >= low && domain[0] <= domain[1] && domain[1] <= high
            };
            if !(fits && domain.iter().all(|bound| bound.is_finite())) {
                return Err(LutError::Domain {
                    axis,
                    expected: found.bounds(),
                    found: domain,
                });
            }
        }
        for (what, expected, found) in [
            ("channels", CHANNELS.as_slice(), &self.channels),
            ("terms", self.form.terms(), &self.terms),
        ] {
            let names_fit = if what == "terms" && self.form == Form::Extended {
                !found.is_empty() && extended::slots(found).is_some()
            } else {
                found == expected
            };
            if !names_fit {
                return Err(LutError::Names {
                    what,
                    form: self.form,
                    expected,
                });
            }
        }
        if self.extinction.as_ref().is_some_and(|e| !e.is_valid()) {
            return Err(LutError::Extinction);
        }
        for (what, q) in [
            ("delta_e_2000", &self.fit.delta_e_2000),
            (
                "luminance_relative_error",
                &self.fit.luminance_relative_error,
            ),
        ] {
            for found in [q.median, q.p95, q.max] {
                if !found.is_finite() {
                    return Err(LutError::Statistics { what, found });
                }
            }
        }
        let product = |all: usize, count: usize| all.checked_mul(count);
        self.shape()
            .into_iter()
            .chain([self.values_per_node()])
            .try_fold(1, product)
            // The file counts bytes, at most 4 a value.
            .filter(|count| u32::try_from(count.saturating_mul(4)).is_ok())
            .ok_or(LutError::TooLarge {
                shape: self.shape(),
            })
    }
}

/// Why bytes or values are no look-up table.
#[derive(Debug, thiserror::Error)]
pub enum LutError {
    /// The file begins otherwise: it is of another kind.
    #[error(
        "byte {offset}: expected 0x{expected:02x} of a .utmlut file, found 0x{found:02x}: a file of another kind"
    )]
    Foreign {
        /// Place of the first byte that differs.
        offset: usize,
        /// The byte of the format.
        expected: u8,
        /// The byte of the file.
        found: u8,
    },
    /// A version that this program does not read.
    #[error("byte 12: expected version {expected} of the .utmlut format, found {found}")]
    Version {
        /// The version that is read.
        expected: u32,
        /// The version of the file.
        found: u32,
    },
    /// The end is missing.
    #[error("truncated: expected {expected} bytes, found {found}")]
    Truncated {
        /// Length that the file should have.
        expected: u64,
        /// Length that it has.
        found: u64,
    },
    /// Something follows the end.
    #[error("byte {expected}: expected the end of the file, found {} more bytes", found - expected)]
    TooLong {
        /// Length that the file should have.
        expected: u64,
        /// Length that it has.
        found: u64,
    },
    /// The content is not what was written.
    #[error("damaged: expected checksum {expected:016x}, found {found:016x}")]
    Checksum {
        /// The checksum that the file states.
        expected: u64,
        /// The checksum of its bytes.
        found: u64,
    },
    /// The header is not the JSON that the format asks for.
    #[error("header: {0}")]
    Header(#[from] serde_json::Error),
    /// An axis in another unit.
    #[error("header: {axis}: expected the unit {expected}, found another")]
    Unit {
        /// Which axis.
        axis: &'static str,
        /// Its unit.
        expected: &'static str,
    },
    /// A domain that the axes do not cover.
    #[error("header: domain: {axis}: expected bounds within {} to {}, found {} to {}",
        expected[0], expected[1], found[0], found[1])]
    Domain {
        /// Which axis.
        axis: &'static str,
        /// First and last node.
        expected: [f64; 2],
        /// Bounds of the domain.
        found: [f64; 2],
    },
    /// Channels or terms that do not belong to the form.
    #[error("header: {what}: expected {} for the form {}, found others", expected.join(" "), form.name())]
    Names {
        /// `channels` or `terms`.
        what: &'static str,
        /// The form.
        form: Form,
        /// The names.
        expected: &'static [&'static str],
    },
    /// A statistic that is not finite.
    #[error("header: fit: {what}: expected finite numbers, found {found}")]
    Statistics {
        /// Which statistic.
        what: &'static str,
        /// The value.
        found: f64,
    },
    /// An extinction that is none.
    #[error(
        "header: extinction: expected finite numbers that are not negative and {LEVELS} levels, found others"
    )]
    Extinction,
    /// More values than a file can hold.
    #[error("header: {} x {} x {} nodes: expected fewer than 2^30 values", shape[0], shape[1], shape[2])]
    TooLarge {
        /// Nodes along the axes.
        shape: [usize; 3],
    },
    /// The number of values does not belong to the axes.
    #[error("values: expected {expected} for the axes of the header, found {found}")]
    Shape {
        /// Nodes times values of a node.
        expected: usize,
        /// Number of values.
        found: usize,
    },
    /// A value that is NaN or infinite, or too large for f32.
    #[error("value {index}: expected a finite number, found {found}")]
    NotFinite {
        /// Place among the values, from 0.
        index: usize,
        /// The value.
        found: f64,
    },
}

/// A look-up table whose parts are known to fit together.
#[derive(Clone, Debug, PartialEq)]
pub struct Lut {
    header: LutHeader,
    data: Vec<f32>,
    /// Place of each stored term among those of the form.
    slots: Vec<usize>,
}

impl Lut {
    /// From a header and values over \[altitude\]\[turbidity\]\[sun zenith\]\[channel\]\[term\]. Under
    /// [`Storage::Linear16`] the values become those that the file will hold.
    ///
    /// # Errors
    /// When the header contradicts itself, or the values are too many, too few or not finite.
    pub fn new(header: LutHeader, data: Vec<f32>) -> Result<Self, LutError> {
        let expected = header.check()?;
        if data.len() != expected {
            return Err(LutError::Shape {
                expected,
                found: data.len(),
            });
        }
        let slots = match header.form {
            Form::Extended => extended::slots(&header.terms).unwrap_or_default(),
            Form::PerezReport | Form::PerezSpherical => (0..header.terms.len()).collect(),
        };
        match data.iter().position(|value| !value.is_finite()) {
            Some(index) => Err(LutError::NotFinite {
                index,
                found: data[index].into(),
            }),
            None => Ok(match header.storage {
                Storage::F32 => Self {
                    header,
                    data,
                    slots,
                },
                Storage::Linear16 => {
                    let scales = Scale::of(&data, header.values_per_node());
                    let data = data
                        .iter()
                        .zip(scales.iter().cycle())
                        .map(|(value, scale)| scale.value(scale.index(*value)))
                        .collect();
                    Self {
                        header,
                        data,
                        slots,
                    }
                }
            }),
        }
    }

    /// From values in double precision, each rounded to the nearest f32.
    ///
    /// # Errors
    /// As [`Self::new`]; a value beyond the range of f32 counts as not finite.
    pub fn from_f64(header: LutHeader, data: &[f64]) -> Result<Self, LutError> {
        Self::new(
            header,
            data.iter().map(|value| f32_from_f64(*value)).collect(),
        )
    }

    /// What the table says about itself.
    #[must_use]
    pub fn header(&self) -> &LutHeader {
        &self.header
    }

    /// All values.
    #[must_use]
    pub fn data(&self) -> &[f32] {
        &self.data
    }

    /// Place of each stored term among those of the form.
    #[must_use]
    pub fn term_slots(&self) -> &[usize] {
        &self.slots
    }

    /// The values of one node, \[channel\]\[term\].
    ///
    /// # Panics
    /// When an index is not below the length of its axis.
    #[must_use]
    pub fn node(&self, altitude: usize, turbidity: usize, sun_zenith: usize) -> &[f32] {
        let [altitudes, turbidities, suns] = self.header.shape();
        assert!(
            altitude < altitudes && turbidity < turbidities && sun_zenith < suns,
            "node [{altitude}][{turbidity}][{sun_zenith}] of {altitudes} x {turbidities} x {suns}"
        );
        let count = self.header.values_per_node();
        let first = ((altitude * turbidities + turbidity) * suns + sun_zenith) * count;
        &self.data[first..first + count]
    }

    /// The file's bytes; always the same for the same table.
    ///
    /// # Panics
    /// Never: the header of a table is checked, and can be written as JSON.
    #[must_use]
    pub fn encode(&self) -> Vec<u8> {
        let mut header = serde_json::to_vec(&self.header).expect("a checked header");
        let end = (PRELUDE_BYTES + header.len()).next_multiple_of(ALIGNMENT);
        header.resize(end - PRELUDE_BYTES, b' ');
        let data: Vec<u8> = match self.header.storage {
            Storage::F32 => self
                .data
                .iter()
                .flat_map(|value| value.to_le_bytes())
                .collect(),
            Storage::Linear16 => {
                let scales = Scale::of(&self.data, self.header.values_per_node());
                let indices = self
                    .data
                    .iter()
                    .zip(scales.iter().cycle())
                    .flat_map(|(value, scale)| scale.index(*value).to_le_bytes());
                let ranges = scales.iter().flat_map(|s| [s.least, s.largest]);
                ranges.flat_map(f32::to_le_bytes).chain(indices).collect()
            }
        };
        let count = |n: usize| u32::try_from(n).expect("a checked header").to_le_bytes();
        let mut bytes = Vec::with_capacity(end + data.len() + CHECKSUM_BYTES);
        bytes.extend(MAGIC);
        bytes.extend(VERSION.to_le_bytes());
        bytes.extend(count(header.len()));
        bytes.extend(count(data.len()));
        bytes.extend(header);
        bytes.extend(data);
        bytes.extend(crc_64_xz(&bytes).to_le_bytes());
        bytes
    }

    /// From a file's bytes.
    ///
    /// Takes no more memory than the bytes do, whatever lengths they claim.
    ///
    /// # Errors
    /// When the file is of another kind or version, incomplete, damaged or contradicts itself.
    pub fn decode(bytes: &[u8]) -> Result<Self, LutError> {
        for (offset, (expected, found)) in MAGIC.into_iter().zip(bytes.iter().copied()).enumerate()
        {
            if expected != found {
                return Err(LutError::Foreign {
                    offset,
                    expected,
                    found,
                });
            }
        }
        let found = bytes.len() as u64;
        let truncated = |expected| LutError::Truncated { expected, found };
        let least = (PRELUDE_BYTES + CHECKSUM_BYTES) as u64;
        let number = |offset: usize| {
            bytes
                .get(offset..)
                .and_then(|rest| rest.first_chunk())
                .map(|chunk| u32::from_le_bytes(*chunk))
                .ok_or_else(|| truncated(least))
        };
        let version = number(12)?;
        if version != VERSION {
            return Err(LutError::Version {
                expected: VERSION,
                found: version,
            });
        }
        let (header_bytes, data_bytes) = (number(16)?, number(20)?);
        let expected = least + u64::from(header_bytes) + u64::from(data_bytes);
        if found < expected {
            return Err(truncated(expected));
        }
        if found > expected {
            return Err(LutError::TooLong { expected, found });
        }
        let (content, checksum) = bytes
            .split_last_chunk::<CHECKSUM_BYTES>()
            .ok_or_else(|| truncated(least))?;
        let (expected, found) = (u64::from_le_bytes(*checksum), crc_64_xz(content));
        if expected != found {
            return Err(LutError::Checksum { expected, found });
        }
        let (header, data) = content[PRELUDE_BYTES..].split_at(header_bytes as usize);
        let header: LutHeader = serde_json::from_slice(header)?;
        let floats = |bytes: &[u8]| -> Vec<f32> {
            bytes
                .as_chunks()
                .0
                .iter()
                .map(|chunk| f32::from_le_bytes(*chunk))
                .collect()
        };
        let (found, odd, data) = match header.storage {
            Storage::F32 => (data.len() / 4, data.len() % 4, floats(data)),
            Storage::Linear16 => {
                let (ranges, indices) =
                    data.split_at((8 * header.values_per_node()).min(data.len()));
                let scales: Vec<Scale> = floats(ranges)
                    .as_chunks()
                    .0
                    .iter()
                    .map(|[least, largest]| Scale {
                        least: *least,
                        largest: *largest,
                    })
                    .collect();
                let values = indices
                    .as_chunks()
                    .0
                    .iter()
                    .zip(scales.iter().cycle())
                    .map(|(chunk, scale)| scale.value(u16::from_le_bytes(*chunk)))
                    .collect();
                (indices.len() / 2, indices.len() % 2, values)
            }
        };
        let expected = header.check()?;
        if found != expected || odd != 0 {
            return Err(LutError::Shape { expected, found });
        }
        Self::new(header, data)
    }

    /// The table as CSV, in the layout of Appendix A of the report.
    ///
    /// Columns: `reference_altitude_km,turbidity,sun_zenith_deg,sun_azimuth_deg`; then for each channel
    /// its coefficients, `A_Y` to `E_Y`, `A_x` to `E_x`, `A_y` to `E_y` (and what else the form has); then
    /// `zenith_Y_cd_m2,zenith_x,zenith_y`. One row a node; altitude changes slowest, then turbidity.
    ///
    /// A sky turns with its sun, so the table has no axis for the sun's azimuth and its column is
    /// empty. Tables under the report's rule are written with the report's suns: from the east (90°)
    /// over the zenith (0°) to the west (270°), each node twice but the one at the zenith; 5 × 3 × 5
    /// rows for the report's grid.
    #[must_use]
    pub fn to_csv_string(&self) -> String {
        let h = &self.header;
        let terms = h.terms.len();
        let mut out = "reference_altitude_km,turbidity,sun_zenith_deg,sun_azimuth_deg".to_owned();
        for channel in &h.channels {
            for term in h.terms.iter().filter(|term| *term != ZENITH) {
                push(&mut out, format_args!(",{term}_{channel}"));
            }
        }
        out.push_str(",zenith_Y_cd_m2,zenith_x,zenith_y\n");
        let is_zenith = |i: usize| h.terms[i % terms] == ZENITH;
        for (a, altitude) in h.altitude_km.nodes().iter().enumerate() {
            for (t, turbidity) in h.turbidity.nodes().iter().enumerate() {
                for (s, azimuth) in self.suns() {
                    let sun = h.sun_zenith_deg.nodes()[s];
                    push(
                        &mut out,
                        format_args!("{altitude},{turbidity},{sun},{azimuth}"),
                    );
                    let node = self.node(a, t, s);
                    let (zenith, shape): (Vec<usize>, Vec<usize>) =
                        (0..node.len()).partition(|i| is_zenith(*i));
                    for i in shape.into_iter().chain(zenith) {
                        push(&mut out, format_args!(",{}", node[i]));
                    }
                    out.push('\n');
                }
            }
        }
        out
    }

    /// The suns of the CSV: index of the node, and azimuth in degrees or nothing.
    fn suns(&self) -> Vec<(usize, &'static str)> {
        let nodes = self.header.sun_zenith_deg.nodes();
        match self.header.interpolation {
            Interpolation::LogLinear => (0..nodes.len()).map(|s| (s, "")).collect(),
            Interpolation::ReportLagrange => {
                let low: Vec<usize> = (0..nodes.len()).filter(|s| nodes[*s] > 0.0).collect();
                let east = low.iter().rev().map(|s| (*s, "90"));
                let zenith = (0..nodes.len() - low.len()).map(|s| (s, "0"));
                let west = low.iter().map(|s| (*s, "270"));
                east.chain(zenith).chain(west).collect()
            }
        }
    }
}

/// The term that is a channel's value at the zenith.
const ZENITH: &str = "zenith";

/// Appends to a text.
fn push(out: &mut String, piece: core::fmt::Arguments<'_>) {
    // A `String` takes everything.
    let _ = out.write_fmt(piece);
}

/// The range of one value of a node over the table.
#[derive(Clone, Copy, Debug)]
struct Scale {
    least: f32,
    largest: f32,
}

impl Scale {
    /// The ranges of all values of a node.
    fn of(data: &[f32], values_per_node: usize) -> Vec<Self> {
        (0..values_per_node)
            .map(|i| {
                let column = data.iter().skip(i).step_by(values_per_node);
                column.fold(
                    Self {
                        least: f32::INFINITY,
                        largest: f32::NEG_INFINITY,
                    },
                    |s, v| Self {
                        least: s.least.min(*v),
                        largest: s.largest.max(*v),
                    },
                )
            })
            .collect()
    }

    /// The nearest index of a value.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "rounding to an index is what is wanted; the value lies within the range"
    )]
    fn index(self, value: f32) -> u16 {
        let [least, largest, value] = [self.least, self.largest, value].map(f64::from);
        if largest > least {
            ((value - least) / (largest - least) * f64::from(u16::MAX)).round() as u16
        } else {
            0
        }
    }

    /// The value of an index; least and largest come out exactly.
    fn value(self, index: u16) -> f32 {
        let share = f64::from(index) / f64::from(u16::MAX);
        f32_from_f64(f64::from(self.least) * (1.0 - share) + f64::from(self.largest) * share)
    }
}

/// The nearest f32; the only place where the project's numbers lose digits.
#[expect(
    clippy::cast_possible_truncation,
    reason = "rounding to the nearest f32 is what is wanted; an overflow gives infinity"
)]
const fn f32_from_f64(value: f64) -> f32 {
    value as f32
}

/// CRC-64/XZ: reflected polynomial of ECMA-182, all ones before and after.
///
/// Source: the .xz file format 1.1.0, section 6.
fn crc_64_xz(bytes: &[u8]) -> u64 {
    const TABLE: [u64; 256] = crc_table();
    !bytes.iter().fold(u64::MAX, |crc, byte| {
        let [low, ..] = crc.to_le_bytes();
        TABLE[usize::from(low ^ byte)] ^ (crc >> 8)
    })
}

const fn crc_table() -> [u64; 256] {
    const POLYNOMIAL: u64 = 0xC96C_5795_D787_0F42;
    let mut table = [0; 256];
    let mut byte = 0;
    while byte < 256 {
        let mut crc = byte as u64;
        let mut bit = 0;
        while bit < 8 {
            crc = if crc & 1 == 1 {
                (crc >> 1) ^ POLYNOMIAL
            } else {
                crc >> 1
            };
            bit += 1;
        }
        table[byte] = crc;
        byte += 1;
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_checksum_is_that_of_xz() {
        // Check value of CRC-64/XZ in the catalogue of parametrised CRC algorithms.
        assert_eq!(crc_64_xz(b"123456789"), 0x995D_C9BB_DF19_39FA);
        assert_eq!(crc_64_xz(b""), 0);
    }

    #[test]
    fn names_are_those_of_the_file() {
        for form in Form::ALL {
            let json = serde_json::to_string(&form).unwrap();
            assert_eq!(json, format!("\"{}\"", form.name()));
            // Perez's formula is relative to the zenith, the extended one is not
            let zeniths = form.terms().iter().filter(|t| **t == ZENITH).count();
            assert_eq!(zeniths, usize::from(form != Form::Extended));
        }
        for rule in Interpolation::ALL {
            let json = serde_json::to_string(&rule).unwrap();
            assert_eq!(json, format!("\"{}\"", rule.name()));
        }
    }
}
