//! The contents of `metrics.json`.

use crate::input::RUNS_TABLE;
use crate::input::coordinates::{AxisNames, CoordinateValue, value_of};
use crate::metric::deviation::ROUNDING_FRACTION;
use crate::metric::{BOUND_ONLY, Definition, Law, Metric, MetricScope, SCHEMA};
use crate::run::RunAnalysis;
use crate::statistics::{
    BY_CHANCE, DEPENDS_ON_START, NOTHING_COUNTED, SET_BY_MANIFEST, is_of_short_series,
};
use kinetoscope_console::text::json;
use kinetoscope_manifest::{Coordinate, manifest_values, unit_of_key};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The contents of `metrics.json`.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Document {
    /// Version of the layout.
    pub(crate) schema: u32,
    /// The experiment's name.
    pub(crate) experiment: String,
    /// The question that it asks; empty if none is stated.
    #[serde(default)]
    pub(crate) question: String,
    /// The answer; `None` if nothing is known that answers a question.
    #[serde(default)]
    pub(crate) answer: Option<AnswerEntry>,
    /// The model's name.
    pub(crate) model: String,
    /// Version of the program that derived the metrics.
    pub(crate) analysis_version: String,
    /// The number of runs.
    #[serde(default)]
    pub(crate) run_count: usize,
    /// The runs; empty if there are more than [`MOST_RUNS`].
    pub(crate) runs: Vec<RunEntry>,
    /// The file next to this one with one row per run; `None` from a program without Parquet.
    #[serde(default)]
    pub(crate) table: Option<String>,
    /// The definitions of the metrics, by name.
    #[serde(default)]
    pub(crate) definitions: BTreeMap<String, DefinitionEntry>,
    /// The metrics of the sweep, then those of the runs, unless these are left out.
    pub(crate) metrics: Vec<MetricEntry>,
    /// The results of the checks if the runs are left out.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) checks: Vec<CheckEntry>,
}

/// Maximum number of runs whose metrics are in the files; for more, the files hold means over replicates, fits and checks.
pub(crate) const MOST_RUNS: usize = 1000;

/// A definition in the file.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct DefinitionEntry {
    /// "1" for a fraction or ratio, empty for the model's own unit.
    pub(crate) unit: String,
    /// How the value is derived.
    source: String,
    /// The laws that give theoretical values.
    laws: Vec<LawEntry>,
}

/// A law in the file.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct LawEntry {
    /// The law and its literature.
    source: String,
    /// Where it holds; null if everywhere.
    range: Option<String>,
}

/// The result of a check in the file.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct CheckEntry {
    pub(crate) subject: String,
    pub(crate) passed: bool,
    pub(crate) finding: String,
}

/// The answer in the file.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct AnswerEntry {
    /// One or two sentences.
    pub(crate) text: String,
    /// The measured numbers in it.
    pub(crate) numbers: Vec<NumberEntry>,
}

/// A number of the answer.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct NumberEntry {
    pub(crate) metric: String,
    /// The number as the sentence contains it.
    pub(crate) text: String,
    /// Whether its checks pass; null without a check.
    pub(crate) passed: Option<bool>,
}

/// A run in the file.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct RunEntry {
    pub(crate) file: String,
    pub(crate) run_key: String,
    pub(crate) coordinates: Coordinates,
    pub(crate) replicate: u32,
    pub(crate) seed: u64,
    pub(crate) program_version: String,
    pub(crate) physics_version: u32,
    pub(crate) outcome: String,
    /// What failed.
    pub(crate) outcome_detail: Option<String>,
    pub(crate) frames: u64,
    /// The dotted keys of the run's manifest with their values as TOML.
    pub(crate) manifest: BTreeMap<String, String>,
}

/// A metric in the file.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct MetricEntry {
    pub(crate) name: String,
    /// Null if it is not finite.
    pub(crate) value: Option<f64>,
    pub(crate) unit: String,
    pub(crate) standard_error: Option<f64>,
    pub(crate) conditional_standard_error: Option<f64>,
    pub(crate) degrees_of_freedom: Option<f64>,
    pub(crate) theory: Option<TheoryEntry>,
    pub(crate) deviation_sigma: Option<f64>,
    pub(crate) applicable: bool,
    pub(crate) reason: Option<String>,
    #[serde(flatten)]
    pub(crate) scope: ScopeEntry,
}

/// The theoretical value in the file.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct TheoryEntry {
    value: Option<f64>,
    accuracy: Option<f64>,
    /// Index of the law among those of the definition.
    #[serde(default)]
    law: Option<usize>,
    in_range: bool,
}

