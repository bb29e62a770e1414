//! Blocking of correlated series.

use super::estimate::Estimate;
use super::missing_error::{Entries, MissingError};
use super::sums::Sum;

/// One level of blocking: moments of the pairs (x, w), each the sum over a block of 2^level entries.
#[derive(Clone, Copy, Debug, Default)]
struct Level {
    blocks: u64,
    xx: Sum,
    xw: Sum,
    ww: Sum,
    pending: Option<(f64, f64)>,
}

/// Weighted mean of a correlated series with its error by blocking (Flyvbjerg and Petersen 1989). Memory grows with the
/// logarithm of the length. The mean is sum(w x) / sum(w); with window lengths as weights it is a rate.
///
/// The block length is the smallest power of two B with B^3 > 2 n (error at B / error at 1)^4 (Lee et al. 2011, Phys.
/// Rev. E 83, 066706), or else the longest of which the series has [`MIN_BLOCKS`]. For an anticorrelated series, whose error
/// decreases with B, the inverse ratio counts. The error has as many degrees of
/// freedom as there are blocks, minus one, over the square of the factor by which the correction for correlated blocks amplifies
/// the scatter of the error. They may be fewer than one, for an error that is too large. An error is not withheld because of them:
/// those that remain would be the ones that came out too small. Whether there is an error depends on the number of entries, and not
/// on the values, except for series that are correlated over more than half of the longest block.
#[derive(Clone, Debug, Default)]
pub(crate) struct Blocking {
    kind: Entries,
    origin: Option<f64>,
    entries: u64,
    total: Sum,
    weight: Sum,
    levels: Vec<Level>,
}

/// Minimum number of entries for an error estimate: eight blocks of the shortest length that Lee's criterion accepts.
const MIN_ENTRIES: u64 = 64;
/// Minimum number of blocks for an error estimate.
const MIN_BLOCKS: u64 = 8;
/// Minimum length of blocks over that of a known correlation.
const MIN_BLOCK_OVER_CORRELATION: f64 = 3.0;
/// Maximum ratio of the statistical inefficiency of block means to their length, which is 1 for a series that drifts.
const MAX_INEFFICIENCY_OVER_BLOCK: f64 = 0.8;
/// Minimum of the root in the correction for correlated blocks, which limits its scatter.
const MIN_ROOT: f64 = 0.25;

impl Blocking {
    /// Creates an empty series of these entries, which are named where there are too few of them.
    pub(crate) fn of(kind: Entries) -> Self {
        Self { kind, ..Self::default() }
    }

    /// Adds the next value with weight 1.
    pub(crate) fn add(&mut self, value: f64) {
        self.add_weighted(value, 1.0);
    }

    /// Adds an amount accumulated over a window of this length; the estimate is amount per length.
    pub(crate) fn add_amount(&mut self, amount: f64, length: f64) {
        // Entries are stored relative to the first value, so that a nearly constant series keeps its digits.
        let first = if length > 0.0 { amount / length } else { 0.0 };
        let origin = *self.origin.get_or_insert(first);
        let (mut x, mut w) = (amount - origin * length, length);
        self.entries += 1;
        self.total.add(x);
        self.weight.add(w);
        let mut depth = 0;
        loop {
            if self.levels.len() == depth {
                self.levels.push(Level::default());
            }
            let level = &mut self.levels[depth];
            level.blocks += 1;
            level.xx.add(x * x);
            level.xw.add(x * w);
            level.ww.add(w * w);
            match level.pending.take() {
                None => {
                    level.pending = Some((x, w));
                    return;
                }
                Some((earlier_x, earlier_w)) => {
                    x += earlier_x;
                    w += earlier_w;
                    depth += 1;
                }
            }
        }
    }

    /// Adds the next value with a non-negative weight, such as its duration.
    pub(crate) fn add_weighted(&mut self, value: f64, weight: f64) {
        self.add_amount(value * weight, weight);
    }

    /// Number of entries.
    pub(crate) const fn entries(&self) -> u64 {
        self.entries
    }

