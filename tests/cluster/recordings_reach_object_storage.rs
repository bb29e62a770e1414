//! Promise: with `--output s3://…` every run's recording is on object storage in the end, byte for byte the one that a folder would
//! have; a kill, a store that goes away and a second command cost no run and do none twice; other bytes are never replaced; and the
//! analysis of what is there is that of a folder, byte for byte.
//!
//! The store is moto's server on loopback, behind a wire that can be cut or held. Controls: an object with other bytes is no recording of
//! a run, and a program without the feature says so.
//!
//! Both programs must be built with it before: `cargo build --features object-storage`.

#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::process::Output;

/// Six runs of some milliseconds.
const SWEEP: &str = "seed = 11\nreplicates = 3\n[model.gas]\nparticles = 200\nduration_s = 0.001\n[record]\nframes = 6\n\
    [sweep]\n\"model.gas.temperature_k\" = [200.0, 300.0]\n";

fn words(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

#[cfg(not(feature = "object-storage"))]
#[test]
fn a_program_without_it_says_how_to_have_it() {
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
    assert!(words(&output).contains("cargo build --release --features object-storage"));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "nothing was written");
}

#[cfg(feature = "object-storage")]
mod with_a_server {
    use super::{SWEEP, words};
    use crate::recordings_in::recordings_in;
    use crate::s3_server::{S3Server, Wire};
    use std::collections::BTreeMap;
    use std::fs;
    use std::path::{Path, PathBuf};
    use std::process::{Child, Command, Output, Stdio};
    use std::thread::sleep;
    use std::time::{Duration, Instant};
    use tempfile::TempDir;

    const PROGRAM: &str = env!("CARGO_BIN_EXE_run-experiment");
    /// A recording of 20 MB, so that it is put in three parts: 30000 rows of four columns in each of 21 frames.
    const LARGE: &str = "[model.gas]\nparticles = 30000\nduration_s = 0.001\n\
        [record]\nframes = 20\nchannels = [\"state\"]\ncompression = \"none\"\n";

    /// A server, and a folder with a manifest and what it gives in a folder.
    struct Bench {
        server: S3Server,
        folder: TempDir,
        alone: BTreeMap<String, Vec<u8>>,
    }

    impl Bench {
        fn new(manifest: &str, wire: Wire) -> Self {
            let folder = tempfile::tempdir().unwrap();
            fs::write(folder.path().join("sweep.toml"), manifest).unwrap();
            let status = Command::new(PROGRAM)
                .args(["sweep.toml", "--quiet", "--output", "alone"])
                .current_dir(folder.path())
                .status()
                .unwrap();
            assert!(status.success());
            let alone = recordings_in(&folder.path().join("alone/sweep"));
            Self { server: S3Server::start(wire), folder, alone }
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

        /// Recordings in the spool that are finished.
        fn waiting(&self) -> usize {
            let spool = self.path("spool/bucket/kept/sweep");
            let all = if spool.exists() { recordings_in(&spool) } else { BTreeMap::new() };
            all.keys().filter(|name| !name.ends_with(".partial.mcap")).count()
        }

        /// Every recording is there with the bytes of the folder's, and none other, and none is left here.
        fn all_is_there(&self) {
            for (name, bytes) in &self.alone {
                assert!(self.object(name).as_ref() == Some(bytes), "{name}");
            }
            assert_eq!(self.server.names(".mcap").len(), self.alone.len());
            assert_eq!(self.waiting(), 0);
        }

        fn analyze(&self, path: &str, output: &str) -> Output {
            let program = Path::new(PROGRAM).with_file_name("analyze-recordings");
            assert!(program.exists(), "cargo build --features object-storage makes it");
            let mut command = self.server.command(program.to_str().unwrap());
            command.args([path, "--output", output, "--export", "csv"]);
            command.current_dir(self.folder.path()).output().unwrap()
        }
    }

    fn wait_until(what: &str, holds: impl Fn() -> bool) {
        let started = Instant::now();
        while !holds() {
            assert!(started.elapsed() < Duration::from_secs(60), "{what}");
            sleep(Duration::from_millis(20));
        }
    }

    #[test]
    #[ignore = "needs moto_server of the Python package moto"]
    fn a_sweep_arrives_whole_and_is_analyzed_there() {
        let bench = Bench::new(SWEEP, Wire::Cut);
        let first = bench.run(&["--jobs", "2"]);
        assert_eq!(first.status.code(), Some(0), "{}", words(&first));
        assert!(words(&first).contains("Put 6 recordings to s3://bucket/kept/sweep"));
        bench.all_is_there();
        assert_eq!(bench.server.names(".host.json").len(), 6);

        // A machine that has never seen them finds them.
        let again = bench.run(&["--spool", "other"]);
        assert_eq!(again.status.code(), Some(0));
        let said = words(&again);
        assert!(said.contains("Nothing to do") && !said.contains("Put "), "{said}");

        let remote = bench.analyze("s3://bucket/kept", "remote");
        assert_eq!(remote.status.code(), Some(0), "{}", words(&remote));
        assert_eq!(bench.analyze("alone", "local").status.code(), Some(0));
        let read = |output: &str| {
            let csv = format!("{output}/export/{}/state.csv", stem(&bench));
            [format!("{output}/metrics.json"), format!("{output}/report.html"), csv]
                .map(|file| fs::read(bench.path(&file)).unwrap())
        };
        assert!(read("remote") == read("local"));
    }

    /// The first recording's name without its ending.
    fn stem(bench: &Bench) -> String {
        bench.alone.keys().next().unwrap().trim_end_matches(".mcap").to_owned()
    }

