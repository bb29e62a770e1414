//! The discretization of the equation of motion.
//!
//! Semi-implicit Euler is the DEM exercise's equation (3):
//!
//! v' = v + a dt, x' = x + v' dt, with a from x and v at the step's start only.
//!
//! Therefore, v is half a step behind x. The velocity at the positions' time is the mid-step one, v + a dt/2. The same holds for spins.
//!
//! Velocity Verlet with the dashpot evaluated at the half-step velocity (half kick, drift, half kick) is the same map: two
//! successive half kicks by the same acceleration are one kick. Only its start differs: its half-step velocity is
//! v - a dt/2 of the given one, where Euler takes the given one itself.
//!
//! The implicit dashpot changes the forces, not the step: see `forces::implicit`.
//!
//! Blocks of discs move in parallel. First all inter-block forces are found, while every disc is at rest; then each block finds
//! its other forces and moves its own discs, which no other block reads.

use super::block::{BLOCK, Block, BlockDiscs, Partner};
use super::discs::Discs;
use super::forces::ForceFinder;
use super::forces::implicit;
use super::forces::inter_block::InterBlockForces;
use super::integrate;
use super::materials::ContactLaw;
use super::motion;
use super::neighbors::Neighbors;
use super::neighbors::near_pairs::NearPairs;
use super::neighbors::pair_search::SearchMemory;
use super::parameters::StepContext;
use super::spare::Spare;
use super::totals::{BlockForces, Contact, StepTotals};
use crate::sum::CompensatedSum;
use rayon::prelude::*;

/// Blocks whose contacts are in memory at a time when a state is evaluated: a large bed has no room for a list of all.
const EVALUATED: usize = 16;

/// Memory of a step. It is not part of the state.
#[derive(Clone, Debug, Default)]
pub(super) struct Workspace {
    /// Inter-block forces of each block.
    inter_block: Vec<InterBlockForces>,
    /// Near pairs of each block.
    near: Vec<NearPairs>,
    /// Forces on the discs of the block that a thread is moving.
    forces: Spare<ForceFinder>,
    /// For building lists between steps.
    pub(super) search: SearchMemory,
}

/// The forces of a block that are known before it moves, and its near pairs.
struct KnownForces<'a> {
    /// All forces, with implicit dashpots.
    solved: Option<&'a BlockForces>,
    inter_block: &'a InterBlockForces,
    near: &'a mut NearPairs,
}

impl Workspace {
    /// Moves all discs by a step.
    pub(super) fn advance(
        &mut self,
        neighbors: &mut Neighbors,
        discs: &mut Discs,
        step: &StepContext<'_>,
    ) -> StepTotals {
        let solved = solved(neighbors, discs, step).map(|solution| solution.forces);
        let solved = solved.as_deref().unwrap_or_default();
        let blocks = &mut neighbors.blocks;
        let count = blocks.len();
        self.inter_block.resize_with(count, InterBlockForces::default);
        self.near.resize_with(count, NearPairs::default);
        if let [block] = blocks.as_mut_slice() {
            // Small runs do not need threads.
            self.inter_block[0].find(block, discs, step, false);
            let (inter_block, near) = (&self.inter_block[0], &mut self.near[0]);
            let forces = KnownForces { solved: solved.first(), inter_block, near };
            let memory = &self.forces;
            let moved =
                discs.blocks().pop().map(|discs| move_block(block, discs, forces, memory, step));
            return moved.unwrap_or_default();
        }
        let at_rest = &*discs;
        blocks
            .par_iter_mut()
            .zip(self.inter_block.par_iter_mut())
            .for_each(|(block, forces)| forces.find(block, at_rest, step, false));
        let mut totals = vec![StepTotals::default(); count];
        blocks
            .par_iter_mut()
            .zip(discs.blocks())
            .zip(self.inter_block.par_iter())
            .zip(self.near.par_iter_mut())
            .zip(totals.par_iter_mut())
            .for_each(|((((block, discs), inter_block), near), totals)| {
                let solved = solved.get(block.start / BLOCK);
                let forces = KnownForces { solved, inter_block, near };
                *totals = move_block(block, discs, forces, &self.forces, step);
            });
        StepTotals::of_all(&totals)
    }
}

