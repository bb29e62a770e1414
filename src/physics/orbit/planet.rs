//! One light body about the Sun: what is followed of it, and its distance from the exact solution.

use super::elements::Elements;
use super::kepler::Kepler;
use super::motion::{self, FixedSun, State, energy, kinetic_energy, length, potential_energy};
use super::phase::Plane;
use super::tables::Integrator;
use super::track::{Lost, Scheme, Track, Turns};
use super::{DOCUMENT_START, HELIOCENTRIC_START, forecast};
use crate::model::SetupError;
use crate::restart_state;
use kinetoscope_manifest::model::OrbitStart;
use kinetoscope_recording::channels::{OrbitElements, OrbitEnergy};
use kinetoscope_recording::frame::{Frame, Level};
use kinetoscope_recording::scenery::{DrawnRadius, Scenery, Wall};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Drawn radius of the Sun, AU; its true one, 0.00465 AU, could hardly be seen.
const DRAWN_SUN_AU: f64 = 0.05;

/// Sine of the angle between position and velocity below which the motion counts as radial.
const RADIAL: f64 = 1e-12;

/// The body, at one instant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Planet {
    start: Start,
    exact: Kepler,
    plane: Plane,
    pub(super) track: Track<[f64; 3]>,
}

/// Which start the manifest asked for; the log says what it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
enum Start {
    Document,
    Heliocentric,
    Given,
    Recorded,
}

impl Turns<[f64; 3]> for Plane {
    #[inline]
    fn side(&self, position: &[f64; 3]) -> bool {
        self.is_first_half(*position)
    }

    #[inline]
    fn between(&self, from: &[f64; 3], to: &[f64; 3]) -> i64 {
        self.turns_between(*from, *to)
    }
}

impl Planet {
    pub(super) fn prepare(start: &OrbitStart, scheme: &Scheme) -> Result<Self, SetupError> {
        let (start, state) = match start {
            OrbitStart::Document => (Start::Document, DOCUMENT_START),
            OrbitStart::Heliocentric => (Start::Heliocentric, HELIOCENTRIC_START),
            OrbitStart::Given { position_au, velocity_au_per_day } => {
                let position = position_au.map(|component| component.get());
                let velocity = velocity_au_per_day.map(|component| component.get());
                (Start::Given, State { position, velocity })
            }
            OrbitStart::Recorded(start) => {
                let rows = restart_state::rows(start, ["x", "y", "z", "vx", "vy", "vz"])?;
                let [[x, y, z, vx, vy, vz]] = rows[..] else {
                    return Err(SetupError(
                        "The recording in start_from is one of several bodies: write them out as bodies."
                            .to_owned(),
                    ));
                };
                let state = State { position: [x, y, z], velocity: [vx, vy, vz] };
                (Start::Recorded, state)
            }
        };
        check_start(state)?;
        Ok(Self {
            start,
            exact: Kepler::from_start(state),
            plane: Plane::of(state),
            track: Track::new(state, scheme),
        })
    }

    pub(super) fn advance(&mut self, scheme: &Scheme, steps: u64) -> Result<(), Lost> {
        if scheme.integrator == Integrator::Kepler {
            return self.leap(scheme, steps);
        }
        self.track.walk(&FixedSun, scheme, steps, &self.plane)
    }

    /// The exact solution so many steps later, from the start and in one go.
    fn leap(&mut self, scheme: &Scheme, steps: u64) -> Result<(), Lost> {
        let count = self.track.count + steps;
        let point = self.exact.at(scheme.time_at(count));
        if !point.state.is_finite() {
            return Err(Lost);
        }
        let beyond = point.angle - self.plane.angle(point.state.position);
        self.track.phase = point.state;
        self.track.count = count;
        self.track.turns = point.turns + (beyond / TAU + 0.5).floor() as i64;
        Ok(())
    }

    pub(super) fn observe(&self, time: f64, frame: &mut Frame) {
        let State { position: [x, y, z], velocity: [vx, vy, vz] } = self.track.phase;
        frame.push_state(&[x, y, z, vx, vy, vz]);
        frame.push(&self.energy_message());
        frame.push(&self.elements_message(time));
    }

    pub(super) fn scenery(&self, scheme: &Scheme, duration: f64) -> Scenery {
        let reach = forecast::reach(&self.exact, scheme.integrator, scheme.step, duration);
        Scenery {
            walls: vec![Wall::Body { center: [0.0, 0.0], radius: DRAWN_SUN_AU }],
            view: [[-reach, -reach], [reach, reach]],
            drawn_radius: DrawnRadius::Fixed(0.02 * (2.0 * reach)),
            speed_range_top: 1.5 * length(self.exact.start().velocity),
            speed_unit: "AU/d",
            arrows: true,
            force_range_top: None,
            trail: true,
        }
    }

