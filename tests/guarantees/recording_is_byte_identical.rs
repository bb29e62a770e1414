//! Guarantee: the same manifest gives the same bytes.
//!
//! Setup: the recording of each small experiment is made repeatedly: with one and two runs in parallel, with one to three threads, in
//! two folders and two time zones, by another user, and by other builds of the program if they are named. All files are compared.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::small_experiments::MANIFESTS;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;

/// The recordings that a program makes of two replicates of all small experiments, by file name.
fn recordings(program: &Path, jobs: &str) -> BTreeMap<String, Vec<u8>> {
    recordings_by(&mut || Command::new(program), jobs)
}

fn recordings_by(program: &mut dyn FnMut() -> Command, jobs: &str) -> BTreeMap<String, Vec<u8>> {
    let folder = tempfile::tempdir().unwrap();
    recordings_in(program, jobs, folder.path())
}

fn recordings_in(
    program: &mut dyn FnMut() -> Command,
    jobs: &str,
    folder: &Path,
) -> BTreeMap<String, Vec<u8>> {
    let output = folder.join("recordings");
    let mut files = BTreeMap::new();
    for (name, manifest) in MANIFESTS {
        let path = folder.join(format!("{name}.toml"));
        fs::write(&path, format!("replicates = 2\n{manifest}")).unwrap();
        let ran = program()
            .args(["--quiet", "--jobs", jobs, "--output"])
            .arg(&output)
            .arg(&path)
            .output()
            .unwrap();
        assert!(ran.status.success(), "{name}: {}", String::from_utf8_lossy(&ran.stderr));
        for entry in fs::read_dir(output.join(name)).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_some_and(|extension| extension == "mcap") {
                let file = path.file_name().unwrap().to_string_lossy().into_owned();
                files.insert(file, fs::read(&path).unwrap());
            }
        }
    }
    assert_eq!(files.len(), 2 * MANIFESTS.len(), "one recording per run");
    files
}

fn assert_same(one: &BTreeMap<String, Vec<u8>>, other: &BTreeMap<String, Vec<u8>>, case: &str) {
    assert!(one.keys().eq(other.keys()), "{case}: other files, therefore other run keys");
    for (name, bytes) in one {
        assert!(bytes == &other[name], "{case}: {name} differs");
    }
}

#[test]
fn recordings_do_not_depend_on_the_number_of_jobs() {
    let program = Path::new(env!("CARGO_BIN_EXE_run-experiment"));
    let first = recordings(program, "1");
    assert_same(&first, &recordings(program, "1"), "a repeated run");
    assert_same(&first, &recordings(program, "2"), "two jobs");
    let bodies: Vec<&Vec<u8>> = first.values().collect();
    assert!(bodies.windows(2).all(|pair| pair[0] != pair[1]), "replicates and models must differ");
}

#[test]
fn recordings_in_memory_equal_the_program_s() {
    let folder = tempfile::tempdir().unwrap();
    let written = recordings(Path::new(env!("CARGO_BIN_EXE_run-experiment")), "1");
    let mut made = BTreeMap::new();
    for (name, manifest) in MANIFESTS {
        let text = format!("name = \"{name}\"\nreplicates = 2\n{manifest}");
        let experiment: kinetoscope::Experiment = text.parse().unwrap();
        for run in &experiment.runs {
            let recording = kinetoscope::run(run).unwrap();
            let path = folder.path().join(&recording.provenance().run_key);
            recording.save(&path).unwrap();
            assert!(recording.save(&path).is_err(), "an existing file is kept");
            made.insert(recording.provenance().run_key.clone(), fs::read(&path).unwrap());
        }
    }
    assert_eq!(made.len(), written.len());
    for (name, bytes) in &written {
        let (key, same) = made.iter().find(|(_, made)| *made == bytes).unwrap();
        assert!(name.contains(&key[..8]), "{name} has the bytes of the run {key}, {}", same.len());
    }
}

#[test]
fn recordings_do_not_depend_on_the_number_of_threads() {
    let program = env!("CARGO_BIN_EXE_run-experiment");
    let with = |threads| {
        recordings_by(
            &mut || {
                let mut command = Command::new(program);
                command.args(["--threads", threads]);
                command
            },
            "1",
        )
    };
    let one = with("1");
    assert_same(&one, &with("2"), "two threads");
    assert_same(&one, &with("3"), "three threads");
}

#[test]
fn recordings_do_not_depend_on_time_zone_and_language() {
    let program = env!("CARGO_BIN_EXE_run-experiment");
    let here = recordings(Path::new(program), "2");
    let mut elsewhere = || {
        let mut command = Command::new(program);
        command.env("TZ", "Pacific/Chatham").env("LC_ALL", "da_DK.UTF-8").env("COLUMNS", "60");
        command
    };
    assert_same(&here, &recordings_by(&mut elsewhere, "2"), "another time zone");
}

#[test]
#[ignore = "needs root and setpriv, to become another user"]
fn recordings_do_not_depend_on_the_user() {
    // The copy is in a folder where every user may run it. Another process copies it, because a child that another test starts
    // at the same time would inherit the open file and keep it busy.
    let folder = tempfile::tempdir().unwrap();
    let program = folder.path().join("run-experiment");
    let copied =
        Command::new("cp").arg(env!("CARGO_BIN_EXE_run-experiment")).arg(&program).status();
    assert!(copied.unwrap().success());
    open_to_all(folder.path());
    let mine = recordings(&program, "2");
    let place = tempfile::tempdir().unwrap();
    open_to_all(place.path());
    let mut as_other_user = || {
        let mut command = Command::new("setpriv");
        command.args(["--reuid=65534", "--regid=65534", "--clear-groups"]).arg(&program);
        command
    };
    assert_same(&mine, &recordings_in(&mut as_other_user, "2", place.path()), "another user");
}

#[cfg(unix)]
fn open_to_all(path: &Path) {
    use std::os::unix::fs::PermissionsExt as _;
    fs::set_permissions(path, fs::Permissions::from_mode(0o777)).unwrap();
}

#[cfg(not(unix))]
fn open_to_all(_: &Path) {}

#[test]
#[ignore = "needs other builds of run-experiment; OTHER_BUILDS contains their paths, separated by colons"]
fn recordings_do_not_depend_on_the_build() {
    let reference = recordings(Path::new(env!("CARGO_BIN_EXE_run-experiment")), "2");
    let builds = std::env::var("OTHER_BUILDS").expect("OTHER_BUILDS must name the other builds");
    for build in builds.split(':') {
        assert_same(&reference, &recordings(Path::new(build), "2"), build);
    }
}
