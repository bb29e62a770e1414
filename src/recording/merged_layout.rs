//! The viewer's layout for a merged recording: that of the first run, with every topic once per run.

use crate::channels::STATE;
use crate::error::RecordError;
use crate::ghosts;
use crate::merged::prefix_of_run;
use serde_json::{Map, Value, json};

/// Color of the first run's curves.
const FIRST_COLOR: &str = "#5aa9e6";
/// Share of the window's height for the panels of the first run's layout, percent; the rest shows the separation.
const PANELS_PERCENT: f64 = 78.0;

/// The layout for recordings that [`crate::merged::merge`] wrote, from the layout of the first run and the labels of all runs.
///
/// # Errors
/// A layout that is none: a defect of the program.
pub fn merged_layout_json(first: &str, labels: &[String]) -> Result<String, RecordError> {
    let defect = |what: String| RecordError::Declaration(format!("the layout of a run {what}"));
    let mut layout: Value =
        serde_json::from_str(first).map_err(|error| defect(format!("is no JSON ({error})")))?;
    let panels = layout.get_mut("configById").and_then(Value::as_object_mut);
    let panels = panels.ok_or_else(|| defect("has no panels".to_owned()))?;
    for panel in panels.values_mut().filter_map(Value::as_object_mut) {
        if panel.contains_key("topics") {
            draw_all(panel, labels);
        } else if panel.contains_key("paths") {
            plot_all(panel, labels);
        }
        for key in ["topicPath", "topicToRender"] {
            prefix(panel.get_mut(key), 0);
        }
        prefix(panel.get_mut("xAxisPath").and_then(|path| path.get_mut("value")), 0);
    }
    let label = panels.values().find_map(|panel| panel.get("xAxisLabel").cloned());
    panels.insert("Plot!separation".to_owned(), separation(labels, label));
    layout["layout"] = json!({
        "direction": "column",
        "splitPercentage": PANELS_PERCENT,
        "first": layout["layout"],
        "second": "Plot!separation",
    });
    Ok(format!("{layout:#}\n"))
}

/// Puts the prefix of a run before a topic.
fn prefix(topic: Option<&mut Value>, run: usize) {
    if let Some(topic) = topic
        && let Some(text) = topic.as_str().filter(|text| text.starts_with('/'))
    {
        *topic = json!(format!("{}{text}", prefix_of_run(run)));
    }
}

/// The scene: the topics of all runs, with the colors of the ghosts in the title.
fn draw_all(panel: &mut Map<String, Value>, labels: &[String]) {
    if let Some(topics) = panel.get_mut("topics").and_then(Value::as_object_mut) {
        let of_run = |run: usize| {
            let prefix = prefix_of_run(run);
            let drawn = topics.iter().filter(move |(topic, _)| run == 0 || *topic != "/legend");
            drawn.map(move |(topic, shown)| {
                let mut shown = shown.clone();
                if topic == STATE {
                    shown["flatColor"] = json!(curve_color(run));
                }
                (format!("{prefix}{topic}"), shown)
            })
        };
        *topics = (0..labels.len()).flat_map(of_run).collect();
    }
    let named = labels.iter().enumerate().skip(1);
    let named: Vec<String> =
        named.map(|(run, label)| format!("{label} ({})", ghosts::name(run - 1))).collect();
    let colored = labels.first().map_or("", String::as_str);
    let state = panel.get("topics").map(|topics| &topics[format!("{}{STATE}", prefix_of_run(0))]);
    let are_points = state.is_some_and(|state| state["visible"] == true);
    let color = if are_points { "blue" } else { "color" };
    for key in ["foxglovePanelTitle", "lichtblickPanelTitle"] {
        if let Some(title) = panel.get(key).and_then(Value::as_str) {
            let title = format!("{title}; {colored} in {color}, over it {}", named.join(", "));
            panel.insert(key.to_owned(), json!(title));
        }
    }
}

/// A plot: every curve once per run. A plot of one quantity has the runs' colors.
fn plot_all(panel: &mut Map<String, Value>, labels: &[String]) {
    let Some(paths) = panel.get_mut("paths").and_then(Value::as_array_mut) else { return };
    let is_curve = |path: &Value| path["value"].as_str().is_some_and(|text| text.starts_with('/'));
    let is_single = paths.iter().filter(|path| is_curve(path)).count() == 1;
    let mut all = Vec::new();
    for path in paths.iter() {
        if !is_curve(path) {
            all.push(path.clone());
            continue;
        }
        for (run, label) in labels.iter().enumerate() {
            let mut of_run = path.clone();
            prefix(of_run.get_mut("value"), run);
            if is_single {
                of_run["label"] = json!(label);
                of_run["color"] = json!(curve_color(run));
            } else {
                let quantity = path["label"].as_str().unwrap_or_default();
                of_run["label"] = json!(format!("{quantity}, {label}"));
            }
            all.push(of_run);
        }
    }
    *paths = all;
}

fn curve_color(run: usize) -> String {
    run.checked_sub(1).map_or_else(|| FIRST_COLOR.to_owned(), ghosts::hex)
}

/// The plot of the distances from the first run.
fn separation(labels: &[String], axis: Option<Value>) -> Value {
    let curve = |(run, label): (usize, &String)| {
        json!({
            "value": format!("{}/separation.log10_max_distance", prefix_of_run(run)),
            "label": label,
            "color": curve_color(run),
            "enabled": true,
            "timestampMethod": "receiveTime",
            "showLine": true,
            "lineSize": 1.0,
        })
    };
    let first = labels.first().map_or("the first run", String::as_str);
    let title = format!("Largest distance of a particle from {first} (decimal logarithm)");
    json!({
        "paths": labels.iter().enumerate().skip(1).map(curve).collect::<Vec<_>>(),
        "showLegend": true,
        "legendDisplay": "left",
        "showPlotValuesInLegend": false,
        "sidebarDimension": 190,
        "showXAxisLabels": true,
        "showYAxisLabels": true,
        "isSynced": true,
        "xAxisVal": "timestamp",
        "xAxisLabel": axis.unwrap_or_else(|| json!("playback time (s)")),
        "yAxisLabel": "log10(distance)",
        "foxglovePanelTitle": title,
        "lichtblickPanelTitle": title,
    })
}
