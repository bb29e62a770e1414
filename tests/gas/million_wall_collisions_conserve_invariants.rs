//! Law: after a million wall collisions, |v| and p x v equal their initial values and no particle is outside; the
//! measured pressure is within 5 R/(v_rms T sqrt(2N)) of N m <v^2>/(2A) for any N, r, T and m. Guarantee: the number of
//! threads changes no bit.
//!
//! Source: specular reflection in a circle; kinetic theory in two dimensions (standard error: see
//! `wall_pressure_follows_mean_square_speed`).
//! Setup: given and drawn particles; 30 gases with N, r, T, m drawn over decades from a fixed stream.
//! Tolerance: 1e-12 (exact: two roundings for any number of collisions; stepped: 2^-53 per step, accumulated at
//! random); five standard errors; none for the threads.
//! Control: equation (12) of the gas exercise, with the squared mean speed, is rejected.

// Tests compare with the platform's functions and do not affect recorded bits.
#![allow(clippy::disallowed_methods, clippy::unwrap_used)]

use crate::runs::{advance, channel, count, gas, given, kelvin, particles, positive};
use kinetoscope_manifest::model::{
    GasConfig, Propagation, SpeedDistribution, TemperatureDefinition,
};
use kinetoscope_physics::model::Target;
use kinetoscope_physics::random::{Seed, Stream};
use kinetoscope_recording::channels::{GasCollisions, GasInvariants, GasPressure, GasTemperature};
use rayon::ThreadPoolBuilder;

#[test]
fn million_wall_collisions_conserve_speed_and_angular_momentum() {
    let start = given(&[([0.9, 0.1], [-0.11, 0.99])]);
    let duration = 860_000.0;
    let exact = GasConfig { duration_s: positive(duration), ..start };
    for (name, propagation, target) in [
        ("exact", Propagation::Exact, Target::Time(duration)),
        (
            "stepped",
            Propagation::TimeStepped { time_step_s: positive(0.5) },
            Target::Count(2 * duration as u64),
        ),
    ] {
        let mut run = gas(&GasConfig { propagation, ..exact.clone() }, 1);
        advance(&mut run, target);
        let invariants = channel::<GasInvariants>(&run);
        let collisions = channel::<GasCollisions>(&run).wall_collisions;
        println!(
            "{name}: {collisions} wall collisions, |v| to {:e}, p x v to {:e}",
            invariants.max_speed_change_relative, invariants.max_angular_momentum_change_relative
        );
        assert!(collisions > 1_000_000);
        assert!(invariants.max_speed_change_relative < 1e-12);
        assert!(invariants.max_angular_momentum_change_relative < 1e-12);
        assert_eq!(invariants.particles_outside, 0);
    }
}

#[test]
fn pressure_at_thirty_random_points_is_within_five_standard_errors() {
    let mut draws = Seed { seed: 30, replicate: 0 }.stream(Stream::Radii);
    let mut decades = |low: f64, high: f64| low * (high / low).powf(draws.uniform());
    let mut max_deviation = 0.0;
    for point in 0..30 {
        let (particles, radius) = (decades(50.0, 20_000.0) as u32, decades(0.01, 100.0));
        let (temperature, mass) = (decades(1.0, 5000.0), decades(1e-27, 1e-24));
        let v_rms = (2.0 * 1.380658e-23 * temperature / mass).sqrt();
        let duration = decades(3.0, 300.0) * radius / v_rms;
        let config = GasConfig {
            particles: count(particles),
            radius_m: positive(radius),
            mass_kg: positive(mass),
            speed_scale: kelvin(temperature),
            temperature_definition: TemperatureDefinition::MeanSquare,
            speed_distribution: SpeedDistribution::Maxwell,
            duration_s: positive(duration),
            ..GasConfig::default()
        };
        let mut run = gas(&config, point);
        advance(&mut run, Target::Time(duration));
        let measured = channel::<GasPressure>(&run).measured_since_start_n_per_m;
        let expected = f64::from(particles) * mass * v_rms * v_rms
            / (2.0 * std::f64::consts::PI * radius * radius);
        let error = radius / (v_rms * duration * (2.0 * f64::from(particles)).sqrt());
        let deviation = (measured / expected - 1.0).abs() / error;
        max_deviation = f64::max(max_deviation, deviation);
        assert!(
            deviation < 5.0,
            "N = {particles}, r = {radius}, T = {temperature}, m = {mass}: {deviation}"
        );
        // Control: equation (12) of the exercise is pi/4 of the pressure for Maxwell's distribution, rejected if the
        // error is small enough.
        let speed = channel::<GasTemperature>(&run).mean_speed_m_per_s;
        let formula_12 = (speed / v_rms).powi(2);
        assert!(error > 0.03 || (measured / expected - formula_12).abs() > 5.0 * error);
    }
    println!("30 points: at most {max_deviation} standard errors");
}

#[test]
fn results_are_independent_of_the_number_of_threads() {
    let exact =
        GasConfig { particles: count(5000), duration_s: positive(0.02), ..GasConfig::default() };
    let stepped = GasConfig {
        propagation: Propagation::TimeStepped { time_step_s: positive(1e-5) },
        ..exact.clone()
    };
    for (config, target) in [(exact, Target::Time(0.02)), (stepped, Target::Count(2000))] {
        let on = |threads: usize| {
            let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let mut run = gas(&config, 3);
            pool.install(|| advance(&mut run, target));
            (particles(&run), channel::<GasPressure>(&run), channel::<GasInvariants>(&run))
        };
        let one = on(1);
        assert_eq!(one, on(2));
        assert_eq!(one, on(3));
    }
}
