//! Frames to numbers: one file a model. Frames come one after the other; only scalars of them are kept.

mod bodies;
pub mod dem;
mod displacement;
pub mod gas;
pub mod gas_kinetics;
pub mod orbit;
pub mod packing;
mod pictures;
mod rebounds;
pub(crate) mod scenes;
mod series;
pub(crate) mod stress;
mod structure;

pub use pictures::{Pictures, Placed, Snapshot};
pub use series::Series;

use crate::figures::Figures;
use crate::measurement::Measurement;
use kinetoscope_manifest::model::ModelConfig;
use kinetoscope_recording::error::ReadError;
use kinetoscope_recording::reader::{RecordedFrame, StateTable};

/// Watches the frames of one run and then tells what was seen.
pub trait Observer {
    /// Takes in the next frame.
    ///
    /// # Errors
    /// A message that can't be decoded.
    fn see(&mut self, frame: RecordedFrame) -> Result<(), ReadError>;

    /// The run's numbers; those whose channels were not recorded are left out.
    fn measurements(&self) -> Vec<Measurement>;

    /// The run's plots.
    fn figures(&self) -> Figures;
}

/// The observer of a model, with pictures at its start, at these times, and at its end.
#[must_use]
pub fn observer(config: &ModelConfig, pictures_at: &[f64]) -> Box<dyn Observer> {
    let pictures = Pictures::at(pictures_at);
    match config {
        ModelConfig::Dem(config) => Box::new(dem::DemRun::new(config.clone(), pictures)),
        ModelConfig::Gas(config) => Box::new(gas::GasRun::new(config.clone(), pictures)),
        ModelConfig::Packing(config) => {
            Box::new(packing::PackingRun::new(config.clone(), pictures))
        }
        ModelConfig::Orbit(config) if config.bodies.is_some() => {
            Box::new(bodies::BodiesRun::new(config))
        }
        ModelConfig::Orbit(config) => Box::new(orbit::OrbitRun::new(config.clone())),
    }
}

/// (x - reference) / |reference|.
fn relative_change(x: f64, reference: f64) -> f64 {
    (x - reference) / reference.abs()
}
