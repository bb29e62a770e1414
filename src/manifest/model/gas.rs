//! `[model.gas]`: point particles in a circular container.

use super::gas_walls::ThermalWall;
use super::start_from::MayBeRecorded;
use super::{Placement, StartFrom};
use crate::diagnostics::Diagnostic;
use crate::keys::{Keys, Reader};
use crate::quantity::{Finite, NonNegative, Positive};
use crate::tree::Node;
use crate::value::{TomlValue, words};
use serde_json::Value as Json;
use std::num::NonZeroU32;

/// All physics of a gas run.
#[derive(Clone, Debug, PartialEq)]
pub struct GasConfig {
    /// Number of particles N.
    pub particles: NonZeroU32,
    /// Mass m of a particle, kg.
    pub mass_kg: Positive,
    /// Radius r of the container, m.
    pub radius_m: Positive,
    /// Center c of the container, m.
    pub center_m: [Finite; 2],
    /// The law that speeds are drawn from, unless they are listed.
    pub speed_distribution: SpeedDistribution,
    /// The scale of the speeds.
    pub speed_scale: SpeedScale,
    /// Which mean the temperature is defined by.
    pub temperature_definition: TemperatureDefinition,
    /// Boltzmann's constant in use.
    pub boltzmann_constant: BoltzmannConstant,
    /// How particles are moved.
    pub propagation: Propagation,
    /// How particles are placed at the start; never [`Placement::Lattice`].
    pub placement: Placement,
    /// Further masses, kg: particle i has the (i mod n)-th of `mass_kg` and these.
    pub further_masses_kg: Vec<Positive>,
    /// The law of the places at the start.
    pub place_distribution: PlaceDistribution,
    /// Times, s, rising, and the temperatures, K, that are set at them by rescaling all velocities.
    pub temperature_schedule: Vec<[NonNegative; 2]>,
    /// Speed of the wall outwards, m/s: a circular piston.
    pub wall_speed_m_per_s: Finite,
    /// A wall that gives particles back with its own temperature.
    pub thermal_wall: Option<ThermalWall>,
    /// Arc of an opening in the wall about the direction of x, m, at the start.
    pub opening_width_m: Option<Positive>,
    /// Radius of particles that are discs and collide, m; `None` for points.
    pub disc_radius_m: Option<Positive>,
    /// Speeds that are given to the particles in turn, m/s; where there are any, no law of speeds counts.
    pub speeds_m_per_s: Vec<NonNegative>,
    /// Simulated time, s.
    pub duration_s: Positive,
}

/// The law of the places at the start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlaceDistribution {
    /// Uniform over the area: stationary.
    Area,
    /// Distance from the center uniform in [0, r]: too many in the middle, and not stationary.
    Radius,
}

/// The law of the speeds at the start; directions are uniform.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpeedDistribution {
    /// Uniform in `[0, v_max)`, as the source document asks.
    Uniform,
    /// Maxwell's in two dimensions.
    Maxwell,
    /// All equal.
    Equal,
}

/// What fixes the scale of the speeds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SpeedScale {
    /// The start is rescaled to exactly this temperature, K.
    Temperature(NonNegative),
    /// Upper bound of uniform speeds, m/s; nothing is rescaled. For `equal` the speed itself; not for `maxwell`.
    MaxSpeed(NonNegative),
    /// The start is written out with its velocities, or its speeds are; nothing is rescaled.
    Given,
}

/// Which mean of the speeds the temperature is defined by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum TemperatureDefinition {
    /// N k_B T = N m <v>^2 / 2: the source document's equation (13).
    MeanSpeed,
    /// N k_B T = N m <v^2> / 2: equipartition in two dimensions.
    MeanSquare,
}

/// Boltzmann's constant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BoltzmannConstant {
    /// 1.380658e-23 J/K (CODATA 1986), the source document's.
    Codata1986,
    /// 1.380649e-23 J/K, exact in the SI since 2019.
    Si2019,
}

