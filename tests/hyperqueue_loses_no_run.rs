//! Promise: a sweep on HyperQueue gives the recordings that this machine alone gives, byte for byte, whatever is killed: tasks
//! and workers by signal 9, the server, and the program that waits.
//!
//! The HyperQueue is a real one, on loopback. Control: without `hq` the same command ends with exit code 75.

#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod recordings_in;

use recordings_in::recordings_in;
use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Runs of some tenths of a second.
const SWEEP: &str = "seed = 11\nreplicates = 60\n[model.dem]\ndiscs = 60\nwidth_m = 0.02\nheight_m = 0.02\n\
    duration_s = 0.9\n[record]\nframes = 40\n";

/// A server and two workers in a temporary folder: started here and ended here, by process number.
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
            .expect("hq is on the PATH")
    }

    fn wait_for_server(&self) {
        wait("the server", || {
            let answer = hq(self.folder.path()).args(["job", "list"]).output().unwrap();
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

    /// Kills a worker, whose task lives on as nobody's child, and starts another one.
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

fn wait(what: &str, mut is_so: impl FnMut() -> bool) {
    let started = Instant::now();
    while !is_so() {
        assert!(started.elapsed() < Duration::from_secs(60), "waited a minute for {what}");
        sleep(Duration::from_millis(50));
    }
}

fn kill(process: u32) {
    let _ = Command::new("kill").args(["-9", &process.to_string()]).output();
}

/// Tasks: processes of this program whose command line names a folder of this test.
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
#[ignore = "needs HyperQueue's hq on the PATH, which no registry of packages has: CONTRIBUTING.md"]
fn full_harness_of_hyperqueue() {
    let mut queue = Queue::start();
    let manifest = queue.folder.path().join("sweep.toml");
    fs::write(&manifest, SWEEP).unwrap();
    let alone = queue.folder.path().join("alone");
    assert!(program(&manifest, &alone).arg("--quiet").status().unwrap().success());
    let alone = recordings_in(&alone.join("sweep"));

    let output = queue.folder.path().join("queued");
    let tasks_folder = output.join("sweep/.tasks");
    let waiting = on_hyperqueue(&queue, &manifest, &output);
    let mut killed = 0;
    for moment in 0..6_u64 {
        sleep(Duration::from_millis(moment * 7919 % 700));
        let mut caught = Vec::new();
        wait("a task", || {
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
    // The one who waits leaves; what is submitted goes on.
    Command::new("kill").args(["-INT", &waiting.id().to_string()]).status().unwrap();
    let left = waiting.wait_with_output().unwrap();
    assert_eq!(left.status.code(), Some(130));
    assert!(String::from_utf8_lossy(&left.stdout).contains("still on the cluster"));

    let waiting = on_hyperqueue(&queue, &manifest, &output);
    wait("a task", || !programs_about(&tasks_folder).is_empty());
    queue.restart_server();
    let ended = waiting.wait_with_output().unwrap();
    assert_eq!(ended.status.code(), Some(0), "{}", String::from_utf8_lossy(&ended.stdout));
    let queued = recordings_in(&output.join("sweep"));
    assert_eq!(alone.len(), 60);
    assert!(alone == queued, "other bytes, or other recordings");
    println!(
        "60 runs, {killed} tasks and 2 workers killed, the server restarted, one detachment: equal in every byte"
    );
    let again = on_hyperqueue(&queue, &manifest, &output).wait_with_output().unwrap();
    assert_eq!(again.status.code(), Some(0));
}

#[test]
fn without_hyperqueue_the_command_says_so() {
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
