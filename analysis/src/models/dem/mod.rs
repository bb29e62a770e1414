//! Analysis of DEM runs: energy balance, contacts, rebounds, beds, outlets and stress.

mod bed_shape;
mod contact_constants;
mod disc;
mod figures;
mod laws;
mod metrics;
mod observe;
mod rebounds;
mod special_setups;
mod stress;
mod sweep;

use crate::models::contract::{Extent, ModelAnalysis, PlottedObserver};
use crate::models::snapshots::Snapshots;
use kinetoscope_manifest::model::DemConfig;
use observe::DemRun;

/// The analysis of DEM runs.
pub(super) const ANALYSIS: ModelAnalysis = ModelAnalysis {
    name: "dem",
    title: "DEM",
    metrics: metrics::ALL,
    sweep_metrics: sweep::ALL,
    fits: sweep::FITS,
    ordinates: sweep::ORDINATES,
    trade_offs: &[],
};

/// The observer of a run.
pub(super) fn observer(config: DemConfig, snapshots: Snapshots) -> Box<dyn PlottedObserver> {
    Box::new(DemRun::new(config, snapshots))
}

/// Size of the discs and of their box.
pub(super) fn extent(config: &DemConfig) -> Extent {
    Extent {
        radius: config.radius_m.mean(),
        bounds: Some([[0.0, 0.0], [config.width_m.get(), config.height_m.get()]]),
    }
}
