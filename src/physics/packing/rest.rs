//! The end of motion: inelastic discs cool until the powers of their velocities are no longer normal numbers.

use super::motion::Vector;
use crate::model::SimulationFault;
use crate::short_number::short;

/// Fraction of the initial `<v²>` below which discs are at rest.
const REST_FRACTION: f64 = 1e-200;

/// `<v²>` below which discs are at rest from any start: a2 contains its square, whose digits end at 2.2e-308. The slowest start
/// (`start.rs`) has a speed of 1e-60, so one of 1e6 discs that moves gives 1e-126.
const REST_MEAN_SQUARE_SPEED: f64 = 1e-140;

/// What prevents rest.
const HELP: &str = "end the run earlier, or use a restitution closer to 1";

/// The `<v²>` below which discs are at rest after a start with this `<v²>`. Discs without initial motion are not a failure.
#[inline(always)]
pub(super) fn limit(initial_mean_square_speed: f64) -> f64 {
    let fraction = REST_FRACTION * initial_mean_square_speed;
    let limit = if fraction > REST_MEAN_SQUARE_SPEED { fraction } else { REST_MEAN_SQUARE_SPEED };
    if initial_mean_square_speed > 0.0 { limit } else { 0.0 }
}

/// The failure of discs that have come to rest after a number of events.
pub(super) fn fault(events: u64, mean_square_speed: f64, initial: f64) -> SimulationFault {
    SimulationFault::new(
        format!(
            "the discs have come to rest after {events} events: the mean square velocity is {}, at the start it was {}",
            short(mean_square_speed),
            short(initial)
        ),
        HELP,
    )
}

/// The failure of a disc that is too slow to leave a wall with noise: the square of its velocity is no normal number.
pub(super) fn fault_at_wall(disc: u32, [vx, vy]: Vector) -> SimulationFault {
    SimulationFault::new(
        format!(
            "the discs have come to rest: no angle of the wall noise lets disc {disc} leave the wall with the velocity \
             ({}, {})",
            short(vx),
            short(vy)
        ),
        HELP,
    )
}
