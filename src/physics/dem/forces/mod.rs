//! The forces on the discs of a block, contact by contact in the order of its lists.
//!
//! For each disc, the dissipative part D of its force F is summed as well: the sum of (f_e - f) n with the elastic forces f_e. The power that dashpots
//! take is then the sum of D . v over discs, and no contact is visited again once accelerations are known.
//!
//! *Invariant:* contacts are traversed once, by the kernel; the forces that are reported are those that move the discs, to the
//! last bit.

mod contact_law;
pub(super) mod implicit;
pub(super) mod inter_block;
mod kernel;
mod pair_loops;

use crate::dem::block::{Block, BlockDiscs, Partner, WallPair};
use crate::dem::laws::{NormalLaw, with_law};
use crate::dem::motion;
use crate::dem::neighbors::near_pairs::{ContactNumbers, NearPairs};
use crate::dem::parameters::StepContext;
use crate::dem::totals::{BlockForces, Contact, ContactMask, ContactRecorder};
use crate::dem::walls::PlacedWall;
use crate::simd::registers::Scalar;
use contact_law::{ContactKinematics, LawRegisters, Surfaces, Torque};
use inter_block::InterBlockForces;
use kernel::{PairContext, PairSums};
use pair_loops::NearMemory;

/// Finds the forces on the discs of one block after another; keeps memory that they share.
#[derive(Clone, Debug, Default)]
pub(super) struct ForceFinder {
    pub(super) found: BlockForces,
    /// Radius, m, and spin, rad/s, of each disc.
    rotors: Vec<[f64; 2]>,
    contact_numbers: ContactNumbers,
}

impl ForceFinder {
    /// Finds all forces on the discs of a block; the springs of its contacts advance by a step. Contacts are recorded in the order
    /// inner pairs, inter-block pairs, walls.
    pub(super) fn find(
        &mut self,
        block: &mut Block,
        discs: &BlockDiscs<'_>,
        inter_block: &InterBlockForces,
        near: &mut NearPairs,
        step: &StepContext<'_>,
        mut recorder: ContactRecorder<'_>,
    ) {
        let count = discs.positions.len();
        let found = &mut self.found;
        // The integration has left them at zero.
        if found.forces.len() != count {
            found.forces.clear_to(count);
            found.torques.clear();
        }
        found.sums.clear(step, block.start);
        found.mask = ContactMask::default();
        self.add_inner_pairs(block, discs, near, step, recorder.as_deref_mut());
        for &(disc, force) in &inter_block.forces {
            add(&mut self.found.forces[disc as usize], force);
            self.found.mask.insert(disc);
        }
        for (&(disc, _), torque) in inter_block.forces.iter().zip(&inter_block.torques) {
            self.add_torque(disc as usize, torque);
        }
        if let Some(contacts) = &mut recorder {
            contacts.extend_from_slice(&inter_block.contacts);
        }
        with_law!(step.parameters.law.normal, law => {
            let law = LawRegisters::new(Scalar, step, law);
            self.add_walls(&law, block, discs, step, recorder);
        });
        self.found.sums.add(&inter_block.sums);
    }

    fn add_inner_pairs(
        &mut self,
        block: &mut Block,
        discs: &BlockDiscs<'_>,
        near: &mut NearPairs,
        step: &StepContext<'_>,
        recorder: ContactRecorder<'_>,
    ) {
        let has_friction = step.parameters.law.has_friction();
        let BlockForces { forces, torques, sums, mask } = &mut self.found;
        if has_friction {
            torques.resize(forces.len(), [0.0; 2]);
            self.rotors.clear();
            let columns = discs.radii.iter().zip(discs.spins.iter());
            self.rotors.extend(columns.map(|(&radius, &spin)| [radius, spin]));
        }
        let context = PairContext { step, discs, rotors: &self.rotors };
        let mut pair_sums = PairSums { forces, torques, max_overlap: &mut sums.max_overlap };
        if has_friction {
            let [elastic, friction, rolling] =
                pair_loops::add_with_friction(&context, &mut block.inner, &mut pair_sums, recorder);
            sums.elastic += elastic;
            sums.friction += friction;
            sums.rolling += rolling;
        } else {
            let memory = NearMemory { near, contacts: &mut self.contact_numbers, mask };
            let (pairs, sums) = (&block.inner, &mut pair_sums);
            pair_loops::add_without_friction(&context, pairs, memory, sums, recorder);
        }
    }

