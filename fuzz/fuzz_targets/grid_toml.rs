//! Any text is a grid or refused.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sky_eval::grid::parse_grid;

fuzz_target!(|text: &str| {
    if let Ok(grid) = parse_grid("fuzz.toml", text) {
        for (axis, [low, high]) in [
            (&grid.altitude_km, [0.0, 30.0]),
            (&grid.turbidity, [1.0, 12.0]),
            (&grid.sun_zenith_deg, [0.0, 96.0]),
        ] {
            let [first, last] = axis.bounds();
            assert!(first >= low && last <= high, "{axis:?}");
            assert!(axis.nodes().windows(2).all(|pair| pair[0] < pair[1]), "{axis:?}");
        }
    }
});
