//! Significance of differences between runs with other seeds: Student's t, and Holm's correction for several metrics.

use crate::statistics::students_t::{normal_equivalent, two_sided_probability, two_sided_quantile};

/// Probability that chance fails the comparison of an unchanged experiment, for all of its metrics together.
///
/// Of 40 correct seeds against one, 0.04 fail on average. Seeds that are compared with the same baseline are not independent:
/// with errors that are 20 % too small and 20 metrics, 0.5 of 40 fail, and more than two of 40 in 1 % of all baselines.
pub(super) const FAMILY_LEVEL: f64 = 1e-3;

/// Probability that a change of the least detectable size is found.
pub(super) const POWER: f64 = 0.95;

/// A value with its standard error and its degrees of freedom; `None` for a normal distribution, and an error as good as exact.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    pub(super) value: f64,
    pub(super) error: f64,
    pub(super) degrees_of_freedom: Option<f64>,
}

impl Sample {
    /// Another value with the same scatter; `None` without one.
    pub(super) fn with_value(self, value: Option<f64>) -> Option<Self> {
        Some(Self { value: value?, ..self })
    }
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
    /// The combined error, in the metric's unit.
    pub(super) error: f64,
    /// Whether this error is itself a rounding error, so that it is no scatter.
    pub(super) is_of_rounding: bool,
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
        Self { probability, sigma, degrees_of_freedom, error: combined, is_of_rounding: false }
    }

    /// The same comparison of a difference that is a rounding error.
    pub(super) const fn of_equal_values(self) -> Self {
        Self { probability: 1.0, sigma: 0.0, ..self }
    }

    /// The same comparison, in which errors up to this one are rounding errors.
    pub(super) fn with_rounding(self, rounding: f64) -> Self {
        Self { is_of_rounding: self.error <= rounding, ..self }
    }

    /// The least change that a test at this level finds with the probability [`POWER`], in the metric's unit: (t_α + t_β) s with
    /// the combined error s, the quantile t_α at the level and the one-sided quantile t_β at 1 - [`POWER`]. A change δ is found if
    /// δ + ε > t_α s, and ε/s, the chance deviation over the measured error, is above -t_β with the probability [`POWER`]. `None`
    /// if the error is a rounding error.
    pub(super) fn least_detectable(self, level: f64) -> Option<f64> {
        let quantile = |probability| two_sided_quantile(probability, self.degrees_of_freedom);
        let factor = || quantile(level) + quantile(2.0 * (1.0 - POWER));
        (!self.is_of_rounding).then(|| factor() * self.error)
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
    use crate::statistics::mean_of_independent;
    use crate::statistics::random::Uniform;
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

    /// Law: a change of the size that a comparison states as its least detectable one is found in 95 % of all comparisons. Setup: 2000 pairs
    /// of means of 4 and of 8 normal values, at a level of 1e-4, and pairs with exact errors. Tolerance: 0.93 to 0.98, four standard errors
    /// and what Welch's degrees of freedom are too few. Source of the factors: the distribution function of Student's t for 6 degrees of
    /// freedom in closed form, and erfc. Control: of changes of half the size, fewer than 25 % are found.
    #[test]
    fn changes_of_the_least_detectable_size_are_found() {
        // docs/statistics.md states the factors of 20 metrics: 12.2 and 5.70.
        for (degrees_of_freedom, factor) in [(Some(6.0), 12.204), (None, 5.700)] {
            let exact = |value| Sample { value, error: 1.0, degrees_of_freedom };
            let known = Significance {
                degrees_of_freedom,
                error: 1.0,
                ..Significance::of(exact(0.0), exact(1.0))
            };
            let least = known.least_detectable(FAMILY_LEVEL / 20.0).unwrap();
            assert!((least - factor).abs() < 1e-3);
        }
        let level = 1e-4;
        for replicates in [Some(4), Some(8), None] {
            let mut uniform = Uniform(46);
            let mut sample = || {
                let Some(count) = replicates else {
                    let value = uniform.normal();
                    return Sample { value, error: 1.0, degrees_of_freedom: None };
                };
                let values: Vec<f64> = (0..count).map(|_| uniform.normal()).collect();
                let mean = mean_of_independent(&values).unwrap();
                let (value, error) = (mean.value, mean.standard_error.unwrap());
                Sample { value, error, degrees_of_freedom: mean.degrees_of_freedom }
            };
            let (mut found, mut found_half) = (0, 0);
            for _ in 0..2000 {
                let (before, now) = (sample(), sample());
                let size = Significance::of(before, now).least_detectable(level).unwrap();
                let is_found = |change: f64| {
                    let changed = Sample { value: now.value + change, ..now };
                    Significance::of(before, changed).probability < level
                };
                found += u32::from(is_found(size));
                found_half += u32::from(is_found(size / 2.0));
            }
            println!("{replicates:?}: {found} of 2000 are found, {found_half} of half the size");
            assert!((1860..1960).contains(&found), "{replicates:?}: {found} of 2000");
            assert!(found_half < 500, "control, {replicates:?}: {found_half} of 2000");
        }
    }

    /// Law: the difference of two mean squares of normal values, whose errors follow from a formula, exceeds what Student's t with half of their
    /// number k of values for each allows in at most the stated fraction of all cases. Setup: 200,000 pairs for each k, at a level of 1e-3. Control: by a normal
    /// distribution, more than three times as many do: 1 % for k = 2, whose difference has a Laplace distribution.
    #[test]
    fn mean_squares_of_few_values_do_not_differ_by_chance() {
        const PAIRS: u32 = 200_000;
        let mut uniform = Uniform(2);
        for values in [2_u32, 4, 8] {
            let freedom = f64::from(values);
            let error = (2.0 / freedom).sqrt();
            let mut mean_square =
                || (0..values).map(|_| uniform.normal().powi(2)).sum::<f64>() / freedom;
            let (mut beyond, mut beyond_normal) = (0, 0);
            for _ in 0..PAIRS {
                let [one, other] = [mean_square(), mean_square()];
                let probability = |degrees_of_freedom: Option<f64>| {
                    let sample = |value| Sample { value, error, degrees_of_freedom };
                    Significance::of(sample(one), sample(other)).probability
                };
                beyond += u32::from(probability(Some(freedom / 2.0)) < 1e-3);
                beyond_normal += u32::from(probability(None) < 1e-3);
            }
            println!("{values}: {beyond} of {PAIRS}, {beyond_normal} by a normal distribution");
            assert!(beyond <= PAIRS / 1000, "{values}: {beyond}");
            assert!(beyond_normal > 3 * PAIRS / 1000, "control, {values}: {beyond_normal}");
        }
    }

    /// Source: Holm's procedure by hand: 0.01 × 4, 0.02 × 3, 0.03 × 2, 0.04 × 1 at level 0.05: only the first is significant.
    #[test]
    fn holm_stops_at_the_first_difference_that_is_not_significant() {
        assert_eq!(holm(&[0.04, 0.01, 0.02, 0.03], 0.05), [false, true, false, false]);
        assert_eq!(holm(&[0.04, 0.001, 0.002, 0.003], 0.05), [true; 4]);
        assert!(holm(&[], 0.05).is_empty());
    }
}
