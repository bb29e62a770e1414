//! Plots of a sweep: a metric over a swept number, with one curve per group of equal other coordinates.

use crate::input::coordinates::{self, grouped, last_part, without};
use crate::input::key_words::words_and_unit;
use crate::models::MODELS;
use crate::models::contract::{ModelAnalysis, Ordinate, TradeOff};
use crate::models::figures::SharedCurve;
use crate::plot::{Axis, Curve, CurveStyle, Plot, Point, SLOPE, Scale, extremes};
use crate::run::RunAnalysis;
use crate::sweep::SweepPoint;
use std::collections::BTreeSet;

/// Maximum number of curves per chart: the number of distinct colors.
pub(crate) const MAX_CURVES: usize = 7;
/// The name of a curve of data that has no other.
pub(super) const MEASURED: &str = "measured";
/// The color of references.
pub(super) const REFERENCE_COLOR: usize = 6;

/// All plots over the numeric axes of the sweep.
pub(crate) fn plots(points: &[SweepPoint<'_>]) -> Vec<Plot> {
    let mut keys: Vec<&str> = Vec::new();
    for coordinate in points.iter().flat_map(|point| &point.coordinates) {
        if !keys.contains(&coordinate.key.as_str()) {
            keys.push(&coordinate.key);
        }
    }
    let models = models_of(points);
    let mut plots = Vec::new();
    for key in keys {
        for ordinate in models.iter().flat_map(|model| model.ordinates) {
            plots.extend(plot(points, key, ordinate));
        }
    }
    for trade_off in models.iter().flat_map(|model| model.trade_offs) {
        plots.extend(trade_off_plot(points, trade_off));
    }
    plots
}

/// The models of the runs.
fn models_of(points: &[SweepPoint<'_>]) -> Vec<&'static ModelAnalysis> {
    let runs = points.iter().flat_map(|point| &point.runs);
    let names: BTreeSet<&str> = runs.map(|run| run.model().name()).collect();
    MODELS.iter().filter(|model| names.contains(model.name)).copied().collect()
}

/// One metric against another, with one curve per group of equal other coordinates.
fn trade_off_plot(points: &[SweepPoint<'_>], trade_off: &TradeOff) -> Option<Plot> {
    let others = |point: &SweepPoint<'_>| {
        trade_off.keys.iter().fold(point.coordinates.clone(), |places, key| without(&places, key))
    };
    let groups = grouped(points.iter().map(|point| (others(point), point)));
    let groups = groups.iter().filter(|(_, group)| group.len() > 1).take(MAX_CURVES);
    let mut curves = Vec::new();
    for (color, (others, group)) in groups.enumerate() {
        let found = group.iter().filter_map(|point| {
            let value = |name| point.runs.first()?.measurement(name).map(|it| it.estimate.value);
            let (cost, error) = (value(trade_off.x.0)?, value(trade_off.y.0)?);
            (cost.is_finite() && error.is_finite()).then(|| Point::bare(cost, error))
        });
        let mut points: Vec<Point> = found.collect();
        points.sort_by(|a, b| a.x.total_cmp(&b.x));
        if points.iter().filter(|point| point.x > 0.0 && point.y > 0.0).count() > 1 {
            let name = coordinates::label(others);
            curves.push(Curve { name, style: CurveStyle::Data, color, points });
        }
    }
    let axes = [trade_off.x, trade_off.y].map(|(_, label, unit)| Axis::logarithmic(label, unit));
    (curves.len() > 1).then(|| Plot::chart(trade_off.stem, trade_off.title, axes, curves))
}

fn abscissa(point: &SweepPoint<'_>, key: &str) -> Option<f64> {
    point.coordinates.iter().find(|coordinate| coordinate.key == key)?.value.parse().ok()
}

fn plot(points: &[SweepPoint<'_>], key: &str, ordinate: &Ordinate) -> Option<Plot> {
    let swept = points.iter().filter(|point| abscissa(point, key).is_some());
    let groups = grouped(swept.map(|point| (without(&point.coordinates, key), point)));
    let mut curves = Vec::new();
    let groups = groups.iter().filter(|(_, group)| group.len() > 1).take(MAX_CURVES);
    for (index, (others, group)) in groups.enumerate() {
        let color = if ordinate.companion.is_some() { 2 * index } else { index };
        let label = coordinates::label(others);
        let names = [MEASURED, "theory"];
        curves.extend(curves_of(group, key, ordinate.metric, &label, color, names));
        if ordinate.order.is_some_and(|order| order.key == key) {
            curves.extend(order_line(group, &curves, ordinate, &label, color));
        }
        if let Some((metric, name)) = ordinate.companion {
            let name = [name, ""];
            let color = color + 1;
            curves.extend(curves_of(group, key, metric, &label, color, name).into_iter().take(1));
        }
    }
    let values =
        |of: fn(&Point) -> f64| extremes(curves.iter().flat_map(|curve| &curve.points).map(of));
    let (least, greatest) = values(|point| point.y)?;
    // Values that are equal within rounding are not plotted.
    if greatest - least <= 1e-9 * greatest.abs() {
        return None;
    }
    let unit =
        |run: &&RunAnalysis| run.measurement(ordinate.metric).map(|found| found.definition.unit);
    let unit = points.iter().flat_map(|point| &point.runs).copied().find_map(|run| unit(&run))?;
    let unit = if unit == "1" { "" } else { unit };
    let (x_label, x_unit) = words_and_unit(last_part(key));
    let axis = |of: fn(&Point) -> f64, label: &str, unit: &str| {
        let follows_power_law = ordinate.is_power_law || x_label.ends_with("radius");
        let is_steep = |(low, high): (f64, f64)| follows_power_law || high > 30.0 * low;
        // An axis that contains 0 is linear, so that every point is drawn.
        if values(of).is_some_and(|range| range.0 > 0.0 && is_steep(range)) {
            Axis::logarithmic(label, unit)
        } else {
            Axis::linear(label, unit)
        }
    };
    let axes =
        [axis(|point| point.x, &x_label, x_unit), axis(|point| point.y, ordinate.title, unit)];
    let stem = format!("{}_vs_{}", stem_of(ordinate.metric), x_label.replace(' ', "_"));
    let title = format!("{} against {x_label}", capitalized(ordinate.title));
    Some(Plot::chart(stem, title, axes, curves))
}

/// A line of known order through the group's first point, for groups without a theoretical value.
fn order_line(
    group: &[&SweepPoint<'_>],
    curves: &[Curve],
    ordinate: &Ordinate,
    label: &str,
    color: usize,
) -> Option<Curve> {
    let last =
        curves.last().filter(|last| last.style == CurveStyle::Data && last.color == color)?;
    let order = (ordinate.order?.order)(group.first()?.runs.first()?.model())?;
    let (first, end) = (last.points.first()?, last.points.last()?);
    let at = |x: f64| Point::bare(x, first.y * libm::pow(x / first.x, order));
    let name = labeled(label, &format!("{SLOPE}{order}"));
    Some(Curve { name, style: CurveStyle::Theory, color, points: vec![at(first.x), at(end.x)] })
}

/// The name of a curve in a group of curves.
fn labeled(group: &str, name: &str) -> String {
    if group.is_empty() { name.to_owned() } else { format!("{group}: {name}") }
}

/// The measured values of one group and, if known, the theoretical line.
fn curves_of(
    group: &[&SweepPoint<'_>],
    key: &str,
    metric: &str,
    label: &str,
    color: usize,
    names: [&str; 2],
) -> Vec<Curve> {
    let (mut data, mut theory) = (Vec::new(), Vec::new());
    for point in group {
        let Some(x) = abscissa(point, key) else { continue };
        let Some((estimate, expected, _)) = point.mean_of(metric) else { continue };
        data.push(Point { x, y: estimate.value, error: estimate.standard_error });
        let expected = expected.and_then(|theory| theory.applicable());
        theory.extend(expected.map(|value| Point::bare(x, value)));
    }
    let by_x = |a: &Point, b: &Point| a.x.total_cmp(&b.x);
    data.sort_by(by_x);
    theory.sort_by(by_x);
    let curve = |name: &str, style: CurveStyle, points: Vec<Point>| {
        // A curve of data is named after its group only, and its theory after it: they share an entry of the legend.
        let name = if name == MEASURED && !label.is_empty() {
            label.to_owned()
        } else {
            labeled(label, name)
        };
        Curve { name, style, color, points }
    };
    let data = (!data.is_empty()).then(|| curve(names[0], CurveStyle::Data, data));
    let theory = (theory.len() > 1).then(|| curve(names[1], CurveStyle::Theory, theory));
    data.into_iter().chain(theory).collect()
}

/// File name of a metric: some metrics use only the first part of their name.
pub(super) fn stem_of(metric: &str) -> String {
    match metric {
        "pressure.measured" => "pressure".to_owned(),
        "position_error.final" => "position_error".to_owned(),
        other => other.replace('.', "_"),
    }
}

pub(crate) fn capitalized(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// Charts with one curve per run, if there are at least two runs.
pub(crate) fn comparisons(runs: &[&RunAnalysis]) -> Vec<Plot> {
    if runs.len() > 1 { shared_charts(runs) } else { Vec::new() }
}

/// Charts with one curve per run.
pub(crate) fn shared_charts(runs: &[&RunAnalysis]) -> Vec<Plot> {
    let mut plots = Vec::new();
    let Some(first) = runs.first() else { return plots };
    for SharedCurve { stem, title, axes, .. } in &first.figures.comparisons {
        let curve = |(color, run): (usize, &&RunAnalysis)| {
            let shared = run.figures.comparisons.iter().find(|other| other.stem == *stem)?;
            let name = coordinates::label(&run.coordinates);
            Some(Curve { name, style: CurveStyle::Line, color, points: shared.points.clone() })
        };
        let curves: Vec<Curve> =
            runs.iter().take(MAX_CURVES).enumerate().filter_map(curve).collect();
        let [x, mut y] = axes.clone();
        let values = curves.iter().flat_map(|curve| &curve.points).map(|point| point.y);
        if extremes(values).is_some_and(|(least, greatest)| least > 0.0 && greatest > 1e3 * least) {
            y.scale = Scale::Logarithmic;
        }
        plots.push(Plot::chart(stem, title, [x, y], curves));
    }
    plots
}
