//! `utm-sky chart`: speed against accuracy of every sky, measured in one run on one machine.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;
use sky_core::conditions::Conditions;
use sky_core::quantity::Angle;
use sky_eval::cases::conditions;
use sky_eval::chart::measure::{chart_cases, chosen, rows};
use sky_eval::chart::rows::GpuCosts;
use sky_eval::chart::{offline, page};
use sky_eval::models::{Model, Opened, Source, general_truth};
use sky_eval::progress::Progress as _;
use sky_gpu::headless::Headless;
use sky_gpu::{Dome, FrameSettings, Tier};
use sky_render::published::published;
use sky_render::stage::{
    CASES, Cost, Draw, STAGE_PLACE, STAGE_SUN_ZENITH_DEG, Stage, adapter_name,
};
use sky_render::world_direction;

use crate::io::files::{OutputFile, create_directory, print};
use crate::io::progress::Bars;

/// Sizes that GPU costs are taken at.
const SIZES: [[u32; 2]; 2] = [[1920, 1080], [3840, 2160]];

/// `utm-sky chart`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  utm-sky chart
  utm-sky chart --models utm-sky,hillaire,preetham --quick --out chart

Measures error against the transport engine and cost of every model in one run, and writes chart.csv,
chart.svg and chart.html. --quick takes fewer cases and one picture size.")]
pub struct ChartArgs {
    /// Models to compare, by name; without it all (see utm-sky models)
    #[arg(long, value_name = "A,B", value_delimiter = ',')]
    pub models: Vec<String>,
    /// Fewer cases and frames
    #[arg(long)]
    pub quick: bool,
    /// Directory
    #[arg(long, value_name = "DIR", default_value = "target/utm-sky/chart")]
    pub out: PathBuf,
}

/// Runs the command.
///
/// # Errors
/// When a model is unknown, a table cannot be baked or an output cannot be written.
pub fn run(args: &ChartArgs) -> Result<()> {
    let models = chosen(&args.models)?;
    let bars = Bars::new();
    create_directory(&args.out)?;
    let file = |name: &str| OutputFile::create(&args.out.join(name));
    let (csv_file, svg_file, page_file) =
        (file("chart.csv")?, file("chart.svg")?, file("chart.html")?);
    // our own settings belong to the whole chart; a quick one has a sample of them
    let offline = if args.quick || args.models.is_empty() {
        Some((file("offline.csv")?, offline::measure(args.quick, &bars)?))
    } else {
        None
    };
    let truth = general_truth()?;
    let cases = chart_cases(&truth, args.quick, &bars)?;
    let skies: Vec<Opened> = models
        .iter()
        .map(|model| model.open(&truth, &bars))
        .collect::<Result<_>>()?;
    let gpu = Headless::new().ok();
    let adapter = gpu.as_ref().map_or_else(|| "none".to_owned(), adapter_name);
    let gpu_costs = match &gpu {
        Some(gpu) => time_on_gpu(gpu, &models, &skies, args.quick, &bars)?,
        None => vec![GpuCosts::default(); models.len()],
    };
    let measured = models
        .into_iter()
        .zip(&skies)
        .zip(gpu_costs)
        .map(|((model, sky), gpu)| (model, sky, gpu))
        .collect();
    let rows = rows(measured, &cases, &timed(), &bars)?;
    csv_file.commit(page::csv(&rows, &adapter)?.as_bytes())?;
    let panels = page::panels(&rows)?;
    svg_file.commit(page::sheet(&rows)?.as_bytes())?;
    let offline = match offline {
        Some((file, points)) => {
            file.commit(offline::csv(&points)?.as_bytes())?;
            offline::html(&points)?
        }
        None => "<p class=\"soft\">Measured where all models are.</p>".to_owned(),
    };
    page_file.commit(page::html(&rows, &panels, &offline, &adapter).as_bytes())?;
    print(&page::beside_text(&rows, &page::beside(&rows))?)?;
    Ok(())
}

/// The conditions of the timed frames.
const fn timed() -> Conditions {
    conditions(STAGE_PLACE[0], STAGE_PLACE[1], STAGE_SUN_ZENITH_DEG)
}

/// Nanoseconds a pixel at both sizes and the ratio to the floor, for each model.
fn time_on_gpu(
    gpu: &Headless,
    models: &[Model],
    skies: &[Opened],
    quick: bool,
    bars: &Bars,
) -> Result<Vec<GpuCosts>> {
    let mut out = vec![GpuCosts::default(); models.len()];
    let sizes = if quick { &SIZES[..1] } else { &SIZES[..] };
    let (frames, seconds) = if quick { (5, 2.0) } else { (15, 4.0) };
    bars.begin("GPU frames", Some(sizes.len() * (frames as usize + 1)));
    for (s, size) in sizes.iter().enumerate() {
        let stage = Stage::new(gpu, *size)?;
        let mut draws: Vec<Draw<'_>> = vec![stage.draw(CASES[0])];
        let mut places = Vec::new();
        for (i, (model, sky)) in models.iter().zip(skies).enumerate() {
            let tier = match model.source {
                Source::Ours => Some(Tier::Fragment),
                Source::Baked => Some(Tier::Baked),
                Source::Dome => Some(Tier::Vertex(Dome::REPORT)),
                Source::Table(_) | Source::Published(_) => None,
            };
            if let Some(case) = CASES
                .iter()
                .find(|c| tier.is_some() && c.tier == tier && !c.composite)
            {
                draws.push(stage.draw(*case));
                places.push(i);
            } else if let Some(shader) = sky.shader_sky() {
                let axes = FrameSettings {
                    sun: world_direction(
                        Angle::ZERO,
                        Angle::from_degrees(90.0 - STAGE_SUN_ZENITH_DEG),
                    ),
                    ..FrameSettings::default()
                }
                .local_axes();
                let clip_to_local = Stage::camera(*size).clip_to_local(axes);
                let format = wgpu::TextureFormat::Rgba16Float;
                draws.push(published(gpu, shader, &timed(), clip_to_local, format)?);
                places.push(i);
            }
        }
        let costs: Vec<Cost> = stage.interleaved(gpu, &draws, frames, seconds, &|| bars.step())?;
        for (place, cost) in places.iter().zip(&costs[1..]) {
            out[*place].ns[s] = Some(cost.median_ns);
            if s == 0 {
                out[*place].ratio = Some(cost.median_ns / costs[0].median_ns);
            }
        }
    }
    bars.end();
    Ok(out)
}
