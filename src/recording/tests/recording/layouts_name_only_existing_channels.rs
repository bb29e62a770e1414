//! Guarantee: a layout names only topics and fields that exist, in the form that viewers require, and plots that the manifest requests
//! come first.

#![allow(clippy::unwrap_used, reason = "a test's own failure")]

use kinetoscope_recording::channels::{self, ALL};
use kinetoscope_recording::layout::{layout_json, shows_states, template, with_names, with_states};
use kinetoscope_recording::merged_layout::merged_layout_json;
use kinetoscope_recording::recorder::{Compression, Header, Selection};
use kinetoscope_recording::requested_panels::PanelRequest;
use kinetoscope_recording::scenery::DrawnRadius;
use serde_json::Value;

const MODELS: [&str; 4] = ["dem", "gas", "packing", "orbit"];
const DRAWN: [&str; 7] = [
    channels::STATE,
    channels::DISCS,
    channels::WALLS,
    channels::LEGEND,
    channels::VELOCITY,
    channels::FORCE_CHAINS,
    channels::TRAIL,
];

fn panels(model: &str) -> Vec<(String, Value)> {
    let layout: Value = serde_json::from_str(template(model).unwrap()).unwrap();
    layout["configById"].as_object().unwrap().clone().into_iter().collect()
}

/// Whether a schema belongs to a model.
fn is_of(model: &str, schema: &str) -> bool {
    let prefix = match model {
        "dem" => "kinetoscope.Dem",
        "gas" => "kinetoscope.Gas",
        "packing" => "kinetoscope.Packing",
        _ => "kinetoscope.Orbit",
    };
    schema.starts_with(prefix)
}

/// Whether a path such as "/speeds.density[:]" names a field of the model's channels; a bare number is a reference line.
fn exists(model: &str, path: &str) -> bool {
    if path.parse::<f64>().is_ok() {
        return true;
    }
    let Some((topic, field)) = path.split_once('.') else { return false };
    let (field, series) = match field.strip_suffix("[:]") {
        Some(field) => (field, true),
        None => (field, false),
    };
    ALL.iter().filter(|channel| channel.topic == topic && is_of(model, channel.schema)).any(
        |channel| {
            let found = channel.fields.iter().find(|declared| declared.name == field);
            found.is_some_and(|declared| declared.kind.contains("repeated") == series)
        },
    )
}

#[test]
fn every_topic_and_field_exists() {
    for model in MODELS {
        for (id, panel) in panels(model) {
            for path in panel["paths"].as_array().into_iter().flatten() {
                let value = path["value"].as_str().unwrap();
                assert!(exists(model, value), "{model}, {id}: {value}");
                assert!(path["label"].as_str().unwrap().len() <= 16, "{model}, {id}: {value}");
            }
            if let Some(path) = panel.get("xAxisPath") {
                assert!(exists(model, path["value"].as_str().unwrap()), "{model}, {id}: {path}");
            }
            for topic in panel["topics"].as_object().into_iter().flat_map(|topics| topics.keys()) {
                assert!(DRAWN.contains(&topic.as_str()), "{model}, {id}: {topic}");
            }
            if let Some(topic) = panel.get("topicToRender") {
                assert_eq!(topic, channels::LOG);
            }
            if let Some(topic) = panel.get("topicPath") {
                let found = |topic: &str| ALL.iter().any(|channel| channel.topic == topic);
                assert!(found(topic.as_str().unwrap()), "{model}, {id}: {topic}");
            }
        }
    }
}

#[test]
fn control_foreign_topics_and_misspelled_fields_are_found() {
    assert!(exists("dem", "/energy_percent.kinetic_percent"));
    assert!(!exists("dem", "/energy_percent.kinetic_pct"));
    assert!(!exists("gas", "/energy_percent.kinetic_percent"));
    assert!(!exists("gas", "/speeds.density"));
}

