//! Guarantee: a sweep on HyperQueue gives the same recordings as the local machine, byte for byte, whichever process is killed: tasks and
//! workers by signal 9, the server, or the waiting program.
//!
//! Setup: a real HyperQueue on loopback. Control: without `hq`, the same command ends with exit code 75.

#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::recordings_in::recordings_in;
use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

/// Runs of a few tenths of a second.
const SWEEP: &str = "seed = 11\nreplicates = 60\n[model.dem]\ndiscs = 60\nwidth_m = 0.02\nheight_m = 0.02\n\
    duration_s = 0.9\n[record]\nframes = 40\n";

/// A server and two workers in a temporary folder, started and ended by process number.
struct Queue {
    folder: tempfile::TempDir,
    server: Child,
    workers: Vec<Child>,
}

impl Queue {
    fn start() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let server = Self::server(folder.path());
        let mut queue = Self { folder, server, workers: Vec::new() };
        queue.wait_for_server();
        queue.workers = vec![queue.worker(), queue.worker()];
        queue
    }

    fn server(folder: &Path) -> Child {
        hq(folder)
            .args(["server", "start", "--host", "127.0.0.1", "--journal-flush-period", "200ms"])
            .arg("--journal")
            .arg(folder.join("journal"))
            .stdout(Stdio::null())
            .spawn()
            .expect("hq must be on the PATH")
    }

    fn wait_for_server(&mut self) {
        let folder = self.folder.path();
        wait("the server answers", &mut self.server, || {
            let answer = hq(folder).args(["job", "list"]).output().unwrap();
            answer.status.success()
        });
    }

    fn worker(&self) -> Child {
        hq(self.folder.path())
            .args(["worker", "start", "--cpus", "1", "--on-server-lost", "finish-running"])
            .stdout(Stdio::null())
            .spawn()
            .unwrap()
    }

    /// Kills a worker, whose task continues without a parent process, and starts another one.
    fn kill_a_worker(&mut self) {
        let mut worker = self.workers.remove(0);
        worker.kill().unwrap();
        worker.wait().unwrap();
        self.workers.push(self.worker());
    }

    /// Kills the server and starts it again from its journal; workers that lost it are replaced.
    fn restart_server(&mut self) {
        self.server.kill().unwrap();
        self.server.wait().unwrap();
        self.server = Self::server(self.folder.path());
        self.wait_for_server();
        self.workers.extend([self.worker(), self.worker()]);
    }
}

impl Drop for Queue {
    fn drop(&mut self) {
        for child in self.workers.iter_mut().chain([&mut self.server]) {
            let _ = child.kill();
            let _ = child.wait();
        }
        programs_about(self.folder.path()).into_iter().for_each(kill);
    }
}

fn hq(folder: &Path) -> Command {
    let mut command = Command::new("hq");
    command.env("HQ_SERVER_DIR", folder.join("server")).stderr(Stdio::null());
    command
}

/// Waits until a process has brought about a condition.
fn wait(condition: &str, process: &mut Child, mut holds: impl FnMut() -> bool) {
    while !holds() {
        assert_eq!(process.try_wait().unwrap(), None, "ended before {condition}");
        sleep(Duration::from_millis(50));
    }
}

fn kill(process: u32) {
    let _ = Command::new("kill").args(["-9", &process.to_string()]).output();
}

/// The tasks: processes of this program whose command line names a folder of this test.
fn programs_about(folder: &Path) -> Vec<u32> {
    let name = folder.display().to_string();
    let entries = fs::read_dir("/proc").unwrap();
    entries
        .filter_map(|entry| entry.ok()?.file_name().to_str()?.parse().ok())
        .filter(|process| {
            fs::read(format!("/proc/{process}/cmdline")).is_ok_and(|line| {
                line.starts_with(env!("CARGO_BIN_EXE_run-experiment").as_bytes())
                    && String::from_utf8_lossy(&line).contains(&name)
            })
        })
        .collect()
}

fn program(manifest: &Path, output: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_run-experiment"));
    command.arg(manifest).arg("--output").arg(output);
    command
}

fn on_hyperqueue(queue: &Queue, manifest: &Path, output: &Path) -> Child {
    program(manifest, output)
        .args(["--executor", "hyperqueue", "--runs-per-task", "2", "--checkpoint-every", "0.1"])
        .env("HQ_SERVER_DIR", queue.folder.path().join("server"))
        .stdout(Stdio::piped())
        .spawn()
        .unwrap()
}

#[test]
#[ignore = "needs HyperQueue's hq on the PATH, which no package registry offers: CONTRIBUTING.md"]
fn full_harness_killed_processes_of_hyperqueue_lose_no_run() {
    let mut queue = Queue::start();
    let manifest = queue.folder.path().join("sweep.toml");
    fs::write(&manifest, SWEEP).unwrap();
    let local = queue.folder.path().join("local");
    assert!(program(&manifest, &local).arg("--quiet").status().unwrap().success());
    let local = recordings_in(&local.join("sweep"));

    let output = queue.folder.path().join("queued");
    let tasks_folder = output.join("sweep/.tasks");
    let mut waiting = on_hyperqueue(&queue, &manifest, &output);
    let mut killed = 0;
    for moment in 0..6_u64 {
        sleep(Duration::from_millis(moment * 7919 % 700));
        let mut caught = Vec::new();
        wait("a task runs", &mut waiting, || {
            caught = programs_about(&tasks_folder);
            !caught.is_empty()
        });
        match moment {
            1 | 4 => queue.kill_a_worker(),
            _ => {
                killed += caught.len();
                caught.into_iter().for_each(kill);
            }
        }
    }
    // The waiting program is interrupted; the submitted tasks continue.
    Command::new("kill").args(["-INT", &waiting.id().to_string()]).status().unwrap();
    let left = waiting.wait_with_output().unwrap();
    assert_eq!(left.status.code(), Some(130));
    assert!(String::from_utf8_lossy(&left.stdout).contains("still on the cluster"));

    let mut waiting = on_hyperqueue(&queue, &manifest, &output);
    wait("a task runs", &mut waiting, || !programs_about(&tasks_folder).is_empty());
    queue.restart_server();
    let ended = waiting.wait_with_output().unwrap();
    assert_eq!(ended.status.code(), Some(0), "{}", String::from_utf8_lossy(&ended.stdout));
    let queued = recordings_in(&output.join("sweep"));
    assert_eq!(local.len(), 60);
    assert!(local == queued, "the recordings or their bytes differ");
    println!(
        "60 runs, {killed} tasks and 2 workers killed, the server restarted, one detachment: byte-identical"
    );
    let again = on_hyperqueue(&queue, &manifest, &output).wait_with_output().unwrap();
    assert_eq!(again.status.code(), Some(0));
}

#[test]
fn control_missing_hyperqueue_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let manifest = folder.path().join("sweep.toml");
    fs::write(&manifest, SWEEP).unwrap();
    let output = program(&manifest, folder.path())
        .args(["--executor", "hyperqueue"])
        .env("PATH", folder.path())
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(75));
    assert!(String::from_utf8_lossy(&output.stderr).contains("hq: "));
}
