//! Guarantee: no external fault loses a run.
//!
//! Setup: runs are interrupted by signals, file size limits, full disks, removed or read-only folders, damaged files, and by system
//! calls that fail or at which the program is killed. Afterwards, the folder must contain either the complete recording or a partial
//! recording that the same command completes to the same bytes. The message and the exit code must state which.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Output, Stdio};
use std::thread::sleep;
use std::time::Duration;

/// Three chunks of frames, recorded in a tenth of a second.
const SHORT: &str =
    "seed = 1\n[model.gas]\nparticles = 500\nduration_s = 0.02\n[record]\nframes = 80\n";
/// The same calls of the system with little physics: a thousand runs of it are started, one for each call.
const CALLS: &str =
    "seed = 1\n[model.gas]\nparticles = 50\nduration_s = 0.0005\n[record]\nframes = 40\n";
/// More than ten chunks. A checkpoint, which waits for the disk, follows each frame.
const MEDIUM: &str =
    "seed = 1\n[model.gas]\nparticles = 500\nduration_s = 0.2\n[record]\nframes = 400\n";
/// Takes half a minute at least; no test waits for its end.
const LONG: &str =
    "seed = 2\n[model.dem]\ndiscs = 1000\nduration_s = 10.0\n[record]\nframes = 2000\n";
/// Exit code of a failure that a later attempt may overcome, as stated in the help text.
const RETRYABLE: i32 = 75;

struct Workspace {
    folder: tempfile::TempDir,
    manifest: PathBuf,
}

impl Workspace {
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

    /// The program and its arguments; checkpoints are written as often as possible.
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
        let mut command = if cfg!(target_os = "linux") {
            // The caller of the tests may ignore SIGHUP, as `nohup` does, and a run would ignore it as well.
            let mut command = Command::new("env");
            command.arg("--default-signal=HUP").args(&arguments);
            command
        } else {
            let mut command = Command::new(&arguments[0]);
            command.args(&arguments[1..]);
            command
        };
        command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
    }

    fn has_checkpoint(&self) -> bool {
        let is_one = |path: &PathBuf| path.extension().is_some_and(|end| end == "checkpoint");
        self.files().iter().any(is_one)
    }

    /// Waits until a run has a checkpoint or has ended: a resumed run may end before its checkpoint is seen. Returns whether
    /// it has a checkpoint.
    fn wait_for_checkpoint_or_end(&self, child: &mut Child) -> bool {
        loop {
            let has_ended = child.try_wait().unwrap().is_some();
            if has_ended || self.has_checkpoint() {
                return !has_ended;
            }
            sleep(Duration::from_millis(5));
        }
    }

    /// Waits until a long run has a checkpoint. Only the end of the run ends the wait early.
    fn wait_for_checkpoint(&self, child: &mut Child) {
        assert!(self.wait_for_checkpoint_or_end(child), "the run ended before it was disturbed");
    }

    /// Runs to the end and returns the bytes of the recording. No other file of the run may remain.
    fn finish(&self) -> Vec<u8> {
        let done = self.run();
        assert!(done.status.success(), "{}", messages(&done));
        let side = |path: &PathBuf| path.to_string_lossy().contains(".checkpoint");
        assert!(!self.files().iter().any(side), "a temporary file remains: {:?}", self.files());
        fs::read(self.recording().unwrap()).unwrap()
    }
}

