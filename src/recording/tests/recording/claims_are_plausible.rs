//! Guarantee: a file that claims more channels, messages, log lines or particles than a recording can have is damaged, columns of
//! one message have the same length, and files of other programs are named as such.
//!
//! Setup: files with correct checksums, written by the container's own library.

#![allow(clippy::unwrap_used, reason = "a test's own failure")]

use crate::sample::{header, read, record};
use kinetoscope_recording::channels::{Channel as _, DemContactForces, FrameClock};
use kinetoscope_recording::reader::Recording;
use kinetoscope_recording::recorder::Compression;
use mcap::records::{MessageHeader, Metadata};
use prost::Message as _;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::Cursor;

type Writer = mcap::Writer<Cursor<Vec<u8>>>;

/// A file with the head of a recording, and in one chunk what `write` writes.
fn file(library: &str, provenance: bool, write: impl FnOnce(&mut Writer)) -> Vec<u8> {
    let mut writer = mcap::WriteOptions::new()
        .library(library)
        .compression(None)
        .chunk_size(None)
        .disable_seeking(true)
        .create(Cursor::new(Vec::new()))
        .unwrap();
    let original = record(&header(Compression::None), 1, 1);
    let summary = mcap::Summary::read(&original).unwrap().unwrap();
    for index in &summary.attachment_indexes {
        writer.attach(&mcap::read::attachment(&original, index).unwrap()).unwrap();
    }
    for index in summary.metadata_indexes.iter().filter(|_| provenance) {
        writer.write_metadata(&mcap::read::metadata(&original, index).unwrap()).unwrap();
    }
    write(&mut writer);
    writer.finish().unwrap();
    writer.into_inner().into_inner()
}

fn add(writer: &mut Writer, topic: &str, schema: &str) -> u16 {
    let schema = writer.add_schema(schema, "protobuf", b"").unwrap();
    writer.add_channel(schema, topic, "protobuf", &BTreeMap::new()).unwrap()
}

fn message(writer: &mut Writer, channel_id: u16, payload: &[u8]) {
    let message = MessageHeader { channel_id, sequence: 0, log_time: 0, publish_time: 0 };
    writer.write_to_known_channel(&message, payload).unwrap();
}

fn error_of(bytes: &[u8]) -> String {
    let folder = tempfile::tempdir().unwrap();
    let (frames, error) = read(bytes, &folder.path().join("claims.mcap"));
    assert!(frames.is_empty());
    error.unwrap()
}

#[test]
fn recording_with_thousands_of_channels_is_damaged() {
    let bytes = file("kinetoscope", true, |writer| {
        let frame = add(writer, "/frame", FrameClock::SCHEMA);
        message(writer, frame, &[]);
        for index in 0..2000 {
            let channel = add(writer, &format!("/t{index}"), FrameClock::SCHEMA);
            message(writer, channel, &[]);
        }
    });
    assert!(error_of(&bytes).contains("more channels than any recording"));
}

#[test]
fn frame_with_millions_of_log_lines_is_damaged() {
    let bytes = file("kinetoscope", true, |writer| {
        let frame = add(writer, "/frame", FrameClock::SCHEMA);
        let log = add(writer, "/log", "foxglove.Log");
        message(writer, frame, &[]);
        for _ in 0..100_000 {
            message(writer, log, &[]);
        }
    });
    assert!(error_of(&bytes).contains("more log lines than any recording"));
}

#[test]
fn chunk_larger_than_the_particles_of_the_manifest_is_damaged() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bomb.mcap");
    let bytes = file("kinetoscope", true, |writer| {
        let frame = add(writer, "/frame", FrameClock::SCHEMA);
        message(writer, frame, &[]);
        let state = add(writer, "/state", "foxglove.PointCloud");
        message(writer, state, &vec![0; 80 << 20]);
    });
    std::fs::write(&path, bytes).unwrap();
    let last = |recording: Recording| recording.frames().unwrap().next().unwrap().unwrap_err();
    let of_two = last(Recording::open(&path).unwrap().with_max_particles(2)).to_string();
    assert!(of_two.contains("claims a size"), "{of_two}");
    // With as many particles, the state itself is wrong.
    let of_many = last(Recording::open(&path).unwrap().with_max_particles(1 << 20)).to_string();
    assert!(!of_many.contains("claims a size"), "{of_many}");
}

#[test]
fn columns_of_different_lengths_are_damage() {
    let forces = DemContactForces { from_x_m: vec![1.0, 2.0], ..DemContactForces::default() };
    let bytes = file("kinetoscope", true, |writer| {
        let frame = add(writer, "/frame", FrameClock::SCHEMA);
        message(writer, frame, &FrameClock::default().encode_to_vec());
        let channel = add(writer, DemContactForces::TOPIC, DemContactForces::SCHEMA);
        message(writer, channel, &forces.encode_to_vec());
    });
    let folder = tempfile::tempdir().unwrap();
    let (frames, _) = read(&bytes, &folder.path().join("columns.mcap"));
    let error = frames[0].get::<DemContactForces>().unwrap_err().to_string();
    assert!(error.contains("its columns have different lengths"), "{error}");
}

#[test]
fn file_of_another_program_with_our_names_is_foreign() {
    let attachment = |name: &str, data: &'static [u8]| mcap::Attachment {
        log_time: 0,
        create_time: 0,
        name: name.to_owned(),
        media_type: String::new(),
        data: Cow::Borrowed(data),
    };
    let foreign = |write: &dyn Fn(&mut Writer)| {
        let mut writer = mcap::Writer::new(Cursor::new(Vec::new())).unwrap();
        write(&mut writer);
        writer.finish().unwrap();
        error_of(&writer.into_inner().into_inner())
    };
    let metadata = Metadata { name: "kinetoscope".to_owned(), metadata: BTreeMap::new() };
    for error in [
        foreign(&|writer| writer.attach(&attachment("manifest.toml", b"\xff\xfe")).unwrap()),
        foreign(&|writer| writer.attach(&attachment("manifest.toml", b"a = 1")).unwrap()),
        foreign(&|writer| writer.write_metadata(&metadata).unwrap()),
    ] {
        assert!(error.contains("not a recording of this program"), "{error}");
    }
    // The same in a file that names this program as its writer is damage.
    let own = error_of(&file("kinetoscope", false, |writer| {
        writer.write_metadata(&metadata).unwrap();
    }));
    assert!(own.contains("the provenance is incomplete"), "{own}");
}
