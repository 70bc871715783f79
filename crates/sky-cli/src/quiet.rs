//! Drivers that complain where nothing is wrong.

use std::env;
use std::ffi::{OsStr, OsString};

/// Names a directory of sockets. Mesa's Vulkan drivers look for a display there, although none is asked
/// for, and print an error where it is not set.
const SOCKETS: &str = "XDG_RUNTIME_DIR";

/// What the variable is set to for a program that opens a GPU; `None` where it is set already.
pub(crate) fn sockets() -> Option<[OsString; 2]> {
    let is_set = env::var_os(SOCKETS).is_some_and(|value| !value.is_empty());
    (cfg!(target_os = "linux") && !is_set).then(|| {
        [
            OsStr::new(SOCKETS).to_owned(),
            env::temp_dir().into_os_string(),
        ]
    })
}

/// Starts this program again, with its arguments and the variable set, for a process cannot safely change its own. Where
/// that is not needed or fails, it returns.
pub(crate) fn start_again_where_drivers_complain(args: &[OsString]) {
    #[cfg(unix)]
    if let (Some([name, value]), Ok(here)) = (sockets(), env::current_exe()) {
        use std::os::unix::process::CommandExt as _;
        // comes back only if it fails, and then the words of the driver are the lesser evil
        drop(
            std::process::Command::new(here)
                .args(args)
                .env(name, value)
                .exec(),
        );
    }
}
