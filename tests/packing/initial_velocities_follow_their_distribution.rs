//! Laws: velocity components at the start are normal with variance 1 (unmodified) or 1/n (modified), their mean removed;
//! the two starts differ by the factor n^-1/2 alone, so that their trajectories are the same with time stretched by n^1/2:
//! bit for bit where that is a power of two.
//! Source: packing document, modification 4 and `initialize_random`; scaling of hard-disc dynamics.
//! Tolerance: T at the start: n T / sigma^2 is chi-square with 2 (n - 1) degrees of freedom. For other n trajectories
//! part as any rounding grows: 1e-6 over 3 events a disc, while a true difference is of order 1.
//! Control: the modified law's T is rejected where the unmodified is expected.

use crate::runs::{advance_to_count, at_fraction, look, mean_and_standard_error, message, prepare};
use kinetoscope_manifest::model::{InitialVelocities, PackingConfig};
use kinetoscope_physics::model::Model;
use kinetoscope_recording::channels::{PackingCollisions, PackingTemperature};

fn modified(config: &PackingConfig) -> PackingConfig {
    PackingConfig { initial_velocities: InitialVelocities::Modified, ..config.clone() }
}

#[test]
fn trajectories_agree_bit_for_bit_where_n_is_a_power_of_four() {
    for discs in [1_u32, 4, 16, 64, 256] {
        let config = at_fraction(discs, if discs == 1 { 0.02 } else { 0.25 });
        let stretch = f64::from(discs).sqrt();
        let (mut plain, mut slow) = (prepare(&config, 9, 2), prepare(&modified(&config), 9, 2));
        for frame in 0..=100 {
            advance_to_count(&mut plain, u64::from(frame * discs));
            advance_to_count(&mut slow, u64::from(frame * discs));
            assert_eq!(slow.time(), plain.time() * stretch, "n = {discs}, frame {frame}");
            let collisions = [&plain, &slow].map(message::<PackingCollisions>);
            assert_eq!(collisions[0].pair, collisions[1].pair);
            for (one, other) in look(&plain).iter().zip(look(&slow)) {
                assert_eq!(one.position, other.position);
                assert_eq!(one.velocity, other.velocity.map(|component| component * stretch));
            }
        }
    }
}

#[test]
fn trajectories_agree_to_rounding_for_other_n() {
    for discs in [5_u32, 20, 50] {
        let config = at_fraction(discs, 0.25);
        let stretch = f64::from(discs).sqrt();
        let (mut plain, mut slow) = (prepare(&config, 4, 0), prepare(&modified(&config), 4, 0));
        let count = u64::from(3 * discs);
        advance_to_count(&mut plain, count);
        advance_to_count(&mut slow, count);
        assert!((slow.time() / plain.time() / stretch - 1.0).abs() < 1e-6);
        for (one, other) in look(&plain).iter().zip(look(&slow)) {
            for axis in 0..2 {
                assert!((one.position[axis] - other.position[axis]).abs() < 1e-6);
                assert!((one.velocity[axis] - other.velocity[axis] * stretch).abs() < 1e-6);
            }
        }
    }
}

/// Whether the mean of T over replicates is 2 (1 - 1/n) variance within 4.5 standard errors, and its scatter
/// sqrt(4 (n - 1)) / n variance within a fifth.
fn has_law(config: &PackingConfig, variance: f64) -> bool {
    let discs = f64::from(config.discs.get());
    let temperatures: Vec<f64> = (0..1000)
        .map(|replicate| message::<PackingTemperature>(&prepare(config, 8, replicate)).temperature)
        .collect();
    let (mean, error) = mean_and_standard_error(&temperatures);
    let expected = 2.0 * (1.0 - 1.0 / discs) * variance;
    let scatter = (4.0 * (discs - 1.0)).sqrt() / discs * variance / (1000.0_f64).sqrt();
    println!("n {discs}: T {mean:.5} +- {error:.5}, expected {expected:.5} +- {scatter:.5}");
    (mean - expected).abs() < 4.5 * scatter && (error / scatter - 1.0).abs() < 0.2
}

#[test]
fn temperatures_at_the_start_have_their_law() {
    for discs in [2_u32, 5, 50] {
        let config = at_fraction(discs, 0.03);
        assert!(has_law(&config, 1.0));
        assert!(has_law(&modified(&config), 1.0 / f64::from(discs)));
        assert!(!has_law(&modified(&config), 1.0));
    }
}

#[test]
fn the_mean_velocity_is_removed_unless_there_is_one_disc() {
    for discs in [2, 7, 50] {
        let seen = look(&prepare(&at_fraction(discs, 0.03), 8, 0));
        for axis in 0..2 {
            assert!(seen.iter().map(|disc| disc.velocity[axis]).sum::<f64>().abs() < 1e-13);
        }
    }
    let lonely = look(&prepare(&at_fraction(1, 0.03), 8, 0));
    assert!(lonely[0].velocity.iter().all(|component| *component != 0.0));
}
