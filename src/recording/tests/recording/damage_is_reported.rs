//! Guarantee: every frame delivered from a torn or damaged recording is bitwise identical to the recorded one, and an error states what is
//! lost. Frames and error do not depend on the number of threads. No input makes the reader panic or allocate memory that the size of
//! the file does not justify.
//!
//! Setup: every cut, a flipped bit in every byte, random damage, hostile lengths, and files of other programs.

#![allow(clippy::unwrap_used, reason = "a test's own failure")]

use crate::sample::{fill, header, read, read_on, record};
use kinetoscope_recording::reader::{RecordedFrame, Recording};
use kinetoscope_recording::recorder::{Clock, Compression, Outcome, Recorder, Selection};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Seek, SeekFrom, Write};
use std::path::Path;

/// A recording of three frames in one chunk.
fn small(compression: Compression) -> Vec<u8> {
    let mut header = header(compression);
    header.selection = Selection::Named(vec!["state".to_owned(), "temperature".to_owned()]);
    record(&header, 3, 2)
}

/// A recording of eighty frames of 120 kB, 35 per block.
fn large() -> Vec<u8> {
    let mut header = header(Compression::Zstd);
    header.selection = Selection::Named(vec!["state".to_owned(), "temperature".to_owned()]);
    record(&header, 80, 3750)
}

/// Whether two frames are equal, except for their positions in the file.
fn same(one: &RecordedFrame, other: &RecordedFrame) -> bool {
    one.clock == other.clock
        && one.state() == other.state()
        && one.log_lines() == other.log_lines()
        && one.messages() == other.messages()
}

fn check(bytes: &[u8], original: &[RecordedFrame], path: &Path, case: &str) {
    std::fs::write(path, bytes).unwrap();
    check_file(path, original, &[2, 4], case);
}

fn check_file(path: &Path, original: &[RecordedFrame], thread_counts: &[usize], case: &str) {
    let (frames, error) = read_on(path, 1);
    for &threads in thread_counts {
        let on_threads = read_on(path, threads);
        assert!(on_threads.0 == frames, "{case}: the frames differ on {threads} threads");
        assert_eq!(on_threads.1, error, "{case}: {threads} threads");
    }
    assert!(error.is_some(), "{case}: no error");
    assert!(frames.len() <= original.len(), "{case}");
    assert!(frames.iter().zip(original).all(|(one, other)| same(one, other)), "{case}");
}

#[test]
fn cut_at_any_byte_is_reported_and_leaves_whole_frames() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cut.mcap");
    for compression in [Compression::Zstd, Compression::Lz4, Compression::None] {
        let bytes = small(compression);
        let (original, error) = read(&bytes, &path);
        assert_eq!((original.len(), error), (3, None));
        let file = File::options().write(true).open(&path).unwrap();
        for cut in (0..bytes.len()).rev() {
            file.set_len(cut as u64).unwrap();
            check_file(&path, &original, &[2], &format!("{compression:?}, cut at {cut}"));
            let error = read_on(&path, 1).1.unwrap();
            assert!(error.contains("is cut off"), "{compression:?}, cut at {cut}: {error}");
        }
    }
}

#[test]
fn flipped_bit_in_any_byte_is_reported_and_changes_no_frame() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flip.mcap");
    for compression in [Compression::Zstd, Compression::Lz4, Compression::None] {
        let bytes = small(compression);
        let (original, _) = read(&bytes, &path);
        let mut file = File::options().write(true).open(&path).unwrap();
        let mut put = |offset: usize, byte: u8| {
            file.seek(SeekFrom::Start(offset as u64)).unwrap();
            file.write_all(&[byte]).unwrap();
        };
        for (offset, &byte) in bytes.iter().enumerate() {
            let mask = 1 << (offset % 8);
            put(offset, byte ^ mask);
            check_file(
                &path,
                &original,
                &[2],
                &format!("{compression:?}, byte {offset} ^ {mask:#x}"),
            );
            put(offset, byte);
        }
    }
}

