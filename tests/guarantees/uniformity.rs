//! Distance of a sample from the uniform distribution.
#![allow(clippy::disallowed_methods, reason = "statistics in tests are not part of any recording")]

/// Kolmogorov–Smirnov statistic sqrt(n) sup |F_n(x) - x| of numbers that should be uniform in [0, 1).
pub(crate) fn kolmogorov_smirnov(mut numbers: Vec<f64>) -> f64 {
    numbers.sort_by(f64::total_cmp);
    let count = numbers.len() as f64;
    let largest = numbers.iter().enumerate().fold(0.0_f64, |largest, (rank, &x)| {
        largest.max(x - rank as f64 / count).max((rank as f64 + 1.0) / count - x)
    });
    largest * count.sqrt()
}
