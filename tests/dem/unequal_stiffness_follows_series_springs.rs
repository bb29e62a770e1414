//! Law: two discs of the stiffness ratios a and b collide as on two springs in series, k = 2 a b/(a + b) of the manifest's; for spheres,
//! 1/E* is the sum of both (1 - nu^2)/E. The restitution is e^2 = (e_a^2 b + e_b^2 a)/(a + b). Walls have the ratio 1.
//!
//! Source: half a period of an oscillator, T = pi sqrt(m/k) and delta = v sqrt(m/k); Landau and Lifshitz, Theory of Elasticity, section 9;
//! Coaplen, Stronge and Ravani, Int. J. Impact Eng. 30 (2004) 581.
//! Setup: head-on pairs and single discs without gravity, at 2000 steps per contact of the stiffest materials; 50 random draws of both ratios
//! (0.1 to 10), restitutions (0.1 to 1) and steps per contact (20 to 200), with either tail. Materials are drawn at random; replicates are
//! searched for the required pair.
//! Tolerance: two steps of the duration, 1e-5 of the overlap; 0.3 h + h^2/2 with h = dt sqrt(k/m) for the restitution (see
//! `restitution_is_correct_for_random_parameters`).
//! Control: the arithmetic mean of both stiffnesses, a restitution that is mixed as for equal ones, and 0.9 of it exceed the tolerances.

use crate::scene::{
    SEED, discs, frame, given, gravity, material, per_contact, positive, prepared, restitution,
    run_to, spring, time_step,
};
use kinetoscope_manifest::model::{DemConfig, DemContactPair, DemMaterial, Elasticity};
use kinetoscope_manifest::quantity::Positive;
use kinetoscope_physics::dem::Dem;
use kinetoscope_physics::dem::restitution::damping_ratio;
use kinetoscope_physics::model::Model;
use kinetoscope_physics::random::{Seed, Stream};
use std::f64::consts::PI;

const STIFFNESS: f64 = 5e5;
const MODULUS: f64 = 1e9;
const RADIUS: f64 = 5e-4;
const MASS: f64 = 1e-3;
const SPEED: f64 = 0.5;
const RATIOS: [f64; 2] = [0.2, 3.0];

/// A material of a density ratio, restitution and stiffness ratio.
fn stiff(name: &str, density: f64, requested: f64, ratio: f64) -> DemMaterial {
    let mut material = material(name, requested, 0.0);
    material.density_ratio = positive(density);
    material.constants.stiffness_ratio = Positive::new(ratio);
    material
}

fn two(ratios: [f64; 2], restitutions: [f64; 2]) -> DemConfig {
    DemConfig {
        gravity_m_per_s2: gravity(0.0, 0.0),
        elasticity: spring(STIFFNESS),
        materials: vec![
            stiff("a", 1.0, restitutions[0], ratios[0]),
            stiff("b", 2.0, restitutions[1], ratios[1]),
        ],
        time_step: per_contact(2000.0),
        ..DemConfig::default()
    }
}

/// A disc of each material that approach each other at a gap.
fn pair(config: &DemConfig, gap: f64) -> Dem {
    let start = [([0.01, 0.02], [0.0; 2]), ([0.01 + 2.0 * RADIUS + gap, 0.02], [-SPEED, 0.0])];
    let config = given(config.clone(), &start);
    let models = (0..200).map(|replicate| {
        Dem::prepare(&config, Seed { seed: 2, replicate }, false)
            .unwrap_or_else(|error| panic!("{error}"))
    });
    let is_wanted = |model: &Dem| {
        let found = discs(model);
        found[0].mass < 1.5 * MASS && found[1].mass > 1.5 * MASS
    };
    models.into_iter().find(is_wanted).expect("one of 200 replicates has both materials")
}

/// Duration of the nonzero force, s, and largest overlap, m, of a contact.
fn contact(mut model: Dem, overlap: fn(&Dem) -> f64) -> [f64; 2] {
    let (mut steps, mut largest, mut has_begun) = (0_u32, 0.0, false);
    for step in 1..=200_000 {
        run_to(&mut model, step);
        let is_touching = frame(&model).contacts().iter().any(|line| line.force != 0.0);
        steps += u32::from(is_touching);
        let overlap = overlap(&model);
        largest = if overlap > largest { overlap } else { largest };
        if has_begun && !is_touching {
            return [f64::from(steps) * time_step(&model), largest];
        }
        has_begun |= is_touching;
    }
    panic!("the contact has not ended");
}

fn of_pair(model: &Dem) -> f64 {
    let found = discs(model);
    2.0 * RADIUS - (found[1].position[0] - found[0].position[0])
}

fn on_floor(model: &Dem) -> f64 {
    RADIUS - discs(model)[0].position[1]
}

/// Whether duration and overlap are within the tolerance.
fn agrees([duration, largest]: [f64; 2], [expected, overlap]: [f64; 2], step: f64) -> bool {
    println!("{duration:e} s, formula {expected:e}; {largest:e} m, formula {overlap:e}");
    (duration - expected).abs() < 2.0 * step && (largest / overlap - 1.0).abs() < 1e-5
}

/// Duration and largest overlap on a linear spring.
fn oscillator(mass: f64, stiffness: f64) -> [f64; 2] {
    let time = libm::sqrt(mass / stiffness);
    [PI * time, SPEED * time]
}

const PAIR_MASS: f64 = MASS * 2.0 / 3.0;

