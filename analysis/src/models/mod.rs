//! The analysis of each model: one folder per model, the contract that it fulfills, and the list of all.
//!
//! To add a model, add its folder, and its `mod` line and its line in [`MODELS`] here.

pub mod contract;
pub mod figures;
pub mod series;
pub mod snapshots;

pub mod dem;
pub mod gas;
pub mod orbit;
pub mod packing;

use crate::metric::Definition;
use crate::models::contract::{Extent, ModelAnalysis, PlottedObserver};
use crate::models::snapshots::Snapshots;
use kinetoscope_manifest::model::ModelConfig;

/// The analyses of all models, in the order of the metrics reference.
pub const MODELS: &[&ModelAnalysis] =
    &[&dem::ANALYSIS, &gas::ANALYSIS, &packing::ANALYSIS, &orbit::ANALYSIS];

/// The analysis of the model with this name.
#[must_use]
pub fn of_model(name: &str) -> Option<&'static ModelAnalysis> {
    MODELS.iter().find(|model| model.name == name).copied()
}

/// The metrics of a model's runs; empty for an unknown name.
#[must_use]
pub fn metrics_of(name: &str) -> &'static [&'static Definition] {
    of_model(name).map_or(&[], |model| model.metrics)
}

/// Whether runs of a model, or a sweep over them, can have a metric of this name.
#[must_use]
pub fn is_metric(model: &str, name: &str) -> bool {
    names_of(model).any(|known| known == name)
}

/// The metric whose name is nearest to a misspelled one, if one is near.
#[must_use]
pub fn nearest_metric(model: &str, name: &str) -> Option<&'static str> {
    names_of(model)
        .map(|known| (strsim::damerau_levenshtein(known, name), known))
        .filter(|(distance, _)| *distance <= 1 + name.len() / 4)
        .min()
        .map(|(_, known)| known)
}

fn names_of(model: &str) -> impl Iterator<Item = &'static str> {
    let sweeps = of_model(model).map_or(&[][..], |model| model.sweep_metrics);
    metrics_of(model).iter().chain(sweeps).map(|definition| definition.name)
}

/// The observer of a run, with snapshots at its start, at these times, and at its end; `None` for an unregistered model.
#[must_use]
pub fn observer(config: &ModelConfig, snapshots_at: &[f64]) -> Option<Box<dyn PlottedObserver>> {
    (of_model(config.name())?.observer)(config, Snapshots::at(snapshots_at))
}

/// Size of the particles and of their container.
#[must_use]
pub fn extent(config: &ModelConfig) -> Extent {
    of_model(config.name()).and_then(|model| (model.extent)(config)).unwrap_or_default()
}

/// (x - reference) / |reference|.
fn relative_change(x: f64, reference: f64) -> f64 {
    (x - reference) / reference.abs()
}

/// The larger of two numbers, or NaN if either is NaN, so that a numerical blow-up stays visible.
fn max_or_nan(a: f64, b: f64) -> f64 {
    if a >= b || a.is_nan() { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    /// Checks and readers find a metric by its name: a model lists no name twice, and no sweep metric hides a run's.
    #[test]
    fn every_metric_name_is_unique_within_a_model() {
        for model in MODELS {
            let mut names = BTreeSet::new();
            let sweeps = MODELS.iter().flat_map(|model| model.sweep_metrics);
            for definition in model.metrics.iter().chain(sweeps) {
                assert!(names.insert(definition.name), "{}: {}", model.name, definition.name);
                assert!(definition.rounding >= 0.0);
            }
        }
    }
}
