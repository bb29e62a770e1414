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
use kinetoscope_manifest::starter;
use maud::{Markup, PreEscaped, html};
use serde::Serialize;

pub(super) const SCRIPT: &str = include_str!("rerun.js");
/// Maximum number of runs to choose from: each has its manifest in the page.
const MOST_RUNS: usize = 60;
/// Maximum number of keys with a field.
const MOST_KEYS: usize = 8;
/// What a page without a recording says before its first run.
const HINT: &str = "Press Run: the particles move here, and their numbers follow.";
/// Maximum number of metrics that are compared.
const MOST_NUMBERS: usize = 8;

/// A run that can be changed: a recorded one, or a starter. The script finds the keys and numbers of a starter.
#[derive(Serialize)]
struct Changeable<'a> {
    name: String,
    manifest: &'a str,
    /// The keys with a number to change, and their words with the unit.
    #[serde(skip_serializing_if = "Option::is_none")]
    keys: Option<Vec<(&'a str, String)>>,
    numbers: Option<Vec<RecordedNumber<'a>>>,
    /// What the page says before the first run.
    #[serde(skip_serializing_if = "Option::is_none")]
    hint: Option<&'a str>,
}

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
            keys: Some(keys(run, &claim.manifest)),
            numbers: Some(numbers(report, run)),
            hint: None,
        })
        .collect();
    html! {
        details class="rerun" data-page=(if is_single_file { "" } else { PLAY }) hidden {
            summary { h2 { "Change and rerun" } }
            (bench(&runs, "Run", &["recorded run", "run in this page", "theory for it"]))
        }
        script nonce=(NONCE) { (PreEscaped(SCRIPT)) }
    }
}

/// The same without a recording, for the engine of this hash.
pub(super) fn play(module_hash: &str) -> Markup {
    let starters = ModelConfig::NAMES.iter().filter_map(|name| {
        let (name, manifest) = ((*name).to_owned(), starter(name)?);
        Some(Changeable { name, manifest, keys: None, numbers: None, hint: Some(HINT) })
    });
    html! {
        section class="rerun" data-play data-page="" data-module=(module_hash) hidden {
            (bench(&starters.collect::<Vec<_>>(), "Start from", &["value", "theory"]))
        }
        script nonce=(NONCE) { (PreEscaped(SCRIPT)) }
    }
}

/// The fields, the manifest, and the places of the run's frames and numbers.
fn bench(runs: &[Changeable<'_>], menu: &str, columns: &[&str]) -> Markup {
    html! {
        div class="setup" {
            @if runs.len() > 1 {
                p { label { (menu) ": " select autocomplete="off" { @for run in runs { option { (run.name) } } } } }
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
        }
        (data("given", &runs))
    }
}

/// The numbers of the model's table: the swept ones first, then those at its head.
fn keys<'a>(run: &'a RunAnalysis, manifest: &'a str) -> Vec<(&'a str, String)> {
    let model = manifest.split("[model.").nth(1).and_then(|rest| rest.split("\n[").next());
    let lines = model.unwrap_or_default().lines().filter_map(|line| line.split_once(" = "));
    let numeric = lines.filter(|(_, value)| value.parse::<f64>().is_ok_and(f64::is_finite));
    let mut keys: Vec<&str> = numeric.map(|(key, _)| key).collect();
    let is_swept = |key: &str| run.coordinates.iter().any(|it| last_part(&it.key) == key);
    // Only one integrator reads the tolerance.
    keys.sort_by_key(|key| (!is_swept(key), *key == "tolerance"));
    let named = keys.into_iter().take(MOST_KEYS).map(|key| match words_and_unit(key) {
        (words, "") => (key, words),
        (words, unit) => (key, format!("{words} ({unit})")),
    });
    named.collect()
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
