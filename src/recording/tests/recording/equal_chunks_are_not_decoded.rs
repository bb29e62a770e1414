//! Guarantee: two recordings read in pairs deliver every pair of frames that differs, with its index, but only a few blocks of those
//! that are equal; damage that both files share is an error.
//!
//! Setup: 190 frames of 120 kB, 35 per block. Control: all pairs without this shortcut.

#![allow(clippy::unwrap_used, reason = "a test's own failure")]

use crate::sample::{fill, header, time_of};
use kinetoscope_recording::frame::Frame;
use kinetoscope_recording::paired_frames::PairedFrames;
use kinetoscope_recording::reader::{RecordedFrame, Recording, StoredFrames};
use kinetoscope_recording::recorder::{Clock, Compression, Outcome, Recorder, Selection};
use std::path::Path;

const FRAMES: u64 = 190;
/// Frames of a block.
const BLOCK: usize = 35;

/// The bytes of a recording with other values in some frames.
fn bytes(compression: Compression, frames: u64, changed: &[u64], first: u64) -> Vec<u8> {
    bytes_of(compression, frames, changed, first, &|_| 3750)
}

/// The same with a number of particles for each frame.
fn bytes_of(
    compression: Compression,
    frames: u64,
    changed: &[u64],
    first: u64,
    particles: &dyn Fn(u64) -> usize,
) -> Vec<u8> {
    let mut header = header(compression);
    header.selection = Selection::Named(vec!["state".to_owned(), "temperature".to_owned()]);
    if first > 0 {
        header.stored = StoredFrames::From(first);
    }
    let recorder = Recorder::create(Vec::new(), &header).unwrap();
    let mut recorder = if first > 0 { recorder.at_frame(first) } else { recorder };
    let mut frame = Frame::new();
    for index in first..frames {
        let values = if changed.contains(&index) { index + 1000 } else { index };
        fill(&mut frame, values, particles(index));
        recorder.write(Clock { count: 10 * index, time: time_of(index) }, &mut frame).unwrap();
    }
    recorder.finish(&Outcome::Complete).unwrap()
}

fn recording(bytes: Vec<u8>) -> Recording {
    Recording::from_bytes(bytes, Path::new("sample.mcap")).unwrap()
}

type Pair = [Option<RecordedFrame>; 2];

/// The pairs up to the end of both recordings, or an error.
fn drain(mut pairs: PairedFrames) -> Result<Vec<Pair>, String> {
    let mut found = Vec::new();
    loop {
        match pairs.advance().map_err(|error| error.to_string())? {
            [None, None] => return Ok(found),
            pair => found.push(pair),
        }
    }
}

fn differs([one, other]: &Pair) -> bool {
    match (one, other) {
        (Some(one), Some(other)) => one.messages() != other.messages(),
        _ => true,
    }
}

fn index([one, other]: &Pair) -> u64 {
    one.as_ref().or(other.as_ref()).unwrap().clock.frame
}

/// The pairs that differ, and how many pairs were delivered.
fn compared(left: &Recording, right: &Recording) -> (Vec<u64>, usize) {
    let pairs = drain(PairedFrames::that_can_differ(left, right).unwrap()).unwrap();
    let all = drain(PairedFrames::all(left, right).unwrap()).unwrap();
    let different =
        |pairs: &[Pair]| pairs.iter().filter(|pair| differs(pair)).map(index).collect::<Vec<_>>();
    assert_eq!(different(&pairs), different(&all));
    // Each pair is one of all, in their order.
    let mut rest = all.iter();
    for [one, other] in &pairs {
        let same = |a: &Option<RecordedFrame>, b: &Option<RecordedFrame>| match (a, b) {
            (Some(a), Some(b)) => a == b,
            (None, None) => true,
            _ => false,
        };
        assert!(rest.any(|[a, b]| same(one, a) && same(other, b)));
    }
    (different(&pairs), pairs.len())
}

#[test]
fn pairs_that_differ_are_delivered_and_most_others_are_not() {
    for compression in [Compression::None, Compression::Lz4, Compression::Zstd] {
        let left = recording(bytes(compression, FRAMES, &[], 0));
        for changed in [&[0][..], &[35], &[80], &[189], &[4, 80], &[]] {
            let right = recording(bytes(compression, FRAMES, changed, 0));
            let (different, delivered) = compared(&left, &right);
            assert_eq!(different, changed);
            // The first block; for each row of equal blocks its last one; and the blocks that differ.
            let most = (2 + 2 * changed.len()) * BLOCK;
            assert!(delivered <= most, "{delivered} pairs for {changed:?}");
        }
        // A recording that ends earlier, and parts of a run.
        let short = recording(bytes(compression, 100, &[], 0));
        assert_eq!(compared(&left, &short).0, (100..FRAMES).collect::<Vec<_>>());
        let part = recording(bytes(compression, FRAMES, &[], 10));
        let other = recording(bytes(compression, FRAMES, &[110], 10));
        assert_eq!(compared(&part, &other).0, [110]);
    }
}

/// The particles of a block that is equal in both recordings are those of the states after it.
#[test]
fn particles_of_equal_blocks_are_read() {
    let particles = |frame| if frame < 80 { 3750 } else { 3751 };
    let [left, right] = [&[][..], &[189]]
        .map(|changed| recording(bytes_of(Compression::Zstd, FRAMES, changed, 0, &particles)));
    let (different, delivered) = compared(&left, &right);
    assert_eq!(different, [189]);
    assert!(delivered < FRAMES as usize, "{delivered} pairs");
}

#[test]
fn damage_in_both_files_is_an_error() {
    let mut damaged = bytes(Compression::None, FRAMES, &[], 0);
    let middle = damaged.len() / 2;
    damaged[middle] ^= 1;
    let [left, right] = [damaged.clone(), damaged].map(recording);
    let shortcut = drain(PairedFrames::that_can_differ(&left, &right).unwrap());
    let all = drain(PairedFrames::all(&left, &right).unwrap());
    assert!(shortcut.is_err() && all.unwrap_err().contains("does not match its checksum"));
}
