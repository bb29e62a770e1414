//! Guarantee: the program alone suffices to begin: it carries every shipped experiment, and runs a manifest that is its only argument.

use crate::subcommand_bench::{Bench, GAS, call};
use std::fs;
use std::path::Path;

/// The manifests of `experiments`, by name.
fn shipped() -> Vec<(String, String)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../experiments");
    let paths = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let manifests = paths.filter(|path| path.extension().is_some_and(|end| end == "toml"));
    let mut named: Vec<(String, String)> = manifests
        .map(|path| {
            let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
            (name, fs::read_to_string(path).unwrap())
        })
        .collect();
    named.sort();
    named
}

#[test]
fn every_shipped_experiment_is_in_the_program() {
    let shipped = shipped();
    let list = call(["new", "--list"]);
    let names: Vec<&str> =
        list.out.lines().filter_map(|line| line.split_whitespace().next()).collect();
    let expected: Vec<&str> = shipped.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, expected);
    assert!(list.out.lines().all(|line| line.ends_with('?')), "{}", list.out);
    for (name, manifest) in &shipped {
        let printed = call(["new", name]);
        assert_eq!((printed.code, printed.out.trim_end()), (Some(0), manifest.trim_end()));
    }
    let bench = Bench::new();
    let kept = bench.write("first_run.toml", "mine");
    let written = bench.call(&["new", "--all", "."]);
    let count = format!("{} manifests", shipped.len() - 1);
    assert!(
        written.out.contains(&count) && written.out.contains("1 file existed"),
        "{}",
        written.out
    );
    assert_eq!(fs::read_to_string(kept).unwrap(), "mine");
    for (name, manifest) in shipped.iter().filter(|(name, _)| name != "first_run") {
        let file = bench.path(&format!("{name}.toml"));
        assert_eq!(&fs::read_to_string(file).unwrap(), manifest);
    }
}

#[test]
fn file_that_exists_is_not_replaced() {
    let bench = Bench::new();
    let unnamed = bench.call(&["new", "gas", "--output", "my gas.toml"]);
    assert_eq!(unnamed.code, Some(2), "{}", unnamed.out);
    assert!(unnamed.err.contains("cannot name an experiment\nhelp: "), "{}", unnamed.err);
    let first = bench.call(&["new", "gas", "--output", "my_gas.toml"]);
    assert_eq!(first.code, Some(0), "{}", first.err);
    assert!(first.out.ends_with("kinetoscope run my_gas.toml\n"), "{}", first.out);
    let manifest = fs::read_to_string(bench.path("my_gas.toml")).unwrap();
    let again = bench.call(&["new", "dem", "--output", "my_gas.toml"]);
    assert_eq!(again.code, Some(2), "{}", again.out);
    assert!(again.err.contains("exists already\nhelp: "), "{}", again.err);
    assert_eq!(fs::read_to_string(bench.path("my_gas.toml")).unwrap(), manifest);
    let unwritable = bench.call(&["new", "dem", "--output", "none/dem.toml"]);
    assert!(unwritable.code.is_some_and(|code| code > 0), "{}", unwritable.err);
    assert!(unwritable.err.contains("\nhelp: "), "{}", unwritable.err);
}

#[test]
fn demo_leaves_manifest_recording_and_report() {
    let bench = Bench::new();
    for _ in 0..2 {
        let demo = bench.call(&["demo", "--no-open"]);
        assert_eq!(demo.code, Some(0), "{}", demo.err);
        assert!(demo.out.contains("report     recordings/first_run/report.html"), "{}", demo.out);
        assert!(bench.path("recordings/first_run/report.html").exists());
    }
    bench.write("first_run.toml", GAS);
    let changed = bench.call(&["demo", "--no-open"]);
    assert_eq!(changed.code, Some(2));
    assert!(changed.err.contains("other contents\nhelp: "), "{}", changed.err);
}

#[test]
fn manifest_alone_is_run_and_analyzed_by_its_name() {
    let bench = Bench::new();
    bench.write("gas.toml", GAS);
    let nowhere = bench.call(&["analyze"]);
    assert_eq!(nowhere.code, Some(2), "{}", nowhere.out);
    assert!(nowhere.err.contains("no folder `recordings` here\nhelp: "), "{}", nowhere.err);
    let early = bench.call(&["analyze", "gas.toml"]);
    assert!(early.err.contains("gas.toml has no recordings in recordings/gas\nhelp: run it"));
    let ran = bench.call(&["gas.toml", "--quiet"]);
    assert_eq!((ran.code, ran.out.as_str()), (Some(0), ""), "{}", ran.err);
    for arguments in [&["analyze", "gas.toml"] as &[&str], &["analyze"]] {
        let analyzed = bench.call(arguments);
        assert_eq!(analyzed.code, Some(0), "{}", analyzed.err);
        assert!(analyzed.out.starts_with("gas (gas, 1 run)"), "{}", analyzed.out);
    }
    assert!(bench.path("recordings/index.html").exists());
    bench.write("named.toml", &format!("name = \"gas\"\n{GAS}"));
    assert_eq!(bench.call(&["analyze", "named.toml"]).code, Some(0));
    // Not the folder of all recordings, and no other one.
    for name in ["name = \"../gas\"", "name = \"\""] {
        bench.write("odd.toml", &format!("{name}\n{GAS}"));
        let odd = bench.call(&["analyze", "odd.toml"]);
        assert_eq!((odd.code, odd.out.as_str()), (Some(2), ""), "{name}");
        assert!(odd.err.contains("states no name of an experiment"), "{}", odd.err);
    }
    let mistaken = bench.call(&["gas.toml", "--forse"]);
    assert_eq!(mistaken.err, "error: unknown option `--forse`\nhelp: did you mean `--force`?\n");
    let help = bench.call(&["help", "verify"]);
    assert_eq!((help.code, help.out), (Some(0), call(["verify", "--help"]).out));
}

#[test]
fn folders_and_several_recordings_are_verified_and_described() {
    let bench = Bench::new();
    bench.write("gas.toml", &format!("replicates = 3\n{GAS}"));
    assert_eq!(bench.call(&["gas.toml", "--quiet"]).code, Some(0));
    let verified = bench.call(&["verify", "recordings"]);
    assert_eq!(verified.code, Some(0), "{}", verified.err);
    assert!(
        verified.out.ends_with("3 of 3 recordings equal to their reruns\n"),
        "{}",
        verified.out
    );
    let info = bench.call(&["info", "--json", "recordings"]);
    let documents: serde_json::Value = serde_json::from_str(&info.out).unwrap();
    let files: Vec<&str> =
        documents.as_array().unwrap().iter().map(|one| one["file"].as_str().unwrap()).collect();
    assert_eq!(files.len(), 3);
    // A flipped bit in one of them.
    let mut bytes = fs::read(bench.path(files[1])).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(bench.path(files[1]), bytes).unwrap();
    let damaged = bench.call(&["verify", "recordings"]);
    assert!(damaged.code.is_some_and(|code| code == 4 || code == 5), "{}", damaged.err);
    assert!(damaged.err.contains(files[1]), "{}", damaged.err);
    assert!(damaged.out.ends_with("2 of 3 recordings equal to their reruns\n"), "{}", damaged.out);
}
