//! Law: the corrected scheme keeps every particle inside at constant speed, and the wall pressure is N m <v^2> / (2A).
//! The text of the gas exercise violates this in nine places; each test shows one of them and that it is detected.
//!
//! Source: gas exercise 14g1; the numbers of the defects follow its steps. Single steps: 50-digit arithmetic.
//! Setup: the corrected scheme (`stepped`, `exact`) and the scheme as printed (`literal`) on the same particles.
//! Tolerance: 1e-14 for single steps; four standard errors, derived at each test, for counts.
//! Control: the scheme as printed.

// Tests compare with the platform's functions and do not affect recorded bits; reference values keep all their digits.
#![allow(clippy::disallowed_methods, clippy::excessive_precision)]

use crate::runs::{
    advance, channel, count, exercise, frame, gas, given, kelvin, max_difference, max_speed,
    particles, positive,
};
use kinetoscope_manifest::model::{GasConfig, Propagation, SpeedDistribution};
use kinetoscope_manifest::quantity::Finite;
use kinetoscope_physics::gas::as_printed::step_as_printed;
use kinetoscope_physics::gas::motion::{Particle, drifted, reflected, time_to_wall};
use kinetoscope_physics::gas::time_stepped;
use kinetoscope_physics::model::Target;
use kinetoscope_recording::channels::{
    GasCollisions, GasInvariants, GasPressure, GasSpeeds, GasTemperature,
};
use kinetoscope_recording::frame::Level;
use std::f64::consts::PI;

const ORIGIN: [f64; 2] = [0.0, 0.0];

/// A particle, and its time to the wall, collision point and reflected velocity (50-digit arithmetic).
const START: Particle = Particle { position: [0.9, 0.1], velocity: [0.3, 0.2] };
const TO_WALL: f64 = 0.29132250934692332782;
const COLLISION: [f64; 2] = [0.98739675280407699835, 0.15826450186938466556];
const REFLECTED: [f64; 2] = [-0.34747935056081539967, 0.096219025841223099504];

fn printed(time_step_s: f64, config: GasConfig) -> GasConfig {
    GasConfig {
        propagation: Propagation::AsPrinted { time_step_s: positive(time_step_s) },
        ..config
    }
}

fn corrected(time_step_s: f64, config: GasConfig) -> GasConfig {
    GasConfig {
        propagation: Propagation::TimeStepped { time_step_s: positive(time_step_s) },
        ..config
    }
}

/// Number of particles outside after a number of steps.
fn outside(config: &GasConfig, steps: u64) -> u64 {
    let mut gas = gas(config, 14);
    advance(&mut gas, Target::Count(steps));
    channel::<GasInvariants>(&gas).particles_outside
}

#[test]
fn defect_1_the_rest_of_a_step_is_dt_minus_u() {
    let time_step = 0.5;
    let rest = time_step - TO_WALL;
    let expected = [COLLISION[0] + rest * REFLECTED[0], COLLISION[1] + rest * REFLECTED[1]];
    let end = time_stepped::step(START, 1.0, time_step).particle;
    assert!(max_difference(end.position, expected) < 1e-14);
    let control = step_as_printed(START, ORIGIN, 1.0, time_step).particle;
    assert!(max_difference(control.position, expected) > 0.1);
}

