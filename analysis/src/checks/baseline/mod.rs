//! Comparison of metrics with those of an earlier analysis, run by run (experiment, coordinates, replicate).
//!
//! | what differs | rule |
//! |---|---|
//! | nothing (same run key, same versions) | values are equal to the last digit |
//! | a version of the programs or of the physics | values are equal within the metric's rounding |
//! | the seed, or keys that are allowed to differ, of runs that draw no random numbers | values are equal within the metric's rounding |
//! | the seed, or keys that are allowed to differ | see `pair.rs` |
//! | any other key | the comparison fails |
//!
//! A tolerance of the manifest (`[[baseline]]`) replaces all rules but the first and the last. A comparison fails if it finds
//! nothing in common that could differ: no run, or no metric that is evidence; a comparison of single runs also if it would not have found a
//! change of a tenth (`sensitivity.rs`).

mod kinds;
mod pair;
mod relation;
mod replicates;
mod row;
mod runs;
mod sensitivity;
mod significance;

pub(crate) use row::BaselineRow;

use crate::checks::{CheckKind, CheckResult};
use crate::metric::{Metric, SCHEMA};
use crate::metric_files::document::{Document, MOST_RUNS, MetricEntry, ScopeEntry};
use crate::models::{main_results, metric_names, metrics_of};
use crate::run::RunAnalysis;
use kinetoscope_console::text::plural;
use kinetoscope_manifest::BaselineTolerance;
use pair::{Pair, Rule};
use relation::{Place, Relation, Relations};
use replicates::MetricsOfRuns;
use runs::Runs;
use sensitivity::Sensitivity;
use serde_json::json;
use significance::{FAMILY_LEVEL, holm};
use std::collections::{BTreeMap, BTreeSet};

/// The schema with the texts of its definition in each metric; it has all that is compared.
const WITH_TEXTS: u64 = 2;

/// What a comparison requires of a metric.
pub(crate) const EQUAL: &str = "equal to the baseline";

/// The metrics of an earlier analysis.
#[derive(Debug)]
pub(crate) struct Baseline(Document);

/// The comparison of all metrics with those of an earlier analysis.
#[derive(Debug)]
pub(crate) struct BaselineComparison {
    /// What differs between the runs, and the rule that follows from it.
    pub(crate) rules: Vec<String>,
    /// Failures that are not those of a metric: keys that differ, and runs that one analysis does not have.
    failures: Vec<(String, String)>,
    /// All metrics, the worst first.
    pub(crate) rows: Vec<BaselineRow>,
    /// Which changes would have been found, if some of the runs have another seed.
    sensitivity: Option<Sensitivity>,
}

impl Baseline {
    /// Reads a `metrics.json`.
    ///
    /// # Errors
    /// A text that is not a whole `metrics.json`, or one of another schema, with the user's next step.
    pub(crate) fn read(text: &str) -> Result<Self, String> {
        let broken = |error| format!("is not a complete metrics.json ({error})");
        let read: serde_json::Value = serde_json::from_str(text).map_err(broken)?;
        match read["schema"].as_u64() {
            Some(schema) if schema == u64::from(SCHEMA) || schema == WITH_TEXTS => {
                let document: Document = serde_json::from_value(read).map_err(broken)?;
                if document.run_count > MOST_RUNS {
                    return Err(format!(
                        "holds means of {}, and metrics are compared run by run: compare up to {MOST_RUNS} runs, such as those of a smaller sweep",
                        plural(document.run_count as u64, "run")
                    ));
                }
                Ok(Self(document))
            }
            Some(schema) => Err(format!("has schema {schema}, this version reads {SCHEMA}")),
            None => Err("is not a metrics.json, because it has no schema".to_owned()),
        }
    }

    /// The name of the experiment.
    pub(crate) fn experiment(&self) -> &str {
        &self.0.experiment
    }

