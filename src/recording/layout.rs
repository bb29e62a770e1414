//! The viewer's layout for a run: the model's template with the run's camera and time scale, without panels for topics that are
//! not recorded. A layout for several runs states no time scale unless it is that of all.

use crate::channels;
use crate::error::RecordError;
use crate::header::Header;
use crate::plot_labels::{change_title, move_long_labels};
use crate::requested_panels::{PanelRequest, add_requested, move_to_the_top};
use crate::scenery::{GuideMeaning, Scenery, Wall};
use serde_json::{Map, Value, json};

/// Height of the strip for the color bar below the container, over the container's longer side.
const LEGEND_STRIP: f64 = 0.1;
/// Space around container and color bar.
const MARGIN: f64 = 1.12;
/// Space around a view without a color bar.
const MARGIN_WITHOUT_LEGEND: f64 = 1.06;

/// Width over height of the scene's panel: 1.38 on a screen of 1920 x 1080 and 1.15 on 1366 x 768 with an open sidebar. The
/// smaller value fits both.
const PANEL_ASPECT: f64 = 1.15;
/// Height of the scene's panel on a screen of 1920 x 1080, px.
const PANEL_HEIGHT_PX: f64 = 700.0;
/// Diameter below which a disc disappears under its outline, px.
const MIN_OUTLINED_PX: f64 = 6.0;

/// The key of a plot's label at the x axis.
const TIME_LABEL: &str = "xAxisLabel";
/// Label of the time axis where the runs have different scales.
const LABEL_WITHOUT_SCALE: &str = "playback time (s), scale in the log";

/// The template of a model, as it stands in `layouts/`.
#[must_use]
pub fn template(model: &str) -> Option<&'static str> {
    match model {
        "dem" => Some(include_str!("layouts/dem.json")),
        "gas" => Some(include_str!("layouts/gas.json")),
        "packing" => Some(include_str!("layouts/packing.json")),
        "orbit" => Some(include_str!("layouts/orbit.json")),
        _ => None,
    }
}

/// The layout of a run for Foxglove and Lichtblick, as JSON: panels for the plots that the manifest requests, and those of the template.
/// It names only topics that the run records.
///
/// # Errors
/// A model without a template, or a template that is no layout: defects of the program.
pub fn layout_json(header: &Header, requests: &[PanelRequest]) -> Result<String, RecordError> {
    let defect = |what: &str| {
        RecordError::Declaration(format!("the layout of model {} {what}", header.model))
    };
    let template = template(header.model).ok_or_else(|| defect("does not exist"))?;
    let mut layout: Value =
        serde_json::from_str(template).map_err(|error| defect(&format!("is no JSON ({error})")))?;
    let panels = layout.get_mut("configById").and_then(Value::as_object_mut);
    let panels = panels.ok_or_else(|| defect("has no panels"))?;
    let requested = add_requested(panels, requests, header);
    panels.retain(|_, panel| keep_recorded(panel, header));
    for (id, panel) in panels.iter_mut() {
        let panel = panel.as_object_mut().ok_or_else(|| defect("has a panel that is no object"))?;
        if id.starts_with("3D!") {
            name_lines(panel, header);
            let distance = aim_camera(panel, header.scenery.view);
            let pixels = smallest_disc_px(&header.scenery, distance);
            outline_discs(panel, pixels);
            size_points(panel, pixels);
        } else if is_over_time(panel) {
            panel.insert(TIME_LABEL.to_owned(), json!(time_label(header)));
        }
    }
    let kept: Vec<String> = panels.keys().cloned().collect();
    let tree = layout.get("layout").and_then(|tree| pruned(tree, &kept));
    let mut tree = tree.ok_or_else(|| defect("has no panel for what is recorded"))?;
    if let Some(panels) = layout.get_mut("configById").and_then(Value::as_object_mut) {
        move_to_the_top(&mut tree, panels, &requested);
        move_long_labels(&tree, panels, 1.0);
    }
    layout["layout"] = tree;
    Ok(format!("{layout:#}\n"))
}

/// The same layout for runs with different time scales: its labels refer to the log, which has the scale of the recording.
///
/// # Errors
/// A text that is no layout: a defect of the program.
pub fn without_time_scale(layout: &str) -> Result<String, RecordError> {
    with_changed_panels(layout, |_, panel| {
        if is_over_time(panel) {
            panel.insert(TIME_LABEL.to_owned(), json!(LABEL_WITHOUT_SCALE));
        }
    })
}

