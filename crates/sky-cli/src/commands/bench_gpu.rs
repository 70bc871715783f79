//! `utm-sky bench-gpu`: what each way to draw a sky costs, beside the floor of a constant color.

use std::fmt::Write as _;
use std::path::PathBuf;

use anyhow::Result;
use clap::Args;
use sky_eval::progress::Progress as _;
use sky_gpu::headless::Headless;
use sky_render::stage::{CASES, Stage, adapter_name};

use crate::args::size;
use crate::io::files::OutputFile;
use crate::io::progress::Bars;

/// `utm-sky bench-gpu`.
#[derive(Debug, Args)]
#[command(after_help = "Example:
  utm-sky bench-gpu --size 1920x1080 --out bench.csv

Times are of render passes on a 16-bit float target, by the GPU's own clock where it has one. The sky
fills the picture. With composite, a scene 50 km away covers its lower half.")]
pub struct BenchGpuArgs {
    /// Pixels
    #[arg(long, value_name = "WxH", default_value = "1920x1080", value_parser = size)]
    pub size: [u32; 2],
    /// Frames a case, taken in turn
    #[arg(long, value_name = "N", default_value_t = 30, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub frames: u32,
    /// Times
    #[arg(long, value_name = "CSV")]
    pub out: PathBuf,
}

/// Runs the command.
///
/// # Errors
/// When there is no GPU or the output cannot be written.
pub fn run(args: &BenchGpuArgs) -> Result<()> {
    let out = OutputFile::create(&args.out)?;
    let gpu = Headless::new()?;
    let stage = Stage::new(&gpu, args.size)?;
    let draws: Vec<_> = CASES.iter().map(|case| stage.draw(*case)).collect();
    let bars = Bars::new();
    bars.begin("frames", Some(args.frames as usize + 1));
    let costs = stage.interleaved(&gpu, &draws, args.frames, f64::INFINITY, &|| bars.step())?;
    bars.end();
    let mut text =
        String::from("name,median_ns_per_pixel,p95_ns_per_pixel,ratio_to_floor,adapter\n");
    for (case, cost) in CASES.iter().zip(&costs) {
        writeln!(
            text,
            "{},{:.4},{:.4},{:.3},\"{}\"",
            case.name,
            cost.median_ns,
            cost.p95_ns,
            cost.median_ns / costs[0].median_ns,
            adapter_name(&gpu)
        )?;
    }
    out.commit(text.as_bytes())?;
    Ok(())
}
