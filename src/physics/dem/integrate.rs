//! Kick and drift of a block's discs: v' = v + a dt, x' = x + v' dt, and w' = w + alpha dt with friction.
//!
//! Loops are written for any width of instructions. Sums run over a fixed number of lanes, so their bits do not depend on it.

use super::block::BlockDiscs;
use super::motion;
use super::parameters::{Parameters, StepContext};
use super::totals::{BlockForces, StepTotals};
use crate::simd::registers::{self, InstructionSet, Kernel, Register as _, each, vectorized};

/// Numbers of two discs, x and y of the first, then of the second.
type TwoDiscs = [f64; 4];

/// Discs whose powers are summed separately; their sum does not depend on the width of instructions.
const LANES: usize = 4;

/// Moves the discs of a block by a step. The forces are left at zero, for the next step.
pub(super) fn kick_and_drift(
    discs: &mut BlockDiscs<'_>,
    forces: &mut BlockForces,
    step: &StepContext<'_>,
) -> StepTotals {
    let Parameters { gravity, time_step, .. } = *step.parameters;
    let is_free_flight = gravity == [0.0; 2] && forces.mask.is_sparse(discs.positions.len());
    let sums = if is_free_flight {
        fly(discs, forces, time_step)
    } else {
        let BlockDiscs { positions, velocities, inverse_masses, .. } = discs;
        drift(positions, velocities, inverse_masses, &mut forces.forces, gravity, time_step)
    };
    let Sums { dashpot_power: power, fastest_squared: fastest } = sums;
    let dashpot_power = (power[0] + power[2]) + (power[1] + power[3]);
    let mut totals = StepTotals {
        dashpot_power: dashpot_power + rotate(discs, forces, time_step),
        contacts: forces.sums.clone(),
        fastest_squared: fastest[0].larger(fastest[1]),
        outside: None,
    };
    // If a position is not a number, neither is its velocity, nor the power.
    let bound = step.scope.moved + totals.max_displacement(time_step);
    if bound >= step.scope.clearance || dashpot_power.is_nan() {
        let is_outside = |&position: &[f64; 2]| !step.parameters.is_inside(position);
        totals.outside = discs.positions.iter().position(is_outside).map(|disc| discs.start + disc);
    }
    totals
}

/// The same as [`drift`] without gravity and with few discs in contact: the others only drift.
fn fly(discs: &mut BlockDiscs<'_>, forces: &mut BlockForces, time_step: f64) -> Sums {
    let half = 0.5 * time_step;
    // Of the even discs, and of the odd ones.
    let mut power = [[0.0; 2]; 2];
    let BlockForces { forces, mask, .. } = forces;
    mask.for_each(|disc| {
        let [vx, vy] = &mut discs.velocities[disc];
        let [fx, fy, dx, dy] = std::mem::take(&mut forces[disc]);
        let [ax, ay] = motion::acceleration([0.0; 2], [fx, fy], discs.inverse_masses[disc]);
        let [x, y] = power[disc % 2];
        power[disc % 2] = [x + dx * (*vx + ax * half), y + dy * (*vy + ay * half)];
        (*vx, *vy) = (*vx + ax * time_step, *vy + ay * time_step);
    });
    let (positions, velocities) = (&mut *discs.positions, &*discs.velocities);
    let fastest_squared = registers::run(FreeFlight { positions, velocities, time_step }, LANES);
    let [[x, y], [other_x, other_y]] = power;
    Sums { dashpot_power: [x, y, other_x, other_y], fastest_squared: [fastest_squared, 0.0] }
}

#[inline(always)]
fn larger_of_each(one: [f64; 2], other: [f64; 2]) -> [f64; 2] {
    [one[0].larger(other[0]), one[1].larger(other[1])]
}

/// Sums over every other disc, axis by axis: their order does not depend on the width of instructions.
struct Sums {
    /// Power taken by the dashpots, W.
    dashpot_power: TwoDiscs,
    /// Largest squares of the speeds after the kick, m^2/s^2.
    fastest_squared: [f64; 2],
}

