//! Guarantee: the columns that a particle keeps are recorded when they change, and a reader delivers all columns of every state bit for
//! bit, or an error that names what is missing or contradicts the state.
//!
//! Setup: rows whose constants are before, between and after the other columns; recordings rewritten by the container's own library with
//! correct checksums. Control: the recording without a change.

#![allow(clippy::unwrap_used, reason = "a test's own failure")]

use crate::changed_chunks_are_reported::{Chunk, chunks, frames, with_chunks};
use crate::sample::header;
use kinetoscope_recording::frame::{Frame, StateColumn};
use kinetoscope_recording::reader::RecordedFrame;
use kinetoscope_recording::recorder::{Clock, Compression, Header, Outcome, Recorder, Selection};

const COLUMNS: &[StateColumn] = &[
    StateColumn { name: "radius", unit: "m" },
    StateColumn { name: "x", unit: "m" },
    StateColumn { name: "y", unit: "m" },
    StateColumn { name: "id", unit: "" },
    StateColumn { name: "vx", unit: "m/s" },
    StateColumn { name: "vy", unit: "m/s" },
    StateColumn { name: "mass", unit: "kg" },
];

/// Ids and masses of the particles in each frame.
const PARTICLES: [&[(f64, f64)]; 8] = [
    &[],
    &[(0.0, 1.5), (1.0, 2.5)],
    &[(0.0, 1.5), (1.0, 2.5)],
    // Another mass, another number, another particle, and a NaN, which equals no number.
    &[(0.0, 1.5), (1.0, 3.5)],
    &[(0.0, 1.5)],
    &[(7.0, 1.5)],
    &[(7.0, f64::NAN)],
    &[(7.0, f64::NAN)],
];

fn rows(frame: usize) -> Vec<[f64; 7]> {
    let row = |&(id, mass): &(f64, f64)| {
        let phase = frame as f64 / 7.0 + id;
        [0.01 + id / 3.0, libm::sin(phase), phase, id, 1.0 / 3.0, -phase, mass]
    };
    PARTICLES[frame].iter().map(row).collect()
}

fn recorded() -> Vec<u8> {
    let selection = Selection::Named(vec!["state".to_owned(), "velocity".to_owned()]);
    let header = Header { state_columns: COLUMNS, selection, ..header(Compression::Zstd) };
    let mut recorder = Recorder::create(Vec::new(), &header).unwrap();
    let mut frame = Frame::new();
    for index in 0..PARTICLES.len() {
        frame.clear();
        rows(index).iter().for_each(|row| frame.push_state(row));
        recorder.write(Clock { count: 0, time: index as f64 }, &mut frame).unwrap();
    }
    recorder.finish(&Outcome::Complete).unwrap()
}

fn assert_rows(frame: &RecordedFrame) {
    let state = frame.state().unwrap();
    let expected = rows(frame.clock.frame as usize);
    assert_eq!(state.rows(), expected.len());
    assert_eq!(state.columns(), COLUMNS.iter().map(|column| column.name).collect::<Vec<_>>());
    for (found, expected) in state.iter().zip(expected) {
        let bits = |row: &[f64]| row.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(found), bits(&expected));
    }
}

fn payload<'a>(frame: &'a RecordedFrame, topic: &str) -> Option<&'a [u8]> {
    let found = frame.messages().iter().find(|message| message.topic() == topic);
    found.map(|message| message.payload())
}

#[test]
fn particles_are_recorded_when_they_change() {
    let (found, error) = frames(recorded());
    assert_eq!((found.len(), error), (PARTICLES.len(), None));
    found.iter().for_each(assert_rows);
    let has_particles: Vec<bool> =
        found.iter().map(|frame| payload(frame, "/particles").is_some()).collect();
    assert_eq!(has_particles, [true, true, false, true, true, true, true, false]);
    // Of seven columns, three are constants.
    let [two, one] = [2, 4].map(|frame| payload(&found[frame], "/state").unwrap().len());
    assert_eq!(two - one, 4 * 8);
}

/// Changes the chunk of the states, and returns the frames before the error, and the error.
fn changed(change: impl Fn(&mut Chunk)) -> (Vec<RecordedFrame>, Option<String>) {
    let original = recorded();
    let mut chunks = chunks(&original);
    let is_of_states = |chunk: &&mut Chunk| is_particles(&chunk[0]);
    change(chunks.iter_mut().find(is_of_states).unwrap());
    frames(with_chunks(&original, &chunks))
}

fn is_particles(message: &mcap::Message<'_>) -> bool {
    message.channel.topic == "/particles"
}

/// The place of the particles of a frame.
fn place(states: &Chunk, frame: u32) -> usize {
    let is_wanted =
        |message: &mcap::Message<'_>| is_particles(message) && message.sequence == frame;
    states.iter().position(is_wanted).unwrap()
}

#[test]
fn missing_and_late_particles_are_reported() {
    let (found, error) = changed(|_| {});
    assert_eq!((found.len(), error), (PARTICLES.len(), None), "control");
    let what = "a state has no message of /particles before it";
    let (found, error) = changed(|states| states.retain(|message| !is_particles(message)));
    assert!(found.is_empty() && error.unwrap().contains(what));
    let (found, error) = changed(|states| drop(states.remove(0)));
    assert!(found.is_empty() && error.unwrap().contains(what));
    // Those of the first frame come with the second one.
    let (found, error) = changed(|states| {
        let first = states.remove(0);
        let second = place(states, 1);
        let (log_time, publish_time) = (states[second].log_time, states[second].publish_time);
        states[second] = mcap::Message { log_time, publish_time, ..first };
    });
    assert!(found.is_empty() && error.unwrap().contains(what));
}

#[test]
fn particles_that_contradict_the_state_are_reported() {
    // Those of two discs for one.
    let (found, error) = changed(|states| drop(states.remove(place(states, 4))));
    let what = "the state has another number of particles than /particles";
    assert_eq!(found.len(), 4);
    assert!(error.unwrap().contains(what));
    let (found, error) = changed(|states| {
        let at = place(states, 3);
        states.insert(at, states[at].clone());
    });
    assert!(found.is_empty() && error.unwrap().contains("a frame has two messages of one topic"));
    let (found, error) = changed(|states| {
        let state = states.iter().find(|message| message.channel.topic == "/state");
        states[0].data = state.unwrap().data.clone();
    });
    let what = "the state's columns are not those of the recording";
    assert!(found.is_empty() && error.unwrap().contains(what));
}

/// A set of particles may change. That it did not change in the run is found by `verify`.
#[test]
fn repeated_particles_with_other_values_are_those_of_the_states_after_them() {
    let (found, error) = changed(|states| {
        let (one, three) = (place(states, 1), place(states, 3));
        states[three].data = states[one].data.clone();
    });
    assert_eq!((found.len(), error), (PARTICLES.len(), None));
    assert_eq!(found[3].state().unwrap().value(1, "mass"), Some(2.5));
}
