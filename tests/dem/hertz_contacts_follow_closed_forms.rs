//! Law: with `youngs_modulus_pa`, contacts are those of elastic spheres. The force is f = 4/3 E* sqrt(R delta) delta + eta v with
//! eta = alpha sqrt(m kappa) delta^(1/4), kappa = 4/3 E* sqrt(R). An elastic impact overlaps by (5 m v^2/(4 kappa))^(2/5) and lasts
//! 2.9433 times that over v, proportional to v^(-1/5). The restitution is the requested one, whatever the speed, with either tail.
//!
//! Source: Landau and Lifshitz, Theory of Elasticity, section 9; Antypov and Elliott, EPL 94 (2011) 50004, for
//! alpha = -sqrt 5 ln e/sqrt(ln^2 e + pi^2) with the attractive tail.
//! Setup: pairs and single discs without gravity; numbers of steps per contact are those of `steps_per_wall_contact`, which refers to
//! the stiffness at the largest overlap; a disc at rest on the floor; 50 random draws of E (1e6 to 1e10 Pa), e, radii (ratio up to 10),
//! overlaps (1e-4 to 0.03 radii) and steps (20 to 200).
//! Tolerance: 1e-15 of the elastic force, 1e-14 of the dashpot's; two steps of the duration; |e' - e| <= 0.1 h + h^2/2 with
//! h = dt sqrt(k/m_eff) at the largest overlap, a third of a linear spring's first term, because the dashpot sets in gradually.
//! Control: Poisson's ratio 0.29 in place of 0.3, 1 % more of E, a linear spring, and 0.9 of the restitution exceed the tolerances.

use crate::scene::{
    SEED, discs, energy, equal, frame, given, gravity, per_contact, positive, prepared,
    restitution, run_to, spring, time_step,
};
use kinetoscope_manifest::model::{
    DemConfig, DiscRadius, Elasticity, StepLength, TimeStep, UnstableTimeStep,
};
use kinetoscope_manifest::quantity::{Fraction, PoissonRatio};
use kinetoscope_physics::dem::Dem;
use kinetoscope_physics::dem::restitution::{damping_ratio, max_overlap};
use kinetoscope_physics::model::Model;
use kinetoscope_physics::random::Stream;
use kinetoscope_recording::channels::DemDiscForces;
use std::f64::consts::PI;

const MASS: f64 = 1e-3;
const RADIUS: f64 = 5e-4;

/// E* of Young's modulus with Poisson's ratio 0.3, Pa.
fn effective(modulus: f64) -> f64 {
    modulus / (2.0 * (1.0 - 0.3 * 0.3))
}

/// kappa of f = kappa delta^(3/2), N/m^(3/2).
fn kappa(modulus: f64, reduced_radius: f64) -> f64 {
    4.0 / 3.0 * effective(modulus) * reduced_radius.sqrt()
}

fn spheres(modulus: f64) -> DemConfig {
    DemConfig {
        gravity_m_per_s2: gravity(0.0, 0.0),
        elasticity: Elasticity::Hertz(positive(modulus)),
        dissipation: restitution(1.0),
        ..DemConfig::default()
    }
}

/// Two discs of different radii whose centers approach on a line, at a gap.
fn pair(config: &DemConfig, [small, large]: [f64; 2], gap: f64, speed: f64) -> DemConfig {
    let config = DemConfig {
        width_m: positive(1.0),
        height_m: positive(1.0),
        on_unstable_time_step: UnstableTimeStep::Warn,
        radius_m: DiscRadius::TwoSizes {
            small: positive(small),
            large: positive(large),
            small_fraction: Fraction::new(0.5).expect("a fraction"),
        },
        ..config.clone()
    };
    // A first model with distant discs determines the radii that are drawn.
    let apart = given(config.clone(), &[([0.25, 0.5], [0.0; 2]), ([0.75, 0.5], [0.0; 2])]);
    let drawn = discs(&prepared(&apart));
    let reach = drawn[0].radius + drawn[1].radius;
    given(config, &[([0.5, 0.5], [0.0; 2]), ([0.5 + reach + gap, 0.5], [-speed, 0.0])])
}

