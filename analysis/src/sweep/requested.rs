//! Plots that a manifest or a command line requests: a metric over a swept key, or a field of a channel over time.

use crate::input::coordinates::CoordinateValue;
use crate::input::coordinates::{self, grouped, last_part, shown_value, value_of};
use crate::metric::{Definition, Metric, MetricScope};
use crate::models::MODELS;
use crate::plot::{Axis, Curve, CurveStyle, Plot, Point, Scale, extremes, short_number};
use crate::run::RunAnalysis;
use crate::statistics::Estimate;
use crate::sweep::figures::{MAX_CURVES, capitalized, stem_of, words_and_unit};
use crate::sweep::{SHARED_STREAMS, SweepPoint, share_random_streams};
use kinetoscope_manifest::{Axis as SweptAxis, Coordinate, PlotAxis, PlotRequest, TIME, nearest};
use kinetoscope_usage::text::one_line;

/// A plot that cannot be drawn: what is wrong, and what to do.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{what}\nhelp: {help}")]
pub(crate) struct RejectedPlot {
    pub(crate) what: String,
    pub(crate) help: String,
}

impl RejectedPlot {
    pub(crate) fn new(what: impl Into<String>, help: impl Into<String>) -> Self {
        Self { what: what.into(), help: help.into() }
    }
}

/// The results that plots show.
#[derive(Clone, Copy)]
pub(crate) struct PlotData<'a> {
    /// The runs in the order of the experiment.
    pub(crate) runs: &'a [RunAnalysis],
    /// The points of the sweep with their complete runs.
    pub(crate) points: &'a [SweepPoint<'a>],
    /// All metrics.
    pub(crate) metrics: &'a [Metric],
    /// The coordinates of all runs, including those that were not read.
    pub(crate) places: &'a [Vec<Coordinate>],
    /// The axes of the sweep; empty if they are not known.
    pub(crate) axes: &'a [SweptAxis],
}

