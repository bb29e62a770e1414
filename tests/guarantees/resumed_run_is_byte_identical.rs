//! Guarantee: a run that was killed and resumed gives the same bytes as an undisturbed run.
//!
//! Setup: each model is saved, dropped and restored after every frame and whenever its step budget is used up; its frames must not
//! change. The program is killed (signal 9) several times per run at seeded instants, and once while a checkpoint exists. Then the
//! recordings are compared.
//! Control: the test fails if a run of a model does not resume from a checkpoint.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::small_experiments::{MANIFESTS, Taking, run_of, trajectory};
use kinetoscope::run::schedule::Schedule;
use kinetoscope_physics::model::Model;
use kinetoscope_physics::prepare;
use kinetoscope_physics::random::Seed;
use kinetoscope_recording::checkpoint;
use kinetoscope_recording::frame::Frame;
use kinetoscope_recording::scenery::Scenery;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Runs of about a second that write many chunks.
const LONGER: &[(&str, &str)] = &[
    ("dem", "seed = 1\n[model.dem]\ndiscs = 300\nduration_s = 0.1\n[record]\nframes = 150\n"),
    (
        "dem_rain",
        "seed = 4\n[model.dem]\ndiscs = 60\nwidth_m = 0.02\nheight_m = 0.04\nremove_below_m = 0.002\nduration_s = 0.1\n\
         insertion = { discs = 300, discs_per_s = 4000.0, from_m = [0.002, 0.038], to_m = [0.018, 0.038], \
         velocity_m_per_s = [0.0, -1.0] }\n[record]\nframes = 150\n",
    ),
    ("gas", "seed = 2\n[model.gas]\nparticles = 1000\nduration_s = 0.05\n[record]\nframes = 150\n"),
    (
        "packing",
        "seed = 3\n[model.packing]\ndiscs = 300\nwall_noise_variance_rad2 = 0.003\nwidth = 60.0\nheight = 60.0\nevents_per_disc = 500\n[record]\nframes = 150\n\
         channels = [\"state\", \"discs\", \"temperature\", \"collisions\", \"pressure\", \"per_collision\", \"log\"]\n",
    ),
    (
        "orbit",
        "[model.orbit]\nintegrator = \"rk4\"\ntime_step_days = 0.002\nduration_days = 3650.0\n[record]\nframes = 300\n",
    ),
];

#[test]
fn restored_model_continues_bitwise_identically() {
    for (name, manifest) in MANIFESTS {
        let run = run_of(name, manifest);
        let whole = trajectory(&run, Taking::PLAIN);
        for budget in [7, 1000, u64::MAX] {
            let restored = trajectory(&run, Taking { budget, restore: true, ..Taking::PLAIN });
            for (index, (one, other)) in whole.iter().zip(&restored).enumerate() {
                assert!(
                    one == other,
                    "{name}: restored with budget {budget}, frame {} differs",
                    index + 1
                );
            }
            assert_eq!(whole.len(), restored.len());
        }
    }
}

/// A resumed run goes on with the drawing that it began with: ranges of colors, arrows, and the size of discs.
#[test]
fn scenery_is_at_any_time_that_of_the_start() {
    let mut runs_with_fewer_or_more_discs = 0;
    for (name, manifest) in MANIFESTS {
        let run = run_of(name, manifest);
        let seed = Seed { seed: run.seed, replicate: run.replicate };
        let mut model = prepare(&run.model, seed, false).unwrap();
        let values = |model: &dyn Model| {
            let mut frame = Frame::new();
            model.observe(&mut frame);
            frame.state().len()
        };
        let (start, values_at_start) = (model.scenery(), values(&*model));
        let schedule = Schedule::new(run.record.interval, model.extent()).unwrap();
        for index in 1..=schedule.frames() {
            model.advance(schedule.target(index), u64::MAX).unwrap();
            // Only the first frame has the walls of the start.
            let now = Scenery { walls: start.walls.clone(), ..model.scenery() };
            assert_eq!(now, start, "{name}, frame {index}");
        }
        runs_with_fewer_or_more_discs += usize::from(values(&*model) != values_at_start);
    }
    assert!(runs_with_fewer_or_more_discs > 1, "the number of discs never changes");
}

/// A run that ends with a fault long before its last event (`tests/packing/cooled_discs_come_to_rest.rs`).
const AT_REST: &str = "seed = 1\n[model.packing]\ndiscs = 100\nrestitution = 0.9\nwall_noise_variance_rad2 = 0.1\nevents_per_disc = 20000\n[record]\nframes = 2000\n";

/// Reproducible instants from SplitMix64 (Steele, Lea and Flood 2014).
struct Instants(u64);

impl Instants {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (mixed ^ (mixed >> 31)) as f64 / u64::MAX as f64
    }
}