/// How particles are moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Propagation {
    /// Closed form: exact at any time.
    Exact,
    /// The source document's steps with its defects mended.
    Stepped {
        /// Time step, s.
        time_step_s: Positive,
    },
    /// The source document's steps as printed, losses included.
    Literal {
        /// Time step, s.
        time_step_s: Positive,
    },
}

impl Default for GasConfig {
    /// A thousand of the document's particles at 300 K by its own definition of temperature.
    fn default() -> Self {
        Self {
            particles: const { NonZeroU32::new(1000).expect("not zero") },
            mass_kg: const { Positive::literal(1e-26) },
            radius_m: const { Positive::literal(1.0) },
            center_m: const { [Finite::literal(0.0), Finite::literal(0.0)] },
            speed_distribution: SpeedDistribution::Uniform,
            speed_scale: SpeedScale::Temperature(const { NonNegative::literal(300.0) }),
            temperature_definition: TemperatureDefinition::MeanSpeed,
            boltzmann_constant: BoltzmannConstant::Codata1986,
            propagation: Propagation::Exact,
            placement: Placement::Random,
            further_masses_kg: Vec::new(),
            place_distribution: PlaceDistribution::Area,
            temperature_schedule: Vec::new(),
            wall_speed_m_per_s: const { Finite::literal(0.0) },
            thermal_wall: None,
            opening_width_m: None,
            disc_radius_m: None,
            speeds_m_per_s: Vec::new(),
            duration_s: const { Positive::literal(0.1) },
        }
    }
}

words!(pub PlaceDistribution { Area = "area", Radius = "radius" });
words!(pub SpeedDistribution { Uniform = "uniform", Maxwell = "maxwell", Equal = "equal" });
words!(pub TemperatureDefinition { MeanSpeed = "mean-speed", MeanSquare = "mean-square" });
words!(pub BoltzmannConstant { Codata1986 = "codata-1986", Si2019 = "si-2019" });

/// The words for [`Propagation`], whose time step is a key of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Scheme {
    Exact,
    Stepped,
    Literal,
}
words!(Scheme { Exact = "exact", Stepped = "stepped", Literal = "literal" });

impl Propagation {
    fn scheme(self) -> Scheme {
        match self {
            Self::Exact => Scheme::Exact,
            Self::Stepped { .. } => Scheme::Stepped,
            Self::Literal { .. } => Scheme::Literal,
        }
    }

    /// The time step, s, of the stepped ways of moving.
    #[must_use]
    pub fn time_step_s(self) -> Option<Positive> {
        match self {
            Self::Exact => None,
            Self::Stepped { time_step_s } | Self::Literal { time_step_s } => Some(time_step_s),
        }
    }
}

/// A placement as the gas has it: points need no lattice.
struct GasPlacement(Placement);

impl From<StartFrom> for GasPlacement {
    fn from(start: StartFrom) -> Self {
        Self(start.into())
    }
}

impl MayBeRecorded for GasPlacement {
    fn recorded(&self) -> Option<&StartFrom> {
        self.0.recorded()
    }

    fn recorded_mut(&mut self) -> Option<&mut StartFrom> {
        self.0.recorded_mut()
    }
}

impl TomlValue for GasPlacement {
    fn read(node: &Node, name: &str, errors: &mut Vec<Diagnostic>) -> Option<Self> {
        let words = [("random", Placement::Random)];
        super::read_placement(node, name, &words, Placement::Given, super::GIVEN_SI, errors)
            .map(Self)
    }

    fn write(&self) -> String {
        self.0.write()
    }

    fn schema() -> Json {
        super::placement_schema(&["random"], super::GIVEN_SI)
    }
}

