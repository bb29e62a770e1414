//! Law: the wall pressure is P = N m <v^2> / (2A), A = pi r^2, and P A = N k_B T for a temperature defined by the mean
//! square.
//!
//! Source: gas exercise, equations (12) and (13) with the mean square instead of the squared mean; kinetic theory in
//! two dimensions. Reference values: 50-digit arithmetic.
//! Setup: gases of several T, r and N with k_B of 1986, exact and stepped; P is the normal impulse over perimeter and time.
//! Tolerance: four relative standard errors R/(v_rms T sqrt(2N)). The wall collisions of a particle are equidistant in
//! time, so only their phase scatters (variance 1/6); with <C^2> = 3/4 R^2, the variance of the impulse is m^2 <v^2> /
//! 2 at any time.
//! Control: equation (12) as printed is rejected.

// Tests compare with the platform's functions and do not affect recorded bits.
#![allow(clippy::disallowed_methods)]

use crate::runs::{advance, channel, count, exercise, gas, given, kelvin, positive};
use kinetoscope_manifest::model::{
    BoltzmannConstant, GasConfig, Propagation, SpeedDistribution, TemperatureDefinition,
};
use kinetoscope_physics::gas::Gas;
use kinetoscope_physics::gas::pressure::{ideal_gas_pressure, kinetic_pressure, measured_pressure};
use kinetoscope_physics::model::{Model, Target};
use kinetoscope_physics::random::Seed;
use kinetoscope_recording::channels::{GasInvariants, GasPressure, GasTemperature};
use std::f64::consts::PI;

fn at(temperature: f64, radius: f64, particles: u32) -> GasConfig {
    GasConfig {
        particles: count(particles),
        radius_m: positive(radius),
        speed_scale: kelvin(temperature),
        temperature_definition: TemperatureDefinition::MeanSquare,
        ..exercise()
    }
}

/// Deviation of the measured pressure from theory, in standard errors.
fn deviation(
    measured: f64,
    theory: f64,
    rms_speed: f64,
    radius: f64,
    time: f64,
    particles: f64,
) -> f64 {
    (measured / theory - 1.0) * (rms_speed * time * (2.0 * particles).sqrt()) / radius
}

#[test]
fn wall_pressure_equals_that_of_the_mean_square_speed() {
    let mut max_deviation = 0.0;
    for temperature in [10.0, 300.0, 373.15, 1e4] {
        for radius in [0.5, 1.0, 3.0] {
            for particles in [100, 1000] {
                for distribution in [
                    SpeedDistribution::Uniform,
                    SpeedDistribution::Maxwell,
                    SpeedDistribution::Equal,
                ] {
                    let config = GasConfig {
                        speed_distribution: distribution,
                        ..at(temperature, radius, particles)
                    };
                    let mut gas = gas(&config, 14);
                    advance(&mut gas, Target::Time(0.1));
                    let (n, k) = (f64::from(particles), 1.380_658e-23);
                    let theory = n * k * temperature / (PI * radius * radius);
                    let rms = (2.0 * k * temperature / 1e-26_f64).sqrt();
                    let measured = channel::<GasPressure>(&gas).measured_since_start_n_per_m;
                    let deviation = deviation(measured, theory, rms, radius, 0.1, n).abs();
                    max_deviation = f64::max(max_deviation, deviation);
                    assert!(
                        deviation < 4.0,
                        "{temperature} K, {radius} m, {particles}: {deviation}"
                    );
                }
            }
        }
    }
    println!("72 gases: at most {max_deviation} standard errors");
}

#[test]
fn control_formula_12_is_rejected() {
    // With <v>^2 instead of <v^2>, the theoretical value is 3/4 of the pressure.
    let mut gas = gas(&at(300.0, 1.0, 1000), 14);
    advance(&mut gas, Target::Time(0.1));
    let pressure = channel::<GasPressure>(&gas);
    let rms = channel::<GasTemperature>(&gas).rms_speed_m_per_s;
    let theory = pressure.mean_speed_formula_n_per_m;
    let deviation = deviation(pressure.measured_since_start_n_per_m, theory, rms, 1.0, 0.1, 1000.0);
    println!("control: {deviation} standard errors");
    assert!(deviation > 100.0);
}

#[test]
fn standard_error_equals_the_scatter_of_replicates() {
    // 400 replicates: the root mean square of their deviations is 1 +- 1/sqrt(800); four standard errors are 0.14.
    let config = at(300.0, 1.0, 100);
    let mut squares = 0.0;
    for replicate in 0..400 {
        let mut gas = Gas::prepare(&config, Seed { seed: 3, replicate }, false).unwrap();
        advance(&mut gas, Target::Time(0.05));
        let (pressure, temperature) =
            (channel::<GasPressure>(&gas), channel::<GasTemperature>(&gas));
        let theory = pressure.mean_square_formula_n_per_m;
        let measured = pressure.measured_since_start_n_per_m;
        let deviation =
            deviation(measured, theory, temperature.rms_speed_m_per_s, 1.0, 0.05, 100.0);
        squares += deviation * deviation / 400.0;
    }
    println!("rms deviation {} standard errors", squares.sqrt());
    assert!((squares.sqrt() - 1.0).abs() < 0.14);
}

