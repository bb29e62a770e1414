//! Engines that do tasks on other machines, each through its own commands.

use crate::executor::cluster::task::TaskCommand;
use crate::executor::cluster::{hyperqueue, slurm};
use crate::plan::PlannedRun;
use std::collections::HashSet;
use std::io;
use std::path::Path;
use std::process::Command;

/// Jobs of this program are named so, and then by their submission.
pub(super) const JOB_NAME: &str = "kinetoscope-";

/// Who does tasks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Engine {
    /// Slurm: a job array a submission.
    Slurm,
    /// HyperQueue: a job of tasks a submission.
    HyperQueue,
}

/// What a task asks of the engine.
#[derive(Clone, Copy, Debug)]
pub struct Resources {
    /// Processors.
    pub processors: usize,
    /// Memory.
    pub memory_mib: u64,
    /// Minutes; `None` is the site's default.
    pub time_limit_min: Option<u64>,
}

/// The tasks that the engine has of one plan.
#[derive(Debug, Default)]
pub struct ActiveTasks {
    /// The run keys of their runs.
    pub keys: HashSet<String>,
    /// Tasks that run now.
    pub running: usize,
    /// Tasks that wait, and will be started.
    pub waiting: usize,
    /// Tasks that are not started until a person acts.
    pub held: usize,
    /// Why those are not, and what to type; empty if there are none.
    pub hold_reasons: String,
}

impl ActiveTasks {
    /// Adds a task that runs or will: its line of run keys, and whether it runs.
    pub(super) fn add(&mut self, keys: &str, runs: bool) {
        self.add_keys(keys);
        if runs { self.running += 1 } else { self.waiting += 1 }
    }

    /// Adds a task that is not started until a person acts: its line of run keys.
    pub(super) fn add_held(&mut self, keys: &str) {
        self.add_keys(keys);
        self.held += 1;
    }

    fn add_keys(&mut self, keys: &str) {
        self.keys.extend(keys.split(',').map(str::to_owned));
    }

    /// Whether nothing goes on unless a person acts or more is submitted.
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        self.running + self.waiting == 0
    }

    /// How many tasks there are of each kind.
    #[must_use]
    pub fn words(&self) -> String {
        let words = format!("{} tasks running, {} waiting", self.running, self.waiting);
        if self.held == 0 { words } else { format!("{words}, {} held back", self.held) }
    }
}

impl Engine {
    /// Asks which tasks the engine has of the plan that records into `folder`.
    ///
    /// # Errors
    /// An engine that does not answer: then nothing is known, and nothing must be concluded.
    pub fn live(self, folder: &Path) -> io::Result<ActiveTasks> {
        match self {
            Self::Slurm => slurm::live(folder),
            Self::HyperQueue => hyperqueue::live(folder),
        }
    }

    /// The most tasks that one submission may have.
    #[must_use]
    pub fn most_tasks(self) -> usize {
        match self {
            Self::Slurm => slurm::most_tasks(),
            Self::HyperQueue => hyperqueue::MOST_TASKS,
        }
    }

    /// Submits tasks together.
    ///
    /// # Errors
    /// A folder that can't be written, or what the engine says against it.
    pub fn submit(
        self,
        folder: &Path,
        tasks: &[Vec<&PlannedRun>],
        command: &TaskCommand,
        resources: Resources,
    ) -> io::Result<()> {
        match self {
            Self::Slurm => slurm::submit(folder, tasks, command, resources),
            Self::HyperQueue => hyperqueue::submit(folder, tasks, command, resources),
        }
    }
}

/// What a command prints; an error with its own words if it fails.
pub(super) fn answer(command: &mut Command) -> io::Result<String> {
    let name = command.get_program().to_string_lossy().into_owned();
    let output = command.output().map_err(|error| {
        let next = match error.kind() {
            io::ErrorKind::NotFound => ". Put it on the PATH, as the site's modules may do",
            _ => "",
        };
        io::Error::new(error.kind(), format!("{name}: {error}{next}"))
    })?;
    let printed = String::from_utf8_lossy(&output.stdout).into_owned();
    if !output.status.success() {
        let words = String::from_utf8_lossy(&output.stderr);
        let words = if words.trim().is_empty() { printed.as_str() } else { &words };
        return Err(io::Error::other(format!("{name}: {}", words.trim())));
    }
    Ok(printed)
}
