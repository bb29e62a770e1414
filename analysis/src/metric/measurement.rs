//! A number that was found in one recording.

use crate::metric::definition::Definition;
use crate::metric::law::Law;
use crate::statistics::Estimate;

/// A number with its error, beside theory's value.
#[derive(Clone, Debug, PartialEq)]
pub struct Measurement {
    /// What it is.
    pub definition: &'static Definition,
    /// The number and its error.
    pub estimate: Estimate,
    /// What theory says.
    pub theory: Option<f64>,
    /// Which of the definition's laws says it.
    pub law: Option<Law>,
}

impl Measurement {
    /// A number without a theory.
    #[must_use]
    pub fn new(definition: &'static Definition, estimate: impl Into<Estimate>) -> Self {
        Self { definition, estimate: estimate.into(), theory: None, law: None }
    }

    /// The same beside what the definition's first law says, where it says something for this run.
    #[must_use]
    pub fn against(self, theory: impl Into<Option<f64>>) -> Self {
        let law = self.definition.laws.first().copied();
        self.against_law(theory, law)
    }

    /// The same beside what one of the definition's laws says.
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

    /// Its name.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        self.definition.name
    }

    /// How it was found, and where theory's value comes from.
    #[must_use]
    pub fn source(&self) -> String {
        match self.law {
            Some(law) => format!("{}; theory: {law}", self.definition.how),
            None => self.definition.how.to_owned(),
        }
    }
}
