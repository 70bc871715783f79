//! The kinds of failure, how many samples were asked for each, and where the worst is.

use sky_core::conditions::Conditions;
use sky_core::direction::SkyDirection;

/// In what numbers a model answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arithmetic {
    /// Double precision on the CPU.
    CpuF64,
    /// Single precision on the CPU.
    CpuF32,
    /// Single precision on the GPU.
    GpuF32,
    /// Single precision on the CPU, coefficients rounded to half precision.
    F16Table,
}

impl Arithmetic {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::CpuF64, Self::CpuF32, Self::GpuF32, Self::F16Table];

    /// The name in files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::CpuF64 => "cpu_f64",
            Self::CpuF32 => "cpu_f32",
            Self::GpuF32 => "gpu_f32",
            Self::F16Table => "f16_table",
        }
    }
}

/// A kind of failure, in the order in which a map's cell names them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// NaN or an infinity.
    NotFinite,
    /// A luminance below 0.
    NegativeLuminance,
    /// A chromaticity that no light has.
    OutsideLocus,
    /// An answer outside the domain.
    SilentOutside,
    /// No answer inside the domain.
    RefusedInside,
    /// Luminance has a step or a bend over directions: what its slope does not explain.
    JumpDirection,
    /// Luminance has a step or a bend over altitudes.
    JumpAltitude,
    /// Luminance changes with the direction faster than a sky does.
    SteepDirection,
    /// Luminance changes with the altitude faster than a sky does.
    SteepAltitude,
    /// Left and right of the sun differ.
    Asymmetry,
    /// Between two altitude nodes the sky leaves the range of the nodes' skies.
    Overshoot,
    /// The zenith grows brighter with altitude.
    RisingZenith,
    /// The same formula in other numbers differs.
    Precision,
    /// A path's transmittance or light is NaN or infinite.
    PathNotFinite,
    /// A path adds light below 0.
    PathNegative,
    /// A path's transmittance is no share, or grows with distance, or is not 1 without distance.
    PathTransmittance,
    /// A path's light has a step or a bend over directions.
    PathJump,
    /// A path's light differs left and right of the sun.
    PathAsymmetry,
}

/// What is said of a kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KindEntry {
    /// The kind.
    pub kind: Kind,
    /// The name in files.
    pub name: &'static str,
    /// A score above this is a failure.
    pub limit: f64,
    /// What the score is.
    pub score: &'static str,
    /// Color on the maps.
    pub color: [u8; 3],
}

const fn entry(
    kind: Kind,
    name: &'static str,
    limit: f64,
    score: &'static str,
    color: [u8; 3],
) -> KindEntry {
    KindEntry {
        kind,
        name,
        limit,
        score,
        color,
    }
}

/// Every kind.
pub const KINDS: [KindEntry; 18] = [
    entry(
        Kind::NotFinite,
        "not_finite",
        0.0,
        "1 for NaN or an infinity",
        [20, 20, 20],
    ),
    entry(
        Kind::NegativeLuminance,
        "negative_luminance",
        0.0,
        "minus the luminance [cd·m⁻²]",
        [179, 20, 60],
    ),
    entry(
        Kind::OutsideLocus,
        "outside_locus",
        1e-6,
        "distance from the spectral locus in x, y",
        [150, 60, 190],
    ),
    entry(
        Kind::SilentOutside,
        "silent_outside",
        0.0,
        "1 for an answer",
        [235, 130, 20],
    ),
    entry(
        Kind::RefusedInside,
        "refused_inside",
        0.0,
        "1 for no answer",
        [120, 85, 60],
    ),
    entry(
        Kind::JumpDirection,
        "jump_direction",
        0.01,
        "bend of ln Y over 0.01°",
        [215, 75, 60],
    ),
    // a table that is linear between nodes bends at them: at the rim toward a sun that is down, by 1.1 %
    entry(
        Kind::JumpAltitude,
        "jump_altitude",
        0.0125,
        "bend of ln Y over 10 m",
        [230, 160, 60],
    ),
    // with the sun below the rim a true sky falls by up to 8.4 % per 0.01°: T 4, sun 96°, 0.4° above
    // the horizon of 30 km
    entry(
        Kind::SteepDirection,
        "steep_direction",
        0.085,
        "share of luminance per 0.01°",
        [205, 190, 60],
    ),
    // a true sky changes by 1.9 % per 10 m toward a low sun in haze: T 4, sun 86°, at the ground
    entry(
        Kind::SteepAltitude,
        "steep_altitude",
        0.05,
        "share of luminance per 10 m",
        [160, 170, 50],
    ),
    entry(
        Kind::Asymmetry,
        "asymmetry",
        1e-5,
        "share of luminance, left to right",
        [200, 80, 150],
    ),
    entry(
        Kind::Overshoot,
        "overshoot",
        0.05,
        "share of luminance beyond the nodes' range",
        [30, 120, 200],
    ),
    entry(
        Kind::RisingZenith,
        "rising_zenith",
        1e-3,
        "share of luminance per 100 m",
        [20, 155, 150],
    ),
    entry(
        Kind::Precision,
        "precision",
        1e-3,
        "share of luminance, or x or y",
        [110, 130, 150],
    ),
    entry(
        Kind::PathNotFinite,
        "path_not_finite",
        0.0,
        "1 for NaN or an infinity",
        [60, 60, 60],
    ),
    entry(
        Kind::PathNegative,
        "path_negative",
        0.0,
        "minus the least of red, green, blue [cd·m⁻²]",
        [140, 30, 50],
    ),
    // four sections carry a path to about 1 %
    entry(
        Kind::PathTransmittance,
        "path_transmittance",
        0.02,
        "transmittance gained with distance, or not a share",
        [90, 60, 30],
    ),
    // at the horizon from 30 km, 0.01° is 110 m of haze
    entry(
        Kind::PathJump,
        "path_jump",
        0.05,
        "bend over 0.01° as a share of the longest path's luminance",
        [190, 100, 90],
    ),
    entry(
        Kind::PathAsymmetry,
        "path_asymmetry",
        1e-5,
        "share of the longest path's luminance",
        [170, 100, 150],
    ),
];

