//! Speed of writing and reading, each compared with the bare `mcap` crate with the same messages in the same run.
//!
//! Ours and the bare crate take turns, so that a busy machine slows both: the last column, the median of the ratios of the
//! pairs, is what to compare. The state is random: it hardly packs, as a state of many particles does. The written bytes go
//! nowhere, so that no disk hides a difference; the files that are read lie in the system's temporary folder.
//!
//! The bar: with `/state` alone a recording is written at 0.9 of the bare crate's speed or more. It holds but for one line: not
//! packed and into nothing, 0.8 at some 7 GB/s. There the bare crate copies a message once and we twice: the numbers are put
//! behind the message's head first, since the crate takes a message in one piece.

#![allow(clippy::unwrap_used, reason = "a benchmark may end on an error")]

use kinetoscope_recording::frame::{Frame, StateColumn};
use kinetoscope_recording::reader::Recording;
use kinetoscope_recording::recorder::{Clock, Compression, Header, Outcome, Recorder, Selection};
use kinetoscope_recording::scenery::{DrawnRadius, Scenery};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::num::{NonZeroU32, NonZeroU64, NonZeroUsize};
use std::path::Path;
use std::time::Instant;

const COLUMNS: &[StateColumn] = &[
    StateColumn { name: "x", unit: "m" },
    StateColumn { name: "y", unit: "m" },
    StateColumn { name: "vx", unit: "m/s" },
    StateColumn { name: "vy", unit: "m/s" },
    StateColumn { name: "radius", unit: "m" },
];
/// 100 kB a frame.
const PARTICLES: usize = 2500;
/// 80 MB a recording.
const FRAMES: u64 = 800;
const MEGABYTES: f64 = 80.0;
const PAIRS: usize = 15;
/// Bytes of messages after which a recording closes its chunk at the frame's end.
const CHUNK_PAYLOAD: usize = 1 << 20;

fn main() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("speed.mcap");
    let written = folder.path().join("written.mcap");
    let frames = RefCell::new(random_frames());
    println!("{:<24}{:>10}{:>10}{:>9}", "MB/s of state", "ours", "bare mcap", "ratio");
    for compression in [Compression::None, Compression::Lz4, Compression::Zstd, Compression::Zstd3]
    {
        let header = header(compression);
        std::fs::write(&path, record(Vec::new(), &header, &mut frames.borrow_mut())).unwrap();
        let messages = messages(&path);
        compare(
            &format!("write {compression:?}, no file"),
            || {
                drop(record(
                    Box::new(std::io::sink()) as Box<dyn Write>,
                    &header,
                    &mut frames.borrow_mut(),
                ))
            },
            || write_bare(Box::new(std::io::sink()), compression, &messages),
        );
        let file = || Box::new(BufWriter::new(File::create(&written).unwrap()));
        compare(
            &format!("write {compression:?}"),
            || record(file() as Box<dyn Write>, &header, &mut frames.borrow_mut()).flush().unwrap(),
            || write_bare(file(), compression, &messages),
        );
        for threads in [1, 2] {
            compare(
                &format!("read {compression:?}, threads {threads}"),
                || read(&path, threads),
                || read_bare(&path),
            );
        }
    }
}

/// Runs both in turn and prints the median speeds and the median of the ratios.
fn compare(name: &str, ours: impl Fn(), bare: impl Fn()) {
    let speed = |work: &dyn Fn()| {
        let start = Instant::now();
        work();
        MEGABYTES / start.elapsed().as_secs_f64()
    };
    let pairs: Vec<[f64; 2]> = (0..PAIRS).map(|_| [speed(&ours), speed(&bare)]).collect();
    let median = |of: &dyn Fn(&[f64; 2]) -> f64| {
        let mut values: Vec<f64> = pairs.iter().map(of).collect();
        values.sort_by(f64::total_cmp);
        values[PAIRS / 2]
    };
    println!(
        "{name:<24}{:>10.0}{:>10.0}{:>9.2}",
        median(&|pair| pair[0]),
        median(&|pair| pair[1]),
        median(&|pair| pair[0] / pair[1])
    );
}

