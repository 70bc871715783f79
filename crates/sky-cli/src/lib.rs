//! The `utm-sky` command as a library: files, terminal, plots.
//!
//! Everything that touches a file or the terminal is here; the physics is in the other crates. The
//! binary is one call of [`run`]. Exit status: 0 on success, 2 on bad input, on a file that cannot
//! be written and on interruption.

pub mod args;
pub mod atlas;
pub mod atmosphere;
pub mod beam;
pub mod bench_gpu;
pub mod chart;
pub mod engine;
pub mod evaluate;
pub mod export_shaders;
pub mod extinction;
pub mod files;
pub mod fit_stress;
pub mod gallery;
pub mod generate;
pub mod light;
pub mod lut_commands;
pub mod map;
pub mod models;
pub mod optics;
mod perez_table;
pub mod plan;
pub mod profile;
pub mod render;
pub mod report;
pub mod scene;
pub mod segment;
pub mod sky;
pub mod table_io;
pub mod terrain;
pub mod tiers;
pub mod truth;
pub mod view;

use std::ffi::OsString;
use std::io::{self, Write as _};
use std::process::ExitCode;

use clap::Parser as _;

use args::{Cli, Command};

/// Exit status of every failure.
pub const EXIT_FAILURE: u8 = 2;

/// Runs a command line; the first argument is the program's name.
pub fn run<I, T>(args: I) -> ExitCode
where
    I: IntoIterator<Item = T>,
    T: Into<OsString> + Clone,
{
    let cli = match Cli::try_parse_from(args) {
        Ok(cli) => cli,
        Err(message) => {
            // Help and version are messages too; a terminal that is gone is no reason to fail.
            drop(message.print());
            return if message.use_stderr() {
                ExitCode::from(EXIT_FAILURE)
            } else {
                ExitCode::SUCCESS
            };
        }
    };
    files::clean_up_on_interrupt();
    match dispatch(&cli.command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            drop(writeln!(io::stderr(), "error: {error}"));
            ExitCode::from(EXIT_FAILURE)
        }
    }
}

fn dispatch(command: &Command) -> anyhow::Result<()> {
    match command {
        Command::Profile(args) => profile::run(args),
        Command::Optics(args) => optics::run(args),
        Command::Map(args) => map::run(args),
        Command::Beam(args) => beam::run(args),
        Command::Sky(args) => sky::run(args),
        Command::Segment(args) => segment::run(args),
        Command::Render(args) => render::run(args),
        Command::View(args) => view::run(args),
        Command::Gallery(args) => gallery::run(args),
        Command::Chart(args) => chart::run(args),
        Command::Models => models::run(),
        Command::Light(args) => light::run(args),
        Command::BenchGpu(args) => bench_gpu::run(args),
        Command::ExportShaders(args) => export_shaders::run(args),
        Command::Generate(args) => generate::run(args),
        Command::Plan(args) => plan::run(args),
        Command::Report(args) => report::run(args),
        Command::Atlas(args) => atlas::run(args),
        Command::FitStress(args) => fit_stress::run(args),
        Command::Lut(args) => lut_commands::run(args),
    }
}
