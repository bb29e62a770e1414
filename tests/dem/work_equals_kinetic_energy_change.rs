//! Law: the kinetic energy changes by the work of all forces, dKE = sum F . v dt with the mid-step velocity v, and the
//! dissipated energy of the energy balance is sum (k delta - f) v_n dt over the dashpots.
//!
//! Source: m (v' - v) . (v' + v)/2 = m (v'^2 - v^2)/2, an identity. The forces are computed here independently, over
//! all pairs, from the recorded positions and the integrator's velocities; the mid-step velocities are the recorded vx,
//! vy.
//! Setup: 60 discs of mixed radii that collapse in a narrow box, 3000 steps, both tails, linear springs and spheres by Hertz's law.
//! Tolerance: 1e-11 of the sum of |work|, for the rounding of 3000 sums.
//! Control: damping larger by 1e-6 is rejected by both sums.

use crate::scene::{
    Disc, discs, energy, per_contact, positive, prepared, restitution, run_to, spring, time_step,
};
use kinetoscope_manifest::model::{DemConfig, DiscRadius, Elasticity};
use kinetoscope_physics::dem::restitution::damping_ratio;
use std::num::NonZeroU32;

const STIFFNESS: f64 = 5e4;
/// Young's modulus, Pa; Poisson's ratio is 0.3.
const MODULUS: f64 = 1e8;
const SIDE: f64 = 0.012;
const REQUESTED: f64 = 0.7;
const STEPS: u64 = 3000;

fn mass(disc: &Disc) -> f64 {
    1e-3 * disc.radius * disc.radius / (5e-4 * 5e-4)
}

/// Work of all forces in a step, energy dissipated by the dashpots, and number of contacts.
struct Step {
    work: f64,
    dissipated: f64,
    contacts: u64,
}

/// Elastic force and damping of a contact with the damping ratio zeta, by the overlap, the effective mass and the reduced radius. Those
/// of spheres are `hertz_contacts_follow_closed_forms`'s.
fn contact_law(hertz: bool, zeta: f64, overlap: f64, mass: f64, radius: f64) -> [f64; 2] {
    if !hertz {
        return [STIFFNESS * overlap, 2.0 * zeta * (STIFFNESS * mass).sqrt()];
    }
    let kappa = 4.0 / 3.0 * MODULUS / (2.0 * (1.0 - 0.09)) * radius.sqrt();
    let damping = zeta * (5.0 * mass * kappa).sqrt() * libm::pow(overlap, 0.25);
    [kappa * libm::pow(overlap, 1.5), damping]
}

/// Equation (1) of the DEM exercise for every pair and every wall. `damping_scale` is 1, except in the control.
fn step(state: &[Disc], [tail, hertz]: [bool; 2], time_step: f64, damping_scale: f64) -> Step {
    let zeta = damping_ratio(REQUESTED, tail) * damping_scale;
    let mut sum = Step { work: 0.0, dissipated: 0.0, contacts: 0 };
    let mut contact = |overlap: f64, mass: f64, radius: f64, speed: f64, mid_speed: f64| {
        if overlap <= 0.0 {
            return;
        }
        let [spring, damping] = contact_law(hertz, zeta, overlap, mass, radius);
        let mut force = spring - damping * speed;
        if tail && force < 0.0 {
            force = 0.0;
        }
        sum.work += force * mid_speed * time_step;
        sum.dissipated += (spring - force) * mid_speed * time_step;
        sum.contacts += 1;
    };
    for (index, disc) in state.iter().enumerate() {
        for other in &state[index + 1..] {
            let branch = [0, 1].map(|axis| disc.position[axis] - other.position[axis]);
            let distance = (branch[0] * branch[0] + branch[1] * branch[1]).sqrt();
            let along = |a: [f64; 2], b: [f64; 2]| {
                ((a[0] - b[0]) * branch[0] + (a[1] - b[1]) * branch[1]) / distance
            };
            contact(
                disc.radius + other.radius - distance,
                1.0 / (1.0 / mass(disc) + 1.0 / mass(other)),
                1.0 / (1.0 / disc.radius + 1.0 / other.radius),
                along(disc.step_velocity, other.step_velocity),
                along(disc.velocity, other.velocity),
            );
        }
        for axis in 0..2 {
            for (distance, sign) in [(disc.position[axis], 1.0), (SIDE - disc.position[axis], -1.0)]
            {
                let (speed, mid_speed) = (disc.step_velocity[axis], disc.velocity[axis]);
                let overlap = disc.radius - distance;
                contact(overlap, mass(disc), disc.radius, sign * speed, sign * mid_speed);
            }
        }
    }
    for disc in state {
        sum.work += -9.81 * mass(disc) * disc.velocity[1] * time_step;
    }
    sum
}

