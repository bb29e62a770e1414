//! Reruns of the manifests of answers in memory, within stated limits.

use crate::grading::answer::Answer;
use crate::grading::key::Key;
use crate::grading::limits::Limits;
use crate::messages::Failure;
use crate::messages::exit::of_run_error;
use kinetoscope::interrupt::Interrupt;
use kinetoscope::run::in_memory::run_with_hash;
use kinetoscope::verify::lock_file::RunHashes;
use kinetoscope_analysis::analyze;
use kinetoscope_analysis::run::RunStatus;
use kinetoscope_console::{Exit, Explained as _};
use kinetoscope_manifest::{Coordinate, Experiment, run_key};
use kinetoscope_physics::kind_of;
use kinetoscope_recording::channels::SCHEMA_VERSION;
use std::sync::mpsc;
use std::thread;
use std::time::Duration;

/// A metric of a run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MetricValue {
    pub(crate) name: &'static str,
    pub(crate) value: f64,
    pub(crate) error: Option<f64>,
    pub(crate) theory: Option<f64>,
}

/// A run that has been repeated.
#[derive(Debug)]
pub(crate) struct RerunPoint {
    /// Its point in the sweep.
    pub(crate) coordinates: Vec<Coordinate>,
    /// Its metrics that have a value.
    pub(crate) metrics: Vec<MetricValue>,
}

/// The runs of an answer, repeated.
#[derive(Debug)]
pub(crate) struct Rerun {
    /// Hash of the messages of all runs.
    pub(crate) hash: String,
    /// The runs in the order of the sweep.
    pub(crate) runs: Vec<RerunPoint>,
    /// What failed in a run.
    pub(crate) fault: Option<String>,
}

/// The run keys of an experiment: equal keys, equal runs.
pub(crate) fn run_keys(experiment: &Experiment) -> String {
    let key = |run: &kinetoscope::Run| {
        let version = kind_of(&run.manifest.model).physics_version;
        run_key(&run.manifest.canonical(), version, SCHEMA_VERSION).as_str().to_owned()
    };
    experiment.runs.iter().map(key).collect::<Vec<_>>().join(" ")
}

/// Executes the runs of an answer, starts included, within the limits. With a key, they are those of its exercise.
pub(crate) fn rerun(
    answer: &Answer,
    key: Option<&Key>,
    interrupt: &Interrupt,
) -> Result<Rerun, Failure> {
    let limits = Limits::new(&answer.experiment, key);
    rerun_within(Duration::from_secs(limits.seconds()), &limits, answer, interrupt)
}

fn rerun_within(
    time: Duration,
    limits: &Limits<'_>,
    answer: &Answer,
    interrupt: &Interrupt,
) -> Result<Rerun, Failure> {
    let stop = interrupt.with_own_stop();
    thread::scope(|scope| {
        let (finished, wait) = mpsc::channel::<()>();
        let clock = stop.clone();
        scope.spawn(move || {
            if wait.recv_timeout(time) == Err(mpsc::RecvTimeoutError::Timeout) {
                clock.stop();
            }
        });
        let rerun = limits
            .check(&answer.experiment, &stop)
            .and_then(|()| execute(&answer.experiment, &stop));
        drop(finished);
        // A stop ends a start and a run with errors of their own.
        match stop.is_raised() {
            true => Err(limits.exceeded(&limits.too_slow())),
            false => rerun,
        }
    })
}

fn execute(experiment: &Experiment, stop: &Interrupt) -> Result<Rerun, Failure> {
    let (mut hashes, mut runs, mut fault) = (Vec::new(), Vec::new(), None);
    for run in &experiment.runs {
        let executed = run_with_hash(run, stop);
        let (recording, hash) =
            executed.map_err(|error| Failure::of(of_run_error(&error), error.message()))?;
        hashes.push(hash.iter().map(|byte| format!("{byte:02x}")).collect());
        let analysis =
            analyze(&recording).map_err(|error| Failure::of(Exit::RunFailed, error.message))?;
        if let RunStatus::Fault(what) = &analysis.ending {
            fault = Some(what.clone());
        }
        let with_value = analysis.measurements.iter().filter(|one| one.reason.is_none());
        let metrics = with_value.map(|one| MetricValue {
            name: one.name(),
            value: one.estimate.value,
            error: one.estimate.standard_error,
            theory: one.theory.map(|theory| theory.value),
        });
        runs.push(RerunPoint { coordinates: run.coordinates.to_vec(), metrics: metrics.collect() });
    }
    Ok(Rerun { hash: RunHashes::new(&[], &hashes).messages, runs, fault })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A start that compresses 20,000 discs to a packing fraction of 0.89, for many minutes.
    const ENDLESS_START: &str = r#"
seed = 1
[model.packing]
discs = 20000
width = 300.0
height = 300.0
radius = 1.127
boundary = "periodic"
placement = "compressed"
events_per_disc = 10
[record]
frames = 2
[exercise]
name = "hard_discs/dense_fluid"
value = 1.0
unit = "1"
standard_error = 0.1
"#;

    /// Guarantee: the limit of the time includes the starts, so that no hand-in stops a class.
    #[test]
    fn start_that_takes_long_is_within_the_limit_of_the_time() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.toml");
        std::fs::write(&path, ENDLESS_START).unwrap();
        let answer = Answer::read(&path).unwrap();
        let limits = Limits::new(&answer.experiment, None);
        let time = Duration::from_millis(200);
        let failure = rerun_within(time, &limits, &answer, &Interrupt::default());
        let text = failure.unwrap_err().plain_text();
        assert!(text.contains("take more than"), "{text}");
    }
}
