//! How the equation of motion is discretised.
//!
//! Semi-implicit Euler is the source document's equation (3):
//!
//! v' = v + a dt, x' = x + v' dt, with a from x and v at the step's start alone.
//!
//! So v stands half a step behind x. The velocity at the positions' time is the mid-step one, v + a dt/2. Spins likewise.
//!
//! Velocity Verlet with the dashpot evaluated at the half-step velocity (half kick, drift, half kick) is the same map: two
//! half kicks in a row by the same acceleration are one kick. Only its start differs: there the half-step velocity is
//! v - a dt/2 of the given one, where Euler takes the given one itself.
//!
//! The implicit dashpot changes the forces, not the step: see `implicit`.
//!
//! Blocks of discs move side by side. First all edges are found, while every disc stands still; then each block finds the
//! rest of its forces and moves its own discs, which no other block looks at.

use crate::dem::discs::Discs;
use crate::dem::forces::contact::{self, Contact, Partner};
use crate::dem::forces::implicit;
use crate::dem::forces::{ContactSums, EdgeForces, Forces, Own, Scene};
use crate::dem::integrate;
use crate::dem::motion;
use crate::dem::neighbors::near_pairs::Near;
use crate::dem::neighbors::pair_search::Finders;
use crate::dem::neighbors::{BLOCK, Block, Neighbors};
use crate::dem::parameters::Parameters;
use crate::dem::turn;
use crate::sum::CompensatedSum;
use rayon::prelude::*;

/// Blocks are moved in at most so many groups, of at least two; a group shares memory that stays in the cache.
const GROUPS: usize = 64;

/// Memory of a step. It is no part of the state.
#[derive(Clone, Debug, Default)]
pub(super) struct Workspace {
    /// Forces at the edges of each block.
    edges: Vec<EdgeForces>,
    /// Near pairs of each block.
    near: Vec<Near>,
    /// Forces on the discs of the block that a group is at.
    forces: Vec<Forces>,
    /// Forces with implicit dashpots on the discs of each block; empty with explicit ones.
    solved: Vec<Forces>,
    /// For building lists between steps.
    pub(super) finders: Finders,
}

/// What a step, or the discs of one block in it, did.
#[derive(Clone, Debug, Default)]
pub(super) struct Moved {
    /// Power taken by the dashpots, W.
    pub(super) dashpot_power: f64,
    /// Sums over contacts.
    pub(super) contacts: ContactSums,
    /// Bound of the largest speed after the kick, squared, m^2/s^2.
    pub(super) fastest_squared: f64,
    /// Where the first disc that left the box stands in memory.
    pub(super) outside: Option<usize>,
}

/// What can't go on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum BlowUp {
    /// A disc, by its place in memory, and its partner overlapped by so many of the smaller radius, more than one.
    Overlap(u32, Partner, f64),
    /// A disc's center is outside the box, or no number; its place in memory.
    Outside(usize),
    /// The ledger's residual is larger than all the energy there was, J.
    Residual(f64),
}

impl Moved {
    /// The longest way of a disc in the step, m.
    pub(super) fn longest_way(&self, time_step: f64) -> f64 {
        self.fastest_squared.sqrt() * time_step
    }

    /// Two that overlap by more than the smaller radius, or a disc that left.
    pub(super) fn blow_up(&self) -> Option<BlowUp> {
        let deepest = &self.contacts.deepest;
        let ends = deepest.ends.filter(|_| deepest.over_radius > 1.0);
        let overlap = ends.map(|(disc, who)| BlowUp::Overlap(disc, who, deepest.over_radius));
        overlap.or(self.outside.map(BlowUp::Outside))
    }

    /// Adds another block's.
    fn take(&mut self, block: &Self) {
        self.dashpot_power += block.dashpot_power;
        if block.fastest_squared > self.fastest_squared {
            self.fastest_squared = block.fastest_squared;
        }
        self.outside = self.outside.or(block.outside);
        self.contacts.add(&block.contacts);
    }

    fn of_all(blocks: &[Self]) -> Self {
        let mut whole = Self::default();
        for block in blocks {
            whole.take(block);
        }
        whole
    }
}

