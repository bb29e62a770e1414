//! Guarantee: how often the neighbor lists are rebuilt, and in which order they then name the two discs of a pair, does not affect the
//! trajectory: the springs of contacts keep their stretch, and a rolling spring, which is stretched by the rotation of the first disc
//! against the second, keeps its sense.
//!
//! Source: Newton's third law: the torque of a rolling spring on one disc is the opposite of that on the other (Luding,
//! Granular Matter 10 (2008) 235, section 3.3), before and after a rebuild.
//! Setup: a bed of several blocks with sliding and rolling friction collapses in one chamber; a disc in another chamber is at rest, or so
//! fast that it makes the program rebuild all lists every few steps, with another skin and thus another order of the discs.
//! Tolerance: 1e-9 of a radius and of the spins; the order of sums is another, and rounding grows in collisions. A spring that loses
//! its stretch or its sense would cause 1e-4.
//! Control: another coefficient of rolling friction is rejected.

use crate::scene::{
    Disc, discs, given, gravity, non_negative, positive, prepared, restitution, run_to, segment,
    spring,
};
use kinetoscope_manifest::model::DemConfig;

const RADIUS: f64 = 5e-4;
const COLUMNS: u32 = 100;
const ROWS: u32 = 45;
const STEPS: u64 = 400;

/// The bed after some steps, in the order of the ids.
fn bed_after(speed_of_other_disc: f64, rolling_friction: f64) -> Vec<Disc> {
    let (width, height) = (2.1 * RADIUS * f64::from(COLUMNS), 0.06);
    let place = |disc: u32| {
        let (column, row) = (f64::from(disc % COLUMNS), f64::from(disc / COLUMNS));
        // Every other row is shifted; the discs move in directions that fill the circle evenly (Weyl 1916).
        let shift = if (disc / COLUMNS).is_multiple_of(2) { 0.0 } else { 0.06 * RADIUS };
        let angle = std::f64::consts::TAU * (f64::from(disc) * std::f64::consts::SQRT_2).fract();
        let position = [RADIUS * (1.02 + 2.08 * column) + shift, RADIUS * (1.01 + 2.02 * row)];
        (position, [0.3 * libm::cos(angle), 0.3 * libm::sin(angle)])
    };
    let mut placed: Vec<([f64; 2], [f64; 2])> = (0..COLUMNS * ROWS).map(place).collect();
    placed.push(([width + 0.005, 0.03], [0.0, -speed_of_other_disc]));
    let config = DemConfig {
        width_m: positive(width + 0.01),
        height_m: positive(height),
        gravity_m_per_s2: gravity(300.0, -981.0),
        elasticity: spring(5e6),
        dissipation: restitution(0.6),
        friction: non_negative(0.5),
        rolling_friction: non_negative(rolling_friction),
        walls: vec![segment([width, 0.0], [width, height])],
        ..DemConfig::default()
    };
    let mut model = prepared(&given(config, &placed));
    run_to(&mut model, STEPS);
    let mut discs = discs(&model);
    discs.sort_by_key(|disc| disc.id);
    discs.truncate((COLUMNS * ROWS) as usize);
    discs
}

/// Largest difference of positions over a radius, and of spins over the largest spin.
fn difference(one: &[Disc], other: &[Disc]) -> f64 {
    let larger = |a: f64, b: f64| if a > b { a } else { b };
    let top_spin = one.iter().map(|disc| disc.spin.abs()).fold(0.0, larger);
    assert!(top_spin > 10.0, "the discs do not roll: {top_spin} rad/s");
    let of_pair = |(a, b): (&Disc, &Disc)| {
        let apart = [0, 1].map(|axis: usize| (a.position[axis] - b.position[axis]).abs() / RADIUS);
        larger(larger(apart[0], apart[1]), (a.spin - b.spin).abs() / top_spin)
    };
    one.iter().zip(other).map(of_pair).fold(0.0, larger)
}

#[test]
fn rebuilt_lists_do_not_affect_the_trajectory() {
    let rarely = bed_after(0.0, 0.3);
    let often = difference(&rarely, &bed_after(15.0, 0.3));
    let control = difference(&rarely, &bed_after(0.0, 0.31));
    println!("{often:.1e}; control {control:.1e}");
    assert!(often < 1e-9, "{often:e}");
    assert!(control > 1e-6, "{control:e}");
}
