//! Guarantee: `fill` and `zoom` report keyframes and manifests that do not agree with the rerun, and write no file of them.

use crate::forged_recording::Forgery;
use crate::keyframes::{MODELS, expect, keyframes, zoom};
use crate::subcommand_bench::Bench;
use kinetoscope::Recording;
use kinetoscope_recording::keyframe::{KEYFRAME, Keyframe};
use std::fs;
use std::path::{Path, PathBuf};

/// Replaces the bytes of the provenance, with a checksum that the reader does not need at the start of the file.
fn edited(path: &Path, old: &[u8], new: &[u8]) -> PathBuf {
    let mut bytes = fs::read(path).unwrap();
    let at = bytes.windows(old.len()).position(|window| window == old).unwrap();
    bytes.splice(at..at + old.len(), new.iter().copied());
    let copy = path.with_file_name("edited.mcap");
    fs::write(&copy, bytes).unwrap();
    copy
}

#[test]
fn other_physics_version_is_rejected_with_both_versions() {
    let bench = Bench::new();
    let keys = keyframes(&bench, MODELS[1].1);
    let own = Recording::open(&keys).unwrap().provenance().physics_version.to_string();
    let other = "9".repeat(own.len());
    let entry = |version: &str| {
        let length = (version.len() as u32).to_le_bytes();
        [b"physics_version", &length[..], version.as_bytes()].concat()
    };
    let copy = edited(&keys, &entry(&own), &entry(&other));
    for called in [
        zoom(&bench, &copy, ["0.01", "0.011", "1e-4"], "out.mcap"),
        bench.call(&["fill", copy.to_str().unwrap(), "-o", "out.mcap"]),
    ] {
        expect(&called, 5);
        let text = called.err.replace('\n', " ");
        assert!(text.contains(&format!("version {other} of gas")), "{text}");
        assert!(text.contains(&format!("version {own}")), "{text}");
        assert!(!bench.path("out.mcap").exists());
    }
}

/// Damage to the keyframe before the interval: the one before it gives the same frames.
#[test]
fn damaged_keyframe_is_replaced_by_the_one_before() {
    let bench = Bench::new();
    let (_, model, [from, to, every, _]) = MODELS[0];
    let keys = keyframes(&bench, model);
    expect(&zoom(&bench, &keys, [from, to, every], "intact.mcap"), 0);
    let mut bytes = fs::read(&keys).unwrap();
    // The keyframe of frame 7, which is before the interval.
    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    let (id, _) = summary.channels.iter().find(|(_, channel)| channel.topic == KEYFRAME).unwrap();
    let mut chunks = summary.chunk_indexes.iter();
    let chunk = chunks.rfind(|chunk| {
        chunk.message_index_offsets.contains_key(id) && chunk.message_start_time < 10 * 40_000_000
    });
    let chunk = chunk.unwrap();
    let middle = chunk.chunk_start_offset + chunk.chunk_length / 2;
    bytes[usize::try_from(middle).unwrap()] ^= 1;
    let copy = keys.with_file_name("damaged.mcap");
    fs::write(&copy, bytes).unwrap();
    let called = zoom(&bench, &copy, [from, to, every], "damaged.mcap");
    expect(&called, 5);
    assert!(called.out.contains("that of frame 0 is used"), "{}", called.out);
    let [intact, damaged] = ["intact.mcap", "damaged.mcap"].map(|name| bench.path(name));
    assert!(fs::read(intact).unwrap() == fs::read(damaged).unwrap());
    // Hashes are missing, so that the whole file cannot be proved.
    expect(&bench.call(&["fill", copy.to_str().unwrap(), "-o", "out.mcap"]), 5);
    assert!(!bench.path("out.mcap").exists());
}

/// Corrects the checksum of the first attachment: CRC-32 of its record without its last four bytes (<https://mcap.dev/spec>).
fn correct_attachment(path: &Path) {
    const ATTACHMENT: u8 = 9;
    let mut bytes = fs::read(path).unwrap();
    let mut at = 8;
    loop {
        let length = u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap());
        let end = at + 9 + usize::try_from(length).unwrap();
        if bytes[at] == ATTACHMENT {
            let mut sum = u32::MAX;
            for byte in &bytes[at + 9..end - 4] {
                sum ^= u32::from(*byte);
                for _ in 0..8 {
                    sum = (sum >> 1) ^ (0xedb8_8320 & (sum & 1).wrapping_neg());
                }
            }
            bytes[end - 4..end].copy_from_slice(&(!sum).to_le_bytes());
            break;
        }
        at = end;
    }
    fs::write(path, bytes).unwrap();
}