impl PlotData<'_> {
    /// Draws a requested plot.
    ///
    /// # Errors
    /// A request that these results cannot satisfy.
    pub(crate) fn draw(&self, request: &PlotRequest) -> Result<Plot, RejectedPlot> {
        let mut plot = if request.is_of_channel() {
            self.field_over_time(request)?
        } else {
            self.metric_over_key(request)?
        };
        if let Some(title) = &request.title {
            plot.title = one_line(title).into_owned();
        }
        plot.stem += &coordinates::file_part(&places(&request.at));
        Ok(plot)
    }

    fn metric_over_key(&self, request: &PlotRequest) -> Result<Plot, RejectedPlot> {
        let y = request.y.as_str();
        let definition = definition(y).ok_or_else(|| {
            RejectedPlot::new(format!("`{y}` is not a metric"), "name a metric of metrics.json")
        })?;
        let key = swept_key(request.x.as_deref(), self.places, self.axes)?;
        let words = words(&key, self.places);
        let samples = self.samples(request);
        let mut remarks = Vec::new();
        let abscissa = |place: &[Coordinate]| position(place, &key, &words);
        let curves = curves(&samples, &key, abscissa, self.axes, &mut remarks);
        let missing = samples.iter().filter(|sample| !sample.has_value()).count();
        if curves.is_empty() {
            return Err(self.without_values(request));
        }
        if missing > 0 {
            remarks.push(format!("{missing} of {} points have no value", samples.len()));
        }
        if let [only] = samples.as_slice() {
            remarks.push(only.described());
        }
        if share_random_streams(self.points, y) {
            remarks.push(SHARED_STREAMS.to_owned());
        }
        let unit = if definition.unit == "1" { "" } else { definition.unit };
        let (label, is_power_law) = label(y);
        let (x_label, x_unit) = words_and_unit(last_part(&key));
        let scales = scales(request, &curves, is_power_law, !words.is_empty())?;
        let [across, up] = axes([(&x_label, x_unit), (&label, unit)], scales);
        let axes = [Axis { words, ..across }, up];
        let stem = format!("{}_vs_{}", stem_of(y), x_label.replace(' ', "_"));
        let title = format!("{} against {x_label}", capitalized(&label));
        Ok(Plot::chart(stem, title, axes, curves).with_remark(&remarks.join("; ")))
    }

    /// The values at all selected points: means over replicates, or fits along another axis.
    fn samples(&self, request: &PlotRequest) -> Vec<Sample> {
        let selected = self.points.iter().filter(|point| request.selects(&point.coordinates));
        let of_points: Vec<Sample> = selected
            .map(|point| {
                let found = point.mean_of(&request.y);
                let theory = found.and_then(|(_, theory, _)| theory?.applicable());
                let estimate = found.map(|(estimate, ..)| estimate);
                Sample { coordinates: point.coordinates.clone(), estimate, theory }
            })
            .collect();
        if of_points.iter().any(|sample| sample.estimate.is_some()) {
            return of_points;
        }
        let is_fit = |metric: &&Metric| matches!(&metric.scope, MetricScope::Sweep(sweep) if sweep.along.is_some());
        let fits = self.metrics.iter().filter(|metric| metric.name() == request.y).filter(is_fit);
        let fits =
            fits.filter(|metric| request.selects(metric.coordinates())).map(|metric| Sample {
                coordinates: metric.coordinates().to_vec(),
                estimate: Some(metric.estimate),
                theory: metric.theory.and_then(|theory| theory.applicable()),
            });
        fits.collect()
    }

    /// Why a metric has no value at any selected point.
    fn without_values(&self, request: &PlotRequest) -> RejectedPlot {
        let y = &request.y;
        if !self.points.iter().any(|point| request.selects(&point.coordinates)) {
            return no_run_selected(request);
        }
        let mut measurements = self.runs.iter().flat_map(|run| &run.measurements);
        let reason = measurements
            .find(|found| found.name() == y)
            .and_then(|found| found.reason.as_ref().map(ToString::to_string));
        let why = reason.map_or_else(String::new, |reason| format!(": {reason}"));
        RejectedPlot::new(
            format!("no finished run has a value of `{y}`{why}"),
            "`kinetoscope analyze` reports the metrics of these recordings",
        )
    }

    /// Which of several replicates is drawn.
    fn one_of_several(&self, shown: &[&RunAnalysis]) -> Option<String> {
        let replicates =
            |run: &&RunAnalysis| self.places.iter().filter(|it| **it == run.coordinates).count();
        let most = shown.iter().map(replicates).max().filter(|most| *most > 1)?;
        Some(match shown {
            [run] => format!("replicate {} of 0 to {}", run.manifest.replicate, most - 1),
            _ => "one replicate of each point".to_owned(),
        })
    }

    fn field_over_time(&self, request: &PlotRequest) -> Result<Plot, RejectedPlot> {
        let y = request.y.as_str();
        let (topic, field) = request.channel_field().unwrap_or((y, ""));
        if request.x.as_deref().is_some_and(|x| x != TIME) {
            let what = format!("`{y}` can be plotted over time only");
            return Err(RejectedPlot::new(what, "leave out the horizontal axis, or name `time`"));
        }
        let mut shown: Vec<&RunAnalysis> = Vec::new();
        for run in self.runs.iter().filter(|run| request.selects(&run.coordinates)) {
            if !shown.iter().any(|other| other.coordinates == run.coordinates) {
                shown.push(run);
            }
        }
        if shown.is_empty() {
            return Err(no_run_selected(request));
        }
        let mut remarks = Vec::new();
        let selected = self.places.iter().filter(|place| request.selects(place));
        let selected = grouped(selected.map(|place| (place.clone(), ()))).len();
        if selected > MAX_CURVES {
            remarks.push(format!("the first {MAX_CURVES} of {selected} points of the sweep"));
        }
        remarks.extend(self.one_of_several(&shown));
        let several = shown.len() > 1;
        let mut curves = Vec::new();
        for (color, run) in shown.iter().take(MAX_CURVES).enumerate() {
            let name = if several { coordinates::label(&run.coordinates) } else { String::new() };
            let recorded = run.fields.iter().find(|recorded| recorded.name == y);
            let points = recorded.map_or(&[][..], |recorded| &recorded.points);
            curves.extend(uninterrupted(points, &name, color));
        }
        if curves.is_empty() {
            let what = format!("no recording has a value of `{y}`");
            let help = "`kinetoscope info` lists the channels of a recording";
            return Err(RejectedPlot::new(what, help));
        }
        let (words, unit) = words_and_unit(field);
        let channel = topic.trim_start_matches('/');
        let label = format!("{}: {words}", channel.replace('_', " "));
        let scales = scales(request, &curves, false, false)?;
        let time_unit = &shown[0].time_unit;
        let axes = axes([("time", time_unit), (&label, unit)], scales);
        let title = format!("{} against time", capitalized(&label));
        let plot = Plot::chart(format!("{channel}_{field}_vs_time"), title, axes, curves);
        Ok(plot.with_remark(&remarks.join("; ")))
    }
}

