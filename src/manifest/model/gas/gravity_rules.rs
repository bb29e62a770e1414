//! `[model.gas]`: rules for uniform gravity and for a partition.

use super::GasConfig;
use super::partition::PartitionSide;
use super::rules::BOLTZMANN_J_PER_K;
use super::start::{
    GasPlacement, PositionDistribution, SpeedDistribution, SpeedScale, TemperatureDefinition,
};
use crate::keys::{Reader, rules};

/// Distance of the partition from the center over the radius, up to which a gas can be drawn behind it.
const MAX_PARTITION_OFFSET: f64 = 0.999;

/// Maximum ratio of the weight on the container's radius, m g R, to `k_B T`. Above it, all particles lie within the rounding of the
/// bottom.
const MAX_WEIGHT_OVER_THERMAL: f64 = 1e6;

impl GasConfig {
    /// Whether gravity or a partition acts on the particles.
    #[must_use]
    pub fn has_gravity_or_partition(&self) -> bool {
        self.gravity_m_per_s2.get() > 0.0 || self.partition.is_some()
    }

    /// Species of a particle: the index of its mass among `mass_kg` and `additional_masses_kg`.
    #[must_use]
    pub fn species_of(&self, particle: usize) -> usize {
        particle % (1 + self.additional_masses_kg.len())
    }

    /// A partition before a drawn start separates all particles from nothing, unless the manifest names something else.
    pub(super) fn complete_partition(&mut self) {
        if self.placement == GasPlacement::Random
            && let Some(partition) = &mut self.partition
        {
            partition.side.get_or_insert(PartitionSide::Left);
        }
    }

    /// Rejects keys that cannot be used with gravity or a partition.
    pub(super) fn check_gravity_and_partition(&self, table: &mut Reader<'_>) {
        let has_gravity = self.gravity_m_per_s2.get() > 0.0;
        let more = [
            ("disc_radius_m", self.disc_radius_m.is_some(), "remove one of them"),
            ("temperature_schedule", !self.temperature_schedule.is_empty(), "remove one of them"),
        ];
        for (own, is_used) in
            [("gravity_m_per_s2", has_gravity), ("partition_x_m", self.partition.is_some())]
        {
            if is_used {
                self.exclude_steps_and_more(own, &more, table);
            }
        }
        self.check_partition(table);
        self.check_barometric(table);
    }

    fn check_partition(&self, table: &mut Reader<'_>) {
        for key in ["partition_opens_s", "partition_side"] {
            rules! { table;
                table.has(key) && !table.has("partition_x_m") => [key]
                    "`{key}` needs `partition_x_m`", "add `partition_x_m`";
            }
        }
        let Some(partition) = self.partition else { return };
        let (x, center, radius) =
            (partition.x_m.get(), self.center_m[0].get(), self.radius_m.get());
        let reach = MAX_PARTITION_OFFSET * radius;
        let nearest = center + if x < center { -reach } else { reach };
        let rounding = f64::EPSILON * (center.abs() + radius);
        let duration = self.duration_s.get();
        let half = duration / 2.0;
        let opens = partition.opens_s.map_or(0.0, |time| time.get());
        let is_drawn = self.placement == GasPlacement::Random;
        let is_uniform = self.position_distribution == PositionDistribution::UniformInArea;
        let is_by_mass = partition.side == Some(PartitionSide::ByMass);
        rules! { table;
            (x - center).abs() > reach + rounding => at "partition_x_m" of ["partition_x_m", "radius_m", "center_m"]
                "`partition_x_m` is {x:?}, outside the container or almost", "the nearest value that works is {nearest:?}";
            opens >= duration => at "partition_opens_s" of ["partition_opens_s", "duration_s"]
                "the partition would be removed at {opens:?} s, but the run ends at {duration:?} s",
                "must be below {duration:?}, such as {half:?}; remove `partition_opens_s` for a partition that stays";
            is_by_mass && self.additional_masses_kg.is_empty() => ["partition_side"]
                "partition_side \"by-mass\" needs `additional_masses_kg`", "add a mass, which may equal `mass_kg`";
            !is_drawn && table.has("partition_side") => ["placement", "start_from", "partition_side"]
                "`partition_side` cannot be used with a given start", "remove `partition_side`";
            is_drawn && !is_uniform => at "position_distribution" of ["partition_x_m", "position_distribution"]
                "`partition_x_m` cannot be used with this `position_distribution`",
                "set position_distribution to \"uniform-in-area\"";
        }
    }

    fn check_barometric(&self, table: &mut Reader<'_>) {
        if self.position_distribution != PositionDistribution::Barometric {
            return;
        }
        let gravity = self.gravity_m_per_s2.get();
        let temperature = match self.speed_scale {
            SpeedScale::Temperature(temperature) => Some(temperature.get()),
            _ => None,
        };
        let is_maxwell = self.speed_distribution == SpeedDistribution::Maxwell
            && self.speeds_m_per_s.is_empty()
            && self.temperature_definition == TemperatureDefinition::MeanSquare;
        let masses = std::iter::once(self.mass_kg).chain(self.additional_masses_kg.iter().copied());
        let heaviest =
            masses.fold(0.0, |most, mass| if mass.get() > most { mass.get() } else { most });
        let thermal = BOLTZMANN_J_PER_K * temperature.unwrap_or(0.0);
        let largest = MAX_WEIGHT_OVER_THERMAL * thermal / (heaviest * self.radius_m.get());
        // The scale height is the radius.
        let typical = thermal / (heaviest * self.radius_m.get());
        let typical = if typical > 0.0 { typical } else { 9.81 };
        rules! { table;
            temperature.is_none() => ["position_distribution", "max_speed_m_per_s", "speeds_m_per_s"]
                "a barometric start needs a temperature", "use `temperature_k`, such as 300, in place of the other key";
            temperature == Some(0.0) => ["position_distribution", "temperature_k"]
                "without motion, all particles of a barometric start lie at the bottom", "must be above 0, such as 300; or set position_distribution to \"uniform-in-area\"";
            gravity == 0.0 => ["position_distribution"]
                "a barometric start needs gravity", "add `gravity_m_per_s2`, such as {typical:e}, or set position_distribution to \"uniform-in-area\"";
            temperature.is_some() && !is_maxwell => ["position_distribution", "speed_distribution", "speeds_m_per_s", "temperature_definition"]
                "a barometric start needs Maxwell's speeds at a temperature defined by the mean square",
                "set speed_distribution to \"maxwell\" and temperature_definition to \"mean-square\"";
            self.placement != GasPlacement::Random => ["position_distribution", "placement", "start_from"]
                "a barometric start cannot be used with a given start", "remove `position_distribution`";
            thermal > 0.0 && gravity > largest => at "gravity_m_per_s2" of ["gravity_m_per_s2", "temperature_k", "radius_m"]
                "gravity leaves no particle above the bottom: m g R exceeds k_B T {MAX_WEIGHT_OVER_THERMAL:e} times",
                "the nearest value that works is {largest:e}; or increase `temperature_k`";
        }
    }
}
