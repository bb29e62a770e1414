//! What the runs of a plan take together: disk space, memory and time.

use crate::interrupt::Interrupt;
use crate::plan::{Plan, PlannedRun};
use crate::run::resources::SPEED_OF_SLOW_PROCESSOR;
use crate::run::resources::time::measured_seconds;
use kinetoscope_recording::file;
use std::fs;

/// Time of a run on one core in addition to its physics and its frames: its start, its files and their names. This and the next number follow from
/// the bench `whole_runs -- tiny`, whose header states its results: with two jobs, a thousand runs of a gas take 0.96 s with 21 frames
/// and 2.6 s with 201; those of a packing with 3 frames, 0.63 s.
const SECONDS_PER_RUN: f64 = 1.5e-3;
/// Time of a frame of few particles on one core.
const SECONDS_PER_FRAME: f64 = 1.8e-5;

/// The expected time of a plan's execution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExpectedTime {
    /// Seconds from the call of the program to the end.
    pub total_s: f64,
    /// Seconds of it before the first run, in which the starts are built.
    pub preparation_s: f64,
}

impl Plan {
    /// Upper estimate of the bytes still to be written.
    #[must_use]
    pub fn bytes_to_write(&self) -> u64 {
        let estimates = self.runs.iter().filter_map(PlannedRun::estimate);
        estimates.map(|estimate| estimate.bytes).fold(0, u64::saturating_add)
    }

    /// Upper estimate of the bytes that the `jobs` largest recordings still need. The part of an interrupted run on the disk is
    /// subtracted.
    #[must_use]
    pub fn bytes_at_once(&self, jobs: usize) -> u64 {
        let needed = |run: &PlannedRun| {
            let left = fs::metadata(file::partial_path(&self.folder, &run.stem()));
            let there = left.map_or(0, |file| file.len());
            run.estimate().map(|estimate| estimate.bytes.saturating_sub(there))
        };
        largest(self.runs.iter().filter_map(needed).collect(), jobs)
    }

    /// Upper estimate of the memory of `jobs` runs in parallel.
    #[must_use]
    pub fn memory_at_once(&self, jobs: usize) -> u64 {
        let estimates = self.runs.iter().filter_map(PlannedRun::estimate);
        largest(estimates.map(|estimate| estimate.memory_bytes).collect(), jobs)
    }

    /// The time that the runs take on this machine with `jobs` in parallel: their starts as this plan measured them, the physics from a
    /// measurement of the costliest run, and a constant time for each run and frame; `None` if nothing could be measured, or after an
    /// interrupt. The frames of many particles take longer.
    #[must_use]
    pub fn expected_time(&self, jobs: usize, interrupt: &Interrupt) -> Option<ExpectedTime> {
        let runs = self.to_do_by_cost();
        let costliest = runs.first()?;
        let overheads: Vec<f64> = runs
            .iter()
            .map(|run| {
                let frames = run.estimate().map_or(0, |estimate| estimate.frames);
                SECONDS_PER_RUN + frames as f64 * SECONDS_PER_FRAME + rebuilt_s(run, runs.len())
            })
            .collect();
        let preparation_s = in_parallel(
            runs.iter().map(|run| run.preparation_s),
            std::thread::available_parallelism().map_or(1, usize::from),
        );
        let start = costliest.take_start();
        let longest = measured_seconds(&costliest.run.manifest, start, interrupt)?;
        let cost = |run: &PlannedRun| run.estimate().map_or(0.0, |estimate| estimate.relative_cost);
        let per_cost = longest / cost(costliest);
        let all =
            runs.iter().zip(&overheads).map(|(run, overhead)| per_cost * cost(run) + overhead);
        let total_s = preparation_s + in_parallel(all, jobs);
        total_s.is_finite().then_some(ExpectedTime { total_s, preparation_s })
    }
}

/// Seconds in which a start is built once more, because a plan of `runs` runs does not keep it; that of the only run is kept.
fn rebuilt_s(run: &PlannedRun, runs: usize) -> f64 {
    let is_built_again = runs > 1 && !run.has_start();
    if is_built_again { run.preparation_s } else { 0.0 }
}

/// The time of these runs one after the other on a slow processor, with their starts, which this plan measured; `None` if the work of a run
/// is not known before.
pub(crate) fn seconds_on_slow_processor(runs: &[&PlannedRun]) -> Option<f64> {
    let seconds = |run: &&PlannedRun| {
        let start = (run.preparation_s + rebuilt_s(run, runs.len())) / SPEED_OF_SLOW_PROCESSOR;
        Some(run.estimate()?.seconds_on_slow_processor? + start)
    };
    runs.iter().map(seconds).sum()
}

/// The time of works of these seconds, with `jobs` in parallel.
fn in_parallel(seconds: impl Iterator<Item = f64>, jobs: usize) -> f64 {
    let (mut sum, mut longest) = (0.0, 0.0);
    for seconds in seconds {
        sum += seconds;
        longest = if seconds > longest { seconds } else { longest };
    }
    let shared = sum / jobs as f64;
    if shared > longest { shared } else { longest }
}

