//! The plan on a cluster: what is missing is submitted, and the recordings that appear are counted.
//!
//! Nothing is remembered but what lies in the folder. So the program may leave at any time, and the same command takes up
//! the thread: what the cluster has in its queue is not submitted again, what it lost is.

use crate::executor::cluster::active_tasks::ActiveTasks;
use crate::executor::cluster::expected_time;
use crate::executor::cluster::scheduler::Engine;
use crate::executor::cluster::submission::Resources;
use crate::executor::cluster::task::{TaskCommand, dealt};
use crate::executor::progress::ProgressDisplay;
use crate::interrupt::Interrupt;
use crate::outputs::sidecars::{self, Failure};
use crate::plan::{Plan, PlannedRun};
use kinetoscope_recording::file::partial_path;
use kinetoscope_recording::recorder::Outcome;
use std::collections::HashSet;
use std::fs;
use std::io;
use std::path::Path;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Submissions in a row that bring nothing, until the cluster is given up.
const FRUITLESS_SUBMISSIONS: u32 = 5;
/// Tasks of a plan, unless the user says how many runs a task has.
const USUAL_TASKS: usize = 200;
/// How soon Ctrl-C is heard.
const SHORT: Duration = Duration::from_millis(100);

/// What became of a run; `None` where the cluster still has it.
pub type Result<'a> = (&'a PlannedRun, Option<std::result::Result<Outcome, Failure>>);

/// How the wait for a plan ended.
#[derive(Debug)]
pub struct End<'a> {
    /// What became of each run.
    pub results: Vec<Result<'a>>,
    /// Why the cluster will not start what it still has, and what to type; `None` where it will.
    pub hold_reasons: Option<String>,
}

/// How the plan is submitted.
#[derive(Clone, Debug)]
pub struct SubmissionOptions {
    /// Who does the tasks.
    pub engine: Engine,
    /// What all tasks have in common.
    pub command: TaskCommand,
    /// Runs that a task does one after the other; `None` leaves it to the plan's size.
    pub runs_per_task: Option<usize>,
    /// Minutes that a task may take; `None` leaves it to the plan, or to the site where that does not tell.
    pub time_limit_min: Option<u64>,
}

struct Watch<'a> {
    folder: &'a Path,
    options: &'a SubmissionOptions,
    results: Vec<Result<'a>>,
    fruitless: u32,
    /// Runs recorded, and bytes of unfinished recordings, at the last submission.
    before: Option<(usize, u64)>,
    /// What was last said of tasks that are not started until a person acts.
    told: String,
}

/// Does the plan's runs on the cluster, and returns what became of each. Ends when all have an end, when interrupted, when
/// the cluster loses them again and again, or when it will start none of the tasks that are left.
///
/// # Errors
/// A folder that can't be read or written, or a cluster that takes nothing.
pub fn run_all<'a>(
    plan: &'a Plan,
    options: &'a SubmissionOptions,
    interrupt: &Interrupt,
    progress: &ProgressDisplay,
) -> io::Result<End<'a>> {
    let runs = plan.to_do_by_cost();
    for run in &runs {
        sidecars::remove_failure(&plan.folder, &run.stem)?;
    }
    let results = runs.into_iter().map(|run| (run, None)).collect();
    let mut watch = Watch {
        folder: &plan.folder,
        options,
        results,
        fruitless: 0,
        before: None,
        told: String::new(),
    };
    let (started, mut silent) = (Instant::now(), false);
    while !interrupt.is_raised() && watch.results.iter().any(|(_, end)| end.is_none()) {
        // In this order: a task that ends in between is found among the recordings.
        match options.engine.live(&plan.folder) {
            Ok(live) => {
                watch.look()?;
                let ended = watch.results.iter().filter(|(_, end)| end.is_some()).count();
                progress.elsewhere(ended, &live.words());
                if watch.is_held(&live) {
                    // A person may be days away, and nobody may look at what is said here. So who started this hears of it
                    // by an exit code; the tasks stay where they are, and the same command waits for them again.
                    return Ok(End {
                        results: watch.results,
                        hold_reasons: Some(live.hold_reasons),
                    });
                }
                watch.report_hold_reasons(&live.hold_reasons, progress);
                if let Err(error) = watch.submit_what_is_missing(&live.keys) {
                    if live.is_at_rest() {
                        return Err(error);
                    }
                    progress.remark(&format!("{error}. Trying again later"));
                }
                silent = false;
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Err(error),
            Err(error) if !silent => {
                progress.remark(&format!("{error}. Waiting for an answer"));
                silent = true;
            }
            Err(_) => {}
        }
        rest(started.elapsed(), interrupt);
    }
    Ok(End { results: watch.results, hold_reasons: None })
}

