//! Guarantee: the initial state of a gas follows its configuration, or the configuration is rejected; its first frame
//! describes the run, and a serialized gas continues with the same bits.
//!
//! Setup: default, given and invalid configurations.
//! Tolerance: none.
//! Control: another seed and another replicate have other positions.

// Values written in a test are in range.
#![allow(clippy::unwrap_used)]

use crate::runs::{
    advance, channel, exercise, frame, gas, given, kelvin, max_speed, particles, positive,
    rejection,
};
use kinetoscope_manifest::model::{GasConfig, Propagation, SpeedDistribution, SpeedScale};
use kinetoscope_manifest::quantity::Finite;
use kinetoscope_physics::gas::Gas;
use kinetoscope_physics::model::{Extent, Model, Target};
use kinetoscope_physics::random::Seed;
use kinetoscope_recording::channels::{GasEnergyBalance, GasPressure, GasSpeeds, GasTemperature};
use kinetoscope_recording::frame::Level;
use kinetoscope_recording::scenery::{DrawnRadius, Wall};

fn centered_at(center: [f64; 2], config: GasConfig) -> GasConfig {
    GasConfig { center_m: center.map(|axis| Finite::new(axis).unwrap()), ..config }
}

fn stepped(time_step: f64) -> Propagation {
    Propagation::TimeStepped { time_step_s: positive(time_step) }
}

#[test]
fn given_particles_have_the_given_positions() {
    let starts = [([0.3, -0.2], [0.7, 0.4]), ([1.0, 0.0], [1.0, 0.0]), ([0.6, 0.8], [-1.0, 0.0])];
    let start = particles(&gas(&given(&starts), 1));
    for (particle, (position, velocity)) in start.iter().zip(starts) {
        // A particle on the wall that moves outward is recorded as given; it collides after frame 0.
        assert_eq!(particle.position, position);
        assert_eq!(particle.velocity, velocity);
    }
    // On the wall up to the rounding of the decimals.
    let near = [([0.7071067811866, 0.7071067811866], [1.0, 1.0])];
    let mut gas = gas(&given(&near), 1);
    advance(&mut gas, Target::Time(1.0));
    assert_eq!(frame(&gas).log_lines().len(), 0);
}

#[test]
fn invalid_configurations_are_rejected() {
    let outside = given(&[([0.0, 0.0], [1.0, 0.0]), ([0.8, 0.7], [0.0, 0.0])]);
    assert!(rejection(&outside).contains("particle 1 "), "{}", rejection(&outside));
    // The distance is measured from the center.
    let moved = centered_at([5.0, 0.0], given(&[([0.0, 0.0], [1.0, 0.0])]));
    assert!(rejection(&moved).contains("5 m from the center"));
    let fewer = GasConfig { particles: crate::runs::count(3), ..outside };
    assert!(rejection(&fewer).contains("make the three numbers equal"));
    let default = exercise;
    let cases = [
        (GasConfig { speed_scale: SpeedScale::Given, ..default() }, "must have a scale"),
        (
            GasConfig {
                speed_distribution: SpeedDistribution::Maxwell,
                speed_scale: max_speed(1.0),
                ..default()
            },
            "no upper bound",
        ),
        (
            GasConfig { speed_scale: max_speed(1.0), ..given(&[([0.0, 0.0], [1.0, 0.0])]) },
            "cannot be used with given velocities",
        ),
        (
            GasConfig { speed_scale: kelvin(300.0), ..given(&[([0.0, 0.0], [0.0, 0.0])]) },
            "cannot be scaled",
        ),
        (GasConfig { duration_s: positive(1e9), ..default() }, "shorten duration_s"),
        (GasConfig { speed_scale: kelvin(1e300), ..default() }, "fastest particle"),
        (given(&[([0.0, 0.0], [1e300, 0.0])]), "fastest particle"),
    ];
    for (config, text) in cases {
        let message = rejection(&config);
        assert!(message.contains(text), "{message}");
    }
}

#[test]
fn at_zero_kelvin_all_particles_rest_and_all_numbers_are_finite() {
    for (number, disc_radius_m) in
        [(1, None), (5, None), (1, Some(positive(0.1))), (5, Some(positive(0.1)))]
    {
        for propagation in [Propagation::Exact, stepped(1e-3)] {
            if disc_radius_m.is_some() && propagation != Propagation::Exact {
                continue;
            }
            let config = GasConfig {
                particles: crate::runs::count(number),
                speed_scale: kelvin(0.0),
                disc_radius_m,
                propagation,
                ..exercise()
            };
            let mut gas = gas(&config, 1);
            let before = particles(&gas);
            match propagation {
                Propagation::Exact => advance(&mut gas, Target::Time(0.1)),
                _ => advance(&mut gas, Target::Count(100)),
            }
            assert_eq!(particles(&gas), before);
            let frame = frame(&gas);
            let pressure: GasPressure = frame.get().unwrap();
            let temperature: GasTemperature = frame.get().unwrap();
            let energy_balance: GasEnergyBalance = frame.get().unwrap();
            let speeds: GasSpeeds = frame.get().unwrap();
            assert_eq!(pressure.measured_since_start_n_per_m, 0.0);
            assert_eq!(temperature.mean_square_temperature_k, 0.0);
            assert_eq!(energy_balance.residual_relative, 0.0);
            assert!(energy_balance.relative_entropy.is_finite());
            assert!(speeds.density.iter().chain(&speeds.maxwell).all(|value| value.is_finite()));
        }
    }
}

