//! Executes collisions: the rules of `motion` applied to the records of the discs.

use super::state::Engine;
use crate::cell_grid::{Cell, Side};
use crate::model::SimulationFault;
use crate::packing::collision::{Collision, CollisionPartner};
use crate::packing::contact::MovingDisc;
use crate::packing::domain::Floor;
use crate::packing::motion::{self, Vector};
use crate::packing::rest;
use crate::random::flux_speed;

/// Number of pairs of angles of the wall noise that are drawn at most. At least half of all angles let a disc leave the wall, so
/// that more pairs are needed in one of 4^1000 collisions, unless the velocity is no normal number.
const MAX_DRAWS: u32 = 1000;

impl Engine {
    /// Executes the collision of two discs and predicts the next event of both.
    ///
    /// # Errors
    /// Inelastic collapse.
    #[inline(always)]
    pub(super) fn collide_pair<const WIDTH: usize, const FALLS: bool>(
        &mut self,
        disc: u32,
        partner: u32,
    ) -> Result<Collision, SimulationFault> {
        // Ordered by id: the arithmetic does not depend on which disc predicted the collision.
        let pair = if disc < partner { [disc, partner] } else { [partner, disc] };
        let now = self.state.clock.local();
        let [first, second] = pair.map(|disc| &self.state.discs[disc as usize]);
        let ages = [now - first.time, now - second.time];
        let gravity = self.state.domain.gravity;
        let present = [first.at::<FALLS>(now, gravity), second.at::<FALLS>(now, gravity)];
        let [positions, before] = [present.map(|disc| disc.0), present.map(|disc| disc.1)];
        let cells = [first.cell, second.cell];
        self.state.collapse_detector.record(pair, ages, self.state.clock)?;
        let offset = self.cells.grid.offset_between(cells[0], cells[1]);
        let separation = [
            positions[1][0] + offset[0] - positions[0][0],
            positions[1][1] + offset[1] - positions[0][1],
        ];
        let time_since_previous = if ages[0] < ages[1] { ages[0] } else { ages[1] };
        let domain = &self.state.domain;
        let contact_distance = self.radius(pair[0] as usize) + self.radius(pair[1] as usize);
        let collision = match self.state.growth {
            None => motion::pair_collision(separation, before, |approach_speed| {
                domain.restitution_at(approach_speed, time_since_previous)
            }),
            Some(growth) => {
                let growth_rate = growth.rate * contact_distance;
                motion::growing_pair_collision(separation, before, growth_rate)
            }
        };
        let energy_gain = if FALLS {
            let restitution = |speed| domain.restitution_at(speed, time_since_previous);
            motion::energy_gain(separation, before, restitution)
        } else {
            0.0
        };
        let moving = [0, 1].map(|index: usize| MovingDisc {
            id: pair[index],
            cell: cells[index],
            position: positions[index],
            velocity: collision.velocities[index],
            now,
        });
        for moving in moving {
            self.store_after_collision(moving);
        }
        // The two predictions are independent, so the processor overlaps them.
        let predictions = [
            self.predict_next_event::<WIDTH, FALLS>(moving[0]),
            self.predict_next_event::<WIDTH, FALLS>(moving[1]),
        ];
        for (disc, prediction) in pair.into_iter().zip(predictions) {
            self.set_prediction(disc, prediction);
            self.schedule(disc);
        }
        let [first, second] = collision.velocities;
        Ok(Collision {
            disc: pair[0],
            partner: CollisionPartner::Disc { id: pair[1], contact_distance },
            separation,
            velocity_changes: [[before[0], first], [before[1], second]],
            normal_impulse: collision.normal_impulse,
            energy_gain,
            time_since_previous: self.record_collision_time(),
        })
    }

