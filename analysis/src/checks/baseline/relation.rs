//! In what the runs of two analyses differ, which decides how their metrics are compared.

use crate::metric_files::document::{Coordinates, Document, MetricEntry, RunEntry, ScopeEntry};
use kinetoscope_manifest::{KeyDifference, differing_values};
use std::collections::{BTreeMap, BTreeSet};

/// Identifies a run, or a part of a sweep, independently of its recording's file name, which changes with the physics.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Place {
    pub(super) coordinates: BTreeMap<String, String>,
    /// Number of the replicate; `None` for a mean or a fit.
    pub(super) replicate: Option<u32>,
    /// The axis of a fit.
    pub(super) along: Option<String>,
}

impl Place {
    pub(super) fn of_run(run: &RunEntry) -> Self {
        let (coordinates, replicate) = (texts(&run.coordinates), Some(run.replicate));
        Self { coordinates, replicate, along: None }
    }

    pub(super) fn of_metric(metric: &MetricEntry) -> Self {
        match &metric.scope {
            ScopeEntry::Run { coordinates, replicate, .. } => {
                Self { coordinates: texts(coordinates), replicate: Some(*replicate), along: None }
            }
            ScopeEntry::Sweep { along, coordinates, .. } => {
                Self { coordinates: texts(coordinates), replicate: None, along: along.clone() }
            }
        }
    }

    /// The mean over the replicates of this run's point.
    pub(super) fn of_mean(&self) -> Self {
        Self { replicate: None, along: None, ..self.clone() }
    }

    /// Whether a run is this one, or one from which this mean or fit was derived.
    pub(super) fn includes(&self, run: &Self) -> bool {
        let is_here =
            self.coordinates.iter().all(|(key, value)| run.coordinates.get(key) == Some(value));
        is_here && (self.replicate.is_none() || *self == *run)
    }

    /// The place as text, such as "temperature_k = 300, replicate = 1"; empty for the only run. The first of several replicates is named, too:
    /// their mean is not.
    pub(super) fn text(&self, has_replicates: bool) -> String {
        let places = self.coordinates.iter().map(|(key, value)| format!("{key} = {value}"));
        let replicate = self.replicate.filter(|replicate| has_replicates || *replicate > 0);
        let replicate = replicate.map(|replicate| format!("replicate = {replicate}"));
        places.chain(replicate).collect::<Vec<_>>().join(", ")
    }
}

fn texts(coordinates: &Coordinates) -> BTreeMap<String, String> {
    coordinates.iter().map(|(key, entry)| (key.clone(), entry.value.to_string())).collect()
}

/// In what a run differs from that of the baseline, from the least to the most.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Relation {
    /// In nothing: same run key, same versions.
    Same,
    /// In the versions of the programs or of the physics only.
    OtherVersions(Vec<String>),
    /// In the seed, or in keys that are allowed to differ, of a run that draws no random numbers.
    NoRandomNumbers(Vec<String>),
    /// In the seed, or in keys that are allowed to differ.
    OtherSeed(Vec<String>),
    /// In other keys.
    OtherKeys(Vec<String>),
    /// One analysis has no such run, or its runs are not those of the other.
    NoCounterpart,
}

/// The relations of all runs of the baseline.
pub(super) struct Relations {
    runs: BTreeMap<Place, Relation>,
}

impl Relations {
    /// Compares the runs, of which `draws` states whether the new ones draw random numbers. Keys that are `allowed`, by their name or
    /// by its last part, may differ as the seed may.
    pub(super) fn between(
        old: &Document,
        new: &Document,
        draws: &[bool],
        allowed: &[String],
    ) -> Self {
        let now: BTreeMap<Place, (&RunEntry, bool)> = new
            .runs
            .iter()
            .zip(draws)
            .map(|(run, &draws)| (Place::of_run(run), (run, draws)))
            .collect();
        let mut runs: BTreeMap<Place, Relation> =
            now.keys().map(|place| (place.clone(), Relation::NoCounterpart)).collect();
        for run in &old.runs {
            let place = Place::of_run(run);
            let relation =
                now.get(&place).map_or(Relation::NoCounterpart, |&(counterpart, draws)| {
                    let versions = [&old.analysis_version, &new.analysis_version];
                    match relation(run, counterpart, versions, allowed) {
                        Relation::OtherSeed(keys) if !draws => Relation::NoRandomNumbers(keys),
                        relation => relation,
                    }
                });
            runs.insert(place, relation);
        }
        Self { runs }
    }