#[test]
fn positions_and_velocities_have_separate_random_streams() {
    // Another speed distribution does not change the positions; another replicate changes both; the same seed gives the
    // same bits.
    let uniform = exercise();
    let maxwell = GasConfig { speed_distribution: SpeedDistribution::Maxwell, ..uniform.clone() };
    let positions = |config, seed| -> Vec<[f64; 2]> {
        particles(&gas(config, seed)).iter().map(|particle| particle.position).collect()
    };
    assert_eq!(positions(&uniform, 1), positions(&maxwell, 1));
    assert_ne!(positions(&uniform, 1), positions(&uniform, 2));
    assert_eq!(gas(&uniform, 1), gas(&uniform, 1));
    let replicate = Gas::prepare(&uniform, Seed { seed: 1, replicate: 1 }, false).unwrap();
    assert_ne!(particles(&replicate), particles(&gas(&uniform, 1)));
}

#[test]
fn first_frame_describes_the_run() {
    let config = GasConfig { propagation: stepped(1e-4), ..exercise() };
    let mut gas = gas(&config, 1);
    assert_eq!(gas.extent(), Extent::Steps { total: 1000, step: 1e-4 });
    let first = frame(&gas);
    let has_text = |text: &str| first.log_lines().iter().any(|line| line.text.contains(text));
    assert!(has_text("N = 1000 particles"));
    assert!(has_text("r = 1 m"));
    assert!(has_text("300 K here is"));
    assert!(has_text("uniform over the area"));
    // v_max dt / r = 0.18 causes a warning.
    let warning = first.log_lines().iter().find(|line| line.level == Level::Warning).unwrap();
    assert!(warning.text.contains("v_max dt / r = 0.18"), "{}", warning.text);
    assert_eq!(first.state().len(), 4 * 1000);
    let topics: Vec<_> = first.messages().map(|message| message.topic).collect();
    let declared = Gas::kind().channels.iter().filter(|channel| !channel.opt_in);
    let declared: Vec<_> = declared.map(|channel| channel.topic).collect();
    assert_eq!(topics, declared);
    advance(&mut gas, Target::Count(1));
    assert!(frame(&gas).log_lines().is_empty());
}

/// Before the first frame interval, nothing was measured: a zero would be a wrong value and stretch the axes of plots.
#[test]
fn pressure_of_the_start_is_not_a_number() {
    let measured = |gas: &Gas| {
        let pressure = channel::<GasPressure>(gas);
        [
            pressure.measured_n_per_m,
            pressure.measured_since_start_n_per_m,
            pressure.pressure_over_mean_square_formula,
            pressure.window_pressure_over_mean_square_formula,
        ]
    };
    let mut gas = gas(&exercise(), 1);
    // The bits are those of one constant, so that recordings are byte-identical.
    assert_eq!(measured(&gas).map(f64::to_bits), [f64::NAN.to_bits(); 4]);
    advance(&mut gas, Target::Time(0.05));
    assert!(measured(&gas).iter().all(|value| *value > 0.0));
}

#[test]
fn scenery_shows_the_container() {
    let config = centered_at([2.0, -1.0], GasConfig { radius_m: positive(0.5), ..exercise() });
    let scenery = gas(&config, 1).scenery();
    assert_eq!(scenery.walls, [Wall::Circle { center: [2.0, -1.0], radius: 0.5 }]);
    assert_eq!(scenery.view, [[1.5, -1.5], [2.5, -0.5]]);
    assert_eq!(scenery.drawn_radius, DrawnRadius::Fixed(0.006));
    assert!(scenery.arrows);
    let many = GasConfig { particles: crate::runs::count(2001), ..exercise() };
    assert!(!gas(&many, 1).scenery().arrows);
}

#[test]
fn resumed_gas_is_bitwise_identical() {
    for propagation in
        [Propagation::Exact, stepped(1e-4), Propagation::AsPrinted { time_step_s: positive(1e-4) }]
    {
        let mut gas = gas(&GasConfig { propagation, ..exercise() }, 14);
        advance(&mut gas, Target::Time(0.03));
        let saved = serde_json::to_value(&gas).unwrap();
        let mut restored: Gas = serde_json::from_value(saved).unwrap();
        assert_eq!(restored, gas);
        advance(&mut gas, Target::Time(0.1));
        advance(&mut restored, Target::Time(0.1));
        assert_eq!(frame(&restored), frame(&gas));
        assert_eq!(restored, gas);
    }
}

#[test]
fn observation_changes_nothing_and_time_cannot_decrease() {
    let mut gas = gas(&exercise(), 1);
    advance(&mut gas, Target::Time(0.05));
    assert_eq!(frame(&gas), frame(&gas));
    assert!(gas.advance(Target::Time(0.04), 1).unwrap_err().recorded().contains("order of time"));
    assert!(gas.advance(Target::Count(5), 1).unwrap_err().recorded().contains("by time"));
}
