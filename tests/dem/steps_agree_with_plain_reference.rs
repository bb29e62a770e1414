//! Law: every step changes the velocity of each disc by the forces of all contacts, those with images beyond periodic sides included,
//! also after the neighbor lists have been used for many steps: no contact is missed, and none counts twice.
//!
//! Source: the reference below, which compares all pairs: Cundall and Strack, Géotechnique 29 (1979) 47, f = k delta - eta v_n with
//! eta = 2 zeta sqrt(k m_eff).
//! Setup: gases from three discs to several blocks, in boxes of three shapes with every choice of periodic sides, with size ratios of 1 and 10,
//! which move so fast that the lists are rebuilt every few tens of steps; one restitution, and one damping, for all pairs.
//! Tolerance: 1e-9 of the largest force, for the rounding of v' - v.
//! Control: a reference that leaves out the images, or a contact, is rejected.

// Assertions compare within tolerances, so no bit of a run depends on these functions.
#![allow(clippy::disallowed_methods)]

use crate::scene::{
    Disc, damping, discs, gravity, non_negative, per_contact, positive, prepared, restitution,
    run_to, spring, time_step,
};
use kinetoscope_manifest::model::{
    DemConfig, DiscRadius, Dissipation, PeriodicSides, UnstableTimeStep,
};
use kinetoscope_physics::dem::restitution::damping_ratio;
use std::num::NonZeroU32;

const RADIUS: f64 = 5e-4;
const STIFFNESS: f64 = 5e4;
/// Area of the discs over that of the box.
const FRACTION: f64 = 0.3;

/// What the reference leaves out, for the control.
#[derive(Clone, Copy, PartialEq)]
enum LeftOut {
    Nothing,
    Images,
    LastContact,
}

/// A gas in a box of the given width over height.
fn gas(count: u32, aspect: f64, least_radius: f64, periodic: PeriodicSides) -> DemConfig {
    let area = f64::from(count) * std::f64::consts::PI * RADIUS * RADIUS / FRACTION;
    DemConfig {
        discs: NonZeroU32::new(count).expect("not zero"),
        radius_m: if least_radius < RADIUS {
            DiscRadius::Uniform { min: positive(least_radius), max: positive(RADIUS) }
        } else {
            crate::scene::equal(RADIUS)
        },
        width_m: positive((area * aspect).sqrt()),
        height_m: positive((area / aspect).sqrt()),
        gravity_m_per_s2: gravity(0.3, -9.81),
        elasticity: spring(STIFFNESS),
        dissipation: restitution(0.7),
        friction: non_negative(0.0),
        time_step: per_contact(20.0),
        on_unstable_time_step: UnstableTimeStep::Warn,
        periodic,
        velocity_std_m_per_s: Some(positive(0.3)),
        ..DemConfig::default()
    }
}

/// Damping of a contact, N s/m.
fn damping_of(config: &DemConfig, effective_mass: f64) -> f64 {
    match config.dissipation {
        Dissipation::Restitution(wanted) => {
            let zeta = damping_ratio(wanted.get(), config.limit_damping);
            2.0 * zeta * (STIFFNESS * effective_mass).sqrt()
        }
        Dissipation::Damping(damping) => damping.get(),
    }
}

/// The contact forces on all discs, N, and the number of contacts, by comparing all pairs.
fn forces(all: &[Disc], config: &DemConfig, left_out: LeftOut) -> (Vec<[f64; 2]>, usize) {
    let sides = [config.width_m.get(), config.height_m.get()];
    let is_periodic = config.periodic.axes();
    let (mut forces, mut last) = (vec![[0.0; 2]; all.len()], None);
    let mut contacts = 0;
    for (i, one) in all.iter().enumerate() {
        for (axis, &side) in sides.iter().enumerate().filter(|(axis, _)| !is_periodic[*axis]) {
            for (gap, sign) in [(one.position[axis], 1.0), (side - one.position[axis], -1.0)] {
                if gap < one.radius {
                    let separating = sign * one.step_velocity[axis];
                    let dashpot = damping_of(config, one.mass) * separating;
                    forces[i][axis] += sign * (STIFFNESS * (one.radius - gap) - dashpot);
                    contacts += 1;
                }
            }
        }
        for (j, other) in all.iter().enumerate().take(i) {
            let mut apart = [0, 1].map(|axis: usize| one.position[axis] - other.position[axis]);
            for axis in (0..2).filter(|&axis| is_periodic[axis] && left_out != LeftOut::Images) {
                apart[axis] -= sides[axis] * (apart[axis] / sides[axis]).round();
            }
            let distance = (apart[0] * apart[0] + apart[1] * apart[1]).sqrt();
            let overlap = one.radius + other.radius - distance;
            if overlap <= 0.0 {
                continue;
            }
            let normal = apart.map(|part| part / distance);
            let relative =
                [0, 1].map(|axis: usize| one.step_velocity[axis] - other.step_velocity[axis]);
            let separating = relative[0] * normal[0] + relative[1] * normal[1];
            let effective_mass = one.mass * other.mass / (one.mass + other.mass);
            let force = STIFFNESS * overlap - damping_of(config, effective_mass) * separating;
            for axis in 0..2 {
                forces[i][axis] += force * normal[axis];
                forces[j][axis] -= force * normal[axis];
            }
            (last, contacts) = (Some((i, j, normal.map(|part| part * force))), contacts + 1);
        }
    }
    if let (LeftOut::LastContact, Some((i, j, force))) = (left_out, last) {
        for axis in 0..2 {
            forces[i][axis] -= force[axis];
            forces[j][axis] += force[axis];
        }
    }
    (forces, contacts)
}

