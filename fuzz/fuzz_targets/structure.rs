//! Guarantee: recordings whose records were changed behind correct checksums are read, analyzed and compared without a panic.
//!
//! The input is the seed of the changes, which the tests share (`tests/shared/mutated_recording.rs`).

#![no_main]

#[path = "../../tests/shared/mutated_recording.rs"]
mod mutated_recording;

use kinetoscope::verify::compare::compare_recordings;
use kinetoscope_fuzz::{recordings, scratch_file};
use kinetoscope_recording::reader::Recording;
use libfuzzer_sys::fuzz_target;
use mutated_recording::{Numbers, Records};
use std::path::PathBuf;
use std::sync::LazyLock;

static ORIGINALS: LazyLock<Vec<(Vec<u8>, PathBuf)>> = LazyLock::new(|| {
    let with_path = |(index, bytes): (usize, Vec<u8>)| {
        let path = scratch_file().with_extension(format!("original_{index}.mcap"));
        std::fs::write(&path, &bytes).unwrap();
        (bytes, path)
    };
    recordings().into_iter().enumerate().map(with_path).collect()
});

fuzz_target!(|input: &[u8]| {
    let seed = input.iter().fold(0_u64, |seed, byte| seed.rotate_left(8) ^ u64::from(*byte));
    let mut numbers = Numbers(seed);
    let (original, original_path) = &ORIGINALS[numbers.below(ORIGINALS.len())];
    let path = scratch_file();
    std::fs::write(&path, Records::of(original).mutated(&mut numbers)).unwrap();
    if let Ok(recording) = Recording::open(&path) {
        drop(kinetoscope_analysis::analyze(&recording));
    }
    drop(compare_recordings(original_path, &path, None));
});
