//! Execution of the plan on this machine, with several runs in parallel.

use crate::executor::budget::Budget;
use crate::executor::observer::ExecutionObserver;
use crate::outputs::sidecars;
use crate::plan::PlannedRun;
use crate::run::{RunContext, RunError, RunReport, execute};
use kinetoscope_physics::model::SetupError;
use kinetoscope_recording::recorder::Outcome;
use rayon::ThreadPoolBuilder;
use std::num::NonZeroUsize;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Mutex, PoisonError};
use std::thread::{self, Builder};
use std::time::Duration;

/// Runs whose files wait for the disk, per parallel run, while as many other runs are executed: a tiny run waits for as long as it
/// computes. Only where runs have one thread, because threads are kept for each of them.
const SAVED_PER_JOB: usize = 3;
/// Maximum number of runs that wait so, because each has a thread.
const MAX_SAVED: usize = 48;

/// Time after which reports are passed on.
const BETWEEN_REPORTS: Duration = Duration::from_millis(50);

/// The number of threads. It does not change a byte of a recording.
#[derive(Clone, Copy, Debug)]
pub struct LocalPool {
    /// Number of parallel runs.
    pub jobs: NonZeroUsize,
    /// Number of threads of one model. The recorder of each run has one more thread, which is mostly idle.
    pub threads: NonZeroUsize,
}

impl LocalPool {
    /// Number of threads that execute runs, those whose runs wait for the disk included.
    fn workers(self) -> usize {
        let jobs = self.jobs.get();
        let is_shared = jobs > 1 && self.threads.get() == 1;
        if is_shared { jobs + (jobs * SAVED_PER_JOB).min(MAX_SAVED) } else { jobs }
    }
}

/// What became of a run that was not stopped before its first frame.
pub type Report = Result<RunReport, RunError>;

/// A run to be executed, and the folder of its recording.
pub type QueuedRun<'a> = (&'a PlannedRun, &'a Path);

/// Executes the runs in the given order: at most `jobs` in parallel, without those whose files wait for the disk, and only as many as fit
/// into the memory. The failure of one run does not stop the others. `after` is called for each finished recording, on the thread of its
/// run; `ended` for each report, on the calling thread, while other runs are executed. Both receive the index of the run. After an
/// interrupt, runs have no report if they were not started.
pub fn run_all(
    runs: &[QueuedRun<'_>],
    pool_size: LocalPool,
    context: RunContext<'_>,
    progress: &dyn ExecutionObserver,
    after: &(dyn Fn(usize) + Sync),
    ended: &mut dyn FnMut(usize, Report),
) {
    let next = AtomicUsize::new(0);
    let memory = Budget::of_the_memory();
    let places = Budget::new(pool_size.jobs.get() as u64);
    let work = |reports: Sender<(usize, Report)>| {
        // A pool without this thread would wake another one for each run, and a program of many short runs would wait for it.
        let pool = ThreadPoolBuilder::new().num_threads(pool_size.threads.get());
        let pool = pool.use_current_thread().build();
        loop {
            let place = places.take(1);
            if context.interrupt.is_raised() {
                break;
            }
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some((run, folder)) = runs.get(index) else { break };
            let needed = run.estimate().map_or(0, |estimate| estimate.memory_bytes);
            let held = Mutex::new(Some((place, memory.take(needed))));
            let bar = progress.start_run(&run.stem());
            let on_frame = |done, of| bar.frame(done, of);
            let on_written = || drop(held.lock().unwrap_or_else(PoisonError::into_inner).take());
            let context = RunContext { on_frame: &on_frame, on_written: &on_written, ..context };
            let run_it = || execute(&run.spec(folder), run.take_start(), context);
            // If the pool cannot be built, the run uses the global one.
            let report = pool.as_ref().map_or_else(|_| run_it(), |pool| pool.install(run_it));
            bar.finish(&report);
            if is_stopped(&report) {
                continue;
            }
            if let Ok(report) = &report
                && report.outcome != Outcome::Interrupted
            {
                keep_timing(run, folder, report, pool_size.jobs);
                after(index);
            }
            // The receiver is dropped after the last sender.
            let _ = reports.send((index, report));
        }
    };
    thread::scope(|scope| {
        let (sender, reports) = channel();
        // Closed when the last thread ends.
        let (alive, threads) = channel::<()>();
        let is_started = |_: &usize| {
            let (work, sender, alive) = (&work, sender.clone(), alive.clone());
            let execute = move || {
                work(sender);
                drop(alive);
            };
            Builder::new().spawn_scoped(scope, execute).is_ok()
        };
        let started = (0..pool_size.workers().min(runs.len())).filter(is_started).count();
        // If the system starts no thread, the runs are executed on this one.
        if started == 0 {
            work(sender.clone());
        }
        drop((sender, alive));
        // A report does not wake this thread: each of many short runs would interrupt another one.
        let mut is_over = false;
        while !is_over {
            is_over = threads.recv_timeout(BETWEEN_REPORTS) == Err(RecvTimeoutError::Disconnected);
            reports.try_iter().for_each(|(index, report)| ended(index, report));
        }
    });
}

/// Whether an interrupt stopped a run before its start was complete.
fn is_stopped(report: &Report) -> bool {
    matches!(report, Err(RunError::Setup(error)) if *error == SetupError::stopped())
}

/// Writes the timing file of a finished run.
fn keep_timing(run: &PlannedRun, folder: &Path, report: &RunReport, jobs: NonZeroUsize) {
    if let Err(error) = sidecars::write_host(folder, &run.stem(), report, jobs.get()) {
        let warning = format!("warning: no timing file for {}: {error}", run.stem());
        kinetoscope_console::complain(&warning, false);
    }
}