/// The blocks before the damage are read; those after it are not.
#[test]
fn frames_before_the_damage_are_delivered() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("large.mcap");
    let mut bytes = large();
    let (original, error) = read(&bytes, &path);
    assert_eq!((original.len(), error), (80, None));
    let mut random = splitmix64();
    let mut delivered = std::collections::BTreeSet::new();
    for trial in 0..60 {
        let byte = random() as usize % bytes.len();
        let (frames, _) = read(&bytes[..byte], &path);
        delivered.insert(frames.len());
        check(&bytes[..byte], &original, &path, &format!("trial {trial}, cut at {byte}"));
        bytes[byte] ^= 0x10;
        check(&bytes, &original, &path, &format!("trial {trial}, byte {byte}"));
        bytes[byte] ^= 0x10;
    }
    assert!(delivered.is_superset(&[0, 35, 70].into()), "{delivered:?}");
}

#[test]
fn bytes_after_the_end_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("longer.mcap");
    let mut bytes = small(Compression::Zstd);
    let (original, _) = read(&bytes, &path);
    bytes.push(0);
    check(&bytes, &original, &path, "an additional byte");
}

/// All frames of the blocks that were closed before a kill are delivered.
#[test]
fn killed_run_leaves_the_frames_of_its_closed_blocks() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("killed.partial.mcap");
    // Compressed blocks leave the recorder when a thread has finished them, so that their number depends on the time.
    let header = header(Compression::None);
    let mut bytes = Vec::new();
    let mut recorder = Recorder::create(&mut bytes, &header).unwrap();
    let mut frame = kinetoscope_recording::frame::Frame::new();
    for index in 0..200 {
        fill(&mut frame, index, 500);
        recorder.write(Clock { count: index, time: 0.0 }, &mut frame).unwrap();
    }
    drop(recorder);
    let (frames, error) = read(&bytes, &path);
    // 500 particles need 20 kB of state and about 90 kB of drawings per frame; a block of 8 MiB of drawings contains about 92 frames.
    assert!(frames.len() > 100 && frames.len() < 200, "{}", frames.len());
    let error = error.unwrap();
    assert!(error.contains(&format!("frames 0 to {} are intact", frames.len() - 1)), "{error}");
    assert_eq!(Recording::open(&path).unwrap().provenance().outcome, None);
}

#[test]
fn impossible_record_length_is_rejected() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("hostile.mcap");
    // 33 bytes that make a reader without checks panic: magic, an empty header record, a record of u64::MAX bytes.
    let mut bytes = b"\x89MCAP0\r\n".to_vec();
    bytes.push(0x01);
    bytes.extend(7_u64.to_le_bytes());
    bytes.extend([0; 7]);
    bytes.push(0x06);
    bytes.extend(u64::MAX.to_le_bytes());
    assert_eq!(bytes.len(), 33);
    let (frames, error) = read(&bytes, &path);
    assert!(frames.is_empty() && error.is_some());
}

/// A chunk states an unpacked size of 1 TiB; the size is rejected before memory is allocated.
#[test]
fn excessive_chunk_size_is_rejected() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("hostile.mcap");
    let mut bytes = small(Compression::Zstd);
    let (chunk, length) = chunk_of(&bytes);
    assert!(length > 60);
    bytes[chunk + 9 + 16..chunk + 9 + 24].copy_from_slice(&(1_u64 << 40).to_le_bytes());
    let (frames, error) = read(&bytes, &path);
    assert!(frames.is_empty());
    assert!(error.unwrap().contains("claims a size"));
}

/// A chunk with a correct checksum contains a record with a stated length of u64::MAX bytes.
#[test]
fn hostile_length_inside_a_chunk_is_rejected() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("hostile.mcap");
    let mut bytes = small(Compression::None);
    let (chunk, length) = chunk_of(&bytes);
    let (end, content) = (chunk + 9 + length, chunk + 9 + 40);
    bytes[content + 1..content + 9].copy_from_slice(&u64::MAX.to_le_bytes());
    let checksum = crc32fast::hash(&bytes[content..end]);
    bytes[chunk + 9 + 24..chunk + 9 + 28].copy_from_slice(&checksum.to_le_bytes());
    let (frames, error) = read(&bytes, &path);
    assert!(frames.is_empty());
    assert!(error.unwrap().contains("a record is too short"));
}

