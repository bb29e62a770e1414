//! Guarantee: a new model is a set of new files and a few lines in at most four existing ones. A metric changes the files of one folder
//! of the analysis, and an integrator and a contact law change two files each. ARCHITECTURE.md names them.
//!
//! Setup: the example `extend` adds all of them to a copy of the sources, which is built once. Its programs record and analyze an
//! experiment of each extension: the energy error of an oscillator by semi-implicit Euler is (omega dt/2)/(1 - omega dt/2) = 5.26 %, the
//! speed at the perihelion follows from the conservation of energy, Ruth's method has the order 3 that its properties state, and an
//! impact of a cone has the overlap, the duration and the restitution of its closed form.
//! Control: the checks would fail for an energy error of 4 % or 5.5 %, for another speed, for another order, and for a linear spring; the
//! build fails if one of the lines is missing.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;

/// The extensions, with the bullet of ARCHITECTURE.md and the experiment of each.
const EXTENSIONS: [(&str, &str, &str); 4] = [
    ("model", "- **A model:**", "oscillator"),
    ("metric", "- **A metric:**", "perihelion_speed"),
    ("integrator", "- **An integrator:**", "ruth"),
    ("contact_law", "- **A contact law:**", "cone"),
];

/// Runs a command in a folder and returns what it printed.
fn succeed(command: &mut Command, folder: &Path) -> String {
    let output = command.current_dir(folder).output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{text}{}", String::from_utf8_lossy(&output.stderr));
    text
}

/// The existing files that each extension changes, from the output of the example.
fn changed_files(printed: &str) -> BTreeMap<&str, Vec<&str>> {
    let mut changed: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    let mut extension = "";
    for line in printed.lines() {
        match line.strip_prefix("  ") {
            Some(file) => changed.entry(extension).or_default().push(file),
            None => extension = line.split(':').next().unwrap(),
        }
    }
    changed
}

/// Whether a bullet of ARCHITECTURE.md names a file, or the folder that contains it.
fn names(bullet: &str, file: &str) -> bool {
    bullet
        .split('`')
        .skip(1)
        .step_by(2)
        .any(|path| path == file || path.ends_with('/') && file.starts_with(path))
}

#[test]
#[ignore = "builds the programs again, without optimization"]
fn extensions_change_the_files_that_the_architecture_names() {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    let folder = tempfile::tempdir().unwrap();
    let copy = folder.path().join("copy");
    let example = ["run", "--quiet", "--example", "extend", "--"];
    let printed = succeed(Command::new(env!("CARGO")).args(example).arg(&copy), root);
    let changed = changed_files(&printed);
    assert!(changed["model"].len() <= 4, "{printed}");
    let architecture = fs::read_to_string(root.join("ARCHITECTURE.md")).unwrap();
    for (extension, bullet, _) in EXTENSIONS {
        let (_, text) = architecture.split_once(bullet).unwrap();
        let text = text.split("\n- ").next().unwrap();
        let unnamed = changed[extension].iter().find(|file| !names(text, file));
        assert_eq!(unnamed, None, "not named at {bullet}");
    }

    let target = root.join("target/unoptimized");
    let build = ["build", "--quiet", "--config", "profile.dev.opt-level=0", "--target-dir"];
    succeed(Command::new(env!("CARGO")).args(build).arg(&target), &copy);
    let program = |name: &str| Command::new(target.join("debug").join(name));
    for (_, _, experiment) in EXTENSIONS {
        let manifest = format!("experiments/{experiment}.toml");
        succeed(program("run-experiment").args(["--quiet", &manifest]), &copy);
        let recordings = format!("recordings/{experiment}");
        let analysis = succeed(program("analyze-recordings").arg(recordings), &copy);
        let passed = analysis.contains("check passed") || analysis.contains("checks passed");
        assert!(passed && !analysis.contains("failed"), "{analysis}");
    }
    let analysis = succeed(program("analyze-recordings").arg("recordings/oscillator"), &copy);
    assert!(analysis.contains("energy.max_error_relative  0.0526"), "{analysis}");
}
