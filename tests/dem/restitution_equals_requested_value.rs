//! Law: the restitution obtained is the one wanted, |e - wanted| <= A w0 dt, for every phase of the step at which a contact
//! begins, either tail, discs and walls, equal and unequal masses; and a pair keeps its momentum.
//!
//! Source: the bands at e = 0.9 with the attractive tail against a wall are an independent program's over 1000 phases
//! (N_t 20: mean 0.89985, [0.8986, 0.9095]; 50: 0.89991, [0.8997, 0.9036]). The first step of a contact lasts between
//! nothing and dt, so the error is of first order in w0 dt; A = 0.3 bounds its factor for any e and either tail, as
//! `tests/dem/restitution_of_fifty_draws.rs` derives.
//! Setup: 1000 collisions side by side in one box without gravity, each begun 1/1000 of a step later.
//! Tolerance: one unit of the bands' last digit for the scatter's ends; A w0 dt; momentum to rounding, 1e-14.

use crate::scene::{
    Disc, discs, given, gravity, per_contact, positive, prepared, restitution, run_to, time_step,
};
use kinetoscope_manifest::model::{DemConfig, DiscRadius, ForceTail};
use std::f64::consts::PI;

const PHASES: u32 = 1000;
const SPEED: f64 = 1.0;
const MASS: f64 = 1e-3;
const STIFFNESS: f64 = 5e4;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Against {
    Wall,
    Pair,
}

struct Scatter {
    mean: f64,
    least: f64,
    most: f64,
}

fn config(wanted: f64, tail: ForceTail, steps_per_contact: f64) -> DemConfig {
    DemConfig {
        width_m: positive(2.1),
        gravity_m_per_s2: gravity(0.0, 0.0),
        dissipation: restitution(wanted),
        force_tail: tail,
        time_step: per_contact(steps_per_contact),
        ..DemConfig::default()
    }
}

fn collisions(against: Against, wanted: f64, tail: ForceTail, steps: f64) -> Scatter {
    let time_step = PI * (MASS / STIFFNESS).sqrt() / steps;
    let start = |phase: u32| {
        let gap = 1e-5 + SPEED * time_step * (f64::from(phase) + 0.5) / f64::from(PHASES);
        let x = 0.001 + 0.002 * f64::from(phase);
        match against {
            Against::Wall => vec![([x, 5e-4 + gap], [0.0, -SPEED])],
            Against::Pair => {
                let half = 0.5 * SPEED;
                vec![([x, 0.02], [0.0, half]), ([x, 0.021 + gap], [0.0, -half])]
            }
        }
    };
    let places: Vec<_> = (0..PHASES).flat_map(start).collect();
    let mut model = prepared(&given(config(wanted, tail, steps), &places));
    // An overdamped end of a contact takes longest: five undamped contacts are enough from e = 0.2 on.
    run_to(&mut model, (5.0 * steps) as u64);
    let end = discs(&model);
    let obtained: Vec<f64> = match against {
        Against::Wall => end.iter().map(|disc| disc.velocity[1] / SPEED).collect(),
        Against::Pair => {
            end.chunks(2).map(|pair| (pair[1].velocity[1] - pair[0].velocity[1]) / SPEED).collect()
        }
    };
    let mut scatter = Scatter { mean: 0.0, least: obtained[0], most: obtained[0] };
    for &e in &obtained {
        scatter.mean += e / f64::from(PHASES);
        scatter.least = if e < scatter.least { e } else { scatter.least };
        scatter.most = if e > scatter.most { e } else { scatter.most };
    }
    scatter
}

#[test]
fn the_scatter_over_phases_is_the_independent_programs() {
    for (steps, mean, least, most) in
        [(20.0, 0.899_85, 0.8986, 0.9095), (50.0, 0.899_91, 0.8997, 0.9036)]
    {
        let found = collisions(Against::Wall, 0.9, ForceTail::Attractive, steps);
        println!("N_t {steps}: {:.5} [{:.5}, {:.5}]", found.mean, found.least, found.most);
        assert!((found.mean - mean).abs() < 2e-5, "mean {}", found.mean);
        assert!((found.least - least).abs() < 1e-4, "least {}", found.least);
        assert!((found.most - most).abs() < 1e-4, "most {}", found.most);
    }
}