#[test]
fn defect_2_the_path_after_a_wall_collision_is_v_times_rest() {
    // With dt = 1, defect 1 has no effect: the printed scheme moves 1 - u METERS from the collision, the corrected one
    // for 1 - u seconds.
    let path =
        |end: Particle| f64::hypot(end.position[0] - COLLISION[0], end.position[1] - COLLISION[1]);
    let speed = f64::hypot(0.3, 0.2);
    let end = time_stepped::step(START, 1.0, 1.0).particle;
    assert!((path(end) - speed * (1.0 - TO_WALL)).abs() < 1e-14);
    let control = step_as_printed(START, ORIGIN, 1.0, 1.0).particle;
    assert!((path(control) - (1.0 - TO_WALL)).abs() < 1e-14);
    // The velocity is correct in both schemes.
    assert!(max_difference(end.velocity, REFLECTED) < 1e-14);
    assert!(max_difference(control.velocity, REFLECTED) < 1e-14);
    // The gas of the exercise at 300 K: all particles that reach the wall are moved by a meter, outside if their chord
    // is shorter. Half chords have the density (4/pi) C^2 / sqrt(1 - C^2); the fraction 1 - (2/pi) (pi/3 + sqrt(3)/4)
    // is below 1/2 m.
    let config = GasConfig { particles: count(20_000), ..exercise() };
    let kept = outside(&corrected(5e-5, config.clone()), 2000);
    let lost = outside(&printed(5e-5, config), 2000) as f64;
    let fraction = 1.0 - 2.0 / PI * (PI / 3.0 + 3.0_f64.sqrt() / 4.0);
    let expected = fraction * 20_000.0;
    println!("outside of 20,000: corrected {kept}, as printed {lost}, theory {expected}");
    assert_eq!(kept, 0);
    // One particle in 200 is too slow to reach the wall.
    let standard_error = (fraction / 20_000.0).sqrt();
    assert!((lost / 20_000.0 - fraction).abs() < 4.0 * standard_error + 0.005 * fraction);
}

#[test]
fn defect_3_the_reflection_refers_to_the_center_not_the_origin() {
    // Speed 1 and dt = 1: defects 1 and 2 have no effect. The runs differ only in the center.
    let unit = |center: [f64; 2]| GasConfig {
        radius_m: positive(20.0),
        center_m: center.map(|axis| Finite::new(axis).unwrap()),
        speed_distribution: SpeedDistribution::Equal,
        speed_scale: max_speed(1.0),
        duration_s: positive(1000.0),
        ..exercise()
    };
    let far = [30.0, 10.0];
    let lost_at_origin = outside(&printed(1.0, unit(ORIGIN)), 1000);
    let lost = outside(&printed(1.0, unit(far)), 1000);
    let kept = outside(&corrected(1.0, unit(far)), 1000);
    println!(
        "outside of 1000: printed {lost_at_origin} at the origin, {lost} elsewhere; corrected {kept}"
    );
    assert_eq!(kept, 0);
    assert!(lost_at_origin < 10);
    assert!(lost > 900);
    // One step: the corrected reflection is the same for every center, the printed one is not.
    let start = Particle { position: [19.5, 3.0], velocity: [0.8, 0.6] };
    let expected = time_stepped::step(start, 20.0, 1.0).particle.velocity;
    let at_origin = step_as_printed(start, ORIGIN, 20.0, 1.0).particle.velocity;
    let elsewhere = step_as_printed(start, far, 20.0, 1.0).particle.velocity;
    assert!(max_difference(at_origin, expected) < 1e-12);
    assert!(max_difference(elsewhere, expected) > 0.1);
}

#[test]
fn defect_4_radial_collisions_and_particles_on_the_wall_or_at_rest_are_defined() {
    let starts = [([0.5, 0.0], [1.0, 0.0]), ([1.0, 0.0], [1.0, 0.0]), ([0.25, 0.0], [0.0, 0.0])];
    let mut good = gas(&corrected(1.0, given(&starts)), 1);
    advance(&mut good, Target::Count(1));
    let ends = particles(&good);
    for (end, expected) in ends.iter().zip([[0.5, 0.0], [0.0, 0.0], [0.25, 0.0]]) {
        assert!(max_difference(end.position, expected) < 1e-15);
    }
    // As printed, the first is 0/0 and the second has no root: both are counted as lost, reported, and keep finite
    // positions.
    let mut control = gas(&printed(1.0, given(&starts)), 1);
    advance(&mut control, Target::Count(1));
    assert_eq!(channel::<GasInvariants>(&control).particles_outside, 2);
    let frame = frame(&control);
    assert!(frame.state().iter().all(|value| value.is_finite()));
    assert!(
        frame
            .log_lines()
            .iter()
            .any(|line| line.level == Level::Warning && line.text.contains("outside"))
    );
    assert_eq!(particles(&control)[0].position, [0.5, 0.0]);
}

