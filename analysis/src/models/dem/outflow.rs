//! Discharge through an outlet: number of removed discs over time.

use crate::models::series::Series;
use crate::statistics::least_squares_line;

/// Number of removed discs over time.
#[derive(Clone, Debug, Default)]
pub(super) struct Outflow {
    removed: Series<(f64, u64)>,
}

/// Fractions of all removed discs between which the rate is measured: the first discs fall before the flow is steady,
/// and the last ones have no bed above them.
const STEADY_SHARE: [f64; 2] = [0.1, 0.6];

impl Outflow {
    pub(super) fn add_frame(&mut self, time: f64, removed: u64) {
        self.removed.add((time, removed));
    }

    /// Discs per second, by a line through the counts of the steady part.
    pub(super) fn rate_per_s(&self) -> Option<f64> {
        let most = self.removed.last()?.1 as f64;
        let [low, high] = STEADY_SHARE.map(|share| share * most);
        let steady = self.removed.iter().map(|&(time, removed)| (time, removed as f64));
        let steady: Vec<(f64, f64)> =
            steady.filter(|(_, removed)| (low..=high).contains(removed) && most > 0.0).collect();
        if steady.len() < 3 { None } else { least_squares_line(&steady).map(|line| line.slope) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Setup: counts of a steady stream between a slow beginning and a slow end.
    #[test]
    fn the_rate_is_that_of_the_steady_part() {
        let mut outflow = Outflow::default();
        for frame in 0..=100 {
            let time = 0.01 * f64::from(frame);
            let removed = if time < 0.1 { 0.0 } else { 1000.0 * (time - 0.1) };
            outflow.add_frame(time, if removed < 800.0 { removed.round() as u64 } else { 800 });
        }
        let rate = outflow.rate_per_s().unwrap();
        assert!((rate - 1000.0).abs() < 1.0, "{rate}");
        assert!(Outflow::default().rate_per_s().is_none());
    }
}
