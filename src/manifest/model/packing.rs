//! `[model.packing]`: event-driven hard discs. Lengths and times are dimensionless, a disc has mass 1.

use super::GivenState;
use crate::quantity::{BoxSide, NonNegative, Positive, Share};
use std::num::NonZeroU32;

/// All physics of a packing run. The box is centred on the origin.
#[derive(Clone, Debug, PartialEq)]
pub struct PackingConfig {
    /// Number of discs n.
    pub discs: NonZeroU32,
    /// Width lx of the box.
    pub width: BoxSide,
    /// Height ly of the box.
    pub height: BoxSide,
    /// Radius of the discs, below half of the shorter side.
    pub radius: Positive,
    /// Coefficient of restitution alpha of a pair collision.
    pub restitution: Share,
    /// Variance of the angle by which a wall turns the outgoing direction, rad^2.
    pub wall_noise_variance_rad2: NonNegative,
    /// Law of the velocity components at the start.
    pub initial_velocities: InitialVelocities,
    /// When the run ends.
    pub length: RunLength,
    /// How discs are placed at the start.
    pub placement: PackingPlacement,
}

/// Law of the velocity components at the start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InitialVelocities {
    /// Normal, variance 1.
    Unmodified,
    /// Normal, variance 1/n.
    Modified,
}

/// When a packing run ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RunLength {
    /// After this many events a disc, pair and wall collisions alike.
    EventsPerDisc(NonZeroU32),
    /// After this simulated time, in the model's unit.
    Duration(Positive),
}

/// How discs are placed at the start.
#[derive(Clone, Debug, PartialEq)]
pub enum PackingPlacement {
    /// Uniformly at random without overlap (packing fraction below 0.5).
    Random,
    /// On a regular lattice.
    Lattice,
    /// Written out, with velocities.
    Given(GivenState),
}

impl Default for PackingConfig {
    /// Fifty elastic discs in a box of 40 x 40 with the document's wall noise.
    fn default() -> Self {
        Self {
            discs: const { NonZeroU32::new(50).expect("not zero") },
            width: const { BoxSide::literal(40.0) },
            height: const { BoxSide::literal(40.0) },
            radius: const { Positive::literal(1.0) },
            restitution: const { Share::literal(1.0) },
            wall_noise_variance_rad2: const { NonNegative::literal(std::f64::consts::PI / 1000.0) },
            initial_velocities: InitialVelocities::Unmodified,
            length: RunLength::EventsPerDisc(const { NonZeroU32::new(100).expect("not zero") }),
            placement: PackingPlacement::Random,
        }
    }
}
