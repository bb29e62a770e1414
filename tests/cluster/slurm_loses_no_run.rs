//! Guarantee: a sweep on Slurm gives the same recordings as the local machine, byte for byte, whichever process is killed: tasks by
//! signal 9, a requeued task, the controller, or the waiting program. Tasks that Slurm holds are named while others run. When only held
//! tasks remain, the command ends with exit code 75, loses no run, and resumes after the tasks are released.
//!
//! Setup: a real Slurm on loopback. Control: without the daemons of the cluster, the same command ends with exit code 75.

#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::recordings_in::recordings_in;
use crate::slurm_cluster::{Cluster, kill, output_text, processes_about};
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Runs of a few tenths of a second.
const SWEEP: &str = "seed = 11\nreplicates = 24\n[model.dem]\ndiscs = 60\nwidth_m = 0.02\nheight_m = 0.02\n\
    duration_s = 0.9\n[record]\nframes = 40\n";

fn on_slurm(cluster: &Cluster, manifest: &Path, output: &Path) -> Child {
    let warnings = File::create(cluster.folder().join("warnings")).unwrap();
    cluster
        .command(env!("CARGO_BIN_EXE_run-experiment"))
        .arg(manifest)
        .arg("--output")
        .arg(output)
        .args(["--executor", "slurm", "--runs-per-task", "2", "--checkpoint-every", "0.1"])
        .stdout(Stdio::piped())
        .stderr(warnings)
        .spawn()
        .unwrap()
}

/// The standard error of the last command on Slurm so far.
fn warnings(cluster: &Cluster) -> String {
    fs::read_to_string(cluster.folder().join("warnings")).unwrap()
}

/// Executes the sweep on this machine only; returns the recordings and the time in seconds.
fn local(cluster: &Cluster, manifest: &Path) -> (BTreeMap<String, Vec<u8>>, f64) {
    let output = cluster.folder().join("local");
    let started = Instant::now();
    let status = Command::new(env!("CARGO_BIN_EXE_run-experiment"))
        .arg(manifest)
        .args(["--quiet", "--output"])
        .arg(&output)
        .status()
        .unwrap();
    assert!(status.success());
    let seconds = started.elapsed().as_secs_f64();
    (recordings_in(&output.join("sweep")), seconds)
}

/// Executes replicates on Slurm with disturbances: in turn, tasks are killed and requeued.
fn disturbed(replicates: usize, moments: u64) {
    let mut cluster = Cluster::start();
    let manifest = cluster.folder().join("sweep.toml");
    fs::write(&manifest, SWEEP.replace("24", &replicates.to_string())).unwrap();
    let (local, _) = local(&cluster, &manifest);

    let output = cluster.folder().join("clustered");
    let mut waiting = on_slurm(&cluster, &manifest, &output);
    let tasks_folder = output.join("sweep/.tasks");
    let tasks = || {
        let mine = processes_about(&tasks_folder);
        mine.into_iter().filter(|process| is_program(*process)).collect::<Vec<u32>>()
    };
    let (mut killed, mut requeued) = (0, 0);
    for moment in 0..moments {
        sleep(Duration::from_millis(moment * 7919 % 1000));
        let mut caught = Vec::new();
        cluster.wait("a task", || {
            assert_eq!(waiting.try_wait().unwrap(), None, "the sweep ended undisturbed");
            cluster.resume_node();
            caught = tasks();
            !caught.is_empty()
        });
        if moment % 2 == 0 {
            for task in caught {
                kill(task);
                killed += 1;
            }
        } else {
            for job in cluster.running() {
                let requeue = cluster.command("scontrol").args(["requeue", &job]).output();
                requeued += u32::from(requeue.unwrap().status.success());
            }
        }
    }
    assert!(killed >= moments / 2 && requeued > 0, "{killed} {requeued}");

    // The waiting program is interrupted; the submitted tasks continue.
    interrupt(&waiting);
    let left = cluster.end_of(waiting, |_| {});
    assert_eq!(left.status.code(), Some(130), "{}", warnings(&cluster));
    assert!(output_text(&left).contains("still on the cluster"), "{}", output_text(&left));

    let waiting = on_slurm(&cluster, &manifest, &output);
    cluster.wait("a running task", || {
        cluster.resume_node();
        !cluster.running().is_empty()
    });
    cluster.restart_controller();
    let mut ended = cluster.end_of(waiting, Cluster::resume_node);
    if ended.status.code() == Some(75) {
        // Only tasks remained that Slurm held because they were requeued during their launch; they are released by now.
        let again = on_slurm(&cluster, &manifest, &output);
        ended = cluster.end_of(again, Cluster::resume_node);
    }
    assert_eq!(ended.status.code(), Some(0), "{}{}", output_text(&ended), warnings(&cluster));

    let clustered = recordings_in(&output.join("sweep"));
    assert_eq!(local.len(), replicates);
    assert_eq!(local.keys().collect::<Vec<_>>(), clustered.keys().collect::<Vec<_>>());
    assert!(local == clustered, "the bytes differ");
    println!(
        "{replicates} runs, {killed} tasks killed, {requeued} requeued, the controller restarted, \
         one detachment: byte-identical"
    );
    let nothing_left = cluster.end_of(on_slurm(&cluster, &manifest, &output), |_| {});
    assert_eq!(nothing_left.status.code(), Some(0));
}

