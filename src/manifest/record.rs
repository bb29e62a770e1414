//! `[record]`: what of a run is kept.

use crate::diagnostics::{Diagnostic, nearest};
use crate::keys::{Keys, Reader};
use crate::model::{ModelConfig, Propagation, RunLength};
use crate::quantity::{PlaybackRate, Positive};
use crate::tree::Value;
use crate::value::words;
pub use crate::value::{Decades, FramesPerDecade};
use std::num::{NonZeroU32, NonZeroU64};

/// What is recorded, how often, and how it plays.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordConfig {
    /// When frames are taken.
    pub interval: RecordInterval,
    /// Topics wanted, without the leading slash; `None` is all that the model has but series of single collisions and contacts.
    pub channels: Option<Vec<String>>,
    /// Frames a second of playback, at most 50.
    pub playback_rate: Positive,
    /// Particles drawn at most.
    pub drawn_particles: NonZeroU32,
    /// Compression of the chunks.
    pub compression: Compression,
}

/// When frames are taken. The start is frame 0 and the end is always a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RecordInterval {
    /// This many intervals, hence one state more.
    Frames(NonZeroU64),
    /// Simulated time between frames, in the model's unit (`every_s`, `every_days`, `every_time`).
    EveryTime(Positive),
    /// Every so many steps (stepped models).
    EverySteps(NonZeroU64),
    /// Every so many collisions (packing).
    EveryCollisions(NonZeroU64),
    /// Evenly in the logarithm of time, steps or collisions: so many frames a decade, so many decades back from the end.
    Logarithmic(FramesPerDecade, Decades),
}

/// Compression of a recording's chunks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compression {
    /// zstd, level 1.
    Zstd,
    /// zstd, level 3: a little smaller, and slower to write.
    Zstd3,
    /// lz4.
    Lz4,
    /// None.
    None,
}

words!(pub Compression { Zstd = "zstd", Zstd3 = "zstd-3", Lz4 = "lz4", None = "none" });

/// The channels that each model can be asked for, without the leading slash; `/frame` is always recorded.
pub const CHANNELS: [(&str, &[&str]); 4] = [
    (
        "dem",
        &[
            "state",
            "discs",
            "walls",
            "legend",
            "velocity",
            "contacts",
            "energy",
            "energy_share",
            "contact_count",
            "wall_forces",
            "temperature",
            "contact_forces",
            "log",
        ],
    ),
    (
        "gas",
        &[
            "state",
            "discs",
            "walls",
            "legend",
            "velocity",
            "pressure",
            "temperature",
            "energy",
            "ledger",
            "collisions",
            "speeds",
            "log",
        ],
    ),
    (
        "packing",
        &[
            "state",
            "discs",
            "walls",
            "legend",
            "velocity",
            "temperature",
            "collisions",
            "pressure",
            "per_collision",
            "log",
        ],
    ),
    (
        "orbit",
        &[
            "state",
            "discs",
            "walls",
            "legend",
            "velocity",
            "trail",
            "energy",
            "orbit",
            "conserved",
            "log",
        ],
    ),
];

/// The keys of which at most one says when frames are taken.
const INTERVALS: &[&str] = &[
    "frames",
    "every_s",
    "every_days",
    "every_time",
    "every_steps",
    "every_collisions",
    "frames_per_decade",
];

impl Default for RecordConfig {
    /// 200 intervals, all channels but series of single collisions and contacts, 25 frames a second of playback, 10,000 particles drawn.
    fn default() -> Self {
        Self {
            interval: RecordInterval::Frames(const { NonZeroU64::new(200).expect("not zero") }),
            channels: None,
            playback_rate: const { Positive::literal(25.0) },
            drawn_particles: const { NonZeroU32::new(10_000).expect("not zero") },
            compression: Compression::Zstd,
        }
    }
}

impl RecordConfig {
    /// The keys of `[record]`, in the order of the canonical manifest. The model names the key of a time interval.
    pub(crate) fn keys(&mut self, model: &ModelConfig, keys: &mut impl Keys) {
        self.interval_keys(model, keys);
        self.channels = keys.optional(
            "channels",
            "",
            "Topics wanted, without the leading slash; by default all that the model has, \
            but `per_collision` (packing) and `contact_forces` (dem).",
            self.channels.take(),
        );
        // The default is in both ranges.
        if let Some(rate) = keys.optional(
            "playback_rate",
            "1/s",
            "Frames a second of playback.",
            PlaybackRate::new(self.playback_rate.get()),
        ) {
            self.playback_rate = rate.into();
        }
        keys.key(
            "drawn_particles",
            "1",
            "Particles drawn at most: of more, every k-th, and the strongest contact forces. The recorded state has all of them.",
            &mut self.drawn_particles,
        );
        keys.key(
            "compression",
            "",
            "Compression of the recording's chunks.",
            &mut self.compression,
        );
    }

