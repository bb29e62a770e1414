//! Functions that prepare and advance an orbit run and read its frames.

// Not every test file uses every function; an invalid configuration fails its test.
#![allow(clippy::unwrap_used)]

use kinetoscope_manifest::model::{
    OrbitBody, OrbitConfig, OrbitIntegrator, OrbitStart, OrbitState,
};
use kinetoscope_manifest::quantity::{Finite, NonNegative, Positive};
use kinetoscope_physics::model::{Extent, Model, Progress, Target};
use kinetoscope_physics::orbit::Orbit;
use kinetoscope_physics::orbit::motion::State;
use kinetoscope_physics::random::Seed;
use kinetoscope_recording::channels::{OrbitElements, OrbitEnergy};
use kinetoscope_recording::frame::Frame;

/// Duration of one year in the orbit exercise, days.
pub(crate) const JULIAN_YEAR: f64 = 365.25;

/// Configuration with the initial state of the orbit exercise, an integrator, a step and a duration (days).
pub(crate) fn exercise(integrator: OrbitIntegrator, step: f64, duration: f64) -> OrbitConfig {
    OrbitConfig {
        start: OrbitStart::Barycentric,
        integrator,
        time_step_days: Positive::new(step).unwrap(),
        duration_days: Positive::new(duration).unwrap(),
        ..Default::default()
    }
}

fn vectors(position: [f64; 3], velocity: [f64; 3]) -> OrbitState {
    OrbitState::Vectors {
        position_au: position.map(|component| Finite::new(component).unwrap()),
        velocity_au_per_day: velocity.map(|component| Finite::new(component).unwrap()),
    }
}

/// Initial state given in AU and AU/day.
pub(crate) fn given(position: [f64; 3], velocity: [f64; 3]) -> OrbitStart {
    OrbitStart::Given(vectors(position, velocity))
}

/// A body given by G m in AU^3/day^2, AU and AU/day.
pub(crate) fn body(gm: f64, position: [f64; 3], velocity: [f64; 3]) -> OrbitBody {
    OrbitBody { gm_au3_per_day2: NonNegative::new(gm).unwrap(), state: vectors(position, velocity) }
}

/// Returns the run in its initial state.
pub(crate) fn prepare(config: &OrbitConfig) -> Orbit {
    Orbit::prepare(config, Seed { seed: 14, replicate: 0 }, false).unwrap()
}

/// Returns the run in its final state.
pub(crate) fn finished(config: &OrbitConfig) -> Orbit {
    let mut orbit = prepare(config);
    let Extent::Steps { total, .. } = orbit.extent() else { panic!("an orbit run has steps") };
    advance(&mut orbit, total);
    orbit
}

/// Advances the run to a step.
pub(crate) fn advance(orbit: &mut Orbit, count: u64) {
    assert_eq!(orbit.advance(Target::Count(count), u64::MAX), Ok(Progress::Reached));
}

/// Recorded data of one frame.
pub(crate) struct Observation {
    /// Position and velocity.
    pub(crate) state: State,
    /// The channel `/energy`.
    pub(crate) energy: OrbitEnergy,
    /// The channel `/orbit`.
    pub(crate) orbit: OrbitElements,
}

/// Reads the run through a frame, as the recorder does.
pub(crate) fn observe(orbit: &Orbit) -> Observation {
    let mut frame = Frame::new();
    orbit.observe(&mut frame);
    let &[x, y, z, vx, vy, vz] = frame.state() else { panic!("one row of six columns") };
    Observation {
        state: State { position: [x, y, z], velocity: [vx, vy, vz] },
        energy: frame.get::<OrbitEnergy>().unwrap(),
        orbit: frame.get::<OrbitElements>().unwrap(),
    }
}

/// Returns |a - b|.
pub(crate) fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    ((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]))
        .sqrt()
}
