//! Mean square displacement and velocity autocorrelation function.

use crate::models::series::Series;
use crate::statistics::{Estimate, mean_of_independent};
use kinetoscope_recording::reader::StateTable;

/// Maximum number of tracked particles: more would hardly reduce the errors, and each costs memory and time per frame.
pub(super) const MAX_PARTICLES: usize = 1000;

/// Fraction of a box side that a disc may travel between two frames. The nearest image is certain up to half a side;
/// collisions may speed a disc up in between.
const MAX_DISPLACEMENT_OVER_SIDE: f64 = 0.25;

/// Initial state, and both functions of the time since then.
#[derive(Clone, Debug, Default)]
pub(crate) struct Displacement {
    /// Sides of the box if it is periodic.
    sides: Option<[f64; 2]>,
    start: Vec<[f64; 4]>,
    /// Time of the last frame.
    time: f64,
    /// Positions in the last frame.
    positions: Vec<[f64; 2]>,
    /// Displacements from the start to the last frame.
    displacements: Vec<[f64; 2]>,
    /// Whether a disc traveled so far between two frames that its displacement is unknown.
    is_displacement_unknown: bool,
    /// Time and mean |x - x(0)|^2.
    pub(crate) mean_square: Series<(f64, f64)>,
    /// Time and sum of v . v(0) over sum of v(0)^2.
    pub(crate) velocity_autocorrelation: Series<(f64, f64)>,
    last_squares: Vec<f64>,
}

impl Displacement {
    /// Creates an empty record for a box with walls, or for a periodic box with these sides.
    pub(super) fn new(sides: Option<[f64; 2]>) -> Self {
        Self { sides, ..Self::default() }
    }

    /// Adds the next frame's state.
    pub(super) fn add_frame(&mut self, time: f64, state: &StateTable) {
        let places = ["x", "y", "vx", "vy"].map(|name| state.index(name));
        let [Some(x), Some(y), Some(vx), Some(vy)] = places else { return };
        let rows = (0..state.rows().min(MAX_PARTICLES)).map(|particle| {
            let row = state.row(particle);
            [row[x], row[y], row[vx], row[vy]]
        });
        if self.start.is_empty() {
            self.start = rows.clone().collect();
            self.positions = self.start.iter().map(|start| [start[0], start[1]]).collect();
            self.displacements = vec![[0.0; 2]; self.start.len()];
            self.time = time;
        }
        let (mut product, mut square) = (0.0, 0.0);
        for (particle, now) in rows.enumerate() {
            let Some(&start) = self.start.get(particle) else { break };
            // A displacement once unknown stays so.
            if !self.is_displacement_unknown {
                self.move_to(particle, now, time - self.time);
            }
            product += now[2] * start[2] + now[3] * start[3];
            square += start[2] * start[2] + start[3] * start[3];
        }
        self.time = time;
        self.last_squares.clear();
        if !self.is_displacement_unknown {
            self.last_squares.extend(self.displacements.iter().map(|[x, y]| x * x + y * y));
        }
        if !self.last_squares.is_empty() {
            let moved: f64 = self.last_squares.iter().sum();
            self.mean_square.add((time, moved / self.last_squares.len() as f64));
        }
        if square > 0.0 {
            self.velocity_autocorrelation.add((time, product / square));
        }
    }

    /// Adds the way of a particle since the last frame, `duration` ago.
    fn move_to(&mut self, particle: usize, [x, y, vx, vy]: [f64; 4], duration: f64) {
        let moved = [x - self.positions[particle][0], y - self.positions[particle][1]];
        self.positions[particle] = [x, y];
        let way = match self.sides {
            Some(sides) => {
                let speed = libm::hypot(vx, vy);
                [0, 1].map(|axis| {
                    let far = MAX_DISPLACEMENT_OVER_SIDE * sides[axis];
                    let nearest =
                        moved[axis] - sides[axis] * libm::round(moved[axis] / sides[axis]);
                    self.is_displacement_unknown |= speed * duration > far || nearest.abs() > far;
                    nearest
                })
            }
            None => moved,
        };
        for (sum, way) in self.displacements[particle].iter_mut().zip(way) {
            *sum += way;
        }
    }

    /// Displacements from the start to the last frame; `None` if one is unknown.
    pub(super) fn unwrapped(&self) -> Option<&[[f64; 2]]> {
        (!self.is_displacement_unknown && !self.displacements.is_empty())
            .then_some(self.displacements.as_slice())
    }

    /// Mean square displacement of the last frame; its error is from the scatter of the particles.
    pub(super) fn last_mean_square(&self) -> Option<Estimate> {
        mean_of_independent(&self.last_squares)
    }
}
