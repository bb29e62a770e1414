//! Speed of an analysis compared with a bare reader that decompresses and verifies the chunks of the same file on the
//! same number of threads.
//!
//! Each model has a recording with 1 GB of state: random numbers in [0, 1), which hardly compress, like the state of
//! many particles. Both programs alternate, so that other load slows both. The figure to compare is the ratio: the
//! median of the pairs, with the smallest and the largest. The files are in the system's temporary folder and in the
//! page cache when they are read.
//!
//! Requirement: at least 0.9 of the bare reader's rate. Two quiet cores of an AMD EPYC of the fourth generation, series of 7 pairs:
//!
//! | | one series before | four series now |
//! |---|---|---|
//! | DEM | 0.61 (0.57 to 0.65) | 0.99 (0.98 to 1.12), 1.01 (0.99 to 1.02), 0.81 (0.70 to 1.12), 1.00 (0.96 to 1.06) |
//! | gas | 1.11 (1.08 to 1.27) | 1.10 (1.06 to 1.13), 1.06 (1.05 to 1.13), 1.14 (1.02 to 1.16), 1.08 (0.93 to 1.43) |
//! | packing | 0.81 (0.69 to 0.84) | 0.92 (0.86 to 0.95), 0.90 (0.84 to 0.94), 0.92 (0.64 to 1.14), 0.90 (0.85 to 0.95) |
//!
//! The discs of a DEM state are now read without a call for each. The call returned a disc in memory, and a read of two values that have
//! just been written one after the other waits. Rows of a packing are read without a call as well.
//!
//! The size distribution of discs found once per run, displacements only while they are known, and radii divided by a mean found once
//! per frame: 1.03 (packing, 0.96 to 1.22) and 1.01 (DEM, 0.91 to 1.15) less processor time, hardly beyond noise.

#![allow(clippy::unwrap_used, reason = "a benchmark may end on an error")]

use kinetoscope_analysis::{input::recording, run, run::RunOptions};
use kinetoscope_manifest::parse;
use kinetoscope_recording::channels::{self, ChannelDeclaration};
use kinetoscope_recording::frame::{Frame, StateColumn};
use kinetoscope_recording::recorder::{Clock, Compression, Header, Outcome, Recorder, Selection};
use kinetoscope_recording::scenery::{DrawnRadius, Scenery};
use std::fs::File;
use std::io::{BufReader, Read};
use std::num::{NonZeroU32, NonZeroU64, NonZeroUsize};
use std::path::Path;
use std::sync::mpsc::sync_channel;
use std::sync::{Arc, Mutex};
use std::thread::available_parallelism;
use std::time::Instant;

const COLUMNS: &[StateColumn] = &[
    StateColumn { name: "x", unit: "" },
    StateColumn { name: "y", unit: "" },
    StateColumn { name: "vx", unit: "" },
    StateColumn { name: "vy", unit: "" },
    StateColumn { name: "radius", unit: "" },
];
const PARTICLES: u64 = 10_000;
const FRAMES: u64 = 2500;
const GIGABYTES: f64 = (PARTICLES * FRAMES * 40) as f64 / 1e9;
const PAIRS: usize = 7;

fn main() {
    let folder = tempfile::tempdir().unwrap();
    let threads = available_parallelism().unwrap();
    println!("{:<10}{:>14}{:>14}{:>9}   range", "GB/s", "analysis", "bare reader", "ratio");
    for (model, config, scale) in [
        ("dem", "discs = 10000\nwidth_m = 1.0\nheight_m = 1.0", 1.0),
        ("gas", "particles = 10000", 0.7),
        ("packing", "discs = 10000\nwidth = 400.0\nheight = 400.0", 400.0),
    ] {
        let path = folder.path().join(format!("{model}.mcap"));
        record(&path, model, config, scale);
        let pairs: Vec<[f64; 2]> = (0..PAIRS)
            .map(|_| [speed(|| analyze(&path, threads)), speed(|| read_bare(&path, threads))])
            .collect();
        let sorted = |of: &dyn Fn(&[f64; 2]) -> f64| {
            let mut values: Vec<f64> = pairs.iter().map(of).collect();
            values.sort_by(f64::total_cmp);
            values
        };
        let ratios = sorted(&|pair| pair[0] / pair[1]);
        println!(
            "{model:<10}{:>14.2}{:>14.2}{:>9.2}   {:.2} to {:.2}",
            sorted(&|pair| pair[0])[PAIRS / 2],
            sorted(&|pair| pair[1])[PAIRS / 2],
            ratios[PAIRS / 2],
            ratios[0],
            ratios[PAIRS - 1]
        );
        std::fs::remove_file(path).unwrap();
    }
}

