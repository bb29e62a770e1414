//! Snapshots of the particles at chosen times, drawn from the recorded scenes or else from the state.

use crate::plot::DRAWS;
use crate::plot::drawing::Drawing;
use crate::plot::velocity_field::velocity_field;
use kinetoscope_recording::drawing::Shape;
use kinetoscope_recording::reader::{RecordedFrame, StateTable};

/// The particles of a frame.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Snapshot {
    /// Simulated time in the model's unit.
    pub(crate) time: f64,
    /// Number of particles.
    pub(crate) particles: usize,
    /// The drawing; without discs if the state has no positions.
    pub(crate) drawing: Drawing,
    /// Arrows of the velocities; `None` for a state without velocities, for particles at rest, and unless they are requested.
    pub(crate) velocities: Option<Drawing>,
}

/// How a state is drawn that was recorded without scenes.
#[derive(Clone, Debug, Default)]
pub(crate) struct StateStyle {
    /// The container and the walls at rest.
    pub(crate) walls: Vec<Shape>,
    /// Radius of particles without a radius in the state.
    pub(crate) radius: f64,
}

/// The snapshots of a run: at its start, at chosen times, and at its end.
#[derive(Clone, Debug, Default)]
pub(crate) struct Snapshots {
    style: StateStyle,
    /// The unit of speeds if velocities are drawn.
    speed_unit: Option<&'static str>,
    /// Times that have not been reached, the latest first.
    waiting: Vec<f64>,
    /// Scenes of the first frame, which apply until a frame replaces them.
    fixed: Drawing,
    taken: Vec<Snapshot>,
    /// Time and state of the last frame.
    last: Option<(f64, StateTable)>,
    /// The last frame, with its scenes.
    last_frame: Option<RecordedFrame>,
}

impl Snapshots {
    /// Takes snapshots at the start, at the end, and at the first frame at or after each of these times.
    pub(crate) fn at(times: &[f64]) -> Self {
        let mut waiting: Vec<f64> = times.iter().copied().chain([f64::NEG_INFINITY]).collect();
        waiting.sort_by(|a, b| b.total_cmp(a));
        waiting.dedup();
        Self { waiting, ..Self::default() }
    }

    /// Sets how states without scenes are drawn.
    pub(crate) fn with_style(self, style: StateStyle) -> Self {
        Self { style, ..self }
    }

    /// Draws velocities as well.
    pub(crate) fn with_velocities(self, speed_unit: &'static str) -> Self {
        Self { speed_unit: Some(speed_unit), ..self }
    }

    /// Adds the state of the next frame and takes a snapshot if its time has been reached.
    pub(crate) fn add_state(&mut self, frame: &RecordedFrame, state: StateTable) {
        let time = frame.clock.time;
        if DRAWS && self.last.is_none() {
            // A scene that cannot be decoded is replaced by a drawing of the state.
            let _ = self.fixed.update(frame);
            self.fixed.discs.clear();
        }
        let before = self.waiting.len();
        while self.waiting.last().is_some_and(|wanted| *wanted <= time) {
            self.waiting.pop();
        }
        if DRAWS && self.waiting.len() < before {
            self.taken.push(self.snapshot(time, Some(frame), &state));
        }
        self.last = Some((time, state));
    }

    /// Keeps the scenes of a frame, whose state was added, in case that it is the last.
    pub(crate) fn keep_scenes(&mut self, frame: RecordedFrame) {
        self.last_frame = Some(frame);
    }

    /// The last recorded state.
    pub(crate) fn last(&self) -> Option<&StateTable> {
        self.last.as_ref().map(|(_, state)| state)
    }

    fn snapshot(&self, time: f64, frame: Option<&RecordedFrame>, state: &StateTable) -> Snapshot {
        let mut drawing = self.fixed.clone();
        if let Some(frame) = frame.filter(|frame| frame.clock.time == time) {
            let _ = drawing.update(frame);
        }
        if drawing.walls.is_empty() {
            drawing.walls.clone_from(&self.style.walls);
        }
        if drawing.discs.is_empty() {
            // A recorded color bar is that of recorded discs.
            drawing.legend.clear();
            drawing.draw_state(state, self.style.radius);
        }
        let velocities = self.speed_unit.and_then(|unit| {
            let columns = ["x", "y", "vx", "vy"].map(|name| state.index(name));
            let [Some(x), Some(y), Some(vx), Some(vy)] = columns else { return None };
            let rows = (0..state.rows()).map(|particle| state.row(particle));
            let particles: Vec<_> =
                rows.map(|row| [x, y, vx, vy].map(|column| row[column])).collect();
            velocity_field(&particles, &drawing.walls, unit)
        });
        Snapshot { time, particles: state.rows(), drawing, velocities }
    }

    /// All snapshots in order, each with the end of its file name and its description.
    pub(crate) fn named(&self) -> impl Iterator<Item = (String, &'static str, Snapshot)> {
        let end = self.last.as_ref().map_or(f64::NEG_INFINITY, |(end, _)| *end);
        let early = self.taken.iter().filter(move |snapshot| snapshot.time < end);
        let early = early.cloned().enumerate().map(|(index, snapshot)| match index {
            0 => ("start".to_owned(), "at the start", snapshot),
            _ => (index.to_string(), "on the way", snapshot),
        });
        let last = self.last.iter().map(|(end, state)| {
            ("end".to_owned(), "at the end", self.snapshot(*end, self.last_frame.as_ref(), state))
        });
        early.chain(last).filter(|(.., snapshot)| !snapshot.drawing.discs.is_empty())
    }
}
