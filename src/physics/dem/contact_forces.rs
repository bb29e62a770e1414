//! The force of every contact with its friction, as `/contact_forces` tells it.

use crate::dem::Dem;
use crate::dem::forces::contact::{Contact, Partner};
use crate::dem::forces::touch::Touch;
use crate::dem::walls::PlacedWall;
use kinetoscope_recording::channels::DemContactForces;
use kinetoscope_recording::frame::ContactLine;

/// What a disc touches, as friction feels it.
struct OtherSide {
    /// m/s
    velocity: [f64; 2],
    /// Speed of its surface by its spin, m/s.
    surface_speed: f64,
}

impl Dem {
    /// Tells of a contact, from center to center or to the wall, with the force of the step that comes next.
    pub(super) fn tell_force(
        &self,
        contact: &Contact,
        walls: &[PlacedWall],
        told: &mut DemContactForces,
    ) {
        let ContactLine { from, to, .. } = self.line(contact);
        let force = self.force(contact, walls);
        for (column, value) in [
            (&mut told.from_x_m, from[0]),
            (&mut told.from_y_m, from[1]),
            (&mut told.to_x_m, to[0]),
            (&mut told.to_y_m, to[1]),
            (&mut told.force_x_n, force[0]),
            (&mut told.force_y_n, force[1]),
        ] {
            column.push(value);
        }
    }

    /// Force on the first disc of a contact, N.
    fn force(&self, contact: &Contact, walls: &[PlacedWall]) -> [f64; 2] {
        let [nx, ny] = contact.normal;
        let law = &self.parameters.law;
        // Implicit dashpots solve the normal forces of all contacts together, and know no friction.
        if law.is_implicit || !law.has_friction() {
            return [contact.force * nx, contact.force * ny];
        }
        let discs = &self.discs;
        let disc = contact.disc as usize;
        let (radius, material) = (discs.radii[disc], discs.materials[disc]);
        let other = self.other_side(contact, walls);
        let [vx, vy] = discs.velocities[disc];
        let touch = Touch {
            normal: contact.normal,
            overlap: contact.overlap,
            velocity: [vx - other.velocity[0], vy - other.velocity[1]],
            // Rolling friction is a torque and no force.
            rolling_rate: 0.0,
            surface_speed: radius * discs.spins[disc] + other.surface_speed,
        };
        let (constants, damping) = match contact.partner {
            Partner::Disc(partner) => (
                law.materials.between(material, discs.materials[partner as usize]),
                law.damping(discs, disc, partner as usize),
            ),
            Partner::Wall(_) => (law.materials.with_walls(material), law.wall_damping(discs, disc)),
        };
        let push = touch.push(law, damping);
        let (step, mut stretch) = (self.parameters.time_step, [contact.stretch, 0.0]);
        let rub = touch.rub(law, constants, step, None, &push, &mut stretch);
        let [fx, fy, ..] = push.and(&rub, contact.normal);
        [fx, fy]
    }

    fn other_side(&self, contact: &Contact, walls: &[PlacedWall]) -> OtherSide {
        match contact.partner {
            Partner::Disc(partner) => {
                let other = partner as usize;
                OtherSide {
                    velocity: self.discs.velocities[other],
                    surface_speed: self.discs.radii[other] * self.discs.spins[other],
                }
            }
            Partner::Wall(number) => {
                let wall = &walls[number as usize];
                OtherSide {
                    // That of the surface: a drum's spin is in it.
                    velocity: wall.surface_velocity(wall.step_velocity, contact.normal),
                    surface_speed: 0.0,
                }
            }
        }
    }
}
