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

use crate::models::contract::{
    Extent, Flight, HeightLayers, MainResults, ModelAnalysis, PlottedObserver,
};
use crate::models::snapshots::Snapshots;
use crate::plot::drawing;
use kinetoscope_manifest::model::{GasConfig, SpeedDistribution};
use observe::GasRun;

/// The analysis of gas runs.
pub(super) const ANALYSIS: ModelAnalysis = ModelAnalysis {
    name: "gas",
    title: "Gas",
    metrics: metrics::ALL,
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

/// What the container is made for: effusion, a free expansion, a compression, a thermal wall, gravity, or collisions of discs; else the pressure.
pub(super) fn main_results(config: &GasConfig) -> MainResults {
    let opens = config.partition.is_some_and(|partition| partition.opens_s.is_some());
    match config {
        _ if config.orifice_width_m.is_some() => {
            MainResults::new(&["effusion_rate"], &["escaped_over_time"])
        }
        _ if opens => MainResults::new(&["box_entropy.change"], &["box_entropy_over_time"]),
        _ if config.wall_speed_m_per_s.get() != 0.0 => MainResults::new(
            &["temperature.mean_square", "adiabatic_invariant"],
            &["temperature_over_time"],
        ),
        _ if config.thermal_wall.is_some() => {
            MainResults::new(&["temperature.thermalized"], &["temperature_over_time"])
        }
        _ if config.gravity_m_per_s2.get() > 0.0 => {
            MainResults::new(&["layers.mean_height"], &["density_by_height"])
        }
        _ if config.disc_radius_m.is_some() => {
            let metrics = match config.speed_distribution {
                SpeedDistribution::Maxwell => {
                    &["pressure.measured", "pair_collision_rate_per_disc"]
                }
                _ => &["relative_entropy", "pair_collision_rate_per_disc"],
            };
            MainResults::new(metrics, &["h_over_time", "pressure_over_time"])
        }
        _ => MainResults::new(&["pressure.measured"], &["pressure_over_time"]),
    }
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
        is_periodic: false,
        flight: Some(Flight {
            masses: std::iter::once(&config.mass_kg)
                .chain(&config.additional_masses_kg)
                .map(|mass| mass.get())
                .collect(),
            gravity: 0.0,
        }),
    }
}
