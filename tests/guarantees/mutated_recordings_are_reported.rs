//! Guarantee: recordings with any content behind correct checksums cause no panic, no abort, and no use of much
//! memory or time, in `analyze`, `compare`, `verify`, `export --thumbnail`, `fill`, `zoom` and `start_from`.
//!
//! Setup: structure-aware mutations of two small recordings of each model (`tests/shared/mutated_recording.rs`), one with all frames
//! and one that keeps only keyframes.
//! Programs run with limits of their memory (1 GiB) and processor time (10 s for a file, 109 s for 100). Control: the unchanged recording verifies.
//!
//! A change of a recording's manifest may ask for a run of years. What executes a run is interrupted after [`LONGEST_RUN`] and then must
//! end within [`LONGEST_END`], both of processor time; the campaigns print the number of these files.
//!
//! The ignored tests are the campaigns: `MUTATIONS=20000 cargo test --test guarantees -- --ignored full_harness_mutated_recordings`.
//! `MODEL=gas` limits them to one model.

#![allow(clippy::unwrap_used, reason = "a test may panic")]
#![cfg(unix)]

use crate::kinetoscope_program::kinetoscope;
use crate::mutated_recording::{Numbers, Records};
use kinetoscope::Experiment;
use kinetoscope::interrupt::Interrupt;
use kinetoscope::run::in_memory::run_interruptibly;
use kinetoscope::run::restart_files::StartFiles;
use kinetoscope::verify::compare::compare_recordings;
use kinetoscope::verify::fill::fill;
use kinetoscope::verify::fine_frames::Interval;
use kinetoscope::verify::verify;
use kinetoscope::verify::zoom::zoom;
use kinetoscope_manifest::{Lookup, parse_with};
use rayon::ThreadPoolBuilder;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

/// A small experiment that records every channel.
struct Small {
    model: &'static str,
    keys: &'static str,
    /// The keys of a run that starts from its last frame.
    start: &'static str,
    /// An interval of the run.
    interval: Interval,
}

const MODELS: [Small; 4] = [
    Small {
        model: "dem",
        keys: "discs = 6\nwidth_m = 0.006\nheight_m = 0.006\nfriction = 0.3\nduration_s = 0.004\n",
        start: "width_m = 0.006\nheight_m = 0.006\nduration_s = 0.001\n",
        interval: Interval { from: 0.0015, to: 0.0025, every: 0.0005 },
    },
    Small {
        model: "gas",
        keys: "particles = 6\nduration_s = 0.003\n",
        start: "duration_s = 0.001\n",
        interval: Interval { from: 0.001, to: 0.002, every: 0.0005 },
    },
    Small {
        model: "packing",
        keys: "discs = 6\nwidth = 10.0\nheight = 10.0\nevents_per_disc = 20\n",
        start: "width = 10.0\nheight = 10.0\nevents_per_disc = 5\n",
        interval: Interval { from: 20.0, to: 40.0, every: 5.0 },
    },
    Small {
        model: "orbit",
        keys: "duration_days = 20.0\n",
        start: "duration_days = 5.0\n",
        interval: Interval { from: 8.0, to: 12.0, every: 1.0 },
    },
];

/// What is recorded: all frames, or keyframes alone.
const RECORDED: [&str; 2] =
    ["frames = 4\n", "frames = 6\nkeep = \"keyframes\"\nkeyframe_distance = 3\n"];

/// Files per call of a program.
pub(crate) const BATCH: usize = 100;

pub(crate) fn mutations(default: usize) -> usize {
    std::env::var("MUTATIONS").map_or(default, |count| count.parse().unwrap())
}

/// Number of the signal that interrupts a run.
const SIGTERM: usize = 15;

/// Processor time after which a run is interrupted.
pub(crate) const LONGEST_RUN: Duration = Duration::from_secs(2);

/// Processor time within which an interrupted run ends.
const LONGEST_END: Duration = Duration::from_secs(1);

/// Elapsed time after which a run that uses no processor time is interrupted.
const LONGEST_WAIT: Duration = Duration::from_mins(10);

