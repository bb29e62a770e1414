//! `[model.dem]`: discs with spring–dashpot contacts in a box.

use super::dem_radius::MOST_RADIUS_RATIO;
use super::{DemContactPair, DemMaterial, DemRain, DemWall, DiscRadius, Placement};
use crate::diagnostics::Diagnostic;
use crate::keys::{Keys, Reader};
use crate::quantity::{Finite, NonNegative, Positive, Share};
use crate::tree::{Node, Value};
use crate::value::{TomlValue, refuse, words};
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
    /// Coefficient of friction mu, between discs and with walls.
    pub friction: NonNegative,
    /// Coefficient of rolling friction mu_r.
    pub rolling_friction: NonNegative,
    /// Stiffness k_t of the tangential and rolling springs over k.
    pub tangential_stiffness_share: Positive,
    /// Damping eta_t of the tangential spring over eta, while the contact sticks.
    pub tangential_damping_share: NonNegative,
    /// What the discs are made of; empty where all are alike.
    pub materials: Vec<DemMaterial>,
    /// Constants of contacts between two materials, or of one with the walls, where they do not follow from the two.
    pub contact_pairs: Vec<DemContactPair>,
    /// Directions in which the box is periodic and has no walls.
    pub periodic: PeriodicSides,
    /// Walls besides the box's own.
    pub walls: Vec<DemWall>,
    /// Discs whose center sinks below this height are removed, m.
    pub outlet_below_m: Option<Finite>,
    /// The part of the box that discs are placed in at the start, lower left and upper right corner, m.
    pub region_m: Option<[[Finite; 2]; 2]>,
    /// Discs that fall in while it runs.
    pub rain: Option<DemRain>,
    /// Standard deviation of each component of the velocities at the start, m/s; `None` for discs at rest.
    pub velocity_deviation_m_per_s: Option<Positive>,
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

/// Directions in which the box is periodic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PeriodicSides {
    /// Four walls.
    None,
    /// Left and right side are one.
    X,
    /// Floor and ceiling are one.
    Y,
    /// No walls.
    Both,
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
    /// Dashpots that take the velocities at the step's end, solved over all contacts together (projected Gauss–Seidel):
    /// stable at any damping, in beds, too.
    ImplicitDashpot,
}

/// The time step of the DEM.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TimeStep {
    /// The source document's N_t: dt = pi sqrt(m/k) / N_t, m the smallest disc's mass (equation 2).
    PerContact(Positive),
    /// In seconds.
    Fixed(Positive),
    /// The longest that the stability bounds allow with room to spare.
    Automatic,
}

