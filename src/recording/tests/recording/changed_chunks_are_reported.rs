//! Guarantee: chunks of one group that are missing, repeated, in another order, of overlapping times, or that have messages of another
//! group give the recorded frames or an error that names the damage, never other messages. Only a drawing can be absent without an error:
//! a reader does not know which frames are drawn, and `verify` compares them.
//!
//! Setup: recordings of several blocks, whose chunks are changed and written again by the container's own library, with correct checksums
//! and indexes. Control: the chunks without a change are read.

#![allow(clippy::unwrap_used, reason = "a test's own failure")]

use crate::sample::{header, record};
use kinetoscope_recording::channels::{
    Channel as _, DISCS, FORCE_CHAINS, FrameClock, LEGEND, LOG, PARTICLES, STATE, TRAIL, VELOCITY,
    WALLS,
};
use kinetoscope_recording::keyframe::KEYFRAME;
use kinetoscope_recording::reader::{RecordedFrame, Recording, StoredFrames};
use kinetoscope_recording::recorder::{Compression, Header};
use std::collections::BTreeMap;
use std::io::Cursor;
use std::num::NonZeroU64;
use std::path::Path;

pub(crate) type Chunk = Vec<mcap::Message<'static>>;
/// Drawings, states and scalars: their chunks have this order in each block.
const GROUPS: usize = 3;

/// A recording of eight frames with a keyframe at each second one, after which a block ends; or of each frame.
fn recorded(distance: u64) -> Vec<u8> {
    let stored = StoredFrames::Keyframes(NonZeroU64::new(distance).unwrap());
    record(&Header { stored, frames_expected: Some(8), ..header(Compression::Zstd) }, 8, 3)
}

fn group(topic: &str) -> usize {
    match topic {
        DISCS | VELOCITY | FORCE_CHAINS | TRAIL | LEGEND => 0,
        PARTICLES | STATE | WALLS | KEYFRAME => 1,
        _ => 2,
    }
}

fn is_drawing(topic: &str) -> bool {
    group(topic) == 0
}

pub(crate) fn chunks(bytes: &[u8]) -> Vec<Chunk> {
    let messages = mcap::MessageStream::new(bytes).unwrap().map(Result::unwrap);
    let messages: Chunk = messages
        .map(|message| mcap::Message { data: message.data.into_owned().into(), ..message })
        .collect();
    let is_same = |one: &mcap::Message<'_>, other: &mcap::Message<'_>| {
        group(&one.channel.topic) == group(&other.channel.topic)
    };
    messages.chunk_by(is_same).map(<[_]>::to_vec).collect()
}

/// The file `original` with other chunks.
pub(crate) fn with_chunks(original: &[u8], chunks: &[Chunk]) -> Vec<u8> {
    let summary = mcap::Summary::read(original).unwrap().unwrap();
    let mut writer = mcap::WriteOptions::new()
        .library("kinetoscope")
        .compression(None)
        .chunk_size(None)
        .create(Cursor::new(Vec::new()))
        .unwrap();
    for index in &summary.attachment_indexes {
        writer.attach(&mcap::read::attachment(original, index).unwrap()).unwrap();
    }
    let metadata: Vec<mcap::records::Metadata> = summary
        .metadata_indexes
        .iter()
        .map(|index| mcap::read::metadata(original, index).unwrap())
        .collect();
    let (end, start): (Vec<_>, Vec<_>) =
        metadata.into_iter().partition(|record| record.name == "kinetoscope.outcome");
    start.iter().for_each(|record| writer.write_metadata(record).unwrap());
    for chunk in chunks {
        chunk.iter().for_each(|message| writer.write(message).unwrap());
        writer.flush().unwrap();
    }
    end.iter().for_each(|record| writer.write_metadata(record).unwrap());
    writer.finish().unwrap();
    writer.into_inner().into_inner()
}

/// The frames before the first error, with those between keyframes, and the error.
pub(crate) fn frames(bytes: Vec<u8>) -> (Vec<RecordedFrame>, Option<String>) {
    let recording = match Recording::from_bytes(bytes, Path::new("changed.mcap")) {
        Ok(recording) => recording,
        Err(error) => return (Vec::new(), Some(error.to_string())),
    };
    let mut whole = Vec::new();
    for frame in recording.frames().unwrap().with_scalar_frames() {
        match frame {
            Ok(frame) => whole.push(frame),
            Err(error) => return (whole, Some(error.to_string())),
        }
    }
    (whole, None)
}

/// The messages of a frame that a filter of topics selects.
fn messages(frame: &RecordedFrame, is_wanted: impl Fn(&str) -> bool) -> BTreeMap<String, Vec<u8>> {
    let messages = frame.messages().iter().filter(|message| is_wanted(message.topic()));
    messages.map(|message| (message.topic().to_owned(), message.payload().to_vec())).collect()
}

