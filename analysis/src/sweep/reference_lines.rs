//! Lines in a plot of metrics: the fits that the model knows or that the plot requests, their laws, and power laws for comparison.

use super::samples::{Abscissa, Group, typographic_unit};
use crate::input::coordinates::label;
use crate::metric::{Metric, MetricScope};
use crate::models::MODELS;
use crate::models::contract::{Fit, FitShape};
use crate::number_text::{plus_minus, short_number, three_digits};
use crate::plot::{Curve, CurveStyle, Point, SLOPE, extremes};
use crate::statistics::{Estimate, least_squares_line, mean_of_independent, power_law_exponent};
use crate::sweep::SweepPoint;
use crate::sweep::figures::{MAX_CURVES, MEASURED, REFERENCE_COLOR};
use crate::sweep::fits::{self, Refusal};
use kinetoscope_manifest::{Coordinate, PlotFit, PlotRequest};
use std::collections::BTreeMap;

/// Error over its rounding from which a line shows the order of a method.
const LEAST_OVER_ROUNDING: f64 = 30.0;
/// Number of points of a line that is evaluated between those of the data.
const LINE_POINTS: usize = 61;

/// What lines depend on.
pub(super) struct Lines<'a> {
    pub(super) request: &'a PlotRequest,
    pub(super) abscissa: &'a Abscissa,
    /// All metrics, among them the fits.
    pub(super) metrics: &'a [Metric],
    /// The points of the sweep.
    pub(super) points: &'a [SweepPoint<'a>],
}

impl Lines<'_> {
    /// The curves of all groups, each followed by its lines, and the requested power laws. Remarks state the fitted numbers.
    pub(super) fn added_to(
        &self,
        groups: Vec<(&str, Group)>,
        remarks: &mut Vec<String>,
    ) -> Vec<Curve> {
        let mut curves = Vec::new();
        for (metric, Group { coordinates, curves: of_group }) in groups {
            let data = of_group.iter().find(|curve| curve.style == CurveStyle::Data).cloned();
            let has_theory = of_group.iter().any(|curve| curve.style == CurveStyle::Theory);
            curves.extend(of_group);
            let Some(data) = data.filter(|data| data.points.len() > 1) else { continue };
            let place = label(&coordinates);
            let fit = match self.request.fit {
                Some(shape) => self.requested_fit(shape, metric, &coordinates, &data),
                None => self.known_fit(metric, &coordinates, &data, has_theory),
            };
            remarks.extend(self.refusal(metric, &coordinates, fit.is_some()));
            let Some(Fitted { line, text }) = fit else {
                remarks.extend(self.request.fit.map(|shape| unfitted(shape, &place)));
                continue;
            };
            // A fit that is drawn has its number in the legend.
            let is_named = line
                .as_ref()
                .is_some_and(|line| line.style == CurveStyle::Fit && !line.name.contains(": "));
            if let Some(text) = text.filter(|_| !is_named) {
                let place = if place.is_empty() { String::new() } else { format!("{place}: ") };
                remarks.push(format!("{place}{text}"));
            }
            curves.extend(line);
        }
        let power_laws = self.request.exponents.iter().enumerate();
        let power_laws: Vec<Curve> = power_laws
            .filter_map(|(index, exponent)| power_law(&curves, exponent.get(), index))
            .collect();
        curves.extend(power_laws);
        curves
    }

    /// The fit of this metric over this axis that the model defines: its curve, or the line of its law where points have no theory of
    /// their own.
    fn known_fit(
        &self,
        metric: &str,
        coordinates: &[Coordinate],
        data: &Curve,
        has_theory: bool,
    ) -> Option<Fitted> {
        let fit = self.fit_of_model(metric)?;
        let first = self.fitted(fit, coordinates);
        let run = self.points_at(coordinates).next().and_then(|point| point.runs.first());
        let theory = run.and_then(|run| (fit.theory)(run.model()));
        let text = |name: &str| first.map(|first| format!("fitted {name} {}", number(first)));
        // A single curve has no name that its law could follow.
        let name = |of: &str| match data.name.as_str() {
            MEASURED => of.to_owned(),
            name => format!("{name}: {of}"),
        };
        match fit.shape {
            FitShape::Saturation => {
                let scale = first?.value;
                let law = fit.parameters[0].laws.first().map_or("fit", |law| law.title());
                let name = if has_theory { name(law) } else { format!("{law}, fitted") };
                let points = saturation_points(scale, range_of(data)?[1]);
                let line = Some(comparison(CurveStyle::Fit, name, data.color, points));
                Some(Fitted { line, text: None })
            }
            FitShape::PowerLaw => {
                let (exponent, of, style) = match (theory, first) {
                    (Some(theory), _) => {
                        let law = fit.parameters.first().and_then(|it| it.laws.first()?.name);
                        let exponent = exponent_text(theory);
                        let of = match law {
                            Some(law) => format!("{law}, exponent {exponent}"),
                            None => format!("{SLOPE}{exponent}"),
                        };
                        (theory, of, CurveStyle::Theory)
                    }
                    (None, Some(first)) => {
                        let of = format!("fit, exponent {}", number(first));
                        (first.value, of, CurveStyle::Fit)
                    }
                    (None, None) => return None,
                };
                let (anchor, from) = match (&fit.asymptotic_range, run) {
                    (Some(range), Some(run)) => {
                        let least =
                            LEAST_OVER_ROUNDING * (range.rounding)(run.model(), run.end_time);
                        // The order is seen above the rounding.
                        let anchor = data.points.iter().find(|point| point.y > least).copied();
                        (anchor, anchor.map(|anchor| anchor.x))
                    }
                    _ => (center(&data.points), None),
                };
                let text = text(if from.is_some() { "order" } else { "exponent" });
                let line = anchor.filter(|_| !has_theory).and_then(|anchor| {
                    let [low, high] = range_of(data)?;
                    let low = from.unwrap_or(low);
                    // A single point above the rounding shows no slope.
                    let points =
                        power_points(anchor, exponent, [low, high]).filter(|_| low < high)?;
                    Some(comparison(style, name(&of), data.color, points))
                });
                Some(Fitted { line, text })
            }
            FitShape::Line => {
                let unit = fit.parameters.first().map_or("", |slope| slope.unit);
                let with_unit = |text: String| {
                    format!("{text} {}", typographic_unit(unit)).trim_end().to_owned()
                };
                Some(Fitted { line: None, text: text("slope").map(with_unit) })
            }
        }
    }
}

