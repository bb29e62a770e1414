//! Law: with `tangential_law = "mindlin"`, the elastic tangential force T of two spheres changes by dT = -8 G* a ds with the displacement s of
//! their surfaces, decreases in proportion to the radius a of the circle of contact while that shrinks, and is at most mu f. An impact
//! that slides throughout changes the tangential velocity by mu (1 + e) v_n.
//!
//! Source: Mindlin, J. Appl. Mech. 16 (1949) 259, k_t = 8 G* a with G* = G/(2 (2 - nu)); Thornton, Cummins and Cleary, Powder Technology 233
//! (2013) 30, for the increments; the last sentence is the impulse of Coulomb's law.
//! Setup: a disc that meets the floor without gravity and dashpots at six angles, friction 0.4, nu 0.2, 2000 steps per contact; the
//! reference below integrates force, velocity and spin in 200,000 steps. One step for the formula. For the energy, 200 impacts at 40 and 160
//! steps per contact.
//! Tolerance: 1e-14 of the first force, for rounding; 5e-4 of the impact's normal velocity for the reference, a step of 2000, within which the
//! contact begins and slip ends; 1e-5 for the impulse; 1e-4 for the residual of the energy, which is of first order, because the arm
//! r - delta changes within a step: at 40 steps it is at least twice as large, and at most a quarter for spheres that are 100 times as
//! hard and overlap by a sixth; 1e-12 of the work of random steps of the spring, for rounding.
//! Control: 1 % more of k_t, nu 0.21, the constant stiffness of the other springs, a force that is kept as the circle shrinks, and a balance
//! without the loss exceed the tolerances.

use crate::scene::{
    SEED, discs, energy, frame, given, gravity, non_negative, per_contact, positive, prepared,
    restitution, run_to,
};
use kinetoscope_manifest::model::{
    DemConfig, DiscRadius, Elasticity, StepLength, TangentialLaw, TangentialStiffness, TimeStep,
    UnstableTimeStep,
};
use kinetoscope_manifest::quantity::PoissonRatio;
use kinetoscope_physics::dem::Dem;
use kinetoscope_physics::dem::motion::{SliderConstants, mindlin_slider};
use kinetoscope_physics::model::Model;
use kinetoscope_physics::random::Stream;
use kinetoscope_recording::channels::DemDiscForces;

const MASS: f64 = 1e-3;
const RADIUS: f64 = 1.0 / 1024.0;
const MODULUS: f64 = 1e9;
const RATIO: f64 = 0.2;
const FRICTION: f64 = 0.4;
/// Normal velocity of the impacts, m/s.
const SPEED: f64 = 0.5;
/// Tangential over normal velocity of the impacts; the last one slides throughout.
const SLOPES: [f64; 6] = [0.1, 0.4, 0.8, 1.2, 2.0, 6.0];

fn spheres() -> DemConfig {
    DemConfig {
        mass_kg: positive(MASS),
        radius_m: DiscRadius::Equal(positive(RADIUS)),
        gravity_m_per_s2: gravity(0.0, 0.0),
        elasticity: Elasticity::Hertz(positive(MODULUS)),
        poisson_ratio: PoissonRatio::new(RATIO),
        dissipation: restitution(1.0),
        friction: non_negative(FRICTION),
        tangential_to_normal_damping: non_negative(0.0),
        tangential_stiffness: TangentialStiffness::Law(TangentialLaw::Mindlin),
        ..DemConfig::default()
    }
}

/// 8 G*, Pa.
fn tangential_modulus(ratio: f64) -> f64 {
    let shear_modulus = MODULUS / (2.0 * (1.0 + ratio));
    8.0 * shear_modulus / (2.0 * (2.0 - ratio))
}

/// The tangential force after the first step in contact over 8 G* a v_t dt.
fn force_over_formula(ratio: f64) -> f64 {
    let (gap, step) = (1.0 / 16384.0, 1.0 / 1_048_576.0);
    let config = DemConfig {
        poisson_ratio: PoissonRatio::new(ratio),
        friction: non_negative(1e3),
        time_step: TimeStep::Length(StepLength::Fixed(positive(step))),
        on_unstable_time_step: UnstableTimeStep::Warn,
        ..spheres()
    };
    let start = ([1.0 / 64.0, RADIUS + gap], [1.0, -2.0 * gap / step]);
    let mut model = Dem::prepare(&given(config, &[start]), SEED, true).expect("a start");
    run_to(&mut model, 1);
    let forces: DemDiscForces = frame(&model).get().expect("forces");
    -forces.force_x_n[0] / (tangential_modulus(RATIO) * (RADIUS * gap).sqrt() * step)
}

#[test]
fn first_force_equals_mindlins() {
    let found = force_over_formula(RATIO) - 1.0;
    println!("deviation {found:e}");
    assert!(found.abs() < 1e-14, "{found:e}");
    assert!((force_over_formula(RATIO + 0.01) - 1.0).abs() > 1e-3, "control");
}

/// What the reference changes, for the controls.
#[derive(Clone, Copy)]
struct Changed {
    /// Factor of k_t.
    stiffness: f64,
    /// Whether the force is kept as the circle shrinks.
    keeps_force: bool,
}

