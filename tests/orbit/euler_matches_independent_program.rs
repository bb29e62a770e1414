//! Law: explicit Euler as printed in the orbit exercise, r(n+1) = r(n) + v(n) h and v(n+1) = v(n) + a(r(n)) h, gives
//! the same numbers in an independent program.
//!
//! Source: equations (14) to (16) of the orbit exercise. The reference values are printed with 17 digits by
//! `tests/interop/orbit_euler.py` (plain Python 3, written independently of this program).
//! Setup: the initial state of the exercise, N = floor(T / h + 1e-9) steps.
//! Tolerance: none. Both programs execute the same sums, products, quotients and square roots in the same order, and
//! IEEE 754 defines the rounding of each.
//! Control: the semi-implicit method, which differs only in the position used for the kick, is rejected, and so is a
//! step with a different association of products.

use crate::run::{JULIAN_YEAR, exercise, finished, observe};
use kinetoscope_manifest::model::OrbitIntegrator;
use kinetoscope_physics::constants::GM_SUN_AU3_PER_DAY2;
use kinetoscope_physics::orbit::BARYCENTRIC_START;
use std::process::Command;

/// Step (days) and position (AU) after 365.25 days: `python3 tests/interop/orbit_euler.py`.
const AFTER_ONE_YEAR: [(f64, [f64; 3]); 3] = [
    (1.0 / 24.0, [-0.195_031_692_606_949_44, 0.970_545_320_910_731_3, -6.911_350_179_845_52e-5]),
    (0.25, [0.009_027_088_902_342_602, 1.033_069_120_307_039_5, -7.087_045_965_435_331e-5]),
    (0.5, [0.252_128_173_008_902_9, 1.054_572_797_231_453_8, -6.932_310_031_693_968e-5]),
];

/// Duration (days) and position (AU) with steps of 0.25 days: `python3 tests/interop/orbit_euler.py 3652.5 0.25`, and
/// the same with 36525.
const LATER: [(f64, [f64; 3]); 2] = [
    (3652.5, [1.332_261_203_710_371_4, -0.412_974_588_009_352_8, 4.495_295_699_199_534e-5]),
    (36525.0, [1.123_612_969_645_329_9, 2.279_871_910_919_100_6, -0.000_142_670_295_086_253_98]),
];

fn position_after(integrator: OrbitIntegrator, step: f64, duration: f64) -> [f64; 3] {
    observe(&finished(&exercise(integrator, step, duration))).state.position
}

fn bits(position: [f64; 3]) -> [u64; 3] {
    position.map(f64::to_bits)
}

#[test]
fn position_after_one_year_is_bitwise_identical() {
    for (step, expected) in AFTER_ONE_YEAR {
        let position = position_after(OrbitIntegrator::ExplicitEuler, step, JULIAN_YEAR);
        assert_eq!(bits(position), bits(expected), "step {step}: {position:?} {expected:?}");
    }
}

#[test]
fn position_after_ten_and_a_hundred_years_is_bitwise_identical() {
    for (duration, expected) in LATER {
        let position = position_after(OrbitIntegrator::ExplicitEuler, 0.25, duration);
        assert_eq!(bits(position), bits(expected), "{duration} d: {position:?} {expected:?}");
    }
}

#[test]
fn control_different_method_and_order_of_products_are_rejected() {
    let (step, expected) = AFTER_ONE_YEAR[1];
    let other = position_after(OrbitIntegrator::SemiImplicitEuler, step, JULIAN_YEAR);
    assert_ne!(bits(other), bits(expected));

    let [mut r, mut v] = [BARYCENTRIC_START.position, BARYCENTRIC_START.velocity];
    for _ in 0..1461 {
        let squared = r[0] * r[0] + (r[1] * r[1] + r[2] * r[2]);
        let k = -GM_SUN_AU3_PER_DAY2 / (squared * squared.sqrt());
        let drifted = [r[0] + v[0] * step, r[1] + v[1] * step, r[2] + v[2] * step];
        v = [v[0] + k * (r[0] * step), v[1] + k * (r[1] * step), v[2] + k * (r[2] * step)];
        r = drifted;
    }
    assert_ne!(bits(r), bits(expected));
}

#[test]
#[ignore = "needs python3"]
fn independent_program_prints_the_reference_values() {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/interop/orbit_euler.py");
    let output = Command::new("python3").arg(script).output().unwrap();
    let printed = String::from_utf8(output.stdout).unwrap();
    let lines: Vec<Vec<f64>> = printed
        .lines()
        .map(|line| line.split(' ').map(|word| word.parse().unwrap()).collect())
        .collect();
    let expected: Vec<Vec<f64>> =
        AFTER_ONE_YEAR.iter().map(|(step, [x, y, z])| vec![*step, *x, *y, *z]).collect();
    assert_eq!(lines, expected);
}
