//! `[record]`: which data of a run are kept.

use crate::diagnostics::{Diagnostic, nearest};
use crate::keys::{HasKeys as _, Keys, Names, Reader};
pub use crate::model::CHANNELS;
use crate::model::ModelConfig;
use crate::quantity::{PlaybackRate, Positive};
use crate::table::table;
use crate::tree::Value;
pub use crate::value::{Decades, FramesPerDecade};
use crate::value::{count, words};
use std::num::{NonZeroU32, NonZeroU64};

table! {
    /// What is recorded, how often, and how it plays. By default, 200 intervals, and all channels except the series of single
    /// collisions and contacts.
    pub struct RecordConfig {
        /// When frames are taken.
        interval: RecordInterval [apart] = RecordInterval::Frames(NonZeroU64::new(200).expect("not zero")),
        /// Topics to record, without the leading slash; by default all that the model has, but `per_collision` (packing), `events` (packing and colliding gas),
        /// `contact_forces` and `disc_forces` (dem), and `divergence` (dem and several bodies of orbit), for which a run has a twin.
        channels: Option<Vec<String>> ["", optional],
        /// Frames per second of playback.
        playback_fps: PlaybackRate ["1/s"] = PlaybackRate::literal(25.0),
        /// Maximum number of particles drawn: of more, every k-th, and the strongest contact forces. The recorded state has
        /// all of them.
        max_drawn_particles: NonZeroU32 ["1"] = count(10_000),
        /// Every k-th frame is drawn, and the first and the last one; where not given, every frame of a run that draws at most
        /// 2,010,000 particles in all of them, and one in 2, 5, 10, 20, … of a larger one, at most one in 10 if hardly any step lies between
        /// its frames. The state is recorded in every frame.
        draw_every: Option<NonZeroU64> ["1", optional],
        /// Compression of the recording's chunks.
        compression: Compression [""] = Compression::Zstd,
        /// Which frames are stored: all of them, only keyframes, from which `kinetoscope fill` restores the others, or none, of which only
        /// the metrics remain and `kinetoscope restore` writes any recording.
        keep: Keep ["", sparse] = Keep::All,
        /// With `keep = "keyframes"`: a keyframe is every k-th frame; 100 where not given. The start and the end always are.
        keyframe_distance: Option<NonZeroU64> ["1", optional],
    }
}

/// Distance of keyframes where none is given: a keyframe takes up to five times the space of a frame (`benches/keyframes.py`), so
/// that recordings of many particles are at least 20 times smaller.
const DEFAULT_KEYFRAME_DISTANCE: NonZeroU64 = NonZeroU64::new(100).expect("not zero");

/// Number of particles drawn in all frames together above which not every frame is drawn: the maximum per frame in the default number of
/// frames, 201. Their drawings have 241 MB.
const DRAWN_PARTICLES: u64 = 2_010_000;

/// Time to draw a particle, and to record its state, in that of one step of one particle of a dilute dem cloud, some 3 ns
/// (`cargo bench --bench recording_overhead -- dense`). Above [`DRAWN_PARTICLES`], drawings take at most 15 % of the time of a run.
const DRAWING_STEPS: u128 = 60;
const STATE_STEPS: u128 = 60;

/// The channel for which a run has a twin.
pub const DIVERGENCE: &str = "divergence";

/// When frames are taken. The start is frame 0 and the end is always a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RecordInterval {
    /// This many intervals, hence one state more.
    Frames(NonZeroU64),
    /// Simulated time between frames, in the model's unit (`every_s`, `every_days`, `every_time`).
    EveryTime(Positive),
    /// Number of steps between frames (stepped models).
    EverySteps(NonZeroU64),
    /// Number of collisions between frames (packing).
    EveryCollisions(NonZeroU64),
    /// Evenly in the logarithm of time, steps or collisions: so many frames per decade, so many decades back from the end.
    Logarithmic(FramesPerDecade, Decades),
}

words! {
    /// Compression of a recording's chunks.
    pub enum Compression {
        /// zstd, level 1 for chunks of a single frame, level 2 for others.
        Zstd = "zstd",
        /// zstd, level 3: a little smaller, and slower to write.
        Zstd3 = "zstd-3",
        /// lz4.
        Lz4 = "lz4",
        /// None.
        None = "none",
    }
}

words! {
    /// Which frames of a run are stored.
    pub enum Keep {
        /// All of them.
        All = "all",
        /// Every k-th frame, with the state of the model, and a hash of each of the others.
        Keyframes = "keyframes",
        /// None: of each run, a row of `runs.parquet` with its metrics and the hash of its messages remains.
        Metrics = "metrics",
    }
}

