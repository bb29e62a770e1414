//! Law: `cohesion_n` is a constant attraction F_c of surfaces in contact, in addition to the force f of spring and dashpot. A pair at rest overlaps
//! by F_c/k; a disc hangs under a ceiling if its weight is below F_c, and falls if it is above. A rebound has the speed of the damped
//! oscillator with F_c, and a slower impact sticks. A sliding disc decelerates by mu (g + F_c/m).
//!
//! Source: equilibrium of forces; m x'' = -k x - eta x' with x = delta - F_c/k, delta = 0 and delta' = v at the start, until delta = 0
//! again; with `limit_damping`, only F_c acts from k delta + eta delta' = 0 on; Coulomb's law for f = m g + F_c.
//! Setup: single discs and pairs, linear springs and Hertz's law. Rebounds at 20,000 steps per contact.
//! Tolerance: 1e-9 of overlaps at rest, 1e-6 under the ceiling; 2e-4 of the impact's speed for rebounds, some steps of 20,000; 1 % of the friction, because the disc starts without
//! overlap; 1 % of the speed at which impacts begin to rebound.
//! Control: F_c that is 1e-6 larger, an impact without F_c or with 2 % more, and friction without F_c exceed the tolerances.

use crate::scene::{
    SEED, discs, energy, frame, given, gravity, non_negative, per_contact, positive, prepared,
    restitution, run_to, run_to_time,
};
use kinetoscope::Experiment;
use kinetoscope_manifest::model::{DemConfig, DemContactPair, Elasticity, ModelConfig};
use kinetoscope_physics::dem::Dem;
use kinetoscope_physics::dem::restitution::damping_ratio;
use kinetoscope_physics::model::Model as _;

const STIFFNESS: f64 = 5e4;
const RADIUS: f64 = 5e-4;
const MASS: f64 = 1e-3;
const WEIGHT: f64 = MASS * 9.81;
const HEIGHT: f64 = 0.04;

fn cohesive(force: f64) -> DemConfig {
    DemConfig { cohesion_n: non_negative(force), ..DemConfig::default() }
}

/// Overlap of a pair at rest that touched slowly, m.
fn overlap_at_rest(config: DemConfig) -> f64 {
    let config =
        DemConfig { gravity_m_per_s2: gravity(0.0, 0.0), dissipation: restitution(0.3), ..config };
    let start = [([0.02, 0.02], [1e-3, 0.0]), ([0.02 + 2.0 * RADIUS, 0.02], [-1e-3, 0.0])];
    let mut model = prepared(&given(config, &start));
    run_to(&mut model, 8000);
    let found = discs(&model);
    2.0 * RADIUS - (found[1].position[0] - found[0].position[0])
}

#[test]
fn pair_at_rest_overlaps_by_cohesion_over_stiffness() {
    const FORCE: f64 = 0.5;
    for tail in [false, true] {
        let config = |force| DemConfig { limit_damping: tail, ..cohesive(force) };
        let found = overlap_at_rest(config(FORCE)) / (FORCE / STIFFNESS) - 1.0;
        let other = overlap_at_rest(config(FORCE * (1.0 + 1e-6))) / (FORCE / STIFFNESS) - 1.0;
        println!("{tail}: deviation {found:.1e}, control {other:.1e}");
        assert!(found.abs() < 1e-9, "{found:e}");
        assert!(other.abs() > 1e-9, "control");
    }
    let spheres =
        |force| DemConfig { elasticity: Elasticity::Hertz(positive(1e9)), ..cohesive(force) };
    let kappa = 4.0 / 3.0 * 1e9 / (2.0 * (1.0 - 0.09)) * libm::sqrt(0.5 * RADIUS);
    let expected = libm::pow(FORCE / kappa, 2.0 / 3.0);
    let found = overlap_at_rest(spheres(FORCE)) / expected - 1.0;
    println!("spheres: deviation {found:.1e}");
    assert!(found.abs() < 1e-9, "{found:e}");
}

