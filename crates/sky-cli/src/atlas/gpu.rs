//! The sky as the GPU computes it, against the CPU's: whole panoramas at places all over the domain.

use anyhow::Result;
use sky_core::color::Yxy;
use sky_core::color::{LinearSrgb, xyz_from_linear_srgb, yxy_from_xyz};
use sky_core::conditions::{Conditions, Domain};
use sky_core::direction::{SkyDirection, horizon_zenith};
use sky_core::haze::Haze;
use sky_core::quantity::Angle;
use sky_core::quantity::single;
use sky_core::utm_sky::UtmSky;
use sky_gpu::headless::Headless;
use sky_gpu::{Camera, Exposure, Projection, SkyFrame, SkyRenderer, Tier};

use super::kind::{Arithmetic, Kind, Place, With};
use super::locus::Locus;
use super::sweep::{Density, EDGE_DEG, Findings, difference, is_finite};
use crate::evaluate::conditions;
use crate::render::{clip, facing, world_direction};

/// Pixels of a panorama; somewhat more than half of them are sky.
const SIZE: [u32; 2] = [512, 256];
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

impl Density {
    /// Panoramas: in full above 10⁷ lights.
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
/// When the table cannot be drawn or the device is lost.
pub(super) fn sweep(
    gpu: &Headless,
    sky: &UtmSky,
    density: Density,
    findings: &mut Findings,
    done: &dyn Fn(),
) -> Result<()> {
    let target = gpu.target(SIZE, FORMAT)?;
    let view = target.create_view(&wgpu::TextureViewDescriptor::default());
    let mut renderer = SkyRenderer::new(&gpu.device, sky.lut(), FORMAT)?;
    let locus = Locus::new();
    for i in 0..density.panoramas() {
        let wanted = place(&sky.lut().header().domain, i);
        let azimuth = f64::from(i) * 137.5;
        let frame = SkyFrame {
            observer_altitude: wanted.observer_altitude,
            haze: Haze::Turbidity(wanted.turbidity),
            sun: world_direction(
                Angle::from_degrees(azimuth),
                Angle::from_degrees(90.0 - wanted.sun_zenith.degrees()),
            ),
            sun_disc: false,
            exposure: Exposure::None,
            tone: None,
            ..SkyFrame::default()
        };
        let camera = Camera::panorama(Projection::Equirectangular, facing(azimuth + 10.0));
        // what the renderer sees in the sun's direction, which is single
        let Ok(seen) = frame.conditions() else {
            continue;
        };
        let Ok(truth) = sky.frame(&seen) else {
            continue;
        };
        renderer.update(&gpu.queue, &frame)?;
        renderer.set_camera(&gpu.queue, 0, &camera);
        gpu.draw(&mut renderer, &view, Tier::Fragment, |_, _| ());
        let bytes = gpu.read(&target)?;
        let axes = frame.local_axes();
        let horizon = horizon_zenith(seen.observer_altitude).radians();
        let lowest = single((horizon - Angle::from_degrees(EDGE_DEG).radians()).cos());
        let [width, height] = SIZE;
        let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        for ((x, y), pixel) in places.zip(bytes.chunks_exact(16)) {
            let Some(world) = camera.direction(clip([x, y], SIZE)) else {
                continue;
            };
            let local = axes.map(|axis| axis.dot(world));
            if local[2] < lowest {
                continue;
            }
            let Some(expected) = truth.light(local) else {
                continue;
            };
            let expected = Yxy {
                luminance_cd_m2: expected[0].into(),
                x: expected[1].into(),
                y: expected[2].into(),
            };
            let number = |c: usize| {
                let b = &pixel[4 * c..4 * c + 4];
                f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
            };
            let found = yxy_from_xyz(xyz_from_linear_srgb(LinearSrgb {
                red: number(0),
                green: number(1),
                blue: number(2),
            }));
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
        done();
    }
    Ok(())
}
