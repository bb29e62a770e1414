//! `[model.gas]`: point particles in a circular container.

mod gravity_rules;
mod partition;
mod rules;
mod start;
mod walls;

pub use partition::{Partition, PartitionSide};
pub use start::{
    BoltzmannConstant, GasPlacement, PositionDistribution, SpeedDistribution, SpeedScale,
    TemperatureDefinition,
};
pub use walls::ThermalWall;

use crate::keys::{HasKeys, Keys, Reader};
use crate::model::contract::{Model, check_steps};
use crate::quantity::{Finite, NonNegative, Positive};
use crate::table::table;
use crate::value::{count, words};
use std::num::NonZeroU32;

table! {
    /// All physics of a gas run. By default, a thousand particles with Maxwell's speeds at 300 K.
    pub struct GasConfig {
        /// Number of particles N; with a given placement it follows from that.
        particles: NonZeroU32 ["1"] = count(1000),
        /// Mass m of a particle.
        mass_kg: Positive ["kg"] = Positive::literal(1e-26),
        /// Radius r of the container.
        radius_m: Positive ["m"] = Positive::literal(1.0),
        /// Center c of the container, [x, y].
        center_m: [Finite; 2] ["m"] = [Finite::literal(0.0); 2],
        /// The distribution that speeds are drawn from, unless they are listed; directions are uniform.
        speed_distribution: SpeedDistribution [""] = SpeedDistribution::Maxwell,
        /// The scale of the speeds.
        speed_scale: SpeedScale [group] = SpeedScale::Temperature(NonNegative::literal(300.0)),
        /// The mean that the temperature is defined by: mean-square is `N k T = N m <v^2> / 2` (equipartition), mean-speed is
        /// `N k T = N m <v>^2 / 2`, the gas exercise's.
        temperature_definition: TemperatureDefinition [""] = TemperatureDefinition::MeanSquare,
        /// si-2019 is 1.380649e-23 J/K, exact in the SI; codata-1986 is 1.380658e-23 J/K, the gas exercise's.
        boltzmann_constant: BoltzmannConstant [""] = BoltzmannConstant::Si2019,
        /// How particles are moved.
        propagation: Propagation [group] = Propagation::Exact,
        /// How particles are placed at the start, never on a lattice. A given or recorded start keeps its velocities unless
        /// `temperature_k` is given as well.
        placement: GasPlacement [start] = GasPlacement::Random,
        /// Additional masses: particle i has the (i mod n)-th of `mass_kg` and these.
        additional_masses_kg: Vec<Positive> ["kg", sparse] = Vec::new(),
        /// uniform-in-area: stationary (default). uniform-in-radius: the distance from the center is uniform, which is not stationary.
        /// barometric: equilibrium at `temperature_k` in gravity.
        position_distribution: PositionDistribution ["", sparse] = PositionDistribution::UniformInArea,
        /// Pairs [time, temperature] in rising order: at each time all velocities are rescaled to the temperature.
        temperature_schedule: Vec<[NonNegative; 2]> ["s, K", sparse] = Vec::new(),
        /// Speed at which the radius grows (above 0) or shrinks (below): a piston. Needs exact propagation.
        wall_speed_m_per_s: Finite ["m/s", sparse] = Finite::literal(0.0),
        /// A wall that re-emits particles with its own temperature.
        thermal_wall: Option<ThermalWall> [group],
        /// Arc of an opening in the wall about the direction of x, at the start; what leaves does not return. Needs exact
        /// propagation.
        orifice_width_m: Option<Positive> ["m", optional],
        /// Radius of particles that are discs and collide elastically with one another; points, which do not, where it is
        /// left out. Needs exact propagation and a plain wall.
        disc_radius_m: Option<Positive> ["m", optional],
        /// Speeds that are given to the particles in turn, in place of `speed_distribution`; directions are uniform. They
        /// are kept unless `temperature_k` is given as well.
        speeds_m_per_s: Vec<NonNegative> ["m/s", sparse] = Vec::new(),
        /// Uniform gravity toward -y. Needs exact propagation, points and a wall at rest.
        gravity_m_per_s2: NonNegative ["m/s^2", sparse] = NonNegative::literal(0.0),
        /// A partition that is removed.
        partition: Option<Partition> [group],
        /// Simulated time.
        duration_s: Positive ["s"] = Positive::literal(0.1),
    }
}

/// How particles are moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Propagation {
    /// Closed form: exact at any time.
    Exact,
    /// The gas exercise's steps with its defects corrected.
    TimeStepped {
        /// Time step, s.
        time_step_s: Positive,
    },
    /// The gas exercise's steps as printed, losses included.
    AsPrinted {
        /// Time step, s.
        time_step_s: Positive,
    },
}