/// The words of a swept key in the order of the sweep; empty for a key with numbers.
fn words(key: &str, places: &[Vec<Coordinate>]) -> Vec<String> {
    if places.iter().any(|place| number(place, key).is_some()) {
        return Vec::new();
    }
    let mut words = Vec::new();
    for coordinate in places.iter().flatten().filter(|coordinate| coordinate.key == key) {
        let word = shown_value(coordinate);
        if !words.contains(&word) {
            words.push(word);
        }
    }
    words
}

/// The place on the horizontal axis: the number of the key, or that of its word.
fn position(place: &[Coordinate], key: &str, words: &[String]) -> Option<f64> {
    if words.is_empty() {
        return number(place, key);
    }
    let coordinate = place.iter().find(|coordinate| coordinate.key == key)?;
    let word = shown_value(coordinate);
    words.iter().position(|other| *other == word).map(|index| index as f64)
}

/// The fields that each run must be read for, given the coordinates of all runs: those of the requested plots, for the first run at
/// each of their first points.
pub(crate) fn fields_to_read<'a>(
    requests: &[PlotRequest],
    runs: impl IntoIterator<Item = &'a Vec<Coordinate>> + Clone,
) -> Vec<Vec<String>> {
    let mut wanted: Vec<Vec<String>> = runs.clone().into_iter().map(|_| Vec::new()).collect();
    for request in requests.iter().filter(|request| request.is_of_channel()) {
        let mut read: Vec<&Vec<Coordinate>> = Vec::new();
        for (names, coordinates) in wanted.iter_mut().zip(runs.clone()) {
            let is_new = request.selects(coordinates) && !read.contains(&coordinates);
            if is_new && read.len() < MAX_CURVES {
                read.push(coordinates);
                if !names.contains(&request.y) {
                    names.push(request.y.clone());
                }
            }
        }
    }
    wanted
}

/// A value at a point of the sweep.
struct Sample {
    coordinates: Vec<Coordinate>,
    estimate: Option<Estimate>,
    theory: Option<f64>,
}

impl Sample {
    fn has_value(&self) -> bool {
        self.estimate.is_some_and(|estimate| estimate.value.is_finite())
    }

    /// Its place with its numbers: theory is a line only between several points.
    fn described(&self) -> String {
        let measured = self.estimate.map_or(f64::NAN, |estimate| estimate.value);
        let theory = self.theory.map(|theory| format!(", theory {}", short_number(theory)));
        let place = coordinates::label(&self.coordinates);
        format!("{place}: measured {}{}", short_number(measured), theory.unwrap_or_default())
    }
}

