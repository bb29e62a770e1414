//! The runs from which an order of convergence can be read: those whose error is a pure power of the step.
//!
//! A run is outside if its phase error is so large that the position error is no longer proportional to it, or if its error is
//! dominated by rounding. The coarsest runs are outside as long as the order still changes from step to step.

use crate::models::contract::{AsymptoticRange, Fit};
use crate::run::RunAnalysis;
use crate::sweep::SweepPoint;

/// Maximum phase error, rad: the chord of an arc differs from the arc by a fraction of its square over 24.
const MAX_PHASE_ERROR_RAD: f64 = 0.1;
/// Minimum error over its rounding error, so that rounding changes the order by less than 0.05 even at twice the step.
const MIN_ERROR_OVER_ROUNDING: f64 = 30.0;
/// Maximum range of the orders between neighboring steps.
const MAX_ORDER_RANGE: f64 = 0.04;
/// Minimum number of runs.
const MIN_RUNS: usize = 3;

/// Logarithms of step and error of one run.
struct ConvergencePoint {
    step: f64,
    ln_step: f64,
    ln_error: f64,
}

impl Fit {
    /// The points in the asymptotic range, by a run of each.
    ///
    /// # Errors
    /// The runs that are outside, if fewer than three are left.
    pub(super) fn in_asymptotic_range<'a, 'b>(
        &self,
        range: &AsymptoticRange,
        group: &[&'a SweepPoint<'b>],
    ) -> Result<Vec<&'a SweepPoint<'b>>, String> {
        let mut outside = Vec::new();
        let mut points: Vec<(ConvergencePoint, &SweepPoint<'_>)> = Vec::new();
        for &point in group {
            let run = point.runs[0];
            let Some(step) = self.step_of(point) else { continue };
            let Some(error) = run.measurement(self.of).map(|found| found.estimate.value) else {
                continue;
            };
            match self.reason_outside(range, run, error) {
                Some(why) => outside.push(format!("{} = {step} ({why})", self.along)),
                None => {
                    let (ln_step, ln_error) = (libm::log(step), libm::log(error));
                    points.push((ConvergencePoint { step, ln_step, ln_error }, point));
                }
            }
        }
        points.sort_by(|(one, _), (other, _)| other.step.total_cmp(&one.step));
        while let Some((first, last)) = range_of_orders(&points)
            && (first - last).abs() > MAX_ORDER_RANGE
        {
            let (coarsest, _) = points.remove(0);
            outside.push(format!(
                "{} = {} (the order still changes, from {first:.2} to {last:.2})",
                self.along, coarsest.step
            ));
        }
        if points.len() < MIN_RUNS {
            return Err(format!(
                "too few runs are in the asymptotic range, {} of {} where {MIN_RUNS} are needed; outside: {}",
                points.len(),
                group.len(),
                if outside.is_empty() { "none".to_owned() } else { outside.join(", ") }
            ));
        }
        Ok(points.into_iter().map(|(_, point)| point).collect())
    }

    fn step_of(&self, point: &SweepPoint<'_>) -> Option<f64> {
        let coordinate = point.coordinates.iter().find(|coordinate| coordinate.key == self.along);
        coordinate?.value.parse().ok()
    }

    fn reason_outside(
        &self,
        range: &AsymptoticRange,
        run: &RunAnalysis,
        error: f64,
    ) -> Option<String> {
        let phase = run.measurement(range.phase_error).map(|found| found.estimate.value.abs());
        if let Some(phase) = phase.filter(|phase| *phase > MAX_PHASE_ERROR_RAD) {
            return Some(format!("phase error {phase:.2} rad, over {MAX_PHASE_ERROR_RAD}"));
        }
        let rounding = (range.rounding)(run.model(), run.end_time);
        // An error that is not a number is outside as well.
        let is_resolved = error > MIN_ERROR_OVER_ROUNDING * rounding;
        (!is_resolved).then(|| format!("its {} {error:.1e} is dominated by rounding", self.of))
    }
}

/// The orders of two neighboring pairs of steps that differ most; `None` for fewer than three points.
fn range_of_orders(points: &[(ConvergencePoint, &SweepPoint<'_>)]) -> Option<(f64, f64)> {
    let orders: Vec<f64> = points
        .windows(2)
        .map(|pair| {
            let (coarse, fine) = (&pair[0].0, &pair[1].0);
            (coarse.ln_error - fine.ln_error) / (coarse.ln_step - fine.ln_step)
        })
        .collect();
    if orders.len() < 2 {
        return None;
    }
    let least = orders.iter().copied().fold(f64::INFINITY, f64::min);
    let greatest = orders.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    Some((greatest, least))
}