    /// Executes a wall collision and predicts the next event of the disc.
    ///
    /// # Errors
    /// A disc that is too slow to leave the wall.
    #[inline(always)]
    pub(super) fn collide_wall<const WIDTH: usize, const FALLS: bool>(
        &mut self,
        disc: u32,
        side: Side,
    ) -> Result<Collision, SimulationFault> {
        let axis = side.axis();
        let record = &self.state.discs[disc as usize];
        let now = self.state.clock.local();
        let (cell, age) = (record.cell, now - record.time);
        let (mut position, before) = record.at::<FALLS>(now, self.state.domain.gravity);
        let is_floor = FALLS && side == Side::Bottom;
        if is_floor {
            self.state.collapse_detector.record([disc], [age], self.state.clock)?;
        }
        let (mut after, floor_energy) = if is_floor && self.state.domain.floor != Floor::AtRest {
            position[1] = self.floor_below(disc, cell);
            self.velocity_after_floor(before)
        } else {
            position[axis] = self.contact_position_at_wall(disc, side);
            let after = self.velocity_after_wall(before, axis);
            (after.ok_or_else(|| rest::fault_at_wall(disc, before))?, 0.0)
        };
        if let Some(growth) = self.state.growth {
            let growth_rate = growth.rate * self.radius(disc as usize);
            after = motion::growing_wall_collision(before, axis, side.is_upper(), growth_rate);
        }
        let moving = MovingDisc { id: disc, cell, position, velocity: after, now };
        self.leave::<WIDTH, FALLS>(moving);
        Ok(Collision {
            disc,
            partner: CollisionPartner::Wall,
            separation: side.outward_normal(),
            velocity_changes: [[before, after], [[0.0; 2]; 2]],
            normal_impulse: (after[axis] - before[axis]).abs(),
            energy_gain: floor_energy,
            time_since_previous: self.record_collision_time(),
        })
    }

    /// Stores a disc after a collision with a wall or an obstacle, and predicts its next event.
    #[inline(always)]
    pub(super) fn leave<const WIDTH: usize, const FALLS: bool>(&mut self, moving: MovingDisc) {
        self.store_after_collision(moving);
        let prediction = self.predict_next_event::<WIDTH, FALLS>(moving);
        self.set_prediction(moving.id, prediction);
        self.schedule(moving.id);
    }

    /// Stores the position and velocity of a disc after a collision, and counts it.
    #[inline(always)]
    fn store_after_collision(&mut self, moving: MovingDisc) {
        let disc = &mut self.state.discs[moving.id as usize];
        disc.position = moving.position;
        disc.velocity = moving.velocity;
        disc.time = moving.now;
        disc.collisions = disc.collisions.wrapping_add(1);
    }

    /// Records the present time as that of the last collision; returns the time since the previous one.
    #[inline(always)]
    pub(super) fn record_collision_time(&mut self) -> f64 {
        let time_since_previous = self.time_since_last_collision();
        self.state.last_collision = self.state.clock.local();
        time_since_previous
    }

    /// The coordinate at which a disc touches a floor that gives energy, relative to the corner of a cell.
    fn floor_below(&self, disc: u32, cell: Cell) -> f64 {
        let radius = self.radius(disc as usize);
        let Floor::Shaken(shaking) = self.state.domain.floor else { return radius };
        let [height, _] = shaking.motion_at(self.state.clock.time());
        radius + (height - f64::from(cell[1]) * self.cells.grid.cell_sides[1])
    }

    /// The velocity after a collision with a floor that gives energy, and the energy that the disc gains: the heat of a thermal floor, whose
    /// emission has the flux distribution of a Maxwellian gas (Maxwell, Phil. Trans. 170 (1879) 231), or the work of a shaken one,
    /// its impulse times its velocity.
    #[inline(never)]
    fn velocity_after_floor(&mut self, [vx, vy]: Vector) -> (Vector, f64) {
        match self.state.domain.floor {
            Floor::AtRest => ([vx, -vy], 0.0),
            Floor::Thermal { speed } => {
                let generator = &mut self.state.wall_noise;
                let up = speed * flux_speed(generator.uniform());
                let along = speed * generator.normal_pair()[0];
                ([along, up], 0.5 * ((along * along + up * up) - (vx * vx + vy * vy)))
            }
            Floor::Shaken(shaking) => {
                let [_, speed] = shaking.motion_at(self.state.clock.time());
                ([vx, 2.0 * speed - vy], 2.0 * (speed - vy) * speed)
            }
        }
    }

    /// The velocity after a wall collision: the angle of the noise is drawn again until the disc leaves the wall. `None` if it does
    /// not in [`MAX_DRAWS`].
    fn velocity_after_wall(&mut self, velocity: Vector, axis: usize) -> Option<Vector> {
        let std = self.state.domain.wall_noise_rad;
        (0..MAX_DRAWS).find_map(|_| {
            let angles = if std > 0.0 {
                self.state.wall_noise.normal_pair().map(|normal| normal * std)
            } else {
                [0.0; 2]
            };
            let outgoing = |angle| motion::wall_collision(velocity, axis, angle);
            angles.into_iter().find_map(outgoing)
        })
    }
}
