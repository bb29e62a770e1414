//! Promise: the same frames give the same bytes, and what was recorded comes back bit for bit.

use crate::sample::{fill, header, read, record, record_with_outcome, time_of};
use kinetoscope_recording::channels::{GasTemperature, PerCollision};
use kinetoscope_recording::frame::Frame;
use kinetoscope_recording::reader::Recording;
use kinetoscope_recording::recorder::{Compression, Outcome, Selection};

#[test]
fn equal_frames_give_equal_bytes() {
    for compression in [Compression::Zstd, Compression::Zstd3, Compression::Lz4, Compression::None]
    {
        let header = header(compression);
        let first = record(&header, 30, 500);
        let second = std::thread::spawn(move || record(&header, 30, 500)).join().unwrap();
        assert!(first == second, "{compression:?}");
    }
}

#[test]
fn recorded_frames_come_back_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    for compression in [Compression::Zstd, Compression::Zstd3, Compression::Lz4, Compression::None]
    {
        // 500 particles x 5 columns x 8 bytes x 120 frames: several chunks.
        let bytes = record(&header(compression), 120, 500);
        let (frames, error) = read(&bytes, &folder.path().join("sample.mcap"));
        assert_eq!(error, None);
        assert_eq!(frames.len(), 120);
        let mut expected = Frame::new();
        for (index, frame) in (0..).zip(&frames) {
            fill(&mut expected, index, 500);
            assert_eq!(frame.clock.frame, index);
            assert_eq!(frame.clock.step_or_event_count, 10 * index);
            assert_eq!(frame.clock.time.to_bits(), time_of(index).to_bits());
            let table = frame.state().unwrap();
            assert_eq!(table.rows(), 500);
            let bits =
                |values: &[f64]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
            let rows: Vec<f64> = (0..500).flat_map(|row| table.row(row).to_vec()).collect();
            assert_eq!(bits(&rows), bits(expected.state()));
            assert_eq!(table.value(7, "vy"), Some(expected.state()[7 * 5 + 3]));
            assert_eq!(table.column("radius").unwrap().count(), 500);
            assert!(table.column("mass").is_none());
            assert_eq!(frame.get::<GasTemperature>().unwrap(), expected.get::<GasTemperature>());
            // Opt-in, and not named.
            assert_eq!(frame.get::<PerCollision>().unwrap(), None);
            let model_lines =
                frame.log_lines().iter().filter(|line| !line.text.contains("playback"));
            assert!(model_lines.eq(expected.log_lines()));
        }
        assert_eq!(frames[0].log_lines()[0].text, "1 s of playback = 75 ms simulated");
    }
}

#[test]
fn the_file_says_what_ran() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sample.mcap");
    let fault = Outcome::Fault("a disc left the box at t = 0.3 s".to_owned());
    for outcome in [Outcome::Complete, fault, Outcome::Interrupted] {
        let header = header(Compression::Zstd);
        std::fs::write(&path, record_with_outcome(&header, 3, 2, &outcome).unwrap()).unwrap();
        let recording = Recording::open(&path).unwrap();
        assert_eq!(recording.manifest(), header.manifest);
        assert_eq!(recording.provenance().run_key, header.run_key);
        assert_eq!(recording.provenance().model, "gas");
        assert_eq!(recording.provenance().physics_version, 3);
        assert_eq!(recording.provenance().schema_version, 1);
        assert_eq!(recording.provenance().program_version, "0.1.0");
        assert_eq!(recording.provenance().outcome, Some(outcome));
        assert_eq!(recording.state_columns(), ["x", "y", "vx", "vy", "radius"]);
    }
}

