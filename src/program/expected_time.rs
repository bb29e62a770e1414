//! Expected time of a plan on this machine, from the start of its costliest run, executed for a fraction of a second.
//!
//! A large run is measured by its sample, whose steps cost less per particle where the run does not fit into the cache.

use kinetoscope::plan::{Plan, PlannedRun};
use kinetoscope_manifest::model::ModelConfig;
use kinetoscope_physics::model::{Extent, Model, Progress, Target};
use kinetoscope_physics::random::Seed;
use std::time::{Duration, Instant};

/// The measurement stops after this time.
const MEASURED_TIME: Duration = Duration::from_millis(200);
/// The fraction of the run that is measured first; it doubles until the time is over.
const FIRST_FRACTION: f64 = 1e-4;
/// Steps or events per call, so that a slow run cannot exceed the measured time by much.
const STEPS_PER_CALL: u64 = 64;

/// Seconds that the runs of a plan take with `jobs` in parallel and without recording; `None` if nothing could be measured.
pub(crate) fn expected_seconds(plan: &Plan, jobs: usize) -> Option<f64> {
    let runs = plan.to_do_by_cost();
    let costliest = runs.first()?;
    let longest = seconds_of_run(costliest)?;
    let cost = |run: &PlannedRun| run.estimate().map_or(0.0, |estimate| estimate.relative_cost);
    let total: f64 = runs.iter().map(|run| cost(run)).sum();
    let of_all = longest * total / cost(costliest);
    let in_parallel = of_all / jobs as f64;
    let seconds = if in_parallel > longest { in_parallel } else { longest };
    seconds.is_finite().then_some(seconds)
}

/// Measured from the start that the plan has kept. A large run's is that of its sample.
fn seconds_of_run(run: &PlannedRun) -> Option<f64> {
    if let Some(mut start) = run.take_start() {
        return measure(start.model.as_mut());
    }
    let manifest = &run.run.manifest;
    let seed = Seed { seed: manifest.seed, replicate: manifest.replicate };
    let prepare = |model: &ModelConfig| kinetoscope_physics::prepare(model, seed, false).ok();
    if let Some(sample) = manifest.model.sample()
        && let Some(mut start) = prepare(&sample)
    {
        let particles = manifest.model.particles() as f64 / sample.particles() as f64;
        return Some(particles * measure(start.as_mut())?);
    }
    measure(prepare(&manifest.model)?.as_mut())
}

fn measure(model: &mut dyn Model) -> Option<f64> {
    let extent = model.extent();
    let started = Instant::now();
    let mut fraction = FIRST_FRACTION;
    loop {
        let target = match extent {
            Extent::Steps { total, .. } | Extent::Events(total) => {
                Target::Count(((total as f64 * fraction).ceil() as u64).min(total))
            }
            Extent::Time(duration) => Target::Time(duration * fraction),
        };
        while model.advance(target, STEPS_PER_CALL).ok()? == Progress::Working {
            if started.elapsed() > MEASURED_TIME {
                let done = match extent {
                    Extent::Steps { total, .. } | Extent::Events(total) => {
                        model.count() as f64 / total as f64
                    }
                    Extent::Time(_) => fraction,
                };
                return (done > 0.0).then(|| started.elapsed().as_secs_f64() / done);
            }
        }
        if fraction >= 1.0 || started.elapsed() > MEASURED_TIME {
            return Some(started.elapsed().as_secs_f64() / fraction);
        }
        fraction = if fraction < 0.5 { 2.0 * fraction } else { 1.0 };
    }
}

/// Formats a time, such as "about 2 min".
pub(crate) fn text(seconds: f64) -> String {
    match seconds {
        seconds if seconds < 1.0 => "less than 1 s".to_owned(),
        seconds if seconds < 120.0 => format!("about {seconds:.0} s"),
        seconds if seconds < 7200.0 => format!("about {:.0} min", seconds / 60.0),
        seconds if seconds < 172_800.0 => format!("about {:.0} h", seconds / 3600.0),
        seconds => format!("about {:.0} days", seconds / 86_400.0),
    }
}