const UNCHANGED: Changed = Changed { stiffness: 1.0, keeps_force: false };

/// Tangential velocity and surface speed of the spin after an impact, m/s, by small steps of the incremental law.
fn reference(slope: f64, changed: Changed) -> [f64; 2] {
    let kappa = 4.0 / 3.0 * MODULUS / (2.0 * (1.0 - RATIO * RATIO)) * RADIUS.sqrt();
    let modulus = changed.stiffness * tangential_modulus(RATIO);
    let largest = libm::pow(1.25 * MASS * SPEED * SPEED / kappa, 0.4);
    let step = 2.943_275 * largest / SPEED / 200_000.0;
    let inertia = 0.5 * MASS * RADIUS * RADIUS;
    let (mut overlap, mut approach) = (0.0, SPEED);
    let (mut velocity, mut spin, mut tangential, mut circle) = (slope * SPEED, 0.0, 0.0, 0.0);
    loop {
        overlap += approach * step;
        if overlap <= 0.0 {
            return [velocity, RADIUS * spin];
        }
        let (arm, before) = (RADIUS - overlap, circle);
        circle = (RADIUS * overlap).sqrt();
        if circle < before && !changed.keeps_force {
            tangential *= circle / before;
        }
        tangential -= modulus * circle * (velocity + arm * spin) * step;
        let pressing = kappa * overlap * overlap.sqrt();
        let limit = FRICTION * pressing;
        if tangential.abs() > limit {
            tangential = limit.copysign(tangential);
        }
        approach -= pressing / MASS * step;
        velocity += tangential / MASS * step;
        spin += tangential * arm / inertia * step;
    }
}

/// The same of a run.
fn impact(config: &DemConfig, slope: f64) -> [f64; 2] {
    let config = DemConfig { time_step: per_contact(2000.0), ..config.clone() };
    let start = ([0.01, RADIUS + 1e-9], [slope * SPEED, -SPEED]);
    let mut model = prepared(&given(config, &[start]));
    run_to(&mut model, 4000);
    let disc = discs(&model)[0];
    assert!((disc.velocity[1] / SPEED - 1.0).abs() < 1e-5, "{:e}", disc.velocity[1]);
    [disc.velocity[0], RADIUS * disc.spin]
}

/// Largest deviation over the angles, over the normal velocity.
fn deviation(found: &[[f64; 2]], changed: Changed) -> f64 {
    let deviations = found.iter().zip(SLOPES).flat_map(|(found, slope)| {
        let expected = reference(slope, changed);
        [0, 1].map(|part: usize| (found[part] - expected[part]).abs() / SPEED)
    });
    deviations.fold(0.0, |largest, one| if one > largest { one } else { largest })
}

#[test]
fn oblique_impacts_agree_with_the_incremental_law() {
    let found = SLOPES.map(|slope| impact(&spheres(), slope));
    for (slope, [velocity, spin]) in SLOPES.iter().zip(found) {
        println!("slope {slope}: velocity {:.5}, surface {:.5}", velocity / SPEED, spin / SPEED);
    }
    let agreed = deviation(&found, UNCHANGED);
    let stiffer = deviation(&found, Changed { stiffness: 1.01, ..UNCHANGED });
    let kept = deviation(&found, Changed { keeps_force: true, ..UNCHANGED });
    println!("deviation {agreed:.1e}; k_t 1 % higher {stiffer:.1e}, force kept {kept:.1e}");
    assert!(agreed < 5e-4, "{agreed:e}");
    assert!(stiffer > 1e-3 && kept > 1e-3, "control");
    let constant =
        DemConfig { tangential_stiffness: DemConfig::default().tangential_stiffness, ..spheres() };
    let constant = deviation(&SLOPES.map(|slope| impact(&constant, slope)), UNCHANGED);
    assert!(constant > 1e-2, "control: a constant stiffness deviates by {constant:e}");
}

#[test]
fn sliding_impact_has_coulombs_impulse() {
    let [velocity, _] = impact(&spheres(), 6.0);
    let change = 6.0 - velocity / SPEED;
    println!("change of the tangential velocity {change:.7} v_n");
    assert!((change - 2.0 * FRICTION).abs() < 1e-5, "{change}");
    let other = DemConfig { friction: non_negative(1.01 * FRICTION), ..spheres() };
    let [velocity, _] = impact(&other, 6.0);
    assert!((6.0 - velocity / SPEED - 2.0 * FRICTION).abs() > 1e-5, "control");
}

/// Residual of the energy and energy dissipated by friction over the initial energy, after 200 oblique impacts at phases of a step.
fn balance(config: DemConfig, steps: f64) -> [f64; 2] {
    const PHASES: u32 = 200;
    let config = DemConfig { width_m: positive(1.0), time_step: per_contact(steps), ..config };
    let gap = |phase: u32| 1e-5 + 2e-5 * f64::from(phase) / f64::from(PHASES);
    let start = |phase: u32| {
        ([0.002 + 0.004 * f64::from(phase), RADIUS + gap(phase)], [0.8 * SPEED, -SPEED])
    };
    let start: Vec<_> = (0..PHASES).map(start).collect();
    let mut model = prepared(&given(config, &start));
    let before = energy(&model).total_j;
    run_to(&mut model, (6.0 * steps) as u64);
    let after = energy(&model);
    assert!(after.elastic_j == 0.0, "the contacts have not ended");
    [after.residual_j / before, after.friction_j / before]
}

