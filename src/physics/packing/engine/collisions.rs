//! What collisions do to discs, and what is told of them.

use super::Engine;
use crate::cell_grid::Side;
use crate::model::Fault;
use crate::packing::motion::{self, Vector};
use crate::packing::scan::MovingDisc;

/// A collision that has taken place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::packing) struct Collision {
    /// CollisionPartner whom.
    pub(in crate::packing) with: CollisionPartner,
    /// Velocities before and after, of each disc that took part.
    pub(in crate::packing) changes: Changes,
    /// Magnitude of the momentum handed over along the normal.
    pub(in crate::packing) normal_impulse: f64,
    /// Time since the collision before it, of any discs, or since the start.
    pub(in crate::packing) wait: f64,
}

/// What a disc collided with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::packing) enum CollisionPartner {
    /// Another disc, at this distance of the centers.
    Disc(f64),
    /// A wall.
    Wall,
}

/// Velocities before and after a collision: of the pair, or of one disc and nobody (at rest before and after).
pub(in crate::packing) type Changes = [[Vector; 2]; 2];

impl Engine {
    #[inline(always)]
    pub(super) fn collide_pair<const HAS_AVX512: bool>(
        &mut self,
        disc: u32,
        partner: u32,
    ) -> Result<Collision, Fault> {
        // The same arithmetic whichever of the two predicted it.
        let pair = if disc < partner { [disc, partner] } else { [partner, disc] };
        let now = self.state.clock.local();
        let [first, second] = pair.map(|disc| &self.state.discs[disc as usize]);
        let ages = [now - first.time, now - second.time];
        let positions = [first.position_at(now), second.position_at(now)];
        let before = [first.velocity, second.velocity];
        let cells = [first.cell, second.cell];
        self.state.collapse_detector.note(pair, ages, self.state.clock)?;
        let shift = self.cells.grid.offset_between(cells[0], cells[1]);
        let separation = [
            positions[1][0] + shift[0] - positions[0][0],
            positions[1][1] + shift[1] - positions[0][1],
        ];
        let since = if ages[0] < ages[1] { ages[0] } else { ages[1] };
        let domain = &self.state.domain;
        let reach = self.radius(pair[0] as usize) + self.radius(pair[1] as usize);
        let impact = match self.state.growth {
            None => motion::pair_collision(separation, before, |approach| {
                domain.restitution_at(approach, since)
            }),
            Some(growth) => motion::growing_pair_collision(separation, before, growth.rate * reach),
        };
        let moving = [0, 1].map(|of: usize| MovingDisc {
            id: pair[of],
            cell: cells[of],
            position: positions[of],
            velocity: impact.velocities[of],
            now,
        });
        for moving in moving {
            self.leave(moving);
        }
        // Neither prediction waits for the other.
        let predictions =
            [self.soonest::<HAS_AVX512>(moving[0]), self.soonest::<HAS_AVX512>(moving[1])];
        for (disc, prediction) in pair.into_iter().zip(predictions) {
            self.set(disc, prediction);
            self.schedule(disc);
        }
        Ok(Collision {
            with: CollisionPartner::Disc(reach),
            changes: [[before[0], impact.velocities[0]], [before[1], impact.velocities[1]]],
            normal_impulse: impact.normal_impulse,
            wait: self.mark_collision(),
        })
    }

    #[inline(always)]
    pub(super) fn collide_wall<const HAS_AVX512: bool>(
        &mut self,
        disc: u32,
        side: Side,
    ) -> Collision {
        let axis = side.axis();
        let record = &self.state.discs[disc as usize];
        let (cell, before) = (record.cell, record.velocity);
        let now = self.state.clock.local();
        let mut position = record.position_at(now);
        position[axis] = self.wall(disc, side);
        let mut after = self.leave_wall(before, axis);
        if let Some(growth) = self.state.growth {
            // Elastic for the disc's edge, which comes toward the wall faster than the center by the growth.
            let parting = 2.0 * growth.rate * self.radius(disc as usize);
            after = before;
            after[axis] = -before[axis] + if side.is_upper() { -parting } else { parting };
        }
        let moving = MovingDisc { id: disc, cell, position, velocity: after, now };
        self.leave(moving);
        let prediction = self.soonest::<HAS_AVX512>(moving);
        self.set(disc, prediction);
        self.schedule(disc);
        Collision {
            with: CollisionPartner::Wall,
            changes: [[before, after], [[0.0; 2]; 2]],
            normal_impulse: (after[axis] - before[axis]).abs(),
            wait: self.mark_collision(),
        }
    }

    /// Sends a disc on its way from here and now.
    #[inline(always)]
    fn leave(&mut self, moving: MovingDisc) {
        let disc = &mut self.state.discs[moving.id as usize];
        disc.position = moving.position;
        disc.velocity = moving.velocity;
        disc.time = moving.now;
        disc.collisions = disc.collisions.wrapping_add(1);
    }

    /// Notes that a collision takes place now; returns the time since the one before.
    #[inline(always)]
    fn mark_collision(&mut self) -> f64 {
        let wait = self.time_since_last_collision();
        self.state.last_collision = self.state.clock.local();
        wait
    }

    /// The velocity after a wall: the angle is drawn again until the disc leaves the wall.
    fn leave_wall(&mut self, velocity: Vector, axis: usize) -> Vector {
        let deviation = self.state.domain.wall_noise_rad;
        loop {
            let angles = if deviation > 0.0 {
                self.state.wall_noise.normal_pair().map(|normal| normal * deviation)
            } else {
                [0.0; 2]
            };
            let turned = |angle| motion::wall_collision(velocity, axis, angle);
            if let Some(leaving) = angles.into_iter().find_map(turned) {
                return leaving;
            }
        }
    }
}