struct Workspace {
    folder: tempfile::TempDir,
    name: &'static str,
}

impl Workspace {
    fn new(name: &'static str, manifest: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join(format!("{name}.toml")), manifest).unwrap();
        Self { folder, name }
    }

    /// Checkpoints are frequent, but the runs do not spend most of their time waiting for the disk.
    fn command(&self, output: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_run-experiment"));
        command
            .args(["--checkpoint-every", "0.02", "--output"])
            .arg(self.folder.path().join(output))
            .arg(self.folder.path().join(format!("{}.toml", self.name)))
            .stdout(Stdio::null())
            .stderr(Stdio::piped());
        command
    }

    /// Runs to the end and returns the messages and the only recording.
    fn finish(&self, output: &str) -> (String, Vec<u8>) {
        self.end(output, 0)
    }

    /// Runs to the end with this exit code, and returns the messages and the only recording.
    fn end(&self, output: &str, code: i32) -> (String, Vec<u8>) {
        let done = self.command(output).output().unwrap();
        let said = String::from_utf8_lossy(&done.stderr).into_owned();
        assert_eq!(done.status.code(), Some(code), "{}: {said}", self.name);
        let left = self.files(output);
        let recordings: Vec<&PathBuf> = left
            .iter()
            .filter(|path| path.extension().is_some_and(|extension| extension == "mcap"))
            .collect();
        assert_eq!(recordings.len(), 1, "{}: {left:?}", self.name);
        let side = |path: &&PathBuf| path.to_string_lossy().contains(".checkpoint");
        assert_eq!(left.iter().find(side), None, "{}: a temporary file remains", self.name);
        (said, fs::read(recordings[0]).unwrap())
    }

    fn files(&self, output: &str) -> Vec<PathBuf> {
        match fs::read_dir(self.folder.path().join(output).join(self.name)) {
            Ok(entries) => entries.map(|entry| entry.unwrap().path()).collect(),
            Err(_) => Vec::new(),
        }
    }

    /// Kills the run after a delay if it is still in progress.
    fn kill_after(&self, output: &str, wait: Duration) {
        let mut child = self.command(output).spawn().unwrap();
        sleep(wait);
        child.kill().unwrap();
        child.wait().unwrap();
    }

    /// Kills the run as soon as its partial file has the given size, and returns the file.
    fn kill_at_size(&self, output: &str, bytes: u64) -> PathBuf {
        let mut child = self.command(output).spawn().unwrap();
        let partial = loop {
            let large_enough = |path: &PathBuf| {
                path.to_string_lossy().ends_with(".partial.mcap")
                    && fs::metadata(path).is_ok_and(|file| file.len() >= bytes)
            };
            if let Some(path) = self.files(output).into_iter().find(large_enough) {
                break path;
            }
            assert_eq!(child.try_wait().unwrap(), None, "the run ended before it was killed");
            sleep(Duration::from_millis(1));
        };
        child.kill().unwrap();
        child.wait().unwrap();
        partial
    }

    /// Kills the run while it has a checkpoint. Returns whether it was killed: a run may end before its checkpoint is seen.
    fn kill_at_checkpoint(&self, output: &str) -> bool {
        let is_checkpoint =
            |path: &PathBuf| path.extension().is_some_and(|end| end == "checkpoint");
        let mut child = self.command(output).spawn().unwrap();
        while child.try_wait().unwrap().is_none() {
            if self.files(output).iter().any(is_checkpoint) {
                break;
            }
            sleep(Duration::from_millis(1));
        }
        child.kill().unwrap();
        child.wait().unwrap();
        self.files(output).iter().any(is_checkpoint)
    }

    /// Simulates a power failure: bytes that were not synced to the disk are lost or changed.
    fn lose_unsynced_bytes(&self, output: &str, share: f64) {
        let Some(partial) = self
            .files(output)
            .into_iter()
            .find(|path| path.to_string_lossy().ends_with(".partial.mcap"))
        else {
            return;
        };
        let mut bytes = fs::read(&partial).unwrap();
        let safe = synced_bytes(&partial).unwrap_or(0);
        let kept = safe + ((bytes.len() - safe) as f64 * share) as usize;
        let garbled = safe + (kept - safe) / 2;
        bytes.truncate(kept);
        bytes[garbled..].fill(0);
        fs::write(&partial, bytes).unwrap();
    }
}