fn header(compression: Compression) -> Header {
    Header {
        manifest: "name = \"speed\"\n".to_owned(),
        run_key: "0".repeat(64),
        model: "gas",
        physics_version: 1,
        program_version: "0".to_owned(),
        time_unit: "s",
        state_columns: COLUMNS,
        channels: &[],
        selection: Selection::Named(vec!["state".to_owned()]),
        scenery: Scenery {
            walls: Vec::new(),
            view: [[0.0, 0.0], [1.0, 1.0]],
            drawn_radius: DrawnRadius::Column { min: 0.02 },
            speed_range_top: 1.0,
            speed_unit: "m/s",
            arrows: false,
            force_range_top: None,
            trail: false,
            unused_fields: Vec::new(),
            names: Vec::new(),
            central_particle: None,
        },
        playback_fps: 25.0,
        max_drawn_particles: NonZeroU32::new(10_000).unwrap(),
        draw_every: NonZeroU64::MIN,
        compression,
        stored: kinetoscope_recording::recorder::StoredFrames::All,
        frames_expected: None,
        model_time: None,
    }
}

/// The frames of a recording; numbers in [0, 1) with 53 random bits, by Vigna's splitmix64.
fn random_frames() -> Vec<Frame> {
    let mut state = 14_u64;
    let mut random = || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((mixed ^ (mixed >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut frame = || {
        let mut frame = Frame::new();
        (0..PARTICLES).for_each(|_| frame.push_state(&[(); 5].map(|()| random())));
        frame
    };
    (0..FRAMES).map(|_| frame()).collect()
}

fn record<W: Write>(sink: W, header: &Header, frames: &mut [Frame]) -> W {
    let mut recorder = Recorder::create(sink, header).unwrap();
    for (count, frame) in (0..).zip(frames) {
        recorder.write(Clock { count, time: count as f64 }, frame).unwrap();
    }
    recorder.finish(&Outcome::Complete).unwrap()
}

/// A message as the bare writer takes it: the first channel is that of the clock, the second that of the state.
struct BareMessage {
    channel: usize,
    log_time: u64,
    payload: Vec<u8>,
}

fn messages(path: &Path) -> Vec<BareMessage> {
    let frames = Recording::open(path).unwrap().frames().unwrap();
    let messages = |frame: kinetoscope_recording::reader::RecordedFrame| {
        let copy = |message: &kinetoscope_recording::reader::RecordedMessage| BareMessage {
            channel: usize::from(message.topic() == "/state"),
            log_time: message.log_time_ns(),
            payload: message.payload().to_vec(),
        };
        frame.messages().iter().map(copy).collect::<Vec<_>>()
    };
    frames.flat_map(|frame| messages(frame.unwrap())).collect()
}

/// The recorder's options, and its chunks.
fn write_bare(sink: Box<dyn Write>, compression: Compression, messages: &[BareMessage]) {
    let options = mcap::WriteOptions::new()
        .compression(match compression {
            Compression::Zstd | Compression::Zstd3 => Some(mcap::Compression::Zstd),
            Compression::Lz4 => Some(mcap::Compression::Lz4),
            Compression::None => None,
        })
        .compression_level(if compression == Compression::Zstd3 { 3 } else { 1 })
        .compression_threads(0)
        .chunk_size(None)
        .disable_seeking(true);
    let mut writer = options.create(mcap::write::NoSeek::new(sink)).unwrap();
    let channels = ["/frame", "/state"].map(|topic| {
        let schema = writer.add_schema(topic, "protobuf", &[]).unwrap();
        writer.add_channel(schema, topic, "protobuf", &BTreeMap::new()).unwrap()
    });
    let mut in_chunk = 0;
    for (sequence, message) in (0..).zip(messages) {
        let header = mcap::records::MessageHeader {
            channel_id: channels[message.channel],
            sequence,
            log_time: message.log_time,
            publish_time: message.log_time,
        };
        writer.write_to_known_channel(&header, &message.payload).unwrap();
        in_chunk += message.payload.len();
        if in_chunk >= CHUNK_PAYLOAD {
            in_chunk = 0;
            writer.flush().unwrap();
        }
    }
    writer.finish().unwrap();
    writer.into_inner().into_inner().flush().unwrap();
}

fn read(path: &Path, threads: usize) {
    let recording = Recording::open(path).unwrap();
    let frames = recording.frames_on(NonZeroUsize::new(threads).unwrap()).unwrap();
    let rows: usize = frames.map(|frame| frame.unwrap().state().unwrap().rows()).sum();
    assert_eq!(rows as u64, FRAMES * PARTICLES as u64);
}

/// Unpacks all and checks the chunks; decodes no message.
fn read_bare(path: &Path) {
    let bytes = std::fs::read(path).unwrap();
    let messages = mcap::MessageStream::new(&bytes).unwrap();
    let payload: usize = messages.map(|message| message.unwrap().data.len()).sum();
    assert!(payload > FRAMES as usize * PARTICLES * 40);
}