/// Elapsed time between two readings of the processor time.
const BETWEEN_READINGS: Duration = Duration::from_millis(10);

/// What executed a run: its panic or its failure to end, and whether it was interrupted.
#[derive(Default)]
pub(crate) struct Execution {
    pub(crate) finding: Option<String>,
    pub(crate) is_interrupted: bool,
    /// Processor time from the interrupt to the end.
    pub(crate) end_after_signal: Duration,
}

/// The processor time of a thread, which other work on the machine does not change (`proc_pid_schedstat(5)`).
fn processor_time(schedstat: &Path) -> Duration {
    let text = fs::read_to_string(schedstat).unwrap_or_default();
    let nanoseconds = text.split(' ').next().and_then(|first| first.parse().ok());
    Duration::from_nanos(nanoseconds.unwrap_or(0))
}

/// Calls a function that executes a run, and interrupts it after [`LONGEST_RUN`].
pub(crate) fn execute(function: impl FnOnce(&Interrupt) + Send) -> Execution {
    execute_for(LONGEST_RUN, function)
}

/// Calls a function that executes a run, on one thread, and interrupts it after a processor time of that thread.
pub(crate) fn execute_for(
    longest: Duration,
    function: impl FnOnce(&Interrupt) + Send,
) -> Execution {
    let pool = ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    pool.install(|| execute_here_for(longest, function))
}

fn execute_here_for(longest: Duration, function: impl FnOnce(&Interrupt)) -> Execution {
    let interrupt = Interrupt::default();
    let watched = interrupt.clone();
    let (ended, has_ended) = mpsc::channel::<()>();
    let own = Path::new("/proc").join(fs::read_link("/proc/thread-self").unwrap());
    let schedstat = &own.join("schedstat");
    let start = (Instant::now(), processor_time(schedstat));
    thread::scope(|scope| {
        let watch = scope.spawn(move || {
            while has_ended.recv_timeout(BETWEEN_READINGS) == Err(RecvTimeoutError::Timeout) {
                let used = processor_time(schedstat).saturating_sub(start.1);
                if used > longest || start.0.elapsed() > LONGEST_WAIT {
                    watched.raise(SIGTERM);
                    return Some(used);
                }
            }
            None
        });
        let panic = panic_of(|| function(&interrupt));
        let used = processor_time(schedstat).saturating_sub(start.1);
        drop(ended);
        let used_at_signal = watch.join().unwrap();
        let end_after_signal = used_at_signal.map_or(Duration::ZERO, |before| used - before);
        let late = || {
            let is_late = end_after_signal > LONGEST_END || start.0.elapsed() > 2 * LONGEST_WAIT;
            is_late.then(|| format!("an interrupt ended the run after {end_after_signal:?}"))
        };
        Execution {
            finding: panic.or_else(late),
            is_interrupted: used_at_signal.is_some(),
            end_after_signal,
        }
    })
}

/// The recording of a manifest, in memory.
fn record(manifest: &str, interrupt: &Interrupt) -> Option<Vec<u8>> {
    let experiment: Experiment = manifest.parse().ok()?;
    let recording = run_interruptibly(experiment.runs.first()?, interrupt).ok()?;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    recording.save(&path).unwrap();
    Some(fs::read(path).unwrap())
}

/// Calls `kinetoscope` with limits of memory and of processor time; returns what is wrong with its end.
fn limited(arguments: &[&str], files: usize) -> Result<i32, String> {
    let program = kinetoscope();
    let limits = format!("ulimit -v 1048576; ulimit -t {}; exec \"$0\" \"$@\"", files + 9);
    let mut shell = Command::new("sh");
    shell.args(["-c", &limits]).arg(program.get_program()).args(arguments);
    let called = shell.output().unwrap();
    let errors = String::from_utf8_lossy(&called.stderr).into_owned();
    match called.status.code() {
        Some(70 | 101 | 134) | None => Err(format!("{}: {errors}", called.status)),
        Some(_) if errors.contains("internal error") => Err(errors),
        Some(code) => Ok(code),
    }
}

