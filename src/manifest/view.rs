//! `[view]`: how the report shows the runs first.

use crate::canonical::RunManifest;
use crate::checks::{Points, read_where, selects};
use crate::diagnostics::{Diagnostic, Errors};
use crate::keys::{HasKeys as _, Reader, Writer};
use crate::model::ModelConfig;
use crate::quantity::NonNegative;
use crate::sweep::{Axis, Coordinate, VARIANT};
use crate::table::table;
use crate::tree::{Entry, Node, Value};
use crate::value::{quoted, refuse_type, shortest, words};

words! {
    /// What the color of a particle means.
    pub enum ViewColor {
        /// Its speed.
        Speed = "speed",
        /// Its height in the first frame, so that mixing from top to bottom is visible.
        Height = "height",
        /// Its horizontal position in the first frame, so that mixing from side to side is visible.
        Side = "side",
        /// Its species, such as the masses of a gas; its speed if there is only one.
        Species = "species",
        /// Its angular velocity, if the state has one; its speed if not.
        Spin = "spin",
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
        /// What the color of a particle means in the replay: its speed, its height or side in the first frame, its species, or its spin. By default its speed, of discs at rest in the first picture their height.
        color: Option<ViewColor> ["", optional],
        /// The frame of reference of the replay: that of the recorded positions, or the one that rotates with the second of several bodies about the first one.
        frame: ViewFrame ["", sparse] = ViewFrame::Fixed,
        /// Whether the replay of discs with contacts draws the normal forces, as lines whose width is the force. `record.channels` must contain `contact_forces`.
        forces: bool ["", sparse] = false,
        /// The quantity of which the names of the variants are numbers, such as "packing fraction".
        variants: Option<String> ["", optional],
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
    /// What the color of a particle means; `None` for its speed, or the height at the start of discs at rest.
    pub color: Option<ViewColor>,
    /// The frame of reference; `None` for that of the recorded positions.
    pub frame: Option<ViewFrame>,
    /// Whether contact forces are drawn.
    pub forces: bool,
    /// The quantity of which the names of the variants are numbers.
    pub variants: Option<String>,
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

    /// The coordinates with the quantity of the variants before their names.
    #[must_use]
    pub fn named(&self, coordinates: &[Coordinate]) -> Vec<Coordinate> {
        let mut named = coordinates.to_vec();
        for coordinate in named.iter_mut().filter(|coordinate| coordinate.key == VARIANT) {
            if let Some(quantity) = &self.variants {
                coordinate.value = format!("{quantity} {}", coordinate.value);
            }
        }
        named
    }
}

/// What is known about the manifest of a view.
#[derive(Clone, Copy)]
pub(crate) struct ViewedManifest<'a> {
    /// The axes of its sweep.
    pub(crate) axes: &'a [Axis],
    /// Its runs, each with its coordinates; empty if they cannot be read.
    pub(crate) runs: &'a [ViewedRun<'a>],
}

/// A run that a view may show.
pub(crate) type ViewedRun<'a> = (&'a [Coordinate], &'a RunManifest);

/// Reads the table, and compares it with the manifest if it is part of one.
pub(crate) fn read(
    entry: &Entry,
    manifest: Option<ViewedManifest<'_>>,
    errors: &mut Errors,
) -> ViewRequest {
    let Some(table) = entry.node.table() else {
        return refuse_type(&entry.node, "view", "a table", errors).unwrap_or_default();
    };
    let points = manifest.map(|manifest| Points::new(manifest.axes));
    let errors_before = errors.len();
    let compare = table.get("compare");
    let compare = compare.map_or_else(Vec::new, |entry| compared(entry, points.as_ref(), errors));
    let mut reader = Reader::new("view", table, errors);
    reader.also_known(&["compare"]);
    let mut keys = ViewKeys::default();
    keys.keys(&mut reader);
    check_names(&keys.names, &mut reader);
    if let Some(quantity) = keys.variants.as_ref().filter(|it| !is_shown_name(it)) {
        let title = format!("`view.variants` is {}", quoted(quantity));
        let label = format!("must be 1 to {LONGEST_NAME} characters without control characters");
        reader.refuse(&["variants"], title, label);
    }
    let runs = manifest.map_or(&[][..], |manifest| manifest.runs);
    if !runs.is_empty() {
        check_effect(&keys, runs, &mut reader);
    }
    reader.finish();
    let request = ViewRequest {
        poster: keys.poster.map(NonNegative::get),
        color: keys.color,
        frame: Some(keys.frame).filter(|frame| *frame != ViewFrame::Fixed),
        forces: keys.forces,
        variants: keys.variants,
        names: keys.names,
        compare,
    };
    let is_shown = |place: usize| runs.iter().any(|(at, _)| request.compared(at) == Some(place));
    let is_sound = errors.len() == errors_before && !runs.is_empty();
    if let Some(entry) = table.get("compare").filter(|_| is_sound)
        && !(0..COMPARED).all(is_shown)
    {
        let title = "`view.compare` names the same runs twice";
        errors.push(Diagnostic::new(title).at(entry.node.span, "name two different points"));
    }
    request
}

/// Maximum length of a name, characters: the picture has no room for more.
const LONGEST_NAME: usize = 40;

