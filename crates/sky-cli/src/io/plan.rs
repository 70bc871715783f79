//! Scene and plan files, each with the profile that it names.

use std::path::Path;

use anyhow::{Result, anyhow};
use sky_eval::profiles::NamedProfile;
use sky_plan::{Plan, Scene};

use super::files::read_text;
use super::profile::load_profile;

/// Reads a scene.
///
/// # Errors
/// Names file, field, what was expected and what was found.
pub fn load_scene(path: &Path) -> Result<Scene> {
    let stem = path
        .file_stem()
        .map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    Scene::from_toml(&stem, &read_text(path)?).map_err(|e| anyhow!("{}: {e}", path.display()))
}

/// Reads a plan and its profile.
///
/// # Errors
/// Names file, field, what was expected and what was found.
pub fn load_plan(path: &Path) -> Result<(Plan, NamedProfile)> {
    let plan = Plan::from_toml(&path.display().to_string(), &read_text(path)?)?;
    let profile = load_profile(&plan.profile)?;
    Ok((plan, profile))
}
