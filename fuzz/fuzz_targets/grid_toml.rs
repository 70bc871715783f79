//! Any text is a grid or refused.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sky_eval::grid::parse_grid;

fuzz_target!(|text: &str| {
    if let Ok(grid) = parse_grid("fuzz.toml", text) {
        // one node an axis is legal: nothing is interpolated there
        assert!(grid.nodes() >= 1);
        for axis in [&grid.altitude_km, &grid.turbidity, &grid.sun_zenith_deg] {
            let nodes = axis.nodes();
            assert!(nodes.iter().all(|n| n.is_finite()) && nodes.windows(2).all(|w| w[0] < w[1]));
        }
    }
});
