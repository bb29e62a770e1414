//! Law: m (v' - v)/dt = sum f + m g for every disc, where f are the recorded contact forces and v, v' the integrator's
//! velocities before and after a step; each force acts on both discs of a pair with opposite signs.
//!
//! Source: Newton's second and third laws; equation (3) of the DEM exercise discretizes the second.
//! Setup: every scene of `threads_and_simd_do_not_affect_results`, with friction, moving walls and periodic sides,
//! after 1500 steps; the discs of a pair are identified by their centers, and their recorded numbers are compared with those.
//! Tolerance: 1e-9 of the largest force, for the rounding of v' - v.
//! Control: forces without their tangential part are rejected in every scene with friction.
//!
//! Law: F = m (a - g) for the recorded sum F of the forces on a disc: v + (g + F/m) dt/2 is the velocity of `/state`, and
//! v + (g + F/m) dt the next one, to the last bit.
//! Control: forces that differ by 1e-9 are rejected.

// Assertions compare within tolerances, so no bit of a run depends on these functions.
#![allow(clippy::disallowed_methods)]

use crate::scene::{Disc, SEED, discs, frame, run_to, scenes, time_step};
use kinetoscope_manifest::model::{DemConfig, PeriodicSides};
use kinetoscope_physics::dem::Dem;
use kinetoscope_physics::model::Model;
use kinetoscope_recording::channels::{DemContactForces, DemDiscForces};
use std::collections::BTreeMap;

const STEP: u64 = 1500;
/// Two recorded centers of the same disc differ by less than this fraction of its radius.
const SAME_CENTER: f64 = 1e-9;

/// Index of discs by cells of half the smallest radius, each of which contains at most one center.
struct CenterIndex<'a> {
    discs: &'a [Disc],
    side: f64,
    cells: BTreeMap<[i64; 2], usize>,
}

impl<'a> CenterIndex<'a> {
    fn new(discs: &'a [Disc]) -> Self {
        let side = 0.5 * discs.iter().fold(f64::INFINITY, |min, disc| min.min(disc.radius));
        let cell = |disc: &Disc| disc.position.map(|part| (part / side).floor() as i64);
        let cells = discs.iter().enumerate().map(|(index, disc)| (cell(disc), index)).collect();
        Self { discs, side, cells }
    }

    /// Returns the disc with this center.
    fn disc_at(&self, center: [f64; 2]) -> Option<usize> {
        let [column, row] = center.map(|part| (part / self.side).floor() as i64);
        let around = (-1..=1).flat_map(|i| (-1..=1).map(move |j| [column + i, row + j]));
        around.filter_map(|cell| self.cells.get(&cell).copied()).find(|&index| {
            let Disc { position: [x, y], radius, .. } = self.discs[index];
            (center[0] - x).hypot(center[1] - y) < SAME_CENTER * radius
        })
    }
}

/// Sum of the recorded contact forces on each disc, N, after `transform(force, branch)` of each force.
fn sums(
    recorded: &DemContactForces,
    discs: &[Disc],
    config: &DemConfig,
    transform: fn([f64; 2], [f64; 2]) -> [f64; 2],
) -> Vec<[f64; 2]> {
    let centers = CenterIndex::new(discs);
    let width = config.width_m.get();
    let mut sums = vec![[0.0; 2]; discs.len()];
    for contact in 0..recorded.from_x_m.len() {
        let from = [recorded.from_x_m[contact], recorded.from_y_m[contact]];
        let to = [recorded.to_x_m[contact], recorded.to_y_m[contact]];
        let force = [recorded.force_x_n[contact], recorded.force_y_n[contact]];
        let [fx, fy] = transform(force, [from[0] - to[0], from[1] - to[1]]);
        let first = centers.disc_at(from).expect("every force starts at the center of a disc");
        let ids = [recorded.first_id[contact], recorded.second_id[contact]];
        assert_eq!(ids[0], u64::from(discs[first].id));
        sums[first] = [sums[first][0] + fx, sums[first][1] + fy];
        let images: &[f64] =
            if config.periodic == PeriodicSides::X { &[0.0, -width, width] } else { &[0.0] };
        let partner = images.iter().find_map(|shift| centers.disc_at([to[0] + shift, to[1]]));
        assert_eq!(ids[1], u64::from(discs[partner.unwrap_or(first)].id));
        if let Some(other) = partner {
            sums[other] = [sums[other][0] - fx, sums[other][1] - fy];
        }
    }
    sums
}

