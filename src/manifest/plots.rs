//! `[[plots]]`: the plots that the analysis shows first.

use crate::checks::{
    CheckedManifest, Points, check_metric, names, read_where, selects, write_where,
};
use crate::diagnostics::{Diagnostic, Errors, nearest};
use crate::keys::{HasKeys as _, Reader, Writer};
use crate::quantity::Finite;
use crate::sweep::Coordinate;
use crate::syntax::LineCounter;
use crate::table::table;
use crate::tree::{Node, Table};
use crate::value::{tables, words};
use kinetoscope_console::text::one_line;

/// A plot: a metric over a swept key or another metric, a field of a recorded channel over time, or a chart of the model.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlotRequest {
    /// Name of a metric, such as `bed.height`, or of a channel's field, such as `/energy.kinetic_j`; empty for a chart of the model.
    pub y: String,
    /// Further metrics or fields on the same axes.
    pub also: Vec<String>,
    /// A chart that the analysis of the model draws, such as `energy_balance`, in place of `y`.
    pub figure: Option<String>,
    /// The swept key or a key to which variants give numbers, as its full name or its last part, or a metric; `None` for time, and if the
    /// sweep has one numeric axis only, or one axis.
    pub x: Option<String>,
    /// The function that is fitted to each curve.
    pub fit: Option<PlotFit>,
    /// Exponents of reference lines through the middle of the points.
    pub exponents: Vec<Finite>,
    /// The title; `None` for one that names both quantities.
    pub title: Option<String>,
    /// The logarithmic axes; `None` if the range of the values decides.
    pub log: Option<Vec<PlotAxis>>,
    /// The points of the sweep that are shown: pairs of a key and its value, in the form of [`Coordinate`].
    pub at: Vec<(String, String)>,
    /// The plot's line in the manifest, from 1; 0 if it is not known.
    pub line: u32,
}

words! {
    /// An axis of a plot.
    pub enum PlotAxis {
        /// The horizontal axis.
        X = "x",
        /// The vertical axis.
        Y = "y",
    }
}

words! {
    /// A function that is fitted to the points of a curve by least squares.
    pub enum PlotFit {
        /// A power law y = c x^p.
        Power = "power",
        /// A straight line.
        Linear = "linear",
    }
}

/// Maximum number of requested plots: the report shows all of them, and each is a file.
const MOST_PLOTS: usize = 100;

/// Maximum number of reference lines: the number of distinct colors.
const MOST_EXPONENTS: usize = 7;

/// The name of time as the horizontal axis.
pub const TIME: &str = "time";

impl PlotRequest {
    /// Whether the plot shows a field of a channel rather than a metric.
    #[must_use]
    pub fn is_of_channel(&self) -> bool {
        self.y.starts_with('/')
    }

    /// All metrics or fields of the plot; none for a chart of the model.
    pub fn ordinates(&self) -> impl Iterator<Item = &str> {
        let y = Some(self.y.as_str()).filter(|y| !y.is_empty());
        y.into_iter().chain(self.also.iter().map(String::as_str))
    }

    /// What the plot shows, as the manifest names it.
    #[must_use]
    pub fn subject(&self) -> &str {
        self.figure.as_deref().unwrap_or(&self.y)
    }

    /// Whether the plot shows a run or group with these coordinates. A key may be written as its last part only.
    #[must_use]
    pub fn selects(&self, coordinates: &[Coordinate]) -> bool {
        selects(&self.at, coordinates)
    }
}

/// The channel with its leading slash, and the field, of a name such as `/energy.kinetic_j`; `None` for a metric, and for a name
/// without a field.
#[must_use]
pub fn channel_field(name: &str) -> Option<(&str, &str)> {
    name.split_once('.').filter(|_| name.starts_with('/'))
}

