//! Guarantee: with `--output s3://…`, the recording of every run reaches object storage, byte for byte as a folder would contain it. A kill,
//! an unreachable store and a second command lose no run and repeat none; an object with other bytes is never replaced. The analysis of
//! the objects equals the analysis of a folder, byte for byte.
//!
//! Setup: moto's server on loopback, behind a connection that can be cut or held. Both programs must be built with the feature before:
//! `cargo build --features object-storage`.
//! Control: an object with other bytes does not count as the recording of a run, and a program without the feature reports this.

#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::process::Output;

/// Six runs of a few milliseconds.
const SWEEP: &str = "seed = 11\nreplicates = 3\n[model.gas]\nparticles = 200\nduration_s = 0.001\n[record]\nframes = 6\n\
    [sweep]\n\"model.gas.temperature_k\" = [200.0, 300.0]\n";

fn messages(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

#[cfg(not(feature = "object-storage"))]
#[test]
fn control_program_without_the_feature_names_it() {
    use std::fs;

    let folder = tempfile::tempdir().unwrap();
    let manifest = folder.path().join("sweep.toml");
    fs::write(&manifest, SWEEP).unwrap();
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_run-experiment"))
        .arg(&manifest)
        .args(["--output", "s3://bucket/kept"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(messages(&output).contains("cargo build --release --features object-storage"));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "no file must be written");
}

#[cfg(feature = "object-storage")]
mod with_a_server {
    use super::{SWEEP, messages};
    use crate::recordings_in::recordings_in;
    use crate::s3_server::{S3Server, Wire};
    use std::collections::BTreeMap;
    use std::fs;
    use std::path::{Path, PathBuf};
    use std::process::{Child, Command, Output, Stdio};
    use std::thread::sleep;
    use std::time::Duration;
    use tempfile::TempDir;

    const PROGRAM: &str = env!("CARGO_BIN_EXE_run-experiment");
    /// A recording of 20 MB, which is uploaded in three parts: 30000 rows of four columns in each of 21 frames.
    const LARGE: &str = "[model.gas]\nparticles = 30000\nduration_s = 0.001\n\
        [record]\nframes = 20\nchannels = [\"state\"]\ncompression = \"none\"\n";

    /// A server, and a folder with a manifest and its recordings as a folder contains them.
    struct Workspace {
        server: S3Server,
        folder: TempDir,
        in_folder: BTreeMap<String, Vec<u8>>,
    }

    impl Workspace {
        fn new(manifest: &str, wire: Wire) -> Self {
            let folder = tempfile::tempdir().unwrap();
            fs::write(folder.path().join("sweep.toml"), manifest).unwrap();
            let status = Command::new(PROGRAM)
                .args(["sweep.toml", "--quiet", "--output", "in_folder"])
                .current_dir(folder.path())
                .status()
                .unwrap();
            assert!(status.success());
            let in_folder = recordings_in(&folder.path().join("in_folder/sweep"));
            Self { server: S3Server::start(wire), folder, in_folder }
        }

        fn path(&self, name: &str) -> PathBuf {
            self.folder.path().join(name)
        }

        fn command(&self, more: &[&str]) -> Command {
            let mut command = self.server.command(PROGRAM);
            command.args(["sweep.toml", "--output", "s3://bucket/kept"]).args(more);
            command.current_dir(self.folder.path());
            command
        }

        fn run(&self, more: &[&str]) -> Output {
            self.command(more).output().unwrap()
        }

        fn object(&self, name: &str) -> Option<Vec<u8>> {
            self.server.get(&format!("/bucket/kept/sweep/{name}"))
        }

        /// The number of finished recordings in the spool.
        fn waiting(&self) -> usize {
            let spool = self.path("spool/bucket/kept/sweep");
            let all = if spool.exists() { recordings_in(&spool) } else { BTreeMap::new() };
            all.keys().filter(|name| !name.ends_with(".partial.mcap")).count()
        }

        /// Asserts that the store contains exactly the recordings of the folder, and that none remains locally.
        fn assert_all_stored(&self) {
            for (name, bytes) in &self.in_folder {
                assert!(self.object(name).as_ref() == Some(bytes), "{name}");
            }
            assert_eq!(self.server.names(".mcap").len(), self.in_folder.len());
            assert_eq!(self.waiting(), 0);
        }

        fn analyze(&self, path: &str, output: &str) -> Output {
            let program = Path::new(PROGRAM).with_file_name("analyze-recordings");
            assert!(
                program.exists(),
                "analyze-recordings must be built with --features object-storage"
            );
            let mut command = self.server.command(program.to_str().unwrap());
            command.args([path, "--output", output, "--export", "csv"]);
            command.current_dir(self.folder.path()).output().unwrap()
        }
    }

    /// Waits until a program has brought about a condition.
    fn wait_until(program: &mut Child, condition: &str, holds: impl Fn() -> bool) {
        while !holds() {
            assert_eq!(program.try_wait().unwrap(), None, "ended before {condition}");
            sleep(Duration::from_millis(20));
        }
    }

    #[test]
    #[ignore = "needs moto_server of the Python package moto"]
    fn sweep_reaches_the_store_completely_and_is_analyzed_there() {
        let workspace = Workspace::new(SWEEP, Wire::Cut);
        let first = workspace.run(&["--jobs", "2"]);
        assert_eq!(first.status.code(), Some(0), "{}", messages(&first));
        assert!(messages(&first).contains("Put 6 recordings to s3://bucket/kept/sweep"));
        workspace.assert_all_stored();
        assert_eq!(workspace.server.names(".host.json").len(), 6);

        // Another machine finds the recordings.
        let again = workspace.run(&["--spool", "other"]);
        assert_eq!(again.status.code(), Some(0));
        let said = messages(&again);
        assert!(said.contains("Nothing to do") && !said.contains("Put "), "{said}");

        let remote = workspace.analyze("s3://bucket/kept", "remote");
        assert_eq!(remote.status.code(), Some(0), "{}", messages(&remote));
        assert_eq!(workspace.analyze("in_folder", "local").status.code(), Some(0));
        let read = |output: &str| {
            let csv = format!("{output}/export/{}/state.csv", stem(&workspace));
            // The runs in the folder and in the store took place at different times.
            let report = fs::read_to_string(workspace.path(&format!("{output}/report.html")));
            let report = report.unwrap();
            let (before, machine) = report.split_once("<p class=\"machine").unwrap();
            let (_, after) = machine.split_once("</p>").unwrap();
            let files = [format!("{output}/metrics.json"), csv];
            let files = files.map(|file| fs::read(workspace.path(&file)).unwrap());
            (files, format!("{before}{after}"))
        };
        assert!(read("remote") == read("local"));
    }

    /// The name of the first recording without its extension.
    fn stem(workspace: &Workspace) -> String {
        workspace.in_folder.keys().next().unwrap().trim_end_matches(".mcap").to_owned()
    }

    #[test]
    #[ignore = "needs moto_server of the Python package moto"]
    fn objects_with_other_bytes_are_never_replaced() {
        let workspace = Workspace::new(SWEEP, Wire::Cut);
        let name = format!("{}.mcap", stem(&workspace));
        let path = format!("/bucket/kept/sweep/{name}");
        workspace.server.put(&path, b"other bytes");
        let refused = workspace.run(&[]);
        assert_eq!(refused.status.code(), Some(1), "{}", messages(&refused));
        assert!(
            messages(&refused).contains("already exists with other bytes"),
            "{}",
            messages(&refused)
        );
        assert_eq!(workspace.object(&name).unwrap(), b"other bytes");
        assert_eq!(workspace.waiting(), 1);
        // An object with the same bytes counts as the recording, whichever program uploaded it.
        workspace.server.put(&path, &workspace.in_folder[&name]);
        let forced = workspace.run(&["--force", "--keep-local"]);
        assert_eq!(forced.status.code(), Some(0), "{}", messages(&forced));
        assert_eq!(workspace.waiting(), 6, "all recordings must be kept");
        assert_eq!(workspace.run(&[]).status.code(), Some(0));
        workspace.assert_all_stored();
    }

    fn start_upload(workspace: &Workspace) -> Child {
        workspace.command(&[]).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
    }

    #[test]
    #[ignore = "needs moto_server of the Python package moto"]
    fn kill_during_an_upload_loses_only_the_upload() {
        let workspace = Workspace::new(LARGE, Wire::Held);
        assert!(
            workspace.in_folder.values().all(|bytes| bytes.len() > 16 << 20),
            "each recording must need three parts"
        );
        for signal in [libc_signal::KILL, libc_signal::INT] {
            workspace.server.allow(10 << 20);
            let mut child = start_upload(&workspace);
            wait_until(&mut child, "the put is under way", || workspace.server.is_stopped());
            let killed = Command::new("kill").args([signal, &child.id().to_string()]).status();
            assert!(killed.unwrap().success());
            let code = child.wait().unwrap().code();
            assert_eq!(code, (signal == libc_signal::INT).then_some(130));
            assert!(workspace.server.names(".mcap").is_empty() && workspace.waiting() == 1);
        }
        workspace.server.allow(i64::MAX);
        let again = workspace.run(&[]);
        let said = messages(&again);
        assert_eq!(again.status.code(), Some(0), "{said}");
        assert!(said.contains("Put 1 recording") && !said.contains("Wrote"), "{said}");
        workspace.assert_all_stored();
    }

    /// Names of signals for `kill`.
    mod libc_signal {
        pub(super) const KILL: &str = "-KILL";
        pub(super) const INT: &str = "-INT";
    }

    #[test]
    #[ignore = "needs moto_server of the Python package moto"]
    fn unreachable_store_loses_no_run() {
        let workspace = Workspace::new(SWEEP, Wire::Cut);
        // Enough bytes for the listing, the sidecar files and the first recording.
        workspace.server.allow(100_000);
        let cut = workspace.run(&["--jobs", "1"]);
        assert_eq!(cut.status.code(), Some(75), "{}", messages(&cut));
        let waiting = workspace.waiting();
        assert!(waiting > 1, "only {waiting} recordings are waiting");
        assert!(
            messages(&cut).contains(&format!("{waiting} recordings are still in")),
            "{}",
            messages(&cut)
        );
        let away = workspace.run(&[]);
        assert_eq!(away.status.code(), Some(75), "{}", messages(&away));
        assert_eq!(workspace.analyze("s3://bucket/kept", "remote").status.code(), Some(75));

        workspace.server.allow(i64::MAX);
        let back = workspace.run(&[]);
        let said = messages(&back);
        assert_eq!(back.status.code(), Some(0), "{said}");
        assert!(said.contains(&format!("Put {waiting} recordings")), "{said}");
        assert!(!said.contains("Wrote"), "{said}");
        workspace.assert_all_stored();
    }

    #[test]
    #[ignore = "needs moto_server of the Python package moto"]
    fn wrong_address_is_rejected_as_an_argument() {
        let workspace = Workspace::new(SWEEP, Wire::Cut);
        for (address, why) in [
            ("s3://nowhere/kept", "the bucket nowhere does not exist"),
            ("s3://", "the bucket is missing"),
        ] {
            let mut command = workspace.server.command(PROGRAM);
            command.args(["sweep.toml", "--output", address]).current_dir(workspace.folder.path());
            let output = command.output().unwrap();
            assert_eq!(output.status.code(), Some(2), "{}", messages(&output));
            assert!(messages(&output).contains(why), "{}", messages(&output));
            assert!(!workspace.path("spool").exists(), "no file must be written");
            assert_eq!(workspace.analyze(address, "remote").status.code(), Some(2));
        }
        let output = workspace.run(&["--executor", "slurm"]);
        assert_eq!(output.status.code(), Some(2));
        assert!(messages(&output).contains("--export-commands"), "{}", messages(&output));
    }

    #[test]
    #[ignore = "needs moto_server of the Python package moto"]
    fn exported_commands_upload_their_recordings() {
        let workspace = Workspace::new(SWEEP, Wire::Cut);
        let exported = workspace.run(&["--runs-per-task", "2", "--export-commands", "list"]);
        assert_eq!(exported.status.code(), Some(0), "{}", messages(&exported));
        assert_eq!(workspace.server.names("experiment.toml").len(), 1);
        let list = fs::read_to_string(workspace.path("list")).unwrap();
        assert_eq!(list.lines().count(), 3);
        for line in list.lines().chain(list.lines()) {
            let mut task = workspace.server.command("sh");
            let task = task.args(["-c", line]).current_dir("/").output().unwrap();
            assert_eq!(task.status.code(), Some(0), "{}", messages(&task));
        }
        workspace.assert_all_stored();
    }
}