    /// Compares metrics and runs, which `new` contains in the same order, with the baseline.
    ///
    /// # Errors
    /// A key in `allowed` that no manifest has.
    pub(crate) fn compare(
        &self,
        metrics: &[Metric],
        new: &Document,
        runs: &[RunAnalysis],
        tolerances: &[BaselineTolerance],
        allowed: &[String],
    ) -> Result<BaselineComparison, String> {
        let old = &self.0;
        reject_unknown_keys([old, new], allowed)?;
        let draws = |run: &RunAnalysis| run.manifest.model.draws_random_numbers();
        let draws: Vec<bool> = runs.iter().map(draws).collect();
        let relations = Relations::between(old, new, &draws, allowed);
        let [means_before, means_now] = [old, new].map(means_of);
        let is_mean_of = |name: &str, place: &Place| {
            [&means_before, &means_now].map(|means| means.contains(&(name, place.of_mean())))
        };
        let replicates = [MetricsOfRuns::of(old), MetricsOfRuns::of(new)];
        let settings = Runs::of(old, new, runs);
        let (known, definitions) = (metric_names(&old.model), metrics_of(&old.model));
        let mut now: BTreeMap<(&str, Place), (&MetricEntry, &Metric)> = new
            .metrics
            .iter()
            .zip(metrics)
            .map(|(entry, metric)| {
                ((entry.name.as_str(), Place::of_metric(entry)), (entry, metric))
            })
            .collect();
        let mut rows: Vec<BaselineRow> = Vec::new();
        for earlier in &old.metrics {
            let place = Place::of_metric(earlier);
            let found = now.remove(&(earlier.name.as_str(), place.clone()));
            let has_means = is_mean_of(&earlier.name, &place);
            let pair = Pair {
                old: Some(earlier),
                new: found.map(|(entry, _)| entry),
                has_replicates: has_means.contains(&true),
            };
            let mut tolerances = tolerances.iter();
            let definition = definitions.iter().find(|definition| definition.name == earlier.name);
            let laws = definition.map_or(&[][..], |definition| definition.laws);
            let rounding = definition.map_or(0.0, |definition| definition.rounding);
            let particles = settings.particles(&place);
            let rule = Rule {
                rounding: found.map_or(rounding, |(_, metric)| metric.rounding),
                is_conservation: found.map_or_else(
                    || laws.iter().any(|law| law.is_conservation()),
                    |(_, metric)| metric.is_of_conservation_law(),
                ),
                is_of_integrator: laws.iter().any(|law| law.is_of_integrator),
                is_of_manifest: laws.iter().any(|law| law.is_of_manifest),
                replicates: [
                    replicates[0].of_mean(pair.old, &place, particles),
                    replicates[1].of_mean(pair.new, &place, particles),
                ],
                particles,
                is_of_some_seeds: replicates
                    .iter()
                    .any(|runs| runs.is_of_some_runs(&earlier.name, &place)),
                is_saturated: settings.is_saturated(&earlier.name, &place),
                zero: settings.zero_of(&earlier.name, &place, earlier.value.unwrap_or(0.0)),
                is_identity: found.is_some_and(|(_, metric)| metric.is_of_identity()),
                tolerance: tolerances.find(|tolerance| tolerance.metric == earlier.name),
                is_known: known.contains(&earlier.name.as_str()),
                has_mean: place.replicate.is_some() && has_means == [true; 2],
            };
            rows.push(pair.compare(&place, &relations.of(&place), &rule));
        }
        for ((name, place), (entry, _)) in now {
            let has_replicates = is_mean_of(name, &place).contains(&true);
            let pair = Pair { old: None, new: Some(entry), has_replicates };
            let reason = "the baseline does not contain it";
            rows.push(pair.row(&place, None, reason));
        }
        let main = runs.first().map_or(&[][..], |run| main_results(run.model()).metrics);
        let has_replicates = !means_before.is_disjoint(&means_now);
        let failures = failures(old, new, &relations);
        Ok(BaselineComparison::of(rows, failures, &relations, has_replicates, main))
    }
}

