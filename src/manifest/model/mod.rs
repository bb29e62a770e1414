//! The models: one type per model with all its physics and its duration, every value in range.
//!
//! A new model needs a file here, with a type that implements `contract::Model`, and one line in the list in
//! `config`.

mod config;
mod contract;
mod dem;
mod dem_insertion;
mod dem_materials;
mod dem_radius;
mod dem_rules;
mod dem_walls;
mod gas;
mod gas_rules;
mod gas_start;
mod gas_walls;
mod orbit;
mod packing;
mod start;
mod start_from;

pub(crate) use config::no_model;
pub use config::{CHANNELS, ModelConfig, starter};
pub use dem::{
    DemConfig, DemDashpot, DemIntegrator, Dissipation, PeriodicSides, TimeStep, UnstableTimeStep,
};
pub use dem_insertion::DemInsertion;
pub use dem_materials::{DISC, DemContactConstants, DemContactPair, DemMaterial, WALL};
pub use dem_radius::DiscRadius;
pub use dem_walls::{DemWall, DemWallShape};
pub use gas::{GasConfig, Propagation};
pub use gas_start::{
    BoltzmannConstant, GasPlacement, PositionDistribution, SpeedDistribution, SpeedScale,
    TemperatureDefinition,
};
pub use gas_walls::ThermalWall;
pub use orbit::{OrbitBody, OrbitConfig, OrbitIntegrator, OrbitStart, OrbitState, OrbitSummation};
pub use packing::{
    Boundary, CollapseGuard, InitialVelocities, PERIODIC_DIAMETERS, PackingConfig,
    PackingPlacement, PackingState, RunLength,
};
pub use start::{GivenState, Placement};
pub use start_from::{RecordedState, Recordings, StartFrom};