impl Workspace {
    /// Moves all discs on by a step.
    pub(super) fn advance(
        &mut self,
        neighbors: &mut Neighbors,
        discs: &mut Discs,
        scene: &Scene<'_>,
        parameters: &Parameters,
    ) -> Moved {
        self.solved = solved(neighbors, discs, scene, parameters);
        let blocks = &mut neighbors.blocks;
        let (count, groups) = (blocks.len(), Ord::max(blocks.len().div_ceil(GROUPS), 2));
        self.edges.resize_with(count, EdgeForces::default);
        self.near.resize_with(count, Near::default);
        self.forces.resize_with(count.div_ceil(groups), Forces::default);
        let mut moves = vec![Moved::default(); count];
        if let [block] = blocks.as_mut_slice() {
            // Small runs do without the threads' machinery.
            self.edges[0].find(block, discs, scene);
            let (solved, memory) = (self.solved.first(), &mut self.forces[0]);
            let forces = Found { solved, edges: &self.edges[0], near: &mut self.near[0], memory };
            return move_block(block, discs.own(), forces, scene, parameters);
        }
        let (edges, solved) = (&mut self.edges, &self.solved);
        let at_rest = &*discs;
        blocks
            .par_iter_mut()
            .zip(edges.par_iter_mut())
            .for_each(|(block, edges)| edges.find(block, at_rest, scene));
        blocks
            .par_iter_mut()
            .zip(discs.blocks())
            .zip(edges.par_iter())
            .zip(self.near.par_iter_mut())
            .zip(moves.par_iter_mut())
            .chunks(groups)
            .zip(self.forces.par_iter_mut())
            .with_max_len(1)
            .for_each(|(group, memory)| {
                for ((((block, own), edges), near), moved) in group {
                    let solved = solved.get(block.start / BLOCK);
                    let forces = Found { solved, edges, near, memory };
                    *moved = move_block(block, own, forces, scene, parameters);
                }
            });
        Moved::of_all(&moves)
    }
}

/// What is known of a block's forces before it moves, and memory for the rest.
struct Found<'a> {
    /// All of them, with implicit dashpots.
    solved: Option<&'a Forces>,
    edges: &'a EdgeForces,
    near: &'a mut Near,
    memory: &'a mut Forces,
}

/// Moves the discs of a block on by the forces that are solved, or else found now.
fn move_block(
    block: &mut Block,
    mut own: Own<'_>,
    Found { solved, edges, near, memory }: Found<'_>,
    scene: &Scene<'_>,
    parameters: &Parameters,
) -> Moved {
    match solved {
        Some(solved) => memory.clone_from(solved),
        None => memory.find(block, &own, edges, near, scene),
    }
    integrate::kick_and_drift(&mut own, memory, block.start, scene, parameters)
}

/// Forces with implicit dashpots, block by block; none with explicit ones.
fn solved(
    neighbors: &Neighbors,
    discs: &Discs,
    scene: &Scene<'_>,
    parameters: &Parameters,
) -> Vec<Forces> {
    if !scene.law.is_implicit {
        return Vec::new();
    }
    let mut found = Vec::new();
    contact::find(discs, scene, neighbors, &mut found);
    implicit::solve_dashpots(discs, parameters, &mut found);
    let mut forces = vec![Forces::default(); neighbors.blocks.len()];
    implicit::forces_of(&found, discs, scene, &mut forces);
    forces
}

/// Forces and accelerations at the present state, for looking at it.
#[derive(Clone, Debug, Default)]
pub(super) struct Evaluation {
    /// What all contacts come to.
    pub(super) touching: Touching,
    /// Velocities at the positions' time, v + a dt/2, m/s.
    pub(super) velocities: Vec<[f64; 2]>,
    /// Spins at the positions' time, rad/s.
    pub(super) spins: Vec<f64>,
    /// What the contacts do.
    pub(super) moved: Moved,
}

/// What all contacts come to: a large bed has no room for a list of them.
#[derive(Clone, Debug, Default)]
pub(super) struct Touching {
    /// Contacts of two discs.
    pub(super) pairs: u64,
    /// Contacts with walls.
    pub(super) walls: u64,
    /// Energy k delta^2/2 of the normal springs, J.
    pub(super) elastic: CompensatedSum,
    /// Largest overlap over the smaller radius of a contact, 0 without contacts.
    pub(super) largest_overlap: f64,
}

impl Touching {
    fn take(&mut self, contact: &Contact, stiffness: f64) {
        match contact.partner {
            Partner::Disc(_) => self.pairs += 1,
            Partner::Wall(_) => self.walls += 1,
        }
        self.elastic.add(0.5 * stiffness * contact.overlap * contact.overlap);
        if contact.overlap_over_radius > self.largest_overlap {
            self.largest_overlap = contact.overlap_over_radius;
        }
    }
}

