//! Promise: a sweep on Slurm gives the recordings that this machine alone gives, byte for byte, whatever is killed: tasks by
//! signal 9, a requeued task, the controller, and the program that waits.
//!
//! And it is not waited for ever and in silence for tasks that Slurm holds back: they are named while others go on, and when
//! they are all that is left, the command ends with exit code 75, loses nothing, and goes on when they are released.
//!
//! The Slurm is a real one, on loopback. Control: without the cluster's daemons the same command ends with exit code 75.

#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod recordings_in;
mod slurm_cluster;

use recordings_in::recordings_in;
use slurm_cluster::{Cluster, kill, processes_about, said};
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Runs of some tenths of a second.
const SWEEP: &str = "seed = 11\nreplicates = 24\n[model.dem]\ndiscs = 60\nwidth_m = 0.02\nheight_m = 0.02\n\
    duration_s = 0.9\n[record]\nframes = 40\n";
/// For what takes seconds.
const MINUTE: Duration = Duration::from_secs(60);

fn on_slurm(cluster: &Cluster, manifest: &Path, output: &Path) -> Child {
    let complaints = File::create(cluster.folder().join("complaints")).unwrap();
    cluster
        .command(env!("CARGO_BIN_EXE_run-experiment"))
        .arg(manifest)
        .arg("--output")
        .arg(output)
        .args(["--executor", "slurm", "--runs-per-task", "2", "--checkpoint-every", "0.1"])
        .stdout(Stdio::piped())
        .stderr(complaints)
        .spawn()
        .unwrap()
}

/// What the last command on Slurm has said on its standard error so far.
fn complaints(cluster: &Cluster) -> String {
    fs::read_to_string(cluster.folder().join("complaints")).unwrap()
}

