//! Law: the ledger's residual falls with the square of the time step, and at N_t = 20 and e = 0.9 what the dashpots took is the
//! loss of energy within 0.2 % of the energy.
//!
//! Source: sum k delta_n (delta_(n-1) - delta_(n+1))/2 telescopes to a term of each end of the contact, of the order
//! k (v dt)^2, whose mean over the phases is -(1 - e^2)(w0 dt)^2/6 of the energy before.
//! Setup: 400 discs against a wall without gravity, each 1/400 of a step later; the residual summed over them; N_t 20, 40,
//! 80, 160; e = 0.5; both tails.
//! Tolerance: order 2 +- 0.02 and 2 % of the formula at N_t = 160, for its next term, w0 dt.

use crate::scene::{
    discs, energy, given, gravity, per_contact, positive, prepared, restitution, run_to,
};
use kinetoscope_manifest::model::{DemConfig, ForceTail};

const PHASES: u32 = 400;

/// Residual over the energy at the start.
fn ledger(wanted: f64, tail: ForceTail, steps_per_contact: f64) -> f64 {
    let time_step = std::f64::consts::PI * (1e-3_f64 / 5e4).sqrt() / steps_per_contact;
    let place = |phase: u32| {
        let gap = 1e-5 + time_step * (f64::from(phase) + 0.5) / f64::from(PHASES);
        ([0.001 + 0.002 * f64::from(phase), 5e-4 + gap], [0.0, -1.0])
    };
    let places: Vec<_> = (0..PHASES).map(place).collect();
    let config = DemConfig {
        width_m: positive(1.0),
        gravity_m_per_s2: gravity(0.0, 0.0),
        dissipation: restitution(wanted),
        force_tail: tail,
        time_step: per_contact(steps_per_contact),
        ..DemConfig::default()
    };
    let mut model = prepared(&given(config, &places));
    let before = energy(&model).total_j;
    run_to(&mut model, (4.0 * steps_per_contact) as u64);
    assert!(discs(&model).iter().all(|disc| disc.velocity[1] > 0.0));
    let after = energy(&model);
    let unaccounted = after.dissipated_j - (before - after.total_j);
    assert!((unaccounted - after.residual_j).abs() < 1e-14 * before, "no ledger: {after:?}");
    after.residual_j / before
}

/// Slope of log |residual| against log N_t, by least squares.
fn order(points: &[(f64, f64)]) -> f64 {
    let count = points.len() as f64;
    let logs: Vec<[f64; 2]> =
        points.iter().map(|p| [libm::log(p.0), libm::log(p.1.abs())]).collect();
    let mean = [0, 1].map(|axis| logs.iter().map(|log| log[axis]).sum::<f64>() / count);
    let moment = |axis: usize| -> f64 {
        logs.iter().map(|log| (log[0] - mean[0]) * (log[axis] - mean[axis])).sum()
    };
    -moment(1) / moment(0)
}

#[test]
fn the_residual_is_of_second_order() {
    for tail in [ForceTail::Attractive, ForceTail::Clamped] {
        let points: Vec<(f64, f64)> =
            [20.0, 40.0, 80.0, 160.0].map(|steps| (steps, ledger(0.5, tail, steps))).to_vec();
        let found = order(&points);
        println!("{tail:?}: order {found:.3}, residuals {points:?}");
        assert!((found - 2.0).abs() < 0.02, "{tail:?}: {found}");
    }
}

#[test]
fn the_residual_is_the_one_of_both_ends_of_a_contact() {
    let step = std::f64::consts::PI / 160.0;
    let expected = -(1.0 - 0.25) * step * step / 6.0;
    let residual = ledger(0.5, ForceTail::Attractive, 160.0);
    println!("residual {residual:e}, formula {expected:e}");
    assert!((residual / expected - 1.0).abs() < 0.02, "{residual:e}");
}

#[test]
fn dissipated_energy_is_the_loss_within_two_thousandths_of_the_energy() {
    for tail in [ForceTail::Attractive, ForceTail::Clamped] {
        let residual = ledger(0.9, tail, 20.0);
        println!("{tail:?}: dissipated - loss = {residual:.5} of the energy at N_t = 20");
        assert!(residual.abs() < 2e-3, "{residual}");
    }
}

/// Control: a residual that falls with the first power is not taken for the second.
#[test]
fn the_fit_tells_first_order() {
    let points = [20.0, 40.0, 80.0, 160.0].map(|steps| (steps, 1.0 / steps));
    assert!((order(&points) - 1.0).abs() < 1e-12);
}