/// Calls a function; returns its panic, if any.
fn panic_of(function: impl FnOnce()) -> Option<String> {
    let panic = catch_unwind(AssertUnwindSafe(function)).err()?;
    let text = panic.downcast_ref::<String>().cloned();
    Some(
        text.or_else(|| panic.downcast_ref::<&str>().map(|text| (*text).to_owned()))
            .unwrap_or_default(),
    )
}

/// The findings about some files of one folder.
pub(crate) struct Findings {
    pub(crate) found: Vec<String>,
    /// Number of runs that were interrupted because they are long.
    interrupted: usize,
    /// Where files with findings are kept.
    kept: PathBuf,
}

impl Findings {
    /// No findings; files are kept in this folder.
    pub(crate) fn kept_in(folder: &Path) -> Self {
        Self { found: Vec::new(), interrupted: 0, kept: folder.to_owned() }
    }

    pub(crate) fn add(&mut self, what: &str, file: &Path, finding: &str) {
        fs::create_dir_all(&self.kept).unwrap();
        let kept = self.kept.join(format!("{}_{}.mcap", what, self.found.len()));
        if file.is_file() {
            fs::copy(file, &kept).unwrap();
        }
        let short: String = finding.chars().take(600).collect();
        self.found.push(format!("{what} of {}: {short}", kept.display()));
    }

    /// Compares, verifies and starts from each file, in this process.
    fn read(&mut self, original: &Path, files: &[PathBuf], start: impl Fn(&str) -> String + Sync) {
        for file in files {
            let name = file.file_name().unwrap().to_str().unwrap();
            let compared = panic_of(|| drop(compare_recordings(original, file, None)));
            let verified = execute(|interrupt| drop(verify(file, interrupt, &|_, _| {})));
            let started = execute(|interrupt| {
                let starts = StartFiles::relative_to(file.parent().unwrap());
                let read = |name: &str| starts.read(name);
                let text = start(name);
                let lookup = Lookup { recordings: Some(&read), ..Lookup::default() };
                if let Ok(experiment) = parse_with(&text, "a.toml", &[], lookup) {
                    drop(run_interruptibly(&experiment.runs[0], interrupt));
                }
            });
            self.interrupted +=
                [&verified, &started].map(|run| run.is_interrupted.into()).iter().sum::<usize>();
            let (verified, started) = (verified.finding, started.finding);
            for (what, finding) in
                [("compare", compared), ("verify", verified), ("start_from", started)]
            {
                if let Some(finding) = finding {
                    self.add(what, file, &finding);
                }
            }
        }
    }

    /// Restores frames of each file, in this process. No file is left of what is not restored.
    fn restore(&mut self, files: &[PathBuf], interval: Interval) {
        for file in files {
            let folder = tempfile::tempdir().unwrap();
            let output = folder.path().join("restored.mcap");
            let filled = execute(|interrupt| {
                if fill(file, Some(&output), interrupt, &|_, _| {}).is_ok() {
                    fs::remove_file(&output).unwrap();
                }
            });
            let zoomed = execute(|interrupt| {
                if zoom(file, interval, Some(&output), interrupt).is_ok() {
                    fs::remove_file(&output).unwrap();
                }
            });
            for (what, run) in [("fill", filled), ("zoom", zoomed)] {
                self.interrupted += usize::from(run.is_interrupted);
                if let Some(finding) = run.finding {
                    self.add(what, file, &finding);
                }
            }
            if fs::read_dir(folder.path()).unwrap().next().is_some() {
                self.add("restored", file, "an incomplete file was left");
            }
        }
    }

    /// Analyzes all files of a folder in one call. If it fails, each file is analyzed alone.
    pub(crate) fn analyze(&mut self, folder: &Path, files: &[PathBuf]) {
        if limited(&["analyze", "--quiet", folder.to_str().unwrap()], files.len()).is_ok() {
            return;
        }
        let before = self.found.len();
        for file in files {
            if let Err(why) = limited(&["analyze", "--quiet", file.to_str().unwrap()], 1) {
                self.add("analyze", file, &why);
            }
        }
        if self.found.len() == before {
            self.add("analyze", folder, "the files together fail, each alone does not");
        }
    }

