//! The analysis of each model: one folder per model, the contract that it fulfills, and the list of all.
//!
//! To add a model, add its folder, and its `mod` line and its line in `models!` here.

pub(crate) mod contract;
pub(crate) mod figures;
pub(crate) mod flow_statistics;
pub(crate) mod hard_discs;
pub(crate) mod lyapunov;
pub(crate) mod series;
pub(crate) mod snapshots;

mod dem;
mod gas;
mod orbit;
mod packing;

use crate::metric::Definition;
use crate::models::contract::{Extent, HeightLayers, MainResults, ModelAnalysis, PlottedObserver};
use crate::models::snapshots::Snapshots;
use kinetoscope_manifest::model::ModelConfig;

/// Defines the list of models and what depends on the type of a model's configuration.
macro_rules! models {
    ($($variant:ident => $model:ident,)+) => {
        /// The analyses of all models, in the order of the metrics reference.
        pub(crate) const MODELS: &[&ModelAnalysis] = &[$(&$model::ANALYSIS),+];

        /// The observer of a run, with snapshots at its start, at these times, and at its end.
        pub(crate) fn observer(config: &ModelConfig, snapshots_at: &[f64]) -> Box<dyn PlottedObserver> {
            let snapshots = Snapshots::at(snapshots_at);
            match config {
                $(ModelConfig::$variant(config) => $model::observer(config.clone(), snapshots),)+
            }
        }

        /// What answers where neither a check nor a plot states what is asked.
        pub(crate) fn main_results(config: &ModelConfig) -> MainResults {
            match config {
                $(ModelConfig::$variant(config) => $model::main_results(config),)+
            }
        }

        /// Size of the particles and of their container.
        pub(crate) fn extent(config: &ModelConfig) -> Extent {
            match config {
                $(ModelConfig::$variant(config) => $model::extent(config),)+
            }
        }
    };
}

models! {
    Dem => dem,
    Gas => gas,
    Packing => packing,
    Orbit => orbit,
}

fn of_model(name: &str) -> Option<&'static ModelAnalysis> {
    MODELS.iter().find(|model| model.name == name).copied()
}

/// The heading of a model; `None` for an unknown name.
pub(crate) fn title_of(name: &str) -> Option<&'static str> {
    of_model(name).map(|model| model.title)
}

/// The metrics of a model's runs; empty for an unknown name.
pub(crate) fn metrics_of(name: &str) -> &'static [&'static Definition] {
    of_model(name).map_or(&[], |model| model.metrics)
}

/// The metrics of a model's runs that are 0 in every correct one; none for an unknown name.
pub(crate) fn never_in(name: &str) -> &'static [&'static Definition] {
    of_model(name).map_or(&[], |model| model.never)
}

/// Whether a metric of this model has no standard error in a single run, because other starts give other values.
#[must_use]
pub fn needs_replicates(model: &str, metric: &str) -> bool {
    of_model(model)
        .is_some_and(|model| model.needs_replicates.iter().any(|known| known.name == metric))
}

/// Whether a metric of this model follows from the states of all frames.
pub(crate) fn needs_all_states(model: &str, metric: &Definition) -> bool {
    of_model(model).is_some_and(|model| model.needs_all_states.contains(&metric))
}

/// Whether a chart of this model shows the states of all frames.
pub(crate) fn chart_needs_all_states(model: &str, stem: &str) -> bool {
    let mut charts = of_model(model).into_iter().flat_map(|model| model.figures);
    charts.any(|chart| chart.stem == stem && chart.needs_all_states)
}

/// The names of the metrics of a model's runs, and of sweeps over them; none for an unknown model.
#[must_use]
pub fn metric_names(model: &str) -> Vec<&'static str> {
    let models = of_model(model).into_iter();
    let metrics = models.flat_map(|model| model.metrics.iter().chain(model.sweep_metrics));
    metrics.map(|metric| metric.name).collect()
}

/// The charts of a model's runs that a plot may name; none for an unknown model.
#[must_use]
pub fn figure_names(model: &str) -> Vec<&'static str> {
    let charts = of_model(model).into_iter().flat_map(|model| model.figures);
    charts.map(|chart| chart.stem).collect()
}

/// The metrics that a chart of a model's runs shows; none for an unknown chart.
#[must_use]
pub fn metrics_of_figure(model: &str, stem: &str) -> &'static [&'static str] {
    let mut charts = of_model(model).into_iter().flat_map(|model| model.figures);
    charts.find(|chart| chart.stem == stem).map_or(&[], |chart| chart.metrics)
}

