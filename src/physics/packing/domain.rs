//! The box and the collision parameters of a run.

use super::motion::Vector;
use kinetoscope_manifest::model::{Boundary, CollapseGuard, PackingConfig};
use serde::{Deserialize, Serialize};

/// The box and the collision parameters.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Domain {
    /// Width and height of the box, which is centered on the origin.
    pub(super) sides: Vector,
    /// Whether the box has walls; otherwise it is periodic.
    pub(super) has_walls: bool,
    /// Radius of the largest disc.
    pub(super) max_radius: f64,
    /// Coefficient of restitution of a pair.
    pub(super) restitution: f64,
    /// Pair collisions that are elastic for any restitution.
    pub(super) elastic_threshold: ElasticThreshold,
    /// Standard deviation of the angle by which a wall rotates the outgoing velocity, rad.
    pub(super) wall_noise_rad: f64,
}

/// The threshold below which a pair collision is elastic, to prevent inelastic collapse.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) enum ElasticThreshold {
    /// No threshold.
    Off,
    /// Time since the last collision of either disc: the TC model (Luding and McNamara, Granular Matter 1 (1998) 113).
    ContactTime(f64),
    /// Approach speed.
    CutoffVelocity(f64),
}

impl Domain {
    /// The box and the collision parameters of a manifest.
    pub(super) fn new(config: &PackingConfig, max_radius: f64) -> Self {
        let elastic_threshold = match config.collapse_guard {
            CollapseGuard::Off => ElasticThreshold::Off,
            CollapseGuard::ContactTime(time) => ElasticThreshold::ContactTime(time.get()),
            CollapseGuard::CutoffVelocity(speed) => ElasticThreshold::CutoffVelocity(speed.get()),
        };
        Self {
            sides: [config.width.get(), config.height.get()],
            has_walls: config.boundary == Boundary::Walls,
            max_radius,
            restitution: config.restitution.get(),
            elastic_threshold,
            wall_noise_rad: config.wall_noise_variance_rad2.get().sqrt(),
        }
    }

    /// Sides of the rectangle accessible to the centers; if the radii differ, to the center of the largest disc.
    pub(super) fn accessible_sides(&self) -> Vector {
        let excluded = if self.has_walls { 2.0 * self.max_radius } else { 0.0 };
        self.sides.map(|side| side - excluded)
    }

    /// The coefficient of restitution at an approach speed, at a time since the last collision of either disc.
    #[inline(always)]
    pub(super) fn restitution_at(&self, approach_speed: f64, time: f64) -> f64 {
        let is_elastic = match self.elastic_threshold {
            ElasticThreshold::Off => false,
            ElasticThreshold::ContactTime(threshold) => time < threshold,
            ElasticThreshold::CutoffVelocity(threshold) => approach_speed < threshold,
        };
        if is_elastic { 1.0 } else { self.restitution }
    }
}
