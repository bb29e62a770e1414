//! The data of a chart for the script of `report.html`: numbers rounded to what is visible, also after zooming in.

use crate::models::main_results;
use crate::plot::{Axis, Chart, Curve, Plot, PlotContent, Point, Scale, extremes};
use crate::run::RunAnalysis;
use crate::sweep::figures::shared_charts;
use serde::Serialize;
use serde_json::{Value, json};

/// Significant digits of every number.
const DIGITS: i32 = 4;
/// Digits of the range of a linear axis that are kept, so that a tenth of it can fill the screen.
const DIGITS_OF_RANGE: i32 = 5;
/// Curves of up to this number of points are tables to read, and keep more digits.
const FEW_POINTS: usize = 100;
/// Digits of the numbers of such curves.
const DIGITS_OF_FEW: i32 = 7;

/// A chart.
#[derive(Serialize)]
pub(super) struct ChartData<'a> {
    title: &'a str,
    x: AxisData<'a>,
    y: AxisData<'a>,
    /// Whether both axes have the same scale.
    equal: bool,
    /// Whether x is the time of the replay.
    time: bool,
    remark: &'a str,
    curves: Vec<CurveData<'a>>,
}

#[derive(Serialize)]
struct AxisData<'a> {
    label: &'a str,
    unit: &'a str,
    log: bool,
    /// The words at 0, 1, 2, and so on, in place of numbers.
    #[serde(skip_serializing_if = "<[String]>::is_empty")]
    words: &'a [String],
}

#[derive(Serialize)]
struct CurveData<'a> {
    name: &'a str,
    style: &'static str,
    color: usize,
    x: Abscissas,
    y: Vec<Option<f64>>,
    /// Standard errors of y; empty without any.
    e: Vec<Option<f64>>,
    run: Option<CurveRun>,
}

/// A run that a curve shows.
#[derive(Serialize)]
pub(super) struct CurveRun {
    /// The recording.
    pub(super) file: String,
    /// The run's place in the sweep, or its file.
    pub(super) name: String,
}

/// The abscissas of a curve, or the index of an earlier curve with the same ones.
#[derive(PartialEq, Serialize)]
#[serde(untagged)]
enum Abscissas {
    Own(Vec<Option<f64>>),
    Of(usize),
}

impl<'a> ChartData<'a> {
    /// The data of a chart whose curves show these runs.
    pub(super) fn of(title: &'a str, chart: &'a Chart, runs: Vec<Option<CurveRun>>) -> Self {
        let points = || chart.curves.iter().flat_map(|curve| &curve.points);
        let [x_step, y_step] = [
            step(&chart.x, points().map(|point| point.x)),
            step(&chart.y, points().map(|point| point.y)),
        ];
        let mut curves: Vec<CurveData<'a>> = Vec::new();
        for (curve, run) in chart.curves.iter().zip(runs) {
            let own = column(curve, x_step, |point| Some(point.x));
            let same =
                curves.iter().position(|other| matches!(&other.x, Abscissas::Own(x) if *x == own));
            let has_errors = curve.points.iter().any(|point| point.error.is_some());
            curves.push(CurveData {
                name: &curve.name,
                style: curve.style.word(),
                color: curve.color,
                x: same.map_or(Abscissas::Own(own), Abscissas::Of),
                y: column(curve, y_step, |point| Some(point.y)),
                e: if has_errors { column(curve, y_step, |point| point.error) } else { Vec::new() },
                run,
            });
        }
        let axis = |axis: &'a Axis| AxisData {
            label: &axis.label,
            unit: if axis.unit == "1" { "" } else { &axis.unit },
            log: axis.scale == Scale::Logarithmic,
            words: &axis.words,
        };
        let (x, y) = (axis(&chart.x), axis(&chart.y));
        let (equal, time) = (chart.equal_aspect, chart.x.label == "time");
        Self { title, x, y, equal, time, remark: &chart.remark, curves }
    }
}

