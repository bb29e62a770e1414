//! A number that was found in one recording.

use crate::laws::Law;
use crate::statistics::Estimate;

/// A named number with its unit, its error, theory's value and where both come from.
#[derive(Clone, Debug, PartialEq)]
pub struct Measurement {
    /// The metric's name.
    pub name: &'static str,
    /// Its unit; empty for a dimensionless one.
    pub unit: &'static str,
    /// The number and its error.
    pub estimate: Estimate,
    /// What theory says.
    pub theory: Option<f64>,
    /// Formula or reference in a few words.
    pub source: String,
}

impl Measurement {
    /// A number without a theory. `from` says in a few words how it was found.
    #[must_use]
    pub fn new(
        name: &'static str,
        unit: &'static str,
        estimate: impl Into<Estimate>,
        from: &str,
    ) -> Self {
        Self { name, unit, estimate: estimate.into(), theory: None, source: from.to_owned() }
    }

    /// The same beside what a law says, where it says something for this run.
    #[must_use]
    pub fn against(mut self, theory: impl Into<Option<f64>>, law: Law) -> Self {
        self.theory = theory.into();
        if self.theory.is_some() {
            self.source = format!("{}; theory: {law}", self.source);
        }
        self
    }
}