/// A recording with its chunks, and what became of the changed ones.
struct Trials {
    original: Vec<u8>,
    chunks: Vec<Chunk>,
    expected: Vec<RecordedFrame>,
    counts: BTreeMap<&'static str, usize>,
}

impl Trials {
    fn of(distance: u64) -> Self {
        let original = recorded(distance);
        let chunks = chunks(&original);
        let (expected, error) = frames(original.clone());
        assert_eq!((expected.len(), error), (8, None));
        Self { original, chunks, expected, counts: BTreeMap::new() }
    }

    /// Reads a file with other chunks; `has_same_drawings` states whether all drawings are still in it.
    fn read(&mut self, what: &str, chunks: &[Chunk], has_same_drawings: bool) -> &'static str {
        let (found, error) = frames(with_chunks(&self.original, chunks));
        assert!(found.len() <= self.expected.len(), "{what}");
        for (one, other) in found.iter().zip(&self.expected) {
            let all = messages(other, |_| true);
            let mut known = messages(one, |_| true).into_iter();
            let is_recorded = |(topic, payload)| all.get(&topic) == Some(&payload);
            assert!(known.all(is_recorded), "{what}: frame {}", one.clock.frame);
            let is_wanted = |topic: &str| has_same_drawings || !is_drawing(topic);
            let has_all = messages(one, is_wanted) == messages(other, is_wanted);
            assert!(has_all || error.is_some(), "{what}: frame {}", one.clock.frame);
        }
        let result = match error {
            Some(error) => {
                assert!(error.contains("changed.mcap"), "{what}: {error}");
                "error"
            }
            None => {
                assert_eq!(found.len(), self.expected.len(), "{what}: frames are missing silently");
                "same numbers"
            }
        };
        *self.counts.entry(result).or_default() += 1;
        result
    }
}

#[test]
fn chunks_without_a_change_are_read() {
    for distance in [1, 2] {
        let mut trials = Trials::of(distance);
        let chunks = trials.chunks.clone();
        assert!(chunks.len() >= 4 * GROUPS, "{} chunks", chunks.len());
        assert_eq!(trials.read("control", &chunks, true), "same numbers");
    }
}

#[test]
fn missing_and_repeated_chunks_are_reported() {
    for distance in [1, 2] {
        let mut trials = Trials::of(distance);
        for at in 0..trials.chunks.len() {
            let is_of_drawings = group(&trials.chunks[at][0].channel.topic) == 0;
            let mut missing = trials.chunks.clone();
            missing.remove(at);
            let found = trials.read(&format!("chunk {at} is missing"), &missing, !is_of_drawings);
            assert_eq!(found == "error", !is_of_drawings, "chunk {at} is missing");
            for place in 0..=trials.chunks.len() {
                let mut repeated = trials.chunks.clone();
                repeated.insert(place, trials.chunks[at].clone());
                let what = format!("chunk {at} is repeated before chunk {place}");
                assert_eq!(trials.read(&what, &repeated, true), "error", "{what}");
            }
        }
    }
}

#[test]
fn chunks_in_another_order_are_reported() {
    for distance in [1, 2] {
        let mut trials = Trials::of(distance);
        for one in 0..trials.chunks.len() {
            for other in 0..one {
                let mut swapped = trials.chunks.clone();
                swapped.swap(one, other);
                let what = format!("chunks {other} and {one} are swapped");
                let found = trials.read(&what, &swapped, true);
                let groups = [one, other].map(|at| group(&trials.chunks[at][0].channel.topic));
                let is_same_block = one / GROUPS == other / GROUPS;
                // Drawings and states of one block may have any order.
                assert!(found == "error" || is_same_block && !groups.contains(&2), "{what}");
            }
        }
        assert!(trials.counts.contains_key("same numbers"), "{:?}", trials.counts);
    }
}

/// The last or first message of a chunk in another chunk: of another block, so that times overlap, or of another group.
#[test]
fn messages_in_other_chunks_are_reported() {
    for distance in [1, 2] {
        let mut trials = Trials::of(distance);
        for from in 0..trials.chunks.len() {
            for to in (0..trials.chunks.len()).filter(|to| *to != from) {
                for is_first in [true, false] {
                    let mut moved = trials.chunks.clone();
                    let message = match is_first {
                        true => moved[from].remove(0),
                        false => moved[from].pop().unwrap(),
                    };
                    let topic = message.channel.topic.clone();
                    match is_first {
                        true => moved[to].push(message),
                        false => moved[to].insert(0, message),
                    }
                    moved.retain(|chunk| !chunk.is_empty());
                    let what = format!("{topic} of chunk {from} is in chunk {to}, {is_first}");
                    let found = trials.read(&what, &moved, true);
                    // A message of the first block may bring the declaration of its channel.
                    let is_first_block = from.max(to) < GROUPS;
                    assert!(found == "error" || is_first_block, "{what}");
                }
            }
        }
    }
}

