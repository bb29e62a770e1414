//! Fits along an axis of a sweep.
//!
//! The points of a sweep share their random draws, so their scatter around a fit does not measure its error. Therefore, each
//! replicate is fitted on its own and the error is that of the mean over replicates; for one replicate it is unknown.

use crate::input::coordinates::{self, grouped, without};
use crate::metric::theory::Expected;
use crate::metric::{Definition, Metric, MetricScope, SweepScope};
use crate::models::contract::{Fit, FitShape};
use crate::models::{MODELS, label_of};
use crate::plot::extremes;
use crate::statistics::{least_squares_line, mean_of_independent, power_law_exponent, saturation};
use crate::sweep::SweepPoint;
use kinetoscope_manifest::Coordinate;
use std::collections::BTreeMap;

/// Maximum relative difference of equal end times.
const END_TIME_TOLERANCE: f64 = 1e-9;
/// Fraction of the ordinates below which an intercept is a rounding error.
const ROUNDING_FRACTION: f64 = 1e-9;

/// A fit that failed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Refusal {
    /// The metrics that have no value.
    pub(crate) names: Vec<&'static str>,
    /// The coordinates of the group.
    pub(crate) coordinates: Vec<Coordinate>,
    /// The reason.
    pub(crate) why: String,
}

impl Refusal {
    /// The failure in a sentence.
    pub(crate) fn note(&self) -> String {
        let place = coordinates::text(&self.coordinates);
        let place = if place.is_empty() { place } else { format!(" at {place}") };
        let name = self.names.first().copied().unwrap_or_default();
        format!("{name}{place} was not fitted: {}", self.why)
    }
}

/// All possible fits, one per group of equal other coordinates, and those that failed.
pub(crate) fn fits(points: &[SweepPoint<'_>]) -> (Vec<Metric>, Vec<Refusal>) {
    let (mut metrics, mut refusals) = (Vec::new(), Vec::new());
    for fit in MODELS.iter().flat_map(|model| model.fits) {
        let swept = points
            .iter()
            .filter(|point| point.coordinates.iter().any(|coordinate| coordinate.key == fit.along));
        for (others, group) in
            grouped(swept.map(|point| (without(&point.coordinates, fit.along), point)))
        {
            if !fit.is_seen(&group) {
                continue;
            }
            // An error that is dominated by rounding has no order and is not fitted.
            let has_order =
                fit.asymptotic_range.is_none() || (fit.theory)(group[0].runs[0].model()).is_some();
            if group.len() > 1 && has_order {
                match fit.make(&others, &group) {
                    Ok(found) => metrics.extend(found),
                    Err(why) => {
                        let names = fit.parameters.iter().map(|known| known.name).collect();
                        refusals.push(Refusal { names, coordinates: others, why });
                    }
                }
            }
        }
    }
    (metrics, refusals)
}

impl Fit {
    fn make(
        &self,
        others: &[Coordinate],
        group: &[&SweepPoint<'_>],
    ) -> Result<Vec<Metric>, String> {
        let mut in_range = group.to_vec();
        if let Some(range) = &self.asymptotic_range {
            reject_unequal_end_times(group)?;
            in_range = self.in_asymptotic_range(range, group)?;
        }
        let group = in_range.as_slice();
        let fitted: Vec<[f64; 2]> = self
            .replicates(group)
            .values()
            .filter(|points| points.len() == group.len())
            .filter_map(|points| match self.shape {
                FitShape::Line => {
                    least_squares_line(points).map(|line| [line.slope, line.intercept])
                }
                FitShape::PowerLaw => power_law_exponent(points).map(|exponent| [exponent, 0.0]),
                FitShape::Saturation => saturation(points).map(|(scale, misfit)| [scale, misfit]),
            })
            .collect();
        if fitted.is_empty() {
            let of = label_of(self.of).unwrap_or(self.of);
            return Err(match self.shape {
                FitShape::Saturation => format!("the {of} does not level off in any replicate"),
                FitShape::Line | FitShape::PowerLaw => {
                    format!("no replicate has a {of} above zero at every point")
                }
            });
        }
        let theory = (self.theory)(group[0].runs[0].model());
        let metrics = self.parameters.iter().enumerate().filter_map(|(index, definition)| {
            let values: Vec<f64> = fitted.iter().map(|parameters| parameters[index]).collect();
            let is_intercept = index == 1 && matches!(self.shape, FitShape::Line);
            let theory = match index {
                0 => theory,
                _ => theory.filter(|_| is_intercept).map(|_| 0.0),
            };
            let metric = self.metric(definition, &values, theory, others)?;
            // An intercept is a difference of ordinates, so it cannot be more accurate than their rounding.
            let rounding = ROUNDING_FRACTION * self.max_ordinate(group);
            Some(if is_intercept { Metric { rounding, ..metric } } else { metric })
        });
        Ok(metrics.collect())
    }

    /// Whether any run has the fitted metrics.
    fn is_seen(&self, group: &[&SweepPoint<'_>]) -> bool {
        let has = |name: &str| {
            let mut runs = group.iter().flat_map(|point| &point.runs);
            runs.any(|run| run.measurement(name).is_some())
        };
        has(self.of) && self.over.is_none_or(has)
    }

    fn max_ordinate(&self, group: &[&SweepPoint<'_>]) -> f64 {
        let runs = group.iter().flat_map(|point| &point.runs);
        let ordinates = runs.filter_map(|run| run.measurement(self.of));
        ordinates.map(|found| found.estimate.value.abs()).fold(0.0, f64::max)
    }

    /// The points of each replicate, in the order of the sweep.
    fn replicates(&self, group: &[&SweepPoint<'_>]) -> BTreeMap<u32, Vec<(f64, f64)>> {
        let mut replicates: BTreeMap<u32, Vec<(f64, f64)>> = BTreeMap::new();
        for point in group {
            let coordinate =
                point.coordinates.iter().find(|coordinate| coordinate.key == self.along);
            for run in &point.runs {
                let x = match self.over {
                    Some(name) => run.measurement(name).map(|found| found.estimate.value),
                    None => coordinate.and_then(|coordinate| coordinate.value.parse().ok()),
                };
                if let (Some(x), Some(found)) = (x, run.measurement(self.of)) {
                    let points = replicates.entry(run.manifest.replicate).or_default();
                    points.push((x, found.estimate.value));
                }
            }
        }
        replicates
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
        let theory = theory.expected().map(|expected| expected.by(law));
        let scope = MetricScope::Sweep(SweepScope {
            along: Some(self.along.to_owned()),
            coordinates: others.to_vec(),
            replicates: values.len(),
        });
        Some(Metric::new(definition, estimate, theory, scope))
    }
}

/// Reports runs that do not end at the same time.
fn reject_unequal_end_times(group: &[&SweepPoint<'_>]) -> Result<(), String> {
    let ends = group.iter().flat_map(|point| &point.runs).map(|run| run.end_time);
    match extremes(ends) {
        Some((least, latest)) if latest - least > END_TIME_TOLERANCE * latest => Err(format!(
            "the runs end at different times, from {least} to {latest}: take steps that all divide the duration"
        )),
        _ => Ok(()),
    }
}