    fn interval_keys(&mut self, model: &ModelConfig, keys: &mut impl Keys) {
        let (mut frames, mut time, mut steps, mut collisions) = (None, None, None, None);
        match self.interval {
            RecordInterval::Frames(number) => frames = Some(number),
            RecordInterval::EveryTime(interval) => time = Some(interval),
            RecordInterval::EverySteps(number) => steps = Some(number),
            RecordInterval::EveryCollisions(number) => collisions = Some(number),
            RecordInterval::Logarithmic(..) => {}
        }
        let of = |key: &str| time.filter(|_| time_key(model) == key);
        let (every_s, every_days, every_time) = (of("every_s"), of("every_days"), of("every_time"));
        keys.exclusive(INTERVALS);
        if let Some(number) = keys.optional(
            "frames",
            "1",
            "Number of intervals: one state more is recorded, the start and the end included.",
            frames,
        ) {
            self.interval = RecordInterval::Frames(number);
        }
        if let Some(interval) =
            keys.optional("every_s", "s", "Simulated time between frames (dem, gas).", every_s)
        {
            self.interval = RecordInterval::EveryTime(interval);
        }
        if let Some(interval) =
            keys.optional("every_days", "d", "Simulated time between frames (orbit).", every_days)
        {
            self.interval = RecordInterval::EveryTime(interval);
        }
        if let Some(interval) = keys.optional(
            "every_time",
            "1",
            "Simulated time between frames (packing that runs for a `duration`).",
            every_time,
        ) {
            self.interval = RecordInterval::EveryTime(interval);
        }
        if let Some(number) = keys.optional(
            "every_steps",
            "1",
            "Steps between frames (dem, orbit, and gas that is not propagated exactly).",
            steps,
        ) {
            self.interval = RecordInterval::EverySteps(number);
        }
        if let Some(number) = keys.optional(
            "every_collisions",
            "1",
            "Collisions between frames (packing).",
            collisions,
        ) {
            self.interval = RecordInterval::EveryCollisions(number);
        }
        self.logarithmic_keys(keys);
    }

    fn logarithmic_keys(&mut self, keys: &mut impl Keys) {
        let (per_decade, decades) = match self.interval {
            RecordInterval::Logarithmic(number, reach) => (Some(number), Some(reach)),
            _ => (None, None),
        };
        let per_decade = keys.optional(
            "frames_per_decade",
            "1",
            "Frames a decade, evenly in the logarithm of time (steps, collisions): frame j before the end at 10^(-j/frames_per_decade) \
            of the run, as far as counts differ.",
            per_decade,
        );
        let decades = keys.optional(
            "decades",
            "1",
            "With `frames_per_decade`: decades that the frames reach back from the end of the run; 3 where not given.",
            decades,
        );
        if let Some(number) = per_decade {
            self.interval =
                RecordInterval::Logarithmic(number, decades.unwrap_or(Decades::DEFAULT));
        }
    }

    /// The rules between `[record]` and the model, which is only `sound` if its own table had no errors.
    pub(crate) fn check(&mut self, model: &ModelConfig, sound: bool, table: &mut Reader<'_>) {
        let allowed = intervals(model, sound);
        for key in INTERVALS {
            if table.has(key) && !allowed.contains(key) {
                let title = format!("`record.{key}` is not for this {} experiment", model.name());
                let label = format!("it takes {}", allowed.join(", "));
                table.refuse(&[key], &title, &label);
            }
        }
        if table.has("decades") && !table.has("frames_per_decade") {
            let title = "`record.decades` says how far back `frames_per_decade` reaches";
            table.refuse(&["decades"], title, "give frames_per_decade, too");
        }
        let known = channels(model);
        check_channels(model.name(), known, table);
        if let Some(wanted) = &mut self.channels {
            // Their order decides nothing, so that it must not decide the run key.
            wanted.sort_by_key(|channel| known.iter().position(|name| name == channel));
        }
    }
}

/// The key of an interval of simulated time.
fn time_key(model: &ModelConfig) -> &'static str {
    match model {
        ModelConfig::Dem(_) | ModelConfig::Gas(_) => "every_s",
        ModelConfig::Orbit(_) => "every_days",
        ModelConfig::Packing(_) => "every_time",
    }
}

/// The channels that a model can be asked for.
fn channels(model: &ModelConfig) -> &'static [&'static str] {
    CHANNELS.iter().find(|(name, _)| *name == model.name()).map_or(&[], |(_, channels)| channels)
}

/// The interval keys that make sense for a model; of a model with errors those that might.
fn intervals(model: &ModelConfig, sound: bool) -> Vec<&'static str> {
    let more: &[&str] = match model {
        ModelConfig::Gas(gas) if sound && gas.propagation == Propagation::Exact => &["every_s"],
        ModelConfig::Dem(_) | ModelConfig::Gas(_) => &["every_s", "every_steps"],
        ModelConfig::Orbit(_) => &["every_days", "every_steps"],
        ModelConfig::Packing(packing) => match packing.length {
            RunLength::EventsPerDisc(_) if sound => &["every_collisions"],
            _ => &["every_time", "every_collisions"],
        },
    };
    [&["frames"], more, &["frames_per_decade"]].concat()
}

/// Every channel must be one of the model's, and stand once.
fn check_channels(model: &str, known: &[&str], table: &mut Reader<'_>) {
    let Some(Value::Array(elements)) = table.node("channels").map(|node| &node.value) else {
        return;
    };
    let mut seen = Vec::new();
    for element in elements.iter() {
        let Value::Text(channel) = &element.value else { continue };
        if seen.contains(&channel) {
            let title = format!("channel \"{channel}\" stands twice");
            table.report(Diagnostic::new(title).at(element.span, "once is enough"));
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
