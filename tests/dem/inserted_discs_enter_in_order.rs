//! Law: inserted discs enter in the order of their ids, at the requested rate if there is room, without overlap, and
//! with the energy that the energy balance reports. The number of discs inside is the initial number plus entered minus
//! removed discs.
//!
//! Source: conservation of the number of discs, and of energy.
//! Setup: insertion of 100 discs per second for 0.4 s onto an empty floor; insertion faster than the insertion line
//! clears; a funnel with an outlet; one disc that falls in without a contact.
//! Tolerance: none for numbers and order. Overlap is excluded exactly at entry and stays below 1 % afterwards. The
//! energy-balance error is below 2 % of the energy that entered.
//! Control: a balance without the energy of the inserted discs does not close; insertion faster than the line clears is
//! delayed.

use crate::scene::{
    discs, energy, finite, frame, given, gravity, non_negative, positive, prepared, run_to_time,
    segment,
};
use kinetoscope_manifest::model::{DemConfig, DemInsertion, DemIntegrator};
use kinetoscope_manifest::quantity::Finite;
use kinetoscope_physics::dem::Dem;
use kinetoscope_recording::channels::DemWalls;
use std::num::NonZeroU32;

const G: f64 = 9.81;

fn insertion(discs: u32, discs_per_s: f64) -> DemInsertion {
    DemInsertion {
        discs: NonZeroU32::new(discs).expect("not zero"),
        discs_per_s: positive(discs_per_s),
        from_m: finite([0.005, 0.035]),
        to_m: finite([0.035, 0.035]),
        velocity_m_per_s: finite([0.0, -0.5]),
        starts_s: non_negative(0.02),
    }
}

/// One disc at rest on the floor, and insertion.
fn scene(insertion: DemInsertion) -> DemConfig {
    let config = DemConfig {
        insertion: Some(insertion),
        friction: non_negative(0.3),
        ..DemConfig::default()
    };
    given(config, &[([0.02, 5e-4], [0.0, 0.0])])
}

/// Numbers of discs that have entered and that were removed.
fn entered_and_removed(model: &Dem) -> (u64, u64) {
    let walls: DemWalls = frame(model).get().expect("wall data");
    (walls.discs_entered, walls.discs_removed)
}

#[test]
fn discs_enter_in_order_at_their_rate() {
    let mut model = prepared(&scene(insertion(40, 100.0)));
    for number in 0..=50 {
        let time = 0.01 * f64::from(number);
        run_to_time(&mut model, time);
        let (entered, _) = entered_and_removed(&model);
        // The first disc is due at 0.02 s; the line is free every 2 ms, the time in which a disc clears it.
        let due = |time: f64| if time < 0.02 { 0 } else { ((time - 0.02) * 100.0 + 1.0) as u64 };
        assert!(entered <= due(time) && entered >= due(time - 0.0025).min(40), "{time}: {entered}");
        let ids: Vec<u32> = discs(&model).iter().map(|disc| disc.id).collect();
        assert!(ids.iter().copied().eq(0..=entered as u32));
    }
    assert_eq!(entered_and_removed(&model), (40, 0));
}

#[test]
fn inserted_discs_do_not_overlap() {
    let mut model = prepared(&scene(insertion(300, 1e5)));
    let mut before = 1;
    for step in 1..400 {
        run_to_time(&mut model, 0.02 + 2e-4 * f64::from(step));
        let state = discs(&model);
        // Discs in free fall stay separated; on the floor, contacts overlap by less than 1 %.
        for (number, disc) in state.iter().enumerate().skip(before) {
            for other in &state[..number] {
                let branch = [0, 1].map(|axis: usize| disc.position[axis] - other.position[axis]);
                let distance = (branch[0] * branch[0] + branch[1] * branch[1]).sqrt();
                assert!(distance > 0.99 * (disc.radius + other.radius));
            }
        }
        before = state.len();
    }
    // Control: a line of 30 diameters is free every 2 ms, so not all of the 1000 discs due after 10 ms can enter.
    let mut model = prepared(&scene(insertion(2000, 1e5)));
    run_to_time(&mut model, 0.03);
    let (entered, _) = entered_and_removed(&model);
    println!("{entered} of 1000 due discs entered");
    assert!((60..=180).contains(&entered));
}

/// A rate at which more discs are due than any integer counts: all enter as soon as the line has room.
/// Control: at the smallest rate, only the first disc is due, at the start of the insertion.
#[test]
fn discs_enter_at_rates_of_any_size() {
    for (rate, expected) in [(1e300, 3), (5e-324, 1)] {
        let mut model = prepared(&scene(insertion(3, rate)));
        run_to_time(&mut model, 0.05);
        assert_eq!(entered_and_removed(&model), (expected, 0), "{rate:e} discs per second");
    }
}

#[test]
fn inserted_disc_adds_its_energy_to_the_balance() {
    for integrator in [DemIntegrator::SemiImplicitEuler, DemIntegrator::VelocityVerlet] {
        let config = DemConfig { integrator, ..scene(insertion(1, 100.0)) };
        let mut model = prepared(&config);
        run_to_time(&mut model, 0.03);
        let energy = energy(&model);
        let expected = 1e-3 * (0.5 * 0.25 + G * 0.035);
        println!("{integrator:?}: {:e} J entered, expected {expected:e} J", energy.entered_j);
        // With Euler, the given velocity is that of half a step earlier: m g v dt/2 = 5e-8 J.
        assert!((energy.entered_j - expected).abs() < 1e-7);
        assert!(energy.residual_j.abs() < 1e-7);
    }
}

#[test]
fn number_of_discs_and_energy_are_conserved_with_an_outlet() {
    let config = DemConfig {
        walls: vec![segment([0.0, 0.02], [0.015, 0.008]), segment([0.04, 0.02], [0.025, 0.008])],
        remove_below_m: Finite::new(0.004),
        gravity_m_per_s2: gravity(0.0, -G),
        ..given(
            DemConfig { insertion: Some(insertion(400, 2000.0)), ..DemConfig::default() },
            &[([0.02, 0.02], [0.0, 0.0])],
        )
    };
    let mut model = prepared(&config);
    for number in 1..=40 {
        run_to_time(&mut model, 0.01 * f64::from(number));
        let (entered, removed) = entered_and_removed(&model);
        assert_eq!(discs(&model).len() as u64, 1 + entered - removed);
    }
    let (entered, removed) = entered_and_removed(&model);
    let energy = energy(&model);
    let residual = |offset: f64| (energy.residual_j + offset).abs() / energy.entered_j;
    println!(
        "{entered} entered, {removed} removed, residual {:.1e} of the energy entered",
        residual(0.0)
    );
    assert!(entered == 400 && removed > 200);
    assert!(residual(0.0) < 0.02);
    assert!(residual(energy.entered_j) > 0.02, "control");
}
