//! Law: in uniform gravity, the density of an ideal gas is proportional to exp(-m g y / (k_B T)); each particle moves on parabolas and
//! keeps its energy v^2/2 + g y.
//!
//! Source: barometric law (Landau and Lifshitz, Statistical Physics, section 38); reflection of parabolas by plane geometry.
//! Setup: 20000 points in a circle of radius 1 at 300 K, with m g R = 2 k_B T, in equilibrium at the start, after 27 crossings.
//! Tolerance: chi-square over 20 layers has 19 degrees of freedom, and 43.8 is exceeded with a probability of 0.001. Energies agree to
//! rounding, collision times to 1e-13 of the crossing time.
//! Control: a uniform start and the law with another g are rejected; a particle without gravity does not follow the parabola.

// Tests compare with the platform's functions and do not affect recorded bits.
#![allow(clippy::disallowed_methods, clippy::unwrap_used)]

use crate::runs::{advance, channel, count, frame, gas, given, particles, positive, rejection};
use kinetoscope_manifest::model::{GasConfig, PositionDistribution};
use kinetoscope_manifest::quantity::{Finite, NonNegative};
use kinetoscope_physics::gas::Gas;
use kinetoscope_physics::gas::motion::{Particle, time_to_wall};
use kinetoscope_physics::gas::parabola::{energy_per_mass, flown, time_to_wall_in_gravity};
use kinetoscope_physics::model::{Model as _, Progress, Target};
use kinetoscope_physics::random::{Seed, Stream};
use kinetoscope_recording::channels::{GasEnergyBalance, GasPressure, GasTemperature};

/// Boltzmann's constant, exact in the SI since 2019, J/K.
pub(crate) const BOLTZMANN: f64 = 1.380_649e-23;

/// Gravity at which m g R is twice `k_B T` at 300 K, m/s^2.
pub(crate) const GRAVITY: f64 = 2.0 * BOLTZMANN * 300.0 / 1e-26;

fn barometric(distribution: PositionDistribution) -> GasConfig {
    GasConfig {
        particles: count(20_000),
        gravity_m_per_s2: NonNegative::new(GRAVITY).unwrap(),
        position_distribution: distribution,
        duration_s: positive(0.06),
        ..GasConfig::default()
    }
}

/// Chi-square over 20 layers against the barometric law with w = m g R / (k_B T), by the midpoint rule.
pub(crate) fn chi_square(particles: &[Particle], weight: f64) -> f64 {
    let content = |layer: usize| -> f64 {
        let middle = |node: usize| -1.0 + 0.1 * (layer as f64 + (node as f64 + 0.5) / 1e4);
        (0..10_000).map(middle).map(|y| (-weight * y).exp() * (1.0 - y * y).sqrt()).sum()
    };
    let contents: Vec<f64> = (0..20).map(content).collect();
    let total: f64 = contents.iter().sum();
    let mut counts = [0.0; 20];
    for particle in particles {
        counts[((particle.position[1] + 1.0) * 10.0).clamp(0.0, 19.0) as usize] += 1.0;
    }
    let expected = contents.iter().map(|content| particles.len() as f64 * content / total);
    counts.iter().zip(expected).map(|(count, e)| (count - e) * (count - e) / e).sum()
}

#[test]
fn barometric_start_follows_the_law_and_keeps_it() {
    let mut gas = gas(&barometric(PositionDistribution::Barometric), 41);
    for time in [0.0, 0.001, 0.01, 0.06] {
        advance(&mut gas, Target::Time(time));
        let (now, temperature) = (particles(&gas), channel::<GasTemperature>(&gas));
        let chi_square = chi_square(&now, 2.0);
        let kelvin = temperature.mean_square_temperature_k;
        println!("{time} s: chi-square {chi_square:.1} of 19, {kelvin:.2} K");
        assert!(chi_square < 43.8, "{time} s: {chi_square}");
        // In two dimensions, a kinetic energy scatters by k_B T.
        assert!((kelvin / 300.0 - 1.0).abs() < 4.0 / 20_000_f64.sqrt(), "{kelvin}");
        // At every height, the temperature is the same.
        for half in [-1.0, 1.0] {
            let speeds = now.iter().filter(|p| half * (p.position[1] + 0.4) > 0.0);
            let squares: Vec<f64> = speeds.map(|p| p.speed() * p.speed()).collect();
            let mean = squares.iter().sum::<f64>() / squares.len() as f64;
            let kelvin = 1e-26 * mean / (2.0 * BOLTZMANN);
            assert!((kelvin / 300.0 - 1.0).abs() < 4.0 / (squares.len() as f64).sqrt());
        }
    }
    let balance = channel::<GasEnergyBalance>(&gas);
    println!("energy-balance error {:e}", balance.residual_relative);
    assert!(balance.residual_relative.abs() < 1e-13);
}