/// Bits of the states at the start, in the middle and at the end of a run, behind correct checksums. Control: the same file without a
/// change gives all frames.
#[test]
fn changed_keyframe_is_found() {
    for (name, model, [from, to, every, _]) in MODELS {
        let bench = Bench::new();
        let keys = keyframes(&bench, model);
        let forge = |changed: u64, place: Option<usize>| {
            let message = |topic: &str, frame: u64, payload: &mut Vec<u8>| {
                if let (KEYFRAME, Some(place), true) = (topic, place, frame == changed) {
                    let state = Keyframe::from_bytes(payload).unwrap().model;
                    let start = payload.windows(state.len()).position(|part| part == state);
                    payload[start.unwrap() + (state.len() - 1) * place / 4] ^= 1 << place;
                }
                true
            };
            let forgery = Forgery { message: Some(&message), ..Forgery::default() };
            forgery.write(&keys, &bench.path("forged.mcap"));
        };
        let fill = || bench.call(&["fill", "forged.mcap", "-o", "out.mcap"]);
        // Frames 0, 7, …, 35 and 40 are keyframes.
        for keyframe in [0, 14, 40] {
            for place in [0, 2, 4] {
                forge(keyframe, Some(place));
                let filled = fill();
                assert_eq!(filled.code, Some(4), "{name}: {}{}", filled.out, filled.err);
                assert!(filled.err.contains("/keyframe"), "{name}: {}", filled.err);
                assert!(!bench.path("out.mcap").exists());
            }
        }
        // The interval is after the second keyframe, and the third one is in it or next to it.
        forge(14, Some(2));
        let zoomed = zoom(&bench, &bench.path("forged.mcap"), [from, to, every], "out.mcap");
        assert!(zoomed.code != Some(0), "{name}: {}{}", zoomed.out, zoomed.err);
        forge(0, None);
        expect(&fill(), 0);
    }
}

/// Setup: 40 bits of the state in the first frame, behind correct checksums, and an interval before the second keyframe. Control: the same
/// file without a change is recomputed without a note.
#[test]
fn zoom_finds_a_changed_state_in_the_first_frame() {
    let intervals = [
        ["0.0011", "0.0012", "1e-4"],
        ["0.0011", "0.0012", "1e-4"],
        ["110", "112", "1"],
        ["3", "4", "0.5"],
    ];
    for ((name, model, _), interval) in MODELS.into_iter().zip(intervals) {
        let bench = Bench::new();
        let keys = keyframes(&bench, model);
        let forge = |place: Option<usize>| {
            let message = |topic: &str, frame: u64, payload: &mut Vec<u8>| {
                if let (KEYFRAME, Some(place), 0) = (topic, place, frame) {
                    let state = Keyframe::from_bytes(payload).unwrap().model;
                    let start = payload.windows(state.len()).position(|part| part == state);
                    payload[start.unwrap() + (state.len() - 1) * place / 9] ^= 1 << (place % 8);
                }
                true
            };
            let forgery = Forgery { message: Some(&message), ..Forgery::default() };
            forgery.write(&keys, &bench.path("forged.mcap"));
            zoom(&bench, &bench.path("forged.mcap"), interval, "out.mcap")
        };
        for place in 0..10 {
            let zoomed = forge(Some(place));
            assert_eq!(zoomed.code, Some(4), "{name} {place}: {}{}", zoomed.out, zoomed.err);
            assert!(zoomed.err.contains("in frame 0, /keyframe"), "{name}: {}", zoomed.err);
            assert!(!bench.path("out.mcap").exists());
        }
        let zoomed = forge(None);
        expect(&zoomed, 0);
        assert!(!zoomed.err.contains("damaged"), "{name}: {}", zoomed.err);
    }
}

/// A manifest with another coefficient under the frames of this one.
#[test]
fn rerun_that_differs_is_named_by_frame_and_channel() {
    let bench = Bench::new();
    let keys = keyframes(&bench, MODELS[0].1);
    let copy = edited(&keys, b"friction = 0.5\n", b"friction = 0.4\n");
    correct_attachment(&copy);
    let called = bench.call(&["fill", copy.to_str().unwrap(), "-o", "out.mcap"]);
    expect(&called, 4);
    assert!(called.err.contains("in frame ") && called.err.contains(", /"), "{}", called.err);
    assert!(!bench.path("out.mcap").exists());
}
