//! Times a function: what the benches need, without a package that takes longer to build than to run.

use std::hint::black_box;
use std::time::{Duration, Instant};

/// Prints the least and the median time of a call, of at least five samples and two seconds; quick calls
/// are sampled by the thousandth of a second.
#[expect(clippy::print_stdout, reason = "a bench prints what it measures")]
pub(crate) fn time<T>(what: &str, mut call: impl FnMut() -> T) {
    let mut calls = 1_u32;
    let mut sample = |calls: u32| {
        let start = Instant::now();
        for _ in 0..calls {
            black_box(call());
        }
        start.elapsed()
    };
    while calls < 1 << 20 && sample(calls) < Duration::from_millis(1) {
        calls *= 2;
    }
    let start = Instant::now();
    let mut samples = Vec::new();
    while samples.len() < 5 || start.elapsed() < Duration::from_secs(2) {
        samples.push(sample(calls).as_secs_f64() * 1e9 / f64::from(calls));
    }
    samples.sort_by(f64::total_cmp);
    let (least, median) = (samples[0], samples[samples.len() / 2]);
    println!("{what}: median {median:.0} ns, least {least:.0} ns");
}
