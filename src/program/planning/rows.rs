//! Rows of runs of which only the metrics are kept, and the time that they take.

use kinetoscope::interrupt::Interrupt;
use kinetoscope::plan::totals::ExpectedTime;
use kinetoscope::run::in_memory::run_with_hash;
use kinetoscope_analysis::{RunRow, row_of_recording};
use kinetoscope_console::{Explained as _, Message};
use kinetoscope_manifest::{Experiment, Run};
use std::time::{Duration, Instant};

/// Time for which runs are executed as a sample of the others.
const SAMPLING: Duration = Duration::from_millis(300);
/// Expected duration of a run up to which it may be in the sample, seconds.
const LONGEST_SAMPLED_S: f64 = 0.05;
/// Number of runs from which on a sample is executed.
const FEWEST_SAMPLED: usize = 100;

/// The row of a run, which is executed and analyzed in memory; `None` after an interrupt.
pub(crate) fn row_of(run: &Run, interrupt: &Interrupt) -> Result<Option<RunRow>, Message> {
    let executed = run_with_hash(run, interrupt).map_err(|error| error.message());
    if interrupt.is_raised() {
        return Ok(None);
    }
    let (recording, messages) = executed?;
    let row = row_of_recording(recording, run.manifest.clone());
    let mut row = row.map_err(|error| error.message)?;
    row.messages = Some(messages);
    Ok(Some(row))
}

/// The time of short runs of which only the metrics are kept: some of them, spread over the sweep, are executed and analyzed.
pub(super) fn sampled(
    experiment: &Experiment,
    jobs: usize,
    expected: ExpectedTime,
    interrupt: &Interrupt,
) -> ExpectedTime {
    if !experiment.keeps_only_metrics() {
        return expected;
    }
    // The start of such a run is built when it is executed.
    let total_s = expected.total_s - expected.preparation_s;
    let expected = ExpectedTime { total_s, preparation_s: 0.0 };
    let runs = &experiment.runs;
    let shared = runs.len() as f64 / jobs as f64;
    let is_short = expected.total_s / shared < LONGEST_SAMPLED_S;
    if !is_short || runs.len() < FEWEST_SAMPLED {
        return expected;
    }
    let per_run = seconds_per_run(runs, interrupt);
    per_run.map_or(expected, |seconds| ExpectedTime { total_s: seconds * shared, ..expected })
}

/// The mean time of runs of which only the metrics are kept, from a sample that is executed; `None` after an interrupt or an error.
pub(crate) fn seconds_per_run(runs: &[Run], interrupt: &Interrupt) -> Option<f64> {
    let (started, mut executed) = (Instant::now(), 0.0_f64);
    while started.elapsed() < SAMPLING && !interrupt.is_raised() {
        // Multiples of the golden section are spread over the sweep, however many there are.
        let at = (executed * 0.618_033_988_749_895).fract() * runs.len() as f64;
        row_of(&runs[at as usize], interrupt).ok()?;
        executed += 1.0;
    }
    (!interrupt.is_raised()).then(|| started.elapsed().as_secs_f64() / executed)
}
