//! The rules between the keys of `[model.gas]`: start, speeds, wall, collisions.

use super::gas::{GasConfig, Propagation};
use super::gas_start::{PositionDistribution, SpeedDistribution, SpeedScale};
use super::placement::Placement;
use crate::keys::Reader;

/// Fraction of the container that discs placed at random can cover: random sequential addition jams at 0.547 (Feder, J. Theor. Biol.
/// 87, 237 (1980)), and comes near it ever more slowly.
const MOST_COVERED: f64 = 0.5;

impl GasConfig {
    pub(super) fn check_speeds(&mut self, table: &mut Reader<'_>) {
        if self.speeds_m_per_s.is_empty() {
            if table.has("speeds_m_per_s") {
                table.refuse(
                    &["speeds_m_per_s"],
                    "`speeds_m_per_s` is empty",
                    "add a speed or remove the key",
                );
            }
            return;
        }
        if table.has("max_speed_m_per_s") {
            let title = "`speeds_m_per_s` and `max_speed_m_per_s` cannot be used together";
            table.refuse(&["speeds_m_per_s", "max_speed_m_per_s"], title, "keep one of them");
        }
        if let Placement::Given(_) = self.placement {
            let title = "`speeds_m_per_s` cannot be used with a given start";
            table.refuse(&["placement", "speeds_m_per_s"], title, "remove `speeds_m_per_s`");
        }
        if !table.has("temperature_k") {
            self.speed_scale = SpeedScale::Given;
        }
    }

    pub(super) fn check_start(&mut self, table: &mut Reader<'_>) {
        if self.speed_distribution == SpeedDistribution::Maxwell
            && let SpeedScale::MaxSpeed(_) = self.speed_scale
        {
            table.refuse(
                &["speed_distribution", "max_speed_m_per_s"],
                "`max_speed_m_per_s` cannot be used with Maxwell's distribution, which is unbounded",
                "use `temperature_k` instead",
            );
        }
        self.particles = match &self.placement {
            Placement::Random | Placement::Lattice => return,
            Placement::Given(state) => state.count(table, "particles", self.particles),
            Placement::Recorded(start) => start.count(table, "particles", self.particles),
        };
        if table.has("max_speed_m_per_s") {
            table.refuse(
                &["placement", "start_from", "max_speed_m_per_s"],
                "`max_speed_m_per_s` cannot be used with a given start",
                "remove `max_speed_m_per_s`; `temperature_k` rescales a given start",
            );
        }
        if !table.has("temperature_k") {
            self.speed_scale = SpeedScale::Given;
        }
    }

    pub(super) fn check_wall(&self, table: &mut Reader<'_>) {
        let exact = self.propagation == Propagation::Exact;
        for key in ["wall_speed_m_per_s", "wall_temperature_k", "orifice_width_m"] {
            if table.has(key) && !exact {
                let title = format!("`{key}` needs exact propagation");
                table.refuse(&["propagation", key], &title, "set propagation to \"exact\"");
            }
        }
        if table.has("temperature_schedule")
            && matches!(self.propagation, Propagation::AsPrinted { .. })
        {
            let title = "`temperature_schedule` cannot be used with as-printed propagation";
            table.refuse(
                &["propagation", "temperature_schedule"],
                title,
                "set propagation to \"exact\" or \"time-stepped\"",
            );
        }
        if table.has("accommodation_coefficient") && !table.has("wall_temperature_k") {
            table.refuse(
                &["accommodation_coefficient"],
                "`accommodation_coefficient` needs `wall_temperature_k`",
                "add `wall_temperature_k`",
            );
        }
        let rising = self.temperature_schedule.windows(2).all(|pair| pair[0][0] < pair[1][0]);
        if !rising {
            table.refuse(
                &["temperature_schedule"],
                "the times of `temperature_schedule` are not in rising order",
                "order the pairs [time, temperature] by time",
            );
        }
        let radius_at_end =
            self.radius_m.get() + self.wall_speed_m_per_s.get() * self.duration_s.get();
        if radius_at_end <= 0.0 {
            table.refuse(
                &["wall_speed_m_per_s", "duration_s"],
                "the wall reaches the center before the run ends",
                "shorten the duration or slow the wall",
            );
        }
        let perimeter = std::f64::consts::TAU * self.radius_m.get();
        if self.orifice_width_m.is_some_and(|width| width.get() > perimeter) {
            table.refuse(
                &["orifice_width_m", "radius_m"],
                "`orifice_width_m` is longer than the wall",
                "must be at most 2 pi radius_m",
            );
        }
    }

    pub(super) fn check_collisions(&self, table: &mut Reader<'_>) {
        let Some(disc_radius) = self.disc_radius_m.map(|radius| radius.get()) else { return };
        let beside = [
            ("propagation", self.propagation == Propagation::Exact, "set propagation to \"exact\""),
            ("wall_speed_m_per_s", self.wall_speed_m_per_s.get() == 0.0, "remove the wall's speed"),
            ("wall_temperature_k", self.thermal_wall.is_none(), "remove the wall's temperature"),
            ("orifice_width_m", self.orifice_width_m.is_none(), "remove the opening"),
            (
                "position_distribution",
                self.position_distribution == PositionDistribution::UniformInArea,
                "set position_distribution to \"uniform-in-area\"",
            ),
        ];
        for (key, is_plain, label) in beside {
            if !is_plain {
                let title = format!("`disc_radius_m` cannot be used with this `{key}`");
                table.refuse(&["disc_radius_m", key], &title, label);
            }
        }
        let radius = self.radius_m.get();
        let share = f64::from(self.particles.get()) * disc_radius * disc_radius / (radius * radius);
        if disc_radius >= radius || share > MOST_COVERED {
            let title = format!("the discs would cover {share:.3} of the container");
            let label = format!(
                "must be at most {MOST_COVERED}: fewer or smaller discs, or a larger container"
            );
            table.refuse(&["disc_radius_m", "particles", "radius_m"], &title, &label);
        }
    }
}
