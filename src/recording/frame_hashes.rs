//! Hashes of the messages of a run, frame by frame: from two lists follow the first frame and the topics that differ.
//!
//! Each hash covers all messages so far (topic, log time, payload), not the compression of the file. Therefore, a list of every k-th
//! frame misses no difference, and the last hash is that of all messages in a lock file.

use crate::error::ReadError;
use crate::observer::{ChannelList, FrameObserver};
use crate::reader::{RecordedFrame, Recording};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Adds up the messages of a run.
#[derive(Clone, Debug, Default)]
pub struct FrameHasher {
    all: Sha256,
    // The checksum of each topic's messages so far, in the order of `hashes.topics`.
    checksums: Vec<crc32fast::Hasher>,
    hashes: FrameHashes,
}

/// Adds the messages of a recording up while they are written.
#[derive(Clone, Debug, Default)]
pub struct HashingObserver(pub Arc<Mutex<FrameHasher>>);

impl HashingObserver {
    fn hasher(&self) -> MutexGuard<'_, FrameHasher> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl FrameObserver for HashingObserver {
    fn begin(&mut self, _: ChannelList) {}

    fn message(&mut self, topic: &'static str, log_time_ns: u64, payload: &[u8]) {
        self.hasher().add(topic, log_time_ns, payload);
    }

    fn end_of_frame(&mut self) {
        self.hasher().end_frame();
    }
}

/// The hashes of a run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FrameHashes {
    /// Number of frames.
    pub frames: u64,
    /// Every k-th frame is listed, and the last one.
    pub every: u64,
    /// The first bytes of the SHA-256 of all messages up to the end of a listed frame.
    hashes: Vec<[u8; 8]>,
    topics: Vec<TopicTags>,
    /// The first half of the SHA-256 of all messages.
    pub messages: [u8; 16],
}

/// One topic, and for each listed frame a byte of the checksum of its messages so far. It shows which topics differ, not whether one does.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct TopicTags {
    name: String,
    tags: Vec<u8>,
}

/// The frames among which two runs first differ, counted from 0, and the topics that do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HashDifference {
    /// The first frame in which it may be.
    pub first: u64,
    /// The last one.
    pub last: u64,
    /// The topics, with the leading slash; empty if a run has fewer frames.
    pub topics: Vec<String>,
}

impl Default for FrameHashes {
    fn default() -> Self {
        Self { frames: 0, every: 1, hashes: Vec::new(), topics: Vec::new(), messages: [0; 16] }
    }
}

impl FrameHasher {
    /// Adds a message of the current frame, or one that follows the last frame.
    pub fn add(&mut self, topic: &str, log_time_ns: u64, payload: &[u8]) {
        self.all.update((topic.len() as u64).to_le_bytes());
        self.all.update(topic);
        self.all.update(log_time_ns.to_le_bytes());
        self.all.update((payload.len() as u64).to_le_bytes());
        self.all.update(payload);
        let known = self.hashes.topics.iter().position(|known| known.name == topic);
        let index = known.unwrap_or_else(|| {
            let tags = vec![0; self.hashes.hashes.len()];
            self.hashes.topics.push(TopicTags { name: topic.to_owned(), tags });
            self.checksums.push(crc32fast::Hasher::new());
            self.checksums.len() - 1
        });
        self.checksums[index].update(&log_time_ns.to_le_bytes());
        self.checksums[index].update(payload);
    }

    /// Adds all messages of a frame that was read, and ends it.
    pub fn add_frame(&mut self, frame: &RecordedFrame) {
        for message in frame.messages() {
            self.add(message.topic(), message.log_time_ns(), message.payload());
        }
        self.end_frame();
    }

    /// Ends a frame.
    pub fn end_frame(&mut self) {
        self.hashes.frames += 1;
        self.hashes.hashes.push([0; 8]);
        self.hashes.topics.iter_mut().for_each(|topic| topic.tags.push(0));
        self.list_last();
    }

    fn list_last(&mut self) {
        let hash = self.all.clone().finalize();
        self.hashes.messages.copy_from_slice(&hash[..16]);
        if let Some(last) = self.hashes.hashes.last_mut() {
            last.copy_from_slice(&hash[..8]);
        }
        for (topic, checksum) in self.hashes.topics.iter_mut().zip(&self.checksums) {
            if let Some(last) = topic.tags.last_mut() {
                *last = checksum.clone().finalize() as u8;
            }
        }
    }

    /// The hashes so far. Messages after the last frame belong to it.
    pub fn hashes(&mut self) -> &FrameHashes {
        self.list_last();
        &self.hashes
    }

    /// Whether the last frame is the first one at which another list disagrees. Only its listed frames tell.
    #[must_use]
    pub fn differs_now(&self, expected: &FrameHashes) -> bool {
        let last = self.hashes.frames.saturating_sub(1);
        let place = expected.place(last);
        place.is_some_and(|place| expected.hashes.get(place) != self.hashes.hashes.last())
    }
}

impl FrameHashes {
    /// Reads all messages of a recording. Of a recording of keyframes, which has not all of them, nothing follows.
    ///
    /// # Errors
    /// A recording that is not complete and intact.
    pub fn of(recording: &Recording) -> Result<Self, ReadError> {
        let mut hasher = FrameHasher::default();
        for frame in recording.frames()? {
            hasher.add_frame(&frame?);
        }
        Ok(hasher.hashes().clone())
    }

