//! Profiles by name or from files.

use std::path::Path;

use anyhow::Result;
use sky_eval::profiles::NamedProfile;

use super::files::read_text;

/// The profile of that name, or the one in that file (`./general` is a file).
///
/// # Errors
/// When the file cannot be read or its table is wrong.
pub fn load_profile(path_or_name: &Path) -> Result<NamedProfile> {
    let name = path_or_name.display().to_string();
    match NamedProfile::shipped(&name)? {
        Some(shipped) => Ok(shipped),
        None => NamedProfile::from_csv(&name, &read_text(path_or_name)?),
    }
}
