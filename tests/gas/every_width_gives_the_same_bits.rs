//! Guarantee: a gas has the same bits in registers of every width: AVX-512, AVX2 and plain x86-64.
//!
//! Setup: points in circles with a wall at rest and with a wall that moves, of radii that are powers of two and of others, from the start to
//! thousands of wall collisions, in closed form and in time steps; the numbers of particles do not fill the last register. Widths that the
//! processor does not have are left out.
//! Tolerance: none; the state and all messages of the frames are compared.
//! Control: another wall speed, by one part in 10^12, changes the bits.

use crate::runs::{advance, count, frame, gas, positive};
use kinetoscope_manifest::model::{GasConfig, Propagation};
use kinetoscope_manifest::quantity::Finite;
use kinetoscope_physics::model::Target;
use kinetoscope_physics::simd::registers::widest;

/// Widths of the propagators' registers.
const WIDTHS: [usize; 2] = [4, 8];
/// Times of the frames, s.
const TIMES_S: [f64; 5] = [0.0, 1e-4, 0.013, 1.7, 20.0];

fn config(particles: u32, radius: f64, wall_speed: f64, propagation: Propagation) -> GasConfig {
    GasConfig {
        particles: count(particles),
        radius_m: positive(radius),
        wall_speed_m_per_s: Finite::literal(wall_speed),
        duration_s: positive(20.0),
        propagation,
        ..GasConfig::default()
    }
}

/// Bits of the state and of the messages of all frames.
fn bits(config: &GasConfig, max_width: usize) -> Vec<u64> {
    let mut gas = gas(config, 11).with_max_width(max_width);
    let mut bits = Vec::new();
    for time_s in TIMES_S {
        advance(&mut gas, Target::Time(time_s));
        let frame = frame(&gas);
        bits.extend(frame.state().iter().map(|number| number.to_bits()));
        let messages = frame.messages().flat_map(|message| message.payload.iter());
        bits.extend(messages.map(|byte| u64::from(*byte)));
    }
    bits
}

fn assert_same_bits(config: &GasConfig, name: &str) {
    let plain = bits(config, 1);
    for width in WIDTHS.into_iter().filter(|&width| width <= widest()) {
        assert!(bits(config, width) == plain, "{name}, width {width}");
    }
}

#[test]
fn closed_form_has_the_same_bits_at_every_width() {
    for (radius, wall_speed) in
        [(1.0, 0.0), (0.7, 0.0), (3.0, 0.0), (1024.0, 0.0), (1.0, 0.01), (0.9, -0.01)]
    {
        let config = config(1003, radius, wall_speed, Propagation::Exact);
        assert_same_bits(&config, &format!("radius {radius}, wall speed {wall_speed}"));
    }
}

#[test]
fn time_steps_have_the_same_bits_at_every_width() {
    let propagation = Propagation::TimeStepped { time_step_s: positive(2e-3) };
    assert_same_bits(&config(203, 1.0, 0.0, propagation), "time steps");
}

#[test]
fn control_another_wall_speed_alters_bits() {
    let [one, other] = [0.01, 0.01 * (1.0 + 1e-12)]
        .map(|speed| bits(&config(1003, 1.0, speed, Propagation::Exact), 1));
    assert!(one != other);
}
