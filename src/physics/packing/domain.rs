//! The box and the collision parameters of a run.

use super::motion::Vector;
use super::obstacles::Obstacles;
use super::shaking::Shaking;
use kinetoscope_manifest::model::{Boundary, CollapseGuard, PackingConfig};
use serde::{Deserialize, Serialize};

/// The box and the collision parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
    /// Gravity, toward smaller y.
    pub(super) gravity: f64,
    /// What the floor does in gravity.
    pub(super) floor: Floor,
    /// Discs that never move.
    pub(super) obstacles: Obstacles,
}

/// What the floor does to the discs that fall on it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) enum Floor {
    /// It reflects them, as the other walls do.
    AtRest,
    /// It emits them again at its temperature T.
    Thermal {
        /// sqrt(T): the standard deviation of a velocity component.
        speed: f64,
    },
    /// It moves up and down, and reflects them.
    Shaken(Shaking),
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

impl Floor {
    /// The floor of a manifest.
    pub(super) fn of(config: &PackingConfig) -> Self {
        match (config.floor_temperature, config.shaking) {
            (Some(temperature), _) => Self::Thermal { speed: temperature.get().sqrt() },
            (None, Some(keys)) => Self::Shaken(Shaking::new(keys)),
            (None, None) => Self::AtRest,
        }
    }
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
            gravity: config.gravity.get(),
            floor: Floor::of(config),
            obstacles: Obstacles::new(config),
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
