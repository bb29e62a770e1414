//! Comparison of metrics with those of an earlier analysis, run by run (experiment, coordinates, replicate).
//!
//! | what differs | rule |
//! |---|---|
//! | nothing (same run key, same versions) | values are equal to the last digit |
//! | a version of the programs or of the physics | values are equal within the metric's rounding |
//! | the seed, or keys that are allowed to differ | the difference is not significant by Student's t, with Holm's correction; a value that was that of its exact law still is; the violation of a conservation law is not compared |
//! | any other key | the comparison fails |
//!
//! A tolerance of the manifest (`[[baseline]]`) replaces the second and the third rule. A comparison of no run, or of no
//! metric, fails.

mod relation;
mod significance;

pub(crate) use significance::Significance;

use crate::checks::{CheckKind, CheckResult, digits};
use crate::metric::deviation::ROUNDING_FRACTION;
use crate::metric::{Metric, SCHEMA};
use crate::metric_files::document::{Document, MetricEntry};
use crate::models::metric_names;
use kinetoscope_console::text::plural;
use kinetoscope_manifest::BaselineTolerance;
use relation::{Place, Relation, Relations};
use serde_json::json;
use significance::{FAMILY_LEVEL, Sample, holm};
use std::collections::BTreeMap;

/// Why a comparison in which no metric passes or fails is a failure, and what to do.
const NOTHING_COMPARED: &str = "undecided: no metric is compared, because none has a standard error in both analyses: record several \
     replicates in both, or set a relative_tolerance in [[baseline]]";

/// Why the violation of a conservation law is not compared between seeds.
const VIOLATION_COMPARED: &str = "the violation of a conservation law is no random deviation: set a relative_tolerance in [[baseline]]";

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
}

/// One metric in both analyses.
#[derive(Clone, Debug)]
pub(crate) struct BaselineRow {
    /// The metric and its run or part of the sweep.
    pub(crate) subject: String,
    /// The metric's unit.
    pub(crate) unit: String,
    /// The earlier value.
    pub(crate) old: Option<f64>,
    /// The value now.
    pub(crate) new: Option<f64>,
    /// The significance of the difference, if both values have a standard error and are of different seeds.
    pub(crate) significance: Option<Significance>,
    /// Whether the metric passes; `None` if it is not compared.
    pub(crate) passed: Option<bool>,
    /// Why.
    pub(crate) reason: String,
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
            Some(schema) if schema == u64::from(SCHEMA) => {
                serde_json::from_value(read).map(Self).map_err(broken)
            }
            Some(schema) => Err(format!("has schema {schema}, this version reads {SCHEMA}")),
            None => Err("is not a metrics.json, because it has no schema".to_owned()),
        }
    }

    /// The name of the experiment.
    pub(crate) fn experiment(&self) -> &str {
        &self.0.experiment
    }

    /// Compares metrics, which `new` contains in the same order, with the baseline.
    ///
    /// # Errors
    /// A key in `allowed` that no manifest has.
    pub(crate) fn compare(
        &self,
        metrics: &[Metric],
        new: &Document,
        tolerances: &[BaselineTolerance],
        allowed: &[String],
    ) -> Result<BaselineComparison, String> {
        let old = &self.0;
        for name in allowed {
            let mut manifests =
                old.runs.iter().chain(&new.runs).flat_map(|run| run.manifest.keys());
            if !manifests.any(|key| relation::names(name, key)) {
                return Err(format!(
                    "--allow-changed {name}: no run of {} has this key; the keys are those of `manifest` in metrics.json",
                    new.experiment
                ));
            }
        }
        let relations = Relations::between(old, new, allowed);
        let known = metric_names(&old.model);
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
            let pair = Pair { old: Some(earlier), new: found.map(|(entry, _)| entry) };
            let mut tolerances = tolerances.iter();
            let rule = Rule {
                rounding: found.map_or(0.0, |(_, metric)| metric.rounding),
                is_conservation: found.is_some_and(|(_, metric)| metric.is_of_conservation_law()),
                tolerance: tolerances.find(|tolerance| tolerance.metric == earlier.name),
                is_known: known.contains(&earlier.name.as_str()),
            };
            rows.push(pair.compare(&place, &relations.of(&place), &rule));
        }
        for ((_, place), (entry, _)) in now {
            let pair = Pair { old: None, new: Some(entry) };
            let reason = "the baseline does not contain it";
            rows.push(pair.row(&place, None, reason));
        }
        correct(&mut rows);
        rows.sort_by(|one, other| one.rank().total_cmp(&other.rank()));
        let mut failures = failures(old, new, &relations);
        if failures.is_empty() && rows.iter().all(|row| row.passed.is_none()) {
            failures.push(("the comparison".to_owned(), NOTHING_COMPARED.to_owned()));
        }
        Ok(BaselineComparison { rules: rules(&relations, &rows), failures, rows })
    }
}