impl GasConfig {
    /// The keys of `[model.gas]`, in the order of the canonical manifest.
    pub(crate) fn keys(&mut self, keys: &mut impl Keys) {
        keys.key(
            "particles",
            "1",
            "Number of particles N; with a given placement it follows from that.",
            &mut self.particles,
        );
        keys.key("mass_kg", "kg", "Mass m of a particle.", &mut self.mass_kg);
        keys.key("radius_m", "m", "Radius r of the container.", &mut self.radius_m);
        keys.key("center_m", "m", "Center c of the container, [x, y].", &mut self.center_m);
        keys.key(
            "speed_distribution",
            "",
            "The law that speeds are drawn from; directions are uniform.",
            &mut self.speed_distribution,
        );
        self.speed_scale_keys(keys);
        keys.key(
            "temperature_definition",
            "",
            "The mean that the temperature is defined by: mean-speed is N k T = N m <v>^2 / \
            2, mean-square is N k T = N m <v^2> / 2.",
            &mut self.temperature_definition,
        );
        keys.key(
            "boltzmann_constant",
            "",
            "codata-1986 is 1.380658e-23 J/K, si-2019 is 1.380649e-23 J/K.",
            &mut self.boltzmann_constant,
        );
        self.propagation_keys(keys);
        let mut placement = GasPlacement(self.placement.clone());
        super::start_keys(
            "placement",
            "How particles are placed at the start. A given or recorded start keeps its velocities \
            unless `temperature_k` stands beside it.",
            &["placement", "start_from"],
            &mut placement,
            keys,
        );
        self.placement = placement.0;
        self.beyond_keys(keys);
        keys.key("duration_s", "s", "Simulated time.", &mut self.duration_s);
    }

    fn speed_scale_keys(&mut self, keys: &mut impl Keys) {
        let (temperature, max_speed) = match self.speed_scale {
            SpeedScale::Temperature(temperature) => (Some(temperature), None),
            SpeedScale::MaxSpeed(max_speed) => (None, Some(max_speed)),
            SpeedScale::Given => (None, None),
        };
        keys.exclusive(&["temperature_k", "max_speed_m_per_s"]);
        if let Some(temperature) = keys.optional(
            "temperature_k",
            "K",
            "All velocities are rescaled at the start to exactly this temperature.",
            temperature,
        ) {
            self.speed_scale = SpeedScale::Temperature(temperature);
        }
        if let Some(max_speed) = keys.optional(
            "max_speed_m_per_s",
            "m/s",
            "Upper bound of uniform speeds, or the speed itself for equal ones, in place of \
            `temperature_k`; nothing is rescaled.",
            max_speed,
        ) {
            self.speed_scale = SpeedScale::MaxSpeed(max_speed);
        }
    }

    /// Keys that are absent from the canonical manifest unless they say something.
    fn beyond_keys(&mut self, keys: &mut impl Keys) {
        let masses = (!self.further_masses_kg.is_empty()).then(|| self.further_masses_kg.clone());
        self.further_masses_kg = keys
            .optional(
                "further_masses_kg",
                "kg",
                "Further masses: `mass_kg` and these are given to the particles in turn.",
                masses,
            )
            .unwrap_or_default();
        let places =
            (self.place_distribution != PlaceDistribution::Area).then_some(self.place_distribution);
        self.place_distribution = keys
            .optional(
                "place_distribution",
                "",
                "area: uniform over the area (default). radius: distance from the center uniform, which is not stationary.",
                places,
            )
            .unwrap_or(PlaceDistribution::Area);
        let schedule =
            (!self.temperature_schedule.is_empty()).then(|| self.temperature_schedule.clone());
        self.temperature_schedule = keys
            .optional(
                "temperature_schedule",
                "s, K",
                "Pairs [time, temperature] in rising order: at each time all velocities are rescaled to \
                the temperature.",
                schedule,
            )
            .unwrap_or_default();
        self.wall_keys(keys);
        self.collision_keys(keys);
        let speeds = (!self.speeds_m_per_s.is_empty()).then(|| self.speeds_m_per_s.clone());
        self.speeds_m_per_s = keys
            .optional(
                "speeds_m_per_s",
                "m/s",
                "Speeds that are given to the particles in turn, in place of `speed_distribution`; directions are uniform. They are kept unless \
                `temperature_k` stands beside them.",
                speeds,
            )
            .unwrap_or_default();
    }