impl Sums {
    /// Moves two discs, and adds theirs.
    #[inline(always)]
    fn move_two(
        &mut self,
        gravity: [f64; 2],
        time_step: f64,
        positions: &mut [[f64; 2]; 2],
        velocities: &mut [[f64; 2]; 2],
        inverse_masses: [f64; 2],
        forces: &mut [[f64; 4]; 2],
    ) {
        let half = 0.5 * time_step;
        let [[x, y], [other_x, other_y]] = *positions;
        let [[vx, vy], [other_vx, other_vy]] = *velocities;
        let (centers, before) = ([x, y, other_x, other_y], [vx, vy, other_vx, other_vy]);
        let [[fx, fy, dx, dy], [other_fx, other_fy, other_dx, other_dy]] = *forces;
        *forces = [[0.0; 4]; 2];
        let losses = [dx, dy, other_dx, other_dy];
        let [ax, ay] = motion::acceleration(gravity, [fx, fy], inverse_masses[0]);
        let [other_ax, other_ay] =
            motion::acceleration(gravity, [other_fx, other_fy], inverse_masses[1]);
        let a = [ax, ay, other_ax, other_ay];
        let power = self.dashpot_power;
        self.dashpot_power = each(|at| power[at] + losses[at] * (before[at] + a[at] * half));
        let v = each(|at| before[at] + a[at] * time_step);
        let x = each(|at| centers[at] + v[at] * time_step);
        let squared = each(|at| v[at] * v[at]);
        let squared = [squared[0] + squared[1], squared[2] + squared[3]];
        self.fastest_squared = larger_of_each(squared, self.fastest_squared);
        *positions = [[x[0], x[1]], [x[2], x[3]]];
        *velocities = [[v[0], v[1]], [v[2], v[3]]];
    }
}

/// Free flight of all discs of a block. Its instructions are chosen here: the loop that the compiler made took 1.45 times as long.
struct FreeFlight<'a> {
    positions: &'a mut [[f64; 2]],
    velocities: &'a [[f64; 2]],
    time_step: f64,
}

impl Kernel for FreeFlight<'_> {
    /// The largest squared speed, m^2/s^2.
    type Output = f64;

    #[inline(always)]
    fn run<const N: usize, I: InstructionSet<N>>(self, instructions: I) -> f64 {
        let Self { positions, velocities, time_step } = self;
        let step = instructions.splat(time_step);
        let mut tops = instructions.splat(0.0);
        let (groups, last) = positions.as_chunks_mut::<N>();
        let (velocities, last_velocities) = velocities.as_chunks::<N>();
        for (positions, velocities) in groups.iter_mut().zip(velocities) {
            let rows = positions.as_flattened_mut().as_chunks_mut().0;
            for (x, v) in rows.iter_mut().zip(velocities.as_flattened().as_chunks().0) {
                instructions.store(instructions.load(x) + instructions.load(v) * step, x);
            }
            let [vx, vy] = instructions.columns(velocities);
            tops = (vx * vx + vy * vy).larger(tops);
        }
        let mut lanes = [0.0; N];
        instructions.store(tops, &mut lanes);
        let mut top = lanes.into_iter().fold(0.0, |top, lane| lane.larger(top));
        for ([x, y], [vx, vy]) in last.iter_mut().zip(last_velocities) {
            (*x, *y) = (*x + vx * time_step, *y + vy * time_step);
            top = (vx * vx + vy * vy).larger(top);
        }
        top
    }
}

