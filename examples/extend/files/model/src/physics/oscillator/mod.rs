//! A body on a spring, by semi-implicit Euler.

mod motion;

use crate::model::{Extent, Model, ModelKind, Progress, SetupError, SimulationFault, Target};
use crate::random::Seed;
use kinetoscope_manifest::model::OscillatorConfig;
use kinetoscope_recording::channels::{ChannelDeclaration, OscillatorEnergy};
use kinetoscope_recording::frame::{Frame, StateColumn};
use kinetoscope_recording::scenery::{DrawnRadius, Scenery};
use motion::State;
use serde::{Deserialize, Serialize};

/// One run at one time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Oscillator {
    angular_frequency: f64,
    amplitude: f64,
    step: f64,
    total_steps: u64,
    count: u64,
    state: State,
}

const KIND: ModelKind = ModelKind {
    name: "oscillator",
    physics_version: 1,
    time_unit: "s",
    state_columns: &[
        StateColumn { name: "x", unit: "m" },
        StateColumn { name: "y", unit: "m" },
        StateColumn { name: "vx", unit: "m/s" },
        StateColumn { name: "vy", unit: "m/s" },
    ],
    channels: &[ChannelDeclaration::of::<OscillatorEnergy>()],
};

impl Model for Oscillator {
    type Config = OscillatorConfig;

    fn kind() -> &'static ModelKind {
        &KIND
    }

    fn prepare(config: &OscillatorConfig, _: Seed, _: bool) -> Result<Self, SetupError> {
        let amplitude = config.amplitude_m.get();
        let step = config.time_step_s.get();
        Ok(Self {
            angular_frequency: config.angular_frequency_rad_per_s.get(),
            amplitude,
            step,
            total_steps: whole_steps(config.duration_s.get(), step),
            count: 0,
            state: State { position: amplitude, velocity: 0.0 },
        })
    }

    fn is_valid_for(&self, config: &OscillatorConfig) -> bool {
        let Ok(start) = Self::prepare(config, Seed { seed: 0, replicate: 0 }, false) else {
            return false;
        };
        let State { position, velocity } = self.state;
        Self { count: 0, state: start.state, ..self.clone() } == start
            && self.count <= self.total_steps
            && position.is_finite()
            && velocity.is_finite()
    }

    fn channels(&self) -> &'static [ChannelDeclaration] {
        KIND.channels
    }

    fn extent(&self) -> Extent {
        Extent::Steps { total: self.total_steps, step: self.step }
    }

    fn advance(&mut self, target: Target, at_most: u64) -> Result<Progress, SimulationFault> {
        let goal = match target {
            Target::Count(count) => count,
            Target::Time(time) => whole_steps(time, self.step),
        };
        for _ in 0..goal.saturating_sub(self.count).min(at_most) {
            self.state = motion::step(self.state, self.angular_frequency, self.step);
            self.count += 1;
        }
        if !self.state.position.is_finite() {
            return Err(SimulationFault::new("the position is not finite", "reduce time_step_s"));
        }
        Ok(if self.count >= goal { Progress::Reached } else { Progress::Working })
    }

    fn count(&self) -> u64 {
        self.count
    }

    fn time(&self) -> f64 {
        self.count as f64 * self.step
    }

    fn observe(&self, frame: &mut Frame) {
        frame.push_state(&[self.state.position, 0.0, self.state.velocity, 0.0]);
        let specific_energy_j_per_kg = motion::specific_energy(self.state, self.angular_frequency);
        frame.push(&OscillatorEnergy { specific_energy_j_per_kg });
    }

    fn scenery(&self) -> Scenery {
        let half = 1.2 * self.amplitude;
        Scenery {
            walls: Vec::new(),
            view: [[-half, -half], [half, half]],
            drawn_radius: DrawnRadius::Fixed(0.05 * self.amplitude),
            speed_range_top: self.amplitude * self.angular_frequency,
            speed_unit: "m/s",
            arrows: true,
            force_range_top: None,
            trail: false,
            unused_fields: Vec::new(),
            names: Vec::new(),
            central_particle: None,
        }
    }
}

/// Number of whole steps in a time; a step that is short only by rounding counts.
fn whole_steps(time: f64, step: f64) -> u64 {
    (time / step + 1e-9) as u64
}