/// The corrected step with at most one reflection.
fn one_reflection(particle: Particle, radius: f64, time_step: f64) -> Particle {
    let to_wall = time_to_wall(particle, radius);
    if to_wall >= time_step {
        drifted(particle, time_step)
    } else {
        drifted(reflected(drifted(particle, to_wall)), time_step - to_wall)
    }
}

#[test]
fn defect_5_a_step_reflects_at_every_wall_collision() {
    // Fraction of steps with two or more wall collisions, in the uniform isotropic state, for a step of length l = s
    // dt. Half chords have the density (4/pi) C^2 / sqrt(1 - C^2) (R = 1), and the first collision is uniform along a
    // chord 2C: the integral of min(1, (l - 2C) / 2C) up to 2C = l; l^3 / (16 pi) for small l.
    let length = 0.4;
    let slices = 100_000;
    let width = length / 2.0 / f64::from(slices);
    let fraction: f64 = (0..slices)
        .map(|slice| {
            let half = (f64::from(slice) + 0.5) * width;
            let twice = f64::min(1.0, (length - 2.0 * half) / (2.0 * half));
            4.0 / PI * half * half / (1.0 - half * half).sqrt() * twice * width
        })
        .sum();
    let config = GasConfig {
        particles: count(400_000),
        speed_distribution: SpeedDistribution::Equal,
        speed_scale: max_speed(1.0),
        ..exercise()
    };
    let starts = particles(&gas(&config, 5));
    let is_outside =
        |particle: &Particle| f64::hypot(particle.position[0], particle.position[1]) > 1.0 + 1e-9;
    let control =
        starts.iter().filter(|&&start| is_outside(&one_reflection(start, 1.0, length))).count();
    let expected = fraction * 400_000.0;
    println!("outside after one step with one reflection: {control}, theory {expected:.0}");
    assert!((control as f64 - expected).abs() < 4.0 * expected.sqrt());
    let kept = starts
        .iter()
        .filter(|&&start| is_outside(&time_stepped::step(start, 1.0, length).particle))
        .count();
    assert_eq!(kept, 0);
}

#[test]
fn defect_6_formula_12_requires_the_mean_square_speed() {
    // 300 K in the definition of the exercise: the wall pressure is 4/3 of (12), for uniform speeds.
    let mut hot = gas(&GasConfig { particles: count(20_000), ..exercise() }, 6);
    advance(&mut hot, Target::Time(0.1));
    let pressure = channel::<GasPressure>(&hot);
    let temperature = channel::<GasTemperature>(&hot);
    let ratio = pressure.measured_since_start_n_per_m / pressure.mean_speed_formula_n_per_m;
    println!("measured over (12): {ratio}; {} K", temperature.mean_square_temperature_k);
    // 4/3 is <v^2>/<v>^2: its standard error from 20,000 speeds is the fraction sqrt(2/15/N), by the moments of uniform
    // numbers; the wall's own R/(v_rms T sqrt(2N)) is 0.00005.
    assert!((ratio / (4.0 / 3.0) - 1.0).abs() < 4.0 * (2.0 / 15.0 / 20_000.0_f64).sqrt());
    assert!((temperature.mean_speed_temperature_k - 300.0).abs() < 1e-10);
    assert!((pressure.pressure_over_mean_square_formula - 1.0).abs() < 4.0 * 0.00005);
    let first = frame(&gas(&exercise(), 6));
    assert!(first.log_lines().iter().any(|line| line.text.contains("300 K here is")));
}