fn is_shown_name(name: &str) -> bool {
    let is_short = name.chars().count() <= LONGEST_NAME && !name.trim().is_empty();
    is_short && !name.chars().any(char::is_control)
}

/// Reports names that name no particle, that two particles share, or that the picture cannot show.
fn check_names(names: &[String], reader: &mut Reader<'_>) {
    let mut refuse = |title: String, label: &str| reader.refuse(&["names"], title, label);
    let is_new = |(index, name): (usize, &String)| !names[..index].contains(name);
    let repeated =
        names.iter().enumerate().find(|(i, name)| !name.is_empty() && !is_new((*i, *name)));
    if let Some(name) = names.iter().find(|name| name.chars().count() > LONGEST_NAME) {
        let title = format!("a name of `view.names` has {} characters", name.chars().count());
        refuse(title, &format!("must have at most {LONGEST_NAME}"));
    } else if names.iter().any(|name| name.chars().any(char::is_control)) {
        refuse("a name of `view.names` contains a control character".to_owned(), "leave it out");
    } else if let Some((index, name)) = repeated {
        let title = format!("`view.names` names two particles {}", quoted(name));
        refuse(title, &format!("give name {} another word, or \"\" for none", index + 1));
    } else if names.iter().all(|name| name.trim().is_empty()) && reader.has("names") {
        reader.refuse(&["names"], "`view.names` names no particle", "leave it out");
    }
}

/// Whether a run records the force of each contact, which it does only if asked to.
fn records_forces(manifest: &RunManifest) -> bool {
    let channels = manifest.record.channels.as_deref().unwrap_or_default();
    channels.iter().any(|channel| channel == "contact_forces")
}

/// Reports keys that change nothing in any picture of these runs.
fn check_effect(keys: &ViewKeys, runs: &[ViewedRun<'_>], reader: &mut Reader<'_>) {
    let models = || runs.iter().map(|(_, manifest)| &*manifest.model);
    let ends: Option<Vec<f64>> = models().map(ModelConfig::duration).collect();
    let end = ends.and_then(|ends| ends.into_iter().max_by(f64::total_cmp));
    if let (Some(poster), Some(end)) = (keys.poster.map(NonNegative::get), end)
        && poster > end
    {
        let title = format!("`view.poster` is {}, after the end of the run", shortest(poster));
        reader.refuse(&["poster"], title, format!("must be at most {}", shortest(end)));
    }
    if keys.color == Some(ViewColor::Species) && models().any(|model| model.species() < 2) {
        let title = "`view.color` is \"species\", and the particles of a run have only one";
        let label = "add `additional_masses_kg` to the gas, or color by \"speed\"";
        reader.refuse(&["color"], title, label);
    }
    let is_rotating =
        |model: &ModelConfig| matches!(model, ModelConfig::Orbit(_)) && model.particles() > 2;
    if keys.frame == ViewFrame::Rotating && !models().all(is_rotating) {
        let title = "`view.frame` is \"rotating\", which needs an orbit of more than two `bodies`";
        reader.refuse(&["frame"], title, "leave it out");
    }
    if keys.forces && !models().all(|model| matches!(model, ModelConfig::Dem(_))) {
        let title = "`view.forces` is true, and a run has no discs with contacts";
        reader.refuse(&["forces"], title, "leave it out; `model.dem` has contact forces");
    } else if keys.forces && !runs.iter().all(|(_, manifest)| records_forces(manifest)) {
        let title = "`view.forces` is true, and a run does not record `contact_forces`";
        reader.refuse(&["forces"], title, "add \"contact_forces\" to `record.channels`");
    }
    let has_variant = |at: &[Coordinate]| at.iter().any(|it| it.key == VARIANT);
    if keys.variants.is_some() && !runs.iter().all(|(at, _)| has_variant(at)) {
        let title = "`view.variants` is the quantity of variants, and the sweep has none";
        reader.refuse(&["variants"], title, "leave it out, or add [[sweep.variants]]");
    }
    let most = models().map(ModelConfig::particles).max().unwrap_or_default();
    let is_fixed_sun =
        |model: &ModelConfig| matches!(model, ModelConfig::Orbit(_)) && model.particles() == 1;
    if keys.names.first().is_some_and(|name| name == "Sun") && models().any(is_fixed_sun) {
        let title = "`view.names` gives the name of the Sun to the body that moves around it";
        let label = "name the moving body only: the Sun is fixed and has its name";
        reader.refuse(&["names"], title, label);
    } else if keys.names.len() as u64 > most {
        let title = format!("`view.names` has {} names for {most} particles", keys.names.len());
        reader.refuse(&["names"], title, "leave out the others");
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
    let frame = view.frame.unwrap_or(ViewFrame::Fixed);
    let ViewRequest { color, forces, ref variants, ref names, .. } = *view;
    let (variants, names) = (variants.clone(), names.clone());
    ViewKeys { poster, color, frame, forces, variants, names }.keys(writer);
    if !view.compare.is_empty() {
        let pair = |(key, value): &(String, String)| format!("{} = {}", quoted(key), quoted(value));
        let point = |point: &Vec<(String, String)>| {
            format!("{{ {} }}", point.iter().map(pair).collect::<Vec<_>>().join(", "))
        };
        let points: Vec<String> = view.compare.iter().map(point).collect();
        writer.text.push_str(&format!("compare = [{}]\n", points.join(", ")));
    }
}
