//! What a lock file keeps of a recording: the hash of all messages, and a tag per frame from which the first differing frame follows.
//!
//! The hash covers topic, log time and payload of each message, not the compression of the file. Therefore, it is the same on
//! every architecture.

use kinetoscope_recording::error::ReadError;
use kinetoscope_recording::frame_hashes::FrameHasher;
use kinetoscope_recording::reader::Recording;

/// Tags that a lock file keeps of a run. Those of a longer run cover several frames each.
const MOST_TAGS: u64 = 192;

/// Hash and tags of a recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fingerprint {
    /// The first half of the SHA-256 of all messages, 32 hexadecimal digits.
    pub messages: String,
    /// Six bits per frame: the state of the hash of all messages after the frame.
    pub frames: Vec<u8>,
    /// Steps or events of the last frame.
    pub steps_or_events: u64,
}

/// The tags of a run's frames as a lock file keeps them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FrameTags {
    /// Number of frames.
    pub frames: u64,
    /// The tag of the last frame of each group of `frames_per_tag`.
    pub tags: Vec<u8>,
}

/// The frames that contain the first difference. They are counted as they are in the file, which may begin with a later one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FirstDifference {
    /// The first frame in which it may be.
    pub first: u64,
    /// The last one.
    pub last: u64,
}

/// Reads a recording and derives its fingerprint.
///
/// # Errors
/// A recording that is not complete and intact.
pub fn fingerprint(recording: &Recording) -> Result<Fingerprint, ReadError> {
    let (mut hasher, mut steps_or_events) = (FrameHasher::default(), 0);
    for frame in recording.frames()?.with_scalar_frames() {
        let frame = frame?;
        hasher.add_frame(&frame);
        steps_or_events = frame.clock.step_or_event_count;
    }
    let hashes = hasher.hashes();
    let messages = data_encoding::HEXLOWER.encode(&hashes.messages);
    let frames = hashes.first_bytes().map(|byte| byte % 64).collect();
    Ok(Fingerprint { messages, frames, steps_or_events })
}

impl Fingerprint {
    /// The tags that a lock file keeps.
    #[must_use]
    pub fn tags(&self) -> FrameTags {
        let frames = self.frames.len() as u64;
        let group = usize::try_from(frames_per_tag(frames)).unwrap_or(usize::MAX);
        let last_of = |group: &[u8]| group.last().copied().unwrap_or_default();
        FrameTags { frames, tags: self.frames.chunks(group).map(last_of).collect() }
    }
}

/// The number of frames that share a tag, in a run of so many.
const fn frames_per_tag(frames: u64) -> u64 {
    if frames == 0 { 1 } else { frames.div_ceil(MOST_TAGS) }
}

impl FrameTags {
    /// Tags that were read; `None` if their number is not that of a run of so many frames.
    #[must_use]
    pub fn new(frames: u64, tags: Vec<u8>) -> Option<Self> {
        let expected = frames.div_ceil(frames_per_tag(frames));
        (tags.len() as u64 == expected).then_some(Self { frames, tags })
    }

    /// Whether equal tags show that two runs have the same messages. A change k groups of frames before the end has equal tags with a
    /// probability of 64^-(k + 1); runs of fewer than four frames are not decided.
    #[must_use]
    pub fn shows_equal_messages(&self, found: &Fingerprint) -> bool {
        *self == found.tags() && self.tags.len() >= 4
    }

    /// The frames with the first difference of another recording of the same run, whose messages are not the same. A frame that
    /// differs has the same tag one time in 64; then, a later frame is named.
    #[must_use]
    pub fn first_difference(&self, found: &Fingerprint) -> FirstDifference {
        let group = frames_per_tag(self.frames);
        let there = found.frames.len() as u64;
        for (tag, first) in self.tags.iter().zip((0..).map(|index| index * group)) {
            let last = if first + group < self.frames { first + group } else { self.frames } - 1;
            let other = usize::try_from(last).ok().and_then(|last| found.frames.get(last));
            if other != Some(tag) {
                let end = if last < there { last } else { there };
                return FirstDifference { first, last: if end < first { first } else { end } };
            }
        }
        FirstDifference { first: self.frames, last: self.frames }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may panic")]
mod tests {
    use super::*;

    fn found(frames: &[u8]) -> Fingerprint {
        Fingerprint { messages: String::new(), frames: frames.to_vec(), steps_or_events: 0 }
    }

    #[test]
    fn first_differing_frame_follows_from_the_tags() {
        let locked = found(&[1, 2, 3, 4]).tags();
        let difference = |frames: &[u8]| {
            let FirstDifference { first, last } = locked.first_difference(&found(frames));
            (first, last)
        };
        assert_eq!(difference(&[1, 2, 9, 8]), (2, 2));
        assert_eq!(difference(&[1, 2]), (2, 2));
        assert_eq!(difference(&[1, 2, 3, 4, 5]), (4, 4));
    }

    /// Setup: 1000 frames, whose tags cover six each. Control: the last group has four frames.
    #[test]
    fn first_differing_frames_of_a_long_run_share_a_tag() {
        let frames: Vec<u8> = (0..1000_u32).map(|frame| (frame % 61) as u8).collect();
        let locked = found(&frames).tags();
        assert_eq!(locked.tags.len(), 167);
        assert_eq!(FrameTags::new(1000, locked.tags.clone()).unwrap(), locked);
        assert!(FrameTags::new(1001, locked.tags.clone()).is_some());
        assert!(FrameTags::new(1003, locked.tags.clone()).is_none());
        for (change, first, last) in [(0, 0, 5), (503, 498, 503), (504, 504, 509), (999, 996, 999)]
        {
            let mut other = frames.clone();
            other[change..].iter_mut().for_each(|tag| *tag ^= 63);
            assert_eq!(locked.first_difference(&found(&other)), FirstDifference { first, last });
        }
        let cut = locked.first_difference(&found(&frames[..10]));
        assert_eq!(cut, FirstDifference { first: 6, last: 10 });
    }

    /// Controls: a run of three frames proves little, and neither do other tags.
    #[test]
    fn equal_tags_of_all_frames_show_equal_messages() {
        let shows =
            |one: &[u8], other: &[u8]| found(one).tags().shows_equal_messages(&found(other));
        assert!(shows(&[1, 2, 3, 4], &[1, 2, 3, 4]));
        assert!(!shows(&[1, 2], &[1, 2]) && !shows(&[1, 2, 3, 4], &[1, 2, 3, 5]));
        assert!(!shows(&[1, 2, 3, 4], &[1, 2, 3, 4, 5]));
    }
}
