//! Analysis of DEM runs: energy balance, contacts, rebounds, beds, outlets and stress.

mod bed_shape;
mod cooling;
pub mod figures;
pub mod laws;
pub mod metrics;
pub mod observe;
mod outflow;
mod rebounds;
mod special_walls;
mod stress;
pub mod sweep;

use crate::models::contract::{Extent, ModelAnalysis};
use kinetoscope_manifest::model::ModelConfig;
use observe::DemRun;

/// The analysis of DEM runs.
pub const ANALYSIS: ModelAnalysis = ModelAnalysis {
    name: "dem",
    title: "DEM",
    metrics: metrics::ALL,
    sweep_metrics: sweep::ALL,
    fits: sweep::FITS,
    ordinates: sweep::ORDINATES,
    trade_offs: &[],
    observer: |config, snapshots| match config {
        ModelConfig::Dem(config) => Some(Box::new(DemRun::new(config.clone(), snapshots))),
        _ => None,
    },
    extent: |config| match config {
        ModelConfig::Dem(config) => Some(Extent {
            radius: config.radius_m.mean(),
            bounds: Some([[0.0, 0.0], [config.width_m.get(), config.height_m.get()]]),
        }),
        _ => None,
    },
};
