//! `[record]`: what of a run is kept.

use crate::quantity::Positive;
use std::num::NonZeroU64;

/// What is recorded, how often, and how it plays.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordConfig {
    /// When frames are taken.
    pub interval: RecordInterval,
    /// Topics wanted, without the leading slash; `None` is all that the model has but per-collision series.
    pub channels: Option<Vec<String>>,
    /// Frames a second of playback, at most 50.
    pub playback_rate: Positive,
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
}

/// Compression of a recording's chunks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compression {
    /// zstd, level 1.
    Zstd,
    /// lz4.
    Lz4,
    /// None.
    None,
}