#[test]
fn formulas_give_the_reference_values() {
    for (temperature, radius, expected) in [
        (300.0, 1.0, 1.31843127251622e-18),
        (373.15, 1.0, 1.63990876446476e-18),
        (300.0, 0.5, 5.27372509006488e-18),
    ] {
        let pressure = channel::<GasPressure>(&gas(&at(temperature, radius, 1000), 2));
        for value in [pressure.mean_square_formula_n_per_m, pressure.ideal_gas_n_per_m] {
            assert!((value / expected - 1.0).abs() < 1e-13, "{value:e}");
        }
        assert!(pressure.measured_n_per_m.is_nan());
        assert!(pressure.pressure_over_mean_square_formula.is_nan());
    }
    assert_eq!(ideal_gas_pressure(2.0, 3.0, 5.0, 1.0), 30.0 / PI);
    assert_eq!(kinetic_pressure(2.0, 3.0, 5.0, 1.0), 15.0 / PI);
    assert_eq!(measured_pressure(2.0, 1.0, 4.0), 0.25 / PI);
    assert!(measured_pressure(2.0, 1.0, 0.0).is_nan());
}

#[test]
fn boltzmann_constant_is_selectable() {
    // The SI value is smaller by 6.5e-6, which changes the pressure by the same ratio.
    let si = GasConfig { boltzmann_constant: BoltzmannConstant::Si2019, ..at(300.0, 1.0, 1000) };
    let pressure = |config| channel::<GasPressure>(&gas(config, 2)).mean_square_formula_n_per_m;
    let ratio = pressure(&si) / pressure(&at(300.0, 1.0, 1000));
    assert!((ratio - 1.380_649 / 1.380_658).abs() < 1e-13);
}

#[test]
fn windows_measure_their_own_time() {
    // One particle moves back and forth on a diameter: it collides at 1, 3, 5, ... with an impulse of 2 m v each.
    for propagation in
        [Propagation::Exact, Propagation::TimeStepped { time_step_s: positive(0.125) }]
    {
        let mut gas = gas(&GasConfig { propagation, ..given(&[([0.0, 0.0], [1.0, 0.0])]) }, 1);
        for (end, collisions) in [(0.5, 0.0), (2.0, 1.0), (6.0, 2.0), (6.5, 0.0), (6.5, 0.0)] {
            let window = end - gas.time();
            advance(&mut gas, Target::Time(end));
            let pressure = channel::<GasPressure>(&gas);
            let impulse: f64 = collisions * 2e-26;
            assert!((pressure.wall_impulse_n_s - impulse).abs() < 1e-39);
            assert_eq!(pressure.window_s, window);
            let expected = impulse / (2.0 * PI * window);
            // A window of no length has no mean.
            let is_empty = window == 0.0 && pressure.measured_n_per_m.is_nan();
            assert!(is_empty || (pressure.measured_n_per_m - expected).abs() < 1e-39);
        }
        let pressure = channel::<GasPressure>(&gas);
        let since_start = 3.0 * 2e-26 / (2.0 * PI * 6.5);
        assert!((pressure.measured_since_start_n_per_m / since_start - 1.0).abs() < 1e-14);
    }
}

#[test]
fn windows_measure_their_own_time_for_tangential_motion() {
    // The force is m s^2 / R with s = 3.
    let mut gas = gas(&given(&[([1.0, 0.0], [0.0, 3.0])]), 1);
    for (end, window) in [(2.0, 2.0), (2.5, 0.5), (7.5, 5.0)] {
        advance(&mut gas, Target::Time(end));
        let impulse = channel::<GasPressure>(&gas).wall_impulse_n_s;
        assert!((impulse / (9e-26 * window) - 1.0).abs() < 1e-14);
    }
}

#[test]
fn gas_at_zero_kelvin_is_at_rest_without_pressure() {
    for propagation in [
        Propagation::Exact,
        Propagation::TimeStepped { time_step_s: positive(0.01) },
        Propagation::AsPrinted { time_step_s: positive(0.01) },
    ] {
        let mut gas = gas(&GasConfig { propagation, ..at(0.0, 1.0, 100) }, 1);
        let first = crate::runs::particles(&gas);
        advance(&mut gas, Target::Time(0.1));
        assert_eq!(crate::runs::particles(&gas), first);
        // Zero, not minus zero, because equal states must have equal bytes.
        assert!(first.iter().all(|p| p.velocity.iter().all(|v| v.to_bits() == 0)));
        let mut pressure = channel::<GasPressure>(&gas);
        // 0 / 0 has no value.
        for ratio in [
            &mut pressure.pressure_over_mean_square_formula,
            &mut pressure.window_pressure_over_mean_square_formula,
        ] {
            assert!(std::mem::take(ratio).is_nan());
        }
        let expected = GasPressure { window_s: gas.time(), ..GasPressure::default() };
        assert_eq!(pressure, expected);
        assert_eq!(channel::<GasTemperature>(&gas), GasTemperature::default());
        let invariants = channel::<GasInvariants>(&gas);
        assert_eq!(invariants, GasInvariants::default());
        assert!(gas.scenery().speed_range_top > 0.0);
        assert!(crate::runs::frame(&gas).state().iter().all(|value| value.is_finite()));
    }
}
