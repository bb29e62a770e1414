//! Guarantee: the same frames give the same bytes, and recorded values are read back bitwise identical.

use crate::sample::{fill, header, read, record, record_with_outcome, time_of};
use kinetoscope_console::Explained as _;
use kinetoscope_recording::channels::{GasSpeeds, GasTemperature, PerCollision};
use kinetoscope_recording::frame::Frame;
use kinetoscope_recording::reader::Recording;
use kinetoscope_recording::recorder::{Clock, Compression, Header, Outcome, Recorder, Selection};

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
fn recorded_frames_are_read_back_bitwise_identical() {
    let folder = tempfile::tempdir().unwrap();
    for compression in [Compression::Zstd, Compression::Zstd3, Compression::Lz4, Compression::None]
    {
        // 500 particles x 5 columns x 8 bytes x 120 frames give several chunks.
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
            // The channel is optional and not selected.
            assert_eq!(frame.get::<PerCollision>().unwrap(), None);
            let model_lines =
                frame.log_lines().iter().filter(|line| !line.text.contains("playback"));
            assert!(model_lines.eq(expected.log_lines()));
        }
        assert_eq!(frames[0].log_lines()[0].text, "1 s of playback = 75 ms simulated");
    }
}

/// Guarantee: a message of more than 16 MiB, which has a chunk of its own, is read back bit for bit, also as the first of its group and
/// between small ones. Control: each frame has another number of particles.
#[test]
fn large_messages_are_read_back_bitwise_identical() {
    let folder = tempfile::tempdir().unwrap();
    for compression in [Compression::Zstd, Compression::Lz4, Compression::None] {
        let selection = Selection::Named(vec!["state".to_owned()]);
        let header = Header { selection, ..header(compression) };
        for particles in [[600_000, 3, 600_001], [3, 600_000, 4]] {
            let mut recorder = Recorder::create(Vec::new(), &header).unwrap();
            let values = |count: usize| (0..5 * count).map(|value| value as f64 / 3.0);
            for (index, count) in (0..).zip(particles) {
                let mut frame = Frame::new();
                let rows = frame.resize_state(5 * count);
                rows.iter_mut().zip(values(count)).for_each(|(row, value)| *row = value);
                recorder.write(Clock { count: index, time: time_of(index) }, &mut frame).unwrap();
            }
            let bytes = recorder.finish(&Outcome::Complete).unwrap();
            let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
            assert_eq!(summary.stats.unwrap().message_count, 10);
            let (frames, error) = read(&bytes, &folder.path().join("large.mcap"));
            assert_eq!((frames.len(), error), (3, None));
            for (frame, count) in frames.iter().zip(particles) {
                let found = frame.state().unwrap().iter().flatten().map(|value| value.to_bits());
                assert!(found.eq(values(count).map(f64::to_bits)), "{compression:?}, {count}");
            }
        }
    }
}

/// Guarantee: every NaN has the bits of `f64::NAN`, whatever the processor that computed it: 0/0 has a sign on x86-64 and none on aarch64.
/// Setup: NaNs with a sign and with a payload, in the state, in single values and in series.
/// Control: the bits of other numbers count, also the sign of a zero.
#[test]
fn computed_nan_has_one_form() {
    let bytes_with = |number: f64, other: f64| {
        let mut recorder = Recorder::create(Vec::new(), &header(Compression::None)).unwrap();
        let mut frame = Frame::new();
        for index in 0..2 {
            frame.clear();
            if index == 0 {
                frame.push_state(&[0.5, 0.25, number, other, 0.02]);
            } else {
                frame.resize_state(5).copy_from_slice(&[0.5, 0.25, other, number, 0.02]);
            }
            let mean_speed_temperature_k = number;
            frame.push(&GasTemperature { mean_speed_temperature_k, ..GasTemperature::default() });
            frame.push(&GasSpeeds { density: vec![1.0, other, number], ..GasSpeeds::default() });
            recorder.write(Clock { count: index, time: time_of(index) }, &mut frame).unwrap();
        }
        recorder.finish(&Outcome::Complete).unwrap()
    };
    let expected = bytes_with(f64::NAN, f64::NAN);
    let [negative, payload] = [0xfff8_0000_0000_0000, 0x7ff8_0000_0000_0001].map(f64::from_bits);
    assert!(bytes_with(negative, payload) == expected);
    assert!(bytes_with(0.0, 1.0) != bytes_with(-0.0, 1.0), "control");
}

