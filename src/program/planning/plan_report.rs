//! The plan of an experiment as text and JSON: runs, steps, disk space, memory and expected time.

use crate::manifests::NoRecording;
use crate::manifests::step::Step;
use crate::messages::progress::size;
use crate::messages::{Failure, bad, counted, describe, missing_space, plural};
use crate::planning::planner::Planned;
use crate::planning::rows::sampled;
use kinetoscope::interrupt::Interrupt;
use kinetoscope::plan::totals::ExpectedTime;
use kinetoscope::run::resources::Estimate;
use kinetoscope_analysis::needs_replicates;
use kinetoscope_console::Exit;
use kinetoscope_console::text::shown_path;
use kinetoscope_manifest::model::{Boundary, ModelConfig, RunLength};
use kinetoscope_manifest::{Bound, Check, Experiment};
use kinetoscope_physics::model::Extent;
use serde_json::{Value as Json, json};
use std::path::Path;

/// The plan of an experiment that starts from a run without a recording.
///
/// # Errors
/// A run that failed, or a manifest that cannot be started from.
pub(crate) fn not_planned(step: &Step, why: NoRecording) -> Result<String, Failure> {
    let manifest = shown_path(&step.manifest);
    match why {
        NoRecording::Failed(why) => {
            let what = format!("{manifest} cannot start: {why}");
            Err(Failure::new(Exit::RunFailed, what).help("change the manifest that it starts from"))
        }
        NoRecording::Invalid(why) => {
            let what = format!("{manifest} cannot start: {why}");
            Err(bad(what).help("correct the manifest that it starts from"))
        }
        NoRecording::Missing(why) => {
            Ok(format!("{manifest}: planned when the run that it starts from is finished: {why}"))
        }
    }
}

/// The plan of a manifest, as `check` reports it.
pub(crate) struct PlanReport<'a> {
    manifest: &'a Path,
    experiment: &'a Experiment,
    planned: &'a Planned,
    /// The plan whose resources are reported: that of a rerun if all runs are finished.
    costs: &'a Planned,
    time: Option<ExpectedTime>,
}

impl<'a> PlanReport<'a> {
    /// Checks the plan of an experiment, for a fraction of a second or until the interrupt. `rerun` is the plan of its rerun if all runs are
    /// finished.
    pub(crate) fn new(
        manifest: &'a Path,
        experiment: &'a Experiment,
        planned: &'a Planned,
        rerun: Option<&'a Planned>,
        interrupt: &Interrupt,
    ) -> Self {
        let costs = rerun.unwrap_or(planned);
        let time = costs.plan.expected_time(costs.jobs, interrupt);
        let time = time.map(|time| sampled(experiment, costs.jobs, time, interrupt));
        Self { manifest, experiment, planned, costs, time }
    }

    fn estimates(&self) -> Vec<&Estimate> {
        self.costs.plan.to_do().into_iter().filter_map(|run| run.estimate()).collect()
    }

    /// Memory of the runs that execute in parallel.
    fn memory_bytes(&self) -> u64 {
        self.costs.plan.memory_at_once(self.costs.jobs)
    }

    /// The checks that compare with a standard error which the metric does not have in a single run.
    fn checks_without_error(&self) -> Vec<&Check> {
        let is_single = self.experiment.replicates == 1;
        let has_none = |check: &&Check| {
            let compares =
                matches!(check.bound, Bound::WithinStandardErrors { expected: Some(_), .. });
            is_single && compares && needs_replicates(self.experiment.model(), &check.metric)
        };
        self.experiment.checks.iter().filter(has_none).collect()
    }

    /// Whether discs that cool in a periodic box must reach a number of collisions. At last, all may move in parallel.
    fn may_end_in_parallel_motion(&self) -> bool {
        self.experiment.runs.iter().any(|run| match &*run.manifest.model {
            ModelConfig::Packing(config) => {
                config.restitution.get() < 1.0
                    && config.boundary == Boundary::Periodic
                    && matches!(config.length, RunLength::EventsPerDisc(_))
            }
            _ => false,
        })
    }