/// The charts of a run for the script, as pairs of their file name and their data; those of the model's main results come first.
#[must_use]
pub fn charts_of_run(run: &RunAnalysis) -> Vec<Value> {
    let shared = shared_charts(&[run]);
    let main = main_results(run.model()).charts;
    let mut plots: Vec<&Plot> = Vec::new();
    for plot in run.figures.plots.iter().chain(&shared) {
        if !plots.iter().any(|known| known.draws_the_points_of(plot)) {
            plots.push(plot);
        }
    }
    plots.sort_by_key(|plot| main.iter().position(|stem| plot.stem == *stem).unwrap_or(usize::MAX));
    let data = plots.into_iter().filter_map(|plot| match &plot.content {
        PlotContent::Chart(chart) => {
            let runs = chart.curves.iter().map(|_| None).collect();
            Some(json!([plot.stem, ChartData::of(&plot.title, chart, runs)]))
        }
        PlotContent::Picture(_) => None,
    });
    data.collect()
}

fn column(curve: &Curve, step: f64, of: fn(&Point) -> Option<f64>) -> Vec<Option<f64>> {
    let digits = if curve.points.len() <= FEW_POINTS { DIGITS_OF_FEW } else { DIGITS };
    curve
        .points
        .iter()
        .map(|point| of(point).and_then(|value| rounded(value, step, digits)))
        .collect()
}

/// The decimal step that is visible on an axis; zero if only relative changes are visible.
fn step(axis: &Axis, values: impl Iterator<Item = f64>) -> f64 {
    let range = extremes(values.filter(|value| value.is_finite()));
    let range = range.map_or(0.0, |(least, greatest)| greatest - least);
    if axis.scale == Scale::Logarithmic || range <= 0.0 {
        return 0.0;
    }
    libm::pow(10.0, libm::log10(range).floor() + 1.0 - f64::from(DIGITS_OF_RANGE))
}

/// A number rounded to a step or to significant digits, whichever is finer; `None` if it is not finite.
pub(super) fn rounded(value: f64, step: f64, digits: i32) -> Option<f64> {
    if !value.is_finite() || value == 0.0 {
        return value.is_finite().then_some(0.0);
    }
    let by_step = if step > 0.0 { libm::log10(value.abs() / step).ceil() as i32 } else { 0 };
    let decimals = usize::try_from(by_step.max(digits).min(17) - 1).unwrap_or(0);
    format!("{value:.decimals$e}").parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_rounded_to_what_is_visible() {
        assert_eq!(rounded(1.234_567_8e-18, 0.0, 4), Some(1.235e-18));
        assert_eq!(rounded(1.000_012_345, 1e-7, 4), Some(1.000_012_3));
        assert_eq!(rounded(-0.0, 0.1, 4), Some(0.0));
        assert_eq!(rounded(f64::NAN, 0.1, 4), None);
        let axis = Axis::linear("t", "s");
        let close = step(&axis, [0.0, 123.0].into_iter()) / 0.01;
        assert!((close - 1.0).abs() < 1e-9, "{close}");
        assert_eq!(step(&Axis::logarithmic("t", "s"), [1.0, 123.0].into_iter()), 0.0);
    }

    /// Guarantee: the script draws what the SVG shows, to 1/1000 of the axis. Control: fewer digits would not.
    #[test]
    fn rounding_is_not_visible() {
        let ends = [1.0e5, 1.0e5 + 0.37];
        let values = (0..1000).map(|index| ends[0] + 0.37 * f64::from(index) / 999.0);
        let step = step(&Axis::linear("y", ""), ends.into_iter());
        let (mut worst, mut control): (f64, f64) = (0.0, 0.0);
        for value in values {
            worst = worst.max((rounded(value, step, DIGITS).unwrap() - value).abs() / 0.37);
            control = control.max((rounded(value, 0.0, DIGITS).unwrap() - value).abs() / 0.37);
        }
        assert!(worst < 1e-3 && control > 1e-3, "{worst} {control}");
    }

    #[test]
    fn shared_abscissas_are_written_once() {
        let line = |color: usize| Curve::line("a", color, (0..9).map(|x| (f64::from(x), 1.5)));
        let chart = Chart {
            x: Axis::linear("time", "s"),
            y: Axis::linear("y", "1"),
            equal_aspect: false,
            curves: vec![line(0), line(1)],
            remark: String::new(),
        };
        let text = serde_json::to_string(&ChartData::of("t", &chart, vec![None, None])).unwrap();
        assert_eq!(text.matches("[0.0,1.0,2.0").count(), 1, "{text}");
        assert!(text.contains("\"x\":0,") && text.contains("\"time\":true"), "{text}");
        assert!(text.contains("\"unit\":\"\""), "a pure number has no unit: {text}");
    }
}