#[test]
fn defect_7_the_mean_speed_is_not_the_magnitude_of_the_mean_velocity() {
    let temperature = channel::<GasTemperature>(&gas(&exercise(), 7));
    // |mean of v| has the mean square <v^2> / N.
    let fluctuation = temperature.rms_speed_m_per_s / 1000.0_f64.sqrt();
    assert!(temperature.mean_velocity_m_per_s < 3.0 * fluctuation);
    assert!(temperature.mean_velocity_m_per_s > 0.0);
    // Mean |v| at 300 K by (13), sqrt(2 k_B T / m): 50-digit arithmetic.
    assert!((temperature.mean_speed_m_per_s / 910.161963608676 - 1.0).abs() < 1e-12);
}

#[test]
fn defect_8_masses_are_kilograms_and_areas_square_meters() {
    // 1e-23 g = 1e-26 kg; grams together with J/K would reduce speeds by sqrt(1000).
    assert_eq!(exercise().mass_kg.get(), 1e-26);
    let config = GasConfig { speed_scale: kelvin(300.0), ..exercise() };
    let pressure = channel::<GasPressure>(&gas(&config, 8));
    // N k_B T / A = 1000 * 1.380658e-23 * 300 / pi N/m.
    assert!((pressure.ideal_gas_n_per_m / 1.31843127251622e-18 - 1.0).abs() < 1e-13);
    assert!((pressure.mean_speed_formula_n_per_m / 1.31843127251622e-18 - 1.0).abs() < 1e-13);
}

#[test]
fn defect_9_without_collisions_speeds_are_constant_and_only_a_uniform_state_is_stationary() {
    // The histogram after thousands of wall collisions equals the initial histogram.
    let mut unchanged = gas(&exercise(), 9);
    let before = channel::<GasSpeeds>(&unchanged);
    advance(&mut unchanged, Target::Time(0.1));
    assert!(channel::<GasCollisions>(&unchanged).wall_collisions > 10_000);
    assert_eq!(channel::<GasSpeeds>(&unchanged).density, before.density);
    // Fraction of particles inside r/2, for the uniform initial state and for one with radius uniform in [0, r] (the
    // control).
    let fraction = |particles: &[Particle]| {
        let inside = |p: &&Particle| f64::hypot(p.position[0], p.position[1]) < 0.5;
        particles.iter().filter(inside).count() as f64 / particles.len() as f64
    };
    let config = GasConfig {
        particles: count(20_000),
        speed_scale: max_speed(1.0),
        duration_s: positive(1000.0),
        ..exercise()
    };
    let mut uniform = gas(&config, 9);
    let starts = particles(&uniform);
    let uniform_in_radius: Vec<_> = starts
        .iter()
        .map(|p| {
            // |p| = sqrt(U) for a uniform U; multiplied by |p|, it is U.
            let distance = f64::hypot(p.position[0], p.position[1]);
            (p.position.map(|axis| axis * distance), p.velocity)
        })
        .collect();
    let mut control = gas(&given(&uniform_in_radius), 9);
    let first = [fraction(&starts), fraction(&particles(&control))];
    advance(&mut uniform, Target::Time(1000.0));
    advance(&mut control, Target::Time(1000.0));
    let later = [fraction(&particles(&uniform)), fraction(&particles(&control))];
    println!(
        "inside r/2: uniform {} then {}, control {} then {}",
        first[0], later[0], first[1], later[1]
    );
    // Four standard errors sqrt(q (1 - q) / N). The control approaches the mean of sqrt((1/4 - d^2) / (1 - d^2)), the
    // fraction of a chord inside r/2, over d = U sin(angle): 0.3281 by quadrature.
    let error = 4.0 * (0.25 * 0.75 / 20_000.0_f64).sqrt();
    assert!((first[0] - 0.25).abs() < error);
    assert!((later[0] - 0.25).abs() < error);
    assert!((first[1] - 0.5).abs() < 2.0 * error);
    assert!((later[1] - 0.3281).abs() < 2.0 * error);
}