/// The number of bytes that the checkpoint relies on; they were synced before it was written.
fn synced_bytes(partial: &Path) -> Option<usize> {
    let stem = partial.file_name()?.to_str()?.strip_suffix(".partial.mcap")?;
    let bytes = fs::read(checkpoint::path(partial.parent()?, stem)).ok()?;
    // Layout of a checkpoint: magic 8, version 4, identity with its length, length 8, then varints of postcard:
    // next frame, frames, frames in closed chunks, bytes in closed chunks.
    let identity = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let mut rest = bytes[16 + identity + 8..].iter();
    let mut varint = || {
        let mut value = 0_usize;
        for (place, byte) in rest.by_ref().enumerate() {
            value |= usize::from(byte & 0x7f) << (7 * place);
            if byte & 0x80 == 0 {
                break;
            }
        }
        value
    };
    let [_next, _frames, _closed_frames, closed_bytes] = std::array::from_fn(|_| varint());
    Some(closed_bytes)
}

/// Kills each longer run the given number of times and compares the recordings; returns the numbers of kills and of resumed runs. The
/// run of each model is killed at a checkpoint in addition.
fn kill_and_compare(kills_per_model: u32, seed: u64) -> (u32, u32) {
    let mut instants = Instants(seed);
    let (mut killed, mut resumed) = (0, 0);
    for (name, manifest) in LONGER {
        let bench = Workspace::new(name, manifest);
        let started = Instant::now();
        let (_, reference) = bench.finish("reference");
        let length = started.elapsed();
        let mut left = kills_per_model;
        let mut round = 0;
        // One kill of each model leaves a checkpoint for certain, however fast the machine is.
        while !bench.kill_at_checkpoint("at_checkpoint") {
            fs::remove_dir_all(bench.folder.path().join("at_checkpoint")).unwrap();
        }
        let (said, bytes) = bench.finish("at_checkpoint");
        assert!(said.contains("from frame"), "{name}: {said}");
        assert!(bytes == reference, "{name}: the bytes differ after a kill at a checkpoint");
        while left > 0 {
            let output = format!("killed_{round}");
            for _ in 0..(1 + round % 4).min(left) {
                bench.kill_after(&output, length.mul_f64(instants.next()));
                if round % 2 == 1 {
                    bench.lose_unsynced_bytes(&output, instants.next());
                }
                left -= 1;
                killed += 1;
            }
            let (said, bytes) = bench.finish(&output);
            resumed += u32::from(said.contains("from frame"));
            assert!(!said.contains("restarted from scratch"), "{name}: {said}");
            assert!(bytes == reference, "{name}: the bytes differ in round {round}");
            fs::remove_dir_all(bench.folder.path().join(&output)).unwrap();
            round += 1;
        }
    }
    (killed, resumed)
}

#[test]
#[ignore = "needs Python 3 with the package mcap"]
fn other_reader_recovers_the_messages_of_a_killed_run() {
    for (name, manifest) in LONGER {
        let bench = Workspace::new(name, manifest);
        let (_, bytes) = bench.finish("whole");
        let whole = bench.folder.path().join("whole.mcap");
        fs::write(&whole, &bytes).unwrap();
        let partial = bench.kill_at_size("torn", bytes.len() as u64 / 3);
        let read = Command::new("python3")
            .arg(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/interop/check_torn.py"))
            .args([partial, whole])
            .output()
            .unwrap();
        println!("{name}: {}", String::from_utf8_lossy(&read.stdout).trim());
        assert!(read.status.success(), "{name}: {}", String::from_utf8_lossy(&read.stderr));
    }
}

#[test]
fn killed_runs_resume_to_the_same_bytes() {
    let (killed, resumed) = kill_and_compare(6, 1);
    println!("{killed} kills at seeded instants, {resumed} recordings resumed from a checkpoint");
}

/// Setup: inelastic discs between noisy walls, which come to rest. The run is killed at a checkpoint.
#[test]
fn killed_run_of_discs_that_come_to_rest_resumes_to_the_fault() {
    let bench = Workspace::new("rest", AT_REST);
    let fault = |said: &str| {
        let lines =
            said.lines().skip_while(|line| !line.contains("the discs have come to rest after"));
        lines.map(str::to_owned).collect::<Vec<_>>().join("\n")
    };
    let (said, reference) = bench.end("reference", 1);
    assert!(fault(&said).contains("\nhelp: end the run earlier"), "{said}");
    while !bench.kill_at_checkpoint("killed") {
        fs::remove_dir_all(bench.folder.path().join("killed")).unwrap();
    }
    let (resumed, bytes) = bench.end("killed", 1);
    assert!(resumed.contains(": failed from frame "), "{resumed}");
    assert_eq!(fault(&resumed), fault(&said));
    assert!(bytes == reference, "the bytes of the resumed run differ");
}

#[test]
#[ignore = "240 kills, takes minutes"]
fn full_harness_240_killed_runs_resume_to_the_same_bytes() {
    let (killed, resumed) = kill_and_compare(48, 2);
    println!("{killed} kills, {resumed} recordings resumed from a checkpoint");
    assert!(killed >= 240);
}
