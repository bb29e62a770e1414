//! "Change and rerun": the reader changes numbers of the manifest, and the engine in the page runs it. The result is marked as the reader's, next to the
//! numbers of the recorded run.

use crate::input::coordinates::last_part;
use crate::input::key_words::words_and_unit;
use crate::metric::Measurement;
use crate::models::main_results;
use crate::report::AnalysisReport;
use crate::report::engine::{NONCE, PLAY};
use crate::report::plot_section::data;
use crate::report::replay_section::run_name;
use crate::run::RunAnalysis;
use kinetoscope_manifest::model::ModelConfig;
use kinetoscope_manifest::{json_schema, starter};
use maud::{Markup, PreEscaped, html};
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;

pub(super) const SCRIPT: &str = include_str!("rerun.js");
/// Maximum number of runs to choose from: each has its manifest in the page.
const MOST_RUNS: usize = 60;
/// What a page without a recording says before its first run.
const HINT: &str = "Press Run: the particles move here, and their numbers follow.";
/// Distance of a slider from an end that is not allowed, as a fraction of the largest value.
const OPEN_END: f64 = 0.005;
/// Maximum number of metrics that are compared.
const MOST_NUMBERS: usize = 8;

/// What the script can change.
#[derive(Serialize)]
struct Given<'a> {
    runs: Vec<Changeable<'a>>,
    /// The keys of each model's table that have a number.
    keys: BTreeMap<&'a str, BTreeMap<String, NumericKey>>,
}

/// A run that can be changed: a recorded one, or a starter, which has no numbers.
#[derive(Serialize)]
struct Changeable<'a> {
    name: String,
    manifest: &'a str,
    /// The recording.
    #[serde(skip_serializing_if = "Option::is_none")]
    file: Option<&'a str>,
    /// The keys that differ between the recorded runs.
    swept: Vec<&'a str>,
    numbers: Option<Vec<RecordedNumber<'a>>>,
    /// What the page says before the first run.
    #[serde(skip_serializing_if = "Option::is_none")]
    hint: Option<&'a str>,
}

/// The words of a key with its unit, the ends of its range, and whether it is a whole number.
type NumericKey = (String, Option<f64>, Option<f64>, bool);

/// A number of the recorded run.
#[derive(Serialize)]
struct RecordedNumber<'a> {
    name: &'a str,
    label: &'a str,
    unit: &'a str,
    value: f64,
    standard_error: Option<f64>,
}

/// What changes the runs of a report. Links are of the play page next to it, or of a page that has its engine in itself.
pub(super) fn section(report: &AnalysisReport, is_single_file: bool) -> Markup {
    let claimed = report.runs.iter().filter_map(|run| Some((run, run.claim.as_ref()?)));
    let runs: Vec<Changeable<'_>> = claimed
        .take(MOST_RUNS)
        .map(|(run, claim)| Changeable {
            name: run_name(run, &report.view),
            manifest: &claim.manifest,
            file: Some(&run.file),
            swept: run.coordinates.iter().map(|it| last_part(&it.key)).collect(),
            numbers: Some(numbers(report, run)),
            hint: None,
        })
        .collect();
    let models = report.runs.iter().map(|run| run.model().name());
    let given = Given { runs, keys: numeric_keys(models) };
    html! {
        details class="rerun" data-page=(if is_single_file { "" } else { PLAY }) hidden {
            summary { h2 { "Change and rerun" } }
            (bench(&given, "Run", &["recorded run", "run in this page", "theory for it"]))
        }
        script nonce=(NONCE) { (PreEscaped(SCRIPT)) }
    }
}

/// The same without a recording, for the engine of this hash.
pub(super) fn play(module_hash: &str) -> Markup {
    let starters = ModelConfig::NAMES.iter().filter_map(|name| {
        let (name, manifest) = ((*name).to_owned(), starter(name)?);
        Some(Changeable {
            name,
            manifest,
            file: None,
            swept: vec![],
            numbers: None,
            hint: Some(HINT),
        })
    });
    let names = ModelConfig::NAMES.iter().copied();
    let given = Given { runs: starters.collect(), keys: numeric_keys(names) };
    html! {
        section class="rerun" data-play data-page="" data-module=(module_hash) hidden {
            (bench(&given, "Start from", &["value", "theory"]))
        }
        script nonce=(NONCE) { (PreEscaped(SCRIPT)) }
    }
}