/// The same layout with the names that a manifest gives to bodies, where the run draws their numbers.
///
/// # Errors
/// A text that is no layout: a defect of the program.
pub fn with_names(layout: &str, header: &Header, names: &[String]) -> Result<String, RecordError> {
    let drawn = header.scenery.names.iter().zip(0..);
    let is_numbered = drawn.clone().all(|(drawn, number)| *drawn == u64::to_string(&number));
    let named = drawn.zip(names).filter(|(_, name)| is_numbered && !name.is_empty());
    let named: Vec<String> = named.map(|((number, _), name)| format!("{number} {name}")).collect();
    with_changed_panels(layout, |id, panel| {
        if id.starts_with("3D!") && !named.is_empty() {
            // In front of what is the same in every run.
            change_title(panel, |title| {
                title.replacen(';', &format!("; {};", named.join(", ")), 1)
            });
        }
    })
}

/// The same layout for runs of which not every frame is drawn: it shows the points of the states, which do not stand still in between.
///
/// # Errors
/// A text that is no layout: a defect of the program.
pub fn with_states(layout: &str) -> Result<String, RecordError> {
    with_changed_panels(layout, |_, panel| {
        let topics = panel.get_mut("topics").and_then(Value::as_object_mut);
        let Some(topics) = topics.filter(|topics| topics.contains_key(channels::STATE)) else {
            return;
        };
        for (topic, settings) in topics {
            if ![channels::WALLS, channels::TRAIL].contains(&topic.as_str()) {
                settings["visible"] = json!(topic == channels::STATE);
            }
        }
        change_title(panel, |_| "Particles as points, because not every frame is drawn".to_owned());
    })
}

fn with_changed_panels(
    layout: &str,
    change: impl Fn(&str, &mut Map<String, Value>),
) -> Result<String, RecordError> {
    let defect = |error| RecordError::Declaration(format!("the layout is no JSON ({error})"));
    let mut layout: Value = serde_json::from_str(layout).map_err(defect)?;
    let panels = layout.get_mut("configById").and_then(Value::as_object_mut);
    for (id, panel) in panels.into_iter().flatten() {
        if let Some(panel) = panel.as_object_mut() {
            change(id, panel);
        }
    }
    Ok(format!("{layout:#}\n"))
}

/// Whether a layout shows the states.
#[must_use]
pub fn shows_states(layout: &str) -> bool {
    let layout: Value = serde_json::from_str(layout).unwrap_or_default();
    let panels = layout["configById"].as_object();
    let mut panels = panels.into_iter().flat_map(Map::values);
    panels.any(|panel| panel["topics"][channels::STATE]["visible"] == true)
}

/// Whether the plots over time of two layouts have the same label.
#[must_use]
pub fn have_one_time_scale(one: &str, other: &str) -> bool {
    let [one, other] = [one, other].map(|layout| {
        let layout: Value = serde_json::from_str(layout).ok()?;
        let panels = layout["configById"].as_object()?;
        let over_time =
            panels.values().filter_map(Value::as_object).find(|panel| is_over_time(panel))?;
        over_time.get(TIME_LABEL).cloned()
    });
    one.is_some() && one == other
}

fn is_over_time(panel: &Map<String, Value>) -> bool {
    panel.get("xAxisVal").is_some_and(|axis| axis == "timestamp")
}

/// Takes out of a panel what the run does not record, and says whether anything is left to show.
fn keep_recorded(panel: &mut Value, header: &Header) -> bool {
    let recorded = |path: &str| {
        let topic = path.split('.').next().unwrap_or(path);
        header.wants(topic) && !header.scenery.unused_fields.contains(&path)
    };
    if let Some(topics) = panel.get_mut("topics").and_then(Value::as_object_mut) {
        topics.retain(|topic, _| recorded(topic));
        return !topics.is_empty();
    }
    if let Some(paths) = panel.get_mut("paths").and_then(Value::as_array_mut) {
        // A bare number is a line of reference, and stays with what it is compared with.
        paths.retain(|path| {
            path["value"].as_str().is_some_and(|path| !path.starts_with('/') || recorded(path))
        });
        return paths.iter().any(|path| path["value"].as_str().is_some_and(recorded));
    }
    let topic = panel.get("topicToRender").or_else(|| panel.get("topicPath"));
    topic.and_then(Value::as_str).is_some_and(recorded)
}