    /// Weighted mean and its error; `None` while all weights are zero.
    pub(crate) fn estimate(&self) -> Option<Estimate> {
        let weight = self.weight.value();
        if weight.is_nan() || weight <= 0.0 {
            return None;
        }
        let excess = self.total.value() / weight;
        let value = Estimate::bare(self.origin.unwrap_or(0.0) + excess);
        Some(match self.standard_error(excess) {
            Ok(found) => Estimate::new(value.value, found.error)
                .with_degrees_of_freedom(found.degrees_of_freedom),
            Err(reason) => value.without_error(reason),
        })
    }

    /// Weighted mean of a series with a known correlation, and its error by the longest blocks of which there are [`MIN_BLOCKS`]; `None`
    /// while all weights are zero.
    ///
    /// The correlation is the weight over which it decays to 1/e. Blocks of a weight B have means whose variance is too small by
    /// 1 - correlation/B, which is corrected. Whether there is an error depends on the weights only: blocks shorter than
    /// [`MIN_BLOCK_OVER_CORRELATION`] correlations have none.
    pub(crate) fn estimate_with_correlation(&self, correlation: f64) -> Option<Estimate> {
        let weight = self.weight.value();
        if weight.is_nan() || weight <= 0.0 {
            return None;
        }
        let excess = self.total.value() / weight;
        let value = Estimate::bare(self.origin.unwrap_or(0.0) + excess);
        let Some(level) = self.levels.iter().rfind(|level| level.blocks >= MIN_BLOCKS) else {
            let (entries, needs, has) = (self.kind, MIN_BLOCKS, self.entries);
            return Some(value.without_error(MissingError::TooFewEntries { entries, needs, has }));
        };
        let block = self.block_weight(level);
        if block < MIN_BLOCK_OVER_CORRELATION * correlation {
            return Some(value.without_error(MissingError::TooCorrelated(self.kind)));
        }
        let error = self.error_at(level, excess) / (1.0 - correlation / block).sqrt();
        Some(Estimate::new(value.value, error).with_degrees_of_freedom(level.blocks as f64 - 1.0))
    }

    /// Standard error of the mean with blocks of one level, by the linearized ratio: variance of sum(x - R w) over (sum
    /// w)^2.
    fn error_at(&self, level: &Level, excess: f64) -> f64 {
        let blocks = level.blocks as f64;
        let squares =
            level.xx.value() - 2.0 * excess * level.xw.value() + excess * excess * level.ww.value();
        let scatter = if squares > 0.0 { squares } else { 0.0 };
        // The incomplete last block is excluded from the scatter. The variance of a mean is proportional to 1/weight.
        let complete = blocks * self.block_weight(level);
        (scatter * blocks / (blocks - 1.0) / (complete * self.weight.value())).sqrt()
    }

    /// Mean weight per block of this level.
    fn block_weight(&self, level: &Level) -> f64 {
        let entries_per_block = self.levels[0].blocks as f64 / level.blocks as f64;
        self.weight.value() / self.entries as f64 * entries_per_block
    }

    fn standard_error(&self, excess: f64) -> Result<BlockingError, MissingError> {
        let too_few = MissingError::TooFewEntries {
            entries: self.kind,
            needs: MIN_ENTRIES,
            has: self.entries,
        };
        let first = self.levels.first().filter(|_| self.entries >= MIN_ENTRIES).ok_or(too_few)?;
        let plain = self.error_at(first, excess);
        if plain == 0.0 && self.origin == Some(0.0) {
            return Err(MissingError::NothingCounted);
        }
        if plain == 0.0 {
            let degrees_of_freedom = first.blocks as f64 - 1.0;
            return Ok(BlockingError { error: 0.0, degrees_of_freedom });
        }
        let (mut length, mut longest) = (1.0, None);
        for level in self.levels.iter().take_while(|level| level.blocks >= MIN_BLOCKS) {
            let error = self.error_at(level, excess);
            let inefficiency = (error / plain) * (error / plain);
            let change = inefficiency.max(1.0 / inefficiency);
            longest = BlockingError::corrected(error, inefficiency, length, level.blocks);
            if length * length * length > 2.0 * self.entries as f64 * change * change {
                break;
            }
            length *= 2.0;
        }
        longest.ok_or(MissingError::TooCorrelated(self.kind))
    }
}

