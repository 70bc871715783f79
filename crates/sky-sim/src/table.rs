//! CSV tables of numbers, read strictly: every column is known, every cell is a finite number.
//!
//! Shared by the profile, optics and solar readers. Text comes in as `&str`; this module opens no
//! file, `file` is only the name that errors print. Lines starting with `#` are comments.

use thiserror::Error;

/// What a CSV table can get wrong: file, line, column, what was expected and what was found.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum TableError {
    /// No header line.
    #[error("{file}:1: expected a header with {expected}, found an empty file")]
    Empty {
        /// Name of the file.
        file: String,
        /// The columns that were expected.
        expected: String,
    },
    /// A spreadsheet's separator.
    #[error("{file}:{line}: expected commas between the cells, found semicolons")]
    Semicolons {
        /// Name of the file.
        file: String,
        /// Line of the header.
        line: u64,
    },
    /// A required column is absent.
    #[error("{file}:{line}: column {column}: expected in the header, found only {found}")]
    MissingColumn {
        /// Name of the file.
        file: String,
        /// Line of the header.
        line: u64,
        /// The absent column.
        column: &'static str,
        /// The header that was read.
        found: String,
    },
    /// The quantity is known, but its unit is not the one that the format asks for.
    #[error("{file}:{line}: column {found}: expected the unit of {expected}, found {found}")]
    WrongUnit {
        /// Name of the file.
        file: String,
        /// Line of the header.
        line: u64,
        /// The column name that was expected.
        expected: &'static str,
        /// The column name that was found.
        found: String,
    },
    /// A column that the format does not know.
    #[error("{file}:{line}: column {found}: expected one of {expected}, found {found}")]
    UnknownColumn {
        /// Name of the file.
        file: String,
        /// Line of the header.
        line: u64,
        /// The columns that the format knows.
        expected: String,
        /// The column name that was found.
        found: String,
    },
    /// A column stands twice in the header.
    #[error("{file}:{line}: column {column}: expected once, found twice")]
    DuplicateColumn {
        /// Name of the file.
        file: String,
        /// Line of the header.
        line: u64,
        /// The repeated column.
        column: &'static str,
    },
    /// A row with more or fewer cells than the header.
    #[error("{file}:{line}: expected {expected} cells as in the header, found {found}")]
    RaggedRow {
        /// Name of the file.
        file: String,
        /// Line of the row.
        line: u64,
        /// Cells in the header.
        expected: usize,
        /// Cells in the row.
        found: usize,
    },
    /// Text where a number should be.
    #[error("{file}:{line}: column {column}: expected a number, found {found:?}")]
    NotANumber {
        /// Name of the file.
        file: String,
        /// Line of the row.
        line: u64,
        /// Column of the cell.
        column: &'static str,
        /// The cell's text.
        found: String,
    },
    /// An empty cell in a column that allows none.
    #[error("{file}:{line}: column {column}: expected a number, found an empty cell")]
    EmptyCell {
        /// Name of the file.
        file: String,
        /// Line of the row.
        line: u64,
        /// Column of the cell.
        column: &'static str,
    },
    /// NaN or an infinity.
    #[error("{file}:{line}: column {column}: expected a finite number, found {found}")]
    NotFinite {
        /// Name of the file.
        file: String,
        /// Line of the row.
        line: u64,
        /// Column of the cell.
        column: &'static str,
        /// The value.
        found: f64,
    },
    /// A number outside its physical bounds.
    #[error(
        "{file}:{line}: column {column}: expected {} to {}, found {found}",
        expected[0],
        expected[1]
    )]
    OutOfRange {
        /// Name of the file.
        file: String,
        /// Line of the row.
        line: u64,
        /// Column of the cell.
        column: &'static str,
        /// The bounds, both allowed.
        expected: [f64; 2],
        /// The value.
        found: f64,
    },
    /// Fewer rows than the format needs.
    #[error("{file}:{line}: expected at least {expected} rows, found {found}")]
    TooFewRows {
        /// Name of the file.
        file: String,
        /// Last line.
        line: u64,
        /// Rows that are needed.
        expected: usize,
        /// Rows that were read.
        found: usize,
    },
    /// A value that does not ascend from row to row.
    #[error("{file}:{line}: column {column}: expected more than {previous}, found {found}")]
    NotAscending {
        /// Name of the file.
        file: String,
        /// Line of the row.
        line: u64,
        /// The column.
        column: &'static str,
        /// Value of the row before.
        previous: f64,
        /// Value of this row.
        found: f64,
    },
}

