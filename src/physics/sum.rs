//! Compensated sums, shared by the models.

use serde::{Deserialize, Serialize};

/// Sum with a separate sum of its rounding errors (Neumaier, Z. angew. Math. Mech. 54 (1974) 39). The last bits of the result still
/// depend on the order of the terms.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CompensatedSum {
    sum: f64,
    lost: f64,
}

impl CompensatedSum {
    /// Adds a term.
    pub fn add(&mut self, term: f64) {
        let next = self.sum + term;
        self.lost += if self.sum.abs() >= term.abs() {
            (self.sum - next) + term
        } else {
            (term - next) + self.sum
        };
        self.sum = next;
    }

    /// Whether the sum is a number.
    pub(crate) fn is_finite(&self) -> bool {
        self.sum.is_finite() && self.lost.is_finite()
    }

    /// Value of the sum.
    #[must_use]
    pub fn value(&self) -> f64 {
        self.sum + self.lost
    }
}

impl FromIterator<f64> for CompensatedSum {
    fn from_iter<I: IntoIterator<Item = f64>>(terms: I) -> Self {
        let mut sum = Self::default();
        for term in terms {
            sum.add(term);
        }
        sum
    }
}