impl Lines<'_> {
    /// The fit of a metric over this axis that the model defines.
    fn fit_of_model(&self, metric: &str) -> Option<&'static Fit> {
        let is_over = |fit: &&Fit| match (self.abscissa, fit.over) {
            (Abscissa::Metric(x), Some(over)) => x.name == over,
            (Abscissa::Key { key, .. }, None) => key == fit.along,
            _ => false,
        };
        let mut fits = MODELS.iter().flat_map(|model| model.fits);
        fits.find(|fit| fit.of == metric && is_over(fit))
    }

    /// Why the fit of the model has no number here, if one is requested. A requested line that is drawn is another fit: it goes through all points.
    fn refusal(&self, metric: &str, coordinates: &[Coordinate], is_drawn: bool) -> Option<String> {
        let fit = self.fit_of_model(metric).filter(|_| self.request.fit.is_some())?;
        let parameter = fit.parameters.first()?;
        let (_, refusals) = fits::fits(self.points);
        let is_of_fit =
            |it: &&Refusal| it.names.contains(&parameter.name) && it.coordinates == coordinates;
        // What follows the first clause names keys and values, which the notes of the report list.
        let why = refusals.iter().find(is_of_fit)?.why.split("; ").next()?;
        let label = parameter.label;
        Some(match is_drawn {
            true => {
                format!("the line is a fit to all points, without a standard error, because {why}")
            }
            false => format!("the numbers give no {label}, because {why}"),
        })
    }

    /// The first parameter of a fit of the model, as the metrics contain it.
    fn fitted(&self, fit: &Fit, coordinates: &[Coordinate]) -> Option<Estimate> {
        let name = fit.parameters.first()?.name;
        let is_fit = |metric: &&Metric| matches!(&metric.scope, MetricScope::Sweep(scope) if scope.along.is_some());
        let mut fits = self.metrics.iter().filter(is_fit);
        let found = fits.find(|it| it.name() == name && it.coordinates() == coordinates);
        found.map(|metric| metric.estimate)
    }

    /// The shown points of the sweep with these coordinates.
    fn points_at(&self, coordinates: &[Coordinate]) -> impl Iterator<Item = &SweepPoint<'_>> {
        self.points.iter().filter(|point| {
            self.request.selects(&point.coordinates)
                && coordinates.iter().all(|coordinate| point.coordinates.contains(coordinate))
        })
    }

    /// A fit of a requested shape through the middle of the data. Its slope is that of the metrics if the model defines this fit, or else the
    /// mean over the replicates with its error, as there.
    fn requested_fit(
        &self,
        shape: PlotFit,
        metric: &str,
        coordinates: &[Coordinate],
        data: &Curve,
    ) -> Option<Fitted> {
        let has_shape = |fit: &&Fit| {
            matches!(
                (fit.shape, shape),
                (FitShape::PowerLaw, PlotFit::Power) | (FitShape::Line, PlotFit::Linear)
            )
        };
        let fit = self.fit_of_model(metric).filter(has_shape);
        let slope = fit.and_then(|fit| self.fitted(fit, coordinates));
        let slope =
            slope.or_else(|| self.mean_slope(shape, metric, coordinates)).or_else(|| {
                let points: Vec<_> = data.points.iter().map(|point| (point.x, point.y)).collect();
                slope_of(shape, &points).map(Estimate::bare)
            })?;
        let [low, high] = range_of(data)?;
        let (drawn, of) = match shape {
            PlotFit::Power => {
                let drawn = power_points(center(&data.points)?, slope.value, [low, high])?;
                (drawn, format!("exponent {}", number(slope)))
            }
            PlotFit::Linear => {
                let mean = |of: fn(&Point) -> f64| {
                    data.points.iter().map(of).sum::<f64>() / data.points.len() as f64
                };
                let (x, y) = (mean(|point| point.x), mean(|point| point.y));
                let end = |at: f64| Point::bare(at, y + slope.value * (at - x));
                (vec![end(low), end(high)], format!("slope {}", number(slope)))
            }
        };
        let name = match data.name.as_str() {
            MEASURED => format!("fit, {of}"),
            name => format!("{name}: fit, {of}"),
        };
        let line = comparison(CurveStyle::Fit, name, data.color, drawn);
        Some(Fitted { line: Some(line), text: Some(format!("fitted {of}")) })
    }

    /// The mean slope over the replicates that have a value at every point with one: points of a sweep share their random draws, so that
    /// their scatter about a line is not its error.
    fn mean_slope(
        &self,
        shape: PlotFit,
        metric: &str,
        coordinates: &[Coordinate],
    ) -> Option<Estimate> {
        let points = self.points_at(coordinates).filter(|point| point.mean_of(metric).is_some());
        let mut replicates: BTreeMap<u32, Vec<(f64, f64)>> = BTreeMap::new();
        let mut count = 0;
        for point in points {
            count += 1;
            for run in &point.runs {
                let y = run.measurement(metric).map(|found| found.estimate.value);
                if let (Some(x), Some(y)) = (self.abscissa.of_run(run), y) {
                    replicates.entry(run.manifest.replicate).or_default().push((x, y));
                }
            }
        }
        let whole = replicates.values().filter(|points| points.len() == count);
        let slopes: Vec<f64> = whole.filter_map(|points| slope_of(shape, points)).collect();
        mean_of_independent(&slopes)
    }
}

