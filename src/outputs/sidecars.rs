//! The side files of recordings: the experiment as executed, the viewer's layout, and host and timing of each run.

use crate::plan::Plan;
use crate::run::RunReport;
use crate::run::resources::memory::memory_bytes;
use kinetoscope_console::Message;
use kinetoscope_console::text::one_line;
use kinetoscope_files::atomic_file::{remove_if_exists, replace, replace_unsynced};
use kinetoscope_files::regular_file::{
    MAX_EXPERIMENT_RECORD_BYTES, MAX_SIDE_FILE_BYTES, read, read_text,
};
use kinetoscope_manifest::{Experiment, ExperimentRecord, RunKey, TimingTable};
use kinetoscope_recording::layout::{
    have_one_time_scale, shows_states, with_states, without_time_scale,
};
use serde::Serialize;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use std::time::{SystemTime, UNIX_EPOCH};

/// Writes `experiment.toml`: name, description, checks, sweep and replicates as executed, with the files and keys of the runs.
///
/// # Errors
/// A folder that cannot be written.
pub fn write_experiment(
    experiment: &Experiment,
    folder: &Path,
    files: impl IntoIterator<Item = (String, RunKey)>,
) -> io::Result<()> {
    write_record(ExperimentRecord::new(experiment, files), folder)
}

/// Writes `experiment.toml` without the files and keys of the runs.
///
/// # Errors
/// A folder that cannot be written.
pub fn write_experiment_without_runs(experiment: &Experiment, folder: &Path) -> io::Result<()> {
    write_record(ExperimentRecord::without_runs(experiment), folder)
}

fn write_record(record: ExperimentRecord, folder: &Path) -> io::Result<()> {
    update(&folder.join("experiment.toml"), record.to_toml().as_bytes())
}

/// File name of an experiment's layout: a viewer lists an imported layout by its file name.
#[must_use]
pub fn layout_name(folder: &Path) -> String {
    let experiment = folder.file_name().unwrap_or_default().to_string_lossy();
    format!("{experiment}.layout.json")
}

/// Writes `NAME.layout.json` for the run with the largest view, so that every run of a sweep fits it. A plan whose runs are all
/// finished keeps the existing layout.
///
/// # Errors
/// A folder that cannot be written.
pub fn write_layout(plan: &Plan) -> io::Result<()> {
    let Some(layout) = &plan.layout else { return Ok(()) };
    let path = plan.folder.join(layout_name(&plan.folder));
    let mut layout = layout.clone();
    if plan.finished().next().is_some() {
        // Finished runs have the time scale and the drawings of the existing layout.
        let existing = read_text(&path, MAX_SIDE_FILE_BYTES).unwrap_or_default();
        if !have_one_time_scale(&existing, &layout) {
            layout = without_time_scale(&layout).unwrap_or(layout);
        }
        if shows_states(&existing) {
            layout = with_states(&layout).unwrap_or(layout);
        }
    }
    update(&path, layout.as_bytes())
}

/// Replaces a file unless it has these contents already, so that a start that has nothing to do writes nothing.
fn update(path: &Path, contents: &[u8]) -> io::Result<()> {
    match read(path, MAX_EXPERIMENT_RECORD_BYTES) {
        Ok(existing) if existing == contents => Ok(()),
        Ok(_) | Err(_) => replace(path, contents).map_err(|error| {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            io::Error::new(error.kind(), format!("{}: {error}", one_line(&name)))
        }),
    }
}

/// Writes `timing.json` to the folder of the experiment's recordings and returns its path.
///
/// # Errors
/// A folder that cannot be written.
pub fn write_timing(output: &Path, table: &TimingTable) -> io::Result<PathBuf> {
    let folder = output.join(&table.experiment);
    fs::create_dir_all(&folder)?;
    let path = folder.join(TimingTable::FILE);
    replace(&path, table.to_json()?.as_bytes())?;
    Ok(path)
}

