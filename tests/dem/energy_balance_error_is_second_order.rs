//! Law: the energy-balance error decreases with the square of the time step. At N_t = 20 and e = 0.9, the dissipated
//! energy equals the loss of energy within 0.2 % of the energy.
//!
//! Source: sum k delta_n (delta_(n-1) - delta_(n+1))/2 telescopes to one term at each end of the contact, of order k (v
//! dt)^2; its mean over the phases is -(1 - e^2)(w0 dt)^2/6 of the initial energy.
//! Setup: 400 discs against a wall without gravity, at 400 phases of a step; the residual summed over them; N_t = 20,
//! 40, 80, 160; e = 0.5; both tails.
//! Tolerance: order 2 +- 0.02, and 2 % of the formula at N_t = 160, for its next term, of relative order w0 dt.
//! Control: the fit finds order 1 for errors of first order.

use crate::scene::{
    discs, energy, given, gravity, per_contact, positive, prepared, restitution, run_to,
};
use kinetoscope_manifest::model::DemConfig;

const PHASES: u32 = 400;

/// Residual over the initial energy.
fn residual_ratio(requested: f64, tail: bool, steps_per_wall_contact: f64) -> f64 {
    let time_step = std::f64::consts::PI * (1e-3_f64 / 5e4).sqrt() / steps_per_wall_contact;
    let start = |phase: u32| {
        let gap = 1e-5 + time_step * (f64::from(phase) + 0.5) / f64::from(PHASES);
        ([0.001 + 0.002 * f64::from(phase), 5e-4 + gap], [0.0, -1.0])
    };
    let start: Vec<_> = (0..PHASES).map(start).collect();
    let config = DemConfig {
        width_m: positive(1.0),
        gravity_m_per_s2: gravity(0.0, 0.0),
        dissipation: restitution(requested),
        limit_damping: tail,
        time_step: per_contact(steps_per_wall_contact),
        ..DemConfig::default()
    };
    let mut model = prepared(&given(config, &start));
    let before = energy(&model).total_j;
    run_to(&mut model, (4.0 * steps_per_wall_contact) as u64);
    assert!(discs(&model).iter().all(|disc| disc.velocity[1] > 0.0));
    let after = energy(&model);
    let difference = after.dissipated_j - (before - after.total_j);
    assert!(
        (difference - after.residual_j).abs() < 1e-14 * before,
        "the residual is not dissipated minus lost energy: {after:?}"
    );
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
fn residual_is_of_second_order() {
    for tail in [false, true] {
        let points: Vec<(f64, f64)> = [20.0, 40.0, 80.0, 160.0]
            .map(|steps| (steps, residual_ratio(0.5, tail, steps)))
            .to_vec();
        let found = order(&points);
        println!("{tail:?}: order {found:.3}, residuals {points:?}");
        assert!((found - 2.0).abs() < 0.02, "{tail:?}: {found}");
    }
}

#[test]
fn residual_follows_the_formula_of_contact_ends() {
    let step = std::f64::consts::PI / 160.0;
    let expected = -(1.0 - 0.25) * step * step / 6.0;
    let residual = residual_ratio(0.5, false, 160.0);
    println!("residual {residual:e}, formula {expected:e}");
    assert!((residual / expected - 1.0).abs() < 0.02, "{residual:e}");
}

#[test]
fn dissipated_energy_equals_the_loss_within_two_per_mille() {
    for tail in [false, true] {
        let residual = residual_ratio(0.9, tail, 20.0);
        println!("{tail:?}: (dissipated - lost)/initial energy = {residual:.5} at N_t = 20");
        assert!(residual.abs() < 2e-3, "{residual}");
    }
}

#[test]
fn control_first_order_is_not_taken_for_second() {
    let points = [20.0, 40.0, 80.0, 160.0].map(|steps| (steps, 1.0 / steps));
    assert!((order(&points) - 1.0).abs() < 1e-12);
}