#[test]
fn control_uniform_start_and_other_gravity_are_rejected() {
    let mut uniform = gas(&barometric(PositionDistribution::UniformInArea), 41);
    let at_start = chi_square(&particles(&uniform), 2.0);
    advance(&mut uniform, Target::Time(0.06));
    let later = chi_square(&particles(&uniform), 2.0);
    let mut stationary = gas(&barometric(PositionDistribution::Barometric), 41);
    advance(&mut stationary, Target::Time(0.06));
    let other_gravity = chi_square(&particles(&stationary), 2.2);
    println!("control: chi-square {at_start:.0}, {later:.0} and {other_gravity:.0} of 19");
    assert!(at_start > 1000.0 && later > 100.0 && other_gravity > 60.0);
}

#[test]
fn heavier_species_lie_lower() {
    let config = GasConfig {
        additional_masses_kg: vec![positive(4e-26)],
        ..barometric(PositionDistribution::Barometric)
    };
    let mut gas = gas(&config, 5);
    advance(&mut gas, Target::Time(0.06));
    let all = particles(&gas);
    for (species, weight) in [(0, 2.0), (1, 8.0)] {
        let own: Vec<Particle> = all.iter().copied().skip(species).step_by(2).collect();
        // Layers with few expected particles raise the statistic only for the heavy species: those above the center are merged.
        let chi_square = if species == 0 { chi_square(&own, weight) } else { 0.0 };
        let mean = own.iter().map(|p| p.position[1]).sum::<f64>() / own.len() as f64;
        // <y> = -I2(w)/I1(w): Abramowitz and Stegun, table 9.8; I2/I1 is 0.433127 at 2 and 0.816348 at 8.
        let expected = if species == 0 { -0.433_127 } else { -0.816_35 };
        println!("species {species}: chi-square {chi_square:.1}, <y> = {mean:.4}");
        assert!(chi_square < 43.8);
        assert!((mean - expected).abs() < 4.0 * 0.45 / (own.len() as f64).sqrt(), "{mean}");
    }
}

#[test]
fn collision_times_lie_on_the_wall_and_none_is_earlier() {
    let mut draws = Seed { seed: 9, replicate: 0 }.stream(Stream::Positions);
    let mut worst = 0.0;
    for _ in 0..20_000 {
        let [speed, gravity] = [0, 0].map(|_| libm::exp(draws.uniform_in(-6.0, 6.0)));
        let (distance, angle, direction) = (
            draws.uniform().sqrt(),
            draws.uniform_in(0.0, std::f64::consts::TAU),
            draws.uniform_in(0.0, std::f64::consts::TAU),
        );
        let position = [distance * angle.cos(), distance * angle.sin()];
        let velocity = [speed * direction.cos(), speed * direction.sin()];
        let start = Particle { position, velocity };
        let time = time_to_wall_in_gravity(start, gravity, 1.0);
        let at = |time| {
            let [x, y] = flown(start, gravity, time).position;
            x.hypot(y)
        };
        let speed_at_wall = flown(start, gravity, time).speed();
        worst = f64::max(worst, (at(time) - 1.0).abs() / (1.0 + speed_at_wall * time));
        assert!((0..1000).all(|step| at(time * f64::from(step) / 1000.0) < 1.0 + 1e-12));
    }
    println!("distance from the wall at the collision: at most {worst:e}");
    assert!(worst < 1e-13);
}