#[test]
fn panels_have_titles_and_plots_share_an_axis() {
    for model in MODELS {
        for (id, panel) in panels(model) {
            let title = panel["foxglovePanelTitle"].as_str().unwrap();
            assert!(!title.is_empty(), "{model}, {id}");
            assert_eq!(panel["lichtblickPanelTitle"], title, "{model}, {id}");
            if id.starts_with("Plot!") {
                assert_eq!(panel["sidebarDimension"], 190, "{model}, {id}");
                assert_eq!(panel["legendDisplay"], "left", "{model}, {id}");
                assert_eq!(panel["showPlotValuesInLegend"], false, "{model}, {id}");
                let is_thin = |path: &Value| path["lineSize"] == 1.0;
                assert!(panel["paths"].as_array().unwrap().iter().all(is_thin), "{model}, {id}");
                assert_eq!(panel["isSynced"], panel["xAxisVal"] == "timestamp", "{model}, {id}");
                assert!(!panel["xAxisLabel"].as_str().unwrap().is_empty(), "{model}, {id}");
                assert!(!panel["yAxisLabel"].as_str().unwrap().is_empty(), "{model}, {id}");
            }
        }
    }
}

fn leaves(tree: &Value, into: &mut Vec<String>) {
    match tree {
        Value::String(id) => into.push(id.clone()),
        tree => {
            leaves(&tree["first"], into);
            leaves(&tree["second"], into);
        }
    }
}

#[test]
fn every_panel_is_placed_once() {
    for model in MODELS {
        let layout: Value = serde_json::from_str(template(model).unwrap()).unwrap();
        let mut placed = Vec::new();
        leaves(&layout["layout"], &mut placed);
        placed.sort();
        let mut configured: Vec<String> = panels(model).into_iter().map(|(id, _)| id).collect();
        configured.sort();
        assert_eq!(placed, configured, "{model}");
    }
}

/// The sample contains temperatures and speeds of the gas, but neither pressure nor collisions.
#[test]
fn unrecorded_channels_have_no_panel() {
    let mut header = crate::sample::header(Compression::Zstd);
    let layout: Value = serde_json::from_str(&layout_json(&header, &[]).unwrap()).unwrap();
    let mut placed = Vec::new();
    leaves(&layout["layout"], &mut placed);
    assert_eq!(placed, ["3D!scene", "RosOut!log", "Plot!speeds", "Plot!temperature"]);
    assert_eq!(layout["layout"]["second"]["splitPercentage"], 50.0);
    // The height of the scene does not change, because the log is still below it.
    assert_eq!(layout["layout"]["first"]["splitPercentage"], 74);
    assert_eq!(layout["configById"].as_object().unwrap().len(), 4);
    header.selection = Selection::Named(vec!["temperature".to_owned()]);
    let layout: Value = serde_json::from_str(&layout_json(&header, &[]).unwrap()).unwrap();
    let mut placed = Vec::new();
    leaves(&layout["layout"], &mut placed);
    assert_eq!(placed, ["RosOut!log", "Plot!temperature"]);
    header.selection = Selection::Named(vec!["discs".to_owned()]);
    let layout: Value = serde_json::from_str(&layout_json(&header, &[]).unwrap()).unwrap();
    let topics = layout["configById"]["3D!scene"]["topics"].as_object().unwrap();
    assert_eq!(topics.keys().collect::<Vec<_>>(), ["/discs", "/legend", "/walls"]);
}

