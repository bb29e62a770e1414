//! `[model.orbit]`: rules for states and for several bodies.

use super::{OrbitBody, OrbitConfig, OrbitState};
use crate::diagnostics::Diagnostic;
use crate::keys::{Reader, rules};
use crate::model::sizes::{LARGEST, SMALLEST, length, nearest_size};
use crate::quantity::Finite;
use crate::tree::{Span, Value};
use std::collections::HashMap;
use std::f64::consts::TAU;

/// Largest sine of the angle between position and velocity of a straight line through the Sun.
const MAX_RADIAL_SINE: f64 = 1e-12;
/// Gravitational constant times the mass of the Sun, AU^3/day^2 (orbit exercise 14to4), for the advice on a speed.
const GM_OF_THE_SUN: f64 = 2.959_122_082_322_128e-4;
/// Up to this eccentricity, position and velocity at the perihelion determine the semi-major axis to about 1e-10: the vectors keep
/// 1 - e to an absolute accuracy of 2^-53.
const LARGEST_ECCENTRICITY: f64 = 1.0 - 1e-6;
/// Up to this angle, rad, the rounding of an angle is below 1.5e-14.
const LARGEST_ANOMALY: f64 = 100.0;

impl OrbitBody {
    pub(super) fn rules(&self, name: &str, reader: &mut Reader<'_>) {
        let gm = self.gm_au3_per_day2.get();
        let nearest = nearest_size(gm);
        rules! { reader;
            gm != 0.0 && gm != nearest => ["gm_au3_per_day2"]
                "`{name}.gm_au3_per_day2` is {gm:?}", "must be 0 or in [{SMALLEST:?}, {LARGEST:?}]; the nearest value is {nearest:?}";
        }
        self.state.describes_an_orbit(name, reader);
    }
}

impl OrbitState {
    pub(super) fn rules(&self, name: &str, reader: &mut Reader<'_>) {
        self.describes_an_orbit(name, reader);
        let Self::Vectors { position_au, velocity_au_per_day } = self else { return };
        let (distance, speed) = (length(*position_au), length(*velocity_au_per_day));
        let is_in_range = (SMALLEST..=LARGEST).contains(&distance) && speed <= LARGEST;
        let circular = (GM_OF_THE_SUN / distance).sqrt();
        rules! { reader;
            distance == 0.0 => ["position_au"]
                "`{name}` is at the position of the Sun", "must not be [0, 0, 0]; [1, 0, 0] is 1 AU away";
            distance > 0.0 && distance < SMALLEST => ["position_au"]
                "`{name}.position_au` is at a distance of {distance:e} AU from the Sun", "must be at least {SMALLEST:e} AU away";
            is_in_range && sine_between(*position_au, *velocity_au_per_day) <= MAX_RADIAL_SINE => ["position_au", "velocity_au_per_day"]
                "`{name}.velocity_au_per_day` is zero or along the position, so the path is a straight line through the Sun",
                "needs a component perpendicular to `position_au`: {circular:.5} AU/day on a circle";
        }
    }

    /// Reports vectors at which the equation of motion overflows, and elements without an ellipse.
    fn describes_an_orbit(&self, name: &str, reader: &mut Reader<'_>) {
        if let Self::Vectors { position_au, velocity_au_per_day } = self {
            for (key, vector) in
                [("position_au", position_au), ("velocity_au_per_day", velocity_au_per_day)]
            {
                let size = length(*vector);
                rules! { reader;
                    size > LARGEST => [key]
                        "the length of `{name}.{key}` is {size:e}, at which the equation of motion overflows",
                        "must be at most {LARGEST:e}";
                }
            }
        }
        let Self::Elements {
            semi_major_axis_au,
            eccentricity,
            inclination_rad,
            true_anomaly_rad,
            mean_anomaly_rad,
            ..
        } = self
        else {
            return;
        };
        let (axis, e, tilt) = (semi_major_axis_au.get(), eccentricity.get(), inclination_rad.get());
        let suggested = if axis < 0.0 { nearest_size(-axis) } else { 1.0 };
        let nearest_axis = nearest_size(axis);
        let nearest = if e < 0.0 { 0.0 } else { LARGEST_ECCENTRICITY };
        let nearest_tilt = if tilt < 0.0 { 0.0 } else { std::f64::consts::PI };
        let in_degrees = if (4.0..=180.0).contains(&tilt) {
            format!("; {tilt:?} degrees are {:?} rad", tilt.to_radians())
        } else {
            String::new()
        };
        let two_anomalies = reader.has("true_anomaly_rad") && reader.has("mean_anomaly_rad");
        rules! { reader;
            axis <= 0.0 => ["semi_major_axis_au"]
                "`{name}.semi_major_axis_au` is {axis:?}, which describes no ellipse",
                "must be > 0, such as {suggested:?}; an open path is given by `position_au` and `velocity_au_per_day`";
            axis > 0.0 && axis != nearest_axis => ["semi_major_axis_au"]
                "`{name}.semi_major_axis_au` is {axis:?}, at which the equation of motion overflows",
                "must be in [{SMALLEST:?}, {LARGEST:?}]; the nearest value is {nearest_axis:?}";
            !(0.0..=LARGEST_ECCENTRICITY).contains(&e) => ["eccentricity"]
                "`{name}.eccentricity` is {e:?}, which describes no ellipse, or one too narrow for these elements",
                "must be in [0, {LARGEST_ECCENTRICITY:?}]; the nearest value is {nearest:?}";
            !(0.0..=std::f64::consts::PI).contains(&tilt) => ["inclination_rad"]
                "`{name}.inclination_rad` is {tilt:?}",
                "must be in [0, pi], above pi/2 for retrograde motion; the nearest value is {nearest_tilt:?}{in_degrees}";
            two_anomalies => ["true_anomaly_rad", "mean_anomaly_rad"]
                "`{name}` has a true and a mean anomaly, which cannot be used together", "keep one of them";
        }
        for (key, anomaly) in
            [("true_anomaly_rad", true_anomaly_rad), ("mean_anomaly_rad", mean_anomaly_rad)]
        {
            let angle = anomaly.map_or(0.0, Finite::get);
            let equal = angle % TAU;
            rules! { reader;
                angle.abs() > LARGEST_ANOMALY => [key]
                    "`{name}.{key}` is {angle:?}", "must be in [-{LARGEST_ANOMALY:?}, {LARGEST_ANOMALY:?}]: the same angle without multiples of 2 pi is {equal:?}";
            }
        }
    }