impl TheoryEntry {
    /// The value of an exact law; `None` for another law, and outside its range.
    fn exact_value(&self) -> Option<f64> {
        self.value.filter(|_| self.in_range && self.accuracy == Some(0.0))
    }

    /// The value of a law with its accuracy; `None` for an exact law, and outside its range.
    fn bounded_value(&self) -> Option<(f64, f64)> {
        let accuracy = self.accuracy.filter(|&accuracy| self.in_range && accuracy > 0.0)?;
        Some((self.value?, accuracy))
    }
}

/// What a metric in the file describes.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum ScopeEntry {
    /// One run, by its file; the other fields are those of the run.
    Run { file: String, coordinates: Coordinates, replicate: u32, outcome: String },
    /// The mean over the replicates of a point, or a fit along an axis.
    Sweep { along: Option<String>, coordinates: Coordinates, replicates: usize },
}

/// Coordinates by the name of their axis.
pub(crate) type Coordinates = BTreeMap<String, CoordinateEntry>;

/// A coordinate with its unit: "1" for a pure number, empty for a word.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct CoordinateEntry {
    pub(crate) value: CoordinateValue,
    pub(crate) unit: String,
}

impl Document {
    /// The contents for the runs and the metrics of an experiment. The model is that of the first run; empty without a run.
    pub(crate) fn of(experiment: &str, runs: &[RunAnalysis], metrics: &[Metric]) -> Self {
        let has_runs = runs.len() <= MOST_RUNS;
        let is_listed = |metric: &&Metric| has_runs || !metric.is_of_run();
        let listed = || metrics.iter().filter(is_listed);
        let names = AxisNames::of(runs.iter().map(|run| run.coordinates.as_slice()));
        Self {
            schema: SCHEMA,
            experiment: experiment.to_owned(),
            question: String::new(),
            answer: None,
            model: runs.first().map_or("", |run| run.model().name()).to_owned(),
            analysis_version: env!("CARGO_PKG_VERSION").to_owned(),
            run_count: runs.len(),
            table: cfg!(feature = "parquet").then(|| RUNS_TABLE.to_owned()),
            runs: runs
                .iter()
                .take_while(|_| has_runs)
                .map(|run| RunEntry::of(run, &names))
                .collect(),
            definitions: listed().map(|metric| DefinitionEntry::of(metric.definition)).collect(),
            metrics: listed().map(|metric| MetricEntry::of(metric, &names)).collect(),
            checks: Vec::new(),
        }
    }

    /// The text of `metrics.json`; equal recordings give equal bytes. A terminal may show it.
    ///
    /// # Errors
    /// Errors of the serializer; none is expected.
    pub(crate) fn to_json(&self) -> serde_json::Result<String> {
        serde_json::to_string_pretty(self).map(|text| json(&text) + "\n")
    }
}

impl DefinitionEntry {
    /// The entry with its name.
    pub(crate) fn of(definition: &Definition) -> (String, Self) {
        let law = |law: &Law| LawEntry {
            source: law.to_string(),
            range: Some(law.range.to_owned()).filter(|range| !range.is_empty()),
        };
        let entry = Self {
            unit: definition.unit.to_owned(),
            source: definition.how.to_owned(),
            laws: definition.laws.iter().map(law).collect(),
        };
        (definition.name.to_owned(), entry)
    }
}

impl RunEntry {
    fn of(run: &RunAnalysis, names: &AxisNames) -> Self {
        Self {
            file: run.file.clone(),
            run_key: run.origin.run_key.clone(),
            coordinates: entries(&run.coordinates, names),
            replicate: run.manifest.replicate,
            seed: run.manifest.seed,
            program_version: run.origin.program_version.clone(),
            physics_version: run.origin.physics_version,
            outcome: run.ending.word().to_owned(),
            outcome_detail: run.ending.detail(),
            frames: run.frames,
            manifest: manifest_values(&run.manifest.canonical()).into_iter().collect(),
        }
    }
}

