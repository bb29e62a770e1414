//! Law: initial velocity components are normal with variance 1 (unmodified) or 1/n (modified); their mean is removed
//! only on request, so <v^2> is 2, or 2 (1 - 1/n), in units of the variance. The two initial states differ only by the factor n^-1/2, so their trajectories are the same with time
//! multiplied by n^1/2, bitwise if that is a power of two.
//!
//! Source: packing exercise, modification 4 and `initialize_random`; scaling of hard-disc dynamics.
//! Setup: 1 to 256 discs; 1000 replicates for the initial temperature.
//! Tolerance: 4.5 standard errors of the initial T, where n T / sigma^2 is chi-square with 2 (n - 1) degrees of
//! freedom, or 2 n with the mean velocity. For other n, trajectories diverge by growing rounding errors: 1e-6 over 3 events per disc, while a true
//! difference is of order 1.
//! Control: T of the modified distribution is rejected for the unmodified one.

use crate::runs::{
    advance_to_count, at_fraction, disc_states, mean_and_standard_error, message, prepare,
};
use kinetoscope_manifest::Experiment;
use kinetoscope_manifest::model::{InitialVelocities, ModelConfig, PackingConfig};
use kinetoscope_physics::model::Model;
use kinetoscope_recording::channels::{PackingCollisions, PackingTemperature};
use std::num::NonZeroU32;

fn modified(config: &PackingConfig) -> PackingConfig {
    PackingConfig { initial_velocities: InitialVelocities::VarianceOneOverN, ..config.clone() }
}

#[test]
fn trajectories_are_bitwise_identical_if_n_is_a_power_of_four() {
    for discs in [1_u32, 4, 16, 64, 256] {
        let config = at_fraction(discs, if discs == 1 { 0.02 } else { 0.25 });
        let stretch = f64::from(discs).sqrt();
        let (mut plain, mut slow) = (prepare(&config, 9, 2), prepare(&modified(&config), 9, 2));
        for frame in 0..=100 {
            advance_to_count(&mut plain, u64::from(frame * discs));
            advance_to_count(&mut slow, u64::from(frame * discs));
            assert_eq!(slow.time(), plain.time() * stretch, "n = {discs}, frame {frame}");
            let collisions = [&plain, &slow].map(message::<PackingCollisions>);
            assert_eq!(collisions[0].pair_collisions, collisions[1].pair_collisions);
            for (one, other) in disc_states(&plain).iter().zip(disc_states(&slow)) {
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
        for (one, other) in disc_states(&plain).iter().zip(disc_states(&slow)) {
            for axis in 0..2 {
                assert!((one.position[axis] - other.position[axis]).abs() < 1e-6);
                assert!((one.velocity[axis] - other.velocity[axis] * stretch).abs() < 1e-6);
            }
        }
    }
}

/// Mean of the initial <v^2> over 1000 replicates, and its standard error.
fn mean_square_velocity(config: &PackingConfig) -> (f64, f64) {
    let mean_squares: Vec<f64> = (0..1000)
        .map(|replicate| {
            message::<PackingTemperature>(&prepare(config, 8, replicate)).mean_square_velocity
        })
        .collect();
    mean_and_standard_error(&mean_squares)
}

/// Whether the mean of <v^2> over replicates is 2 f / n variance within 4.5 standard errors, and its scatter is sqrt(4 f) / n
/// variance within 20 %, with f = n - 1 if the mean velocity is removed and n otherwise.
fn has_mean_square_velocity_of(config: &PackingConfig, variance: f64) -> bool {
    let discs = f64::from(config.discs.get());
    let (mean, error) = mean_square_velocity(config);
    let degrees = if config.remove_mean_velocity { discs - 1.0 } else { discs };
    let expected = 2.0 * degrees / discs * variance;
    let scatter = (4.0 * degrees).sqrt() / discs * variance / (1000.0_f64).sqrt();
    println!("n {discs}: <v^2> {mean:.5} +- {error:.5}, expected {expected:.5} +- {scatter:.5}");
    (mean - expected).abs() < 4.5 * scatter && (error / scatter - 1.0).abs() < 0.2
}

#[test]
fn initial_temperature_follows_chi_square() {
    for discs in [2_u32, 5, 50] {
        let config = at_fraction(discs, 0.03);
        assert!(has_mean_square_velocity_of(&config, 1.0));
        assert!(has_mean_square_velocity_of(&modified(&config), 1.0 / f64::from(discs)));
        // Control.
        assert!(!has_mean_square_velocity_of(&modified(&config), 1.0));
    }
}

/// Control: with `remove_mean_velocity`, <v^2> of two discs is 1, which is rejected for the default.
#[test]
fn default_packing_velocities_follow_their_distribution() {
    let two =
        PackingConfig { discs: NonZeroU32::MIN.saturating_add(1), ..PackingConfig::default() };
    let removed = PackingConfig { remove_mean_velocity: true, ..two.clone() };
    let (mean, error) = mean_square_velocity(&two);
    let (control, control_error) = mean_square_velocity(&removed);
    println!(
        "<v^2> of two discs: {mean} +- {error}, without their mean {control} +- {control_error}"
    );
    assert!((mean - 2.0).abs() < 4.5 * error);
    assert!((control - 1.0).abs() < 4.5 * control_error);
    assert!((control - 2.0).abs() > 4.5 * error);
}

#[test]
fn mean_velocity_is_removed_for_more_than_one_disc() {
    for discs in [2, 7, 50] {
        let discs = disc_states(&prepare(&at_fraction(discs, 0.03), 8, 0));
        for axis in 0..2 {
            assert!(discs.iter().map(|disc| disc.velocity[axis]).sum::<f64>().abs() < 1e-13);
        }
    }
    let single = disc_states(&prepare(&at_fraction(1, 0.03), 8, 0));
    assert!(single[0].velocity.iter().all(|component| *component != 0.0));
}

/// The packing exercise draws velocities and subtracts nothing: <v^2> of n discs is 2 on average, also for n = 5, where it is 1.6 without
/// the mean (packing exercise, initial conditions). Its shipped experiments do the same, but for one variant that says so.
#[test]
fn shipped_exercises_start_as_printed() {
    for name in ["packing_fifty_discs", "packing_velocity_laws", "packing_timing_table"] {
        let path = format!("{}/experiments/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        let experiment: Experiment = std::fs::read_to_string(path).unwrap().parse().unwrap();
        for run in &experiment.runs {
            let ModelConfig::Packing(config) = &*run.manifest.model else { panic!("{name}") };
            let says_so = run.coordinates.iter().any(|place| place.value.contains("removed"));
            assert_eq!(config.remove_mean_velocity, says_so, "{name}: {:?}", run.coordinates);
        }
    }
}
