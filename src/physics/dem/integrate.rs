//! Kick and drift of a block's discs, two at a time, so that the compiler can use wide instructions.

use crate::dem::forces::{Forces, Own, Scene};
use crate::dem::motion;
use crate::dem::parameters::Parameters;
use crate::dem::step::Moved;
use crate::dem::turn;
use crate::simd::dispatch::{self, Kernel, each, larger};

/// Numbers of two discs, x and y of the first, then of the second.
type Pair = [f64; 4];

/// Equation (3) for the discs of a block: v' = v + a dt, x' = x + v' dt; and w' = w + alpha dt with friction. `start` is
/// where they begin in memory. The forces are left at zero, for the next step.
pub(super) fn kick_and_drift(
    own: &mut Own<'_>,
    forces: &mut Forces,
    start: usize,
    scene: &Scene<'_>,
    parameters: &Parameters,
) -> Moved {
    let Parameters { gravity, time_step, .. } = *parameters;
    let flies_free = gravity == [0.0; 2] && forces.touched.are_few(own.positions.len());
    let sums = if flies_free {
        fly_free(own, forces, time_step)
    } else {
        dispatch::run(Drift {
            positions: own.positions,
            velocities: own.velocities,
            inverse_masses: own.inverse_masses,
            forces: &mut forces.forces,
            gravity,
            time_step,
        })
    };
    let Sums { dashpot_power: power, fastest_squared: fastest } = sums;
    let dashpot_power = (power[0] + power[2]) + (power[1] + power[3]);
    let mut moved = Moved {
        dashpot_power: dashpot_power + turn::turn(own, forces, time_step),
        contacts: forces.sums.clone(),
        fastest_squared: larger(fastest[0], fastest[1]),
        outside: None,
    };
    // Where a place is no number, a velocity is none, and the power neither.
    let bound = scene.scope.moved + moved.longest_way(time_step);
    if bound >= scene.scope.clearance || dashpot_power.is_nan() {
        let left = own.positions.iter().position(|&position| !parameters.is_inside(position));
        moved.outside = left.map(|disc| start + disc);
    }
    moved
}

/// The loop over a block.
struct Drift<'a> {
    positions: &'a mut [[f64; 2]],
    velocities: &'a mut [[f64; 2]],
    inverse_masses: &'a [f64],
    forces: &'a mut [[f64; 4]],
    gravity: [f64; 2],
    time_step: f64,
}

/// The same as [`Drift`] without gravity, where nothing acts on most discs: these only move on.
fn fly_free(own: &mut Own<'_>, forces: &mut Forces, time_step: f64) -> Sums {
    let half = 0.5 * time_step;
    // Of even discs, and of odd ones.
    let mut power = [[0.0; 2]; 2];
    for disc in forces.touched.all() {
        let [vx, vy] = &mut own.velocities[disc];
        let [fx, fy, dx, dy] = std::mem::take(&mut forces.forces[disc]);
        let [ax, ay] = motion::acceleration([0.0; 2], [fx, fy], own.inverse_masses[disc]);
        let [x, y] = power[disc % 2];
        power[disc % 2] = [x + dx * (*vx + ax * half), y + dy * (*vy + ay * half)];
        (*vx, *vy) = (*vx + ax * time_step, *vy + ay * time_step);
    }
    let fastest_squared =
        dispatch::run(Flight { positions: own.positions, velocities: own.velocities, time_step });
    let [[x, y], [other_x, other_y]] = power;
    Sums { dashpot_power: [x, y, other_x, other_y], fastest_squared }
}

/// Free flight of all discs of a block.
struct Flight<'a> {
    positions: &'a mut [[f64; 2]],
    velocities: &'a [[f64; 2]],
    time_step: f64,
}

impl Kernel for Flight<'_> {
    /// The largest squares of speeds of even discs, and of odd ones, m^2/s^2.
    type Output = [f64; 2];

    #[inline(always)]
    fn run(self) -> [f64; 2] {
        let Self { positions, velocities, time_step } = self;
        let (fours, last) = positions.as_chunks_mut::<4>();
        let (velocities, last_velocities) = velocities.as_chunks::<4>();
        let mut tops = [[0.0; 2]; 2];
        for (positions, velocities) in fours.iter_mut().zip(velocities) {
            let pairs = positions.as_flattened_mut().as_chunks_mut::<4>().0.iter_mut();
            let velocities = velocities.as_flattened().as_chunks::<4>().0;
            for ((x, v), top) in pairs.zip(velocities).zip(&mut tops) {
                *x = each(|at| x[at] + v[at] * time_step);
                let squared = each(|at| v[at] * v[at]);
                *top = larger_of_each([squared[0] + squared[1], squared[2] + squared[3]], *top);
            }
        }
        let mut top = larger_of_each(tops[0], tops[1]);
        for ([x, y], [vx, vy]) in last.iter_mut().zip(last_velocities) {
            (*x, *y) = (*x + vx * time_step, *y + vy * time_step);
            top = larger_of_each([vx * vx + vy * vy, 0.0], top);
        }
        top
    }
}

#[inline(always)]
fn larger_of_each(one: [f64; 2], other: [f64; 2]) -> [f64; 2] {
    [larger(one[0], other[0]), larger(one[1], other[1])]
}

/// Sums over every other disc, axis by axis: their order does not depend on how many are taken at a time.
struct Sums {
    /// Power taken by the dashpots, W.
    dashpot_power: Pair,
    /// Largest squares of the speeds after the kick, m^2/s^2.
    fastest_squared: [f64; 2],
}

impl Sums {
    /// Two discs.
    #[inline(always)]
    fn move_on(
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
        let (places, before) = ([x, y, other_x, other_y], [vx, vy, other_vx, other_vy]);
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
        let x = each(|at| places[at] + v[at] * time_step);
        let squared = each(|at| v[at] * v[at]);
        let squared = [squared[0] + squared[1], squared[2] + squared[3]];
        self.fastest_squared = larger_of_each(squared, self.fastest_squared);
        *positions = [[x[0], x[1]], [x[2], x[3]]];
        *velocities = [[v[0], v[1]], [v[2], v[3]]];
    }
}

impl Kernel for Drift<'_> {
    type Output = Sums;

    #[inline(always)]
    fn run(self) -> Sums {
        let (gravity, time_step) = (self.gravity, self.time_step);
        let mut sums = Sums { dashpot_power: [0.0; 4], fastest_squared: [0.0; 2] };
        let (positions, last_position) = self.positions.as_chunks_mut::<2>();
        let (velocities, last_velocity) = self.velocities.as_chunks_mut::<2>();
        let (inverse_masses, last_mass) = self.inverse_masses.as_chunks::<2>();
        let (forces, last_force) = self.forces.as_chunks_mut::<2>();
        let states = positions.iter_mut().zip(velocities);
        for (((positions, velocities), &inverse), forces) in states.zip(inverse_masses).zip(forces)
        {
            sums.move_on(gravity, time_step, positions, velocities, inverse, forces);
        }
        if let ([position], [velocity], [inverse], [force]) =
            (last_position, last_velocity, last_mass, last_force)
        {
            // The last disc, with a copy that takes no power.
            let [fx, fy, ..] = *force;
            let (mut positions, mut velocities) = ([*position; 2], [*velocity; 2]);
            let mut forces = [*force, [fx, fy, 0.0, 0.0]];
            let inverse = [*inverse; 2];
            sums.move_on(gravity, time_step, &mut positions, &mut velocities, inverse, &mut forces);
            (*position, *velocity, *force) = (positions[0], velocities[0], forces[0]);
        }
        sums
    }
}
