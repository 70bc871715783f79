//! The transport engine of the table that ships. One a process, which keeps what it has solved.

use std::sync::LazyLock;

use sky_eval::bake::MAP_STEP_NM;
use sky_eval::truth::{DEFAULT_GROUND_ALBEDO, TransportSky};
use sky_sim::optics::OpticsSettings;
use sky_sim::profile::AtmosphereProfile;

pub(crate) static TRUTH: LazyLock<TransportSky> = LazyLock::new(|| {
    let settings = OpticsSettings::with_step_nm(MAP_STEP_NM).expect("a step");
    TransportSky::new(
        AtmosphereProfile::general(),
        settings,
        DEFAULT_GROUND_ALBEDO,
    )
    .expect("the truth")
});
