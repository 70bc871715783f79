//! `utm-sky light`: what a scene is lit with, as JSON.

use anyhow::Result;
use clap::{ArgGroup, Args};
use serde_json::{Value, json};
use sky_core::color::{LinearSrgb, xyz_from_linear_srgb, yxy_from_xyz};
use sky_core::picture::Picture;
use sky_core::quantity::single;

use crate::args::{HAZE, SceneArgs, within};
use crate::io::files::print;
use crate::io::scene::Scene;

/// `utm-sky light`.
#[derive(Debug, Args)]
#[command(
    group(ArgGroup::new("haze").required(true).args(HAZE)),
    after_help = "Example:
  utm-sky light --altitude-km 3 --turbidity 2 --sun-zenith-deg 60

Prints JSON: sunlight on a plane facing the sun, skylight on a horizontal plane, light of the ground,
and sky and ground as nine spherical harmonics (x toward the sun's azimuth, z up)."
)]
pub struct LightArgs {
    /// Table, observer, sun and haze.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Albedo of the ground
    #[arg(long, value_name = "A", default_value_t = 0.2, value_parser = within(0.0, 1.0))]
    pub albedo: f64,
}

/// Runs the command.
///
/// # Errors
/// When an input is wrong or the terminal is gone.
pub fn run(args: &LightArgs) -> Result<()> {
    let scene = Scene::open(&args.scene)?;
    let picture = Picture::new(&scene.sky, &scene.conditions, single(args.albedo))
        .map_err(|e| scene.refusal(e))?;
    let text = serde_json::to_string_pretty(&described(&picture))? + "\n";
    print(&text)?;
    Ok(())
}

/// A light by luminance (or illuminance), chromaticity and linear sRGB.
fn light(unit: &str, rgb: [f32; 3]) -> Value {
    let [red, green, blue] = rgb.map(f64::from);
    let yxy = yxy_from_xyz(xyz_from_linear_srgb(LinearSrgb { red, green, blue }));
    json!({
        unit: yxy.luminance_cd_m2,
        "x": yxy.x,
        "y": yxy.y,
        "linear_srgb": rgb,
    })
}

/// The values by name.
#[must_use]
pub fn described(picture: &Picture) -> Value {
    let l = &picture.light;
    json!({
        "sun_direct_normal": light("illuminance_lx", l.sun_normal),
        "sky_horizontal": light("illuminance_lx", l.sky_horizontal),
        "ground": light("luminance_cd_m2", l.ground),
        "sky_harmonics_cd_m2": {
            "order": ["1", "y", "z", "x", "xy", "yz", "3z2-1", "xz", "x2-y2"],
            "linear_srgb": l.harmonics,
        },
    })
}
