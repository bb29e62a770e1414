//! Law: a wall rotates the outgoing direction by phi, normal with mean 0 and variance pi/1000. The speed is conserved,
//! the disc never moves back into the wall, and no other disc changes its velocity.
//!
//! Source: packing exercise, section `pcolisiona` and equations 1 to 3; its code draws sqrt(pi/1000) N(0, 1).
//! Setup: one disc that moves perpendicular to a wall, 20,000 times, so that phi is the outgoing direction; a disc that
//! grazes the wall, which a third of all angles would turn back into the wall. For the perpendicular disc, this would
//! require phi > pi/2, 28 standard deviations.
//! Tolerance: 4.5 standard errors. (n - 1) S^2 / sigma^2 is chi-square with n - 1 degrees of freedom, so the standard
//! error of S^2 / sigma^2 is sqrt(2 / n) = 0.01; that of the mean is sigma / sqrt(n). The fourth moment of a normal
//! distribution is 3 sigma^4 with the standard error sqrt(96 / n) = 0.07. Speeds: four roundings of 1.
//! Control: a standard deviation (instead of the variance) of pi/1000 is rejected.

// Assertions compare within tolerances, so no bit of a run depends on these functions.
#![allow(clippy::disallowed_methods, clippy::unwrap_used)]

use crate::runs::{
    advance_to_count, at_fraction, disc_states, exercise, given, prepare, squared_speed,
};
use kinetoscope_manifest::model::PackingConfig;
use kinetoscope_manifest::quantity::NonNegative;
use kinetoscope_physics::model::Model;
use std::f64::consts::PI;

fn with_variance(config: PackingConfig, variance: f64) -> PackingConfig {
    PackingConfig { wall_noise_variance_rad2: NonNegative::new(variance).unwrap(), ..config }
}

/// Angles by which the right wall rotates the direction of a perpendicular disc. Each seed is one draw.
fn angles(variance: f64, count: u64) -> Vec<f64> {
    let config = with_variance(given(&[[18.0, 0.0, 1.0, 0.0]]), variance);
    (0..count)
        .map(|seed| {
            let mut packing = prepare(&config, seed, 0);
            advance_to_count(&mut packing, 1);
            let [x, y] = disc_states(&packing)[0].velocity;
            assert!(x < 0.0, "the disc must leave the wall");
            assert!((squared_speed([x, y]).sqrt() - 1.0).abs() < 4.0 * f64::EPSILON);
            (-y).atan2(-x)
        })
        .collect()
}

fn is_normal_with_variance(angles: &[f64], variance: f64) -> bool {
    let count = angles.len() as f64;
    let mean = angles.iter().sum::<f64>() / count;
    let central =
        |power| angles.iter().map(|angle| (angle - mean).powi(power)).sum::<f64>() / count;
    let (second, fourth) = (central(2) / variance, central(4) / (variance * variance));
    println!("mean {mean:.5}, variance {second:.4}, fourth moment {fourth:.3} (in units of sigma)");
    mean.abs() < 4.5 * (variance / count).sqrt()
        && (second - 1.0).abs() < 4.5 * (2.0 / count).sqrt()
        && (fourth - 3.0).abs() < 4.5 * (96.0 / count).sqrt()
}

#[test]
fn angle_is_normal_with_the_variance_of_the_exercise() {
    let angles = angles(exercise().wall_noise_variance_rad2.get(), 20_000);
    assert!(is_normal_with_variance(&angles, PI / 1000.0));
    // Control.
    assert!(!is_normal_with_variance(&angles, (PI / 1000.0) * (PI / 1000.0)));
}

/// The direction after the collision is that of the specular reflection plus phi, at any angle of incidence: the perpendicular disc of the
/// same seed gives phi. Source: packing exercise, equation 3. Tolerance: 16 rounding errors of angles up to pi.
/// Control: the exercise's program rotates vy with the vx that it has just rotated, so that vy is off by phi sin(phi).
#[test]
fn direction_is_that_of_the_specular_reflection_plus_the_angle() {
    let variance = PI / 100.0;
    let mut control = 0;
    for (seed, phi) in angles(variance, 200).into_iter().enumerate() {
        for (speed, theta) in [(1.0, 0.2), (3e-5, 0.5), (2e7, -0.4)] {
            let [vx, vy] = [speed * libm::cos(theta), speed * libm::sin(theta)];
            let config = with_variance(given(&[[18.0, 0.0, vx, vy]]), variance);
            let mut packing = prepare(&config, seed as u64, 0);
            advance_to_count(&mut packing, 1);
            let [x, y] = disc_states(&packing)[0].velocity;
            let wanted = theta - phi;
            // Both angles are measured from the normal, which points to the left.
            let is_wanted = |x: f64, y: f64| ((y).atan2(-x) - wanted).abs() < 16.0 * f64::EPSILON;
            assert!(is_wanted(x, y), "seed {seed}, {theta}: {} for {wanted}", y.atan2(-x));
            let rotated = -vx * phi.cos() - vy * phi.sin();
            control += u32::from(!is_wanted(rotated, rotated * phi.sin() + vy * phi.cos()));
        }
    }
    assert!(control > 500, "control: {control}");
}

/// The rule as printed in the exercise would move a grazing disc through the wall.
#[test]
fn grazing_disc_leaves_the_wall_at_constant_speed() {
    let variances = [PI / 1000.0, 1.0, 100.0];
    for (seed, variance) in (0..3000).zip(variances.into_iter().cycle()) {
        let config = with_variance(given(&[[0.0, 18.5, 3.0, 0.05]]), variance);
        let mut packing = prepare(&config, seed, 0);
        advance_to_count(&mut packing, 1);
        let velocity = disc_states(&packing)[0].velocity;
        // The disc reaches the top wall after 10 and the right wall after 6.3, so it has left one of the two.
        assert!(velocity[0] < 0.0);
        assert!((squared_speed(velocity) / squared_speed([3.0, 0.05]) - 1.0).abs() < 1e-15);
        for count in 2..20 {
            advance_to_count(&mut packing, count);
            let disc = disc_states(&packing)[0];
            for axis in 0..2 {
                let at_wall = disc.position[axis].abs() == 19.0;
                assert!(!at_wall || disc.position[axis] * disc.velocity[axis] <= 0.0);
                assert!(disc.position[axis].abs() <= 19.0);
            }
        }
    }
}

/// The rule as printed in the exercise also rotates the velocities of other discs.
#[test]
fn wall_collision_changes_one_disc_only() {
    let mut packing = prepare(&at_fraction(50, 0.1), 5, 0);
    for count in 1..=2000 {
        let before = disc_states(&packing);
        advance_to_count(&mut packing, count);
        let after = disc_states(&packing);
        let changed: Vec<usize> =
            (0..50).filter(|&disc| before[disc].velocity != after[disc].velocity).collect();
        assert!(changed.len() == 1 || changed.len() == 2, "event {count}: {changed:?}");
        if let [disc] = changed[..] {
            let speeds = [before, after].map(|discs| squared_speed(discs[disc].velocity));
            assert!((speeds[1] / speeds[0] - 1.0).abs() < 1e-15);
        }
    }
    assert_eq!(packing.count(), 2000);
}
