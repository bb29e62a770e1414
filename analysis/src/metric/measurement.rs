//! The metrics of one recording.

use crate::metric::definition::Definition;
use crate::metric::law::Law;
use crate::statistics::Estimate;

/// A value with its error and the theoretical value.
#[derive(Clone, Debug, PartialEq)]
pub struct Measurement {
    /// The metric.
    pub definition: &'static Definition,
    /// The value and its error.
    pub estimate: Estimate,
    /// The theoretical value.
    pub theory: Option<f64>,
    /// The law of the definition that gives the theoretical value.
    pub law: Option<Law>,
}

impl Measurement {
    /// The metric's name.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        self.definition.name
    }

    /// How the value is derived, and the law of the theoretical value.
    pub(crate) fn source(&self) -> String {
        match self.law {
            Some(law) => format!("{}; theory: {law}", self.definition.how),
            None => self.definition.how.to_owned(),
        }
    }
}

/// The metrics of a run, in the order in which they are derived. A value that is `None` adds no metric.
#[derive(Debug, Default)]
pub(crate) struct Measurements(pub(crate) Vec<Measurement>);

impl Measurements {
    /// Adds a value without a theoretical value.
    pub(crate) fn add(&mut self, definition: &'static Definition, value: impl Measured) {
        self.compare(definition, value, None);
    }

    /// Adds a value with the theoretical value of the definition's first law, if there is one for this run.
    pub(crate) fn compare(
        &mut self,
        definition: &'static Definition,
        value: impl Measured,
        theory: impl Into<Option<f64>>,
    ) {
        self.compare_with(definition, value, definition.laws.first().copied(), theory);
    }

    /// Adds a value with the theoretical value of one of the definition's laws.
    pub(crate) fn compare_with(
        &mut self,
        definition: &'static Definition,
        value: impl Measured,
        law: impl Into<Option<Law>>,
        theory: impl Into<Option<f64>>,
    ) {
        let Some(estimate) = value.estimate() else { return };
        let theory = theory.into();
        let law = law.into().filter(|_| theory.is_some());
        debug_assert!(law.is_none_or(|law| definition.laws.contains(&law)));
        self.0.push(Measurement { definition, estimate, theory, law });
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
