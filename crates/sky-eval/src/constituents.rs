//! The constituents of the air by their names, and what can be left out of a sky.

use anyhow::{Context as _, Result};
use sky_sim::optics::{Constituents, OpticsSettings};
use sky_sim::profile::AtmosphereProfile;

use crate::truth::TransportSky;

/// A constituent that can be left out: its name on the command line, and its switch.
#[derive(Clone, Copy, Debug)]
pub struct Switch {
    /// The name.
    pub name: &'static str,
    /// The switch.
    pub of: fn(&mut Constituents) -> &mut bool,
}

/// Every constituent, those first that are most likely not seen.
pub const SWITCHES: [Switch; 8] = [
    Switch {
        name: "no2",
        of: |c| &mut c.no2,
    },
    Switch {
        name: "o2o2",
        of: |c| &mut c.o2o2,
    },
    Switch {
        name: "o2",
        of: |c| &mut c.o2_band,
    },
    Switch {
        name: "h2o",
        of: |c| &mut c.h2o_band,
    },
    Switch {
        name: "stratosphere",
        of: |c| &mut c.stratospheric_aerosol,
    },
    Switch {
        name: "ozone",
        of: |c| &mut c.ozone,
    },
    Switch {
        name: "aerosol",
        of: |c| &mut c.aerosol,
    },
    Switch {
        name: "rayleigh",
        of: |c| &mut c.rayleigh,
    },
];

/// Names of the constituents that are on.
#[must_use]
pub fn names(mut constituents: Constituents) -> Vec<String> {
    let on = SWITCHES.iter().filter(|s| *(s.of)(&mut constituents));
    on.map(|s| s.name.to_owned()).collect()
}

/// The constituents of some names.
///
/// # Errors
/// Names those that there are, and the one that is none.
pub fn named(names: &[String]) -> Result<Constituents> {
    let mut all = Constituents::ALL;
    for switch in &SWITCHES {
        *(switch.of)(&mut all) = false;
    }
    for name in names {
        let switch = SWITCHES.iter().find(|s| s.name == name);
        let switch = switch.with_context(|| {
            let known: Vec<&str> = SWITCHES.iter().map(|s| s.name).collect();
            format!(
                "constituents: expected some of {}, found {name}",
                known.join(" ")
            )
        })?;
        *(switch.of)(&mut all) = true;
    }
    Ok(all)
}

/// The transport engine over an atmosphere of some constituents.
///
/// # Errors
/// When the settings do not suit the profile.
pub fn truth(
    profile: &AtmosphereProfile,
    constituents: Constituents,
    step_nm: u16,
    ground_albedo: f64,
) -> Result<TransportSky> {
    let settings = OpticsSettings {
        constituents,
        ..OpticsSettings::with_step_nm(step_nm)?
    };
    TransportSky::new(profile.clone(), settings, ground_albedo)
}

/// Distance of the wavelengths of the whole truth \[nm\].
pub const WHOLE_STEP_NM: u16 = 10;

/// The truth with every constituent: what is judged by, where constituents are chosen.
///
/// # Errors
/// When the settings do not suit the profile.
pub fn whole_truth(profile: &AtmosphereProfile, ground_albedo: f64) -> Result<TransportSky> {
    truth(profile, Constituents::ALL, WHOLE_STEP_NM, ground_albedo)
}

/// What can be left out of a sky.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Ozone.
    Ozone,
    /// Nitrogen dioxide.
    No2,
    /// Pairs of oxygen molecules.
    OxygenPairs,
    /// Oxygen bands.
    Oxygen,
    /// Water vapor bands.
    Water,
    /// The faint stratospheric layer.
    Stratosphere,
    /// The light that the ground reflects.
    Ground,
}

impl Part {
    /// Every part, its name and what it is.
    pub const ALL: [(Self, &'static str, &'static str); 7] = [
        (Self::Ozone, "ozone", "Ozone"),
        (Self::No2, "no2", "Nitrogen dioxide"),
        (Self::OxygenPairs, "o2o2", "Pairs of oxygen molecules"),
        (Self::Oxygen, "o2", "Oxygen bands"),
        (Self::Water, "h2o", "Water vapor bands"),
        (
            Self::Stratosphere,
            "stratosphere",
            "The faint stratospheric layer",
        ),
        (Self::Ground, "ground", "The light that the ground reflects"),
    ];

    /// The name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        Self::ALL[self as usize].1
    }
}

/// The truth without a part.
///
/// # Errors
/// When the settings do not suit the profile.
pub fn without(
    profile: &AtmosphereProfile,
    ground_albedo: f64,
    part: Part,
) -> Result<TransportSky> {
    let mut constituents = Constituents::ALL;
    let mut albedo = ground_albedo;
    match SWITCHES.iter().find(|s| s.name == part.name()) {
        Some(switch) => *(switch.of)(&mut constituents) = false,
        None => albedo = 0.0,
    }
    truth(profile, constituents, WHOLE_STEP_NM, albedo)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_in_the_order_of_their_list() {
        for (i, (part, ..)) in Part::ALL.iter().enumerate() {
            assert_eq!(*part as usize, i);
        }
    }
}
