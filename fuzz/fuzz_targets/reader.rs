//! Guarantee: for any bytes as a file, the reader delivers frames and at most one error, equal on 1 and 2 threads.

#![no_main]

use kinetoscope_fuzz::{read, scratch_file};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let path = scratch_file();
    std::fs::write(&path, bytes).unwrap();
    let (frames, error) = read(&path, 1);
    let (frames_on_two, error_on_two) = read(&path, 2);
    // A damaged state may contain NaN, so frames are compared by the bytes of their messages.
    assert!(
        frames
            .iter()
            .map(|frame| frame.messages())
            .eq(frames_on_two.iter().map(|frame| frame.messages()))
    );
    assert_eq!(error, error_on_two);
});
