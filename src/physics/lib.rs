//! The physics of Kinetoscope: four models behind one trait, [`model::Model`].
//!
//! Each model is a folder that imports no other model; `motion.rs` holds its equation of motion with the formula above the code.
//! Nothing here depends on files, the command line, the clock or the number of threads, so results have the same bits everywhere.

mod cell_grid;
mod cell_lists;
pub mod collision_time;
pub mod constants;
pub mod dem;
pub mod gas;
mod memory;
pub mod model;
pub mod orbit;
pub mod packing;
pub mod placement;
pub mod random;
mod restart_state;
pub mod simd;
pub mod sum;

use crate::model::Model;
use kinetoscope_manifest::model::ModelConfig;

/// Something that is done alike for every model: one generic function, called with the model's type.
pub trait ForModel {
    /// What comes of it.
    type Output;

    /// Does it for one model.
    fn call<M: Model>(self, config: &M::Config) -> Self::Output;
}

/// Calls `action` with the model that `config` names.
pub fn with_model<A: ForModel>(config: &ModelConfig, action: A) -> A::Output {
    match config {
        ModelConfig::Dem(config) => action.call::<dem::Dem>(config),
        ModelConfig::Gas(config) => action.call::<gas::Gas>(config),
        ModelConfig::Packing(config) => action.call::<packing::Packing>(config),
        ModelConfig::Orbit(config) => action.call::<orbit::Orbit>(config),
    }
}

/// The version of a model's physics.
#[must_use]
pub fn physics_version(config: &ModelConfig) -> u32 {
    struct Action;
    impl ForModel for Action {
        type Output = u32;
        fn call<M: Model>(self, _: &M::Config) -> u32 {
            M::PHYSICS_VERSION
        }
    }
    with_model(config, Action)
}
