//! `[model.dem]`: discs with spring–dashpot contacts in a box.

use super::Placement;
use crate::quantity::{Finite, NonNegative, Positive, Share};
use std::num::NonZeroU32;

/// All physics of a DEM run. The box is `[0, width] x [0, height]`.
#[derive(Clone, Debug, PartialEq)]
pub struct DemConfig {
    /// Number of discs.
    pub discs: NonZeroU32,
    /// Mass of a disc of the mean radius, kg; the areal density is the same for all discs.
    pub mass_kg: Positive,
    /// Radius of the discs, m.
    pub radius_m: DiscRadius,
    /// Width of the box, m.
    pub width_m: Positive,
    /// Height of the box, m.
    pub height_m: Positive,
    /// Acceleration of gravity, m/s^2.
    pub gravity_m_per_s2: [Finite; 2],
    /// Stiffness k of the contact spring, N/m.
    pub stiffness_n_per_m: Positive,
    /// The dashpot, by what is wanted or by what it is.
    pub dissipation: Dissipation,
    /// What the force does where the dashpot would pull.
    pub force_tail: ForceTail,
    /// How the equation of motion is discretised.
    pub integrator: DemIntegrator,
    /// The time step, by contacts or in seconds.
    pub time_step: TimeStep,
    /// What an unstable time step leads to.
    pub stability: Stability,
    /// How discs are placed at the start.
    pub placement: Placement,
    /// Simulated time, s.
    pub duration_s: Positive,
}

/// The discs' radius, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DiscRadius {
    /// All equal.
    Equal(Positive),
    /// Uniform between two bounds, `min <= max`.
    Uniform {
        /// Smallest radius, m.
        min: Positive,
        /// Largest radius, m.
        max: Positive,
    },
}

/// The dashpot of a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Dissipation {
    /// Coefficient of restitution e; the damping follows for each pair from its effective mass.
    Restitution(Share),
    /// Damping eta itself, N s/m, the same for every contact.
    Damping(NonNegative),
}

/// What the contact force does at the end of a contact, where the dashpot outweighs the spring.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ForceTail {
    /// It pulls until the discs part.
    Attractive,
    /// It is zero: a contact only pushes.
    Clamped,
}

/// Time-stepping scheme of the DEM.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DemIntegrator {
    /// The source document's equation (3).
    SemiImplicitEuler,
    /// Half kick, drift, half kick.
    VelocityVerlet,
    /// The dashpot solved implicitly, contact by contact: stable at any damping, exact for isolated pairs only.
    ImplicitDashpot,
}

/// The time step of the DEM.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TimeStep {
    /// The source document's N_t: dt = pi sqrt(m/k) / N_t, m the smallest disc's mass (equation 2).
    PerContact(Positive),
    /// In seconds.
    Fixed(Positive),
}

/// What a time step beyond the stability bounds leads to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stability {
    /// The run is refused before its first step.
    Refuse,
    /// The run goes on, with a warning in its log.
    Warn,
}

impl Default for DemConfig {
    /// The document's values where they can be integrated: e = 0.5 in place of eta = 1.5e3, the listing's radius.
    fn default() -> Self {
        Self {
            discs: const { NonZeroU32::new(20).expect("not zero") },
            mass_kg: const { Positive::literal(1e-3) },
            radius_m: DiscRadius::Equal(const { Positive::literal(5e-4) }),
            width_m: const { Positive::literal(0.04) },
            height_m: const { Positive::literal(0.04) },
            gravity_m_per_s2: const { [Finite::literal(0.0), Finite::literal(-9.81)] },
            stiffness_n_per_m: const { Positive::literal(5e4) },
            dissipation: Dissipation::Restitution(const { Share::literal(0.5) }),
            force_tail: ForceTail::Attractive,
            integrator: DemIntegrator::SemiImplicitEuler,
            time_step: TimeStep::PerContact(const { Positive::literal(20.0) }),
            stability: Stability::Refuse,
            placement: Placement::Random,
            duration_s: const { Positive::literal(1.0) },
        }
    }
}
