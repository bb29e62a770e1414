//! Fits along an axis of a sweep.
//!
//! The points of a sweep share their random draws, so their scatter around a fit does not measure its error. Therefore, each
//! replicate is fitted on its own and the error is that of the mean over replicates; for one replicate it is unknown.

use crate::input::coordinates::{self, grouped, without};
use crate::metric::{Definition, Metric, MetricScope, SweepScope};
use crate::models::MODELS;
use crate::models::contract::{Fit, FitShape};
use crate::statistics::{least_squares_line, mean_of_independent, power_law_exponent, saturation};
use crate::sweep::SweepPoint;
use kinetoscope_manifest::Coordinate;
use std::collections::BTreeMap;

/// Maximum relative difference of equal end times.
const END_TIME_TOLERANCE: f64 = 1e-9;
/// Fraction of the ordinates below which an intercept is a rounding error.
const ROUNDING_SHARE: f64 = 1e-9;

/// All possible fits, one per group of equal other coordinates, and the reasons for fits that failed.
#[must_use]
pub fn fits(points: &[SweepPoint<'_>]) -> (Vec<Metric>, Vec<String>) {
    let (mut metrics, mut notes) = (Vec::new(), Vec::new());
    for fit in MODELS.iter().flat_map(|model| model.fits) {
        let swept = points
            .iter()
            .filter(|point| point.coordinates.iter().any(|place| place.key == fit.along));
        for (others, group) in
            grouped(swept.map(|point| (without(&point.coordinates, fit.along), point)))
        {
            if !fit.is_seen(&group) {
                continue;
            }
            // An error that is dominated by rounding has no order and is not fitted.
            let has_order =
                !fit.is_convergence_order || (fit.theory)(group[0].runs[0].model()).is_some();
            if group.len() > 1 && has_order {
                match fit.make(&others, &group) {
                    Ok(found) => metrics.extend(found),
                    Err(why) => notes.push(why),
                }
            }
        }
    }
    (metrics, notes)
}

impl Fit {
    fn make(
        &self,
        others: &[Coordinate],
        group: &[&SweepPoint<'_>],
    ) -> Result<Vec<Metric>, String> {
        if self.is_convergence_order {
            self.reject_unequal_end_times(others, group)?;
        }
        let lines: Vec<(f64, f64)> = self
            .replicates(group)
            .values()
            .filter(|points| points.len() == group.len())
            .filter_map(|points| match self.shape {
                FitShape::Line { .. } => {
                    least_squares_line(points).map(|line| (line.slope, line.intercept))
                }
                FitShape::PowerLaw(_) => power_law_exponent(points).map(|exponent| (exponent, 0.0)),
                FitShape::Saturation { .. } => saturation(points),
            })
            .collect();
        if lines.is_empty() {
            let of = self.of;
            let why = match self.shape {
                FitShape::Saturation { .. } => format!("{of} does not level off in any replicate"),
                FitShape::Line { .. } | FitShape::PowerLaw(_) => {
                    format!("no replicate has a {of} above zero at every point")
                }
            };
            return Err(self.refusal(others, &why));
        }
        let theory = (self.theory)(group[0].runs[0].model());
        let slopes: Vec<f64> = lines.iter().map(|line| line.0).collect();
        let intercepts: Vec<f64> = lines.iter().map(|line| line.1).collect();
        Ok(match self.shape {
            FitShape::PowerLaw(exponent) => vec![self.metric(exponent, &slopes, theory, others)],
            FitShape::Saturation { scale, misfit } => vec![
                self.metric(scale, &slopes, theory, others),
                self.metric(misfit, &intercepts, None, others),
            ],
            FitShape::Line { slope, intercept } => {
                let zero = theory.map(|_| 0.0);
                let found = self.metric(intercept, &intercepts, zero, others);
                // An intercept is a difference of ordinates, so it cannot be more accurate than their rounding.
                let rounding = ROUNDING_SHARE * self.largest_ordinate(group);
                vec![
                    self.metric(slope, &slopes, theory, others),
                    found.map(|metric| Metric { rounding, ..metric }),
                ]
            }
        }
        .into_iter()
        .flatten()
        .collect())
    }

    /// Whether any run has the fitted metrics.
    fn is_seen(&self, group: &[&SweepPoint<'_>]) -> bool {
        let has = |name: &str| {
            let mut runs = group.iter().flat_map(|point| &point.runs);
            runs.any(|run| run.measurement(name).is_some())
        };
        has(self.of) && self.over.is_none_or(has)
    }

    fn largest_ordinate(&self, group: &[&SweepPoint<'_>]) -> f64 {
        let runs = group.iter().flat_map(|point| &point.runs);
        let ordinates = runs.filter_map(|run| run.measurement(self.of));
        ordinates.map(|found| found.estimate.value.abs()).fold(0.0, f64::max)
    }

    /// The points of each replicate, in the order of the sweep.
    fn replicates(&self, group: &[&SweepPoint<'_>]) -> BTreeMap<u32, Vec<(f64, f64)>> {
        let mut replicates: BTreeMap<u32, Vec<(f64, f64)>> = BTreeMap::new();
        for point in group {
            let place = point.coordinates.iter().find(|place| place.key == self.along);
            for run in &point.runs {
                let x = match self.over {
                    Some(name) => run.measurement(name).map(|found| found.estimate.value),
                    None => place.and_then(|place| place.value.parse().ok()),
                };
                if let (Some(x), Some(found)) = (x, run.measurement(self.of)) {
                    let points = replicates.entry(run.manifest.replicate).or_default();
                    points.push((x, found.estimate.value));
                }
            }
        }
        replicates
    }

    fn reject_unequal_end_times(
        &self,
        others: &[Coordinate],
        group: &[&SweepPoint<'_>],
    ) -> Result<(), String> {
        let ends = || group.iter().flat_map(|point| &point.runs).map(|run| run.end_time);
        let least = ends().fold(f64::INFINITY, f64::min);
        let latest = ends().fold(0.0, f64::max);
        if latest - least > END_TIME_TOLERANCE * latest {
            let why = format!(
                "the runs end at different times, from {least} to {latest}: take steps that all divide the duration"
            );
            return Err(self.refusal(others, &why));
        }
        Ok(())
    }

    fn refusal(&self, others: &[Coordinate], why: &str) -> String {
        let place = coordinates::text(others);
        let place = if place.is_empty() { place } else { format!(" at {place}") };
        format!("{}{place} was not fitted: {why}", self.name())
    }

    fn name(&self) -> &'static str {
        match self.shape {
            FitShape::PowerLaw(metric)
            | FitShape::Line { slope: metric, .. }
            | FitShape::Saturation { scale: metric, .. } => metric.name,
        }
    }

    fn metric(
        &self,
        definition: &'static Definition,
        values: &[f64],
        theory: Option<f64>,
        others: &[Coordinate],
    ) -> Option<Metric> {
        let estimate = mean_of_independent(values)?;
        let law = definition.laws.first().filter(|_| theory.is_some());
        let law = law.map_or_else(String::new, |law| format!("; theory: {law}"));
        Some(Metric {
            definition,
            value: estimate.value,
            standard_error: estimate.standard_error,
            theory,
            rounding: definition.rounding,
            source: format!("{}, a replicate at a time{law}", definition.how),
            scope: MetricScope::Sweep(SweepScope {
                along: Some(self.along.to_owned()),
                coordinates: others.to_vec(),
                replicates: values.len(),
            }),
        })
    }
}
