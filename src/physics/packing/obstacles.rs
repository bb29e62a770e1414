//! Fixed obstacles.

use super::motion::Vector;
use kinetoscope_manifest::model::{MAX_OBSTACLES, PackingConfig};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Discs that never move.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Obstacles {
    pub(super) centers: Vec<Vector>,
    /// Radius of all of them.
    pub(super) radius: f64,
}

impl Obstacles {
    /// The obstacles of a manifest.
    pub(super) fn new(config: &PackingConfig) -> Self {
        let (centers, radius) = config.obstacles();
        Self { centers, radius }
    }

    /// Whether a manifest could have these obstacles in a box with these sides.
    pub(super) fn is_valid(&self, sides: Vector) -> bool {
        let count = self.centers.len();
        let is_inside = |axis: usize, at: f64| at.abs() <= 0.5 * sides[axis];
        let area = count as f64 * PI * self.radius * self.radius;
        count <= MAX_OBSTACLES
            && self.radius >= 0.0
            && area <= sides[0] * sides[1]
            && self.centers.iter().all(|&[x, y]| is_inside(0, x) && is_inside(1, y))
    }
}
