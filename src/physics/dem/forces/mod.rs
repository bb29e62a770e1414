//! The forces on the discs of a block, contact by contact in the order of its lists.
//!
//! For each disc, the dissipative part D of its force F is summed as well: the sum of (k delta - f) n. The power that dashpots
//! take is then the sum of D . v over discs, and no contact is visited again once accelerations are known.
//!
//! *Invariant:* contacts are traversed once, by the kernel; the forces that are reported are those that move the discs, to the
//! last bit.

mod contact_law;
pub(super) mod implicit;
pub(super) mod inter_block;
mod kernel;
mod pair_loops;
#[cfg(test)]
mod register_width_does_not_affect_forces;

use crate::dem::block::{Block, BlockView};
use crate::dem::neighbors::near_pairs::{ContactNumbers, NearPairs};
use crate::dem::parameters::StepContext;
use crate::dem::totals::{BlockForces, Contact, ContactRecorder, MaxOverlap, Partner};
use crate::simd::dispatch::{self, Kernel};
use crate::simd::registers::{MAX_WIDTH, Scalar};
use contact_law::{ContactKinematics, LawRegisters, Surfaces};
use inter_block::{FrictionalContact, InterBlockForces, RimForce};
use kernel::{FrictionEnergies, PairContext, PairSums};
use pair_loops::NearMemory;

/// Finds the forces on the discs of one block after another; keeps memory that they share.
#[derive(Clone, Debug, Default)]
pub(super) struct ForceFinder {
    pub(super) found: BlockForces,
    /// Speeds r w of the discs' rims, m/s.
    rim_speeds: Vec<f64>,
    contact_numbers: ContactNumbers,
}

impl ForceFinder {
    /// Finds all forces on the discs of a block; the springs of its contacts advance by a step. Contacts are recorded in the order
    /// inner pairs, inter-block pairs, walls.
    pub(super) fn find<C: ContactRecorder>(
        &mut self,
        block: &mut Block,
        discs: &BlockView<'_>,
        inter_block: &InterBlockForces,
        near: &mut NearPairs,
        step: &StepContext<'_>,
        recorder: &mut C,
    ) {
        let count = discs.positions.len();
        // The integration has left them at zero.
        if self.found.forces.len() != count {
            self.found.forces.clear_to(count);
        }
        let max_overlap = MaxOverlap::new(step.known_overlap, step.smallest_radius, block.start);
        self.found.sums.clear(step.walls.len(), max_overlap);
        self.found.mask.clear();
        self.found.tangential.clear();
        self.found.rolling.clear();
        self.add_inner_pairs(block, discs, near, step, recorder);
        for &(disc, force) in &inter_block.forces {
            add(&mut self.found.forces[disc as usize], force);
            self.found.mask.insert(disc);
        }
        for (&(disc, _), rim) in inter_block.forces.iter().zip(&inter_block.rims) {
            self.add_rim_force(disc as usize, rim);
        }
        inter_block.contacts.iter().for_each(|&contact| recorder.record(contact));
        let law = LawRegisters::new(Scalar, step.law, step.time_step);
        self.add_walls(block, discs, step, &law, recorder);
        self.found.sums.add(&inter_block.sums);
    }

    fn add_inner_pairs<C: ContactRecorder>(
        &mut self,
        block: &mut Block,
        discs: &BlockView<'_>,
        near: &mut NearPairs,
        step: &StepContext<'_>,
        recorder: &mut C,
    ) {
        let has_friction = step.law.has_friction();
        let BlockForces { forces, tangential, rolling, sums, mask } = &mut self.found;
        if has_friction {
            tangential.resize(forces.len(), [0.0; 2]);
            rolling.resize(forces.len(), 0.0);
            self.rim_speeds.resize(forces.len(), 0.0);
            let (radii, spins) = (discs.radii, discs.spins);
            dispatch::run(RimSpeeds { speeds: &mut self.rim_speeds, radii, spins });
        }
        let context = PairContext {
            law: step.law,
            time_step: step.time_step,
            discs: *discs,
            rim_speeds: &self.rim_speeds,
            max_width: if step.use_simd { MAX_WIDTH } else { 1 },
        };
        let mut pair_sums =
            PairSums { forces, tangential, rolling, max_overlap: &mut sums.max_overlap };
        if has_friction {
            let end = block.inner.in_tiers(step.scope.tiers);
            let pairs = &mut block.inner;
            let energies =
                pair_loops::add_with_friction(&context, pairs, end, &mut pair_sums, recorder);
            let FrictionEnergies { elastic, friction, rolling } = energies;
            sums.elastic += sum(elastic);
            sums.friction += sum(friction);
            sums.rolling += sum(rolling);
        } else {
            let memory = NearMemory { near, contacts: &mut self.contact_numbers, mask };
            let (pairs, scope) = (&block.inner, &step.scope);
            pair_loops::add_without_friction(
                &context,
                pairs,
                scope,
                memory,
                &mut pair_sums,
                recorder,
            );
        }
    }

