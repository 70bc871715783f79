//! The `utm-sky` command as a library: files, terminal, plots.
//!
//! Everything that touches a file or the terminal is here; the physics is in the other crates. The
//! binary is one call of [`run`]. Exit status: 0 on success, 1 where a verdict is "not met", 2 on bad
//! input, on a file that cannot be written and on interruption.

pub mod args;
pub mod commands;
pub mod io;
mod quiet;
mod tell;

use std::ffi::OsString;
use std::io::{Write as _, stderr};
use std::process::ExitCode;

use clap::{Parser, Subcommand};

use commands::{
    atlas, beam, bench_gpu, chart, export_shaders, fit_stress, gallery, generate, light, lut, map,
    models, optics, plan, profile, render, report, segment, sky, view,
};
use io::files::{EXIT_FAILURE, clean_up_on_interrupt, remove_empty_directories};
use tell::tell;

/// Spectral sky radiance, fitted sky formulas and look-up tables for flight simulators.
#[derive(Debug, Parser)]
#[command(
    name = "utm-sky",
    version,
    max_term_width = 100,
    after_help = "Examples:
  utm-sky generate
  utm-sky map --altitude-km 6 --turbidity 2 --sun-zenith-deg 60 --yxy --out sky.csv

An output named - is standard output. Exit status: 0 on success, 1 where a verdict is \"not met\" (plan
--verify), 2 on bad input, when a file cannot be written and on interruption."
)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Print the atmosphere: the vertical profile that everything else starts from
    Profile(profile::ProfileArgs),
    /// Write extinction per level and wavelength
    Optics(optics::OpticsArgs),
    /// Write the sky's spectral radiance or Yxy by direction, computed from the atmosphere
    Map(map::MapArgs),
    /// Write the direct normal spectrum of the sun
    Beam(beam::BeamArgs),
    /// Write the sky's Yxy by direction, as the look-up table gives it
    Sky(sky::SkyArgs),
    /// Write transmittance and in-scattered light of finite paths
    Segment(segment::SegmentArgs),
    /// Draw a picture: sky, sun, ground or terrain
    Render(render::RenderArgs),
    /// Fly through the sky in a window
    View(view::ViewArgs),
    /// Draw the figures of the report of 2005 on one contact sheet
    Gallery(gallery::GalleryArgs),
    /// Compare every sky: error against cost, on one chart
    Chart(chart::ChartArgs),
    /// List the skies that can be compared, with citation and domain
    #[command(after_help = "Example:\n  utm-sky models")]
    Models,
    /// Print what a scene is lit with: sun, sky, spherical harmonics
    Light(light::LightArgs),
    /// Time the ways to draw a sky
    BenchGpu(bench_gpu::BenchGpuArgs),
    /// Write the shaders in another language, with the table
    ExportShaders(export_shaders::ExportShadersArgs),
    /// Compute maps on a grid, fit them, and write the look-up table and the report
    Generate(generate::GenerateArgs),
    /// Find the cheapest table that a scene needs
    Plan(plan::PlanArgs),
    /// Write the report on a look-up table as one HTML page
    Report(report::ReportArgs),
    /// Find where the models fail: a sweep over their domains and beyond
    Atlas(atlas::AtlasArgs),
    /// Fit damaged maps from random starts, with and without the fit's safeguards
    FitStress(fit_stress::FitStressArgs),
    /// Inspect or export a look-up table
    Lut(lut::LutArgs),
}

/// Runs a command line; the first argument is the program's name.
pub fn run<I, T>(args: I) -> ExitCode
where
    I: IntoIterator<Item = T>,
    T: Into<OsString> + Clone,
{
    let args: Vec<OsString> = args.into_iter().map(Into::into).collect();
    let cli = match Cli::try_parse_from(&args) {
        Ok(cli) => cli,
        Err(message) => return tell(&message),
    };
    if cli.command.wants_gpu() {
        quiet::start_again_where_drivers_complain(args.get(1..).unwrap_or_default());
    }
    clean_up_on_interrupt();
    match dispatch(&cli.command, args.get(2..).unwrap_or_default()) {
        Ok(status) => status,
        Err(error) => {
            remove_empty_directories();
            drop(writeln!(stderr(), "error: {error}"));
            ExitCode::from(EXIT_FAILURE)
        }
    }
}