#[derive(Serialize)]
struct Host<'a> {
    recording: &'a str,
    program_version: &'static str,
    host: Option<String>,
    operating_system: &'static str,
    architecture: &'static str,
    processors: Option<usize>,
    jobs_side_by_side: usize,
    finished_unix_time_s: Option<u64>,
    wall_time_s: f64,
    steps_or_events: u64,
    steps_or_events_per_s: f64,
    frames: u64,
    bytes: u64,
    peak_memory_of_the_program_bytes: Option<u64>,
}

/// Asked once: a program of many short runs would make twenty calls of the system for each.
static MACHINE: LazyLock<Machine> = LazyLock::new(|| Machine {
    name: read_text(Path::new("/proc/sys/kernel/hostname"), MAX_SIDE_FILE_BYTES)
        .ok()
        .map(|name| name.trim().into()),
    processors: std::thread::available_parallelism().ok().map(usize::from),
});

/// What does not change between runs.
struct Machine {
    name: Option<String>,
    processors: Option<usize>,
}

/// Writes `STEM.host.json`: machine and speed of a run. No physical metric reads it.
///
/// # Errors
/// A folder that cannot be written.
pub fn write_host(folder: &Path, stem: &str, report: &RunReport, jobs: usize) -> io::Result<()> {
    let wall_time_s = report.wall_time.as_secs_f64();
    let host = Host {
        recording: &format!("{stem}.mcap"),
        program_version: env!("CARGO_PKG_VERSION"),
        host: MACHINE.name.clone(),
        operating_system: std::env::consts::OS,
        architecture: std::env::consts::ARCH,
        processors: MACHINE.processors,
        jobs_side_by_side: jobs,
        finished_unix_time_s: SystemTime::now()
            .duration_since(UNIX_EPOCH)
            .ok()
            .map(|t| t.as_secs()),
        wall_time_s,
        steps_or_events: report.work,
        steps_or_events_per_s: report.work as f64 / wall_time_s,
        frames: report.frames,
        bytes: report.bytes,
        peak_memory_of_the_program_bytes: memory_bytes("/proc/self/status", "VmHWM"),
    };
    let text = serde_json::to_string_pretty(&host)?;
    // Not synced, because a lost file has no consequence.
    replace_unsynced(&folder.join(format!("{stem}.host.json")), text.as_bytes())
}

/// A run without a recording, as its task reports it in `STEM.failed.txt`: the class of the exit code, the reason, and on
/// the last line, after `help: `, the next step.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Failure {
    /// Whether the same run may succeed later.
    pub is_retryable: bool,
    /// The reason and the next step, for the user.
    pub message: Message,
}

/// What divides the reason from the next step in a task's failure report, as a [`Message`] is formatted.
const START_OF_HELP: &str = "\nhelp: ";

/// File name of a task's failure report.
#[must_use]
pub fn failure_name(stem: &str) -> String {
    format!("{stem}.failed.txt")
}

/// Writes `STEM.failed.txt`.
///
/// # Errors
/// A folder that cannot be written.
pub fn write_failure(folder: &Path, stem: &str, failure: &Failure) -> io::Result<()> {
    let class = if failure.is_retryable { "retryable" } else { "final" };
    let text = format!("{class}\n{}\n", failure.message);
    replace(&folder.join(failure_name(stem)), text.as_bytes())
}

/// Reads `STEM.failed.txt`; `None` if it cannot be read.
#[must_use]
pub fn read_failure(folder: &Path, stem: &str) -> Option<Failure> {
    let text = read_text(&folder.join(failure_name(stem)), MAX_SIDE_FILE_BYTES).ok()?;
    let (class, text) = text.trim_end().split_once('\n')?;
    let message = match text.rsplit_once(START_OF_HELP) {
        Some((what, help)) => Message::new(what, help),
        None => text.into(),
    };
    Some(Failure { is_retryable: class == "retryable", message })
}

/// Removes `STEM.failed.txt` of an earlier attempt.
///
/// # Errors
/// A folder that cannot be written.
pub fn remove_failure(folder: &Path, stem: &str) -> io::Result<()> {
    remove_if_exists(&folder.join(failure_name(stem)))
}
