//! Snapshots of the particles at chosen times, drawn from the recorded scenes or else from the state.

use crate::plot::drawing::Drawing;
use kinetoscope_recording::drawing::Shape;
use kinetoscope_recording::reader::{RecordedFrame, StateTable};

/// The particles of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Snapshot {
    /// Simulated time in the model's unit.
    pub time: f64,
    /// Number of particles.
    pub particles: usize,
    /// The drawing; without discs if the state has no positions.
    pub drawing: Drawing,
}

/// How a state is drawn that was recorded without scenes.
#[derive(Clone, Debug, Default)]
pub struct StateStyle {
    /// The container and the walls at rest.
    pub walls: Vec<Shape>,
    /// Radius of particles without a radius in the state.
    pub radius: f64,
}

/// The snapshots of a run: at its start, at chosen times, and at its end.
#[derive(Clone, Debug, Default)]
pub struct Snapshots {
    style: StateStyle,
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

/// A snapshot with its name: the end of its file name, and its description.
pub struct NamedSnapshot {
    /// For example "end".
    pub stem: String,
    /// For example "at the end".
    pub words: String,
    /// The particles.
    pub snapshot: Snapshot,
}

impl Snapshots {
    /// Takes snapshots at the start, at the end, and at the first frame at or after each of these times.
    #[must_use]
    pub fn at(times: &[f64]) -> Self {
        let mut waiting: Vec<f64> = times.iter().copied().chain([f64::NEG_INFINITY]).collect();
        waiting.sort_by(|a, b| b.total_cmp(a));
        waiting.dedup();
        Self { waiting, ..Self::default() }
    }

    /// Sets how states without scenes are drawn.
    #[must_use]
    pub fn with_style(self, style: StateStyle) -> Self {
        Self { style, ..self }
    }

    /// Adds the state of the next frame and takes a snapshot if its time has been reached.
    pub fn add_state(&mut self, frame: &RecordedFrame, state: StateTable) {
        let time = frame.clock.time;
        if self.last.is_none() {
            // A scene that cannot be decoded is replaced by a drawing of the state.
            let _ = self.fixed.update(frame);
            self.fixed.discs.clear();
        }
        let before = self.waiting.len();
        while self.waiting.last().is_some_and(|wanted| *wanted <= time) {
            self.waiting.pop();
        }
        if self.waiting.len() < before {
            self.taken.push(self.snapshot(time, Some(frame), &state));
        }
        self.last = Some((time, state));
    }

    /// Keeps the scenes of a frame, whose state was added, in case that it is the last.
    pub fn keep_scenes(&mut self, frame: RecordedFrame) {
        self.last_frame = Some(frame);
    }

    /// The last recorded state.
    #[must_use]
    pub fn last(&self) -> Option<&StateTable> {
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
        Snapshot { time, particles: state.rows(), drawing }
    }

    /// All snapshots in order.
    #[must_use]
    pub fn named(&self) -> Vec<NamedSnapshot> {
        let Some((end, state)) = &self.last else { return Vec::new() };
        let early = self.taken.iter().filter(|snapshot| snapshot.time < *end);
        let named = early.cloned().enumerate().map(|(index, snapshot)| {
            let (stem, words) = match index {
                0 => ("start".to_owned(), "at the start".to_owned()),
                _ => (index.to_string(), "on the way".to_owned()),
            };
            NamedSnapshot { stem, words, snapshot }
        });
        let (stem, words) = ("end".to_owned(), "at the end".to_owned());
        let snapshot = self.snapshot(*end, self.last_frame.as_ref(), state);
        named
            .chain([NamedSnapshot { stem, words, snapshot }])
            .filter(|named| !named.snapshot.drawing.discs.is_empty())
            .collect()
    }
}
