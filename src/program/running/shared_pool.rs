//! Executes the runs of several experiments on this machine: long runs first, so that no processor is idle when one of the
//! experiments ends.

use crate::executor::MAX_THREADS;
use crate::messages::progress::ProgressDisplay;
use crate::messages::{Failure, complain};
use crate::planning::planner::{Planned, parallel_runs};
use crate::running::arguments::{ExecutionArguments, RunArguments};
use crate::running::experiment::{Executed, Execution};
use kinetoscope::executor::local::{self, LocalPool, QueuedRun, Report};
use kinetoscope::interrupt::Interrupt;
use kinetoscope::plan::PlannedRun;
use kinetoscope::run::RunContext;
use kinetoscope_console::Exit;
use std::num::NonZeroUsize;

/// What a signal is answered with.
const INTERRUPTED: &str = "Interrupted. Run the same command again to resume.";

/// Memory for the starts that the plans of waiting experiments keep, by the runs' memory estimates.
const KEPT_STARTS_BYTES: u64 = 256 << 20;

/// Particles from which a run is faster with several threads: a model splits its work into blocks of at least 1024 particles
/// (gas) and 2500 discs (DEM), and two blocks of a gas gain less than a second run does.
const PARTICLES_FOR_THREADS: u64 = 2500;

/// An experiment whose runs are planned.
pub(crate) struct Member<'a> {
    pub(crate) execution: Execution<'a>,
    pub(crate) planned: Planned,
}

impl Member<'_> {
    /// Whether its runs gain nothing from the threads that they would have without other experiments.
    fn shares_processors(&self, jobs: Option<NonZeroUsize>) -> bool {
        let runs = self.planned.plan.to_do();
        let mut estimates = runs.iter().filter_map(|run| run.estimate());
        self.execution.arguments.execution.threads.is_some()
            || self.planned.jobs == parallel_runs(jobs, usize::MAX)
            || estimates.all(|estimate| estimate.particles < PARTICLES_FOR_THREADS)
    }
}

/// Experiments that wait for their execution together, in the order of their manifests.
pub(crate) struct SharedPool<'a> {
    arguments: &'a RunArguments,
    members: Vec<Member<'a>>,
    /// Upper estimate of the bytes of their recordings.
    disk_bytes: u64,
    /// Upper estimate of the memory of the starts that their plans have kept.
    start_bytes: u64,
}

impl<'a> SharedPool<'a> {
    pub(crate) fn new(arguments: &'a RunArguments) -> Self {
        Self { arguments, members: Vec::new(), disk_bytes: 0, start_bytes: 0 }
    }

    /// Takes the experiments that wait.
    pub(crate) fn take(&mut self) -> Self {
        std::mem::replace(self, Self::new(self.arguments))
    }

    /// Whether disk and memory suffice for another experiment.
    pub(crate) fn has_room_for(&self, member: &Member<'_>) -> bool {
        let start_bytes = self.start_bytes.saturating_add(member.planned.plan.kept_bytes());
        self.members.is_empty()
            || (start_bytes <= KEPT_STARTS_BYTES
                && member.execution.disk_shortage(&member.planned, self.disk_bytes).is_none())
    }

    /// Adds an experiment; returns whether others can be executed together with it.
    pub(crate) fn add(&mut self, member: Member<'a>) -> bool {
        let plan = &member.planned.plan;
        self.disk_bytes = self.disk_bytes.saturating_add(plan.bytes_to_write());
        self.start_bytes = self.start_bytes.saturating_add(plan.kept_bytes());
        let is_finished = plan.to_do().is_empty() && self.members.is_empty();
        let is_alone = member.planned.depot.is_some() || self.arguments.live.is_requested();
        self.members.push(member);
        !(is_finished || is_alone)
    }