/// Rejects a key that no manifest has.
fn reject_unknown_keys(documents: [&Document; 2], allowed: &[String]) -> Result<(), String> {
    let [_, new] = documents;
    let runs = || documents.into_iter().flat_map(|document| &document.runs);
    let is_known = |name: &String| {
        runs().flat_map(|run| run.manifest.keys()).any(|key| relation::names(name, key))
    };
    match allowed.iter().find(|name| !is_known(name)) {
        None => Ok(()),
        Some(name) => Err(format!(
            "--allow-changed {name}: no run of {} has this key; the keys are those of `manifest` in metrics.json",
            new.experiment
        )),
    }
}

/// The metrics and points of which an analysis has the mean over replicates.
fn means_of(document: &Document) -> BTreeSet<(&str, Place)> {
    let is_mean =
        |entry: &&MetricEntry| matches!(&entry.scope, ScopeEntry::Sweep { along: None, .. });
    let entries = document.metrics.iter().filter(is_mean);
    entries.map(|entry| (entry.name.as_str(), Place::of_metric(entry))).collect()
}

/// Fails the rows whose differences are significant, and states which differences would have been.
fn correct(rows: &mut [BaselineRow]) {
    let tested: Vec<usize> =
        (0..rows.len()).filter(|&index| rows[index].significance.is_some()).collect();
    let level = FAMILY_LEVEL / tested.len() as f64;
    for &index in &tested {
        let significance = rows[index].significance;
        rows[index].least_detectable = significance.and_then(|found| found.least_detectable(level));
    }
    let probability = |&index: &usize| rows[index].significance.map_or(1.0, |it| it.probability);
    let probabilities: Vec<f64> = tested.iter().map(probability).collect();
    for (&index, is_significant) in tested.iter().zip(holm(&probabilities, FAMILY_LEVEL)) {
        if is_significant {
            rows[index].passed = Some(false);
            "beyond the scatter of seeds".clone_into(&mut rows[index].reason);
        }
    }
}

/// Keys that differ, and runs that one analysis does not have.
fn failures(old: &Document, new: &Document, relations: &Relations) -> Vec<(String, String)> {
    let mut failures = Vec::new();
    for (relation, count) in relations.counts() {
        if let Relation::OtherKeys(keys) = relation {
            let runs = plural(count as u64, "run");
            failures.push((
                format!("keys of {runs}"),
                format!("{}; allow a change with --allow-changed KEY", keys.join(", ")),
            ));
        }
    }
    let places = |document: &Document| document.runs.iter().map(Place::of_run).collect::<Vec<_>>();
    let name = |place: &Place| match place.text(false) {
        text if text.is_empty() => "the run".to_owned(),
        text => format!("the run at {text}"),
    };
    let (before, now) = (places(old), places(new));
    if !before.iter().any(|place| now.contains(place)) {
        failures.push((
            "the runs".to_owned(),
            "no run is in both analyses: write the baseline again from recordings of this experiment"
                .to_owned(),
        ));
    }
    for place in before.iter().filter(|place| !now.contains(place)) {
        failures.push((name(place), "the baseline has it, and this analysis does not".to_owned()));
    }
    for run in &old.runs {
        let place = Place::of_run(run);
        let counterpart = new.runs.iter().find(|other| Place::of_run(other) == place);
        if let Some(other) = counterpart.filter(|other| other.outcome != run.outcome) {
            let finding = format!("was {}, and is now {}", run.outcome, other.outcome);
            failures.push((name(&place), finding));
        }
    }
    failures
}

/// One line per relation: how many runs have it, and the rule.
fn rules(relations: &Relations, rows: &[BaselineRow]) -> Vec<String> {
    let tested = rows.iter().filter(|row| row.significance.is_some()).count();
    let lines = relations.counts().into_iter().map(|(relation, count)| {
        let runs = plural(count as u64, "run");
        match relation {
            Relation::Same => format!("{runs}, same run key and versions: equal to the last digit"),
            Relation::OtherVersions(versions) => {
                format!("{runs}, {}: equal within rounding", versions.join(", "))
            }
            Relation::NoRandomNumbers(keys) => format!(
                "{runs} without random numbers, {}: equal within rounding",
                keys.join(", ")
            ),
            Relation::OtherSeed(keys) if tested == 0 => {
                format!("{runs}, {}: no metric has an error in both analyses", keys.join(", "))
            }
            Relation::OtherSeed(keys) => format!(
                "{runs}, {}: differences by Student's t, at a level of {FAMILY_LEVEL} for all {tested} metrics with an error (Holm)",
                keys.join(", ")
            ),
            Relation::OtherKeys(keys) => format!("{runs}, {}: not compared", keys.join(", ")),
            Relation::NoCounterpart => format!("{runs} in one of the analyses only: not compared"),
        }
    });
    lines.collect()
}

