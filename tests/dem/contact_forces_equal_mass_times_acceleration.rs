//! Law: the contact forces that a recording tells are those that move the discs: m (v' - v)/dt = sum f + m g for every disc, v the
//! integrator's velocities before and after a step; each force acts on both of a pair, with opposite signs.
//!
//! Source: Newton's second and third laws, as the source document's equation (3) discretises the second.
//! Setup: every scene of the promise of equal bits, with friction, walls that move and periodic sides, after 1500 steps; discs of a pair
//! are found by their centers alone.
//! Tolerance: rounding of v' - v, 1e-9 of the largest force. Control: forces without their tangential part must be rejected
//! wherever discs rub.

// A test judges within tolerances: no bit of a run depends on it.
#![allow(clippy::disallowed_methods)]

use crate::scene::{Disc, SEED, discs, frame, run_to, scenes, time_step};
use kinetoscope_manifest::model::{DemConfig, PeriodicSides};
use kinetoscope_physics::dem::Dem;
use kinetoscope_physics::model::Model;
use kinetoscope_recording::channels::DemContactForces;
use std::collections::BTreeMap;

const STEP: u64 = 1500;
/// Centers told twice are nearer than this share of a disc's radius.
const SAME_PLACE: f64 = 1e-9;

/// Discs by cells of half a smallest radius: at most one in each.
struct Places<'a> {
    discs: &'a [Disc],
    side: f64,
    cells: BTreeMap<[i64; 2], usize>,
}

impl<'a> Places<'a> {
    fn of(discs: &'a [Disc]) -> Self {
        let side = 0.5 * discs.iter().fold(f64::INFINITY, |least, disc| least.min(disc.radius));
        let cell = |disc: &Disc| disc.position.map(|part| (part / side).floor() as i64);
        let cells = discs.iter().enumerate().map(|(index, disc)| (cell(disc), index)).collect();
        Self { discs, side, cells }
    }

    /// The disc whose center is there.
    fn at(&self, place: [f64; 2]) -> Option<usize> {
        let [column, row] = place.map(|part| (part / self.side).floor() as i64);
        let around = (-1..=1).flat_map(|i| (-1..=1).map(move |j| [column + i, row + j]));
        around.filter_map(|cell| self.cells.get(&cell).copied()).find(|&index| {
            let Disc { position: [x, y], radius, .. } = self.discs[index];
            (place[0] - x).hypot(place[1] - y) < SAME_PLACE * radius
        })
    }
}

/// Sum of the told forces on each disc, N, each force as `seen` has it by the direction of its branch.
fn sums(
    told: &DemContactForces,
    discs: &[Disc],
    config: &DemConfig,
    seen: fn([f64; 2], [f64; 2]) -> [f64; 2],
) -> Vec<[f64; 2]> {
    let places = Places::of(discs);
    let width = config.width_m.get();
    let mut sums = vec![[0.0; 2]; discs.len()];
    for contact in 0..told.from_x_m.len() {
        let from = [told.from_x_m[contact], told.from_y_m[contact]];
        let to = [told.to_x_m[contact], told.to_y_m[contact]];
        let force = [told.force_x_n[contact], told.force_y_n[contact]];
        let [fx, fy] = seen(force, [from[0] - to[0], from[1] - to[1]]);
        let first = places.at(from).expect("a disc is where a force begins");
        sums[first] = [sums[first][0] + fx, sums[first][1] + fy];
        let images: &[f64] =
            if config.periodic == PeriodicSides::X { &[0.0, -width, width] } else { &[0.0] };
        let partner = images.iter().find_map(|shift| places.at([to[0] + shift, to[1]]));
        if let Some(other) = partner {
            sums[other] = [sums[other][0] - fx, sums[other][1] - fy];
        }
    }
    sums
}

/// Largest |m (v' - v)/dt - m g - sum f| over the largest force on a disc.
fn misfit(config: &DemConfig, seen: fn([f64; 2], [f64; 2]) -> [f64; 2]) -> f64 {
    let mut model = Dem::prepare(config, SEED, true).expect("the scene can be run");
    run_to(&mut model, STEP);
    let told: DemContactForces = frame(&model).get().expect("forces were asked for");
    let before = discs(&model);
    let forces = sums(&told, &before, config, seen);
    run_to(&mut model, STEP + 1);
    let after: BTreeMap<u32, Disc> = discs(&model).into_iter().map(|d| (d.id, d)).collect();
    let (step, gravity) = (time_step(&model), config.gravity_m_per_s2.map(|part| part.get()));
    let (mut worst, mut largest) = (0.0_f64, 0.0_f64);
    for (disc, force) in before.iter().zip(forces) {
        let Some(moved) = after.get(&disc.id) else { continue };
        for axis in [0, 1] {
            let change = (moved.step_velocity[axis] - disc.step_velocity[axis]) / step;
            let needed = disc.mass * (change - gravity[axis]);
            worst = worst.max((needed - force[axis]).abs());
            largest = largest.max(needed.abs());
        }
    }
    assert!(largest > 0.0, "nothing touches");
    worst / largest
}

#[test]
fn told_forces_are_those_of_the_next_step() {
    for (name, config) in scenes() {
        let whole = misfit(&config, |force, _| force);
        let normal_alone = misfit(&config, |[fx, fy], [x, y]| {
            let normal = (fx * x + fy * y) / (x * x + y * y);
            [normal * x, normal * y]
        });
        println!("{name}: misfit {whole:.1e}; without friction {normal_alone:.1e}");
        assert!(whole < 1e-9, "{name}: {whole:e}");
        let rubs = config.friction.get() > 0.0;
        assert_eq!(normal_alone > 1e-9, rubs, "{name}: {normal_alone:e}");
    }
}
