//! Slurm through its commands: one job array per submission, and one line of run keys per index.
//!
//! `sbatch` reads partition, account and similar options from `SBATCH_PARTITION`, `SBATCH_ACCOUNT` …

use crate::executor::cluster::active_tasks::ActiveTasks;
use crate::executor::cluster::engine_command::output_of;
use crate::executor::cluster::squeue::{self, TaskState, hold_reasons};
use crate::executor::cluster::submission::{self, JOB_NAME, Resources};
use crate::executor::cluster::task::{Task, TaskCommand};
use std::io;
use std::path::Path;
use std::process::Command;

/// Slurm's default.
const DEFAULT_ARRAY_SIZE: usize = 1001;
/// Time between SIGTERM and the time limit, in which a task saves its run.
const SECONDS_TO_SAVE: u32 = 30;

/// As [`super::scheduler::Engine::live`].
pub(super) fn live(folder: &Path) -> io::Result<ActiveTasks> {
    let queue = output_of(
        Command::new("squeue")
            .args(["--noheader", "--array", "--me"])
            .arg(format!("--states={}", squeue::STATES))
            .arg(format!("--format={}", squeue::FORMAT)),
    )?;
    let mut live = ActiveTasks::default();
    let mut held = Vec::new();
    let mut submission = String::new();
    let mut lines: Vec<String> = Vec::new();
    for task in squeue::tasks(&queue) {
        let Some(name) = task.name.strip_prefix(JOB_NAME) else { continue };
        if name != submission {
            name.clone_into(&mut submission);
            lines = submission::key_lines(folder, name);
        }
        // Job arrays of other folders have no file of keys in this folder.
        let Some(keys) = lines.get(task.index) else { continue };
        match task.state {
            TaskState::Runs => live.add(keys, true),
            TaskState::Waits => live.add(keys, false),
            TaskState::Held(..) => {
                live.add_held(keys);
                held.push(task);
            }
        }
    }
    live.hold_reasons = hold_reasons(&held);
    Ok(live)
}

/// Maximum number of tasks per job array of the site.
pub(super) fn most_tasks() -> usize {
    let configuration = output_of(Command::new("scontrol").args(["show", "config"]));
    configuration
        .ok()
        .and_then(|text| {
            let line = text.lines().find(|line| line.starts_with("MaxArraySize"))?;
            line.split('=').nth(1)?.trim().parse().ok()
        })
        .filter(|size| *size > 0)
        .unwrap_or(DEFAULT_ARRAY_SIZE)
}

/// As [`super::scheduler::Engine::submit`].
pub(super) fn submit(
    folder: &Path,
    tasks: &[Task<'_>],
    command: &TaskCommand,
    resources: Resources,
) -> io::Result<()> {
    let submission = submission::write(folder, tasks, command, "SLURM_ARRAY_TASK_ID")?;
    let mut sbatch = Command::new("sbatch");
    sbatch
        .args(["--parsable", "--requeue", "--open-mode=append", "--ntasks=1"])
        .arg(format!("--job-name={JOB_NAME}{}", submission.name))
        .arg(format!("--array=0-{}", tasks.len() - 1))
        .arg(format!("--signal=B:TERM@{SECONDS_TO_SAVE}"))
        .arg(format!("--cpus-per-task={}", resources.processors))
        .arg(format!("--mem={}M", resources.memory_mib))
        .arg(format!("--output={}", submission.own_folder.join("%a.log").to_string_lossy()));
    if let Some(minutes) = resources.time_limit_min {
        sbatch.arg(format!("--time={minutes}"));
    }
    output_of(sbatch.arg(submission.script)).map(drop)
}
