//! What is said of a plan before its runs and after them.

use crate::executor::progress::size;
use crate::plan::{Plan, PlannedRun};
use crate::run::RunReport;
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
    let mut estimates = to_do.iter().filter_map(|run| run.estimate());
    let particles = counted(estimates.clone().map(|run| run.particles), "particle");
    let frames = counted(estimates.clone().map(|run| run.frames), "frame");
    if let (Some(particles), Some(frames)) = (particles, frames) {
        text += &format!("\n  {particles}, {frames}, at most {}", size(plan.bytes_to_write()));
        if plan.runs.len() > 1 {
            text += &format!(" in all, {jobs} at a time");
        }
        if estimates.any(|run| run.has_series_on_request) {
            text += "\n  and what each collision or contact takes, as its channel asks";
        }
    }
    text += &format!("\n  to {place}");
    if done > 0 {
        text += &format!("\n  {done} finished already, {} to do (--force does all)", to_do.len());
    }
    text
}

/// How many there are in the runs, from the fewest to the most, such as "5 to 50 particles"; `None` without runs.
fn counted(counts: impl Iterator<Item = u64> + Clone, what: &str) -> Option<String> {
    let (fewest, most) = (counts.clone().min()?, counts.max()?);
    let plural = if most == 1 { "" } else { "s" };
    let span = if fewest == most { most.to_string() } else { format!("{fewest} to {most}") };
    Some(format!("{span} {what}{plural}"))
}

/// What was recorded, and what was stopped.
pub(crate) fn summary(plan: &Plan, endings: &[&RunReport]) -> String {
    let (stopped, written): (Vec<&RunReport>, Vec<&RunReport>) =
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
