//! An axis of a table: from a value to its place between nodes, and back.
//!
//! This is the one place where values become places in a table. Outside its first and last node an
//! axis has no cell; the rounding of a unit's conversion leaves a node's own value at the node.

use serde::{Deserialize, Serialize};

/// Ascending node values of one quantity, at least one. With one node nothing changes along the axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "UncheckedAxis")]
pub struct Axis {
    unit: String,
    nodes: Vec<f64>,
}

/// What an axis looks like before it is checked.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct UncheckedAxis {
    unit: String,
    nodes: Vec<f64>,
}

/// A place between two nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Index of the node below; the node above is the next one, where the axis has more than one.
    pub lower: usize,
    /// Share of the way from the lower node to the upper, 0 to 1.
    pub fraction: f64,
}

/// Node values that make no axis.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum AxisError {
    /// No nodes.
    #[error("axis: expected at least 1 node, found {found}")]
    TooFewNodes {
        /// Number of nodes.
        found: usize,
    },
    /// NaN or an infinity.
    #[error("axis: node {index}: expected a finite number, found {found}")]
    NotFinite {
        /// Which node, from 0.
        index: usize,
        /// The value.
        found: f64,
    },
    /// A node that does not lie above the one before.
    #[error("axis: node {index}: expected ascending values, more than {before}, found {found}")]
    NotAscending {
        /// Which node, from 0.
        index: usize,
        /// The value of the node before.
        before: f64,
        /// The value.
        found: f64,
    },
}

/// How far beyond an end a value may lie, as a share of the larger end or 1: degrees that became
/// radians and degrees again are off by 2e-16.
const ROUNDING: f64 = 1e-12;

impl Axis {
    /// From the name of a unit and ascending node values in it.
    ///
    /// # Errors
    /// Refuses an empty list, and names the first node that is not finite or not ascending.
    pub fn new(unit: impl Into<String>, nodes: Vec<f64>) -> Result<Self, AxisError> {
        if nodes.is_empty() {
            return Err(AxisError::TooFewNodes { found: nodes.len() });
        }
        for (index, &found) in nodes.iter().enumerate() {
            if !found.is_finite() {
                return Err(AxisError::NotFinite { index, found });
            }
        }
        for (index, pair) in nodes.windows(2).enumerate() {
            let (before, found) = (pair[0], pair[1]);
            if found <= before {
                return Err(AxisError::NotAscending {
                    index: index + 1,
                    before,
                    found,
                });
            }
        }
        Ok(Self {
            unit: unit.into(),
            nodes,
        })
    }

    /// Name of the nodes' unit, `1` for a pure number.
    #[must_use]
    pub fn unit(&self) -> &str {
        &self.unit
    }

    /// The node values.
    #[must_use]
    pub fn nodes(&self) -> &[f64] {
        &self.nodes
    }

    /// Number of nodes, at least 1.
    #[must_use]
    #[expect(
        clippy::len_without_is_empty,
        reason = "an axis is never empty, so there is nothing to ask"
    )]
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// First and last node value.
    #[must_use]
    pub fn bounds(&self) -> [f64; 2] {
        [self.nodes[0], self.nodes[self.nodes.len() - 1]]
    }

    /// The cell that holds a value, `None` outside the bounds and for NaN.
    ///
    /// A value on an inner node is fraction 0 of the cell above it; the last node is fraction 1 of the
    /// last cell. The node of an axis that has no other is fraction 0.
    #[must_use]
    pub fn cell_from_value(&self, value: f64) -> Option<Cell> {
        let [first, last] = self.bounds();
        let slack = ROUNDING * first.abs().max(last.abs()).max(1.0);
        if !(value >= first - slack && value <= last + slack) {
            return None;
        }
        let value = value.clamp(first, last);
        if self.nodes.len() == 1 {
            return Some(Cell {
                lower: 0,
                fraction: 0.0,
            });
        }
        let above = self.nodes.partition_point(|node| *node <= value);
        let lower = above.min(self.nodes.len() - 1) - 1;
        let (from, to) = (self.nodes[lower], self.nodes[lower + 1]);
        Some(Cell {
            lower,
            fraction: (value - from) / (to - from),
        })
    }

    /// The value at a place in a cell, inverse of [`Self::cell_from_value`]; `None` where the axis has
    /// no such cell or the fraction is not within 0 to 1.
    #[must_use]
    pub fn value_from_cell(&self, cell: Cell) -> Option<f64> {
        let from = *self.nodes.get(cell.lower)?;
        let to = match self.nodes.as_slice() {
            [only] => *only,
            nodes => *nodes.get(cell.lower + 1)?,
        };
        (0.0..=1.0)
            .contains(&cell.fraction)
            .then_some(from * (1.0 - cell.fraction) + to * cell.fraction)
    }

    /// The two nodes around a value and their weights, linear in a coordinate of the axis. A value
    /// beyond the axis takes its end: the caller has checked the domain, this undoes rounding alone. Of
    /// a single node both are the same, and the second weighs nothing.
    #[must_use]
    pub fn blend(&self, value: f64, coordinate: impl Fn(f64) -> f64) -> [(usize, f64); 2] {
        let [low, high] = self.bounds();
        let value = value.clamp(low, high);
        match self.cell_from_value(value) {
            Some(Cell { lower, .. }) if self.len() > 1 => {
                let from = coordinate(self.nodes[lower]);
                let to = coordinate(self.nodes[lower + 1]);
                let fraction = (coordinate(value) - from) / (to - from);
                [(lower, 1.0 - fraction), (lower + 1, fraction)]
            }
            _ => [(0, 1.0), (0, 0.0)],
        }
    }
}