    /// Whether nothing but the mirror acts on the particles, so that each keeps its speed.
    #[must_use]
    pub fn keeps_speeds(&self) -> bool {
        self.keeps_energy() && self.disc_radius_m.is_none()
    }

    /// Whether the particles keep their energy, each of them or all together.
    #[must_use]
    pub fn keeps_energy(&self) -> bool {
        self.thermal_wall.is_none()
            && self.wall_speed_m_per_s.get() == 0.0
            && self.temperature_schedule.is_empty()
    }

    fn propagation_keys(&mut self, keys: &mut impl Keys) {
        let mut scheme = self.propagation.scheme();
        keys.key(
            "propagation",
            "",
            "How particles are moved: exact is the closed form, stepped the source \
            document's steps mended, literal the same as printed.",
            &mut scheme,
        );
        let step = keys.optional(
            "time_step_s",
            "s",
            "Time step of `stepped` and `literal`.",
            self.propagation.time_step_s(),
        );
        self.propagation = match (scheme, step) {
            (Scheme::Stepped, Some(time_step_s)) => Propagation::Stepped { time_step_s },
            (Scheme::Literal, Some(time_step_s)) => Propagation::Literal { time_step_s },
            // A scheme without its time step is refused by `check`, which sees the key.
            (Scheme::Exact, _) | (_, None) => Propagation::Exact,
        };
    }

    /// The rules between the keys.
    pub(crate) fn check(&mut self, table: &mut Reader<'_>) {
        self.check_start(table);
        self.check_speeds(table);
        self.check_wall(table);
        self.check_collisions(table);
        let scheme = table.text("propagation").unwrap_or("exact");
        match (scheme, table.has("time_step_s")) {
            ("exact", true) => table.refuse(
                &["propagation", "time_step_s"],
                "exact propagation takes no time step",
                "remove it, or set propagation to \"stepped\" or \"literal\"",
            ),
            ("stepped" | "literal", false) => {
                let title = format!("propagation \"{scheme}\" needs a time step");
                table.refuse(&["propagation"], &title, "add `time_step_s`");
            }
            _ => {}
        }
        let steps = match self.propagation.time_step_s() {
            Some(step) => self.duration_s.get() / step.get(),
            None => f64::INFINITY,
        };
        super::at_least_one_step(steps, table, &["time_step_s", "duration_s"]);
    }

    fn check_speeds(&mut self, table: &mut Reader<'_>) {
        if self.speeds_m_per_s.is_empty() {
            if table.has("speeds_m_per_s") {
                table.refuse(
                    &["speeds_m_per_s"],
                    "there is no speed in the list",
                    "write one, or remove the key",
                );
            }
            return;
        }
        if table.has("max_speed_m_per_s") {
            let title = "written speeds leave nothing to `max_speed_m_per_s`";
            table.refuse(&["speeds_m_per_s", "max_speed_m_per_s"], title, "keep one of them");
        }
        if let Placement::Given(_) = self.placement {
            let title = "a given start has its own speeds";
            table.refuse(&["placement", "speeds_m_per_s"], title, "remove `speeds_m_per_s`");
        }
        if !table.has("temperature_k") {
            self.speed_scale = SpeedScale::Given;
        }
    }

    fn check_start(&mut self, table: &mut Reader<'_>) {
        if self.speed_distribution == SpeedDistribution::Maxwell
            && let SpeedScale::MaxSpeed(_) = self.speed_scale
        {
            table.refuse(
                &["speed_distribution", "max_speed_m_per_s"],
                "Maxwell's speeds have no upper bound",
                "give `temperature_k` in place of `max_speed_m_per_s`",
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
                "a given start has its own speeds",
                "remove `max_speed_m_per_s`; `temperature_k` rescales a given start",
            );
        }
        if !table.has("temperature_k") {
            self.speed_scale = SpeedScale::Given;
        }
    }
}
