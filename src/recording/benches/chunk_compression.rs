//! What groups of channels with chunks of their own, one call per chunk, and several frames per chunk are worth: size and time per
//! frame of the states and drawings of recordings, compressed in other ways.
//!
//! `cargo bench -p kinetoscope-recording --bench chunk_compression -- RECORDING...`; recordings of dense runs are made by
//! `cargo bench --bench recording_overhead -- dense`. Each time is the minimum of three.
//!
//! Sizes in KB per frame of 10^4 particles, recorded after every step (DEM) or 60 times (gas, packing):
//!
//! | | DEM | gas | packing |
//! |---|---|---|---|
//! | state and drawing in one chunk, a frame each, level 1 | 222 | 405 | 408 |
//! | drawing, a frame per chunk, level 1 | 46 | 94 | 95 |
//! | state, a frame per chunk, level 1 | 176 | 310 | 313 |
//! | state, 8 frames per chunk, level 1 | 176 | 182 | 313 |
//! | state, 8 frames per chunk, level 2 | 75 | 175 | 194 |
//!
//! One call takes 0.87 to 0.89 of the time of a stream for the same bytes. Level -1 takes 0.81 to 0.98 of the time for drawings that
//! are 7 to 8 % larger: not used.

#![allow(clippy::unwrap_used, reason = "a benchmark may end on an error")]

use kinetoscope_recording::channels::{DISCS, STATE};
use kinetoscope_recording::reader::Recording;
use std::io::Write as _;
use std::path::Path;
use std::time::Instant;

const TRIALS: usize = 3;

fn main() {
    for path in std::env::args().skip(1).filter(|word| !word.starts_with('-')) {
        let recording = Recording::open(Path::new(&path)).unwrap();
        let [mut states, mut drawings] = [Vec::new(), Vec::new()];
        for frame in recording.frames().unwrap() {
            for message in frame.unwrap().messages() {
                match message.topic() {
                    STATE => states.push(message.payload().to_vec()),
                    DISCS => drawings.push(message.payload().to_vec()),
                    _ => {}
                }
            }
        }
        println!("{path}: {} frames", states.len());
        println!("{:<44}{:>10}{:>10}", "", "ms/frame", "KB/frame");
        let both: Vec<Vec<u8>> =
            states.iter().zip(&drawings).map(|(one, other)| [&one[..], other].concat()).collect();
        let print =
            |what: &str, messages: &[Vec<u8>], together: usize, pack: &dyn Fn(&[u8]) -> usize| {
                let chunks: Vec<Vec<u8>> = messages.chunks(together).map(<[_]>::concat).collect();
                let (seconds, bytes) = (0..TRIALS)
                    .map(|_| measured(&chunks, pack))
                    .min_by(|one, other| one.0.total_cmp(&other.0))
                    .unwrap();
                let frames = messages.len() as f64;
                println!(
                    "{what:<44}{:>10.2}{:>10.0}",
                    1e3 * seconds / frames,
                    bytes as f64 / 1e3 / frames
                );
            };
        print("both, 1 frame, level 1, stream", &both, 1, &streamed);
        print("both, 1 frame, level 1", &both, 1, &|chunk| packed(chunk, 1));
        for level in [1, -1] {
            print(&format!("drawing, 1 frame, level {level}"), &drawings, 1, &|chunk| {
                packed(chunk, level)
            });
        }
        for (together, level) in [(1, 1), (1, 2), (4, 1), (4, 2), (8, 1), (8, 2), (8, 3)] {
            let what = format!("state, {together} frames, level {level}");
            print(&what, &states, together, &|chunk| packed(chunk, level));
        }
    }
}

fn measured(chunks: &[Vec<u8>], pack: &dyn Fn(&[u8]) -> usize) -> (f64, usize) {
    let started = Instant::now();
    let bytes = chunks.iter().map(|chunk| pack(chunk)).sum();
    (started.elapsed().as_secs_f64(), bytes)
}

fn packed(chunk: &[u8], level: i32) -> usize {
    zstd::bulk::compress(chunk, level).unwrap().len()
}

fn streamed(chunk: &[u8]) -> usize {
    let mut encoder = zstd::Encoder::new(Vec::new(), 1).unwrap();
    // A message arrives in pieces.
    chunk.chunks(128 << 10).for_each(|piece| encoder.write_all(piece).unwrap());
    encoder.finish().unwrap().len()
}
