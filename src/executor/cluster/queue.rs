//! Execution of the plan on a cluster: missing runs are submitted, and finished recordings are counted.
//!
//! Invariant: the folder holds the whole state. The program may end at any time, and the same command continues: queued tasks
//! are not submitted again, lost tasks are.

use crate::executor::cluster::active_tasks::ActiveTasks;
use crate::executor::cluster::scheduler::Engine;
use crate::executor::cluster::silence::Silence;
use crate::executor::cluster::submission::Resources;
use crate::executor::cluster::task::{TaskCommand, dealt, in_intervals};
use crate::executor::observer::ExecutionObserver;
use crate::interrupt::Interrupt;
use crate::outputs::sidecars::{self, Failure};
use crate::plan::totals::seconds_on_slow_processor;
use crate::plan::{Plan, PlannedRun};
use kinetoscope_console::Message;
use kinetoscope_console::text::shown_path;
use kinetoscope_recording::checkpoint;
use kinetoscope_recording::file::partial_path;
use kinetoscope_recording::recorder::Outcome;
use std::collections::HashSet;
use std::fs;
use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::io;
use std::path::Path;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Number of consecutive submissions without progress before the program gives up.
const MAX_FRUITLESS_SUBMISSIONS: u32 = 5;
/// Default number of tasks per plan.
pub const DEFAULT_TASKS: usize = 200;
/// Minimum time limit of a task in minutes, for its start and slow file systems.
const MIN_LIMIT_MIN: u64 = 15;
/// Ratio of a task's time limit to the expected time. A wrong estimate loses no work: a run that reaches the limit resumes from its
/// checkpoint in the next task.
const TIME_MARGIN: f64 = 3.0;
/// Interval at which Ctrl-C is checked.
const INTERRUPT_INTERVAL: Duration = Duration::from_millis(100);

/// Result of a run; `None` while it is queued or running.
pub type Result<'a> = (&'a PlannedRun, Option<std::result::Result<Outcome, Failure>>);

/// Result of the execution of a plan.
#[derive(Debug)]
pub struct End<'a> {
    /// Results of the runs.
    pub results: Vec<Result<'a>>,
    /// Why the cluster does not start the remaining tasks, and the remedy; `None` if it does.
    pub hold_reasons: Option<String>,
}

/// Where tasks leave the results of their runs.
pub trait Results {
    /// Finds what has come since the last call.
    ///
    /// # Errors
    /// A folder that cannot be read or written.
    fn scan(&mut self) -> io::Result<()>;

    /// How a run ended; `None` without a result.
    fn outcome(&self, run: &PlannedRun) -> Option<Outcome>;

    /// Size of what unfinished tasks of these runs have left.
    fn unfinished_bytes(&self, runs: &[&PlannedRun]) -> u64;

    /// A number that changes when tasks of these runs write.
    fn trace(&self, runs: &[&PlannedRun]) -> u64;
}

/// Recordings in a folder.
#[derive(Debug)]
pub struct Recordings<'a> {
    folder: &'a Path,
    names: HashSet<String>,
}

impl<'a> Recordings<'a> {
    /// The recordings in this folder.
    #[must_use]
    pub fn in_folder(folder: &'a Path) -> Self {
        Self { folder, names: HashSet::new() }
    }
}

impl Results for Recordings<'_> {
    fn scan(&mut self) -> io::Result<()> {
        self.names = names_in(self.folder)?;
        Ok(())
    }

    fn outcome(&self, run: &PlannedRun) -> Option<Outcome> {
        let exists = self.names.contains(&run.file_name());
        exists.then(|| run.recorded(self.folder)).flatten()
    }

    fn unfinished_bytes(&self, runs: &[&PlannedRun]) -> u64 {
        let partial = |run: &&PlannedRun| fs::metadata(partial_path(self.folder, &run.stem())).ok();
        runs.iter().filter_map(partial).map(|file| file.len()).sum()
    }

    fn trace(&self, runs: &[&PlannedRun]) -> u64 {
        let mut seen = DefaultHasher::new();
        for run in runs {
            let partial = partial_path(self.folder, &run.stem());
            for file in [checkpoint::path(self.folder, &run.stem()), partial] {
                let file = fs::metadata(file).ok();
                file.map(|file| (file.len(), file.modified().ok())).hash(&mut seen);
            }
        }
        seen.finish()
    }
}