/// Runs the sweep on this machine alone, and returns its recordings and the seconds that it took.
fn alone(cluster: &Cluster, manifest: &Path) -> (BTreeMap<String, Vec<u8>>, f64) {
    let output = cluster.folder().join("alone");
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

/// So many replicates on Slurm, disturbed at so many moments: tasks are killed and, at every other moment, requeued.
fn disturbed(replicates: usize, moments: u64) {
    let mut cluster = Cluster::start();
    let manifest = cluster.folder().join("sweep.toml");
    fs::write(&manifest, SWEEP.replace("24", &replicates.to_string())).unwrap();
    let (alone, _) = alone(&cluster, &manifest);

    let output = cluster.folder().join("clustered");
    let waiting = on_slurm(&cluster, &manifest, &output);
    let tasks_folder = output.join("sweep/.tasks");
    let tasks = || {
        let mine = processes_about(&tasks_folder);
        mine.into_iter().filter(|process| is_program(*process)).collect::<Vec<u32>>()
    };
    let (mut killed, mut requeued) = (0, 0);
    for moment in 0..moments {
        sleep(Duration::from_millis(moment * 7919 % 1000));
        let mut caught = Vec::new();
        cluster.wait("a task", MINUTE, || {
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

    // The one who waits leaves; what is submitted goes on.
    interrupt(&waiting);
    let left = cluster.end_of(waiting, MINUTE, |_| {});
    assert_eq!(left.status.code(), Some(130), "{}", complaints(&cluster));
    assert!(said(&left).contains("still on the cluster"), "{}", said(&left));

    let waiting = on_slurm(&cluster, &manifest, &output);
    cluster.wait("a running task", MINUTE, || {
        cluster.resume_node();
        !cluster.running().is_empty()
    });
    cluster.restart_controller();
    let longest = MINUTE * 10;
    let mut ended = cluster.end_of(waiting, longest, Cluster::resume_node);
    if ended.status.code() == Some(75) {
        // Tasks that Slurm held back since their launch met a requeue were all that was left: by now they are released.
        let again = on_slurm(&cluster, &manifest, &output);
        ended = cluster.end_of(again, longest, Cluster::resume_node);
    }
    assert_eq!(ended.status.code(), Some(0), "{}{}", said(&ended), complaints(&cluster));

    let clustered = recordings_in(&output.join("sweep"));
    assert_eq!(alone.len(), replicates);
    assert_eq!(alone.keys().collect::<Vec<_>>(), clustered.keys().collect::<Vec<_>>());
    assert!(alone == clustered, "other bytes");
    println!(
        "{replicates} runs, {killed} tasks killed, {requeued} requeued, the controller restarted, \
         one detachment: equal in every byte"
    );
    let nothing_left = cluster.end_of(on_slurm(&cluster, &manifest, &output), MINUTE, |_| {});
    assert_eq!(nothing_left.status.code(), Some(0));
}

#[test]
#[ignore = "needs root, munge and Slurm, which .ci/run installs"]
fn killed_tasks_requeues_and_a_restarted_controller_lose_no_run() {
    disturbed(24, 4);
}

#[test]
#[ignore = "as above"]
fn held_tasks_are_named_and_go_on_when_released() {
    let cluster = Cluster::start();
    let manifest = cluster.folder().join("sweep.toml");
    fs::write(&manifest, SWEEP).unwrap();
    let (alone, _) = alone(&cluster, &manifest);
    let output = cluster.folder().join("clustered");
    let hold = |how: &str, task: &str| {
        let held = cluster.command("scontrol").args([how, task]).status();
        assert!(held.unwrap().success());
    };

    // Nothing starts on a drained node: that passes, and is no reason to complain.
    cluster.set_node("DRAIN");
    let waiting = on_slurm(&cluster, &manifest, &output);
    // Twelve tasks in job arrays of nine at most.
    cluster.wait("two job arrays", MINUTE, || cluster.job_arrays().len() == 2);
    let arrays: Vec<String> = cluster.job_arrays().into_iter().collect();
    let (first, second) = (&arrays[0], &arrays[1]);
    hold("hold", &format!("{first}_0"));
    hold("uhold", &format!("{second}_0"));
    let both = format!(
        "Slurm holds back 2 tasks (JobHeldAdmin, JobHeldUser). `scontrol release {first} {second}`"
    );
    cluster.wait("a word on both", MINUTE, || complaints(&cluster).contains(&both));

    // Released while the command waits, a task goes on. The other one is then all that is left.
    hold("release", &format!("{second}_0"));
    cluster.set_node("RESUME");
    let ended = cluster.end_of(waiting, MINUTE * 2, |_| {});
    assert_eq!(ended.status.code(), Some(75), "{}{}", said(&ended), complaints(&cluster));
    assert!(said(&ended).contains("22 new recordings"), "{}", said(&ended));
    assert!(said(&ended).contains("2 runs still on the cluster"), "{}", said(&ended));

    // The same command submits nothing beside the held task, and says what to type.
    let again = cluster.end_of(on_slurm(&cluster, &manifest, &output), MINUTE, |_| {});
    assert_eq!(again.status.code(), Some(75), "{}{}", said(&again), complaints(&cluster));
    assert_eq!(cluster.job_arrays().into_iter().collect::<Vec<_>>(), [first.as_str()]);
    let complaint = complaints(&cluster);
    assert!(complaint.contains("holds back 1 task (JobHeldAdmin)"), "{complaint}");
    let typed = complaint.split('`').nth(1).unwrap();
    let mut words = typed.split(' ');
    // Slurm minds that other tasks of the array have ended, and releases the held one.
    cluster.command(words.next().unwrap()).args(words).output().unwrap();

    let done = cluster.end_of(on_slurm(&cluster, &manifest, &output), MINUTE, |_| {});
    assert_eq!(done.status.code(), Some(0), "{}{}", said(&done), complaints(&cluster));
    assert!(alone == recordings_in(&output.join("sweep")), "other bytes");
    println!("24 runs, two tasks held and released: equal in every byte");
}

#[test]
#[ignore = "as above, and takes minutes: CONTRIBUTING.md"]
fn full_harness_of_two_hundred_runs() {
    disturbed(200, 10);
}

#[test]
#[ignore = "as above: a measurement, which asserts no time"]
fn full_harness_measures_what_slurm_costs() {
    let cluster = Cluster::start();
    let manifest = cluster.folder().join("sweep.toml");
    // Runs of about two seconds in a release build, in four tasks on two processors.
    fs::write(&manifest, SWEEP.replace("24", "32").replace("0.9\n", "40.0\n")).unwrap();
    let (alone, alone_s) = alone(&cluster, &manifest);
    let output = cluster.folder().join("clustered");
    let started = Instant::now();
    let mut slurm = cluster.command(env!("CARGO_BIN_EXE_run-experiment"));
    slurm.arg(&manifest).arg("--output").arg(&output);
    slurm.args(["--executor", "slurm", "--runs-per-task", "8", "--quiet"]);
    assert!(slurm.status().unwrap().success());
    let slurm_s = started.elapsed().as_secs_f64();
    assert!(alone == recordings_in(&output.join("sweep")));
    println!(
        "32 runs: alone {alone_s:.1} s, through Slurm {slurm_s:.1} s, {:.3}",
        slurm_s / alone_s
    );
}

#[test]
fn without_a_cluster_the_command_says_so() {
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