/// Largest |m (v' - v)/dt - m g - f| over the largest force, and the number of contacts, over steps that are `stride` apart.
fn max_relative_error(config: &DemConfig, steps: [u64; 2], left_out: LeftOut) -> (f64, usize) {
    let [end, stride] = steps;
    let mut model = prepared(config);
    let (step, gravity) = (time_step(&model), config.gravity_m_per_s2.map(|part| part.get()));
    let (mut max_error, mut max_force, mut contacts) = (0.0_f64, 0.0_f64, 0);
    for at in (0..end).step_by(stride as usize) {
        run_to(&mut model, at);
        let mut before = discs(&model);
        before.sort_by_key(|disc| disc.id);
        run_to(&mut model, at + 1);
        let mut after = discs(&model);
        after.sort_by_key(|disc| disc.id);
        let (forces, found) = forces(&before, config, left_out);
        contacts += found;
        for ((disc, moved), force) in before.iter().zip(&after).zip(forces) {
            for axis in 0..2 {
                let change = (moved.step_velocity[axis] - disc.step_velocity[axis]) / step;
                let required = disc.mass * (change - gravity[axis]);
                max_error = max_error.max((required - force[axis]).abs());
                max_force = max_force.max(required.abs());
            }
        }
    }
    (if max_force > 0.0 { max_error / max_force } else { max_error }, contacts)
}

const SIDES: [PeriodicSides; 4] =
    [PeriodicSides::None, PeriodicSides::X, PeriodicSides::Y, PeriodicSides::Both];

#[test]
fn every_step_agrees_with_the_reference() {
    let mut contacts = 0;
    for periodic in SIDES {
        for (count, aspect) in [(3, 1.0), (30, 1.0), (300, 1.0), (300, 12.0), (300, 1.0 / 12.0)] {
            for least_radius in [RADIUS, 0.1 * RADIUS] {
                let config = gas(count, aspect, least_radius, periodic);
                let (error, found) = max_relative_error(&config, [450, 9], LeftOut::Nothing);
                assert!(error < 1e-9, "{count} discs, {aspect}, {periodic:?}: {error:e}");
                contacts += found;
            }
        }
    }
    println!("{contacts} contacts");
    assert!(contacts > 5000, "{contacts}");
}

#[test]
fn steps_of_several_blocks_agree_with_the_reference() {
    for (periodic, dissipation) in [
        (PeriodicSides::None, restitution(0.7)),
        (PeriodicSides::Both, restitution(0.7)),
        (PeriodicSides::Both, damping(0.5)),
    ] {
        let config = DemConfig { dissipation, ..gas(5000, 1.0, 0.6 * RADIUS, periodic) };
        let (error, contacts) = max_relative_error(&config, [300, 60], LeftOut::Nothing);
        println!("{periodic:?}: {contacts} contacts, error {error:.1e}");
        assert!(error < 1e-9 && contacts > 1000, "{error:e}, {contacts}");
    }
}

#[test]
fn control_missing_contacts_are_rejected() {
    for left_out in [LeftOut::Images, LeftOut::LastContact] {
        let config = gas(300, 1.0, RADIUS, PeriodicSides::Both);
        assert!(max_relative_error(&config, [60, 3], left_out).0 > 1e-9);
    }
}