/// The tree of the panels that are kept. Where some are gone, those in one column share its height evenly.
fn pruned(tree: &Value, kept: &[String]) -> Option<Value> {
    if let Some(id) = tree.as_str() {
        return kept.iter().any(|kept| kept == id).then(|| tree.clone());
    }
    let (first, second) = (pruned(&tree["first"], kept), pruned(&tree["second"], kept));
    let (Some(first), Some(second)) = (&first, &second) else { return first.or(second) };
    let mut node = tree.clone();
    if *first != tree["first"] || *second != tree["second"] {
        let (above, below) = (in_column(first), in_column(second));
        let before = in_column(&tree["first"]) + in_column(&tree["second"]);
        if tree["direction"] == "column" && above + below < before {
            node["splitPercentage"] = json!(100.0 * above / (above + below));
        }
    }
    node["first"] = first.clone();
    node["second"] = second.clone();
    Some(node)
}

/// How many panels stand above each other.
fn in_column(tree: &Value) -> f64 {
    if tree["direction"] == "column" {
        in_column(&tree["first"]) + in_column(&tree["second"])
    } else {
        1.0
    }
}

fn time_label(header: &Header) -> String {
    match header.simulated_per_second() {
        Some(simulated) => format!("playback time (s), 1 s = {simulated} simulated"),
        None => "playback time (s)".to_owned(),
    }
}

/// Adds to the title of the scene the lines that the run records.
fn name_lines(panel: &mut Map<String, Value>, header: &Header) {
    let is_exact =
        |wall: &Wall| matches!(wall, Wall::Guide { meaning: GuideMeaning::ExactSolution, .. });
    let has_exact = header.scenery.walls.iter().any(is_exact);
    let lines = [
        (channels::FORCE_CHAINS, "contact forces (red)", true),
        (channels::VELOCITY, "velocity", true),
        (channels::TRAIL, "path", true),
        (channels::WALLS, "exact orbit (green)", has_exact),
    ];
    let shown = lines.into_iter().filter(|(topic, _, is_drawn)| *is_drawn && header.wants(topic));
    let names: Vec<&str> = shown.map(|(_, name, _)| name).collect();
    if !names.is_empty() {
        change_title(panel, |title| format!("{title}; lines = {}", names.join(", ")));
    }
}

/// Diameter of the smallest disc on the screen, px. `distance` is the visible height.
fn smallest_disc_px(scenery: &Scenery, distance: f64) -> f64 {
    let (radius, smallest) = (scenery.min_radius(), scenery.min_drawn_radius());
    let drawn = if radius < smallest { smallest } else { radius };
    2.0 * drawn / distance * PANEL_HEIGHT_PX
}

/// Makes the points of the state, which the template does not show, as wide as the smallest disc.
fn size_points(panel: &mut Map<String, Value>, pixels: f64) {
    if let Some(state) = panel.get_mut("topics").and_then(|topics| topics.get_mut(channels::STATE))
    {
        state["pointSize"] = json!(pixels.ceil());
    }
}

/// Outlines the discs unless the smallest ones would disappear under their outlines.
fn outline_discs(panel: &mut Map<String, Value>, pixels: f64) {
    if let Some(discs) = panel.get_mut("topics").and_then(|topics| topics.get_mut("/discs")) {
        discs["showOutlines"] = json!(pixels >= MIN_OUTLINED_PX);
    }
}

/// Looks down on the view's middle and returns the visible height. `distance` is the visible height of an orthographic camera; the visible
/// width is larger by the panel's aspect ratio, and the container must fit into both.
fn aim_camera(panel: &mut Map<String, Value>, view: [[f64; 2]; 2]) -> f64 {
    let legend = panel
        .get("topics")
        .and_then(|topics| topics.get("/legend"))
        .is_some_and(|legend| legend["visible"] == true);
    let (strip, margin) =
        if legend { (LEGEND_STRIP, MARGIN) } else { (0.0, MARGIN_WITHOUT_LEGEND) };
    let [[x0, y0], [x1, y1]] = view;
    let (width, height) = (x1 - x0, y1 - y0);
    let strip = strip * if height > width { height } else { width };
    let shown = height + strip;
    let across = width / PANEL_ASPECT;
    let distance = margin * if shown > across { shown } else { across };
    let center = [(x0 + x1) / 2.0, (y0 + y1 - strip) / 2.0];
    if let Some(camera) = panel.get_mut("cameraState").and_then(Value::as_object_mut) {
        camera.insert("distance".to_owned(), json!(distance));
        camera.insert("targetOffset".to_owned(), json!([center[0], center[1], 0.0]));
        camera.insert("near".to_owned(), json!(0.01 * distance));
        camera.insert("far".to_owned(), json!(20.0 * distance));
    }
    distance
}
