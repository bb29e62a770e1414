//! Guarantee: the frames that a recorder on its own thread keeps in memory are bounded. Small frames are filled while others are still being
//! written, so no thread waits for the disk. A frame of 40 MB is filled only after the previous one is in the file, also if frames have
//! grown to that size. Frames of a few bytes are written by the caller at the end, without a thread, and more of them in batches.
//! The bytes equal those of a recorder without a thread, which programs without threads use.

#![allow(clippy::unwrap_used, reason = "a test's own failure")]

use kinetoscope_recording::background::FrameWriter;
use kinetoscope_recording::error::RecordError;
use kinetoscope_recording::frame::{Frame, Level, LogLine};
use kinetoscope_recording::recorder::{Clock, Compression, Header, Outcome, Recorder, Selection};
use std::collections::HashSet;
use std::io::{self, Write};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::{self, ThreadId};
use std::time::Duration;

/// Columns of the sample's state.
const WIDTH: usize = 5;
/// 4.4 MB per frame, more than a block, so that every frame is written to the disk at its end.
const SMALL: usize = 137_500;
/// 40 MB.
const LARGE: usize = 1_000_000;

/// A disk that delays every chunk and counts the bytes that it contains.
struct SlowDisk {
    bytes: Vec<u8>,
    arrived: Arc<AtomicU64>,
}

impl Write for SlowDisk {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if bytes.len() > 1 << 20 {
            thread::sleep(Duration::from_millis(50));
        }
        self.bytes.extend_from_slice(bytes);
        self.arrived.store(self.bytes.len() as u64, Ordering::SeqCst);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

fn header() -> Header {
    let selection = Selection::Named(vec!["state".to_owned()]);
    Header { selection, ..crate::sample::header(Compression::None) }
}

fn fill(frame: &mut Frame, particles: usize) {
    let rows = frame.resize_state(particles * WIDTH).chunks_exact_mut(WIDTH);
    rows.enumerate().for_each(|(particle, row)| row.fill(particle as f64));
}

fn clock(index: usize) -> Clock {
    Clock { count: index as u64, time: index as f64 }
}

/// For each frame of a run, given its number of particles: how many earlier frames were not in the file yet when it was filled;
/// and the file.
fn unwritten_frames(particles: &[usize]) -> (Vec<usize>, Vec<u8>) {
    let arrived = Arc::new(AtomicU64::new(0));
    let disk = SlowDisk { bytes: Vec::new(), arrived: Arc::clone(&arrived) };
    let mut writer = FrameWriter::start(Recorder::create(disk, &header()).unwrap());
    let mut unwritten = Vec::new();
    for (index, &count) in particles.iter().enumerate() {
        let look_and_fill = |frame: &mut Frame| {
            assert!(frame.state().is_empty(), "frame {index} contains rows of another frame");
            let arrived = arrived.load(Ordering::SeqCst) as usize;
            // Without compression, a file consists of the bytes of its states and little else.
            let (mut needed, mut whole) = (0, 0);
            for &before in &particles[..index] {
                // The radius, which does not change, is in the first one.
                needed += before * (WIDTH - 1) * size_of::<f64>();
                whole += usize::from(arrived >= needed);
            }
            unwritten.push(index - whole);
            fill(frame, count);
        };
        writer.write(clock(index), look_and_fill).unwrap();
    }
    (unwritten, writer.finish(&Outcome::Complete).unwrap().bytes)
}

#[test]
fn only_large_frames_wait_for_the_disk() {
    let (small, _) = unwritten_frames(&[SMALL; 8]);
    let (large, _) = unwritten_frames(&[LARGE; 4]);
    println!("under way: small frames {small:?}, large ones {large:?}");
    assert!(small.iter().any(|&frames| frames > 0), "frames must be filled while the disk writes");
    assert!(small.iter().all(|&frames| frames <= 3), "at most one frame is written and two wait");
    assert_eq!(large, [0; 4]);
}

#[test]
fn growing_frames_reach_the_same_bound() {
    let particles = [SMALL, SMALL, SMALL, SMALL, LARGE, LARGE, LARGE];
    let (unwritten, bytes) = unwritten_frames(&particles);
    println!("under way: {unwritten:?}");
    assert_eq!(unwritten[5..], [0, 0]);
    let mut recorder = Recorder::create(Vec::new(), &header()).unwrap();
    for (index, &count) in particles.iter().enumerate() {
        let mut frame = Frame::new();
        fill(&mut frame, count);
        recorder.write(clock(index), &mut frame).unwrap();
    }
    assert!(bytes == recorder.finish(&Outcome::Complete).unwrap());
}

/// Writes frames with `particles`, and a line of the log after some of them if there are to be remarks.
fn written<W: Write + Send + 'static>(
    mut writer: FrameWriter<W>,
    particles: &[usize],
    has_remarks: bool,
) -> W {
    for (index, &count) in particles.iter().enumerate() {
        writer.write(clock(index), |frame| fill(frame, count)).unwrap();
        if has_remarks && index % 7 == 0 {
            let text = format!("frame {index}");
            writer.remark(LogLine { level: Level::Warning, text }).unwrap();
        }
    }
    assert_eq!(writer.frames_written(), particles.len() as u64);
    writer.finish(&Outcome::Complete).unwrap()
}

