//! Random conditions that are the same on every run, the ends of their ranges among them.

use sky_core::conditions::Conditions;
use sky_core::quantity::{Angle, Length};

/// A number from 0 to below 1 by seed and place, as even as a die: FNV-1a's hash of both, mixed.
pub(crate) fn random(seed: &str, place: [u32; 2]) -> f64 {
    let bytes = seed
        .bytes()
        .chain(place.into_iter().flat_map(u32::to_le_bytes));
    let mut hash = bytes.fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3)
    });
    for shift in [33, 29, 32] {
        hash = (hash ^ (hash >> shift)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    }
    let upper = u32::try_from(hash >> 32).expect("32 bits");
    f64::from(upper) / (f64::from(u32::MAX) + 1.0)
}

/// Between two bounds, by share.
pub(crate) fn between([low, high]: [f64; 2], share: f64) -> f64 {
    (low + share * (high - low)).clamp(low, high)
}

/// Ranges of altitude \[km\], turbidity and sun zenith angle \[deg\].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ranges {
    pub(crate) altitude_km: [f64; 2],
    pub(crate) turbidity: [f64; 2],
    pub(crate) sun_zenith_deg: [f64; 2],
}

impl Ranges {
    /// Conditions inside the ranges: the eight corners, then random ones, low altitudes and clear air
    /// more often. Of `turbidities` in turn, the ends among them: each costs the engine a solution.
    pub(crate) fn conditions(&self, seed: &str, turbidities: u32, count: u32) -> Vec<Conditions> {
        let [low, high] = self.turbidity;
        (0..count)
            .map(|i| {
                let corner = |bit: u32| f64::from((i >> bit) & 1);
                let haze = match i % turbidities {
                    _ if i < 8 => corner(0),
                    0 => 0.0,
                    1 => 1.0,
                    kind => random(seed, [kind, 0]),
                };
                let share = |dimension: u32| match i {
                    0..8 => corner(dimension),
                    _ => random(seed, [i, dimension]),
                };
                Conditions {
                    observer_altitude: Length::from_km(between(self.altitude_km, share(1).powi(2))),
                    turbidity: (low * (high / low).powf(haze)).clamp(low, high),
                    sun_zenith: Angle::from_degrees(between(self.sun_zenith_deg, share(2))),
                }
            })
            .collect()
    }
}
