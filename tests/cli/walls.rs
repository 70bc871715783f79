//! The walls of ARCHITECTURE.md: who may know whom, and who may touch the world.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use toml::{Table, Value};

use crate::source::Source;

/// A crate of the product, and what it may do.
struct Crate {
    name: &'static str,
    /// Crates of ours that it may know.
    knows: &'static [&'static str],
    /// Packages of [`KEPT_APART`] that it may link.
    links: &'static [&'static str],
    /// Ways of [`WORLD`] that it may go.
    ways: &'static [&'static str],
}

/// Packages of data: files and their names, no code. Every crate may know them.
const DATA: [&str; 3] = ["sky-luts", "sky-profiles", "sky-shaders"];

/// One that is not written yet is held to its line as soon as it is there.
const CRATES: [Crate; 13] = [
    library("sky-core", &[], &[]),
    library("sky-gpu", &["sky-core"], &["wgpu"]),
    library("sky-science", &["sky-core"], &[]),
    library("sky-sim", &["sky-core", "sky-science"], &[]),
    library("sky-fit", &["sky-core", "sky-science"], &[]),
    library("sky-baselines", &["sky-core", "sky-science"], &[]),
    library("sky-plot", &[], &["image", "plotters"]),
    Crate {
        // costs are measured, in one file: `the_clock_of_measurements_is_in_one_file`
        ways: CLOCK,
        ..library(
            "sky-eval",
            &[
                "sky-core",
                "sky-science",
                "sky-sim",
                "sky-fit",
                "sky-baselines",
                "sky-plot",
            ],
            &["anyhow"],
        )
    },
    library(
        "sky-plan",
        &["sky-core", "sky-science", "sky-sim", "sky-fit", "sky-eval"],
        &["anyhow"],
    ),
    Crate {
        // costs are measured; pictures are encoded in memory, through a cursor
        ways: &["std::time", "Instant", "std::io"],
        ..library(
            "sky-render",
            &["sky-core", "sky-gpu", "sky-science"],
            &["anyhow", "image", "wgpu"],
        )
    },
    Crate {
        // a flight goes by the clock
        ways: CLOCK,
        ..library(
            "sky-view",
            &["sky-core", "sky-gpu", "sky-render"],
            &["anyhow", "egui", "egui-wgpu", "egui-winit", "wgpu", "winit"],
        )
    },
    Crate {
        name: COMMAND_LINE,
        knows: &[
            "sky-core",
            "sky-gpu",
            "sky-science",
            "sky-sim",
            "sky-fit",
            "sky-baselines",
            "sky-eval",
            "sky-plan",
            "sky-plot",
            "sky-render",
        ],
        links: &["anyhow", "clap", "ctrlc", "indicatif", "tempfile", "wgpu"],
        ways: &WORLD,
    },
    Crate {
        // the window's program: arguments to a flight, pictures to files
        name: "utm-sky-view",
        knows: &[
            "sky-cli",
            "sky-core",
            "sky-gpu",
            "sky-plan",
            "sky-render",
            "sky-view",
        ],
        links: &["anyhow"],
        ways: &WORLD,
    },
];

/// Ways to the clock.
const CLOCK: &[&str] = &["std::time", "Instant"];

const fn library(
    name: &'static str,
    knows: &'static [&'static str],
    links: &'static [&'static str],
) -> Crate {
    Crate {
        name,
        knows,
        links,
        ways: &[],
    }
}

/// The only crate that may touch files and the terminal.
const COMMAND_LINE: &str = "sky-cli";

/// Ways to files, terminal, network and environment, and the clock.
const WORLD: [&str; 17] = [
    "std::fs",
    "std::io",
    "std::net",
    "std::env",
    "std::os",
    "std::process",
    "std::time",
    "File",
    "Instant",
    "SystemTime",
    "print!",
    "println!",
    "eprint!",
    "eprintln!",
    "dbg!",
    "stdout",
    "stderr",
];

/// Ways to more threads.
const THREADS: [&str; 2] = ["std::thread", "rayon"];

/// Packages that plot, ask, show, open files, or drive a GPU.
const KEPT_APART: [&str; 13] = [
    "anyhow",
    "clap",
    "ctrlc",
    "egui",
    "egui-wgpu",
    "egui-winit",
    "image",
    "indicatif",
    "miette",
    "plotters",
    "tempfile",
    "wgpu",
    "winit",
];

/// Crates whose files still know each other in a circle: what is left to take apart.
const WITH_CIRCLES: [&str; 0] = [];

/// Most lines of the command line, tests left out.
const MAX_LINES: usize = 5000;

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

