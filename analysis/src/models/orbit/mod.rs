//! Analysis of orbit runs: one body around a fixed Sun, or several bodies that attract each other.

mod bodies;
mod bodies_figures;
pub mod figures;
pub mod laws;
pub mod metrics;
pub mod observe;
pub mod sweep;

use crate::models::contract::{Extent, ModelAnalysis};
use bodies::BodiesRun;
use kinetoscope_manifest::model::ModelConfig;
use observe::OrbitRun;

/// The analysis of orbit runs.
pub const ANALYSIS: ModelAnalysis = ModelAnalysis {
    name: "orbit",
    title: "Orbit",
    metrics: metrics::ALL,
    sweep_metrics: sweep::ALL,
    fits: sweep::FITS,
    ordinates: sweep::ORDINATES,
    trade_offs: sweep::TRADE_OFFS,
    observer: |config, _| match config {
        ModelConfig::Orbit(config) if config.bodies.is_some() => {
            Some(Box::new(BodiesRun::new(config)))
        }
        ModelConfig::Orbit(config) => Some(Box::new(OrbitRun::new(config.clone()))),
        _ => None,
    },
    extent: |config| match config {
        ModelConfig::Orbit(_) => Some(Extent::default()),
        _ => None,
    },
};
