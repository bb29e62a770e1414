//! The engines that execute tasks on other machines, each through its own commands.

use crate::executor::cluster::active_tasks::ActiveTasks;
use crate::executor::cluster::submission::Resources;
use crate::executor::cluster::task::{Task, TaskCommand};
use crate::executor::cluster::{hyperqueue, slurm};
use std::io;
use std::path::Path;

/// An engine that executes tasks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Engine {
    /// Slurm: one job array per submission.
    Slurm,
    /// HyperQueue: one job per submission.
    HyperQueue,
}

impl Engine {
    /// Queries the tasks of the plan that records into `folder`.
    ///
    /// # Errors
    /// An engine that does not answer. The state of the tasks is then unknown.
    pub fn live(self, folder: &Path) -> io::Result<ActiveTasks> {
        match self {
            Self::Slurm => slurm::live(folder),
            Self::HyperQueue => hyperqueue::live(folder),
        }
    }

    /// Maximum number of tasks per submission.
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
    /// A folder that cannot be written, or the engine's error.
    pub fn submit(
        self,
        folder: &Path,
        tasks: &[Task<'_>],
        command: &TaskCommand,
        resources: Resources,
    ) -> io::Result<()> {
        match self {
            Self::Slurm => slurm::submit(folder, tasks, command, resources),
            Self::HyperQueue => hyperqueue::submit(folder, tasks, command, resources),
        }
    }
}