/// A column that a format knows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColumnSpec {
    /// Name with unit, as it stands in the header.
    pub name: &'static str,
    /// Whether the header must have it.
    pub required: bool,
    /// Whether cells may be empty.
    pub gaps: bool,
    /// Smallest and largest value allowed.
    pub range: [f64; 2],
}

impl ColumnSpec {
    /// A required column without gaps.
    #[must_use]
    pub const fn required(name: &'static str, range: [f64; 2]) -> Self {
        Self {
            name,
            required: true,
            gaps: false,
            range,
        }
    }

    /// An optional column without gaps.
    #[must_use]
    pub const fn optional(name: &'static str, range: [f64; 2]) -> Self {
        Self {
            name,
            required: false,
            gaps: false,
            range,
        }
    }

    /// The same column with empty cells allowed.
    #[must_use]
    pub const fn with_gaps(mut self) -> Self {
        self.gaps = true;
        self
    }
}

/// A table that was read: one vector a known column, `None` where the header lacks it.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Name of the file, for errors.
    pub file: String,
    /// Line of the header.
    pub header_line: u64,
    /// Line of each row.
    pub line: Vec<u64>,
    /// Columns in the order of the specification; `NAN` marks an empty cell where gaps are allowed.
    pub columns: Vec<Option<Vec<f64>>>,
}

/// Unit suffixes of column names, longest first where one ends another.
const UNIT_SUFFIXES: [&str; 33] = [
    "_w_m2_sr_nm",
    "_w_m2_nm",
    "_w_m2_um",
    "_w_m2",
    "_mw_m2_nm",
    "_per_m3",
    "_per_cm3",
    "_per_km",
    "_per_cm",
    "_per_m",
    "_m-3",
    "_cm-3",
    "_km-1",
    "_m-1",
    "_percent",
    "_fraction",
    "_ppmv",
    "_kg_m3",
    "_g_m3",
    "_hpa",
    "_kpa",
    "_pa",
    "_mbar",
    "_mb",
    "_atm",
    "_km",
    "_nm",
    "_um",
    "_ft",
    "_m",
    "_k",
    "_c",
    "_f",
];

/// A column name without its unit.
fn stem(name: &str) -> &str {
    UNIT_SUFFIXES
        .iter()
        .find_map(|suffix| name.strip_suffix(suffix))
        .unwrap_or(name)
}

/// The line of a record. The reader says where it began to look for it, before comments and blank lines.
fn line_of(text: &str, record: &csv::StringRecord) -> u64 {
    let Some(position) = record.position() else {
        return 1;
    };
    let start = usize::try_from(position.byte()).unwrap_or(text.len());
    let rest = text.get(start..).unwrap_or_default();
    let skipped = rest
        .split('\n')
        .take_while(|line| line.starts_with('#') || line.trim_end_matches('\r').is_empty());
    position.line() + u64::try_from(skipped.count()).unwrap_or(0)
}

fn names(specs: &[ColumnSpec]) -> String {
    specs.iter().map(|s| s.name).collect::<Vec<_>>().join(", ")
}

impl Table {
    /// Reads a table; header names are case-insensitive and in any order.
    ///
    /// # Errors
    /// The first thing that is wrong, with its line and column.
    pub fn read(
        file: &str,
        text: &str,
        specs: &[ColumnSpec],
        min_rows: usize,
    ) -> Result<Self, TableError> {
        Self::read_with(file, text, specs, min_rows, false)
    }

    /// The same from a table that may have other columns, which are passed over.
    ///
    /// # Errors
    /// The first thing that is wrong, with its line and column.
    pub fn read_some(
        file: &str,
        text: &str,
        specs: &[ColumnSpec],
        min_rows: usize,
    ) -> Result<Self, TableError> {
        Self::read_with(file, text, specs, min_rows, true)
    }

