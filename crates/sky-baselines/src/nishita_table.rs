//! Nishita et al. 1993 with the paper's table (Section 4.3.4): lengths of air and haze towards the
//! sun, tabulated over the radius of a shell and that of a cylinder around the sun's axis through the
//! Earth's center. On a circle where both meet, every point sees the sun through the same air.
//!
//! Shells as in Eq. 11, `r_i` = R − H₀ ln(1 − i/N), here N = 96, the last one the top. (The print has
//! `H₀ log(ρ_i)` + R, which would lie under the ground: the sign is lost.) Cylinders: the paper does not
//! say how they are spaced. On fixed radii the cells at the terminator have corners where shell and
//! cylinder do not meet, so here their radii are shares of the shell's, C = r (1 − v⁴), v uniform:
//! dense at grazing light. Behind the terminator the length is twice that of the whole line's half
//! less that in front. The view ray is marched as in `nishita.rs`.
//!
//! The table holds densities, not optical depths, so it does not depend on the haze's amount.

use sky_core::color::Yxy;
use sky_core::conditions::{Conditions, Domain, OutsideDomain};
use sky_core::direction::SkyDirection;
use sky_science::shader_sky::{ShaderFrame, ShaderSky};
use sky_science::sky_model::{SkyError, SkyModel};

use crate::atmosphere::{Atmosphere, TOP_KM};
use crate::nishita::{AIR_SCALE_KM, DOMAIN, SingleScattering};
use crate::ray::{self, Ray};
use crate::texture::{Table, single};
use crate::view;

/// Shells, the ground and the top among them; cylinders for each.
const SHELLS: usize = 97;
const CYLINDERS: usize = 128;

/// Steps of the integrals in the table.
const STEPS: u16 = 400;

/// Nishita's sky with its table.
#[derive(Clone, Debug)]
pub struct NishitaTable {
    air: SingleScattering,
    lengths: Table,
}

impl Default for NishitaTable {
    fn default() -> Self {
        Self::new(Atmosphere::default())
    }
}

/// Place of a shell on the table's axis, i/N.
#[must_use]
pub fn shell_from_altitude(altitude_km: f64) -> f64 {
    -(-altitude_km / AIR_SCALE_KM).exp_m1()
}

/// Altitude of a shell \[km\], Eq. 11; the inverse of [`shell_from_altitude`].
#[must_use]
pub fn altitude_from_shell(shell: f64) -> f64 {
    -AIR_SCALE_KM * (-shell).ln_1p()
}

/// Place of a cylinder on the table's axis, from the cosine of the sun's local zenith angle (0–1):
/// v = (1 − C/r)^¼ with C/r the sine.
#[must_use]
pub fn cylinder_from_cosine(cos_sun: f64) -> f64 {
    let sine = (1.0 - cos_sun * cos_sun).max(0.0).sqrt();
    (cos_sun / (1.0 + sine).sqrt()).sqrt()
}

/// The inverse of [`cylinder_from_cosine`].
#[must_use]
pub fn cosine_from_cylinder(cylinder: f64) -> f64 {
    let square = cylinder * cylinder;
    square * (2.0 - square * square).sqrt()
}

/// Equivalent lengths at sea level of air and haze from a point to the top, upwards \[km\].
fn lengths(altitude_km: f64, cos_sun: f64, haze_km: f64) -> [f64; 2] {
    let ray = Ray::new(altitude_km, cos_sun);
    let length = ray.to_top_km();
    let mut sums = [0.0; 2];
    for i in 0..STEPS {
        let u = (f64::from(i) + 0.5) / f64::from(STEPS);
        let [altitude, _] = ray.at(length * u * u * u);
        sums[0] += u * u * (-altitude / AIR_SCALE_KM).exp();
        sums[1] += u * u * (-altitude / haze_km).exp();
    }
    sums.map(|s| s * 3.0 * length / f64::from(STEPS))
}

impl NishitaTable {
    /// In another atmosphere.
    #[must_use]
    pub fn new(atmosphere: Atmosphere) -> Self {
        let haze_km = atmosphere.aerosol_scale_height_km;
        let lengths = Table::build(CYLINDERS, SHELLS, |cylinder, shell| {
            let altitude = altitude_from_shell(shell).min(TOP_KM);
            let [air, haze] = lengths(altitude, cosine_from_cylinder(cylinder), haze_km);
            [air, haze, 0.0, 0.0]
        });
        Self {
            air: SingleScattering::new(atmosphere),
            lengths,
        }
    }

