//! Promise: one thread or two, four pairs at a time or one, looked at or not, put away and taken up again or not: the same
//! bits, for every kind of scene.
//!
//! Setup: enough discs for several blocks; a bed, a rubbing bed with rolling friction, a periodic one, a drum that turns, a shaken
//! box, a hopper that loses discs, rain on two materials behind a gate; gases in a periodic box, of which the larger has so many blocks that it keeps no near pairs.

use crate::scene::{
    frame, gravity, non_negative, per_contact, positive, prepared, restitution, scenes,
};
use kinetoscope_manifest::model::{DemConfig, PeriodicSides, Placement};
use kinetoscope_physics::dem::Dem;
use kinetoscope_physics::model::{Model, Progress, Target};
use std::num::NonZeroU32;

/// Bits of all numbers of the state and the channels after so many steps; every 75 steps something is done to the model.
fn bits(
    steps: u64,
    config: &DemConfig,
    threads: usize,
    lanes: bool,
    between: fn(Dem) -> Dem,
) -> Vec<u64> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    pool.install(|| {
        let mut model = prepared(config).with_lanes(lanes);
        for target in [steps / 2, steps] {
            while let Progress::Working =
                model.advance(Target::Count(target), 75).unwrap_or_else(|fault| panic!("{fault}"))
            {
                model = between(model).with_lanes(lanes);
            }
            model = between(model).with_lanes(lanes);
        }
        let seen = frame(&model);
        let messages = seen.messages().iter().flat_map(|message| message.payload.iter());
        let state = seen.state().iter().map(|value| value.to_bits());
        state.chain(messages.map(|byte| u64::from(*byte))).collect()
    })
}

fn let_alone(model: Dem) -> Dem {
    model
}

fn looked_at(model: Dem) -> Dem {
    frame(&model);
    model
}

fn stored(model: Dem) -> Dem {
    let value = serde_json::to_value(&model).expect("a model can be stored");
    serde_json::from_value(value).expect("and taken up")
}

#[test]
fn threads_lanes_looks_and_checkpoints_leave_no_trace() {
    for (name, config) in scenes() {
        let whole = bits(300, &config, 1, true, let_alone);
        assert!(whole == bits(300, &config, 2, true, let_alone), "{name}: two threads");
        assert!(whole == bits(300, &config, 1, false, let_alone), "{name}: pair by pair");
        assert!(whole == bits(300, &config, 1, true, looked_at), "{name}: looked at");
        assert!(whole == bits(300, &config, 2, false, stored), "{name}: stored");
    }
}

/// Discs on which nothing acts fly free in a pass of their own, and only near pairs are compared, where lanes are in use.
#[test]
fn a_gas_has_the_bits_of_pairs_one_by_one() {
    for (discs, steps) in [(6001, 400), (210_000, 40)] {
        // Packing fraction 0.3, r 0.5 mm.
        let side = 5e-4 * (std::f64::consts::PI * f64::from(discs) / 0.3).sqrt();
        let gas = DemConfig {
            discs: NonZeroU32::new(discs).unwrap(),
            radius_m: crate::scene::equal(5e-4),
            width_m: positive(side),
            height_m: positive(side),
            gravity_m_per_s2: gravity(0.0, 0.0),
            stiffness_n_per_m: positive(5e6),
            dissipation: restitution(0.9),
            time_step: per_contact(20.0),
            periodic: PeriodicSides::Both,
            placement: Placement::Lattice,
            velocity_deviation_m_per_s: Some(positive(3.0)),
            ..DemConfig::default()
        };
        let whole = bits(steps, &gas, 2, true, let_alone);
        assert!(whole == bits(steps, &gas, 2, false, let_alone), "{discs}");
    }
}

/// Control: the bits tell a difference of one part in 10^15 of a parameter.
#[test]
fn another_friction_is_noticed() {
    let (_, config) = scenes().swap_remove(1);
    let other = DemConfig { friction: non_negative(0.5 * (1.0 + 1e-15)), ..config.clone() };
    assert!(bits(300, &config, 1, true, let_alone) != bits(300, &other, 1, true, let_alone));
    let tilted = DemConfig { gravity_m_per_s2: gravity(1e-12, -9.81), ..config.clone() };
    assert!(bits(300, &config, 1, true, let_alone) != bits(300, &tilted, 1, true, let_alone));
}
