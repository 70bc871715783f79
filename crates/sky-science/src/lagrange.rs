//! The cubic through four points.

/// Weights of the cubic through four nodes at a place (Lagrange); exact for cubics.
#[must_use]
pub fn lagrange_weights(nodes: &[f64; 4], x: f64) -> [f64; 4] {
    core::array::from_fn(|i| {
        (0..4)
            .filter(|j| *j != i)
            .map(|j| (x - nodes[j]) / (nodes[i] - nodes[j]))
            .product()
    })
}

/// The four of some nodes that begin at an index.
///
/// # Panics
/// When fewer than four nodes begin there.
#[must_use]
pub fn four_from(nodes: &[f64], first: usize) -> [f64; 4] {
    core::array::from_fn(|i| nodes[first + i])
}
