//! Promise: no run is lost. Whatever goes wrong from outside, the folder holds the whole recording or a partial one that the
//! same command continues to the same bytes, and the message and the exit code say which.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Three chunks of frames, a tenth of a second.
const SHORT: &str =
    "seed = 1\n[model.gas]\nparticles = 500\nduration_s = 0.02\n[record]\nframes = 80\n";
/// Tens of chunks, about a second.
const MEDIUM: &str =
    "seed = 1\n[model.gas]\nparticles = 500\nduration_s = 0.2\n[record]\nframes = 1600\n";
/// Half a minute: never waited for.
const LONG: &str =
    "seed = 2\n[model.dem]\ndiscs = 1000\nduration_s = 10.0\n[record]\nframes = 2000\n";
/// Exit code of what may succeed later, by the help text.
const RETRYABLE: i32 = 75;

struct Place {
    folder: tempfile::TempDir,
    manifest: PathBuf,
}

impl Place {
    fn new(manifest: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.toml");
        fs::write(&path, manifest).unwrap();
        Self { folder, manifest: path }
    }

    fn output(&self) -> PathBuf {
        self.folder.path().join("recordings")
    }

    fn files(&self) -> Vec<PathBuf> {
        let Ok(entries) = fs::read_dir(self.output().join("run")) else { return Vec::new() };
        let mut files: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
        files.sort();
        files
    }

    fn recording(&self) -> Option<PathBuf> {
        let is_whole = |path: &PathBuf| {
            let name = path.to_string_lossy();
            name.ends_with(".mcap") && !name.ends_with(".partial.mcap")
        };
        self.files().into_iter().find(is_whole)
    }

    /// The program and its arguments, with a checkpoint wherever there can be one.
    fn arguments(&self) -> Vec<String> {
        let text = |path: &Path| path.to_string_lossy().into_owned();
        vec![
            env!("CARGO_BIN_EXE_run-experiment").to_owned(),
            "--checkpoint-every".to_owned(),
            "0".to_owned(),
            "--output".to_owned(),
            text(&self.output()),
            text(&self.manifest),
        ]
    }

    fn run(&self) -> Output {
        let arguments = self.arguments();
        Command::new(&arguments[0]).args(&arguments[1..]).output().unwrap()
    }

    fn spawn(&self) -> Child {
        let arguments = self.arguments();
        let mut command = Command::new(&arguments[0]);
        command.args(&arguments[1..]).stdout(Stdio::null()).stderr(Stdio::piped());
        command.spawn().unwrap()
    }

    fn wait_for_checkpoint(&self) {
        let started = Instant::now();
        while !self
            .files()
            .iter()
            .any(|path| path.extension().is_some_and(|end| end == "checkpoint"))
        {
            assert!(started.elapsed() < Duration::from_secs(60), "no checkpoint in a minute");
            sleep(Duration::from_millis(5));
        }
    }

