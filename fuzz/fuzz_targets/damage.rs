//! Guarantee: if up to 4 adjacent bytes of a valid recording are changed, or its end is cut off, every delivered frame is bitwise identical
//! to the recorded one, and an error reports the damage. (CRC-32 finds every burst of up to 32 bits; larger damage can match.)

#![no_main]

use kinetoscope_fuzz::{read, recordings, scratch_file};
use kinetoscope_recording::reader::RecordedFrame;
use libfuzzer_sys::fuzz_target;
use std::sync::LazyLock;

static ORIGINALS: LazyLock<Vec<(Vec<u8>, Vec<RecordedFrame>)>> = LazyLock::new(|| {
    let path = scratch_file();
    let with_frames = |bytes: Vec<u8>| {
        std::fs::write(&path, &bytes).unwrap();
        let (frames, error) = read(&path, 1);
        assert_eq!((frames.len(), error), (3, None));
        (bytes, frames)
    };
    recordings().into_iter().map(with_frames).collect()
});

// The input: the recording, the offset of the damage (two bytes), four bytes of changes, and the length after a cut (two bytes).
fuzz_target!(|input: &[u8]| {
    let &[which, low, high, ref rest @ ..] = input else { return };
    let (original, frames) = &ORIGINALS[usize::from(which) % ORIGINALS.len()];
    let place = usize::from(u16::from_le_bytes([low, high])) % original.len();
    let (burst, cut) = rest.split_at_checked(4).unwrap_or((rest, &[]));
    let mut bytes = original.clone();
    bytes[place..].iter_mut().zip(burst).for_each(|(byte, change)| *byte ^= change);
    if let &[low, high, ..] = cut {
        bytes.truncate(usize::from(u16::from_le_bytes([low, high])));
    }
    if bytes == *original {
        return;
    }
    let path = scratch_file();
    std::fs::write(&path, &bytes).unwrap();
    for threads in [1, 2] {
        let (delivered, error) = read(&path, threads);
        assert!(error.is_some(), "unreported damage");
        assert!(delivered.len() <= frames.len());
        for (one, other) in delivered.iter().zip(frames) {
            assert_eq!(one.clock, other.clock);
            assert_eq!(one.messages(), other.messages());
            assert_eq!(one.state(), other.state());
        }
    }
});