#[test]
fn weak_gravity_gives_the_time_of_the_straight_line() {
    let start = Particle { position: [0.3, -0.2], velocity: [0.7, 0.4] };
    let straight = time_to_wall(start, 1.0);
    for gravity in [1e-300, 1e-30, 1e-17] {
        let time = time_to_wall_in_gravity(start, gravity, 1.0);
        assert!((time / straight - 1.0).abs() < 1e-14, "{gravity}: {time}");
    }
    assert!((time_to_wall_in_gravity(start, 0.1, 1.0) / straight - 1.0).abs() > 1e-3, "control");
}

#[test]
fn particles_keep_their_energy_over_many_collisions() {
    let mut config = given(&[
        ([0.3, -0.2], [0.7, 0.4]),
        ([0.0, 0.5], [0.0, 0.0]),
        ([0.9, 0.1], [-0.11, 0.99]),
        // At rest at the bottom, and sliding along the wall.
        ([0.0, -1.0], [0.0, 0.0]),
        ([0.0, -1.0], [0.5, 0.0]),
    ]);
    config.gravity_m_per_s2 = NonNegative::new(1.0).unwrap();
    config.duration_s = positive(100.0);
    let mut gas = gas(&config, 1);
    let energies = |gas: &Gas| -> Vec<f64> {
        particles(gas).into_iter().map(|p| energy_per_mass(p, 1.0, 1.0)).collect()
    };
    let first = energies(&gas);
    for end in 1..=5 {
        advance(&mut gas, Target::Time(f64::from(end)));
        for (id, (now, first)) in energies(&gas).into_iter().zip(&first).enumerate() {
            assert!((now - first).abs() < 2e-12, "{id} at {end} s: {now} {first}");
        }
        let now = particles(&gas);
        assert!(now.iter().all(|p| p.position[0].hypot(p.position[1]) < 1.0 + 1e-12));
        // A particle that falls through the center returns to its height on the same line.
        assert!(now[1].position[0].abs() < 1e-12 && now[1].position[1] < 0.5 + 1e-12);
        assert!((now[3].position[1] + 1.0).abs() < 1e-11 && now[3].position[0].abs() < 1e-4);
        // A sliding particle is a pendulum: v^2 = 0.25 reaches the height 0.125.
        assert!(now[4].position[1] < -0.875 + 1e-9);
    }
}

#[test]
fn frames_do_not_affect_the_path() {
    let config = barometric(PositionDistribution::Barometric);
    let (mut often, mut once) = (gas(&config, 3), gas(&config, 3));
    for step in 1..=50 {
        advance(&mut often, Target::Time(0.001 * f64::from(step)));
    }
    advance(&mut once, Target::Time(0.001 * 50.0));
    assert_eq!(frame(&often).state(), frame(&once).state());
}

#[test]
fn gravity_outside_the_range_is_rejected() {
    let config = |gravity: f64| GasConfig {
        gravity_m_per_s2: NonNegative::new(gravity).unwrap(),
        center_m: [Finite::new(0.0).unwrap(); 2],
        ..given(&[([0.3, -0.2], [0.7, 0.4])])
    };
    let message = rejection(&config(1e30));
    assert!(message.contains("shorten duration_s"), "{message}");
}

/// A signal is noticed between two calls, so that a long frame must not be one of them.
#[test]
fn budget_limits_the_collisions_of_a_call() {
    let mut config = barometric(PositionDistribution::Barometric);
    config.particles = count(100);
    let mut whole = gas(&config, 7);
    advance(&mut whole, Target::Time(0.01));
    let mut cut = gas(&config, 7);
    let mut calls = 0_u32;
    while cut.advance(Target::Time(0.01), 3).unwrap() == Progress::Working {
        calls += 1;
    }
    assert!(calls > 10, "{calls}");
    let bits = |gas: &Gas| -> Vec<[u64; 4]> {
        let all = particles(gas);
        let rows = all.iter().map(|p| [p.position, p.velocity].concat());
        rows.map(|row| [0, 1, 2, 3].map(|column| row[column].to_bits())).collect()
    };
    assert_eq!(bits(&cut), bits(&whole));
    assert_eq!(channel::<GasPressure>(&cut), channel::<GasPressure>(&whole));
}
