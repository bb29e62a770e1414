//! Analysis of packing runs: temperature, velocity moments, collision rates, pressure and structure.

mod diffusion_windows;
mod displacement;
mod distributions;
mod equilibrium;
mod exponent;
mod figures;
mod free_flights;
mod freezing;
mod gravity;
mod in_gravity;
mod laws;
mod liquid;
mod long_range;
mod mean_a2;
mod mean_free_path;
mod metrics;
mod observe;
mod scatter;
mod self_diffusion;
mod structure;
mod sweep;
mod tangent;

use crate::models::contract::{Extent, Flight, MainResults, ModelAnalysis, PlottedObserver};
use crate::models::snapshots::Snapshots;
use crate::plot::drawing;
use kinetoscope_manifest::model::{Boundary, PackingConfig, drawn_obstacles};
use observe::PackingRun;

/// The analysis of packing runs.
pub(super) const ANALYSIS: ModelAnalysis = ModelAnalysis {
    name: "packing",
    title: "Packing",
    metrics: metrics::ALL,
    never: &[],
    needs_replicates: &[],
    needs_all_states: metrics::NEED_ALL_STATES,
    sweep_metrics: &[],
    fits: &[],
    ordinates: sweep::ORDINATES,
    trade_offs: &[],
    figures: figures::CHARTS,
};

/// The observer of a run.
pub(super) fn observer(config: PackingConfig, snapshots: Snapshots) -> Box<dyn PlottedObserver> {
    Box::new(PackingRun::new(config, snapshots))
}

/// The heights of discs in gravity; the temperature of cooling discs; the collisions and the pressure of elastic ones.
pub(super) fn main_results(config: &PackingConfig) -> MainResults {
    if config.gravity.get() > 0.0 {
        return MainResults::new(&["height.mean"], &["density_by_height"]);
    }
    if config.restitution.get() < 1.0 {
        return MainResults::new(
            &["temperature.final_over_initial", "pair_collision_rate_per_disc"],
            &["temperature", "temperature_by_run"],
        );
    }
    MainResults::new(
        &["pair_collision_rate_per_disc", "compressibility_factor"],
        &["collision_rate", "pressure_over_time"],
    )
}

/// Size of the discs and of their box.
pub(super) fn extent(config: &PackingConfig) -> Extent {
    let half = [config.width.get() / 2.0, config.height.get() / 2.0];
    let bounds = [half.map(|side| -side), half];
    let (centers, radius) = config.obstacles();
    let is_periodic = config.boundary == Boundary::Periodic;
    let sides = half.map(|half| 2.0 * half);
    let drawn = drawn_obstacles(&centers, radius, sides, is_periodic);
    let obstacles = drawn.into_iter().map(|center| drawing::circle(center, radius));
    let walls = [drawing::rectangle(bounds)].into_iter().chain(obstacles).collect();
    Extent {
        radius: config.radius.get(),
        bounds: Some(bounds),
        walls,
        has_trails: false,
        is_periodic,
        flight: Some(Flight { masses: vec![1.0], gravity: config.gravity.get() }),
    }
}
