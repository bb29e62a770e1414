//! Which frames of a run a recording holds.

use std::num::NonZeroU64;

/// Which frames of a run are drawn: every k-th of those that are stored, and the first and the last one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DrawnFrames {
    pub(crate) stored: StoredFrames,
    /// Number of frames of the run.
    pub(crate) frames: Option<u64>,
    pub(crate) every: NonZeroU64,
}

impl DrawnFrames {
    /// Whether a frame is drawn.
    pub(crate) fn has(self, frame: u64) -> bool {
        let is_end = frame == self.stored.first() || self.frames == frame.checked_add(1);
        self.stored.has(frame, self.frames) && (is_end || frame.is_multiple_of(self.every.get()))
    }
}

/// Which frames of a run a recording holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StoredFrames {
    /// All frames.
    #[default]
    All,
    /// Every k-th frame and the last one, each with the state of the model; of the others, the scalars and a hash of the state.
    Keyframes(NonZeroU64),
    /// The frames from this one on: a part of a run.
    From(u64),
}

impl StoredFrames {
    /// Index of the first frame in the file.
    #[must_use]
    pub fn first(self) -> u64 {
        match self {
            Self::All | Self::Keyframes(_) => 0,
            Self::From(first) => first,
        }
    }

    /// Whether a frame of a run with so many frames is stored.
    #[must_use]
    pub fn has(self, frame: u64, frames: Option<u64>) -> bool {
        match self {
            Self::All => true,
            Self::Keyframes(distance) => {
                frame.is_multiple_of(distance.get()) || frames == frame.checked_add(1)
            }
            Self::From(first) => frame >= first,
        }
    }

    /// Number of frames in the file before a frame that is in it.
    #[must_use]
    pub fn count_before(self, frame: u64) -> u64 {
        match self {
            Self::All => frame,
            Self::Keyframes(distance) => frame.div_ceil(distance.get()),
            Self::From(first) => frame.saturating_sub(first),
        }
    }

    /// Whether a frame follows the last one in the file. Of all frames from the first one on, a file has at least the scalars.
    pub(crate) fn may_follow(self, frame: u64, last: Option<u64>) -> bool {
        last.map_or(Some(self.first()), |last| last.checked_add(1)) == Some(frame)
    }

    /// The value of the provenance; `None` for a recording of all frames.
    pub(crate) fn to_text(self) -> Option<String> {
        match self {
            Self::All => None,
            Self::Keyframes(distance) => Some(format!("keyframes {distance}")),
            Self::From(first) => Some(format!("from {first}")),
        }
    }

    /// Reads the value of the provenance.
    pub(crate) fn from_text(text: Option<&str>) -> Option<Self> {
        let Some(text) = text else { return Some(Self::All) };
        match text.split_once(' ')? {
            ("keyframes", distance) => distance.parse().ok().map(Self::Keyframes),
            ("from", first) => first.parse().ok().map(Self::From),
            _ => None,
        }
    }
}