    #[inline]
    fn add_rim_force(&mut self, disc: usize, rim: &RimForce) {
        let [force, dashpot] = self.found.tangential[disc];
        let [on_rim, dashpot_on_rim] = rim.tangential;
        self.found.tangential[disc] = [force + on_rim, dashpot + dashpot_on_rim];
        self.found.rolling[disc] += rim.torque;
    }

    fn add_walls<C: ContactRecorder>(
        &mut self,
        block: &mut Block,
        discs: &BlockView<'_>,
        step: &StepContext<'_>,
        law: &LawRegisters<f64>,
        recorder: &mut C,
    ) {
        for pair in &mut block.walls {
            let disc = pair.disc as usize;
            let wall = &step.walls[pair.wall as usize];
            let radius = discs.radii[disc];
            let contact = wall.shape.contact(discs.positions[disc]);
            if contact.distance >= radius {
                inter_block::release(&mut self.found.sums, law, &mut pair.stretch, 1.0);
                continue;
            }
            let (distance, normal) = (contact.distance, contact.normal);
            let [vx, vy] = discs.velocities[disc];
            let [wall_vx, wall_vy] = wall.surface_velocity(wall.step_velocity, normal);
            let velocity = [vx - wall_vx, vy - wall_vy];
            let contact = ContactKinematics::new(normal, radius - distance, velocity);
            let partner = Partner::Wall(pair.wall);
            let overlap = contact.overlap;
            self.found.sums.max_overlap.note(overlap, disc, radius, partner, radius);
            let normal_force = law.normal_force(&contact, pair.damping);
            let mut on_disc = contact.along_normal(&normal_force);
            if step.law.has_friction() {
                let spin = discs.spins[disc];
                let surfaces = Surfaces {
                    constants: step.law.materials.with_walls(discs.materials[disc]),
                    rim_speed: radius * spin,
                    rolling_rate: spin - wall.spin,
                    reduced_radius: step.law.has_rolling_friction().then_some(radius),
                };
                let (normal, damping) = (normal_force, pair.damping);
                let contact = FrictionalContact { contact, normal, damping, share: 1.0 };
                let sums = &mut self.found.sums;
                let (force, rim) = contact.slide(law, &surfaces, &mut pair.stretch, sums);
                on_disc = force;
                self.add_rim_force(disc, &rim);
            }
            add(&mut self.found.forces[disc], on_disc);
            self.found.mask.insert(pair.disc);
            let [u, v] = wall.surface_velocity(wall.mid_velocity, normal);
            self.found.sums.wall_dissipation -= on_disc[2] * u + on_disc[3] * v;
            let by_wall = &mut self.found.sums.walls[pair.wall as usize];
            let [fx, fy, ..] = on_disc;
            *by_wall = [by_wall[0] + fx, by_wall[1] + fy, by_wall[2] + (fx * u + fy * v)];
            if C::IS_ACTIVE {
                recorder.record(Contact {
                    disc: (block.start + disc) as u32,
                    partner,
                    separation: normal.map(|part| distance * part),
                    normal,
                    overlap,
                    overlap_over_radius: overlap / radius,
                    normal_force: normal_force.force,
                    force: [fx, fy],
                });
            }
        }
    }
}

/// The sum of all lanes, in an order that does not depend on the width.
fn sum([a, b, c, d, e, f, g, h]: [f64; MAX_WIDTH]) -> f64 {
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}

#[inline]
fn add(sum: &mut [f64; 4], part: [f64; 4]) {
    *sum = [sum[0] + part[0], sum[1] + part[1], sum[2] + part[2], sum[3] + part[3]];
}

/// Finds the speeds r w of rims.
struct RimSpeeds<'a> {
    speeds: &'a mut [f64],
    radii: &'a [f64],
    spins: &'a [f64],
}

impl Kernel for RimSpeeds<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for ((speed, radius), spin) in self.speeds.iter_mut().zip(self.radii).zip(self.spins) {
            *speed = radius * spin;
        }
    }
}
