//! From a look-up table to the light of the sky: the runtime model.
//!
//! What depends on observer, haze and sun is computed once ([`UtmSky::frame`]); what is left for a
//! direction is one formula in `f32` without allocation ([`SkyFrame::yxy`]), the twin of the shader.
//! Out of scope: the sun's disc and the ground.

use crate::color::{Yxy, linear_srgb};
use crate::conditions::{Conditions, Domain, OutsideDomain};
use crate::direction::{SkyDirection, horizon_zenith};
use crate::extended::{self, Coefficients, ScaledRadii, angle_from_sun};
use crate::extinction::Extinction;
use crate::lut::{Form, Lut, LutError};
use crate::quantity::{Angle, single};

/// Bytes of the default table, `luts/default.utmlut`.
#[cfg(feature = "default-table")]
pub const EMBEDDED_LUT: &[u8] = sky_luts::DEFAULT;

/// Distance of the lowest ring that tables of the extended form are fitted to from the geometric
/// horizon \[deg\]. Below it the sky is soon that ring's: the formula is not made to go on.
pub const LOWEST_RING_DEG: f64 = 0.25;
/// Width of the bend from the formula to the lowest ring's sky, in the cosine: 0.08° at the horizon.
pub const LOWEST_RING_BEND: f64 = 1.4e-3;

/// A hair below the horizon is the horizon: f32 resolves 1e-7 in the cosine.
pub const HORIZON_SLACK: f32 = 2e-7;

/// Altitudes that a table may have: as many as a frame of the air holds.
pub const MAX_LAYERS: usize = 16;

/// The sky of a look-up table that has all that the runtime needs: the extended form, the extinction
/// of its air, and no more altitudes than a frame holds.
#[derive(Clone, Debug)]
pub struct UtmSky {
    lut: Lut,
    extinction: Extinction,
}

/// Why there is no sky: bytes that are no table, or a table that lacks what the runtime needs.
#[derive(Debug, thiserror::Error)]
pub enum TableError {
    /// Not a table.
    #[error(transparent)]
    Lut(#[from] LutError),
    /// Its form is not the extended one.
    #[error("table: expected the form extended, found {}", found.name())]
    Form {
        /// The form.
        found: Form,
    },
    /// It does not know the air's extinction.
    #[error("table: expected the air's extinction in the header, found none")]
    NoExtinction,
    /// It has too many altitudes.
    #[error("table: expected at most {MAX_LAYERS} altitudes, found {found}")]
    Altitudes {
        /// How many.
        found: usize,
    },
}

/// The sky for one observer, haze and sun.
#[derive(Clone, Debug)]
pub struct SkyFrame {
    coefficients: Coefficients,
    radii: ScaledRadii,
    sin_sun: f32,
    cos_sun: f32,
    cos_horizon: f32,
    cos_lowest: f32,
}

/// A cosine of the view zenith angle as the extended form takes it: below that of the lowest fitted ring
/// it bends, without a kink, to stay.
fn held(cosine: f32, lowest: f32) -> f32 {
    const BEND: f32 = single(LOWEST_RING_BEND);
    let below = ((lowest - cosine) / BEND).clamp(0.0, 1.0);
    cosine.max(lowest) - BEND * (below - 0.5 * below * below)
}

/// Place of a turbidity for interpolation: light grows like the logarithm of the haze.
#[must_use]
pub fn haze_coordinate(turbidity: f64) -> f64 {
    (turbidity - 0.7).ln()
}

impl UtmSky {
    /// The sky of a table.
    ///
    /// # Errors
    /// When the table is not of the extended form, lacks the extinction or has too many altitudes.
    pub fn new(lut: Lut) -> Result<Self, TableError> {
        let header = lut.header();
        if header.form != Form::Extended {
            return Err(TableError::Form { found: header.form });
        }
        let found = header.altitude_km.len();
        if found > MAX_LAYERS {
            return Err(TableError::Altitudes { found });
        }
        let extinction = header.extinction.clone().ok_or(TableError::NoExtinction)?;
        Ok(Self { lut, extinction })
    }

    /// The sky of a `.utmlut` file's bytes.
    ///
    /// # Errors
    /// When the bytes are no table, or as [`Self::new`].
    pub fn decode(bytes: &[u8]) -> Result<Self, TableError> {
        Self::new(Lut::decode(bytes)?)
    }

