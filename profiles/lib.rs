//! The atmospheres of the UTM sky model as CSV text, which `sky-sim` reads, and the scenes that plans begin
//! with as TOML, which `sky-plan` does.
//!
//! Where their numbers come from stands in the README beside them.

/// An atmosphere that ships.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Profile {
    /// Its name.
    pub name: &'static str,
    /// Its file in the project.
    pub file: &'static str,
    /// The file's text.
    pub csv: &'static str,
}

macro_rules! profile {
    ($name:literal) => {
        Profile {
            name: $name,
            file: concat!("profiles/", $name, ".csv"),
            csv: include_str!(concat!($name, ".csv")),
        }
    };
}

/// What tables are made for unless told otherwise.
pub const GENERAL: Profile = profile!("general");
/// The atmosphere of the report of 2005.
pub const UTM2005: Profile = profile!("utm2005");
/// Tropical.
pub const TROPICAL: Profile = profile!("tropical");
/// Subarctic winter.
pub const SUBARCTIC_WINTER: Profile = profile!("subarctic_winter");

/// All of them.
pub const ALL: [Profile; 4] = [GENERAL, UTM2005, TROPICAL, SUBARCTIC_WINTER];

/// A scene that ships.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Scene {
    /// Its name.
    pub name: &'static str,
    /// The file's text.
    pub toml: &'static str,
}

macro_rules! scene {
    ($name:literal) => {
        Scene {
            name: $name,
            toml: include_str!(concat!("scenes/", $name, ".toml")),
        }
    };
}

/// All scenes.
pub const SCENES: [Scene; 7] = [
    scene!("airliner_day"),
    scene!("airliner_dusk"),
    scene!("circuit_training"),
    scene!("hazy_city"),
    scene!("high_altitude"),
    scene!("runway_noon"),
    scene!("web_demo"),
];
