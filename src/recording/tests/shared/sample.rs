//! A small recording for several tests: three columns of motion and every kind of message.

#![allow(clippy::unwrap_used, reason = "a test's own failure")]

use kinetoscope_recording::channels::{
    ChannelDeclaration, GasSpeeds, GasTemperature, PerCollision,
};
use kinetoscope_recording::error::{ReadError, RecordError};
use kinetoscope_recording::frame::{ContactLine, Frame, Level, StateColumn};
use kinetoscope_recording::reader::{Frames, RecordedFrame, Recording};
use kinetoscope_recording::recorder::{Clock, Compression, Header, Outcome, Recorder, Selection};
use kinetoscope_recording::scenery::{DrawnRadius, Scenery, Wall};
use std::num::{NonZeroU32, NonZeroU64, NonZeroUsize};
use std::path::Path;

pub(crate) const COLUMNS: &[StateColumn] = &[
    StateColumn { name: "x", unit: "m" },
    StateColumn { name: "y", unit: "m" },
    StateColumn { name: "vx", unit: "m/s" },
    StateColumn { name: "vy", unit: "m/s" },
    StateColumn { name: "radius", unit: "m" },
];

pub(crate) const CHANNELS: &[ChannelDeclaration] = &[
    ChannelDeclaration::of::<GasTemperature>(),
    ChannelDeclaration::of::<GasSpeeds>(),
    ChannelDeclaration::opt_in::<PerCollision>(),
];

pub(crate) fn header(compression: Compression) -> Header {
    Header {
        manifest: "name = \"sample\"\nseed = 14\n".to_owned(),
        run_key: "00c0ffee".repeat(8),
        model: "gas",
        physics_version: 3,
        program_version: "0.1.0".to_owned(),
        time_unit: "s",
        state_columns: COLUMNS,
        channels: CHANNELS,
        selection: Selection::All,
        scenery: Scenery {
            walls: vec![
                Wall::Rectangle { min: [-1.0, -1.0], max: [1.0, 1.0] },
                Wall::Circle { center: [0.0, 0.0], radius: 1.0 },
                Wall::Body { center: [0.0, 0.0], radius: 0.1 },
            ],
            view: [[-1.0, -1.0], [1.0, 1.0]],
            drawn_radius: DrawnRadius::Column { min: 0.02 },
            speed_range_top: 2.0,
            speed_unit: "m/s",
            arrows: true,
            force_range_top: Some(10.0),
            trail: true,
            unused_fields: Vec::new(),
            names: Vec::new(),
            central_particle: None,
        },
        playback_fps: 25.0,
        max_drawn_particles: NonZeroU32::new(10_000).unwrap(),
        draw_every: NonZeroU64::MIN,
        compression,
        stored: kinetoscope_recording::recorder::StoredFrames::All,
        frames_expected: Some(201),
        model_time: Some(0.6),
    }
}

/// Fills a frame with values that are not exactly representable in fewer bits, so that a lost bit is found.
pub(crate) fn fill(frame: &mut Frame, index: u64, particles: usize) {
    frame.clear();
    for particle in 0..particles {
        let phase = particle as f64 / 3.0 + index as f64 / 7.0;
        let (x, y) = (0.9 * libm::sin(phase), 0.9 * libm::cos(1.3 * phase));
        frame.push_state(&[x, y, libm::cos(phase), -libm::sin(phase) / 3.0, 0.02]);
    }
    frame.push(&GasTemperature {
        mean_speed_temperature_k: 1.0 / 3.0 + index as f64,
        mean_square_temperature_k: 300.0,
        mean_speed_m_per_s: 1.0,
        mean_velocity_m_per_s: 0.0,
        rms_speed_m_per_s: libm::sqrt(2.0),
    });
    frame.push(&GasSpeeds {
        speed_m_per_s: vec![0.1, 0.3, 0.5],
        density: vec![1.0, 2.0, 1.0 / 3.0],
        initial_distribution: vec![1.0; 3],
        maxwell: vec![0.5; 3],
        ..GasSpeeds::default()
    });
    frame.push(&PerCollision {
        event: vec![1, 2],
        time: vec![0.1, 0.2],
        mean_square_velocity: vec![1.0, 0.9],
        a2: vec![0.0, -0.1],
    });
    if index.is_multiple_of(2) {
        let (from, to) = ([0.0, 0.0], [0.1, 0.1]);
        frame.push_contact(ContactLine { from, to, force: index as f64 });
    }
    if index == 1 {
        frame.log(Level::Warning, "the time step is large: 0.1 s");
    }
}

pub(crate) fn time_of(index: u64) -> f64 {
    index as f64 * 0.003
}

/// The bytes of a whole recording.
pub(crate) fn record(header: &Header, frames: u64, particles: usize) -> Vec<u8> {
    record_with_outcome(header, frames, particles, &Outcome::Complete).unwrap()
}

pub(crate) fn record_with_outcome(
    header: &Header,
    frames: u64,
    particles: usize,
    outcome: &Outcome,
) -> Result<Vec<u8>, RecordError> {
    let mut recorder = Recorder::create(Vec::new(), header)?;
    let mut frame = Frame::new();
    for index in 0..frames {
        fill(&mut frame, index, particles);
        recorder.write(Clock { count: 10 * index, time: time_of(index) }, &mut frame)?;
    }
    recorder.finish(outcome)
}

/// The result of reading bytes: whole frames, and the error that follows, if any.
pub(crate) fn read(bytes: &[u8], path: &Path) -> (Vec<RecordedFrame>, Option<String>) {
    std::fs::write(path, bytes).unwrap();
    read_file(path)
}

/// The result of reading a file.
pub(crate) fn read_file(path: &Path) -> (Vec<RecordedFrame>, Option<String>) {
    drain(Recording::open(path).and_then(|recording| recording.frames()))
}

/// The result of reading a file with the given number of threads.
pub(crate) fn read_on(path: &Path, threads: usize) -> (Vec<RecordedFrame>, Option<String>) {
    let threads = NonZeroUsize::new(threads).unwrap();
    drain(Recording::open(path).and_then(|recording| recording.frames_on(threads)))
}

fn drain(frames: Result<Frames, ReadError>) -> (Vec<RecordedFrame>, Option<String>) {
    let mut whole = Vec::new();
    match frames {
        Err(error) => (whole, Some(error.to_string())),
        Ok(frames) => {
            for frame in frames {
                match frame {
                    Ok(frame) => whole.push(frame),
                    Err(error) => return (whole, Some(error.to_string())),
                }
            }
            (whole, None)
        }
    }
}