table! {
    /// The keys of one of `[[plots]]` except the table `where`.
    pub(crate) struct PlotKeys {
        /// What is plotted: a metric as in metrics.json, such as `bed.height`, or a field of a recorded channel, such as
        /// `/energy.kinetic_j`.
        y: Option<String> ["", optional],
        /// Further metrics or fields on the same axes.
        also: Option<Vec<String>> ["", optional],
        /// In place of `y`: a chart that the analysis of the model draws for a run, such as `energy_balance`. `kinetoscope analyze` names
        /// the file of each.
        figure: Option<String> ["", optional],
        /// The horizontal axis: a swept key, a key to which the variants of the sweep give numbers, another metric, or `time` for a field
        /// of a channel. By default time, or the only numeric key of the sweep, or its only key.
        x: Option<String> ["", optional],
        /// A function that is fitted to each curve by least squares: `power` or `linear`.
        fit: Option<PlotFit> ["", optional],
        /// Exponents of power laws that are drawn as reference lines through the middle of the points, at most 7.
        exponents: Option<Vec<Finite>> ["", optional],
        /// Title of the plot; by default the names of both quantities.
        title: Option<String> ["", optional],
        /// Logarithmic axes: `["x", "y"]`, one of them, or `[]` for none. By default, the range of the values decides.
        log: Option<Vec<PlotAxis>> ["", optional],
    }
}

/// What is known about the manifest that requests plots.
#[derive(Clone, Copy)]
pub(crate) struct PlottedManifest<'a> {
    /// Its text, axes and metrics.
    pub(crate) manifest: CheckedManifest<'a>,
    /// The keys to which the variants of its sweep give numbers.
    pub(crate) numbers_of_variants: &'a [String],
    /// The channels that the model can record.
    pub(crate) channels: &'a [&'static str],
    /// The channels that are recorded; `None` for the default.
    pub(crate) recorded: Option<&'a [String]>,
    /// The charts that the analysis of the model draws; `None` if they are not known.
    pub(crate) figures: Option<&'a [&'static str]>,
}

/// Reads all plots, and compares them with their manifest if they are part of one.
pub(crate) fn read(
    node: &Node,
    manifest: Option<PlottedManifest<'_>>,
    errors: &mut Errors,
) -> Vec<PlotRequest> {
    let mut tables = tables(node, "plots", ["tables [[plots]]", "a table"], errors);
    if tables.len() > MOST_PLOTS {
        let title = format!("{} plots are requested; must be at most {MOST_PLOTS}", tables.len());
        errors.push(Diagnostic::new(title).at(tables[MOST_PLOTS].0.span, "the first too many"));
        tables.truncate(MOST_PLOTS);
    }
    let mut lines = manifest.map(|known| LineCounter::new(known.manifest.source));
    let points = manifest.and_then(|known| known.manifest.axes).map(Points::new);
    let mut plots = Vec::new();
    for (element, table) in tables {
        let line = lines.as_mut().map_or(0, |lines| lines.line_of(element.span.start));
        let mut plot = read_one(element, table, points.as_ref(), manifest, errors);
        plot.line = u32::try_from(line).unwrap_or(u32::MAX);
        plots.push(plot);
    }
    plots
}

