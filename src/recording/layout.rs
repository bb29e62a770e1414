//! The viewer's layout for a run: a model's template with the run's camera and time scale.

use crate::error::RecordError;
use crate::header::Header;
use serde_json::{Map, Value, json};

/// Height of the strip for the colour bar below the container, over the container's height.
const LEGEND_STRIP: f64 = 0.1;
/// Space around container and colour bar.
const MARGIN: f64 = 1.12;
/// Space around a view without a colour bar.
const MARGIN_WITHOUT_LEGEND: f64 = 1.06;

/// The template of a model, as it stands in `experiments/layouts/`.
#[must_use]
pub fn template(model: &str) -> Option<&'static str> {
    match model {
        "dem" => Some(include_str!("../../experiments/layouts/dem.json")),
        "gas" => Some(include_str!("../../experiments/layouts/gas.json")),
        "packing" => Some(include_str!("../../experiments/layouts/packing.json")),
        "orbit" => Some(include_str!("../../experiments/layouts/orbit.json")),
        _ => None,
    }
}

/// The layout of a run for Foxglove and Lichtblick, as JSON.
///
/// # Errors
/// A model without a template, or a template that is no layout: defects of the program.
pub fn layout_json(header: &Header) -> Result<String, RecordError> {
    let defect = |what: &str| {
        RecordError::Declaration(format!("the layout of model {} {what}", header.model))
    };
    let template = template(header.model).ok_or_else(|| defect("does not exist"))?;
    let mut layout: Value =
        serde_json::from_str(template).map_err(|error| defect(&format!("is no JSON ({error})")))?;
    let panels = layout.get_mut("configById").and_then(Value::as_object_mut);
    for (id, panel) in panels.ok_or_else(|| defect("has no panels"))? {
        let panel = panel.as_object_mut().ok_or_else(|| defect("has a panel that is no object"))?;
        if id.starts_with("3D!") {
            aim_camera(panel, header.scenery.view);
        } else if panel.get("xAxisVal").is_some_and(|axis| axis == "timestamp") {
            panel.insert("xAxisLabel".to_owned(), json!(time_label(header)));
        }
    }
    Ok(format!("{layout:#}\n"))
}

fn time_label(header: &Header) -> String {
    match header.simulated_per_second() {
        Some(simulated) => format!("playback time (s), 1 s = {simulated} simulated"),
        None => "playback time (s)".to_owned(),
    }
}

/// Looks down on the view's middle. `distance` is the visible height of an orthographic camera; a panel at least as wide
/// as high is assumed, and the container's width must fit as well.
fn aim_camera(panel: &mut Map<String, Value>, view: [[f64; 2]; 2]) {
    let legend = panel
        .get("topics")
        .and_then(|topics| topics.get("/legend"))
        .is_some_and(|legend| legend["visible"] == true);
    let (strip, margin) =
        if legend { (LEGEND_STRIP, MARGIN) } else { (0.0, MARGIN_WITHOUT_LEGEND) };
    let [[x0, y0], [x1, y1]] = view;
    let (width, height) = (x1 - x0, (y1 - y0) * (1.0 + strip));
    let distance = margin * if height > width { height } else { width };
    let centre = [(x0 + x1) / 2.0, (y0 + y1) / 2.0 - (y1 - y0) * strip / 2.0];
    if let Some(camera) = panel.get_mut("cameraState").and_then(Value::as_object_mut) {
        camera.insert("distance".to_owned(), json!(distance));
        camera.insert("targetOffset".to_owned(), json!([centre[0], centre[1], 0.0]));
        camera.insert("near".to_owned(), json!(0.01 * distance));
        camera.insert("far".to_owned(), json!(20.0 * distance));
    }
}
