//! `[model.packing]`: obstacles, discs that never move.

use crate::inline::inline_table;
use crate::quantity::{Finite, Positive};

/// Largest number of obstacles: each is drawn, and few manifests are longer.
pub const MAX_OBSTACLES: usize = 1000;

inline_table! {
    /// Fixed obstacles: discs that never move, from which the others rebound with the restitution of a pair.
    pub struct PackingObstacles = "{ positions = ..., radius = ... }" {
        /// Centers, `[x, y]` each, inside of the box. Obstacles may overlap each other and the walls.
        positions: Vec<[Finite; 2]> [nonempty],
        /// Radius of all obstacles.
        radius: Positive [required],
    }
}

/// Centers of the circles to draw for obstacles: in a periodic box, also those of the images that reach into it.
#[must_use]
pub fn drawn_obstacles(
    centers: &[[f64; 2]],
    radius: f64,
    sides: [f64; 2],
    is_periodic: bool,
) -> Vec<[f64; 2]> {
    let shifts: &[f64] = if is_periodic { &[0.0, -1.0, 1.0] } else { &[0.0] };
    let images = |&[x, y]: &[f64; 2]| {
        let column = move |right: &f64| {
            let x = x + right * sides[0];
            shifts.iter().map(move |up| [x, y + up * sides[1]])
        };
        shifts.iter().flat_map(column)
    };
    let reaches = |center: &[f64; 2]| {
        (0..2).all(|axis: usize| center[axis].abs() < 0.5 * sides[axis] + radius)
    };
    centers.iter().flat_map(images).filter(reaches).collect()
}