    /// The first byte of each hash.
    pub fn first_bytes(&self) -> impl Iterator<Item = u8> + '_ {
        self.hashes.iter().map(|hash| hash[0])
    }

    /// The list of at most so many frames.
    #[must_use]
    pub fn thinned(&self, at_most: u64) -> Self {
        let every = self.frames.div_ceil(at_most.max(1)).max(1);
        let thinned = Self { every, ..self.clone() };
        let listed: Vec<usize> = (0..self.frames)
            .filter(|frame| thinned.place(*frame).is_some())
            .map(|frame| frame as usize)
            .collect();
        let tags = |topic: &TopicTags| TopicTags {
            name: topic.name.clone(),
            tags: listed.iter().filter_map(|frame| topic.tags.get(*frame)).copied().collect(),
        };
        Self {
            hashes: listed.iter().filter_map(|frame| self.hashes.get(*frame)).copied().collect(),
            topics: self.topics.iter().map(tags).collect(),
            ..thinned
        }
    }

    /// Whether this is a whole list of at most so many frames, as [`Self::thinned`] gives it.
    pub(crate) fn is_whole(&self, at_most: u64) -> bool {
        let listed = self.hashes.len();
        self.every == self.frames.div_ceil(at_most.max(1)).max(1)
            && listed as u64 == self.frames.div_ceil(self.every)
            && self.topics.iter().all(|topic| topic.tags.len() == listed)
    }

    /// The place of a frame in the list.
    fn place(&self, frame: u64) -> Option<usize> {
        let is_listed = (frame + 1).is_multiple_of(self.every) || frame + 1 == self.frames;
        let place = usize::try_from(frame / self.every).ok();
        place.filter(|_| is_listed && frame < self.frames)
    }

    /// The first difference between this list and that of all frames of another run.
    #[must_use]
    pub fn first_difference(&self, found: &Self) -> Option<HashDifference> {
        let mut first = 0;
        for place in 0..self.hashes.len() {
            let end = (place as u64 + 1).saturating_mul(self.every);
            let frame = end.min(self.frames).saturating_sub(1);
            let other = found.place(frame).and_then(|place| found.hashes.get(place));
            if other.is_none() || other != self.hashes.get(place) {
                let topics = self.differing_topics(found, place, frame);
                return Some(HashDifference { first, last: frame, topics });
            }
            first = frame + 1;
        }
        let is_equal = self.frames == found.frames && self.messages == found.messages;
        (!is_equal).then(|| HashDifference { first, last: first, topics: Vec::new() })
    }

    fn differing_topics(&self, found: &Self, place: usize, frame: u64) -> Vec<String> {
        let Some(other) = found.place(frame) else { return Vec::new() };
        let tag = |list: &Self, name: &str, place: usize| {
            let topic = list.topics.iter().find(|topic| topic.name == name);
            topic.and_then(|topic| topic.tags.get(place)).copied()
        };
        let mut names: Vec<&String> =
            self.topics.iter().chain(&found.topics).map(|topic| &topic.name).collect();
        names.sort();
        names.dedup();
        names.retain(|name| tag(self, name, place) != tag(found, name, other));
        names.into_iter().cloned().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten frames with two topics; `changed` is a frame whose `/state` has another payload.
    fn hashes(changed: Option<u8>) -> FrameHashes {
        let mut hasher = FrameHasher::default();
        for frame in 0..10_u8 {
            hasher.add("/frame", u64::from(frame), &[frame]);
            hasher.add("/state", u64::from(frame), &[if changed == Some(frame) { 99 } else { 7 }]);
            hasher.end_frame();
        }
        hasher.hashes().clone()
    }

    #[test]
    fn first_differing_frame_and_topic_are_named() {
        let expected = hashes(None);
        assert_eq!(expected.first_difference(&hashes(None)), None);
        for frame in 0..10 {
            let difference = expected.first_difference(&hashes(Some(frame)));
            let (first, topics) = (u64::from(frame), vec!["/state".to_owned()]);
            assert_eq!(difference, Some(HashDifference { first, last: first, topics }));
        }
    }

    /// Control: a list of every third frame names a range, and misses no frame.
    #[test]
    fn thinned_list_finds_every_difference() {
        let expected = hashes(None).thinned(4);
        assert_eq!((expected.every, expected.hashes.len()), (3, 4));
        assert_eq!(expected.first_difference(&hashes(None)), None);
        for (frame, first, last) in [(0, 0, 2), (3, 3, 5), (8, 6, 8), (9, 9, 9)] {
            let difference = expected.first_difference(&hashes(Some(frame))).unwrap();
            assert_eq!((difference.first, difference.last), (first, last));
        }
    }

    #[test]
    fn run_of_fewer_or_more_frames_is_not_equal() {
        let all = hashes(None);
        let mut short = FrameHasher::default();
        short.add("/frame", 0, &[0]);
        short.add("/state", 0, &[7]);
        short.end_frame();
        let short = short.hashes().clone();
        let difference = HashDifference { first: 1, last: 1, topics: Vec::new() };
        assert_eq!(all.first_difference(&short), Some(difference.clone()));
        assert_eq!(short.first_difference(&all), Some(difference));
    }

    /// The reason for the end of a run is a message after its last frame.
    #[test]
    fn message_after_the_last_frame_is_part_of_it() {
        let mut hasher = FrameHasher::default();
        hasher.add("/frame", 0, &[1]);
        hasher.end_frame();
        let before = hasher.hashes().clone();
        hasher.add("/log", 0, &[2]);
        let topics = vec!["/log".to_owned()];
        let difference = before.first_difference(hasher.hashes());
        assert_eq!(difference, Some(HashDifference { first: 0, last: 0, topics }));
    }
}
