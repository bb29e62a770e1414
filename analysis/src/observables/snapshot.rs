//! The particles at one instant, as far as they are drawn.

use crate::plot::{Body, MOST_BODIES};
use kinetoscope_recording::reader::StateTable;

/// The particles of a frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Snapshot {
    /// Simulated time in the model's unit.
    pub time: f64,
    /// Number of particles.
    pub particles: usize,
    /// Those that are drawn, the first [`MOST_BODIES`].
    pub bodies: Vec<Body>,
}

impl Snapshot {
    /// Replaces the snapshot by a state of two dimensions. Radii come from the state where it has them, else from
    /// `radius`; points have none.
    pub fn take(&mut self, time: f64, state: &StateTable, radius: Option<f64>) {
        let index = |name: &str| state.columns().iter().position(|column| column == name);
        let (Some(x), Some(y)) = (index("x"), index("y")) else { return };
        let velocity = index("vx").zip(index("vy"));
        let column = index("radius");
        self.time = time;
        self.particles = state.rows();
        self.bodies.clear();
        self.bodies.extend((0..state.rows().min(MOST_BODIES)).map(|particle| {
            let row = state.row(particle);
            Body {
                centre: [row[x], row[y]],
                radius: column.map_or(radius, |column| Some(row[column])),
                speed: velocity.map_or(0.0, |(vx, vy)| row[vx].hypot(row[vy])),
            }
        }));
    }
}
