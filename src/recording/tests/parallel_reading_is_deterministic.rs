//! Guarantee: the number of threads that unpack chunks does not affect the frames or their order, and no thread outlives the iterator.
//! (`damage_is_reported` tests that damage is reported identically.)

#![allow(clippy::unwrap_used, reason = "a test's own failure")]

#[path = "shared/sample.rs"]
mod sample;

use kinetoscope_recording::reader::Recording;
use kinetoscope_recording::recorder::{Compression, Selection};
use sample::{header, read, read_on, record};
use std::num::NonZeroUsize;

/// This binary has only one test, so that threads of other tests are not counted.
#[test]
fn frames_do_not_depend_on_threads_and_threads_end_with_the_iterator() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sample.mcap");
    for compression in [Compression::None, Compression::Lz4, Compression::Zstd] {
        let mut header = header(compression);
        header.selection = Selection::Named(vec!["state".to_owned(), "temperature".to_owned()]);
        // 120 kB per frame and 35 frames per block give four blocks, with a chunk of states and one of scalars each.
        let bytes = record(&header, 120, 3750);
        let chunks = mcap::Summary::read(&bytes).unwrap().unwrap().chunk_indexes.len();
        assert_eq!(chunks, 8);
        let (original, error) = read(&bytes, &path);
        assert_eq!((original.len(), error), (120, None));
        for threads in [1, 2, 3, 4, 16] {
            let (frames, error) = read_on(&path, threads);
            assert_eq!(error, None);
            assert!(frames == original, "{threads} threads");
        }
    }
    let before = threads();
    let recording = Recording::open(&path).unwrap();
    for delivered in [0, 1, 50, 120] {
        let mut frames = recording.frames_on(NonZeroUsize::new(4).unwrap()).unwrap();
        assert_eq!(frames.by_ref().take(delivered).count(), delivered);
        let during = threads();
        assert!(during <= before + 4, "{during} threads, {before} before");
        assert!(delivered == 0 || before == 0 || during == before + 4);
        drop(frames);
        // A joined thread disappears from the system's list with a short delay.
        let listed = (0..1000).map(|_| {
            std::thread::sleep(std::time::Duration::from_millis(1));
            threads()
        });
        assert!(listed.into_iter().any(|now| now == before), "after {delivered} frames");
    }
}

/// Number of threads of this process; 0 if the system does not report it.
fn threads() -> usize {
    std::fs::read_dir("/proc/self/task").map_or(0, Iterator::count)
}
