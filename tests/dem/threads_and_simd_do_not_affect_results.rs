//! Guarantee: in every scene, the number of threads, the width of SIMD registers, observation, and serialization
//! of the model change no bit of the results.
//!
//! Source: a run must not depend on the machine; see the invariants in ARCHITECTURE.md.
//! Setup: enough discs for several blocks in a bed, a frictional bed with rolling friction, a periodic bed, a rotating
//! drum, a shaken box, a hopper that discs leave, and insertion onto two materials behind a gate; two gases in a
//! periodic box, of which the larger has too many blocks to store lists of near pairs.
//! Tolerance: none; all bits of the state and of the channels are compared.
//! Control: a friction coefficient that differs by one part in 10^15 and gravity that differs by 1e-12 m/s^2 change the
//! bits.

use crate::scene::{
    frame, gravity, non_negative, per_contact, positive, prepared, restitution, scenes, spring,
};
use kinetoscope_manifest::model::{DemConfig, PeriodicSides, Placement};
use kinetoscope_physics::dem::Dem;
use kinetoscope_physics::model::{Model, Progress, Target};
use std::num::NonZeroU32;

/// Bits of the state and the channels after `steps` steps; `between` is applied to the model every 75 work units.
fn bits(
    steps: u64,
    config: &DemConfig,
    threads: usize,
    max_width: usize,
    between: fn(Dem) -> Dem,
) -> Vec<u64> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    pool.install(|| {
        let mut model = prepared(config).with_max_width(max_width);
        for target in [steps / 2, steps] {
            while let Progress::Working =
                model.advance(Target::Count(target), 75).unwrap_or_else(|fault| panic!("{fault}"))
            {
                model = between(model).with_max_width(max_width);
            }
            model = between(model).with_max_width(max_width);
        }
        let frame = frame(&model);
        let messages = frame.messages().flat_map(|message| message.payload.iter());
        let state = frame.state().iter().map(|value| value.to_bits());
        state.chain(messages.map(|byte| u64::from(*byte))).collect()
    })
}

fn unchanged(model: Dem) -> Dem {
    model
}

fn observed(model: Dem) -> Dem {
    frame(&model);
    model
}

fn serialized(model: Dem) -> Dem {
    let value = serde_json::to_value(&model).expect("a model can be serialized");
    serde_json::from_value(value).expect("a serialized model can be read")
}

#[test]
fn results_are_independent_of_threads_simd_observation_and_serialization() {
    for (name, config) in scenes() {
        let reference = bits(300, &config, 1, 8, unchanged);
        assert!(reference == bits(300, &config, 2, 8, unchanged), "{name}: two threads");
        assert!(reference == bits(300, &config, 1, 4, unchanged), "{name}: registers of four");
        assert!(reference == bits(300, &config, 1, 1, unchanged), "{name}: scalar");
        assert!(reference == bits(300, &config, 1, 8, observed), "{name}: observed");
        assert!(reference == bits(300, &config, 2, 1, serialized), "{name}: serialized");
    }
}

/// Covers the separate loop for discs without any force and the comparison of near pairs, which SIMD evaluation alone uses.
#[test]
fn gas_results_are_independent_of_simd() {
    for (discs, steps) in [(6001, 400), (210_000, 40)] {
        // Packing fraction 0.3, r 0.5 mm.
        let side = 5e-4 * (std::f64::consts::PI * f64::from(discs) / 0.3).sqrt();
        let gas = DemConfig {
            discs: NonZeroU32::new(discs).unwrap(),
            radius_m: crate::scene::equal(5e-4),
            width_m: positive(side),
            height_m: positive(side),
            gravity_m_per_s2: gravity(0.0, 0.0),
            elasticity: spring(5e6),
            dissipation: restitution(0.9),
            time_step: per_contact(20.0),
            periodic: PeriodicSides::Both,
            placement: Placement::Lattice,
            velocity_std_m_per_s: Some(positive(3.0)),
            ..DemConfig::default()
        };
        let reference = bits(steps, &gas, 2, 8, unchanged);
        assert!(reference == bits(steps, &gas, 2, 1, unchanged), "{discs} discs");
    }
}

#[test]
fn control_tiny_parameter_change_alters_bits() {
    let (_, config) = scenes().swap_remove(1);
    let other = DemConfig { friction: non_negative(0.5 * (1.0 + 1e-15)), ..config.clone() };
    assert!(bits(300, &config, 1, 8, unchanged) != bits(300, &other, 1, 8, unchanged));
    let tilted = DemConfig { gravity_m_per_s2: gravity(1e-12, -9.81), ..config.clone() };
    assert!(bits(300, &config, 1, 8, unchanged) != bits(300, &tilted, 1, 8, unchanged));
}
