//! Guarantee: a recording that its manifest does not reproduce is rejected with exit code 4, and the first difference is named with
//! topic, frame, simulated time, particle, field and both values.
//!
//! Setup: each recording is a valid one with one change behind correct checksums, so that only a rerun can find the change.

#![allow(clippy::unwrap_used, reason = "a test's own failure")]

use crate::forged_recording::{Forgery, MessageChange, kinetoscope, record, stderr, stdout};
use crate::small_experiments::manifest;
use kinetoscope_recording::channels::{Channel, PackingTemperature};
use kinetoscope_recording::reader::{RecordedFrame, Recording};
use prost::Message as _;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

/// The changed frame, particle and column.
const FRAME: u64 = 5;
const PARTICLE: usize = 7;
const COLUMN: usize = 3;

struct Packing {
    folder: tempfile::TempDir,
    recording: PathBuf,
}

impl Packing {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let recording = record(folder.path(), "packing", manifest("packing"));
        Self { folder, recording }
    }

    fn frame(&self, index: u64) -> RecordedFrame {
        let recording = Recording::open(&self.recording).unwrap();
        recording.frames().unwrap().nth(index as usize).unwrap().unwrap()
    }

    fn forged(&self, forgery: &Forgery<'_>) -> PathBuf {
        let path = self.folder.path().join("forged.mcap");
        forgery.write(&self.recording, &path);
        path
    }

    /// The output of `kinetoscope verify` for a recording with changed messages.
    fn changed(&self, change: MessageChange<'_>) -> Output {
        verify(&self.forged(&Forgery { message: Some(change), ..Forgery::default() }))
    }
}

fn verify(recording: &Path) -> Output {
    kinetoscope(["verify".as_ref(), recording.as_os_str()])
}

fn assert_differs(verified: &Output, expected: &str) {
    assert_eq!(verified.status.code(), Some(4), "{}{}", stdout(verified), stderr(verified));
    let text = stderr(verified);
    assert!(text.contains(expected), "{text}\nlacks\n{expected}");
}

/// Offset of a value in the payload of `/state`, whose rows are at its end.
fn offset_in_state(payload: &[u8], frame: &RecordedFrame) -> usize {
    let table = frame.state().unwrap();
    // The radius is on `/particles`.
    let width = table.columns().len() - 1;
    payload.len() - 8 * width * table.rows() + 8 * (width * PARTICLE + COLUMN)
}

#[test]
fn changed_bit_of_the_state_is_named() {
    let packing = Packing::new();
    let frame = packing.frame(FRAME);
    let verified = packing.changed(&|topic, index, payload| {
        if (topic, index) == ("/state", FRAME) {
            let offset = offset_in_state(payload, &frame);
            payload[offset] ^= 1;
        }
        true
    });
    let table = frame.state().unwrap();
    let right = table.row(PARTICLE)[COLUMN];
    let wrong = f64::from_bits(right.to_bits() ^ 1);
    let column = &table.columns()[COLUMN];
    let time = frame.clock.time;
    let expected = format!(
        "first difference: /state, frame 5 (time {time:?}), particle 7, {column}: {wrong:?} in the file, {right:?} in the rerun"
    );
    assert_differs(&verified, &expected);
}

/// Particles that are repeated with other values, and those of the start with another value: both are in the file only.
#[test]
fn changed_particles_are_named() {
    let packing = Packing::new();
    let (right, rows) =
        packing.frame(0).state().map(|state| (state.row(PARTICLE)[4], state.rows())).unwrap();
    let verified = packing.changed(&|topic, _, payload| {
        if topic == "/particles" {
            let offset = payload.len() - 8 * rows + 8 * PARTICLE;
            payload[offset] ^= 1;
        }
        true
    });
    let wrong = f64::from_bits(right.to_bits() ^ 1);
    let expected = format!(
        "first difference: /particles, frame 0 (time 0.0), particle 7, radius: {wrong:?} in the file, {right:?} in the rerun"
    );
    assert_differs(&verified, &expected);
}

#[test]
fn numbers_with_equal_text_are_distinguished_by_their_bits() {
    let packing = Packing::new();
    let frame = packing.frame(FRAME);
    let one = packing.folder.path().join("one.mcap");
    for (name, bits) in
        [("one.mcap", 0x7ff8_0000_0000_0000_u64), ("two.mcap", 0x7ff8_0000_0000_0001)]
    {
        let change = |topic: &str, index: u64, payload: &mut Vec<u8>| {
            if (topic, index) == ("/state", FRAME) {
                let offset = offset_in_state(payload, &frame);
                payload[offset..offset + 8].copy_from_slice(&bits.to_le_bytes());
            }
            true
        };
        Forgery { message: Some(&change), ..Forgery::default() }
            .write(&packing.recording, &packing.folder.path().join(name));
    }
    let two = packing.folder.path().join("two.mcap");
    let compared = kinetoscope(["compare".as_ref(), one.as_os_str(), two.as_os_str()]);
    assert_eq!(compared.status.code(), Some(4));
    let text = stderr(&compared);
    assert!(text.contains("NaN (bits 0x7ff8000000000000) in "), "{text}");
    assert!(text.contains("NaN (bits 0x7ff8000000000001) in "), "{text}");
}

#[test]
fn changed_field_of_a_channel_is_named() {
    let packing = Packing::new();
    let right = packing.frame(2).get::<PackingTemperature>().unwrap().unwrap();
    let wrong = PackingTemperature { a2: right.a2 + 1.0, ..right.clone() };
    let verified = packing.changed(&|topic, index, payload| {
        if (topic, index) == (PackingTemperature::TOPIC, 2) {
            *payload = wrong.encode_to_vec();
        }
        true
    });
    let expected = format!(", a2: {:?} in the file, {:?} in the rerun", wrong.a2, right.a2);
    assert_differs(&verified, "first difference: /temperature, frame 2 (time ");
    assert_differs(&verified, &expected);
}

