//! `[model.orbit]`: the Earth around the Sun, in AU and days.

use crate::diagnostics::Diagnostic;
use crate::keys::{Keys, Reader};
use crate::quantity::{Finite, Positive, StepBelowOneDay};
use crate::tree::{Node, Value};
use crate::value::{TomlValue, word, words};
use serde_json::{Value as Json, json};

/// All physics of an orbit run. The Sun is fixed at the origin.
#[derive(Clone, Debug, PartialEq)]
pub struct OrbitConfig {
    /// Where the Earth is and how it moves at the start.
    pub start: OrbitStart,
    /// How the equation of motion is discretised.
    pub integrator: OrbitIntegrator,
    /// Time step, days; below one day, by the source document.
    pub time_step_days: Positive,
    /// Simulated time, days.
    pub duration_days: Positive,
}

/// State at the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum OrbitStart {
    /// As printed in the source document: relative to the solar system's barycentre, 2013-01-01.
    Document,
    /// The same day relative to the Sun.
    Heliocentric,
    /// Written out; the position is not zero.
    Given {
        /// Position, AU.
        position_au: [Finite; 3],
        /// Velocity, AU/day.
        velocity_au_per_day: [Finite; 3],
    },
}

/// Time-stepping scheme of the orbit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum OrbitIntegrator {
    /// The source document's equations (15) and (16).
    ExplicitEuler,
    /// Kick, then drift.
    SemiImplicitEuler,
    /// Half kick, drift, half kick.
    VelocityVerlet,
    /// The classical fourth-order Runge–Kutta method.
    Rk4,
    /// Yoshida's fourth-order symplectic composition.
    Yoshida4,
    /// The exact solution of the two-body problem.
    Kepler,
}

impl Default for OrbitConfig {
    /// The document's start and method, a quarter of a day a step, one Julian year.
    fn default() -> Self {
        Self {
            start: OrbitStart::Document,
            integrator: OrbitIntegrator::ExplicitEuler,
            time_step_days: const { Positive::literal(0.25) },
            duration_days: const { Positive::literal(365.25) },
        }
    }
}

words!(pub OrbitIntegrator {
    ExplicitEuler = "explicit-euler",
    SemiImplicitEuler = "semi-implicit-euler",
    VelocityVerlet = "velocity-verlet",
    Rk4 = "rk4",
    Yoshida4 = "yoshida4",
    Kepler = "kepler",
});

impl OrbitConfig {
    /// The keys of `[model.orbit]`, in the order of the canonical manifest.
    pub(crate) fn keys(&mut self, keys: &mut impl Keys) {
        keys.key("start", "", "State at the start: document is the barycentric one as printed, heliocentric the same day relative to the Sun, or { position_au, velocity_au_per_day }.", &mut self.start);
        keys.key(
            "integrator",
            "",
            "How the equation of motion is discretised; kepler is the exact solution.",
            &mut self.integrator,
        );
        // The default is a quarter of a day, which is in both ranges.
        if let Some(step) = keys.optional(
            "time_step_days",
            "d",
            "Time step, below one day by the source document.",
            StepBelowOneDay::new(self.time_step_days.get()),
        ) {
            self.time_step_days = step.into();
        }
        keys.key("duration_days", "d", "Simulated time.", &mut self.duration_days);
    }

    /// The rules between the keys.
    pub(crate) fn check(&mut self, table: &mut Reader<'_>) {
        let steps = self.duration_days.get() / self.time_step_days.get();
        super::at_least_one_step(steps, table, &["time_step_days", "duration_days"]);
    }
}

impl TomlValue for OrbitStart {
    fn read(node: &Node, name: &str, errors: &mut Vec<Diagnostic>) -> Option<Self> {
        let Value::Table(table) = &node.value else {
            let words = [("document", Self::Document), ("heliocentric", Self::Heliocentric)];
            let besides = " or { position_au = ..., velocity_au_per_day = ... }";
            return word(node, name, &words, besides, errors);
        };
        let mut reader = Reader::new(name, table, errors);
        let position: Option<[Finite; 3]> = reader.required("position_au", node.span);
        let velocity: Option<[Finite; 3]> = reader.required("velocity_au_per_day", node.span);
        let apart = position.filter(|position| position.iter().any(|x| x.get() != 0.0));
        if position.is_some() && apart.is_none() {
            let title = format!("`{name}` lies in the Sun");
            reader.refuse(&["position_au"], &title, "must not be [0, 0, 0]");
        }
        reader.finish();
        let (position_au, velocity_au_per_day) = apart.zip(velocity)?;
        Some(Self::Given { position_au, velocity_au_per_day })
    }

    fn write(&self) -> String {
        match self {
            Self::Document => "\"document\"".to_owned(),
            Self::Heliocentric => "\"heliocentric\"".to_owned(),
            Self::Given { position_au, velocity_au_per_day } => format!(
                "{{ position_au = {}, velocity_au_per_day = {} }}",
                position_au.write(),
                velocity_au_per_day.write()
            ),
        }
    }

    fn schema() -> Json {
        let vector = <[Finite; 3]>::schema();
        json!({ "anyOf": [{ "enum": ["document", "heliocentric"] }, {
            "type": "object",
            "properties": { "position_au": vector, "velocity_au_per_day": vector },
            "required": ["position_au", "velocity_au_per_day"],
            "additionalProperties": false
        }] })
    }
}
