//! Guarantee: the layout of the file does not affect the values in it: every channel of every small experiment has the values that
//! were read before the layout was changed.
//!
//! Source: `recorded_values.txt`, written by this test from recordings of schema version 3. State columns and fields of messages are
//! hashed with their names, drawings by their bytes.
//! Control: a value that differs in its last bit, and a column with another name.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::small_experiments::MANIFESTS;
use kinetoscope_recording::channels::{ALL, PARTICLES, STATE};
use kinetoscope_recording::fields::{FieldValue, read_fields};
use kinetoscope_recording::reader::{RecordedFrame, StateTable};
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// The hash FNV-1a (Fowler, Noll and Vo; draft-eastlake-fnv), 64 bits.
struct Hash(u64);

impl Hash {
    fn add(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
}

impl Default for Hash {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

fn add_state(hash: &mut Hash, state: &StateTable) {
    // The masses of a gas, whose states have no radius, are recorded by later versions.
    let is_later = |name: &str| name == "mass" && state.column("radius").is_none();
    for name in state.columns().iter().filter(|name| !is_later(name)) {
        hash.add(name.as_bytes());
        for value in state.column(name).unwrap() {
            hash.add(&value.to_le_bytes());
        }
    }
}

/// Adds the values of a frame to the hashes of its channels.
fn add_frame(hashes: &mut BTreeMap<String, Hash>, frame: &RecordedFrame) {
    for message in frame.messages() {
        // Its columns are among those of the state.
        if message.topic() == PARTICLES {
            continue;
        }
        let hash = hashes.entry(message.topic().to_owned()).or_default();
        hash.add(&message.log_time_ns().to_le_bytes());
        if message.topic() == STATE {
            add_state(hash, frame.state().unwrap());
            continue;
        }
        let Some(channel) = ALL.iter().find(|channel| channel.schema == message.schema()) else {
            hash.add(message.payload());
            continue;
        };
        let fields = read_fields(channel, message.payload()).unwrap();
        // Fields of later versions.
        for field in
            fields.into_iter().filter(|field| !["first_id", "second_id"].contains(&field.name))
        {
            hash.add(field.name.as_bytes());
            for value in field.values {
                match value {
                    FieldValue::Number(number) => hash.add(&number.to_le_bytes()),
                    FieldValue::Count(count) => hash.add(&count.to_le_bytes()),
                    FieldValue::Text(text) => hash.add(text.as_bytes()),
                }
            }
        }
    }
}

/// A line per experiment and channel.
fn recorded_values() -> String {
    let mut text = String::new();
    for (name, manifest) in MANIFESTS {
        let experiment = kinetoscope_manifest::parse(manifest, &format!("{name}.toml"), &[]);
        let experiment = experiment.unwrap_or_else(|diagnostics| panic!("{diagnostics}"));
        let recording = kinetoscope::run(&experiment.runs[0]).unwrap();
        let mut hashes = BTreeMap::new();
        for frame in recording.frames().unwrap() {
            add_frame(&mut hashes, &frame.unwrap());
        }
        for (topic, hash) in hashes {
            writeln!(text, "{name} {topic} {:016x}", hash.0).unwrap();
        }
    }
    text
}

#[test]
fn values_of_all_channels_equal_those_before_the_layout_changed() {
    let (expected, found) = (include_str!("recorded_values.txt"), recorded_values());
    let differing: Vec<_> =
        found.lines().filter(|line| !expected.lines().any(|other| other == *line)).collect();
    assert!(differing.is_empty(), "other values:\n{}", differing.join("\n"));
    let missing: Vec<_> =
        expected.lines().filter(|line| !found.lines().any(|other| other == *line)).collect();
    assert!(missing.is_empty(), "missing:\n{}", missing.join("\n"));
}

#[test]
fn control_last_bit_and_name_of_a_value_change_the_hash() {
    let hash_of = |name: &str, value: f64| {
        let mut hash = Hash::default();
        hash.add(name.as_bytes());
        hash.add(&value.to_le_bytes());
        hash.0
    };
    assert_ne!(hash_of("x", 1.0), hash_of("x", 1.0_f64.next_up()));
    assert_ne!(hash_of("x", 1.0), hash_of("y", 1.0));
}
