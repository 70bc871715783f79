//! Progress on the terminal.

use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};
use sky_eval::progress::Progress;

/// Bars on standard error; silent where that is no terminal. What is not ended is cleared with it.
#[derive(Debug, Default)]
pub struct Bars(Mutex<Vec<ProgressBar>>);

impl Bars {
    /// None yet.
    #[must_use]
    pub const fn new() -> Self {
        Self(Mutex::new(Vec::new()))
    }

    fn bars(&self) -> MutexGuard<'_, Vec<ProgressBar>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Bars {
    fn drop(&mut self) {
        for bar in self.bars().drain(..) {
            bar.finish_and_clear();
        }
    }
}

impl Progress for Bars {
    fn begin(&self, what: &'static str, steps: Option<usize>) {
        let bar = steps.map_or_else(|| spinner(what), |steps| progress(what, steps));
        self.bars().push(bar);
    }

    fn step(&self) {
        if let Some(bar) = self.bars().last() {
            bar.inc(1);
        }
    }

    fn end(&self) {
        if let Some(bar) = self.bars().pop() {
            bar.finish_and_clear();
        }
    }
}

/// A progress bar with the time that is left; silent where there is no terminal.
fn progress(what: &'static str, count: usize) -> ProgressBar {
    let bar = ProgressBar::new(count as u64);
    let style = ProgressStyle::with_template("{msg:>12} [{bar:40}] {pos}/{len}  {eta} left")
        .expect("a constant template");
    bar.set_style(style.progress_chars("=> "));
    bar.set_message(what);
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}

/// A sign of life for work of unknown length.
fn spinner(what: &'static str) -> ProgressBar {
    let bar = ProgressBar::new_spinner();
    let style =
        ProgressStyle::with_template("{spinner} {msg}  {elapsed}").expect("a constant template");
    bar.set_style(style);
    bar.set_message(what);
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}