fn speed(work: impl Fn()) -> f64 {
    let start = Instant::now();
    work();
    GIGABYTES / start.elapsed().as_secs_f64()
}

fn analyze(path: &Path, threads: NonZeroUsize) {
    let open = recording::open(path).map_err(|error| error.message).unwrap();
    let options = RunOptions { with_figures: true, ..RunOptions::default() };
    let found = run::analyze(&open, Vec::new(), options, threads).map_err(|error| error.message);
    assert_eq!(found.unwrap().frames, FRAMES);
}

/// Reads record by record, and passes chunks to threads that decompress them and verify their checksums.
fn read_bare(path: &Path, threads: NonZeroUsize) {
    const MAGIC: u64 = 8;
    const CHUNK: u8 = 6;
    let mut file = BufReader::new(File::open(path).unwrap());
    let end = file.get_ref().metadata().unwrap().len() - MAGIC;
    let mut magic = [0; MAGIC as usize];
    file.read_exact(&mut magic).unwrap();
    let mut position = MAGIC;
    let (sender, queue) = sync_channel::<Vec<u8>>(2 * threads.get());
    let queue = Arc::new(Mutex::new(queue));
    std::thread::scope(|scope| {
        for _ in 0..threads.get() {
            let queue = Arc::clone(&queue);
            scope.spawn(move || {
                loop {
                    let next = queue.lock().unwrap().recv();
                    let Ok(body) = next else { return };
                    check_chunk(&body);
                }
            });
        }
        while position < end {
            let mut prefix = [0; 9];
            file.read_exact(&mut prefix).unwrap();
            let length = u64::from_le_bytes(prefix[1..].try_into().unwrap());
            let mut body = Vec::with_capacity(length as usize);
            file.by_ref().take(length).read_to_end(&mut body).unwrap();
            position += 9 + length;
            if prefix[0] == CHUNK {
                sender.send(body).unwrap();
            }
        }
        drop(sender);
    });
}

/// Parses a chunk: two times, size and checksum of its content, compression, and the content with its length.
fn check_chunk(body: &[u8]) {
    let size = u64::from_le_bytes(body[16..24].try_into().unwrap()) as usize;
    let sum = u32::from_le_bytes(body[24..28].try_into().unwrap());
    let name = u32::from_le_bytes(body[28..32].try_into().unwrap()) as usize;
    let content = zstd::bulk::decompress(&body[32 + name + 8..], size).unwrap();
    assert_eq!(crc32fast::hash(&content), sum);
}

/// Positions are distributed over `scale`, around the origin for models whose box is centered there.
fn record(path: &Path, model: &'static str, config: &str, scale: f64) {
    let manifest = format!("name = \"speed\"\n[model.{model}]\n{config}\n");
    let experiment = parse(&manifest, "speed.toml", &[]).unwrap();
    let header = Header {
        manifest: experiment.runs[0].manifest.canonical(),
        run_key: "0".repeat(64),
        model,
        physics_version: 1,
        program_version: "0".to_owned(),
        time_unit: "s",
        state_columns: COLUMNS,
        channels: CHANNELS,
        selection: Selection::Named(vec!["state".to_owned(), "energy".to_owned()]),
        scenery: Scenery {
            walls: Vec::new(),
            view: [[0.0, 0.0], [1.0, 1.0]],
            drawn_radius: DrawnRadius::Column { min: 0.02 },
            speed_range_top: 1.0,
            speed_unit: "",
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
        compression: Compression::Zstd,
        stored: kinetoscope_recording::recorder::StoredFrames::All,
        frames_expected: None,
        model_time: None,
    };
    let mut recorder = Recorder::create(File::create(path).unwrap(), &header).unwrap();
    let mut random = 14_u64;
    let mut frame = Frame::new();
    for count in 0..FRAMES {
        frame.clear();
        for _ in 0..PARTICLES {
            let [x, y, vx, vy, radius] = [0.0; 5].map(|_: f64| uniform(&mut random));
            let origin = if model == "dem" { 0.0 } else { 0.5 };
            frame.push_state(&[(x - origin) * scale, (y - origin) * scale, vx, vy, radius]);
        }
        // The kinetic energy that is compared with the state of a DEM run in every frame.
        frame.push(&channels::DemEnergy { kinetic_j: 1.0, ..channels::DemEnergy::default() });
        let events = 1_000_000 * count;
        recorder.write(Clock { count: events, time: count as f64 }, &mut frame).unwrap();
    }
    recorder.finish(&Outcome::Complete).unwrap();
}

const CHANNELS: &[ChannelDeclaration] = &[ChannelDeclaration::of::<channels::DemEnergy>()];

/// Uniform numbers in [0, 1) with 53 random bits, by Vigna's splitmix64.
fn uniform(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut bits = *state;
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((bits ^ (bits >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}