table! {
    /// The keys of a [`RecordInterval`].
    struct IntervalKeys at most one of [
        frames, every_s, every_days, every_time, every_steps, every_collisions, frames_per_decade
    ] {
        /// Number of intervals: one state more is recorded, the start and the end included.
        frames: Option<NonZeroU64> ["1", optional],
        /// Simulated time between frames (dem, gas).
        every_s: Option<Positive> ["s", optional],
        /// Simulated time between frames (orbit).
        every_days: Option<Positive> ["d", optional],
        /// Simulated time between frames (packing that runs for a `duration`).
        every_time: Option<Positive> ["1", optional],
        /// Steps between frames (dem, orbit, and gas that is not propagated exactly).
        every_steps: Option<NonZeroU64> ["1", optional],
        /// Collisions between frames (packing).
        every_collisions: Option<NonZeroU64> ["1", optional],
        /// Frames per decade, evenly in the logarithm of time (steps, collisions): frame j before the end at
        /// 10^(-j/frames_per_decade) of the run, as far as counts differ.
        frames_per_decade: Option<FramesPerDecade> ["1", optional],
        /// With `frames_per_decade`: decades that the frames reach back from the end of the run; 3 where not given.
        decades: Option<Decades> ["1", optional],
    }
}

impl RecordInterval {
    /// The interval as keys; the model decides on the key of a time interval.
    fn to_keys(self, time_key: &str) -> IntervalKeys {
        let mut own = IntervalKeys::default();
        match self {
            Self::Frames(number) => own.frames = Some(number),
            Self::EveryTime(time) => match time_key {
                "every_s" => own.every_s = Some(time),
                "every_days" => own.every_days = Some(time),
                _ => own.every_time = Some(time),
            },
            Self::EverySteps(number) => own.every_steps = Some(number),
            Self::EveryCollisions(number) => own.every_collisions = Some(number),
            Self::Logarithmic(number, reach) => {
                (own.frames_per_decade, own.decades) = (Some(number), Some(reach));
            }
        }
        own
    }

    /// The interval that the keys give, if they give one.
    fn from_keys(own: &IntervalKeys) -> Option<Self> {
        let logarithmic =
            |number| Self::Logarithmic(number, own.decades.unwrap_or(Decades::DEFAULT));
        let time = own.every_s.or(own.every_days).or(own.every_time);
        own.frames_per_decade
            .map(logarithmic)
            .or(own.every_collisions.map(Self::EveryCollisions))
            .or(own.every_steps.map(Self::EverySteps))
            .or(time.map(Self::EveryTime))
            .or(own.frames.map(Self::Frames))
    }
}

impl RecordConfig {
    /// Visits all keys of `[record]`. `time_key` is the model's key of a time interval.
    pub(crate) fn keys_for(&mut self, time_key: &str, keys: &mut impl Keys) {
        let mut interval = self.interval.to_keys(time_key);
        interval.keys(keys);
        self.interval = RecordInterval::from_keys(&interval).unwrap_or(self.interval);
        self.keys(keys);
    }

    /// The names of all keys of `[record]`, with those of every model's intervals.
    pub(crate) fn names() -> Names {
        let mut names = Names::default();
        for time_key in ["every_s", "every_days", "every_time"] {
            Self::default().keys_for(time_key, &mut names);
        }
        names
    }

    /// The same record with every frame stored.
    #[must_use]
    pub fn with_all_frames(&self) -> Self {
        Self { keep: Keep::All, keyframe_distance: None, ..self.clone() }
    }

    /// Distance of the drawn frames of a run with so many particles and frames, whose model computes so many steps of single particles: as
    /// few of 1, 2, 5, 10, 20, 50, … as suffice. Keyframes, whose default distance is 100, are then drawn.
    #[must_use]
    pub fn distance_of_drawings(&self, particles: u64, frames: u64, steps: u64) -> NonZeroU64 {
        let drawn = particles.min(self.max_drawn_particles.get().into()).saturating_mul(frames);
        let other = u128::from(particles.saturating_mul(frames)) * STATE_STEPS + u128::from(steps);
        let by_time = (u128::from(drawn) * DRAWING_STEPS * 100).div_ceil(15 * other.max(1));
        let by_number = u128::from(drawn.div_ceil(DRAWN_PARTICLES));
        let least = if by_number > 1 { by_number.max(by_time) } else { 1 };
        let mut distances =
            (0..18).flat_map(|zeros| [1, 2, 5].map(|digit| digit * 10_u64.pow(zeros)));
        let by_size =
            distances.find(|distance| u128::from(*distance) >= least).and_then(NonZeroU64::new);
        self.draw_every.or(by_size).unwrap_or(NonZeroU64::MAX)
    }

