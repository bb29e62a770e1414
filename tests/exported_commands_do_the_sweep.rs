//! Promise: the commands of `--export-commands` do the runs that the program itself does, to the same bytes, in any order,
//! side by side and more than once; a key that no run has is an error.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod recordings_in;

use recordings_in::recordings_in;
use std::fs;
use std::process::Command;

const SWEEP: &str = "seed = 11\nreplicates = 3\n[model.gas]\nparticles = 20\nduration_s = 0.001\n[record]\nframes = 4\n\
    [sweep]\n\"model.gas.temperature_k\" = [200.0, 300.0]\n";

fn program() -> Command {
    Command::new(env!("CARGO_BIN_EXE_run-experiment"))
}

#[test]
#[cfg(unix)]
fn commands_do_the_sweep() {
    let folder = tempfile::tempdir().unwrap();
    // A shell must not trip over it.
    let place = folder.path().join("it's a $place");
    fs::create_dir(&place).unwrap();
    let (manifest, list) = (place.join("sweep.toml"), place.join("commands"));
    fs::write(&manifest, SWEEP).unwrap();
    let set = ["--set", "model.gas.particles=25"];
    let mut alone = program();
    alone.arg(&manifest).args(set).arg("--output").arg(place.join("alone"));
    assert!(alone.output().unwrap().status.success());

    let mut export = program();
    export.arg(&manifest).args(set).arg("--output").arg(place.join("listed"));
    assert!(export.arg("--export-commands").arg(&list).output().unwrap().status.success());
    let commands = fs::read_to_string(&list).unwrap();
    assert_eq!(commands.lines().count(), 6);
    let twice: String =
        commands.lines().rev().chain(commands.lines()).map(|l| format!("{l}\n")).collect();
    fs::write(&list, twice).unwrap();
    let parallel = Command::new("sh")
        .args(["-c", r#"tr '\n' '\0' < "$0" | xargs -0 -P 3 -n 1 sh -c"#])
        .arg(&list)
        .output()
        .unwrap();
    // The same run twice at the same time: one of them is told to come back later (75), for xargs 123.
    assert!(matches!(parallel.status.code(), Some(0 | 123)), "{parallel:?}");
    let (alone, listed) =
        (recordings_in(&place.join("alone/sweep")), recordings_in(&place.join("listed/sweep")));
    assert_eq!(alone.len(), 6);
    assert!(alone == listed, "{:?}", listed.keys());
    assert!(place.join("listed/sweep/experiment.toml").exists());
}

#[test]
fn an_unknown_key_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let manifest = folder.path().join("sweep.toml");
    fs::write(&manifest, SWEEP).unwrap();
    let output = program().arg(&manifest).args(["--only-keys", "0123"]).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("no run has the key 0123"));
}
