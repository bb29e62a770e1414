//! `[model.orbit]`: the Earth around the Sun, in AU and days.

use super::contract::{Model, at_least_one_step};
use super::start_from::{StartFrom, may_be_recorded};
use crate::diagnostics::Diagnostic;
use crate::inline::{self, inline_table};
use crate::keys::Reader;
use crate::quantity::{Finite, NonNegative, Positive, StepTolerance};
use crate::table::table;
use crate::tree::Node;
use crate::value::{TomlValue, quoted, word, words};
use serde_json::{Value as Json, json};

table! {
    /// All physics of an orbit run. The Sun is fixed at the origin, unless several bodies attract each other. By default,
    /// the Earth relative to the Sun on 2013-01-01, a quarter of a day per step, one Julian year.
    pub struct OrbitConfig {
        /// State at the start, 2013-01-01: heliocentric is relative to the Sun, barycentric relative to the solar system's barycenter
        /// as printed in the orbit exercise; or { position_au, velocity_au_per_day }.
        start: OrbitStart [start OrbitStart, unless bodies] = OrbitStart::Heliocentric,
        /// In place of start: two bodies or more that attract each other, each
        /// { gm_au3_per_day2, position_au, velocity_au_per_day }. Their center of mass is put at rest in the origin.
        bodies: Option<Vec<OrbitBody>> ["", optional],
        /// How the equation of motion is discretized; dop853 chooses its own steps, kepler is the exact solution.
        integrator: OrbitIntegrator [""] = OrbitIntegrator::VelocityVerlet,
        /// Whether each addition to positions and velocities is rounded (plain), or what it rounds off is kept and added
        /// with the next one (compensated).
        summation: OrbitSummation [""] = OrbitSummation::Plain,
        /// Largest error of a step of dop853, of position and velocity relative to their lengths.
        tolerance: StepTolerance ["1"] = StepTolerance::literal(1e-13),
        /// Time step. For dop853, the first step to try.
        time_step_days: Positive ["d"] = Positive::literal(0.25),
        /// Simulated time.
        duration_days: Positive ["d"] = Positive::literal(365.25),
    }
}

/// State at the start.
#[derive(Clone, Debug, PartialEq)]
pub enum OrbitStart {
    /// The orbit exercise's: relative to the solar system's barycenter, 2013-01-01.
    Barycentric,
    /// The same day relative to the Sun.
    Heliocentric,
    /// Written out; the position is not zero.
    Given {
        /// Position, AU.
        position_au: [Finite; 3],
        /// Velocity, AU/day.
        velocity_au_per_day: [Finite; 3],
    },
    /// The last state of a recording.
    Recorded(StartFrom),
}

may_be_recorded!(OrbitStart);

words! {
    /// Time-stepping scheme of the orbit.
    #[derive(PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
    pub enum OrbitIntegrator {
        /// The orbit exercise's equations (15) and (16).
        ExplicitEuler = "explicit-euler",
        /// Kick, then drift.
        SemiImplicitEuler = "semi-implicit-euler",
        /// Half kick, drift, half kick.
        VelocityVerlet = "velocity-verlet",
        /// The classical fourth-order Runge–Kutta method.
        Rk4 = "rk4",
        /// Yoshida's fourth-order symplectic composition.
        Yoshida4 = "yoshida4",
        /// Dormand and Prince's method of order 8 with adaptive steps.
        Dop853 = "dop853",
        /// The exact solution of the two-body problem.
        Kepler = "kepler",
    }
}

words! {
    /// How sums of positions and velocities are rounded.
    #[derive(PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
    pub enum OrbitSummation {
        /// At every addition, as the orbit exercise's equations read.
        Plain = "plain",
        /// What an addition rounds off is added with the next one.
        Compensated = "compensated",
    }
}

inline_table! {
    /// One of several bodies that attract each other.
    pub struct OrbitBody = "a table { gm_au3_per_day2, position_au, velocity_au_per_day }" {
        /// Gravitational constant times mass, AU^3/day^2; zero for a body that attracts no other.
        gm_au3_per_day2: NonNegative [required],
        /// Position, AU.
        position_au: [Finite; 3] [required],
        /// Velocity, AU/day.
        velocity_au_per_day: [Finite; 3] [required],
    }
}

inline_table! {
    /// The keys of [`OrbitStart::Given`].
    struct OrbitState = "a table { position_au, velocity_au_per_day }" with OrbitState::rules {
        position_au: [Finite; 3] [required],
        velocity_au_per_day: [Finite; 3] [required],
    }
}

impl OrbitState {
    fn rules(&self, name: &str, reader: &mut Reader<'_>) {
        if self.position_au.iter().all(|x| x.get() == 0.0) {
            let title = format!("`{name}` is at the position of the Sun");
            reader.refuse(&["position_au"], &title, "must not be [0, 0, 0]");
        }
    }
}

impl OrbitStart {
    const WORDS: [(&'static str, Self); 2] =
        [("barycentric", Self::Barycentric), ("heliocentric", Self::Heliocentric)];
}

impl TomlValue for OrbitStart {
    fn read(node: &Node, name: &str, errors: &mut Vec<Diagnostic>) -> Option<Self> {
        if node.table().is_none() {
            let or = " or { position_au = ..., velocity_au_per_day = ... }";
            return word(node, name, &Self::WORDS, or, errors);
        }
        let OrbitState { position_au, velocity_au_per_day } = inline::read(node, name, errors)?;
        Some(Self::Given { position_au, velocity_au_per_day })
    }

    fn write(&self) -> String {
        match self {
            &Self::Given { position_au, velocity_au_per_day } => {
                OrbitState { position_au, velocity_au_per_day }.write()
            }
            Self::Recorded(start) => start.write(),
            start => {
                let word = Self::WORDS.iter().find(|(_, value)| value == start);
                word.map_or_else(String::new, |(word, _)| quoted(word))
            }
        }
    }

    fn schema() -> Json {
        let words = Self::WORDS.map(|(word, _)| word);
        json!({ "anyOf": [{ "enum": words }, OrbitState::schema()] })
    }
}

impl Model for OrbitConfig {
    const CHANNELS: &'static [&'static str] = &[
        "state",
        "discs",
        "walls",
        "legend",
        "velocity",
        "trail",
        "energy",
        "orbit",
        "conserved",
        "log",
    ];

    const TIME_KEY: &'static str = "every_days";

    fn intervals(&self, _sound: bool) -> &'static [&'static str] {
        &["every_days", "every_steps"]
    }

    fn check(&mut self, table: &mut Reader<'_>) {
        let steps = self.duration_days.get() / self.time_step_days.get();
        at_least_one_step(steps, table, &["time_step_days", "duration_days"]);
        if let OrbitStart::Recorded(start) = &self.start
            && start.particles().is_some_and(|bodies| bodies > 1)
        {
            table.refuse(
                &["start_from"],
                "the recording has several bodies",
                "list them as `bodies`: their masses are not in its frames",
            );
        }
        let Some(bodies) = &self.bodies else { return };
        if self.integrator == OrbitIntegrator::Kepler {
            table.refuse(
                &["bodies", "integrator"],
                "`integrator = \"kepler\"` cannot be used with several bodies",
                "\"kepler\" moves one body about the Sun",
            );
        }
        if bodies.len() < 2 || bodies.iter().all(|body| body.gm_au3_per_day2.get() == 0.0) {
            let title = "no body of `model.orbit.bodies` attracts another";
            table.refuse(&["bodies"], title, "needs at least two bodies, one of them with mass");
        }
    }
}
