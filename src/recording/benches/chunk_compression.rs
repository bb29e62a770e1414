//! What groups of channels with chunks of their own, one call per chunk, and several frames per chunk are worth: size and time per
//! frame of the states and drawings of recordings, compressed in other ways.
//!
//! `cargo bench -p kinetoscope-recording --bench chunk_compression -- RECORDING...`; recordings of dense runs are made by
//! `cargo bench --bench recording_overhead -- dense`. Each time is the minimum of three, in processor time.
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
//! Columns that do not change (radius, id and mass of DEM, the radius of packing; gas has none) in a channel of their own, as they are now, and rows in the order
//! of places instead of ids; states in chunks of 4 MiB at level 2, ms and KB per frame, on two cores with AVX-512 under a load of 25:
//!
//! | | DEM cloud | DEM with friction | gas | packing |
//! |---|---|---|---|---|
//! | all columns | 1.04, 82 | 2.65, 544 | 0.75, 164 | 0.95, 189 |
//! | without the constant columns | 0.54, 74 | 1.67, 496 | 0.77, 164 | 0.82, 182 |
//! | the constant columns once per chunk | 0.62, 79 | 1.70, 498 | 0.78, 164 | 0.79, 182 |
//! | rows by place | 1.04, 82 | 2.71, 546 | 0.77, 164 | 0.93, 188 |
//! | both | 0.49, 71 | 1.71, 496 | 0.78, 164 | 0.80, 182 |
//!
//! One call takes 0.87 to 0.89 of the time of a stream for the same bytes. Level -1 takes 0.81 to 0.98 of the time for drawings that
//! are 7 to 8 % larger: not used.

#![allow(clippy::unwrap_used, reason = "a benchmark may end on an error")]

use kinetoscope_recording::channels::{DISCS, STATE};
use kinetoscope_recording::reader::{Recording, StateTable};
use std::io::Write as _;
use std::path::Path;

const TRIALS: usize = 3;

fn main() {
    for path in std::env::args().skip(1).filter(|word| !word.starts_with('-')) {
        let recording = Recording::open(Path::new(&path)).unwrap();
        let [mut states, mut drawings] = [Vec::new(), Vec::new()];
        let mut tables = Vec::new();
        for frame in recording.frames().unwrap() {
            let frame = frame.unwrap();
            tables.extend(frame.state().cloned());
            for message in frame.messages() {
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
                let together = if together > 0 { together } else { frames_per_chunk(messages) };
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
        print("state, 4 MiB, level 2", &states, 0, &|chunk| packed(chunk, 2));
        let all: Vec<usize> = (0..tables[0].columns().len()).collect();
        let varying = varying_columns(&tables);
        let in_order: Vec<usize> = (0..tables[0].rows()).collect();
        let by_place = rows_by_place(&tables[0]);
        for (what, columns, rows) in [
            ("state again", &all, &in_order),
            ("state without constants", &varying, &in_order),
            ("state by place", &all, &by_place),
            ("state without constants, by place", &varying, &by_place),
        ] {
            let rows: Vec<_> = tables.iter().map(|table| bytes_of(table, columns, rows)).collect();
            print(&format!("{what}, 4 MiB, level 2"), &rows, 0, &|chunk| packed(chunk, 2));
        }
        let constant: Vec<usize> = all.iter().copied().filter(|at| !varying.contains(at)).collect();
        let mut rows: Vec<_> =
            tables.iter().map(|table| bytes_of(table, &varying, &in_order)).collect();
        let together = frames_per_chunk(&rows);
        for (first, table) in rows.iter_mut().step_by(together).zip(&tables) {
            first.extend(bytes_of(table, &constant, &in_order));
        }
        print("state, constants once per chunk, level 2", &rows, together, &|chunk| {
            packed(chunk, 2)
        });
    }
}

/// Frames of a chunk of states as the recorder closes it.
fn frames_per_chunk(messages: &[Vec<u8>]) -> usize {
    (4_usize << 20).div_ceil(messages[0].len())
}

/// The columns of the state that change.
fn varying_columns(tables: &[StateTable]) -> Vec<usize> {
    let is_varying = |&column: &usize| {
        tables.iter().any(|table| {
            table.iter().zip(tables[0].iter()).any(|(now, first)| now[column] != first[column])
        })
    };
    (0..tables[0].columns().len()).filter(is_varying).collect()
}

/// The rows by cells of a thousandth of the area, one column of cells after the other, as in the memory of a model.
fn rows_by_place(table: &StateTable) -> Vec<usize> {
    let largest =
        [0, 1].map(|axis| table.iter().map(|row| row[axis]).max_by(f64::total_cmp).unwrap());
    let cell = |row: usize, axis: usize| (table.row(row)[axis] / largest[axis] * 32.0) as i64;
    let mut rows: Vec<usize> = (0..table.rows()).collect();
    rows.sort_by_key(|&row| (cell(row, 0), cell(row, 1)));
    rows
}

/// The values of some columns, in this order of the rows.
fn bytes_of(table: &StateTable, columns: &[usize], rows: &[usize]) -> Vec<u8> {
    let values = rows.iter().flat_map(|&row| columns.iter().map(move |&at| table.row(row)[at]));
    values.flat_map(f64::to_le_bytes).collect()
}

fn measured(chunks: &[Vec<u8>], pack: &dyn Fn(&[u8]) -> usize) -> (f64, usize) {
    let started = processor_seconds();
    let bytes = chunks.iter().map(|chunk| pack(chunk)).sum();
    (processor_seconds() - started, bytes)
}

/// Processor time of this thread so far, which Linux reports in ns. Other programs do not change it much.
fn processor_seconds() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap();
    text.split(' ').next().unwrap().parse::<f64>().unwrap() / 1e9
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
