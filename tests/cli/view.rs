//! The window: what it draws, how it ends, and what happens to it on the way. Needs a Vulkan driver and,
//! but for the errors, Xvfb: without it the tests are skipped, unless CI is set.

#![cfg(target_os = "linux")]
#![expect(
    clippy::print_stdout,
    reason = "the measured figures are part of the test's answer"
)]

use std::io::{BufRead as _, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use sky_core::quantity::Angle;
use sky_core::tonemap::Tone;
use sky_core::utm_sky::UtmSky;
use sky_eval::cases::conditions;
use sky_gpu::{Camera, Tier};
use sky_render::Scenery;
use sky_render::{Pixels, Shot, draw_on_cpu, looking};
use tempfile::tempdir;
use x11rb::connection::Connection as _;
use x11rb::protocol::xproto::{
    ClientMessageEvent, ConfigureWindowAux, ConnectionExt as _, EventMask,
};

use crate::support::{names, refuse, succeed, utm_sky};

/// An X server without a screen, until it is dropped.
struct Display {
    server: Child,
    name: String,
}

impl Display {
    /// `None` where there is no Xvfb and CI is not set.
    fn open() -> Option<Self> {
        let started = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "800x600x24"])
            .args(["-nolisten", "tcp"])
            // else it starts anew when a program ends, and refuses the next meanwhile
            .arg("-noreset")
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn();
        let mut server = match started {
            Ok(server) => server,
            Err(error) => {
                assert!(
                    std::env::var_os("CI").is_none(),
                    "Xvfb: expected with CI set, found none ({error})"
                );
                println!("skipped: no Xvfb ({error})");
                return None;
            }
        };
        let mut number = String::new();
        let out = server.stdout.take().expect("a pipe");
        BufReader::new(out)
            .read_line(&mut number)
            .expect("the display's number");
        let name = format!(":{}", number.trim());
        Some(Self { server, name })
    }

    /// A program in its window.
    fn command(&self, mut program: Command, directory: &Path, line: &str) -> Command {
        program
            .current_dir(directory)
            .env("DISPLAY", &self.name)
            .env_remove("WAYLAND_DISPLAY")
            .env_remove("WAYLAND_SOCKET")
            .env("XDG_RUNTIME_DIR", directory)
            .args(line.split_whitespace());
        program
    }

    /// Runs a program in its window; it must succeed without a word.
    fn succeed(&self, program: Command, directory: &Path, line: &str) {
        let start = Instant::now();
        let output = self
            .command(program, directory, line)
            .output()
            .expect("the program starts");
        let words = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{line}: {words}");
        assert_eq!(words, "", "{line}");
        println!("{line}: {:.1} s", start.elapsed().as_secs_f64());
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        drop(self.server.kill());
        drop(self.server.wait());
    }
}

/// Red, green and blue of a PNG, and its size.
fn pixels(path: &Path) -> (Vec<u8>, [u32; 2]) {
    let picture = image::open(path).expect("a picture").to_rgb8();
    let size = [picture.width(), picture.height()];
    (picture.into_raw(), size)
}

/// What the evaluator draws for the window's first frame.
fn expected(scenery: Scenery, altitude_km: f64, size: [u32; 2]) -> Vec<u8> {
    let [width, height] = size.map(|side| f32::from(u16::try_from(side).expect("a small side")));
    let shot = Shot {
        conditions: conditions(altitude_km, 2.5, 60.0),
        sun_azimuth: Angle::from_degrees(180.0),
        camera: Camera {
            depth_is_distance: true,
            ..Camera::perspective(
                core::f32::consts::FRAC_PI_3,
                width / height,
                looking(180.0, 5.0),
            )
        },
        size,
        ev100: None,
        tone: Some(Tone::Neutral),
        tier: Tier::Fragment,
        scenery,
        sun_disc: true,
        aerial: true,
    };
    match draw_on_cpu(&UtmSky::embedded().expect("the table"), &shot).expect("a picture") {
        Pixels::Srgb8(bytes) => bytes,
        Pixels::Linear(_) => panic!("a tone curve was asked for"),
    }
}

