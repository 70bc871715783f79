//! The `utm-sky` command for the tests: cargo builds the programs of a package before its tests.

use std::process::ExitCode;

fn main() -> ExitCode {
    sky_cli::run(std::env::args_os())
}