/// Setup: a run that ends before its frames are handed over, batches of hundreds of frames, frames of many sizes, and runs whose first
/// frame is written after a pause; with remarks, which are behind the frames before them, and without. Control: a frame less.
#[test]
fn batches_contain_the_same_bytes() {
    let recorder = || Recorder::create(Vec::new(), &header()).unwrap();
    for has_remarks in [false, true] {
        let written = |writer, particles: &[usize]| written(writer, particles, has_remarks);
        for particles in [&[3; 2][..], &[3; 2000], &[1, SMALL, 2, 2, SMALL], &[SMALL; 3]] {
            let here = written(FrameWriter::on_this_thread(recorder()), particles);
            assert!(here == written(FrameWriter::start(recorder()), particles));
            let late = FrameWriter::start(recorder());
            thread::sleep(Duration::from_millis(20));
            assert!(here == written(late, particles));
            assert!(here != written(FrameWriter::start(recorder()), &particles[1..]));
        }
    }
}

/// Setup: discs are drawn, and a slow disk lets frames wait, so that the caller draws some of them. Which ones depends on the time.
#[test]
fn frames_that_wait_are_drawn_as_others() {
    let header = crate::sample::header(Compression::None);
    let particles = [SMALL; 8];
    let here = FrameWriter::on_this_thread(Recorder::create(Vec::new(), &header).unwrap());
    let here = written(here, &particles, true);
    let disk = SlowDisk { bytes: Vec::new(), arrived: Arc::default() };
    let slow = FrameWriter::start(Recorder::create(disk, &header).unwrap());
    assert!(here == written(slow, &particles, true).bytes);
    assert!(here.windows(6).any(|bytes| bytes == b"/discs"), "the sample has no drawing");
}

/// The threads that wrote to a disk.
#[derive(Clone, Default)]
struct Writers(Arc<Mutex<HashSet<ThreadId>>>);

impl Write for Writers {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap().insert(thread::current().id());
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Setup: two frames of a few bytes, up to a hundred times, because a run that takes long enough has a thread. Control: two frames of
/// 4.4 MB are written by another thread.
#[test]
fn short_run_has_no_thread() {
    let own = HashSet::from([thread::current().id()]);
    let is_own = |particles: usize| {
        let writers = Writers::default();
        let recorder = Recorder::create(writers.clone(), &header()).unwrap();
        written(FrameWriter::start(recorder), &[particles; 2], false);
        *writers.0.lock().unwrap() == own
    };
    assert!((0..100).any(|_| is_own(3)));
    assert!(!is_own(SMALL));
}

/// A disk that is full.
struct FullDisk(usize);

impl Write for FullDisk {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0 = self.0.checked_sub(bytes.len()).ok_or(io::ErrorKind::StorageFull)?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Setup: a disk that is full after 100,000 bytes. The error arrives with a later frame or at the end, and the writer does not wait
/// for the thread that has ended.
#[test]
fn full_disk_is_an_error_of_a_later_frame_or_of_the_end() {
    for particles in [3, 300, SMALL] {
        let recorder = Recorder::create(FullDisk(100_000), &header()).unwrap();
        let mut writer = FrameWriter::start(recorder);
        let frames =
            (0..50_000).map(|index| writer.write(clock(index), |frame| fill(frame, particles)));
        let failed = frames.into_iter().find_map(Result::err);
        let failed = failed.or_else(|| writer.finish(&Outcome::Complete).err());
        assert!(matches!(failed, Some(RecordError::Io(_))), "{particles}: {failed:?}");
    }
}