#[test]
fn pair_collides_as_on_two_springs_in_series() {
    let config = two(RATIOS, [1.0; 2]);
    let model = pair(&config, 1e-9);
    let step = time_step(&model);
    let found = contact(model, of_pair);
    // Half the manifest's 1/k for each disc.
    let series = 1.0 / (0.5 / (RATIOS[0] * STIFFNESS) + 0.5 / (RATIOS[1] * STIFFNESS));
    assert!(agrees(found, oscillator(PAIR_MASS, series), step));
    let mean = 0.5 * (RATIOS[0] + RATIOS[1]) * STIFFNESS;
    assert!(!agrees(found, oscillator(PAIR_MASS, mean), step), "control");
    // A given ratio takes precedence.
    let mut constants = config.materials[0].constants;
    constants.stiffness_ratio = Positive::new(0.7);
    let between = ["a", "b"].map(str::to_owned);
    let config = DemConfig { contact_pairs: vec![DemContactPair { between, constants }], ..config };
    let found = contact(pair(&config, 1e-9), of_pair);
    assert!(agrees(found, oscillator(PAIR_MASS, 0.7 * STIFFNESS), step));
}

#[test]
fn walls_have_the_stiffness_of_the_manifest() {
    for ratio in RATIOS {
        let config =
            DemConfig { materials: vec![stiff("a", 1.0, 1.0, ratio)], ..two(RATIOS, [1.0; 2]) };
        let config = DemConfig { dissipation: restitution(1.0), ..config };
        let model = prepared(&given(config, &[([0.02, RADIUS + 1e-9], [0.0, -SPEED])]));
        let step = time_step(&model);
        let found = contact(model, on_floor);
        let series = 1.0 / (0.5 / (ratio * STIFFNESS) + 0.5 / STIFFNESS);
        assert!(agrees(found, oscillator(MASS, series), step));
        assert!(!agrees(found, oscillator(MASS, ratio * STIFFNESS), step), "control");
    }
}

#[test]
fn spheres_of_two_moduli_collide_by_hertz() {
    let config =
        DemConfig { elasticity: Elasticity::Hertz(positive(MODULUS)), ..two(RATIOS, [1.0; 2]) };
    let model = pair(&config, 1e-9);
    let step = time_step(&model);
    let found = contact(model, of_pair);
    let expected = |modulus: f64| {
        let kappa = 4.0 / 3.0 * modulus * libm::sqrt(0.5 * RADIUS);
        let overlap = libm::pow(1.25 * PAIR_MASS * SPEED * SPEED / kappa, 0.4);
        [2.943_275 * overlap / SPEED, overlap]
    };
    let compliance = |ratio: f64| (1.0 - 0.09) / (ratio * MODULUS);
    assert!(agrees(found, expected(1.0 / (compliance(RATIOS[0]) + compliance(RATIOS[1]))), step));
    let mean = 0.25 * (RATIOS[0] + RATIOS[1]) * MODULUS / (1.0 - 0.09);
    assert!(!agrees(found, expected(mean), step), "control");
}

/// Largest |e' - e| over its bound, over 50 draws; `mixed` maps ratios and restitutions of both to the restitution expected.
fn max_error(tail: bool, mixed: fn([f64; 2], [f64; 2]) -> f64) -> f64 {
    let mut generator = SEED.stream(Stream::Positions);
    let (mut done, mut max_error) = (0, 0.0);
    while done < 50 {
        let mut logarithmic = |low, high| libm::pow(10.0, generator.uniform_in(low, high));
        let ratios = [logarithmic(-1.0, 1.0), logarithmic(-1.0, 1.0)];
        let steps = logarithmic(1.3, 2.3);
        let restitutions = [generator.uniform_in(0.1, 1.0), generator.uniform_in(0.1, 1.0)];
        let config = DemConfig {
            limit_damping: tail,
            time_step: per_contact(steps),
            ..two(ratios, restitutions)
        };
        let mut model = pair(&config, 1e-6 * generator.uniform_in(0.1, 1.0));
        let stiffness = STIFFNESS * 2.0 * ratios[0] * ratios[1] / (ratios[0] + ratios[1]);
        let h = time_step(&model) * libm::sqrt(stiffness / PAIR_MASS);
        let expected = mixed(ratios, restitutions);
        if 2.0 * damping_ratio(expected, tail) * h >= 0.15 {
            continue;
        }
        done += 1;
        run_to(&mut model, (30.0 / h) as u64 + 100);
        let found = discs(&model);
        let obtained = (found[1].velocity[0] - found[0].velocity[0]) / SPEED;
        let error = (obtained - expected).abs() / (0.3 * h + 0.5 * h * h);
        max_error = if error > max_error { error } else { max_error };
    }
    max_error
}

fn by_energy([a, b]: [f64; 2], [e, e_other]: [f64; 2]) -> f64 {
    libm::sqrt((e * e * b + e_other * e_other * a) / (a + b))
}

#[test]
fn restitution_shares_the_energy_by_stiffness() {
    for tail in [false, true] {
        let found = max_error(tail, by_energy);
        println!("{tail}: |e' - e| is at most {found:.3} of its bound");
        assert!(found <= 1.0, "{tail}: {found}");
        let equal = max_error(tail, |_, [e, other]| libm::sqrt(0.5 * (e * e + other * other)));
        let smaller = max_error(tail, |ratios, both| 0.9 * by_energy(ratios, both));
        println!("{tail}: mixed as for equal stiffness {equal:.1}, 0.9 of it {smaller:.1}");
        assert!(equal > 1.0 && smaller > 1.0, "control");
    }
}
