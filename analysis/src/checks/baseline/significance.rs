//! Significance of differences between runs with other seeds: Student's t, and Holm's correction for several metrics.

use crate::statistics::students_t::{normal_equivalent, two_sided_probability};

/// Probability that chance fails the comparison of an unchanged experiment, for all of its metrics together.
///
/// Of 40 correct seeds against one, 0.04 fail on average. Seeds that are compared with the same baseline are not independent:
/// with errors that are 20 % too small and 20 metrics, 0.5 of 40 fail, and more than two of 40 in 1 % of all baselines.
pub(super) const FAMILY_LEVEL: f64 = 1e-3;

/// A value with its standard error and its degrees of freedom; `None` for an error as good as exact.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    pub(super) value: f64,
    pub(super) error: f64,
    pub(super) degrees_of_freedom: Option<f64>,
}

/// The difference of two independent values in units of its error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Significance {
    /// Probability that chance gives this difference or a larger one.
    pub(crate) probability: f64,
    /// The deviation of a normal distribution with this probability.
    pub(crate) sigma: f64,
    /// Degrees of freedom of the combined error.
    pub(crate) degrees_of_freedom: Option<f64>,
}

impl Significance {
    /// Of the difference of two values, by their combined error with the degrees of freedom of Welch (1947) and
    /// Satterthwaite (1946).
    pub(super) fn of(one: Sample, other: Sample) -> Self {
        let combined = libm::hypot(one.error, other.error);
        let t = (one.value - other.value).abs() / combined;
        let inverse: f64 = [one, other]
            .iter()
            .filter_map(|sample| {
                Some((sample.error / combined).powi(4) / sample.degrees_of_freedom?)
            })
            .sum();
        let degrees_of_freedom = (inverse > 0.0).then(|| 1.0 / inverse);
        let probability = two_sided_probability(t, degrees_of_freedom);
        let sigma = degrees_of_freedom.map_or(t, |freedom| normal_equivalent(t, freedom));
        Self { probability, sigma, degrees_of_freedom }
    }

    /// Of a difference within rounding errors.
    pub(super) const fn none() -> Self {
        Self { probability: 1.0, sigma: 0.0, degrees_of_freedom: None }
    }
}

/// Which differences are significant at a family-wise level (Holm 1979, Scand. J. Stat. 6, 65), in the order of the
/// probabilities.
pub(super) fn holm(probabilities: &[f64], level: f64) -> Vec<bool> {
    let mut order: Vec<usize> = (0..probabilities.len()).collect();
    order.sort_by(|one, other| probabilities[*one].total_cmp(&probabilities[*other]));
    let mut is_significant = vec![false; probabilities.len()];
    for (rank, &index) in order.iter().enumerate() {
        if probabilities[index] * (probabilities.len() - rank) as f64 > level {
            break;
        }
        is_significant[index] = true;
    }
    is_significant
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::SQRT_2;

    /// Law: equal errors with ν degrees of freedom each have 2ν together; an exact error adds none to the sum.
    #[test]
    fn degrees_of_freedom_follow_welch_and_satterthwaite() {
        let sample = |value, degrees_of_freedom| Sample { value, error: 0.5, degrees_of_freedom };
        let found = Significance::of(sample(1.0, Some(3.0)), sample(2.0, Some(3.0)));
        assert!((found.degrees_of_freedom.unwrap() - 6.0).abs() < 1e-12);
        let found = Significance::of(sample(1.0, Some(3.0)), sample(2.0, None));
        assert!((found.degrees_of_freedom.unwrap() - 12.0).abs() < 1e-12);
        let found = Significance::of(sample(1.0, None), sample(2.0, None));
        assert_eq!(found.degrees_of_freedom, None);
        assert!((found.sigma - SQRT_2).abs() < 1e-9, "{found:?}");
    }

    /// Source: Holm's procedure by hand: 0.01 × 4, 0.02 × 3, 0.03 × 2, 0.04 × 1 at level 0.05: only the first is significant.
    #[test]
    fn holm_stops_at_the_first_difference_that_is_not_significant() {
        assert_eq!(holm(&[0.04, 0.01, 0.02, 0.03], 0.05), [false, true, false, false]);
        assert_eq!(holm(&[0.04, 0.001, 0.002, 0.003], 0.05), [true; 4]);
        assert!(holm(&[], 0.05).is_empty());
    }
}