/// Every change of the spring's energy with the circle is a loss of friction: what remains is the error of the integrator.
#[test]
fn energy_balance_closes() {
    let [coarse, fine] = [40.0, 160.0].map(|steps| balance(spheres(), steps));
    let hard = DemConfig { elasticity: Elasticity::Hertz(positive(100.0 * MODULUS)), ..spheres() };
    let [hard, _] = balance(hard, 160.0);
    println!("40 steps: {coarse:?}, 160 steps: {fine:?}, 100 times as hard: {hard:e}");
    assert!(fine[0].abs() < 1e-4 && fine[0].abs() < 0.5 * coarse[0].abs(), "{fine:?}");
    assert!(hard.abs() < 0.25 * fine[0].abs(), "{hard:e}");
    assert!(fine[1] > 1e-2, "control: the residual without the loss");
}

/// Work less gain of energy and loss of Mindlin's springs over 10,000 random steps of loading, unloading and slip, over the sum of all |work|;
/// the same without the part of the loss that is due to the circle; and the largest deviation of a force that holds at rest.
fn random_steps() -> [f64; 3] {
    const STIFFNESS: f64 = 3.0;
    let constants = |root: f64| SliderConstants {
        stiffness: STIFFNESS * root,
        half_stiffness: 0.5 * STIFFNESS,
        compliance: 1.0 / (STIFFNESS * root),
    };
    let energy = |stretch: f64| 0.5 * STIFFNESS * stretch * stretch;
    let mut generator = SEED.stream(Stream::Positions);
    let (mut circle, mut stretch, mut force): (f64, f64, f64) = (0.5, 0.0, 0.0);
    let (mut balance, mut without_circle, mut total, mut deviation) = (0.0, 0.0, 0.0, 0.0);
    for step in 0..10_000 {
        let (circle_before, stretch_before, force_before) = (circle, stretch, force);
        circle = generator.uniform_in(0.1, 1.0);
        let travel = generator.uniform_in(-0.1, 0.1) * f64::from(step % 3);
        let (circles, limit) = ([circle_before, circle], 0.4 * circle);
        let slid = mindlin_slider(&constants(1.0), circles, stretch, travel, 0.0, limit);
        (stretch, force) = (slid.stretch, slid.force);
        let unaccounted =
            -0.5 * (force_before + force) * travel - energy(stretch) + energy(stretch_before);
        balance += unaccounted - slid.loss;
        total += (0.5 * (force_before + force) * travel).abs();
        let shrinks = circle < circle_before;
        let ratio = if shrinks { circle / circle_before } else { circle_before / circle };
        let (rescaled, root) = (ratio.sqrt() * stretch_before, circle.sqrt());
        let slip = (rescaled + root * travel - stretch) * 0.5 * STIFFNESS * (rescaled + stretch);
        without_circle += unaccounted - slip;
        if travel == 0.0 && force.abs() < 0.999 * limit {
            let expected = if shrinks { force_before * ratio } else { force_before };
            let error = (force - expected).abs();
            deviation = if error > deviation { error } else { deviation };
        }
    }
    [balance / total, without_circle / total, deviation]
}

/// Tolerance: 1e-12 of the work and 1e-14 of forces of the order of 0.1, for rounding.
#[test]
fn work_of_springs_is_energy_or_loss() {
    let [balance, without_circle, deviation] = random_steps();
    println!("balance {balance:e}, without the circle {without_circle:e}; force {deviation:e}");
    assert!(balance.abs() < 1e-12, "{balance:e}");
    assert!(deviation < 1e-14, "{deviation:e}");
    assert!(without_circle > 1e-2, "control: {without_circle:e}");
}

/// Law: surfaces that touch without an overlap exert no force, before and after a contact.
#[test]
fn mindlins_springs_have_no_force_without_a_circle() {
    let spring = SliderConstants { stiffness: 3.0, half_stiffness: 1.5, compliance: 1.0 / 3.0 };
    for travel in [0.0, 0.1, -0.1] {
        for (before, stretch) in [(0.0_f64, 0.0_f64), (0.5, 0.2)] {
            let slid = mindlin_slider(&spring, [before, 0.0], stretch, travel, 0.0, 0.0);
            assert_eq!((slid.force.abs(), slid.stretch.abs()), (0.0, 0.0));
            let kept = 1.5 * stretch * stretch;
            let work = 0.5 * 3.0 * before.sqrt() * stretch * travel;
            assert!((slid.loss - kept - work).abs() < 1e-15, "{} {kept}", slid.loss);
            let slid = mindlin_slider(&spring, [0.0, 0.5], 0.0, travel, 0.0, 1.0);
            assert!((slid.force + 3.0 * 0.5 * travel).abs() < 1e-15, "{}", slid.force);
        }
    }
}