/// A message of a channel that the other frames have.
#[test]
fn missing_messages_of_a_frame_are_reported() {
    for distance in [1, 2] {
        let mut trials = Trials::of(distance);
        for chunk in 0..trials.chunks.len() {
            for at in 0..trials.chunks[chunk].len() {
                let topic = trials.chunks[chunk][at].channel.topic.clone();
                if is_drawing(&topic) || [LOG, WALLS].contains(&topic.as_str()) {
                    continue;
                }
                let mut missing = trials.chunks.clone();
                missing[chunk].remove(at);
                missing.retain(|chunk| !chunk.is_empty());
                let what = format!("{topic} of chunk {chunk} is missing");
                assert_eq!(trials.read(&what, &missing, true), "error", "{what}");
            }
        }
    }
}

/// Guarantee: an analysis, which passes over chunks of drawings by their indexes, does not pass over others. Control: the indexes as written.
#[test]
fn index_of_another_group_is_reported() {
    let original = recorded(1);
    let [drawing, scalar] = [DISCS, FrameClock::TOPIC].map(|topic| {
        let summary = mcap::Summary::read(&original).unwrap().unwrap();
        summary.channels.values().find(|channel| channel.topic == topic).unwrap().id
    });
    let read = |bytes: Vec<u8>| {
        let recording = Recording::from_bytes(bytes, Path::new("changed.mcap")).unwrap();
        let [all, some] = [(); 2].map(|()| recording.frames().unwrap());
        [all.filter_map(Result::err).next(), some.with_first_drawing_only().find_map(Result::err)]
    };
    assert!(read(with_indexes(original.clone(), |channel| channel)).iter().all(Option::is_none));
    let lies = with_indexes(original, |channel| if channel == scalar { drawing } else { channel });
    for error in read(lies) {
        assert!(error.unwrap().to_string().contains("changed.mcap is damaged"));
    }
}

/// Guarantee: all states cannot be missing, if the summary still declares their channel. Control: another channel, which may have no message.
#[test]
fn states_without_a_chunk_are_reported() {
    let original = recorded(1);
    let error = |topic: &str| frames(with_declared_channel(original.clone(), topic)).1;
    assert_eq!(error("/trail"), None);
    let found = error(STATE).unwrap();
    assert!(found.contains("its chunks have other messages than its summary states"), "{found}");
}

/// The file with one more channel record in its summary, and the right checksum.
fn with_declared_channel(mut bytes: Vec<u8>, topic: &str) -> Vec<u8> {
    const CHANNEL: u8 = 0x04;
    // Opcode, length, two positions and the checksum of the footer, and the magic: https://mcap.dev/spec#footer-op0x02
    let footer = bytes.len() - (1 + 8 + 8 + 8 + 4 + 8);
    let start = u64::from_le_bytes(bytes[footer + 9..footer + 17].try_into().unwrap()) as usize;
    // A number, a schema, the topic, and an empty encoding and list.
    let length = topic.len() as u32;
    let body = [&[0xe7, 3, 1, 0], &length.to_le_bytes()[..], topic.as_bytes(), &[0; 8]].concat();
    let record = [&[CHANNEL][..], &(body.len() as u64).to_le_bytes(), &body].concat();
    bytes.splice(start..start, record.iter().copied());
    let checksum_at = footer + record.len() + 25;
    let checksum = crc32fast::hash(&bytes[start..checksum_at]);
    bytes[checksum_at..checksum_at + 4].copy_from_slice(&checksum.to_le_bytes());
    bytes
}

/// The file with other channels in the indexes behind its chunks, and the right checksum.
fn with_indexes(mut bytes: Vec<u8>, channel: impl Fn(u16) -> u16) -> Vec<u8> {
    // Opcodes of the MCAP specification: https://mcap.dev/spec#records
    const MESSAGE_INDEX: u8 = 0x07;
    const DATA_END: u8 = 0x0f;
    let mut at = 8;
    loop {
        let length = u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap());
        let body = at + 9;
        match bytes[at] {
            MESSAGE_INDEX => {
                let named = u16::from_le_bytes(bytes[body..body + 2].try_into().unwrap());
                bytes[body..body + 2].copy_from_slice(&channel(named).to_le_bytes());
            }
            DATA_END => {
                let checksum = crc32fast::hash(&bytes[..at]);
                bytes[body..body + 4].copy_from_slice(&checksum.to_le_bytes());
                return bytes;
            }
            _ => {}
        }
        at = body + usize::try_from(length).unwrap();
    }
}
