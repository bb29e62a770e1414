//! One light body around the Sun: its integration, and its deviation from the exact solution.

use super::elements::{Elements, log10_of_change};
use super::estimates;
use super::guides;
use super::kepler::Kepler;
use super::motion::{self, FixedSun, State, energy, kinetic_energy, length, potential_energy};
use super::orbital_plane::OrbitalPlane;
use super::path::PathRecord;
use super::starts::{self, BARYCENTRIC_START, HELIOCENTRIC_START};
use super::trajectory::{Discretization, NotFinite, StepBudget, Trajectory};
use crate::constants::GM_SUN_AU3_PER_DAY2;
use crate::model::SetupError;
use crate::restart_state;
use kinetoscope_manifest::model::{OrbitIntegrator, OrbitStart};
use kinetoscope_recording::channels::{OrbitElements, OrbitEnergy};
use kinetoscope_recording::frame::{Frame, Level};
use kinetoscope_recording::scenery::{DrawnRadius, Scenery, Wall};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Drawn radius of the Sun, AU; its true radius, 0.00465 AU, would be hardly visible.
const DRAWN_SUN_AU: f64 = 0.05;

/// Maximum sine of the angle between position and velocity for radial motion.
const MAX_RADIAL_SINE: f64 = 1e-12;

/// Body at one time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Planet {
    /// Description of the start for the log.
    start_description: String,
    exact: Kepler,
    plane: OrbitalPlane,
    pub(super) trajectory: Trajectory<[f64; 3], PathRecord>,
}

impl Planet {
    /// Whether this can be a later state of a start.
    pub(super) fn is_valid_after(&self, start: &Self) -> bool {
        self.start_description == start.start_description
            && self.exact == start.exact
            && self.plane == start.plane
            && self.trajectory.is_valid_after(&start.trajectory)
    }

    /// The body at the start that the manifest describes.
    pub(super) fn prepare(
        start: &OrbitStart,
        discretization: &Discretization,
    ) -> Result<Self, SetupError> {
        let (description, state) = match start {
            OrbitStart::Barycentric => (
                "\"barycentric\": as printed in exercise 14to4. These numbers are relative to the barycenter of the solar system \
                 (2013-01-01), not to the Sun, so the period is not a year; start = \"heliocentric\" gives the same day relative \
                 to the Sun (a = 0.99935 AU, period 364.898 d)",
                BARYCENTRIC_START,
            ),
            OrbitStart::Heliocentric => {
                ("\"heliocentric\": the Earth relative to the Sun, 2013-01-01", HELIOCENTRIC_START)
            }
            OrbitStart::Given(state) => {
                ("given in the manifest", starts::given(state, GM_SUN_AU3_PER_DAY2))
            }
            OrbitStart::Recorded(start) => {
                let rows = restart_state::rows(start, ["x", "y", "z", "vx", "vy", "vz"])?;
                let [[x, y, z, vx, vy, vz]] = rows[..] else {
                    return Err(SetupError::new(
                        format!(
                            "start_from: expected a recording of one body, found {} bodies",
                            rows.len()
                        ),
                        "give them as bodies",
                    ));
                };
                let state = State { position: [x, y, z], velocity: [vx, vy, vz] };
                ("the end of the recording", state)
            }
        };
        check_start(state)?;
        Ok(Self {
            start_description: description.to_owned(),
            exact: Kepler::from_start(state),
            plane: OrbitalPlane::of(state),
            trajectory: Trajectory::new(state, PathRecord::default(), discretization),
        })
    }

    pub(super) fn advance(
        &mut self,
        discretization: &Discretization,
        budget: StepBudget,
    ) -> Result<(), NotFinite> {
        if discretization.integrator == OrbitIntegrator::Kepler {
            return self.advance_exactly(discretization, budget.steps);
        }
        self.trajectory.advance(&FixedSun, discretization, budget, &self.plane)
    }

    /// Evaluates the exact solution the given number of steps later.
    fn advance_exactly(
        &mut self,
        discretization: &Discretization,
        steps: u64,
    ) -> Result<(), NotFinite> {
        let count = self.trajectory.count + steps;
        let time = discretization.time_at(count);
        let point = self.exact.at(time);
        if !point.state.is_finite() {
            return Err(NotFinite);
        }
        let unwrapped = point.angle - self.plane.angle(point.state.position);
        self.trajectory.phase = point.state;
        self.trajectory.count = count;
        let turns = point.turns + (unwrapped / TAU + 0.5).floor() as i64;
        self.trajectory.path = PathRecord::exact(&self.exact, &point, turns, time);
        Ok(())
    }

    pub(super) fn observe(&self, time: f64, frame: &mut Frame) {
        let State { position: [x, y, z], velocity: [vx, vy, vz] } = self.trajectory.phase;
        frame.push_state(&[x, y, z, vx, vy, vz]);
        frame.push(&self.energy_message());
        frame.push(&self.elements_message(time));
    }

    pub(super) fn scenery(&self, discretization: &Discretization, duration: f64) -> Scenery {
        let half = estimates::view_half_width(&self.exact, discretization, duration);
        let mut walls = vec![Wall::Body { center: [0.0, 0.0], radius: DRAWN_SUN_AU }];
        walls.extend(guides::around_the_sun(self.exact.start(), half));
        let is_earth = [BARYCENTRIC_START, HELIOCENTRIC_START].contains(&self.exact.start());
        Scenery {
            walls,
            view: [[-half, -half], [half, half]],
            drawn_radius: DrawnRadius::Fixed(0.02 * (2.0 * half)),
            speed_range_top: 1.5 * length(self.exact.start().velocity),
            speed_unit: "AU/d",
            arrows: true,
            force_range_top: None,
            trail: true,
            unused_fields: Vec::new(),
            names: is_earth.then(|| "Earth".to_owned()).into_iter().collect(),
            central_particle: None,
        }
    }