/// Largest |m (v' - v)/dt - m g - sum f| over the largest force on a disc.
fn max_relative_error(config: &DemConfig, transform: fn([f64; 2], [f64; 2]) -> [f64; 2]) -> f64 {
    let mut model = Dem::prepare(config, SEED, true).expect("the scene is valid");
    run_to(&mut model, STEP);
    let recorded: DemContactForces = frame(&model).get().expect("contact forces are requested");
    let before = discs(&model);
    let forces = sums(&recorded, &before, config, transform);
    run_to(&mut model, STEP + 1);
    let after: BTreeMap<u32, Disc> = discs(&model).into_iter().map(|d| (d.id, d)).collect();
    let (step, gravity) = (time_step(&model), config.gravity_m_per_s2.map(|part| part.get()));
    let (mut max_error, mut max_force) = (0.0_f64, 0.0_f64);
    for (disc, force) in before.iter().zip(forces) {
        let Some(moved) = after.get(&disc.id) else { continue };
        for axis in [0, 1] {
            let change = (moved.step_velocity[axis] - disc.step_velocity[axis]) / step;
            let required = disc.mass * (change - gravity[axis]);
            max_error = max_error.max((required - force[axis]).abs());
            max_force = max_force.max(required.abs());
        }
    }
    assert!(max_force > 0.0, "the scene has no contacts");
    max_error / max_force
}

#[test]
fn recorded_forces_equal_mass_times_acceleration() {
    for (name, config) in scenes() {
        let complete = max_relative_error(&config, |force, _| force);
        let normal_only = max_relative_error(&config, |[fx, fy], [x, y]| {
            let normal = (fx * x + fy * y) / (x * x + y * y);
            [normal * x, normal * y]
        });
        println!("{name}: error {complete:.1e}; without tangential forces {normal_only:.1e}");
        assert!(complete < 1e-9, "{name}: {complete:e}");
        // Control.
        let has_friction = config.friction.get() > 0.0;
        assert_eq!(normal_only > 1e-9, has_friction, "{name}: {normal_only:e}");
    }
}

/// Number of velocities of `/state` that the recorded forces, times `factor`, do not give to the last bit, and of all compared.
fn velocities_that_differ(config: &DemConfig, factor: f64) -> [usize; 2] {
    let mut model = Dem::prepare(config, SEED, true).expect("the scene is valid");
    run_to(&mut model, STEP);
    let recorded: DemDiscForces = frame(&model).get().expect("forces are requested");
    let before = discs(&model);
    assert_eq!([recorded.force_x_n.len(), recorded.force_y_n.len()], [before.len(); 2]);
    run_to(&mut model, STEP + 1);
    let after: BTreeMap<u32, Disc> = discs(&model).into_iter().map(|d| (d.id, d)).collect();
    let (step, gravity) = (time_step(&model), config.gravity_m_per_s2.map(|part| part.get()));
    let mut counts = [0; 2];
    for (index, disc) in before.iter().enumerate() {
        let force = [recorded.force_x_n[index], recorded.force_y_n[index]];
        for axis in [0, 1] {
            let acceleration = gravity[axis] + force[axis] * factor * (1.0 / disc.mass);
            let [now, next] =
                [0.5 * step, step].map(|time| disc.step_velocity[axis] + acceleration * time);
            counts[0] += usize::from(now.to_bits() != disc.velocity[axis].to_bits());
            if let Some(moved) = after.get(&disc.id) {
                counts[0] += usize::from(next.to_bits() != moved.step_velocity[axis].to_bits());
            }
            counts[1] += 2;
        }
    }
    counts
}

#[test]
fn recorded_sums_of_forces_give_the_velocities_to_the_last_bit() {
    for (name, config) in scenes() {
        let [differ, compared] = velocities_that_differ(&config, 1.0);
        let [control, _] = velocities_that_differ(&config, 1.0 + 1e-9);
        println!("{name}: {differ} of {compared} velocities differ; control {control}");
        assert_eq!(differ, 0, "{name}");
        // Control.
        assert!(control > 0, "{name}");
    }
}
