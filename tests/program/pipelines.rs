//! Guarantee: `run` takes several manifests and folders; a manifest that `start_from` names runs first, once.

use crate::subcommand_bench::{Bench, GAS, recordings};
use std::fs;

/// A bed of discs, and a run that starts where it ends.
const BED: &str = "[model.dem]\ndiscs = 5\nduration_s = 0.002\n[record]\nframes = 2\n";

fn next(name: &str) -> String {
    format!("[model.dem]\nstart_from = \"{name}\"\nduration_s = 0.001\n[record]\nframes = 2\n")
}

#[test]
fn several_manifests_and_a_folder_run() {
    let bench = Bench::new();
    fs::create_dir(bench.path("set")).unwrap();
    bench.write("set/one.toml", GAS);
    bench.write("set/two.toml", GAS);
    bench.write("three.toml", GAS);
    let ran = bench.call(&["run", "--json", "set", "three.toml", "set/one.toml"]);
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    let json = ran.json();
    let names: Vec<&str> = json["experiments"]
        .as_array()
        .unwrap()
        .iter()
        .map(|experiment| experiment["experiment"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["one", "two", "three"]);
    for name in names {
        assert_eq!(recordings(&bench.path("recordings").join(name)).len(), 1);
    }
}

#[test]
fn an_error_in_one_manifest_stops_all_before_the_first_run() {
    let bench = Bench::new();
    bench.write("good.toml", GAS);
    bench.write("bad.toml", "[model.gas]\nparticle = 1\n");
    let ran = bench.call(&["run", "good.toml", "bad.toml", "none.toml"]);
    assert_eq!(ran.code, Some(2));
    assert!(ran.err.contains("particle") && ran.err.contains("none.toml"), "{}", ran.err);
    assert!(!bench.path("recordings").exists(), "no run was started");
}

#[test]
fn manifests_of_one_name_and_empty_folders_are_rejected() {
    let bench = Bench::new();
    fs::create_dir(bench.path("other")).unwrap();
    let empty = bench.call(&["run", "other"]);
    assert_eq!(empty.code, Some(2));
    assert!(empty.err.contains("the folder other has no manifest (*.toml)"), "{}", empty.err);
    bench.write("gas.toml", GAS);
    bench.write("other/gas.toml", GAS);
    let same = bench.call(&["run", "gas.toml", "other"]);
    assert_eq!(same.code, Some(2));
    assert!(same.err.contains("have the same name \"gas\""), "{}", same.err);
    let export = bench.call(&["run", "gas.toml", "other/gas.toml", "--export-commands", "list"]);
    assert!(export.err.contains("--export-commands takes one manifest"), "{}", export.err);
}

#[test]
fn a_manifest_to_start_from_runs_first_and_once() {
    let bench = Bench::new();
    bench.write("bed.toml", BED);
    bench.write("next.toml", &next("bed.toml"));
    bench.write("last.toml", &next("next.toml"));
    let planned = bench.call(&["check", "last.toml"]);
    assert_eq!(planned.code, Some(0), "{}", planned.err);
    let pending = "last.toml: planned when the run that it starts from is finished: \
                   bed.toml has no recording in recordings/bed";
    assert!(planned.out.contains(pending), "{}", planned.out);
    assert!(!bench.path("recordings").exists());

    let ran = bench.call(&["run", "--json", "last.toml"]);
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    let written = |name: &str| recordings(&bench.path("recordings").join(name));
    let bed = fs::metadata(&written("bed")[0]).unwrap().modified().unwrap();
    assert!(written("next").len() == 1 && written("last").len() == 1);
    let experiments = ran.json()["experiments"].as_array().unwrap().len();
    assert_eq!(experiments, 3);

    let again = bench.call(&["run", "last.toml"]);
    assert!(
        again.out.contains("Nothing to do: all recordings are in recordings/last"),
        "{}",
        again.out
    );
    let forced = bench.call(&["run", "--force", "last.toml"]);
    assert_eq!(forced.code, Some(0), "{}", forced.err);
    assert_eq!(fs::metadata(&written("bed")[0]).unwrap().modified().unwrap(), bed, "bed ran once");

    // Control: the same start by the path of the recording has the same key.
    let recording = written("next").remove(0);
    let by_path =
        next(&format!("../{}", recording.strip_prefix(bench.path("")).unwrap().display()));
    fs::create_dir(bench.path("by_path")).unwrap();
    bench.write("by_path/last.toml", &by_path);
    let same = bench.call(&["run", "by_path/last.toml"]);
    assert!(same.out.contains("Nothing to do"), "{}{}", same.out, same.err);
}

/// The exit code is that of the run that failed, and the next step is named.
#[test]
fn manifests_whose_start_failed_are_not_started() {
    let bench = Bench::new();
    let unstable = "on_unstable_time_step = \"warn\"\ntime_step_s = 0.01\nduration_s = 1.0";
    bench.write("bed.toml", &BED.replace("duration_s = 0.002", unstable));
    bench.write("next.toml", &next("bed.toml"));
    let exported = bench.call(&["run", "--export-commands", "list", "next.toml"]);
    assert_eq!(exported.code, Some(75), "{}", exported.err);
    assert!(exported.err.contains("help: execute the commands of list"), "{}", exported.err);
    let why = bench.call(&["why", "next.toml"]);
    assert_eq!((why.code, why.err.as_str()), (Some(0), ""));
    assert!(why.out.contains("next.toml: planned when the run"), "{}", why.out);
    let ran = bench.call(&["run", "--json", "next.toml"]);
    assert_eq!(ran.code, Some(1), "{}", ran.err);
    let error = "error: next.toml was not started: the run of bed.toml failed\n\
                 help: change the manifest that it starts from\n";
    assert!(ran.err.ends_with(error), "{}", ran.err);
    for subcommand in ["check", "why"] {
        let called = bench.call(&[subcommand, "--json", "next.toml"]);
        assert_eq!(called.code, Some(1), "{}", called.err);
        assert!(called.err.contains("next.toml cannot start: the run of bed.toml failed"));
        assert_eq!(called.json()["errors"].as_array().unwrap().len(), 1);
    }
}

#[test]
fn a_cycle_is_an_error_with_both_lines() {
    let bench = Bench::new();
    bench.write("a.toml", &next("b.toml"));
    bench.write("b.toml", &format!("seed = 2\n{}", next("a.toml")));
    for subcommand in ["run", "check", "why"] {
        let called = bench.call(&[subcommand, "a.toml"]);
        assert_eq!(called.code, Some(2), "{}", called.err);
        let expected = "error: the manifests start from each other\n  \
                        a.toml:2: start_from = \"b.toml\"\n  b.toml:3: start_from = \"a.toml\"\n\
                        help: name a recording (*.mcap) in one of these lines\n";
        assert_eq!(called.err, expected);
    }
    bench.write("self.toml", &next("self.toml"));
    let own = bench.call(&["run", "self.toml"]);
    assert!(own.code == Some(2) && own.err.contains("self.toml:2:"), "{}", own.err);
}

#[test]
fn a_start_without_one_recording_is_rejected() {
    let bench = Bench::new();
    bench.write("next.toml", &next("bed.toml"));
    let missing = bench.call(&["run", "next.toml"]);
    assert_eq!(missing.code, Some(2));
    assert!(missing.err.contains("next.toml:2: start_from = \"bed.toml\""), "{}", missing.err);
    bench.write("bed.toml", &format!("replicates = 2\n{BED}"));
    let several = bench.call(&["run", "--quiet", "next.toml"]);
    assert_eq!(several.code, Some(2), "{}", several.err);
    let what = "error: next.toml starts from bed.toml, which has 2 runs; must have 1\n";
    assert!(several.err.starts_with(what), "{}", several.err);
    assert!(!bench.path("recordings").exists(), "no run was started");
}

#[test]
fn a_chain_of_more_than_64_manifests_is_an_error_with_its_next_line() {
    let bench = Bench::new();
    bench.write("m0.toml", BED);
    for number in 1..400 {
        bench.write(&format!("m{number}.toml"), &next(&format!("m{}.toml", number - 1)));
    }
    for subcommand in ["run", "check", "why", "benchmark"] {
        let called = bench.call(&[subcommand, "m399.toml"]);
        assert_eq!(called.code, Some(2), "{}", called.err);
        let what = "error: more than 64 manifests, of which each starts from the next\n  \
                    m336.toml:2: start_from = \"m335.toml\"\nhelp: ";
        assert!(called.err.starts_with(what), "{subcommand}: {}", called.err);
    }
    // A chain of 64 is planned.
    let called = bench.call(&["check", "m63.toml"]);
    assert_eq!(called.code, Some(0), "{}", called.err);
    assert!(called.out.contains("m63.toml: planned when the run"), "{}", called.out);
}

/// Each of two manifests per level starts from both of the level below: 2^50 ways lead to the lowest.
#[test]
fn many_ways_to_one_manifest_read_it_once() {
    let bench = Bench::new();
    let model = "[model.dem]\nduration_s = 0.001\n";
    for side in ["a", "b"] {
        bench.write(&format!("{side}0.toml"), BED);
        for level in 1..50 {
            let below = level - 1;
            let sweep = format!(
                "{model}[sweep]\nmodel.dem.start_from = [\"a{below}.toml\", \"b{below}.toml\"]\n"
            );
            bench.write(&format!("{side}{level}.toml"), &sweep);
        }
    }
    let called = bench.call(&["check", "a49.toml"]);
    assert_eq!(called.code, Some(0), "{}", called.err);
    let what = "a49.toml: planned when the run that it starts from is finished";
    assert!(called.out.contains(what), "{}", called.out);
    // An error of a start is reported once, not with those of all its starts.
    assert_eq!(bench.call(&["run", "--quiet", "a0.toml"]).code, Some(0));
    let called = bench.call(&["run", "--dry-run", "a49.toml"]);
    assert!(called.out.len() + called.err.len() < 100_000, "{}", called.out.len());
}