    /// The relation of a run, or the greatest relation of the runs from which a mean or fit was derived.
    pub(super) fn of(&self, place: &Place) -> Relation {
        let included = self.runs.iter().filter(|(run, _)| place.includes(run));
        included.map(|(_, relation)| relation.clone()).max().unwrap_or(Relation::NoCounterpart)
    }

    /// The keys that differ in addition to the seed, and are allowed to, with their values.
    pub(super) fn changed_keys(&self) -> Vec<String> {
        let keys = self.runs.values().filter_map(|relation| match relation {
            Relation::OtherSeed(differences) | Relation::NoRandomNumbers(differences) => {
                Some(differences)
            }
            _ => None,
        });
        // The versions of the programs are named in several words.
        let is_key = |text: &&String| {
            text.split_once(": ").is_some_and(|(name, _)| name != "seed" && !name.contains(' '))
        };
        let changed: BTreeSet<&String> = keys.flatten().filter(is_key).collect();
        changed.into_iter().cloned().collect()
    }

    /// Each relation with the number of its runs, from the least to the greatest.
    pub(super) fn counts(&self) -> BTreeMap<&Relation, usize> {
        let mut counts = BTreeMap::new();
        for relation in self.runs.values() {
            *counts.entry(relation).or_default() += 1;
        }
        counts
    }
}

fn relation(
    old: &RunEntry,
    new: &RunEntry,
    analysis_versions: [&String; 2],
    allowed: &[String],
) -> Relation {
    let pairs = |run: &RunEntry| -> Vec<(String, String)> {
        run.manifest.iter().map(|(key, value)| (key.clone(), value.clone())).collect()
    };
    let differing = differing_values(pairs(old), &pairs(new));
    let texts = |differences: Vec<&KeyDifference>| -> Vec<String> {
        differences.into_iter().map(ToString::to_string).collect()
    };
    let is_allowed = |difference: &&KeyDifference| {
        difference.key == "seed" || allowed.iter().any(|allowed| names(allowed, &difference.key))
    };
    let (seed, other): (Vec<_>, Vec<_>) = differing.iter().partition(is_allowed);
    let version = |name: &str, old: &dyn ToString, new: &dyn ToString| {
        let (old, new) = (old.to_string(), new.to_string());
        (old != new).then(|| format!("{name}: {old} → {new}"))
    };
    let [old_analysis, new_analysis] = analysis_versions;
    let versions = [
        version("program version", &old.program_version, &new.program_version),
        version("physics version", &old.physics_version, &new.physics_version),
        version("version of the analysis", old_analysis, new_analysis),
    ];
    let mut versions: Vec<String> = versions.into_iter().flatten().collect();
    if !other.is_empty() {
        return Relation::OtherKeys(texts(other));
    }
    if !seed.is_empty() {
        return Relation::OtherSeed(texts(seed).into_iter().chain(versions).collect());
    }
    if versions.is_empty() && old.run_key != new.run_key {
        // The run key contains the version of the recording's layout as well.
        versions.push(format!("run key: {:.8} → {:.8}", old.run_key, new.run_key));
    }
    if versions.is_empty() { Relation::Same } else { Relation::OtherVersions(versions) }
}

/// Whether a name is a key, or the last part of one.
pub(super) fn names(name: &str, key: &str) -> bool {
    name == key || key.rsplit('.').next() == Some(name)
}
