//! `[model.orbit]`: the Earth around the Sun, in AU and days.

use super::StartFrom;
use crate::diagnostics::Diagnostic;
use crate::keys::{Keys, Reader};
use crate::quantity::{Finite, NonNegative, Positive, StepBelowOneDay, StepTolerance};
use crate::tree::{Node, Value};
use crate::value::{TomlValue, refuse, table_schema, word, words};
use serde_json::{Value as Json, json};

/// All physics of an orbit run. The Sun is fixed at the origin, unless several bodies attract each other.
#[derive(Clone, Debug, PartialEq)]
pub struct OrbitConfig {
    /// Where the Earth is and how it moves at the start.
    pub start: OrbitStart,
    /// In place of a start: bodies that attract each other, at least two, one of them with mass.
    pub bodies: Option<Vec<OrbitBody>>,
    /// How the equation of motion is discretised.
    pub integrator: OrbitIntegrator,
    /// How what is added to positions and velocities is rounded.
    pub summation: OrbitSummation,
    /// Largest error of a step that the adaptive method chooses, of position and velocity relative to their lengths.
    pub tolerance: StepTolerance,
    /// Time step, days; below one day, by the source document. Of the adaptive method the first step to try.
    pub time_step_days: Positive,
    /// Simulated time, days.
    pub duration_days: Positive,
}

/// State at the start.
#[derive(Clone, Debug, PartialEq)]
pub enum OrbitStart {
    /// As printed in the source document: relative to the solar system's barycenter, 2013-01-01.
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
    /// As the run of a recording ended.
    Recorded(StartFrom),
}

/// Time-stepping scheme of the orbit.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize,
)]
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
    /// Dormand and Prince's method of order 8 in steps of its own.
    DormandPrince8,
    /// The exact solution of the two-body problem.
    Kepler,
}

/// How sums of positions and velocities are rounded.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize,
)]
pub enum OrbitSummation {
    /// At every addition, as the source document's equations read.
    Plain,
    /// What an addition rounds off is added with the next one.
    Compensated,
}

/// One of several bodies that attract each other.
#[derive(Clone, Debug, PartialEq)]
pub struct OrbitBody {
    /// Gravitational constant times mass, AU^3/day^2; zero for a body that attracts nobody.
    pub gm_au3_per_day2: NonNegative,
    /// Position, AU.
    pub position_au: [Finite; 3],
    /// Velocity, AU/day.
    pub velocity_au_per_day: [Finite; 3],
}

impl Default for OrbitConfig {
    /// The document's start and method, a quarter of a day a step, one Julian year.
    fn default() -> Self {
        Self {
            start: OrbitStart::Document,
            bodies: None,
            integrator: OrbitIntegrator::ExplicitEuler,
            summation: OrbitSummation::Plain,
            tolerance: const { StepTolerance::literal(1e-13) },
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
    DormandPrince8 = "dormand-prince8",
    Kepler = "kepler",
});

words!(pub OrbitSummation {
    Plain = "plain",
    Compensated = "compensated",
});

impl OrbitConfig {
    /// The keys of `[model.orbit]`, in the order of the canonical manifest.
    pub(crate) fn keys(&mut self, keys: &mut impl Keys) {
        if self.bodies.is_none() {
            super::start_keys(
                "start",
                "State at the start: document is the barycentric one as printed, heliocentric \
                the same day relative to the Sun, or { position_au, velocity_au_per_day }.",
                &["start", "start_from", "bodies"],
                &mut self.start,
                keys,
            );
        }
        self.bodies = keys.optional(
            "bodies",
            "",
            "In place of start: two bodies or more that attract each other, each \
            { gm_au3_per_day2, position_au, velocity_au_per_day }. Their center of mass is put at rest in the origin.",
            self.bodies.take(),
        );
        keys.key(
            "integrator",
            "",
            "How the equation of motion is discretised; dormand-prince8 chooses its own steps, kepler is the exact solution.",
            &mut self.integrator,
        );
        keys.key(
            "summation",
            "",
            "Whether each addition to positions and velocities is rounded (plain), or what it rounds off is \
            kept and added with the next one (compensated).",
            &mut self.summation,
        );
        keys.key(
            "tolerance",
            "1",
            "Largest error of a step of dormand-prince8, of position and velocity relative to their lengths.",
            &mut self.tolerance,
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
        if let OrbitStart::Recorded(start) = &self.start
            && start.particles().is_some_and(|bodies| bodies > 1)
        {
            table.refuse(
                &["start_from"],
                "the recording is one of several bodies",
                "write them out as `bodies`: their masses are not in its frames",
            );
        }
        let Some(bodies) = &self.bodies else { return };
        if self.integrator == OrbitIntegrator::Kepler {
            table.refuse(
                &["bodies", "integrator"],
                "several bodies have no exact solution",
                "\"kepler\" moves one body about the Sun",
            );
        }
        if bodies.len() < 2 || bodies.iter().all(|body| body.gm_au3_per_day2.get() == 0.0) {
            let title = "`model.orbit.bodies` attract nobody";
            table.refuse(&["bodies"], title, "needs at least two bodies, one of them with mass");
        }
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
            Self::Recorded(start) => start.write(),
        }
    }

    fn schema() -> Json {
        let vector = <[Finite; 3]>::schema();
        let properties = json!({ "position_au": vector, "velocity_au_per_day": vector });
        let given = table_schema(&properties, &["position_au", "velocity_au_per_day"]);
        json!({ "anyOf": [{ "enum": ["document", "heliocentric"] }, given] })
    }
}

impl TomlValue for OrbitBody {
    fn read(node: &Node, name: &str, errors: &mut Vec<Diagnostic>) -> Option<Self> {
        let Value::Table(table) = &node.value else {
            let what = "a table { gm_au3_per_day2, position_au, velocity_au_per_day }";
            refuse(node, name, what, errors);
            return None;
        };
        let mut reader = Reader::new(name, table, errors);
        let gm_au3_per_day2 = reader.required("gm_au3_per_day2", node.span);
        let position_au = reader.required("position_au", node.span);
        let velocity_au_per_day = reader.required("velocity_au_per_day", node.span);
        reader.finish();
        Some(Self {
            gm_au3_per_day2: gm_au3_per_day2?,
            position_au: position_au?,
            velocity_au_per_day: velocity_au_per_day?,
        })
    }

    fn write(&self) -> String {
        format!(
            "{{ gm_au3_per_day2 = {}, position_au = {}, velocity_au_per_day = {} }}",
            self.gm_au3_per_day2.write(),
            self.position_au.write(),
            self.velocity_au_per_day.write()
        )
    }

    fn schema() -> Json {
        let vector = <[Finite; 3]>::schema();
        let properties = json!({
            "gm_au3_per_day2": NonNegative::schema(),
            "position_au": vector,
            "velocity_au_per_day": vector
        });
        table_schema(&properties, &["gm_au3_per_day2", "position_au", "velocity_au_per_day"])
    }
}
