//! Law: the restitution e of a spring-dashpot collision depends only on its damping ratio zeta, and zeta only on e.
//! Attractive tail: e = exp(-pi b/w). Clamped tail: e = exp{-(b/w) [pi - atan(2 b w/(w^2 - b^2))]} for zeta < 1/sqrt 2,
//! exp{-(b/w) atan(2 b w/(b^2 - w^2))} for 1/sqrt 2 < zeta < 1, e^-2 at 1, and 1/(4 zeta^2) for zeta >> 1.
//!
//! Source: Schwager and Pöschel, Granular Matter 9 (2007) 465. TABLE: these formulas in 50-digit arithmetic, outside
//! this program.
//! Setup: the functions alone, without a simulation.
//! Tolerance: half a unit of the table's eighth digit; 1e-14 for formulas in double precision; 1e-3 for the limit of
//! large zeta, whose next term is of the order ln(zeta)/zeta^2 = 2e-4.
//! Control: the columns of the two tails are not interchangeable.

use kinetoscope_physics::dem::restitution::{damping_ratio, restitution};
use std::f64::consts::PI;

/// Requested e, zeta with the attractive tail, zeta with the clamped tail.
const TABLE: [[f64; 3]; 4] = [
    [0.9, 0.033_518_45, 0.034_265_20],
    [0.8, 0.070_850_30, 0.074_355_10],
    [0.5, 0.215_453_76, 0.255_275_64],
    [0.2, 0.455_949_81, 0.731_246_93],
];

fn agrees_with_the_table(tail: bool, column: usize) -> bool {
    TABLE.iter().all(|row| (damping_ratio(row[0], tail) - row[column]).abs() < 0.6e-8)
}

#[test]
fn damping_ratio_equals_the_table() {
    assert!(agrees_with_the_table(false, 1));
    assert!(agrees_with_the_table(true, 2));
}

#[test]
fn control_tables_of_the_tails_are_not_interchangeable() {
    assert!(!agrees_with_the_table(false, 2));
    assert!(!agrees_with_the_table(true, 1));
}

/// Clamped restitution as written in the source, with w0 = 1.
fn published_restitution(zeta: f64) -> f64 {
    let (b, w) = (zeta, libm::sqrt(1.0 - zeta * zeta));
    let angle = libm::atan(2.0 * b * w / (w * w - b * b));
    // Above 1/sqrt 2 the source's second case is atan(2 b w / (b^2 - w^2)) = -angle.
    libm::exp(-(b / w) * if zeta * zeta < 0.5 { PI - angle } else { -angle })
}

#[test]
fn clamped_formula_equals_the_published_one() {
    for step in 1..100 {
        let zeta = f64::from(step) / 100.0;
        let difference = restitution(zeta, true) - published_restitution(zeta);
        assert!(difference.abs() < 1e-14, "zeta = {zeta}: {difference:e}");
    }
}

#[test]
fn clamped_formula_is_continuous_at_critical_damping_and_has_the_correct_limit() {
    let critical = libm::exp(-2.0);
    for near in [1.0 - 1e-9, 1.0, 1.0 + 1e-9] {
        assert!((restitution(near, true) - critical).abs() < 1e-9);
    }
    let far = restitution(150.0, true) * 4.0 * 150.0 * 150.0;
    // The next term is of the order ln(zeta)/zeta^2 = 2e-4.
    assert!((far - 1.0).abs() < 1e-3, "{far}");
    assert_eq!(restitution(1.0, false), 0.0);
}

#[test]
fn restitution_inverts_damping_ratio() {
    for tail in [false, true] {
        for step in 1..=100 {
            let requested = f64::from(step) / 100.0;
            let obtained = restitution(damping_ratio(requested, tail), tail);
            assert!((obtained - requested).abs() < 1e-14, "{tail:?} {requested}: {obtained}");
        }
    }
}