fn read_one(
    element: &Node,
    table: &Table,
    points: Option<&Points<'_>>,
    manifest: Option<PlottedManifest<'_>>,
    errors: &mut Errors,
) -> PlotRequest {
    let at = table.get("where");
    let at = at.map_or_else(Vec::new, |place| read_where("plots", place, points, errors));
    let mut reader = Reader::new("plots", table, errors);
    reader.also_known(&["where"]);
    let mut keys = PlotKeys::default();
    keys.keys(&mut reader);
    let PlotKeys { y, also, figure, x, fit, exponents, title, log } = keys;
    let (also, exponents) = (also.unwrap_or_default(), exponents.unwrap_or_default());
    let y = y.unwrap_or_default();
    let mut plot = PlotRequest { y, also, figure, x, fit, exponents, title, log, at, line: 0 };
    if let Some(figure) = &plot.figure {
        check_figure(figure, table, manifest.and_then(|known| known.figures), &mut reader);
    } else if plot.is_of_channel() {
        check_channel(&plot.y, "y", manifest, &mut reader);
        plot.also.iter().for_each(|name| check_channel(name, "also", manifest, &mut reader));
        if plot.x.as_deref().is_some_and(|x| x != TIME) {
            let title = format!("`{}` can be plotted over time only", plot.y);
            reader.refuse(&["x"], title, "must be `time`");
        }
    } else {
        check_y(&plot.y, "y", manifest, element, &mut reader);
        plot.also.iter().for_each(|name| check_y(name, "also", manifest, element, &mut reader));
        let metrics = manifest.and_then(|known| known.manifest.metrics);
        let is_metric = |x: &str| metrics.is_none_or(|metrics| metrics.contains(&x));
        let of_variants = manifest.map_or(&[][..], |known| known.numbers_of_variants);
        let x = plot.x.as_deref().filter(|x| points.is_some_and(|it| it.full_name(x).is_none()));
        let set = x.filter(|x| metrics.is_none_or(|metrics| !metrics.contains(x)));
        let set = set.and_then(|x| of_variants.iter().find(|key| names(x, key)));
        if let Some(key) = set {
            plot.x = Some(key.clone());
        } else if let Some(points) = points
            && reader.has("y")
            && !plot.x.as_deref().is_some_and(|x| points.full_name(x).is_none() && is_metric(x))
        {
            plot.x = swept_key(plot.x.as_deref(), points, metrics, element, &mut reader);
        }
    }
    if plot.exponents.len() > MOST_EXPONENTS {
        let title = format!("`plots.exponents` has {} numbers", plot.exponents.len());
        reader.refuse(&["exponents"], title, format!("must have at most {MOST_EXPONENTS}"));
    }
    if plot.title.as_ref().is_some_and(|title| title.trim().is_empty()) {
        reader.refuse(&["title"], "the title of a plot is empty", "leave it out");
    }
    reader.finish();
    plot
}

