//! The checked metrics that moved since they were locked, in the order of their significance.

use crate::messages::plural;
use kinetoscope::verify::lock_file::{LockedExperiment, LockedValue};
use kinetoscope_analysis::{CheckedValue, value_text};
use kinetoscope_console::text::one_line;

/// Differences below this fraction of a value are rounding errors, as for a deviation from theory.
const ROUNDING: f64 = 1e-9;

/// Digits of a value without a standard error.
const DIGITS: u8 = 6;

/// A checked metric before and after a change.
#[derive(Clone, Debug)]
pub(crate) struct Movement {
    /// The metric and its part of the sweep.
    pub(crate) name: String,
    /// The locked value; `None` if there is none.
    pub(crate) before: Option<LockedValue>,
    /// The value now; `None` if there is none.
    pub(crate) after: Option<CheckedValue>,
}

/// How far a metric moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Distance {
    /// There is only one value.
    Missing,
    /// In standard errors of the difference.
    StandardErrors(f64),
    /// As a fraction of the larger value, if no standard error is known.
    Fraction(f64),
    /// By no more than rounding errors.
    Rounding,
}

/// The metrics of an entry whose text is another one now, the most significant first.
pub(crate) fn moved(entry: &LockedExperiment, found: &[CheckedValue]) -> Vec<Movement> {
    let after = |name: &str| found.iter().find(|value| one_line(&value.name) == name).cloned();
    let before = entry.checked_values();
    let locked = before.iter().map(|(name, value)| Movement {
        name: name.clone(),
        before: Some(*value),
        after: after(name),
    });
    let is_new =
        |value: &&CheckedValue| !before.iter().any(|(name, _)| *name == one_line(&value.name));
    let new = found.iter().filter(is_new).map(|value| Movement {
        name: value.name.clone(),
        before: None,
        after: Some(value.clone()),
    });
    let mut movements: Vec<Movement> =
        locked.chain(new).filter(|movement| !movement.is_equal()).collect();
    movements.sort_by(|one, other| other.order().total_cmp(&one.order()));
    movements
}

impl Movement {
    /// Whether the file would contain the same text.
    fn is_equal(&self) -> bool {
        match (self.before, &self.after) {
            (Some(before), Some(after)) => before.text() == locked(after).text(),
            _ => false,
        }
    }

    /// How far the metric moved.
    pub(crate) fn distance(&self) -> Distance {
        let (Some(before), Some(after)) = (self.before, &self.after) else {
            return Distance::Missing;
        };
        let difference = after.value - before.value;
        let [one, other] = [before.value.abs(), after.value.abs()];
        let larger = if one > other { one } else { other };
        let rounding = ROUNDING * larger;
        if difference.abs() <= rounding || difference.abs() <= after.rounding {
            return Distance::Rounding;
        }
        match (before.standard_error, after.standard_error) {
            (None, None) => Distance::Fraction(difference / larger),
            (one, other) => {
                let [one, other] = [one, other].map(|error| error.unwrap_or(0.0));
                let error = (one * one + other * other).sqrt();
                Distance::StandardErrors(difference / error)
            }
        }
    }

    /// The place in the list: a metric that is missing now, then by standard errors. Without them, one percent counts as one.
    fn order(&self) -> f64 {
        match self.distance() {
            Distance::Missing => f64::INFINITY,
            Distance::StandardErrors(distance) => distance.abs(),
            Distance::Fraction(fraction) => 100.0 * fraction.abs(),
            Distance::Rounding => -1.0,
        }
    }

    /// Before, after and distance as text.
    pub(crate) fn cells(&self) -> [String; 3] {
        let before = self.before.map(|value| value_text(value.value, value.standard_error, DIGITS));
        let after =
            self.after.as_ref().map(|value| value_text(value.value, value.standard_error, DIGITS));
        let [before, after] = [before, after].map(|text| text.unwrap_or_else(|| "none".to_owned()));
        let distance = match self.distance() {
            Distance::Missing => String::new(),
            Distance::StandardErrors(distance) => format!("{distance:+.1} σ").replace('-', "−"),
            Distance::Fraction(fraction) => {
                let sign = if fraction > 0.0 { "+" } else { "" };
                format!("{sign}{} %", value_text(100.0 * fraction, None, 2))
            }
            Distance::Rounding => "rounding".to_owned(),
        };
        [before, after, distance]
    }

    /// Whether the checks of the metric pass now; `None` without a check.
    pub(crate) fn passes(&self) -> Option<bool> {
        self.after.as_ref().and_then(|value| value.passes)
    }

    fn line(&self) -> String {
        let [before, after, distance] = self.cells();
        let distance = if distance.is_empty() { distance } else { format!(" ({distance})") };
        let check = match self.passes() {
            Some(false) => ", its check fails",
            _ => "",
        };
        format!("{}: {before} → {after}{distance}{check}", self.name)
    }
}

fn locked(found: &CheckedValue) -> LockedValue {
    LockedValue { value: found.value, standard_error: found.standard_error }
}

/// One line per metric that moved, and one for those that moved within rounding.
pub(crate) fn lines(movements: &[Movement]) -> Vec<String> {
    let is_rounding = |movement: &&Movement| movement.distance() == Distance::Rounding;
    let mut lines: Vec<String> = movements
        .iter()
        .filter(|movement| !is_rounding(movement))
        .map(|movement| one_line(&movement.line()).into_owned())
        .collect();
    let rounding = movements.iter().filter(is_rounding).count();
    if rounding > 0 {
        lines.push(format!("{} moved within rounding errors", plural(rounding as u64, "metric")));
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    fn movement(before: (f64, Option<f64>), after: (f64, Option<f64>)) -> Movement {
        Movement {
            name: "x".to_owned(),
            before: Some(LockedValue { value: before.0, standard_error: before.1 }),
            after: Some(CheckedValue {
                name: "x".to_owned(),
                value: after.0,
                standard_error: after.1,
                rounding: 1e-15,
                passes: None,
            }),
        }
    }

    /// Law: a difference in units of its standard error, the root of the sum of squares: 3 and 4 give 5.
    #[test]
    fn metrics_that_moved_most_in_standard_errors_come_first() {
        let significant = movement((10.0, Some(3.0)), (30.0, Some(4.0)));
        assert_eq!(significant.distance(), Distance::StandardErrors(4.0));
        let insignificant = movement((1.0, Some(1.0)), (1.5, Some(1.0)));
        let rounding = movement((4.4e-28, None), (1.1e-27, None));
        assert_eq!(rounding.distance(), Distance::Rounding);
        let bare = movement((1.0, None), (1.02, None));
        let mut all = [&rounding, &insignificant, &bare, &significant];
        all.sort_by(|one, other| other.order().total_cmp(&one.order()));
        let order: Vec<f64> = all.iter().map(|movement| movement.order()).collect();
        assert!(order.is_sorted_by(|one, next| one >= next), "{order:?}");
        assert_eq!(all[0].distance(), significant.distance());
        assert_eq!(all[3].distance(), Distance::Rounding);
    }
}
