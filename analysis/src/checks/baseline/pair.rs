//! The comparison of one metric of two analyses.
//!
//! Of other seeds, the first of these rules that applies decides:
//!
//! | value | rule |
//! |---|---|
//! | set by the manifest | equal within rounding |
//! | has an exact law that follows from the manifest alone | the law gives the same value |
//! | was that of its exact law, and does not differ from start to start | still is |
//! | standard errors in both analyses; of a mean over replicates, by the errors of `replicates.rs` | the difference is not significant by Student's t, with Holm's correction |
//! | nothing was counted in one of the analyses | by the standard error of the other |
//! | a run too short for the standard error of one of the values, or one that has it by chance | not compared |
//! | a value that only some replicates of one analysis have, or that a run has by chance | may be missing in the other |
//! | a standard error in the baseline only | fails |
//! | was inside the accuracy of its law | still is |
//! | anything else | not compared |

use super::kinds::{FORMS, OF_SOME_SEEDS, is_lawful, most_accuracies};
use super::relation::{Place, Relation};
use super::replicates::{Replicates, freedom};
use super::row::{BaselineRow, Evidence};
use super::sensitivity::LARGEST_SENSITIVE_FRACTION;
use super::significance::{Sample, Significance};
use crate::checks::digits;
use crate::metric::deviation::ROUNDING_FRACTION;
use crate::metric_files::document::{MetricEntry, ScopeEntry};
use kinetoscope_manifest::BaselineTolerance;

/// Why the violation of a conservation law is not compared with that of another seed without errors.
const VIOLATION_COMPARED: &str = "the violation of a conservation law in one run each: use replicates, or set a relative_tolerance in [[baseline]]";

/// Degrees of freedom from which Student's t is taken as normal.
const NORMAL_FREEDOM: f64 = 1e5;

/// A metric in both analyses; at least one of them has it.
#[derive(Clone, Copy)]
pub(super) struct Pair<'a> {
    pub(super) old: Option<&'a MetricEntry>,
    pub(super) new: Option<&'a MetricEntry>,
    /// Whether one of the analyses has the mean over replicates at this place.
    pub(super) has_replicates: bool,
}

/// What a metric may differ by.
pub(super) struct Rule<'a> {
    /// A difference below this is a rounding error.
    pub(super) rounding: f64,
    /// Whether its law is a conservation law.
    pub(super) is_conservation: bool,
    /// Whether its law is an identity of the recorded values, which holds whatever the run does.
    pub(super) is_identity: bool,
    /// Whether one of its laws holds up to the error of an integrator.
    pub(super) is_of_integrator: bool,
    /// The tolerance of the manifest.
    pub(super) tolerance: Option<&'a BaselineTolerance>,
    /// Whether this program derives such a metric.
    pub(super) is_known: bool,
    /// Whether its law's value follows from the manifest alone.
    pub(super) is_of_manifest: bool,
    /// Whether both analyses have the mean over the replicates of this run, which has a smaller error.
    pub(super) has_mean: bool,
    /// What the replicates of a mean state, in the baseline and now.
    pub(super) replicates: [Replicates; 2],
    /// The number of particles behind the value.
    pub(super) particles: f64,
    /// Whether only some replicates of one of the analyses have a value.
    pub(super) is_of_some_seeds: bool,
    /// Whether the container limits the value, before and now.
    pub(super) is_saturated: bool,
    /// The value from which changes of the baseline's count.
    pub(super) zero: f64,
}