/// Offset and length of the first chunk record.
fn chunk_of(bytes: &[u8]) -> (usize, usize) {
    let mut position = 8;
    loop {
        let length: [u8; 8] = bytes[position + 1..position + 9].try_into().unwrap();
        let length = u64::from_le_bytes(length) as usize;
        if bytes[position] == 0x06 {
            return (position, length);
        }
        position += 9 + length;
    }
}

#[test]
fn files_of_other_programs_are_identified() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("foreign.mcap");
    let (_, error) = read(b"name = \"a manifest\"\n", &path);
    assert!(error.unwrap().contains("is not an MCAP file"));
    let mut foreign = Vec::new();
    let mut writer = mcap::Writer::new(std::io::Cursor::new(&mut foreign)).unwrap();
    let channel =
        writer.add_channel(0, "/imu", "json", &std::collections::BTreeMap::new()).unwrap();
    let message = mcap::records::MessageHeader {
        channel_id: channel,
        sequence: 0,
        log_time: 0,
        publish_time: 0,
    };
    writer.write_to_known_channel(&message, b"{}").unwrap();
    writer.finish().unwrap();
    drop(writer);
    let (_, error) = read(&foreign, &path);
    assert!(error.unwrap().contains("not a recording of this program"));
    let missing = Recording::open(&folder.path().join("missing.mcap")).unwrap_err();
    assert!(missing.to_string().contains("missing.mcap"));
}

/// Vigna's splitmix64 with a fixed seed, so that a failure is reproducible.
fn splitmix64() -> impl FnMut() -> u64 {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    move || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }
}

#[test]
fn random_damage_does_not_panic() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("random.mcap");
    let mut random = splitmix64();
    for compression in [Compression::Zstd, Compression::Lz4, Compression::None] {
        let bytes = small(compression);
        let (original, _) = read(&bytes, &path);
        for trial in 0..1000 {
            let mut damaged = bytes.clone();
            for _ in 0..=random() % 8 {
                let byte = random() as usize % damaged.len();
                damaged[byte] = random() as u8;
            }
            if damaged != bytes {
                check(&damaged, &original, &path, &format!("{compression:?}, trial {trial}"));
            }
        }
    }
}

#[test]
fn interrupted_run_opens_with_its_outcome() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("stopped.partial.mcap");
    let bytes =
        crate::sample::record_with_outcome(&header(Compression::Zstd), 3, 2, &Outcome::Interrupted)
            .unwrap();
    let (frames, error) = read(&bytes, &path);
    assert_eq!((frames.len(), error), (3, None));
}

#[test]
fn recording_of_another_schema_is_rejected_with_both_versions() {
    for version in ["1", "4", "6"] {
        let error = error_of_schema(version);
        let expected = format!("has schema version {version}; this program reads version 5");
        assert!(error.contains(&expected), "{error}");
    }
}

/// The error of a recording whose provenance has another version, and other values than today.
fn error_of_schema(version: &str) -> String {
    // The metadata of schema 1, with its names of keys.
    let metadata = BTreeMap::from([
        ("content_key".to_owned(), "0".to_owned()),
        ("playback_rate".to_owned(), "25".to_owned()),
        ("program_version".to_owned(), "0.1.0".to_owned()),
        ("physics_version".to_owned(), "2".to_owned()),
        ("schema_version".to_owned(), version.to_owned()),
    ]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("old.mcap");
    let mut writer = mcap::WriteOptions::new()
        .library("kinetoscope")
        .create(std::fs::File::create(&path).unwrap())
        .unwrap();
    let attachment = mcap::Attachment {
        log_time: 0,
        create_time: 0,
        name: "manifest.toml".to_owned(),
        media_type: "application/toml".to_owned(),
        data: b"name = \"old\"\n".to_vec().into(),
    };
    writer.attach(&attachment).unwrap();
    writer
        .write_metadata(&mcap::records::Metadata { name: "kinetoscope".to_owned(), metadata })
        .unwrap();
    writer.finish().unwrap();
    Recording::open(&path).unwrap_err().to_string()
}