/// Energy of the contact at rest: -F_c^2/(2 k).
#[test]
fn elastic_energy_contains_cohesion() {
    let config = DemConfig {
        gravity_m_per_s2: gravity(0.0, 0.0),
        dissipation: restitution(0.3),
        ..cohesive(0.5)
    };
    let start = [([0.02, 0.02], [1e-3, 0.0]), ([0.02 + 2.0 * RADIUS, 0.02], [-1e-3, 0.0])];
    let mut model = prepared(&given(config, &start));
    run_to(&mut model, 8000);
    let ratio = energy(&model).elastic_j / (-0.5 * 0.5 / (2.0 * STIFFNESS));
    assert!((ratio - 1.0).abs() < 1e-9, "{ratio}");
}

/// Overlap with the ceiling after 0.02 s, m; negative if the disc has fallen. It touches the ceiling with 0.01 mm/s, which no step of gravity
/// reverses: a faster one rebounds.
fn overlap_with_ceiling(config: DemConfig) -> f64 {
    let time_step = per_contact(2000.0);
    let config = DemConfig { dissipation: restitution(0.3), time_step, ..config };
    let mut model = prepared(&given(config, &[([0.02, HEIGHT - RADIUS], [0.0, 1e-5])]));
    run_to_time(&mut model, 0.02);
    RADIUS - (HEIGHT - discs(&model)[0].position[1])
}

#[test]
fn disc_hangs_under_a_ceiling_by_its_cohesion() {
    for excess in [1.02, 5.0] {
        let found = overlap_with_ceiling(cohesive(excess * WEIGHT));
        let expected = (excess - 1.0) * WEIGHT / STIFFNESS;
        println!("F_c = {excess} m g: overlap {found:e} m, expected {expected:e} m");
        assert!((found / expected - 1.0).abs() < 1e-6, "{found:e}");
    }
    assert!(overlap_with_ceiling(cohesive(0.98 * WEIGHT)) < 0.0, "control: it falls");
    // Cohesion of the discs alone does not hold it.
    let mut config = cohesive(5.0 * WEIGHT);
    let between = ["disc", "wall"].map(str::to_owned);
    let mut pair = DemContactPair { between, constants: Default::default() };
    pair.constants.cohesion_n = Some(non_negative(0.0));
    config.contact_pairs = vec![pair];
    assert!(overlap_with_ceiling(config) < 0.0);
}

/// Speed after an impact at a speed, m/s, by the exact solution; `None` if the disc sticks.
fn exact(speed: f64, force: f64, requested: f64, tail: bool) -> Option<f64> {
    let zeta = damping_ratio(requested, tail);
    let natural = libm::sqrt(STIFFNESS / MASS);
    let (b, w) = (zeta * natural, natural * libm::sqrt(1.0 - zeta * zeta));
    let center = force / STIFFNESS;
    // Overlap and its rate.
    let at = |time: f64| {
        let (sine, cosine) = libm::sincos(w * time);
        let decay = libm::exp(-b * time);
        let amplitude = (speed - b * center) / w;
        let x = decay * (amplitude * sine - center * cosine);
        let rate =
            decay * ((amplitude * w + b * center) * cosine + (center * w - b * amplitude) * sine);
        [x + center, rate]
    };
    // The contact ends, or its force without cohesion, where this changes its sign; at the earliest after the largest overlap.
    let remaining = |[overlap, rate]: [f64; 2]| match tail {
        false => overlap,
        true => STIFFNESS * overlap + 2.0 * b * MASS * rate,
    };
    let steps = 20_000_u32;
    let time = |step: u32| f64::from(step) * 2.0 * std::f64::consts::PI / w / f64::from(steps);
    let end =
        (1..=steps).find(|&step| at(time(step))[1] < 0.0 && remaining(at(time(step))) <= 0.0)?;
    let (mut low, mut high) = (time(end - 1), time(end));
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if remaining(at(middle)) > 0.0 { low = middle } else { high = middle }
    }
    let [overlap, rate] = at(high);
    let squared = rate * rate - if tail { 2.0 * force / MASS * overlap } else { 0.0 };
    (squared > 0.0).then(|| libm::sqrt(squared))
}