    /// Prints a line on what was tried so far.
    #[allow(clippy::print_stderr, reason = "the figures of a campaign")]
    fn print(&self, what: &str) {
        let (found, interrupted) = (self.found.len(), self.interrupted);
        eprintln!("{what}: {found} findings, {interrupted} runs interrupted in all");
    }

    fn draw(&mut self, file: &Path) {
        let picture = file.with_extension("png");
        let arguments = ["export", "--quiet", "--thumbnail", picture.to_str().unwrap()];
        if let Err(why) = limited(&[&arguments[..], &[file.to_str().unwrap()]].concat(), 1) {
            self.add("thumbnail", file, &why);
        }
    }
}

/// Mutates recordings of each model; returns the findings.
fn mutate(counts: [usize; 2], thumbnails: usize, seed: u64, kept: &Path) -> Vec<String> {
    let mut findings = Findings::kept_in(kept);
    let only = std::env::var("MODEL").ok();
    for small in
        MODELS.iter().filter(|small| only.as_deref().is_none_or(|only| only == small.model))
    {
        for (recorded, count) in RECORDED.iter().zip(counts) {
            mutate_one(small, recorded, count, thumbnails, seed, &mut findings);
            findings.print(&format!("{count} mutations of {} with {recorded:?}", small.model));
        }
    }
    findings.found
}

fn mutate_one(
    small: &Small,
    recorded: &str,
    count: usize,
    thumbnails: usize,
    seed: u64,
    findings: &mut Findings,
) {
    let Small { model, keys, start, interval } = *small;
    let manifest = format!("seed = 1\n[model.{model}]\n{keys}[record]\n{recorded}");
    let bytes = record(&manifest, &Interrupt::default()).unwrap();
    let records = Records::of(&bytes);
    let original_folder = tempfile::tempdir().unwrap();
    let original = original_folder.path().join("original.mcap");
    fs::write(&original, &bytes).unwrap();
    assert_eq!(limited(&["verify", original.to_str().unwrap()], 1), Ok(0));
    let output = original_folder.path().join("restored.mcap");
    zoom(&original, interval, Some(&output), &Interrupt::default()).unwrap();
    fs::remove_file(&output).unwrap();
    let filled = fill(&original, Some(&output), &Interrupt::default(), &|_, _| {});
    assert_eq!(filled.is_ok(), recorded.contains("keyframes"));
    let mut numbers = Numbers(seed);
    for first in (0..count).step_by(BATCH) {
        let folder = tempfile::tempdir().unwrap();
        let files: Vec<PathBuf> = (first..count.min(first + BATCH))
            .map(|index| {
                let path = folder.path().join(format!("mutation_{index}.mcap"));
                fs::write(&path, records.mutated(&mut numbers)).unwrap();
                path
            })
            .collect();
        findings.read(&original, &files, |name| {
            format!("[model.{model}]\nstart_from = \"{name}\"\n{start}[record]\nframes = 2\n")
        });
        findings.restore(&files, interval);
        files.iter().take(thumbnails).for_each(|file| findings.draw(file));
        findings.analyze(folder.path(), &files);
    }
}

pub(crate) fn assert_none(findings: &[String]) {
    assert!(findings.is_empty(), "{} findings:\n{}", findings.len(), findings.join("\n"));
}

#[test]
fn mutated_recordings_neither_panic_nor_exhaust_the_machine() {
    let kept = tempfile::tempdir().unwrap();
    assert_none(&mutate([60, 40], 10, 1, kept.path()));
}

#[test]
#[ignore = "a campaign of minutes to hours: set MUTATIONS to the number per model"]
fn full_harness_mutated_recordings() {
    assert_none(&mutate([mutations(2_000); 2], 5, 2, Path::new("target/mutations")));
}