    /// Executes the runs. Each experiment is concluded when it is finished, in the order of the manifests, while runs of the next ones
    /// are executed.
    pub(crate) fn execute(
        self,
        interrupt: &Interrupt,
        mut conclude: impl FnMut(Result<Executed, Failure>),
    ) {
        if let Some(code) = interrupt.exit_code() {
            complain(INTERRUPTED);
            let ended = |Member { execution, planned }: &Member<'_>| {
                Ok(execution.not_executed(planned, Exit::Signal(code)))
            };
            return self.members.iter().map(ended).for_each(conclude);
        }
        let prepared = |member| Ending::prepared(member, interrupt);
        let mut endings: Vec<Ending<'_>> = self.members.iter().map(prepared).collect();
        let requested = self.arguments.execution.jobs;
        let (shared, alone): (Vec<usize>, Vec<usize>) =
            (0..endings.len()).partition(|index| self.members[*index].shares_processors(requested));
        let runs = endings.iter().map(|ending| ending.left).sum();
        let progress = ProgressDisplay::new(runs, self.arguments.verbosity());
        let mut concluded = 0;
        let mut ended = |endings: &[Ending<'_>]| {
            // The last one is concluded below, when there are no bars.
            while concluded + 1 < endings.len() && endings[concluded].left == 0 {
                endings[concluded].process(interrupt);
                progress.above(|| conclude(endings[concluded].conclude(interrupt)));
                concluded += 1;
            }
        };
        ended(&endings);
        for round in [shared].into_iter().chain(alone.into_iter().map(|index| vec![index])) {
            let executed =
                self.execute_round(&round, &mut endings, interrupt, &progress, &mut ended);
            if let (Err(failure), [index, ..]) = (executed, round.as_slice()) {
                endings[*index].failure = Some(failure);
            }
        }
        progress.close();
        for ending in &endings[concluded..] {
            ending.process(interrupt);
            conclude(ending.conclude(interrupt));
        }
        if interrupt.is_raised() {
            complain(INTERRUPTED);
        }
    }

    /// Executes the runs of some experiments. `ended` is called after each run.
    fn execute_round(
        &self,
        round: &[usize],
        endings: &mut [Ending<'_>],
        interrupt: &Interrupt,
        progress: &ProgressDisplay,
        ended: &mut dyn FnMut(&[Ending<'_>]),
    ) -> Result<(), Failure> {
        let mut queue: Vec<(usize, usize, &PlannedRun)> = Vec::new();
        for member in round {
            let runs = endings[*member].reports.iter().enumerate();
            queue.extend(runs.map(|(index, (run, _))| (*member, index, *run)));
        }
        let ([first, ..], false) = (round, queue.is_empty()) else { return Ok(()) };
        let pool_size = self.pool_size(queue.len());
        // One after the other, the runs of the first experiment end first.
        if round.len() > 1 && pool_size.jobs > NonZeroUsize::MIN {
            queue.sort_by(|(.., one), (.., other)| {
                other.nominal_seconds().total_cmp(&one.nominal_seconds())
            });
        }
        let arguments = self.arguments;
        let live = arguments.live.open(interrupt)?;
        if let Some(live) = &live {
            let plan = &self.members[*first].planned.plan;
            arguments.messages.say_commands(&arguments.live.invitation(live, plan));
        }
        let gnuplot = arguments.live.gnuplot_loop()?;
        let planned: Vec<&Planned> =
            queue.iter().map(|(member, ..)| &self.members[*member].planned).collect();
        let runs: Vec<QueuedRun<'_>> = queue
            .iter()
            .zip(&planned)
            .map(|((.., run), planned)| (*run, planned.plan.folder.as_path()))
            .collect();
        local::run_all(
            &runs,
            pool_size,
            RunContext {
                interrupt,
                checkpoint_every: arguments.execution.checkpoint_every,
                on_frame: &|_, _| {},
                on_written: &|| {},
                live: live.as_ref(),
                gnuplot: gnuplot.as_ref(),
            },
            progress,
            &|index| {
                if let Some(depot) = &planned[index].depot {
                    let (run, folder) = runs[index];
                    depot.put_soon(run, folder, &|| interrupt.is_raised());
                }
            },
            &mut |index, report| {
                let (member, place, _) = queue[index];
                endings[member].take(place, report);
                ended(endings);
            },
        );
        Ok(())
    }

    /// `--threads` is limited by the number of parallel runs.
    fn pool_size(&self, runs: usize) -> LocalPool {
        let ExecutionArguments { jobs, threads, .. } = self.arguments.execution;
        let jobs = parallel_runs(jobs, runs);
        let processors = std::thread::available_parallelism().map_or(1, usize::from);
        let threads =
            threads.map_or(processors / jobs, |threads| threads.get().min(MAX_THREADS / jobs));
        LocalPool {
            jobs: NonZeroUsize::new(jobs).unwrap_or(NonZeroUsize::MIN),
            threads: NonZeroUsize::new(threads).unwrap_or(NonZeroUsize::MIN),
        }
    }
}

/// What the runs of an experiment have left so far.
struct Ending<'a> {
    member: &'a Member<'a>,
    /// The runs in the order in which they are executed without other experiments.
    reports: Vec<(&'a PlannedRun, Option<Report>)>,
    /// Runs without a report.
    left: usize,
    /// Why no run can be executed.
    failure: Option<Failure>,
}

impl<'a> Ending<'a> {
    /// Prepares the folder of the recordings.
    fn prepared(member: &'a Member<'_>, interrupt: &Interrupt) -> Self {
        let failure = member.execution.prepare_folder(&member.planned, interrupt).err();
        let runs = if failure.is_some() { Vec::new() } else { member.planned.plan.to_do_by_cost() };
        let reports: Vec<_> = runs.into_iter().map(|run| (run, None)).collect();
        Self { member, left: reports.len(), reports, failure }
    }

    fn take(&mut self, index: usize, report: Report) {
        self.reports[index].1 = Some(report);
        self.left -= 1;
    }

    fn process(&self, interrupt: &Interrupt) {
        if self.failure.is_none() {
            self.member.execution.process_recordings(&self.member.planned, interrupt);
        }
    }

    fn conclude(&self, interrupt: &Interrupt) -> Result<Executed, Failure> {
        let Member { execution, planned } = self.member;
        let failure = self.failure.clone();
        failure.map_or_else(|| execution.conclude(planned, &self.reports, interrupt), Err)
    }
}
