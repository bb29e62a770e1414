//! Starts that the manifest can name.

use super::elements::{Anomaly, Ellipse};
use super::motion::{State, add_scaled};
use kinetoscope_manifest::model::{OrbitBody, OrbitState};

/// Start as printed in the orbit exercise, which states "from the center of the Sun". The numbers are the position of the Earth relative to
/// the barycenter of the solar system (2013-01-01 0h, ecliptic of J2000), so the period of the orbit is 362.073 days.
pub const BARYCENTRIC_START: State = State {
    position: [-1.813_068_419_866_209e-1, 9.642_197_733_507_97e-1, -6.850_809_238_551_276e-5],
    velocity: [-1.718_334_419_397_708e-2, -3.209_800_047_122_614e-3, 6.736_104_268_755_766e-9],
};

/// The Earth at the same time relative to the Sun (ecliptic of J2000, from an ephemeris): period 364.898 days.
pub const HELIOCENTRIC_START: State = State {
    position: [-0.180_022_557_728, 0.966_674_933_247, -2.644_611e-5],
    velocity: [-0.017_189_490_082_1, -0.003_208_481_984_12, 1.372_135e-7],
};

/// State that the manifest gives by vectors, or by elements around a mass with this G m, AU^3/day^2.
pub(super) fn given(state: &OrbitState, gravitational_parameter: f64) -> State {
    match *state {
        OrbitState::Vectors { position_au, velocity_au_per_day } => State {
            position: position_au.map(|component| component.get()),
            velocity: velocity_au_per_day.map(|component| component.get()),
        },
        OrbitState::Elements {
            semi_major_axis_au,
            eccentricity,
            inclination_rad,
            longitude_of_ascending_node_rad,
            argument_of_perihelion_rad,
            true_anomaly_rad,
            mean_anomaly_rad,
        } => Ellipse {
            semi_major_axis: semi_major_axis_au.get(),
            eccentricity: eccentricity.get(),
            inclination: inclination_rad.get(),
            ascending_node: longitude_of_ascending_node_rad.get(),
            argument_of_perihelion: argument_of_perihelion_rad.get(),
            anomaly: match true_anomaly_rad {
                Some(angle) => Anomaly::True(angle.get()),
                None => Anomaly::Mean(mean_anomaly_rad.map_or(0.0, |mean| mean.get())),
            },
        }
        .state(gravitational_parameter),
    }
}

/// States of several bodies. Elements are those of the motion relative to the first body, under the attraction of both masses.
pub(super) fn of_bodies(bodies: &[OrbitBody]) -> Vec<State> {
    let mut states: Vec<State> = Vec::with_capacity(bodies.len());
    let central = bodies.first().map_or(0.0, |body| body.gm_au3_per_day2.get());
    for body in bodies {
        let state = given(&body.state, central + body.gm_au3_per_day2.get());
        states.push(match (body.state, states.first()) {
            (OrbitState::Elements { .. }, Some(first)) => State {
                position: add_scaled(state.position, first.position, 1.0),
                velocity: add_scaled(state.velocity, first.velocity, 1.0),
            },
            _ => state,
        });
    }
    states
}