/// Largest |e - wanted| over w0 dt of all cases.
fn worst(tail: ForceTail) -> f64 {
    let mut worst = 0.0;
    for (against, effective_mass) in [(Against::Wall, MASS), (Against::Pair, 0.5 * MASS)] {
        for wanted in [0.9, 0.8, 0.5, 0.2] {
            for steps in [20.0, 50.0] {
                let found = collisions(against, wanted, tail, steps);
                let step = PI * (MASS / effective_mass).sqrt() / steps;
                for error in [found.most - wanted, wanted - found.least] {
                    worst = if error / step > worst { error / step } else { worst };
                }
            }
        }
    }
    worst
}

#[test]
fn the_error_is_of_first_order_in_the_time_step() {
    for (tail, bound) in [(ForceTail::Attractive, 0.3), (ForceTail::Clamped, 0.3)] {
        let worst = worst(tail);
        println!("{tail:?}: |e - wanted| <= {worst:.4} w0 dt");
        assert!(worst < bound, "{tail:?}: {worst}");
    }
}

/// Control: the damping ratio of the other tail gives another restitution, outside the bound at N_t = 50.
#[test]
fn the_other_tails_dashpot_is_noticed() {
    let step = PI / 50.0;
    // 0.5 by the clamped formula is 0.43 with the attractive tail: see the table of damping ratios.
    let found = collisions(Against::Wall, 0.434, ForceTail::Attractive, 50.0);
    assert!((found.mean - 0.5).abs() > 0.1 * step);
}

#[test]
fn unequal_discs_have_the_same_restitution_and_keep_their_momentum() {
    // The radius of 1e-4 m, where 5e-4 m has the mean mass.
    const LIGHTEST: f64 = MASS / 25.0;
    for tail in [ForceTail::Attractive, ForceTail::Clamped] {
        let config = DemConfig {
            radius_m: DiscRadius::Uniform { min: positive(1e-4), max: positive(9e-4) },
            stiffness_n_per_m: positive(1e6),
            ..config(0.6, tail, 50.0)
        };
        let pair = |number: u32| {
            let x = 0.002 + 0.004 * f64::from(number);
            [([x, 0.02], [0.0, 0.5]), ([x, 0.022], [0.0, -0.5])]
        };
        let places: Vec<_> = (0..100).flat_map(pair).collect();
        let mut model = prepared(&given(config, &places));
        let before = discs(&model);
        // Until the smallest gap's and the largest's pair have met: at most 1.8 mm at 1 m/s, and the contact itself.
        let steps = (4e-3 / time_step(&model)) as u64;
        run_to(&mut model, steps);
        let after = discs(&model);
        // Areal density: the mean radius has the mean mass.
        let mass = |disc: &Disc| MASS * disc.radius * disc.radius / (5e-4 * 5e-4);
        let (mut largest_ratio, mut largest_error) = (1.0, 0.0);
        for (before, after) in before.chunks(2).zip(after.chunks(2)) {
            let masses = [mass(&before[0]), mass(&before[1])];
            let momentum =
                |pair: &[Disc]| masses[0] * pair[0].velocity[1] + masses[1] * pair[1].velocity[1];
            let change = momentum(after) - momentum(before);
            assert!(change.abs() < 1e-14 * (masses[0] + masses[1]), "{change:e}");
            let error: f64 = after[1].velocity[1] - after[0].velocity[1] - 0.6;
            // dt goes by the lightest disc that is allowed, w0 by the pair.
            let effective_mass = masses[0] * masses[1] / (masses[0] + masses[1]);
            let step = PI * (LIGHTEST / effective_mass).sqrt() / 50.0;
            assert!(error.abs() < 0.3 * step, "{masses:?}: {error}");
            let ratio = masses[1] / masses[0];
            largest_ratio = if ratio > largest_ratio { ratio } else { largest_ratio };
            largest_error = if error.abs() > largest_error { error.abs() } else { largest_error };
        }
        println!(
            "{tail:?}: mass ratios up to {largest_ratio:.1}, |e - 0.6| up to {largest_error:.1e}"
        );
        assert!(largest_ratio > 10.0);
    }
}
