//! What collisions do to discs, and what is told of them.

use super::Engine;
use crate::model::SimulationFault;
use crate::packing::events::Side;
use crate::packing::motion::{self, Vector};
use crate::packing::scan::Seeker;

/// A collision that has taken place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::packing) struct Collision {
    /// With whom.
    pub(in crate::packing) with: With,
    /// Velocities before and after, of each disc that took part.
    pub(in crate::packing) changes: Changes,
    /// Magnitude of the momentum handed over along the normal.
    pub(in crate::packing) normal_impulse: f64,
    /// Time since the collision before it, of any discs, or since the start.
    pub(in crate::packing) wait: f64,
}

/// What a disc collided with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::packing) enum With {
    /// Another disc, at this distance of the centers.
    Disc(f64),
    /// A wall.
    Wall,
}

/// Velocities before and after a collision: of the pair, or of one disc and nobody (at rest before and after).
pub(in crate::packing) type Changes = [[Vector; 2]; 2];

impl Engine {
    #[inline(always)]
    pub(super) fn collide_pair<const WIDE: bool>(
        &mut self,
        disc: u32,
        partner: u32,
    ) -> Result<Collision, SimulationFault> {
        // The same arithmetic whichever of the two predicted it.
        let pair = if disc < partner { [disc, partner] } else { [partner, disc] };
        let now = self.state.clock.local();
        let [first, second] = pair.map(|disc| &self.state.discs[disc as usize]);
        let ages = [now - first.time, now - second.time];
        let positions = [first.position_at(now), second.position_at(now)];
        let before = [first.velocity, second.velocity];
        let cells = [first.cell, second.cell];
        self.state.rapid.note(pair, ages, self.state.clock)?;
        let shift = self.cells.grid.shift(cells[0], cells[1]);
        let separation = [
            positions[1][0] + shift[0] - positions[0][0],
            positions[1][1] + shift[1] - positions[0][1],
        ];
        let since = if ages[0] < ages[1] { ages[0] } else { ages[1] };
        let arena = &self.state.arena;
        let reach = self.radius(pair[0] as usize) + self.radius(pair[1] as usize);
        let impact = match self.state.growth {
            None => motion::pair_impact(separation, before, |approach| {
                arena.restitution_of(approach, since)
            }),
            Some(growth) => motion::growing_pair_impact(separation, before, growth.rate * reach),
        };
        let seekers = [0, 1].map(|of: usize| Seeker {
            disc: pair[of],
            cell: cells[of],
            position: positions[of],
            velocity: impact.velocities[of],
            now,
        });
        for seeker in seekers {
            self.leave(seeker);
        }
        // Neither prediction waits for the other.
        let prospects = [self.soonest::<WIDE>(seekers[0]), self.soonest::<WIDE>(seekers[1])];
        for (disc, prospect) in pair.into_iter().zip(prospects) {
            self.set(disc, prospect);
            self.file(disc);
        }
        Ok(Collision {
            with: With::Disc(reach),
            changes: [[before[0], impact.velocities[0]], [before[1], impact.velocities[1]]],
            normal_impulse: impact.normal_impulse,
            wait: self.mark_collision(),
        })
    }

    #[inline(always)]
    pub(super) fn collide_wall<const WIDE: bool>(&mut self, disc: u32, side: Side) -> Collision {
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
        let seeker = Seeker { disc, cell, position, velocity: after, now };
        self.leave(seeker);
        let prospect = self.soonest::<WIDE>(seeker);
        self.set(disc, prospect);
        self.file(disc);
        Collision {
            with: With::Wall,
            changes: [[before, after], [[0.0; 2]; 2]],
            normal_impulse: (after[axis] - before[axis]).abs(),
            wait: self.mark_collision(),
        }
    }

    /// Sends a disc on its way from here and now.
    #[inline(always)]
    fn leave(&mut self, seeker: Seeker) {
        let disc = &mut self.state.discs[seeker.disc as usize];
        disc.position = seeker.position;
        disc.velocity = seeker.velocity;
        disc.time = seeker.now;
        disc.collisions = disc.collisions.wrapping_add(1);
    }

    /// Notes that a collision takes place now; returns the time since the one before.
    #[inline(always)]
    fn mark_collision(&mut self) -> f64 {
        let wait = self.time_since_collision();
        self.state.last_collision = self.state.clock.local();
        wait
    }

    /// The velocity after a wall: the angle is drawn again until the disc leaves the wall.
    fn leave_wall(&mut self, velocity: Vector, axis: usize) -> Vector {
        let deviation = self.state.arena.wall_noise_rad;
        loop {
            let angles = if deviation > 0.0 {
                self.state.wall_noise.normal_pair().map(|normal| normal * deviation)
            } else {
                [0.0; 2]
            };
            let turned = |angle| motion::wall_impact(velocity, axis, angle);
            if let Some(leaving) = angles.into_iter().find_map(turned) {
                return leaving;
            }
        }
    }
}