impl TryFrom<UncheckedAxis> for Axis {
    type Error = AxisError;

    fn try_from(axis: UncheckedAxis) -> Result<Self, AxisError> {
        Self::new(axis.unit, axis.nodes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::Angle;

    /// Uneven nodes: dense below, like the altitudes of a sky.
    fn uneven(count: u32) -> Axis {
        let nodes = (0..count)
            .map(|i| 30.0 * (f64::from(i) / f64::from(count - 1)).powi(2) - 1.0)
            .collect();
        Axis::new("km", nodes).unwrap()
    }

    #[test]
    fn a5_a_node_that_was_converted_is_still_on_its_axis() {
        // 96 degrees come back from radians as 96.00000000000001
        let axis = Axis::new("deg", vec![0.0, 52.0, 86.7, 96.0]).unwrap();
        let cells = [(0, 0.0), (1, 0.0), (2, 0.0), (2, 1.0)];
        for (node, (lower, fraction)) in axis.nodes().iter().zip(cells) {
            let back = Angle::from_degrees(*node).degrees();
            let found = axis.value_from_cell(axis.cell_from_value(back).unwrap());
            let want = axis.value_from_cell(Cell { lower, fraction });
            assert!(
                (found.unwrap() - want.unwrap()).abs() < 1e-12,
                "{node}: {found:?}"
            );
        }
        let back = Angle::from_degrees(96.0).degrees();
        assert!(back > 96.0, "the case that was lost: {back}");
    }

    #[test]
    fn cell_and_value_are_inverse() {
        for count in [2, 32, 257] {
            let axis = uneven(count);
            for i in 0..=10_000 {
                let value = 30.0 * f64::from(i) / 10_000.0 - 1.0;
                let cell = axis.cell_from_value(value).unwrap();
                assert!((0.0..=1.0).contains(&cell.fraction));
                let back = axis.value_from_cell(cell).unwrap();
                assert!((back - value).abs() < 1e-12, "{count}: {value} -> {back}");
                let [(lower, below), (upper, above)] = axis.blend(value, |v| v);
                let blended = below * axis.nodes()[lower] + above * axis.nodes()[upper];
                assert!(
                    (blended - value).abs() < 1e-12,
                    "{count}: {value} -> {blended}"
                );
            }
        }
    }

    #[test]
    fn nodes_are_exact() {
        for count in [2, 32, 257] {
            let axis = uneven(count);
            for (i, node) in axis.nodes().iter().enumerate() {
                let cell = axis.cell_from_value(*node).unwrap();
                assert_eq!(axis.value_from_cell(cell), Some(*node));
                for (at, weight) in axis.blend(*node, |v| v) {
                    // exactly all or nothing
                    let all = if at == i { 1.0_f64 } else { 0.0 };
                    assert!([0.0, all].map(f64::to_bits).contains(&weight.to_bits()));
                }
            }
        }
    }

    #[test]
    fn nothing_outside_has_a_cell() {
        let axis = uneven(32);
        let [first, last] = axis.bounds();
        for outside in [
            first - 1e-9,
            last + 1e-9,
            f64::NAN,
            f64::INFINITY,
            f64::NEG_INFINITY,
        ] {
            assert_eq!(axis.cell_from_value(outside), None);
        }
        let none = |lower, fraction| axis.value_from_cell(Cell { lower, fraction }).is_none();
        assert!(none(31, 0.0) && none(0, 1.1) && none(0, f64::NAN) && none(usize::MAX - 1, 0.5));
    }

    #[test]
    fn an_axis_of_one_node_is_that_value() {
        let axis = Axis::new("km", vec![5.0]).unwrap();
        assert!(axis.bounds().iter().all(|b| (b - 5.0).abs() < 1e-12));
        assert_eq!(axis.cell_from_value(5.1), None);
        assert_eq!(axis.blend(5.1, |v| v), [(0, 1.0), (0, 0.0)]);
    }

    #[test]
    fn bad_nodes_are_named() {
        let refused = |nodes: &[f64]| Axis::new("1", nodes.to_vec()).unwrap_err();
        assert_eq!(refused(&[]), AxisError::TooFewNodes { found: 0 });
        assert!(matches!(
            refused(&[0.0, f64::NAN]),
            AxisError::NotFinite { index: 1, .. }
        ));
        let message = refused(&[0.0, 6.0, 6.0]).to_string();
        assert_eq!(
            message,
            "axis: node 2: expected ascending values, more than 6, found 6"
        );
    }

    #[test]
    fn an_axis_read_from_a_file_is_checked() {
        let good: Axis = serde_json::from_str(r#"{"unit":"km","nodes":[0,6]}"#).unwrap();
        assert_eq!(good, Axis::new("km", vec![0.0, 6.0]).unwrap());
        let bad = serde_json::from_str::<Axis>(r#"{"unit":"km","nodes":[6,0]}"#).unwrap_err();
        assert!(bad.to_string().contains("ascending"), "{bad}");
    }
}