/// The force on the second disc after one step, over the formula, for dyadic numbers that are not rounded.
fn force_over_formula(config: DemConfig, requested: f64) -> f64 {
    let (gap, step) = (1.0 / 16384.0, 1.0 / 1_048_576.0);
    let config = DemConfig {
        dissipation: restitution(requested),
        time_step: TimeStep::Length(StepLength::Fixed(positive(step))),
        ..config
    };
    let speed = 2.0 * gap / step;
    let config = pair(&config, [1.0 / 1024.0, 1.0 / 512.0], gap, speed);
    let mut model = Dem::prepare(&config, SEED, true).expect("a start");
    run_to(&mut model, 1);
    let forces: DemDiscForces = frame(&model).get().expect("forces");
    let [one, other] = [discs(&model)[0], discs(&model)[1]];
    assert_eq!(one.radius + other.radius - (other.position[0] - one.position[0]), gap);
    let reduced = one.radius * other.radius / (one.radius + other.radius);
    let mass = one.mass * other.mass / (one.mass + other.mass);
    let kappa = kappa(1e8, reduced);
    let logarithm = libm::log(requested);
    let alpha = -logarithm * libm::sqrt(5.0 / (logarithm * logarithm + PI * PI));
    let dashpot = alpha * libm::sqrt(mass * kappa) * libm::pow(gap, 0.25) * speed;
    forces.force_x_n[1] / (kappa * libm::pow(gap, 1.5) + dashpot)
}

#[test]
fn force_equals_the_formula() {
    let elastic = force_over_formula(spheres(1e8), 1.0) - 1.0;
    let damped = force_over_formula(spheres(1e8), 0.4) - 1.0;
    println!("elastic force {elastic:e}, with a dashpot {damped:e}");
    assert!(elastic.abs() < 1e-15, "{elastic:e}");
    assert!(damped.abs() < 1e-14, "{damped:e}");
    let other = DemConfig { poisson_ratio: PoissonRatio::new(0.29), ..spheres(1e8) };
    assert!((force_over_formula(other, 1.0) - 1.0).abs() > 1e-3, "control");
}

/// Duration of the nonzero force, s, and largest overlap, m, of an impact on the floor, and the time step.
fn impact(config: DemConfig, speed: f64) -> [f64; 3] {
    let config = DemConfig { time_step: per_contact(2000.0), ..config };
    let mut model = prepared(&given(config, &[([0.02, RADIUS + 1e-9], [0.0, -speed])]));
    let (mut steps, mut largest) = (0_u32, 0.0);
    for step in 1..=4000 {
        run_to(&mut model, step);
        steps += u32::from(frame(&model).contacts().iter().any(|line| line.force != 0.0));
        let overlap = RADIUS - discs(&model)[0].position[1];
        largest = if overlap > largest { overlap } else { largest };
    }
    assert!(discs(&model)[0].velocity[1] > 0.0, "the contact has not ended");
    [f64::from(steps) * time_step(&model), largest, time_step(&model)]
}

#[test]
fn elastic_impact_has_hertz_duration_and_overlap() {
    let kappa = kappa(1e9, RADIUS);
    let mut durations = Vec::new();
    for speed in [0.03, 1.0] {
        let overlap = libm::pow(1.25 * MASS * speed * speed / kappa, 0.4);
        let [duration, largest, step] = impact(spheres(1e9), speed);
        let expected = 2.943_275 * overlap / speed;
        println!("{speed} m/s: {duration:e} s, formula {expected:e}; {largest:e} m, {overlap:e}");
        assert!((duration - expected).abs() < 2.0 * step);
        assert!((largest / overlap - 1.0).abs() < 1e-5);
        let [duration, largest, step] = impact(spheres(1.01e9), speed);
        assert!((duration - expected).abs() > 2.0 * step, "control");
        assert!((largest / overlap - 1.0).abs() > 1e-5, "control");
        durations.push(expected);
    }
    let exponent = libm::log(durations[1] / durations[0]) / libm::log(1.0 / 0.03);
    assert!((exponent + 0.2).abs() < 1e-12, "{exponent}");
    let linear = DemConfig { elasticity: spring(5e4), ..spheres(1e9) };
    let [slow, ..] = impact(linear.clone(), 0.03);
    let [fast, ..] = impact(linear, 1.0);
    assert!((fast / slow - 1.0).abs() < 1e-3, "control: a linear spring's does not depend on v");
}

