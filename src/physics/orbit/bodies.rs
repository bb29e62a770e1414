//! Several bodies that attract one another, in the frame of their center of mass: conserved quantities and messages.
//!
//! Energy and momenta are divided by the total mass, so that only AU and days remain: m_i is G m_i over the sum of all. Where only one
//! body has mass, its motion is uniform; energy and angular momentum are then means over the test particles, each of which keeps its own.

use super::elements::log10_of_change;
use super::encounters::{Closest, EncounterRecord, Encounters};
use super::motion::{MutualGravity, Phase, State, add_scaled, cross, dot, length};
use super::starts;
use super::trajectory::{Discretization, NotFinite, StepBudget, Trajectory};
use crate::model::SetupError;
use kinetoscope_manifest::model::{OrbitBody, OrbitIntegrator};
use kinetoscope_recording::channels::{OrbitConserved, OrbitEnergy};
use kinetoscope_recording::frame::{Frame, Level};
use kinetoscope_recording::scenery::{DrawnRadius, Scenery};
use serde::{Deserialize, Serialize};

/// Half width of the view over the maximum distance from the center of mass at the start.
const MARGIN: f64 = 1.3;

/// Bodies at one time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Bodies {
    force: MutualGravity,
    start: Conserved,
    /// AU
    view_half_width: f64,
    /// Maximum speed at the start, AU/day.
    max_speed: f64,
    pub(super) trajectory: Trajectory<Vec<f64>, EncounterRecord>,
}

/// Conserved quantities per total mass.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Conserved {
    /// AU^2/day^2.
    kinetic: f64,
    /// AU^2/day^2.
    potential: f64,
    /// AU^2/day.
    angular_momentum: [f64; 3],
    /// Sum of m |r| |v|, AU^2/day: the scale of changes of the angular momentum, which may itself be zero.
    angular_scale: f64,
    /// AU/day.
    momentum: [f64; 3],
    /// AU.
    center: [f64; 3],
    /// Minimum distance between two bodies, AU.
    min_separation: f64,
}

/// The parts of the bodies in energy and angular momentum: their parts of the mass, or equal parts of the test particles if only
/// one body has mass.
fn weights(gravitational_parameters: &[f64]) -> Vec<f64> {
    let total: f64 = gravitational_parameters.iter().sum();
    let test_particles = gravitational_parameters.iter().filter(|mass| **mass == 0.0).count();
    let is_only_mass = test_particles + 1 == gravitational_parameters.len();
    let weight = |mass: &f64| match (is_only_mass, *mass == 0.0) {
        (false, _) => mass / total,
        (true, is_test_particle) => {
            if is_test_particle {
                1.0 / test_particles as f64
            } else {
                0.0
            }
        }
    };
    gravitational_parameters.iter().map(weight).collect()
}

impl Conserved {
    /// Sums over the bodies in the order of their numbers.
    fn of(gravitational_parameters: &[f64], phase: &Phase<Vec<f64>>) -> Self {
        let total: f64 = gravitational_parameters.iter().sum();
        let (positions, _) = phase.position.as_chunks::<3>();
        let (velocities, _) = phase.velocity.as_chunks::<3>();
        let mut sums = Self {
            kinetic: 0.0,
            potential: 0.0,
            angular_momentum: [0.0; 3],
            angular_scale: 0.0,
            momentum: [0.0; 3],
            center: [0.0; 3],
            min_separation: f64::INFINITY,
        };
        let weights = weights(gravitational_parameters);
        for (i, (position, velocity)) in positions.iter().zip(velocities).enumerate() {
            let (fraction, weight) = (gravitational_parameters[i] / total, weights[i]);
            sums.kinetic += 0.5 * weight * dot(*velocity, *velocity);
            sums.angular_momentum =
                add_scaled(sums.angular_momentum, cross(*position, *velocity), weight);
            sums.angular_scale += weight * length(*position) * length(*velocity);
            sums.momentum = add_scaled(sums.momentum, *velocity, fraction);
            sums.center = add_scaled(sums.center, *position, fraction);
            for (j, other) in positions.iter().enumerate().skip(i + 1) {
                // Test particles pass through each other.
                if gravitational_parameters[i] == 0.0 && gravitational_parameters[j] == 0.0 {
                    continue;
                }
                let distance = length(add_scaled(*position, *other, -1.0));
                sums.potential -= if weight == fraction {
                    fraction * gravitational_parameters[j] / distance
                } else {
                    // One of the two is the only mass.
                    (weight * gravitational_parameters[j]
                        + weights[j] * gravitational_parameters[i])
                        / distance
                };
                sums.min_separation =
                    if distance < sums.min_separation { distance } else { sums.min_separation };
            }
        }
        sums
    }

