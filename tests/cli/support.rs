//! Runs the program and reads what it wrote.

use std::path::Path;
use std::process::{Command, Output};

/// The program.
pub(crate) fn utm_sky() -> Command {
    Command::new(env!("CARGO_BIN_EXE_utm-sky-under-test"))
}

/// What a run gave.
#[derive(Debug)]
pub(crate) struct Outcome {
    pub(crate) code: Option<i32>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl From<Output> for Outcome {
    fn from(output: Output) -> Self {
        Self {
            code: output.status.code(),
            stdout: String::from_utf8_lossy(&output.stdout).into_owned(),
            stderr: String::from_utf8_lossy(&output.stderr).into_owned(),
        }
    }
}

/// Runs the program in a directory; the words of `line` are its arguments.
pub(crate) fn run(directory: &Path, line: &str) -> Outcome {
    utm_sky()
        .current_dir(directory)
        // without one, a driver complains on stderr
        .env("XDG_RUNTIME_DIR", directory)
        .args(line.split_whitespace())
        .output()
        .expect("the program starts")
        .into()
}

/// Runs the program, which must succeed without a word on stderr but that it is still at work.
pub(crate) fn succeed(directory: &Path, line: &str) -> Outcome {
    let mut outcome = run(directory, line);
    assert_eq!(outcome.code, Some(0), "{line}: {}", outcome.stderr);
    let words = outcome.stderr.split_inclusive('\n');
    outcome.stderr = words.filter(|l| !l.starts_with("progress: ")).collect();
    assert_eq!(outcome.stderr, "", "{line}");
    outcome
}

/// Runs the program, which must exit with 2, print nothing on stdout, and say on stderr all of the
/// given words.
pub(crate) fn refuse(directory: &Path, line: &str, words: &[&str]) {
    let mut outcome = run(directory, line);
    let words_on_stderr = outcome.stderr.split_inclusive('\n');
    outcome.stderr = words_on_stderr
        .filter(|l| !l.starts_with("progress: "))
        .collect();
    assert_eq!(outcome.code, Some(2), "{line}: {outcome:?}");
    assert_eq!(outcome.stdout, "", "{line}");
    assert!(outcome.stderr.starts_with("error: "), "{}", outcome.stderr);
    for word in words {
        assert!(
            outcome.stderr.contains(word),
            "{line}: no {word:?} in: {}",
            outcome.stderr
        );
    }
}

/// Names of the files in a directory, hidden ones too.
pub(crate) fn names(directory: &Path) -> Vec<String> {
    let mut names: Vec<String> = std::fs::read_dir(directory)
        .expect("the directory exists")
        .map(|entry| {
            let name = entry.expect("the directory can be read").file_name();
            name.to_string_lossy().into_owned()
        })
        .collect();
    names.sort();
    names
}
