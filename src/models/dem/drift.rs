//! Kick and drift of a block's discs, four at a time in columns, so that the compiler can use wide instructions.

use super::discs::Discs;
use super::forces::{Forces, Scene};
use super::motion;
use super::parameters::Parameters;
use super::step::Moved;
use crate::vector_width::{self, Kernel};

/// Discs at a time.
const LANES: usize = 4;

/// A number for each of the discs taken at a time.
type Lanes = [f64; LANES];

/// Equation (3) for the discs of a block: v' = v + a dt, x' = x + v' dt; and w' = w + alpha dt with friction. What they do
/// is written to `moved`, their new states and spins to `after`.
pub(super) fn kick_and_drift(
    moved: &mut Moved,
    forces: &Forces,
    start: usize,
    scene: &Scene<'_>,
    parameters: &Parameters,
    (states, spins): (&mut [[f64; 4]], &mut [f64]),
) {
    let own = start..start + states.len();
    let Parameters { sides, gravity, time_step, periodic, .. } = *parameters;
    // Discs may leave through a periodic side until they are put back when the list is built.
    let open = |axis: usize| if periodic[axis] { f64::INFINITY } else { 0.0 };
    let low = [-open(0), -open(1)];
    let high = [sides[0] + open(0), sides[1] + open(1)];
    let sums = vector_width::run(Drift {
        before: &scene.discs.states[own.clone()],
        masses: &scene.discs.masses[own],
        forces: &forces.forces,
        after: states,
        gravity,
        time_step,
        low,
        high,
    });
    moved.contacts.clone_from(&forces.sums);
    moved.dashpot_power = sums.dashpot_power.iter().sum();
    moved.fastest_squared =
        sums.fastest_squared.iter().fold(0.0, |top, &one| if one > top { one } else { top });
    moved.outside = None;
    if sums.outside != [0.0; LANES] {
        // No number is inside nothing.
        let is_inside =
            |[x, y, ..]: &[f64; 4]| *x >= low[0] && *x <= high[0] && *y >= low[1] && *y <= high[1];
        moved.outside = states.iter().position(|state| !is_inside(state)).map(|disc| start + disc);
    }
    moved.dashpot_power += turn(forces, start, scene.discs, time_step, spins);
}

/// w' = w + alpha dt; the power that dashpots take from the spins, W.
fn turn(forces: &Forces, start: usize, discs: &Discs, time_step: f64, spins: &mut [f64]) -> f64 {
    let half = 0.5 * time_step;
    let mut power = 0.0;
    for (disc, (spin, &[torque, loss])) in spins.iter_mut().zip(&forces.torques).enumerate() {
        let (before, mass) = (discs.spins[start + disc], discs.masses[start + disc]);
        let alpha = motion::angular_acceleration(torque, mass, discs.radii[start + disc]);
        *spin = before + alpha * time_step;
        power += loss * (before + alpha * half);
    }
    power
}

/// The loop over a block.
struct Drift<'a> {
    before: &'a [[f64; 4]],
    masses: &'a [f64],
    forces: &'a [[f64; 4]],
    after: &'a mut [[f64; 4]],
    gravity: [f64; 2],
    time_step: f64,
    /// The box.
    low: [f64; 2],
    high: [f64; 2],
}

/// Sums over every fourth disc: their order does not depend on how many are taken at a time.
#[derive(Default)]
struct Sums {
    /// Power taken by the dashpots, W.
    dashpot_power: Lanes,
    /// Largest speed after the kick, squared, m^2/s^2.
    fastest_squared: Lanes,
    /// 1 where a disc left the box.
    outside: Lanes,
}

#[inline(always)]
fn each(value: impl Fn(usize) -> f64) -> Lanes {
    [value(0), value(1), value(2), value(3)]
}

/// Rows to columns, and back.
#[inline(always)]
fn transposed(rows: &[[f64; 4]; LANES]) -> [Lanes; 4] {
    let column = |number: usize| each(|lane| rows[lane][number]);
    [column(0), column(1), column(2), column(3)]
}

impl Drift<'_> {
    /// Four discs.
    #[inline(always)]
    fn move_on(
        &self,
        states: &[[f64; 4]; LANES],
        masses: &Lanes,
        forces: &[[f64; 4]; LANES],
        sums: &mut Sums,
    ) -> [[f64; 4]; LANES] {
        let (step, half) = (self.time_step, 0.5 * self.time_step);
        let [x, y, vx, vy] = transposed(states);
        let [fx, fy, dx, dy] = transposed(forces);
        let acceleration =
            |lane: usize| motion::acceleration(self.gravity, [fx[lane], fy[lane]], masses[lane]);
        let (ax, ay) = (each(|lane| acceleration(lane)[0]), each(|lane| acceleration(lane)[1]));
        let power = each(|lane| {
            dx[lane] * (vx[lane] + ax[lane] * half) + dy[lane] * (vy[lane] + ay[lane] * half)
        });
        sums.dashpot_power = each(|lane| sums.dashpot_power[lane] + power[lane]);
        let vx = each(|lane| vx[lane] + ax[lane] * step);
        let vy = each(|lane| vy[lane] + ay[lane] * step);
        let x = each(|lane| x[lane] + vx[lane] * step);
        let y = each(|lane| y[lane] + vy[lane] * step);
        let squared = each(|lane| vx[lane] * vx[lane] + vy[lane] * vy[lane]);
        let fastest = sums.fastest_squared;
        sums.fastest_squared =
            each(|lane| if squared[lane] > fastest[lane] { squared[lane] } else { fastest[lane] });
        sums.outside = each(|lane| {
            let is_inside = (x[lane] >= self.low[0])
                & (x[lane] <= self.high[0])
                & (y[lane] >= self.low[1])
                & (y[lane] <= self.high[1]);
            if is_inside { sums.outside[lane] } else { 1.0 }
        });
        transposed(&[x, y, vx, vy])
    }
}

impl Kernel for Drift<'_> {
    type Output = Sums;

    #[inline(always)]
    fn run(self) -> Sums {
        let mut sums = Sums::default();
        let (states, states_left) = self.before.as_chunks::<LANES>();
        let (masses, masses_left) = self.masses.as_chunks::<LANES>();
        let (forces, forces_left) = self.forces.as_chunks::<LANES>();
        let whole = states.len();
        for number in 0..Ord::min(whole, Ord::min(masses.len(), forces.len())) {
            let moved = self.move_on(&states[number], &masses[number], &forces[number], &mut sums);
            self.after[number * LANES..][..LANES].copy_from_slice(&moved);
        }
        let left = states_left.len();
        if left > 0 {
            // The last discs, with copies of the very last that take no power.
            let place = |lane: usize| Ord::min(lane, left - 1);
            let states = [0, 1, 2, 3].map(|lane| states_left[place(lane)]);
            let masses = [0, 1, 2, 3].map(|lane| masses_left[place(lane)]);
            let forces = [0, 1, 2, 3].map(|lane| {
                let [fx, fy, dx, dy] = forces_left[place(lane)];
                if lane < left { [fx, fy, dx, dy] } else { [fx, fy, 0.0, 0.0] }
            });
            let moved = self.move_on(&states, &masses, &forces, &mut sums);
            self.after[whole * LANES..].copy_from_slice(&moved[..left]);
        }
        sums
    }
}