/// Mean and 99th percentile of the differences of two pictures, in 1/255.
fn difference(a: &[u8], b: &[u8]) -> (f64, u8) {
    assert_eq!(a.len(), b.len());
    let mut steps: Vec<u8> = a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).collect();
    steps.sort_unstable();
    let sum: f64 = steps.iter().map(|s| f64::from(*s)).sum();
    let count = f64::from(u32::try_from(steps.len()).expect("a small picture"));
    (sum / count, steps[steps.len() * 99 / 100])
}

#[test]
fn the_window_shows_the_evaluator_s_sky() {
    let Some(display) = Display::open() else {
        return;
    };
    let dir = tempdir().unwrap();
    for tier in ["fragment", "baked"] {
        let line = format!("view --frames 30 --size 320x180 --tier {tier} --screenshot sky.png");
        display.succeed(utm_sky(), dir.path(), &line);
        let (found, size) = pixels(&dir.path().join("sky.png"));
        assert_eq!(size, [320, 180]);
        let (mean, most) = difference(&found, &expected(Scenery::None, 1.0, size));
        println!("{tier}: mean {mean:.2}, p99 {most}");
        assert!(mean <= 1.0 && most <= 3, "{tier}: {mean} {most}");
    }
    assert_eq!(names(dir.path()), ["sky.png"]);
}

/// The mesh against the rays that march through the same heights: both under the same air. A mesh is
/// smoother, so single pixels may differ.
#[test]
fn the_window_s_terrain_is_that_of_render() {
    let Some(display) = Display::open() else {
        return;
    };
    let dir = tempdir().unwrap();
    let line = "view --scene terrain --altitude-km 3.5 --frames 10 --size 320x180";
    let with = format!("{line} --screenshot air.png");
    display.succeed(utm_sky(), dir.path(), &with);
    let (found, size) = pixels(&dir.path().join("air.png"));
    let (mean, most) = difference(&found, &expected(Scenery::Terrain, 3.5, size));
    println!("terrain: mean {mean:.2}, p99 {most}");
    assert!(mean <= 1.5 && most <= 16, "{mean} {most}");

    let without = format!("{line} --no-aerial --screenshot bare.png");
    display.succeed(utm_sky(), dir.path(), &without);
    let (bare, _) = pixels(&dir.path().join("bare.png"));
    let (mean, _) = difference(&found, &bare);
    assert!(mean > 10.0, "the air is seen: {mean}");
}

#[test]
fn a_lost_device_is_replaced() {
    let Some(display) = Display::open() else {
        return;
    };
    let dir = tempdir().unwrap();
    let line = "view --scene terrain --altitude-km 3.5 --frames 8 --size 160x90";
    display.succeed(
        utm_sky(),
        dir.path(),
        &format!("{line} --screenshot kept.png"),
    );
    let lost = format!("{line} --lose-device-after 3 --screenshot lost.png");
    display.succeed(utm_sky(), dir.path(), &lost);
    let (kept, _) = pixels(&dir.path().join("kept.png"));
    let (lost, _) = pixels(&dir.path().join("lost.png"));
    assert_eq!(difference(&kept, &lost), (0.0, 0));
}

/// The display's only window, once it is there.
fn window(connection: &impl x11rb::connection::Connection, root: u32) -> u32 {
    for _ in 0..200 {
        let tree = connection.query_tree(root).expect("a request");
        for child in tree.reply().expect("a tree").children {
            let request = connection.get_geometry(child).expect("a request");
            if request.reply().is_ok_and(|g| g.width >= 100) {
                return child;
            }
        }
        sleep(Duration::from_millis(50));
    }
    panic!("no window after ten seconds");
}

