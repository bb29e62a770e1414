//! Law: with the implicit dashpot, an isolated contact follows v' = (v + k delta dt/m_eff) / (1 + c), and discs with
//! the damping of the DEM exercise, c = 67, come to rest. Explicit dashpots multiply the velocity by 1 - c.
//!
//! Source: backward Euler of the dashpot for an isolated pair, written out here; eta = 1.5e3 N s/m, k = 5e4 N/m and r =
//! 1e-4 m of the DEM exercise.
//! Setup: a head-on pair without gravity, 200 steps; 200 discs of the exercise collapsing for 0.12 s.
//! Tolerance: 1e-12 of the speed for the pair. For the bed, the energy never rises by more than the energy-balance
//! error of 1 %, no overlap reaches half a radius, and the dissipated energy never decreases by more than 1e-6 of the
//! total.
//! Control: `unstable_time_step_is_rejected` rejects an explicit dashpot with the same damping.

use crate::scene::{
    damping, discs, energy, equal, frame, given, gravity, positive, prepared, run_to, time_step,
};
use kinetoscope_manifest::model::{DemConfig, DemDashpot};
use kinetoscope_recording::channels::DemContactStatistics;
use std::num::NonZeroU32;

fn exercise() -> DemConfig {
    DemConfig { dissipation: damping(1.5e3), dashpot: DemDashpot::Implicit, ..DemConfig::default() }
}

#[test]
fn isolated_pair_follows_backward_euler() {
    let config = DemConfig { gravity_m_per_s2: gravity(0.0, 0.0), ..exercise() };
    let pair = [([0.0195, 0.02], [0.5, 0.0]), ([0.020_500_01, 0.02], [-0.5, 0.0])];
    let mut model = prepared(&given(config, &pair));
    let step = time_step(&model);
    let c = 1.5e3 * step / 5e-4;
    let mut max_overlap = 0.0;
    for count in 1..=200 {
        let before = discs(&model);
        let overlap = 1e-3 - (before[1].position[0] - before[0].position[0]);
        let separating =
            |pair: &[crate::scene::Disc]| pair[1].step_velocity[0] - pair[0].step_velocity[0];
        let v = separating(&before);
        let expected =
            if overlap > 0.0 { (v + 5e4 * overlap * step / 5e-4) / (1.0 + c) } else { v };
        run_to(&mut model, count);
        let found = separating(&discs(&model));
        assert!((found - expected).abs() < 1e-12, "step {count}: {found}, expected {expected}");
        max_overlap = if overlap > max_overlap { overlap } else { max_overlap };
    }
    // The contact begins within a step at 1 m/s; one step later 1/(1 + c) of that speed remains, and less after each step.
    assert!(max_overlap > 0.0 && max_overlap < step * (1.0 + 2.0 / c), "{max_overlap:e} m");
}

#[test]
fn exercise_discs_come_to_rest() {
    let config = DemConfig {
        discs: NonZeroU32::new(200).expect("not zero"),
        radius_m: equal(1e-4),
        width_m: positive(0.008),
        ..exercise()
    };
    let mut model = prepared(&config);
    let total = energy(&model).total_j;
    let frames = 24;
    let steps = (0.12 / time_step(&model)) as u64 / frames;
    let mut before = energy(&model);
    for number in 1..=frames {
        run_to(&mut model, steps * number);
        let now = energy(&model);
        assert!(now.dissipated_j - before.dissipated_j > -1e-6 * total, "{now:?}");
        assert!(now.total_j < before.total_j + 1e-2 * total, "{now:?}");
        let contacts: DemContactStatistics = frame(&model).get().expect("contact statistics");
        assert!(contacts.max_overlap_over_radius < 0.5, "{contacts:?}");
        before = now;
    }
    println!(
        "residual {:.1e}, kinetic {:.1e} of the initial energy",
        before.residual_j / total,
        before.kinetic_j / total
    );
    assert!(before.residual_j.abs() < 1e-2 * total, "{before:?}");
    assert!(before.kinetic_j < 1e-3 * total, "{before:?}");
}