/// The layers of a gas in gravity with their law; `None` for other runs.
pub(crate) fn height_layers(model: &ModelConfig) -> Option<HeightLayers> {
    match model {
        ModelConfig::Gas(config) => gas::height_layers(config),
        _ => None,
    }
}

/// The label of a metric of any model.
pub(crate) fn label_of(metric: &str) -> Option<&'static str> {
    let of_model = |model: &&ModelAnalysis| model.metrics.iter().chain(model.sweep_metrics);
    let mut all = MODELS.iter().flat_map(of_model);
    all.find(|known| known.name == metric).map(|known| known.label)
}

/// The unit of a metric of any model, "1" for a pure number; `None` for an unknown metric.
#[must_use]
pub fn unit_of(metric: &str) -> Option<&'static str> {
    let of_model = |model: &&ModelAnalysis| model.metrics.iter().chain(model.sweep_metrics);
    let mut all = MODELS.iter().flat_map(of_model);
    all.find(|known| known.name == metric).map(|known| known.unit)
}

/// The swept keys along which a metric of a sweep is fitted; none for a metric of runs.
#[must_use]
pub fn fitted_along(metric: &str) -> Vec<&'static str> {
    let fits = MODELS.iter().flat_map(|model| model.fits);
    let of_metric = fits.filter(|fit| fit.parameters.iter().any(|known| known.name == metric));
    of_metric.map(|fit| fit.along).collect()
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

    /// Guarantee: every metric has a label in words, which a sentence can contain after "the": no name of a metric or of a key.
    #[test]
    fn every_metric_has_a_label_in_words() {
        for model in MODELS {
            for definition in model.metrics.iter().chain(model.sweep_metrics) {
                let label = definition.label;
                let is_word = |part: &str| !part.is_empty() && !part.contains('_');
                assert!(label.split(' ').all(is_word), "{}: {label:?}", definition.name);
                assert!(label.len() > 3 && label != definition.name, "{}", definition.name);
                let is_named = MODELS
                    .iter()
                    .flat_map(|model| model.metrics)
                    .any(|other| other.name.contains('.') && label.contains(other.name));
                assert!(!is_named && !label.ends_with('.'), "{label:?} contains a name");
                assert!(!["the ", "a ", "an "].iter().any(|it| label.starts_with(it)), "{label}");
            }
        }
    }

    #[test]
    fn main_results_of_every_starter_exist() {
        for model in MODELS {
            let text = kinetoscope_manifest::starter(model.name).unwrap();
            let experiment = kinetoscope_manifest::parse(text, model.name, &[]).unwrap();
            let main = main_results(&experiment.runs[0].manifest.model);
            assert!(!main.metrics.is_empty(), "{}", model.name);
            for name in main.metrics {
                let mut all = model.metrics.iter();
                assert!(all.any(|known| known.name == *name), "{}: {name}", model.name);
            }
            for stem in main.charts {
                let mut all = model.figures.iter();
                assert!(all.any(|known| known.stem == *stem), "{}: {stem}", model.name);
            }
        }
    }

    /// Guarantee: without a request, the plot of a run shows what its answer speaks of: a chart of the most telling result exists.
    #[test]
    fn most_telling_result_of_a_run_has_a_chart() {
        for (model, keys) in [
            ("dem", ""),
            ("dem", "discs = 1"),
            ("dem", "friction = 0.5"),
            ("dem", "remove_below_m = 0.001"),
            ("gas", ""),
            ("gas", "orifice_width_m = 0.1"),
            ("gas", "gravity_m_per_s2 = 4e5"),
            ("gas", "disc_radius_m = 0.004"),
            ("packing", ""),
            ("packing", "restitution = 0.9"),
            ("packing", "boundary = \"periodic\""),
            ("orbit", ""),
            ("orbit", "integrator = \"explicit-euler\""),
            ("orbit", "integrator = \"kepler\""),
        ] {
            let manifest = format!("[model.{model}]\n{keys}\n");
            let experiment = kinetoscope_manifest::parse(&manifest, "test", &[]).unwrap();
            let main = main_results(&experiment.runs[0].manifest.model);
            let metric = &main.metrics[0];
            let mut charts = main.charts.iter();
            assert!(charts.any(|it| metrics_of_figure(model, it).contains(metric)), "{manifest}");
        }
        let charts = figure_names("packing");
        assert!(
            charts
                .iter()
                .any(|it| metrics_of_figure("packing", it).contains(&"compressibility_factor"))
        );
    }

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
