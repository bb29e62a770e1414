//! Promise: a gas starts as its configuration says or is refused in words, its frames say what they must, and its value is its
//! own checkpoint.

// What is written in a test is in range, or the test is wrong.
#![allow(clippy::unwrap_used)]

use crate::runs::{advance, frame, gas, kelvin, max_speed, particles, positive, refusal, written};
use kinetoscope_manifest::model::{
    GasConfig, Placement, Propagation, SpeedDistribution, SpeedScale,
};
use kinetoscope_manifest::quantity::Finite;
use kinetoscope_physics::gas::Gas;
use kinetoscope_physics::model::{Extent, Model, Target};
use kinetoscope_physics::random::Seed;
use kinetoscope_recording::channels::{GasLedger, GasPressure, GasSpeeds, GasTemperature};
use kinetoscope_recording::frame::Level;
use kinetoscope_recording::scenery::{DrawnRadius, Wall};

fn centered_at(center: [f64; 2], config: GasConfig) -> GasConfig {
    GasConfig { center_m: center.map(|axis| Finite::new(axis).unwrap()), ..config }
}

fn stepped(time_step: f64) -> Propagation {
    Propagation::Stepped { time_step_s: positive(time_step) }
}

#[test]
fn written_particles_stand_where_they_are_written() {
    let starts = [([0.3, -0.2], [0.7, 0.4]), ([1.0, 0.0], [1.0, 0.0]), ([0.6, 0.8], [-1.0, 0.0])];
    let start = particles(&gas(&written(&starts), 1));
    for (particle, (position, velocity)) in start.iter().zip(starts) {
        // A particle on the wall that moves outwards is shown as written: it hits after frame 0.
        assert_eq!(particle.position, position);
        assert_eq!(particle.velocity, velocity);
    }
    // On the wall but for the rounding of its decimals.
    let near = [([0.7071067811866, 0.7071067811866], [1.0, 1.0])];
    let mut gas = gas(&written(&near), 1);
    advance(&mut gas, Target::Time(1.0));
    assert_eq!(frame(&gas).log_lines().len(), 0);
}

#[test]
fn what_cannot_be_run_is_refused_in_words() {
    let outside = written(&[([0.0, 0.0], [1.0, 0.0]), ([0.8, 0.7], [0.0, 0.0])]);
    assert!(refusal(&outside).contains("particle 1 "), "{}", refusal(&outside));
    // Outside is measured from the center.
    let moved = centered_at([5.0, 0.0], written(&[([0.0, 0.0], [1.0, 0.0])]));
    assert!(refusal(&moved).contains("5 m from the center"));
    let fewer = GasConfig { particles: crate::runs::count(3), ..outside };
    assert!(refusal(&fewer).contains("must agree"));
    let default = GasConfig::default;
    let cases = [
        (GasConfig { placement: Placement::Lattice, ..default() }, "lattice"),
        (GasConfig { speed_scale: SpeedScale::Given, ..default() }, "need a scale"),
        (
            GasConfig {
                speed_distribution: SpeedDistribution::Maxwell,
                speed_scale: max_speed(1.0),
                ..default()
            },
            "no upper bound",
        ),
        (
            GasConfig { speed_scale: max_speed(1.0), ..written(&[([0.0, 0.0], [1.0, 0.0])]) },
            "no law to bound",
        ),
        (
            GasConfig { speed_scale: kelvin(300.0), ..written(&[([0.0, 0.0], [0.0, 0.0])]) },
            "can't be scaled",
        ),
        (GasConfig { propagation: stepped(1.0), ..default() }, "no step fits"),
        (GasConfig { propagation: stepped(1e-30), ..default() }, "can be counted"),
        (GasConfig { duration_s: positive(1e9), ..default() }, "shorten duration_s"),
        (GasConfig { speed_scale: kelvin(1e300), ..default() }, "fastest particle"),
        (GasConfig { radius_m: positive(1e-200), ..default() }, "radius_m"),
        (centered_at([1e12, 0.0], default()), "lose their digits"),
        (written(&[([0.0, 0.0], [1e300, 0.0])]), "fastest particle"),
    ];
    for (config, words) in cases {
        let refusal = refusal(&config);
        assert!(refusal.contains(words), "{refusal}");
    }
}