/// A standard error by blocking.
#[derive(Clone, Copy, Debug, PartialEq)]
struct BlockingError {
    error: f64,
    degrees_of_freedom: f64,
}

impl BlockingError {
    /// The error of the mean from that of blocks with a length B, corrected for their correlation.
    ///
    /// The inefficiency s is the variance of the mean over that of as many independent entries. For correlations that decay
    /// exponentially, that of the block means is s - (s^2 - 1)/(2B) for B longer than the correlation; this is solved for s. The
    /// correction increases the scatter of the error, so there are fewer degrees of freedom. `None` if the inefficiency exceeds
    /// [`MAX_INEFFICIENCY_OVER_BLOCK`].
    fn corrected(error: f64, inefficiency: f64, length: f64, blocks: u64) -> Option<Self> {
        if inefficiency > MAX_INEFFICIENCY_OVER_BLOCK * length {
            return None;
        }
        let square = 1.0 - (2.0 * inefficiency - 1.0 / length) / length;
        let root = square.max(MIN_ROOT * MIN_ROOT).sqrt();
        let corrected = length * (1.0 - root);
        // The correction of a strongly anticorrelated series would be as large as its error.
        let ratio = if inefficiency > 0.0 { (corrected / inefficiency).max(0.5) } else { 1.0 };
        let amplified = root.recip() / ratio;
        Some(Self {
            error: error * ratio.sqrt(),
            degrees_of_freedom: (blocks as f64 - 1.0) / (amplified * amplified).max(1.0),
        })
        .filter(|found| found.error.is_finite())
    }
}