fn names_in(folder: &Path) -> io::Result<HashSet<String>> {
    let entries = fs::read_dir(folder)?;
    Ok(entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok()).collect())
}

/// The options of a submission.
#[derive(Clone, Debug)]
pub struct SubmissionOptions {
    /// The engine that executes the tasks.
    pub engine: Engine,
    /// The part of the command that all tasks share.
    pub command: TaskCommand,
    /// Number of runs that a task executes one after the other; by default it depends on the size of the plan.
    pub runs_per_task: Option<usize>,
    /// Time limit of a task in minutes; by default the plan's estimate, or the site's default if there is none.
    pub time_limit_min: Option<u64>,
}

struct Watch<'a> {
    folder: &'a Path,
    options: &'a SubmissionOptions,
    stored: &'a mut dyn Results,
    results: Vec<Result<'a>>,
    fruitless: u32,
    /// Number of recorded runs and bytes of unfinished recordings at the last submission.
    before: Option<(usize, u64)>,
    /// The last message about held tasks.
    last_message: String,
    silence: Silence,
}

/// Executes the plan's runs on the cluster and returns their results. Returns when all runs have ended, on an interruption, if
/// the cluster loses the tasks repeatedly, or if it does not start any of the remaining tasks.
///
/// # Errors
/// A folder that cannot be read or written, or a cluster that rejects the submission.
pub fn run_all<'a>(
    plan: &'a Plan,
    options: &'a SubmissionOptions,
    stored: &'a mut dyn Results,
    interrupt: &Interrupt,
    progress: &dyn ExecutionObserver,
) -> io::Result<End<'a>> {
    let runs = plan.to_do_by_cost();
    for run in &runs {
        sidecars::remove_failure(&plan.folder, &run.stem())?;
    }
    let results = runs.into_iter().map(|run| (run, None)).collect();
    let mut watch = Watch {
        folder: &plan.folder,
        options,
        stored,
        results,
        fruitless: 0,
        before: None,
        last_message: String::new(),
        silence: Silence::new(options.command.checkpoint_every_s),
    };
    let (started, mut silent) = (Instant::now(), false);
    while !interrupt.is_raised() && watch.results.iter().any(|(_, end)| end.is_none()) {
        // The order matters: a task that ends after this query is found among the recordings.
        match options.engine.live(&plan.folder) {
            Ok(live) => {
                watch.scan_folder()?;
                let ended = watch.results.iter().filter(|(_, end)| end.is_some()).count();
                progress.show_remote(ended, &live.summary());
                if watch.is_held(&live) {
                    // A user may not read the messages for days; therefore, the program ends with an exit code. The tasks
                    // stay queued, and the same command waits for them again.
                    return Ok(End {
                        results: watch.results,
                        hold_reasons: Some(live.hold_reasons),
                    });
                }
                watch.report_hold_reasons(&live.hold_reasons, progress);
                watch.report_silence(live.running, progress);
                if let Err(error) = watch.submit_what_is_missing(&live) {
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

/// Waits 1/50 of the time so far, between 1 and 30 s, to limit the number of queries.
fn rest(so_far: Duration, interrupt: &Interrupt) {
    let until =
        Instant::now() + (so_far / 50).clamp(Duration::from_secs(1), Duration::from_secs(30));
    while Instant::now() < until && !interrupt.is_raised() {
        sleep(INTERRUPT_INTERVAL);
    }
}

impl Watch<'_> {
    /// Scans the folder for results and failure reports.
    fn scan_folder(&mut self) -> io::Result<()> {
        let names = names_in(self.folder)?;
        self.stored.scan()?;
        for (run, end) in self.results.iter_mut().filter(|(_, end)| end.is_none()) {
            if let Some(outcome) = self.stored.outcome(run) {
                *end = Some(Ok(outcome));
            } else if names.contains(&sidecars::failure_name(&run.stem()))
                && let Some(failure) = sidecars::read_failure(self.folder, &run.stem())
                && !failure.is_retryable
            {
                *end = Some(Err(failure));
            }
        }
        Ok(())
    }

    /// Whether only held tasks remain.
    fn is_held(&self, live: &ActiveTasks) -> bool {
        let mut left = self.results.iter().filter(|(_, end)| end.is_none()).peekable();
        left.peek().is_some() && live.is_at_rest() && left.all(|(run, _)| live.has(&run.run_key))
    }

    /// Reports why tasks are held, whenever the reason changes.
    fn report_hold_reasons(&mut self, hold_reasons: &str, progress: &dyn ExecutionObserver) {
        if hold_reasons != self.last_message && !hold_reasons.is_empty() {
            progress.remark(hold_reasons);
        }
        hold_reasons.clone_into(&mut self.last_message);
    }

    /// Reports tasks that run according to the engine and record nothing.
    fn report_silence(&mut self, running: usize, progress: &dyn ExecutionObserver) {
        let mut seen = DefaultHasher::new();
        let left = self.results.iter().filter(|(_, end)| end.is_none());
        let left: Vec<&PlannedRun> = left.map(|(run, _)| *run).collect();
        (left.len(), self.stored.trace(&left)).hash(&mut seen);
        if let Some(message) = self.silence.message(running, seen.finish(), Instant::now()) {
            progress.remark(&message);
        }
    }

    /// Submits the runs without a result and without a task, in job arrays within the site's limit.
    fn submit_what_is_missing(&mut self, live: &ActiveTasks) -> io::Result<()> {
        let missing: Vec<&PlannedRun> = self
            .results
            .iter()
            .filter(|(run, end)| end.is_none() && !live.has(&run.run_key))
            .map(|(run, _)| *run)
            .collect();
        if missing.is_empty() {
            return Ok(());
        }
        if self.is_fruitless(&missing) {
            self.give_up(live);
            return Ok(());
        }
        let usual = self.results.len().div_ceil(DEFAULT_TASKS);
        let runs_per_task = self.options.runs_per_task.unwrap_or(usual);
        let tasks = match self.options.command.is_of_rows {
            true => in_intervals(&missing, runs_per_task, |one, next| live.divide(one, next)),
            false => dealt(&missing, runs_per_task),
        };
        let needed = missing.iter().filter_map(|run| run.estimate()).map(|run| run.memory_bytes);
        let memory_mib = needed.max().unwrap_or_default().div_ceil(1 << 20);
        for array in tasks.chunks(self.options.engine.most_tasks()) {
            let expected: Option<Vec<u64>> =
                array.iter().map(|task| time_limit_min(&task.runs)).collect();
            let longest = expected.and_then(|minutes| minutes.into_iter().max());
            let resources = Resources {
                processors: self.options.command.threads,
                memory_mib,
                time_limit_min: self.options.time_limit_min.or(longest),
            };
            for run in array.iter().flat_map(|task| &task.runs) {
                sidecars::remove_failure(self.folder, &run.stem())?;
            }
            let SubmissionOptions { engine, command, .. } = self.options;
            engine.submit(self.folder, array, command, resources)?;
        }
        Ok(())
    }

    /// Whether several consecutive submissions recorded no byte.
    fn is_fruitless(&mut self, missing: &[&PlannedRun]) -> bool {
        let recorded = self.results.iter().filter(|(_, end)| end.is_some()).count();
        let now = Some((recorded, self.stored.unfinished_bytes(missing)));
        self.fruitless = if self.before == now { self.fruitless + 1 } else { 0 };
        self.before = now;
        self.fruitless >= MAX_FRUITLESS_SUBMISSIONS
    }

    fn give_up(&mut self, live: &ActiveTasks) {
        for (run, end) in self.results.iter_mut().filter(|(_, end)| end.is_none()) {
            if !live.has(&run.run_key) {
                let failure = sidecars::read_failure(self.folder, &run.stem());
                *end = Some(Err(failure.unwrap_or_else(|| Failure {
                    is_retryable: true,
                    message: Message::new(
                        format!(
                            "its task ended {MAX_FRUITLESS_SUBMISSIONS} times without a result"
                        ),
                        format!(
                            "look at the logs in {}, then run the same command again",
                            shown_path(&self.folder.join(".tasks"))
                        ),
                    ),
                })));
            }
        }
    }
}

/// Time limit of a task in minutes; `None` if it cannot be estimated.
fn time_limit_min(runs: &[&PlannedRun]) -> Option<u64> {
    let minutes = (TIME_MARGIN * seconds_on_slow_processor(runs)? / 60.0).ceil() as u64;
    Some(minutes.max(MIN_LIMIT_MIN))
}