    fn has_elements(&self) -> bool {
        matches!(self, Self::Elements { .. })
    }

    /// Text of the numbers that the position follows from: equal ones have equal texts. Bodies on one ellipse differ by their anomaly.
    fn position_text(&self) -> String {
        match self {
            Self::Vectors { position_au, .. } => format!("{position_au:?}"),
            Self::Elements { .. } => format!("{self:?}"),
        }
    }
}

/// Sine of the angle between two vectors that are not zero; 0 if one is.
fn sine_between(one: [Finite; 3], other: [Finite; 3]) -> f64 {
    let unit = |vector: [Finite; 3]| {
        let length = length(vector);
        vector.map(|component| if length > 0.0 { component.get() / length } else { 0.0 })
    };
    let ([ax, ay, az], [bx, by, bz]) = (unit(one), unit(other));
    let [x, y, z] = [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx];
    (x * x + y * y + z * z).sqrt()
}

impl OrbitConfig {
    /// Reports bodies between which no motion can be followed.
    pub(super) fn check_bodies(&self, table: &mut Reader<'_>) {
        report_first_elements(table);
        let Some(bodies) = &self.bodies else { return };
        let attracts = |body: &OrbitBody| body.gm_au3_per_day2.get() > 0.0;
        let has_elements = bodies.iter().any(|body| body.state.has_elements());
        let first = bodies.first();
        let is_motion = bodies.len() >= 2 && bodies.iter().any(attracts);
        rules! { table;
            !is_motion => ["bodies"]
                "no body of `model.orbit.bodies` attracts another",
                "needs at least two bodies, one of them with mass: `gm_au3_per_day2 = {GM_OF_THE_SUN:?}` is the Sun's";
            has_elements && first.is_some_and(|first| !first.state.has_elements() && !attracts(first)) => ["bodies"]
                "the first body of `model.orbit.bodies` has no mass, but others have elements relative to it",
                "list the body that they orbit first";
            is_motion && is_at_relative_rest(bodies) => ["bodies"]
                "all bodies of `model.orbit.bodies` have the same velocity, so none moves relative to the others",
                "change one of `velocity_au_per_day`";
        }
        report_coinciding(bodies, table);
    }
}

/// Reports a first body with elements. From the text, so that no error in a number hides it.
fn report_first_elements(table: &mut Reader<'_>) {
    let Some(Value::Array(bodies)) = table.node("bodies").map(|node| &node.value) else { return };
    let Some(first) = bodies.first() else { return };
    let keys = ["semi_major_axis_au", "eccentricity"];
    if first.table().is_some_and(|body| keys.iter().any(|key| body.get(key).is_some())) {
        let title = "the first body of `model.orbit.bodies` has elements, which are relative to the first body";
        let label = "give the first body by `position_au` and `velocity_au_per_day`, such as [0, 0, 0] and [0, 0, 0]";
        table.report(Diagnostic::new(title).at(first.span, label));
    }
}

/// Whether all bodies have the same velocity.
fn is_at_relative_rest(bodies: &[OrbitBody]) -> bool {
    let mut velocities = bodies.iter().map(|body| match body.state {
        OrbitState::Vectors { velocity_au_per_day, .. } => Some(velocity_au_per_day),
        OrbitState::Elements { .. } => None,
    });
    let first = velocities.next().flatten();
    first.is_some() && velocities.all(|velocity| velocity == first)
}

/// Reports each body with the position of an earlier one, unless both are test particles, which pass through each other. A first body
/// with elements has no position.
fn report_coinciding(bodies: &[OrbitBody], table: &mut Reader<'_>) {
    let Some(Value::Array(elements)) = table.node("bodies").map(|node| &node.value) else { return };
    // Body at a position, if possible one that attracts.
    let mut bodies_at: HashMap<_, (usize, bool)> = HashMap::new();
    let is_placed =
        |(number, body): &(usize, &OrbitBody)| *number > 0 || !body.state.has_elements();
    for (number, body) in bodies.iter().enumerate().filter(is_placed) {
        let attracts = body.gm_au3_per_day2.get() > 0.0;
        let there = bodies_at.entry(body.state.position_text()).or_insert((number, attracts));
        let (other, other_attracts) = *there;
        if other == number || !(attracts || other_attracts) {
            continue;
        }
        if attracts {
            *there = (number, true);
        }
        let title =
            format!("bodies {other} and {number} of `model.orbit.bodies` are at the same position");
        let places: Vec<Span> =
            [other, number].iter().filter_map(|body| Some(elements.get(*body)?.span)).collect();
        let key = match body.state {
            OrbitState::Vectors { .. } => "`position_au`",
            OrbitState::Elements { .. } => "`mean_anomaly_rad`",
        };
        table.report(Diagnostic::between(title, places, format!("change {key} of one of them")));
    }
}