    /// Distance of the keyframes; `None` if all frames are stored.
    #[must_use]
    pub fn distance_of_keyframes(&self) -> Option<NonZeroU64> {
        match self.keep {
            Keep::All | Keep::Metrics => None,
            Keep::Keyframes => Some(self.keyframe_distance.unwrap_or(DEFAULT_KEYFRAME_DISTANCE)),
        }
    }

    /// Whether a run has a twin from which it diverges.
    #[must_use]
    pub fn has_twin(&self) -> bool {
        self.channels.iter().flatten().any(|channel| channel == DIVERGENCE)
    }

    /// Reports the broken rules between the keys, and between them and the model, which is `sound` if its own table had no errors.
    pub(crate) fn check(&mut self, model: &ModelConfig, sound: bool, table: &mut Reader<'_>) {
        let allowed = model.intervals(sound);
        for key in IntervalKeys::EXCLUSIVE {
            if table.has(key) && !allowed.contains(key) {
                let title =
                    format!("`record.{key}` cannot be used with this {} experiment", model.name());
                let label = format!("must be one of {}", allowed.join(", "));
                table.refuse(&[key], &title, &label);
            }
        }
        if table.has("decades") && !table.has("frames_per_decade") {
            let title = "`record.decades` needs `frames_per_decade`";
            table.refuse(&["decades"], title, "add `frames_per_decade`");
        }
        if self.keep != Keep::Keyframes && table.has("keyframe_distance") {
            let title = "`record.keyframe_distance` needs `keep = \"keyframes\"`";
            table.refuse(&["keyframe_distance"], title, "add `keep = \"keyframes\"`");
        }
        // The canonical text leaves nothing to a default.
        self.keyframe_distance = self.distance_of_keyframes();
        let known = model.channels();
        check_channels(model.name(), known, table);
        let names_events = self.channels.iter().flatten().any(|channel| channel == "events");
        if names_events && matches!(model, ModelConfig::Gas(gas) if gas.disc_radius_m.is_none()) {
            let title = "`record.channels` has \"events\", and the particles are points, which do not collide";
            table.refuse(
                &["channels"],
                title,
                "give `model.gas.disc_radius_m`, or leave \"events\" out",
            );
        }
        let is_known = known.contains(&DIVERGENCE);
        if is_known && self.has_twin() && !model.keeps_its_particles() {
            let title = "`record.channels` has \"divergence\", and no twin of this run has its particles throughout";
            table.refuse(
                &["channels"],
                title,
                "give `model.orbit.bodies`, or a bed without insertion and `remove_below_m`; or leave \"divergence\" out",
            );
        }
        let names_energy = self.channels.iter().flatten().any(|channel| channel == "energy");
        if names_energy
            && matches!(model, ModelConfig::Packing(discs) if discs.gravity.get() == 0.0)
        {
            let title = "`record.channels` has \"energy\", and the discs do not fall, so that their energy is kinetic";
            table.refuse(
                &["channels"],
                title,
                "give `model.packing.gravity`, or \"temperature\" in place of \"energy\"",
            );
        }
        if let Some(wanted) = &mut self.channels {
            // Their order has no effect, so it must not affect the run key.
            wanted.sort_by_key(|channel| known.iter().position(|name| name == channel));
        }
    }
}

/// Reports channels that the model does not have or that are listed twice.
fn check_channels(model: &str, known: &[&str], table: &mut Reader<'_>) {
    let Some(Value::Array(elements)) = table.node("channels").map(|node| &node.value) else {
        return;
    };
    let mut seen = Vec::new();
    for element in elements.iter() {
        let Value::Text(channel) = &element.value else { continue };
        if seen.contains(&channel) {
            let title = format!("channel \"{channel}\" is listed twice");
            table.report(Diagnostic::new(title).at(element.span, "list it once"));
        } else if !known.contains(&&**channel) {
            let label = match nearest(channel, known.iter().copied()) {
                Some(meant) => format!("did you mean \"{meant}\"?"),
                None => format!("channels: {}", known.join(", ")),
            };
            let title = format!("the {model} model has no channel \"{channel}\"");
            table.report(Diagnostic::new(title).at(element.span, label));
        }
        seen.push(channel);
    }
}
