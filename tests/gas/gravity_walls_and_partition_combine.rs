//! Law: gravity, a thermal wall, an opening and a partition act together as each does alone:
//! - a thermal wall in gravity: the density tends to exp(-m g y / (k_B T)) at the temperature T of the wall, which is that at every height;
//! - an opening in gravity: the initial rate of escape is `<v>`/pi times the integral of the barometric density along the opening;
//! - a partition through the center in gravity: the path of a particle is that without the partition, folded at it;
//! - a partition next to a thermal wall or an opening: no particle passes until it is removed.
//!
//! Source: barometric law (Landau and Lifshitz, Statistical Physics, section 38); Maxwell, Phil. Trans. 170 (1879) 231, a wall that emits
//! the flux of a Maxwellian gas is in equilibrium with it at any density; Knudsen's flux n `<v>` / pi per meter of wall in two dimensions;
//! the mirror symmetry of circle and gravity.
//! Setup: 4000 to 200000 points in a circle of radius 1, m g R = 2 k_B T at 300 K, some 30 crossings.
//! Tolerance: chi-square over 20 layers has 19 degrees of freedom, and 43.8 is exceeded with a probability of 0.001; four standard errors
//! for other random quantities; rounding for energies and folded paths.
//! Control: stated at each assertion.

// Tests compare with the platform's functions and do not affect recorded bits.
#![allow(clippy::disallowed_methods, clippy::unwrap_used)]

use crate::gravity_gives_the_barometric_law::{BOLTZMANN, GRAVITY, chi_square};
use crate::runs::{
    advance, channel, count, frame, gas, given, kelvin, max_difference, particles, positive,
};
use kinetoscope_manifest::model::{
    GasConfig, Partition, PartitionSide, PositionDistribution, SpeedDistribution, ThermalWall,
};
use kinetoscope_manifest::quantity::{Finite, Fraction, NonNegative};
use kinetoscope_physics::gas::Gas;
use kinetoscope_physics::model::{Model as _, Progress, Target};
use kinetoscope_recording::channels::{
    GasCollisions, GasEnergyBalance, GasInvariants, GasTemperature,
};
use std::f64::consts::PI;

fn thermal(accommodation: f64) -> Option<ThermalWall> {
    let accommodation = Fraction::new(accommodation).unwrap();
    Some(ThermalWall { temperature_k: positive(300.0), accommodation })
}

fn partition(x: f64, opens_s: Option<f64>) -> Option<Partition> {
    Some(Partition {
        x_m: Finite::new(x).unwrap(),
        opens_s: opens_s.map(positive),
        side: Some(PartitionSide::Left),
    })
}

/// A gas of equal speeds at 100 K, uniform over the area.
fn cold(particles: u32) -> GasConfig {
    GasConfig {
        particles: count(particles),
        speed_distribution: SpeedDistribution::Equal,
        speed_scale: kelvin(100.0),
        duration_s: positive(0.06),
        ..GasConfig::default()
    }
}

fn in_gravity(config: GasConfig) -> GasConfig {
    GasConfig { gravity_m_per_s2: NonNegative::new(GRAVITY).unwrap(), ..config }
}

/// The energy balance closes, and no particle is lost.
fn assert_consistent(gas: &Gas) {
    let residual = channel::<GasEnergyBalance>(gas).residual_relative;
    println!("energy-balance error {residual:e}");
    assert!(residual.abs() < 1e-11, "{residual:e}");
    assert_eq!(channel::<GasInvariants>(gas).particles_outside, 0);
}

