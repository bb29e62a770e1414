//! Guarantee: `check --locked` finds a flipped sign in a force, a wall collision and a coefficient of an integrator, and names the
//! first frame that differs.
//!
//! Setup: a copy of the sources with four flipped signs is built; its program checks against the lock file one experiment that
//! executes each of them. The two wall collisions are those of a closed wall, and of one with an orifice. A sign of `reflected` is
//! not among them: it sends particles into the wall, where they collide without end.
//! Control: the hard discs, in which no line is changed, are equal.
//!
//!     cargo test --test guarantees -- --ignored --nocapture full_harness_flipped_signs

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

/// File, text, what it becomes, and an experiment whose first run uses it: the lock file has the tags of that run only.
const FLIPPED: [[&str; 4]; 4] = [
    [
        "src/physics/dem/motion.rs",
        "let trial = dashpot - spring.stiffness * stretched;",
        "let trial = dashpot + spring.stiffness * stretched;",
        "experiments/dem_incline.toml",
    ],
    [
        "src/physics/gas/closed_form.rs",
        "let position = distance - chord * collisions;",
        "let position = distance + chord * collisions;",
        "experiments/gas_300_kelvin.toml",
    ],
    [
        "src/physics/gas/motion.rs",
        "self.speed * time - 2.0 * self.half_chord * wall_collisions as f64",
        "self.speed * time + 2.0 * self.half_chord * wall_collisions as f64",
        "experiments/gas_effusion.toml",
    ],
    [
        "src/physics/orbit/integrators.rs",
        "Splitting([Kick(0.5), Drift(1.0), Kick(0.5)])",
        "Splitting([Kick(-0.5), Drift(1.0), Kick(0.5)])",
        "experiments/orbit_heliocentric.toml",
    ],
];
const CONTROL: &str = "experiments/packing_fifty_discs.toml";

fn output(command: &mut Command, folder: &Path) -> Output {
    let output = command.current_dir(folder).output().unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(matches!(output.status.code(), Some(0 | 4)), "{errors}");
    output
}

/// Copies the sources, with the flipped signs.
fn copy_flipped(root: &Path, copy: &Path) {
    let listed = output(Command::new("git").args(["ls-files", "-z"]), root).stdout;
    for name in String::from_utf8(listed).unwrap().split_terminator('\0') {
        let (from, to) = (root.join(name), copy.join(name));
        fs::create_dir_all(to.parent().unwrap()).unwrap();
        fs::copy(from, to).unwrap();
    }
    for [name, old, new, _] in FLIPPED {
        let text = fs::read_to_string(copy.join(name)).unwrap();
        assert_eq!(text.matches(old).count(), 1, "{name}: {old}");
        fs::write(copy.join(name), text.replace(old, new)).unwrap();
    }
}

#[test]
#[ignore = "builds the program again, without optimization"]
fn full_harness_flipped_signs_are_found() {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    let folder = tempfile::tempdir().unwrap();
    let copy = folder.path().join("copy");
    copy_flipped(root, &copy);
    let target = root.join("target/unoptimized");
    let build = ["build", "--quiet", "--config", "profile.dev.opt-level=0"];
    let build = [&build[..], &["--package", "kinetoscope-program", "--target-dir"]].concat();
    output(Command::new(env!("CARGO")).args(build).arg(&target), &copy);
    let mut check = Command::new(target.join("debug/kinetoscope"));
    check.args(["check", "--locked", "--json"]);
    check.args(FLIPPED.map(|[.., manifest]| manifest)).arg(CONTROL);
    let report: Value = serde_json::from_slice(&output(&mut check, &copy).stdout).unwrap();
    let findings = |manifest: &str| {
        let entries = report["experiments"].as_array().unwrap();
        let entry = entries.iter().find(|entry| entry["manifest"] == manifest).unwrap();
        assert_eq!(entry["equal"].as_bool(), Some(entry["findings"] == Value::Array(Vec::new())));
        entry["findings"].clone()
    };
    for [.., manifest] in FLIPPED {
        let place = findings(manifest)[0].as_str().unwrap_or("equal").to_owned();
        println!("{manifest}: {place}");
        assert!(place.contains("first difference in frame"), "{manifest}: {place}");
    }
    assert_eq!(findings(CONTROL), Value::Array(Vec::new()));
}