impl Rule<'_> {
    /// Whether a value is that of its exact law, up to rounding. What an identity leaves is rounding, also if several runs give it a scatter.
    fn is_exact(&self, entry: &MetricEntry) -> Option<bool> {
        entry.is_exact(self.rounding, self.is_conservation || self.is_identity)
    }

    /// Whether the value, or that of a replicate, differs from start to start by an amount that the run does not tell.
    fn depends_on_start(&self, entries: [&MetricEntry; 2]) -> bool {
        entries.iter().any(|entry| entry.depends_on_start())
            || self.replicates.iter().any(|replicates| replicates.depend_on_start)
    }

    /// Whether the manifest sets the value in one of the analyses.
    fn is_set_by_manifest(&self, entries: [&MetricEntry; 2]) -> bool {
        entries.iter().any(|entry| entry.is_set_by_manifest())
            || self.replicates.iter().any(|replicates| replicates.are_set_by_manifest)
    }

    /// The most that equal values can show: nothing if no change of the run could have made them differ.
    fn most_evidence(&self, [old, new]: [&MetricEntry; 2]) -> Evidence {
        let name = old.name.as_str();
        let is_exact = self.is_exact(old) == Some(true);
        let cannot_differ = self.is_set_by_manifest([old, new])
            || self.is_identity
            || self.is_saturated
            || is_exact && self.is_of_manifest;
        match cannot_differ {
            true => Evidence::None,
            // The name states that the metric describes the first frame only.
            false if name.ends_with(".start") => Evidence::Start,
            false if is_exact || is_lawful(name) => Evidence::Lawful,
            false => Evidence::Equal,
        }
    }
}

