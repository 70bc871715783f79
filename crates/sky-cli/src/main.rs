//! The `utm-sky` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    sky_cli::run(std::env::args_os())
}
