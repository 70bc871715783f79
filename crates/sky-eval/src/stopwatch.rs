//! The clock of measurements, named here alone: its seconds are what is measured, and decide nothing.

use std::time::Instant;

/// Runs since it was started.
#[derive(Clone, Copy, Debug)]
pub struct Stopwatch(Instant);

impl Stopwatch {
    /// From now on.
    #[must_use]
    pub fn start() -> Self {
        Self(Instant::now())
    }

    /// Seconds since the start.
    #[must_use]
    pub fn seconds(self) -> f64 {
        self.0.elapsed().as_secs_f64()
    }
}

/// The shortest of several runs \[s\].
pub fn shortest(runs: u32, mut work: impl FnMut()) -> f64 {
    (0..runs)
        .map(|_| {
            let watch = Stopwatch::start();
            work();
            watch.seconds()
        })
        .fold(f64::INFINITY, f64::min)
}