/// What the dashed lines are that share the entries of their curves, unless these state their slopes or the law has no name. Next to such slopes, a law
/// has the names of its curves.
pub(super) fn dashes_of(curves: &[Curve]) -> Option<String> {
    let theory = curves.iter().filter(|curve| curve.style == CurveStyle::Theory);
    let named: Vec<(&str, &str)> = theory.filter_map(|curve| curve.name.split_once(": ")).collect();
    let is_law = |law: &str| !law.starts_with(SLOPE) && law != "theory";
    let mut laws: Vec<&str> = named.iter().map(|(_, law)| *law).filter(|law| is_law(law)).collect();
    laws.dedup();
    let has_slopes = named.iter().any(|(_, law)| law.starts_with(SLOPE));
    let text = |law: &&str| {
        let of_law = named.iter().filter(|(_, other)| other == law);
        let names: Vec<&str> = of_law.map(|(name, _)| *name).collect();
        if has_slopes { format!("{law} ({})", names.join(", ")) } else { (*law).to_owned() }
    };
    let laws: Vec<String> = laws.iter().map(text).collect();
    (!laws.is_empty()).then(|| format!("dashed: {}", laws.join(", ")))
}

/// The least-squares slope of points, or the exponent of their power law.
fn slope_of(shape: PlotFit, points: &[(f64, f64)]) -> Option<f64> {
    match shape {
        PlotFit::Power => power_law_exponent(points),
        PlotFit::Linear => least_squares_line(points).map(|line| line.slope),
    }
}

