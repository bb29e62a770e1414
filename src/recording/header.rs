//! The header of a recording: its constant properties and its channels.

use crate::channels::{self, Channel as _, ChannelDeclaration, FrameClock, SCHEMA_VERSION};
use crate::column::is_constant;
use crate::error::RecordError;
use crate::frame::StateColumn;
use crate::keyframe::KEYFRAME;
use crate::playback::{log_time_ns, simulated_per_second};
use crate::provenance::Provenance;
use crate::scenery::Scenery;
use crate::schema::schema_of;
use crate::stored_frames::StoredFrames;
use kinetoscope_files::regular_file::MAX_MANIFEST_BYTES;
use std::num::{NonZeroU32, NonZeroU64};

/// Compression of the chunks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compression {
    /// zstd, level 1 for chunks of a single frame, level 2 for others.
    Zstd,
    /// zstd, level 3.
    Zstd3,
    /// lz4.
    Lz4,
    /// None.
    None,
}

/// Which channels are recorded. `/frame` and `/log` always are; `/walls` and `/legend` are with any drawing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Selection {
    /// All channels of the model except those that are recorded only on request.
    All,
    /// These topics, without the leading slash.
    Named(Vec<String>),
}

/// The constant properties of a recording.
#[derive(Clone, Debug)]
pub struct Header {
    /// Canonical manifest of the run, embedded as it is.
    pub manifest: String,
    /// The run key.
    pub run_key: String,
    /// Name of the model.
    pub model: &'static str,
    /// Version of the model's physics.
    pub physics_version: u32,
    /// Version of the program.
    pub program_version: String,
    /// "s", "d", or "" for dimensionless time.
    pub time_unit: &'static str,
    /// The columns of a particle's row in the state.
    pub state_columns: &'static [StateColumn],
    /// The model's channels, in file order.
    pub channels: &'static [ChannelDeclaration],
    /// Which channels are recorded.
    pub selection: Selection,
    /// The drawing's fixed part.
    pub scenery: Scenery,
    /// Frames per second of playback, in (0, 50].
    pub playback_fps: f64,
    /// Maximum number of particles drawn; of more particles, every k-th is drawn.
    pub max_drawn_particles: NonZeroU32,
    /// Every k-th frame is drawn, and the first and the last one.
    pub draw_every: NonZeroU64,
    /// Compression of the chunks.
    pub compression: Compression,
    /// Which frames are stored.
    pub stored: StoredFrames,
    /// Number of frames, if known in advance.
    pub frames_expected: Option<u64>,
    /// Simulated time of the whole run in `time_unit`, if known in advance.
    pub model_time: Option<f64>,
}

impl Header {
    /// All topics that a recording of this model can hold, in file order.
    #[must_use]
    pub fn topics(&self) -> Vec<&'static str> {
        let mut topics = vec![FrameClock::TOPIC];
        let has_constants = self.state_columns.iter().any(|column| is_constant(column.name));
        topics.extend(has_constants.then_some(channels::PARTICLES));
        topics.push(channels::STATE);
        topics.extend(self.channels.iter().map(|channel| channel.topic));
        topics.push(channels::DISCS);
        topics.push(channels::VELOCITY);
        topics.extend(self.scenery.force_range_top.map(|_| channels::FORCE_CHAINS));
        topics.extend(self.scenery.trail.then_some(channels::TRAIL));
        topics.extend([channels::WALLS, channels::LEGEND, channels::LOG]);
        topics.extend(matches!(self.stored, StoredFrames::Keyframes(_)).then_some(KEYFRAME));
        topics
    }

    /// Full name of the schema of a topic; `None` if it has none.
    #[must_use]
    pub fn schema_name(&self, topic: &str) -> Option<String> {
        schema_of(topic, self.channels).ok().map(|schema| schema.name)
    }

    /// Whether a topic, with its leading slash, is recorded.
    #[must_use]
    pub fn wants(&self, topic: &str) -> bool {
        if !self.topics().contains(&topic) {
            return false;
        }
        match &self.selection {
            Selection::All => {
                let opt_in =
                    |channel: &ChannelDeclaration| channel.topic == topic && channel.opt_in;
                !self.channels.iter().any(opt_in)
                    // Arrows that would hide the particles are drawn only when named.
                    && (topic != channels::VELOCITY || self.scenery.arrows)
            }
            Selection::Named(names) => {
                let named = |topic: &str| names.iter().any(|name| topic[1..] == **name);
                let drawings =
                    [channels::DISCS, channels::VELOCITY, channels::FORCE_CHAINS, channels::TRAIL];
                match topic {
                    topic if topic == FrameClock::TOPIC => true,
                    channels::LOG | KEYFRAME => true,
                    channels::PARTICLES => named(channels::STATE),
                    channels::WALLS | channels::LEGEND => {
                        named(topic) || drawings.into_iter().any(named)
                    }
                    _ => named(topic),
                }
            }
        }
    }

    /// Simulated time per second of playback, such as "75 ms"; `None` if it is not known in advance.
    #[must_use]
    pub fn simulated_per_second(&self) -> Option<String> {
        simulated_per_second(
            self.model_time,
            self.time_unit,
            self.frames_expected,
            self.playback_fps,
        )
    }

    pub(crate) fn provenance(&self) -> Provenance {
        Provenance {
            program_version: self.program_version.clone(),
            model: self.model.to_owned(),
            physics_version: self.physics_version,
            schema_version: SCHEMA_VERSION,
            run_key: self.run_key.clone(),
            time_unit: self.time_unit.to_owned(),
            playback_fps: self.playback_fps,
            state_columns: self.state_columns.iter().map(|column| column.name.to_owned()).collect(),
            state_units: self.state_columns.iter().map(|column| column.unit.to_owned()).collect(),
            stored: self.stored,
            outcome: None,
        }
    }

    /// Whether viewers can show a recording whose last frame has this index.
    #[must_use]
    pub fn can_be_played(&self, last: u64) -> bool {
        log_time_ns(last, self.playback_fps).is_some()
    }

    /// Checks that the selection can be recorded and that viewers can show the playback.
    ///
    /// # Errors
    /// A manifest that is too long; a channel that the model does not have; a rate outside (0, 50]; a playback of more than 93 days.
    pub fn check(&self) -> Result<(), RecordError> {
        let bytes = self.manifest.len() as u64;
        if bytes > MAX_MANIFEST_BYTES {
            return Err(RecordError::LongManifest { bytes });
        }
        let known = self.topics();
        if let Selection::Named(names) = &self.selection {
            for name in names {
                if !known.iter().any(|topic| topic[1..] == **name) {
                    let known = known.iter().map(|topic| &topic[1..]).collect();
                    return Err(RecordError::UnknownTopic { name: name.clone(), known });
                }
            }
        }
        let (last, rate) = (self.frames_expected.unwrap_or(1).saturating_sub(1), self.playback_fps);
        match log_time_ns(last, rate) {
            Some(_) => Ok(()),
            None => Err(RecordError::Playback { frame: last, rate }),
        }
    }
}
