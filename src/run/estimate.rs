//! What a run will take: frames, disk space, memory and relative cost, estimated from its start.

use crate::run::memory::{DRAWN_BYTES, PROGRAM_BYTES};
use crate::run::prepared::{Prepared, wants_opt_in};
use kinetoscope_manifest::RunManifest;
use kinetoscope_physics::kind_of;
use kinetoscope_physics::model::{Extent, ModelKind};
use kinetoscope_recording::frame::Frame;

/// Schemas, manifest, index and summary of a recording: 16 to 20 KiB with all channels.
const BYTES_BESIDE_FRAMES: u64 = 24 << 10;
/// Memory of a model, its neighbors or events and its recorder's queue, as a number of recorded frames. The maximum measured
/// with 10^6 particles is 3.5, for a bed that starts from a recording; it is 3.3 with recorded contact forces.
const FRAMES_IN_MEMORY: u64 = 8;

/// The resources that a run needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Number of frames, including the start.
    pub frames: u64,
    /// Number of particles, including those that enter during the run.
    pub particles: u64,
    /// Upper estimate of the recording's size, without a series that is recorded only on request.
    pub bytes: u64,
    /// Whether such a series is recorded in addition. Its size is unknown: it depends on the number of collisions or contacts.
    pub has_series_on_request: bool,
    /// Length of the run, as the model counts it.
    pub extent: Extent,
    /// Height of the viewer's section, in the state's length unit.
    pub view_height: f64,
    /// Cost relative to the other runs of the experiment: particle steps, particle times, or events.
    pub relative_cost: f64,
    /// Upper estimate of the memory.
    pub memory_bytes: u64,
}

impl Estimate {
    /// Estimates a run from its start.
    #[must_use]
    pub fn of(start: &Prepared, manifest: &RunManifest) -> Self {
        let Prepared { model, schedule, header } = start;
        let kind = kind_of(&manifest.model);
        let mut frame = Frame::new();
        model.observe(&mut frame);
        let rows = frame.state().len() / kind.state_columns.len();
        let particles = rows as u64 + model.particles_to_come();
        let frames = schedule.frames().saturating_add(1);
        let bytes_per_frame = bytes_per_frame(&frame, particles, kind);
        let [[_, bottom], [_, top]] = header.scenery.view;
        Self {
            frames,
            particles,
            extent: model.extent(),
            bytes: frames.saturating_mul(bytes_per_frame).saturating_add(BYTES_BESIDE_FRAMES),
            has_series_on_request: wants_opt_in(kind, &manifest.record),
            view_height: top - bottom,
            relative_cost: relative_cost(model.extent(), particles),
            memory_bytes: FRAMES_IN_MEMORY
                .saturating_mul(bytes_per_frame)
                .saturating_add(PROGRAM_BYTES),
        }
    }
}

fn relative_cost(extent: Extent, particles: u64) -> f64 {
    match extent {
        Extent::Steps { total, .. } => total as f64 * particles as f64,
        Extent::Time(duration) => duration * particles as f64,
        Extent::Events(events) => events as f64,
    }
}

/// The uncompressed state, the drawing at its measured compressed size (about 50 bytes per disc), and the message headers.
fn bytes_per_frame(frame: &Frame, particles: u64, kind: &ModelKind) -> u64 {
    let state = particles * (kind.state_columns.len() * size_of::<f64>()) as u64;
    let on_request =
        |topic| kind.channels.iter().any(|channel| channel.opt_in && channel.topic == topic);
    let scalars: Vec<u64> = frame
        .messages()
        .iter()
        .filter(|message| !on_request(message.topic))
        .map(|message| message.payload.len() as u64)
        .collect();
    let headers = 100 * (scalars.len() as u64 + 4);
    state + DRAWN_BYTES * particles + scalars.iter().sum::<u64>() + headers
}
