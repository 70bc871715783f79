//! What is wrong with a command line, or its help.

use std::process::ExitCode;

use crate::io::files::EXIT_FAILURE;

/// Prints it, and says how to end.
pub(crate) fn tell(message: &clap::Error) -> ExitCode {
    // Help and version are messages too; a terminal that is gone is no reason to fail.
    drop(message.print());
    if message.use_stderr() {
        ExitCode::from(EXIT_FAILURE)
    } else {
        ExitCode::SUCCESS
    }
}
