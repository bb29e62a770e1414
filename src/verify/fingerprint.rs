//! What a lock file keeps of a recording: the hash of all messages, and a tag per frame from which the first differing frame follows.
//!
//! The hash covers topic, log time and payload of each message, not the compression of the file. Therefore, it is the same on
//! every architecture.

use kinetoscope_recording::error::ReadError;
use kinetoscope_recording::reader::{RecordedFrame, Recording};
use sha2::{Digest, Sha256};

/// Frames that have a tag. Differences in later frames are located after them.
const TAGGED_FRAMES: u64 = 4096;

/// Hash and tags of a recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fingerprint {
    /// The first half of the SHA-256 of all messages, 32 hexadecimal digits.
    pub messages: String,
    /// The tags of its frames.
    pub tags: FrameTags,
}

/// The tags of a recording's frames.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FrameTags {
    /// Number of frames.
    pub frames: u64,
    /// One byte per frame: the state of the hash of all messages after the frame.
    pub tags: Vec<u8>,
}

/// The first difference that follows from tags. Frames are counted as they are in the file, which may begin with a later one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FirstDifference {
    /// In this frame.
    At(u64),
    /// In a frame after this one, which is the last one with a tag.
    After(u64),
}

/// Reads a recording and derives its fingerprint.
///
/// # Errors
/// A recording that is not complete and intact.
pub fn fingerprint(recording: &Recording) -> Result<Fingerprint, ReadError> {
    let mut all = Sha256::new();
    let mut found = FrameTags { frames: 0, tags: Vec::new() };
    for frame in recording.frames()?.with_scalar_frames() {
        add_messages(&mut all, &frame?);
        if found.frames < TAGGED_FRAMES {
            found.tags.push(all.clone().finalize()[0]);
        }
        found.frames += 1;
    }
    let messages = data_encoding::HEXLOWER.encode(&all.finalize()[..16]);
    Ok(Fingerprint { messages, tags: found })
}

fn add_messages(hash: &mut Sha256, frame: &RecordedFrame) {
    for message in frame.messages() {
        hash.update((message.topic().len() as u64).to_le_bytes());
        hash.update(message.topic());
        hash.update(message.log_time_ns().to_le_bytes());
        hash.update((message.payload().len() as u64).to_le_bytes());
        hash.update(message.payload());
    }
}

impl FrameTags {
    /// Whether equal tags show that two runs have the same messages: every frame has a tag. A change k frames before the end has
    /// equal tags with a probability of 256^-(k + 1); runs of fewer than three frames are not decided.
    #[must_use]
    pub fn shows_equal_messages(&self, other: &Self) -> bool {
        self == other && self.frames == self.tags.len() as u64 && self.frames >= 3
    }

    /// The first difference to the tags of another recording of the same run, whose messages are not the same. A frame that differs
    /// has the same tag one time in 256; then, a later frame is named.
    #[must_use]
    pub fn first_difference(&self, other: &Self) -> FirstDifference {
        let tagged = self.tags.len().min(other.tags.len()) as u64;
        let mut pairs = self.tags.iter().zip(&other.tags);
        match pairs.position(|(one, other)| one != other) {
            Some(frame) => FirstDifference::At(frame as u64),
            None if self.frames.min(other.frames) == tagged && self.frames != other.frames => {
                FirstDifference::At(tagged)
            }
            None => FirstDifference::After(tagged.saturating_sub(1)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tags(frames: u64, tags: &[u8]) -> FrameTags {
        FrameTags { frames, tags: tags.to_vec() }
    }

    #[test]
    fn first_differing_frame_follows_from_the_tags() {
        let locked = tags(4, &[1, 2, 3, 4]);
        let difference = |other| locked.first_difference(&other);
        assert_eq!(difference(tags(4, &[1, 2, 9, 8])), FirstDifference::At(2));
        assert_eq!(difference(tags(2, &[1, 2])), FirstDifference::At(2));
        assert_eq!(difference(tags(5, &[1, 2, 3, 4, 5])), FirstDifference::At(4));
        let long = tags(9, &[1, 2]);
        assert_eq!(long.first_difference(&tags(9, &[1, 2])), FirstDifference::After(1));
        assert_eq!(long.first_difference(&tags(8, &[1, 2])), FirstDifference::After(1));
    }

    /// Controls: frames without a tag, and a run of two frames, prove nothing.
    #[test]
    fn equal_tags_of_all_frames_show_equal_messages() {
        let shows = |one: FrameTags| one.shows_equal_messages(&one);
        assert!(shows(tags(3, &[1, 2, 3])));
        assert!(!shows(tags(4, &[1, 2, 3])) && !shows(tags(2, &[1, 2])));
        assert!(!tags(3, &[1, 2, 3]).shows_equal_messages(&tags(3, &[1, 2, 4])));
    }
}
