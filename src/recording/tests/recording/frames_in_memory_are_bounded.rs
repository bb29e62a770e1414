//! Promise: a recorder on its own thread holds frames in memory up to a bound. Small ones are filled while others are still
//! written, so that nobody waits for the disk; one of 40 MB is filled only when all of the last is in the file, also where
//! frames have grown to that size. The bytes are those of a recorder without a thread.

#![allow(clippy::unwrap_used, reason = "a test's own failure")]

use kinetoscope_recording::background::FrameWriter;
use kinetoscope_recording::frame::Frame;
use kinetoscope_recording::recorder::{Clock, Compression, Header, Outcome, Recorder, Selection};
use std::io::{self, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use std::time::Duration;

/// Columns of the sample's state.
const WIDTH: usize = 5;
/// Above the size of a chunk, so that every frame goes to the disk at its end: 1.6 MB.
const SMALL: usize = 40_000;
/// 40 MB.
const LARGE: usize = 1_000_000;

/// A disk that takes its time for every chunk, and tells how much it has.
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
    frame.reserve_state(particles * WIDTH);
    (0..particles).for_each(|particle| frame.push_state(&[particle as f64; WIDTH]));
}

fn clock(index: usize) -> Clock {
    Clock { count: index as u64, time: index as f64 }
}

/// For each of a run's frames of so many particles, how many of those before it were not in the file when it was filled;
/// and the file.
fn frames_under_way(particles: &[usize]) -> (Vec<usize>, Vec<u8>) {
    let arrived = Arc::new(AtomicU64::new(0));
    let disk = SlowDisk { bytes: Vec::new(), arrived: Arc::clone(&arrived) };
    let mut writer = FrameWriter::start(Recorder::create(disk, &header()).unwrap());
    let mut under_way = Vec::new();
    for (index, &count) in particles.iter().enumerate() {
        let look_and_fill = |frame: &mut Frame| {
            assert!(frame.state().is_empty(), "frame {index} begins with what another left");
            let arrived = arrived.load(Ordering::SeqCst) as usize;
            // Without compression a file has all bytes of its states, and little else.
            let (mut needed, mut whole) = (0, 0);
            for &before in &particles[..index] {
                needed += before * WIDTH * size_of::<f64>();
                whole += usize::from(arrived >= needed);
            }
            under_way.push(index - whole);
            fill(frame, count);
        };
        writer.write(clock(index), look_and_fill).unwrap();
    }
    (under_way, writer.finish(&Outcome::Complete).unwrap().bytes)
}

#[test]
fn small_frames_do_not_wait_and_large_ones_do() {
    let (small, _) = frames_under_way(&[SMALL; 8]);
    let (large, _) = frames_under_way(&[LARGE; 4]);
    println!("under way: small frames {small:?}, large ones {large:?}");
    assert!(small.iter().any(|&frames| frames > 0), "nothing is filled while the disk writes");
    assert!(small.iter().all(|&frames| frames <= 3), "one is written and two wait");
    assert_eq!(large, [0; 4]);
}

#[test]
fn frames_that_grow_come_to_the_same_bound() {
    let particles = [SMALL, SMALL, SMALL, SMALL, LARGE, LARGE, LARGE];
    let (under_way, bytes) = frames_under_way(&particles);
    println!("under way: {under_way:?}");
    assert_eq!(under_way[5..], [0, 0]);
    let mut recorder = Recorder::create(Vec::new(), &header()).unwrap();
    for (index, &count) in particles.iter().enumerate() {
        let mut frame = Frame::new();
        fill(&mut frame, count);
        recorder.write(clock(index), &mut frame).unwrap();
    }
    assert!(bytes == recorder.finish(&Outcome::Complete).unwrap());
}
