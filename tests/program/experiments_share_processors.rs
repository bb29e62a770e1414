//! Guarantee: the runs of several manifests are executed in parallel and long runs first, and everything else is as if each manifest was
//! executed alone: bytes, errors, the order of plans and summaries, and the resumption after a signal.
//!
//! Setup: few particles. A run that takes hours is a gas of so many steps; it ends by the signal.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::subcommand_bench::{Bench, Called, command, recordings};
use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

const NAMES: [&str; 4] = ["a_gas", "b_packing", "c_bed", "d_orbit"];
const LONGEST: Duration = Duration::from_mins(2);

fn stepped_gas(duration_s: f64) -> String {
    format!(
        "seed = 1\n[model.gas]\nparticles = 50\nduration_s = {duration_s}\npropagation = \"time-stepped\"\ntime_step_s = 1e-6\n\
         [record]\nframes = 20\n"
    )
}

/// A bench with four manifests, of which the last one has the longest runs.
fn bench() -> Bench {
    let bench = Bench::new();
    let texts = [
        // As many particles as have all threads: the run is executed alone.
        "seed = 1\n[model.gas]\nparticles = 3000\nduration_s = 0.01\n[record]\nframes = 4\n",
        "seed = 1\nreplicates = 5\n[model.packing]\ndiscs = 6\nevents_per_disc = 20\n[record]\nframes = 2\n",
        "seed = 1\n[model.dem]\ndiscs = 5\nduration_s = 0.02\n[record]\nframes = 5\n[sweep]\nmodel.dem.restitution = [0.5, 0.9]\n",
        "seed = 1\n[model.orbit]\nduration_days = 3000\ntime_step_days = 0.01\n[record]\nframes = 5\n[sweep]\nmodel.orbit.integrator = [\"rk4\", \"velocity-verlet\"]\n",
    ];
    for (name, text) in NAMES.iter().zip(texts) {
        bench.write(&format!("{name}.toml"), text);
    }
    bench
}

