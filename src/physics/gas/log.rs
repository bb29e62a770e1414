//! Log lines of a frame: description of the run at the start, warnings about long steps and lost particles.

use super::Gas;
use super::clock::{Clock, StepClock};
use super::numeric_range::max_speed;
use super::pressure::SpeedMoments;
use super::speed_distribution::InitialSpeeds;
use crate::short_number::short;
use kinetoscope_manifest::model::TemperatureDefinition;
use kinetoscope_recording::frame::{Frame, Level};

/// Maximum distance per step over the radius for which a particle takes many steps across the container.
const MAX_STEP_OVER_RADIUS: f64 = 0.1;

impl Gas {
    /// Describes the run in the log of the first frame.
    pub(super) fn log_start(&self, moments: &SpeedMoments, frame: &mut Frame) {
        let [cx, cy] = self.state.container.center_m;
        let (radius, mass) = (self.state.container.circle.radius, self.state.substance.mass_kg);
        let count = self.state.particles.len();
        frame.log(
            Level::Info,
            format!(
                "N = {count} particles of {mass:e} kg in a circle of radius r = {radius} m with its center at ({cx}, {cy}) m"
            ),
        );
        let positions = if self.scheme.partition_m().is_some() {
            "uniform over one side of the partition"
        } else if self.scheme.gravity_m_per_s2() > 0.0 {
            "by position_distribution"
        } else {
            "uniform over the area"
        };
        frame.log(
            Level::Info,
            match self.initial_speeds {
                InitialSpeeds::Uniform { max_speed } => format!(
                    "start: positions {positions}, directions uniform, speeds uniform in [0, {}) m/s",
                    short(max_speed)
                ),
                InitialSpeeds::Maxwell { .. } => {
                    format!("start: positions {positions}, velocities from the Maxwell distribution")
                }
                InitialSpeeds::Equal => format!(
                    "start: positions {positions}, directions uniform, all speeds {} m/s",
                    short(moments.mean_speed)
                ),
                InitialSpeeds::Given => "start: positions and velocities as given".to_owned(),
            },
        );
        frame.log(Level::Info, self.temperature_description(moments));
        frame.log(Level::Info, self.scheme.description(&self.state));
        self.warn_of_long_steps(frame);
    }

    fn temperature_description(&self, moments: &SpeedMoments) -> String {
        let by = |definition| short(self.temperature_k(moments, definition));
        let by_mean_speed = by(TemperatureDefinition::MeanSpeed);
        let by_mean_square = by(TemperatureDefinition::MeanSquare);
        let expected = match self.initial_speeds {
            InitialSpeeds::Uniform { .. } => " (expected ratio 4/3 for uniform speeds)",
            InitialSpeeds::Maxwell { .. } => " (expected ratio 4/pi for the Maxwell distribution)",
            InitialSpeeds::Equal | InitialSpeeds::Given => "",
        };
        match self.state.substance.definition {
            TemperatureDefinition::MeanSpeed => format!(
                "temperature by the mean-speed definition: {by_mean_speed} K here is {by_mean_square} K by the mean square{expected}"
            ),
            TemperatureDefinition::MeanSquare => format!(
                "temperature by the mean-square definition: {by_mean_square} K here is {by_mean_speed} K by the mean speed"
            ),
        }
    }

    fn warn_of_long_steps(&self, frame: &mut Frame) {
        let Clock::Steps(StepClock { time_step_s, .. }) = self.scheme.clock() else { return };
        let fastest = match self.initial_speeds {
            InitialSpeeds::Uniform { max_speed } => max_speed,
            _ => max_speed(self.start.iter()),
        };
        let radius = self.state.container.circle.radius;
        let step_over_radius = fastest * time_step_s / radius;
        if step_over_radius > MAX_STEP_OVER_RADIUS {
            frame.log(
                Level::Warning,
                format!(
                    "v_max dt / r = {} is above {MAX_STEP_OVER_RADIUS}: a particle takes few steps across the container; \
                     set time_step_s to at most {}",
                    short(step_over_radius),
                    short(MAX_STEP_OVER_RADIUS * radius / fastest)
                ),
            );
        }
    }

    /// Warns if more particles are outside than at the last frame.
    pub(super) fn log_losses(&self, frame: &mut Frame) {
        if !self.scheme.can_end_outside() {
            return;
        }
        let outside = self.particles_outside();
        if outside > self.outside_at_last_frame {
            frame.log(
                Level::Warning,
                format!(
                    "{outside} of {} particles are outside the wall or lost by 0/0, {} more than at the last frame",
                    self.state.particles.len(),
                    outside - self.outside_at_last_frame
                ),
            );
        }
    }
}
