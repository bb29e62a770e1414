//! Kick and drift of a block's discs, two at a time, so that the compiler can use wide instructions.

use super::forces::{Forces, Own};
use super::motion;
use super::parameters::Parameters;
use super::step::Moved;
use super::turn;
use crate::vector_width::{self, Kernel};

/// Numbers of two discs, x and y of the first, then of the second.
type Pair = [f64; 4];

/// Equation (3) for the discs of a block: v' = v + a dt, x' = x + v' dt; and w' = w + alpha dt with friction. `start` is
/// where they begin in memory.
pub(super) fn kick_and_drift(
    own: &mut Own<'_>,
    forces: &Forces,
    start: usize,
    parameters: &Parameters,
) -> Moved {
    let Parameters { sides, gravity, time_step, periodic, .. } = *parameters;
    // Discs may leave through a periodic side until they are put back when the list is built.
    let open = |axis: usize| if periodic[axis] { f64::INFINITY } else { 0.0 };
    let low = [-open(0), -open(1)];
    let high = [sides[0] + open(0), sides[1] + open(1)];
    let sums = vector_width::run(Drift {
        states: own.states,
        masses: own.masses,
        forces: &forces.forces,
        gravity,
        time_step,
    });
    let [power, fastest] = [sums.dashpot_power, sums.fastest_squared];
    let dashpot_power = (power[0] + power[2]) + (power[1] + power[3]);
    let larger = |a: f64, b: f64| if a > b { a } else { b };
    let fastest_squared = larger(fastest[0], fastest[2]) + larger(fastest[1], fastest[3]);
    let is_inside =
        |[x, y, ..]: &[f64; 4]| *x >= low[0] && *x <= high[0] && *y >= low[1] && *y <= high[1];
    let ends =
        [sums.lowest, sums.highest].map(|[x, y, other_x, other_y]| [[x, y], [other_x, other_y]]);
    let all_inside = ends.iter().flatten().all(|&[x, y]| is_inside(&[x, y, 0.0, 0.0]));
    let mut outside = None;
    // Where a place is no number, a velocity is none, and the power neither.
    if !all_inside || dashpot_power.is_nan() {
        outside = own.states.iter().position(|state| !is_inside(state)).map(|disc| start + disc);
    }
    Moved {
        dashpot_power: dashpot_power + turn::turn(own, forces, time_step),
        contacts: forces.sums.clone(),
        fastest_squared,
        outside,
    }
}

/// The loop over a block.
struct Drift<'a> {
    states: &'a mut [[f64; 4]],
    masses: &'a [f64],
    forces: &'a [[f64; 4]],
    gravity: [f64; 2],
    time_step: f64,
}

/// Sums over every other disc, axis by axis: their order does not depend on how many are taken at a time.
struct Sums {
    /// Power taken by the dashpots, W.
    dashpot_power: Pair,
    /// Largest squares of the velocities' components after the kick, m^2/s^2.
    fastest_squared: Pair,
    /// Smallest and largest coordinates after the drift, m.
    lowest: Pair,
    highest: Pair,
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
        masses: [f64; 2],
        forces: &[[f64; 4]; 2],
    ) {
        let half = 0.5 * time_step;
        let [[x, y, vx, vy], [other_x, other_y, other_vx, other_vy]] = *states;
        let (places, before) = ([x, y, other_x, other_y], [vx, vy, other_vx, other_vy]);
        let [[fx, fy, dx, dy], [other_fx, other_fy, other_dx, other_dy]] = *forces;
        let losses = [dx, dy, other_dx, other_dy];
        let [ax, ay] = motion::acceleration(gravity, [fx, fy], masses[0]);
        let [other_ax, other_ay] = motion::acceleration(gravity, [other_fx, other_fy], masses[1]);
        let a = [ax, ay, other_ax, other_ay];
        let power = self.dashpot_power;
        self.dashpot_power = each(|at| power[at] + losses[at] * (before[at] + a[at] * half));
        let v = each(|at| before[at] + a[at] * time_step);
        let x = each(|at| places[at] + v[at] * time_step);
        let squared = each(|at| v[at] * v[at]);
        let Self { fastest_squared: top, lowest: low, highest: high, .. } = *self;
        self.fastest_squared = each(|at| if squared[at] > top[at] { squared[at] } else { top[at] });
        self.lowest = each(|at| if x[at] < low[at] { x[at] } else { low[at] });
        self.highest = each(|at| if x[at] > high[at] { x[at] } else { high[at] });
        *states = [[x[0], x[1], v[0], v[1]], [x[2], x[3], v[2], v[3]]];
    }
}

impl Kernel for Drift<'_> {
    type Output = Sums;

    #[inline(always)]
    fn run(self) -> Sums {
        let (gravity, time_step) = (self.gravity, self.time_step);
        let mut sums = Sums {
            dashpot_power: [0.0; 4],
            fastest_squared: [0.0; 4],
            lowest: [f64::INFINITY; 4],
            highest: [f64::NEG_INFINITY; 4],
        };
        let (states, last_state) = self.states.as_chunks_mut::<2>();
        let (masses, last_mass) = self.masses.as_chunks::<2>();
        let (forces, last_force) = self.forces.as_chunks::<2>();
        for ((states, &masses), forces) in states.iter_mut().zip(masses).zip(forces) {
            sums.move_on(gravity, time_step, states, masses, forces);
        }
        if let ([state], [mass], [force]) = (last_state, last_mass, last_force) {
            // The last disc, with a copy that takes no power.
            let [fx, fy, ..] = *force;
            let mut states = [*state, *state];
            let forces = [*force, [fx, fy, 0.0, 0.0]];
            sums.move_on(gravity, time_step, &mut states, [*mass, *mass], &forces);
            *state = states[0];
        }
        sums
    }
}
