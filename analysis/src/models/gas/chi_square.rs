//! Pearson's chi-square of a histogram.

/// Minimum expectation per bin.
const MIN_EXPECTED: f64 = 5.0;

/// Pearson's chi-square over bins in which enough is expected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ChiSquare {
    /// Mean over the bins of (count - expected)^2/expected.
    pub(super) per_bin: f64,
    /// The number of bins.
    pub(super) bins: f64,
}

impl ChiSquare {
    /// Merges bins of [count, expectation] from the first to the last until each expects enough, the rest into the last.
    /// `None` if there is no bin.
    pub(super) fn of(counts: impl Iterator<Item = [f64; 2]>) -> Option<Self> {
        let (mut merged, mut open): (Vec<[f64; 2]>, [f64; 2]) = (Vec::new(), [0.0; 2]);
        let add = |sum: &mut [f64; 2], [count, expected]: [f64; 2]| {
            sum[0] += count;
            sum[1] += expected;
        };
        for pair in counts {
            add(&mut open, pair);
            if open[1] >= MIN_EXPECTED {
                merged.push(std::mem::take(&mut open));
            }
        }
        add(merged.last_mut()?, open);
        let terms = merged.iter().map(|[count, expected]| (count - expected).powi(2) / expected);
        let bins = merged.len() as f64;
        Some(Self { per_bin: terms.sum::<f64>() / bins, bins })
    }

    /// Expectation per bin of counts under this many constraints: the degrees of freedom over the bins. `None` if no degree
    /// of freedom is left.
    pub(super) fn expected(&self, constraints: f64) -> Option<f64> {
        Some((self.bins - constraints) / self.bins).filter(|expected| *expected > 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_with_few_expected_counts_are_merged() {
        // Merged: [4, 6], [10, 8], [5, 6 + 1].
        let counts = [[1.0, 3.0], [3.0, 3.0], [10.0, 8.0], [4.0, 6.0], [1.0, 1.0]];
        let chi_square = ChiSquare::of(counts.into_iter()).unwrap();
        let expected = (4.0 / 6.0 + 4.0 / 8.0 + 4.0 / 7.0) / 3.0;
        assert!((chi_square.per_bin - expected).abs() < 1e-15, "{chi_square:?}");
        assert_eq!(chi_square.expected(1.0), Some(2.0 / 3.0));
        assert_eq!(chi_square.expected(3.0), None);
        assert!(ChiSquare::of([[1.0, 1.0]].into_iter()).is_none());
    }
}
