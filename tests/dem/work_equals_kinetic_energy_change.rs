//! Law: the kinetic energy changes by the work of all forces, dKE = sum F . v dt with the mid-step velocity v, and the
//! ledger's dissipated energy is what the dashpots took, sum (k delta - f) v_n dt.
//!
//! Source: m (v' - v) . (v' + v)/2 = m (v'^2 - v^2)/2, an identity; the forces are found here anew, over all pairs, from the
//! recorded positions and the integrator's velocities, and the mid-step velocities are the recorded vx, vy.
//! Setup: 60 discs of mixed radii that fall together in a narrow box, 3000 steps, both tails.
//! Tolerance: 1e-11 of the energy that went through the sum: rounding of 3000 sums.

use crate::scene::{
    Disc, discs, energy, per_contact, positive, prepared, restitution, run_to, time_step,
};
use kinetoscope_manifest::model::{DemConfig, DiscRadius, ForceTail};
use kinetoscope_physics::dem::restitution::damping_ratio;
use std::num::NonZeroU32;

const STIFFNESS: f64 = 5e4;
const SIDE: f64 = 0.012;
const WANTED: f64 = 0.7;
const STEPS: u64 = 3000;

fn mass(disc: &Disc) -> f64 {
    1e-3 * disc.radius * disc.radius / (5e-4 * 5e-4)
}

/// What all forces do in a step: their work, the dashpots' share, and how many contacts there are.
struct Step {
    work: f64,
    dissipated: f64,
    contacts: u64,
}

/// Equation (1) for every pair and every wall. `damping_scale` is 1, but in a control.
fn step(state: &[Disc], tail: ForceTail, time_step: f64, damping_scale: f64) -> Step {
    let zeta = damping_ratio(WANTED, tail) * damping_scale;
    let mut sum = Step { work: 0.0, dissipated: 0.0, contacts: 0 };
    let mut contact = |overlap: f64, mass: f64, speed: f64, mid_speed: f64| {
        if overlap <= 0.0 {
            return;
        }
        let spring = STIFFNESS * overlap;
        let mut force = spring - 2.0 * zeta * (STIFFNESS * mass).sqrt() * speed;
        if tail == ForceTail::Clamped && force < 0.0 {
            force = 0.0;
        }
        sum.work += force * mid_speed * time_step;
        sum.dissipated += (spring - force) * mid_speed * time_step;
        sum.contacts += 1;
    };
    for (index, disc) in state.iter().enumerate() {
        for other in &state[index + 1..] {
            let apart = [0, 1].map(|axis| disc.position[axis] - other.position[axis]);
            let distance = (apart[0] * apart[0] + apart[1] * apart[1]).sqrt();
            let along = |a: [f64; 2], b: [f64; 2]| {
                ((a[0] - b[0]) * apart[0] + (a[1] - b[1]) * apart[1]) / distance
            };
            contact(
                disc.radius + other.radius - distance,
                1.0 / (1.0 / mass(disc) + 1.0 / mass(other)),
                along(disc.step_velocity, other.step_velocity),
                along(disc.velocity, other.velocity),
            );
        }
        for axis in 0..2 {
            for (distance, sign) in [(disc.position[axis], 1.0), (SIDE - disc.position[axis], -1.0)]
            {
                let (speed, mid_speed) = (disc.step_velocity[axis], disc.velocity[axis]);
                contact(disc.radius - distance, mass(disc), sign * speed, sign * mid_speed);
            }
        }
    }
    for disc in state {
        sum.work += -9.81 * mass(disc) * disc.velocity[1] * time_step;
    }
    sum
}

struct Outcome {
    /// |dKE - work| over the largest of both.
    imbalance: f64,
    /// The ledger's dissipated energy against the sum found here, relative.
    dissipation_error: f64,
    contact_steps: u64,
}

fn outcome(tail: ForceTail, damping_scale: f64) -> Outcome {
    let config = DemConfig {
        discs: NonZeroU32::new(60).expect("not zero"),
        radius_m: DiscRadius::Uniform { min: positive(3e-4), max: positive(7e-4) },
        width_m: positive(SIDE),
        height_m: positive(SIDE),
        dissipation: restitution(WANTED),
        force_tail: tail,
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
        let found = step(&discs(&model), tail, time_step, damping_scale);
        work += found.work;
        throughput += found.work.abs();
        dissipated += found.dissipated;
        contact_steps += found.contacts;
        run_to(&mut model, count);
    }
    // A frame counts half a step of the power at its time.
    let half = 0.5 * step(&discs(&model), tail, time_step, damping_scale).dissipated;
    let end = discs(&model);
    Outcome {
        imbalance: (kinetic(&end) - start - work).abs() / throughput,
        dissipation_error: (energy(&model).dissipated_j / (dissipated + half) - 1.0).abs(),
        contact_steps,
    }
}

#[test]
fn the_work_of_all_forces_is_the_change_of_kinetic_energy() {
    for tail in [ForceTail::Attractive, ForceTail::Clamped] {
        let found = outcome(tail, 1.0);
        println!(
            "{tail:?}: imbalance {:.1e}, dissipation off by {:.1e}, {} contact steps",
            found.imbalance, found.dissipation_error, found.contact_steps
        );
        assert!(found.contact_steps > 10_000, "{}", found.contact_steps);
        assert!(found.imbalance < 1e-11, "{tail:?}: {:e}", found.imbalance);
        assert!(found.dissipation_error < 1e-11, "{tail:?}: {:e}", found.dissipation_error);
    }
}

/// Control: with a dashpot one part in a million stronger neither sum fits.
#[test]
fn another_dashpot_is_noticed() {
    let found = outcome(ForceTail::Attractive, 1.0 + 1e-6);
    assert!(found.imbalance > 1e-9, "{:e}", found.imbalance);
    assert!(found.dissipation_error > 1e-9, "{:e}", found.dissipation_error);
}