words! {
    /// The words for [`Propagation`], whose time step is a key of its own.
    enum Scheme {
        Exact = "exact",
        TimeStepped = "time-stepped",
        AsPrinted = "as-printed",
    }
}

table! {
    /// The keys of [`Propagation`].
    struct PropagationKeys {
        /// How particles are moved: exact is the closed form, time-stepped the gas exercise's steps corrected, as-printed the
        /// same steps as printed.
        propagation: Scheme [""] = Scheme::Exact,
        /// Time step of `time-stepped` and `as-printed`.
        time_step_s: Option<Positive> ["s", optional],
    }
}

impl HasKeys for Propagation {
    fn keys(&mut self, keys: &mut impl Keys) {
        let propagation = match self {
            Self::Exact => Scheme::Exact,
            Self::TimeStepped { .. } => Scheme::TimeStepped,
            Self::AsPrinted { .. } => Scheme::AsPrinted,
        };
        let mut own = PropagationKeys { propagation, time_step_s: self.time_step_s() };
        own.keys(keys);
        *self = match (own.propagation, own.time_step_s) {
            (Scheme::TimeStepped, Some(time_step_s)) => Self::TimeStepped { time_step_s },
            (Scheme::AsPrinted, Some(time_step_s)) => Self::AsPrinted { time_step_s },
            // `check`, which sees the keys, reports a scheme without its time step.
            (Scheme::Exact, _) | (_, None) => Self::Exact,
        };
    }
}

impl Propagation {
    /// The time step, s; `None` for exact propagation.
    #[must_use]
    pub fn time_step_s(self) -> Option<Positive> {
        match self {
            Self::Exact => None,
            Self::TimeStepped { time_step_s } | Self::AsPrinted { time_step_s } => {
                Some(time_step_s)
            }
        }
    }
}

impl GasConfig {
    /// Whether only specular reflections act on the particles, so that each keeps its speed.
    #[must_use]
    pub fn keeps_speeds(&self) -> bool {
        self.keeps_energy() && self.disc_radius_m.is_none()
    }

    /// Whether the particles keep their kinetic energy, each of them or all together.
    #[must_use]
    pub fn keeps_energy(&self) -> bool {
        self.thermal_wall.is_none()
            && self.wall_speed_m_per_s.get() == 0.0
            && self.temperature_schedule.is_empty()
            && self.gravity_m_per_s2.get() == 0.0
    }

    fn check_time_step(&self, table: &mut Reader<'_>) {
        let exact = Scheme::Exact.word();
        let scheme = table.text("propagation").unwrap_or(exact);
        let is_stepped =
            [Scheme::TimeStepped, Scheme::AsPrinted].map(Scheme::word).contains(&scheme);
        let has_step = table.has("time_step_s");
        if scheme == exact && has_step {
            table.refuse(
                &["propagation", "time_step_s"],
                "`time_step_s` cannot be used with exact propagation",
                "remove it, or set propagation to \"time-stepped\" or \"as-printed\"",
            );
        } else if is_stepped && !has_step {
            let title = format!("propagation \"{scheme}\" needs a time step");
            table.refuse(&["propagation"], &title, "add `time_step_s`");
        }
        let step = self.propagation.time_step_s();
        check_steps(self.duration_s, step, table, &["time_step_s", "duration_s"]);
    }
}

impl Model for GasConfig {
    fn intervals(&self, sound: bool) -> &'static [&'static str] {
        match self.propagation {
            Propagation::Exact if sound => &["every_s"],
            _ => &["every_s", "every_steps"],
        }
    }

    fn duration(&self) -> Option<f64> {
        Some(self.duration_s.get())
    }

    fn species(&self) -> usize {
        1 + self.additional_masses_kg.len()
    }

    fn particles(&self) -> u64 {
        u64::from(self.particles.get())
    }

    fn draws_random_numbers(&self) -> bool {
        self.placement == GasPlacement::Random || self.thermal_wall.is_some()
    }

    fn with_particles(&self, particles: NonZeroU32) -> Option<Self> {
        let is_drawn = self.placement == GasPlacement::Random
            && self.speeds_m_per_s.is_empty()
            && self.disc_radius_m.is_none()
            && self.partition.is_none();
        is_drawn.then(|| Self { particles, ..self.clone() })
    }

    fn check(&mut self, table: &mut Reader<'_>) {
        self.check_sizes(table);
        self.check_start(table);
        self.check_speeds(table);
        self.check_wall(table);
        self.check_schedule(table);
        self.check_collisions(table);
        self.complete_partition();
        self.check_gravity_and_partition(table);
        self.check_time_step(table);
    }
}
