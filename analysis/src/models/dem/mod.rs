//! Analysis of DEM runs: energy balance, contacts, rebounds, beds, outlets and stress.

mod bed_shape;
mod contact_constants;
mod disc;
mod elasticity;
mod figures;
mod laws;
mod metrics;
mod observe;
mod rebounds;
mod special_setups;
mod stress;
mod sweep;

use crate::models::contract::{Extent, MainResults, ModelAnalysis, PlottedObserver};
use crate::models::snapshots::Snapshots;
use crate::plot::drawing;
use kinetoscope_manifest::model::{DemConfig, DemWall, DemWallShape, PeriodicSides};
use observe::DemRun;

/// The analysis of DEM runs.
pub(super) const ANALYSIS: ModelAnalysis = ModelAnalysis {
    name: "dem",
    title: "DEM",
    metrics: metrics::ALL,
    never: &[],
    needs_replicates: metrics::NEED_REPLICATES,
    needs_all_states: metrics::NEED_ALL_STATES,
    sweep_metrics: sweep::ALL,
    fits: sweep::FITS,
    ordinates: sweep::ORDINATES,
    trade_offs: &[],
    figures: figures::CHARTS,
};

/// The observer of a run.
pub(super) fn observer(config: DemConfig, snapshots: Snapshots) -> Box<dyn PlottedObserver> {
    Box::new(DemRun::new(config, snapshots))
}

/// What the setup is made for: cooling, a chain of impacts, an outlet, a rebound, walls that move, a heap; else the loss of energy, and the part of friction in it.
pub(super) fn main_results(config: &DemConfig) -> MainResults {
    const ENERGY: &[&str] = &["energy_balance", "energy_total_by_run"];
    const BED: &[&str] = &["surface", "energy_balance", "energy_total_by_run"];
    let at_rest = config.walls.iter().all(DemWall::is_at_rest);
    match config {
        _ if special_setups::is_free_gas(config) => {
            MainResults::new(&["cooling.rate", "granular_temperature"], &["cooling"])
        }
        _ if special_setups::row_of(config).is_some() => {
            let charts = &["row_velocities", "energy_balance", "energy_total_by_run"];
            MainResults::new(&["row.velocity_transmission"], charts)
        }
        _ if config.remove_below_m.is_some() => {
            MainResults::new(&["outlet.discharge_rate", "discs_removed"], &["discharge"])
        }
        _ if config.discs.get() == 1 && config.insertion.is_none() => {
            let charts = &["restitution_by_rebound", "energy_balance", "energy_total_by_run"];
            MainResults::new(&["restitution.measured", "energy.total_change_relative"], charts)
        }
        _ if special_setups::has_gate(config) => {
            MainResults::new(&["bed.normalized_runout", "energy.friction_fraction"], BED)
        }
        _ if !at_rest => {
            MainResults::new(&["energy.wall_work", "energy.friction_fraction"], ENERGY)
        }
        _ if config.insertion.is_some() => {
            MainResults::new(&["bed.surface_angle", "energy.friction_fraction"], BED)
        }
        // The energy of cohesion is negative, so that a relative change has no meaning.
        _ if config.has_cohesion() => {
            MainResults::new(&["settling_time", "energy.friction_fraction"], ENERGY)
        }
        _ if special_setups::has_friction(config) => {
            let metrics =
                &["energy.total_change_relative", "energy.friction_fraction", "settling_time"];
            MainResults::new(metrics, ENERGY)
        }
        _ => MainResults::new(&["energy.total_change_relative", "settling_time"], ENERGY),
    }
}

/// Size of the discs, and their box with its walls at rest.
pub(super) fn extent(config: &DemConfig) -> Extent {
    let bounds = [[0.0; 2], [config.width_m.get(), config.height_m.get()]];
    let at_rest = config.walls.iter().filter(|wall| wall.is_at_rest());
    let inner = at_rest.map(|wall| match wall.shape {
        DemWallShape::Segment { from_m, to_m } => {
            drawing::wall(vec![[from_m, to_m].map(|end| end.map(|coordinate| coordinate.get()))])
        }
        DemWallShape::Drum { center_m, radius_m, .. } => {
            drawing::circle(center_m.map(|coordinate| coordinate.get()), radius_m.get())
        }
    });
    Extent {
        radius: config.radius_m.mean(),
        bounds: Some(bounds),
        walls: [drawing::rectangle(bounds)].into_iter().chain(inner).collect(),
        has_trails: false,
        is_periodic: config.periodic != PeriodicSides::None,
        flight: None,
    }
}
