//! Walls: shapes, motion, and contact points with discs.

use crate::simd::registers::vectorized;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// A wall and its motion.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Wall {
    /// Shape and position at the start.
    pub(super) shape: Shape,
    pub(super) motion: Motion,
}

/// The shape of a wall, m.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) enum Shape {
    /// An infinite plane through `point`; the unit `normal` points to the side of the discs.
    Plane { point: [f64; 2], normal: [f64; 2] },
    /// A straight wall with two ends; discs may be on either side.
    Segment { from: [f64; 2], to: [f64; 2] },
    /// A circle with the discs inside.
    Drum { center: [f64; 2], radius: f64 },
}

/// Displacement at the time t: u t + A sin(2 pi f t), and for a drum an angular velocity about its center. The clock t runs
/// only within `moves`, or always without it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Motion {
    /// Constant velocity u, m/s.
    pub(super) velocity: [f64; 2],
    /// Amplitude A, m.
    pub(super) amplitude: [f64; 2],
    /// Frequency f, Hz.
    pub(super) frequency: f64,
    /// Angular velocity of a drum, rad/s.
    pub(super) spin: f64,
    /// Begin and end of the motion, s.
    pub(super) moves: Option<[f64; 2]>,
}

/// A wall at a given step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PlacedWall {
    /// Shape and present position.
    pub(super) shape: Shape,
    /// Its displacement in the step before over dt, m/s: half a step behind, as the discs' integrator velocities are.
    pub(super) step_velocity: [f64; 2],
    /// Its displacement in the steps before and after over 2 dt, m/s.
    pub(super) mid_velocity: [f64; 2],
    /// Angular velocity of a drum, rad/s.
    pub(super) spin: f64,
}

/// The point of a wall that is nearest to a disc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct WallContact {
    /// Unit vector from the wall to the disc's center.
    pub(super) normal: [f64; 2],
    /// Distance of the center, m; negative behind a plane or a drum.
    pub(super) distance: f64,
}

impl Motion {
    /// Displacement at a time, m.
    pub(super) fn displacement(&self, time: f64) -> [f64; 2] {
        let time = self.clock(time);
        let phase = libm::sin(TAU * self.frequency * time);
        let along = |axis: usize| self.velocity[axis] * time + self.amplitude[axis] * phase;
        [along(0), along(1)]
    }

    /// Whether the wall is ever displaced; a drum that only rotates is not.
    pub(super) fn leaves(&self) -> bool {
        self.velocity != [0.0; 2] || self.amplitude != [0.0; 2]
    }

    /// Angle by which a drum has turned, rad, counterclockwise.
    pub(super) fn rotation(&self, time: f64) -> f64 {
        self.spin * self.clock(time)
    }

    /// Whether the wall is ever displaced or rotates.
    pub(super) fn is_moving(&self) -> bool {
        self.leaves() || self.spin != 0.0
    }

    /// Time since the motion began, as long as it lasts, s.
    fn clock(&self, time: f64) -> f64 {
        match self.moves {
            Some([begin, _]) if time < begin => 0.0,
            Some([begin, end]) if time > end => end - begin,
            Some([begin, _]) => time - begin,
            None => time,
        }
    }

    fn runs_at(&self, time: f64) -> bool {
        self.moves.is_none_or(|[begin, end]| time >= begin && time < end)
    }
}

impl Wall {
    /// A wall at rest.
    pub(super) fn at_rest(shape: Shape) -> Self {
        Self { shape, motion: Motion::default() }
    }

    /// The wall after `count` steps.
    pub(super) fn placed(&self, count: u64, time_step: f64) -> PlacedWall {
        let at = |step: f64| self.motion.displacement(step * time_step);
        let step = count as f64;
        let (before, now, after) = (at(step - 1.0), at(step), at(step + 1.0));
        let over = |to: [f64; 2], from: [f64; 2], time: f64| {
            [(to[0] - from[0]) / time, (to[1] - from[1]) / time]
        };
        PlacedWall {
            shape: self.shape.moved(now),
            step_velocity: over(now, before, time_step),
            mid_velocity: over(after, before, 2.0 * time_step),
            spin: if self.motion.runs_at(step * time_step) { self.motion.spin } else { 0.0 },
        }
    }
}

impl Shape {
    fn moved(self, by: [f64; 2]) -> Self {
        let moved = |[x, y]: [f64; 2]| [x + by[0], y + by[1]];
        match self {
            Self::Plane { point, normal } => Self::Plane { point: moved(point), normal },
            Self::Segment { from, to } => Self::Segment { from: moved(from), to: moved(to) },
            Self::Drum { center, radius } => Self::Drum { center: moved(center), radius },
        }
    }

    /// The nearest point of this wall to a disc's center.
    #[inline(always)]
    pub(super) fn contact(&self, [x, y]: [f64; 2]) -> WallContact {
        match *self {
            Self::Plane { point, normal } => {
                let distance = (x - point[0]) * normal[0] + (y - point[1]) * normal[1];
                WallContact { normal, distance }
            }
            Self::Segment { from, to } => {
                let along = [to[0] - from[0], to[1] - from[1]];
                let length_squared = along[0] * along[0] + along[1] * along[1];
                let fraction =
                    ((x - from[0]) * along[0] + (y - from[1]) * along[1]) / length_squared;
                let fraction = if fraction > 0.0 { fraction } else { 0.0 };
                let fraction = if fraction < 1.0 { fraction } else { 1.0 };
                away_from([from[0] + fraction * along[0], from[1] + fraction * along[1]], [x, y])
            }
            Self::Drum { center, radius } => {
                let inward = away_from([x, y], center);
                WallContact { normal: inward.normal, distance: radius - inward.distance }
            }
        }
    }
}

impl PlacedWall {
    /// Distance of a disc's center a step ago, m, by its present position and the velocity and duration of that step.
    pub(super) fn distance_before(
        &self,
        [x, y]: [f64; 2],
        ([vx, vy], time_step): ([f64; 2], f64),
    ) -> f64 {
        let [ux, uy] = self.step_velocity;
        self.shape.contact([x - (vx - ux) * time_step, y - (vy - uy) * time_step]).distance
    }

    /// Velocity of the wall's surface at the contact point, from the wall's velocity and its spin.
    pub(super) fn surface_velocity(&self, velocity: [f64; 2], normal: [f64; 2]) -> [f64; 2] {
        match self.shape {
            Shape::Drum { radius, .. } => {
                let speed = self.spin * radius;
                [velocity[0] + speed * normal[1], velocity[1] - speed * normal[0]]
            }
            Shape::Plane { .. } | Shape::Segment { .. } => velocity,
        }
    }
}

vectorized! {
    /// Marks those discs whose distance from a wall is less than their radius and a margin, m.
    pub(super) fn mark_near(
        shape: Shape,
        positions: &[[f64; 2]],
        radii: &[f64],
        margin: f64,
        are_near: &mut [bool],
    ) -> () {
        for (is_near, (&position, radius)) in are_near.iter_mut().zip(positions.iter().zip(radii)) {
            *is_near |= shape.contact(position).distance < radius + margin;
        }
    }
}

/// Direction and distance from a point to another.
#[inline(always)]
fn away_from(point: [f64; 2], to: [f64; 2]) -> WallContact {
    let apart = [to[0] - point[0], to[1] - point[1]];
    let distance = (apart[0] * apart[0] + apart[1] * apart[1]).sqrt();
    // A center on the point itself has no direction; any one will do.
    let normal =
        if distance > 0.0 { [apart[0] / distance, apart[1] / distance] } else { [0.0, 1.0] };
    WallContact { normal, distance }
}
