//! Analysis of orbit runs: one body around a fixed Sun, or several bodies that attract each other.

mod bodies;
mod figures;
mod laws;
mod metrics;
mod observe;
mod rotating_frame;
mod sweep;

use crate::models::contract::{Extent, MainResults, ModelAnalysis, PlottedObserver};
use crate::models::snapshots::Snapshots;
use bodies::BodiesRun;
use kinetoscope_manifest::model::{OrbitConfig, OrbitIntegrator};
use observe::OrbitRun;

/// The analysis of orbit runs.
pub(super) const ANALYSIS: ModelAnalysis = ModelAnalysis {
    name: "orbit",
    title: "Orbit",
    metrics: metrics::ALL,
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

/// The growth of explicit Euler's orbit, the period of the exact solution, and else the errors of the method; the encounters of several bodies.
pub(super) fn main_results(config: &OrbitConfig) -> MainResults {
    if config.bodies.is_some() {
        return MainResults::new(
            &["closest_approach", "energy.max_error_relative"],
            &["closest_approach", "return_distance_by_run", "energy_error_by_run", "energy_drift"],
        );
    }
    match config.integrator {
        OrbitIntegrator::ExplicitEuler => MainResults::new(
            &["semi_major_axis.growth_relative", "energy.drift_per_revolution"],
            &["semi_major_axis", "energy_error_by_run", "energy_drift"],
        ),
        OrbitIntegrator::Kepler => MainResults::new(
            &["period.measured", "third_law.ratio"],
            &["distance_from_start", "position_error_by_run"],
        ),
        _ => MainResults::new(
            &["position_error.final", "energy.max_error_relative"],
            &["position_error", "position_error_by_run"],
        ),
    }
}

/// Points without walls.
pub(super) fn extent(_: &OrbitConfig) -> Extent {
    Extent { has_trails: true, ..Extent::default() }
}