/// Moves the discs of a block by the forces that are solved, or else found now.
fn move_block(
    block: &mut Block,
    mut discs: BlockDiscs<'_>,
    KnownForces { solved, inter_block, near }: KnownForces<'_>,
    memory: &Spare<ForceFinder>,
    step: &StepContext<'_>,
) -> StepTotals {
    memory.lend(|memory| {
        match solved {
            Some(solved) => memory.found.clone_from(solved),
            None => memory.find(block, &discs, inter_block, near, step, None),
        }
        integrate::kick_and_drift(&mut discs, &mut memory.found, step)
    })
}

/// Contacts with implicit dashpots, and the forces of each block.
struct Solution {
    contacts: Vec<Contact>,
    forces: Vec<BlockForces>,
}

/// The solution with implicit dashpots; `None` with explicit ones.
fn solved(neighbors: &Neighbors, discs: &Discs, step: &StepContext<'_>) -> Option<Solution> {
    if !step.parameters.law.is_implicit {
        return None;
    }
    let (mut contacts, mut copy) = (Vec::new(), discs.clone());
    for (block, of_block) in neighbors.blocks.iter().zip(copy.blocks()) {
        find_forces(block, &of_block, discs, step, &mut contacts);
    }
    implicit::solve(discs, step.parameters, &mut contacts);
    let forces = implicit::forces_of(&contacts, discs, step);
    Some(Solution { contacts, forces })
}

/// Finds the forces on a block's discs, of which `all` is a copy, and records its contacts.
fn find_forces(
    block: &Block,
    discs: &BlockDiscs<'_>,
    all: &Discs,
    step: &StepContext<'_>,
    contacts: &mut Vec<Contact>,
) -> BlockForces {
    let (mut inter_block, mut forces) = (InterBlockForces::default(), ForceFinder::default());
    let block = &mut block.clone();
    inter_block.find(block, all, step, true);
    forces.find(block, discs, &inter_block, &mut NearPairs::default(), step, Some(contacts));
    forces.found
}

/// Forces and accelerations of a state, for observation.
#[derive(Clone, Debug, Default)]
pub(super) struct Evaluation {
    pub(super) contacts: ContactStatistics,
    /// Velocities at the positions' time, v + a dt/2, m/s.
    pub(super) velocities: Vec<[f64; 2]>,
    /// Spins at the positions' time, rad/s; empty if no disc has one.
    spins: Vec<f64>,
    /// Sums of the contact forces, N; empty if they are not recorded.
    pub(super) forces: Vec<[f64; 2]>,
    /// The totals of the next step.
    pub(super) totals: StepTotals,
}

/// Statistics of all contacts.
#[derive(Clone, Debug, Default)]
pub(super) struct ContactStatistics {
    /// Contacts of two discs.
    pub(super) pairs: u64,
    /// Contacts with walls.
    pub(super) walls: u64,
    /// Potential energy of the normal forces, J.
    pub(super) elastic: CompensatedSum,
    /// Largest overlap over the smaller radius of a contact, 0 without contacts.
    pub(super) max_overlap: f64,
}

impl ContactStatistics {
    fn add(&mut self, contact: &Contact, law: &ContactLaw, discs: &Discs) {
        if contact.overlap < 0.0 {
            return;
        }
        let ends = (contact.disc, contact.partner);
        match contact.partner {
            Partner::Disc(_) => self.pairs += 1,
            Partner::Wall(_) => self.walls += 1,
        }
        self.elastic.add(law.force_and_energy(discs, ends, contact.overlap)[1]);
        if contact.overlap_over_radius > self.max_overlap {
            self.max_overlap = contact.overlap_over_radius;
        }
    }
}

