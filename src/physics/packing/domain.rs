//! The box and the laws of collision of one run.

use super::motion::Vector;
use serde::{Deserialize, Serialize};

/// The box and the laws of collision.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Domain {
    /// Width and height of the box, which is centered on the origin.
    pub(super) sides: Vector,
    /// Whether it has walls, as against periodic.
    pub(super) has_walls: bool,
    /// Radius of the largest disc.
    pub(super) max_radius: f64,
    /// Coefficient of restitution of a pair.
    pub(super) restitution: f64,
    /// Which collisions are elastic whatever the restitution.
    pub(super) elastic_threshold: ElasticThreshold,
    /// Standard deviation of the angle by which a wall turns the outgoing direction, rad.
    pub(super) wall_noise_rad: f64,
}

/// What keeps inelastic discs from infinitely many collisions in a finite time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) enum ElasticThreshold {
    /// Nothing.
    Off,
    /// The TC model: elastic where one of the two collided less than this time ago (Luding and McNamara, Granular
    /// Matter 1, 113, 1998).
    ContactTime(f64),
    /// Elastic where the discs approach slower than this.
    CutoffVelocity(f64),
}

impl Domain {
    /// Sides of the rectangle that centers stay in: of the largest disc, where they differ.
    pub(super) fn accessible_sides(&self) -> Vector {
        let kept_off = if self.has_walls { 2.0 * self.max_radius } else { 0.0 };
        self.sides.map(|side| side - kept_off)
    }

    /// The coefficient of restitution of a pair that approaches at `approach`, `time` after the last collision of either.
    #[inline(always)]
    pub(super) fn restitution_at(&self, approach: f64, time: f64) -> f64 {
        let is_elastic = match self.elastic_threshold {
            ElasticThreshold::Off => false,
            ElasticThreshold::ContactTime(least) => time < least,
            ElasticThreshold::CutoffVelocity(least) => approach < least,
        };
        if is_elastic { 1.0 } else { self.restitution }
    }
}

/// Discs that grow all at the same relative rate.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Growth {
    /// Share of the full radius at the zero of the engine's clock.
    pub(super) scale: f64,
    /// Growth of the share in a unit of time.
    pub(super) rate: f64,
}

impl Growth {
    /// The share of the full radius at a local time.
    pub(super) fn scale_at(&self, time: f64) -> f64 {
        self.scale + self.rate * time
    }
}