fn start(bench: &Bench, arguments: &[&str]) -> Child {
    command()
        .args(arguments)
        .current_dir(bench.0.path())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

fn wait_until(what: &str, mut holds: impl FnMut() -> bool) {
    let started = Instant::now();
    while !holds() {
        assert!(started.elapsed() < LONGEST, "{what}");
        sleep(Duration::from_millis(2));
    }
}

fn interrupted(program: Child) -> Called {
    let sent = Command::new("kill").args(["-INT", &program.id().to_string()]).status().unwrap();
    assert!(sent.success());
    program.wait_with_output().unwrap().into()
}

/// The finished recordings of an experiment.
fn finished(bench: &Bench, output: &str, name: &str) -> Vec<PathBuf> {
    let folder = bench.path(output).join(name);
    let mut found = if folder.exists() { recordings(&folder) } else { Vec::new() };
    found.retain(|path| !path.to_string_lossy().ends_with(".partial.mcap"));
    found
}

/// The finished recordings below a folder.
fn bytes(bench: &Bench, output: &str) -> BTreeMap<PathBuf, Vec<u8>> {
    let paths = NAMES.iter().flat_map(|name| finished(bench, output, name));
    paths.map(|path| (path.file_name().unwrap().into(), fs::read(path).unwrap())).collect()
}

/// Lines that start with one of these words, in the order of `words` and once each.
fn in_order(text: &str, words: &[String]) {
    let places: Vec<_> = words
        .iter()
        .map(|word| {
            let found: Vec<_> = text.match_indices(word.as_str()).map(|(place, _)| place).collect();
            assert_eq!(found.len(), 1, "{word:?} in {text}");
            found[0]
        })
        .collect();
    assert!(places.is_sorted(), "{words:?} in {text}");
}

#[test]
fn bytes_and_summaries_do_not_depend_on_jobs_across_manifests() {
    let bench = bench();
    let mut all = Vec::new();
    for jobs in ["1", "2", "3"] {
        let ran = bench.call(&[
            "run",
            "--jobs",
            jobs,
            "--output",
            jobs,
            "a_gas.toml",
            "b_packing.toml",
            "c_bed.toml",
            "d_orbit.toml",
        ]);
        assert_eq!(ran.code, Some(0), "{}", ran.err);
        in_order(&ran.out, &NAMES.map(|name| format!("{name}: ")));
        let wrote = [
            "Wrote 1/a_gas/",
            "Wrote 5 recordings to 1/b_packing",
            "Wrote 2 recordings to 1/c_bed",
            "Wrote 2 recordings to 1/d_orbit",
        ];
        in_order(&ran.out, &wrote.map(|text| text.replace("1/", &format!("{jobs}/"))));
        all.push(bytes(&bench, jobs));
    }
    assert_eq!(all[0].len(), 10);
    assert!(all[1] == all[0] && all[2] == all[0]);
    let again = bench.call(&["run", "--json", "--output", "2", "d_orbit.toml", "a_gas.toml"]);
    assert_eq!(again.json()["experiments"][0]["experiment"], "d_orbit", "{}", again.out);
}

/// Previously, the second manifest was not begun before the end of the first.
#[test]
fn runs_of_another_manifest_are_executed_during_a_long_run() {
    let bench = bench();
    bench.write("0_long.toml", &stepped_gas(1e6));
    let program =
        start(&bench, &["run", "--jobs", "2", "0_long.toml", "b_packing.toml", "c_bed.toml"]);
    let finished = |name| finished(&bench, "recordings", name).len();
    wait_until("no run is finished during the long one", || {
        finished("b_packing") == 5 && finished("c_bed") == 2
    });
    let ended = interrupted(program);
    assert_eq!(ended.code, Some(130), "{}", ended.err);
    in_order(&ended.out, &["Kept recordings/0_long/", "Wrote 5 ", "Wrote 2 "].map(str::to_owned));
    in_order(&ended.err, &["Interrupted. ".to_owned()]);
    assert_eq!(finished("0_long"), 0);
}

#[test]
fn interrupted_set_resumes_to_the_same_bytes() {
    let bench = bench();
    bench.write("a_gas.toml", &stepped_gas(1.0));
    let set = NAMES.map(|name| format!("{name}.toml"));
    let run = |output: &str| {
        let arguments = ["run", "--jobs", "2", "--checkpoint-every", "0.01", "--output", output];
        start(&bench, &[&arguments[..], &set.each_ref().map(String::as_str)].concat())
    };
    assert!(run("whole").wait_with_output().unwrap().status.success());
    for runs in [0, 1, 4] {
        let output = format!("interrupted_{runs}");
        let program = run(&output);
        let counted =
            || NAMES.iter().map(|name| finished(&bench, &output, name).len()).sum::<usize>();
        // The orbits are the longest runs by the estimate.
        let begun = || bench.path(&output).join("d_orbit").exists();
        wait_until("no run is finished", || begun() && counted() >= runs);
        let ended = interrupted(program);
        assert!(ended.code == Some(130) || counted() == 10, "{}", ended.err);
        let resumed: Called = run(&output).wait_with_output().unwrap().into();
        assert_eq!(resumed.code, Some(0), "{}", resumed.err);
        assert!(bytes(&bench, &output) == bytes(&bench, "whole"), "after {runs} runs");
    }
}

#[test]
fn failure_of_one_manifest_stops_no_other() {
    let bench = bench();
    let unstable = "[model.dem]\ndiscs = 5\non_unstable_time_step = \"warn\"\ntime_step_s = 0.01\nduration_s = 1.0\n[record]\nframes = 10\n";
    bench.write("c_bed.toml", unstable);
    fs::create_dir(bench.path("recordings")).unwrap();
    // No folder of recordings can be made in the place of a file.
    bench.write("recordings/a_gas", "");
    let ran = bench.call(&[
        "run",
        "--jobs",
        "2",
        "a_gas.toml",
        "b_packing.toml",
        "c_bed.toml",
        "d_orbit.toml",
    ]);
    assert_eq!(ran.code, Some(1), "{}", ran.err);
    in_order(
        &ran.err,
        &["cannot write to recordings/a_gas".to_owned(), "error: c_bed: failed".to_owned()],
    );
    in_order(
        &ran.out,
        &["Wrote 5 recordings", "Wrote recordings/c_bed/", "Wrote 2 recordings"].map(str::to_owned),
    );
}
