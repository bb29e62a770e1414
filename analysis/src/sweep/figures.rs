//! Plots of a sweep: a metric over a swept number, with one curve per group of equal other coordinates.

use crate::input::coordinates::{self, grouped, last_part, without};
use crate::models::MODELS;
use crate::models::contract::{ModelAnalysis, Ordinate, TradeOff};
use crate::models::figures::SharedCurve;
use crate::plot::{Axis, Chart, Curve, CurveStyle, Plot, Point, Scale};
use crate::run::RunAnalysis;
use crate::statistics::{mean, mean_of_independent};
use crate::sweep::SweepPoint;
use std::collections::BTreeSet;

/// Maximum number of curves per chart: the number of distinct colors.
pub const MAX_CURVES: usize = 7;

/// All plots over the numeric axes of the sweep.
#[must_use]
pub fn plots(points: &[SweepPoint<'_>]) -> Vec<Plot> {
    let mut keys: Vec<&str> = Vec::new();
    for place in points.iter().flat_map(|point| &point.coordinates) {
        if !keys.contains(&place.key.as_str()) {
            keys.push(&place.key);
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
            (cost > 0.0 && error > 0.0).then(|| Point::bare(cost, error))
        });
        let mut points: Vec<Point> = found.collect();
        points.sort_by(|a, b| a.x.total_cmp(&b.x));
        if points.len() > 1 {
            curves.push(Curve {
                name: coordinates::label(others),
                style: CurveStyle::Data,
                color,
                points,
            });
        }
    }
    (curves.len() > 1).then(|| {
        Plot::Chart(Chart {
            stem: trade_off.stem.to_owned(),
            title: trade_off.title.to_owned(),
            x: Axis::logarithmic(trade_off.x.1, trade_off.x.2),
            y: Axis::logarithmic(trade_off.y.1, trade_off.y.2),
            equal_aspect: false,
            curves,
        })
    })
}

fn abscissa(point: &SweepPoint<'_>, key: &str) -> Option<f64> {
    point.coordinates.iter().find(|place| place.key == key)?.value.parse().ok()
}

fn plot(points: &[SweepPoint<'_>], key: &str, ordinate: &Ordinate) -> Option<Plot> {
    let swept = points.iter().filter(|point| abscissa(point, key).is_some());
    let groups = grouped(swept.map(|point| (without(&point.coordinates, key), point)));
    let mut curves = Vec::new();
    let groups = groups.iter().filter(|(_, group)| group.len() > 1).take(MAX_CURVES);
    for (index, (others, group)) in groups.enumerate() {
        let color = if ordinate.companion.is_some() { 2 * index } else { index };
        let label = coordinates::label(others);
        curves.extend(curves_of(
            group,
            key,
            ordinate.metric,
            &label,
            color,
            ["measured", "theory"],
        ));
        if ordinate.order.is_some_and(|order| order.key == key) {
            curves.extend(order_line(group, &curves, ordinate, &label, color));
        }
        if let Some((metric, name)) = ordinate.companion {
            let name = [name, ""];
            let color = color + 1;
            curves.extend(curves_of(group, key, metric, &label, color, name).into_iter().take(1));
        }
    }
    if is_flat(&curves) {
        return None;
    }
    let unit =
        |run: &&RunAnalysis| run.measurement(ordinate.metric).map(|found| found.definition.unit);
    let unit = points.iter().flat_map(|point| &point.runs).copied().find_map(|run| unit(&run))?;
    let unit = if unit == "1" { "" } else { unit };
    let (label, x_unit) = words_and_unit(last_part(key));
    let steep = |of: fn(&Point) -> f64| {
        let values = || curves.iter().flat_map(|curve| &curve.points).map(of);
        let least = values().fold(f64::INFINITY, f64::min);
        least > 0.0 && values().fold(0.0, f64::max) > 30.0 * least
    };
    let radius = label.ends_with("radius");
    let logarithmic = ordinate.is_power_law || radius;
    let scale = |steep: bool| {
        if logarithmic || steep { Scale::Logarithmic } else { Scale::Linear }
    };
    let stem = format!("{}_vs_{}", stem_of(ordinate.metric), label.replace(' ', "_"));
    Some(Plot::Chart(Chart {
        stem,
        title: format!("{} against {label}", capitalised(ordinate.title)),
        x: Axis { label, unit: x_unit.to_owned(), scale: scale(steep(|point| point.x)) },
        y: Axis {
            label: ordinate.title.to_owned(),
            unit: unit.to_owned(),
            scale: scale(steep(|point| point.y)),
        },
        equal_aspect: false,
        curves,
    }))
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
    let at = |x: f64| Point::bare(x, first.y * (x / first.x).powf(order));
    let name = format!("order {order}");
    let name = if label.is_empty() { name } else { format!("{label}: {name}") };
    Some(Curve { name, style: CurveStyle::Theory, color, points: vec![at(first.x), at(end.x)] })
}

/// Whether there are no points, or all values are equal within rounding.
fn is_flat(curves: &[Curve]) -> bool {
    let values = || curves.iter().flat_map(|curve| &curve.points).map(|point| point.y);
    let least = values().fold(f64::INFINITY, f64::min);
    let greatest = values().fold(f64::NEG_INFINITY, f64::max);
    let empty = least > greatest;
    empty || greatest - least <= 1e-9 * greatest.abs()
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
        let found: Vec<_> = point.runs.iter().filter_map(|run| run.measurement(metric)).collect();
        let values: Vec<f64> = found.iter().map(|found| found.estimate.value).collect();
        let Some(estimate) = mean_of_independent(&values) else { continue };
        let alone = if found.len() == 1 { found[0].estimate.standard_error } else { None };
        data.push(Point { x, y: estimate.value, error: estimate.standard_error.or(alone) });
        let theories: Option<Vec<f64>> = found.iter().map(|found| found.theory).collect();
        if let Some(y) = theories.as_deref().and_then(mean) {
            theory.push(Point::bare(x, y));
        }
    }
    let by_x = |a: &Point, b: &Point| a.x.total_cmp(&b.x);
    data.sort_by(by_x);
    theory.sort_by(by_x);
    let name = |what: &str| {
        if label.is_empty() { what.to_owned() } else { format!("{label}: {what}") }
    };
    let mut curves = Vec::new();
    if !data.is_empty() {
        curves.push(Curve { name: name(names[0]), style: CurveStyle::Data, color, points: data });
    }
    if theory.len() > 1 {
        curves.push(Curve {
            name: name(names[1]),
            style: CurveStyle::Theory,
            color,
            points: theory,
        });
    }
    curves
}

