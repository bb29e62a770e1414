//! Plots that a manifest or a command line requests: a metric over a swept key, or a field of a channel over time.

use super::swept_key::{position, swept_key, words};
use crate::input::coordinates::{self, grouped, last_part, without};
use crate::metric::{Definition, Metric, MetricScope};
use crate::models::MODELS;
use crate::number_text::{six_digits, with_error};
use crate::plot::{Axis, Curve, CurveStyle, Plot, Point, Scale, extremes};
use crate::run::{RunAnalysis, RunStatus};
use crate::statistics::Estimate;
use crate::sweep::figures::{MAX_CURVES, capitalized, stem_of, words_and_unit};
use crate::sweep::{SHARED_STREAMS, SweepPoint, share_random_streams};
use kinetoscope_console::Message;
use kinetoscope_console::text::one_line;
use kinetoscope_manifest::{Axis as SweptAxis, Coordinate, PlotAxis, PlotRequest, TIME};

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
    pub(crate) fn draw(&self, request: &PlotRequest) -> Result<Plot, Message> {
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

    fn metric_over_key(&self, request: &PlotRequest) -> Result<Plot, Message> {
        let y = request.y.as_str();
        let definition = definition(y).ok_or_else(|| {
            Message::new(format!("`{y}` is not a metric"), "name a metric of metrics.json")
        })?;
        let key = swept_key(request.x.as_deref(), self.places, self.axes)?;
        let words = words(&key, self.places);
        let samples = self.samples(request);
        let mut remarks = Vec::new();
        let abscissa = |place: &[Coordinate]| position(place, &key, &words);
        let mut curves =
            curves(&samples, &key, abscissa, !words.is_empty(), self.axes, &mut remarks);
        let missing = samples.iter().filter(|sample| !sample.has_value()).count();
        if curves.is_empty() {
            return Err(self.without_values(request));
        }
        if missing > 0 {
            remarks.push(format!("{missing} of {} points have no value", samples.len()));
        }
        let has_place = |sample: &&Sample| abscissa(&sample.coordinates).is_some();
        let elsewhere = samples.iter().filter(|sample| !has_place(sample)).count();
        if elsewhere > 0 {
            let key = last_part(&key);
            remarks.push(format!("{elsewhere} of {} points have no `{key}`", samples.len()));
        }
        let unit = if definition.unit == "1" { "" } else { definition.unit };
        if let [only] = samples.as_slice() {
            remarks.push(only.described(unit));
        } else if share_random_streams(self.points, y) {
            remarks.push(SHARED_STREAMS.to_owned());
        }
        let (label, is_power_law) = label(y);
        let (x_label, x_unit) = words_and_unit(last_part(&key));
        let scales = scales(request, &curves, is_power_law, !words.is_empty())?;
        // Theory that the axes cannot show has no entry in the legend.
        let has_point = |curve: &Curve| curve.points.iter().any(|point| can_show(scales, point));
        curves.retain(|curve| curve.style == CurveStyle::Data || has_point(curve));
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
        let fits = self.fits(&request.y);
        let fits = fits.filter(|(_, metric)| request.selects(metric.coordinates()));
        let fits: Vec<(&str, &Metric)> = fits.collect();
        let Some((along, _)) = fits.first() else { return Vec::new() };
        // Groups without a fit count as points without a value.
        let selected = self.points.iter().filter(|point| request.selects(&point.coordinates));
        let groups = grouped(selected.map(|point| (without(&point.coordinates, along), ())));
        let sample = |(coordinates, _): (Vec<Coordinate>, Vec<()>)| {
            let fit = fits.iter().find(|(_, fit)| fit.coordinates() == coordinates.as_slice());
            Sample {
                coordinates,
                estimate: fit.map(|(_, fit)| fit.estimate),
                theory: fit.and_then(|(_, fit)| fit.theory?.applicable()),
            }
        };
        groups.into_iter().map(sample).collect()
    }

    /// The fits with this name, with the key along which each is fitted.
    fn fits(&self, name: &str) -> impl Iterator<Item = (&str, &Metric)> {
        self.metrics.iter().filter(move |metric| metric.name() == name).filter_map(|metric| {
            match &metric.scope {
                MetricScope::Sweep(sweep) => Some((sweep.along.as_deref()?, metric)),
                MetricScope::Run(_) => None,
            }
        })
    }

    /// Why a metric has no value at any selected point.
    fn without_values(&self, request: &PlotRequest) -> Message {
        let y = &request.y;
        if !self.points.iter().any(|point| request.selects(&point.coordinates)) {
            return self.no_run_selected(request);
        }
        if let Some((along, _)) = self.fits(y).next() {
            let help = format!(
                "name another key as the horizontal axis: each value is a fit along `{}`",
                last_part(along)
            );
            return Message::new(format!("`{y}` has no value at a single point"), help);
        }
        let mut measurements = self.runs.iter().flat_map(|run| &run.measurements);
        let reason = measurements
            .find(|found| found.name() == y)
            .and_then(|found| found.reason.as_ref().map(ToString::to_string));
        let why = reason.map_or_else(String::new, |reason| format!(": {reason}"));
        Message::new(
            format!("no finished run has a value of `{y}`{why}"),
            "`kinetoscope analyze` reports the metrics of these recordings",
        )
    }

    fn no_run_selected(&self, request: &PlotRequest) -> Message {
        let place = coordinates::text(&places(&request.at));
        let place = if place.is_empty() { place } else { format!(" at {place}") };
        let mut selected = self.runs.iter().filter(|run| request.selects(&run.coordinates));
        if selected.any(|run| matches!(run.ending, RunStatus::Fault(_))) {
            return Message::new(
                format!("the run{place} failed, so it has no metrics"),
                "plot a field of a channel, such as `/energy.kinetic_j`; `kinetoscope analyze` states the failure",
            );
        }
        Message::new(
            format!("no recording{place} is finished"),
            "run the experiment again to resume it",
        )
    }

    /// Which of several replicates is drawn.
    fn one_of_several(&self, shown: &[&RunAnalysis]) -> Option<String> {
        let replicates =
            |run: &&RunAnalysis| self.places.iter().filter(|it| **it == run.coordinates).count();
        let most = shown.iter().map(replicates).max().filter(|most| *most > 1)?;
        Some(match shown {
            [run] => format!("replicate {}, one of {most}", run.manifest.replicate),
            _ => "one replicate of each point".to_owned(),
        })
    }

    fn field_over_time(&self, request: &PlotRequest) -> Result<Plot, Message> {
        let y = request.y.as_str();
        let (topic, field) = request.channel_field().unwrap_or((y, ""));
        if request.x.as_deref().is_some_and(|x| x != TIME) {
            let what = format!("`{y}` can be plotted over time only");
            return Err(Message::new(what, "leave out the horizontal axis, or name `time`"));
        }
        let mut shown: Vec<&RunAnalysis> = Vec::new();
        for run in self.runs.iter().filter(|run| request.selects(&run.coordinates)) {
            if !shown.iter().any(|other| other.coordinates == run.coordinates) {
                shown.push(run);
            }
        }
        if shown.is_empty() {
            return Err(self.no_run_selected(request));
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
            return Err(Message::new(what, help));
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
    fn described(&self, unit: &str) -> String {
        let with_unit = |number: String| format!("{number} {unit}").trim_end().to_owned();
        let measured = self.estimate.map_or_else(String::new, |estimate| {
            with_unit(with_error(estimate.value, estimate.standard_error))
        });
        let theory =
            self.theory.map(|theory| format!(", theory {}", with_unit(six_digits(theory))));
        let place = coordinates::label(&self.coordinates);
        format!("{place}: measured {measured}{}", theory.unwrap_or_default())
    }
}

/// One curve of data and one of theory for each group of points that differ in the key only.
fn curves(
    samples: &[Sample],
    key: &str,
    abscissa: impl Fn(&[Coordinate]) -> Option<f64>,
    has_words: bool,
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
            // A line needs two points, except over words.
            let least = usize::from(style == CurveStyle::Theory && !has_words);
            if points.len() > least {
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
) -> Result<[Scale; 2], Message> {
    let values = |of: fn(&Point) -> f64| curves.iter().flat_map(|curve| &curve.points).map(of);
    // An axis that contains 0 is linear, so that every point is drawn.
    let suits_log = |of: fn(&Point) -> f64, is_power_law: bool| {
        let is_steep = |(low, high): (f64, f64)| is_power_law || high > STEEP * low;
        extremes(values(of)).is_some_and(|range| range.0 > 0.0 && is_steep(range))
    };
    let [x, y]: [fn(&Point) -> f64; 2] = [|point| point.x, |point| point.y];
    let is_log = match &request.log {
        Some(axes) => [axes.contains(&PlotAxis::X), axes.contains(&PlotAxis::Y)],
        // Time is shown as it passes.
        None if request.is_of_channel() => [false, suits_log(y, false)],
        None => [!has_words && suits_log(x, is_power_law), suits_log(y, is_power_law)],
    };
    if has_words && is_log[0] {
        let what = "the values of the horizontal axis are words, which have no logarithms";
        return Err(Message::new(what, "use a linear horizontal axis"));
    }
    let scales = is_log.map(|is_log| if is_log { Scale::Logarithmic } else { Scale::Linear });
    if !curves.iter().flat_map(|curve| &curve.points).any(|point| can_show(scales, point)) {
        let what = format!("no point of `{}` is above zero on its logarithmic axis", request.y);
        return Err(Message::new(what, "use a linear axis"));
    }
    Ok(scales)
}

/// Whether axes of these scales show a point.
fn can_show(scales: [Scale; 2], point: &Point) -> bool {
    let axes = scales.iter().zip([point.x, point.y]);
    axes.into_iter().all(|(scale, value)| *scale == Scale::Linear || value > 0.0)
}

fn axes(labels: [(&str, &str); 2], scales: [Scale; 2]) -> [Axis; 2] {
    let [x, y] = labels.map(|(label, unit)| Axis::linear(label, unit));
    [Axis { scale: scales[0], ..x }, Axis { scale: scales[1], ..y }]
}

fn places(at: &[(String, String)]) -> Vec<Coordinate> {
    let place =
        |(key, value): &(String, String)| Coordinate { key: key.clone(), value: value.clone() };
    at.iter().map(place).collect()
}