/// Where a sample was taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Observer, haze and sun.
    pub conditions: Conditions,
    /// Direction of view.
    pub direction: SkyDirection,
    /// What it was compared with, or how far the path goes.
    pub with: With,
}

/// The other half of a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum With {
    /// Nothing.
    Nothing,
    /// Another direction under the same conditions.
    Direction(SkyDirection),
    /// The same direction from another altitude \[km\].
    Altitude(f64),
    /// The same direction from the two altitudes around it \[km\].
    Nodes([f64; 2]),
    /// A path of this length \[km\].
    Path(f64),
}

/// What was found of one kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tally {
    /// Samples taken.
    pub samples: u64,
    /// Samples with a score above the limit.
    pub failures: u64,
    /// Largest score; negative infinity without samples.
    pub worst: f64,
    /// Where it is.
    pub place: Option<Place>,
}

impl Tally {
    const EMPTY: Self = Self {
        samples: 0,
        failures: 0,
        worst: f64::NEG_INFINITY,
        place: None,
    };

    fn add(&mut self, other: &Self) {
        self.samples += other.samples;
        self.failures += other.failures;
        if other.worst > self.worst {
            (self.worst, self.place) = (other.worst, other.place);
        }
    }
}

/// Tallies by arithmetic, kind and side of the domain.
#[derive(Clone, Debug)]
pub struct Tallies(Vec<Tally>);

impl Default for Tallies {
    fn default() -> Self {
        Self(vec![Tally::EMPTY; Arithmetic::ALL.len() * KINDS.len() * 2])
    }
}

impl Tallies {
    const fn index(arithmetic: Arithmetic, kind: Kind, inside: bool) -> usize {
        ((arithmetic as usize) * KINDS.len() + kind as usize) * 2 + inside as usize
    }

    /// What was found of a kind.
    #[must_use]
    pub fn get(&self, arithmetic: Arithmetic, kind: Kind, inside: bool) -> &Tally {
        &self.0[Self::index(arithmetic, kind, inside)]
    }

    /// Counts a sample; whether it failed. A score that is NaN fails.
    pub(super) fn record(
        &mut self,
        arithmetic: Arithmetic,
        kind: Kind,
        inside: bool,
        score: f64,
        place: impl FnOnce() -> Place,
    ) -> bool {
        let tally = &mut self.0[Self::index(arithmetic, kind, inside)];
        tally.samples += 1;
        let score = if score.is_nan() { f64::INFINITY } else { score };
        if score > tally.worst {
            (tally.worst, tally.place) = (score, Some(place()));
        }
        let failed = score > KINDS[kind as usize].limit;
        tally.failures += u64::from(failed);
        failed
    }

    /// Adds what was found elsewhere; of equals the first stays the worst.
    pub(super) fn add(&mut self, other: &Self) {
        for (to, from) in self.0.iter_mut().zip(&other.0) {
            to.add(from);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases::conditions;

    #[test]
    fn the_list_is_in_the_order_of_the_kinds() {
        for (i, entry) in KINDS.iter().enumerate() {
            assert_eq!(entry.kind as usize, i, "{}", entry.name);
        }
    }

    #[test]
    fn the_worst_is_kept_and_a_score_that_is_no_number_fails() {
        let place = Place {
            conditions: conditions(0.0, 1.0, 0.0),
            direction: SkyDirection::from_degrees(0.0, 0.0),
            with: With::Nothing,
        };
        let mut tallies = Tallies::default();
        for score in [0.001, 0.02, 0.005] {
            tallies.record(Arithmetic::CpuF32, Kind::JumpDirection, true, score, || {
                place
            });
        }
        let mut other = Tallies::default();
        assert!(other.record(
            Arithmetic::CpuF32,
            Kind::JumpDirection,
            true,
            f64::NAN,
            || place
        ));
        let found = tallies.get(Arithmetic::CpuF32, Kind::JumpDirection, true);
        assert_eq!((found.samples, found.failures), (3, 1));
        assert!((found.worst - 0.02).abs() < 1e-15);
        tallies.add(&other);
        let found = tallies.get(Arithmetic::CpuF32, Kind::JumpDirection, true);
        assert_eq!((found.samples, found.failures), (4, 2));
        assert!(found.worst.is_infinite());
    }
}
