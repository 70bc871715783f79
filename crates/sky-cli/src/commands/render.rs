//! `utm-sky render`: pictures of the sky without a window, by GPU or CPU.

use std::path::PathBuf;

use anyhow::{Context as _, Result, anyhow, bail};
use clap::{ArgGroup, Args, ValueEnum};
use sky_core::color::{linear_srgb_from_xyz, xyz_from_yxy};
use sky_core::conditions::Conditions;
use sky_core::direction::SkyDirection;
use sky_core::lut::LutHeader;
use sky_core::quantity::{Angle, single};
use sky_core::tonemap::exposure_from_ev100;
use sky_eval::models::{answers, open};
use sky_gpu::headless::check_size;
use sky_gpu::{Camera, Projection, Tier, ev100_for_mean};
use sky_plan::plan::without_aerial;
use sky_render::camera::pixels;
use sky_render::pixels::developed;
use sky_render::{
    Painter, Pixels, Shot, draw_on_cpu, facing, file_bytes, file_bytes_with_comment, looking,
};
use sky_science::direction::report_directions;
use sky_science::metrics::cosine_weighted_mean;
use sky_science::sky_model::SkyModel;

use crate::args::{
    Backend, Ev100, HAZE, SceneArgs, SceneKind, TierKind, ToneKind, ev100, look, size, within,
};
use crate::io::files::{OutputFile, has_extension, is_standard_output, print};
use crate::io::progress::Bars;
use crate::io::scene::Scene;

/// A way to project the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ProjectionKind {
    /// As a camera sees it
    Perspective,
    /// The upper half of the sky as a disc
    Fisheye,
    /// All directions, azimuth across and elevation up
    Equirect,
}

/// `utm-sky render`.
#[derive(Debug, Args)]
#[command(
    group(ArgGroup::new("haze").required(true).args(HAZE)),
    after_help = "Examples:
  utm-sky render --altitude-km 0.1 --turbidity 2.5 --sun-zenith-deg 80 --out evening.png
  utm-sky render --altitude-km 12 --visual-range-km 60 --sun-zenith-deg 60 --scene terrain \\
      --look 30,-5 --fov-deg 70 --size 1920x1080 --out flight.png
  utm-sky render --altitude-km 20 --turbidity 1.5 --sun-zenith-deg 92 --projection fisheye \\
      --size 800x800 --backend cpu --out twilight.exr

  utm-sky render --model hillaire --altitude-km 1 --turbidity 3 --sun-zenith-deg 85 --out peer.png

Azimuths are clockwise from north. A PNG is 8-bit sRGB; an EXR holds linear sRGB in cd/m2. In an
equirectangular EXR the sun's disc is spread over the pixels that it touches, so that their light on a
plane is the sun's at every size; --no-sun leaves it out, and the file says so. With --model the CPU
draws the sky alone: black where the model has no answer, and no sun."
)]
pub struct RenderArgs {
    /// Table, observer, sun and haze.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// A sky of `utm-sky models` in place of the table's
    #[arg(long, value_name = "NAME", conflicts_with_all = ["lut", "scenery", "tier", "no_aerial"])]
    pub model: Option<String>,
    /// Azimuth of the sun, clockwise from north [deg]
    #[arg(long, value_name = "DEG", default_value_t = 180.0, value_parser = within(-360.0, 360.0),
          allow_negative_numbers = true)]
    pub sun_azimuth_deg: f64,
    /// Projection
    #[arg(long, value_enum, default_value = "perspective")]
    pub projection: ProjectionKind,
    /// Pixels
    #[arg(long, value_name = "WxH", default_value = "960x540", value_parser = size)]
    pub size: [u32; 2],
    /// Where the camera looks, azimuth from north and elevation [deg]; without it toward the sun's
    /// azimuth, 10 above the horizontal
    #[arg(long, value_name = "AZ,EL", value_parser = look, allow_hyphen_values = true)]
    pub look: Option<[f64; 2]>,
    /// Vertical field of view of a perspective picture; without it 60 [deg]
    #[arg(long, value_name = "DEG", value_parser = within(1.0, 170.0))]
    pub fov_deg: Option<f64>,
    /// How the GPU draws the sky; without it as a plan has it, else baked
    #[arg(long, value_enum)]
    pub tier: Option<TierKind>,
    /// What stands under the sky
    #[arg(long = "scene", value_enum, default_value_t)]
    pub scenery: SceneKind,
    /// Leave the air between camera and scene out, as some plans do
    #[arg(long)]
    pub no_aerial: bool,
    /// Who draws
    #[arg(long, value_enum, default_value_t)]
    pub backend: Backend,
    /// Exposure value at ISO 100 of a PNG, or auto; without it auto
    #[arg(long, value_name = "E|auto", value_parser = ev100, allow_hyphen_values = true)]
    pub ev100: Option<Ev100>,
    /// Tone curve of a PNG; without it neutral
    #[arg(long, value_enum)]
    pub tone: Option<ToneKind>,
    /// Leave the sun's disc out, for renderers that have a sun of their own
    #[arg(long)]
    pub no_sun: bool,
    /// Picture: .png or .exr; - is a PNG to standard output
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
}

