//! Rows of runs of which only the metrics are kept, and the time that they take.

use kinetoscope::interrupt::Interrupt;
use kinetoscope::plan::totals::ExpectedTime;
use kinetoscope::run::in_memory::run_with_hash;
use kinetoscope_analysis::{RunRow, row_of_recording};
use kinetoscope_console::{Explained as _, Message};
use kinetoscope_manifest::{Experiment, Run};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

/// Time for which runs are executed as a sample of the others.
const SAMPLING: Duration = Duration::from_millis(300);
/// Time after which a run of the sample is stopped: its length may not be known before.
const LONGEST_SAMPLING: Duration = Duration::from_secs(2);
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

/// The mean time of runs of which only the metrics are kept, from a sample that is executed; `None` if not one of them ends within
/// [`LONGEST_SAMPLING`], and after an interrupt or an error.
pub(crate) fn seconds_per_run(runs: &[Run], interrupt: &Interrupt) -> Option<f64> {
    let own = interrupt.with_own_stop();
    thread::scope(|scope| {
        let (done, waiting) = channel::<()>();
        let limit = &own;
        scope.spawn(move || {
            if waiting.recv_timeout(LONGEST_SAMPLING) == Err(RecvTimeoutError::Timeout) {
                limit.stop();
            }
        });
        let seconds = mean_seconds(runs, &own);
        drop(done);
        seconds.filter(|_| !interrupt.is_raised())
    })
}

fn mean_seconds(runs: &[Run], interrupt: &Interrupt) -> Option<f64> {
    let (started, mut executed) = (Instant::now(), 0.0_f64);
    while started.elapsed() < SAMPLING {
        // Multiples of the golden section are spread over the sweep, however many there are.
        let at = (executed * 0.618_033_988_749_895).fract() * runs.len() as f64;
        if row_of(runs.get(at as usize)?, interrupt).ok()?.is_none() {
            break;
        }
        executed += 1.0;
    }
    (executed > 0.0).then(|| started.elapsed().as_secs_f64() / executed)
}
