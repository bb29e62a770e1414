//! The metrics of one recording.

use crate::metric::definition::Definition;
use crate::metric::deviation::Deviation;
use crate::metric::law::Law;
use crate::metric::theory::{Expected, Theory};
use crate::statistics::Estimate;
use std::borrow::Cow;

/// A value with its error and the theoretical value.
#[derive(Clone, Debug, PartialEq)]
pub struct Measurement {
    /// The metric.
    pub definition: &'static Definition,
    /// The value and its error.
    pub estimate: Estimate,
    /// The theoretical value.
    pub theory: Option<Theory>,
    /// Why the metric has no value; then the value is NaN.
    pub reason: Option<Cow<'static, str>>,
}

impl Measurement {
    /// The metric's name.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        self.definition.name
    }

    /// Deviation from theory in standard errors; `None` without theory or error, and within rounding errors.
    #[must_use]
    pub fn deviation_in_standard_errors(&self) -> Option<f64> {
        let deviation = Deviation::of(&self.estimate, self.theory, self.definition.rounding)?;
        deviation.in_standard_errors()
    }
}

/// Why a metric has no value in a recording that has the states of some frames only.
pub(crate) const NEEDS_ALL_STATES: &str = "it needs the states of all frames";

/// The metrics of a run, in the order in which they are derived. A value that is `None` adds no metric.
#[derive(Debug, Default)]
pub(crate) struct Measurements(pub(crate) Vec<Measurement>);

impl Measurements {
    /// Adds a value without a theoretical value.
    pub(crate) fn add(&mut self, definition: &'static Definition, value: impl Measured) {
        self.compare(definition, value, None::<f64>);
    }

    /// Adds a value with the theoretical value of the definition's first law, if there is one for this run.
    pub(crate) fn compare(
        &mut self,
        definition: &'static Definition,
        value: impl Measured,
        theory: impl Expected,
    ) {
        self.insert(definition, value, definition.laws.first(), theory);
    }

    /// Adds a value with the theoretical value of one of the definition's laws.
    pub(crate) fn compare_with(
        &mut self,
        definition: &'static Definition,
        value: impl Measured,
        law: impl Into<Option<Law>>,
        theory: impl Expected,
    ) {
        let law: Option<Law> = law.into();
        let own = law.and_then(|law| definition.laws.iter().find(|own| **own == law));
        debug_assert_eq!(own.is_some(), law.is_some());
        self.insert(definition, value, own, theory);
    }

    fn insert(
        &mut self,
        definition: &'static Definition,
        value: impl Measured,
        law: Option<&'static Law>,
        theory: impl Expected,
    ) {
        let Some(estimate) = value.estimate() else { return };
        let theory = theory.expected().map(|expected| expected.by(law));
        self.0.push(Measurement { definition, estimate, theory, reason: None });
    }

    /// Replaces the values that need the states of all frames by the reason, with the command that restores these.
    pub(crate) fn withhold(&mut self, needs_all: impl Fn(&Definition) -> bool, command: &str) {
        for found in &mut self.0 {
            if found.reason.is_none() && needs_all(found.definition)
                || found.reason.as_deref() == Some(NEEDS_ALL_STATES)
            {
                found.estimate = Estimate::bare(f64::NAN);
                found.theory = None;
                found.reason = Some(format!("{NEEDS_ALL_STATES}: `{command}`").into());
            }
        }
    }

    /// Adds a metric that applies to the run but has no value, with the reason.
    pub(crate) fn explain(
        &mut self,
        definition: &'static Definition,
        reason: impl Into<Cow<'static, str>>,
    ) {
        let estimate = Estimate::bare(f64::NAN);
        self.0.push(Measurement {
            definition,
            estimate,
            theory: None,
            reason: Some(reason.into()),
        });
    }
}

/// A value that may be missing and may have a standard error.
pub(crate) trait Measured {
    /// The value with its error.
    fn estimate(self) -> Option<Estimate>;
}

impl Measured for f64 {
    fn estimate(self) -> Option<Estimate> {
        Some(Estimate::bare(self))
    }
}

impl Measured for Estimate {
    fn estimate(self) -> Option<Estimate> {
        Some(self)
    }
}

impl<M: Measured> Measured for Option<M> {
    fn estimate(self) -> Option<Estimate> {
        self.and_then(M::estimate)
    }
}