/// Why a requested fit is not drawn.
fn unfitted(shape: PlotFit, place: &str) -> String {
    let place = if place.is_empty() { String::new() } else { format!("{place}: ") };
    match shape {
        PlotFit::Power => format!(
            "{place}no power law is fitted, because it needs numbers above 0 at two points or more"
        ),
        PlotFit::Linear => {
            format!("{place}no line is fitted, because it needs numbers at two points or more")
        }
    }
}

/// A line through data, and its numbers.
struct Fitted {
    line: Option<Curve>,
    text: Option<String>,
}

/// A fitted number with its standard error, or to three digits.
fn number(estimate: Estimate) -> String {
    let with_error = estimate.standard_error.and_then(|error| plus_minus(estimate.value, error));
    with_error.unwrap_or_else(|| three_digits(estimate.value).replace('-', "−"))
}

/// An exponent, as a fraction of small numbers if it is close to one.
fn exponent_text(exponent: f64) -> String {
    for denominator in 1..=3_i32 {
        let numerator = libm::round(exponent * f64::from(denominator));
        if (exponent * f64::from(denominator) - numerator).abs() < 1e-3 {
            let whole = denominator == 1;
            let text =
                if whole { format!("{numerator}") } else { format!("{numerator}/{denominator}") };
            return text.replace('-', "−");
        }
    }
    short_number(exponent)
}

fn comparison(style: CurveStyle, name: String, color: usize, points: Vec<Point>) -> Curve {
    Curve { name, style, color, points }
}

/// The least and the greatest abscissa.
fn range_of(curve: &Curve) -> Option<[f64; 2]> {
    extremes(curve.points.iter().map(|point| point.x)).map(|(low, high)| [low, high])
}

/// The geometric mean of points above zero.
fn center(points: &[Point]) -> Option<Point> {
    let above: Vec<&Point> = points.iter().filter(|point| point.x > 0.0 && point.y > 0.0).collect();
    let count = above.len() as f64;
    let mean = |of: fn(&Point) -> f64| {
        libm::exp(above.iter().map(|point| libm::log(of(point))).sum::<f64>() / count)
    };
    (!above.is_empty()).then(|| Point::bare(mean(|point| point.x), mean(|point| point.y)))
}

/// Points of a power law through an anchor above zero, at equal ratios.
fn power_points(anchor: Point, exponent: f64, [low, high]: [f64; 2]) -> Option<Vec<Point>> {
    (low > 0.0 && anchor.x > 0.0).then(|| {
        let at = |index: usize| {
            let x = low * libm::pow(high / low, index as f64 / (LINE_POINTS - 1) as f64);
            Point::bare(x, anchor.y * libm::pow(x / anchor.x, exponent))
        };
        (0..LINE_POINTS).map(at).collect()
    })
}

/// Points of s (1 - exp(-x/s)) from 0 on, at equal distances.
fn saturation_points(scale: f64, high: f64) -> Vec<Point> {
    let at = |index: usize| {
        let x = high * index as f64 / (LINE_POINTS - 1) as f64;
        Point::bare(x, -scale * libm::expm1(-x / scale))
    };
    (0..LINE_POINTS).map(at).collect()
}

/// A power law through the middle of all data.
fn power_law(curves: &[Curve], exponent: f64, index: usize) -> Option<Curve> {
    let data = curves.iter().filter(|curve| curve.style == CurveStyle::Data);
    let points: Vec<Point> = data.flat_map(|curve| curve.points.iter().copied()).collect();
    let (low, high) = extremes(points.iter().map(|point| point.x))?;
    let line = power_points(center(&points)?, exponent, [low, high])?;
    // By turns in dashes and in the dots of the second round of colors.
    let color = (REFERENCE_COLOR + MAX_CURVES - index % MAX_CURVES) % MAX_CURVES;
    let color = color + index % 2 * MAX_CURVES;
    Some(comparison(
        CurveStyle::Theory,
        format!("exponent {}", exponent_text(exponent)),
        color,
        line,
    ))
}