    fn energy(&self) -> f64 {
        self.kinetic + self.potential
    }
}

impl Bodies {
    /// Whether this can be a later state of a start.
    pub(super) fn is_valid_after(&self, start: &Self) -> bool {
        self.force == start.force
            && self.start == start.start
            && self.view_half_width == start.view_half_width
            && self.max_speed == start.max_speed
            && self.trajectory.is_valid_after(&start.trajectory)
    }

    /// Bodies of the manifest, shifted so that their center of mass is at rest at the origin.
    pub(super) fn prepare(
        bodies: &[OrbitBody],
        discretization: &Discretization,
    ) -> Result<Self, SetupError> {
        let states = starts::of_bodies(bodies);
        let numbers = |of: fn(&State) -> [f64; 3]| states.iter().flat_map(of).collect();
        let gravitational_parameters: Vec<f64> =
            bodies.iter().map(|body| body.gm_au3_per_day2.get()).collect();
        let mut phase = Phase {
            position: numbers(|state| state.position),
            velocity: numbers(|state| state.velocity),
        };
        let given = Conserved::of(&gravitational_parameters, &phase);
        for axis in 0..phase.position.len() {
            phase.position[axis] -= given.center[axis % 3];
            phase.velocity[axis] -= given.momentum[axis % 3];
        }
        let start = Conserved::of(&gravitational_parameters, &phase);
        let force = MutualGravity { gravitational_parameters };
        check_start(&start, &force, &phase)?;
        let max_length = |numbers: &[f64]| {
            let lengths = numbers.as_chunks::<3>().0.iter().map(|vector| length(*vector));
            lengths.fold(0.0, |max, next| if next > max { next } else { max })
        };
        Ok(Self {
            start,
            view_half_width: MARGIN * max_length(&phase.position),
            max_speed: max_length(&phase.velocity),
            trajectory: {
                let path = EncounterRecord::at_start(&force.gravitational_parameters, &phase);
                Trajectory::new(phase, path, discretization)
            },
            force,
        })
    }

    pub(super) fn advance(
        &mut self,
        discretization: &Discretization,
        budget: StepBudget,
    ) -> Result<(), NotFinite> {
        let Self { force, trajectory, .. } = self;
        trajectory.advance(force, discretization, budget, &Encounters::of(force))
    }

    /// The closest approaches since the start.
    fn closest(&self, time: f64) -> Closest {
        let Trajectory { path, phase, .. } = &self.trajectory;
        Encounters::of(&self.force).closest(path, phase, time)
    }

    pub(super) fn observe(&self, time: f64, frame: &mut Frame) {
        let Phase { position, velocity } = &self.trajectory.phase;
        let rows = position.as_chunks::<3>().0.iter().zip(velocity.as_chunks::<3>().0);
        for ([x, y, z], [vx, vy, vz]) in rows {
            frame.push_state(&[*x, *y, *z, *vx, *vy, *vz]);
        }
        let now = Conserved::of(&self.force.gravitational_parameters, &self.trajectory.phase);
        frame.push(&OrbitEnergy {
            specific_kinetic_energy_au2_per_day2: now.kinetic,
            specific_potential_energy_au2_per_day2: now.potential,
            specific_total_energy_au2_per_day2: now.energy(),
            drift_ppm: (now.energy() - self.start.energy()) / self.start.energy().abs() * 1e6,
            drift_log10: log10_of_change(now.energy() - self.start.energy(), self.start.energy()),
        });
        let change = add_scaled(now.angular_momentum, self.start.angular_momentum, -1.0);
        let [x, y, z] = now.angular_momentum;
        frame.push(&OrbitConserved {
            specific_angular_momentum_x_au2_per_day: x,
            specific_angular_momentum_y_au2_per_day: y,
            specific_angular_momentum_z_au2_per_day: z,
            specific_angular_momentum_change_ppm: length(change) / self.start.angular_scale * 1e6,
            specific_momentum_au_per_day: length(now.momentum),
            center_of_mass_au: length(now.center),
            min_separation_au: now.min_separation,
            force_evaluations: self.trajectory.evaluations,
            specific_angular_momentum_change_log10: log10_of_change(
                length(change),
                self.start.angular_scale,
            ),
        });
        if let Some(message) = self.closest(time).message() {
            frame.push(&message);
        }
    }