    /// Runs to the end without a fault; the recording's bytes. Nothing else of the run is left.
    fn finish(&self) -> Vec<u8> {
        let done = self.run();
        assert!(done.status.success(), "{}", said(&done));
        let side = |path: &PathBuf| path.to_string_lossy().contains(".checkpoint");
        assert!(!self.files().iter().any(side), "a side file stays: {:?}", self.files());
        fs::read(self.recording().unwrap()).unwrap()
    }
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn reference() -> Vec<u8> {
    Place::new(SHORT).finish()
}

fn signal(child: &Child, name: &str) {
    let sent = Command::new("kill").args([name, &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
}

#[cfg(unix)]
#[test]
fn ctrl_c_and_sigterm_keep_what_there_is_and_say_so() {
    for (name, code) in [("-INT", 130), ("-TERM", 143)] {
        let place = Place::new(LONG);
        let child = place.spawn();
        place.wait_for_checkpoint();
        signal(&child, name);
        let ended = child.wait_with_output().unwrap();
        assert_eq!(ended.status.code(), Some(code), "{}", said(&ended));
        assert!(said(&ended).contains("Run the same command again to resume"), "{}", said(&ended));
        let partial = place
            .files()
            .into_iter()
            .find(|path| path.to_string_lossy().ends_with(".partial.mcap"));
        let bytes = fs::read(partial.unwrap()).unwrap();
        // An orderly stop writes the footer: viewers open what there is.
        assert!(bytes.ends_with(b"\x89MCAP0\r\n"), "{name}: the partial file has no footer");
    }
}

#[cfg(unix)]
#[test]
fn a_stopped_run_goes_on_to_the_bytes_of_an_undisturbed_one() {
    // Long enough that its first checkpoint is seen before its end on a busy machine, too.
    let reference = Place::new(MEDIUM).finish();
    let place = Place::new(MEDIUM);
    for _ in 0..3 {
        let child = place.spawn();
        place.wait_for_checkpoint();
        signal(&child, "-INT");
        child.wait_with_output().unwrap();
    }
    assert!(place.finish() == reference);
}

#[cfg(unix)]
#[test]
fn a_file_size_limit_is_an_error_that_the_same_command_gets_over() {
    let reference = reference();
    let place = Place::new(SHORT);
    let arguments = place.arguments().join("' '");
    // In blocks of 512 or 1024 bytes, as the shell counts: below half of the recording either way.
    let blocks = reference.len() / 4096;
    let limited = format!("ulimit -f {blocks}; exec '{arguments}'");
    let refused = Command::new("sh").args(["-c", &limited]).output().unwrap();
    assert_eq!(refused.status.code(), Some(RETRYABLE), "{}", said(&refused));
    assert!(said(&refused).contains("run the same command again"), "{}", said(&refused));
    assert!(place.recording().is_none());
    assert!(place.finish() == reference);
}

#[test]
fn a_second_process_stops_with_a_clear_word() {
    let place = Place::new(LONG);
    let mut first = place.spawn();
    place.wait_for_checkpoint();
    let second = place.run();
    assert_eq!(second.status.code(), Some(RETRYABLE), "{}", said(&second));
    assert!(said(&second).contains("is being written by another process"), "{}", said(&second));
    first.kill().unwrap();
    first.wait().unwrap();
}

#[test]
fn a_vanished_folder_is_an_error_and_nothing_is_called_done() {
    let place = Place::new(LONG);
    let child = place.spawn();
    place.wait_for_checkpoint();
    // The program may write a file between the listing and the removal.
    while place.output().exists() {
        let _ = fs::remove_dir_all(place.output());
    }
    let ended = child.wait_with_output().unwrap();
    assert_eq!(ended.status.code(), Some(RETRYABLE), "{}", said(&ended));
    assert!(said(&ended).contains("No such file or directory"), "{}", said(&ended));
}

#[cfg(target_os = "linux")]
#[test]
#[ignore = "needs unshare and the right to mount"]
fn a_full_disk_is_an_error_that_the_same_command_gets_over() {
    let place = Place::new(MEDIUM);
    let reference = place.folder.path().join("reference");
    fs::write(&reference, Place::new(MEDIUM).finish()).unwrap();
    fs::create_dir(place.output()).unwrap();
    let command = format!("'{}'", place.arguments().join("' '"));
    // The plan refuses a disk without room, so that the disk is filled by somebody else when the run has begun.
    let script = format!(
        "cd '{disk}' && mount -t tmpfs -o size=100m disk '{disk}' && cd '{disk}' || exit 9
         {command} & run=$!
         until ls run/*.checkpoint > ls 2> ls; do sleep 0.01; done
         dd if=/dev/zero of=filler bs=1M 2> ls
         wait $run; first=$?
         rm filler
         {command} && cmp run/*.mcap '{reference}' || exit 8
         exit $first",
        disk = place.output().display(),
        reference = reference.display(),
    );
    let ended = Command::new("unshare").args(["-Urm", "sh", "-c", &script]).output().unwrap();
    assert_eq!(ended.status.code(), Some(RETRYABLE), "{}", said(&ended));
    assert!(said(&ended).contains("run the same command again"), "{}", said(&ended));
    assert_eq!(place.recording(), None, "the disk was another one");
}

#[cfg(unix)]
#[test]
#[ignore = "needs root and setpriv, to become a user whom a read-only folder stops"]
fn a_read_only_folder_is_an_error_that_the_same_command_gets_over() {
    use std::os::unix::fs::PermissionsExt as _;
    let allow = |path: &Path, mode| {
        fs::set_permissions(path, fs::Permissions::from_mode(mode)).unwrap();
    };
    let place = Place::new(SHORT);
    // The copy stands where anybody may run it.
    let program = place.folder.path().join("run-experiment");
    fs::copy(env!("CARGO_BIN_EXE_run-experiment"), &program).unwrap();
    allow(place.folder.path(), 0o777);
    fs::create_dir_all(place.output().join("run")).unwrap();
    for mode in [0o555, 0o777] {
        allow(&place.output().join("run"), mode);
        let mut command = Command::new("setpriv");
        command.args(["--reuid=65534", "--regid=65534", "--clear-groups"]).arg(&program);
        let ended = command.args(&place.arguments()[1..]).output().unwrap();
        if mode == 0o555 {
            assert_eq!(ended.status.code(), Some(RETRYABLE), "{}", said(&ended));
            assert!(said(&ended).contains("run the same command again"), "{}", said(&ended));
            assert_eq!(place.files(), Vec::<PathBuf>::new());
        } else {
            assert!(ended.status.success(), "{}", said(&ended));
        }
    }
    assert!(fs::read(place.recording().unwrap()).unwrap() == reference());
}

#[test]
fn damaged_leftovers_are_noticed_and_the_run_begins_anew() {
    let reference = reference();
    for (damaged, ending) in [("checkpoint", ".checkpoint"), ("partial file", ".partial.mcap")] {
        let place = Place::new(SHORT);
        let mut child = place.spawn();
        place.wait_for_checkpoint();
        sleep(Duration::from_millis(30));
        child.kill().unwrap();
        child.wait().unwrap();
        let Some(path) =
            place.files().into_iter().find(|path| path.to_string_lossy().ends_with(ending))
        else {
            continue;
        };
        let mut bytes = fs::read(&path).unwrap();
        let early = bytes.len().min(600) / 2;
        bytes[early] ^= 0x10;
        fs::write(&path, bytes).unwrap();
        let done = place.run();
        assert!(done.status.success(), "{damaged}: {}", said(&done));
        assert!(said(&done).contains("began anew, since"), "{damaged}: {}", said(&done));
        assert!(fs::read(place.recording().unwrap()).unwrap() == reference, "{damaged}");
    }
}

/// Runs under strace, which makes one system call fail or kills the program at it.
fn injected(place: &Place, call: &str, fault: &str, when: u32) -> ExitStatus {
    Command::new("strace")
        .args(["-f", "-qq", "-o", "/dev/null", "-e", &format!("trace={call}")])
        .args(["-e", &format!("inject={call}:{fault}:when={when}")])
        .args(place.arguments())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status()
        .unwrap()
}

/// Lets the n-th call of each kind fail or be the last, with n in steps that grow by 1/`growth` of n (none for 0), until
/// the run gets through; each time the same command must then give the reference. Returns how many runs were harmed.
fn harm_system_calls(growth: u32) -> u32 {
    let reference = reference();
    let mut harmed = 0;
    for (call, fault) in [
        ("write", "error=ENOSPC"),
        ("write", "signal=KILL"),
        ("fdatasync", "error=EIO"),
        ("fdatasync", "signal=KILL"),
        ("fsync", "error=EIO"),
        ("fsync", "signal=KILL"),
        ("rename", "error=ENOSPC"),
        ("rename", "signal=KILL"),
        ("link,linkat", "error=EIO"),
        ("link,linkat", "signal=KILL"),
        ("unlink", "signal=KILL"),
        ("ftruncate", "error=EIO"),
    ] {
        let mut when = 1;
        loop {
            let place = Place::new(SHORT);
            let got_through = injected(&place, call, fault, when).success();
            assert!(place.finish() == reference, "{call} {fault} at {when}");
            harmed += u32::from(!got_through);
            // The first calls may be such that the program does without, as a write to the terminal.
            if got_through && when > 3 {
                break;
            }
            when += 1 + when.checked_div(growth).unwrap_or(0);
        }
    }
    harmed
}

#[test]
#[ignore = "needs strace"]
fn a_system_call_may_fail_or_be_the_last() {
    let harmed = harm_system_calls(2);
    println!("{harmed} runs were harmed and continued to the same bytes");
    assert!(harmed > 50, "only {harmed} runs were harmed");
}

#[test]
#[ignore = "needs strace; the whole harness, every call of a run, many minutes"]
fn full_harness_every_system_call_may_fail_or_be_the_last() {
    let harmed = harm_system_calls(0);
    println!("{harmed} runs were harmed and continued to the same bytes");
    assert!(harmed > 500, "only {harmed} runs were harmed");
}
