//! Law: discs that fall in come in the order of their ids, at the rate asked for where there is room, without overlap, and bring
//! the energy that the ledger says; nothing is lost: those inside, those to come and those that left are all there are.
//!
//! Source: conservation of the number of discs, and of energy.
//! Setup: rain of 100 discs a second for 0.5 s onto an empty floor; rain ten times faster than the line clears; a funnel with an
//! outlet; one disc that falls in without touching anything.
//! Tolerance: none for numbers and order; overlap at entry is refused exactly; the ledger's residual 2 % of what came in.
//! Control: a ledger without the discs' own energy does not close; more rain than the line clears comes late.

use crate::scene::{
    discs, energy, finite, frame, given, gravity, non_negative, positive, prepared, run_to_time,
    segment,
};
use kinetoscope_manifest::model::{DemConfig, DemIntegrator, DemRain};
use kinetoscope_manifest::quantity::Finite;
use kinetoscope_physics::dem::Dem;
use kinetoscope_recording::channels::DemWalls;
use std::num::NonZeroU32;

const G: f64 = 9.81;

fn rain(discs: u32, discs_per_s: f64) -> DemRain {
    DemRain {
        discs: NonZeroU32::new(discs).expect("not zero"),
        discs_per_s: positive(discs_per_s),
        from_m: finite([0.005, 0.035]),
        to_m: finite([0.035, 0.035]),
        velocity_m_per_s: finite([0.0, -0.5]),
        starts_s: non_negative(0.02),
    }
}

/// One disc at rest on the floor, and rain.
fn scene(rain: DemRain) -> DemConfig {
    let config =
        DemConfig { rain: Some(rain), friction: non_negative(0.3), ..DemConfig::default() };
    given(config, &[([0.02, 5e-4], [0.0, 0.0])])
}

fn entered(model: &Dem) -> (u64, u64) {
    let walls: DemWalls = frame(model).get().expect("walls");
    (walls.discs_entered, walls.discs_removed)
}

#[test]
fn discs_come_in_order_at_their_rate() {
    let mut model = prepared(&scene(rain(40, 100.0)));
    for number in 0..=50 {
        let time = 0.01 * f64::from(number);
        run_to_time(&mut model, time);
        let (came, _) = entered(&model);
        // The first is due at 0.02 s; the line opens every 2 ms, the time in which a disc clears it.
        let due = |time: f64| if time < 0.02 { 0 } else { ((time - 0.02) * 100.0 + 1.0) as u64 };
        assert!(came <= due(time) && came >= due(time - 0.0025).min(40), "{time}: {came}");
        let ids: Vec<u32> = discs(&model).iter().map(|disc| disc.id).collect();
        assert!(ids.iter().copied().eq(0..=came as u32));
    }
    assert_eq!(entered(&model), (40, 0));
}

#[test]
fn none_enters_where_another_stands() {
    let mut model = prepared(&scene(rain(300, 1e5)));
    let mut before = 1;
    for step in 1..400 {
        run_to_time(&mut model, 0.02 + 2e-4 * f64::from(step));
        let seen = discs(&model);
        // Falling freely they keep apart; on the floor contacts give way by less than a hundredth.
        for (number, disc) in seen.iter().enumerate().skip(before) {
            for other in &seen[..number] {
                let apart = [0, 1].map(|axis: usize| disc.position[axis] - other.position[axis]);
                let distance = (apart[0] * apart[0] + apart[1] * apart[1]).sqrt();
                assert!(distance > 0.99 * (disc.radius + other.radius));
            }
        }
        before = seen.len();
    }
    // Control: a line of 30 diameters opens every 2 ms, and does not let the 1000 through that are due after 10 ms.
    let mut model = prepared(&scene(rain(2000, 1e5)));
    run_to_time(&mut model, 0.03);
    let (came, _) = entered(&model);
    println!("{came} of 1000 due came in");
    assert!((60..=180).contains(&came));
}

#[test]
fn a_disc_that_falls_in_brings_its_energy() {
    for integrator in [DemIntegrator::SemiImplicitEuler, DemIntegrator::VelocityVerlet] {
        let config = DemConfig { integrator, ..scene(rain(1, 100.0)) };
        let mut model = prepared(&config);
        run_to_time(&mut model, 0.03);
        let ledger = energy(&model);
        let own = 1e-3 * (0.5 * 0.25 + G * 0.035);
        println!("{integrator:?}: {:e} J came in, its own {own:e} J", ledger.entered_j);
        // Euler's velocity is the given one half a step earlier: m g v dt/2 = 5e-8 J.
        assert!((ledger.entered_j - own).abs() < 1e-7);
        assert!(ledger.residual_j.abs() < 1e-7);
    }
}

#[test]
fn what_comes_in_stays_or_leaves() {
    let config = DemConfig {
        walls: vec![segment([0.0, 0.02], [0.015, 0.008]), segment([0.04, 0.02], [0.025, 0.008])],
        outlet_below_m: Finite::new(0.004),
        gravity_m_per_s2: gravity(0.0, -G),
        ..given(
            DemConfig { rain: Some(rain(400, 2000.0)), ..DemConfig::default() },
            &[([0.02, 0.02], [0.0, 0.0])],
        )
    };
    let mut model = prepared(&config);
    for number in 1..=40 {
        run_to_time(&mut model, 0.01 * f64::from(number));
        let (came, left) = entered(&model);
        assert_eq!(discs(&model).len() as u64, 1 + came - left);
    }
    let (came, left) = entered(&model);
    let ledger = energy(&model);
    let residual = |with: f64| (ledger.residual_j + with).abs() / ledger.entered_j;
    println!("{came} came, {left} left, residual {:.1e} of what they brought", residual(0.0));
    assert!(came == 400 && left > 200);
    assert!(residual(0.0) < 0.02);
    assert!(residual(ledger.entered_j) > 0.02, "control");
}
