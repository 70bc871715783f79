//! How finely the transport equation is solved, and what the engine refuses.

/// What the transport engine refuses.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum TransportError {
    /// Fewer than two levels, or tables of the wrong length.
    #[error("optical profile: expected at least 2 levels and full tables, found {levels} levels")]
    Shape {
        /// Number of levels found.
        levels: usize,
    },
    /// Fewer local sun zenith angles than the field is interpolated among.
    #[error("columns of the diffuse field: expected at least 4, found {found}")]
    Columns {
        /// Number of columns found.
        found: usize,
    },
    /// The ground reflects a share between 0 and 1.
    #[error("ground albedo: expected 0..1, found {0}")]
    Albedo(f64),
    /// The observer is below the ground.
    #[error("observer altitude [km]: expected at least {ground_km}, found {found}")]
    BelowGround {
        /// Altitude of the ground \[km\].
        ground_km: f64,
        /// Altitude of the observer \[km\].
        found: f64,
    },
    /// The series of orders does not converge in the orders allowed.
    #[error(
        "multiple scattering: order {orders} still adds {share:.1e} of the field, expected below {expected:.1e}"
    )]
    NotConverged {
        /// Orders computed.
        orders: usize,
        /// Share of the field that the last one added.
        share: f64,
        /// Share at which the engine would have stopped.
        expected: f64,
    },
}

/// How finely the transport equation is solved.
#[derive(Clone, Debug, PartialEq)]
pub struct TransportSettings {
    /// Highest degree of spherical harmonics of the diffuse source; `None` chooses by the haze.
    pub degree: Option<usize>,
    /// Gauss points in zenith: from the zenith to 78°, from there to the horizon, below the horizon.
    pub zenith_points: [usize; 3],
    /// Directions in azimuth over half the circle.
    pub azimuth_points: usize,
    /// Most orders of scattering.
    pub most_orders: usize,
    /// The series stops when what remains is below this share of the field everywhere.
    pub tolerance: f64,
    /// Cuts the series after this order, 1 being single scattering: to ask what the others are worth.
    pub last_order: Option<usize>,
    /// Altitudes of the shells of the diffuse field \[km\]; those above the profile's top are dropped.
    pub shells_km: Vec<f64>,
    /// Local sun zenith angles of the diffuse field \[deg\].
    pub columns_deg: Vec<f64>,
}

impl Default for TransportSettings {
    fn default() -> Self {
        Self {
            degree: None,
            zenith_points: [6, 8, 4],
            azimuth_points: 8,
            most_orders: 60,
            tolerance: 2e-3,
            last_order: None,
            shells_km: vec![
                0.0, 0.1, 0.3, 0.6, 1.0, 1.5, 2.1, 2.9, 4.0, 5.5, 7.5, 10.0, 12.5, 15.5, 19.0,
                23.0, 27.0, 32.0, 38.0, 46.0, 56.0, 70.0, 100.0,
            ],
            columns_deg: vec![
                0.0, 15.0, 30.0, 45.0, 57.0, 66.0, 73.0, 78.5, 82.5, 85.5, 87.5, 89.0, 90.5, 92.0,
                93.5, 95.0, 96.5, 98.0, 100.0, 102.5, 106.0,
            ],
        }
    }
}

/// Checks an albedo.
pub(super) fn check_albedo(albedo: f64) -> Result<(), TransportError> {
    if (0.0..=1.0).contains(&albedo) {
        Ok(())
    } else {
        Err(TransportError::Albedo(albedo))
    }
}