/// File name of a metric: some metrics use only the first part of their name.
fn stem_of(metric: &str) -> String {
    match metric {
        "pressure.measured" => "pressure".to_owned(),
        "position_error.final" => "position_error".to_owned(),
        other => other.replace('.', "_"),
    }
}

fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// The quantity and the unit of a manifest key.
fn words_and_unit(key: &str) -> (String, &'static str) {
    const UNITS: &[(&str, &str)] = &[
        ("_n_s_per_m", "N s/m"),
        ("_n_per_m", "N/m"),
        ("_m_per_s2", "m/s²"),
        ("_m_per_s", "m/s"),
        ("_rad2", "rad²"),
        ("_kg", "kg"),
        ("_days", "days"),
        ("_au", "AU"),
        ("_k", "K"),
        ("_m", "m"),
        ("_s", "s"),
    ];
    let found = UNITS.iter().find_map(|(ending, unit)| Some((key.strip_suffix(ending)?, *unit)));
    let (words, unit) = found.unwrap_or((key, ""));
    (words.replace('_', " "), unit)
}

/// Charts with one curve per run, if there are at least two runs.
#[must_use]
pub fn comparisons(runs: &[&RunAnalysis]) -> Vec<Plot> {
    let mut plots = Vec::new();
    let Some(first) = runs.first().filter(|_| runs.len() > 1) else { return plots };
    for shared in &first.figures.comparisons {
        let of = |run: &RunAnalysis| -> Option<SharedCurve> {
            run.figures.comparisons.iter().find(|other| other.stem == shared.stem).cloned()
        };
        let curves: Vec<Curve> = runs
            .iter()
            .take(MAX_CURVES)
            .enumerate()
            .filter_map(|(color, run)| {
                let points = of(run)?.points;
                let name = coordinates::label(&run.coordinates);
                Some(Curve { name, style: CurveStyle::Line, color, points })
            })
            .collect();
        let mut y = shared.y.clone();
        let values = || curves.iter().flat_map(|curve| &curve.points).map(|point| point.y);
        let least = values().fold(f64::INFINITY, f64::min);
        if least > 0.0 && values().fold(0.0, f64::max) > 1e3 * least {
            y.scale = Scale::Logarithmic;
        }
        plots.push(Plot::Chart(Chart {
            stem: shared.stem.clone(),
            title: shared.title.clone(),
            x: shared.x.clone(),
            y,
            equal_aspect: false,
            curves,
        }));
    }
    plots
}
