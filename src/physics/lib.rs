//! The physics of Kinetoscope: four models behind one trait, [`model::Model`].
//!
//! Each model is a folder that imports no other model; `motion.rs` holds its equation of motion with the formula above the code.
//! A model is registered once, in `models!` below. Nothing here depends on files, the command line, the clock or the number of threads, so results have the same bits everywhere.

mod cell_grid;
mod cell_lists;
pub mod collision_time;
pub mod constants;
pub mod dem;
mod event_record;
pub mod gas;
mod memory;
pub mod model;
pub mod orbit;
pub mod packing;
pub mod placement;
pub mod random;
mod restart_state;
mod short_number;
pub mod simd;
pub mod sum;
mod twins;

use crate::model::{Model, ModelKind, Proceed, SetupError};
use crate::random::Seed;
use crate::twins::Twins;
use kinetoscope_manifest::model::ModelConfig;
use kinetoscope_recording::checkpoint;
use kinetoscope_recording::frame::StateColumn;

/// Registers the models: one line per model, its variant of [`ModelConfig`] and its type.
macro_rules! models {
    ($($variant:ident => $model:ty),+ $(,)?) => {
        /// The properties of every model.
        #[must_use]
        pub fn kinds() -> Vec<&'static ModelKind> {
            vec![$(<$model>::kind()),+]
        }

        /// The properties that all runs of the configured model share.
        #[must_use]
        pub fn kind_of(config: &ModelConfig) -> &'static ModelKind {
            match config {
                $(ModelConfig::$variant(_) => <$model>::kind(),)+
            }
        }

        /// Columns of a particle's row in the state of the configured run.
        #[must_use]
        pub fn state_columns_of(config: &ModelConfig) -> &'static [StateColumn] {
            match config {
                $(ModelConfig::$variant(config) => <$model>::state_columns(config),)+
            }
        }

        /// Builds the configured model at its start.
        ///
        /// # Errors
        /// As [`Model::prepare`].
        pub fn prepare(
            config: &ModelConfig,
            seed: Seed,
            opt_in: bool,
        ) -> Result<Box<dyn Model>, SetupError> {
            prepare_while(config, seed, opt_in, &|_| true)
        }

        /// Builds the configured model at its start, unless `proceed` returns `false` before it is complete.
        ///
        /// # Errors
        /// As [`Model::prepare_while`].
        pub fn prepare_while(
            config: &ModelConfig,
            seed: Seed,
            opt_in: bool,
            proceed: Proceed<'_>,
        ) -> Result<Box<dyn Model>, SetupError> {
            match config {
                $(ModelConfig::$variant(config) => {
                    Ok(Box::new(<$model>::prepare_while(config, seed, opt_in, proceed)?))
                })+
            }
        }

        /// Restores the configured model from a checkpoint's bytes; `None` if they are damaged, or if the state is impossible.
        #[must_use]
        pub fn restore(config: &ModelConfig, bytes: &[u8]) -> Option<Box<dyn Model>> {
            match config {
                $(ModelConfig::$variant(config) => {
                    let model = checkpoint::decode_content::<$model>(bytes)?;
                    if model.is_valid_for(config) { Some(Box::new(model)) } else { None }
                })+
            }
        }
    };
}

/// Builds the configured model at its start with a twin from which it diverges; a model whose particles cannot be displaced, without one.
///
/// # Errors
/// As [`Model::prepare_while`].
pub fn prepare_with_twin(
    config: &ModelConfig,
    seed: Seed,
    opt_in: bool,
    proceed: Proceed<'_>,
) -> Result<Box<dyn Model>, SetupError> {
    Ok(match config {
        ModelConfig::Dem(config) => {
            Box::new(Twins::of(dem::Dem::prepare_while(config, seed, opt_in, proceed)?))
        }
        ModelConfig::Orbit(config) => {
            Box::new(Twins::of(orbit::Orbit::prepare_while(config, seed, opt_in, proceed)?))
        }
        _ => prepare_while(config, seed, opt_in, proceed)?,
    })
}

/// Restores a model that was built with a twin, as [`restore`] does.
#[must_use]
pub fn restore_with_twin(config: &ModelConfig, bytes: &[u8]) -> Option<Box<dyn Model>> {
    match config {
        ModelConfig::Dem(config) => Twins::<dem::Dem>::restored(config, bytes),
        ModelConfig::Orbit(config) => Twins::<orbit::Orbit>::restored(config, bytes),
        _ => restore(config, bytes),
    }
}

models! {
    Dem => dem::Dem,
    Gas => gas::Gas,
    Packing => packing::Packing,
    Orbit => orbit::Orbit,
}
