//! The rules between the keys of `[model.gas]`: start, speeds, wall, collisions.

use super::start::{GasPlacement, PositionDistribution, SpeedDistribution, SpeedScale};
use super::{GasConfig, Propagation};
use crate::keys::{Reader, rules};
use crate::model::sizes::{LARGEST, SMALLEST, length, nearest_size, rounded_down};
use crate::tree::Value;
use crate::value::number;

/// Maximum fraction of the container that discs placed at random can cover. Random sequential addition jams at 0.547
/// (Feder, J. Theor. Biol. 87, 237 (1980)) and becomes ever slower near it.
const MOST_COVERED: f64 = 0.5;

/// Maximum distance of the center from the origin in radii: beyond it, absolute positions have fewer than seven digits.
const MAX_CENTER_DISTANCE_IN_RADII: f64 = 1e9;

/// Bounds of the thermal speed sqrt(2 k_B T/m), m/s: that of the fastest particle is up to nine times as large.
const THERMAL_SPEEDS: [f64; 2] = [10.0 * SMALLEST, 0.1 * LARGEST];

/// Boltzmann constant, J/K: a bound needs no more digits.
pub(super) const BOLTZMANN_J_PER_K: f64 = 1.380_649e-23;

impl GasConfig {
    /// Reports all sizes at which products overflow or positions lose their digits.
    pub(super) fn check_sizes(&self, table: &mut Reader<'_>) {
        let (mass, radius) = (self.mass_kg.get(), self.radius_m.get());
        let speeds = self.speeds_m_per_s.iter().map(|speed| ("speeds_m_per_s", speed.get()));
        let max_speed = match self.speed_scale {
            SpeedScale::MaxSpeed(speed) => speed.get(),
            _ => 0.0,
        };
        let sizes = [
            ("mass_kg", mass),
            ("radius_m", radius),
            ("duration_s", self.duration_s.get()),
            ("gravity_m_per_s2", self.gravity_m_per_s2.get()),
            ("max_speed_m_per_s", max_speed),
        ];
        for (key, size) in sizes.into_iter().chain(speeds) {
            let nearest = nearest_size(size);
            rules! { table;
                size != 0.0 && size != nearest => [key]
                    "`{key}` is {size:e}, at which products overflow", "must be in [{SMALLEST:e}, {LARGEST:e}]; the nearest value is {nearest:e}";
            }
        }
        if let SpeedScale::Temperature(temperature) = self.speed_scale {
            let thermal = (2.0 * BOLTZMANN_J_PER_K * temperature.get() / mass).sqrt();
            let [least, most] = THERMAL_SPEEDS;
            let bound = if thermal < least { least } else { most };
            let nearest = mass * bound * bound / (2.0 * BOLTZMANN_J_PER_K);
            rules! { table;
                thermal > 0.0 && !(least..=most).contains(&thermal) && mass == nearest_size(mass) => ["temperature_k"]
                    "the speeds of `temperature_k` are {thermal:e} m/s, at which products overflow", "the nearest value is {nearest:e}";
            }
        }
        let distance = length(self.center_m);
        let limit = MAX_CENTER_DISTANCE_IN_RADII * radius;
        let [x, y] = self.center_m.map(|axis| axis.get() / distance * limit);
        rules! { table;
            distance > limit => at "center_m" of ["center_m", "radius_m"]
                "`center_m` is {distance:e} m from the origin, so far that positions lose their digits",
                "must be within {MAX_CENTER_DISTANCE_IN_RADII:e} radii; the nearest value is [{x:e}, {y:e}]";
        }
    }

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
        let growth = self.wall_speed_m_per_s.get() * self.duration_s.get();
        let perimeter = std::f64::consts::TAU * self.radius_m.get();
        rules! { table;
            is_as_printed && table.has("temperature_schedule") => ["propagation", "temperature_schedule"]
                "`temperature_schedule` cannot be used with as-printed propagation",
                "set propagation to \"exact\" or \"time-stepped\"";
            table.has("accommodation_coefficient") && !table.has("wall_temperature_k") => ["accommodation_coefficient"]
                "`accommodation_coefficient` needs `wall_temperature_k`", "add `wall_temperature_k`";
            self.radius_m.get() + growth <= 0.0 => ["wall_speed_m_per_s", "duration_s"]
                "the wall reaches the center before the run ends", "shorten the duration or slow the wall";
            self.orifice_width_m.is_some_and(|width| width.get() > perimeter) => ["orifice_width_m", "radius_m"]
                "`orifice_width_m` is longer than the wall", "must be at most 2 pi radius_m";
        }
    }

    /// Reports each time of the schedule that is not after all before it, or is after the end of the run. From the text, so that no
    /// error in another pair hides it.
    pub(super) fn check_schedule(&self, table: &mut Reader<'_>) {
        let node = table.node("temperature_schedule");
        let Some(Value::Array(pairs)) = node.map(|node| &node.value) else { return };
        let duration = self.duration_s.get();
        let mut latest: Option<f64> = None;
        for (index, pair) in pairs.iter().enumerate() {
            let Value::Array(pair_numbers) = &pair.value else { continue };
            let time = pair_numbers.first().and_then(number).filter(|time| time.is_finite());
            let Some(time) = time else { continue };
            let name = format!("`temperature_schedule[{index}]`");
            if let Some(before) = latest.filter(|before| time <= *before) {
                let title = format!(
                    "{name} is at {time:?} s, not after the {before:?} s of a pair before it"
                );
                let label = "order the pairs [time, temperature] by time";
                table.refuse_in(pair.span, &[], title, label);
            }
            if latest.is_none_or(|before| time > before) {
                latest = Some(time);
            }
            if time > duration {
                let title = format!(
                    "{name} sets a temperature at {time:?} s, but the run ends at {duration:?} s"
                );
                let label = format!(
                    "the time must be at most {duration:?}; or increase `duration_s` to {time:?}"
                );
                table.refuse_in(pair.span, &["duration_s"], title, label);
            }
        }
    }

    /// Rejects keys that cannot be used with this one: steps, a moving wall, and more, each with its remedy.
    pub(super) fn exclude_steps_and_more(
        &self,
        own: &str,
        more: &[(&str, bool, &str)],
        table: &mut Reader<'_>,
    ) {
        let is_stepped = self.propagation != Propagation::Exact;
        let all = [
            ("propagation", is_stepped, "set propagation to \"exact\""),
            ("wall_speed_m_per_s", self.wall_speed_m_per_s.get() != 0.0, "remove one of them"),
        ];
        for (key, is_used, label) in all.iter().chain(more) {
            rules! { table;
                *is_used => [own, key] "`{own}` cannot be used with this `{key}`", "{label}";
            }
        }
    }

    pub(super) fn check_collisions(&self, table: &mut Reader<'_>) {
        let Some(disc_radius) = self.disc_radius_m.map(|radius| radius.get()) else { return };
        let is_uniform = self.position_distribution == PositionDistribution::UniformInArea;
        let label = "set position_distribution to \"uniform-in-area\"";
        let more = [
            ("wall_temperature_k", self.thermal_wall.is_some(), "remove one of them"),
            ("orifice_width_m", self.orifice_width_m.is_some(), "remove one of them"),
            ("position_distribution", !is_uniform, label),
        ];
        self.exclude_steps_and_more("disc_radius_m", &more, table);
        let radius = self.radius_m.get();
        let covered =
            f64::from(self.particles.get()) * disc_radius * disc_radius / (radius * radius);
        let most = (MOST_COVERED / f64::from(self.particles.get())).sqrt();
        let smaller = rounded_down(radius * most);
        rules! { table;
            disc_radius >= radius || covered > MOST_COVERED => at "disc_radius_m" of ["disc_radius_m", "particles", "radius_m"]
                "the discs would cover {covered:.3} of the container",
                "they can cover at most {MOST_COVERED} of it: `disc_radius_m` at most {smaller:?}, fewer discs, or a larger container";
        }
    }
}
