//! Numbers of several runs: means over replicates, and fits along an axis of a sweep.
//!
//! Points of a sweep share their random draws, so that the scatter of points about a fit says nothing of its error. Each
//! replicate is fitted on its own, and the error is that of the mean over replicates; with one replicate it is unknown.

use crate::catalog::{Definition, sweep as metric};
use crate::coordinates::{self, grouped, without};
use crate::laws::{gas, orbit};
use crate::metrics::{Metric, Place, SweepPlace};
use crate::run::RunAnalysis;
use crate::statistics::{
    least_squares_line, mean, mean_of_independent, power_law_exponent, saturation,
};
use kinetoscope_manifest::Coordinate;
use kinetoscope_manifest::model::ModelConfig;
use std::collections::BTreeMap;

/// The runs at one point of a sweep.
#[derive(Clone, Debug)]
pub struct SweepPoint<'a> {
    /// Where it lies.
    pub coordinates: Vec<Coordinate>,
    /// Its complete replicates.
    pub runs: Vec<&'a RunAnalysis>,
}

/// The points of a sweep, with complete runs only, in the order of the runs.
#[must_use]
pub fn points(runs: &[RunAnalysis]) -> Vec<SweepPoint<'_>> {
    let complete = runs.iter().filter(|run| run.is_complete());
    grouped(complete.map(|run| (run.coordinates.clone(), run)))
        .into_iter()
        .map(|(coordinates, runs)| SweepPoint { coordinates, runs })
        .collect()
}