/// The name of a crate of ours, without what it may be published under.
fn ours(package: &str) -> Option<&str> {
    let name = package.strip_prefix("utm-").unwrap_or(package);
    name.starts_with("sky-").then_some(name)
}

/// Source files of a crate, by their place below `src`: what their code says, tests left out.
fn sources(name: &str) -> BTreeMap<PathBuf, Source> {
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
    let top = root().join("crates").join(name).join("src");
    let mut paths = Vec::new();
    walk(&top, &mut paths);
    assert!(!paths.is_empty(), "{name} has no sources");
    let mut found: BTreeMap<PathBuf, Source> = paths
        .into_iter()
        .map(|path| {
            let source = Source::read(&read(&path));
            let below = path.strip_prefix(&top).expect("a file of the crate");
            (below.to_owned(), source)
        })
        .collect();
    let for_tests: Vec<Vec<String>> = found
        .iter()
        .flat_map(|(path, source)| {
            let here = module_of(path);
            let tests = source.modules.iter().filter(|(_, for_tests)| **for_tests);
            tests.map(move |(name, _)| [here.as_slice(), std::slice::from_ref(name)].concat())
        })
        .collect();
    found.retain(|path, _| {
        let module = module_of(path);
        !for_tests.iter().any(|tests| module.starts_with(tests))
    });
    found
}

/// The module that a file is: `a/b.rs` and `a/b/mod.rs` are `a::b`, `lib.rs` is the crate.
fn module_of(path: &Path) -> Vec<String> {
    let mut names: Vec<String> = path
        .with_extension("")
        .iter()
        .map(|name| name.to_string_lossy().into_owned())
        .collect();
    let last = names.last().map(String::as_str);
    if last == Some("mod") || (names.len() == 1 && matches!(last, Some("lib" | "main"))) {
        names.pop();
    }
    names
}

/// Each place where one of the forms stands in a crate's code.
fn uses(name: &str, forms: &[&str]) -> Vec<String> {
    let mut found = Vec::new();
    for (path, source) in sources(name) {
        for form in forms.iter().filter(|form| source.uses(form)) {
            found.push(format!("{name}/src/{}: {form}", path.display()));
        }
    }
    found
}

/// The files of a crate that each file names.
fn knows(
    files: &BTreeMap<PathBuf, Source>,
    crate_name: &str,
) -> BTreeMap<PathBuf, BTreeSet<PathBuf>> {
    let crate_name = crate_name.replace('-', "_");
    let modules: Vec<(Vec<String>, &PathBuf)> =
        files.keys().map(|path| (module_of(path), path)).collect();
    let file_of = |module: &[String]| {
        let of_it = modules.iter().filter(|(m, _)| module.starts_with(m));
        of_it
            .max_by_key(|(m, path)| (m.len(), path.ends_with("lib.rs")))
            .map(|(_, path)| *path)
    };
    let mut out = BTreeMap::new();
    for (path, source) in files {
        let here = module_of(path);
        let mut known = BTreeSet::new();
        // a word alone is a visibility: `pub(crate)` names no file
        for named in source.paths.iter().filter(|named| named.len() > 1) {
            let ups = named.iter().take_while(|n| *n == "super").count();
            let first = named[0].as_str();
            let (above, rest) = if first == "crate" || first == crate_name {
                (&[][..], &named[1..])
            } else if first == "self" {
                (&here[..], &named[1..])
            } else if ups > 0 {
                (&here[..here.len().saturating_sub(ups)], &named[ups..])
            } else if source.modules.contains_key(first) {
                (&here[..], &named[..])
            } else {
                continue;
            };
            let module = [above, rest].concat();
            known.extend(file_of(&module).filter(|file| *file != path).cloned());
        }
        out.insert(path.clone(), known);
    }
    out
}

/// What files in a circle know of each other: each pair of which the second leads back to the first.
fn in_circles(knows: &BTreeMap<PathBuf, BTreeSet<PathBuf>>) -> Vec<String> {
    let leads_to = |start: &PathBuf, file: &PathBuf| {
        let mut reached = BTreeSet::from([start]);
        let mut open = vec![start];
        while let Some(next) = open.pop() {
            open.extend(knows[next].iter().filter(|k| reached.insert(k)));
        }
        reached.contains(file)
    };
    let mut found = Vec::new();
    for (file, known) in knows {
        let back = known.iter().filter(|k| leads_to(k, file));
        found.extend(back.map(|k| format!("{} knows {}", file.display(), k.display())));
    }
    found
}