impl Pair<'_> {
    /// A row without evidence.
    pub(super) fn row(
        &self,
        place: &Place,
        passed: Option<bool>,
        reason: impl Into<String>,
    ) -> BaselineRow {
        let entry = self.new.or(self.old);
        let name = entry.map_or("", |entry| entry.name.as_str());
        let at = place.text(self.has_replicates);
        BaselineRow {
            name: name.to_owned(),
            subject: if at.is_empty() { name.to_owned() } else { format!("{name} at {at}") },
            unit: entry.map_or_else(String::new, |entry| entry.unit.clone()),
            old: self.old.and_then(|old| old.value),
            new: self.new.and_then(|new| new.value),
            zero: 0.0,
            significance: None,
            least_detectable: None,
            passed,
            evidence: Evidence::None,
            reason: reason.into(),
        }
    }

    /// A row that passes or fails, and would fail for a changed experiment.
    fn evidence(&self, place: &Place, passed: bool, reason: &str) -> BaselineRow {
        BaselineRow { evidence: Evidence::Equal, ..self.row(place, Some(passed), reason) }
    }

    /// Compares the values by the rule that follows from what the runs differ in. A row that is compared by statistics passes
    /// until all are known.
    pub(super) fn compare(
        &self,
        place: &Place,
        relation: &Relation,
        rule: &Rule<'_>,
    ) -> BaselineRow {
        match relation {
            Relation::OtherKeys(_) => {
                return self.row(place, None, "its runs differ in other keys");
            }
            Relation::NoCounterpart => {
                return self.row(place, None, "its runs are not those of the baseline");
            }
            _ => {}
        }
        let is_other_seed = matches!(relation, Relation::OtherSeed(_));
        let Some((old, new)) = self.old.zip(self.new) else {
            return self.lacking(place, rule, is_other_seed, "this analysis does not have it");
        };
        let (Some(before), Some(value)) = (old.value, new.value) else {
            return self.without_value(place, rule, is_other_seed);
        };
        let difference = (value - before).abs();
        let is_rounding =
            difference <= rule.rounding.max(ROUNDING_FRACTION * before.abs()) || value == before;
        match (relation, rule.tolerance) {
            (Relation::Same, _) if value == before => self.evidence(place, true, "equal"),
            (Relation::Same, _) => {
                self.evidence(place, false, "not equal, although the run is the same")
            }
            (_, Some(tolerance)) => {
                self.by_tolerance(place, rule, [old, new], tolerance.relative_tolerance)
            }
            (Relation::OtherVersions(_) | Relation::NoRandomNumbers(_), None) if is_rounding => {
                self.evidence(place, true, "equal up to rounding")
            }
            (Relation::OtherVersions(versions), None) => {
                let versions = versions.join(", ");
                self.evidence(place, false, &format!("beyond rounding ({versions})"))
            }
            (Relation::NoRandomNumbers(_), None) => {
                self.evidence(place, false, "not equal, although the runs draw no random numbers")
            }
            _ => self.of_other_seed(place, rule, [old, new], is_rounding),
        }
    }

    /// Compares with a tolerance of the baseline's value. It is evidence if the values could have differed and the tolerance does not
    /// contain all that they differ from zero by.
    fn by_tolerance(
        &self,
        place: &Place,
        rule: &Rule<'_>,
        entries: [&MetricEntry; 2],
        allowed: f64,
    ) -> BaselineRow {
        let [before, now] = entries.map(|entry| entry.value.unwrap_or(f64::NAN));
        let largest = allowed * before.abs();
        let reason = format!("tolerance {allowed} of the baseline");
        let row = self.row(place, Some((now - before).abs() <= largest), reason);
        let row = BaselineRow { zero: rule.zero, ..row };
        let evidence = match row.fraction(largest) {
            Some(fraction) if fraction <= LARGEST_SENSITIVE_FRACTION => Evidence::Equal,
            Some(fraction) if fraction < 1.0 => Evidence::Scattered,
            _ => Evidence::None,
        };
        BaselineRow { evidence: evidence.min(rule.most_evidence(entries)), ..row }
    }

    /// A metric that only the baseline has. Whether a metric applies may depend on the seed, but not whether the program has it, nor
    /// whether it has an error or follows an exact law.
    fn lacking(
        &self,
        place: &Place,
        rule: &Rule<'_>,
        is_other_seed: bool,
        reason: &str,
    ) -> BaselineRow {
        let is_exact = |old: &MetricEntry| rule.is_exact(old) == Some(true);
        let could_differ = self
            .old
            .is_some_and(|old| is_exact(old) || old.standard_error.is_some() && !rule.has_mean);
        let is_by_chance = rule.is_of_some_seeds
            || self.old.is_some_and(|old| OF_SOME_SEEDS.contains(&old.name.as_str()))
            || self.new.is_some_and(MetricEntry::lacks_by_chance);
        let may_lack = is_other_seed && rule.is_known && (!could_differ || is_by_chance);
        self.row(place, (!may_lack).then_some(false), reason)
    }

    /// A metric without a value in one of the analyses, or in both.
    fn without_value(&self, place: &Place, rule: &Rule<'_>, is_other_seed: bool) -> BaselineRow {
        let value = |entry: Option<&MetricEntry>| entry.and_then(|entry| entry.value);
        let reason = [self.new, self.old]
            .iter()
            .find_map(|entry| entry.filter(|entry| entry.value.is_none())?.reason.clone());
        let reason = reason.unwrap_or_else(|| "one of the values is missing".to_owned());
        match (value(self.old), value(self.new)) {
            (None, None) => self.row(place, None, reason),
            (None, Some(_)) if is_other_seed => self.row(place, None, reason),
            (Some(_), _) => self.lacking(place, rule, is_other_seed, &reason),
            (None, Some(_)) => self.row(place, Some(false), reason),
        }
    }

    fn of_other_seed(
        &self,
        place: &Place,
        rule: &Rule<'_>,
        [old, new]: [&MetricEntry; 2],
        is_rounding: bool,
    ) -> BaselineRow {
        if rule.is_set_by_manifest([old, new]) {
            // Equal input is no evidence for equal results.
            let reason = if is_rounding {
                "set by the manifest"
            } else {
                "set by the manifest, and differs"
            };
            return self.row(place, Some(is_rounding), reason);
        }
        if let [Some(before), Some(now)] = [old, new].map(MetricEntry::exact_theory)
            && rule.is_of_manifest
            && (now - before).abs() > ROUNDING_FRACTION * before.abs()
        {
            let reason = format!(
                "its exact law, which follows from the manifest, gives {}, before {}",
                digits(now),
                digits(before)
            );
            return self.evidence(place, false, &reason);
        }
        // Conservation laws hold for every seed.
        let is_exact = |entry: &MetricEntry| rule.is_exact(entry);
        if rule.is_of_integrator && [old, new].iter().any(|entry| is_exact(entry) == Some(true)) {
            return self.row(place, None, "without contacts, the integrator has no error");
        }
        if is_exact(old) == Some(true) && !rule.depends_on_start([old, new]) {
            let still_is = is_exact(new) == Some(true) || is_rounding;
            let reason = if still_is {
                "now and before equal to the exact law up to rounding"
            } else {
                "no longer equal to its exact law up to rounding"
            };
            let evidence = rule.most_evidence([old, new]).min(Evidence::Lawful);
            return BaselineRow { evidence, ..self.row(place, Some(still_is), reason) };
        }
        if rule.has_mean {
            return self.row(place, None, "compared by the mean over the replicates");
        }
        self.by_errors(place, rule, [old, new], is_rounding)
    }

    /// Compares by the standard errors, or by the accuracy of the law of values that do not scatter.
    fn by_errors(
        &self,
        place: &Place,
        rule: &Rule<'_>,
        [old, new]: [&MetricEntry; 2],
        is_rounding: bool,
    ) -> BaselineRow {
        let [before, now] = rule.replicates.map(|replicates| replicates.known_error);
        let samples = match [sample(old, before, rule), sample(new, now, rule)] {
            // Without a change, both have the same scatter.
            [Some(one), None] if new.counts_nothing() => [Some(one), one.with_value(new.value)],
            [None, Some(other)] if old.counts_nothing() => {
                [other.with_value(old.value), Some(other)]
            }
            samples => samples,
        };
        match samples {
            [Some(one), Some(other)] => {
                self.by_statistics(place, rule, [old, new], [one, other], is_rounding)
            }
            // Whether a series is long enough depends on the seed, and a value that scatters may leave the accuracy of its law.
            [None, _] if old.has_unknown_scatter() => {
                let why = old.reason.as_deref().unwrap_or_default();
                self.row(place, None, format!("the baseline has no standard error: {why}"))
            }
            [_, None] if new.has_unknown_scatter() || FORMS.contains(&new.name.as_str()) => {
                self.row(place, None, new.reason.as_deref().unwrap_or_default())
            }
            [Some(_), None] => {
                let why = new.reason.as_deref().unwrap_or("its error is not known");
                let reason = format!("had a standard error, and has none now: {why}");
                self.evidence(place, false, &reason)
            }
            [None, Some(_)] => self.row(place, None, "the baseline has no standard error"),
            [None, None] => match [old, new].map(MetricEntry::distance_over_accuracy) {
                [Some(before), Some(now)] if before <= 1.0 => {
                    let is_inside = now <= most_accuracies(&new.name);
                    let reason = match is_inside {
                        true => "inside the accuracy of its law, as before",
                        false => "no longer inside the accuracy of its law",
                    };
                    self.row(place, Some(is_inside), reason)
                }
                _ if rule.is_conservation => self.row(place, None, VIOLATION_COMPARED),
                _ => self.row(place, None, new.reason.as_deref().unwrap_or("no standard error")),
            },
        }
    }

    /// The significance of a difference between other seeds.
    fn by_statistics(
        &self,
        place: &Place,
        rule: &Rule<'_>,
        entries: [&MetricEntry; 2],
        [one, other]: [Sample; 2],
        is_rounding: bool,
    ) -> BaselineRow {
        let rounding = rule.rounding.max(ROUNDING_FRACTION * one.value.abs());
        let significance = Significance::of(one, other).with_rounding(rounding);
        let significance = if is_rounding { significance.of_equal_values() } else { significance };
        let is_without_scatter = significance.is_of_rounding;
        let reason = match is_rounding {
            true if is_without_scatter => "equal in all runs, so that its scatter is not known",
            true => "equal up to rounding",
            false if rule.is_saturated => "as large as the container, before and now",
            false => "within the scatter of seeds",
        };
        let evidence = match is_without_scatter {
            true => Evidence::None,
            false => rule.most_evidence(entries).min(Evidence::Scattered),
        };
        let row = self.row(place, Some(true), reason);
        BaselineRow { significance: Some(significance), evidence, zero: rule.zero, ..row }
    }
}

/// The value with its standard error, if both are known: that of the replicates if it is known, else the one of the entry.
fn sample(entry: &MetricEntry, known_error: Option<(f64, f64)>, rule: &Rule<'_>) -> Option<Sample> {
    let value = entry.value?;
    let own = || {
        let error = entry.standard_error?;
        let of_start = match (&entry.scope, entry.degrees_of_freedom) {
            // Blocks of one run have its angular momentum, momentum and slow motion in common: 1 of N shares of what is measured.
            (ScopeEntry::Run { .. }, Some(_)) => (value - rule.zero).abs() / rule.particles,
            _ => 0.0,
        };
        Some((libm::hypot(error, of_start), freedom(entry, rule.particles)))
    };
    let (error, degrees_of_freedom) = known_error.or_else(own)?;
    let degrees_of_freedom = Some(degrees_of_freedom).filter(|freedom| *freedom < NORMAL_FREEDOM);
    Some(Sample { value, error, degrees_of_freedom })
}
