//! Numbers that look random and are the same for the same seed (`SplitMix64`: Steele, Lea & Flood 2014).

/// The step between two states.
const GOLDEN: u64 = 0x9E37_79B9_7F4A_7C15;

const fn mixed(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// Numbers one after the other.
#[derive(Clone, Debug)]
pub struct Dice(u64);

impl Dice {
    /// From a seed.
    #[must_use]
    pub const fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// The next number.
    pub const fn roll(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(GOLDEN);
        mixed(self.0)
    }

    /// Evenly from 0 to 1.
    pub const fn share(&mut self) -> f64 {
        (self.roll() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Evenly between two bounds.
    pub const fn between(&mut self, [low, high]: [f64; 2]) -> f64 {
        low + self.share() * (high - low)
    }
}

/// Numbers by place: the same place has the same number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Random(pub u64);

impl Random {
    /// The numbers of a place.
    #[must_use]
    pub const fn at(self, place: u64) -> Self {
        Self(mixed(
            self.0 ^ place.wrapping_mul(GOLDEN).wrapping_add(0x6A09_E667),
        ))
    }

    /// 0 to 1, 0 excluded.
    #[must_use]
    pub fn uniform(self) -> f64 {
        let high = u32::try_from(self.0 >> 32).unwrap_or(0);
        (f64::from(high) + 0.5) / 4_294_967_296.0
    }

    /// Mean 0, deviation 1 (Box & Muller 1958).
    #[must_use]
    pub fn normal(self) -> f64 {
        let radius = (-2.0 * self.at(1).uniform().ln()).sqrt();
        radius * (core::f64::consts::TAU * self.at(2).uniform()).cos()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_numbers_are_those_that_were_published() {
        // the generator's reference output for seed 1234567 (Vigna's splitmix64.c)
        let mut dice = Dice::new(1_234_567);
        assert_eq!(
            [dice.roll(), dice.roll()],
            [6_457_827_717_110_365_317, 3_203_168_211_198_807_973]
        );
    }

    #[test]
    fn random_numbers_are_spread_and_repeat() {
        let random = Random(7);
        let n = 10_000;
        let uniform = |k: u64| random.at(k).uniform();
        let mean = (0..n).map(uniform).sum::<f64>() / n as f64;
        assert!((mean - 0.5).abs() < 0.01, "{mean}");
        let variance = (0..n).map(|k| random.at(k).normal().powi(2)).sum::<f64>() / n as f64;
        assert!((variance - 1.0).abs() < 0.05, "{variance}");
        assert_eq!(random.at(3).at(4).0, Random(7).at(3).at(4).0);
        assert_ne!(random.at(3).at(4).0, random.at(4).at(3).0);
    }
}
