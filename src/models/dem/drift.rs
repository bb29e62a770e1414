//! Kick and drift of a block's discs, two at a time, so that the compiler can use wide instructions.

use super::forces::{Forces, Own, Scene};
use super::motion;
use super::parameters::Parameters;
use super::step::Moved;
use super::turn;
use crate::vector_width::{self, Kernel};

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
    let flies_free = gravity == [0.0; 2] && forces.touched.are_few(own.states.len());
    let sums = if flies_free {
        fly_free(own, forces, time_step)
    } else {
        vector_width::run(Drift {
            states: own.states,
            inverse_masses: own.inverse_masses,
            forces: &mut forces.forces,
            gravity,
            time_step,
        })
    };
    let Sums { dashpot_power: power, fastest_squared: fastest } = sums;
    let dashpot_power = (power[0] + power[2]) + (power[1] + power[3]);
    let larger = |a: f64, b: f64| if a > b { a } else { b };
    let mut moved = Moved {
        dashpot_power: dashpot_power + turn::turn(own, forces, time_step),
        contacts: forces.sums.clone(),
        fastest_squared: larger(fastest[0], fastest[1]),
        outside: None,
    };
    // Where a place is no number, a velocity is none, and the power neither.
    let bound = scene.scope.moved + moved.longest_way(time_step);
    if bound >= scene.scope.clearance || dashpot_power.is_nan() {
        let left = own.states.iter().position(|&[x, y, ..]| !parameters.is_inside([x, y]));
        moved.outside = left.map(|disc| start + disc);
    }
    moved
}

/// The loop over a block.
struct Drift<'a> {
    states: &'a mut [[f64; 4]],
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
        let [_, _, vx, vy] = &mut own.states[disc];
        let [fx, fy, dx, dy] = std::mem::take(&mut forces.forces[disc]);
        let [ax, ay] = motion::acceleration([0.0; 2], [fx, fy], own.inverse_masses[disc]);
        let [x, y] = power[disc % 2];
        power[disc % 2] = [x + dx * (*vx + ax * half), y + dy * (*vy + ay * half)];
        (*vx, *vy) = (*vx + ax * time_step, *vy + ay * time_step);
    }
    let fastest_squared = vector_width::run(Flight { states: own.states, time_step });
    let [[x, y], [other_x, other_y]] = power;
    Sums { dashpot_power: [x, y, other_x, other_y], fastest_squared: [fastest_squared, 0.0] }
}

/// Free flight of all discs of a block.
struct Flight<'a> {
    states: &'a mut [[f64; 4]],
    time_step: f64,
}

impl Kernel for Flight<'_> {
    /// The largest square of a speed, m^2/s^2.
    type Output = f64;

    #[inline(always)]
    fn run(self) -> f64 {
        let time_step = self.time_step;
        let mut tops = [0.0; 4];
        let (fours, last) = self.states.as_chunks_mut::<4>();
        for four in fours {
            let squared = four.each_mut().map(|state| fly(state, time_step));
            tops = each(|at| if squared[at] > tops[at] { squared[at] } else { tops[at] });
        }
        let mut top = 0.0;
        let rest = last.iter_mut().map(|state| fly(state, time_step));
        for squared in rest.chain(tops) {
            top = if squared > top { squared } else { top };
        }
        top
    }
}

/// Moves a disc on at its velocity, and returns the square of its speed, m^2/s^2.
///
/// The velocity is not written: a row of 32 bytes that is written whole took 1.7 as long.
#[inline(always)]
fn fly(state: &mut [f64; 4], time_step: f64) -> f64 {
    let [x, y, vx, vy] = *state;
    (state[0], state[1]) = (x + vx * time_step, y + vy * time_step);
    vx * vx + vy * vy
}

#[inline(always)]
fn larger_of_each(one: [f64; 2], other: [f64; 2]) -> [f64; 2] {
    let larger = |one: f64, other: f64| if one > other { one } else { other };
    [larger(one[0], other[0]), larger(one[1], other[1])]
}

/// Sums over every other disc, axis by axis: their order does not depend on how many are taken at a time.
struct Sums {
    /// Power taken by the dashpots, W.
    dashpot_power: Pair,
    /// Largest squares of the speeds after the kick, m^2/s^2.
    fastest_squared: [f64; 2],
}

#[inline(always)]
fn each(value: impl Fn(usize) -> f64) -> Pair {
    [value(0), value(1), value(2), value(3)]
}

impl Sums {
    /// Two discs.
    #[inline(always)]
    fn move_on(
        &mut self,
        gravity: [f64; 2],
        time_step: f64,
        states: &mut [[f64; 4]; 2],
        inverse_masses: [f64; 2],
        forces: &mut [[f64; 4]; 2],
    ) {
        let half = 0.5 * time_step;
        let [[x, y, vx, vy], [other_x, other_y, other_vx, other_vy]] = *states;
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
        *states = [[x[0], x[1], v[0], v[1]], [x[2], x[3], v[2], v[3]]];
    }
}

impl Kernel for Drift<'_> {
    type Output = Sums;

    #[inline(always)]
    fn run(self) -> Sums {
        let (gravity, time_step) = (self.gravity, self.time_step);
        let mut sums = Sums { dashpot_power: [0.0; 4], fastest_squared: [0.0; 2] };
        let (states, last_state) = self.states.as_chunks_mut::<2>();
        let (inverse_masses, last_mass) = self.inverse_masses.as_chunks::<2>();
        let (forces, last_force) = self.forces.as_chunks_mut::<2>();
        for ((states, &inverse), forces) in states.iter_mut().zip(inverse_masses).zip(forces) {
            sums.move_on(gravity, time_step, states, inverse, forces);
        }
        if let ([state], [inverse], [force]) = (last_state, last_mass, last_force) {
            // The last disc, with a copy that takes no power.
            let [fx, fy, ..] = *force;
            let mut states = [*state, *state];
            let mut forces = [*force, [fx, fy, 0.0, 0.0]];
            sums.move_on(gravity, time_step, &mut states, [*inverse, *inverse], &mut forces);
            (*state, *force) = (states[0], forces[0]);
        }
        sums
    }
}