struct Outcome {
    /// |dKE - work| over the sum of |work|.
    imbalance: f64,
    /// Relative difference between the recorded dissipated energy and the sum computed here.
    dissipation_error: f64,
    /// Number of contacts, summed over the steps.
    contact_steps: u64,
}

fn outcome([tail, hertz]: [bool; 2], damping_scale: f64) -> Outcome {
    let config = DemConfig {
        discs: NonZeroU32::new(60).expect("not zero"),
        radius_m: DiscRadius::Uniform { min: positive(3e-4), max: positive(7e-4) },
        width_m: positive(SIDE),
        height_m: positive(SIDE),
        dissipation: restitution(REQUESTED),
        limit_damping: tail,
        elasticity: if hertz { Elasticity::Hertz(positive(MODULUS)) } else { spring(STIFFNESS) },
        time_step: per_contact(20.0),
        ..DemConfig::default()
    };
    let mut model = prepared(&config);
    let time_step = time_step(&model);
    let kinetic = |state: &[Disc]| -> f64 {
        let squared = |v: [f64; 2]| v[0] * v[0] + v[1] * v[1];
        state.iter().map(|disc| 0.5 * mass(disc) * squared(disc.step_velocity)).sum()
    };
    let (mut work, mut dissipated, mut throughput, mut contact_steps) = (0.0, 0.0, 0.0, 0);
    let start = kinetic(&discs(&model));
    for count in 1..=STEPS {
        let found = step(&discs(&model), [tail, hertz], time_step, damping_scale);
        work += found.work;
        throughput += found.work.abs();
        dissipated += found.dissipated;
        contact_steps += found.contacts;
        run_to(&mut model, count);
    }
    // At the time of a frame, the recorded energy includes half a step of the current power.
    let half = 0.5 * step(&discs(&model), [tail, hertz], time_step, damping_scale).dissipated;
    let end = discs(&model);
    Outcome {
        imbalance: (kinetic(&end) - start - work).abs() / throughput,
        dissipation_error: (energy(&model).dissipated_j / (dissipated + half) - 1.0).abs(),
        contact_steps,
    }
}

#[test]
fn work_of_all_forces_equals_the_change_of_kinetic_energy() {
    for law @ [tail, hertz] in [[false, false], [true, false], [false, true], [true, true]] {
        let found = outcome(law, 1.0);
        println!(
            "tail {tail}, spheres {hertz}: imbalance {:.1e}, dissipation error {:.1e}, {} contact steps",
            found.imbalance, found.dissipation_error, found.contact_steps
        );
        assert!(found.contact_steps > 10_000, "{}", found.contact_steps);
        assert!(found.imbalance < 1e-11, "{law:?}: {:e}", found.imbalance);
        assert!(found.dissipation_error < 1e-11, "{law:?}: {:e}", found.dissipation_error);
    }
}

#[test]
fn control_stronger_dashpot_is_rejected() {
    for hertz in [false, true] {
        let found = outcome([false, hertz], 1.0 + 1e-6);
        assert!(found.imbalance > 1e-9, "{:e}", found.imbalance);
        assert!(found.dissipation_error > 1e-9, "{:e}", found.dissipation_error);
    }
}