/// Resized, hidden and closed, as a window manager would; the last frame is the picture.
#[test]
fn a_window_may_be_resized_hidden_and_closed() {
    let Some(display) = Display::open() else {
        return;
    };
    let dir = tempdir().unwrap();
    let line = "view --scene terrain --size 200x120 --screenshot last.png";
    let mut program = display.command(utm_sky(), dir.path(), line);
    let mut program = program.spawn().expect("the program starts");
    let (connection, screen) = x11rb::connect(Some(&display.name)).expect("the display");
    let root = connection.setup().roots[screen].root;
    let window = window(&connection, root);
    let pause = || {
        connection.flush().expect("the display");
        sleep(Duration::from_millis(200));
    };
    for size in [[1, 1], [333, 77], [64, 300], [180, 110]] {
        let [width, height] = size;
        let change = ConfigureWindowAux::new().width(width).height(height);
        let request = connection.configure_window(window, &change);
        request.expect("a request");
        pause();
    }
    connection.unmap_window(window).expect("a request");
    pause();
    connection.map_window(window).expect("a request");
    pause();
    let atom = |name: &str| {
        let request = connection.intern_atom(false, name.as_bytes());
        let reply = request.expect("a request").reply();
        reply.expect("an atom").atom
    };
    let close = ClientMessageEvent::new(
        32,
        window,
        atom("WM_PROTOCOLS"),
        [atom("WM_DELETE_WINDOW"), 0, 0, 0, 0],
    );
    let request = connection.send_event(false, window, EventMask::NO_EVENT, close);
    request.expect("a request");
    connection.flush().expect("the display");
    for _ in 0..300 {
        if let Some(status) = program.try_wait().expect("a program") {
            assert!(status.success());
            let (_, size) = pixels(&dir.path().join("last.png"));
            assert_eq!(size, [180, 110]);
            return;
        }
        sleep(Duration::from_millis(100));
    }
    drop(program.kill());
    panic!("the window is still open after 30 s");
}

/// Midnight is beyond the table: the window opens all the same, and says so in its panel.
#[test]
fn beyond_the_table_there_is_a_window_too() {
    let Some(display) = Display::open() else {
        return;
    };
    let dir = tempdir().unwrap();
    for line in [
        "view --date 2025-12-21 --utc-h 23 --place 47.26,11.34 --frames 3 --size 96x64",
        "view --turbidity 30 --altitude-km 30 --sun-zenith-deg 96 --frames 3 --size 96x64",
    ] {
        display.succeed(utm_sky(), dir.path(), line);
    }
}

#[test]
fn the_examples_open_their_windows() {
    let Some(display) = Display::open() else {
        return;
    };
    let dir = tempdir().unwrap();
    for example in [
        env!("CARGO_BIN_EXE_minimal-under-test"),
        env!("CARGO_BIN_EXE_terrain-under-test"),
    ] {
        display.succeed(Command::new(example), dir.path(), "--frames 3");
    }
}

#[test]
fn what_is_wrong_is_told_in_one_line() {
    let dir = tempdir().unwrap();
    let help = succeed(dir.path(), "view --help").stdout;
    assert!(!help.contains("lose-device"), "{help}");
    let without_display = utm_sky()
        .current_dir(dir.path())
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET")
        .args(["view", "--frames", "1", "--screenshot", "sky.png"])
        .output()
        .expect("the program starts");
    let words = String::from_utf8_lossy(&without_display.stderr);
    assert_eq!(without_display.status.code(), Some(2), "{words}");
    for word in ["error: display: expected", "xvfb", "utm-sky render"] {
        assert!(words.contains(word), "no {word:?} in: {words}");
    }
    assert_eq!(words.lines().count(), 1, "{words}");
    for (line, words) in [
        (
            "view --screenshot sky.jpg",
            &["--screenshot", ".png", "sky.jpg"][..],
        ),
        ("view --screenshot nowhere/sky.png", &["nowhere"]),
        ("view --lut none.utmlut", &["none.utmlut"]),
        ("view --visual-range-km 1000", &["haze", "visual range"]),
        (
            "view --date 2025-02-30 --place 47,11",
            &["--date", "2025-02-30"],
        ),
        ("view --date 2025-02-20", &["--place"]),
        (
            "view --date 2025-02-20 --place 91,11",
            &["--place", "-90 to 90"],
        ),
    ] {
        refuse(dir.path(), line, words);
    }
    let Some(display) = Display::open() else {
        return;
    };
    let unknown = display
        .command(
            utm_sky(),
            dir.path(),
            "view --frames 1 --adapter no-such-gpu",
        )
        .output()
        .expect("the program starts");
    let words = String::from_utf8_lossy(&unknown.stderr);
    assert_eq!(unknown.status.code(), Some(2), "{words}");
    assert!(
        words.starts_with("error: GPU: expected one of \"") && words.contains("\"no-such-gpu\""),
        "{words}"
    );
    assert_eq!(names(dir.path()), Vec::<String>::new());
}