/// The viewer's formula for a box of 0.04 m: visible height 0.04 x 1.1 x 1.12 = 0.04928 m, center (0.02, 0.018).
#[test]
fn camera_shows_container_and_color_bar() {
    let mut header = crate::sample::header(Compression::Zstd);
    header.model = "dem";
    header.scenery.view = [[0.0, 0.0], [0.04, 0.04]];
    let layout: Value = serde_json::from_str(&layout_json(&header, &[]).unwrap()).unwrap();
    let camera = &layout["configById"]["3D!scene"]["cameraState"];
    let close = |value: &Value, expected: f64| {
        let rounding = 1e-15 * (1.0 + expected.abs());
        assert!((value.as_f64().unwrap() - expected).abs() < rounding, "{value}, not {expected}");
    };
    close(&camera["distance"], 0.04928);
    close(&camera["targetOffset"][0], 0.02);
    close(&camera["targetOffset"][1], 0.018);
    // Orbit: no color bar, a margin of 6 %. The width of 4 determines the height in a panel 1.15 times as wide as high.
    header.model = "orbit";
    header.scenery.view = [[-2.0, -1.0], [2.0, 1.0]];
    let layout: Value = serde_json::from_str(&layout_json(&header, &[]).unwrap()).unwrap();
    let camera = &layout["configById"]["3D!scene"]["cameraState"];
    close(&camera["distance"], 4.24 / 1.15);
    close(&camera["targetOffset"][1], 0.0);
    // A flat box: the color bar needs 0.1 of the length below the box. A width of 22.4 with
    // margins, hence a height of 22.4 / 1.15; center at (0 + 1 - 2) / 2.
    header.model = "gas";
    header.scenery.view = [[0.0, 0.0], [20.0, 1.0]];
    let layout: Value = serde_json::from_str(&layout_json(&header, &[]).unwrap()).unwrap();
    let camera = &layout["configById"]["3D!scene"]["cameraState"];
    close(&camera["distance"], 22.4 / 1.15);
    close(&camera["targetOffset"][1], -0.5);
}

/// Control: the template alone names no lines, and a recording with arrows and paths names both.
#[test]
fn titles_name_only_recorded_lines_and_unused_fields_have_no_curve() {
    let mut header = crate::sample::header(Compression::Zstd);
    let layout = |header: &Header| -> Value {
        serde_json::from_str(&layout_json(header, &[]).unwrap()).unwrap()
    };
    let title = |layout: &Value| layout["configById"]["3D!scene"]["lichtblickPanelTitle"].clone();
    assert_eq!(
        title(&layout(&header)),
        "Gas, color = speed; lines = contact forces (red), velocity, path"
    );
    header.scenery.arrows = false;
    header.scenery.force_range_top = None;
    assert_eq!(title(&layout(&header)), "Gas, color = speed; lines = path");
    header.scenery.trail = false;
    assert_eq!(title(&layout(&header)), "Gas, color = speed");
    let curves = |header: &Header| {
        let paths = &layout(header)["configById"]["Plot!temperature"]["paths"];
        paths.as_array().map(Vec::len)
    };
    assert_eq!(curves(&header), Some(2));
    header.scenery.unused_fields = vec!["/temperature.mean_speed_temperature_k"];
    assert_eq!(curves(&header), Some(1));
    header.scenery.unused_fields.push("/temperature.mean_square_temperature_k");
    assert_eq!(curves(&header), None);
}

/// On 700 px, a view of 2 with its color bar (2.464) shows a disc of diameter 0.02 on 5.7 px and one of 0.03 on 8.5 px.
#[test]
fn discs_below_six_pixels_have_no_outlines() {
    let mut header = crate::sample::header(Compression::Zstd);
    for (min, outlined) in [(0.01, false), (0.015, true), (1e-6, false)] {
        header.scenery.drawn_radius = DrawnRadius::Column { min };
        let layout: Value = serde_json::from_str(&layout_json(&header, &[]).unwrap()).unwrap();
        let discs = &layout["configById"]["3D!scene"]["topics"]["/discs"];
        assert_eq!(discs["showOutlines"], outlined, "{min}");
    }
}

