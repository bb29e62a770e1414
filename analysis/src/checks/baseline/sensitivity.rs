//! Which changes a comparison would have found: the least detectable change of each metric, in words.

use super::row::{BaselineRow, Evidence, percent};
use super::significance::POWER;
use std::collections::BTreeMap;

/// The least detectable change, as a fraction of the value, above which a comparison is called insensitive: the smallest of the changes
/// that `docs/statistics.md` lists.
const LARGEST_SENSITIVE_FRACTION: f64 = 0.1;

/// Number of metrics that are named.
const NAMED: usize = 4;

/// Why a comparison in which no metric is evidence is a failure, and what to do.
const NOTHING_COMPARED: &str = "nothing could be compared: no metric has a standard error in both analyses or follows an exact law: use \
     replicates (replicates = 8 in both manifests), or set a relative_tolerance in [[baseline]]";

/// Why a comparison of single runs that finds large changes only is a failure, and what to do.
const INSENSITIVE_RUNS: &str = "this comparison is insensitive: no metric of these single runs would have shown a change of 10 % reliably: use replicates \
     (replicates = 8 in both manifests) or longer runs, or set a relative_tolerance in [[baseline]]";

/// Why a comparison in which no metric differs has not shown that nothing changed; `None` if it has. A conservation law alone shows
/// that of what it conserves.
pub(super) fn insufficiency(rows: &[BaselineRow], has_replicates: bool) -> Option<&'static str> {
    if rows.iter().all(|row| row.evidence <= Evidence::Start) {
        return Some(NOTHING_COMPARED);
    }
    (!has_replicates && !is_sensitive(rows)).then_some(INSENSITIVE_RUNS)
}

/// Whether some metric would have shown a change of a tenth in each of its runs or points.
fn is_sensitive(rows: &[BaselineRow]) -> bool {
    let mut by_name: BTreeMap<&str, bool> = BTreeMap::new();
    let could_show = |row: &&BaselineRow| row.evidence > Evidence::Lawful;
    for row in rows.iter().filter(could_show) {
        *by_name.entry(&row.name).or_insert(true) &= row.shows(LARGEST_SENSITIVE_FRACTION);
    }
    by_name.into_values().any(|shows| shows)
}

/// What an insensitive comparison lacks.
const INSENSITIVE: &str = "this comparison is insensitive: no metric with a standard error would have shown a change of 10 % reliably; use more \
     `replicates` in both manifests, or longer runs";

/// Which changes a comparison would have found.
#[derive(Clone, Debug)]
pub(crate) struct Sensitivity {
    /// The least detectable changes of the principal metrics, in one line; `None` if no metric is compared by standard errors.
    pub(crate) changes: Option<String>,
    /// That the comparison finds large changes only, and what to do.
    pub(crate) note: Option<&'static str>,
}

impl Sensitivity {
    /// From the rows of a comparison of other seeds: the model's `main` metrics, also if the changes are larger than the values, then those
    /// with the smallest changes, as far as these are below the value itself. A metric of several runs or points has the largest of its least
    /// detectable changes.
    pub(super) fn of(rows: &[BaselineRow], main: &[&str]) -> Self {
        let mut by_name: BTreeMap<&str, f64> = BTreeMap::new();
        for row in rows.iter().filter(|row| row.evidence > Evidence::None) {
            if let Some(fraction) = row.least_detectable_fraction() {
                let largest = by_name.entry(&row.name).or_default();
                *largest = if fraction > *largest { fraction } else { *largest };
            }
        }
        let mut named: Vec<(&str, f64)> = by_name.into_iter().collect();
        let rank = |name: &str| main.iter().position(|main| *main == name).unwrap_or(main.len());
        named.retain(|(name, fraction)| *fraction < 1.0 || main.contains(name));
        named.sort_by(|one, other| rank(one.0).cmp(&rank(other.0)).then(one.1.total_cmp(&other.1)));
        let changes = named.iter().take(NAMED);
        let changes: Vec<String> =
            changes.map(|(name, fraction)| format!("{} of {name}", percent(*fraction))).collect();
        let line = format!(
            "least changes that are found with a probability of {:.0} %: {}",
            100.0 * POWER,
            changes.join(", ")
        );
        Self {
            changes: (!changes.is_empty()).then_some(line),
            note: (!is_sensitive(rows)).then_some(INSENSITIVE),
        }
    }

    /// The changes and the note, one per line.
    pub(crate) fn lines(&self) -> impl Iterator<Item = &str> {
        self.changes.as_deref().into_iter().chain(self.note)
    }
}
