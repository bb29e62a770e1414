//! Promise: the same manifest gives the same bytes. Each model's recording is made twice, with one and two runs side by
//! side, with one to three threads, in two folders, two time zones, by another user, and by other builds of the program where they are named; all
//! files are compared byte for byte.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::small_experiments::MANIFESTS;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;

/// The recordings that a program makes of all small experiments in two replicates, by file name.
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
    assert_eq!(files.len(), 2 * MANIFESTS.len(), "one recording a run");
    files
}

fn assert_same(one: &BTreeMap<String, Vec<u8>>, other: &BTreeMap<String, Vec<u8>>, who: &str) {
    assert!(one.keys().eq(other.keys()), "{who}: other files, hence other run keys");
    for (name, bytes) in one {
        assert!(bytes == &other[name], "{who}: {name} differs");
    }
}

#[test]
fn two_runs_and_any_number_of_jobs_give_the_same_bytes() {
    let program = Path::new(env!("CARGO_BIN_EXE_run-experiment"));
    let first = recordings(program, "1");
    assert_same(&first, &recordings(program, "1"), "a second run");
    assert_same(&first, &recordings(program, "2"), "two jobs");
    let bodies: Vec<&Vec<u8>> = first.values().collect();
    assert!(bodies.windows(2).all(|pair| pair[0] != pair[1]), "replicates and models must differ");
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
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
fn another_time_zone_and_language_give_the_same_bytes() {
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
fn another_user_gives_the_same_bytes() {
    // The copy is in a folder where every user may run it. Another process writes it: a child that another test starts meanwhile
    // would inherit the open copy and keep it busy.
    let folder = tempfile::tempdir().unwrap();
    let program = folder.path().join("run-experiment");
    let copied =
        Command::new("cp").arg(env!("CARGO_BIN_EXE_run-experiment")).arg(&program).status();
    assert!(copied.unwrap().success());
    open_to_all(folder.path());
    let mine = recordings(&program, "2");
    let place = tempfile::tempdir().unwrap();
    open_to_all(place.path());
    let mut nobody = || {
        let mut command = Command::new("setpriv");
        command.args(["--reuid=65534", "--regid=65534", "--clear-groups"]).arg(&program);
        command
    };
    assert_same(&mine, &recordings_in(&mut nobody, "2", place.path()), "another user");
}

#[cfg(unix)]
fn open_to_all(path: &Path) {
    use std::os::unix::fs::PermissionsExt as _;
    fs::set_permissions(path, fs::Permissions::from_mode(0o777)).unwrap();
}

#[cfg(not(unix))]
fn open_to_all(_: &Path) {}

#[test]
#[ignore = "needs other builds of run-experiment, their paths in OTHER_BUILDS, colons between"]
fn builds_with_and_without_optimization_give_the_same_bytes() {
    let reference = recordings(Path::new(env!("CARGO_BIN_EXE_run-experiment")), "2");
    let builds = std::env::var("OTHER_BUILDS").expect("OTHER_BUILDS names the other builds");
    for build in builds.split(':') {
        assert_same(&reference, &recordings(Path::new(build), "2"), build);
    }
}