/// Guarantee: where not every frame has a drawing, the scene shows the states, which every frame has: as wide as the smallest disc, and in
/// the colors of merged runs.
#[test]
fn scene_of_thinned_drawings_shows_the_states() {
    let mut header = crate::sample::header(Compression::Zstd);
    header.selection = Selection::All;
    // 6 px from a radius of 0.015 on.
    header.scenery.drawn_radius = DrawnRadius::Column { min: 0.03 };
    let drawn = layout_json(&header, &[]).unwrap();
    let points = with_states(&drawn).unwrap();
    for (layout, shows_points) in [(&drawn, false), (&points, true)] {
        assert_eq!(shows_states(layout), shows_points);
        let layout: Value = serde_json::from_str(layout).unwrap();
        let topics = &layout["configById"]["3D!scene"]["topics"];
        let visible =
            ["/state", "/walls", "/discs", "/legend"].map(|topic| &topics[topic]["visible"]);
        assert_eq!(visible, [shows_points, true, !shows_points, !shows_points]);
        assert!(topics["/state"]["pointSize"].as_f64().unwrap() > 10.0);
    }
    let labels = ["one", "two"].map(str::to_owned);
    let merged: Value =
        serde_json::from_str(&merged_layout_json(&points, &labels).unwrap()).unwrap();
    let scene = &merged["configById"]["3D!scene"];
    let color = |topic: &str| scene["topics"][topic]["flatColor"].as_str().unwrap();
    assert_ne!(color("/run_1/state"), color("/run_2/state"));
    assert!(scene["foxglovePanelTitle"].as_str().unwrap().contains("; one in blue, over it two"));
}

#[test]
fn time_axis_states_the_playback_speed() {
    let mut header = crate::sample::header(Compression::Zstd);
    let layout: Value = serde_json::from_str(&layout_json(&header, &[]).unwrap()).unwrap();
    let label = |layout: &Value, panel: &str| layout["configById"][panel]["xAxisLabel"].clone();
    assert_eq!(label(&layout, "Plot!temperature"), "playback time (s), 1 s = 75 ms simulated");
    assert_eq!(label(&layout, "Plot!speeds"), "speed / rms speed");
    header.model_time = None;
    let layout: Value = serde_json::from_str(&layout_json(&header, &[]).unwrap()).unwrap();
    assert_eq!(label(&layout, "Plot!temperature"), "playback time (s)");
}

/// The layout of a run that records all default channels, for requested plots.
fn requested(model: &'static str, subjects: &[&[&str]]) -> Value {
    let mut header = crate::sample::header(Compression::Zstd);
    header.model = model;
    header.selection = Selection::All;
    header.channels = ALL;
    let request = |subjects: &&[&str]| PanelRequest {
        subjects: subjects.iter().map(|subject| (*subject).to_owned()).collect(),
        title: Some("as the manifest says".to_owned()),
    };
    let requests: Vec<PanelRequest> = subjects.iter().map(request).collect();
    serde_json::from_str(&layout_json(&header, &requests).unwrap()).unwrap()
}

/// The names of the plots in the right column, from the top.
fn column(layout: &Value) -> Vec<String> {
    let mut placed = Vec::new();
    leaves(&layout["layout"]["second"], &mut placed);
    placed
}

