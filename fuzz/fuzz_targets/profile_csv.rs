//! Any text is an atmosphere's profile or refused; one that is read answers at every altitude.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sky_core::quantity::Length;
use sky_sim::profile::AtmosphereProfile;

fuzz_target!(|text: &str| {
    if let Ok(profile) = AtmosphereProfile::from_csv_str("fuzz.csv", text) {
        for km in [0.0, 0.5, 11.0, 30.0, 99.0] {
            let row = profile.row(Length::from_km(km));
            let _ = format!("{row:?}");
        }
    }
});
