//! `[model.dem]`: discs with spring–dashpot contacts in a box.

use super::Placement;
use crate::diagnostics::Diagnostic;
use crate::keys::{Keys, Reader};
use crate::quantity::{Finite, NonNegative, Positive, Share};
use crate::tree::{Node, Value};
use crate::value::{TomlValue, number, refuse, words};
use serde_json::{Value as Json, json};
use std::num::NonZeroU32;

/// All physics of a DEM run. The box is `[0, width] x [0, height]`.
#[derive(Clone, Debug, PartialEq)]
pub struct DemConfig {
    /// Number of discs.
    pub discs: NonZeroU32,
    /// Mass of a disc of the mean radius, kg; the areal density is the same for all discs.
    pub mass_kg: Positive,
    /// Radius of the discs, m.
    pub radius_m: DiscRadius,
    /// Width of the box, m.
    pub width_m: Positive,
    /// Height of the box, m.
    pub height_m: Positive,
    /// Acceleration of gravity, m/s^2.
    pub gravity_m_per_s2: [Finite; 2],
    /// Stiffness k of the contact spring, N/m.
    pub stiffness_n_per_m: Positive,
    /// The dashpot, by what is wanted or by what it is.
    pub dissipation: Dissipation,
    /// What the force does where the dashpot would pull.
    pub force_tail: ForceTail,
    /// How the equation of motion is discretised.
    pub integrator: DemIntegrator,
    /// The time step, by contacts or in seconds.
    pub time_step: TimeStep,
    /// What an unstable time step leads to.
    pub stability: Stability,
    /// How discs are placed at the start.
    pub placement: Placement,
    /// Simulated time, s.
    pub duration_s: Positive,
}

/// The discs' radius, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DiscRadius {
    /// All equal.
    Equal(Positive),
    /// Uniform between two bounds, `min <= max`.
    Uniform {
        /// Smallest radius, m.
        min: Positive,
        /// Largest radius, m.
        max: Positive,
    },
}

/// The dashpot of a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Dissipation {
    /// Coefficient of restitution e; the damping follows for each pair from its effective mass.
    Restitution(Share),
    /// Damping eta itself, N s/m, the same for every contact.
    Damping(NonNegative),
}

/// What the contact force does at the end of a contact, where the dashpot outweighs the spring.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ForceTail {
    /// It pulls until the discs part.
    Attractive,
    /// It is zero: a contact only pushes.
    Clamped,
}

/// Time-stepping scheme of the DEM.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DemIntegrator {
    /// The source document's equation (3).
    SemiImplicitEuler,
    /// Half kick, drift, half kick.
    VelocityVerlet,
    /// The dashpot solved implicitly, contact by contact: stable at any damping, exact for isolated pairs only.
    ImplicitDashpot,
}

/// The time step of the DEM.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TimeStep {
    /// The source document's N_t: dt = pi sqrt(m/k) / N_t, m the smallest disc's mass (equation 2).
    PerContact(Positive),
    /// In seconds.
    Fixed(Positive),
}

/// What a time step beyond the stability bounds leads to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stability {
    /// The run is refused before its first step.
    Refuse,
    /// The run goes on, with a warning in its log.
    Warn,
}

impl Default for DemConfig {
    /// The document's values where they can be integrated: e = 0.5 in place of eta = 1.5e3, the listing's radius.
    fn default() -> Self {
        Self {
            discs: const { NonZeroU32::new(20).expect("not zero") },
            mass_kg: const { Positive::literal(1e-3) },
            radius_m: DiscRadius::Equal(const { Positive::literal(5e-4) }),
            width_m: const { Positive::literal(0.04) },
            height_m: const { Positive::literal(0.04) },
            gravity_m_per_s2: const { [Finite::literal(0.0), Finite::literal(-9.81)] },
            stiffness_n_per_m: const { Positive::literal(5e4) },
            dissipation: Dissipation::Restitution(const { Share::literal(0.5) }),
            force_tail: ForceTail::Attractive,
            integrator: DemIntegrator::SemiImplicitEuler,
            time_step: TimeStep::PerContact(const { Positive::literal(20.0) }),
            stability: Stability::Refuse,
            placement: Placement::Random,
            duration_s: const { Positive::literal(1.0) },
        }
    }
}

words!(pub ForceTail { Attractive = "attractive", Clamped = "clamped" });
words!(pub DemIntegrator {
    SemiImplicitEuler = "semi-implicit-euler",
    VelocityVerlet = "velocity-verlet",
    ImplicitDashpot = "implicit-dashpot",
});
words!(pub Stability { Refuse = "refuse", Warn = "warn" });