/// Reports a chart that the model does not draw, and keys that do not apply to one.
fn check_figure(
    figure: &str,
    table: &Table,
    known: Option<&[&'static str]>,
    reader: &mut Reader<'_>,
) {
    for key in ["y", "also", "x", "fit", "exponents", "log"] {
        if table.get(key).is_some() {
            let title = format!("`{key}` cannot be used together with `figure`");
            reader.refuse(&[key], title, "the model's chart has axes of its own");
        }
    }
    if let Some(known) = known.filter(|known| !known.contains(&figure)) {
        let label = match nearest(figure, known.iter().copied()) {
            Some(meant) => format!("did you mean `{meant}`?"),
            None => format!("must be one of {}", known.join(", ")),
        };
        reader.refuse(&["figure"], format!("the model has no chart `{figure}`"), label);
    }
}

/// Reports a metric that the model does not have, or a field of a channel without its slash.
fn check_y(
    name: &str,
    key: &'static str,
    known: Option<PlottedManifest<'_>>,
    element: &Node,
    reader: &mut Reader<'_>,
) {
    let metrics = known.and_then(|known| known.manifest.metrics);
    let is_metric = metrics.is_none_or(|metrics| metrics.contains(&name));
    let channel = name.split('.').next().unwrap_or_default();
    let is_channel = known.is_some_and(|known| known.channels.contains(&channel));
    let is_near = metrics.is_some_and(|metrics| nearest(name, metrics.iter().copied()).is_some());
    if !is_metric && !is_near && is_channel && name.contains('.') {
        let title = format!("`{name}` is not a metric");
        let label = format!("a field of a channel is written `/{}`", one_line(name));
        reader.refuse(&[key], title, label);
    } else {
        check_metric("a plot", key, name, metrics, element, reader);
    }
}

/// Reports a channel that the model does not have or that is not recorded. The fields are those of the recordings, which this package
/// does not know.
fn check_channel(
    name: &str,
    key: &'static str,
    known: Option<PlottedManifest<'_>>,
    reader: &mut Reader<'_>,
) {
    let Some((topic, _)) = channel_field(name).filter(|(_, field)| !field.is_empty()) else {
        let title = format!("`{name}` names no field");
        return reader.refuse(
            &[key],
            title,
            "must be `/CHANNEL.FIELD`, such as `/energy.kinetic_j`",
        );
    };
    let channel = &topic[1..];
    let Some(known) = known.filter(|_| channel != "frame") else { return };
    if !known.channels.contains(&channel) {
        let label = match nearest(channel, known.channels.iter().copied()) {
            Some(meant) => format!("did you mean `/{meant}`?"),
            None => format!("channels: {}", known.channels.join(", ")),
        };
        reader.refuse(&[key], format!("the model has no channel `{topic}`"), label);
    } else if known.recorded.is_some_and(|all| !all.iter().any(|recorded| recorded == channel)) {
        let label = format!("add \"{channel}\" to `record.channels`");
        reader.refuse(&[key], format!("the channel `{topic}` is not recorded"), label);
    }
}

/// The full name of the swept key over which a metric is plotted.
fn swept_key(
    x: Option<&str>,
    points: &Points<'_>,
    metrics: Option<&[&'static str]>,
    element: &Node,
    reader: &mut Reader<'_>,
) -> Option<String> {
    let all = points.axis_keys();
    let Some(x) = x else {
        // Without numbers, words are the axis.
        let numeric = Some(points.numeric_keys()).filter(|axes| !axes.is_empty());
        let kind = if numeric.is_some() { "numeric axes" } else { "axes" };
        let axes = numeric.as_ref().unwrap_or(&all);
        return match axes.as_slice() {
            // A value of another type is reported where it is read.
            _ if reader.has("x") => None,
            [axis] => axis.first().map(|key| (*key).to_owned()),
            [] => {
                let label =
                    "without a sweep, plot a field of a channel, such as `/energy.kinetic_j`";
                let title = "a plot of a metric needs a swept key";
                reader.report(Diagnostic::new(title).at(element.span, label));
                None
            }
            _ => {
                let title = format!("a plot needs `x`: the sweep has {} {kind}", axes.len());
                let label = format!("must be one of {}", axes.concat().join(", "));
                reader.report(Diagnostic::new(title).at(element.span, label));
                None
            }
        };
    };
    let Some(full) = points.full_name(x) else {
        let keys = all.concat();
        let last_parts = keys.iter().filter_map(|key| key.rsplit('.').next());
        let metrics = metrics.unwrap_or_default().iter().copied();
        let label = match nearest(x, last_parts.chain(keys.iter().copied()).chain(metrics)) {
            Some(meant) => format!("did you mean `{meant}`?"),
            None if keys.is_empty() => "the manifest has no sweep".to_owned(),
            None => format!("must be one of {}", keys.join(", ")),
        };
        reader.refuse(&["x"], format!("`{x}` is neither swept nor a metric"), label);
        return None;
    };
    Some(full.to_owned())
}

/// Writes plots in the form in which they are read.
pub(crate) fn write(plots: &[PlotRequest], writer: &mut Writer) {
    for plot in plots.iter().cloned() {
        writer.text.push_str("\n[[plots]]\n");
        let PlotRequest { y, also, figure, x, fit, exponents, title, log, at, .. } = plot;
        let y = Some(y).filter(|y| !y.is_empty());
        let also = Some(also).filter(|also| !also.is_empty());
        let exponents = Some(exponents).filter(|exponents| !exponents.is_empty());
        PlotKeys { y, also, figure, x, fit, exponents, title, log }.keys(writer);
        write_where(&at, writer);
    }
}