#[test]
fn changed_drawing_changed_text_and_missing_message_are_named() {
    let packing = Packing::new();
    let drawing = packing.changed(&|topic, index, payload| {
        if (topic, index) == ("/discs", 4) {
            let last = payload.len() - 1;
            payload[last] ^= 1;
        }
        true
    });
    assert_differs(&drawing, "first difference: /discs, frame 4 (time ");
    assert_differs(&drawing, ": the messages differ from byte ");

    let missing = packing.changed(&|topic, index, _| (topic, index) != ("/discs", 3));
    assert_differs(&missing, "first difference: /discs, frame 3 (time ");
    assert_differs(&missing, ": the file has no such message");
    // Only drawings may be absent from a frame.
    let damaged = packing.changed(&|topic, index, _| (topic, index) != ("/pressure", 3));
    assert_eq!(damaged.status.code(), Some(5), "{}", stderr(&damaged));
    assert!(stderr(&damaged).contains("a frame has no message of /pressure, but another one has"));

    let line = packing.frame(0).log_lines()[0].text.clone();
    let other_log = |topic: &str, payload: &mut Vec<u8>| {
        if topic == "/log" {
            let offset = payload.windows(line.len()).position(|part| part == line.as_bytes());
            payload[offset.unwrap()] = b'X';
        }
    };
    let text = packing.changed(&|topic, _, payload| {
        other_log(topic, payload);
        true
    });
    assert_differs(&text, "first difference: /log, frame 0 (time 0.0): \"X");
    // What else differs, in a later frame, explains more.
    let both = packing.changed(&|topic, index, payload| {
        other_log(topic, payload);
        (topic, index) != ("/discs", 3)
    });
    assert_differs(&both, "first difference: /discs, frame 3 (time ");
    assert_differs(&text, &format!("\"{line}\" in the rerun"));
}

#[test]
fn missing_frames_of_a_complete_file_are_named() {
    let packing = Packing::new();
    let verified = packing.changed(&|_, index, _| index < 9);
    assert_differs(
        &verified,
        "first difference: number of frames: the file has only 9 (complete), all of them equal",
    );
}

#[test]
fn changed_seed_of_the_manifest_is_named() {
    let packing = Packing::new();
    let reseed = |text: &str| text.replace("seed = 8\n", "seed = 9\n");
    let forged = packing.forged(&Forgery { manifest: Some(&reseed), ..Forgery::default() });
    let verified = verify(&forged);
    assert_differs(&verified, "the run key in the file does not match its manifest");
    assert_differs(&verified, "first difference: /state, frame 0 (time 0.0), particle 0, x: ");
    // A forger who makes the key fit is found by the messages alone.
    let opened = Recording::open(&forged).unwrap();
    let provenance = opened.provenance();
    let key = kinetoscope_manifest::run_key(
        opened.manifest(),
        provenance.physics_version,
        provenance.schema_version,
    );
    let metadata = BTreeMap::from([("run_key".to_owned(), key.to_string())]);
    let forged = packing.forged(&Forgery { manifest: Some(&reseed), metadata, message: None });
    let verified = verify(&forged);
    assert!(!stderr(&verified).contains("run key"), "{}", stderr(&verified));
    assert_differs(&verified, "first difference: /state, frame 0 (time 0.0), particle 0, x: ");
}

#[test]
fn intact_part_of_a_torn_or_unfinished_file_is_compared() {
    let packing = Packing::new();
    let whole = packing.forged(&Forgery::default());
    let bytes = fs::read(&whole).unwrap();
    let torn = packing.folder.path().join("torn.mcap");
    fs::write(&torn, &bytes[..bytes.len() / 2]).unwrap();
    let verified = verify(&torn);
    assert_eq!(verified.status.code(), Some(5), "{}", stderr(&verified));
    assert!(stderr(&verified).contains("are intact, the rest is lost"), "{}", stderr(&verified));
    assert!(stdout(&verified).contains("frames rerun: equal in every message"));

    let interrupted = BTreeMap::from([("outcome".to_owned(), "interrupted".to_owned())]);
    let half = |_: &str, index: u64, _: &mut Vec<u8>| index < 9;
    let partial = packing.forged(&Forgery {
        metadata: interrupted,
        message: Some(&half),
        ..Forgery::default()
    });
    let verified = verify(&partial);
    assert_eq!(verified.status.code(), Some(5), "{}", stderr(&verified));
    assert!(stdout(&verified).contains("9 frames rerun: equal in every message"));
    assert!(stderr(&verified).contains("was interrupted"), "{}", stderr(&verified));

    // A change in the intact part takes precedence over the loss.
    let changed = packing.forged(&Forgery {
        message: Some(&|topic: &str, index: u64, payload: &mut Vec<u8>| {
            if (topic, index) == ("/state", 1) {
                let last = payload.len() - 1;
                payload[last] ^= 1;
            }
            true
        }),
        ..Forgery::default()
    });
    let bytes = fs::read(&changed).unwrap();
    fs::write(&torn, &bytes[..bytes.len() / 2]).unwrap();
    assert_differs(&verify(&torn), "first difference: /state, frame 1 (time ");
}

#[test]
fn other_files_are_reported_as_unreadable() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("text.mcap");
    fs::write(&path, "no recording").unwrap();
    assert_eq!(verify(&path).status.code(), Some(5));
    assert_eq!(verify(&folder.path().join("absent.mcap")).status.code(), Some(5));
}
