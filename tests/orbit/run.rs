//! One orbit run as the tests of the orbit's laws need it: prepare, move, look.

// Each test file takes what it needs; a start that can't be built fails its test.
#![allow(clippy::unwrap_used)]

use kinetoscope_manifest::model::{OrbitConfig, OrbitIntegrator, OrbitStart};
use kinetoscope_manifest::quantity::{Finite, Positive};
use kinetoscope_physics::model::{Extent, Model, Progress, Target};
use kinetoscope_physics::orbit::Orbit;
use kinetoscope_physics::orbit::motion::State;
use kinetoscope_physics::random::Seed;
use kinetoscope_recording::channels::{OrbitElements, OrbitEnergy};
use kinetoscope_recording::frame::Frame;

/// A year of the orbit exercise's checks, days.
pub(crate) const JULIAN_YEAR: f64 = 365.25;

/// The orbit exercise's start with this method, step and duration (days).
pub(crate) fn document(integrator: OrbitIntegrator, step: f64, duration: f64) -> OrbitConfig {
    OrbitConfig {
        integrator,
        time_step_days: Positive::new(step).unwrap(),
        duration_days: Positive::new(duration).unwrap(),
        ..Default::default()
    }
}

/// A start written out, AU and AU/day.
pub(crate) fn given(position: [f64; 3], velocity: [f64; 3]) -> OrbitStart {
    OrbitStart::Given {
        position_au: position.map(|component| Finite::new(component).unwrap()),
        velocity_au_per_day: velocity.map(|component| Finite::new(component).unwrap()),
    }
}

/// The run at its start.
pub(crate) fn prepare(config: &OrbitConfig) -> Orbit {
    Orbit::prepare(config, Seed { seed: 14, replicate: 0 }, false).unwrap()
}

/// The run at its end.
pub(crate) fn finished(config: &OrbitConfig) -> Orbit {
    let mut orbit = prepare(config);
    let Extent::Steps { total, .. } = orbit.extent() else { panic!("an orbit has fixed steps") };
    advance(&mut orbit, total);
    orbit
}

/// Moves the run to a step.
pub(crate) fn advance(orbit: &mut Orbit, count: u64) {
    assert_eq!(orbit.advance(Target::Count(count), u64::MAX), Ok(Progress::Reached));
}

/// What the recording would hold of this instant.
pub(crate) struct Seen {
    /// Position and velocity.
    pub(crate) state: State,
    /// The channel `/energy`.
    pub(crate) energy: OrbitEnergy,
    /// The channel `/orbit`.
    pub(crate) orbit: OrbitElements,
}

/// Looks at the run through a frame, as the recorder does.
pub(crate) fn look(orbit: &Orbit) -> Seen {
    let mut frame = Frame::new();
    orbit.observe(&mut frame);
    let &[x, y, z, vx, vy, vz] = frame.state() else { panic!("one row of six columns") };
    Seen {
        state: State { position: [x, y, z], velocity: [vx, vy, vz] },
        energy: frame.get::<OrbitEnergy>().unwrap(),
        orbit: frame.get::<OrbitElements>().unwrap(),
    }
}

/// |a - b|.
pub(crate) fn apart(a: [f64; 3], b: [f64; 3]) -> f64 {
    ((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]))
        .sqrt()
}