impl FromIterator<f64> for Blocking {
    fn from_iter<I: IntoIterator<Item = f64>>(values: I) -> Self {
        let mut blocking = Self::default();
        values.into_iter().for_each(|value| blocking.add(value));
        blocking
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::random::Uniform;
    use crate::statistics::students_t::normal_equivalent;

    #[test]
    fn a_rate_is_amount_per_length() {
        let mut blocking = Blocking::default();
        for window in 1..=100 {
            blocking.add_amount(2.5 * f64::from(window), f64::from(window));
        }
        let estimate = blocking.estimate().unwrap();
        assert!((estimate.value - 2.5).abs() < 1e-15);
        assert!(estimate.standard_error.unwrap() < 1e-14);
    }

    /// Control: a constant rate has an error of zero.
    #[test]
    fn a_series_without_events_has_no_error() {
        let (mut none, mut constant) = (Blocking::default(), Blocking::default());
        for _ in 0..100 {
            none.add_amount(0.0, 1.0);
            constant.add_amount(2.0, 1.0);
        }
        let found = none.estimate().unwrap();
        assert_eq!((found.value, found.standard_error), (0.0, None));
        assert_eq!(found.missing_error, Some(MissingError::NothingCounted));
        assert_eq!(constant.estimate().unwrap().standard_error, Some(0.0));
    }

    #[test]
    fn a_nearly_constant_series_keeps_its_digits() {
        let series: Blocking =
            (0..1000).map(|index| 1e9 + if index % 2 == 0 { 1e-3 } else { -1e-3 }).collect();
        let estimate = series.estimate().unwrap();
        assert!((estimate.value - 1e9).abs() < 1e-6);
        assert!(estimate.standard_error.unwrap() < 1e-4);
    }

    #[test]
    fn a_series_too_short_for_its_correlation_has_no_error() {
        let drift: Blocking = (0..64).map(f64::from).collect();
        assert_eq!(
            drift.estimate().unwrap(),
            Estimate::bare(31.5).without_error(MissingError::TooCorrelated(Entries::Frames))
        );
        let short: Blocking = (0..50).map(|entry| f64::from(entry % 2)).collect();
        let reason = short.estimate().unwrap().missing_error.unwrap();
        assert_eq!(reason.to_string(), "a standard error needs 64 frames, the run has 50");
    }

    /// Law: the 95 % interval, value +- 1.96 errors, covers the mean of correlated noise in 92 to 98 of 100 cases. Setup: 1000
    /// series each of 4096 and of 16384 entries, x(i+1) = rho x(i) + sqrt(1 - rho^2) g. The binomial scatter is 0.7 %; a blocking
    /// error has a scatter of its own, which takes about a percent off. Control: the plain error s/sqrt(n) covers far less.
    #[test]
    fn the_95_per_cent_interval_covers_correlated_noise() {
        const SERIES: u32 = 1000;
        for (rho, length) in [(0.0, 4096), (0.6, 4096), (0.9, 4096), (0.9, 16384)] {
            let mut uniform = Uniform(2026);
            let (mut covered, mut covered_by_plain) = (0_u32, 0_u32);
            for _ in 0..SERIES {
                let series: Blocking = uniform.correlated(rho, length).collect();
                let estimate = series.estimate().unwrap();
                let within = |error: f64| u32::from(estimate.value.abs() < 1.96 * error);
                let excess = series.total.value() / series.weight.value();
                covered += within(estimate.standard_error.unwrap());
                covered_by_plain += within(series.error_at(&series.levels[0], excess));
            }
            let share = f64::from(covered) / f64::from(SERIES);
            let plain = f64::from(covered_by_plain) / f64::from(SERIES);
            println!(
                "rho {rho}, {length} entries: {share:.4} covered, {plain:.4} by the plain error"
            );
            assert!((0.92..=0.98).contains(&share), "rho {rho}: {share}");
            assert!(rho == 0.0 || plain < 0.92, "rho {rho}: {plain}");
        }
    }

    /// Law: for x(i+1) = rho x(i) + sqrt(1 - rho^2) g the mean over n has variance (1 + rho) / ((1 - rho) n), for n much
    /// longer than the correlation. Setup: 400 series of 4096. Tolerance: the mean blocking error within 10 % of the exact
    /// one (measured 3 % low), and 62–74 % of the means within one error (binomial scatter 2.3 %).
    #[test]
    fn blocking_error_covers_the_mean_of_correlated_noise() {
        for rho in [0.0, 0.6, 0.9] {
            let mut uniform = Uniform(14);
            let (mut inside, mut errors) = (0, Sum::default());
            for _ in 0..400 {
                let series: Blocking = uniform.correlated(rho, 4096).collect();
                let estimate = series.estimate().unwrap();
                let error = estimate.standard_error.unwrap();
                errors.add(error / 400.0);
                inside += i32::from(estimate.value.abs() < error);
            }
            let exact = ((1.0 + rho) / ((1.0 - rho) * 4096.0)).sqrt();
            let ratio = errors.value() / exact;
            println!("rho {rho}: error {ratio:.3} of the exact one, {inside} of 400 inside");
            assert!((0.9..1.1).contains(&ratio), "rho {rho}: {ratio}");
            assert!((248..=296).contains(&inside), "rho {rho}: {inside} of 400");
        }
    }

    /// Law: for x(i+1) = rho x(i) + sqrt(1 - rho^2) g, whose correlation decays over -1/ln rho, deviations by Student's t have the
    /// standard deviation 1, and every series has an error with at least seven degrees of freedom. Setup: 1000 series of 320 entries, 40
    /// correlations. Tolerance: 2.2 % of binomial scatter, and the second order of the correction. Control: a series that is shorter
    /// than eight blocks of three correlations has no error.
    #[test]
    fn known_correlation_gives_every_seed_an_error() {
        let rho = libm::exp(-1.0 / 8.0);
        let mut uniform = Uniform(7);
        let mut squares = 0.0;
        for _ in 0..1000 {
            let series: Blocking = uniform.correlated(rho, 320).collect();
            let estimate = series.estimate_with_correlation(8.0).unwrap();
            let freedom = estimate.degrees_of_freedom.unwrap();
            assert!(freedom >= 7.0, "{freedom}");
            let sigma =
                normal_equivalent(estimate.value / estimate.standard_error.unwrap(), freedom);
            squares += sigma * sigma;
        }
        let std = (squares / 1000.0_f64).sqrt();
        assert!((0.9..1.15).contains(&std), "{std}");
        let short: Blocking = uniform.correlated(rho, 160).collect();
        let short = short.estimate_with_correlation(8.0).unwrap();
        assert_eq!(short.missing_error, Some(MissingError::TooCorrelated(Entries::Frames)));
    }

    /// Law: with few degrees of freedom, deviations by Student's t have the standard deviation 1 over all seeds, and 95 % of them are
    /// below 1.96. Setup: 2000 series each of which eight blocks are four to ten correlation times long. Tolerance: 1.6 % of binomial
    /// scatter, and an error that is up to 10 % too large where blocks are hardly longer than a correlation. Control: the errors with at
    /// least four degrees of freedom are those that came out small, so they alone cover less.
    #[test]
    fn errors_with_few_degrees_of_freedom_cover_over_all_seeds() {
        for (rho, length) in [(0.6, 64), (0.8, 128), (0.9, 256)] {
            let mut uniform = Uniform(46);
            let (mut all, mut many) = (Vec::new(), Vec::new());
            for _ in 0..2000 {
                let series: Blocking = uniform.correlated(rho, length).collect();
                let estimate = series.estimate().unwrap();
                let Some(error) = estimate.standard_error else { continue };
                let freedom = estimate.degrees_of_freedom.unwrap();
                let sigma = normal_equivalent(estimate.value / error, freedom).abs();
                all.push(sigma);
                many.extend((freedom >= 4.0).then_some(sigma));
            }
            let [std, std_of_many] = [&all, &many].map(|list| {
                (list.iter().map(|sigma| sigma * sigma).sum::<f64>() / list.len() as f64).sqrt()
            });
            let covered =
                all.iter().filter(|sigma| **sigma < 1.96).count() as f64 / all.len() as f64;
            println!(
                "rho {rho}: {} errors, deviations {std:.3}, {covered:.3} covered; {} with four degrees of freedom: {std_of_many:.3}",
                all.len(),
                many.len()
            );
            assert!(all.len() >= 1990 && many.len() < 1000, "rho {rho}");
            assert!((0.85..1.05).contains(&std), "rho {rho}: {std}");
            assert!((0.93..0.98).contains(&covered), "rho {rho}: {covered}");
            assert!(std_of_many > 1.1, "control, rho {rho}: {std_of_many}");
        }
    }

    /// Guarantee: whether there is an error depends on the number of entries and not on the seed. Setup: 1000 series of
    /// independent entries for each length, and weakly correlated ones. Law: deviations by Student's t have the standard
    /// deviation 1. Tolerance: four standard errors of a standard deviation of 1000 values, and the few percent by which
    /// the choice of the block length lowers an error.
    #[test]
    fn presence_of_an_error_does_not_depend_on_the_seed() {
        for (rho, length) in [(0.0, 64), (0.0, 100), (0.0, 200), (0.3, 200)] {
            let mut uniform = Uniform(3);
            let (mut missing, mut squares) = (0, 0.0);
            for _ in 0..1000 {
                let series: Blocking = uniform.correlated(rho, length).collect();
                let estimate = series.estimate().unwrap();
                let (Some(error), Some(freedom)) =
                    (estimate.standard_error, estimate.degrees_of_freedom)
                else {
                    missing += 1;
                    continue;
                };
                let sigma = normal_equivalent(estimate.value / error, freedom);
                squares += sigma * sigma;
            }
            let std = (squares / f64::from(1000 - missing)).sqrt();
            println!("rho {rho}, {length} entries: {missing} missing, deviations {std:.3}");
            assert!(missing <= 3, "rho {rho}, {length} entries: {missing} of 1000");
            assert!((0.9..1.15).contains(&std), "rho {rho}, {length} entries: {std}");
        }
    }
}
