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
    /// Standard deviation of `per_bin` from sample to sample of any distribution, by the linear order in its counts and that of chi-square.
    pub(super) scatter: f64,
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
        let per_bin = terms.sum::<f64>() / bins;
        Some(Self { per_bin, bins, scatter: variance_of_any_distribution(&merged).sqrt() / bins })
    }

    /// Expectation per bin of counts under this many constraints: the degrees of freedom over the bins. `None` if no degree
    /// of freedom is left.
    pub(super) fn expected(&self, constraints: f64) -> Option<f64> {
        Some((self.bins - constraints) / self.bins).filter(|expected| *expected > 0.0)
    }
}

/// Variance of chi-square for a multinomial distribution other than the expected one: that of its derivatives by the counts, from which
/// the part of the scatter of the counts is subtracted, and at least 2 (bins - 1), that of the expected distribution.
fn variance_of_any_distribution(merged: &[[f64; 2]]) -> f64 {
    let [mut counted, mut first, mut second] = [0.0; 3];
    for [count, expected] in merged {
        let slope = 2.0 * (count - expected) / expected;
        counted += count;
        first += slope * count;
        second += slope * slope * count;
    }
    let by_counts = if counted > 0.0 { second - first * first / counted } else { 0.0 };
    let expected = 2.0 * (merged.len() as f64 - 1.0);
    if by_counts - expected > expected { by_counts - expected } else { expected }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::random::Uniform;
    use crate::statistics::standard_deviation;

    /// Law: chi-square of 500 independent particles scatters by the stated standard deviation, also if their distribution is not the
    /// expected one. Setup: 400 samples in 20 bins; half of the particles fill 20, 10 or 4 of them. Tolerance: 3.5 % for the scatter of
    /// a standard deviation; the larger one of two variances is up to 30 % too large where both are alike, for 20 filled bins.
    /// Control: by the expected distribution, the standard deviation is a third and a ninth of the scatter for 10 and 4 bins.
    #[test]
    fn scatter_includes_other_distributions() {
        let mut uniform = Uniform(11);
        for (filled, control) in [(20.0, 0.85..1.15), (10.0, 2.0..9.0), (4.0, 5.0..20.0)] {
            let (mut values, mut scatter, mut bins) = (Vec::new(), 0.0, 0.0);
            for _ in 0..400 {
                let mut counts = [[0.0, 25.0]; 20];
                for _ in 0..500 {
                    let width = if uniform.next() < 0.5 { filled } else { 20.0 };
                    counts[(uniform.next() * width) as usize][0] += 1.0;
                }
                let found = ChiSquare::of(counts.into_iter()).unwrap();
                values.push(found.per_bin);
                scatter += found.scatter * found.scatter / 400.0;
                bins = found.bins;
            }
            let std = standard_deviation(&values).unwrap();
            let ratio = std / scatter.sqrt();
            assert!((0.8..1.1).contains(&ratio), "{filled}: {ratio}");
            let by_law = std / ((2.0 * (bins - 1.0)).sqrt() / bins);
            assert!(control.contains(&by_law), "control, {filled}: {by_law}");
        }
    }

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
