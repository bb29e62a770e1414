//! `[[plots]]`: the plots that the analysis shows first.

use crate::checks::{CheckedManifest, Points, check_metric, read_where, selects, write_where};
use crate::diagnostics::{Diagnostic, Errors, nearest};
use crate::keys::{HasKeys as _, Reader, Writer};
use crate::sweep::Coordinate;
use crate::syntax::LineCounter;
use crate::table::table;
use crate::tree::{Node, Table};
use crate::value::{tables, words};
use kinetoscope_console::text::one_line;

/// A plot: a metric over a swept key, or a field of a recorded channel over time.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PlotRequest {
    /// Name of a metric, such as `bed.height`, or of a channel's field, such as `/energy.kinetic_j`.
    pub y: String,
    /// The swept key, as its full name or its last part; `None` for time, and if the sweep has one numeric axis only, or one axis.
    pub x: Option<String>,
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

/// Maximum number of requested plots: the report shows all of them, and each is a file.
const MOST_PLOTS: usize = 100;

/// The name of time as the horizontal axis.
pub const TIME: &str = "time";

impl PlotRequest {
    /// Whether the plot shows a field of a channel rather than a metric.
    #[must_use]
    pub fn is_of_channel(&self) -> bool {
        self.y.starts_with('/')
    }

    /// Whether the plot shows a run or group with these coordinates. A key may be written as its last part only.
    #[must_use]
    pub fn selects(&self, coordinates: &[Coordinate]) -> bool {
        selects(&self.at, coordinates)
    }

    /// The channel with its leading slash, and the field; `None` for a metric, and for a name without a field.
    #[must_use]
    pub fn channel_field(&self) -> Option<(&str, &str)> {
        self.y.split_once('.').filter(|_| self.is_of_channel())
    }
}

table! {
    /// The keys of one of `[[plots]]` except the table `where`.
    pub(crate) struct PlotKeys {
        /// What is plotted: a metric as in metrics.json, such as `bed.height`, or a field of a recorded channel, such as
        /// `/energy.kinetic_j`.
        y: String [""] = String::new(),
        /// The horizontal axis: a swept key, or `time` for a field of a channel. By default time, or the only numeric key of the sweep,
        /// or its only key.
        x: Option<String> ["", optional],
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
    /// The channels that the model can record.
    pub(crate) channels: &'a [&'static str],
    /// The channels that are recorded; `None` for the default.
    pub(crate) recorded: Option<&'a [String]>,
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
    let PlotKeys { y, x, title, log } = keys;
    let mut plot = PlotRequest { y, x, title, log, at, line: 0 };
    if plot.is_of_channel() {
        check_channel(&plot, manifest, &mut reader);
    } else {
        check_y(&plot, manifest, element, &mut reader);
        if let Some(points) = points.filter(|_| reader.has("y")) {
            plot.x = swept_key(plot.x.as_deref(), points, element, &mut reader);
        }
    }
    if plot.title.as_ref().is_some_and(|title| title.trim().is_empty()) {
        reader.refuse(&["title"], "the title of a plot is empty", "leave it out");
    }
    reader.finish();
    plot
}

/// Reports a metric that the model does not have, or a field of a channel without its slash.
fn check_y(
    plot: &PlotRequest,
    known: Option<PlottedManifest<'_>>,
    element: &Node,
    reader: &mut Reader<'_>,
) {
    let metrics = known.and_then(|known| known.manifest.metrics);
    let is_metric = metrics.is_none_or(|metrics| metrics.contains(&plot.y.as_str()));
    let channel = plot.y.split('.').next().unwrap_or_default();
    let is_channel = known.is_some_and(|known| known.channels.contains(&channel));
    let is_near =
        metrics.is_some_and(|metrics| nearest(&plot.y, metrics.iter().copied()).is_some());
    if !is_metric && !is_near && is_channel && plot.y.contains('.') {
        let title = format!("`{}` is not a metric", plot.y);
        reader.refuse(
            &["y"],
            title,
            format!("a field of a channel is written `/{}`", one_line(&plot.y)),
        );
    } else {
        check_metric("a plot", "y", &plot.y, metrics, element, reader);
    }
}

/// Reports a channel that the model does not have or that is not recorded, and another abscissa than time. The fields are those of
/// the recordings, which this package does not know.
fn check_channel(plot: &PlotRequest, known: Option<PlottedManifest<'_>>, reader: &mut Reader<'_>) {
    let Some((topic, _)) = plot.channel_field().filter(|(_, field)| !field.is_empty()) else {
        let title = format!("`{}` names no field", plot.y);
        return reader.refuse(
            &["y"],
            title,
            "must be `/CHANNEL.FIELD`, such as `/energy.kinetic_j`",
        );
    };
    if plot.x.as_deref().is_some_and(|x| x != TIME) {
        let title = format!("`{}` can be plotted over time only", plot.y);
        reader.refuse(&["x"], title, "must be `time`");
    }
    let channel = &topic[1..];
    let Some(known) = known.filter(|_| channel != "frame") else { return };
    if !known.channels.contains(&channel) {
        let label = match nearest(channel, known.channels.iter().copied()) {
            Some(meant) => format!("did you mean `/{meant}`?"),
            None => format!("channels: {}", known.channels.join(", ")),
        };
        reader.refuse(&["y"], format!("the model has no channel `{topic}`"), label);
    } else if known.recorded.is_some_and(|all| !all.iter().any(|recorded| recorded == channel)) {
        let label = format!("add \"{channel}\" to `record.channels`");
        reader.refuse(&["y"], format!("the channel `{topic}` is not recorded"), label);
    }
}

/// The full name of the swept key over which a metric is plotted.
fn swept_key(
    x: Option<&str>,
    points: &Points<'_>,
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
        let label = match nearest(x, last_parts.chain(keys.iter().copied())) {
            Some(meant) => format!("did you mean `{meant}`?"),
            None if keys.is_empty() => "the manifest has no sweep".to_owned(),
            None => format!("must be one of {}", keys.join(", ")),
        };
        reader.refuse(&["x"], format!("`{x}` is not swept"), label);
        return None;
    };
    Some(full.to_owned())
}

/// Writes plots in the form in which they are read.
pub(crate) fn write(plots: &[PlotRequest], writer: &mut Writer) {
    for PlotRequest { y, x, title, log, at, .. } in plots {
        writer.text.push_str("\n[[plots]]\n");
        let (x, title) = (x.clone(), title.clone());
        PlotKeys { y: y.clone(), x, title, log: log.clone() }.keys(writer);
        write_where(at, writer);
    }
}