/// The same of a run.
fn rebound(speed: f64, force: f64, requested: f64, tail: bool) -> Option<f64> {
    let config = DemConfig {
        gravity_m_per_s2: gravity(0.0, 0.0),
        dissipation: restitution(requested),
        limit_damping: tail,
        time_step: per_contact(20_000.0),
        ..cohesive(force)
    };
    let mut model = prepared(&given(config, &[([0.02, RADIUS + 1e-12], [0.0, -speed])]));
    run_to(&mut model, 80_000);
    let is_free = frame(&model).contacts().is_empty();
    is_free.then(|| discs(&model)[0].velocity[1])
}

#[test]
fn rebound_has_the_speed_of_the_damped_oscillator() {
    const FORCE: f64 = 0.5;
    for tail in [false, true] {
        for requested in [1.0, 0.8, 0.5] {
            for speed in [0.3, 1.0] {
                let found = rebound(speed, FORCE, requested, tail).expect("a rebound");
                let expected = exact(speed, FORCE, requested, tail).expect("a rebound");
                let deviation = |force| {
                    exact(speed, force, requested, tail).map(|exact| (found - exact).abs() / speed)
                };
                let without = requested * speed;
                println!(
                    "{tail} e = {requested}, v = {speed}: {found:.6}, exact {expected:.6}, without {without:.6}"
                );
                assert!(deviation(FORCE).is_some_and(|it| it < 2e-4));
                if requested < 1.0 {
                    assert!(deviation(1.02 * FORCE).is_none_or(|it| it > 2e-4), "control");
                    assert!((found - without).abs() > 2e-4 * speed, "control");
                }
            }
        }
    }
}

/// Speed of the slow impacts, m/s, and their cohesion, N.
const SLOW: [f64; 2] = [0.05, 0.2];

/// Root of the mean square error of rebounds without loss, over the speed, at 20 phases of the step in which the contact begins.
fn rms_error(rebound: impl Fn(f64) -> f64) -> f64 {
    let square =
        |phase: u32| libm::pow(rebound((f64::from(phase) + 0.5) / 20.0) / SLOW[0] - 1.0, 2.0);
    libm::sqrt((0..20).map(square).sum::<f64>() / 20.0)
}

/// Speed after a slow impact that begins after a part of a step, m/s.
fn slow_rebound(steps: f64, phase: f64) -> f64 {
    let [speed, force] = SLOW;
    let way = speed * std::f64::consts::PI * libm::sqrt(MASS / STIFFNESS) / steps * phase;
    let config = DemConfig {
        gravity_m_per_s2: gravity(0.0, 0.0),
        dissipation: restitution(1.0),
        time_step: per_contact(steps),
        ..cohesive(force)
    };
    let mut model = prepared(&given(config, &[([0.02, RADIUS + way], [0.0, -speed])]));
    run_to(&mut model, 4 * steps as u64);
    discs(&model)[0].velocity[1]
}

/// The same by the leapfrog method with the whole attraction in each step with an overlap.
fn rebound_with_whole_attraction(steps: f64, phase: f64) -> f64 {
    let [mut rate, force] = SLOW;
    let step = std::f64::consts::PI * libm::sqrt(MASS / STIFFNESS) / steps;
    let mut overlap = -rate * step * phase;
    loop {
        overlap += rate * step;
        if overlap <= 0.0 {
            return -rate;
        }
        rate += (force - STIFFNESS * overlap) / MASS * step;
    }
}

/// Errors are of second order. Control: with the whole attraction in each step with an overlap, they are of first order.
#[test]
fn error_of_slow_rebounds_is_of_second_order() {
    let [coarse, medium, fine] =
        [20.0, 40.0, 80.0].map(|steps| rms_error(|phase| slow_rebound(steps, phase)));
    let control = rms_error(|phase| rebound_with_whole_attraction(80.0, phase));
    println!("{coarse:.2e}, {medium:.2e}, {fine:.2e}; whole attraction {control:.2e}");
    assert!(coarse < 5e-3, "{coarse:e}");
    assert!((3.0..6.0).contains(&(coarse / medium)), "{coarse:e}, {medium:e}");
    assert!((3.0..6.0).contains(&(medium / fine)), "{medium:e}, {fine:e}");
    assert!(fine < 5e-4 && control > 5e-3, "{fine:e}, control {control:e}");
}