/// Where the velocities and spins of a block's discs at the positions' time are written.
struct Seen<'a> {
    velocities: &'a mut [[f64; 2]],
    spins: &'a mut [f64],
}

impl Evaluation {
    /// Looks at the state, which stays as it is, at many blocks side by side. `on_contact` is shown all contacts, in a fixed
    /// order.
    pub(super) fn of(
        neighbors: &Neighbors,
        discs: &Discs,
        scene: &Scene<'_>,
        parameters: &Parameters,
        on_contact: &mut dyn FnMut(&Contact),
    ) -> Self {
        let mut all = Self {
            velocities: vec![[0.0; 2]; discs.len()],
            spins: vec![0.0; discs.len()],
            ..Self::default()
        };
        let solved = solved(neighbors, discs, scene, parameters);
        let seen = all.velocities.par_chunks_mut(BLOCK).zip(all.spins.par_chunks_mut(BLOCK));
        let blocks = neighbors.blocks.par_iter().zip(seen).enumerate();
        let looked = blocks.map(|(number, (block, (velocities, spins)))| {
            let seen = Seen { velocities, spins };
            look(block, discs, solved.get(number), scene, parameters, seen)
        });
        all.moved = Moved::of_all(&looked.collect::<Vec<Moved>>());
        let mut take = |contact: &Contact| {
            all.touching.take(contact, scene.law.stiffness);
            on_contact(contact);
        };
        if scene.law.is_implicit {
            let mut contacts = Vec::new();
            contact::find(discs, scene, neighbors, &mut contacts);
            implicit::solve_dashpots(discs, parameters, &mut contacts);
            contacts.iter().for_each(take);
        } else {
            for block in &neighbors.blocks {
                contact::of_block(block, discs, scene).for_each(|contact| take(&contact));
            }
        }
        all
    }
}

/// Moves a copy of a block, for what moves it.
fn look(
    block: &Block,
    discs: &Discs,
    solved: Option<&Forces>,
    scene: &Scene<'_>,
    parameters: &Parameters,
    seen: Seen<'_>,
) -> Moved {
    let (mut block, mut edges, mut memory) =
        (block.clone(), EdgeForces::default(), Forces::default());
    let here = block.start..block.start + block.len(discs);
    let (velocities, spins) = (&discs.velocities[here.clone()], &discs.spins[here.clone()]);
    let mut positions = discs.positions[here.clone()].to_vec();
    let (mut moving, mut turning) = (velocities.to_vec(), spins.to_vec());
    let (radii, masses) = (&discs.radii[here.clone()], &discs.masses[here.clone()]);
    let (inverse_masses, materials) = (&discs.inverse_masses[here.clone()], &discs.materials[here]);
    let mut own = Own {
        positions: &mut positions,
        velocities: &mut moving,
        spins: &mut turning,
        radii,
        masses,
        inverse_masses,
        materials,
    };
    match solved {
        Some(solved) => memory.clone_from(solved),
        None => {
            edges.find(&mut block, discs, scene);
            memory.find(&mut block, &own, &edges, &mut Near::default(), scene);
        }
    }
    let half = 0.5 * parameters.time_step;
    let bodies = velocities.iter().zip(inverse_masses).zip(&memory.forces);
    for (velocity, ((&[vx, vy], &inverse_mass), &[fx, fy, ..])) in
        seen.velocities.iter_mut().zip(bodies)
    {
        let a = motion::acceleration(parameters.gravity, [fx, fy], inverse_mass);
        *velocity = [vx + a[0] * half, vy + a[1] * half];
    }
    seen.spins.copy_from_slice(spins);
    let bodies = masses.iter().zip(radii);
    let friction = memory.tangential.iter().zip(&memory.rolling);
    for ((spin, (&mass, &radius)), (&tangential, &rolling)) in
        seen.spins.iter_mut().zip(bodies).zip(friction)
    {
        let [torque, _] = turn::torque(radius, tangential, rolling);
        *spin += motion::angular_acceleration(torque, mass, radius) * half;
    }
    integrate::kick_and_drift(&mut own, &mut memory, block.start, scene, parameters)
}

/// Turns the velocities of the start, at the positions' time, into those of velocity Verlet's half step before:
/// v - a dt/2. Nothing overlaps at the start, so a is gravity.
pub(super) fn set_back_by_half_a_step(discs: &mut Discs, gravity: [f64; 2], time_step: f64) {
    let half = 0.5 * time_step;
    for [vx, vy] in &mut discs.velocities {
        *vx -= gravity[0] * half;
        *vy -= gravity[1] * half;
    }
}
