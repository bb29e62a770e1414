//! How far particles have gone from their start, and how much they remember of their velocity.

use crate::models::series::Series;
use crate::statistics::{Estimate, mean_of_independent};
use kinetoscope_recording::reader::StateTable;

/// More particles than this hardly sharpen the means, and would have to be kept and gone through in every frame.
const MOST_PARTICLES: usize = 1000;

/// Share of a side that a disc of a periodic box may go between two frames, so that the nearest image is its own: half a side would be
/// the end of it, and collisions may make it faster in between.
const LONGEST_WAY: f64 = 0.25;

/// The start, and both functions of time since then.
#[derive(Clone, Debug, Default)]
pub(crate) struct Displacement {
    /// Sides of a periodic box.
    sides: Option<[f64; 2]>,
    start: Vec<[f64; 4]>,
    /// Time of the last frame, places in it, and ways from the start to there.
    time: f64,
    places: Vec<[f64; 2]>,
    ways: Vec<[f64; 2]>,
    /// Whether a disc went so far between two frames that its way is not known any more.
    is_lost: bool,
    /// Time, and mean |x - x(0)|^2.
    pub(crate) mean_square: Series<(f64, f64)>,
    /// Time, and sum of v . v(0) over sum of v(0)^2.
    pub(crate) velocity_memory: Series<(f64, f64)>,
    last_squares: Vec<f64>,
}

impl Displacement {
    /// Nothing seen yet, in a box with walls or a periodic one of these sides.
    pub(super) fn new(sides: Option<[f64; 2]>) -> Self {
        Self { sides, ..Self::default() }
    }

    /// The next frame's state.
    pub(super) fn add_frame(&mut self, time: f64, state: &StateTable) {
        let index = |name: &str| state.columns().iter().position(|column| column == name);
        let places = ["x", "y", "vx", "vy"].map(index);
        let [Some(x), Some(y), Some(vx), Some(vy)] = places else { return };
        let rows = (0..state.rows().min(MOST_PARTICLES)).map(|particle| {
            let row = state.row(particle);
            [row[x], row[y], row[vx], row[vy]]
        });
        if self.start.is_empty() {
            self.start = rows.clone().collect();
            self.places = self.start.iter().map(|start| [start[0], start[1]]).collect();
            self.ways = vec![[0.0; 2]; self.start.len()];
            self.time = time;
        }
        let (mut product, mut square) = (0.0, 0.0);
        for (particle, (now, start)) in rows.zip(&self.start).enumerate() {
            let speed = now[2].hypot(now[3]);
            for axis in 0..2 {
                let moved = now[axis] - self.places[particle][axis];
                self.ways[particle][axis] += match self.sides {
                    Some(sides) => {
                        let far = LONGEST_WAY * sides[axis];
                        let nearest = moved - sides[axis] * (moved / sides[axis]).round();
                        self.is_lost |= speed * (time - self.time) > far || nearest.abs() > far;
                        nearest
                    }
                    None => moved,
                };
            }
            self.places[particle] = [now[0], now[1]];
            product += now[2] * start[2] + now[3] * start[3];
            square += start[2] * start[2] + start[3] * start[3];
        }
        self.time = time;
        self.last_squares.clear();
        if !self.is_lost {
            self.last_squares.extend(self.ways.iter().map(|way| way[0] * way[0] + way[1] * way[1]));
        }
        if !self.last_squares.is_empty() {
            let moved: f64 = self.last_squares.iter().sum();
            self.mean_square.add((time, moved / self.last_squares.len() as f64));
        }
        if square > 0.0 {
            self.velocity_memory.add((time, product / square));
        }
    }

    /// Mean square displacement of the last frame, with the error from the particles' scatter.
    pub(super) fn last_mean_square(&self) -> Option<Estimate> {
        mean_of_independent(&self.last_squares)
    }
}
