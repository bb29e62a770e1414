//! Guarantee: a sweep of which only the metrics are kept has the same bytes of `runs.parquet` whether this machine executes it or tasks, in any
//! order, killed, and more than once; a lost task costs its unfinished rows only.
//!
//! Control: a task of a changed manifest is rejected.

#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::slurm_cluster::{Cluster, kill, output_text, processes_about};
use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::thread::sleep;
use std::time::Duration;

/// Runs of some milliseconds.
const SWEEP: &str = "seed = 5\nreplicates = 120\n[model.gas]\nparticles = 200\nduration_s = 0.02\n[record]\nframes = 20\n\
    keep = \"metrics\"\n[sweep]\n\"model.gas.temperature_k\" = [200.0, 300.0]\n";

fn program(manifest: &Path, output: &Path) -> Command {
    let mut program = Command::new(env!("CARGO_BIN_EXE_run-experiment"));
    program.arg(manifest).arg("--output").arg(output);
    program
}

/// The table of one machine.
fn local(manifest: &Path, folder: &Path) -> Vec<u8> {
    let output = folder.join("local");
    assert!(program(manifest, &output).output().unwrap().status.success());
    fs::read(output.join("sweep/runs.parquet")).unwrap()
}

fn shell(line: &str) -> Output {
    Command::new("sh").args(["-c", line]).output().unwrap()
}

#[test]
fn exported_tasks_of_rows_give_the_table_of_one_machine() {
    let folder = tempfile::tempdir().unwrap();
    let manifest = folder.path().join("sweep.toml");
    fs::write(&manifest, SWEEP).unwrap();
    let local = local(&manifest, folder.path());
    let (output, list) = (folder.path().join("tasks"), folder.path().join("commands"));
    let mut export = program(&manifest, &output);
    export.args(["--runs-per-task", "10", "--export-commands"]).arg(&list);
    assert!(export.output().unwrap().status.success());
    let commands: Vec<String> =
        fs::read_to_string(&list).unwrap().lines().map(str::to_owned).collect();
    assert_eq!(commands.len(), 24);
    // Three tasks are killed, at other moments, and only two of them are repeated.
    for (at, command) in commands.iter().take(3).enumerate() {
        let mut task = Command::new("sh").args(["-c", &format!("exec {command}")]).spawn().unwrap();
        sleep(Duration::from_millis(5 + 20 * at as u64));
        task.kill().unwrap();
        task.wait().unwrap();
    }
    for command in commands[1..].iter().rev() {
        assert!(shell(command).status.success());
    }
    // A finished task has nothing to do.
    assert!(shell(&commands[7]).status.success());
    let table = output.join("sweep/runs.parquet");
    assert!(!table.exists());
    let again = program(&manifest, &output).output().unwrap();
    let said = String::from_utf8_lossy(&again.stdout).into_owned();
    assert!(again.status.success(), "{again:?}");
    // The rows that the killed task had synced may be among its ten.
    let to_do = said.split(" to do").next().unwrap().rsplit(' ').next().unwrap();
    assert!(to_do.parse::<u32>().unwrap() <= 10, "{said}");
    assert!(fs::read(&table).unwrap() == local, "the bytes differ");
    let left = fs::read_dir(output.join("sweep")).unwrap().count();
    assert_eq!(left, 2, "the table and experiment.toml");

    fs::write(&manifest, SWEEP.replace("seed = 5", "seed = 6")).unwrap();
    let other = shell(&commands[0]);
    assert_eq!(other.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&other.stderr).contains("no run has the key"));

    // The rows of that manifest's tasks are not dropped by the earlier one, whose table is finished.
    let mut export = program(&manifest, &folder.path().join("others"));
    export.args(["--runs-per-task", "10", "--export-commands"]).arg(&list);
    assert!(export.output().unwrap().status.success());
    let first = fs::read_to_string(&list).unwrap().lines().next().unwrap().to_owned();
    assert!(shell(&first.replace("others", "tasks")).status.success());
    fs::write(&manifest, SWEEP).unwrap();
    let rejected = program(&manifest, &output).output().unwrap();
    assert_eq!(rejected.status.code(), Some(2));
    let error = String::from_utf8_lossy(&rejected.stderr);
    assert!(error.contains("has the metrics of 10 runs that the manifest does not"), "{error}");
    assert!(fs::read(&table).unwrap() == local);
}

#[test]
#[ignore = "needs root, munge and Slurm, which .ci/full installs"]
fn killed_tasks_of_rows_on_slurm_give_the_table_of_one_machine() {
    let cluster = Cluster::start();
    let manifest = cluster.folder().join("sweep.toml");
    let longer = SWEEP.replace("particles = 200", "particles = 20000");
    fs::write(&manifest, longer.replace("replicates = 120", "replicates = 240")).unwrap();
    let local = local(&manifest, cluster.folder());
    let output = cluster.folder().join("clustered");
    let mut slurm = cluster.command(env!("CARGO_BIN_EXE_run-experiment"));
    slurm.arg(&manifest).arg("--output").arg(&output);
    slurm.args(["--executor", "slurm", "--runs-per-task", "20"]).stdout(Stdio::piped());
    let mut waiting = slurm.stderr(Stdio::piped()).spawn().unwrap();
    let tasks_folder = output.join("sweep/.tasks");
    for moment in 0..3 {
        sleep(Duration::from_millis(moment * 400));
        let mut caught = Vec::new();
        cluster.wait("a task", || {
            assert_eq!(waiting.try_wait().unwrap(), None, "the sweep ended undisturbed");
            cluster.resume_node();
            caught = processes_about(&tasks_folder);
            !caught.is_empty()
        });
        caught.into_iter().for_each(kill);
    }
    let ended = cluster.end_of(waiting, Cluster::resume_node);
    assert_eq!(ended.status.code(), Some(0), "{}", output_text(&ended));
    assert!(fs::read(output.join("sweep/runs.parquet")).unwrap() == local, "the bytes differ");
    println!("480 runs in 24 tasks, those of three moments killed: the same table");
}
