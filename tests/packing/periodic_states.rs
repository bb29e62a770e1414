//! Periodic boxes of hard discs: configurations, minimum-image distances, Z and psi6.
#![allow(clippy::disallowed_methods, reason = "statistics in tests are not part of any recording")]

use crate::runs::{
    DiscState, advance_to_count, at_fraction, mean_and_standard_error, message, prepare,
    without_noise,
};
use kinetoscope_manifest::model::{Boundary, PackingConfig, PackingPlacement};
use kinetoscope_physics::model::Model;
use kinetoscope_recording::channels::PackingPressure;
use std::f64::consts::PI;

pub(crate) fn periodic(config: PackingConfig) -> PackingConfig {
    PackingConfig { boundary: Boundary::Periodic, ..without_noise(config) }
}

pub(crate) fn placed(config: PackingConfig, placement: PackingPlacement) -> PackingConfig {
    PackingConfig { placement, ..config }
}

/// Minimum-image displacement from one disc to another.
pub(crate) fn separation(one: &DiscState, other: &DiscState, side: f64) -> [f64; 2] {
    std::array::from_fn(|axis| {
        let difference = other.position[axis] - one.position[axis];
        difference - side * (difference / side).round()
    })
}

pub(crate) fn max_overlap(discs: &[DiscState], side: f64) -> f64 {
    let mut max = f64::NEG_INFINITY;
    for (index, one) in discs.iter().enumerate() {
        for other in &discs[..index] {
            let [x, y] = separation(one, other, side);
            max = max.max(one.radius + other.radius - (x * x + y * y).sqrt());
        }
    }
    max
}

/// Z from the virial and from the collision rate, each with its standard error, over blocks of 20 collisions per disc.
pub(crate) fn pressures(discs: u32, fraction: f64, blocks: u64) -> ([f64; 2], [f64; 2]) {
    let config = periodic(placed(at_fraction(discs, fraction), PackingPlacement::Lattice));
    let ([virial, virial_error], [rate, rate_error]) = excess_and_rate(&config, blocks);
    let excess = PI.sqrt() / 4.0 * 2.0;
    ([1.0 + virial, virial_error], [1.0 + excess * rate, excess * rate_error])
}

/// Z - 1 from the virial, and the pair collision rate per disc over sqrt(kT/m), in a periodic box. Both have their
/// standard error, over blocks of 20 collisions per disc.
pub(crate) fn excess_and_rate(config: &PackingConfig, blocks: u64) -> ([f64; 2], [f64; 2]) {
    let discs = config.discs.get();
    let mut packing = prepare(config, 17, 0);
    let block = 10 * u64::from(discs);
    // Dense lattices melt slowly, so the first 30 blocks are discarded.
    advance_to_count(&mut packing, 30 * block);
    let (mut virials, mut rates) = (Vec::new(), Vec::new());
    let mut before = (message::<PackingPressure>(&packing), packing.time(), packing.count());
    for number in 1..=blocks {
        advance_to_count(&mut packing, (30 + number) * block);
        let now = (message::<PackingPressure>(&packing), packing.time(), packing.count());
        let virial = now.0.collision_virial_sum - before.0.collision_virial_sum;
        let energy = now.0.kinetic_energy_time_integral - before.0.kinetic_energy_time_integral;
        virials.push(0.5 * virial / energy);
        let elapsed = now.1 - before.1;
        let rate = 2.0 * (now.2 - before.2) as f64 / (f64::from(discs) * elapsed);
        let temperature = energy / (elapsed * f64::from(discs));
        rates.push(rate / temperature.sqrt());
        before = now;
    }
    let (virial, virial_error) = mean_and_standard_error(&virials);
    let (rate, rate_error) = mean_and_standard_error(&rates);
    ([virial, virial_error], [rate, rate_error])
}

/// |mean over discs of the mean over neighbors of exp(6 i angle)|, with neighbors closer than 1.4 diameters.
pub(crate) fn hexatic_order(discs: &[DiscState], side: f64) -> f64 {
    let mut sum = [0.0; 2];
    for one in discs {
        let (mut local, mut count) = ([0.0; 2], 0.0);
        for other in discs {
            let [x, y] = separation(one, other, side);
            let distance = (x * x + y * y).sqrt();
            if distance > 0.0 && distance < 2.8 {
                let angle = 6.0 * y.atan2(x);
                local = [local[0] + angle.cos(), local[1] + angle.sin()];
                count += 1.0;
            }
        }
        if count > 0.0 {
            sum = [sum[0] + local[0] / count, sum[1] + local[1] / count];
        }
    }
    (sum[0] * sum[0] + sum[1] * sum[1]).sqrt() / discs.len() as f64
}
