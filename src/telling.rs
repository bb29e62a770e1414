//! What is said of a plan before its runs and after them.

use crate::plan::{Plan, PlannedRun, Status};
use crate::progress::size;
use crate::run::Ending;
use kinetoscope_manifest::Experiment;
use kinetoscope_recording::recorder::Outcome;

/// What tells a run from the others: its coordinates and replicate, or the experiment's name.
pub(crate) fn name_of(run: &PlannedRun, experiment: &Experiment) -> String {
    let mut parts: Vec<String> = run
        .run
        .coordinates
        .iter()
        .map(|coordinate| format!("{} = {}", coordinate.key, coordinate.value))
        .collect();
    if experiment.replicates > 1 {
        parts.push(format!("replicate {}", run.run.replicate));
    }
    if parts.is_empty() { experiment.name.clone() } else { parts.join(", ") }
}

/// The plan in a few lines: how many runs, what they take, and where their recordings go.
pub(crate) fn describe(experiment: &Experiment, plan: &Plan, jobs: usize, place: &str) -> String {
    let to_do = plan.to_do();
    let done = plan.runs.len() - to_do.len();
    let mut text = format!("{}: {} ", experiment.name, experiment.model());
    text += &match plan.runs.len() {
        1 => "run".to_owned(),
        runs => format!("runs, {runs}"),
    };
    if experiment.replicates > 1 {
        text += &format!(" ({} replicates each)", experiment.replicates);
    }
    let mut estimates = to_do.iter().filter_map(|run| match &run.status {
        Status::ToDo(estimate) => Some(estimate),
        Status::Done(_) | Status::Refused(_) => None,
    });
    if let Some(first) = estimates.next() {
        let plural = if first.particles == 1 { "particle" } else { "particles" };
        text += &format!("\n  {} {plural}, {} frames", first.particles, first.frames);
        if estimates.any(|other| (other.particles, other.frames) != (first.particles, first.frames))
        {
            text += " in the first";
        }
        text += &format!(", at most {} in all, {jobs} at a time", size(plan.bytes_to_write()));
    }
    text += &format!("\n  to {place}");
    if done > 0 {
        text += &format!("\n  {done} finished already, {} to do (--force does all)", to_do.len());
    }
    text
}

/// What was recorded, and what was stopped.
pub(crate) fn summary(plan: &Plan, endings: &[&Ending]) -> String {
    let (stopped, written): (Vec<&Ending>, Vec<&Ending>) =
        endings.iter().partition(|ending| ending.outcome == Outcome::Interrupted);
    let bytes: u64 = written.iter().map(|ending| ending.bytes).sum();
    let seconds: f64 = written.iter().map(|ending| ending.wall_time.as_secs_f64()).sum();
    let frames: u64 = written.iter().map(|ending| ending.frames).sum();
    let mut lines = Vec::new();
    match written.as_slice() {
        [] => {}
        [ending] => lines.push(format!(
            "Wrote {} ({}, {frames} frames in {seconds:.2} s)",
            ending.path.display(),
            size(bytes)
        )),
        several => lines.push(format!(
            "Wrote {} recordings to {} ({}, {frames} frames, {seconds:.1} s of running)",
            several.len(),
            plan.folder.display(),
            size(bytes)
        )),
    }
    lines.extend(stopped.iter().map(|ending| {
        format!("Kept {} with {} frames so far", ending.path.display(), ending.frames)
    }));
    lines.join("\n")
}
