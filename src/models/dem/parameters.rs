//! The constants of a run, derived from the manifest once.

use super::contacts::{ContactLaw, Dashpot};
use super::restitution;
use kinetoscope_manifest::model::{
    DemConfig, DemIntegrator, DiscRadius, Dissipation, ForceTail, TimeStep,
};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// What does not change during a run. SI units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Parameters {
    /// The box is `[0, sides[0]] x [0, sides[1]]`.
    pub(super) sides: [f64; 2],
    /// Acceleration of gravity g.
    pub(super) gravity: [f64; 2],
    /// The force law.
    pub(super) law: ContactLaw,
    /// Time step dt.
    pub(super) time_step: f64,
    /// Steps of the whole run.
    pub(super) total_steps: u64,
    /// Mean radius, that of a disc of `mass`.
    pub(super) radius: f64,
    /// Mass of a disc of the mean radius.
    pub(super) mass: f64,
    /// Mass of the smallest disc that the manifest allows: with drawn radii, the same time step in all replicates.
    pub(super) smallest_mass: f64,
    /// How far the neighbour list reaches beyond touching.
    pub(super) skin: f64,
}

/// Skin of the neighbour list over the mean radius.
const SKIN_OVER_RADIUS: f64 = 0.5;

impl Parameters {
    pub(super) fn new(config: &DemConfig) -> Self {
        let (smallest_radius, largest_radius) = radius_range(config);
        let radius = 0.5 * (smallest_radius + largest_radius);
        let mass = config.mass_kg.get();
        let smallest_mass = mass_of(smallest_radius, radius, mass);
        let stiffness = config.stiffness_n_per_m.get();
        let time_step = match config.time_step {
            TimeStep::PerContact(steps) => PI * (smallest_mass / stiffness).sqrt() / steps.get(),
            TimeStep::Fixed(step) => step.get(),
        };
        let law = ContactLaw {
            stiffness,
            dashpot: match config.dissipation {
                Dissipation::Restitution(wanted) => {
                    Dashpot::Ratio(restitution::damping_ratio(wanted.get(), config.force_tail))
                }
                Dissipation::Damping(damping) => Dashpot::Damping(damping.get()),
            },
            only_pushes: config.force_tail == ForceTail::Clamped,
            is_implicit: config.integrator == DemIntegrator::ImplicitDashpot,
        };
        Self {
            sides: [config.width_m.get(), config.height_m.get()],
            gravity: [config.gravity_m_per_s2[0].get(), config.gravity_m_per_s2[1].get()],
            law,
            time_step,
            total_steps: (config.duration_s.get() / time_step + 1e-9).floor() as u64,
            radius,
            mass,
            smallest_mass,
            skin: SKIN_OVER_RADIUS * radius,
        }
    }

    /// Effective mass of the lightest pair: two discs of the smallest mass.
    pub(super) fn lightest_pair_mass(&self) -> f64 {
        0.5 * self.smallest_mass
    }

    /// Potential energy that one kilogram can lose on its way through the whole box, J/kg.
    pub(super) fn deepest_fall(&self) -> f64 {
        self.gravity[0].abs() * self.sides[0] + self.gravity[1].abs() * self.sides[1]
    }
}

/// Smallest and largest radius that the manifest allows, m.
pub(super) fn radius_range(config: &DemConfig) -> (f64, f64) {
    match config.radius_m {
        DiscRadius::Equal(radius) => (radius.get(), radius.get()),
        DiscRadius::Uniform { min, max } => (min.get(), max.get()),
    }
}

/// Mass of a disc at the areal density at which a disc of the mean radius has the mean mass.
pub(super) fn mass_of(radius: f64, mean_radius: f64, mean_mass: f64) -> f64 {
    let ratio = radius / mean_radius;
    mean_mass * ratio * ratio
}