/// Waits a fiftieth of the time so far, between one and thirty seconds: a cluster is not to be asked without end.
fn rest(so_far: Duration, interrupt: &Interrupt) {
    let until =
        Instant::now() + (so_far / 50).clamp(Duration::from_secs(1), Duration::from_secs(30));
    while Instant::now() < until && !interrupt.is_raised() {
        sleep(SHORT);
    }
}

impl Watch<'_> {
    /// Looks for recordings and for reports of failures.
    fn look(&mut self) -> io::Result<()> {
        let names: HashSet<String> = fs::read_dir(self.folder)?
            .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
            .collect();
        for (run, end) in self.results.iter_mut().filter(|(_, end)| end.is_none()) {
            if names.contains(&run.file_name())
                && let Some(outcome) = run.recorded(self.folder)
            {
                *end = Some(Ok(outcome));
            } else if names.contains(&sidecars::failure_name(&run.stem))
                && let Some(failure) = sidecars::read_failure(self.folder, &run.stem)
                && !failure.is_retryable
            {
                *end = Some(Err(failure));
            }
        }
        Ok(())
    }

    /// Whether all that is left are tasks that are not started until a person acts.
    fn is_held(&self, live: &ActiveTasks) -> bool {
        let mut left = self.results.iter().filter(|(_, end)| end.is_none()).peekable();
        left.peek().is_some()
            && live.is_at_rest()
            && left.all(|(run, _)| live.keys.contains(run.run_key.as_str()))
    }

    /// Says what hinders tasks while others go on, whenever that has changed.
    fn report_hold_reasons(&mut self, hold_reasons: &str, progress: &ProgressDisplay) {
        if hold_reasons != self.told && !hold_reasons.is_empty() {
            progress.remark(hold_reasons);
        }
        hold_reasons.clone_into(&mut self.told);
    }

    /// Submits the runs that have no end and no task, in job arrays that the site takes.
    fn submit_what_is_missing(&mut self, live: &HashSet<String>) -> io::Result<()> {
        let missing: Vec<&PlannedRun> = self
            .results
            .iter()
            .filter(|(run, end)| end.is_none() && !live.contains(run.run_key.as_str()))
            .map(|(run, _)| *run)
            .collect();
        if missing.is_empty() {
            return Ok(());
        }
        if self.is_fruitless(&missing) {
            self.give_up(live);
            return Ok(());
        }
        let usual = self.results.len().div_ceil(USUAL_TASKS);
        let tasks = dealt(&missing, self.options.runs_per_task.unwrap_or(usual));
        let needed = missing.iter().filter_map(|run| run.estimate()).map(|run| run.memory_bytes);
        let memory_mib = needed.max().unwrap_or_default().div_ceil(1 << 20);
        for array in tasks.chunks(self.options.engine.most_tasks()) {
            let expected: Option<Vec<u64>> =
                array.iter().map(|runs| expected_time::time_limit_min(runs)).collect();
            let longest = expected.and_then(|minutes| minutes.into_iter().max());
            let resources = Resources {
                processors: self.options.command.threads,
                memory_mib,
                time_limit_min: self.options.time_limit_min.or(longest),
            };
            for run in array.iter().flatten() {
                sidecars::remove_failure(self.folder, &run.stem)?;
            }
            let SubmissionOptions { engine, command, .. } = self.options;
            engine.submit(self.folder, array, command, resources)?;
        }
        Ok(())
    }

    /// Whether several submissions in a row brought neither a recording nor a byte of one.
    fn is_fruitless(&mut self, missing: &[&PlannedRun]) -> bool {
        let recorded = self.results.iter().filter(|(_, end)| end.is_some()).count();
        let bytes = missing
            .iter()
            .filter_map(|run| fs::metadata(partial_path(self.folder, &run.stem)).ok())
            .map(|file| file.len())
            .sum();
        let now = Some((recorded, bytes));
        self.fruitless = if self.before == now { self.fruitless + 1 } else { 0 };
        self.before = now;
        self.fruitless >= FRUITLESS_SUBMISSIONS
    }

    fn give_up(&mut self, live: &HashSet<String>) {
        for (run, end) in self.results.iter_mut().filter(|(_, end)| end.is_none()) {
            if !live.contains(run.run_key.as_str()) {
                let failure = sidecars::read_failure(self.folder, &run.stem);
                *end = Some(Err(failure.unwrap_or_else(|| Failure {
                    is_retryable: true,
                    message: format!(
                        "its task ended {FRUITLESS_SUBMISSIONS} times without a recording. \
                         Look at the logs in {}, then run the same command again",
                        self.folder.join(".tasks").display()
                    ),
                })));
            }
        }
    }
}
