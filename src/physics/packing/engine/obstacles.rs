//! Collisions of discs with fixed obstacles.

use super::prediction::Prediction;
use super::state::Engine;
use crate::model::SimulationFault;
use crate::packing::collision::{Collision, CollisionPartner};
use crate::packing::contact::MovingDisc;
use crate::packing::events::EventCode;
use crate::packing::falling_contact::time_to_obstacle;
use crate::packing::motion;

impl Engine {
    /// The earlier of an event and the first contact of a disc with an obstacle.
    #[inline(never)]
    pub(super) fn or_obstacle<const FALLS: bool>(
        &self,
        moving: MovingDisc,
        mut first: Prediction,
    ) -> Prediction {
        let domain = &self.state.domain;
        let contact_distance = domain.obstacles.radius + self.radius(moving.id as usize);
        for number in self.obstacles.near(moving.cell) {
            let r = self.obstacles.separation(moving.position, number);
            let (v, until) = (moving.velocity, first.time - moving.now);
            let time = if FALLS {
                time_to_obstacle(r, v, domain.gravity, contact_distance, until)
            } else {
                motion::time_to_contact(r, v.map(|component| -component), contact_distance)
            };
            let contact = (moving.now + time, EventCode::OBSTACLE);
            if time < f64::MAX && contact < (first.time, first.event) {
                (first.time, first.event) = contact;
                first.partner_collisions = number;
            }
        }
        first
    }

    /// Executes the collision of a disc with an obstacle near its cell, and predicts the next event of the disc.
    ///
    /// # Errors
    /// Inelastic collapse.
    #[inline(never)]
    pub(super) fn collide_obstacle<const WIDTH: usize, const FALLS: bool>(
        &mut self,
        disc: u32,
        number: u32,
    ) -> Result<Collision, SimulationFault> {
        let record = &self.state.discs[disc as usize];
        let now = self.state.clock.local();
        let (cell, age) = (record.cell, now - record.time);
        let (position, before) = record.at::<FALLS>(now, self.state.domain.gravity);
        self.state.collapse_detector.record([disc], [age], self.state.clock)?;
        let separation = self.obstacles.separation(position, number);
        let domain = &self.state.domain;
        let (after, normal_impulse, energy_gain) =
            motion::obstacle_collision(separation, before, |speed| {
                domain.restitution_at(speed, age)
            });
        let moving = MovingDisc { id: disc, cell, position, velocity: after, now };
        self.leave::<WIDTH, FALLS>(moving);
        Ok(Collision {
            disc,
            partner: CollisionPartner::Obstacle,
            separation,
            velocity_changes: [[before, after], [[0.0; 2]; 2]],
            normal_impulse,
            energy_gain,
            time_since_previous: self.record_collision_time(),
        })
    }
}
