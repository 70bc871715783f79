//! The walls of ARCHITECTURE.md: who may know whom, and who may touch the world.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use toml::{Table, Value};

/// Every crate of the product and the crates of ours that it may know. One that is not written yet is
/// held to its line as soon as it is there.
const MAY_KNOW: [(&str, &[&str]); 7] = [
    ("sky-core", &[]),
    ("sky-gpu", &["sky-core"]),
    ("sky-science", &["sky-core"]),
    ("sky-sim", &["sky-core", "sky-science"]),
    ("sky-fit", &["sky-core", "sky-science"]),
    ("sky-baselines", &["sky-core", "sky-science"]),
    (
        "sky-cli",
        &[
            "sky-core",
            "sky-science",
            "sky-sim",
            "sky-fit",
            "sky-baselines",
            "sky-gpu",
        ],
    ),
];

/// The only crate that may touch files and the terminal.
const COMMAND_LINE: &str = "sky-cli";

/// Ways to files, terminal, network and environment, and the clock.
const WORLD: [&str; 17] = [
    "std::fs",
    "std::io",
    "std::net",
    "std::env",
    "std::process",
    "File::open",
    "File::create",
    "print!",
    "println!",
    "eprint!",
    "eprintln!",
    "dbg!",
    "stdout()",
    "stderr()",
    "std::time",
    "Instant::now",
    "SystemTime",
];

/// Ways to more threads.
const THREADS: [&str; 4] = ["std::thread", "thread::spawn", "thread::scope", "rayon"];

/// Packages that plot, ask, show or open files.
const COMMAND_LINE_PACKAGES: [&str; 8] = [
    "anyhow",
    "clap",
    "ctrlc",
    "image",
    "indicatif",
    "miette",
    "plotters",
    "tempfile",
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn manifest(path: &Path) -> Table {
    read(path)
        .parse()
        .unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The crates that are there.
fn crates() -> Vec<(String, Table)> {
    let mut found: Vec<_> = fs::read_dir(root().join("crates"))
        .expect("crates")
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.join("Cargo.toml").is_file())
        .map(|path| {
            let name = path.file_name().expect("a name").to_string_lossy();
            (name.into_owned(), manifest(&path.join("Cargo.toml")))
        })
        .collect();
    found.sort_by(|a, b| a.0.cmp(&b.0));
    assert!(found.len() >= 4, "sky-core, sky-sim, sky-fit and sky-cli");
    found
}

/// Tables of packages in a manifest whose name is one of `kinds`, those for a target included.
fn packages(manifest: &Table, kinds: &[&str]) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for (key, value) in manifest {
        let Value::Table(table) = value else { continue };
        if kinds.contains(&key.as_str()) {
            for (name, package) in table {
                // `name = { package = "real-name" }` is that package under another name.
                let real = package.get("package").and_then(Value::as_str);
                found.insert(real.unwrap_or(name).to_owned());
            }
        } else if key == "target" {
            for value in table.values() {
                found.extend(packages(value.as_table().expect("a table"), kinds));
            }
        }
    }
    found
}

const LINKED: [&str; 2] = ["dependencies", "build-dependencies"];
const ALL_KINDS: [&str; 3] = ["dependencies", "build-dependencies", "dev-dependencies"];

/// Source files of a crate, without comments and without the tests at their end.
fn sources(name: &str) -> Vec<(PathBuf, String)> {
    fn walk(directory: &Path, found: &mut Vec<PathBuf>) {
        for entry in fs::read_dir(directory).expect("a directory of sources") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                walk(&path, found);
            } else if path.extension().is_some_and(|e| e == "rs") {
                found.push(path);
            }
        }
    }
    let mut paths = Vec::new();
    walk(&root().join("crates").join(name).join("src"), &mut paths);
    paths.sort();
    assert!(!paths.is_empty(), "{name} has no sources");
    paths
        .into_iter()
        .map(|path| {
            let text = read(&path);
            let tests = text.find("#[cfg(test)]\nmod ").unwrap_or(text.len());
            let code = text[..tests]
                .lines()
                .filter(|line| !line.trim_start().starts_with("//"))
                .collect::<Vec<_>>()
                .join("\n");
            (path, code)
        })
        .collect()
}

/// Whether a word stands in code, not as the end of a longer one: `print!` is not in `eprint!`.
fn has_word(code: &str, word: &str) -> bool {
    code.match_indices(word).any(|(at, _)| {
        !code[..at]
            .chars()
            .next_back()
            .is_some_and(|c| c.is_alphanumeric() || c == '_')
    })
}