impl BaselineComparison {
    /// Decides on the rows, together with the failures that are not those of a metric.
    fn of(
        mut rows: Vec<BaselineRow>,
        mut failures: Vec<(String, String)>,
        relations: &Relations,
        has_replicates: bool,
        main: &[&str],
    ) -> Self {
        correct(&mut rows);
        rows.sort_by(|one, other| one.rank().total_cmp(&other.rank()));
        let is_failed = !failures.is_empty() || rows.iter().any(|row| row.passed == Some(false));
        if !is_failed && let Some(reason) = sensitivity::insufficiency(&rows, has_replicates) {
            failures.push(("the comparison".to_owned(), reason.to_owned()));
        }
        let has_other_seeds =
            relations.counts().keys().any(|relation| matches!(relation, Relation::OtherSeed(_)));
        let changed_keys = relations.changed_keys();
        let is_stated = has_other_seeds || !changed_keys.is_empty();
        let sensitivity = (is_stated && failures.is_empty())
            .then(|| Sensitivity::of(&rows, main, &changed_keys, has_replicates));
        Self { rules: rules(relations, &rows), failures, rows, sensitivity }
    }

    /// All rows as JSON.
    pub(crate) fn json(&self) -> serde_json::Value {
        let row = |row: &BaselineRow| {
            json!({
                "subject": row.subject,
                "unit": row.unit,
                "baseline": row.old,
                "now": row.new,
                "deviation_sigma": row.significance.map(|found| found.sigma),
                "least_detectable_change": row.least_detectable,
                "passed": row.passed,
                "reason": row.reason,
            })
        };
        let failures: Vec<_> = self
            .failures
            .iter()
            .map(|(subject, finding)| json!({ "subject": subject, "finding": finding }))
            .collect();
        let rows: Vec<_> = self.rows.iter().map(row).collect();
        let sensitivity: Vec<_> = self.sensitivity_lines().collect();
        json!({ "rules": self.rules, "failures": failures, "sensitivity": sensitivity, "rows": rows })
    }

    /// The results of all comparisons: failures, then metrics that are compared.
    pub(crate) fn check_results(&self) -> Vec<CheckResult> {
        let result = |passed, subject: &String, finding| CheckResult {
            passed,
            kind: CheckKind::Baseline,
            subject: subject.clone(),
            run: None,
            requirement: EQUAL.to_owned(),
            finding,
            file: None,
            line: 0,
            seconds: 0.0,
        };
        let failures =
            self.failures.iter().map(|(subject, finding)| result(false, subject, finding.clone()));
        let rows = self.rows.iter();
        let compared =
            rows.filter_map(|row| Some(result(row.passed?, &row.subject, row.finding())));
        let lines: Vec<&str> = self.sensitivity_lines().collect();
        let sensitivity = (!lines.is_empty()).then(|| CheckResult {
            requirement: "least changes that are found".to_owned(),
            ..result(true, &"sensitivity of the comparison".to_owned(), lines.join(". "))
        });
        failures.chain(compared).chain(sensitivity).collect()
    }

    /// Which changes would have been found, one line each.
    pub(crate) fn sensitivity_lines(&self) -> impl Iterator<Item = &str> {
        self.sensitivity.iter().flat_map(Sensitivity::lines)
    }

    /// Failures that are not those of a metric.
    pub(crate) fn failures(&self) -> &[(String, String)] {
        &self.failures
    }
}