    #[test]
    #[ignore = "needs moto_server of the Python package moto"]
    fn other_bytes_are_never_replaced() {
        let bench = Bench::new(SWEEP, Wire::Cut);
        let name = format!("{}.mcap", stem(&bench));
        let path = format!("/bucket/kept/sweep/{name}");
        bench.server.put(&path, b"other bytes");
        let refused = bench.run(&[]);
        assert_eq!(refused.status.code(), Some(1), "{}", words(&refused));
        assert!(words(&refused).contains("holds other bytes"), "{}", words(&refused));
        assert_eq!(bench.object(&name).unwrap(), b"other bytes");
        assert_eq!(bench.waiting(), 1);
        // The same bytes from another hand are no difference: nothing tells who put them.
        bench.server.put(&path, &bench.alone[&name]);
        let forced = bench.run(&["--force", "--keep-local"]);
        assert_eq!(forced.status.code(), Some(0), "{}", words(&forced));
        assert_eq!(bench.waiting(), 6, "they are kept");
        assert_eq!(bench.run(&[]).status.code(), Some(0));
        bench.all_is_there();
    }

    fn begun(bench: &Bench) -> Child {
        bench.command(&[]).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
    }

    #[test]
    #[ignore = "needs moto_server of the Python package moto"]
    fn a_kill_in_the_middle_of_a_put_costs_the_put_alone() {
        let bench = Bench::new(LARGE, Wire::Held);
        assert!(bench.alone.values().all(|bytes| bytes.len() > 16 << 20), "three parts");
        for signal in [libc_signal::KILL, libc_signal::INT] {
            bench.server.allow(10 << 20);
            let mut child = begun(&bench);
            wait_until("the put is under way", || bench.server.is_stopped());
            let killed = Command::new("kill").args([signal, &child.id().to_string()]).status();
            assert!(killed.unwrap().success());
            let code = child.wait().unwrap().code();
            assert_eq!(code, (signal == libc_signal::INT).then_some(130));
            assert!(bench.server.names(".mcap").is_empty() && bench.waiting() == 1);
        }
        bench.server.allow(i64::MAX);
        let again = bench.run(&[]);
        let said = words(&again);
        assert_eq!(again.status.code(), Some(0), "{said}");
        assert!(said.contains("Put 1 recording") && !said.contains("Wrote"), "{said}");
        bench.all_is_there();
    }

    /// Signals as `kill` takes them.
    mod libc_signal {
        pub(super) const KILL: &str = "-KILL";
        pub(super) const INT: &str = "-INT";
    }

    #[test]
    #[ignore = "needs moto_server of the Python package moto"]
    fn a_store_that_goes_away_costs_no_run() {
        let bench = Bench::new(SWEEP, Wire::Cut);
        // Room for the listing, what stands beside the recordings, and the first of them.
        bench.server.allow(100_000);
        let cut = bench.run(&["--jobs", "1"]);
        assert_eq!(cut.status.code(), Some(75), "{}", words(&cut));
        let waiting = bench.waiting();
        assert!(waiting > 1, "{waiting} recordings wait");
        assert!(words(&cut).contains(&format!("{waiting} recordings wait in")), "{}", words(&cut));
        let away = bench.run(&[]);
        assert_eq!(away.status.code(), Some(75), "{}", words(&away));
        assert_eq!(bench.analyze("s3://bucket/kept", "remote").status.code(), Some(75));

        bench.server.allow(i64::MAX);
        let back = bench.run(&[]);
        let said = words(&back);
        assert_eq!(back.status.code(), Some(0), "{said}");
        assert!(said.contains(&format!("Put {waiting} recordings")), "{said}");
        assert!(!said.contains("Wrote"), "{said}");
        bench.all_is_there();
    }

    #[test]
    #[ignore = "needs moto_server of the Python package moto"]
    fn a_wrong_address_is_a_wrong_argument() {
        let bench = Bench::new(SWEEP, Wire::Cut);
        for (address, why) in
            [("s3://nowhere/kept", "there is no bucket nowhere"), ("s3://", "it names no bucket")]
        {
            let mut command = bench.server.command(PROGRAM);
            command.args(["sweep.toml", "--output", address]).current_dir(bench.folder.path());
            let output = command.output().unwrap();
            assert_eq!(output.status.code(), Some(2), "{}", words(&output));
            assert!(words(&output).contains(why), "{}", words(&output));
            assert!(!bench.path("spool").exists(), "nothing was written");
            assert_eq!(bench.analyze(address, "remote").status.code(), Some(2));
        }
        let output = bench.run(&["--executor", "slurm"]);
        assert_eq!(output.status.code(), Some(2));
        assert!(words(&output).contains("--export-commands"), "{}", words(&output));
    }

    #[test]
    #[ignore = "needs moto_server of the Python package moto"]
    fn exported_commands_put_what_they_record() {
        let bench = Bench::new(SWEEP, Wire::Cut);
        let exported = bench.run(&["--runs-per-task", "2", "--export-commands", "list"]);
        assert_eq!(exported.status.code(), Some(0), "{}", words(&exported));
        assert_eq!(bench.server.names("experiment.toml").len(), 1);
        let list = fs::read_to_string(bench.path("list")).unwrap();
        assert_eq!(list.lines().count(), 3);
        for line in list.lines().chain(list.lines()) {
            let mut task = bench.server.command("sh");
            let task = task.args(["-c", line]).current_dir("/").output().unwrap();
            assert_eq!(task.status.code(), Some(0), "{}", words(&task));
        }
        bench.all_is_there();
    }
}
