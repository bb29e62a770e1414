//! Analysis of gas runs: wall pressure, speeds, collisions and conserved quantities.

pub mod figures;
pub mod kinetics;
pub mod kinetics_laws;
pub mod laws;
pub mod metrics;
pub mod observe;
pub mod sweep;

use crate::models::contract::{Extent, ModelAnalysis};
use kinetoscope_manifest::model::ModelConfig;
use observe::GasRun;

/// The analysis of gas runs.
pub const ANALYSIS: ModelAnalysis = ModelAnalysis {
    name: "gas",
    title: "Gas",
    metrics: metrics::ALL,
    sweep_metrics: sweep::ALL,
    fits: sweep::FITS,
    ordinates: sweep::ORDINATES,
    trade_offs: &[],
    observer: |config, snapshots| match config {
        ModelConfig::Gas(config) => Some(Box::new(GasRun::new(config.clone(), snapshots))),
        _ => None,
    },
    extent: |config| match config {
        ModelConfig::Gas(config) => {
            let (center, radius) = (config.center_m.map(|part| part.get()), config.radius_m.get());
            let bounds = [center.map(|c| c - radius), center.map(|c| c + radius)];
            Some(Extent { radius: 0.0, bounds: Some(bounds) })
        }
        _ => None,
    },
};