#[test]
fn thermal_wall_in_gravity_gives_the_barometric_law_at_its_temperature() {
    for (accommodation, duration) in [(1.0, 0.06), (0.4, 0.12)] {
        let config = GasConfig {
            thermal_wall: thermal(accommodation),
            duration_s: positive(duration),
            ..in_gravity(cold(20_000))
        };
        let mut run = gas(&config, 51);
        advance(&mut run, Target::Time(duration));
        let now = particles(&run);
        let (law, other_gravity) = (chi_square(&now, 2.0), chi_square(&now, 2.2));
        println!("accommodation {accommodation}: chi-square {law:.1} and {other_gravity:.1} of 19");
        assert!(law < 43.8, "{law}");
        assert!(other_gravity > 60.0, "control");
        for half in [-1.0, 1.0] {
            let speeds = now.iter().filter(|p| half * (p.position[1] + 0.4) > 0.0);
            let squares: Vec<f64> = speeds.map(|p| p.speed() * p.speed()).collect();
            let mean = squares.iter().sum::<f64>() / squares.len() as f64;
            let kelvin = 1e-26 * mean / (2.0 * BOLTZMANN);
            assert!((kelvin / 300.0 - 1.0).abs() < 4.0 / (squares.len() as f64).sqrt(), "{kelvin}");
        }
        assert_consistent(&run);
    }
    // Control: a wall that practically only reflects leaves the gas in another state.
    let mut specular =
        gas(&GasConfig { thermal_wall: thermal(1e-9), ..in_gravity(cold(20_000)) }, 51);
    advance(&mut specular, Target::Time(0.06));
    let chi_square = chi_square(&particles(&specular), 2.0);
    println!("control: chi-square {chi_square:.0} of 19");
    assert!(chi_square > 100.0);
    assert!(channel::<GasEnergyBalance>(&specular).wall_heat_j == 0.0);
}

#[test]
fn rate_of_escape_in_gravity_follows_the_barometric_density() {
    let (number, width, duration) = (200_000.0, 0.1, 0.002);
    let config = GasConfig {
        particles: count(200_000),
        position_distribution: PositionDistribution::Barometric,
        orifice_width_m: Some(positive(width)),
        duration_s: positive(duration),
        ..in_gravity(GasConfig::default())
    };
    let mut run = gas(&config, 52);
    advance(&mut run, Target::Time(duration));
    let balance = channel::<GasEnergyBalance>(&run);
    let escaped = balance.particles_escaped as f64;
    let speed = (PI * BOLTZMANN * 300.0 / (2.0 * 1e-26)).sqrt();
    // The integral of exp(-2 y) over the circle is 2 pi I1(2)/2, I1(2) = 1.590637 (Abramowitz and Stegun, table 9.8); along the opening,
    // it is w (1 + (2 w)^2/24) by Simpson's rule.
    let density = number / (PI * 1.590_637);
    let along = width * (1.0 + (2.0 * width).powi(2) / 24.0);
    let expected = density * along * speed / PI * duration;
    println!("{escaped} escaped, {expected:.0} expected");
    assert!((escaped - expected).abs() < 4.0 * expected.sqrt());
    // Control: the rate of a uniform gas is rejected.
    let uniform = number / PI * width * speed / PI * duration;
    assert!((escaped - uniform).abs() > 4.0 * uniform.sqrt());
    assert_consistent(&run);
    let inside = channel::<GasTemperature>(&run).mean_square_temperature_k;
    assert!((inside / 300.0 - 1.0).abs() < 4.0 / number.sqrt() + 0.01, "{inside}");
}

#[test]
fn partition_through_the_center_folds_paths_in_gravity() {
    let starts =
        [([-0.3, -0.2], [0.7, 0.4]), ([-0.6, 0.5], [-0.2, 0.1]), ([-0.1, 0.9], [0.3, 0.0])];
    let run = |partition: Option<Partition>, until: f64| {
        let gravity_m_per_s2 = NonNegative::new(1.0).unwrap();
        let mut run = gas(&GasConfig { gravity_m_per_s2, partition, ..given(&starts) }, 1);
        advance(&mut run, Target::Time(until));
        particles(&run)
    };
    for until in [0.5, 2.0, 6.0] {
        let free = run(None, until);
        for (folded, free) in run(partition(0.0, None), until).iter().zip(&free) {
            let [x, y] = free.position;
            let error = max_difference(folded.position, [-x.abs(), y]);
            println!("{until} s: {error:e}");
            assert!(error < 1e-10, "{error:e}");
        }
        // Control: another partition does not fold them.
        let other = run(partition(0.1, None), until);
        let errors = other.iter().zip(&free).map(|(other, free)| {
            max_difference(other.position, [-free.position[0].abs(), free.position[1]])
        });
        assert!(until < 2.0 || errors.fold(0.0, f64::max) > 1e-3, "control");
    }
}

