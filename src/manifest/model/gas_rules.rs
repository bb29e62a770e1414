//! The rules between the keys of `[model.gas]`: start, speeds, wall, collisions.

use super::gas::{GasConfig, Propagation};
use super::gas_start::{GasPlacement, PositionDistribution, SpeedDistribution, SpeedScale};
use crate::keys::{Reader, rules};

/// Maximum fraction of the container that discs placed at random can cover. Random sequential addition jams at 0.547
/// (Feder, J. Theor. Biol. 87, 237 (1980)) and becomes ever slower near it.
const MOST_COVERED: f64 = 0.5;

impl GasConfig {
    pub(super) fn check_speeds(&mut self, table: &mut Reader<'_>) {
        let has_speeds = !self.speeds_m_per_s.is_empty();
        rules! { table;
            !has_speeds && table.has("speeds_m_per_s") => ["speeds_m_per_s"]
                "`speeds_m_per_s` is empty", "add a speed or remove the key";
            has_speeds && table.has("max_speed_m_per_s") => ["speeds_m_per_s", "max_speed_m_per_s"]
                "`speeds_m_per_s` and `max_speed_m_per_s` cannot be used together", "keep one of them";
            has_speeds && matches!(self.placement, GasPlacement::Given(_)) => ["placement", "speeds_m_per_s"]
                "`speeds_m_per_s` cannot be used with a given start", "remove `speeds_m_per_s`";
        }
        if has_speeds && !table.has("temperature_k") {
            self.speed_scale = SpeedScale::Given;
        }
    }

    pub(super) fn check_start(&mut self, table: &mut Reader<'_>) {
        // A given start, listed speeds and a temperature exclude the maximum speed by rules of their own.
        let is_drawn = self.placement == GasPlacement::Random
            && self.speeds_m_per_s.is_empty()
            && !table.has("temperature_k");
        let is_maxwell = is_drawn && self.speed_distribution == SpeedDistribution::Maxwell;
        rules! { table;
            is_maxwell && matches!(self.speed_scale, SpeedScale::MaxSpeed(_)) => ["speed_distribution", "max_speed_m_per_s"]
                "`max_speed_m_per_s` cannot be used with Maxwell's distribution, which is unbounded",
                "set speed_distribution to \"uniform\" or \"equal\", or use `temperature_k` instead";
        }
        self.particles = self.placement.count(table, "particles", self.particles);
        if self.placement == GasPlacement::Random {
            return;
        }
        rules! { table;
            table.has("max_speed_m_per_s") => ["placement", "start_from", "max_speed_m_per_s"]
                "`max_speed_m_per_s` cannot be used with a given start",
                "remove `max_speed_m_per_s`; `temperature_k` rescales a given start";
        }
        if !table.has("temperature_k") {
            self.speed_scale = SpeedScale::Given;
        }
    }

    pub(super) fn check_wall(&self, table: &mut Reader<'_>) {
        for key in ["wall_speed_m_per_s", "wall_temperature_k", "orifice_width_m"] {
            rules! { table;
                table.has(key) && self.propagation != Propagation::Exact => ["propagation", key]
                    "`{key}` needs exact propagation", "set propagation to \"exact\"";
            }
        }
        let is_as_printed = matches!(self.propagation, Propagation::AsPrinted { .. });
        let rising = self.temperature_schedule.windows(2).all(|pair| pair[0][0] < pair[1][0]);
        let growth = self.wall_speed_m_per_s.get() * self.duration_s.get();
        let perimeter = std::f64::consts::TAU * self.radius_m.get();
        rules! { table;
            is_as_printed && table.has("temperature_schedule") => ["propagation", "temperature_schedule"]
                "`temperature_schedule` cannot be used with as-printed propagation",
                "set propagation to \"exact\" or \"time-stepped\"";
            table.has("accommodation_coefficient") && !table.has("wall_temperature_k") => ["accommodation_coefficient"]
                "`accommodation_coefficient` needs `wall_temperature_k`", "add `wall_temperature_k`";
            !rising => ["temperature_schedule"]
                "the times of `temperature_schedule` are not in rising order",
                "order the pairs [time, temperature] by time";
            self.radius_m.get() + growth <= 0.0 => ["wall_speed_m_per_s", "duration_s"]
                "the wall reaches the center before the run ends", "shorten the duration or slow the wall";
            self.orifice_width_m.is_some_and(|width| width.get() > perimeter) => ["orifice_width_m", "radius_m"]
                "`orifice_width_m` is longer than the wall", "must be at most 2 pi radius_m";
        }
    }

    pub(super) fn check_collisions(&self, table: &mut Reader<'_>) {
        let Some(disc_radius) = self.disc_radius_m.map(|radius| radius.get()) else { return };
        let is_uniform = self.position_distribution == PositionDistribution::UniformInArea;
        let excluded = [
            ("propagation", self.propagation != Propagation::Exact, "set propagation to \"exact\""),
            ("wall_speed_m_per_s", self.wall_speed_m_per_s.get() != 0.0, "remove the wall's speed"),
            ("wall_temperature_k", self.thermal_wall.is_some(), "remove the wall's temperature"),
            ("orifice_width_m", self.orifice_width_m.is_some(), "remove the opening"),
            (
                "position_distribution",
                !is_uniform,
                "set position_distribution to \"uniform-in-area\"",
            ),
        ];
        for (key, is_used, label) in excluded {
            rules! { table;
                is_used => ["disc_radius_m", key] "`disc_radius_m` cannot be used with this `{key}`", "{label}";
            }
        }
        let radius = self.radius_m.get();
        let covered =
            f64::from(self.particles.get()) * disc_radius * disc_radius / (radius * radius);
        rules! { table;
            disc_radius >= radius || covered > MOST_COVERED => ["disc_radius_m", "particles", "radius_m"]
                "the discs would cover {covered:.3} of the container",
                "must be at most {MOST_COVERED}: fewer or smaller discs, or a larger container";
        }
    }
}
