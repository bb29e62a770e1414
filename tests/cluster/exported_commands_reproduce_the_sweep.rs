//! Guarantee: the commands of `--export-commands` give the same bytes as the program itself, in any order, in parallel, and if a command
//! is executed more than once. A key that no run has is an error.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::recordings_in::recordings_in;
use std::fs;
use std::process::Command;

const SWEEP: &str = "seed = 11\nreplicates = 3\n[model.gas]\nparticles = 20\nduration_s = 0.001\n[record]\nframes = 4\n\
    [sweep]\n\"model.gas.temperature_k\" = [200.0, 300.0]\n";

fn program() -> Command {
    Command::new(env!("CARGO_BIN_EXE_run-experiment"))
}

#[test]
#[cfg(unix)]
fn exported_commands_reproduce_the_sweep() {
    let folder = tempfile::tempdir().unwrap();
    // The name contains characters that a shell must not interpret.
    let workspace = folder.path().join("it's a $place");
    fs::create_dir(&workspace).unwrap();
    let (manifest, list) = (workspace.join("sweep.toml"), workspace.join("commands"));
    fs::write(&manifest, SWEEP).unwrap();
    let set = ["--set", "model.gas.particles=25"];
    let mut local = program();
    local.arg(&manifest).args(set).arg("--output").arg(workspace.join("local"));
    assert!(local.output().unwrap().status.success());

    let mut export = program();
    export.arg(&manifest).args(set).arg("--output").arg(workspace.join("listed"));
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
    // If a run is executed twice at the same time, one of the two exits with 75 (retry later), and xargs with 123.
    assert!(matches!(parallel.status.code(), Some(0 | 123)), "{parallel:?}");
    let (local, listed) = (
        recordings_in(&workspace.join("local/sweep")),
        recordings_in(&workspace.join("listed/sweep")),
    );
    assert_eq!(local.len(), 6);
    assert!(local == listed, "{:?}", listed.keys());
    assert!(workspace.join("listed/sweep/experiment.toml").exists());
}

#[test]
fn unknown_key_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let manifest = folder.path().join("sweep.toml");
    fs::write(&manifest, SWEEP).unwrap();
    let output = program().arg(&manifest).args(["--only-keys", "0123"]).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("no run has the key 0123"));
}

/// `sh` would execute the second line of such a word as a command of its own, and other bytes than UTF-8 would be replaced.
#[test]
#[cfg(unix)]
fn words_that_no_line_can_contain_are_rejected() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt as _;
    let folder = tempfile::tempdir().unwrap();
    let list = folder.path().join("commands");
    let export = |workspace: &[u8], set: &str| {
        let workspace = folder.path().join(OsStr::from_bytes(workspace));
        fs::create_dir_all(&workspace).unwrap();
        let manifest = workspace.join("sweep.toml");
        fs::write(&manifest, SWEEP).unwrap();
        let mut export = program();
        export.arg(&manifest).args(["--set", set]).arg("--output").arg(workspace.join("listed"));
        export.arg("--export-commands").arg(&list).output().unwrap()
    };
    let description = |text: &str| format!("description=\"\"\"{text}\"\"\"");
    for (workspace, set) in [
        (b"a\ntouch injected\n" as &[u8], description("a")),
        (b"b", description("b\ntouch injected\n")),
        (b"c\xff", description("c")),
    ] {
        let output = export(workspace, &set);
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert!(error.contains("control character or is not UTF-8\nhelp: rename"), "{error}");
        assert!(!list.exists(), "no commands are written");
    }
    assert_eq!(export(b"d", &description("d")).status.code(), Some(0));
}
