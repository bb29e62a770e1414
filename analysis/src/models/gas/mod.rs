//! Analysis of gas runs: wall pressure, speeds, collisions and conserved quantities.

mod box_entropy;
mod boxes;
mod chi_square;
mod figures;
mod kinetics;
mod kinetics_laws;
mod laws;
mod layers;
mod metrics;
mod observe;
mod over_time;
mod scatter;
mod start;
mod state;
mod sweep;
mod wall_collisions;

use crate::models::contract::{Extent, HeightLayers, ModelAnalysis, PlottedObserver};
use crate::models::snapshots::Snapshots;
use crate::plot::drawing;
use kinetoscope_manifest::model::GasConfig;
use observe::GasRun;

/// The analysis of gas runs.
pub(super) const ANALYSIS: ModelAnalysis = ModelAnalysis {
    name: "gas",
    title: "Gas",
    metrics: metrics::ALL,
    main: &["pressure.measured", "effusion_rate", "box_entropy.change", "layers.mean_height"],
    never: &[metrics::PARTICLES_OUTSIDE],
    needs_replicates: &[],
    needs_all_states: &[],
    sweep_metrics: sweep::ALL,
    fits: sweep::FITS,
    ordinates: sweep::ORDINATES,
    trade_offs: &[],
    figures: figures::CHARTS,
};

/// The observer of a run.
pub(super) fn observer(config: GasConfig, snapshots: Snapshots) -> Box<dyn PlottedObserver> {
    Box::new(GasRun::new(config, snapshots))
}

/// The layers of a container at rest in gravity, with their law.
pub(super) fn height_layers(config: &GasConfig) -> Option<HeightLayers> {
    layers::height_layers(config)
}

/// Size of the container; the particles are points.
pub(super) fn extent(config: &GasConfig) -> Extent {
    let (center, radius) = (config.center_m.map(|part| part.get()), config.radius_m.get());
    let bounds = [center.map(|c| c - radius), center.map(|c| c + radius)];
    Extent {
        radius: config.disc_radius_m.map_or(0.0, |radius| radius.get()),
        bounds: Some(bounds),
        walls: vec![drawing::circle(center, radius)],
        has_trails: false,
    }
}