/// After the removal, four standard errors of the number on the left, of which one in a thousand particles has not yet moved.
#[test]
fn gas_behind_a_partition_takes_the_temperature_of_the_wall_and_then_fills_the_container() {
    for config in [cold(4000), in_gravity(cold(4000))] {
        let config = GasConfig {
            thermal_wall: thermal(1.0),
            partition: partition(0.0, Some(0.06)),
            duration_s: positive(0.12),
            ..config
        };
        let mut run = gas(&config, 53);
        advance(&mut run, Target::Time(0.0599));
        let kelvin = channel::<GasTemperature>(&run).mean_square_temperature_k;
        assert!((kelvin / 300.0 - 1.0).abs() < 4.0 / 4000_f64.sqrt(), "{kelvin}");
        assert!(particles(&run).iter().all(|p| p.position[0] <= 0.0));
        advance(&mut run, Target::Time(0.12));
        let left = particles(&run).iter().filter(|p| p.position[0] < 0.0).count();
        println!("{kelvin:.1} K, then {left} of 4000 on the left");
        // Control: nearly all would be on the left if the partition had stayed.
        assert!((left as f64 - 2000.0).abs() < 4.0 * 1000_f64.sqrt(), "{left}");
        assert_consistent(&run);
    }
}

#[test]
fn no_particle_reaches_an_opening_behind_a_partition() {
    for config in [cold(4000), in_gravity(cold(4000))] {
        let escaped = |partition: Option<Partition>| {
            let orifice_width_m = Some(positive(0.5));
            let mut run = gas(&GasConfig { orifice_width_m, partition, ..config.clone() }, 54);
            advance(&mut run, Target::Time(0.01));
            let before = channel::<GasEnergyBalance>(&run).particles_escaped;
            advance(&mut run, Target::Time(0.02));
            assert_consistent(&run);
            [before, channel::<GasEnergyBalance>(&run).particles_escaped]
        };
        let [before, after] = escaped(partition(0.0, Some(0.01)));
        let [open, _] = escaped(None);
        println!("{before} escaped, {after} after the partition is removed; {open} without one");
        assert!(before == 0 && after > 100);
        assert!(open > 100, "control");
    }
}

/// Guarantee: neither frames nor budgets change a bit of a gas in which all of them act.
#[test]
fn frames_and_budgets_do_not_affect_combined_walls() {
    let config = GasConfig {
        thermal_wall: thermal(0.5),
        partition: partition(0.2, Some(0.01)),
        orifice_width_m: Some(positive(0.3)),
        ..in_gravity(cold(3000))
    };
    let [mut often, mut once, mut cut] = [0; 3].map(|_: u8| gas(&config, 55));
    for step in 1..=20 {
        advance(&mut often, Target::Time(0.001 * f64::from(step)));
    }
    advance(&mut once, Target::Time(0.001 * 20.0));
    while cut.advance(Target::Time(0.001 * 20.0), 7).unwrap() == Progress::Working {}
    let of = |run: &Gas| (particles(run), channel::<GasCollisions>(run).wall_collisions);
    assert_eq!(of(&often), of(&once));
    assert_eq!(frame(&cut).state(), frame(&once).state());
    let escaped = |run: &Gas| channel::<GasEnergyBalance>(run).escaped_j.to_bits();
    assert_eq!(escaped(&cut), escaped(&once));
    assert!(channel::<GasEnergyBalance>(&once).particles_escaped > 0, "control");
    assert_consistent(&once);
}
