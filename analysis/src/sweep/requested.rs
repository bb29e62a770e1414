//! Plots that a manifest or a command line requests: a metric over a swept key, or a field of a channel over time.

use super::reference_lines::{Lines, dashes_of};
use super::samples::{self, Abscissa, Sample, definition, label, typographic_unit};
use crate::input::coordinates::{self, grouped, last_part, without};
use crate::input::key_words::words_and_unit;
use crate::metric::{Definition, Metric, MetricScope, NEEDS_ALL_STATES};
use crate::models::chart_needs_all_states;
use crate::models::figures::time_scale_of;
use crate::plot::{Axis, Curve, CurveStyle, Plot, Point, Scale, extremes};
use crate::run::{RunAnalysis, RunStatus};
use crate::sweep::SweepPoint;
use crate::sweep::figures::{MAX_CURVES, capitalized, shared_charts, stem_of};
use kinetoscope_console::Message;
use kinetoscope_console::text::one_line;
use kinetoscope_manifest::{
    Axis as SweptAxis, Coordinate, PlotAxis, PlotRequest, TIME, channel_field,
};

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
        let (mut plot, replicate) = if let Some(figure) = &request.figure {
            self.chart_of_model(request, figure)?
        } else if request.is_of_channel() {
            self.field_over_time(request)?
        } else {
            (self.metric_over_key(request)?, None)
        };
        if let Some(title) = &request.title {
            plot.title = one_line(title).into_owned();
        }
        // A single run next to a mean of several must not pass for the mean.
        if let Some(replicate) = replicate {
            plot.title += &format!(" ({replicate})");
        }
        plot.stem += &coordinates::file_part(&places(&request.at));
        Ok(plot)
    }

    fn metric_over_key(&self, request: &PlotRequest) -> Result<Plot, Message> {
        let abscissa = Abscissa::find(
            request.x.as_deref(),
            self.places,
            self.axes,
            self.runs.iter().map(|run| &run.manifest),
        )?;
        let names: Vec<&str> = request.ordinates().collect();
        let definitions = self.definitions(&names)?;
        let (mut groups, mut remarks) = (Vec::new(), Vec::new());
        for (definition, metric) in definitions.iter().zip(&names) {
            let samples = self.samples(request, metric, &abscissa);
            if !samples.iter().any(Sample::has_value) {
                return Err(self.without_values(request, metric));
            }
            remarks.extend(omissions(&samples, &abscissa));
            let name = if names.len() > 1 { capitalized(&label(metric).0) } else { String::new() };
            let of_metric = samples::groups(
                &samples,
                &abscissa,
                self.axes,
                (&name, groups.len()),
                &mut remarks,
            );
            groups.extend(of_metric.into_iter().map(|group| (*metric, group)));
            if let ([only], 1) = (samples.as_slice(), names.len()) {
                remarks.push(only.described(&typographic_unit(definition.unit)));
            }
        }
        let (label, is_power_law) = (common_label(&names), label(names[0]).1);
        let unit = typographic_unit(definitions[0].unit);
        let lines =
            Lines { request, abscissa: &abscissa, metrics: self.metrics, points: self.points };
        let mut curves = lines.added_to(groups, &mut remarks);
        if curves.iter().all(|curve| curve.points.is_empty()) {
            return Err(self.without_values(request, names[0]));
        }
        let (x_label, x_unit) = abscissa.label();
        let words = abscissa.words().to_vec();
        let scales = scales(request, &curves, is_power_law, !words.is_empty())?;
        // Theory that the axes cannot show has no entry in the legend.
        let has_point = |curve: &Curve| curve.points.iter().any(|point| can_show(scales, point));
        curves.retain(|curve| curve.style == CurveStyle::Data || has_point(curve));
        remarks.extend(dashes_of(&curves));
        let [across, up] = axes([(&x_label, &x_unit), (&label, &unit)], scales);
        let axes = [Axis { words, ..across }, up];
        let stem = format!("{}_vs_{}", stem_of(names[0]), x_label.replace([' ', '/'], "_"));
        let title = format!("{} against {x_label}", capitalized(&label));
        remarks.dedup();
        Ok(Plot::chart(stem, title, axes, curves).with_remark(&remarks.join("; ")))
    }

    /// The definitions of metrics that share an axis.
    ///
    /// # Errors
    /// A name that is not a metric, or two metrics with different units.
    fn definitions(&self, names: &[&str]) -> Result<Vec<&'static Definition>, Message> {
        let model = self.runs.first().map_or("", |run| run.manifest.model.name());
        let mut definitions: Vec<&'static Definition> = Vec::new();
        for name in names {
            let found = definition(model, name).ok_or_else(|| {
                Message::new(format!("`{name}` is not a metric"), "name a metric of metrics.json")
            })?;
            if let Some(first) = definitions.first().filter(|first| first.unit != found.unit) {
                return Err(Message::new(
                    format!("`{}` and `{name}` have different units", first.name),
                    "draw a plot for each unit",
                ));
            }
            definitions.push(found);
        }
        Ok(definitions)
    }

    /// The values at all selected points: means over replicates, or fits along another axis.
    fn samples(&self, request: &PlotRequest, metric: &str, abscissa: &Abscissa) -> Vec<Sample> {
        let selected = self.points.iter().filter(|point| request.selects(&point.coordinates));
        let of_points: Vec<Sample> =
            selected.map(|point| Sample::of_point(point, metric, abscissa)).collect();
        if of_points.iter().any(|sample| sample.estimate.is_some()) {
            return of_points;
        }
        let fits = self.fits(metric);
        let fits = fits.filter(|(_, metric)| request.selects(metric.coordinates()));
        let fits: Vec<(&str, &Metric)> = fits.collect();
        let Some((along, _)) = fits.first() else { return Vec::new() };
        // Groups without a fit count as points without a value.
        let selected = self.points.iter().filter(|point| request.selects(&point.coordinates));
        let groups = grouped(selected.map(|point| (without(&point.coordinates, along), ())));
        let sample = |(coordinates, _): (Vec<Coordinate>, Vec<()>)| {
            let fit = fits.iter().find(|(_, fit)| fit.coordinates() == coordinates.as_slice());
            Sample {
                x: abscissa.of_place(&coordinates),
                coordinates,
                estimate: fit.map(|(_, fit)| fit.estimate),
                theory: fit.and_then(|(_, fit)| fit.theory?.applicable()),
                law: samples::title_of(fit.and_then(|(_, fit)| fit.theory)),
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
    fn without_values(&self, request: &PlotRequest, y: &str) -> Message {
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

    /// The number of replicates of a run, in words; `None` for one.
    fn one_of_several(&self, run: &RunAnalysis) -> Option<String> {
        let replicates = self.places.iter().filter(|it| **it == run.coordinates).count();
        (replicates > 1).then(|| format!("one of {replicates} replicates"))
    }

    /// A run of each selected point of the sweep, and remarks on those that are left out.
    fn shown(&self, request: &PlotRequest) -> Result<(Vec<&RunAnalysis>, Vec<String>), Message> {
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
        if shown.len() > 1 && shown.iter().any(|run| self.one_of_several(run).is_some()) {
            remarks.push("one replicate of each point".to_owned());
        }
        Ok((shown, remarks))
    }

    /// A chart that the model draws: one curve per run if the runs share it, or else that of the first selected run, with the number of its replicates.
    fn chart_of_model(
        &self,
        request: &PlotRequest,
        figure: &str,
    ) -> Result<(Plot, Option<String>), Message> {
        let (shown, remarks) = self.shown(request)?;
        let compared = shared_charts(&shown).into_iter().find(|plot| plot.stem == figure);
        let (plot, remarks, replicate) = match compared {
            Some(plot) => (plot, remarks.join("; "), None),
            None => {
                let mut drawn = shown.iter().flat_map(|run| {
                    let own = run.figures.plots.iter().find(|plot| plot.stem == figure);
                    own.map(|plot| (plot.clone(), run))
                });
                let (plot, run) = drawn.next().ok_or_else(|| without_chart(&shown, figure))?;
                (plot, coordinates::label(&run.coordinates), self.one_of_several(run))
            }
        };
        Ok((plot.with_remark(&remarks), replicate))
    }

    fn field_over_time(&self, request: &PlotRequest) -> Result<(Plot, Option<String>), Message> {
        let y = request.y.as_str();
        let (topic, field) = channel_field(y).unwrap_or((y, ""));
        if request.x.as_deref().is_some_and(|x| x != TIME) {
            let what = format!("`{y}` can be plotted over time only");
            return Err(Message::new(what, "leave out the horizontal axis, or name `time`"));
        }
        let (shown, remarks) = self.shown(request)?;
        let names: Vec<&str> = request.ordinates().collect();
        let mut curves = Vec::new();
        let of_runs = names.iter().flat_map(|name| shown.iter().map(move |run| (*name, *run)));
        for (color, (field, run)) in of_runs.take(MAX_CURVES).enumerate() {
            let place =
                if shown.len() > 1 { coordinates::label(&run.coordinates) } else { String::new() };
            let words = channel_field(field).map_or("", |(_, field)| field);
            let words = if names.len() > 1 { words_and_unit(words).0 } else { String::new() };
            let parts = [words, place].into_iter().filter(|part| !part.is_empty());
            let name = parts.collect::<Vec<_>>().join(", ");
            let recorded = run.fields.iter().find(|recorded| recorded.name == field);
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
        let label = match words.split(' ').count() {
            1 if unit == "J" => format!("{words} energy"),
            1 => format!("{}: {words}", channel.replace('_', " ")),
            _ => words,
        };
        let scales = scales(request, &curves, false, false)?;
        let time_unit = if shown[0].time_unit == "d" { "days" } else { &shown[0].time_unit };
        let [_, up] = scales;
        let across = if request.log.is_none() {
            curves.first().map_or(Scale::Linear, |curve| {
                time_scale_of(curve.points.iter().map(|point| point.x))
            })
        } else {
            scales[0]
        };
        let axes = axes([("time", time_unit), (&label, unit)], [across, up]);
        let title = format!("{} against time", capitalized(&label));
        let plot = Plot::chart(format!("{channel}_{field}_vs_time"), title, axes, curves);
        let replicate = if let [run] = shown[..] { self.one_of_several(run) } else { None };
        Ok((plot.with_remark(&remarks.join("; ")), replicate))
    }
}

/// Why none of these runs has a chart.
fn without_chart(runs: &[&RunAnalysis], figure: &str) -> Message {
    let what = format!("no recording has the values of the chart `{figure}`");
    let lacks_states =
        |run: &&&RunAnalysis| chart_needs_all_states(run.manifest.model.name(), figure);
    let mut lacking = runs.iter().filter(lacks_states);
    match lacking.find_map(|run| run.restored_by.as_ref()) {
        Some(command) => {
            let help = format!("restore them with `{command}`");
            Message::new(format!("{what}: {NEEDS_ALL_STATES}"), help)
        }
        None => {
            Message::new(what, "`kinetoscope analyze` draws the charts that these recordings have")
        }
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
                for name in request.ordinates() {
                    if !names.iter().any(|other| other == name) {
                        names.push(name.to_owned());
                    }
                }
            }
        }
    }
    wanted
}

/// The words that the names of all these metrics begin with; all names if there are none.
fn common_label(names: &[&str]) -> String {
    let labels: Vec<String> = names.iter().map(|name| label(name).0).collect();
    let words = |label: &String| label.split(' ').map(str::to_owned).collect::<Vec<_>>();
    let mut common = words(&labels[0]);
    for label in &labels[1..] {
        let shared = common.iter().zip(words(label)).take_while(|(one, other)| *one == other);
        common.truncate(shared.count());
    }
    // "self diffusion from" is "self diffusion".
    while common
        .last()
        .is_some_and(|last| ["from", "of", "by", "at", "in", "the"].contains(&last.as_str()))
    {
        common.pop();
    }
    if common.is_empty() { labels.join(", ") } else { common.join(" ") }
}

/// States how many points have no value, or no place on the horizontal axis.
fn omissions(samples: &[Sample], abscissa: &Abscissa) -> Vec<String> {
    let missing = samples.iter().filter(|sample| !sample.has_value()).count();
    let elsewhere = samples.iter().filter(|sample| sample.x.is_none()).count();
    let all = samples.len();
    let missing = (missing > 0).then(|| format!("{missing} of {all} points have no value"));
    let elsewhere = (elsewhere > 0)
        .then(|| format!("{elsewhere} of {all} points have no `{}`", abscissa.name()));
    missing.into_iter().chain(elsewhere).collect()
}

/// A line for each part of a series without a gap; the first part has the name.
fn uninterrupted(points: &[(f64, f64)], name: &str, color: usize) -> Vec<Curve> {
    let parts = points.split(|(_, value)| !value.is_finite()).filter(|part| !part.is_empty());
    let named = |(index, part): (usize, &[(f64, f64)])| {
        Curve::line(if index == 0 { name } else { "" }, color, part.iter().copied())
    };
    parts.enumerate().map(named).collect()
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
