//! A full disk and Ctrl-C: exit status 2, the old file untouched, no temporary file left.

#![cfg(unix)]

use std::fmt::Write as _;
use std::fs;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::support::{Outcome, names, refuse, succeed, utm_sky};
use tempfile::tempdir;

/// A file may grow to 64 blocks (32 or 64 KiB), then writing fails as on a full disk.
#[test]
fn a_full_disk_leaves_the_old_file() {
    let dir = tempdir().unwrap();
    fs::write(dir.path().join("optics.csv"), "old").unwrap();
    let outcome: Outcome = Command::new("sh")
        .current_dir(dir.path())
        .arg("-c")
        .arg("trap '' XFSZ; ulimit -f 64; exec \"$0\" \"$@\"")
        .arg(utm_sky().get_program())
        .args(["optics", "--turbidity", "2", "--out", "optics.csv"])
        .output()
        .unwrap()
        .into();
    assert_eq!(outcome.code, Some(2), "{outcome:?}");
    assert!(
        outcome
            .stderr
            .starts_with("error: optics.csv: cannot be written: "),
        "{}",
        outcome.stderr
    );
    assert_eq!(fs::read(dir.path().join("optics.csv")).unwrap(), b"old");
    assert_eq!(names(dir.path()), ["optics.csv"]);
    // With room again it is replaced.
    succeed(
        dir.path(),
        "optics --turbidity 2 --wavelength-step-nm 20 --out optics.csv",
    );
    assert!(fs::read(dir.path().join("optics.csv")).unwrap().len() > 100_000);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_device_is_told() {
    let dir = tempdir().unwrap();
    refuse(
        dir.path(),
        "optics --turbidity 2 --wavelength-step-nm 20 --out /dev/full",
        &["/dev/full", "cannot be written", "No space left"],
    );
}

/// Waits for a condition, at most a minute.
fn wait_for(what: &str, mut condition: impl FnMut() -> bool) {
    let start = Instant::now();
    while !condition() {
        assert!(start.elapsed() < Duration::from_secs(60), "no {what} came");
        sleep(Duration::from_millis(5));
    }
}

#[test]
fn an_interruption_leaves_nothing_half_written() {
    for signal in ["INT", "TERM"] {
        let dir = tempdir().unwrap();
        let mut directions = String::from("view_zenith_deg,relative_azimuth_deg\n");
        for i in 0..400_000_u32 {
            let _ = writeln!(directions, "{},{}", i % 91, i % 360);
        }
        fs::write(dir.path().join("dirs.csv"), directions).unwrap();
        let out = dir.path().join("out");
        fs::create_dir(&out).unwrap();
        fs::write(out.join("map.csv"), "old").unwrap();
        let child = utm_sky()
            .current_dir(dir.path())
            .args(
                "map --altitude-km 1 --turbidity 2 --sun-zenith-deg 60 --engine smarts".split(' '),
            )
            .args(["--directions", "dirs.csv", "--out", "out/map.csv"])
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        wait_for("temporary file", || names(&out).len() == 2);
        let sent = Command::new("sh")
            .arg("-c")
            .arg(format!("kill -{signal} {}", child.id()))
            .status()
            .unwrap();
        assert!(sent.success());
        let outcome: Outcome = child.wait_with_output().unwrap().into();
        assert_eq!(outcome.code, Some(2), "{signal}: {outcome:?}");
        assert!(outcome.stderr.contains("interrupted"), "{outcome:?}");
        assert_eq!(fs::read(out.join("map.csv")).unwrap(), b"old");
        assert_eq!(names(&out), ["map.csv"], "{signal}");
    }
}
