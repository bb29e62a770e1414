//! Slurm through its own commands: one job array a submission, a line of content keys an index.
//!
//! Partition, account and the like are Slurm's own business: `sbatch` reads them from `SBATCH_PARTITION`, `SBATCH_ACCOUNT` …

use crate::executor::task::{TaskCommand, keys, quoted};
use crate::plan::PlannedRun;
use crate::side_files::replace;
use sha2::{Digest as _, Sha256};
use std::collections::HashSet;
use std::fmt::Write as _;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Job arrays of this program are named so, and then by their submission.
const JOB_NAME: &str = "kinetoscope-";
/// Slurm's own default where a site says nothing.
const USUAL_ARRAY_SIZE: usize = 1001;
/// Before its time limit a task hears SIGTERM, saves its run and ends.
const SECONDS_TO_SAVE: u32 = 30;

/// What a task asks of the cluster.
#[derive(Clone, Copy, Debug)]
pub struct Resources {
    /// Processors.
    pub processors: usize,
    /// Memory.
    pub memory_mib: u64,
    /// Minutes; `None` is the site's default.
    pub time_limit_min: Option<u64>,
}

/// The tasks that Slurm has of one plan.
#[derive(Debug, Default)]
pub struct Live {
    /// The content keys of their runs.
    pub keys: HashSet<String>,
    /// Tasks that run now.
    pub running: usize,
    /// Tasks that wait.
    pub waiting: usize,
}

/// The folder of submissions below that of the recordings.
fn submissions(folder: &Path) -> PathBuf {
    folder.join(".tasks")
}

/// Asks Slurm which tasks it has of the plan that records into `folder`.
///
/// # Errors
/// A Slurm that does not answer: then nothing is known, and nothing must be concluded.
pub fn live(folder: &Path) -> io::Result<Live> {
    let queue = answer(Command::new("squeue").args(["--noheader", "--array", "--me"]).args([
        "--states=PENDING,RUNNING,CONFIGURING,COMPLETING,SUSPENDED,REQUEUED,STOPPED,SIGNALING",
        "--format=%j|%K|%T",
    ]))?;
    let mut live = Live::default();
    let mut submission = String::new();
    let mut lines: Vec<String> = Vec::new();
    for task in queue.lines() {
        let mut parts = task.split('|');
        let (Some(name), Some(index), Some(state)) = (parts.next(), parts.next(), parts.next())
        else {
            continue;
        };
        let Some(name) = name.strip_prefix(JOB_NAME) else { continue };
        if name != submission {
            name.clone_into(&mut submission);
            let text = fs::read_to_string(submissions(folder).join(name).join("keys"));
            lines = text.unwrap_or_default().lines().map(str::to_owned).collect();
        }
        // Job arrays of other folders have no file of keys here.
        let Some(keys) = index.parse().ok().and_then(|index: usize| lines.get(index)) else {
            continue;
        };
        live.keys.extend(keys.split(',').map(str::to_owned));
        if state == "RUNNING" { live.running += 1 } else { live.waiting += 1 }
    }
    Ok(live)
}

/// The most tasks that one job array of the site may have.
#[must_use]
pub fn most_tasks() -> usize {
    let configuration = answer(Command::new("scontrol").args(["show", "config"]));
    configuration
        .ok()
        .and_then(|text| {
            let line = text.lines().find(|line| line.starts_with("MaxArraySize"))?;
            line.split('=').nth(1)?.trim().parse().ok()
        })
        .filter(|size| *size > 0)
        .unwrap_or(USUAL_ARRAY_SIZE)
}

/// Submits tasks as one job array. The same tasks always have the same name, so that a submission whose answer was lost is
/// found again.
///
/// # Errors
/// A folder that can't be written, or what Slurm says against it.
pub fn submit(
    folder: &Path,
    tasks: &[Vec<&PlannedRun>],
    command: &TaskCommand,
    resources: Resources,
) -> io::Result<()> {
    let lines: String = tasks.iter().fold(String::new(), |mut text, runs| {
        // Writing to a string does not fail.
        let _ = writeln!(text, "{}", keys(runs));
        text
    });
    let digest = Sha256::digest(lines.as_bytes());
    let name: String = digest.iter().take(8).map(|byte| format!("{byte:02x}")).collect();
    let place = submissions(folder).join(&name);
    fs::create_dir_all(&place)?;
    // Tasks run in another working folder.
    let place = fs::canonicalize(place)?;
    // A manifest that is edited later does not change what was submitted. Its name may be that of the experiment.
    let manifest = place.join(command.manifest.file_name().unwrap_or_default());
    replace(&manifest, &fs::read(&command.manifest)?)?;
    let keys_file = place.join("keys");
    replace(&keys_file, lines.as_bytes())?;
    let starts_in = command.manifest.parent().map(Path::to_owned);
    let command = TaskCommand { manifest, starts_in, ..command.clone() };
    let script = format!(
        "#!/bin/sh\nkeys=$(sed -n \"$((SLURM_ARRAY_TASK_ID + 1))p\" {})\nexec {}\n",
        quoted(&keys_file.display().to_string()),
        command.line("\"$keys\"")
    );
    let script_file = place.join("task.sh");
    replace(&script_file, script.as_bytes())?;
    let mut sbatch = Command::new("sbatch");
    sbatch
        .args(["--parsable", "--requeue", "--open-mode=append", "--ntasks=1"])
        .arg(format!("--job-name={JOB_NAME}{name}"))
        .arg(format!("--array=0-{}", tasks.len() - 1))
        .arg(format!("--signal=B:TERM@{SECONDS_TO_SAVE}"))
        .arg(format!("--cpus-per-task={}", resources.processors))
        .arg(format!("--mem={}M", resources.memory_mib))
        .arg(format!("--output={}", place.join("%a.log").display()));
    if let Some(minutes) = resources.time_limit_min {
        sbatch.arg(format!("--time={minutes}"));
    }
    answer(sbatch.arg(script_file)).map(|_| ())
}

/// What a command prints; an error with its own words if it fails.
fn answer(command: &mut Command) -> io::Result<String> {
    let name = command.get_program().to_string_lossy().into_owned();
    let output = command
        .output()
        .map_err(|error| io::Error::new(error.kind(), format!("{name}: {error}")))?;
    if !output.status.success() {
        let words = String::from_utf8_lossy(&output.stderr);
        return Err(io::Error::other(format!("{name}: {}", words.trim())));
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}
