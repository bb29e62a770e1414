//! Law: a set temperature holds exactly in the definition in use, T = m <v>^2 / (2 k_B) or T = m <v^2> / (2 k_B); the
//! ratio of the two is 3/4 for uniform speeds and pi/4 for Maxwell's distribution.
//!
//! Source: gas exercise, equation (13) and step (d); moments of the two distributions. Reference values: 50-digit
//! arithmetic.
//! Setup: gases in their initial state; by default, uniform speeds and the gas exercise's definition.
//! Tolerance: 1e-14 where a rescaled sample has T by construction (one square root, one product); four standard errors
//! for the ratio of a sample: its logarithm has the variance <(q(x))^2> / N with q = x^2/<x^2> - 2 x/<x> + 1, 2/15 for
//! uniform, 16/pi - 5 for Maxwell.
//! Control: uniform speeds set to 300 K by the mean speed have 400 K by the mean square.

// Tests compare with the platform's functions and do not affect recorded bits.
#![allow(clippy::disallowed_methods)]

use crate::runs::{channel, count, exercise, frame, gas, given, kelvin, max_speed};
use kinetoscope_manifest::model::{GasConfig, SpeedDistribution, TemperatureDefinition};
use kinetoscope_physics::gas::pressure::speed_at;
use kinetoscope_recording::channels::{GasPressure, GasSpeeds, GasTemperature};
use std::f64::consts::PI;

const DISTRIBUTIONS: [SpeedDistribution; 3] =
    [SpeedDistribution::Uniform, SpeedDistribution::Maxwell, SpeedDistribution::Equal];

#[test]
fn set_temperature_holds_to_rounding() {
    for temperature in [1e-9, 300.0, 373.15, 1e9] {
        for speed_distribution in DISTRIBUTIONS {
            for temperature_definition in
                [TemperatureDefinition::MeanSpeed, TemperatureDefinition::MeanSquare]
            {
                for particles in [1, 17, 1000] {
                    let config = GasConfig {
                        particles: count(particles),
                        speed_scale: kelvin(temperature),
                        speed_distribution,
                        temperature_definition,
                        duration_s: crate::runs::positive(1e-3),
                        ..exercise()
                    };
                    let measured = channel::<GasTemperature>(&gas(&config, 14));
                    let found = match temperature_definition {
                        TemperatureDefinition::MeanSpeed => measured.mean_speed_temperature_k,
                        TemperatureDefinition::MeanSquare => measured.mean_square_temperature_k,
                    };
                    assert!((found / temperature - 1.0).abs() < 1e-14, "{found}");
                }
            }
        }
    }
}

/// Tolerance: 1e-12, for the sum of a thousand squares.
/// Control: the gas exercise's definition gives another temperature and pressure.
#[test]
fn default_gas_has_300_kelvin_by_equipartition() {
    let of = |config: GasConfig| {
        let gas = gas(&config, 15);
        let pressure = channel::<GasPressure>(&gas).mean_square_formula_n_per_m;
        (channel::<GasTemperature>(&gas).mean_square_temperature_k, pressure)
    };
    // N k_B T / A with the exact SI constant: 1000 particles in a circle of radius 1 m.
    let expected = 1000.0 * 1.380_649e-23 * 300.0 / PI;
    let (temperature, pressure) = of(GasConfig::default());
    assert!((temperature / 300.0 - 1.0).abs() < 1e-12, "{temperature}");
    assert!((pressure / expected - 1.0).abs() < 1e-12, "{pressure:e}");
    let (temperature, pressure) = of(exercise());
    assert!(temperature > 350.0 && pressure > 1.1 * expected);
}

#[test]
fn given_velocities_are_rescaled() {
    let config = GasConfig {
        speed_scale: kelvin(300.0),
        temperature_definition: TemperatureDefinition::MeanSpeed,
        ..given(&[([0.0, 0.0], [1.0, 0.0]), ([0.5, 0.0], [0.0, -3.0])])
    };
    let measured = channel::<GasTemperature>(&gas(&config, 1));
    assert!((measured.mean_speed_temperature_k / 300.0 - 1.0).abs() < 1e-14);
    // Speeds 1 and 3: <v>^2 = 4, <v^2> = 5.
    assert!((measured.mean_square_temperature_k / 375.0 - 1.0).abs() < 1e-14);
}