    /// The plan as text.
    pub(crate) fn text(&self) -> String {
        let Planned { plan, jobs, .. } = self.planned;
        let mut text = describe(self.experiment, plan, *jobs, &self.planned.destination());
        let estimates = self.estimates();
        let of = |count: fn(Extent) -> Option<u64>| {
            estimates.iter().filter_map(move |estimate| count(estimate.extent)).collect::<Vec<_>>()
        };
        for (counts, what) in [(of(steps), "step"), (of(events), "event")] {
            if let Some(range) = counted(counts.into_iter(), what) {
                text += &format!("\n  {range} per run");
            }
        }
        if !estimates.is_empty() {
            if let (false, Some(what)) = (
                self.experiment.keeps_only_metrics(),
                missing_space(plan, self.planned.bytes_at_once()),
            ) {
                text += &format!("\n  warning: {what}");
            }
            text += &format!("\n  memory: at most {}", size(self.memory_bytes()));
            text += &match self.time {
                Some(ExpectedTime { total_s, preparation_s }) => {
                    let of_rerun = if plan.to_do().is_empty() { " for a rerun" } else { "" };
                    let before = match preparation_s < 1.0 {
                        true => String::new(),
                        false => {
                            format!(", {} of it before the first run", duration(preparation_s))
                        }
                    };
                    format!("\n  time: {}{of_rerun} on this machine{before}", duration(total_s))
                }
                None => "\n  time: unknown".to_owned(),
            };
            if self.may_end_in_parallel_motion() {
                text += "\n  not included in the time: inelastic discs in a periodic box may come to move in parallel, with hardly any collision; such a run ends with a fault";
            }
        }
        text += &format!("\n  {}", plural(self.experiment.checks.len() as u64, "check"));
        if !self.experiment.plots.is_empty() {
            text += &format!(", {}", plural(self.experiment.plots.len() as u64, "requested plot"));
        }
        for check in self.checks_without_error() {
            text += &format!(
                "\n  line {}: `{}` of a single run has no standard error, so the check cannot be decided: set replicates, or a tolerance",
                check.line, check.metric
            );
        }
        text
    }

    /// The plan as JSON.
    pub(crate) fn json(&self) -> Json {
        let Planned { plan, jobs, .. } = self.planned;
        let estimates = self.estimates();
        let range = |values: Vec<u64>| match (values.iter().min(), values.iter().max()) {
            (Some(min), Some(max)) => json!({ "min": min, "max": max }),
            _ => Json::Null,
        };
        let counts = |count: &dyn Fn(&Estimate) -> Option<u64>| {
            range(estimates.iter().filter_map(|estimate| count(estimate)).collect())
        };
        json!({
            "manifest": self.manifest,
            "experiment": self.experiment.name,
            "model": self.experiment.model(),
            "runs": plan.runs.len(),
            "finished": plan.finished().count(),
            "to_do": plan.to_do().len(),
            "destination": self.planned.destination(),
            "jobs": jobs,
            "particles": counts(&|estimate| Some(estimate.particles)),
            "frames": counts(&|estimate| Some(estimate.frames)),
            "steps": counts(&|estimate| steps(estimate.extent)),
            "events": counts(&|estimate| events(estimate.extent)),
            "bytes": (!self.experiment.keeps_only_metrics()).then(|| plan.bytes_to_write()),
            "memory_bytes": self.memory_bytes(),
            "expected_s": self.time.map(|time| time.total_s),
            "preparation_s": self.time.map(|time| time.preparation_s),
            "checks": self.experiment.checks.len(),
            "checks_without_error": self.checks_without_error().iter().map(|check| check.line).collect::<Vec<_>>(),
            "plots": self.experiment.plots.len(),
        })
    }
}

const fn steps(extent: Extent) -> Option<u64> {
    match extent {
        Extent::Steps { total, .. } => Some(total),
        Extent::Events(_) | Extent::Time(_) => None,
    }
}

const fn events(extent: Extent) -> Option<u64> {
    match extent {
        Extent::Events(total) => Some(total),
        Extent::Steps { .. } | Extent::Time(_) => None,
    }
}

/// Formats a time, such as "about 2 min".
fn duration(seconds: f64) -> String {
    match seconds {
        seconds if seconds < 1.0 => "less than 1 s".to_owned(),
        seconds if seconds < 120.0 => format!("about {seconds:.0} s"),
        seconds if seconds < 7200.0 => format!("about {:.0} min", seconds / 60.0),
        seconds if seconds < 172_800.0 => format!("about {:.0} h", seconds / 3600.0),
        seconds => format!("about {:.0} days", seconds / 86_400.0),
    }
}