    fn energy_message(&self) -> OrbitEnergy {
        let start = energy(self.exact.start());
        let total = energy(self.trajectory.phase);
        OrbitEnergy {
            specific_kinetic_energy_au2_per_day2: kinetic_energy(self.trajectory.phase.velocity),
            specific_potential_energy_au2_per_day2: potential_energy(
                self.trajectory.phase.position,
            ),
            specific_total_energy_au2_per_day2: total,
            drift_ppm: (total - start) / start.abs() * 1e6,
            drift_log10: log10_of_change(total - start, start),
        }
    }

    fn elements_message(&self, time: f64) -> OrbitElements {
        let state = self.trajectory.phase;
        let now = Elements::of(state);
        let start = Elements::of(self.exact.start());
        let exact = self.exact.at(time);
        let angle = self.plane.angle(state.position);
        let error = motion::add_scaled(state.position, exact.state.position, -1.0);
        let bound = now.bound;
        let path = &self.trajectory.path;
        let [min_radius_au, max_radius_au] =
            path.radii(self.exact.start().position, state.position);
        OrbitElements {
            radius_au: length(state.position),
            semi_major_axis_au: now.semi_major_axis,
            eccentricity: now.eccentricity,
            specific_angular_momentum_au2_per_day: now.angular_momentum,
            specific_angular_momentum_drift_ppm: (now.angular_momentum - start.angular_momentum)
                / start.angular_momentum
                * 1e6,
            position_error_au: length(error),
            // The difference of the whole turns is exact.
            phase_error_rad: (path.turns - exact.turns) as f64 * TAU + (angle - exact.angle),
            revolutions: path.turns as f64 + angle / TAU,
            inclination_rad: now.inclination,
            longitude_of_ascending_node_rad: now.ascending_node,
            argument_of_perihelion_rad: now.argument_of_perihelion,
            true_anomaly_rad: now.true_anomaly,
            mean_anomaly_rad: bound.map_or(f64::NAN, |bound| bound.mean_anomaly),
            perihelion_distance_au: now.perihelion,
            aphelion_distance_au: bound.map_or(f64::NAN, |bound| bound.aphelion),
            period_days: bound.map_or(f64::NAN, |bound| bound.period),
            force_evaluations: self.trajectory.evaluations,
            completed_revolutions: path.revolutions.unsigned_abs(),
            last_revolution_end_days: path.last_revolution_end.unwrap_or(f64::NAN),
            min_radius_au,
            max_radius_au,
            specific_angular_momentum_drift_log10: log10_of_change(
                now.angular_momentum - start.angular_momentum,
                start.angular_momentum,
            ),
        }
    }

    /// Semi-major axis of explicit Euler at the start and after the duration, AU, to first order in the step; `None` for an open path.
    pub(super) fn grown_by_euler(
        &self,
        discretization: &Discretization,
        duration_days: f64,
    ) -> Option<[f64; 2]> {
        let elements = Elements::of(self.exact.start());
        elements.bound?;
        let grown = estimates::grown_semi_major_axis(&elements, discretization.step, duration_days);
        Some([elements.semi_major_axis, grown])
    }

    /// Describes the start in the log, and the energy gain of explicit Euler.
    pub(super) fn log_start(&self, discretization: &Discretization, frame: &mut Frame) {
        let elements = Elements::of(self.exact.start());
        let orbit = match elements.bound {
            Some(bound) => format!(
                "a = {:.5} AU, e = {:.5}, period {:.3} d",
                elements.semi_major_axis, elements.eccentricity, bound.period
            ),
            None => format!(
                "open path, e = {:.5}, perihelion {:.5} AU",
                elements.eccentricity, elements.perihelion
            ),
        };
        frame.log(Level::Info, format!("start {}; {orbit}", self.start_description));
        if let (OrbitIntegrator::ExplicitEuler, Some(bound)) =
            (discretization.integrator, elements.bound)
        {
            let gain = estimates::euler_energy_gain_per_revolution(
                &elements,
                bound.period,
                discretization.step,
            );
            frame.log(
                Level::Info,
                format!(
                    "explicit Euler adds energy in every step, initially {:.3} % per revolution: the orbit grows. \
                     \"semi-implicit-euler\" has the same cost and no drift",
                    100.0 * gain
                ),
            );
        }
    }
}

/// Rejects a start on a line through the Sun, and numbers that overflow.
fn check_start(start: State) -> Result<(), SetupError> {
    let distance = length(start.position);
    let speed = length(start.velocity);
    let elements = Elements::of(start);
    if !motion::acceleration_over_position(start.position).is_normal()
        || !elements.energy.is_finite()
    {
        return Err(SetupError::new(
            format!(
                "start: the equation of motion overflows at a distance of {distance} AU and a speed of {speed} AU/day"
            ),
            "give a position away from the Sun (the origin) in AU and a velocity in AU/day",
        ));
    }
    if elements.angular_momentum <= MAX_RADIAL_SINE * distance * speed {
        return Err(SetupError::new(
            "start: the velocity is zero or parallel to the position, so the path is a straight line through the Sun",
            "give velocity_au_per_day a component perpendicular to position_au: sqrt(GM / r) for a circle, 0.0172 AU/day at 1 AU",
        ));
    }
    if elements.energy == 0.0 {
        return Err(SetupError::new(
            "start: the energy is exactly zero (a parabola), so its relative drift is not defined",
            "change the last digit of the velocity",
        ));
    }
    Ok(())
}