    /// The sky of the table that is part of the program.
    ///
    /// # Errors
    /// When the embedded table cannot be read: a fault of the build.
    #[cfg(feature = "default-table")]
    pub fn embedded() -> Result<Self, TableError> {
        Self::decode(EMBEDDED_LUT)
    }

    /// The extinction of the air that the table was baked for.
    #[must_use]
    pub const fn extinction(&self) -> &Extinction {
        &self.extinction
    }

    /// Where the table is valid.
    #[must_use]
    pub fn domain(&self) -> &Domain {
        &self.lut.header().domain
    }

    /// The table.
    #[must_use]
    pub const fn lut(&self) -> &Lut {
        &self.lut
    }

    /// Gathers what depends on observer, haze and sun. No allocation.
    ///
    /// # Errors
    /// When the conditions lie outside the table's domain.
    pub fn frame(&self, conditions: &Conditions) -> Result<SkyFrame, OutsideDomain> {
        let header = self.lut.header();
        header.domain.check(conditions)?;
        let layers = header
            .altitude_km
            .blend(conditions.observer_altitude.km(), |h| h);
        let hazes = header
            .turbidity
            .blend(conditions.turbidity, haze_coordinate);
        let suns = header
            .sun_zenith_deg
            .blend(conditions.sun_zenith.degrees(), |s| s);
        let mut coefficients = Coefficients::default();
        for (a, wa) in layers {
            for (t, wt) in hazes {
                for (s, ws) in suns {
                    let weight = single(wa * wt * ws);
                    if weight != 0.0 {
                        let node = self.lut.node(a, t, s);
                        extended::add(&mut coefficients, weight, node, self.lut.term_slots());
                    }
                }
            }
        }
        let (sin_sun, cos_sun) = conditions.sun_zenith.radians().sin_cos();
        let horizon = horizon_zenith(conditions.observer_altitude);
        let lowest_ring = Angle::from_degrees(LOWEST_RING_DEG);
        Ok(SkyFrame {
            coefficients,
            radii: ScaledRadii::at(conditions.observer_altitude),
            sin_sun: single(sin_sun),
            cos_sun: single(cos_sun),
            cos_horizon: single(horizon.radians().cos()),
            cos_lowest: single((horizon.radians() - lowest_ring.radians()).cos()),
        })
    }
}

impl SkyFrame {
    /// The light from a direction, `None` below the geometric horizon.
    #[must_use]
    pub fn yxy(&self, direction: &SkyDirection) -> Option<Yxy> {
        let [luminance, x, y] = self.light(direction.unit_vector())?;
        Some(Yxy {
            luminance_cd_m2: luminance.into(),
            x: x.into(),
            y: y.into(),
        })
    }

    /// Luminance \[cd·m⁻²\], x and y from a direction, `None` below the geometric horizon.
    ///
    /// The direction is a unit vector: z points up, and the sun stands in the plane of x and z on
    /// the side of positive x. The twin of the shader's function.
    #[must_use]
    pub fn light(&self, direction: [f32; 3]) -> Option<[f32; 3]> {
        let cosine = direction[2];
        if cosine < self.cos_horizon - HORIZON_SLACK {
            return None;
        }
        let (gamma, cos_gamma) = angle_from_sun(direction, [self.sin_sun, self.cos_sun]);
        let cosine = held(cosine, self.cos_lowest);
        let basis = extended::basis(cosine, self.radii, gamma, cos_gamma);
        Some(extended::light(&self.coefficients, &basis))
    }

    /// Linear sRGB \[cd·m⁻²\] from a direction, `None` below the geometric horizon.
    #[must_use]
    pub fn linear_srgb(&self, direction: [f32; 3]) -> Option<[f32; 3]> {
        self.light(direction).map(linear_srgb)
    }

    /// The coefficients of the formula.
    #[must_use]
    pub const fn coefficients(&self) -> &Coefficients {
        &self.coefficients
    }

    /// What the air masses need of the altitude.
    #[must_use]
    pub const fn radii(&self) -> ScaledRadii {
        self.radii
    }

    /// Sine and cosine of the sun's zenith angle.
    #[must_use]
    pub const fn sun(&self) -> [f32; 2] {
        [self.sin_sun, self.cos_sun]
    }

    /// Cosine of the zenith angle of the lowest ring that the table was fitted to.
    #[must_use]
    pub const fn cos_lowest(&self) -> f32 {
        self.cos_lowest
    }

    /// Cosine of the geometric horizon's zenith angle.
    #[must_use]
    pub const fn cos_horizon(&self) -> f32 {
        self.cos_horizon
    }
}
