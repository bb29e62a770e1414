//! The theoretical value of a metric.

use crate::metric::law::Law;
use crate::metric::violation::Violation;

/// The theoretical value of a metric for one run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Theory {
    /// The value, in the metric's unit.
    pub value: f64,
    /// The accuracy of the law at this value, in the metric's unit; 0 for an exact law.
    pub accuracy: f64,
    /// The condition of the law that the run does not meet; `None` within the law's range. Outside, the value is not compared.
    pub violation: Option<Violation>,
    /// The law that gives the value.
    pub law: Option<&'static Law>,
}

impl Theory {
    /// Whether the run is in the law's range.
    #[must_use]
    pub const fn in_range(&self) -> bool {
        self.violation.is_none()
    }

    /// The value; `None` outside the law's range.
    pub(crate) fn applicable(&self) -> Option<f64> {
        self.in_range().then_some(self.value)
    }

    /// States that the run is outside the range of the law, with the condition that fails, and the range; `None` within it.
    pub(crate) fn out_of_range(&self) -> Option<String> {
        let what = format!("the run is outside the range of its law: {}", self.violation?);
        Some(match self.law.map_or("", |law| law.range) {
            "" => what,
            range => format!("{what} (range: {range})"),
        })
    }
}

/// A value expected by a law, before it is known which law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ExpectedValue {
    /// The value, in the metric's unit.
    pub(crate) value: f64,
    /// The accuracy in the metric's unit; `None` for the law's relative accuracy.
    pub(crate) accuracy: Option<f64>,
    /// The condition of the law that the run does not meet; `None` within the law's range.
    pub(crate) violation: Option<Violation>,
}

impl ExpectedValue {
    /// The theoretical value by a law.
    pub(crate) fn by(self, law: Option<&'static Law>) -> Theory {
        let relative_accuracy = law.map_or(0.0, |law| law.relative_accuracy);
        let accuracy = self.accuracy.unwrap_or_else(|| relative_accuracy * self.value.abs());
        Theory { value: self.value, accuracy, violation: self.violation, law }
    }
}

/// A theoretical value that may be missing.
pub(crate) trait Expected {
    /// The value, with its accuracy and whether the law applies.
    fn expected(self) -> Option<ExpectedValue>;
}

impl Expected for ExpectedValue {
    fn expected(self) -> Option<ExpectedValue> {
        Some(self)
    }
}

impl Expected for f64 {
    fn expected(self) -> Option<ExpectedValue> {
        Some(ExpectedValue { value: self, accuracy: None, violation: None })
    }
}

impl<E: Expected> Expected for Option<E> {
    fn expected(self) -> Option<ExpectedValue> {
        self.and_then(E::expected)
    }
}
