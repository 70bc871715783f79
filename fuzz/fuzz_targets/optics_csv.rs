//! Any text is an optical profile or refused; what is read is written back the same.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sky_sim::optics::OpticalProfile;

fuzz_target!(|text: &str| {
    if let Ok(optics) = OpticalProfile::from_csv_str("fuzz.csv", text) {
        let written = optics.to_csv_string();
        OpticalProfile::from_csv_str("fuzz.csv", &written).expect("what was written is read");
    }
});
