//! The time of a run on this machine, from its start executed for a fraction of a second.
//!
//! A large run is measured by its sample, whose steps cost less per particle where the run does not fit into the cache.

use crate::interrupt::Interrupt;
use crate::run::prepared::Prepared;
use crate::run::resources::sample::sample_of;
use kinetoscope_manifest::RunManifest;
use kinetoscope_manifest::model::ModelConfig;
use kinetoscope_physics::model::{Extent, Model, Progress, Target};
use kinetoscope_physics::prepare_while;
use kinetoscope_physics::random::Seed;
use std::time::{Duration, Instant};

/// The measurement stops after this time.
const MEASURED_TIME: Duration = Duration::from_millis(200);
/// The fraction of the run that is measured first; it doubles until the time is over.
const FIRST_FRACTION: f64 = 1e-4;
/// Steps or events per call, so that a slow run cannot exceed the measured time by much.
const STEPS_PER_CALL: u64 = 64;

/// Seconds that a run takes on this machine after its start, without recording; `None` if nothing could be measured. The start is built
/// unless it is given.
#[must_use]
pub fn measured_seconds(
    manifest: &RunManifest,
    start: Option<Prepared>,
    interrupt: &Interrupt,
) -> Option<f64> {
    if let Some(mut start) = start {
        return measure(start.model.as_mut());
    }
    let seed = Seed { seed: manifest.seed, replicate: manifest.replicate };
    let proceed = |_: f64| !interrupt.is_raised();
    let prepare = |model: &ModelConfig| prepare_while(model, seed, false, &proceed).ok();
    if let Some(sample) = sample_of(manifest)
        && let Some(mut start) = prepare(&sample.model)
    {
        let particles = manifest.model.particles() as f64 / sample.model.particles() as f64;
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