/// Runs the command.
///
/// # Errors
/// When an input is wrong, there is no GPU, or the picture cannot be written.
pub fn run(args: &RenderArgs) -> Result<()> {
    let is_exr = has_extension(&args.out, "exr");
    if !is_exr && !has_extension(&args.out, "png") && !is_standard_output(&args.out) {
        bail!(
            "--out: expected a name ending in .png or .exr, found {}",
            args.out.display()
        );
    }
    refuse_what_is_unused(args, is_exr)?;
    if let Some(name) = &args.model {
        let shot = shot(args, &args.scene.conditions()?, None, is_exr);
        let out = OutputFile::create(&args.out)?;
        let pixels = draw_model(&*open(name, &Bars::new())?, &shot)?;
        out.commit(&file_bytes(&pixels, shot.size)?)?;
        return Ok(());
    }
    let scene = Scene::open(&args.scene)?;
    let header = scene.sky.lut().header();
    let shot = shot(args, &scene.conditions, Some(header), is_exr);
    let standing = shot.standing().observer_altitude.km();
    if standing > scene.conditions.observer_altitude.km() && !is_standard_output(&args.out) {
        print(&format!(
            "the ground is higher than {} km there: seen from {standing:.3} km\n",
            args.scene.place.altitude_km
        ))?;
    }
    let out = OutputFile::create(&args.out)?;
    let source = scene.source.clone();
    let pixels = match args.backend {
        Backend::Cpu => draw_on_cpu(&scene.sky, &shot),
        Backend::Gpu => Painter::new(scene.sky).and_then(|mut painter| painter.draw(&shot)),
    }
    .with_context(|| source)
    .map_err(|e| anyhow!("{e:#}"))?;
    let bytes = match comment(&shot) {
        Some(comment) => file_bytes_with_comment(&pixels, shot.size, comment)?,
        None => file_bytes(&pixels, shot.size)?,
    };
    out.commit(&bytes)?;
    Ok(())
}

/// What the file says about the sun, where it is not drawn as a camera sees it.
fn comment(shot: &Shot) -> Option<&'static str> {
    if !shot.sun_disc {
        Some("The sun's disc is left out.")
    } else if shot.spreads_sun() {
        Some("Linear sRGB [cd/m2]. The sun's disc is spread over the pixels that it touches.")
    } else {
        None
    }
}

/// What would have no effect on this picture is no part of it.
fn refuse_what_is_unused(args: &RenderArgs, is_exr: bool) -> Result<()> {
    let is_panorama = args.projection != ProjectionKind::Perspective;
    if let (true, Some(fov)) = (is_panorama, args.fov_deg) {
        bail!("--fov-deg: expected with --projection perspective alone, found {fov}");
    }
    if let (true, Some([_, elevation])) = (is_panorama, args.look)
        && elevation.abs() > 0.0
    {
        bail!(
            "--look: expected an elevation of 0 with --projection fisheye or equirect, which stay level, \
             found {elevation}"
        );
    }
    let by_cpu = args.backend == Backend::Cpu;
    if let (true, Some(tier @ (TierKind::Vertex | TierKind::Baked))) = (by_cpu, args.tier) {
        let found = format!("{tier:?}").to_lowercase();
        bail!("--tier: expected fragment with --backend cpu, which knows no other, found {found}");
    }
    if is_exr && (args.ev100.is_some() || args.tone.is_some()) {
        bail!("--ev100, --tone: expected with a .png alone, for an .exr holds linear light");
    }
    Ok(())
}

