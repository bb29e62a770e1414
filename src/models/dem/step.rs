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
//! Blocks of discs move side by side: each reads the old state of all and writes the new state of its own.

use super::contacts::{self, Contact};
use super::discs::Discs;
use super::drift;
use super::forces::{ContactSums, Forces, Scene};
use super::implicit;
use super::motion;
use super::neighbours::{BLOCK, Block, Neighbours};
use super::parameters::Parameters;
use rayon::prelude::*;

/// Memory of a step: forces of each block, and the state that they lead to. It is no part of the state.
#[derive(Clone, Debug, Default)]
pub(super) struct Workspace {
    forces: Vec<Forces>,
    moves: Vec<Moved>,
    states: Vec<[f64; 4]>,
    spins: Vec<f64>,
}

/// What a step, or the discs of one block in it, did.
#[derive(Clone, Debug, Default)]
pub(super) struct Moved {
    /// Power taken by the dashpots, W.
    pub(super) dashpot_power: f64,
    /// Sums over contacts.
    pub(super) contacts: ContactSums,
    /// Largest speed after the kick, squared, m^2/s^2.
    pub(super) fastest_squared: f64,
    /// Where the first disc that left the box stands in memory.
    pub(super) outside: Option<usize>,
}

/// What can't go on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum BlowUp {
    /// Two discs, or a disc and a wall, overlap by more than the smaller radius.
    Overlap(Contact),
    /// A disc's centre is outside the box, or no number; its place in memory.
    Outside(usize),
    /// The ledger's residual is larger than all the energy there was, J.
    Residual(f64),
}

impl Moved {
    /// The longest way of a disc in the step, m.
    pub(super) fn longest_way(&self, time_step: f64) -> f64 {
        self.fastest_squared.sqrt() * time_step
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
}

impl ContactSums {
    pub(super) fn add(&mut self, other: &Self) {
        self.elastic += other.elastic;
        self.friction += other.friction;
        self.rolling += other.rolling;
        self.wall_dissipation += other.wall_dissipation;
        self.walls.resize(other.walls.len(), [0.0; 3]);
        for (sum, part) in self.walls.iter_mut().zip(&other.walls) {
            *sum = [sum[0] + part[0], sum[1] + part[1], sum[2] + part[2]];
        }
        if other.largest_overlap > self.largest_overlap {
            self.largest_overlap = other.largest_overlap;
        }
    }
}

impl Workspace {
    /// Finds the forces, and the state one step later.
    pub(super) fn advance(
        &mut self,
        neighbours: &mut Neighbours,
        scene: &Scene<'_>,
        parameters: &Parameters,
    ) -> Moved {
        let discs = scene.discs;
        self.states.resize(discs.len(), [0.0; 4]);
        // Without friction no spin changes.
        let turning = if scene.law.has_friction() { discs.len() } else { 0 };
        self.spins.resize(turning, 0.0);
        self.forces.resize_with(neighbours.blocks.len(), Forces::default);
        self.moves.resize_with(neighbours.blocks.len(), Moved::default);
        let is_implicit = scene.law.is_implicit;
        if is_implicit {
            self.solve_implicit(neighbours, scene, parameters);
        }
        let work = |block: &mut Block, forces: &mut Forces, moved: &mut Moved, after| {
            if !is_implicit {
                forces.find(block, scene);
            }
            drift::kick_and_drift(moved, forces, block.start, scene, parameters, after);
        };
        let blocks = &mut neighbours.blocks;
        if let [block] = blocks.as_mut_slice() {
            let after = (self.states.as_mut_slice(), self.spins.as_mut_slice());
            work(block, &mut self.forces[0], &mut self.moves[0], after);
        } else {
            let mut spins: Vec<&mut [f64]> = self.spins.chunks_mut(BLOCK).collect();
            spins.resize_with(blocks.len(), Default::default);
            blocks
                .par_iter_mut()
                .zip(self.forces.par_iter_mut())
                .zip(self.moves.par_iter_mut())
                .zip(self.states.par_chunks_mut(BLOCK))
                .zip(spins)
                .with_max_len(1)
                .for_each(|((((block, forces), moved), states), spins)| {
                    work(block, forces, moved, (states, spins));
                });
        }
        let mut whole = Moved::default();
        for block in &self.moves {
            whole.take(block);
        }
        whole
    }

