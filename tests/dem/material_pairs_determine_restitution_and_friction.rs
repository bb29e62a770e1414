//! Law: two discs rebound with the restitution of their pair of materials, by default e^2 = (e_i^2 + e_j^2)/2. A disc
//! slides on the floor with the friction coefficient of its pair, by default the smaller of the two.
//!
//! Source: Coaplen, Stronge and Ravani, Int. J. Impact Eng. 30 (2004) 581, for equal stiffness; friction as in PFC and
//! YADE. A sliding disc decelerates by mu g until it rolls, at 2/3 of its velocity.
//! Setup: a head-on pair without gravity at N_t = 200; a disc at 0.5 m/s on the floor for 30 ms. Materials are drawn at
//! random, so replicates are searched for the required pair.
//! Tolerance: 0.3 w0 dt = 0.007 for the restitution (see `restitution_is_correct_for_random_parameters`); 1 % for
//! friction, because the disc starts without overlap. Five standard deviations for the number of discs of a material.
//! Control: the constants of the other material are outside the tolerance.

use crate::scene::{
    discs, frame, given, gravity, material, per_contact, positive, run_to, run_to_time,
};
use kinetoscope_manifest::model::{DemConfig, DemContactConstants, DemContactPair, DemMaterial};
use kinetoscope_manifest::quantity::{Fraction, NonNegative};
use kinetoscope_physics::dem::Dem;
use kinetoscope_physics::model::Model;
use kinetoscope_physics::random::Seed;

const G: f64 = 9.81;
const BAND: f64 = 0.007;

fn two_materials() -> DemConfig {
    DemConfig {
        materials: vec![
            DemMaterial { density_ratio: positive(3.0), ..material("hard", 0.9, 0.1) },
            material("soft", 0.4, 0.5),
        ],
        friction: NonNegative::new(0.3).expect("a coefficient"),
        ..DemConfig::default()
    }
}

fn with_pair(config: DemConfig, between: [&str; 2], e: Option<f64>, mu: Option<f64>) -> DemConfig {
    let constants = DemContactConstants {
        restitution: e.and_then(Fraction::new),
        friction: mu.and_then(NonNegative::new),
        ..DemContactConstants::default()
    };
    let between = between.map(str::to_owned);
    DemConfig { contact_pairs: vec![DemContactPair { between, constants }], ..config }
}

/// The first replicate whose discs have these masses, in units of 1e-3 kg.
fn with_masses(config: &DemConfig, masses: &[f64]) -> Dem {
    let replicates = (0..200).map(|replicate| {
        Dem::prepare(config, Seed { seed: 2, replicate }, false)
            .unwrap_or_else(|error| panic!("{error}"))
    });
    let has_masses = |model: &Dem| {
        let found = discs(model);
        found.iter().zip(masses).all(|(disc, mass)| (disc.mass / 1e-3 - mass).abs() < 1e-9)
    };
    replicates.into_iter().find(has_masses).expect("one of 200 replicates has these materials")
}

/// Restitution of two discs of these masses.
fn measured_restitution(config: DemConfig, masses: [f64; 2]) -> f64 {
    let config =
        DemConfig { gravity_m_per_s2: gravity(0.0, 0.0), time_step: per_contact(200.0), ..config };
    let pair = given(config, &[([0.01, 0.02], [0.5, 0.0]), ([0.0111, 0.02], [-0.5, 0.0])]);
    let mut model = with_masses(&pair, &masses);
    run_to(&mut model, 2000);
    let end = discs(&model);
    end[1].velocity[0] - end[0].velocity[0]
}

/// Friction coefficient of a disc on the floor: its deceleration over g.
fn measured_friction(config: DemConfig, mass: f64) -> f64 {
    let start = given(config, &[([0.005, 5e-4], [0.5, 0.0])]);
    let mut model = with_masses(&start, &[mass]);
    run_to_time(&mut model, 0.03);
    (0.5 - frame(&model).state()[2]) / (0.03 * G)
}

#[test]
fn pair_rebounds_with_the_restitution_of_its_materials() {
    let (hard, soft) = (3.0, 1.0);
    let mixed = ((0.81 + 0.16) / 2.0_f64).sqrt();
    for (name, masses, expected) in
        [("hard", [hard, hard], 0.9), ("soft", [soft, soft], 0.4), ("mixed", [hard, soft], mixed)]
    {
        let found = measured_restitution(two_materials(), masses);
        println!("{name}: e = {found:.4}, expected {expected:.4}");
        assert!((found - expected).abs() < BAND);
    }
    let config = with_pair(two_materials(), ["soft", "hard"], Some(0.75), None);
    let found = measured_restitution(config, [hard, soft]);
    println!("given: e = {found:.4}");
    // Control: the default for the pair is rejected.
    assert!((found - 0.75).abs() < BAND && (found - mixed).abs() > BAND);
}

#[test]
fn disc_slides_with_the_smaller_or_the_given_friction() {
    // The walls have the manifest's coefficient, 0.3.
    for (name, mass, expected) in [("hard", 3.0, 0.1), ("soft", 1.0, 0.3)] {
        let found = measured_friction(two_materials(), mass);
        println!("{name}: mu = {found:.4}, expected {expected}");
        assert!((found / expected - 1.0).abs() < 0.01);
    }
    let config = with_pair(two_materials(), ["hard", "wall"], None, Some(0.2));
    let found = measured_friction(config, 3.0);
    println!("given: mu = {found:.4}");
    assert!((found / 0.2 - 1.0).abs() < 0.01);
}

#[test]
fn materials_are_drawn_by_their_fractions() {
    let mut config = two_materials();
    config.materials[0].fraction = positive(3.0);
    let config = DemConfig { discs: std::num::NonZeroU32::new(600).expect("not zero"), ..config };
    let model = Dem::prepare(&config, Seed { seed: 2, replicate: 0 }, false)
        .unwrap_or_else(|error| panic!("{error}"));
    let hard = discs(&model).iter().filter(|disc| disc.mass > 2e-3).count();
    println!("{hard} of 600 are hard, 450 expected");
    // Five standard deviations of a binomial count: 5 sqrt(600 * 0.75 * 0.25) = 53.
    assert!(hard.abs_diff(450) < 53);
}
