//! Progress on standard error: bars on a terminal, now and then a line where there is none.

use std::io::{IsTerminal as _, Write, stderr};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};
use sky_eval::progress::Progress;

/// What every line begins with, so that who reads standard error can leave them out.
const LINE: &str = "progress: ";
/// Until the first line; each wait is twice the one before.
const FIRST_WAIT: Duration = Duration::from_secs(10);
const LONGEST_WAIT: Duration = Duration::from_secs(60);

type Tasks = Arc<Mutex<Vec<ProgressBar>>>;

fn locked(tasks: &Tasks) -> MutexGuard<'_, Vec<ProgressBar>> {
    tasks.lock().unwrap_or_else(PoisonError::into_inner)
}

/// What is at work, the innermost last. What is not ended is cleared with it.
#[derive(Debug)]
pub struct Bars {
    tasks: Tasks,
    /// Dropped, it ends the lines; none on a terminal, where there are bars.
    _lines: Option<Sender<()>>,
}

impl Default for Bars {
    fn default() -> Self {
        Self::new()
    }
}

impl Bars {
    /// None yet.
    #[must_use]
    pub fn new() -> Self {
        let tasks = Tasks::default();
        let lines = (!stderr().is_terminal())
            .then(|| write_lines(Arc::clone(&tasks), FIRST_WAIT, stderr()));
        Self {
            tasks,
            _lines: lines,
        }
    }
}

impl Drop for Bars {
    fn drop(&mut self) {
        for bar in locked(&self.tasks).drain(..) {
            bar.finish_and_clear();
        }
    }
}

impl Progress for Bars {
    fn begin(&self, what: &'static str, steps: Option<usize>) {
        let bar = steps.map_or_else(|| spinner(what), |steps| progress(what, steps));
        locked(&self.tasks).push(bar);
    }

    fn step(&self) {
        if let Some(bar) = locked(&self.tasks).last() {
            bar.inc(1);
        }
    }

    fn end(&self) {
        if let Some(bar) = locked(&self.tasks).pop() {
            bar.finish_and_clear();
        }
    }
}

/// Writes what is at work at growing intervals, until the sender is dropped.
fn write_lines(tasks: Tasks, first: Duration, mut to: impl Write + Send + 'static) -> Sender<()> {
    let (end, ended) = channel();
    thread::spawn(move || {
        let mut wait = first;
        while ended.recv_timeout(wait) == Err(RecvTimeoutError::Timeout) {
            let line = locked(&tasks).last().map(line);
            if let Some(line) = line {
                // a reader that is gone stops no work
                drop(to.write_all(line.as_bytes()));
            }
            wait = (2 * wait).min(LONGEST_WAIT);
        }
    });
    end
}

/// A task in words.
fn line(bar: &ProgressBar) -> String {
    let steps = bar
        .length()
        .map_or_else(String::new, |all| format!(" {} of {all}", bar.position()));
    let seconds = bar.elapsed().as_secs();
    format!("{LINE}{}{steps}, {seconds} s\n", bar.message())
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

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Clone, Default)]
    struct Page(Arc<Mutex<Vec<u8>>>);

    impl Write for Page {
        fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
            self.0.lock().unwrap().extend_from_slice(bytes);
            Ok(bytes.len())
        }

        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn c_a_run_without_a_terminal_says_what_it_does() {
        let (tasks, page) = (Tasks::default(), Page::default());
        let bars = Bars {
            tasks: Arc::clone(&tasks),
            _lines: Some(write_lines(tasks, Duration::from_millis(2), page.clone())),
        };
        let said = |words: &str| {
            (0..500).any(|_| {
                thread::sleep(Duration::from_millis(5));
                String::from_utf8_lossy(&page.0.lock().unwrap()).contains(words)
            })
        };
        bars.begin("planning", None);
        assert!(said("progress: planning, 0 s\n"));
        bars.begin("maps", Some(84));
        bars.step();
        assert!(said("progress: maps 1 of 84, 0 s\n"));
    }
}