#[test]
fn ratio_of_the_two_definitions_follows_the_moments() {
    let n = 100_000.0_f64;
    for (speed_distribution, ratio, variance) in [
        (SpeedDistribution::Uniform, 0.75, 2.0 / 15.0),
        // With <x> = sqrt(pi)/2, <x^2> = 1, <x^3> = 3 sqrt(pi)/4, <x^4> = 2.
        (SpeedDistribution::Maxwell, PI / 4.0, 16.0 / PI - 5.0),
        (SpeedDistribution::Equal, 1.0, 1e-24),
    ] {
        let config = GasConfig { particles: count(100_000), speed_distribution, ..exercise() };
        let measured = channel::<GasTemperature>(&gas(&config, 3));
        let found = measured.mean_speed_temperature_k / measured.mean_square_temperature_k;
        println!("{speed_distribution:?}: {found}, theory {ratio}");
        assert!((found / ratio - 1.0).abs() < 4.0 * (variance / n).sqrt());
    }
}

#[test]
fn exercise_temperatures_are_four_thirds_by_equipartition() {
    // "300 K" is 400 K by equipartition and "373.15 K" is 497.53 K, for uniform speeds, in the mean.
    for (set, expected) in [(300.0, 400.0), (373.15, 497.53)] {
        let config =
            GasConfig { particles: count(100_000), speed_scale: kelvin(set), ..exercise() };
        let gas = gas(&config, 4);
        let found = channel::<GasTemperature>(&gas).mean_square_temperature_k;
        println!("{set} K by (13) is {found} K");
        assert!((found / expected - 1.0).abs() < 4.0 * (2.0 / 15.0 / 1e5_f64).sqrt() + 1e-5);
        let text = format!("{set} K here is ");
        assert!(frame(&gas).log_lines().iter().any(|line| line.text.contains(&text)));
    }
}

#[test]
fn mean_and_max_speeds_equal_the_reference() {
    // At 300 K and 1e-26 kg, m/s.
    let rms = speed_at(300.0, 1e-26, 1.380_658e-23);
    assert!((rms / 910.161963608676 - 1.0).abs() < 1e-14);
    // Uniform speeds: <v> = sqrt(3)/2 v_rms and v_max = sqrt(3) v_rms; by the mean-speed definition v_max = 2 v_rms.
    let n = 1_000_000.0_f64;
    let at = |speed_distribution, temperature_definition| {
        let config = GasConfig {
            particles: count(1_000_000),
            speed_distribution,
            temperature_definition,
            ..exercise()
        };
        let gas = gas(&config, 5);
        let speeds = channel::<GasSpeeds>(&gas);
        // The density is constant up to v_max: its value is 1/v_max.
        (channel::<GasTemperature>(&gas).mean_speed_m_per_s, 1.0 / speeds.initial_distribution[0])
    };
    let (mean, top) = at(SpeedDistribution::Uniform, TemperatureDefinition::MeanSquare);
    println!("uniform: mean {mean}, v_max {top}");
    // Relative errors: half of sqrt(2/15/N) for <x>/sqrt(<x^2>), half of sqrt(4/5/N) for 1/sqrt(<x^2>).
    assert!((mean / 788.223382042441 - 1.0).abs() < 2.0 * (2.0 / 15.0 / n).sqrt());
    assert!((top / 1576.44676408688 - 1.0).abs() < 2.0 * (4.0 / 5.0 / n).sqrt());
    let (mean, top) = at(SpeedDistribution::Uniform, TemperatureDefinition::MeanSpeed);
    assert!((mean / 910.161963608676 - 1.0).abs() < 1e-13);
    // The relative error of 1/<x> of uniform numbers is sqrt(1/3/N).
    assert!((top / 1820.323927 - 1.0).abs() < 4.0 * (1.0 / 3.0 / n).sqrt());
    let (mean, _) = at(SpeedDistribution::Maxwell, TemperatureDefinition::MeanSquare);
    println!("Maxwell: mean {mean}");
    assert!((mean / 806.610038672962 - 1.0).abs() < 2.0 * ((16.0 / PI - 5.0) / n).sqrt());
}

#[test]
fn max_speed_sets_the_bound_without_rescaling() {
    let config = GasConfig { speed_scale: max_speed(1820.3), ..exercise() };
    let speeds = channel::<GasSpeeds>(&gas(&config, 6));
    assert!(speeds.initial_distribution.iter().all(|&height| height == 1.0 / 1820.3));
    // Every particle is in a bin, so densities times widths add up to one.
    let total: f64 = speeds.density.iter().sum::<f64>() * 1820.3 / 30.0;
    assert!((total - 1.0).abs() < 1e-12);
    let config = GasConfig { speed_distribution: SpeedDistribution::Equal, ..config };
    let measured = channel::<GasTemperature>(&gas(&config, 6));
    assert!((measured.mean_speed_m_per_s / 1820.3 - 1.0).abs() < 1e-15);
}