fn messages(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn reference() -> Vec<u8> {
    Workspace::new(SHORT).finish()
}

fn signal(child: &Child, name: &str) {
    let sent = Command::new("kill").args([name, &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
}

#[cfg(unix)]
#[test]
fn interrupted_run_keeps_a_readable_partial_recording() {
    for (name, code) in [("-INT", 130), ("-TERM", 143), ("-HUP", 129)] {
        let workspace = Workspace::new(LONG);
        let mut child = workspace.spawn();
        workspace.wait_for_checkpoint(&mut child);
        signal(&child, name);
        let ended = child.wait_with_output().unwrap();
        assert_eq!(ended.status.code(), Some(code), "{}", messages(&ended));
        assert!(
            messages(&ended).contains("Run the same command again to resume"),
            "{}",
            messages(&ended)
        );
        let partial = workspace
            .files()
            .into_iter()
            .find(|path| path.to_string_lossy().ends_with(".partial.mcap"));
        let bytes = fs::read(partial.unwrap()).unwrap();
        // An orderly stop writes the footer, so that viewers can open the partial recording.
        assert!(bytes.ends_with(b"\x89MCAP0\r\n"), "{name}: the partial file has no footer");
    }
}

#[cfg(unix)]
#[test]
fn interrupted_run_resumes_to_the_same_bytes() {
    // The run is long enough to write a checkpoint before its end, even on a busy machine.
    let reference = Workspace::new(MEDIUM).finish();
    let workspace = Workspace::new(MEDIUM);
    for _ in 0..3 {
        let mut child = workspace.spawn();
        if !workspace.wait_for_checkpoint_or_end(&mut child) {
            break;
        }
        signal(&child, "-INT");
        child.wait_with_output().unwrap();
    }
    assert!(workspace.finish() == reference);
}

#[cfg(target_os = "linux")]
#[test]
fn hangup_does_not_end_a_run_whose_caller_ignores_it() {
    let workspace = Workspace::new(MEDIUM);
    // As `nohup` does.
    let ignoring = format!("trap '' HUP; exec '{}'", workspace.arguments().join("' '"));
    let mut child = Command::new("sh").args(["-c", &ignoring]).spawn().unwrap();
    if workspace.wait_for_checkpoint_or_end(&mut child) {
        signal(&child, "-HUP");
    }
    assert!(child.wait().unwrap().success());
    assert!(workspace.recording().is_some());
}

#[cfg(unix)]
#[test]
fn run_resumes_after_a_file_size_limit() {
    let reference = reference();
    let workspace = Workspace::new(SHORT);
    let arguments = workspace.arguments().join("' '");
    // The shell counts in blocks of 512 or 1024 bytes; the limit is below half of the recording in either case.
    let blocks = reference.len() / 4096;
    let limited = format!("ulimit -f {blocks}; exec '{arguments}'");
    let refused = Command::new("sh").args(["-c", &limited]).output().unwrap();
    assert_eq!(refused.status.code(), Some(RETRYABLE), "{}", messages(&refused));
    assert!(messages(&refused).contains("run the same command again"), "{}", messages(&refused));
    assert!(workspace.recording().is_none());
    assert!(workspace.finish() == reference);
}

#[test]
fn second_process_reports_that_the_recording_is_in_use() {
    let workspace = Workspace::new(LONG);
    let mut first = workspace.spawn();
    workspace.wait_for_checkpoint(&mut first);
    let second = workspace.run();
    assert_eq!(second.status.code(), Some(RETRYABLE), "{}", messages(&second));
    assert!(
        messages(&second).contains("is being written by another process"),
        "{}",
        messages(&second)
    );
    first.kill().unwrap();
    first.wait().unwrap();
}

#[test]
fn removed_output_folder_is_an_error() {
    let workspace = Workspace::new(LONG);
    let mut child = workspace.spawn();
    workspace.wait_for_checkpoint(&mut child);
    // The program may write a file between the listing and the removal.
    while workspace.output().exists() {
        let _ = fs::remove_dir_all(workspace.output());
    }
    let ended = child.wait_with_output().unwrap();
    assert_eq!(ended.status.code(), Some(RETRYABLE), "{}", messages(&ended));
    assert!(messages(&ended).contains("No such file or directory"), "{}", messages(&ended));
}

#[cfg(target_os = "linux")]
#[test]
#[ignore = "needs unshare and the right to mount"]
fn run_resumes_after_a_full_disk() {
    let workspace = Workspace::new(MEDIUM);
    let reference = workspace.folder.path().join("reference");
    fs::write(&reference, Workspace::new(MEDIUM).finish()).unwrap();
    fs::create_dir(workspace.output()).unwrap();
    let command = format!("'{}'", workspace.arguments().join("' '"));
    // The plan rejects a disk without space; therefore, `dd` fills the disk after the run has started.
    let script = format!(
        "cd '{disk}' && mount -t tmpfs -o size=100m disk '{disk}' && cd '{disk}' || exit 9
         {command} & run=$!
         until ls run/*.checkpoint > ls 2> ls; do sleep 0.01; done
         dd if=/dev/zero of=filler bs=1M 2> ls
         wait $run; first=$?
         rm filler
         {command} && cmp run/*.mcap '{reference}' || exit 8
         exit $first",
        disk = workspace.output().display(),
        reference = reference.display(),
    );
    let ended = Command::new("unshare").args(["-Urm", "sh", "-c", &script]).output().unwrap();
    assert_eq!(ended.status.code(), Some(RETRYABLE), "{}", messages(&ended));
    assert!(messages(&ended).contains("run the same command again"), "{}", messages(&ended));
    assert_eq!(workspace.recording(), None, "the recording must be on the disk of the test only");
}

#[cfg(unix)]
#[test]
#[ignore = "needs root and setpriv, to become a user for whom the folder is read-only"]
fn run_resumes_after_a_read_only_folder() {
    use std::os::unix::fs::PermissionsExt as _;
    let allow = |path: &Path, mode| {
        fs::set_permissions(path, fs::Permissions::from_mode(mode)).unwrap();
    };
    let workspace = Workspace::new(SHORT);
    // The copy is in a folder where every user may run it. Another process copies it, because a child that another test starts
    // at the same time would inherit the open file and keep it busy.
    let program = workspace.folder.path().join("run-experiment");
    let copied =
        Command::new("cp").arg(env!("CARGO_BIN_EXE_run-experiment")).arg(&program).status();
    assert!(copied.unwrap().success());
    allow(workspace.folder.path(), 0o777);
    fs::create_dir_all(workspace.output().join("run")).unwrap();
    for mode in [0o555, 0o777] {
        allow(&workspace.output().join("run"), mode);
        let mut command = Command::new("setpriv");
        command.args(["--reuid=65534", "--regid=65534", "--clear-groups"]).arg(&program);
        let ended = command.args(&workspace.arguments()[1..]).output().unwrap();
        if mode == 0o555 {
            assert_eq!(ended.status.code(), Some(RETRYABLE), "{}", messages(&ended));
            assert!(!messages(&ended).contains(".kinetoscope-"), "{}", messages(&ended));
            assert!(
                messages(&ended).contains("run the same command again"),
                "{}",
                messages(&ended)
            );
            assert_eq!(workspace.files(), Vec::<PathBuf>::new());
        } else {
            assert!(ended.status.success(), "{}", messages(&ended));
        }
    }
    assert!(fs::read(workspace.recording().unwrap()).unwrap() == reference());
}

#[test]
fn damaged_leftovers_are_reported_and_the_run_restarts() {
    let reference = Workspace::new(SHORT).finish();
    for (damaged, ending) in [("checkpoint", ".checkpoint"), ("partial file", ".partial.mcap")] {
        // The checkpoint is there for most of the run. A run that ends before it is seen is started again.
        let (workspace, path) = loop {
            let workspace = Workspace::new(SHORT);
            let mut child = workspace.spawn();
            workspace.wait_for_checkpoint_or_end(&mut child);
            child.kill().unwrap();
            child.wait().unwrap();
            let files = workspace.files();
            let path = files.into_iter().find(|path| path.to_string_lossy().ends_with(ending));
            if let Some(path) = path.filter(|_| workspace.has_checkpoint()) {
                break (workspace, path);
            }
        };
        let mut bytes = fs::read(&path).unwrap();
        let early = bytes.len().min(600) / 2;
        bytes[early] ^= 0x10;
        fs::write(&path, bytes).unwrap();
        let done = workspace.run();
        assert!(done.status.success(), "{damaged}: {}", messages(&done));
        assert!(
            messages(&done).contains("restarted from scratch: "),
            "{damaged}: {}",
            messages(&done)
        );
        assert!(fs::read(workspace.recording().unwrap()).unwrap() == reference, "{damaged}");
    }
}

/// Runs under strace, which lets one system call fail or kills the program at that call.
fn injected(workspace: &Workspace, call: &str, fault: &str, when: u32) -> ExitStatus {
    Command::new("strace")
        .args(["-f", "-qq", "-o", "/dev/null", "-e", &format!("trace={call}")])
        .args(["-e", &format!("inject={call}:{fault}:when={when}")])
        .args(workspace.arguments())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status()
        .unwrap()
}

/// Lets the n-th call of each kind fail or be the last one, until the run succeeds; n grows by 1/`growth` of n per step (by 1 if
/// `growth` is 0). After each fault, the same command must give the reference. Returns the number of faults.
fn inject_system_call_faults(growth: u32) -> u32 {
    let reference = Workspace::new(CALLS).finish();
    let mut faults = 0;
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
            let workspace = Workspace::new(CALLS);
            let got_through = injected(&workspace, call, fault, when).success();
            assert!(workspace.finish() == reference, "{call} {fault} at {when}");
            faults += u32::from(!got_through);
            // The program does not depend on some of the first calls, such as a write to the terminal.
            if got_through && when > 3 {
                break;
            }
            when += 1 + when.checked_div(growth).unwrap_or(0);
        }
    }
    faults
}

#[test]
#[ignore = "needs strace"]
fn run_survives_sampled_system_call_faults() {
    let faults = inject_system_call_faults(2);
    println!("{faults} faults were injected; all runs resumed to the same bytes");
    assert!(faults > 50, "only {faults} faults were injected");
}

#[test]
#[ignore = "needs strace; every system call of a run, ten minutes on an idle machine"]
fn full_harness_run_survives_every_system_call_fault() {
    let faults = inject_system_call_faults(0);
    println!("{faults} faults were injected; all runs resumed to the same bytes");
    assert!(faults > 500, "only {faults} faults were injected");
}