    /// Warns at the end of encounters that change the orbits, or that the steps do not follow.
    pub(super) fn log_end(&self, discretization: &Discretization, time: f64, frame: &mut Frame) {
        let has_fixed_steps = discretization.integrator != OrbitIntegrator::Dop853;
        let step = has_fixed_steps.then_some(discretization.step);
        for warning in self.closest(time).warnings(step) {
            frame.log(Level::Warning, warning);
        }
    }

    pub(super) fn scenery(&self) -> Scenery {
        let half = self.view_half_width;
        let bodies = &self.force.gravitational_parameters;
        Scenery {
            walls: Vec::new(),
            view: [[-half, -half], [half, half]],
            drawn_radius: DrawnRadius::Fixed(0.02 * (2.0 * half)),
            speed_range_top: 1.5 * self.max_speed,
            speed_unit: "AU/d",
            arrows: true,
            force_range_top: None,
            trail: true,
            unused_fields: Vec::new(),
            // The manifest has no names; numbers are those of the rows of the state.
            names: (0..bodies.len()).map(|body| body.to_string()).collect(),
            central_particle: Encounters::of(&self.force).central,
        }
    }

    /// Describes the start in the log.
    pub(super) fn log_start(&self, discretization: &Discretization, frame: &mut Frame) {
        frame.log(
            Level::Info,
            format!(
                "{} bodies that attract one another, in the frame of their center of mass; energy {:.6e} AU^2/day^2 per unit mass, \
                 minimum separation {:.4} AU",
                self.force.gravitational_parameters.len(),
                self.start.energy(),
                self.start.min_separation
            ),
        );
        let parameters = &self.force.gravitational_parameters;
        let test_particles = parameters.iter().filter(|parameter| **parameter == 0.0).count();
        if test_particles + 1 == parameters.len() {
            let text = "energy and angular momentum are means over the test particles: only one body has mass";
            frame.log(Level::Info, text);
        }
        if test_particles > 0 {
            let steps = match discretization.integrator {
                OrbitIntegrator::Dop853 => {
                    "; the adaptive steps keep the tolerance for them as well, so they affect the rounding of all bodies"
                }
                _ => "; no bit of the motion of the others depends on them",
            };
            frame.log(
                Level::Info,
                format!("{test_particles} of them are test particles without mass{steps}"),
            );
        }
    }
}

/// Rejects bodies between which no motion can be followed.
fn check_start(
    start: &Conserved,
    force: &MutualGravity,
    phase: &Phase<Vec<f64>>,
) -> Result<(), SetupError> {
    let energy = start.energy();
    let (reason, help) = if let Some([one, other]) = Encounters::of(force).coinciding(phase) {
        (
            format!("bodies {one} and {other} are at the same position"),
            "change position_au or mean_anomaly_rad of one of them",
        )
    } else if !energy.is_finite() {
        let separation = start.min_separation;
        (
            format!("the energy of bodies {separation:e} AU apart overflows"),
            "move them further apart",
        )
    } else if energy == 0.0 {
        let reason = "the energy is exactly zero, so its relative drift is not defined";
        (reason.to_owned(), "change the last digit of a velocity_au_per_day")
    } else if start.angular_scale > 0.0 {
        return Ok(());
    } else {
        let reason = "no body moves relative to the others";
        (reason.to_owned(), "change velocity_au_per_day of one of them")
    };
    Err(SetupError::new(format!("bodies: no motion to follow, because {reason}"), help))
}