/// One curve of data and one of theory for each group of points that differ in the key only.
fn curves(
    samples: &[Sample],
    key: &str,
    abscissa: impl Fn(&[Coordinate]) -> Option<f64>,
    axes: &[SweptAxis],
    remarks: &mut Vec<String>,
) -> Vec<Curve> {
    // Keys that advance together with the key are not coordinates of a curve.
    let along = axes.iter().find(|axis| axis.keys.iter().any(|other| other == key));
    let is_along = |other: &str| {
        other == key || along.is_some_and(|axis| axis.keys.iter().any(|one| one == other))
    };
    let others = |sample: &Sample| -> Vec<Coordinate> {
        let others = sample.coordinates.iter().filter(|coordinate| !is_along(&coordinate.key));
        others.cloned().collect()
    };
    let mut groups = grouped(samples.iter().map(|sample| (others(sample), sample)));
    groups.retain(|(_, group)| group.iter().any(|sample| sample.has_value()));
    if groups.len() > MAX_CURVES {
        remarks.push(format!("the first {MAX_CURVES} of {} curves", groups.len()));
    }
    let mut curves = Vec::new();
    for (color, (others, group)) in groups.iter().take(MAX_CURVES).enumerate() {
        let (mut data, mut theory) = (Vec::new(), Vec::new());
        for sample in group {
            let Some(x) = abscissa(&sample.coordinates) else { continue };
            if let Some(estimate) = sample.estimate.filter(|_| sample.has_value()) {
                data.push(Point { x, y: estimate.value, error: estimate.standard_error });
            }
            theory.extend(sample.theory.map(|y| Point::bare(x, y)));
        }
        let name = coordinates::label(others);
        let of_theory =
            if name.is_empty() { "theory".to_owned() } else { format!("{name}: theory") };
        let name = if name.is_empty() { "measured".to_owned() } else { name };
        for (name, style, mut points) in
            [(name, CurveStyle::Data, data), (of_theory, CurveStyle::Theory, theory)]
        {
            points.sort_by(|a, b| a.x.total_cmp(&b.x));
            if points.len() > usize::from(style == CurveStyle::Theory) {
                curves.push(Curve { name, style, color, points });
            }
        }
    }
    curves
}

/// A line for each part of a series without a gap; the first part has the name.
fn uninterrupted(points: &[(f64, f64)], name: &str, color: usize) -> Vec<Curve> {
    let parts = points.split(|(_, value)| !value.is_finite()).filter(|part| !part.is_empty());
    let named = |(index, part): (usize, &[(f64, f64)])| {
        Curve::line(if index == 0 { name } else { "" }, color, part.iter().copied())
    };
    parts.enumerate().map(named).collect()
}

/// The full name of the swept key that is the horizontal axis: the requested one, or the only numeric one, or the only one.
///
/// # Errors
/// A key that is not swept, or a choice among several, with the keys.
pub(crate) fn swept_key(
    requested: Option<&str>,
    places: &[Vec<Coordinate>],
    axes: &[SweptAxis],
) -> Result<String, RejectedPlot> {
    let keys = coordinates::keys_of(places.iter().map(Vec::as_slice));
    let has_numbers = |key: &&String| places.iter().any(|place| number(place, key).is_some());
    let listed =
        |keys: &[&str]| keys.iter().map(|key| last_part(key)).collect::<Vec<_>>().join(", ");
    let all: Vec<&str> = keys.iter().map(String::as_str).collect();
    let Some(x) = requested else {
        let numeric: Vec<&str> = keys.iter().filter(has_numbers).map(String::as_str).collect();
        // Without numbers, words are the axis.
        let (kind, eligible) = if numeric.is_empty() { ("", all) } else { ("numeric ", numeric) };
        let axis_of = |key: &str| axes.iter().position(|axis| axis.keys.iter().any(|it| it == key));
        return match eligible.as_slice() {
            [] => Err(RejectedPlot::new(
                "a plot of a metric needs recordings of a sweep",
                "name a field of a channel, such as `/energy.kinetic_j`, which is plotted over time",
            )),
            [first, rest @ ..]
                if rest
                    .iter()
                    .all(|key| axis_of(key).is_some() && axis_of(key) == axis_of(first)) =>
            {
                Ok((*first).to_owned())
            }
            _ => Err(RejectedPlot::new(
                format!("the recordings differ in {} {kind}keys", eligible.len()),
                format!("name the horizontal axis, one of: {}", listed(&eligible)),
            )),
        };
    };
    let Some(key) = keys.iter().find(|key| *key == x || last_part(key) == x) else {
        let names = all.iter().map(|key| last_part(key));
        let help = match nearest(last_part(x), names) {
            Some(meant) => format!("did you mean `{meant}`?"),
            None if all.is_empty() => "the recordings differ in no key".to_owned(),
            None => format!("name one of: {}", listed(&all)),
        };
        return Err(RejectedPlot::new(format!("`{x}` is not swept"), help));
    };
    Ok(key.clone())
}

