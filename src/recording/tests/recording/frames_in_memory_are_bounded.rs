//! Guarantee: the frames that a recorder on its own thread keeps in memory are bounded. Small frames are filled while others are still being
//! written, so no thread waits for the disk. A frame of 40 MB is filled only after the previous one is in the file, also if frames have
//! grown to that size. The bytes equal those of a recorder without a thread, which programs without threads use.

#![allow(clippy::unwrap_used, reason = "a test's own failure")]

use kinetoscope_recording::background::FrameWriter;
use kinetoscope_recording::frame::{Frame, Level, LogLine};
use kinetoscope_recording::recorder::{Clock, Compression, Header, Outcome, Recorder, Selection};
use std::io::{self, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use std::time::Duration;

/// Columns of the sample's state.
const WIDTH: usize = 5;
/// 1.6 MB per frame, more than a chunk, so that every frame is written to the disk at its end.
const SMALL: usize = 40_000;
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
                needed += before * WIDTH * size_of::<f64>();
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

#[test]
fn recorder_on_the_caller_s_thread_writes_the_same_bytes() {
    let written = |mut writer: FrameWriter<Vec<u8>>| {
        for index in 0..5 {
            writer.write(clock(index), |frame| fill(frame, SMALL + index)).unwrap();
            let text = format!("frame {index}");
            writer.remark(LogLine { level: Level::Warning, text }).unwrap();
        }
        assert_eq!(writer.frames_written(), 5);
        writer.finish(&Outcome::Complete).unwrap()
    };
    let recorder = || Recorder::create(Vec::new(), &header()).unwrap();
    let here = written(FrameWriter::on_this_thread(recorder()));
    assert!(here == written(FrameWriter::start(recorder())));
}