    fn read_with(
        file: &str,
        text: &str,
        specs: &[ColumnSpec],
        min_rows: usize,
        passes_over_others: bool,
    ) -> Result<Self, TableError> {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let empty = || TableError::Empty {
            file: file.to_owned(),
            expected: names(specs),
        };
        let mut reader = csv::ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .comment(Some(b'#'))
            .trim(csv::Trim::All)
            .from_reader(text.as_bytes());
        // Text that is valid UTF-8 and allowed to be ragged has no other csv error left; should
        // one come nevertheless, the file ends there and the row count speaks.
        let mut records = reader.records().map_while(Result::ok);
        let header = records.next().ok_or_else(empty)?;
        let header_line = line_of(text, &header);
        let found: Vec<String> = header.iter().map(str::to_lowercase).collect();
        if found.len() == 1 && found[0].contains(';') {
            return Err(TableError::Semicolons {
                file: file.to_owned(),
                line: header_line,
            });
        }
        let place = Self::places(file, header_line, &found, specs, passes_over_others)?;
        let mut columns: Vec<Option<Vec<f64>>> =
            place.iter().map(|p| p.map(|_| Vec::new())).collect();
        let mut lines = Vec::new();
        for record in records {
            let line = line_of(text, &record);
            if record.len() != found.len() {
                return Err(TableError::RaggedRow {
                    file: file.to_owned(),
                    line,
                    expected: found.len(),
                    found: record.len(),
                });
            }
            for ((spec, cell), column) in specs.iter().zip(&place).zip(&mut columns) {
                if let (Some(cell), Some(column)) = (cell, column) {
                    let text = record.get(*cell).unwrap_or_default();
                    column.push(Self::number(file, line, spec, text)?);
                }
            }
            lines.push(line);
        }
        if lines.len() < min_rows {
            return Err(TableError::TooFewRows {
                file: file.to_owned(),
                line: lines.last().copied().unwrap_or(header_line),
                expected: min_rows,
                found: lines.len(),
            });
        }
        Ok(Self {
            file: file.to_owned(),
            header_line,
            line: lines,
            columns,
        })
    }

    /// The cell of each known column in the header.
    fn places(
        file: &str,
        header_line: u64,
        found: &[String],
        specs: &[ColumnSpec],
        passes_over_others: bool,
    ) -> Result<Vec<Option<usize>>, TableError> {
        let mut place = vec![None; specs.len()];
        for (cell, name) in found.iter().enumerate() {
            let Some(known) = specs.iter().position(|s| s.name == name) else {
                if passes_over_others {
                    continue;
                }
                return Err(Self::unexpected(file, header_line, name, found, specs));
            };
            if place[known].replace(cell).is_some() {
                return Err(TableError::DuplicateColumn {
                    file: file.to_owned(),
                    line: header_line,
                    column: specs[known].name,
                });
            }
        }
        if let Some((spec, _)) = specs
            .iter()
            .zip(&place)
            .find(|(s, p)| s.required && p.is_none())
        {
            return Err(TableError::MissingColumn {
                file: file.to_owned(),
                line: header_line,
                column: spec.name,
                found: found.join(", "),
            });
        }
        Ok(place)
    }

    fn unexpected(
        file: &str,
        line: u64,
        name: &str,
        header: &[String],
        specs: &[ColumnSpec],
    ) -> TableError {
        // A known quantity in another unit, unless the right column stands beside it.
        let twin = specs
            .iter()
            .find(|s| stem(s.name) == stem(name) && !header.iter().any(|h| h == s.name));
        match twin {
            Some(spec) => TableError::WrongUnit {
                file: file.to_owned(),
                line,
                expected: spec.name,
                found: name.to_owned(),
            },
            None => TableError::UnknownColumn {
                file: file.to_owned(),
                line,
                expected: names(specs),
                found: name.to_owned(),
            },
        }
    }