/// The fields, the manifest, and the places of the run's frames, charts and numbers.
fn bench(given: &Given<'_>, menu: &str, columns: &[&str]) -> Markup {
    html! {
        div class="setup" {
            @if given.runs.len() > 1 {
                p { label { (menu) ": " select autocomplete="off" { @for run in &given.runs { option { (run.name) } } } } }
            }
            div class="keys" {}
            details {
                summary { "Manifest" }
                label { span class="unseen" { "Manifest of the changed run" } textarea rows="16" spellcheck="false" autocomplete="off" {} }
            }
            p {
                button type="button" { "Run" } " "
                button type="button" { "Reset" } " "
                button type="button" { "Download the manifest" } " "
                button type="button" { "Copy link" } " "
                button type="button" hidden { "Download the recording" } " "
                span class="facts" { "Runs in this browser for at most 60 s and with 512 MB; nothing leaves the page." }
            }
        }
        div class="result-of-run" {
            p class="asked" {}
            p class="mark" hidden { strong { "Changed by you, not the recorded run: " } span class="changes" {} }
            p role="status" {}
            div class="outcome" {
                canvas width="480" height="480" role="img" aria-label="Particles of the changed run" hidden {}
                table hidden {
                    thead { tr { th { "quantity" } @for column in columns { th { (column) } } } }
                    tbody {}
                }
            }
            div class="plots" {}
        }
        (data("given", given))
    }
}

/// The numeric keys of models, as the schema of the manifest describes them.
fn numeric_keys<'a>(
    models: impl Iterator<Item = &'a str>,
) -> BTreeMap<&'a str, BTreeMap<String, NumericKey>> {
    let schema: Value = serde_json::from_str(&json_schema()).unwrap_or_default();
    models
        .map(|model| {
            let keys = schema["properties"]["model"]["properties"][model]["properties"].as_object();
            let keys = keys.into_iter().flatten();
            (model, keys.filter_map(|(key, of)| Some((key.clone(), numeric(key, of)?))).collect())
        })
        .collect()
}

/// A key with the range of its number; `None` for one that has none. Other forms than a number may be allowed as well.
fn numeric(key: &str, schema: &Value) -> Option<NumericKey> {
    let forms = [schema].into_iter().chain(schema["anyOf"].as_array().into_iter().flatten());
    let form =
        forms.into_iter().find(|form| form["type"] == "number" || form["type"] == "integer")?;
    let high = form["maximum"].as_f64();
    let above = || Some(form["exclusiveMinimum"].as_f64()? + OPEN_END * high?);
    let low = form["minimum"].as_f64().or_else(above);
    let name = match words_and_unit(key) {
        (words, "") => words,
        (words, unit) => format!("{words} ({unit})"),
    };
    Some((name, low, high, form["type"] == "integer"))
}

/// The numbers of a run that the answer, the checks and the model's main results name.
fn numbers<'a>(report: &AnalysisReport, run: &'a RunAnalysis) -> Vec<RecordedNumber<'a>> {
    let checked = report.metrics.iter().filter(|metric| {
        report.check_results.iter().any(|result| result.subject.starts_with(metric.name()))
    });
    let main = main_results(run.model()).metrics.iter().copied();
    let named = report.answer.metrics().chain(checked.map(|metric| metric.name())).chain(main);
    let mut found: Vec<&Measurement> = Vec::new();
    for name in named {
        let is_new = !found.iter().any(|known| known.name() == name);
        found.extend(run.measurement(name).filter(|_| is_new && found.len() < MOST_NUMBERS));
    }
    let number = |found: &'a Measurement| RecordedNumber {
        name: found.name(),
        label: found.definition.label,
        unit: found.definition.unit,
        value: found.estimate.value,
        standard_error: found.estimate.standard_error,
    };
    found.into_iter().map(number).collect()
}