/// The substitution y = delta^(5/4) turns the impact into that of a damped oscillator.
#[test]
fn damped_impact_overlaps_as_the_equivalent_oscillator() {
    let kappa = kappa(1e9, RADIUS);
    for tail in [false, true] {
        let config = DemConfig { limit_damping: tail, ..spheres(1e9) };
        let ratio = damping_ratio(0.5, tail);
        let largest = max_overlap(1.25, ratio, libm::sqrt(1.25 * kappa / MASS));
        let expected = libm::pow(largest, 0.8);
        let found = |requested| {
            impact(DemConfig { dissipation: restitution(requested), ..config.clone() }, 1.0)[1]
        };
        println!("{tail}: {:e} m, formula {expected:e}", found(0.5));
        assert!((found(0.5) / expected - 1.0).abs() < 1e-3);
        assert!((found(0.51) / expected - 1.0).abs() > 1e-3, "control");
    }
}

#[test]
fn disc_at_rest_overlaps_by_its_weight() {
    let config = DemConfig {
        gravity_m_per_s2: gravity(0.0, -9.81),
        dissipation: restitution(0.2),
        ..spheres(1e8)
    };
    let mut model = prepared(&given(config, &[([0.02, RADIUS + 1e-6], [0.0; 2])]));
    run_to(&mut model, 20_000);
    let overlap = RADIUS - discs(&model)[0].position[1];
    let expected = libm::pow(MASS * 9.81 / kappa(1e8, RADIUS), 2.0 / 3.0);
    let linear = MASS * 9.81 / kappa(1e8, RADIUS);
    println!("overlap {overlap:e} m, formula {expected:e} m");
    assert!((overlap / expected - 1.0).abs() < 1e-9, "{overlap:e}");
    assert!((linear / expected - 1.0).abs() > 1e-9, "control");
}

/// Largest |e' - e| over 0.1 h + h^2/2, over 50 draws; `dashpot` maps the requested to the configured restitution.
fn restitution_error(tail: bool, dashpot: fn(f64) -> f64) -> f64 {
    let mut generator = SEED.stream(Stream::Positions);
    let mut largest = 0.0;
    for _ in 0..50 {
        let mut logarithmic = |low, high| libm::pow(10.0, generator.uniform_in(low, high));
        let (modulus, over_radius) = (logarithmic(6.0, 10.0), logarithmic(-4.0, -1.5));
        let (steps, size_ratio) = (logarithmic(1.3, 2.3), logarithmic(0.0, 1.0));
        let requested = generator.uniform_in(0.1, 1.0);
        let radii = [RADIUS, RADIUS * size_ratio];
        let config = DemConfig {
            dissipation: restitution(dashpot(requested)),
            limit_damping: tail,
            time_step: per_contact(steps),
            ..spheres(modulus)
        };
        // The speed at which two small discs overlap by a fraction of their radius.
        let overlap = over_radius * RADIUS;
        let mean = 0.5 * (radii[0] + radii[1]);
        let mass = 0.5 * MASS * RADIUS * RADIUS / (mean * mean);
        let kappa_small = kappa(modulus, 0.5 * RADIUS);
        let speed = libm::sqrt(0.8 * kappa_small * libm::pow(overlap, 2.5) / mass);
        let start = pair(&config, radii, 0.0, speed);
        let mut model = prepared(&start);
        let [one, other] = [discs(&model)[0], discs(&model)[1]];
        let mass = one.mass * other.mass / (one.mass + other.mass);
        let reduced = one.radius * other.radius / (one.radius + other.radius);
        let kappa = kappa(modulus, reduced);
        let overlap = libm::pow(1.25 * mass * speed * speed / kappa, 0.4);
        let h = time_step(&model) * libm::sqrt(1.5 * kappa * libm::sqrt(overlap) / mass);
        run_to(&mut model, (30.0 * PI / h) as u64);
        let after = discs(&model);
        let found = (after[1].velocity[0] - after[0].velocity[0]) / speed;
        let error = (found - requested).abs() / (0.1 * h + 0.5 * h * h);
        largest = if error > largest { error } else { largest };
    }
    largest
}

