//! `[view]`: how the report shows the runs first.

use crate::checks::{Points, read_where, selects};
use crate::diagnostics::{Diagnostic, Errors};
use crate::keys::{HasKeys as _, Reader, Writer};
use crate::quantity::NonNegative;
use crate::sweep::{Axis, Coordinate};

use crate::table::table;
use crate::tree::{Entry, Node, Value};
use crate::value::{quoted, refuse_type, words};

words! {
    /// What the color of a particle means.
    pub enum ViewColor {
        /// Its speed.
        Speed = "speed",
        /// Its height in the first frame, so that mixing from top to bottom is visible.
        Height = "height",
        /// Its horizontal position in the first frame, so that mixing from side to side is visible.
        Side = "side",
    }
}

words! {
    /// The frame of reference of a replay.
    pub enum ViewFrame {
        /// That of the recorded positions.
        Fixed = "fixed",
        /// The frame that rotates with the second body about the first one, such as Jupiter about the Sun; of more than two bodies.
        Rotating = "rotating",
    }
}

table! {
    /// The keys of `[view]` except the list `compare`.
    pub(crate) struct ViewKeys {
        /// Time of the frame that the report shows first, in the model's unit; by default the most telling one, mostly the last.
        poster: Option<NonNegative> ["", optional],
        /// What the color of a particle means in the replay: its speed, or its height or side in the first frame.
        color: ViewColor ["", sparse] = ViewColor::Speed,
        /// The frame of reference of the replay: that of the recorded positions, or the one that rotates with the second of several bodies about the first one.
        frame: ViewFrame ["", sparse] = ViewFrame::Fixed,
        /// Names of the first particles, such as those of planets; "" for none. The Sun is yellow. By default those of the recording.
        names: Vec<String> ["", sparse] = Vec::new(),
    }
}

/// Points that are compared.
const COMPARED: usize = 2;

/// How the report shows the runs first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ViewRequest {
    /// Time of the frame that is shown first, in the model's unit; `None` for the most telling one.
    pub poster: Option<f64>,
    /// What the color of a particle means; `None` for its speed.
    pub color: Option<ViewColor>,
    /// The frame of reference; `None` for that of the recorded positions.
    pub frame: Option<ViewFrame>,
    /// Names of the first particles; empty for those of the recording.
    pub names: Vec<String>,
    /// The two points of the sweep that are compared, in the form of [`Coordinate`]; empty for its ends.
    pub compare: Vec<Vec<(String, String)>>,
}

impl ViewRequest {
    /// The place of a run with these coordinates in the comparison, from 0; `None` if it is not compared.
    #[must_use]
    pub fn compared(&self, coordinates: &[Coordinate]) -> Option<usize> {
        self.compare.iter().position(|at| selects(at, coordinates))
    }
}

/// Reads the table, and compares it with the sweep of its manifest if it is part of one.
pub(crate) fn read(entry: &Entry, axes: Option<&[Axis]>, errors: &mut Errors) -> ViewRequest {
    let Some(table) = entry.node.table() else {
        return refuse_type(&entry.node, "view", "a table", errors).unwrap_or_default();
    };
    let points = axes.map(Points::new);
    let compare = table.get("compare");
    let compare = compare.map_or_else(Vec::new, |entry| compared(entry, points.as_ref(), errors));
    let mut reader = Reader::new("view", table, errors);
    reader.also_known(&["compare"]);
    let mut keys = ViewKeys::default();
    keys.keys(&mut reader);
    reader.finish();
    ViewRequest {
        poster: keys.poster.map(NonNegative::get),
        color: Some(keys.color).filter(|color| *color != ViewColor::Speed),
        frame: Some(keys.frame).filter(|frame| *frame != ViewFrame::Fixed),
        names: keys.names,
        compare,
    }
}

/// Reads the two points.
fn compared(
    entry: &Entry,
    points: Option<&Points<'_>>,
    errors: &mut Errors,
) -> Vec<Vec<(String, String)>> {
    let elements: &[Node] = match &entry.node.value {
        Value::Array(elements) => elements,
        _ => &[],
    };
    if elements.len() != COMPARED {
        let label = "must be two points, such as [{ friction = 0 }, { friction = 0.5 }]";
        let title = "`view.compare` does not name two points of the sweep";
        errors.push(Diagnostic::new(title).at(entry.node.span, label));
        return Vec::new();
    }
    let mut read = |node: &Node| {
        let element =
            Entry { key: entry.key.clone(), key_span: entry.key_span, node: node.clone() };
        read_where("view.compare", &element, points, errors)
    };
    elements.iter().map(&mut read).collect()
}

/// Writes the table in the form in which it is read; nothing if no key is given.
pub(crate) fn write(view: &ViewRequest, writer: &mut Writer) {
    if *view == ViewRequest::default() {
        return;
    }
    writer.text.push_str("\n[view]\n");
    let poster = view.poster.and_then(NonNegative::new);
    let color = view.color.unwrap_or(ViewColor::Speed);
    let frame = view.frame.unwrap_or(ViewFrame::Fixed);
    ViewKeys { poster, color, frame, names: view.names.clone() }.keys(writer);
    if !view.compare.is_empty() {
        let pair = |(key, value): &(String, String)| format!("{} = {}", quoted(key), quoted(value));
        let point = |point: &Vec<(String, String)>| {
            format!("{{ {} }}", point.iter().map(pair).collect::<Vec<_>>().join(", "))
        };
        let points: Vec<String> = view.compare.iter().map(point).collect();
        writer.text.push_str(&format!("compare = [{}]\n", points.join(", ")));
    }
}