    /// The table in front of the terminator.
    #[inline]
    fn in_front(&self, altitude_km: f32, cos_sun: f32) -> [f32; 2] {
        let sine = (1.0 - cos_sun * cos_sun).max(0.0).sqrt();
        let cylinder = (cos_sun / (1.0 + sine).sqrt()).sqrt();
        let shell = -(-altitude_km / single(AIR_SCALE_KM)).exp_m1();
        let [air, haze, ..] = self.lengths.at(cylinder, shell);
        [air, haze]
    }

    /// Lengths towards the sun, none in the Earth's shadow.
    #[inline]
    fn columns(&self, altitude_km: f32, cos_sun: f32) -> Option<[f32; 2]> {
        if cos_sun >= 0.0 {
            return Some(self.in_front(altitude_km, cos_sun));
        }
        let lowest = ray::lowest_km(altitude_km, cos_sun);
        if lowest < 0.0 {
            return None;
        }
        let level = self.in_front(lowest, 0.0);
        let behind = self.in_front(altitude_km, -cos_sun);
        Some([2.0 * level[0] - behind[0], 2.0 * level[1] - behind[1]])
    }
}

impl SkyModel for NishitaTable {
    fn name(&self) -> &'static str {
        "nishita-table"
    }

    fn domain(&self) -> &Domain {
        &DOMAIN
    }

    fn yxy_map(
        &self,
        conditions: &Conditions,
        directions: &[SkyDirection],
    ) -> Result<Vec<Yxy>, SkyError> {
        let frame = self.air.frame(conditions)?;
        Ok(view::each(directions, |v| {
            frame.march(v, |altitude, cos_sun| self.columns(altitude, cos_sun))
        }))
    }
}

impl ShaderSky for NishitaTable {
    fn shader(&self) -> &'static str {
        sky_shaders::baselines::NISHITA_TABLE
    }

    fn shader_frame(&self, conditions: &Conditions) -> Result<ShaderFrame, OutsideDomain> {
        Ok(ShaderFrame {
            uniforms: self.air.frame(conditions)?.uniforms(),
            texture: Some(Table::stacked(&[&self.lengths])),
        })
    }

    fn table_bytes(&self) -> usize {
        self.lengths.bytes(2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nishita::direct;
    use crate::shader_check::{self, conditions};

    #[test]
    fn mappings_are_inverse_pairs() {
        for n in [2_u16, 32, 257] {
            for i in 0..n {
                let x = f64::from(i) / f64::from(n - 1);
                let back = cylinder_from_cosine(cosine_from_cylinder(x));
                assert!((back - x).abs() < 1e-7, "{x} {back}");
                if x < 1.0 {
                    assert!((shell_from_altitude(altitude_from_shell(x)) - x).abs() < 1e-14);
                }
            }
        }
    }

    #[test]
    fn the_table_agrees_with_direct_integration() {
        // Lengths within 0.5 % wherever they matter, that is but for haze thinner than 1 m of the
        // ground's; in front of the terminator and behind it.
        let table = NishitaTable::default();
        for altitude in [0.0, 0.07, 0.4, 1.1, 2.3, 4.9, 9.3, 17.0, 33.0] {
            for degrees in [
                0.0, 33.0, 61.0, 80.0, 86.0, 89.0, 89.7, 90.0, 90.6, 92.0, 94.0_f64,
            ] {
                let cos = sky_core::quantity::Angle::from_degrees(degrees)
                    .radians()
                    .cos();
                let found = table.columns(single(altitude), single(cos));
                let want = direct::columns(altitude, cos, 1.2);
                assert_eq!(found.is_none(), want.is_none(), "{altitude} {degrees}");
                let (Some(found), Some(want)) = (found, want) else {
                    continue;
                };
                for (f, w) in found.into_iter().zip(want) {
                    let error = (f64::from(f) - w).abs();
                    assert!(error < 5e-3 * w + 1e-3, "{altitude} {degrees}: {f} {w}");
                }
            }
        }
    }

    #[test]
    fn agrees_with_fine_integration() {
        direct::compare(&NishitaTable::default(), |turbidity| {
            if turbidity > 5.0 { 0.05 } else { 0.02 }
        });
    }

    #[test]
    fn the_shader_is_valid() {
        shader_check::check(&NishitaTable::default(), &conditions(12.0, 3.0, 91.0));
    }
}