impl Command {
    /// Whether it opens a GPU itself; `view` leaves that to the window's program.
    fn wants_gpu(&self) -> bool {
        match self {
            Self::Render(args) => args.backend == args::Backend::Gpu && args.model.is_none(),
            Self::Gallery(args) => args.backend == args::Backend::Gpu,
            Self::Chart(_) | Self::Atlas(_) | Self::BenchGpu(_) => true,
            _ => false,
        }
    }
}

/// `rest` is what stands behind the command on the line.
fn dispatch(command: &Command, rest: &[OsString]) -> anyhow::Result<ExitCode> {
    match command {
        Command::Profile(args) => profile::run(args),
        Command::Optics(args) => optics::run(args),
        Command::Map(args) => map::run(args),
        Command::Beam(args) => beam::run(args),
        Command::Sky(args) => sky::run(args),
        Command::Segment(args) => segment::run(args),
        Command::Render(args) => render::run(args),
        Command::View(_) => return view::run(rest),
        Command::Gallery(args) => gallery::run(args),
        Command::Chart(args) => chart::run(args),
        Command::Models => models::run(),
        Command::Light(args) => light::run(args),
        Command::BenchGpu(args) => bench_gpu::run(args),
        Command::ExportShaders(args) => export_shaders::run(args),
        Command::Generate(args) => generate::run(args),
        Command::Plan(args) => return plan::run(args),
        Command::Report(args) => report::run(args),
        Command::Atlas(args) => atlas::run(args),
        Command::FitStress(args) => fit_stress::run(args),
        Command::Lut(args) => lut::run(args),
    }?;
    Ok(ExitCode::SUCCESS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_definitions_are_consistent() {
        Cli::command().debug_assert();
    }

    /// Every command, with its path.
    fn all_commands(command: &clap::Command, path: &str) -> Vec<(String, clap::Command)> {
        let mut found = Vec::new();
        for sub in command.get_subcommands() {
            let path = format!("{path} {}", sub.get_name());
            found.extend(all_commands(sub, &path));
            found.push((path, sub.clone()));
        }
        found
    }

    #[test]
    fn every_command_has_an_example_that_parses() {
        for (path, mut command) in all_commands(&Cli::command(), "utm-sky") {
            let help = command.render_long_help().to_string();
            let (_, examples) = help
                .split_once("Example")
                .unwrap_or_else(|| panic!("{path} has no example"));
            let joined = examples.replace("\\\n", " ");
            let lines: Vec<&str> = joined
                .lines()
                .map(str::trim)
                .filter(|l| l.starts_with("utm-sky "))
                .collect();
            assert!(!lines.is_empty(), "{path} has no example");
            for line in lines {
                assert!(line.starts_with(&path), "{line} is no example of {path}");
                if let Err(error) = Cli::try_parse_from(line.split_whitespace()) {
                    panic!("{line}: {error}");
                }
            }
        }
    }

    fn refused(line: &str) -> String {
        Cli::try_parse_from(line.split_whitespace())
            .expect_err(line)
            .to_string()
    }

    #[test]
    fn values_outside_their_range_name_the_option_and_the_range() {
        let rest = "--aod500 0.1 --out o.csv";
        for (command, options, option, expected) in [
            (
                "sky",
                "--altitude-km 31 --sun-zenith-deg 60",
                "--altitude-km",
                "0 to 30",
            ),
            (
                "sky",
                "--altitude-km -1 --sun-zenith-deg 60",
                "--altitude-km",
                "0 to 30",
            ),
            (
                "sky",
                "--altitude-km nan --sun-zenith-deg 60",
                "--altitude-km",
                "0 to 30",
            ),
            (
                "sky",
                "--altitude-km 1 --sun-zenith-deg 96.1",
                "--sun-zenith-deg",
                "0 to 96",
            ),
            (
                "sky",
                "--altitude-km 1 --sun-zenith-deg x",
                "--sun-zenith-deg",
                "0 to 96",
            ),
            (
                "map",
                "--altitude-km 1 --sun-zenith-deg 60 --albedo 2",
                "--albedo",
                "0 to 1",
            ),
            (
                "map",
                "--altitude-km 101 --sun-zenith-deg 60",
                "--altitude-km",
                "-0.5 to 100",
            ),
            (
                "map",
                "--altitude-km 1 --sun-zenith-deg 108.1",
                "--sun-zenith-deg",
                "0 to 108",
            ),
        ] {
            let message = refused(&format!("utm-sky {command} {options} {rest}"));
            assert!(message.contains(option), "{message}");
            assert!(message.contains(expected), "{message}");
        }
    }
}