/// A plan's table says how it is drawn, where the arguments do not.
fn shot(
    args: &RenderArgs,
    conditions: &Conditions,
    header: Option<&LutHeader>,
    linear: bool,
) -> Shot {
    let [azimuth, elevation] = args.look.unwrap_or([args.sun_azimuth_deg, 10.0]);
    let [width, height] = args.size;
    let aspect = pixels(width) / pixels(height);
    let camera = match args.projection {
        ProjectionKind::Perspective => Camera {
            depth_is_distance: true,
            ..Camera::perspective(
                single(Angle::from_degrees(args.fov_deg.unwrap_or(60.0)).radians()),
                aspect,
                looking(azimuth, elevation),
            )
        },
        ProjectionKind::Fisheye => {
            Camera::panorama(Projection::Fisheye { aspect }, facing(azimuth))
        }
        ProjectionKind::Equirect => Camera::panorama(Projection::Equirectangular, facing(azimuth)),
    };
    Shot {
        conditions: *conditions,
        sun_azimuth: Angle::from_degrees(args.sun_azimuth_deg),
        camera,
        size: args.size,
        ev100: args.ev100.and_then(|ev100| ev100.0),
        tone: (!linear).then(|| args.tone.unwrap_or_default().into()),
        tier: args
            .tier
            .map(Tier::from)
            .or_else(|| Tier::planned(header?))
            .unwrap_or_else(|| TierKind::default().into()),
        sun_disc: !args.no_sun && args.model.is_none(),
        scenery: args.scenery.into(),
        aerial: !args.no_aerial && !header.is_some_and(without_aerial),
    }
}

/// The pixels of any sky: black where it has no answer, and no sun.
///
/// # Errors
/// When the conditions lie outside the domain or the size cannot be drawn.
pub fn draw_model(sky: &dyn SkyModel, shot: &Shot) -> Result<Pixels> {
    check_size(shot.size)?;
    let [width, height] = shot.size;
    let axes = shot.frame().local_axes();
    let (places, directions): (Vec<usize>, Vec<SkyDirection>) = (0..height)
        .flat_map(|y| (0..width).map(move |x| (x, y)))
        .enumerate()
        .filter_map(|(i, (x, y))| {
            let world = shot.direction(x, y)?;
            let direction = SkyDirection::from_vector(axes.map(|axis| f64::from(axis.dot(world))));
            answers(sky.domain(), &shot.conditions, &direction).then_some((i, direction))
        })
        .unzip();
    let ask = |directions: &[SkyDirection]| {
        sky.yxy_map(&shot.conditions, directions)
            .map_err(|e| anyhow!("{}: {e}", sky.name()))
    };
    let mut lights = vec![[0.0; 3]; width as usize * height as usize];
    for (place, yxy) in places.into_iter().zip(ask(&directions)?) {
        let rgb = linear_srgb_from_xyz(xyz_from_yxy(yxy));
        lights[place] = [rgb.red, rgb.green, rgb.blue].map(single);
    }
    let exposure = match (shot.tone, shot.ev100) {
        (None, _) => 1.0,
        (_, Some(ev100)) => exposure_from_ev100(ev100),
        (_, None) => {
            // not the horizontal, where 1/cos has no value
            let mut above = report_directions();
            above.retain(|d| d.view_zenith.degrees() < 89.0);
            let luminances: Vec<f64> = ask(&above)?.iter().map(|l| l.luminance_cd_m2).collect();
            let mean = cosine_weighted_mean(&above, &luminances).unwrap_or(0.0);
            exposure_from_ev100(ev100_for_mean(single(mean)))
        }
    };
    Ok(developed(lights, shot.size[0], shot.tone, exposure))
}