    fn number(file: &str, line: u64, spec: &ColumnSpec, text: &str) -> Result<f64, TableError> {
        if text.is_empty() {
            return if spec.gaps {
                Ok(f64::NAN)
            } else {
                Err(TableError::EmptyCell {
                    file: file.to_owned(),
                    line,
                    column: spec.name,
                })
            };
        }
        let value: f64 = text.parse().map_err(|_| TableError::NotANumber {
            file: file.to_owned(),
            line,
            column: spec.name,
            found: text.to_owned(),
        })?;
        if !value.is_finite() {
            return Err(TableError::NotFinite {
                file: file.to_owned(),
                line,
                column: spec.name,
                found: value,
            });
        }
        if value < spec.range[0] || value > spec.range[1] {
            return Err(TableError::OutOfRange {
                file: file.to_owned(),
                line,
                column: spec.name,
                expected: spec.range,
                found: value,
            });
        }
        // a negative zero is the zero: total orders tell them apart
        Ok(value + 0.0)
    }

    /// Line of the last row.
    #[must_use]
    pub fn last_line(&self) -> u64 {
        self.line.last().copied().unwrap_or(self.header_line)
    }

    /// The values of a required column.
    #[must_use]
    pub fn column(&self, index: usize) -> &[f64] {
        self.columns
            .get(index)
            .and_then(Option::as_deref)
            .unwrap_or_default()
    }

    /// The values of an optional column, if the header has it.
    #[must_use]
    pub fn optional_column(&self, index: usize) -> Option<&[f64]> {
        self.columns.get(index).and_then(Option::as_deref)
    }

    /// Checks that a column ascends strictly.
    ///
    /// # Errors
    /// The first row that does not.
    pub fn check_ascending(&self, index: usize, name: &'static str) -> Result<(), TableError> {
        for (pair, line) in self.column(index).windows(2).zip(self.line.iter().skip(1)) {
            if pair[1] <= pair[0] {
                return Err(TableError::NotAscending {
                    file: self.file.clone(),
                    line: *line,
                    column: name,
                    previous: pair[0],
                    found: pair[1],
                });
            }
        }
        Ok(())
    }
}

/// Linear interpolation in an ascending table; the end values continue outside it.
#[must_use]
pub(crate) fn interpolate(x_table: &[f64], y_table: &[f64], x: f64) -> f64 {
    debug_assert_eq!(x_table.len(), y_table.len(), "one value a node");
    let upper = x_table.partition_point(|&t| t < x);
    if upper == 0 {
        return y_table[0];
    }
    if upper == x_table.len() {
        return y_table[upper - 1];
    }
    let (x0, x1) = (x_table[upper - 1], x_table[upper]);
    let t = (x - x0) / (x1 - x0);
    y_table[upper - 1] + t * (y_table[upper] - y_table[upper - 1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn interpolation_hits_nodes_and_middles_and_stops_at_the_ends() {
        let (x, y) = ([1.0, 2.0, 4.0], [10.0, 20.0, 0.0]);
        for (at, want) in [
            (0.0, 10.0),
            (1.0, 10.0),
            (1.5, 15.0),
            (2.0, 20.0),
            (3.0, 10.0),
            (9.0, 0.0),
        ] {
            assert!((interpolate(&x, &y, at) - want).abs() < 1e-12);
        }
    }

    #[test]
    fn c_an_error_names_its_own_line_below_comments() {
        let specs = [ColumnSpec::required("a", [0.0, 9.0])];
        for end in ["\n", "\r\n"] {
            let text = "# c\n# c\na\n1\n\n# c\nx\n".replace('\n', end);
            let error = Table::read("f", &text, &specs, 1).unwrap_err().to_string();
            assert!(error.starts_with("f:7: column a"), "{end:?}: {error}");
            let text = "# c\n\nb\n1\n".replace('\n', end);
            let error = Table::read("f", &text, &specs, 1).unwrap_err().to_string();
            assert!(error.starts_with("f:3: column b"), "{end:?}: {error}");
            let text = "a\n1\nx\n".replace('\n', end);
            let error = Table::read("f", &text, &specs, 1).unwrap_err().to_string();
            assert!(error.starts_with("f:3: column a"), "{end:?}: {error}");
        }
    }
}
