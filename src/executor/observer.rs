//! The progress of runs, as an executor reports it. The program draws it.

use crate::run::{RunError, RunReport};

/// Receives the progress of all runs, from any thread.
pub trait ExecutionObserver: Sync {
    /// A run starts.
    fn start_run<'a>(&'a self, stem: &str) -> Box<dyn RunObserver + 'a>;

    /// The number of runs finished on other machines, and a message about those in progress.
    fn show_remote(&self, finished: usize, message: &str);

    /// A remark about the execution, such as a scheduler that does not answer.
    fn remark(&self, text: &str);
}

/// Receives the progress of one run.
pub trait RunObserver: Sync {
    /// Frame `done` of `of` is recorded.
    fn frame(&self, done: u64, of: u64);

    /// The run ended.
    fn finish(self: Box<Self>, report: &Result<RunReport, RunError>);
}
