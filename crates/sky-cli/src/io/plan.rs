//! Scene and plan files, each with the profile that it names.

use std::path::Path;

use anyhow::{Result, anyhow};
use sky_eval::profiles::NamedProfile;
use sky_plan::{Plan, Scene};

use super::files::read_text;
use super::profile::load_profile;

/// The scenes that can be named instead of a file: name and content.
pub const SCENES: [[&str; 2]; 7] = [
    [
        "airliner_day",
        include_str!("../../../../profiles/scenes/airliner_day.toml"),
    ],
    [
        "airliner_dusk",
        include_str!("../../../../profiles/scenes/airliner_dusk.toml"),
    ],
    [
        "circuit_training",
        include_str!("../../../../profiles/scenes/circuit_training.toml"),
    ],
    [
        "hazy_city",
        include_str!("../../../../profiles/scenes/hazy_city.toml"),
    ],
    [
        "high_altitude",
        include_str!("../../../../profiles/scenes/high_altitude.toml"),
    ],
    [
        "runway_noon",
        include_str!("../../../../profiles/scenes/runway_noon.toml"),
    ],
    [
        "web_demo",
        include_str!("../../../../profiles/scenes/web_demo.toml"),
    ],
];

/// The shipped scene of that name, or the one in that file.
///
/// # Errors
/// Names file, field, what was expected and what was found.
pub fn load_scene(path: &Path) -> Result<Scene> {
    let stem = path
        .file_stem()
        .map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    let shipped = SCENES.iter().find(|[name, _]| Path::new(name) == path);
    let text = shipped.map_or_else(|| read_text(path), |[_, text]| Ok((*text).to_owned()))?;
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
