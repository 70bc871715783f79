//! Any text is a grid or refused.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sky_eval::grid::parse_grid;

fuzz_target!(|text: &str| {
    if let Ok(grid) = parse_grid("fuzz.toml", text) {
        assert!(grid.nodes() >= 8);
    }
});