#[test]
fn restitution_is_the_requested_one() {
    for tail in [false, true] {
        let found = restitution_error(tail, |requested| requested);
        println!("{tail}: |e' - e| is at most {found:.3} of its bound");
        assert!(found <= 1.0, "{tail}: {found}");
        assert!(restitution_error(tail, |requested| 0.9 * requested) > 1.0, "control");
    }
}

/// Errors of energy and restitution of 200 impacts at 200 phases of a step, both as means.
fn errors(steps: f64) -> [f64; 2] {
    const PHASES: u32 = 200;
    let config = DemConfig {
        width_m: positive(1.0),
        radius_m: equal(RADIUS),
        dissipation: restitution(0.6),
        time_step: per_contact(steps),
        ..spheres(1e9)
    };
    let step = time_step(&prepared(&given(config.clone(), &[([0.5, 0.02], [0.0, -1.0])])));
    let start = |phase: u32| {
        let gap = 1e-5 + step * (f64::from(phase) + 0.5) / f64::from(PHASES);
        ([0.001 + 0.002 * f64::from(phase), RADIUS + gap], [0.0, -1.0])
    };
    let start: Vec<_> = (0..PHASES).map(start).collect();
    let mut model = prepared(&given(config, &start));
    let before = energy(&model).total_j;
    run_to(&mut model, (6.0 * steps) as u64);
    let speeds: f64 = discs(&model).iter().map(|disc| disc.velocity[1]).sum();
    [energy(&model).residual_j / before, speeds / f64::from(PHASES) - 0.6]
}

/// The residual of the energy balance decreases with the square of the time step, the restitution's error in proportion to it.
#[test]
fn errors_converge_with_the_time_step() {
    let [coarse, fine] = [errors(40.0), errors(160.0)];
    println!("40 steps: {coarse:?}, 160 steps: {fine:?}");
    let order = |index: usize| libm::log2((coarse[index] / fine[index]).abs()) / 2.0;
    assert!((order(0) - 2.0).abs() < 0.1, "energy: {}", order(0));
    assert!((order(1) - 1.0).abs() < 0.1, "restitution: {}", order(1));
}

/// A time step beyond the limit is rejected; each suggested value is accepted, Young's modulus among them.
#[test]
fn unstable_time_step_is_rejected() {
    let start = ([0.02, 0.01], [0.0, -1.0]);
    let config = given(DemConfig { dissipation: restitution(0.5), ..spheres(1e9) }, &[start]);
    let stable = time_step(&prepared(&config));
    let with_step = |factor: f64| {
        let length = StepLength::Fixed(positive(factor * stable));
        DemConfig { time_step: TimeStep::Length(length), ..config.clone() }
    };
    // 6 k dt^2/m < 4 without a dashpot: dt < 0.26 of a contact, of which the default is a twentieth.
    assert!(Dem::prepare(&with_step(1.5), SEED, false).is_ok());
    let error = Dem::prepare(&with_step(6.0), SEED, false).expect_err("a rejection").0.to_string();
    assert!(error.contains("youngs_modulus_pa = "), "{error}");
    assert!(!error.contains("damping_n_s_per_m = "), "{error}");
}
