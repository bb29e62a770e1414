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
    /// Time since the last collision of either disc below which a pair collision is elastic, to prevent inelastic collapse:
    /// the TC model (Luding and McNamara, Granular Matter 1 (1998) 113). Minus infinity if there is no such limit.
    pub(super) elastic_below_time: f64,
    /// Approach speed below which a pair collision is elastic; minus infinity if there is no such limit.
    pub(super) elastic_below_speed: f64,
    /// Standard deviation of the angle by which a wall rotates the outgoing velocity, rad.
    pub(super) wall_noise_rad: f64,
}

impl Domain {
    /// The box and the collision parameters of a manifest.
    pub(super) fn new(config: &PackingConfig, max_radius: f64) -> Self {
        let (elastic_below_time, elastic_below_speed) = match config.collapse_guard {
            CollapseGuard::Off => (f64::NEG_INFINITY, f64::NEG_INFINITY),
            CollapseGuard::ContactTime(time) => (time.get(), f64::NEG_INFINITY),
            CollapseGuard::CutoffVelocity(speed) => (f64::NEG_INFINITY, speed.get()),
        };
        Self {
            sides: [config.width.get(), config.height.get()],
            has_walls: config.boundary == Boundary::Walls,
            max_radius,
            restitution: config.restitution.get(),
            elastic_below_time,
            elastic_below_speed,
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
        let is_elastic =
            time < self.elastic_below_time || approach_speed < self.elastic_below_speed;
        if is_elastic { 1.0 } else { self.restitution }
    }
}
