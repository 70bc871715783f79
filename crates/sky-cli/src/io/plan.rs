//! Scene and plan files, each with the profile that it names.

use std::path::Path;

use anyhow::{Result, anyhow};
use sky_eval::profiles::NamedProfile;
use sky_plan::{Plan, Scene};
use sky_profiles::SCENES;

use super::files::read_text;
use super::profile::load_profile;

/// The shipped scene of that name, or the one in that file.
///
/// # Errors
/// Names file, field, what was expected and what was found.
pub fn load_scene(path: &Path) -> Result<Scene> {
    let stem = path
        .file_stem()
        .map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    let shipped = SCENES.iter().find(|scene| Path::new(scene.name) == path);
    let text = shipped.map_or_else(|| read_text(path), |scene| Ok(scene.toml.to_owned()))?;
    let name = path.display();
    Scene::from_toml(&stem, &text).map_err(|error| {
        if Plan::from_toml("", &text).is_ok() {
            anyhow!(
                "{name}: expected a scene, found a plan; utm-sky plan --verify {name} measures it"
            )
        } else {
            anyhow!("{name}: {error}")
        }
    })
}

/// Reads a plan and its profile.
///
/// # Errors
/// Names file, field, what was expected and what was found.
pub fn load_plan(path: &Path) -> Result<(Plan, NamedProfile)> {
    let text = read_text(path)?;
    let name = path.display();
    let plan = Plan::from_toml(&name.to_string(), &text).map_err(|error| {
        if Scene::from_toml("", &text).is_ok() {
            anyhow!(
                "{name}: expected a plan, found a scene; utm-sky plan {name} --out plan.toml makes its plan"
            )
        } else {
            error
        }
    })?;
    let profile = load_profile(&plan.profile)?;
    Ok((plan, profile))
}
