//! Sets of directions that skies are compared in.

use sky_core::direction::SkyDirection;

/// The report's 271 directions: the zenith, then nine rings every 10° to the horizontal, each with
/// an endpoint every 12° of azimuth.
#[must_use]
pub fn report_directions() -> Vec<SkyDirection> {
    let mut out = vec![SkyDirection::from_degrees(0.0, 0.0)];
    for ring in 1..=9_u8 {
        for spoke in 0..30_u16 {
            out.push(SkyDirection::from_degrees(
                f64::from(ring) * 10.0,
                f64::from(spoke) * 12.0,
            ));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_report_has_271_directions() {
        assert_eq!(report_directions().len(), 271);
    }
}
