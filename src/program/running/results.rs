//! What became of the runs of an experiment: their errors, the worst exit code, and the summary as JSON.

use crate::messages::exit::of_run_error;
use crate::messages::{Failure, complain, name_of, plural};
use kinetoscope::outputs::sidecars;
use kinetoscope::plan::{Plan, PlannedRun, Status};
use kinetoscope::run::{RunError, RunReport};
use kinetoscope_console::text::one_line;
use kinetoscope_console::{Exit, Explained as _, Message};
use kinetoscope_manifest::{ExpectedOutcome, Experiment};
use kinetoscope_recording::recorder::Outcome;
use serde_json::{Value as Json, json};
use std::collections::HashMap;
use std::fs;

/// What became of one run: what was recorded, or the exit code and the error; `None` if it was not started.
pub(crate) type RunResult<'a> = (&'a PlannedRun, Option<Result<Recorded, (Exit, Message)>>);

/// A recording that a run has left.
#[derive(Clone, Debug)]
pub(crate) struct Recorded {
    outcome: Outcome,
    /// What failed, and what to change; `None` if the physics did not fail, or if only the recording is known.
    fault: Option<Message>,
}

/// Prints why runs failed, now or earlier, and returns the worst exit code.
pub(crate) fn report_errors(
    plan: &Plan,
    experiment: &Experiment,
    results: &[RunResult<'_>],
    is_task: bool,
) -> Exit {
    let (mut exit, mut failed) = (Exit::Done, 0);
    for (run, outcome) in plan.finished() {
        if let Some(message) = unexpected(outcome, None, experiment) {
            let message = message.about(format!("{} (earlier run)", name_of(run, experiment)));
            exit = Failure::of(Exit::RunFailed, message).report();
        }
    }
    for (run, result) in results {
        let (class, message) = match result {
            Some(Ok(Recorded { outcome, fault })) => {
                match unexpected(outcome, fault.as_ref(), experiment) {
                    Some(message) => (Exit::RunFailed, message),
                    None => continue,
                }
            }
            Some(Err((class, message))) => (*class, message.clone()),
            None => continue,
        };
        Failure::of(class, message.clone().about(name_of(run, experiment))).report();
        failed += 1;
        if is_task && matches!(result, Some(Err(_))) {
            leave_failure(plan, run, class, &message);
        }
        exit = exit.worst(class);
    }
    if failed > 0 && results.len() > 1 {
        complain(&format!("{failed} of {} failed", plural(results.len() as u64, "run")));
    }
    exit
}

/// Why an outcome is not the one that the manifest expects. Without the `fault` itself, the recorded text states what failed.
pub(super) fn unexpected(
    outcome: &Outcome,
    fault: Option<&Message>,
    experiment: &Experiment,
) -> Option<Message> {
    match (outcome, experiment.expected_outcome) {
        (Outcome::Fault(recorded), ExpectedOutcome::Complete) => Some(match fault {
            Some(fault) => fault.clone().about("failed"),
            None => Message::new(
                format!("failed: {}", one_line(recorded)),
                "change the manifest; the same manifest fails again",
            ),
        }),
        (Outcome::Complete, ExpectedOutcome::Fault) => Some(Message::new(
            "the run is complete, but its manifest expects a fault",
            "remove expected_outcome, or change the run",
        )),
        _ => None,
    }
}

/// A task reports a run without a recording to the process that submitted it.
fn leave_failure(plan: &Plan, run: &PlannedRun, class: Exit, message: &Message) {
    let is_retryable = class == Exit::Retryable;
    let failure = sidecars::Failure { is_retryable, message: message.clone() };
    if let Err(error) = sidecars::write_failure(&plan.folder, &run.stem(), &failure) {
        complain(&format!(
            "warning: the failure of {} could not be written down: {error}",
            run.stem()
        ));
    }
}

/// What a run on this machine has left, or its exit code and error.
pub(crate) fn of_run(result: &Result<RunReport, RunError>) -> Result<Recorded, (Exit, Message)> {
    match result {
        Ok(report) => Ok(Recorded { outcome: report.outcome.clone(), fault: report.fault.clone() }),
        Err(error) => Err((of_run_error(error), error.message())),
    }
}

/// What a task has left, or the exit code and the error of a run that it could not record.
pub(crate) fn of_task(
    result: Result<Outcome, sidecars::Failure>,
) -> Result<Recorded, (Exit, Message)> {
    match result {
        Ok(outcome) => Ok(Recorded { outcome, fault: None }),
        Err(failure) if failure.is_retryable => Err((Exit::Retryable, failure.message)),
        Err(failure) => Err((Exit::RunFailed, failure.message)),
    }
}

/// The runs of the plan with what became of them.
pub(crate) fn json(plan: &Plan, experiment: &Experiment, results: &[RunResult<'_>]) -> Vec<Json> {
    let results: HashMap<&str, &RunResult<'_>> =
        results.iter().map(|result| (result.0.run_key.as_str(), result)).collect();
    let runs = plan.runs.iter();
    runs.map(|run| run_json(run, plan, experiment, results.get(run.run_key.as_str()).copied()))
        .collect()
}

fn run_json(
    run: &PlannedRun,
    plan: &Plan,
    experiment: &Experiment,
    result: Option<&RunResult<'_>>,
) -> Json {
    let result = result.and_then(|(_, result)| result.as_ref());
    let recorded = result.map(|result| result.as_ref().map(|recorded| &recorded.outcome));
    let (status, error) = match (recorded, &run.status) {
        (Some(Ok(Outcome::Complete)), _) => ("written", None),
        (Some(Ok(Outcome::Interrupted)), _) => ("interrupted", None),
        (Some(Ok(Outcome::Fault(fault))), _) => ("failed", Some(fault.clone())),
        (Some(Err((_, error))), _) => ("failed", Some(error.to_string())),
        (None, Status::Done(Outcome::Fault(fault))) => ("failed earlier", Some(fault.clone())),
        (None, Status::Done(_)) => ("finished earlier", None),
        (None, Status::ToDo(_) | Status::Rejected(_)) => ("not started", None),
    };
    let path = plan.folder.join(run.file_name());
    json!({
        "run": name_of(run, experiment),
        "run_key": run.run_key.as_str(),
        "recording": path,
        "bytes": fs::metadata(&path).ok().map(|file| file.len()),
        "status": status,
        "error": error,
    })
}
