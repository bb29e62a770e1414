//! Analysis of orbit runs: one body around a fixed Sun, or several bodies that attract each other.

mod bodies;
mod figures;
mod laws;
mod metrics;
mod observe;
mod rotating_frame;
mod sweep;

use crate::models::contract::{Extent, ModelAnalysis, PlottedObserver};
use crate::models::snapshots::Snapshots;
use bodies::BodiesRun;
use kinetoscope_manifest::model::OrbitConfig;
use observe::OrbitRun;

/// The analysis of orbit runs.
pub(super) const ANALYSIS: ModelAnalysis = ModelAnalysis {
    name: "orbit",
    title: "Orbit",
    metrics: metrics::ALL,
    main: &["position_error.final", "energy.max_error_relative", "closest_approach"],
    never: &[],
    needs_replicates: &[],
    needs_all_states: metrics::NEED_ALL_STATES,
    sweep_metrics: sweep::ALL,
    fits: sweep::FITS,
    ordinates: sweep::ORDINATES,
    trade_offs: sweep::TRADE_OFFS,
    figures: figures::CHARTS,
};

/// The observer of a run around the Sun, or of several bodies.
pub(super) fn observer(config: OrbitConfig, _: Snapshots) -> Box<dyn PlottedObserver> {
    if config.bodies.is_some() {
        Box::new(BodiesRun::new(&config))
    } else {
        Box::new(OrbitRun::new(config))
    }
}

/// Points without walls.
pub(super) fn extent(_: &OrbitConfig) -> Extent {
    Extent { has_trails: true, ..Extent::default() }
}
