//! Which changes a comparison would have found: the least detectable change of each metric, in words.

use super::row::{BaselineRow, Evidence, percent};
use super::significance::POWER;
use std::collections::BTreeMap;

/// The least detectable change, as a fraction of the value, above which a comparison is called insensitive: the smallest of the changes
/// that `docs/statistics.md` lists.
pub(super) const LARGEST_SENSITIVE_FRACTION: f64 = 0.1;

/// Number of metrics that are named.
const NAMED: usize = 4;

/// Why a comparison in which no metric is evidence is a failure, and what to do.
const NOTHING_COMPARED: &str = "nothing could be compared: no metric has a standard error in both analyses or follows an exact law: use \
     replicates (replicates = 8 in both manifests), or set in [[baseline]] a relative_tolerance of at most 0.1 for a metric that the manifest does not set";

/// Why a comparison of single runs that finds large changes only is a failure, and what to do.
const INSENSITIVE_RUNS: &str = "this comparison is insensitive: no metric of these single runs would have shown a change of 10 % reliably: use replicates \
     (replicates = 8 in both manifests) or longer runs, or set in [[baseline]] a relative_tolerance of at most 0.1 for a metric that the manifest does not set";

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
    /// The metrics of single runs that could show other changes and are not compared; `None` if there are none.
    pub(crate) not_compared: Option<String>,
    /// The keys that are allowed to differ, if no metric shows it.
    pub(crate) hidden: Option<String>,
    /// That the comparison finds large changes only, and what to do.
    pub(crate) note: Option<&'static str>,
}

impl Sensitivity {
    /// From the rows of a comparison of other seeds, with the changed keys as texts: the model's `main` metrics, also if the changes are
    /// larger than the values, then those with the smallest changes, as far as these are below the value itself.
    pub(super) fn of(
        rows: &[BaselineRow],
        main: &[&str],
        changed_keys: &[String],
        has_replicates: bool,
    ) -> Self {
        let is_failed = rows.iter().any(|row| row.passed == Some(false));
        let is_hidden = !changed_keys.is_empty() && !is_failed;
        let hidden = is_hidden.then(|| {
            let keys = changed_keys.join(", ");
            format!("no compared metric shows the change of {keys}")
        });
        Self {
            changes: least_changes(rows, main),
            not_compared: not_compared(rows).filter(|_| !has_replicates),
            hidden,
            note: (!is_sensitive(rows)).then_some(INSENSITIVE),
        }
    }

    /// All of it, one per line.
    pub(crate) fn lines(&self) -> impl Iterator<Item = &str> {
        let texts = [&self.changes, &self.not_compared, &self.hidden];
        texts.into_iter().filter_map(Option::as_deref).chain(self.note)
    }
}

/// The least detectable changes in one line. A metric of several runs or points has the largest of its least detectable changes.
fn least_changes(rows: &[BaselineRow], main: &[&str]) -> Option<String> {
    let mut by_name: BTreeMap<&str, (f64, String)> = BTreeMap::new();
    for row in rows.iter().filter(|row| row.evidence > Evidence::Lawful) {
        if let Some(fraction) = row.least_detectable_fraction()
            && by_name.get(row.name.as_str()).is_none_or(|(largest, _)| fraction > *largest)
        {
            by_name.insert(&row.name, (fraction, row.changing_part()));
        }
    }
    let mut named: Vec<(&str, (f64, String))> = by_name.into_iter().collect();
    let rank = |name: &str| main.iter().position(|main| *main == name).unwrap_or(main.len());
    named.retain(|(name, (fraction, _))| *fraction < 1.0 || main.contains(name));
    named.sort_by(|(one, (small, _)), (other, (large, _))| {
        rank(one).cmp(&rank(other)).then(small.total_cmp(large))
    });
    let changes = named.iter().take(NAMED);
    let changes: Vec<String> =
        changes.map(|(_, (fraction, part))| format!("{} of {part}", percent(*fraction))).collect();
    let line = || {
        format!(
            "least changes that are found with a probability of {:.0} %: {}",
            100.0 * POWER,
            changes.join(", ")
        )
    };
    (!changes.is_empty()).then(line)
}

/// The metrics whose values are known and of which no run or point is compared, in one line.
fn not_compared(rows: &[BaselineRow]) -> Option<String> {
    let mut by_name: BTreeMap<&str, bool> = BTreeMap::new();
    for row in rows.iter().filter(|row| row.difference().is_some()) {
        *by_name.entry(&row.name).or_insert(true) &= row.passed.is_none();
    }
    by_name.retain(|_, is_not_compared| *is_not_compared);
    let named: Vec<&str> = by_name.keys().copied().take(NAMED).collect();
    let more = match by_name.len() - named.len() {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    let line = || {
        format!(
            "not compared in single runs: {}{more}; use replicates to find changes that only these show",
            named.join(", ")
        )
    };
    (!named.is_empty()).then(line)
}
