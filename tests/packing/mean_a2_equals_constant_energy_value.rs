//! Law: in the elastic steady state, the time average of a2 = <v^4> / (2 <v^2>^2) - 1 is -1/(n + 1), because velocities
//! are uniform on the sphere of constant energy in 2n dimensions.
//!
//! Source: moments of the uniform distribution on a sphere, <v^4>/<v^2>^2 = 2n/(n + 1); packing exercise,
//! `calculate_averages`.
//! Setup: n = 5, 20, 50; 300 replicates; 20 samples at equal time intervals after 30 n events (samples at events would
//! be weighted by the collision rate).
//! Tolerance: 4.5 standard errors across replicates.
//! Control: 0, the value of infinitely many discs, is rejected.

use crate::runs::{
    advance_to_count, advance_to_time, at_fraction, mean_and_standard_error, message, prepare,
};
use kinetoscope_physics::model::Model;
use kinetoscope_recording::channels::PackingTemperature;

const SAMPLES: u32 = 20;

fn mean_a2(discs: u32, replicate: u32) -> f64 {
    let mut packing = prepare(&at_fraction(discs, 0.2), 6, replicate);
    advance_to_count(&mut packing, u64::from(30 * discs));
    let start = packing.time();
    // Three events per disc between samples: 30 n events took `start`.
    let interval = start / 10.0;
    let sum: f64 = (1..=SAMPLES)
        .map(|sample| {
            advance_to_time(&mut packing, start + f64::from(sample) * interval);
            message::<PackingTemperature>(&packing).a2
        })
        .sum();
    sum / f64::from(SAMPLES)
}

#[test]
fn mean_a2_equals_the_value_at_constant_energy() {
    for discs in [5, 20, 50] {
        let means: Vec<f64> = (0..300).map(|replicate| mean_a2(discs, replicate)).collect();
        let (mean, error) = mean_and_standard_error(&means);
        let expected = -1.0 / (f64::from(discs) + 1.0);
        println!("n {discs}: a2 {mean:.5} +- {error:.5}, expected {expected:.5}");
        assert!((mean - expected).abs() < 4.5 * error);
        // Control.
        assert!(mean.abs() > 4.5 * error);
    }
}