#[test]
fn rejections_of_cohesive_discs_suggest_what_is_accepted() {
    let message =
        |config: &DemConfig| format!("{:?}", Dem::prepare(config, SEED, false).unwrap_err());
    let manifest = |keys: &str| {
        let text = format!("[model.dem]\nduration_s = 0.01\n{keys}");
        let experiment: Experiment = text.parse().unwrap();
        let ModelConfig::Dem(config) = &*experiment.runs[0].manifest.model else { panic!() };
        config.clone()
    };
    let strong = message(&manifest("cohesion_n = 10.0"));
    assert!(strong.contains("cohesion presses") && strong.contains("cohesion_n = "), "{strong}");
    let dry = message(&manifest("stiffness_n_per_m = 1.0"));
    assert!(dry.contains("falls through the box overlaps the wall"), "control: {dry}");
    // Both are rejected next to what the manifest has.
    assert!(!strong.contains("implicit"), "{strong}");
    let steps = "time_step_s = 1e-3\n";
    let of_materials = |restitution: &str| {
        let materials = format!("{steps}materials = [{{ name = \"steel\"{restitution} }}]");
        message(&manifest(&materials))
    };
    let without = of_materials("");
    assert!(without.contains("implicit"), "control: {without}");
    let own = of_materials(", stiffness_ratio = 2.0, restitution = 0.5");
    assert!(
        !own.contains("damping_n_s_per_m = ") && own.contains("of materials and contact_pairs"),
        "{own}"
    );
}

/// Before the first step, no disc was in contact, whatever its velocity.
#[test]
fn discs_that_start_apart_are_not_attracted() {
    let gap = 1e-8;
    let ceiling = [([0.02, HEIGHT - RADIUS - gap], [0.0, -0.1])];
    let pair = [([0.01, 0.02], [-0.1, 0.0]), ([0.01 + 2.0 * RADIUS + gap, 0.02], [0.1, 0.0])];
    for start in [&ceiling[..], &pair] {
        let config = DemConfig { gravity_m_per_s2: gravity(0.0, 0.0), ..cohesive(0.2) };
        let mut model = prepared(&given(config, start));
        for step in 0..3 {
            run_to(&mut model, step);
            let found: Vec<[f64; 2]> = discs(&model).iter().map(|disc| disc.velocity).collect();
            let expected: Vec<[f64; 2]> = start.iter().map(|disc| disc.1).collect();
            assert_eq!(found, expected, "step {step}");
        }
    }
}

#[test]
fn slow_impact_sticks() {
    const FORCE: f64 = 0.5;
    for tail in [false, true] {
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            match exact(middle, FORCE, 0.5, tail) {
                Some(_) => high = middle,
                None => low = middle,
            }
        }
        println!("{tail}: impacts stick below {high:.5} m/s");
        assert!(rebound(0.99 * high, FORCE, 0.5, tail).is_none());
        assert!(rebound(1.01 * high, FORCE, 0.5, tail).is_some(), "control");
    }
}

#[test]
fn sliding_friction_is_that_of_weight_and_cohesion() {
    const FRICTION: f64 = 0.2;
    let force = 1.5 * WEIGHT;
    let config = DemConfig { friction: non_negative(FRICTION), ..cohesive(force) };
    let mut model = prepared(&given(config, &[([0.005, RADIUS], [0.5, 0.0])]));
    run_to_time(&mut model, 0.02);
    let found = (0.5 - discs(&model)[0].velocity[0]) / (0.02 * 9.81);
    let expected = FRICTION * (1.0 + force / WEIGHT);
    println!("deceleration over g {found:.4}, expected {expected}");
    assert!((found / expected - 1.0).abs() < 0.01);
    assert!((found / FRICTION - 1.0).abs() > 0.01, "control");
}