/// A metric in both analyses; at least one of them has it.
#[derive(Clone, Copy)]
struct Pair<'a> {
    old: Option<&'a MetricEntry>,
    new: Option<&'a MetricEntry>,
}

/// What a metric may differ by.
struct Rule<'a> {
    /// A difference below this is a rounding error.
    rounding: f64,
    /// Whether its law is a conservation law.
    is_conservation: bool,
    /// The tolerance of the manifest.
    tolerance: Option<&'a BaselineTolerance>,
    /// Whether this program derives such a metric.
    is_known: bool,
}

impl Pair<'_> {
    fn row(&self, place: &Place, passed: Option<bool>, reason: impl Into<String>) -> BaselineRow {
        let entry = self.new.or(self.old);
        let name = entry.map_or("", |entry| entry.name.as_str());
        let at = place.text();
        BaselineRow {
            subject: if at.is_empty() { name.to_owned() } else { format!("{name} at {at}") },
            unit: entry.map_or_else(String::new, |entry| entry.unit.clone()),
            old: self.old.and_then(|old| old.value),
            new: self.new.and_then(|new| new.value),
            significance: None,
            passed,
            reason: reason.into(),
        }
    }

    /// Compares the values by the rule that follows from what the runs differ in. A row that is compared by statistics passes
    /// until all are known.
    fn compare(&self, place: &Place, relation: &Relation, rule: &Rule<'_>) -> BaselineRow {
        let row = |passed, reason: &str| self.row(place, passed, reason);
        match relation {
            Relation::OtherKeys(_) => return row(None, "its runs differ in other keys"),
            Relation::NoCounterpart => return row(None, "its runs are not those of the baseline"),
            _ => {}
        }
        let Some((old, new)) = self.old.zip(self.new) else {
            let lacks = "this analysis does not have it";
            // Whether a metric applies may depend on the seed, but not whether the program has it.
            let may_lack = matches!(relation, Relation::OtherSeed(_)) && rule.is_known;
            return row(if may_lack { None } else { Some(false) }, lacks);
        };
        let (Some(before), Some(value)) = (old.value, new.value) else {
            let is_same = old.value == new.value;
            return row(
                Some(is_same),
                new.reason.as_deref().unwrap_or("one of the values is missing"),
            );
        };
        let difference = (value - before).abs();
        let rounding = rule.rounding.max(ROUNDING_FRACTION * before.abs());
        match (relation, rule.tolerance) {
            (Relation::Same, _) if value.to_bits() == before.to_bits() || value == before => {
                row(Some(true), "equal")
            }
            (Relation::Same, _) => row(Some(false), "not equal, although the run is the same"),
            (_, Some(tolerance)) => {
                let allowed = tolerance.relative_tolerance;
                let passed = difference <= allowed * before.abs();
                row(Some(passed), &format!("tolerance {allowed} of the baseline"))
            }
            (Relation::OtherVersions(versions), None) => {
                let passed = difference <= rounding;
                let versions = versions.join(", ");
                let beyond = format!("beyond rounding ({versions})");
                row(Some(passed), if passed { "equal up to rounding" } else { &beyond })
            }
            // Conservation laws hold for every seed.
            _ if old.is_exact(rule.rounding, rule.is_conservation) == Some(true) => {
                match new.is_exact(rule.rounding, rule.is_conservation) {
                    Some(true) => {
                        row(Some(true), "equal to its exact law up to rounding, as before")
                    }
                    Some(false) => {
                        row(Some(false), "no longer equal to its exact law up to rounding")
                    }
                    None => row(None, "its exact law no longer applies"),
                }
            }
            _ if rule.is_conservation => row(None, VIOLATION_COMPARED),
            _ => self.by_statistics(place, [before, value], rounding),
        }
    }

    /// The significance of a difference between other seeds.
    fn by_statistics(
        &self,
        place: &Place,
        [before, value]: [f64; 2],
        rounding: f64,
    ) -> BaselineRow {
        let sample = |entry: Option<&MetricEntry>, value| {
            let entry = entry?;
            let (error, degrees_of_freedom) = (entry.standard_error?, entry.degrees_of_freedom);
            Some(Sample { value, error, degrees_of_freedom })
        };
        let Some((one, other)) = sample(self.old, before).zip(sample(self.new, value)) else {
            let reason = self.new.and_then(|new| new.reason.as_deref());
            return self.row(place, None, reason.unwrap_or("no standard error"));
        };
        let is_rounding = (value - before).abs() <= rounding;
        let significance =
            if is_rounding { Significance::none() } else { Significance::of(one, other) };
        let reason =
            if is_rounding { "equal up to rounding" } else { "within the scatter of seeds" };
        BaselineRow { significance: Some(significance), ..self.row(place, Some(true), reason) }
    }
}