impl DemConfig {
    /// The keys of `[model.dem]`, in the order of the canonical manifest.
    pub(crate) fn keys(&mut self, keys: &mut impl Keys) {
        keys.key(
            "discs",
            "1",
            "Number of discs; with a given placement it follows from that.",
            &mut self.discs,
        );
        keys.key(
            "mass_kg",
            "kg",
            "Mass of a disc of the mean radius; the areal density is the same for all discs.",
            &mut self.mass_kg,
        );
        keys.key(
            "radius_m",
            "m",
            "Radius of the discs, or { min, max }: uniform between the two.",
            &mut self.radius_m,
        );
        keys.key("width_m", "m", "Width of the box [0, width] x [0, height].", &mut self.width_m);
        keys.key("height_m", "m", "Height of the box.", &mut self.height_m);
        keys.key(
            "gravity_m_per_s2",
            "m/s^2",
            "Acceleration of gravity, [x, y].",
            &mut self.gravity_m_per_s2,
        );
        keys.key(
            "stiffness_n_per_m",
            "N/m",
            "Stiffness k of the contact spring.",
            &mut self.stiffness_n_per_m,
        );
        self.dissipation_keys(keys);
        keys.key("force_tail", "", "What the force does where the dashpot would pull: attractive lets it, clamped makes it zero.", &mut self.force_tail);
        keys.key(
            "integrator",
            "",
            "How the equation of motion is discretised.",
            &mut self.integrator,
        );
        self.time_step_keys(keys);
        keys.key(
            "stability",
            "",
            "What an unstable time step leads to: the run is refused, or goes on with a warning.",
            &mut self.stability,
        );
        keys.key(
            "placement",
            "",
            "How discs are placed at the start; given velocities count, all others are at rest.",
            &mut self.placement,
        );
        keys.key("duration_s", "s", "Simulated time.", &mut self.duration_s);
    }

    fn dissipation_keys(&mut self, keys: &mut impl Keys) {
        let (restitution, damping) = match self.dissipation {
            Dissipation::Restitution(restitution) => (Some(restitution), None),
            Dissipation::Damping(damping) => (None, Some(damping)),
        };
        keys.exclusive(&["restitution", "damping_n_s_per_m"]);
        if let Some(restitution) = keys.optional("restitution", "1", "Coefficient of restitution e wanted; the damping follows for each pair from its effective mass.", restitution) {
            self.dissipation = Dissipation::Restitution(restitution);
        }
        if let Some(damping) = keys.optional(
            "damping_n_s_per_m",
            "N s/m",
            "Damping eta itself, the same for every contact, in place of `restitution`.",
            damping,
        ) {
            self.dissipation = Dissipation::Damping(damping);
        }
    }

    fn time_step_keys(&mut self, keys: &mut impl Keys) {
        let (per_contact, fixed) = match self.time_step {
            TimeStep::PerContact(steps) => (Some(steps), None),
            TimeStep::Fixed(step) => (None, Some(step)),
        };
        keys.exclusive(&["steps_per_contact", "time_step_s"]);
        if let Some(steps) = keys.optional(
            "steps_per_contact",
            "1",
            "N_t of dt = pi sqrt(m/k) / N_t, m the smallest disc's mass.",
            per_contact,
        ) {
            self.time_step = TimeStep::PerContact(steps);
        }
        if let Some(step) =
            keys.optional("time_step_s", "s", "Time step, in place of `steps_per_contact`.", fixed)
        {
            self.time_step = TimeStep::Fixed(step);
        }
    }

    /// The rules between the keys.
    pub(crate) fn check(&mut self, table: &mut Reader<'_>) {
        if let Placement::Given(state) = &self.placement {
            self.discs = state.count(table, "discs", self.discs);
        }
        let radius = match self.radius_m {
            DiscRadius::Equal(radius) | DiscRadius::Uniform { max: radius, .. } => radius.get(),
        };
        let (width, height) = (self.width_m.get(), self.height_m.get());
        if 2.0 * radius >= width || 2.0 * radius >= height {
            let title = format!(
                "a disc of radius {radius:?} m does not fit into a box of {width:?} m x {height:?} m"
            );
            table.refuse(
                &["radius_m", "width_m", "height_m"],
                &title,
                "the radius must be below half of the shorter side",
            );
        }
        let steps = match self.time_step {
            TimeStep::Fixed(step) => self.duration_s.get() / step.get(),
            TimeStep::PerContact(_) => f64::INFINITY,
        };
        super::at_least_one_step(steps, table, &["time_step_s", "duration_s"]);
    }
}

impl TomlValue for DiscRadius {
    fn read(node: &Node, name: &str, errors: &mut Vec<Diagnostic>) -> Option<Self> {
        let Value::Table(table) = &node.value else {
            if number(node).is_none() {
                refuse(node, name, "a number > 0 or { min = ..., max = ... }", errors);
                return None;
            }
            return Positive::read(node, name, errors).map(Self::Equal);
        };
        let mut reader = Reader::new(name, table, errors);
        let min: Option<Positive> = reader.required("min", node.span);
        let max: Option<Positive> = reader.required("max", node.span);
        let bounds = min.zip(max);
        let ordered = bounds.filter(|(min, max)| min <= max);
        if bounds.is_some() && ordered.is_none() {
            let title = format!("`{name}` has its smallest radius above its largest");
            reader.refuse(&["min", "max"], &title, "min must be <= max");
        }
        reader.finish();
        ordered.map(|(min, max)| Self::Uniform { min, max })
    }

    fn write(&self) -> String {
        match self {
            Self::Equal(radius) => radius.write(),
            Self::Uniform { min, max } => {
                format!("{{ min = {}, max = {} }}", min.write(), max.write())
            }
        }
    }

    fn schema() -> Json {
        let bounds = json!({ "min": Positive::schema(), "max": Positive::schema() });
        json!({ "anyOf": [Positive::schema(), {
            "type": "object", "properties": bounds, "required": ["min", "max"], "additionalProperties": false
        }] })
    }
}