impl Evaluation {
    /// Evaluates a state without changing it, many blocks in parallel. `on_contact` receives all contacts, in a fixed order.
    pub(super) fn of(
        neighbors: &Neighbors,
        discs: &Discs,
        step: &StepContext<'_>,
        on_contact: &mut dyn FnMut(&Contact),
    ) -> Self {
        let mut all = Self { velocities: vec![[0.0; 2]; discs.len()], ..Self::default() };
        if step.parameters.law.has_friction() || discs.have_spin() {
            all.spins.resize(discs.len(), 0.0);
        }
        let solved = solved(neighbors, discs, step);
        let mut take = |contact: &Contact| {
            all.contacts.add(contact, &step.parameters.law, discs);
            on_contact(contact);
        };
        let mut totals = Vec::with_capacity(neighbors.blocks.len());
        let discs_at_a_time = EVALUATED * BLOCK;
        let velocities = all.velocities.chunks_mut(discs_at_a_time);
        let mut spins = all.spins.chunks_mut(discs_at_a_time);
        for (blocks, velocities) in neighbors.blocks.chunks(EVALUATED).zip(velocities) {
            let spins = spins.next().unwrap_or_default().chunks_mut(BLOCK);
            let mut spins: Vec<&mut [f64]> = spins.collect();
            spins.resize_with(blocks.len(), Default::default);
            let mid_step = velocities.par_chunks_mut(BLOCK).zip(spins);
            let evaluated = blocks.par_iter().zip(mid_step).map(|(block, mid_step)| {
                let forces = solved.as_ref().map(|all| &all.forces[block.start / BLOCK]);
                evaluate_block(block, discs, forces, step, mid_step)
            });
            for (of_block, contacts, forces) in evaluated.collect::<Vec<EvaluatedBlock>>() {
                totals.push(of_block);
                all.forces.extend(forces);
                contacts.iter().for_each(&mut take);
            }
        }
        if let Some(Solution { contacts, .. }) = solved {
            contacts.iter().for_each(take);
        }
        all.totals = StepTotals::of_all(&totals);
        all
    }
}

impl Evaluation {
    /// Spin of a disc at the positions' time, rad/s.
    pub(super) fn spin(&self, disc: usize) -> f64 {
        self.spins.get(disc).copied().unwrap_or(0.0)
    }
}

/// Totals, contacts unless all forces are solved, and the discs' forces if they are recorded.
type EvaluatedBlock = (StepTotals, Vec<Contact>, Vec<[f64; 2]>);

/// Moves a copy of a block. Velocities and spins at the
/// positions' time are written to the last argument.
fn evaluate_block(
    block: &Block,
    discs: &Discs,
    solved: Option<&BlockForces>,
    step: &StepContext<'_>,
    (velocities, spins): (&mut [[f64; 2]], &mut [f64]),
) -> EvaluatedBlock {
    let range = block.start..block.start + block.len(discs.len());
    let mut copy = BlockDiscs {
        start: block.start,
        positions: &mut discs.positions[range.clone()].to_vec(),
        velocities: &mut discs.velocities[range.clone()].to_vec(),
        spins: &mut discs.spins[range.clone()].to_vec(),
        radii: &discs.radii[range.clone()],
        masses: &discs.masses[range.clone()],
        inverse_masses: &discs.inverse_masses[range.clone()],
        materials: &discs.materials[range],
    };
    let mut contacts = Vec::new();
    let mut forces = match solved {
        Some(solved) => solved.clone(),
        None => find_forces(block, &copy, discs, step, &mut contacts),
    };
    let half = 0.5 * step.parameters.time_step;
    for (disc, &[fx, fy, ..]) in forces.forces.iter().enumerate() {
        let inverse_mass = copy.inverse_masses[disc];
        let [ax, ay] = motion::acceleration(step.parameters.gravity, [fx, fy], inverse_mass);
        let [vx, vy] = copy.velocities[disc];
        velocities[disc] = [vx + ax * half, vy + ay * half];
    }
    for (spin, before) in spins.iter_mut().zip(copy.spins.iter()) {
        *spin = *before;
    }
    for ((disc, spin), &[torque, _]) in spins.iter_mut().enumerate().zip(&forces.torques) {
        let (mass, radius) = (copy.masses[disc], copy.radii[disc]);
        *spin += motion::angular_acceleration(torque, mass, radius) * half;
    }
    let recorded = forces.forces.iter().filter(|_| step.parameters.records_forces);
    let recorded = recorded.map(|&[fx, fy, ..]| [fx, fy]).collect();
    let totals = integrate::kick_and_drift(&mut copy, &mut forces, step);
    (totals, contacts, recorded)
}
