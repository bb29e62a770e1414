//! Deviations with few degrees of freedom, as deviations of a normal distribution.

use statrs::function::beta::beta_reg;
use statrs::function::erf::{erfc, erfc_inv};
use std::f64::consts::SQRT_2;

/// Two-sided probabilities below this are converted by an approximation.
const MIN_PROBABILITY: f64 = 1e-300;

/// Probability p = I(ν/(ν + t^2); ν/2, 1/2) of a larger |t| by Student's distribution with ν degrees of freedom; erfc(|t|/sqrt 2)
/// by the normal distribution without.
pub(crate) fn two_sided_probability(t: f64, degrees_of_freedom: Option<f64>) -> f64 {
    match degrees_of_freedom {
        _ if t.is_nan() => 1.0,
        _ if t.is_infinite() => 0.0,
        Some(freedom) => beta_reg(freedom / 2.0, 0.5, freedom / (freedom + t * t)),
        None => erfc(t.abs() / SQRT_2),
    }
}

/// The deviation t beyond which Student's distribution with ν degrees of freedom has a two-sided probability p; the normal
/// distribution without. By bisection, as precisely as `f64` allows.
pub(crate) fn two_sided_quantile(probability: f64, degrees_of_freedom: Option<f64>) -> f64 {
    let is_beyond = |t: f64| two_sided_probability(t, degrees_of_freedom) < probability;
    let (mut low, mut high) = (0.0, 1.0);
    while !is_beyond(high) && high < f64::MAX / 2.0 {
        (low, high) = (high, 2.0 * high);
    }
    loop {
        let middle = f64::midpoint(low, high);
        match middle > low && middle < high {
            true if is_beyond(middle) => high = middle,
            true => low = middle,
            false => return high,
        }
    }
}

/// The deviation z of a normal distribution that is as probable as the deviation t of Student's distribution: both have the
/// same two-sided probability p = erfc(|z|/sqrt 2), with the sign of t. For t = 4: z = 1.42, 1.90, 2.20 and 3.47 for ν = 1, 2,
/// 3 and 24.
///
/// Where p underflows, z = (8ν + 1)/(8ν + 3) sqrt(ν ln(1 + t^2/ν)) (Wallace, Ann. Math. Stat. 30 (1959) 1121).
pub(crate) fn normal_equivalent(t: f64, degrees_of_freedom: f64) -> f64 {
    let freedom = degrees_of_freedom;
    if !(t.is_finite() && freedom.is_finite() && freedom > 0.0) {
        return t;
    }
    let probability = two_sided_probability(t, Some(freedom));
    let deviation = if probability > MIN_PROBABILITY {
        SQRT_2 * erfc_inv(probability)
    } else {
        let logarithm = 2.0 * libm::log(libm::hypot(t / freedom.sqrt(), 1.0));
        (8.0 * freedom + 1.0) / (8.0 * freedom + 3.0) * (freedom * logarithm).sqrt()
    };
    deviation.copysign(t)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::random::Uniform;
    use crate::statistics::{least_squares_line, mean_of_independent};

    /// Source: tables of Student's t: 4.303 (2 degrees of freedom) and 2.228 (10) at 5 %; 1.96 of the normal distribution.
    #[test]
    fn probabilities_equal_those_of_tables() {
        for (t, freedom) in [(4.303, Some(2.0)), (-2.228, Some(10.0)), (1.960, None)] {
            let probability = two_sided_probability(t, freedom);
            assert!((probability - 0.05).abs() < 2e-5, "{t}: {probability}");
        }
    }

    /// Source: tables of Student's t at 5 % and 0.1 %: 4.303 and 31.599 (2 degrees of freedom), 2.228 and 4.587 (10), and 1.960 and 3.291
    /// of the normal distribution.
    #[test]
    fn quantiles_equal_those_of_tables() {
        for (freedom, tables) in
            [(Some(2.0), [4.303, 31.599]), (Some(10.0), [2.228, 4.587]), (None, [1.960, 3.291])]
        {
            for (probability, table) in [0.05, 0.001].into_iter().zip(tables) {
                let t = two_sided_quantile(probability, freedom);
                assert!((t - table).abs() < 6e-4, "{freedom:?}, {probability}: {t}");
            }
        }
    }

    /// Source: 40-digit arithmetic (mpmath), erfc(z/sqrt 2) = I(ν/(ν + t^2); ν/2, 1/2).
    #[test]
    fn normal_equivalents_equal_those_of_40_digit_arithmetic() {
        for (t, freedom, z) in [
            (1.0, 1.0, 0.674_489_750_196_08),
            (4.0, 1.0, 1.418_796_817_645_4),
            (4.0, 2.0, 1.901_848_539_595_5),
            (4.0, 3.0, 2.197_167_916_994_6),
            (0.3, 7.5, 0.289_338_100_506_58),
            (8.0, 24.0, 5.532_554_651_869_3),
            (1e4, 24.0, 19.055_753_045_374),
            (1e6, 3.0, 8.746_264_640_261_7),
            (5.0, 1000.0, 4.967_926_607_472_2),
            (37.0, 1e6, 36.987_336_885_903),
        ] {
            for sign in [1.0, -1.0] {
                let found = normal_equivalent(sign * t, freedom);
                assert!((found / (sign * z) - 1.0).abs() < 1e-10, "t {t}, ν {freedom}: {found}");
            }
        }
        // Below the smallest probability: 39.0562 by the same arithmetic.
        assert!((normal_equivalent(60.0, 1000.0) - 39.0562).abs() < 0.002);
        assert!(normal_equivalent(1e200, 2.0).is_finite());
        assert_eq!(normal_equivalent(0.0, 5.0), 0.0);
    }

    /// Law: the mean of n values deviates from the truth by more than "4 σ" in 6e-5 of all cases. Setup: 2000 cases each of 2, 3
    /// and 4 values. Control: the ratio of deviation and standard error exceeds 4 in far more cases (16 % for n = 2).
    fn assert_4_sigma_is_rare(truth: f64, mut value: impl FnMut() -> f64) {
        for replicates in [2, 3, 4] {
            let (mut beyond, mut beyond_without) = (0, 0);
            for _ in 0..2000 {
                let values: Vec<f64> = (0..replicates).map(|_| value()).collect();
                let mean = mean_of_independent(&values).unwrap();
                let t = (mean.value - truth) / mean.standard_error.unwrap();
                let sigma = normal_equivalent(t, mean.degrees_of_freedom.unwrap());
                beyond += u32::from(sigma.abs() > 4.0);
                beyond_without += u32::from(t.abs() > 4.0);
            }
            println!("{replicates} replicates: {beyond} of 2000, {beyond_without} without Student");
            assert!(beyond <= 2, "{replicates} replicates: {beyond} of 2000 exceed 4 σ");
            assert!(beyond_without > 20, "control, {replicates} replicates: {beyond_without}");
        }
    }

    #[test]
    fn correct_means_of_few_replicates_do_not_exceed_4_sigma() {
        let mut uniform = Uniform(1908);
        assert_4_sigma_is_rare(0.0, || uniform.normal());
    }

    /// Setup: the slope of a line through five points, fitted replicate by replicate.
    #[test]
    fn correct_fits_of_few_replicates_do_not_exceed_4_sigma() {
        let mut uniform = Uniform(4);
        assert_4_sigma_is_rare(0.5, || {
            let points: Vec<(f64, f64)> =
                (0..5).map(|x| (f64::from(x), 0.5 * f64::from(x) + uniform.normal())).collect();
            least_squares_line(&points).unwrap().slope
        });
    }
}
