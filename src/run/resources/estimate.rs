//! What a run will take: frames, disk space, memory and relative cost, estimated from its start or, if it is large, from that of a sample.

use crate::run::prepared::{Prepared, distance_of_drawings, series_on_request};
use crate::run::resources::memory::{bytes_of_particles, upper_memory_bytes};
use crate::run::schedule::Schedule;
use kinetoscope_manifest::RunManifest;
use kinetoscope_manifest::model::{ModelConfig, RunLength};
use kinetoscope_physics::model::{Extent, Model, SetupError};
use kinetoscope_physics::{kind_of, state_columns_of};
use kinetoscope_recording::frame::Frame;
use std::num::NonZeroU64;

/// Schemas, manifest, index and summary of a recording: 16 to 20 KiB with all channels.
const BYTES_BESIDE_FRAMES: u64 = 24 << 10;
/// A collision in `/events`, the largest series: five numbers of 8 bytes, three counters, and the share of the message's header.
const BYTES_PER_EVENT: u64 = 52;

/// The resources that a run needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Number of frames, including the start.
    pub frames: u64,
    /// Number of particles, including those that enter during the run.
    pub particles: u64,
    /// Upper estimate of the recording's size, without a series whose size is unknown.
    pub bytes: u64,
    /// Whether a series is recorded in addition whose size is unknown: it depends on the number of collisions or contacts, which only runs
    /// of a given number of events have.
    pub has_series_of_unknown_size: bool,
    /// Every how many frames one is drawn.
    pub draw_every: NonZeroU64,
    /// Length of the run, as the model counts it.
    pub extent: Extent,
    /// Cost relative to the other runs of the experiment: particle steps, particle times, or events.
    pub relative_cost: f64,
    /// Upper estimate of the memory.
    pub memory_bytes: u64,
    /// Time on a slow processor; `None` if the work is not known before the run.
    pub seconds_on_slow_processor: Option<f64>,
}

impl Estimate {
    /// Estimates a run from its start.
    #[must_use]
    pub fn of(start: &Prepared, manifest: &RunManifest) -> Self {
        let Prepared { model, schedule, .. } = start;
        let start = Seen::of(model.as_ref(), manifest);
        Self::new(&start, model.extent(), schedule.frames(), start.particles, manifest)
    }

    /// Estimates a run from the start of its sample.
    ///
    /// # Errors
    /// A schedule that does not fit the length of the run.
    pub fn of_sample(sample: &dyn Model, manifest: &RunManifest) -> Result<Self, SetupError> {
        let (seen, particles) = (Seen::of(sample, manifest), manifest.model.particles());
        let extent = match sample.extent() {
            Extent::Events(events) => Extent::Events(events / seen.particles * particles),
            extent @ (Extent::Steps { .. } | Extent::Time(_)) => extent,
        };
        let schedule = Schedule::new(manifest.record.interval, extent)?;
        Ok(Self::new(&seen, extent, schedule.frames(), particles, manifest))
    }

    fn new(
        start: &Seen,
        extent: Extent,
        frames: u64,
        particles: u64,
        manifest: &RunManifest,
    ) -> Self {
        let kind = kind_of(&manifest.model);
        let frames = frames.saturating_add(1);
        let bytes_per_frame = bytes_per_frame(&start.frame, particles, &manifest.model);
        let relative_cost = relative_cost(extent, particles);
        let count = series_on_request(kind, &manifest.record) as u64;
        let series = match extent {
            Extent::Events(events) => Some(events.saturating_mul(count * BYTES_PER_EVENT)),
            _ if count == 0 => Some(0),
            _ => None,
        };
        let frame_bytes = frames.saturating_mul(bytes_per_frame);
        Self {
            frames,
            particles,
            extent,
            draw_every: distance_of_drawings(manifest, extent, frames),
            bytes: frame_bytes
                .saturating_add(series.unwrap_or(0))
                .saturating_add(BYTES_BESIDE_FRAMES),
            has_series_of_unknown_size: series.is_none(),
            relative_cost,
            memory_bytes: upper_memory_bytes(bytes_per_frame),
            seconds_on_slow_processor: work_per_second(&manifest.model)
                .map(|rate| relative_cost / rate),
        }
    }
}

/// The first frame of a model, and the number of its particles, those included that enter later.
struct Seen {
    frame: Frame,
    particles: u64,
}

impl Seen {
    fn of(model: &dyn Model, manifest: &RunManifest) -> Self {
        let mut frame = Frame::new();
        model.observe(&mut frame);
        let rows = frame.state().len() / state_columns_of(&manifest.model).len();
        let particles = rows as u64 + model.particles_to_come();
        Self { frame, particles }
    }
}

fn relative_cost(extent: Extent, particles: u64) -> f64 {
    match extent {
        Extent::Steps { total, .. } => total as f64 * particles as f64,
        Extent::Time(duration) => duration * particles as f64,
        Extent::Events(events) => events as f64,
    }
}

/// State and drawing of the particles, the other messages, and the message headers.
fn bytes_per_frame(frame: &Frame, particles: u64, model: &ModelConfig) -> u64 {
    let kind = kind_of(model);
    let on_request =
        |topic| kind.channels.iter().any(|channel| channel.opt_in && channel.topic == topic);
    let scalars: Vec<u64> = frame
        .messages()
        .filter(|message| !on_request(message.topic))
        .map(|message| message.payload.len() as u64)
        .collect();
    let headers = 100 * (scalars.len() as u64 + 4);
    bytes_of_particles(particles, model) + scalars.iter().sum::<u64>() + headers
}

/// Seconds that a run of this many steps or events, and frames, takes on one core of a server of 2024 within a factor of some three, the
/// same on every machine.
#[must_use]
pub fn nominal_seconds(manifest: &RunManifest, steps_or_events: u64, frames: u64) -> f64 {
    let particles = manifest.model.particles() as f64;
    // Steps of all particles, or single events, per second.
    let (each, rate) = match &*manifest.model {
        ModelConfig::Gas(config) if config.propagation.time_step_s().is_some() => (particles, 1e8),
        ModelConfig::Gas(_) | ModelConfig::Packing(_) => (1.0, 2e6),
        _ => (particles, 4e7),
    };
    steps_or_events as f64 * each / rate
        + frames as f64 * particles * SECONDS_PER_PARTICLE_AND_FRAME
}

/// Time to record a particle of a frame.
const SECONDS_PER_PARTICLE_AND_FRAME: f64 = 2e-7;

/// Speed of a slow processor over that of one core of a server of 2024.
#[cfg(not(target_family = "wasm"))]
pub(crate) const SPEED_OF_SLOW_PROCESSOR: f64 = 0.1;

/// Work per second of a slow processor: steps times particles, or events. `None` for models whose work is not known from the plan.
fn work_per_second(model: &ModelConfig) -> Option<f64> {
    match model {
        ModelConfig::Gas(config) => config.propagation.time_step_s().map(|_| 1e7),
        ModelConfig::Packing(config) => match config.length {
            RunLength::EventsPerDisc(_) => Some(2e5),
            RunLength::Duration(_) => None,
        },
        _ => Some(1e6),
    }
}
