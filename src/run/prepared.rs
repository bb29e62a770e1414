//! A run that is ready to be recorded: its model, the schedule of its frames and the header of its recording, built once.

use crate::interrupt::Interrupt;
use crate::run::resources::memory;
use crate::run::schedule::Schedule;
use kinetoscope_console::Explained as _;
use kinetoscope_manifest::RunManifest;
use kinetoscope_manifest::record::{Compression, DIVERGENCE, RecordConfig};
use kinetoscope_physics::model::{Extent, Model, ModelKind, Proceed, SetupError, Target};
use kinetoscope_physics::random::Seed;
use kinetoscope_physics::{
    kind_of, prepare_while, prepare_with_twin, restore, restore_with_twin, state_columns_of,
};
use kinetoscope_recording::recorder::{self, Header, Selection, StoredFrames};
use std::fmt;
use std::num::NonZeroU64;

/// Time of a collision of the packing model, in that of one step of one particle (`RecordConfig::distance_of_drawings`).
const STEPS_PER_COLLISION: u64 = 150;

/// Relative rounding error of a time that is a product of a count and a step.
const TIME_ROUNDING: f64 = 1e-9;

/// Model, schedule and header of one run.
pub struct Prepared {
    /// The model, at the start or restored from a checkpoint.
    pub model: Box<dyn Model>,
    /// The targets of all frames after the start.
    pub schedule: Schedule,
    /// The header of the recording.
    pub header: Header,
}

impl fmt::Debug for Prepared {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut fields = formatter.debug_struct("Prepared");
        fields.field("model", &self.header.model).field("schedule", &self.schedule);
        fields.finish_non_exhaustive()
    }
}

impl Prepared {
    /// Builds the start of a run. `canonical` is the text of the manifest that the recording embeds.
    ///
    /// # Errors
    /// A run that needs more memory than is available, a start, a schedule or a header that cannot be run, or
    /// [`SetupError::stopped`] after an interrupt.
    pub fn new(
        manifest: &RunManifest,
        canonical: &str,
        run_key: &str,
        interrupt: &Interrupt,
    ) -> Result<Self, SetupError> {
        Self::new_while(manifest, canonical, run_key, &|_| !interrupt.is_raised())
    }

    /// As [`Prepared::new`], unless `proceed` returns `false` before the start is complete.
    ///
    /// # Errors
    /// Those of [`Prepared::new`].
    pub fn new_while(
        manifest: &RunManifest,
        canonical: &str,
        run_key: &str,
        proceed: Proceed<'_>,
    ) -> Result<Self, SetupError> {
        memory::check(manifest)?;
        let seed = Seed { seed: manifest.seed, replicate: manifest.replicate };
        let opt_in = wants_opt_in(kind_of(&manifest.model), &manifest.record);
        let prepare = if manifest.record.has_twin() { prepare_with_twin } else { prepare_while };
        let model = prepare(&manifest.model, seed, opt_in, proceed)?;
        let prepared = Self::of(model, manifest, canonical, run_key)?;
        prepared.header.check().map_err(|error| SetupError(error.message()))?;
        Ok(prepared)
    }

    /// Completes a model that was restored from a checkpoint.
    ///
    /// # Errors
    /// A schedule that does not fit the length of the run.
    pub fn of(
        model: Box<dyn Model>,
        manifest: &RunManifest,
        canonical: &str,
        run_key: &str,
    ) -> Result<Self, SetupError> {
        let schedule = Schedule::new(manifest.record.interval, model.extent())?;
        let frames = schedule.frames().saturating_add(1);
        let (kind, record) = (kind_of(&manifest.model), &manifest.record);
        let header = Header {
            manifest: canonical.to_owned(),
            run_key: run_key.to_owned(),
            model: kind.name,
            physics_version: kind.physics_version,
            program_version: env!("CARGO_PKG_VERSION").to_owned(),
            time_unit: kind.time_unit,
            state_columns: state_columns_of(&manifest.model),
            channels: model.channels(),
            selection: match &record.channels {
                None => Selection::All,
                Some(channels) => Selection::Named(channels.clone()),
            },
            scenery: model.scenery(),
            playback_fps: record.playback_fps.get(),
            max_drawn_particles: record.max_drawn_particles,
            draw_every: distance_of_drawings(manifest, model.extent(), frames),
            compression: match record.compression {
                Compression::Zstd => recorder::Compression::Zstd,
                Compression::Zstd3 => recorder::Compression::Zstd3,
                Compression::Lz4 => recorder::Compression::Lz4,
                Compression::None => recorder::Compression::None,
            },
            stored: record
                .distance_of_keyframes()
                .map_or(StoredFrames::All, StoredFrames::Keyframes),
            frames_expected: Some(frames),
            model_time: match model.extent() {
                Extent::Steps { total, step } => Some(total as f64 * step),
                Extent::Time(duration) => Some(duration),
                Extent::Events(_) => None,
            },
        };
        Ok(Self { model, schedule, header })
    }
}

/// Every how many frames one is drawn.
pub(crate) fn distance_of_drawings(
    manifest: &RunManifest,
    extent: Extent,
    frames: u64,
) -> NonZeroU64 {
    let particles = manifest.model.particles();
    let steps = match extent {
        Extent::Steps { total, .. } => total.saturating_mul(particles),
        Extent::Events(total) => total.saturating_mul(STEPS_PER_COLLISION),
        // A closed form, or a number of collisions that no manifest states.
        Extent::Time(_) => 0,
    };
    manifest.record.distance_of_drawings(particles, frames, steps)
}

impl Prepared {
    /// Whether a restored model can be on its way to a frame: not beyond its target. After the last frame, `next` is one more.
    pub(crate) fn is_before_frame(&self, next: u64) -> bool {
        let frames = self.schedule.frames();
        let is_possible = match self.schedule.target(next.min(frames)) {
            Target::Count(count) => self.model.count() <= count,
            Target::Time(time) => self.model.time() <= time * (1.0 + TIME_ROUNDING),
        };
        (1..=frames + 1).contains(&next) && is_possible
    }
}

/// Restores the model of a run from a checkpoint's bytes; `None` if they are damaged, or if the state is impossible.
pub(crate) fn restored(manifest: &RunManifest, bytes: &[u8]) -> Option<Box<dyn Model>> {
    let restore = if manifest.record.has_twin() { restore_with_twin } else { restore };
    restore(&manifest.model, bytes)
}

/// Whether the manifest names a series that is recorded only on request.
pub(crate) fn wants_opt_in(kind: &ModelKind, record: &RecordConfig) -> bool {
    series_on_request(kind, record) > 0
}

/// The number of such series.
pub(crate) fn series_on_request(kind: &ModelKind, record: &RecordConfig) -> usize {
    let on_request = kind.channels.iter().filter(|channel| channel.opt_in);
    let wanted = on_request.filter(|channel| {
        let name = channel.topic.trim_start_matches('/');
        name != DIVERGENCE && record.channels.iter().flatten().any(|wanted| wanted == name)
    });
    wanted.count()
}