/// A time step as it is written.
#[derive(Clone, Copy, Debug, PartialEq)]
enum StepLength {
    Seconds(Positive),
    Automatic,
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
            friction: const { NonNegative::literal(0.0) },
            rolling_friction: const { NonNegative::literal(0.0) },
            tangential_stiffness_share: const { Positive::literal(2.0 / 7.0) },
            tangential_damping_share: const { NonNegative::literal(0.5) },
            materials: Vec::new(),
            contact_pairs: Vec::new(),
            periodic: PeriodicSides::None,
            walls: Vec::new(),
            outlet_below_m: None,
            region_m: None,
            rain: None,
            velocity_deviation_m_per_s: None,
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
words!(pub PeriodicSides { None = "none", X = "x", Y = "y", Both = "both" });
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
            "Radius of the discs; or { min, max }: uniform between the two; or { mean, deviation }: normal, drawn again \
            beyond three deviations; or { small, large, small_share }: two sizes. At most 1 : 10.",
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
        keys.key(
            "force_tail",
            "",
            "What the force does where the dashpot would pull: attractive lets it, clamped \
            makes it zero.",
            &mut self.force_tail,
        );
        self.friction_keys(keys);
        self.material_keys(keys);
        self.scene_keys(keys);
        keys.key(
            "integrator",
            "",
            "How the equation of motion is discretised. implicit-dashpot solves the dashpots over all contacts together \
            (projected Gauss-Seidel) and is stable at any damping, in beds, too; it knows neither friction nor moving walls.",
            &mut self.integrator,
        );
        self.time_step_keys(keys);
        keys.key(
            "stability",
            "",
            "What an unstable time step leads to: the run is refused, or goes on with a warning.",
            &mut self.stability,
        );
        super::start_keys(
            "placement",
            "How discs are placed at the start; given velocities count, all others are at rest.",
            &["placement", "start_from"],
            &mut self.placement,
            keys,
        );
        keys.key("duration_s", "s", "Simulated time.", &mut self.duration_s);
    }

    fn dissipation_keys(&mut self, keys: &mut impl Keys) {
        let (restitution, damping) = match self.dissipation {
            Dissipation::Restitution(restitution) => (Some(restitution), None),
            Dissipation::Damping(damping) => (None, Some(damping)),
        };
        keys.exclusive(&["restitution", "damping_n_s_per_m"]);
        if let Some(restitution) = keys.optional(
            "restitution",
            "1",
            "Coefficient of restitution e wanted; the damping follows for each pair from \
            its effective mass.",
            restitution,
        ) {
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

    fn friction_keys(&mut self, keys: &mut impl Keys) {
        keys.key(
            "friction",
            "1",
            "Coefficient of friction mu: a contact slides where its tangential spring would pull harder than mu times the \
            normal force.",
            &mut self.friction,
        );
        keys.key(
            "rolling_friction",
            "1",
            "Coefficient of rolling friction: a spring and slider against the relative spin, its lever the reduced radius.",
            &mut self.rolling_friction,
        );
        keys.key(
            "tangential_stiffness_share",
            "1",
            "Stiffness of the tangential and rolling springs over that of the normal one.",
            &mut self.tangential_stiffness_share,
        );
        keys.key(
            "tangential_damping_share",
            "1",
            "Damping of the tangential spring over that of the normal one, while the contact sticks.",
            &mut self.tangential_damping_share,
        );
    }

    fn scene_keys(&mut self, keys: &mut impl Keys) {
        keys.key(
            "periodic",
            "",
            "Directions in which the box is periodic and has no walls.",
            &mut self.periodic,
        );
        keys.key(
            "walls",
            "",
            "Walls besides the box's: { from_m, to_m } or { center_m, radius_m, spin_rad_per_s } (a drum, discs inside), \
            each with velocity_m_per_s, amplitude_m, frequency_hz: displacement u t + A sin(2 pi f t), the clock t running \
            within moves_s = [from, to] only, where it is given.",
            &mut self.walls,
        );
        self.outlet_below_m = keys.optional(
            "outlet_below_m",
            "m",
            "Discs whose center sinks below this height are removed.",
            self.outlet_below_m,
        );
        self.region_m = keys.optional(
            "region_m",
            "m",
            "The part of the box that discs are placed in, [[x, y], [x, y]]: lower left and upper right corner.",
            self.region_m,
        );
        self.rain = keys.optional(
            "rain",
            "",
            "Discs that fall in while it runs: { discs, discs_per_s, from_m, to_m, velocity_m_per_s, starts_s }: one after \
            the other, at random on the line between the two points, later where there is no room.",
            self.rain,
        );
        self.velocity_deviation_m_per_s = keys.optional(
            "velocity_deviation_m_per_s",
            "m/s",
            "Standard deviation of each component of normal velocities at the start, with no mean; without it discs that are \
            not given are at rest.",
            self.velocity_deviation_m_per_s,
        );
    }

    fn material_keys(&mut self, keys: &mut impl Keys) {
        let given = Some(std::mem::take(&mut self.materials)).filter(|list| !list.is_empty());
        self.materials = keys
            .optional(
                "materials",
                "",
                "What the discs are made of, drawn by share: { name, share, density_ratio, restitution, friction, \
                rolling_friction }; what is left out is as for all. The stiffness is one for all.",
                given,
            )
            .unwrap_or_default();
        let given = Some(std::mem::take(&mut self.contact_pairs)).filter(|list| !list.is_empty());
        self.contact_pairs = keys
            .optional(
                "contact_pairs",
                "",
                "Constants of contacts between two materials (\"disc\" where none is named), or of one with a \"wall\": \
                { between, restitution, friction, rolling_friction }. Others follow: the smaller friction of the two, and \
                e^2 the mean of both e^2.",
                given,
            )
            .unwrap_or_default();
    }

    fn time_step_keys(&mut self, keys: &mut impl Keys) {
        let (per_contact, fixed) = match self.time_step {
            TimeStep::PerContact(steps) => (Some(steps), None),
            TimeStep::Fixed(step) => (None, Some(StepLength::Seconds(step))),
            TimeStep::Automatic => (None, Some(StepLength::Automatic)),
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
        if let Some(step) = keys.optional(
            "time_step_s",
            "s",
            "Time step, in place of `steps_per_contact`; or automatic: the longest that the stability bounds allow with \
            room to spare.",
            fixed,
        ) {
            self.time_step = match step {
                StepLength::Seconds(step) => TimeStep::Fixed(step),
                StepLength::Automatic => TimeStep::Automatic,
            };
        }
    }

    /// The rules between the keys.
    pub(crate) fn check(&mut self, table: &mut Reader<'_>) {
        match &self.placement {
            Placement::Given(state) => self.discs = state.count(table, "discs", self.discs),
            Placement::Recorded(start) => self.discs = start.count(table, "discs", self.discs),
            Placement::Random | Placement::Lattice => {}
        }
        let (smallest, radius) = self.radius_m.range();
        let (width, height) = (self.width_m.get(), self.height_m.get());
        if 2.0 * radius >= width || 2.0 * radius >= height {
            let title = format!(
                "a disc of radius {radius:?} m does not fit into a box of {width:?} m x \
            {height:?} m"
            );
            table.refuse(
                &["radius_m", "width_m", "height_m"],
                &title,
                "the radius must be below half of the shorter side",
            );
        }
        let steps = match self.time_step {
            TimeStep::Fixed(step) => self.duration_s.get() / step.get(),
            TimeStep::PerContact(_) | TimeStep::Automatic => f64::INFINITY,
        };
        if smallest * MOST_RADIUS_RATIO < radius * (1.0 - 1e-12) {
            table.refuse(
                &["radius_m"],
                &format!("the largest radius is {:.1} times the smallest", radius / smallest),
                "at most 10 times",
            );
        }
        self.check_scene(radius, table);
        super::at_least_one_step(steps, table, &["time_step_s", "duration_s"]);
    }
}

impl TomlValue for StepLength {
    fn read(node: &Node, name: &str, errors: &mut Vec<Diagnostic>) -> Option<Self> {
        match &node.value {
            Value::Text(text) if text == "automatic" => Some(Self::Automatic),
            Value::Text(_) => {
                refuse(node, name, "a number > 0 or \"automatic\"", errors);
                None
            }
            _ => Positive::read(node, name, errors).map(Self::Seconds),
        }
    }

    fn write(&self) -> String {
        match self {
            Self::Seconds(step) => step.write(),
            Self::Automatic => "\"automatic\"".to_owned(),
        }
    }

    fn schema() -> Json {
        json!({ "anyOf": [Positive::schema(), { "enum": ["automatic"] }] })
    }
}