#[test]
#[ignore = "needs root, munge and Slurm, which .ci/full installs"]
fn killed_and_requeued_tasks_and_a_restarted_controller_lose_no_run() {
    disturbed(24, 4);
}

#[test]
#[ignore = "as above"]
fn held_tasks_are_named_and_resume_when_released() {
    let cluster = Cluster::start();
    let manifest = cluster.folder().join("sweep.toml");
    fs::write(&manifest, SWEEP).unwrap();
    let (local, _) = local(&cluster, &manifest);
    let output = cluster.folder().join("clustered");
    let hold = |how: &str, task: &str| {
        let held = cluster.command("scontrol").args([how, task]).status();
        assert!(held.unwrap().success());
    };

    // No task starts on a drained node. This state is temporary and must not cause a warning.
    cluster.set_node("DRAIN");
    let waiting = on_slurm(&cluster, &manifest, &output);
    // Twelve tasks in job arrays of at most nine.
    cluster.wait("two job arrays", || cluster.job_arrays().len() == 2);
    let arrays: Vec<String> = cluster.job_arrays().into_iter().collect();
    let (first, second) = (&arrays[0], &arrays[1]);
    hold("hold", &format!("{first}_0"));
    hold("uhold", &format!("{second}_0"));
    let both = format!(
        "Slurm holds back 2 tasks (JobHeldAdmin, JobHeldUser). `scontrol release {first} {second}`"
    );
    cluster.wait("a warning that names both", || warnings(&cluster).contains(&both));

    // A task that is released while the command waits resumes. Then only the other one remains.
    hold("release", &format!("{second}_0"));
    cluster.set_node("RESUME");
    let ended = cluster.end_of(waiting, |_| {});
    assert_eq!(ended.status.code(), Some(75), "{}{}", output_text(&ended), warnings(&cluster));
    assert!(output_text(&ended).contains("22 new recordings"), "{}", output_text(&ended));
    assert!(output_text(&ended).contains("2 runs still on the cluster"), "{}", output_text(&ended));

    // The same command submits no task in addition to the held one, and it prints the command that releases it.
    let again = cluster.end_of(on_slurm(&cluster, &manifest, &output), |_| {});
    assert_eq!(again.status.code(), Some(75), "{}{}", output_text(&again), warnings(&cluster));
    assert_eq!(cluster.job_arrays().into_iter().collect::<Vec<_>>(), [first.as_str()]);
    let warning = warnings(&cluster);
    assert!(warning.contains("holds back 1 task (JobHeldAdmin)"), "{warning}");
    let release_command = warning.split('`').nth(1).unwrap();
    let mut words = release_command.split(' ');
    // Slurm reports an error because other tasks of the array have ended, but it releases the held one.
    cluster.command(words.next().unwrap()).args(words).output().unwrap();

    let done = cluster.end_of(on_slurm(&cluster, &manifest, &output), |_| {});
    assert_eq!(done.status.code(), Some(0), "{}{}", output_text(&done), warnings(&cluster));
    assert!(local == recordings_in(&output.join("sweep")), "the bytes differ");
    println!("24 runs, two tasks held and released: byte-identical");
}

#[test]
#[ignore = "as above, and takes minutes: CONTRIBUTING.md"]
fn full_harness_two_hundred_disturbed_runs_are_complete() {
    disturbed(200, 10);
}

#[test]
#[ignore = "as above; a measurement without a limit"]
fn full_harness_measures_the_overhead_of_slurm() {
    let cluster = Cluster::start();
    let manifest = cluster.folder().join("sweep.toml");
    // Runs of about two seconds in a release build, in four tasks on two processors.
    fs::write(&manifest, SWEEP.replace("24", "32").replace("0.9\n", "40.0\n")).unwrap();
    let (local, local_s) = local(&cluster, &manifest);
    let output = cluster.folder().join("clustered");
    let started = Instant::now();
    let mut slurm = cluster.command(env!("CARGO_BIN_EXE_run-experiment"));
    slurm.arg(&manifest).arg("--output").arg(&output);
    slurm.args(["--executor", "slurm", "--runs-per-task", "8", "--quiet"]);
    assert!(slurm.status().unwrap().success());
    let slurm_s = started.elapsed().as_secs_f64();
    assert!(local == recordings_in(&output.join("sweep")));
    println!(
        "32 runs: local {local_s:.1} s, through Slurm {slurm_s:.1} s, {:.3}",
        slurm_s / local_s
    );
}

#[test]
fn control_missing_cluster_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let manifest = folder.path().join("sweep.toml");
    fs::write(&manifest, SWEEP).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_run-experiment"))
        .arg(&manifest)
        .args(["--executor", "slurm", "--output"])
        .arg(folder.path())
        .env("PATH", folder.path())
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(75));
    assert!(String::from_utf8_lossy(&output.stderr).contains("squeue"));
}

fn is_program(process: u32) -> bool {
    fs::read(format!("/proc/{process}/cmdline"))
        .is_ok_and(|line| line.starts_with(env!("CARGO_BIN_EXE_run-experiment").as_bytes()))
}

fn interrupt(child: &Child) {
    Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
}
