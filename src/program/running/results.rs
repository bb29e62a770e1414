//! What became of the runs of an experiment: their errors, the worst exit code, and the summary as JSON.

use crate::messages::{Failure, complain, name_of};
use kinetoscope::outputs::sidecars;
use kinetoscope::plan::{Plan, PlannedRun, Status};
use kinetoscope::run::{RunError, RunReport};
use kinetoscope_console::Exit;
use kinetoscope_console::text::one_line;
use kinetoscope_manifest::{ExpectedOutcome, Experiment};
use kinetoscope_recording::recorder::Outcome;
use serde_json::{Value as Json, json};
use std::collections::HashMap;
use std::fs;

/// What became of one run: the outcome of its recording, or the exit code and the error; `None` if it was not started.
pub(crate) type RunResult<'a> = (&'a PlannedRun, Option<Result<Outcome, (Exit, String)>>);

/// Prints why runs failed, now or earlier, and returns the worst exit code.
pub(crate) fn report_errors(
    plan: &Plan,
    experiment: &Experiment,
    results: &[RunResult<'_>],
    is_task: bool,
) -> Exit {
    let (mut exit, mut failed) = (Exit::Done, 0);
    for (run, outcome) in plan.finished() {
        if let Some(message) = unexpected(outcome, experiment) {
            let name = name_of(run, experiment);
            complain(&format!(
                "error: {name} {message} (earlier run)\nhelp: change the manifest; the same manifest fails again"
            ));
            exit = Exit::RunFailed;
        }
    }
    for (run, result) in results {
        let (class, message) = match result {
            Some(Ok(outcome)) => match unexpected(outcome, experiment) {
                Some(message) => (Exit::RunFailed, message),
                None => continue,
            },
            Some(Err((class, message))) => (*class, message.clone()),
            None => continue,
        };
        let error = format!("{}: {message}", name_of(run, experiment));
        Failure::with_remedy(class, error).report();
        failed += 1;
        if is_task && matches!(result, Some(Err(_))) {
            leave_failure(plan, run, class, &message);
        }
        exit = exit.worst(class);
    }
    if failed > 0 && results.len() > 1 {
        complain(&format!("{failed} of {} runs failed", results.len()));
    }
    exit
}

/// Why an outcome is not the one that the manifest expects.
fn unexpected(outcome: &Outcome, experiment: &Experiment) -> Option<String> {
    match (outcome, experiment.expected_outcome) {
        (Outcome::Fault(fault), ExpectedOutcome::Complete) => {
            Some(format!("failed: {}", one_line(fault)))
        }
        (Outcome::Complete, ExpectedOutcome::Fault) => {
            let what = "is complete, but its manifest expects a fault";
            Some(format!("{what}; remove expected_outcome, or change the run"))
        }
        _ => None,
    }
}

/// A task reports a run without a recording to the process that submitted it.
fn leave_failure(plan: &Plan, run: &PlannedRun, class: Exit, message: &str) {
    let is_retryable = class == Exit::Retryable;
    let failure = sidecars::Failure { is_retryable, message: message.to_owned() };
    if let Err(error) = sidecars::write_failure(&plan.folder, &run.stem, &failure) {
        complain(&format!(
            "warning: the failure of {} could not be written down: {error}",
            run.stem
        ));
    }
}

/// The outcome of a run on this machine, or its exit code and error.
pub(crate) fn of_run(result: &Result<RunReport, RunError>) -> Result<Outcome, (Exit, String)> {
    match result {
        Ok(ending) => Ok(ending.outcome.clone()),
        Err(RunError::Record(error)) if error.is_retryable() => {
            Err((Exit::Retryable, error.to_string()))
        }
        Err(error) => Err((Exit::RunFailed, error.to_string())),
    }
}

/// The exit code and the error of a run that a task could not record.
pub(crate) fn of_task(failure: sidecars::Failure) -> (Exit, String) {
    let class = if failure.is_retryable { Exit::Retryable } else { Exit::RunFailed };
    (class, failure.message)
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
    let (status, error) = match (result.and_then(|(_, result)| result.as_ref()), &run.status) {
        (Some(Ok(Outcome::Complete)), _) => ("written", None),
        (Some(Ok(Outcome::Interrupted)), _) => ("interrupted", None),
        (Some(Ok(Outcome::Fault(fault))), _) => ("failed", Some(fault.clone())),
        (Some(Err((_, error))), _) => ("failed", Some(error.clone())),
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
