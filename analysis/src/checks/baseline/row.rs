//! One metric of a comparison with an earlier analysis, and its text.

use super::kinds::LOGARITHMS;
use super::significance::Significance;
use crate::checks::digits;

/// What a value that passes shows of the experiment, from the least to the most.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Evidence {
    /// Nothing: the manifest or the container sets it, or it is the same whatever the run does.
    None,
    /// That the start is as expected, and nothing of what follows.
    Start,
    /// That a law still holds, such as a conservation law, which does so for any size, time and temperature.
    Lawful,
    /// That no change of the least detectable size has happened.
    Scattered,
    /// That the value is the same, within rounding or a tolerance.
    Equal,
}

/// One metric in both analyses.
#[derive(Clone, Debug)]
pub(crate) struct BaselineRow {
    /// The metric's name.
    pub(super) name: String,
    /// The metric and its run or part of the sweep.
    pub(crate) subject: String,
    /// The metric's unit.
    pub(crate) unit: String,
    /// The earlier value.
    pub(crate) old: Option<f64>,
    /// The value now.
    pub(crate) new: Option<f64>,
    /// The value from which changes count: 0, or the one that the metric has where what it measures has no effect.
    pub(super) zero: f64,
    /// The significance of the difference, if both values have a standard error and are those of different seeds.
    pub(crate) significance: Option<Significance>,
    /// The least change that would have been found, in the metric's unit, if the metric is compared by its standard errors.
    pub(super) least_detectable: Option<f64>,
    /// Whether the metric passes; `None` if it is not compared.
    pub(crate) passed: Option<bool>,
    /// What the values show if they pass.
    pub(super) evidence: Evidence,
    /// Why.
    pub(crate) reason: String,
}

impl BaselineRow {
    /// The difference, if both values are known.
    pub(crate) fn difference(&self) -> Option<f64> {
        Some(self.new? - self.old?)
    }

    /// The least change that would have been found, as a fraction of what the baseline's value differs from its zero by, or of the
    /// argument of a logarithm. `None` without such a difference.
    pub(super) fn least_detectable_fraction(&self) -> Option<f64> {
        Some(self.fraction(self.least_detectable?)?).filter(|fraction| fraction.is_finite())
    }

    /// A change as a fraction of what the baseline's value differs from its zero by, or of the argument of a logarithm.
    pub(super) fn fraction(&self, change: f64) -> Option<f64> {
        let is_logarithm = LOGARITHMS.contains(&self.name.as_str());
        let scale = if is_logarithm { 1.0 } else { (self.old? - self.zero).abs() };
        Some(change / scale)
    }

    /// What changes are fractions of, such as "compressibility_factor - 1".
    pub(super) fn changing_part(&self) -> String {
        match self.zero {
            zero if zero > 0.0 => format!("{} - {}", self.name, digits(zero)),
            zero if zero < 0.0 => format!("{} + {}", self.name, digits(-zero)),
            _ => self.name.clone(),
        }
    }

    /// Whether the metric would have shown a change of this fraction of it.
    pub(super) fn shows(&self, fraction: f64) -> bool {
        match self.evidence {
            Evidence::None | Evidence::Start | Evidence::Lawful => false,
            Evidence::Scattered => {
                self.least_detectable_fraction().is_some_and(|least| least <= fraction)
            }
            Evidence::Equal => true,
        }
    }

    /// The order of the rows: failures first, then by significance, then by relative difference; what is not compared is last.
    pub(super) fn rank(&self) -> f64 {
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
        let is_shown = self.passed == Some(true) && self.evidence > Evidence::None;
        let least = self.least_detectable_fraction().filter(|_| is_shown);
        let least = least.map_or_else(String::new, |fraction| {
            let part = match self.zero {
                0.0 => String::new(),
                _ => format!(" of {}", self.changing_part()),
            };
            format!("; a change of {}{part} would have been found", percent(fraction))
        });
        format!("{new}, baseline {old}{difference}{sigma}: {}{least}", self.reason)
    }

    fn in_unit(&self, value: f64) -> String {
        match self.unit.as_str() {
            "" | "1" => digits(value),
            unit => format!("{} {unit}", digits(value)),
        }
    }
}

/// A fraction in percent with two digits.
pub(super) fn percent(fraction: f64) -> String {
    let percent = 100.0 * fraction;
    match percent {
        percent if percent >= 10.0 => format!("{percent:.0} %"),
        percent if percent >= 1.0 => format!("{percent:.1} %"),
        percent if percent >= 0.1 => format!("{percent:.2} %"),
        percent if percent >= 0.01 => format!("{percent:.3} %"),
        percent => format!("{percent:.1e} %"),
    }
}

impl Significance {
    /// The significance as text, such as "5.1 σ (t, 2 degrees of freedom)".
    fn text(self) -> String {
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
