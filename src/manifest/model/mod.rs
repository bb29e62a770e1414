//! One type a model: all its physics and its duration, every value in range.

mod dem;
mod gas;
mod orbit;
mod packing;

pub use dem::{DemConfig, DemIntegrator, DiscRadius, Dissipation, ForceTail, Stability, TimeStep};
pub use gas::{
    BoltzmannConstant, GasConfig, Propagation, SpeedDistribution, SpeedScale, TemperatureDefinition,
};
pub use orbit::{OrbitConfig, OrbitIntegrator, OrbitStart};
pub use packing::{InitialVelocities, PackingConfig, PackingPlacement, RunLength};

use crate::quantity::Finite;

/// The table `[model.<NAME>]`: which model, and its values.
#[derive(Clone, Debug, PartialEq)]
pub enum ModelConfig {
    /// Spring–dashpot discs in a box.
    Dem(DemConfig),
    /// Point particles in a circular container.
    Gas(GasConfig),
    /// Event-driven hard discs.
    Packing(PackingConfig),
    /// The Earth around the Sun.
    Orbit(OrbitConfig),
}

/// Positions and velocities written out in a manifest, one pair a particle, in SI units or the model's own.
#[derive(Clone, Debug, PartialEq)]
pub struct GivenState {
    /// Centres, `[x, y]` each.
    pub positions: Vec<[Finite; 2]>,
    /// Velocities, `[vx, vy]` each; as many as positions.
    pub velocities: Vec<[Finite; 2]>,
}

/// How particles are placed at the start.
#[derive(Clone, Debug, PartialEq)]
pub enum Placement {
    /// Uniformly at random, without overlap where particles have a size.
    Random,
    /// On a regular lattice (DEM only).
    Lattice,
    /// Written out.
    Given(GivenState),
}
