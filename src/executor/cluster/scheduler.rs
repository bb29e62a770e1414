//! The engines that execute tasks on other machines, each through its own commands.

use crate::executor::cluster::active_tasks::ActiveTasks;
use crate::executor::cluster::submission::Resources;
use crate::executor::cluster::task::TaskCommand;
use crate::executor::cluster::{hyperqueue, slurm};
use crate::plan::PlannedRun;
use std::io;
use std::path::Path;

/// Who does tasks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Engine {
    /// Slurm: a job array a submission.
    Slurm,
    /// HyperQueue: a job of tasks a submission.
    HyperQueue,
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