fn number(coordinates: &[Coordinate], key: &str) -> Option<f64> {
    match value_of(coordinates.iter().find(|coordinate| coordinate.key == key)?) {
        CoordinateValue::Integer(number) => Some(number as f64),
        CoordinateValue::Number(number) => Some(number),
        CoordinateValue::Text(_) => None,
    }
}

/// The definition of a metric of a run or of a sweep.
fn definition(name: &str) -> Option<&'static Definition> {
    let mut all = MODELS.iter().flat_map(|model| model.metrics.iter().chain(model.sweep_metrics));
    all.find(|definition| definition.name == name).copied()
}

/// The name of a metric in words, and whether it follows a power law.
fn label(metric: &str) -> (String, bool) {
    let mut ordinates = MODELS.iter().flat_map(|model| model.ordinates);
    match ordinates.find(|ordinate| ordinate.metric == metric) {
        Some(ordinate) => (ordinate.title.to_owned(), ordinate.is_power_law),
        None => (metric.replace(['.', '_'], " "), false),
    }
}

/// Ratio of the values above which an axis is logarithmic unless the request decides.
const STEEP: f64 = 30.0;

/// The scales of both axes.
///
/// # Errors
/// A logarithmic axis on request that can show no point, or that has words.
fn scales(
    request: &PlotRequest,
    curves: &[Curve],
    is_power_law: bool,
    has_words: bool,
) -> Result<[Scale; 2], RejectedPlot> {
    let values = |of: fn(&Point) -> f64| curves.iter().flat_map(|curve| &curve.points).map(of);
    let is_steep = |of: fn(&Point) -> f64| {
        extremes(values(of)).is_some_and(|(low, high)| low > 0.0 && high > STEEP * low)
    };
    let [x, y]: [fn(&Point) -> f64; 2] = [|point| point.x, |point| point.y];
    let is_log = match &request.log {
        Some(axes) => [axes.contains(&PlotAxis::X), axes.contains(&PlotAxis::Y)],
        // Time is shown as it passes.
        None if request.is_of_channel() => [false, is_steep(y)],
        None => [!has_words && (is_power_law || is_steep(x)), is_power_law || is_steep(y)],
    };
    if has_words && is_log[0] {
        let what = "the values of the horizontal axis are words, which have no logarithms";
        return Err(RejectedPlot::new(what, "use a linear horizontal axis"));
    }
    let is_shown = |point: &Point| (!is_log[0] || point.x > 0.0) && (!is_log[1] || point.y > 0.0);
    if !curves.iter().flat_map(|curve| &curve.points).any(is_shown) {
        let what = format!("no point of `{}` is above zero on its logarithmic axis", request.y);
        return Err(RejectedPlot::new(what, "use a linear axis"));
    }
    Ok(is_log.map(|is_log| if is_log { Scale::Logarithmic } else { Scale::Linear }))
}

fn axes(labels: [(&str, &str); 2], scales: [Scale; 2]) -> [Axis; 2] {
    let [x, y] = labels.map(|(label, unit)| Axis::linear(label, unit));
    [Axis { scale: scales[0], ..x }, Axis { scale: scales[1], ..y }]
}

fn no_run_selected(request: &PlotRequest) -> RejectedPlot {
    let place = coordinates::text(&places(&request.at));
    let place = if place.is_empty() { place } else { format!(" at {place}") };
    RejectedPlot::new(
        format!("no recording{place} is finished"),
        "run the experiment again to resume it",
    )
}

fn places(at: &[(String, String)]) -> Vec<Coordinate> {
    let place =
        |(key, value): &(String, String)| Coordinate { key: key.clone(), value: value.clone() };
    at.iter().map(place).collect()
}
