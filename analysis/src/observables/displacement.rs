//! How far particles have gone from their start, and how much they remember of their velocity.

use super::Series;
use crate::statistics::{Estimate, mean_of_independent};
use kinetoscope_recording::reader::StateTable;

/// More particles than this hardly sharpen the means, and would have to be kept and gone through in every frame.
const MOST_PARTICLES: usize = 1000;

/// The start, and both functions of time since then.
#[derive(Clone, Debug, Default)]
pub(crate) struct Displacement {
    start: Vec<[f64; 4]>,
    /// Time, and mean |x - x(0)|^2.
    pub(crate) mean_square: Series<(f64, f64)>,
    /// Time, and sum of v . v(0) over sum of v(0)^2.
    pub(crate) velocity_memory: Series<(f64, f64)>,
    last_squares: Vec<f64>,
}

impl Displacement {
    /// The next frame's state.
    pub(super) fn see(&mut self, time: f64, state: &StateTable) {
        let index = |name: &str| state.columns().iter().position(|column| column == name);
        let places = ["x", "y", "vx", "vy"].map(index);
        let [Some(x), Some(y), Some(vx), Some(vy)] = places else { return };
        let rows = (0..state.rows().min(MOST_PARTICLES)).map(|particle| {
            let row = state.row(particle);
            [row[x], row[y], row[vx], row[vy]]
        });
        if self.start.is_empty() {
            self.start = rows.clone().collect();
        }
        self.last_squares.clear();
        let (mut moved, mut product, mut square) = (0.0, 0.0, 0.0);
        for (now, start) in rows.zip(&self.start) {
            let (dx, dy) = (now[0] - start[0], now[1] - start[1]);
            self.last_squares.push(dx * dx + dy * dy);
            moved += dx * dx + dy * dy;
            product += now[2] * start[2] + now[3] * start[3];
            square += start[2] * start[2] + start[3] * start[3];
        }
        if !self.last_squares.is_empty() {
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