vectorized! {
    /// Kick and drift of all discs of a block.
    fn drift(
        positions: &mut [[f64; 2]],
        velocities: &mut [[f64; 2]],
        inverse_masses: &[f64],
        forces: &mut [[f64; 4]],
        gravity: [f64; 2],
        time_step: f64,
    ) -> Sums {
        let mut sums = Sums { dashpot_power: [0.0; 4], fastest_squared: [0.0; 2] };
        let (positions, last_position) = positions.as_chunks_mut::<2>();
        let (velocities, last_velocity) = velocities.as_chunks_mut::<2>();
        let (inverse_masses, last_mass) = inverse_masses.as_chunks::<2>();
        let (forces, last_force) = forces.as_chunks_mut::<2>();
        let states = positions.iter_mut().zip(velocities);
        for (((x, v), &inverse), f) in states.zip(inverse_masses).zip(forces) {
            sums.move_two(gravity, time_step, x, v, inverse, f);
        }
        if let ([position], [velocity], [inverse], [force]) =
            (last_position, last_velocity, last_mass, last_force)
        {
            // The last disc, with a copy without power.
            let [fx, fy, ..] = *force;
            let (mut x, mut v) = ([*position; 2], [*velocity; 2]);
            let mut f = [*force, [fx, fy, 0.0, 0.0]];
            sums.move_two(gravity, time_step, &mut x, &mut v, [*inverse; 2], &mut f);
            (*position, *velocity, *force) = (x[0], v[0], f[0]);
        }
        sums
    }

    /// Rotates all discs of a block, and returns the power that dashpots take from every fourth one, W. Torques are left at zero.
    fn rotation(
        spins: &mut [f64],
        masses: &[f64],
        radii: &[f64],
        torques: &mut [[f64; 2]],
        time_step: f64,
    ) -> FourDiscs {
        let mut power = [0.0; LANES];
        let (spins, last_spins) = spins.as_chunks_mut::<LANES>();
        let (masses, last_masses) = masses.as_chunks::<LANES>();
        let (radii, last_radii) = radii.as_chunks::<LANES>();
        let (torques, last_torques) = torques.as_chunks_mut::<LANES>();
        let bodies = spins.iter_mut().zip(masses).zip(radii);
        for (((spins, &masses), &radii), torques) in bodies.zip(torques) {
            let torques = std::mem::take(torques);
            let taken = rotate_four(spins, masses, radii, torques, time_step);
            power = each(|at| power[at] + taken[at]);
        }
        // The last discs, filled up with discs without a torque.
        let few = last_spins.len();
        let (mut spins, mut masses, mut radii) = ([0.0; LANES], [1.0; LANES], [1.0; LANES]);
        let mut torques = [[0.0; 2]; LANES];
        spins[..few].copy_from_slice(last_spins);
        masses[..few].copy_from_slice(last_masses);
        radii[..few].copy_from_slice(last_radii);
        torques[..few].swap_with_slice(last_torques);
        let taken = rotate_four(&mut spins, masses, radii, torques, time_step);
        last_spins.copy_from_slice(&spins[..few]);
        each(|at| power[at] + taken[at])
    }
}

/// Advances the spins of a block's discs by a step, and returns the power that dashpots take from them, W.
fn rotate(discs: &mut BlockDiscs<'_>, forces: &mut BlockForces, time_step: f64) -> f64 {
    let torques = &mut forces.torques;
    if torques.is_empty() {
        return 0.0;
    }
    let power = rotation(discs.spins, discs.masses, discs.radii, torques, time_step);
    (power[0] + power[2]) + (power[1] + power[3])
}

/// Numbers of the discs that are rotated at a time.
type FourDiscs = [f64; LANES];

/// Rotates four discs, and returns the power that dashpots take from each.
#[inline(always)]
fn rotate_four(
    spins: &mut FourDiscs,
    masses: FourDiscs,
    radii: FourDiscs,
    torques: [[f64; 2]; LANES],
    time_step: f64,
) -> FourDiscs {
    let half = 0.5 * time_step;
    let before = *spins;
    let alpha = each(|at| motion::angular_acceleration(torques[at][0], masses[at], radii[at]));
    *spins = each(|at| before[at] + alpha[at] * time_step);
    each(|at| torques[at][1] * (before[at] + alpha[at] * half))
}
