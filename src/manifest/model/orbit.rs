//! `[model.orbit]`: the Earth around the Sun, in AU and days.

use super::contract::{Model, at_least_one_step};
use super::start::starts;
use super::start_from::{MayBeRecorded as _, StartFrom};
use crate::diagnostics::Errors;
use crate::inline::{self, inline_enum, inline_table};
use crate::keys::{Reader, rules};
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
    pub struct OrbitBody = "a table { gm_au3_per_day2, position_au, velocity_au_per_day }, or with elements in place of the vectors" with OrbitBody::rules {
        /// Gravitational constant times mass, AU^3/day^2; zero for a test particle, which attracts no other body.
        gm_au3_per_day2: NonNegative [required],
        /// Vectors, or elements relative to the first body.
        state: OrbitState [flatten],
    }
}

inline_enum! {
    /// A state written out in a manifest, as vectors or as the elements of an ellipse.
    pub enum OrbitState = "{ position_au = ..., velocity_au_per_day = ... } or { semi_major_axis_au = ..., eccentricity = ... }" with OrbitState::rules {
        /// Position and velocity; the position of a body around the Sun is not zero.
        Vectors {
            /// Position, AU.
            position_au: [Finite; 3] [required],
            /// Velocity, AU/day.
            velocity_au_per_day: [Finite; 3] [required],
        }
        /// Keplerian elements; the angles are zero where they are left out.
        Elements {
            /// Semi-major axis, AU; above zero.
            semi_major_axis_au: Finite [required],
            /// Eccentricity, in [0, 1).
            eccentricity: Finite [required],
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

/// Up to this eccentricity, position and velocity at the perihelion determine the semi-major axis to about 1e-10: the vectors keep
/// 1 - e to an absolute accuracy of 2^-53.
const LARGEST_ECCENTRICITY: f64 = 1.0 - 1e-6;
/// Up to this angle, rad, the rounding of an angle is below 1.5e-14.
const LARGEST_ANOMALY: f64 = 100.0;

impl OrbitBody {
    fn rules(&self, name: &str, reader: &mut Reader<'_>) {
        self.state.describes_an_orbit(name, reader);
    }
}

impl OrbitState {
    fn rules(&self, name: &str, reader: &mut Reader<'_>) {
        let is_at_the_sun = matches!(self, Self::Vectors { position_au, .. }
            if position_au.iter().all(|x| x.get() == 0.0));
        rules! { reader;
            is_at_the_sun => ["position_au"]
                "`{name}` is at the position of the Sun", "must not be [0, 0, 0]";
        }
        self.describes_an_orbit(name, reader);
    }

    /// Reports elements without an ellipse, and keys that exclude each other.
    fn describes_an_orbit(&self, name: &str, reader: &mut Reader<'_>) {
        const ELEMENTS: [&str; 7] = [
            "semi_major_axis_au",
            "eccentricity",
            "inclination_rad",
            "longitude_of_ascending_node_rad",
            "argument_of_perihelion_rad",
            "true_anomaly_rad",
            "mean_anomaly_rad",
        ];
        let Self::Elements {
            semi_major_axis_au,
            eccentricity,
            inclination_rad,
            true_anomaly_rad,
            mean_anomaly_rad,
            ..
        } = self
        else {
            if let Some(element) = ELEMENTS.iter().find(|element| reader.has(element)) {
                reader.also_known(&ELEMENTS);
                rules! { reader;
                    true => ["position_au", "velocity_au_per_day", element]
                        "`{name}` has vectors and the element `{element}`, which cannot be used together",
                        "keep the vectors or the elements";
                }
            }
            return;
        };
        let (axis, e, tilt) = (semi_major_axis_au.get(), eccentricity.get(), inclination_rad.get());
        let suggested = if axis < 0.0 { -axis } else { 1.0 };
        let nearest = if e < 0.0 { 0.0 } else { LARGEST_ECCENTRICITY };
        let nearest_tilt = if tilt < 0.0 { 0.0 } else { std::f64::consts::PI };
        let two_anomalies = reader.has("true_anomaly_rad") && reader.has("mean_anomaly_rad");
        rules! { reader;
            axis <= 0.0 => ["semi_major_axis_au"]
                "`{name}.semi_major_axis_au` is {axis:?}, which describes no ellipse",
                "must be > 0, such as {suggested:?}; an open path is given by `position_au` and `velocity_au_per_day`";
            !(0.0..=LARGEST_ECCENTRICITY).contains(&e) => ["eccentricity"]
                "`{name}.eccentricity` is {e:?}, which describes no ellipse, or one too narrow for these elements",
                "must be in [0, {LARGEST_ECCENTRICITY:?}]; the nearest value is {nearest:?}";
            !(0.0..=std::f64::consts::PI).contains(&tilt) => ["inclination_rad"]
                "`{name}.inclination_rad` is {tilt:?}",
                "must be in [0, pi], above pi/2 for retrograde motion; the nearest value is {nearest_tilt:?}";
            two_anomalies => ["true_anomaly_rad", "mean_anomaly_rad"]
                "`{name}` has a true and a mean anomaly, which cannot be used together", "keep one of them";
        }
        for (key, anomaly) in
            [("true_anomaly_rad", true_anomaly_rad), ("mean_anomaly_rad", mean_anomaly_rad)]
        {
            let angle = anomaly.map_or(0.0, Finite::get);
            rules! { reader;
                angle.abs() > LARGEST_ANOMALY => [key]
                    "`{name}.{key}` is {angle:?}", "must be in [-{LARGEST_ANOMALY:?}, {LARGEST_ANOMALY:?}]: subtract multiples of 2 pi";
            }
        }
    }

    fn has_elements(&self) -> bool {
        matches!(self, Self::Elements { .. })
    }
}

impl Model for OrbitConfig {
    fn intervals(&self, _sound: bool) -> &'static [&'static str] {
        &["every_days", "every_steps"]
    }

    fn particles(&self) -> u64 {
        self.bodies.as_ref().map_or(1, |bodies| bodies.len() as u64)
    }

    fn check(&mut self, table: &mut Reader<'_>) {
        let steps = self.duration_days.get() / self.time_step_days.get();
        at_least_one_step(steps, table, &["time_step_days", "duration_days"]);
        let recorded = self.start.recorded().and_then(StartFrom::particles);
        let bodies = self.bodies.as_deref();
        let is_kepler = self.integrator == OrbitIntegrator::Kepler;
        let attracts = |body: &OrbitBody| body.gm_au3_per_day2.get() > 0.0;
        let first = bodies.and_then(<[OrbitBody]>::first);
        let has_elements =
            bodies.is_some_and(|bodies| bodies.iter().any(|body| body.state.has_elements()));
        rules! { table;
            recorded.is_some_and(|bodies| bodies > 1) => ["start_from"]
                "the recording has several bodies", "list them as `bodies`: their masses are not in its frames";
            is_kepler && bodies.is_some() => ["bodies", "integrator"]
                "`integrator = \"kepler\"` cannot be used with several bodies", "\"kepler\" moves one body about the Sun";
            bodies.is_some_and(|bodies| bodies.len() < 2 || !bodies.iter().any(attracts)) => ["bodies"]
                "no body of `model.orbit.bodies` attracts another",
                "needs at least two bodies, one of them with mass";
            first.is_some_and(|first| first.state.has_elements()) => ["bodies"]
                "the first body of `model.orbit.bodies` has elements, which are relative to the first body",
                "give the first body by `position_au` and `velocity_au_per_day`";
            has_elements && first.is_some_and(|first| !first.state.has_elements() && !attracts(first)) => ["bodies"]
                "the first body of `model.orbit.bodies` has no mass, but others have elements relative to it",
                "list the body that they orbit first";
        }
    }
}