#[test]
fn requested_plots_come_first_with_fields_that_exist() {
    // Charts and metrics of the shipped experiments, with the panel that shows them.
    for (model, subject, panel) in [
        ("gas", "escaped_over_time", "Plot!escaped"),
        ("gas", "h_over_time", "Plot!entropy"),
        ("gas", "temperature_over_time", "Plot!temperature"),
        ("gas", "/energy_balance.particles_escaped", "Plot!request1"),
        ("gas", "/collisions.wall_collisions", "Plot!collisions"),
        ("dem", "piston.force", "Plot!floor"),
        ("dem", "energy_balance", "Plot!energy"),
        ("orbit", "position_error.final", "Plot!position"),
        ("orbit", "energy_error_by_run", "Plot!energy"),
        ("packing", "a2", "Plot!a2"),
        ("gas", "density_by_height", "Plot!kinetic"),
        ("orbit", "angle_by_run", "Plot!closest"),
    ] {
        let layout = requested(model, &[&[subject]]);
        let column = column(&layout);
        assert_eq!(column[0], panel, "{model}: {subject}");
        assert!(column.len() <= 6, "{column:?}");
        let plots = layout["configById"].as_object().unwrap();
        let configured = plots.keys().filter(|id| id.starts_with("Plot!")).count();
        assert_eq!(column.len(), configured, "{model}: every plot is placed");
        for path in plots[panel]["paths"].as_array().unwrap() {
            let path = path["value"].as_str().unwrap();
            // "[2]" selects one wall of all.
            let all =
                path.split_once('[').map_or(path.to_owned(), |(field, _)| format!("{field}[:]"));
            assert!(exists(model, &all), "{model}: {path}");
        }
        assert_eq!(plots[panel]["isSynced"], true);
    }
    let two = requested(
        "gas",
        &[&["escaped_over_time"], &["/energy.kinetic_j", "/energy.particles_outside"]],
    );
    assert_eq!(column(&two)[..2], ["Plot!escaped", "Plot!request2"]);
    assert_eq!(two["configById"]["Plot!request2"]["lichtblickPanelTitle"], "as the manifest says");
}

/// Control: a chart that no recorded field shows over time leaves the layout as it is.
#[test]
fn control_other_requests_change_nothing() {
    let other = requested("gas", &[&["position_histogram"], &["mean_speed"]]);
    assert_eq!(other, requested("gas", &[]));
}

/// The plots of this column have 640 px on the smallest screen, in parts of 2 : 1 : 1 : 1 : 1, of which each loses 78 to its title and its time
/// axis: labels have 135 px and 29 px. Letters are 6.5 px wide (seen in Lichtblick 1.28.1).
///
/// Control: the high plot keeps its label.
#[test]
fn labels_longer_than_their_axis_are_in_the_title() {
    let layout = requested("dem", &[&["energy_balance"]]);
    assert_eq!(column(&layout).len(), 5);
    let panel = |id: &str| {
        let panel = &layout["configById"][id];
        assert_eq!(panel["foxglovePanelTitle"], panel["lichtblickPanelTitle"]);
        (panel["yAxisLabel"].clone(), panel["foxglovePanelTitle"].as_str().unwrap().to_owned())
    };
    assert_eq!(panel("Plot!energy").0, "energy (%)");
    for (id, title) in [
        ("Plot!residual", "Energy-balance error (ppm)"),
        ("Plot!contacts", "Contacts"),
        ("Plot!temperature", "Granular temperature (square root), speed (m/s)"),
    ] {
        assert_eq!(panel(id), (Value::Null, title.to_owned()));
    }
}

/// Control: a name that the run itself draws, and no name, change nothing.
#[test]
fn numbered_bodies_have_the_names_of_the_manifest() {
    let mut header = crate::sample::header(Compression::Zstd);
    header.model = "orbit";
    header.channels = ALL;
    let title = |drawn: &[&str], names: &[&str]| {
        let [drawn, names] =
            [drawn, names].map(|names| names.iter().map(|name| (*name).to_owned()).collect());
        let mut header = header.clone();
        header.scenery.names = drawn;
        let names: Vec<String> = names;
        let layout = layout_json(&header, &[]).unwrap();
        let layout: Value =
            serde_json::from_str(&with_names(&layout, &header, &names).unwrap()).unwrap();
        layout["configById"]["3D!scene"]["lichtblickPanelTitle"].as_str().unwrap().to_owned()
    };
    let named = title(&["0", "1", "2"], &["Sun", "", "Saturn"]);
    assert!(named.starts_with("Orbit (AU); 0 Sun, 2 Saturn; bodies drawn enlarged;"), "{named}");
    let unnamed = title(&["0", "1", "2"], &[]);
    assert!(unnamed.starts_with("Orbit (AU); bodies drawn enlarged;"), "{unnamed}");
    assert_eq!(title(&["Earth"], &["Mars"]), title(&["Earth"], &[]));
}
