//! Law: with the attractive tail, a collision lasts pi/w and overlaps by at most (v/w0) exp[-(b/w) acos(zeta)]; with
//! the clamped tail, its force ends after 2 acos(zeta)/w.
//!
//! Source: the damped oscillator k delta + eta delta' + m delta'' = 0 with delta = 0, delta' = v at first contact.
//! delta is zero again after half a period; k delta + eta delta' = 0 at the phase given by the argument of (b + i w)^2.
//! Setup: a disc against the floor at 1 m/s, e = 0.5, without gravity, N_t = 2000; one frame per step.
//! Tolerance: two of 2000 steps for both ends of a contact; 1e-3 of the overlap for the phase of its first step.
//! Control: a stiffness larger by 1 % changes duration and overlap by more than the tolerances.

use crate::scene::{
    discs, frame, given, gravity, per_contact, prepared, restitution, run_to, spring, time_step,
};
use kinetoscope_manifest::model::DemConfig;

const RADIUS: f64 = 5e-4;

/// Duration of the nonzero force, s, and largest overlap, m.
fn contact(tail: bool, stiffness: f64) -> (f64, f64) {
    let config = DemConfig {
        gravity_m_per_s2: gravity(0.0, 0.0),
        elasticity: spring(stiffness),
        dissipation: restitution(0.5),
        limit_damping: tail,
        time_step: per_contact(2000.0),
        ..DemConfig::default()
    };
    let mut model = prepared(&given(config, &[([0.02, RADIUS + 1e-6], [0.0, -1.0])]));
    let (mut steps, mut max_overlap) = (0_u32, 0.0);
    for step in 1..=2500 {
        run_to(&mut model, step);
        steps += u32::from(frame(&model).contacts().iter().any(|line| line.force != 0.0));
        let overlap = RADIUS - discs(&model)[0].position[1];
        max_overlap = if overlap > max_overlap { overlap } else { max_overlap };
    }
    (f64::from(steps) * time_step(&model), max_overlap)
}

#[test]
fn duration_and_max_overlap_follow_the_damped_oscillator() {
    let natural_frequency = (5e4_f64 / 1e-3).sqrt();
    // Damping ratios for e = 0.5 from the table in `restitution_follows_from_damping_ratio` (50-digit arithmetic).
    for (tail, zeta) in [(false, 0.215_453_76), (true, 0.255_275_64)] {
        let damped = natural_frequency * libm::sqrt(1.0 - zeta * zeta);
        let expected = match tail {
            false => std::f64::consts::PI / damped,
            true => 2.0 * libm::acos(zeta) / damped,
        };
        let overlap =
            libm::exp(-zeta * natural_frequency / damped * libm::acos(zeta)) / natural_frequency;
        let (duration, max_overlap) = contact(tail, 5e4);
        println!(
            "{tail:?}: {duration:e} s, formula {expected:e}; {max_overlap:e} m, formula {overlap:e}"
        );
        let step = std::f64::consts::PI / natural_frequency / 2000.0;
        assert!((duration - expected).abs() < 2.0 * step);
        assert!((max_overlap / overlap - 1.0).abs() < 1e-3);
        // Control.
        let (duration, max_overlap) = contact(tail, 5.05e4);
        assert!((duration - expected).abs() > 2.0 * step);
        assert!((max_overlap / overlap - 1.0).abs() > 1e-3);
    }
}
