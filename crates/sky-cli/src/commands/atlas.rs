//! `utm-sky atlas`: where every model fails, found by a sweep over its domain and beyond.

use std::path::PathBuf;

use anyhow::{Result, bail};
use clap::Args;
use sky_core::conditions::Conditions;
use sky_core::haze::Haze;
use sky_core::quantity::Angle;
use sky_core::utm_sky::UtmSky;
use sky_eval::atlas::page;
use sky_eval::atlas::panorama::{self, Panorama};
use sky_eval::atlas::rows::{Chapter, csv};
use sky_eval::atlas::subject::chosen;
use sky_eval::progress::Progress as _;
use sky_gpu::headless::Headless;
use sky_gpu::{
    Camera, Exposure, FrameSettings, Output, Projection, SkyRenderer, SkyRendererOptions, Tier,
};
use sky_render::pixels::floats_of;
use sky_render::{clip, facing, world_direction};

use crate::io::files::{OutputFile, create_directory, print};
use crate::io::progress::Bars;

/// Pixels of a panorama; somewhat more than half of them are sky.
const SIZE: [u32; 2] = [512, 256];
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

/// `utm-sky atlas`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  utm-sky atlas --quick
  utm-sky atlas --models utm-sky,utm2005 --out atlas

atlas.csv has a row for each model, arithmetic, kind of failure and side of the model's domain:
samples, failures, the largest score and a command that shows it. What the score of a kind is,
and above which limit it is a failure, stands in atlas.html. The tables that were made for the sweep
are written beside it.")]
pub struct AtlasArgs {
    /// Fewer samples, for a first look, and only the models that are quick themselves
    #[arg(long)]
    pub quick: bool,
    /// Models, separated by commas; without it all of `utm-sky models` but our own tiers
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    pub models: Option<Vec<String>>,
    /// Directory for atlas.csv and atlas.html; made if missing
    #[arg(long, value_name = "DIR", default_value = "target/utm-sky/atlas")]
    pub out: PathBuf,
}

/// Runs the command.
///
/// # Errors
/// When a model is unknown or cannot be made, or the files cannot be written.
pub fn run(args: &AtlasArgs) -> Result<()> {
    let models = chosen(args.models.as_deref(), args.quick)?;
    if models.is_empty() {
        bail!("--models: expected at least one model, found none");
    }
    create_directory(&args.out)?;
    let bars = Bars::new();
    let csv_file = OutputFile::create(&args.out.join("atlas.csv"))?;
    let html_file = OutputFile::create(&args.out.join("atlas.html"))?;
    let mut chapters = Vec::new();
    for entry in models {
        bars.begin(entry.name, None);
        let subject = entry.subject(&bars)?;
        let density = entry.density(args.quick);
        bars.end();
        if let (Some(table), Some(name)) = (subject.table(), &subject.lut)
            && name != "embedded"
        {
            // what the commands of the atlas ask
            OutputFile::create(&args.out.join(name))?.commit(&table.lut().encode())?;
        }
        bars.begin(entry.name, Some(subject.columns(density)));
        let mut findings = subject.sweep(density, &|| bars.step());
        bars.end();
        if let Some(table) = subject.table()
            && subject.lut.as_deref() == Some("embedded")
        {
            match Headless::new() {
                Ok(gpu) => {
                    let mut draw = panoramas(&gpu, table)?;
                    bars.begin("panoramas", Some(density.panoramas() as usize));
                    panorama::sweep(table, density, &mut draw, &mut findings, &|| bars.step())?;
                    bars.end();
                }
                Err(error) => print(&format!("gpu_f32 is left out: {error}\n"))?,
            }
        }
        chapters.push(Chapter {
            name: entry.name,
            subject,
            findings,
        });
    }
    csv_file.commit(&csv(&chapters)?)?;
    html_file.commit(page::html(&chapters)?.as_bytes())?;
    Ok(())
}

/// What draws panoramas of a table's sky on a GPU.
fn panoramas(
    gpu: &Headless,
    table: &UtmSky,
) -> Result<impl FnMut(&Conditions, f64) -> Result<Option<Panorama>>> {
    let target = gpu.target(SIZE, FORMAT)?;
    let target_view = target.create_view(&wgpu::TextureViewDescriptor::default());
    let options = SkyRendererOptions::new(FORMAT, Output::Linear);
    let renderer = SkyRenderer::new(&gpu.device, table, &options);
    let mut view = renderer.view(&gpu.device);
    Ok(move |wanted: &Conditions, azimuth: f64| {
        let frame = FrameSettings {
            observer_altitude: wanted.observer_altitude,
            haze: Haze::Turbidity(wanted.turbidity),
            sun: world_direction(
                Angle::from_degrees(azimuth),
                Angle::from_degrees(90.0 - wanted.sun_zenith.degrees()),
            ),
            sun_disc: false,
            exposure: Exposure::None,
            tone: None,
            ..FrameSettings::default()
        };
        let camera = Camera::panorama(Projection::Equirectangular, facing(azimuth + 10.0));
        let Ok(conditions) = frame.conditions() else {
            return Ok(None);
        };
        if table.domain().check(&conditions).is_err() {
            return Ok(None);
        }
        renderer.update(&gpu.queue, &mut view, &frame)?;
        renderer.set_camera(&gpu.queue, &mut view, &camera);
        gpu.draw(
            &renderer,
            &mut view,
            &target_view,
            Tier::Fragment,
            |_, _| (),
        );
        let bytes = gpu.read(&target)?;
        let axes = frame.local_axes();
        let [width, height] = SIZE;
        let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let pixels = places
            .zip(floats_of(&bytes).chunks_exact(4))
            .filter_map(|((x, y), pixel)| {
                let world = camera.direction(clip([x, y], SIZE))?;
                let local = axes.map(|axis| axis.dot(world));
                Some((local, [pixel[0], pixel[1], pixel[2]]))
            })
            .collect();
        Ok(Some(Panorama { conditions, pixels }))
    })
}
