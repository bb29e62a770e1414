//! Titles of panels, and labels of the y axes of plots: a viewer cuts off what is longer than the axis, so that long labels of low plots are part of the title.

use serde_json::{Map, Value, json};

/// Height of the panels on a screen of 1366 x 768, without the bars of the viewer, px.
const PANELS_PX: f64 = 640.0;
/// Height of a plot's title, of the numbers at its time axis and of their label, px.
const AROUND_AXIS_PX: f64 = 78.0;
/// Length of a character of a label, px.
const CHARACTER_PX: f64 = 6.5;
/// The key of a plot's label at the y axis.
const Y_LABEL: &str = "yAxisLabel";

/// Moves the labels of the plots of a tree that takes this fraction of the height, where they are longer than the axis.
pub(crate) fn move_long_labels(tree: &Value, panels: &mut Map<String, Value>, height: f64) {
    if let Some(panel) = tree.as_str().and_then(|id| panels.get_mut(id)) {
        let label = panel.get(Y_LABEL).and_then(Value::as_str).unwrap_or_default().to_owned();
        let length = CHARACTER_PX * label.chars().count() as f64;
        if let Some(panel) = panel.as_object_mut().filter(|_| length > axis_px(height)) {
            panel.remove(Y_LABEL);
            change_title(panel, |title| with_label(title, &label));
        }
        return;
    }
    let first = match tree.get("direction").and_then(Value::as_str) {
        Some("column") => tree["splitPercentage"].as_f64().unwrap_or(50.0) / 100.0,
        _ => 1.0,
    };
    let second = if first < 1.0 { 1.0 - first } else { 1.0 };
    for (side, part) in [("first", first), ("second", second)] {
        if let Some(tree) = tree.get(side) {
            move_long_labels(tree, panels, part * height);
        }
    }
}

/// Length of the y axis of a plot, px.
fn axis_px(height: f64) -> f64 {
    height * PANELS_PX - AROUND_AXIS_PX
}

/// The title with what it does not say yet of a label: its unit, or all of it.
fn with_label(title: &str, label: &str) -> String {
    let (quantity, unit) = match label.split_once(" (") {
        Some((quantity, unit)) => (quantity, format!(" ({unit}")),
        None => (label, String::new()),
    };
    if title.to_lowercase().contains(&quantity.to_lowercase()) {
        format!("{title}{unit}")
    } else {
        format!("{title}, {label}")
    }
}

/// Changes the title of a panel for both viewers.
pub(crate) fn change_title(panel: &mut Map<String, Value>, change: impl Fn(&str) -> String) {
    for key in ["foxglovePanelTitle", "lichtblickPanelTitle"] {
        if let Some(title) = panel.get(key).and_then(Value::as_str) {
            let title = change(title);
            panel.insert(key.to_owned(), json!(title));
        }
    }
}