impl MetricEntry {
    fn of(metric: &Metric, names: &AxisNames) -> Self {
        let finite = |number: f64| Some(number).filter(|number| number.is_finite());
        let estimate = metric.estimate;
        Self {
            name: metric.name().to_owned(),
            value: finite(estimate.value),
            unit: metric.unit().to_owned(),
            standard_error: estimate.standard_error.and_then(finite),
            conditional_standard_error: estimate.conditional_standard_error.and_then(finite),
            degrees_of_freedom: estimate.degrees_of_freedom.and_then(finite),
            theory: metric.theory.map(|theory| TheoryEntry {
                value: finite(theory.value),
                accuracy: finite(theory.accuracy),
                law: theory
                    .law
                    .and_then(|law| metric.definition.laws.iter().position(|known| known == law)),
                in_range: theory.in_range(),
            }),
            deviation_sigma: metric.deviation_in_standard_errors().and_then(finite),
            applicable: metric.is_applicable(),
            reason: metric.reason_in_files(),
            scope: ScopeEntry::of(&metric.scope, names),
        }
    }
}

impl MetricEntry {
    /// Whether the value is that of its exact law, up to rounding; `None` without such a law, and for a value that scatters, as the
    /// violation of a conservation law does not.
    pub(crate) fn is_exact(&self, rounding: f64, is_conservation: bool) -> Option<bool> {
        let has_error = self.standard_error.or(self.conditional_standard_error).is_some();
        if has_error && !is_conservation {
            return None;
        }
        let theory = self.theory.as_ref()?.exact_value()?;
        let allowed = rounding.max(ROUNDING_FRACTION * theory.abs());
        Some((self.value? - theory).abs() <= allowed)
    }

    /// The value of its exact law; `None` for another law, and outside its range.
    pub(crate) fn exact_theory(&self) -> Option<f64> {
        self.theory.as_ref()?.exact_value()
    }

    /// The theoretical value; `None` outside its law's range.
    pub(crate) fn theory_in_range(&self) -> Option<f64> {
        self.theory.as_ref().filter(|theory| theory.in_range)?.value
    }

    /// The distance of a value from its law, over the law's accuracy; `None` without such a law, and for a value that scatters, as the reason
    /// for its missing error states.
    pub(crate) fn distance_over_accuracy(&self) -> Option<f64> {
        let (theory, accuracy) = self.theory.as_ref()?.bounded_value()?;
        Some((self.value? - theory).abs() / accuracy).filter(|_| self.states(BOUND_ONLY))
    }

    /// Whether the value scatters by an amount that the run is too short to tell, as the reason for its missing error states.
    pub(crate) fn has_unknown_scatter(&self) -> bool {
        self.standard_error.is_none() && self.reason.as_deref().is_some_and(is_of_short_series)
    }

    /// Whether the value differs from start to start by an amount that the run does not tell, as the reason for its missing error states.
    pub(crate) fn depends_on_start(&self) -> bool {
        self.standard_error.is_none() && self.states(DEPENDS_ON_START)
    }

    /// Whether nothing was counted, so that the value is zero by chance, as the reason for its missing error states.
    pub(crate) fn counts_nothing(&self) -> bool {
        self.standard_error.is_none() && self.states(NOTHING_COUNTED)
    }

    /// Whether the reason for a missing value states that another seed may have it.
    pub(crate) fn lacks_by_chance(&self) -> bool {
        self.value.is_none() && BY_CHANCE.iter().any(|reason| self.states(reason))
    }

    /// Whether this is a part of the reason, which a law's range may follow.
    fn states(&self, part: &str) -> bool {
        self.reason.as_deref().is_some_and(|reason| reason.contains(part))
    }

    /// Whether the manifest alone determines the value, as the reason for its missing error states.
    pub(crate) fn is_set_by_manifest(&self) -> bool {
        self.standard_error.is_none() && self.reason.as_deref() == Some(SET_BY_MANIFEST)
    }
}

impl ScopeEntry {
    fn of(scope: &MetricScope, names: &AxisNames) -> Self {
        match scope {
            MetricScope::Run(run) => Self::Run {
                file: run.file.clone(),
                coordinates: entries(&run.coordinates, names),
                replicate: run.replicate,
                outcome: run.outcome.to_owned(),
            },
            MetricScope::Sweep(sweep) => Self::Sweep {
                along: sweep.along.as_deref().map(|key| names.name(key).to_owned()),
                coordinates: entries(&sweep.coordinates, names),
                replicates: sweep.replicates,
            },
        }
    }
}

fn entries(coordinates: &[Coordinate], names: &AxisNames) -> Coordinates {
    let entry = |coordinate: &Coordinate| CoordinateEntry {
        value: value_of(coordinate),
        unit: unit_of_key(&coordinate.key).to_owned(),
    };
    let named = coordinates.iter().map(|it| (names.name(&it.key).to_owned(), entry(it)));
    named.collect()
}