#[test]
fn only_named_channels_are_recorded_and_the_opt_in_one_when_named() {
    let folder = tempfile::tempdir().unwrap();
    let mut header = header(Compression::Zstd);
    header.selection = Selection::Named(vec!["state".to_owned(), "per_collision".to_owned()]);
    let (frames, error) = read(&record(&header, 2, 2), &folder.path().join("sample.mcap"));
    assert_eq!(error, None);
    let topics: Vec<&str> = frames[0].messages().iter().map(|message| message.topic()).collect();
    assert_eq!(topics, ["/frame", "/state", "/per_collision", "/log"]);
    assert_eq!(frames[0].get::<PerCollision>().unwrap().unwrap().event, [1, 2]);
    header.selection = Selection::Named(vec!["presure".to_owned()]);
    let error = record_with_outcome(&header, 1, 1, &Outcome::Complete).unwrap_err();
    assert!(error.to_string().contains("presure") && error.to_string().contains("per_collision"));
}

/// Traps of the container's writer: an empty chunk with times (0, 0), a library text and threads of the machine.
#[test]
fn the_summary_has_the_time_range_of_the_frames() {
    for frames in [1, 2, 60] {
        let bytes = record(&header(Compression::Zstd), frames, 500);
        let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
        let statistics = summary.stats.unwrap();
        assert_eq!(statistics.message_start_time, 0);
        // 25 frames a second: 40 ms each.
        assert_eq!(statistics.message_end_time, (frames - 1) * 40_000_000);
        assert_eq!(statistics.chunk_count as usize, summary.chunk_indexes.len());
        for (chunk, next) in summary.chunk_indexes.iter().zip(summary.chunk_indexes.iter().skip(1))
        {
            // Chunks end where a frame ends.
            assert_eq!(next.message_start_time, chunk.message_end_time + 40_000_000);
        }
        let library = b"kinetoscope";
        // Magic, record kind and length, empty profile, the text's length.
        assert_eq!(bytes[8 + 9 + 4 + 4..][..library.len()], *library);
    }
}

#[test]
fn a_run_that_failed_before_its_first_frame_is_a_recording_without_frames() {
    let folder = tempfile::tempdir().unwrap();
    let (frames, error) =
        read(&record(&header(Compression::Zstd), 0, 0), &folder.path().join("none.mcap"));
    assert_eq!((frames.len(), error), (0, None));
}

#[test]
fn a_frame_that_breaks_the_declaration_is_refused_as_a_whole() {
    use kinetoscope_recording::channels::OrbitEnergy;
    use kinetoscope_recording::recorder::{Clock, Recorder};
    let header = header(Compression::Zstd);
    let mut recorder = Recorder::create(Vec::new(), &header).unwrap();
    let clock = Clock { count: 0, time: 0.0 };
    let mut foreign = Frame::new();
    foreign.push(&OrbitEnergy::default());
    assert!(recorder.write(clock, &mut foreign).unwrap_err().to_string().contains("/energy"));
    let mut twice = Frame::new();
    twice.push(&GasTemperature::default());
    twice.push(&GasTemperature::default());
    assert!(recorder.write(clock, &mut twice).unwrap_err().to_string().contains("two messages"));
    let mut torn = Frame::new();
    torn.push_state(&[1.0, 2.0]);
    assert!(recorder.write(clock, &mut torn).unwrap_err().to_string().contains("rows of 5"));
    assert_eq!(recorder.frames_written(), 0);
    // The refused frames left no trace.
    let mut frame = Frame::new();
    fill(&mut frame, 0, 2);
    recorder.write(clock, &mut frame).unwrap();
    assert!(recorder.finish(&Outcome::Complete).unwrap() == record(&header, 1, 2));
}

/// The same bytes in debug and release and from build to build. Where a change of the layout is meant, raise
/// `SCHEMA_VERSION` and pin the new checksums; a dependency that changes them breaks `--verify` of old recordings.
#[test]
fn the_bytes_are_those_of_earlier_builds() {
    let checksum = |compression| crc32fast::hash(&record(&header(compression), 30, 500));
    assert_eq!(checksum(Compression::None), 0x51b0_ff1f);
    assert_eq!(checksum(Compression::Lz4), 0x4544_7310);
    assert_eq!(checksum(Compression::Zstd), 0xb9cb_5be1);
    assert_eq!(checksum(Compression::Zstd3), 0x5e5a_c59e);
}