/// Lines of a file but for its modules of tests, which end with a brace at a line's begin.
fn lines_without_tests(text: &str) -> usize {
    let mut is_test = false;
    let mut count = 0;
    for line in text.lines() {
        is_test |= line == "#[cfg(test)]";
        count += usize::from(!is_test);
        is_test &= line != "}";
    }
    count
}

fn crate_named(name: &str) -> &'static Crate {
    let known = CRATES.iter().find(|c| c.name == name);
    known.unwrap_or_else(|| panic!("crates/{name}: expected one of the walls' crates"))
}

#[test]
fn crates_know_only_whom_they_may() {
    for (name, manifest) in crates() {
        let allowed = crate_named(&name).knows;
        // Tests and benches of a crate are held to the same wall.
        for package in packages(&manifest, &ALL_KINDS) {
            assert!(
                ours(&package)
                    .is_none_or(|package| allowed.contains(&package) || DATA.contains(&package)),
                "crates/{name}: expected none of ours but {allowed:?}, found {package}"
            );
        }
    }
}

#[test]
fn no_code_comes_from_where_the_walls_do_not_look() {
    for (name, _) in crates() {
        for (path, source) in sources(&name) {
            assert!(!source.takes_in_files, "{name}: {}", path.display());
        }
    }
}

#[test]
fn files_of_a_crate_do_not_know_each_other_in_a_circle() {
    let mut wrong = BTreeMap::new();
    for (name, _) in crates() {
        let circles = in_circles(&knows(&sources(&name), &name));
        if !circles.is_empty() && !WITH_CIRCLES.contains(&name.as_str()) {
            wrong.insert(name, circles);
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn a_circle_of_files_is_found() {
    let files = |texts: &[(&str, &str)]| {
        let read = |(path, text): &(&str, &str)| (PathBuf::from(path), Source::read(text));
        texts.iter().map(read).collect::<BTreeMap<_, _>>()
    };
    let top = ("lib.rs", "mod a; mod b; pub use a::A;");
    for (a, b, expected) in [
        ("use crate::b::B;", "use crate::a::A;", 2),
        (
            "use crate::b as other; fn f() { other::B }",
            "use super::{a::A};",
            2,
        ),
        ("use crate::b::B;", "use crate::A;", 3),
        (
            "use crate::b::B;",
            "#[cfg(test)] mod tests { use crate::a::A; }",
            0,
        ),
        ("use crate::b::B;", "use other::a::A;", 0),
        ("fn f() { crate::b::B }", "fn f() { sky::a::A }", 2),
    ] {
        let all = files(&[top, ("a.rs", a), ("b/mod.rs", b)]);
        let found = in_circles(&knows(&all, "sky"));
        assert_eq!(found.len(), expected, "{a} {b}: {found:?}");
    }
    // a module and what it holds
    let all = files(&[
        ("lib.rs", "mod a;"),
        ("a/mod.rs", "mod b; use b::B;"),
        ("a/b.rs", "use super::A;"),
    ]);
    assert_eq!(in_circles(&knows(&all, "sky")).len(), 2);
}

/// Every package that a crate's user compiles on Linux with the default features, by `cargo tree`.
fn compiled_for(package: &str) -> BTreeSet<String> {
    let output = Command::new(env!("CARGO"))
        .args(["tree", "--locked", "--edges", "normal,build"])
        .args(["--prefix", "none", "--format", "{p}"])
        .args(["--target", "x86_64-unknown-linux-gnu", "--package", package])
        .current_dir(root())
        .output()
        .expect("cargo tree");
    let text = String::from_utf8(output.stdout).expect("text");
    let names = text.lines().filter_map(|line| line.split(' ').next());
    names.map(str::to_owned).collect()
}

/// What a simulator compiles besides wgpu.
const WITHOUT_GPU: [&str; 16] = [
    "itoa",
    "memchr",
    "proc-macro2",
    "quote",
    "serde",
    "serde_core",
    "serde_derive",
    "serde_json",
    "sky-core",
    "sky-luts",
    "solar-positioning",
    "syn",
    "thiserror",
    "thiserror-impl",
    "unicode-ident",
    "zmij",
];

#[test]
fn a_simulator_compiles_the_core_and_little_else() {
    // A package more is a decision: every simulator pays for it.
    let expected: BTreeSet<String> = WITHOUT_GPU.map(str::to_owned).into();
    assert_eq!(compiled_for("sky-core"), expected);
    // With wgpu and its own packages, the same and no crate of ours but the shaders.
    let with_gpu = compiled_for("sky-gpu");
    let ours: BTreeSet<&str> = with_gpu.iter().filter_map(|p| ours(p)).collect();
    assert_eq!(ours, BTreeSet::from(["sky-core", "sky-gpu", "sky-shaders"]));
    for package in [
        "palette", "nalgebra", "rayon", "csv", "argmin", "plotters", "image", "clap",
    ] {
        assert!(!with_gpu.contains(package), "sky-gpu compiles {package}");
    }
    let manifest = manifest(&root().join("crates/sky-gpu/Cargo.toml"));
    let expected = [
        "glam",
        "pollster",
        "sky-core",
        "sky-shaders",
        "thiserror",
        "wgpu",
    ];
    let expected: BTreeSet<String> = expected.map(str::to_owned).into();
    assert_eq!(packages(&manifest, &LINKED), expected);
}

/// Directories of the packages that are meant to be published.
fn published() -> Vec<PathBuf> {
    let mut found: Vec<PathBuf> = DATA
        .iter()
        .map(|name| root().join(name.trim_start_matches("sky-")))
        .collect();
    found.extend(
        crates()
            .into_iter()
            .map(|(name, _)| root().join("crates").join(name)),
    );
    found
}

#[test]
fn every_published_package_carries_its_licenses_and_metadata() {
    for directory in published() {
        for license in ["LICENSE-MIT", "LICENSE-APACHE"] {
            let (here, top) = (directory.join(license), root().join(license));
            assert!(
                read(&here) == read(&top),
                "{}: not as {license}",
                here.display()
            );
        }
        let manifest = manifest(&directory.join("Cargo.toml"));
        for key in ["license", "description", "readme", "keywords", "categories"] {
            let there = manifest["package"]
                .as_table()
                .is_some_and(|p| p.contains_key(key));
            assert!(there, "{}: no {key}", directory.display());
        }
    }
    // A path without a version cannot be published.
    let dependencies = &manifest(&root().join("Cargo.toml"))["workspace"]["dependencies"];
    for (name, package) in dependencies.as_table().expect("a table") {
        let has = |key| package.get(key).is_some();
        assert!(
            !has("path") || has("version"),
            "{name}: a path without a version"
        );
    }
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
        let may = crate_named(&name);
        let forms: Vec<&str> = WORLD
            .into_iter()
            .filter(|w| !may.ways.contains(w))
            .collect();
        assert_eq!(uses(&name, &forms), Vec::<String>::new());
        let linked = packages(&manifest, &LINKED);
        for package in KEPT_APART.iter().filter(|p| !may.links.contains(p)) {
            assert!(!linked.contains(*package), "crates/{name} links {package}");
        }
    }
    // The forms do find something where it is.
    for form in ["std::fs", "std::io", "std::time", "Instant"] {
        assert!(!uses(COMMAND_LINE, &[form]).is_empty(), "{form}");
    }
}

#[test]
fn the_command_line_is_small() {
    let top = root().join("crates").join(COMMAND_LINE).join("src");
    let lines: usize = sources(COMMAND_LINE)
        .keys()
        .map(|file| lines_without_tests(&read(&top.join(file))))
        .sum();
    assert!((1000..=MAX_LINES).contains(&lines), "{lines} lines");
}

#[test]
fn lines_of_tests_are_not_counted() {
    let text = "fn a() {}\n\n#[cfg(test)]\nmod tests {\n    fn b() {}\n}\nfn c() {}\n";
    assert_eq!(lines_without_tests(text), 3);
}

#[test]
fn no_command_waits_for_the_window() {
    let workspace = manifest(&root().join("Cargo.toml"));
    let default = workspace["workspace"]["default-members"].as_array();
    let default: Vec<&str> = default
        .into_iter()
        .flatten()
        .flat_map(Value::as_str)
        .collect();
    assert_eq!(default, [format!("crates/{COMMAND_LINE}")]);
    let crates: BTreeMap<String, Table> = crates().into_iter().collect();
    let mut reached = BTreeSet::from([COMMAND_LINE.to_owned()]);
    let mut open = vec![COMMAND_LINE.to_owned()];
    while let Some(name) = open.pop() {
        for package in packages(&crates[&name], &LINKED) {
            assert!(
                !package.starts_with("egui") && package != "winit",
                "{name} links {package}"
            );
            if crates.contains_key(&package) && reached.insert(package.clone()) {
                open.push(package);
            }
        }
    }
    assert!(reached.contains("sky-gpu"), "{reached:?}");
    // where they are linked, they are seen
    assert!(packages(&crates["sky-view"], &LINKED).contains("winit"));
}

#[test]
fn the_clock_of_measurements_is_in_one_file() {
    let found = uses("sky-eval", CLOCK);
    assert!(!found.is_empty(), "the words are found");
    for place in found {
        assert!(place.contains("/src/stopwatch.rs"), "{place}");
    }
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