    fn energy_message(&self) -> OrbitEnergy {
        let start = energy(self.exact.start());
        let total = energy(self.track.phase);
        OrbitEnergy {
            kinetic_au2_per_day2: kinetic_energy(self.track.phase.velocity),
            potential_au2_per_day2: potential_energy(self.track.phase.position),
            total_au2_per_day2: total,
            drift_ppm: (total - start) / start.abs() * 1e6,
        }
    }

    fn elements_message(&self, time: f64) -> OrbitElements {
        let state = self.track.phase;
        let now = Elements::of(state);
        let start = Elements::of(self.exact.start());
        let exact = self.exact.at(time);
        let angle = self.plane.angle(state.position);
        let error = motion::add_scaled(state.position, exact.state.position, -1.0);
        let bound = now.bound;
        OrbitElements {
            radius_au: length(state.position),
            semi_major_axis_au: now.semi_major_axis,
            eccentricity: now.eccentricity,
            angular_momentum_au2_per_day: now.angular_momentum,
            angular_momentum_drift_ppm: (now.angular_momentum - start.angular_momentum)
                / start.angular_momentum
                * 1e6,
            position_error_au: length(error),
            // Whole turns first: their difference is exact.
            phase_error_rad: (self.track.turns - exact.turns) as f64 * TAU + (angle - exact.angle),
            revolutions: self.track.turns as f64 + angle / TAU,
            inclination_rad: now.inclination,
            ascending_node_rad: now.ascending_node,
            argument_of_perihelion_rad: now.argument_of_perihelion,
            true_anomaly_rad: now.true_anomaly,
            mean_anomaly_rad: bound.map_or(f64::NAN, |bound| bound.mean_anomaly),
            perihelion_au: now.perihelion,
            aphelion_au: bound.map_or(f64::NAN, |bound| bound.aphelion),
            period_days: bound.map_or(f64::NAN, |bound| bound.period),
            force_evaluations: self.track.evaluations,
        }
    }

    pub(super) fn announce(&self, scheme: &Scheme, frame: &mut Frame) {
        let elements = Elements::of(self.exact.start());
        let orbit = match elements.bound {
            Some(bound) => format!(
                "a = {:.5} AU, e = {:.5}, period {:.3} d",
                elements.semi_major_axis, elements.eccentricity, bound.period
            ),
            None => format!(
                "an open path, e = {:.5}, perihelion {:.5} AU",
                elements.eccentricity, elements.perihelion
            ),
        };
        let origin = match self.start {
            Start::Document => {
                "\"document\": as printed in exercise 14to4. These numbers are relative to the barycenter of the solar \
                 system (2013-01-01), not to the Sun, so the period is no year; start = \"heliocentric\" gives the \
                 same day relative to the Sun (a = 0.99935 AU, period 364.898 d)"
            }
            Start::Heliocentric => "\"heliocentric\": the Earth relative to the Sun, 2013-01-01",
            Start::Given => "given in the manifest",
            Start::Recorded => "where the recording ended",
        };
        frame.log(Level::Info, format!("start {origin}; {orbit}"));
        if let (Integrator::ExplicitEuler, Some(bound)) = (scheme.integrator, elements.bound) {
            let gain =
                forecast::euler_energy_gain_per_revolution(&elements, bound.period, scheme.step);
            frame.log(
                Level::Info,
                format!(
                    "explicit Euler adds energy at every step, at first {:.3} % of it a revolution: the orbit widens. \
                     \"semi-implicit-euler\" costs the same and does not drift",
                    100.0 * gain
                ),
            );
        }
    }
}

/// Refuses a start that leads through the Sun or beyond what floating point can hold.
fn check_start(start: State) -> Result<(), SetupError> {
    let distance = length(start.position);
    let speed = length(start.velocity);
    let elements = Elements::of(start);
    if !motion::acceleration_over_position(start.position).is_normal()
        || !elements.energy.is_finite()
    {
        return Err(SetupError(format!(
            "start: at a distance of {distance} AU and a speed of {speed} AU/day the equation of motion overflows. \
             Give a position away from the Sun (the origin), in AU, and a velocity in AU/day."
        )));
    }
    if elements.angular_momentum <= RADIAL * distance * speed {
        return Err(SetupError(
            "start: the velocity is zero or points along the position, so the path is a straight line through the Sun. \
             Give velocity_au_per_day a part across position_au; a circle needs sqrt(GM / r), 0.0172 AU/day at 1 AU."
                .to_owned(),
        ));
    }
    if elements.energy == 0.0 {
        return Err(SetupError(
            "start: the energy is exactly zero (a parabola), so its drift has nothing to be compared with. \
             Change the last digit of the velocity."
                .to_owned(),
        ));
    }
    Ok(())
}