/// Each place where one of the words stands in a crate's code.
fn uses(name: &str, words: &[&str]) -> Vec<String> {
    let mut found = Vec::new();
    for (path, code) in sources(name) {
        for word in words.iter().filter(|word| has_word(&code, word)) {
            found.push(format!("{}: {word}", path.display()));
        }
    }
    found
}

#[test]
fn crates_know_only_whom_they_may() {
    let ours: Vec<&str> = MAY_KNOW.iter().map(|(name, _)| *name).collect();
    for (name, manifest) in crates() {
        let Some((_, allowed)) = MAY_KNOW.iter().find(|(known, _)| *known == name) else {
            panic!("crates/{name}: expected one of {ours:?}");
        };
        // Tests and benches of a crate are held to the same wall.
        for package in packages(&manifest, &ALL_KINDS) {
            assert!(
                !package.starts_with("sky-") || allowed.contains(&package.as_str()),
                "crates/{name}: expected none of ours but {allowed:?}, found {package}"
            );
        }
    }
}

#[test]
fn a_simulator_links_the_core_and_little_else() {
    // What sky-core links is what every simulator links: a package more is a decision.
    let manifest = manifest(&root().join("crates/sky-core/Cargo.toml"));
    let expected = ["serde", "serde_json", "solar-positioning", "thiserror"].map(str::to_owned);
    assert_eq!(packages(&manifest, &LINKED), BTreeSet::from(expected));
}

#[test]
fn the_fit_does_not_know_the_simulation() {
    for path in ["Cargo.toml", "src"] {
        assert!(root().join("crates/sky-fit").join(path).exists());
    }
    assert_eq!(uses("sky-fit", &["sky_sim"]), Vec::<String>::new());
    assert_eq!(uses("sky-sim", &["sky_fit"]), Vec::<String>::new());
}

#[test]
fn only_the_command_line_touches_the_world() {
    for (name, manifest) in crates() {
        if name == COMMAND_LINE {
            continue;
        }
        assert_eq!(uses(&name, &WORLD), Vec::<String>::new());
        let linked = packages(&manifest, &LINKED);
        for package in COMMAND_LINE_PACKAGES {
            assert!(!linked.contains(package), "crates/{name} links {package}");
        }
    }
    // The words do find something where it is.
    assert!(!uses(COMMAND_LINE, &["std::fs"]).is_empty());
    assert!(!uses(COMMAND_LINE, &["std::io"]).is_empty());
}

#[test]
fn the_core_starts_no_thread() {
    assert_eq!(uses("sky-core", &THREADS), Vec::<String>::new());
    assert!(!uses("sky-sim", &["rayon"]).is_empty(), "the word is found");
}

#[test]
fn the_physics_is_computed_in_double_precision() {
    for name in ["sky-sim", "sky-fit"] {
        // the transport engine holds light, not geometry, in lanes of f32
        let mut found = uses(name, &["f32"]);
        found.retain(|place| !place.contains("/src/transport/"));
        assert_eq!(found, Vec::<String>::new());
    }
    assert!(!uses("sky-core", &["f32"]).is_empty(), "the table is f32");
}

#[test]
fn every_crate_takes_the_lints_of_the_workspace() {
    let tests = (
        "tests".to_owned(),
        manifest(&root().join("tests/Cargo.toml")),
    );
    for (name, manifest) in crates().into_iter().chain([tests]) {
        let inherited = manifest["lints"]["workspace"].as_bool();
        assert_eq!(inherited, Some(true), "{name}");
    }
}

#[test]
fn every_shipped_table_and_profile_says_where_it_comes_from() {
    for (directory, kind) in [("luts", "utmlut"), ("profiles", "csv")] {
        let readme = read(&root().join(directory).join("README.md"));
        for entry in fs::read_dir(root().join(directory)).expect("a directory") {
            let path = entry.expect("an entry").path();
            let name = path.file_name().expect("a name").to_string_lossy();
            if path.extension().is_some_and(|e| e == kind) {
                let quoted = format!("`{name}`");
                assert!(
                    readme.contains(&quoted),
                    "{directory}/README.md: no {quoted}"
                );
            }
        }
    }
    for entry in fs::read_dir(root().join("luts")).expect("luts") {
        let path = entry.expect("an entry").path();
        if path.extension().is_some_and(|e| e == "utmlut") {
            let bytes = fs::read(&path).expect("a readable table");
            if let Err(error) = sky_core::lut::Lut::decode(&bytes) {
                panic!("{}: {error}", path.display());
            }
        }
    }
}

#[test]
fn words_are_told_from_their_endings() {
    assert!(has_word("  print!(\"x\")", "print!"));
    assert!(!has_word("  eprint!(\"x\")", "print!"));
    assert!(has_word("use std::fs::File;", "std::fs"));
}
