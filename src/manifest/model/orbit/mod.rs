//! `[model.orbit]`: the Earth around the Sun, in AU and days.

mod integrator;
mod rules;

pub use integrator::{IntegratorProperties, IntegratorSteps, OrbitIntegrator};

use crate::diagnostics::Errors;
use crate::inline::{self, inline_enum, inline_table};
use crate::keys::{Reader, rules};
use crate::model::contract::{Model, check_first_step};
use crate::model::start::starts;
use crate::model::start_from::{MayBeRecorded as _, StartFrom};
use crate::quantity::{Finite, NonNegative, Positive, StepTolerance};
use crate::table::table;
use crate::tree::Node;
use crate::value::{TomlValue, words};

table! {
    /// All physics of an orbit run. The Sun is fixed at the origin, unless several bodies attract each other. By default,
    /// the Earth relative to the Sun on 2013-01-01, a quarter of a day per step, one Julian year.
    pub struct OrbitConfig {
        /// State at the start, 2013-01-01: heliocentric is relative to the Sun, barycentric relative to the solar system's
        /// barycenter as printed in the orbit exercise; or { position_au, velocity_au_per_day }; or elements
        /// { semi_major_axis_au, eccentricity, inclination_rad, longitude_of_ascending_node_rad, argument_of_perihelion_rad,
        /// true_anomaly_rad or mean_anomaly_rad }.
        start: OrbitStart [start unless bodies] = OrbitStart::Heliocentric,
        /// In place of start: two bodies or more that attract each other, each
        /// { gm_au3_per_day2, position_au, velocity_au_per_day }, or with elements relative to the first body in place of the
        /// vectors. A body with gm_au3_per_day2 = 0 is a test particle. Their center of mass is put at rest in the origin.
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

starts! {
    /// State at the start.
    pub enum OrbitStart {
        /// The orbit exercise's: relative to the solar system's barycenter, 2013-01-01.
        Barycentric = "barycentric",
        /// The same day relative to the Sun.
        Heliocentric = "heliocentric",
        | OrbitState
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
    pub struct OrbitBody = "a table { gm_au3_per_day2, position_au, velocity_au_per_day }, or with elements in place of the vectors" with OrbitBody::rules {
        /// Gravitational constant times mass, AU^3/day^2; zero for a test particle, which attracts no other body.
        gm_au3_per_day2: NonNegative [required else NonNegative::literal(0.0)],
        /// Vectors, or elements relative to the first body.
        state: OrbitState [flatten else OrbitState::CIRCLE],
    }
}

inline_enum! {
    /// A state written out in a manifest, as vectors or as the elements of an ellipse.
    pub enum OrbitState = "{ position_au = ..., velocity_au_per_day = ... } or { semi_major_axis_au = ..., eccentricity = ... }" with OrbitState::rules {
        /// Position and velocity; the position of a body around the Sun is not zero.
        Vectors {
            /// Position, AU.
            position_au: [Finite; 3] [required else UNIT_X],
            /// Velocity, AU/day.
            velocity_au_per_day: [Finite; 3] [required else UNIT_Y],
        }
        /// Keplerian elements; the angles are zero where they are left out.
        Elements {
            /// Semi-major axis, AU; above zero.
            semi_major_axis_au: Finite [required else Finite::literal(1.0)],
            /// Eccentricity, in [0, 1).
            eccentricity: Finite [required else Finite::literal(0.0)],
            /// Angle between the orbital plane and the plane z = 0, rad; in [0, pi].
            inclination_rad: Finite [or Finite::literal(0.0)],
            /// Angle from the x axis to the ascending node, rad.
            longitude_of_ascending_node_rad: Finite [or Finite::literal(0.0)],
            /// Angle from the ascending node to the perihelion, rad.
            argument_of_perihelion_rad: Finite [or Finite::literal(0.0)],
            /// Angle from the perihelion to the body, rad.
            true_anomaly_rad: Option<Finite> [optional],
            /// In place of the true anomaly: time since the perihelion, as a fraction of the period times 2 pi, rad.
            mean_anomaly_rad: Option<Finite> [optional],
        }
    }
}

const UNIT_X: [Finite; 3] = [Finite::literal(1.0), Finite::literal(0.0), Finite::literal(0.0)];
const UNIT_Y: [Finite; 3] = [Finite::literal(0.0), Finite::literal(1.0), Finite::literal(0.0)];

impl OrbitState {
    /// A state that breaks no rule.
    const CIRCLE: Self = Self::Vectors { position_au: UNIT_X, velocity_au_per_day: UNIT_Y };
}

impl TomlValue for OrbitState {
    fn read(node: &Node, name: &str, errors: &mut Errors) -> Option<Self> {
        inline::read(node, name, errors)
    }

    fn write(&self) -> String {
        inline::write(self)
    }

    fn schema() -> serde_json::Value {
        inline::schema::<Self>(None)
    }
}

impl Model for OrbitConfig {
    fn intervals(&self, _sound: bool) -> &'static [&'static str] {
        &["every_days", "every_steps"]
    }

    fn duration(&self) -> Option<f64> {
        Some(self.duration_days.get())
    }

    fn particles(&self) -> u64 {
        self.bodies.as_ref().map_or(1, |bodies| bodies.len() as u64)
    }

    fn draws_random_numbers(&self) -> bool {
        false
    }

    fn check(&mut self, table: &mut Reader<'_>) {
        let keys = ["time_step_days", "duration_days"];
        // How small a step can be depends on the positions; `prepare` of the model reports it.
        check_first_step(self.duration_days, self.time_step_days, table, &keys);
        let recorded = self.start.recorded().and_then(StartFrom::particles);
        let bodies = self.bodies.as_deref();
        let is_kepler = self.integrator == OrbitIntegrator::Kepler;
        rules! { table;
            recorded.is_some_and(|bodies| bodies > 1) => ["start_from"]
                "the recording has several bodies", "list them as `bodies`: their masses are not in its frames";
            is_kepler && bodies.is_some() => ["bodies", "integrator"]
                "`integrator = \"kepler\"` cannot be used with several bodies", "\"kepler\" moves one body about the Sun";
        }
        self.check_bodies(table);
    }
}