    fn solve_implicit(
        &mut self,
        neighbours: &Neighbours,
        scene: &Scene<'_>,
        parameters: &Parameters,
    ) {
        let mut found = Vec::new();
        contacts::find(scene.discs, scene.law, scene.walls, neighbours, &mut found);
        implicit::solve_dashpots(scene.discs, parameters, &mut found);
        implicit::forces_of(&found, scene, &mut self.forces);
    }

    /// Makes the state one step later the discs'.
    pub(super) fn hand_over(&mut self, discs: &mut Discs) {
        std::mem::swap(&mut discs.states, &mut self.states);
        if !self.spins.is_empty() {
            std::mem::swap(&mut discs.spins, &mut self.spins);
        }
    }
}

/// Forces and accelerations at the present state, for looking at it.
#[derive(Clone, Debug, Default)]
pub(super) struct Evaluation {
    /// All contacts, in a fixed order.
    pub(super) contacts: Vec<Contact>,
    /// Velocities at the positions' time, v + a dt/2, m/s.
    pub(super) velocities: Vec<[f64; 2]>,
    /// Spins at the positions' time, rad/s.
    pub(super) spins: Vec<f64>,
    /// What the contacts do.
    pub(super) moved: Moved,
}

impl Evaluation {
    /// Looks at the state, which stays as it is.
    pub(super) fn of(neighbours: &Neighbours, scene: &Scene<'_>, parameters: &Parameters) -> Self {
        let mut workspace = Workspace::default();
        // The springs of a copy move on.
        let mut copy = neighbours.clone();
        let moved = workspace.advance(&mut copy, scene, parameters);
        let mut found = Vec::new();
        contacts::find(scene.discs, scene.law, scene.walls, neighbours, &mut found);
        if scene.law.is_implicit {
            implicit::solve_dashpots(scene.discs, parameters, &mut found);
        }
        let half = 0.5 * parameters.time_step;
        let discs = scene.discs;
        let at_positions = |(disc, forces): (usize, &[f64; 4])| {
            let mass = discs.masses[disc];
            let a = motion::acceleration(parameters.gravity, [forces[0], forces[1]], mass);
            let v = discs.velocity(disc);
            [v[0] + a[0] * half, v[1] + a[1] * half]
        };
        let forces = workspace.forces.iter().flat_map(|block| &block.forces);
        let velocities = forces.enumerate().map(at_positions).collect();
        let mut spins = discs.spins.clone();
        let torques = workspace.forces.iter().flat_map(|block| &block.torques);
        for (disc, (spin, torque)) in spins.iter_mut().zip(torques).enumerate() {
            let (mass, radius) = (discs.masses[disc], discs.radii[disc]);
            *spin += motion::angular_acceleration(torque[0], mass, radius) * half;
        }
        Self { contacts: found, velocities, spins, moved }
    }

    /// Largest overlap over the smaller radius of a contact, 0 without contacts.
    pub(super) fn largest_overlap(&self) -> f64 {
        self.contacts.iter().fold(0.0, |largest, contact| {
            let overlap = contact.overlap_over_radius;
            if overlap > largest { overlap } else { largest }
        })
    }
}

/// Turns the velocities of the start, at the positions' time, into those of velocity Verlet's half step before:
/// v - a dt/2. Nothing overlaps at the start, so a is gravity.
pub(super) fn set_back_by_half_a_step(discs: &mut Discs, gravity: [f64; 2], time_step: f64) {
    let half = 0.5 * time_step;
    for [_, _, vx, vy] in &mut discs.states {
        *vx -= gravity[0] * half;
        *vy -= gravity[1] * half;
    }
}