/// Sum of the `count` largest numbers of bytes.
fn largest(mut bytes: Vec<u64>, count: usize) -> u64 {
    bytes.sort_unstable_by(|one, other| other.cmp(one));
    bytes.into_iter().take(count).fold(0, u64::saturating_add)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may panic")]
mod tests {
    use super::*;

    /// Law: the time of many tiny runs is at least that of their files and frames.
    /// Setup: 1000 runs of a packing of two discs, whose physics takes microseconds.
    #[test]
    fn expected_time_includes_the_start_and_the_files_of_each_run() {
        let output = tempfile::tempdir().unwrap();
        let expected = |replicates: u32| {
            let text = format!(
                "seed = 1\nreplicates = {replicates}\n[model.packing]\ndiscs = 2\nevents_per_disc = 1\n[record]\nframes = 1\n"
            );
            let experiment = kinetoscope_manifest::parse(&text, "many.toml", &[]).unwrap();
            let plan = Plan::new(&experiment, output.path(), false, &Interrupt::default());
            plan.expected_time(2, &Interrupt::default()).unwrap().total_s
        };
        let least = SECONDS_PER_RUN + 2.0 * SECONDS_PER_FRAME;
        assert!(expected(1) >= least);
        assert!(expected(1000) >= 500.0 * least);
    }

    /// Law: the starts are built before the first run, on all processors; one that is not kept is built once more, unless it is the only one.
    /// Setup: starts of microseconds, whose measured time is replaced by hours.
    #[test]
    fn expected_time_includes_the_preparation_of_the_starts() {
        let output = tempfile::tempdir().unwrap();
        let processors = std::thread::available_parallelism().unwrap().get() as f64;
        let expected = |replicates: u32, is_kept: bool| {
            let text = format!(
                "seed = 1\nreplicates = {replicates}\n[model.packing]\ndiscs = 2\nevents_per_disc = 1\n[record]\nframes = 1\n"
            );
            let experiment = kinetoscope_manifest::parse(&text, "many.toml", &[]).unwrap();
            let mut plan = Plan::new(&experiment, output.path(), false, &Interrupt::default());
            for run in &mut plan.runs {
                run.preparation_s = 1e5;
                drop((!is_kept).then(|| run.take_start()));
            }
            plan.expected_time(1, &Interrupt::default()).unwrap()
        };
        let is_near = |value: f64, expected: f64| (value - expected).abs() < 1e3;
        let at_once = |runs: f64| if runs < processors { 1e5 } else { 1e5 * runs / processors };
        for (runs, is_kept, built_again) in
            [(1, true, 0.0), (1, false, 0.0), (8, true, 0.0), (8, false, 8e5)]
        {
            let expected = expected(runs, is_kept);
            let preparation = at_once(f64::from(runs));
            assert!(is_near(expected.preparation_s, preparation), "{expected:?}");
            assert!(is_near(expected.total_s, preparation + built_again), "{expected:?}");
        }
    }

    /// Law: a task of a cluster builds the starts of its runs on a slow processor, and those that it does not keep once more, unless it has
    /// one run. Setup: runs of microseconds; the measured time of their starts is replaced by hours.
    #[test]
    fn time_on_a_slow_processor_includes_the_starts() {
        let output = tempfile::tempdir().unwrap();
        let text = "seed = 1\nreplicates = 8\n[model.packing]\ndiscs = 2\nevents_per_disc = 1\n[record]\nframes = 1\n";
        let experiment = kinetoscope_manifest::parse(text, "many.toml", &[]).unwrap();
        let mut plan = Plan::new(&experiment, output.path(), false, &Interrupt::default());
        for run in &mut plan.runs {
            run.preparation_s = 1e5;
        }
        let expect = |runs: &[&PlannedRun], expected: f64| {
            let seconds = seconds_on_slow_processor(runs).unwrap();
            assert!((seconds - expected).abs() < 1e3, "{seconds} instead of {expected}");
        };
        expect(&plan.to_do(), 8e6);
        plan.runs.iter().for_each(|run| drop(run.take_start()));
        expect(&plan.to_do(), 16e6);
        expect(&plan.to_do()[..1], 1e6);
    }

    /// A disk with exactly the missing space must suffice after it was full.
    #[test]
    fn partial_recording_reduces_the_space_needed() {
        let output = tempfile::tempdir().unwrap();
        let experiment =
            kinetoscope_manifest::parse("seed = 1\n[model.gas]\n", "kept.toml", &[]).unwrap();
        let plan = Plan::new(&experiment, output.path(), false, &Interrupt::default());
        let whole = plan.bytes_at_once(1);
        fs::create_dir_all(&plan.folder).unwrap();
        let partial = file::partial_path(&plan.folder, &plan.runs[0].stem());
        fs::write(partial, [0; 1000]).unwrap();
        assert_eq!(plan.bytes_at_once(1), whole - 1000);
    }
}
