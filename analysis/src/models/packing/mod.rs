//! Analysis of packing runs: temperature, velocity moments, collision rates, pressure and structure.

mod displacement;
pub mod figures;
pub mod laws;
pub mod metrics;
pub mod observe;
mod structure;
mod sweep;

use crate::models::contract::{Extent, ModelAnalysis};
use kinetoscope_manifest::model::ModelConfig;
use observe::PackingRun;

/// The analysis of packing runs.
pub const ANALYSIS: ModelAnalysis = ModelAnalysis {
    name: "packing",
    title: "Packing",
    metrics: metrics::ALL,
    sweep_metrics: &[],
    fits: &[],
    ordinates: sweep::ORDINATES,
    trade_offs: &[],
    observer: |config, snapshots| match config {
        ModelConfig::Packing(config) => Some(Box::new(PackingRun::new(config.clone(), snapshots))),
        _ => None,
    },
    extent: |config| match config {
        ModelConfig::Packing(config) => {
            let half = [config.width.get() / 2.0, config.height.get() / 2.0];
            let bounds = [half.map(|side| -side), half];
            Some(Extent { radius: config.radius.get(), bounds: Some(bounds) })
        }
        _ => None,
    },
};
