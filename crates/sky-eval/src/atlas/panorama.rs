//! The sky as a GPU computes it, against the CPU's: whole panoramas at places all over the domain.

use anyhow::Result;
use sky_core::color::{LinearSrgb, Yxy, xyz_from_linear_srgb, yxy_from_xyz};
use sky_core::conditions::{Conditions, Domain};
use sky_core::direction::{SkyDirection, horizon_zenith};
use sky_core::quantity::{Angle, single};
use sky_core::utm_sky::UtmSky;

use super::kind::{Arithmetic, Kind, Place, With};
use super::subject::Density;
use super::sweep::{EDGE_DEG, Findings, difference, is_finite};
use crate::cases::conditions;
use crate::locus::Locus;

/// A panorama of the sky, drawn in linear light without the sun's disc.
#[derive(Clone, Debug)]
pub struct Panorama {
    /// What was drawn: the sun's direction is single, so it differs a little from what was asked for.
    pub conditions: Conditions,
    /// Each pixel's direction in the sky's frame (x toward the sun, z up) and its linear sRGB
    /// \[cd·m⁻²\].
    pub pixels: Vec<([f32; 3], [f32; 3])>,
}

/// Whoever draws panoramas: conditions and the sun's azimuth \[deg\] in; `None` where they cannot be
/// drawn. Somewhat more than half of the pixels should be sky.
pub type Draw<'a> = dyn FnMut(&Conditions, f64) -> Result<Option<Panorama>> + 'a;

impl Density {
    /// Panoramas: in full above 10⁷ lights of pictures of 512 × 256.
    #[must_use]
    pub fn panoramas(self) -> u32 {
        if self == Self::FULL { 180 } else { 12 }
    }
}

/// A place of the domain: bounds now and then, else spread evenly.
fn place(domain: &Domain, i: u32) -> Conditions {
    let spread = |[low, high]: [f64; 2], step: f64, period: u32| {
        let share = match i % period {
            0 => 0.0,
            1 => 1.0,
            _ => (f64::from(i) * step).fract(),
        };
        low + (high - low) * share
    };
    conditions(
        spread(domain.altitude_km, 0.819_172_513_396_164_5, 5),
        spread(domain.turbidity, 0.671_043_606_703_789_2, 7),
        spread(domain.sun_zenith_deg, 0.549_700_477_901_970_2, 11),
    )
}

/// Sweeps a table's sky. `done` is told of each panorama.
///
/// # Errors
/// When a panorama cannot be drawn.
pub fn sweep(
    sky: &UtmSky,
    density: Density,
    draw: &mut Draw<'_>,
    findings: &mut Findings,
    done: &dyn Fn(),
) -> Result<()> {
    let locus = Locus::new();
    for i in 0..density.panoramas() {
        let wanted = place(&sky.lut().header().domain, i);
        let azimuth = f64::from(i) * 137.5;
        if let Some(panorama) = draw(&wanted, azimuth)? {
            judge(sky, &panorama, &locus, findings);
            done();
        }
    }
    Ok(())
}

/// Every pixel of a panorama that is sky, against the evaluator.
fn judge(sky: &UtmSky, panorama: &Panorama, locus: &Locus, findings: &mut Findings) {
    let seen = panorama.conditions;
    let Ok(truth) = sky.frame(&seen) else {
        return;
    };
    let horizon = horizon_zenith(seen.observer_altitude).radians();
    let lowest = single((horizon - Angle::from_degrees(EDGE_DEG).radians()).cos());
    for (local, rgb) in &panorama.pixels {
        if local[2] < lowest {
            continue;
        }
        let Some(expected) = truth.light(*local) else {
            continue;
        };
        let expected = Yxy {
            luminance_cd_m2: expected[0].into(),
            x: expected[1].into(),
            y: expected[2].into(),
        };
        let [red, green, blue] = rgb.map(f64::from);
        let found = yxy_from_xyz(xyz_from_linear_srgb(LinearSrgb { red, green, blue }));
        let place = || Place {
            conditions: seen,
            direction: SkyDirection::from_vector(local.map(f64::from)),
            with: With::Nothing,
        };
        let t = &mut findings.tallies;
        let mut record = |kind, score| {
            t.record(Arithmetic::GpuF32, kind, true, score, place);
        };
        let finite = is_finite(&found);
        record(Kind::NotFinite, f64::from(u8::from(!finite)));
        if finite {
            record(Kind::NegativeLuminance, -found.luminance_cd_m2);
            record(Kind::OutsideLocus, locus.outside(found.x, found.y));
            record(Kind::Precision, difference(&found, &expected));
        }
    }
}
