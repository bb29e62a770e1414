//! Laws of the time at which two discs touch, |r + g t| = s.
//!
//! Source: for a relative velocity along x, the closed form t = x - sqrt(s^2 - y^2); close to contact, t = (r^2 - s^2)/(-2 r.g) for any
//! size of the gap.
//! Setup: a distance of 1e6 diameters, up to nearly grazing collisions; gaps of a few rounding errors, in all directions.
//! Tolerance: 4 rounding errors of t at a distance, 1e-9 of t for the gaps.
//! Control: with the discriminant (r.g)^2 - g^2 (r^2 - s^2), the error at a distance is 1e-4; -r.g - sqrt(...) has no correct digit for the
//! gaps and can be negative.

use kinetoscope_physics::collision_time::time_to_contact;

/// The smaller root by the textbook's quadratic formula.
fn by_quadratic_formula(r: [f64; 2], g: [f64; 2], s: f64) -> f64 {
    let [b, square, c] =
        [r[0] * g[0] + r[1] * g[1], g[0] * g[0] + g[1] * g[1], r[0] * r[0] + r[1] * r[1] - s * s];
    (-b - (b * b - square * c).sqrt()) / square
}

#[test]
fn time_to_contact_is_exact_for_distant_and_grazing_discs() {
    let mut control = 0.0;
    for offset in [0.0, 1.0, 1.9, 1.999] {
        let (r, g) = ([2e6, offset], [-1.0, 0.0]);
        let expected = 2e6 - (4.0_f64 - offset * offset).sqrt();
        let time = time_to_contact(r, g, 2.0);
        assert!((time - expected).abs() < 4.0 * 2e6 * f64::EPSILON, "offset {offset}: {time}");
        let error = (by_quadratic_formula(r, g, 2.0) - expected).abs();
        control = if error > control { error } else { control };
    }
    assert!(control > 1e-5, "control: {control:e}");
}

#[test]
fn time_to_contact_is_exact_for_tiny_gaps() {
    let mut wrong = 0;
    for step in 0..1000 {
        let angle = 0.01 * f64::from(step);
        let distance = 2.0 * (1.0 + 3.0 * f64::EPSILON);
        let r = [distance * libm::cos(angle), distance * libm::sin(angle)];
        let g = [-0.7 * r[0] + 0.2 * r[1], -0.7 * r[1] - 0.2 * r[0]];
        let gap = r[0] * r[0] + r[1] * r[1] - 4.0;
        let expected = if gap > 0.0 { gap / (2.0 * 0.7 * 4.0) } else { 0.0 };
        let is_exact = |time: f64| (time - expected).abs() <= 1e-9 * expected;
        let time = time_to_contact(r, g, 2.0);
        assert!(is_exact(time), "{time:e} and {expected:e}");
        wrong += u32::from(!is_exact(by_quadratic_formula(r, g, 2.0)));
    }
    assert!(wrong > 500, "control: {wrong}");
}
