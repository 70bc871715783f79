//! The atmospheres of the UTM sky model as CSV text; `sky-sim` reads them.
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