    #[inline]
    fn add_torque(&mut self, disc: usize, [torque, by_dashpot]: &Torque) {
        let [sum, sum_by_dashpots] = self.found.torques[disc];
        self.found.torques[disc] = [sum + torque, sum_by_dashpots + by_dashpot];
    }

    /// Adds the force of a wall on a disc.
    fn add_wall_force(
        &mut self,
        pair: &WallPair,
        wall: &PlacedWall,
        normal: [f64; 2],
        on_disc: [f64; 4],
    ) {
        add(&mut self.found.forces[pair.disc as usize], on_disc);
        self.found.mask.insert(pair.disc);
        let [u, v] = wall.surface_velocity(wall.mid_velocity, normal);
        let sums = &mut self.found.sums;
        sums.wall_dissipation -= on_disc[2] * u + on_disc[3] * v;
        let by_wall = &mut sums.walls[pair.wall as usize];
        let [fx, fy, ..] = on_disc;
        *by_wall = [by_wall[0] + fx, by_wall[1] + fy, by_wall[2] + (fx * u + fy * v)];
    }

    fn add_walls<L: NormalLaw>(
        &mut self,
        law: &LawRegisters<f64, L>,
        block: &mut Block,
        discs: &BlockDiscs<'_>,
        step: &StepContext<'_>,
        mut recorder: ContactRecorder<'_>,
    ) {
        let has_friction = step.parameters.law.has_friction();
        let has_rolling_friction = step.parameters.law.has_rolling_friction();
        for pair in &mut block.walls {
            let disc = pair.disc as usize;
            let wall = &step.walls[pair.wall as usize];
            let law = law.of_pair(step.parameters.law.materials.with_walls(discs.materials[disc]));
            let (radius, sums) = (discs.radii[disc], &mut self.found.sums);
            let contact = wall.shape.contact(discs.positions[disc]);
            let moved = (discs.velocities[disc], step.parameters.time_step);
            let part = if law.is_cohesive {
                let since = (discs.velocities[disc], law.time_before);
                let before = wall.distance_before(discs.positions[disc], since);
                motion::attracted_part([radius - before, radius - contact.distance])
            } else {
                0.0
            };
            let (distance, normal) = (contact.distance, contact.normal);
            let partner = Partner::Wall(pair.wall);
            let mut record = |numbers, on_disc| {
                if let Some(contacts) = &mut recorder {
                    let ends = (block.start + disc, partner, [radius; 2]);
                    let separation = normal.map(|part| distance * part);
                    contacts.push(Contact::new(ends, [separation, normal], numbers, on_disc));
                }
            };
            if distance >= radius {
                law.release(&mut pair.stretch, sums, 1.0);
                if part != 0.0 {
                    let on_disc = law.attracted([0.0; 4], normal, part);
                    self.add_wall_force(pair, wall, normal, on_disc);
                    record([radius - distance, -(law.cohesion * part)], on_disc);
                }
                continue;
            }
            let [vx, vy] = discs.velocities[disc];
            let [wall_vx, wall_vy] = wall.surface_velocity(wall.step_velocity, normal);
            let velocity = [vx - wall_vx, vy - wall_vy];
            let mut contact = ContactKinematics::new(normal, radius - distance, velocity)
                .with_circle::<L>(radius);
            if L::HAS_MINDLIN_SPRINGS {
                let before = wall.distance_before(discs.positions[disc], moved);
                contact = contact.with_circle_before(radius, radius - before);
            }
            let overlap = contact.overlap;
            sums.max_overlap.note(overlap, disc, radius, partner, radius);
            let normal_force = law.normal_force::<true>(&contact, pair.damping);
            let mut on_disc = contact.along_normal(&normal_force);
            if has_friction {
                let spin = discs.spins[disc];
                let surfaces = Surfaces {
                    damping: pair.damping,
                    arm: distance,
                    surface_speed: distance * spin,
                    rolling_rate: spin - wall.spin,
                    reduced_radius: has_rolling_friction.then_some(radius),
                };
                let (normal_force, stretch) = (&normal_force, &mut pair.stretch);
                let (force, torque) =
                    law.with_friction(&contact, normal_force, &surfaces, stretch, sums, 1.0);
                on_disc = force;
                self.add_torque(disc, &torque);
            }
            let on_disc = law.attracted(on_disc, normal, part);
            self.add_wall_force(pair, wall, normal, on_disc);
            record([overlap, normal_force.force - law.cohesion * part], on_disc);
        }
    }
}

#[inline]
fn add(sum: &mut [f64; 4], part: [f64; 4]) {
    *sum = [sum[0] + part[0], sum[1] + part[1], sum[2] + part[2], sum[3] + part[3]];
}