/// Fails the rows whose differences are significant.
fn correct(rows: &mut [BaselineRow]) {
    let tested: Vec<usize> =
        (0..rows.len()).filter(|&index| rows[index].significance.is_some()).collect();
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
    let name = |place: &Place| match place.text() {
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

impl BaselineRow {
    /// The difference, if both values are known.
    pub(crate) fn difference(&self) -> Option<f64> {
        Some(self.new? - self.old?)
    }

    /// The order of the rows: failures first, then by significance, then by relative difference; what is not compared is last.
    fn rank(&self) -> f64 {
        let class = match self.passed {
            Some(false) => 0.0,
            Some(true) => 10.0,
            None => 20.0,
        };
        let relative = self.difference().map_or(0.0, |difference| {
            let size = self.old.unwrap_or(0.0).abs().max(self.new.unwrap_or(0.0).abs());
            if difference == 0.0 { 0.0 } else { difference.abs() / size }
        });
        // Both terms are from 0 to 1 and fall with the size of the difference.
        let significance = self.significance.map_or(0.0, |it| 1.0 / (1.0 + it.sigma));
        class + 3.0 * significance + 1.0 / (1.0 + relative)
    }

    /// The significance as text, such as "5.1 σ (t, 2 degrees of freedom)"; empty if there is none.
    pub(crate) fn sigma_text(&self) -> String {
        self.significance.map_or_else(String::new, |it| it.text())
    }

    /// The row in words, without its subject.
    pub(crate) fn finding(&self) -> String {
        let value = |value: Option<f64>| {
            value.map_or_else(|| "none".to_owned(), |value| self.in_unit(value))
        };
        let sigma = self.sigma_text();
        let sigma = if sigma.is_empty() { sigma } else { format!(", {sigma}") };
        let difference = self.difference().map_or_else(String::new, |difference| {
            format!(", difference {}", self.in_unit(difference))
        });
        let (old, new) = (value(self.old), value(self.new));
        format!("{new}, baseline {old}{difference}{sigma}: {}", self.reason)
    }

    fn in_unit(&self, value: f64) -> String {
        match self.unit.as_str() {
            "" | "1" => digits(value),
            unit => format!("{} {unit}", digits(value)),
        }
    }
}

impl Significance {
    /// The significance as text, such as "5.1 σ (t, 2 degrees of freedom)".
    pub(crate) fn text(self) -> String {
        let sigma = match self.sigma {
            sigma if sigma < 37.0 => format!("{sigma:.1} σ"),
            _ => "over 37 σ".to_owned(),
        };
        match self.degrees_of_freedom {
            Some(freedom) => format!("{sigma} (t, {freedom:.0} degrees of freedom)"),
            None => sigma,
        }
    }
}

impl BaselineComparison {
    /// All rows as JSON.
    pub(crate) fn json(&self) -> serde_json::Value {
        let row = |row: &BaselineRow| {
            json!({
                "subject": row.subject,
                "unit": row.unit,
                "baseline": row.old,
                "now": row.new,
                "deviation_sigma": row.significance.map(|found| found.sigma),
                "passed": row.passed,
                "reason": row.reason,
            })
        };
        json!({ "rules": self.rules, "rows": self.rows.iter().map(row).collect::<Vec<_>>() })
    }

    /// The results of all comparisons: failures, then metrics that are compared.
    pub(crate) fn check_results(&self) -> Vec<CheckResult> {
        let result = |passed, subject: &String, finding| CheckResult {
            passed,
            kind: CheckKind::Baseline,
            subject: subject.clone(),
            requirement: "equal to the baseline".to_owned(),
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
        failures.chain(compared).collect()
    }

    /// Failures that are not those of a metric.
    pub(crate) fn failures(&self) -> &[(String, String)] {
        &self.failures
    }
}