/// Means over the replicates of each point that has several, for the metrics that all of them have.
#[must_use]
pub fn replicate_means(points: &[SweepPoint<'_>]) -> Vec<Metric> {
    let mut means = Vec::new();
    for point in points.iter().filter(|point| point.runs.len() > 1) {
        for first in &point.runs[0].measurements {
            let all: Vec<_> =
                point.runs.iter().filter_map(|run| run.measurement(first.name())).collect();
            let values: Vec<f64> = all.iter().map(|found| found.estimate.value).collect();
            let Some(estimate) =
                mean_of_independent(&values).filter(|_| all.len() == point.runs.len())
            else {
                continue;
            };
            let theories: Option<Vec<f64>> = all.iter().map(|found| found.theory).collect();
            means.push(Metric {
                definition: first.definition,
                value: estimate.value,
                standard_error: estimate.standard_error,
                theory: theories.and_then(|theories| mean(&theories)),
                rounding: first.definition.rounding,
                source: format!("mean over replicates of {}", first.source()),
                place: Place::Sweep(SweepPlace {
                    along: None,
                    coordinates: point.coordinates.clone(),
                    replicates: point.runs.len(),
                }),
            });
        }
    }
    means
}

/// What is fitted.
#[derive(Clone, Copy)]
enum Shape {
    /// A line.
    Line { slope: &'static Definition, intercept: &'static Definition },
    /// A power law.
    Power(&'static Definition),
    /// A saturating exponential y = s (1 - exp(-x/s)), and its root mean square relative distance.
    Saturation { scale: &'static Definition, misfit: &'static Definition },
}

/// A fit along an axis.
#[derive(Clone, Copy)]
struct Fit {
    along: &'static str,
    /// The metric that is the abscissa; `None` for the swept key itself.
    over: Option<&'static str>,
    of: &'static str,
    shape: Shape,
    theory: fn(&ModelConfig) -> Option<f64>,
    /// Whether the fit is an order of convergence: all runs must end at the same time, and the theory must know an order.
    equal_ends: bool,
}

/// End times that differ by more than this share of them are not equal.
const END_TIME_TOLERANCE: f64 = 1e-9;
/// Share of the ordinates below which an intercept is rounding.
const ROUNDING_SHARE: f64 = 1e-9;

const FITS: &[Fit] = &[
    Fit {
        along: "model.gas.temperature_k",
        over: None,
        of: "pressure.measured",
        shape: Shape::Line { slope: metric::MEASURED_SLOPE, intercept: metric::MEASURED_INTERCEPT },
        theory: |model| gas_slope(model, |moments| moments.mean_square_m2_per_s2),
        equal_ends: false,
    },
    Fit {
        along: "model.gas.temperature_k",
        over: None,
        of: "pressure.mean_speed_formula",
        shape: Shape::Line {
            slope: metric::MEAN_SPEED_SLOPE,
            intercept: metric::MEAN_SPEED_INTERCEPT,
        },
        theory: |model| gas_slope(model, |moments| moments.mean_m_per_s * moments.mean_m_per_s),
        equal_ends: false,
    },
    Fit {
        along: "model.gas.temperature_k",
        over: None,
        of: "pressure.mean_square_formula",
        shape: Shape::Line {
            slope: metric::MEAN_SQUARE_SLOPE,
            intercept: metric::MEAN_SQUARE_INTERCEPT,
        },
        theory: |model| gas_slope(model, |moments| moments.mean_square_m2_per_s2),
        equal_ends: false,
    },
    Fit {
        along: "model.gas.radius_m",
        over: None,
        of: "pressure.measured",
        shape: Shape::Power(metric::PRESSURE_RADIUS_EXPONENT),
        theory: |_| Some(-2.0),
        equal_ends: false,
    },
    Fit {
        along: "model.gas.temperature_k",
        over: None,
        of: "mean_speed",
        shape: Shape::Power(metric::MEAN_SPEED_EXPONENT),
        theory: |_| Some(0.5),
        equal_ends: false,
    },
    Fit {
        along: "model.orbit.time_step_days",
        over: None,
        of: "position_error.final",
        shape: Shape::Power(metric::CONVERGENCE_ORDER),
        theory: |model| orbit::orbit_order(model, orbit::order),
        equal_ends: true,
    },
    Fit {
        along: "model.orbit.time_step_days",
        over: None,
        of: "energy.largest_error_relative",
        shape: Shape::Power(metric::ENERGY_CONVERGENCE_ORDER),
        theory: |model| orbit::orbit_order(model, orbit::energy_order),
        equal_ends: true,
    },
    Fit {
        along: "variant",
        over: Some("outlet.free_width"),
        of: "outlet.rate",
        shape: Shape::Power(metric::BEVERLOO_EXPONENT),
        theory: |_| Some(1.5),
        equal_ends: false,
    },
    Fit {
        along: "model.dem.discs",
        over: None,
        of: "bed.run_out",
        shape: Shape::Power(metric::RUN_OUT_EXPONENT),
        theory: |_| None,
        equal_ends: false,
    },
    Fit {
        along: "model.dem.discs",
        over: Some("bed.weight"),
        of: "piston.force",
        shape: Shape::Saturation {
            scale: metric::SCREENING_WEIGHT,
            misfit: metric::JANSSEN_MISFIT,
        },
        theory: |_| None,
        equal_ends: false,
    },
];

/// dP/dT of a pressure that is proportional to T.
fn gas_slope(model: &ModelConfig, square: fn(&gas::SpeedMoments) -> f64) -> Option<f64> {
    let ModelConfig::Gas(config) = model else { return None };
    let temperature = gas::temperature_k(config).filter(|temperature| *temperature > 0.0)?;
    let moments = gas::speed_moments(config)?;
    Some(gas::pressure_n_per_m(config, square(&moments)) / temperature)
}

/// All fits that the points allow, a group of equal other coordinates at a time, and why one that was possible was not made.
#[must_use]
pub fn fits(points: &[SweepPoint<'_>]) -> (Vec<Metric>, Vec<String>) {
    let (mut metrics, mut notes) = (Vec::new(), Vec::new());
    for fit in FITS {
        let swept = points
            .iter()
            .filter(|point| point.coordinates.iter().any(|place| place.key == fit.along));
        for (others, group) in
            grouped(swept.map(|point| (without(&point.coordinates, fit.along), point)))
        {
            if !fit.is_seen(&group) {
                continue;
            }
            // An error without an order, of the exact solution or one down at rounding, makes no fit.
            let has_order = !fit.equal_ends || (fit.theory)(group[0].runs[0].model()).is_some();
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
        if self.equal_ends {
            self.refuse_unequal_ends(others, group)?;
        }
        let lines: Vec<(f64, f64)> = self
            .replicates(group)
            .values()
            .filter(|points| points.len() == group.len())
            .filter_map(|points| match self.shape {
                Shape::Line { .. } => {
                    least_squares_line(points).map(|line| (line.slope, line.intercept))
                }
                Shape::Power(_) => power_law_exponent(points).map(|exponent| (exponent, 0.0)),
                Shape::Saturation { .. } => saturation(points),
            })
            .collect();
        if lines.is_empty() {
            let of = self.of;
            let why = match self.shape {
                Shape::Saturation { .. } => format!("{of} does not level off in any replicate"),
                Shape::Line { .. } | Shape::Power(_) => {
                    format!("no replicate has a {of} above zero at every point")
                }
            };
            return Err(self.refusal(others, &why));
        }
        let theory = (self.theory)(group[0].runs[0].model());
        let slopes: Vec<f64> = lines.iter().map(|line| line.0).collect();
        let intercepts: Vec<f64> = lines.iter().map(|line| line.1).collect();
        Ok(match self.shape {
            Shape::Power(exponent) => vec![self.metric(exponent, &slopes, theory, others)],
            Shape::Saturation { scale, misfit } => vec![
                self.metric(scale, &slopes, theory, others),
                self.metric(misfit, &intercepts, None, others),
            ],
            Shape::Line { slope, intercept } => {
                let zero = theory.map(|_| 0.0);
                let found = self.metric(intercept, &intercepts, zero, others);
                // An intercept is a difference of ordinates: it is no better than their rounding.
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

    /// Whether any run has what is fitted.
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

    fn refuse_unequal_ends(
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
            Shape::Power(metric)
            | Shape::Line { slope: metric, .. }
            | Shape::Saturation { scale: metric, .. } => metric.name,
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
            place: Place::Sweep(SweepPlace {
                along: Some(self.along.to_owned()),
                coordinates: others.to_vec(),
                replicates: values.len(),
            }),
        })
    }
}
