//! Guarantee: drawings are small compared with the state. For 1000 discs in 300 frames, the drawing takes at most 3 MB and `/state` at most
//! its uncompressed size.
//!
//! Setup: the discs fly straight and rebound from the box, each at its own speed, so every disc has a new position and color in each
//! frame and no data repeats. Tolerance: the limits of the project's size budget, measured on such drawings.

#![allow(clippy::unwrap_used, reason = "a test's own failure")]

use crate::sample::COLUMNS;
use kinetoscope_recording::frame::Frame;
use kinetoscope_recording::recorder::{Clock, Compression, Header, Outcome, Recorder, Selection};

const DISCS: usize = 1000;
const FRAMES: u64 = 300;

/// A pseudorandom number in [0, 1), determined by the argument.
fn scrambled(number: u64) -> f64 {
    let mut bits = number.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((bits ^ (bits >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}

/// Position and velocity after a flight between walls at -1 and 1.
fn bounced(start: f64, velocity: f64, time: f64) -> (f64, f64) {
    let unfolded = (start + velocity * time + 1.0).rem_euclid(4.0);
    if unfolded <= 2.0 { (unfolded - 1.0, velocity) } else { (3.0 - unfolded, -velocity) }
}

/// Fast discs cross the box in 50 frames.
fn fill(frame: &mut Frame, index: u64) {
    frame.clear();
    let time = 0.02 * index as f64;
    for disc in 0..DISCS as u64 {
        let random = |which: u64| 2.0 * scrambled(4 * disc + which) - 1.0;
        let (x, vx) = bounced(random(0), 2.0 * random(1), time);
        let (y, vy) = bounced(random(2), 2.0 * random(3), time);
        // The speed decreases as for discs that lose energy, so every color changes.
        let slower = 1.0 / (1.0 + time);
        frame.push_state(&[x, y, slower * vx, slower * vy, 0.02]);
    }
}

fn size(selection: &[&str]) -> usize {
    let selection = Selection::Named(selection.iter().map(|&name| name.to_owned()).collect());
    let header = Header { selection, ..crate::sample::header(Compression::Zstd) };
    let mut recorder = Recorder::create(Vec::new(), &header).unwrap();
    let mut frame = Frame::new();
    for index in 0..FRAMES {
        fill(&mut frame, index);
        recorder.write(Clock { count: index, time: index as f64 }, &mut frame).unwrap();
    }
    recorder.finish(&Outcome::Complete).unwrap().len()
}

#[test]
fn drawings_of_a_thousand_discs_are_small() {
    let clock = size(&[]);
    let drawing = size(&["discs"]) - clock;
    let state = size(&["state"]) - clock;
    let raw = DISCS * FRAMES as usize * COLUMNS.len() * size_of::<f64>();
    println!("drawing {drawing} bytes, state {state} of {raw} raw, clock and frame {clock}");
    assert!(drawing <= 3_000_000, "{drawing}");
    assert!(state <= raw, "{state} of {raw}");
}
