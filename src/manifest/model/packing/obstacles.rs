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
