//! Snapshots of the particles at chosen times, limited to those that are drawn.

use crate::plot::{DrawnParticle, MAX_DRAWN_PARTICLES};
use kinetoscope_recording::reader::StateTable;

/// The particles of a frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Snapshot {
    /// Simulated time in the model's unit.
    pub time: f64,
    /// Number of particles.
    pub particles: usize,
    /// The drawn particles: the first [`MAX_DRAWN_PARTICLES`].
    pub bodies: Vec<DrawnParticle>,
}

impl Snapshot {
    /// Reads a two-dimensional state; `None` without positions. Radii come from the state or else from `radius`; points
    /// have none.
    #[must_use]
    pub fn of(time: f64, state: &StateTable, radius: Option<f64>) -> Option<Self> {
        let index = |name: &str| state.columns().iter().position(|column| column == name);
        let (x, y) = (index("x")?, index("y")?);
        let velocity = index("vx").zip(index("vy"));
        let column = index("radius");
        let body = |particle: usize| {
            let row = state.row(particle);
            DrawnParticle {
                center: [row[x], row[y]],
                radius: column.map_or(radius, |column| Some(row[column])),
                speed: velocity.map_or(0.0, |(vx, vy)| row[vx].hypot(row[vy])),
            }
        };
        let bodies = (0..state.rows().min(MAX_DRAWN_PARTICLES)).map(body).collect();
        Some(Self { time, particles: state.rows(), bodies })
    }
}

/// The snapshots of a run: at its start, at chosen times, and at its end.
#[derive(Clone, Debug, Default)]
pub struct Snapshots {
    /// Times that have not been reached, the latest first.
    waiting: Vec<f64>,
    taken: Vec<Snapshot>,
    last: Option<(f64, StateTable)>,
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

    /// Adds the next frame's state and takes a snapshot if its time has been reached.
    pub fn add_frame(&mut self, time: f64, state: StateTable, radius: Option<f64>) {
        let before = self.waiting.len();
        while self.waiting.last().is_some_and(|wanted| *wanted <= time) {
            self.waiting.pop();
        }
        if self.waiting.len() < before {
            self.taken.extend(Snapshot::of(time, &state, radius));
        }
        self.last = Some((time, state));
    }

    /// The last recorded state.
    #[must_use]
    pub fn last(&self) -> Option<&StateTable> {
        self.last.as_ref().map(|(_, state)| state)
    }

    /// All snapshots in order.
    #[must_use]
    pub fn named(&self, radius: Option<f64>) -> Vec<NamedSnapshot> {
        let Some((end, state)) = &self.last else { return Vec::new() };
        let early = self.taken.iter().filter(|snapshot| snapshot.time < *end).enumerate();
        let mut named: Vec<NamedSnapshot> = early
            .map(|(index, snapshot)| {
                let (stem, words) = match index {
                    0 => ("start".to_owned(), "at the start".to_owned()),
                    _ => (index.to_string(), "on the way".to_owned()),
                };
                NamedSnapshot { stem, words, snapshot: snapshot.clone() }
            })
            .collect();
        named.extend(Snapshot::of(*end, state, radius).map(|snapshot| NamedSnapshot {
            stem: "end".to_owned(),
            words: "at the end".to_owned(),
            snapshot,
        }));
        named
    }
}