#[test]
fn file_contains_the_provenance_of_the_run() {
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
        assert_eq!(recording.provenance().schema_version, 5);
        assert_eq!(recording.provenance().program_version, "0.1.0");
        assert_eq!(recording.provenance().outcome, Some(outcome));
        assert_eq!(recording.state_columns(), ["x", "y", "vx", "vy", "radius"]);
    }
}

#[test]
fn only_selected_channels_are_recorded() {
    let folder = tempfile::tempdir().unwrap();
    let mut header = header(Compression::Zstd);
    header.selection = Selection::Named(vec!["state".to_owned(), "per_collision".to_owned()]);
    let (frames, error) = read(&record(&header, 2, 2), &folder.path().join("sample.mcap"));
    assert_eq!(error, None);
    let topics: Vec<&str> = frames[0].messages().iter().map(|message| message.topic()).collect();
    assert_eq!(topics, ["/frame", "/particles", "/state", "/per_collision", "/log"]);
    assert_eq!(frames[0].get::<PerCollision>().unwrap().unwrap().event, [1, 2]);
    header.selection = Selection::Named(vec!["presure".to_owned()]);
    let error = record_with_outcome(&header, 1, 1, &Outcome::Complete).unwrap_err();
    assert!(error.to_string().contains("presure"), "{error}");
    assert!(error.help().unwrap().contains("per_collision"), "{error}");
}

/// Excludes known defects of the container's writer: an empty chunk with times (0, 0), and a library text that depends on the build.
#[test]
fn summary_contains_the_time_range_of_the_frames() {
    for frames in [1, 2, 60, 300] {
        let bytes = record(&header(Compression::Zstd), frames, 500);
        let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
        let statistics = summary.stats.unwrap();
        assert_eq!(statistics.message_start_time, 0);
        // 25 frames per second: 40 ms per frame.
        assert_eq!(statistics.message_end_time, (frames - 1) * 40_000_000);
        assert_eq!(statistics.chunk_count as usize, summary.chunk_indexes.len());
        // Chunks end where a frame ends, and only one group has chunks with a channel.
        for topic in ["/frame", "/state", "/discs"] {
            let (id, _) =
                summary.channels.iter().find(|(_, channel)| channel.topic == topic).unwrap();
            let mut next = 0;
            for chunk in &summary.chunk_indexes {
                if chunk.message_index_offsets.contains_key(id) {
                    assert_eq!(chunk.message_start_time, next);
                    next = chunk.message_end_time + 40_000_000;
                }
            }
            assert_eq!(next, frames * 40_000_000);
        }
        let library = b"kinetoscope";
        // The text follows magic, record kind and length, empty profile, and its own length.
        assert_eq!(bytes[8 + 9 + 4 + 4..][..library.len()], *library);
    }
}

#[test]
fn run_that_fails_before_its_first_frame_gives_a_recording_without_frames() {
    let folder = tempfile::tempdir().unwrap();
    let (frames, error) =
        read(&record(&header(Compression::Zstd), 0, 0), &folder.path().join("none.mcap"));
    assert_eq!((frames.len(), error), (0, None));
}

#[test]
fn frame_that_violates_the_declaration_is_rejected_completely() {
    use kinetoscope_recording::channels::OrbitEnergy;
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
    // The rejected frames do not affect the bytes.
    let mut frame = Frame::new();
    fill(&mut frame, 0, 2);
    recorder.write(clock, &mut frame).unwrap();
    assert!(recorder.finish(&Outcome::Complete).unwrap() == record(&header, 1, 2));
}

/// The bytes are equal in debug and release and for every build. After an intended change of the layout, raise
/// `SCHEMA_VERSION` and pin the new checksums. A dependency that changes the checksums breaks the verification of old recordings.
#[test]
fn bytes_equal_those_of_earlier_builds() {
    let checksum = |compression| crc32fast::hash(&record(&header(compression), 30, 500));
    let found =
        [Compression::None, Compression::Lz4, Compression::Zstd, Compression::Zstd3].map(checksum);
    assert_eq!(found, [0xd89a_ca0b, 0x566b_25ee, 0x3ff8_1624, 0xafc5_8d00], "{found:#x?}");
}