#[test]
fn at_zero_kelvin_nothing_moves_and_all_numbers_are_defined() {
    for (particles_asked, disc_radius_m) in
        [(1, None), (5, None), (1, Some(positive(0.1))), (5, Some(positive(0.1)))]
    {
        for propagation in [Propagation::Exact, stepped(1e-3)] {
            if disc_radius_m.is_some() && propagation != Propagation::Exact {
                continue;
            }
            let config = GasConfig {
                particles: crate::runs::count(particles_asked),
                speed_scale: kelvin(0.0),
                disc_radius_m,
                propagation,
                ..GasConfig::default()
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
            let ledger: GasLedger = frame.get().unwrap();
            let speeds: GasSpeeds = frame.get().unwrap();
            assert_eq!(pressure.measured_since_start_n_per_m, 0.0);
            assert_eq!(temperature.mean_square_temperature_k, 0.0);
            assert_eq!(ledger.residual_relative, 0.0);
            assert!(ledger.excess_h.is_finite());
            assert!(speeds.density.iter().chain(&speeds.maxwell).all(|value| value.is_finite()));
        }
    }
}

#[test]
fn positions_and_velocities_have_streams_of_their_own() {
    // Another law of speeds leaves the places; another replicate changes both; the same seed gives the same bits.
    let uniform = GasConfig::default();
    let maxwell = GasConfig { speed_distribution: SpeedDistribution::Maxwell, ..uniform.clone() };
    let places = |config, seed| -> Vec<[f64; 2]> {
        particles(&gas(config, seed)).iter().map(|particle| particle.position).collect()
    };
    assert_eq!(places(&uniform, 1), places(&maxwell, 1));
    assert_ne!(places(&uniform, 1), places(&uniform, 2));
    assert_eq!(gas(&uniform, 1), gas(&uniform, 1));
    let replicate = Gas::prepare(&uniform, Seed { seed: 1, replicate: 1 }, false).unwrap();
    assert_ne!(particles(&replicate), particles(&gas(&uniform, 1)));
}

#[test]
fn the_first_frame_says_what_runs() {
    let config = GasConfig { propagation: stepped(1e-4), ..GasConfig::default() };
    let mut gas = gas(&config, 1);
    assert_eq!(gas.extent(), Extent::Steps { total: 1000, step: 1e-4 });
    let first = frame(&gas);
    let said = |words: &str| first.log_lines().iter().any(|line| line.text.contains(words));
    assert!(said("N = 1000 particles"));
    assert!(said("r = 1 m"));
    assert!(said("300 K here is"));
    assert!(said("uniform over the area"));
    // v_max dt / r = 0.18: warned.
    let warning = first.log_lines().iter().find(|line| line.level == Level::Warning).unwrap();
    assert!(warning.text.contains("v_max dt / r = 0.18"), "{}", warning.text);
    assert_eq!(first.state().len(), 4 * 1000);
    let topics: Vec<_> = first.messages().iter().map(|message| message.topic).collect();
    let declared: Vec<_> = Gas::CHANNELS.iter().map(|channel| channel.topic).collect();
    assert_eq!(topics, declared);
    advance(&mut gas, Target::Count(1));
    assert!(frame(&gas).log_lines().is_empty());
}

#[test]
fn the_drawing_is_the_container() {
    let config =
        centered_at([2.0, -1.0], GasConfig { radius_m: positive(0.5), ..GasConfig::default() });
    let scenery = gas(&config, 1).scenery();
    assert_eq!(scenery.walls, [Wall::Circle { center: [2.0, -1.0], radius: 0.5 }]);
    assert_eq!(scenery.view, [[1.5, -1.5], [2.5, -0.5]]);
    assert_eq!(scenery.drawn_radius, DrawnRadius::Fixed(0.006));
    assert!(scenery.arrows);
    let many = GasConfig { particles: crate::runs::count(2001), ..GasConfig::default() };
    assert!(!gas(&many, 1).scenery().arrows);
}

#[test]
fn a_saved_gas_goes_on_with_the_same_bits() {
    for propagation in
        [Propagation::Exact, stepped(1e-4), Propagation::Literal { time_step_s: positive(1e-4) }]
    {
        let mut gas = gas(&GasConfig { propagation, ..GasConfig::default() }, 14);
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
fn looking_changes_nothing_and_time_does_not_run_back() {
    let mut gas = gas(&GasConfig::default(), 1);
    advance(&mut gas, Target::Time(0.05));
    assert_eq!(frame(&gas), frame(&gas));
    assert!(gas.advance(Target::Time(0.04), 1).unwrap_err().0.contains("order of time"));
    assert!(gas.advance(Target::Count(5), 1).unwrap_err().0.contains("by time"));
}
