//! The plan on this machine: so many runs side by side.

use crate::executor::memory::MemoryBudget;
use crate::executor::progress::ProgressDisplay;
use crate::outputs::sidecars;
use crate::plan::PlannedRun;
use crate::run::{RunContext, RunError, RunReport, execute};
use kinetoscope_recording::recorder::Outcome;
use rayon::ThreadPoolBuilder;
use std::num::NonZeroUsize;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

/// How many threads work, and on what. It does not change a byte of a recording.
#[derive(Clone, Copy, Debug)]
pub struct LocalPool {
    /// Runs side by side.
    pub jobs: NonZeroUsize,
    /// Threads that the model of one run computes with; its recorder has one more, which mostly waits.
    pub threads: NonZeroUsize,
}

/// What became of one run: `None` where an interruption came before its start.
pub type Result<'a> = (&'a PlannedRun, Option<std::result::Result<RunReport, RunError>>);

/// Does the runs in the order of `runs`, at most `jobs` side by side and only as many as fit the memory, and returns what
/// became of each. The failure of one does not stop the others. `after` hears of each run that left a finished recording, on the thread
/// that did it.
pub fn run_all<'a>(
    runs: &[&'a PlannedRun],
    folder: &Path,
    pool_size: LocalPool,
    context: RunContext<'_>,
    progress: &ProgressDisplay,
    after: &(dyn Fn(&PlannedRun) + Sync),
) -> Vec<Result<'a>> {
    let next = AtomicUsize::new(0);
    let memory = MemoryBudget::of_this_machine();
    let finished = Mutex::new(Vec::with_capacity(runs.len()));
    thread::scope(|scope| {
        for _ in 0..pool_size.jobs.get().min(runs.len()) {
            scope.spawn(|| {
                let pool = ThreadPoolBuilder::new().num_threads(pool_size.threads.get()).build();
                while !context.interrupt.is_raised() {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    let Some(run) = runs.get(index) else { break };
                    let needed = run.estimate().map_or(0, |estimate| estimate.memory_bytes);
                    let _memory = memory.take(needed);
                    let bar = progress.start_run(&run.stem);
                    let on_frame = |done, of| bar.frame(done, of);
                    let context = RunContext { on_frame: &on_frame, ..context };
                    let run_it = || execute(run.spec(folder), run.take_start(), context);
                    // Without threads of its own a run has the pool that all share.
                    let report =
                        pool.as_ref().map_or_else(|_| run_it(), |pool| pool.install(run_it));
                    bar.finish(&report);
                    if let Ok(report) = &report
                        && report.outcome != Outcome::Interrupted
                    {
                        keep_timing(run, folder, report, pool_size.jobs);
                        after(run);
                    }
                    finished
                        .lock()
                        .unwrap_or_else(std::sync::PoisonError::into_inner)
                        .push((index, report));
                }
            });
        }
    });
    let finished = finished.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
    let mut results: Vec<Result<'a>> = runs.iter().map(|run| (*run, None)).collect();
    for (index, report) in finished {
        results[index].1 = Some(report);
    }
    results
}

/// Writes the timing file of a run that has ended.
fn keep_timing(run: &PlannedRun, folder: &Path, report: &RunReport, jobs: NonZeroUsize) {
    if let Err(error) = sidecars::write_host(folder, &run.stem, report, jobs.get()) {
        eprintln!("warning: no timing file for {}: {error}", run.stem);
    }
}
