//! What a run shows of the temperature and the container that its manifest sets.

use super::laws as law;
use super::metrics as metric;
use super::observe::GasRun;
use super::scatter::StartScatter;
use crate::metric::Measurements;
use crate::metric::deviation::ROUNDING_FRACTION;
use crate::statistics::Estimate;
use kinetoscope_manifest::model::{SpeedScale, TemperatureDefinition};

impl GasRun {
    /// Adds the temperature of the first frame and the radius of the container.
    pub(super) fn measure_start(&self, found: &mut Measurements) {
        // A moving wall is where the manifest brings it only if the run has not ended before.
        let duration_s = self.config.duration_s.get();
        let is_set = |time_s: f64| {
            self.config.wall_speed_m_per_s.get() == 0.0
                || (duration_s - time_s).abs() <= ROUNDING_FRACTION * duration_s
        };
        let radius = self.radii.last().map(|&(time_s, radius_m)| match is_set(time_s) {
            true => Estimate::set_by_manifest(radius_m),
            false => Estimate::bare(radius_m),
        });
        found.add(metric::CONTAINER_RADIUS, radius);
        let Some(&(_, by_mean_square, by_mean_speed)) = self.temperatures.first() else { return };
        match self.config.speed_scale {
            SpeedScale::Temperature(given) => {
                let start = match self.config.temperature_definition {
                    TemperatureDefinition::MeanSquare => by_mean_square,
                    TemperatureDefinition::MeanSpeed => by_mean_speed,
                };
                found.compare(
                    metric::TEMPERATURE_START,
                    Estimate::set_by_manifest(start),
                    given.get(),
                );
            }
            // Given velocities, or a list of speeds.
            SpeedScale::Given => {
                found.add(metric::TEMPERATURE_START, Estimate::set_by_manifest(by_mean_square));
            }
            SpeedScale::MaxSpeed(_) => {
                let theory = law::mean_square_of_max_speed_m2_per_s2(&self.config)
                    .map(|square| law::temperature_of_k(&self.config, square));
                let scatter = StartScatter::new(&self.config).map(|start| start.mean_square);
                let error = theory.zip(scatter).map(|(theory, relative)| theory * relative);
                let start = Estimate::new(by_mean_square, error.filter(|error| *error > 0.0));
                found.compare(metric::TEMPERATURE_START, start, theory);
            }
        }
    }
}
