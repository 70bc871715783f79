//! The renderer's tiers as skies on the CPU, so that what they lose can be measured: the texture of
//! `shaders/baked.wgsl`, and the mesh of `shaders/dome.wgsl`.

use std::sync::{Arc, Mutex, PoisonError};

use sky_core::color::{LinearSrgb, Yxy, xyz_from_linear_srgb, yxy_from_xyz};
use sky_core::conditions::{Conditions, Domain};
use sky_core::direction::{SkyDirection, horizon_zenith};
use sky_core::quantity::Angle;
use sky_core::tonemap::luminance;
use sky_core::utm_sky::{SkyFrame, UtmSky};
use sky_science::sky_model::{SkyError, SkyModel};

/// Texels across and, of the sky's part, up.
const TEXELS: [usize; 2] = [160, 152];
/// Rings and spokes of the report's dome.
const DOME: [usize; 2] = [9, 30];

/// The sky through the baked texture, which is kept as long as the conditions stay.
#[derive(Debug)]
pub struct BakedSky {
    sky: UtmSky,
    kept: Mutex<Option<(Conditions, Arc<Texels>)>>,
}

/// The texture of the sky's part, row by row from the horizon up.
type Texels = Vec<[f32; 3]>;

/// The sky through the report's dome.
#[derive(Debug)]
pub struct DomeSky(UtmSky);

impl BakedSky {
    /// Of a table.
    #[must_use]
    pub const fn new(sky: UtmSky) -> Self {
        Self {
            sky,
            kept: Mutex::new(None),
        }
    }

    fn texels(&self, conditions: &Conditions, frame: &SkyFrame) -> Arc<Texels> {
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((for_conditions, texels)) = &*kept
            && for_conditions == conditions
        {
            return Arc::clone(texels);
        }
        let [width, height] = TEXELS;
        let texels: Texels = (0..height)
            .flat_map(|y| (0..width).map(move |x| (x, y)))
            .map(|(x, y)| {
                texel(
                    frame,
                    count(x) / count(width - 1),
                    count(y) / count(height - 1),
                )
            })
            .collect();
        let texels = Arc::new(texels);
        *kept = Some((*conditions, Arc::clone(&texels)));
        texels
    }
}

impl DomeSky {
    /// Of a table.
    #[must_use]
    pub const fn new(sky: UtmSky) -> Self {
        Self(sky)
    }
}

fn yxy([red, green, blue]: [f32; 3]) -> Yxy {
    debug_assert!(luminance([red, green, blue]).is_finite(), "a light");
    yxy_from_xyz(xyz_from_linear_srgb(LinearSrgb {
        red: red.into(),
        green: green.into(),
        blue: blue.into(),
    }))
}

/// Whole part as an index and fraction of a place on a line of nodes.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "clamped to the nodes"
)]
fn cell(place: f32, nodes: usize) -> (usize, f32) {
    let lower = (place.max(0.0) as usize).min(nodes - 2);
    (lower, (place - count(lower)).clamp(0.0, 1.0))
}

fn count(n: usize) -> f32 {
    u16::try_from(n).map_or(0.0, f32::from)
}

fn mix(a: [f32; 3], b: [f32; 3], share: f32) -> [f32; 3] {
    core::array::from_fn(|c| a[c] + share * (b[c] - a[c]))
}

impl SkyModel for BakedSky {
    fn name(&self) -> &'static str {
        "utm-sky-baked"
    }

    fn domain(&self) -> &Domain {
        self.sky.domain()
    }

    fn yxy_map(
        &self,
        conditions: &Conditions,
        directions: &[SkyDirection],
    ) -> Result<Vec<Yxy>, SkyError> {
        let frame = self.sky.frame(conditions)?;
        let [width, height] = TEXELS;
        let texels = self.texels(conditions, &frame);
        let lowest = frame.cos_horizon();
        Ok(directions
            .iter()
            .map(|d| {
                let [x, y, z] = d.unit_vector();
                if z < lowest - 2e-7 {
                    return Yxy::default();
                }
                let flat = (x * x + y * y).max(1e-12).sqrt();
                let across = (0.5 - 0.5 * x / flat).clamp(0.0, 1.0).sqrt();
                let up = ((z - lowest).max(0.0) / (1.0 - lowest)).sqrt().min(1.0);
                let (i, u) = cell(across * count(width - 1), width);
                let (j, v) = cell(up * count(height - 1), height);
                let at = |i: usize, j: usize| texels[j * width + i];
                let low = mix(at(i, j), at(i + 1, j), u);
                yxy(mix(low, mix(at(i, j + 1), at(i + 1, j + 1), u), v))
            })
            .collect())
    }
}

/// Light of a texel: `across` and `up` from 0 to 1.
fn texel(frame: &SkyFrame, across: f32, up: f32) -> [f32; 3] {
    let cos_azimuth = 1.0 - 2.0 * across * across;
    let sin_azimuth = 2.0 * across * (1.0 - across * across).max(0.0).sqrt();
    let lowest = frame.cos_horizon();
    let cosine = lowest + up * up * (1.0 - lowest);
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    let direction = [sine * cos_azimuth, sine * sin_azimuth, cosine];
    frame.linear_srgb(direction).unwrap_or_default()
}

impl SkyModel for DomeSky {
    fn name(&self) -> &'static str {
        "utm-sky-vertex"
    }

    fn domain(&self) -> &Domain {
        self.0.domain()
    }

    /// Blended over the mesh's quads in angles; the triangles' own blending differs within a quad.
    fn yxy_map(
        &self,
        conditions: &Conditions,
        directions: &[SkyDirection],
    ) -> Result<Vec<Yxy>, SkyError> {
        let frame = self.0.frame(conditions)?;
        let [rings, spokes] = DOME;
        let horizon = horizon_zenith(conditions.observer_altitude).radians();
        let corner = |ring: usize, spoke: usize| {
            let zenith = horizon * f64::from(count(ring)) / f64::from(count(rings));
            let azimuth = 360.0 * f64::from(count(spoke)) / f64::from(count(spokes));
            let direction = SkyDirection {
                view_zenith: Angle::from_radians(zenith),
                relative_azimuth: Angle::from_degrees(azimuth),
            };
            frame
                .linear_srgb(direction.unit_vector())
                .unwrap_or_default()
        };
        let corners: Vec<Vec<[f32; 3]>> = (0..=rings)
            .map(|r| (0..=spokes).map(|s| corner(r, s)).collect())
            .collect();
        Ok(directions
            .iter()
            .map(|d| {
                let share = d.view_zenith.radians() / horizon;
                if share > 1.0 + 1e-6 {
                    return Yxy::default();
                }
                let turn = d.relative_azimuth.degrees().rem_euclid(360.0) / 360.0;
                let single = sky_core::quantity::single;
                let (r, v) = cell(single(share) * count(rings), rings + 1);
                let (s, u) = cell(single(turn) * count(spokes), spokes + 1);
                let low = mix(corners[r][s], corners[r][s + 1], u);
                let high = mix(corners[r + 1][s], corners[r + 1][s + 1], u);
                yxy(mix(low, high, v))
            })
            .collect())
    }
}
