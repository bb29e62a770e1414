//! A metric of one recording.

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
    /// A value without a theoretical value.
    #[must_use]
    pub fn new(definition: &'static Definition, estimate: impl Into<Estimate>) -> Self {
        Self { definition, estimate: estimate.into(), theory: None, law: None }
    }

    /// Adds the theoretical value of the definition's first law, if there is one for this run.
    #[must_use]
    pub fn against(self, theory: impl Into<Option<f64>>) -> Self {
        let law = self.definition.laws.first().copied();
        self.against_law(theory, law)
    }

    /// Adds the theoretical value of one of the definition's laws.
    #[must_use]
    pub fn against_law(
        mut self,
        theory: impl Into<Option<f64>>,
        law: impl Into<Option<Law>>,
    ) -> Self {
        self.theory = theory.into();
        self.law = law.into().filter(|_| self.theory.is_some());
        debug_assert!(self.law.is_none_or(|law| self.definition.laws.contains(&law)));
        self
    }

    /// The metric's name.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        self.definition.name
    }

    /// How the value is derived, and the law of the theoretical value.
    #[must_use]
    pub fn source(&self) -> String {
        match self.law {
            Some(law) => format!("{}; theory: {law}", self.definition.how),
            None => self.definition.how.to_owned(),
        }
    }
}
